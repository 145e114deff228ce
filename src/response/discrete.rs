//! Bounces of what is looked at where it is at the end of a tick.

use bevy::{ecs::entity_disabling::Disabled, prelude::*};

use super::{
    bounce::{Bounce, Party, respond},
    outcomes::Outcomes,
};
use crate::{
    collision_index::CollisionIndex,
    contacts::{ContactPair, Contacts},
    counters::CollisionCounters,
    filters::Sensor,
    frame::{Ancestor, Frame},
    motion::Velocity,
    narrow_phase::{NarrowPhase, Workspace},
};

/// Contacts in which neither is a sensor, but for impacts on the way: these are answered when they
/// happen.
fn solid(
    contacts: &Contacts,
    sensors: &Query<(), With<Sensor>>,
) -> impl Iterator<Item = ContactPair> {
    let some_sensors = !sensors.is_empty();
    let is_sensor = move |entity| some_sensors && sensors.contains(entity);
    let is_solid = move |contact: &&ContactPair| {
        !contacts.met_on_the_way(contact.pair) && !is_sensor(contact.a) && !is_sensor(contact.b)
    };
    contacts.pairs().iter().filter(is_solid).copied()
}

pub(super) fn reverse(
    contacts: Res<Contacts>,
    sensors: Query<(), With<Sensor>>,
    outcomes: Res<Outcomes>,
    mut moving: Query<(&mut Velocity, &Bounce)>,
    mut counters: ResMut<CollisionCounters>,
    mut colliding: Local<Vec<Entity>>,
) {
    colliding.clear();
    colliding.extend(solid(&contacts, &sensors).flat_map(|contact| [contact.a, contact.b]));
    colliding.sort_unstable();
    colliding.dedup();
    for &entity in &*colliding {
        if let Ok((mut velocity, Bounce::Reverse)) = moving.get_mut(entity)
            && velocity.0 != Vec3::ZERO
            && !outcomes.has_bounced(entity)
        {
            velocity.0 = -velocity.0;
            counters.tick.bounces += 1;
        }
    }
}

pub(super) fn reflect(
    contacts: Res<Contacts>,
    sensors: Query<(), With<Sensor>>,
    (index, tests): (Res<CollisionIndex>, Res<NarrowPhase>),
    mut moving: Query<(&mut Velocity, Option<&Bounce>)>,
    // A disabled parent is still where it is.
    places: Query<(&Transform, Option<&ChildOf>), Allow<Disabled>>,
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    for contact in solid(&contacts, &sensors) {
        let bounce = |entity| {
            moving
                .get(entity)
                .ok()
                .and_then(|(_, bounce)| bounce.copied())
        };
        let bounces = [contact.a, contact.b].map(bounce);
        if bounces
            .iter()
            .all(|bounce| bounce.and_then(Bounce::restitution).is_none())
        {
            continue;
        }
        let [Some(a), Some(b)] = [contact.pair.a, contact.pair.b].map(|id| index.body(id)) else {
            continue;
        };
        let frames = [contact.a, contact.b].map(|entity| {
            let parent = places
                .get(entity)
                .ok()
                .and_then(|(_, parent)| parent)?
                .parent();
            let velocity = |entity| {
                moving
                    .get(entity)
                    .map_or(Vec3::ZERO, |(velocity, _)| velocity.0)
            };
            let look = |entity| {
                let (transform, parent) = places.get(entity).ok()?;
                let parent = parent.map(ChildOf::parent);
                Some(Ancestor {
                    transform: *transform,
                    velocity: velocity(entity),
                    parent,
                })
            };
            Some(Frame::of(parent, look))
        });
        let party = |which: usize, entity| {
            let own = moving
                .get(entity)
                .map_or(Vec3::ZERO, |(velocity, _)| velocity.0);
            // Who is reversed, has been.
            let party = Party {
                velocity: own,
                bounce: bounces[which],
                reversed: true,
                ..default()
            };
            frames[which].map_or(party, |frame| Party {
                velocity: frame.velocity_in_world(own),
                drift: frame.drift(),
                bounce: party.bounce.filter(|_| frame.leads_back()),
                ..party
            })
        };
        let parties = [party(0, contact.a), party(1, contact.b)];
        let placed = [a.placed(), b.placed()];
        let way = parties[0].velocity - parties[1].velocity;
        let geometry = tests.contact_in_passing(placed[0], placed[1], |_| way, &mut workspace);
        let Some(geometry) = geometry else { continue };
        for ((entity, frame), velocity) in [contact.a, contact.b]
            .into_iter()
            .zip(frames)
            .zip(respond(parties, geometry.normal))
        {
            let own = velocity.and_then(|velocity| {
                frame.map_or(Some(velocity), |frame| frame.own_velocity(velocity))
            });
            if let (Some(own), Ok((mut velocity, _))) = (own, moving.get_mut(entity)) {
                velocity.0 = own;
                counters.tick.bounces += 1;
            }
        }
    }
}
