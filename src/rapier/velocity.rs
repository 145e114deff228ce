//! Bounces of entities with a velocity of Rapier's.

use bevy::{
    ecs::{schedule::InternedScheduleLabel, world::DeferredWorld},
    prelude::*,
};
use bevy_rapier3d::dynamics::Velocity as RapierVelocity;

use crate::{
    motion::{MovedElsewhere, Velocity},
    plugin::CollisionSystems,
    response::Bounce,
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
            (begin_to_mirror, read).chain().after(CollisionSystems::First).before(CollisionSystems::Motion),
            write.after(CollisionSystems::Response).before(CollisionSystems::Report),
        ),
    )
    .add_observer(on_velocity_removed);
}

type WithoutMirror = (With<Bounce>, Without<Velocity>);
type WithMirror = (With<Mirrored>, With<Bounce>);

fn begin_to_mirror(mut commands: Commands, bouncing: Query<(Entity, &RapierVelocity), WithoutMirror>) {
    for (entity, velocity) in &bouncing {
        commands.entity(entity).try_insert((Velocity(velocity.linear), Mirrored));
    }
}

fn read(mut mirrored: Query<(&RapierVelocity, &mut Velocity), WithMirror>) {
    for (theirs, mut ours) in &mut mirrored {
        ours.set_if_neq(Velocity(theirs.linear));
    }
}

/// What a contact changed. A velocity that is not finite is left to Rapier.
fn write(mut mirrored: Query<(&Velocity, &mut RapierVelocity), (WithMirror, Changed<Velocity>)>) {
    for (ours, mut theirs) in &mut mirrored {
        if theirs.linear != ours.0 && ours.is_finite() {
            theirs.linear = ours.0;
        }
    }
}

fn on_velocity_removed(event: On<Remove, RapierVelocity>, mut world: DeferredWorld) {
    if world.get::<Mirrored>(event.entity).is_some() {
        world.commands().entity(event.entity).try_remove::<(Velocity, Mirrored, MovedElsewhere)>();
    }
}
