//! Velocities of Rapier's bodies: what contacts count with, and what bounces change.

use bevy::{
    ecs::{schedule::InternedScheduleLabel, world::DeferredWorld},
    prelude::*,
};
use bevy_rapier3d::dynamics::{RigidBody, RigidBodyDisabled, Velocity as RapierVelocity};

use super::shape::ShapeFromRapier;
use crate::{
    motion::{MovedElsewhere, Velocity},
    parts::RegroupSystems,
    response::Bounce,
    schedule::CollisionSystems,
};

/// The entity's [`Velocity`] mirrors that of Rapier.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(MovedElsewhere)]
struct Mirrored;

pub(super) fn add_systems(app: &mut App, schedule: InternedScheduleLabel) {
    app.add_systems(
        schedule,
        (
            // Impacts on the way are answered as early as in the narrow phase.
            (begin_to_mirror, read)
                .chain()
                .after(CollisionSystems::First)
                .before(RegroupSystems),
            write
                .after(CollisionSystems::Response)
                .before(CollisionSystems::Report),
        ),
    )
    .add_observer(on_loss);
}

/// Who is mirrored, if it has a velocity of Rapier's: who takes part by its collider, whether it
/// bounces or is bounced off, and who bounces.
type TakesPart = Or<(With<ShapeFromRapier>, With<Bounce>)>;
type WithoutMirror = (TakesPart, Without<Velocity>);

fn begin_to_mirror(mut commands: Commands, bodies: Query<(Entity, Moved), WithoutMirror>) {
    for (entity, moved) in &bodies {
        commands
            .entity(entity)
            .try_insert((Velocity(velocity(moved)), Mirrored));
    }
}

type Moved<'a> = (
    &'a RapierVelocity,
    Option<&'a RigidBody>,
    Has<RigidBodyDisabled>,
);

/// How fast Rapier moves a body: what it does not move is at rest, whatever velocity it was given.
fn velocity((velocity, body, is_disabled): (&RapierVelocity, Option<&RigidBody>, bool)) -> Vec3 {
    let is_moved = !is_disabled && body.is_some_and(|body| *body != RigidBody::Fixed);
    if is_moved {
        velocity.linear
    } else {
        Vec3::ZERO
    }
}

fn read(mut mirrored: Query<(Moved, &mut Velocity), With<Mirrored>>) {
    for (moved, mut ours) in &mut mirrored {
        ours.set_if_neq(Velocity(velocity(moved)));
    }
}

type Answered = (With<Mirrored>, With<Bounce>, Changed<Velocity>);

/// What a contact changed. A velocity that is not finite is left to Rapier.
fn write(mut mirrored: Query<(&Velocity, &mut RapierVelocity), Answered>) {
    for (ours, mut theirs) in &mut mirrored {
        if theirs.linear != ours.0 && ours.is_finite() {
            theirs.linear = ours.0;
        }
    }
}

/// The mirror goes the moment in which it is of no more use: without the velocity itself, or if the
/// entity neither takes part by its collider nor bounces any more.
fn on_loss(event: On<Remove, (RapierVelocity, ShapeFromRapier, Bounce)>, mut world: DeferredWorld) {
    if world.get::<Mirrored>(event.entity).is_some() {
        world
            .commands()
            .entity(event.entity)
            .queue_silenced(|mut entity: EntityWorldMut| {
                let takes_part =
                    entity.contains::<ShapeFromRapier>() || entity.contains::<Bounce>();
                if !(takes_part && entity.contains::<RapierVelocity>()) {
                    entity.remove::<(Velocity, Mirrored, MovedElsewhere)>();
                }
            });
    }
}
