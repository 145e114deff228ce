//! Bounces of what is looked at where it is at the end of a tick.

use bevy::{
    ecs::{archetype::Archetype, entity_disabling::DefaultQueryFilters, system::SystemParam},
    prelude::*,
};

use super::{
    answering::Answering,
    bounce::{Bounce, Party, respond},
    outcomes::Outcomes,
};
use crate::{
    collision_index::CollisionIndex,
    contacts::{ContactPair, Contacts},
    counters::CollisionCounters,
    disabled,
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
        let is_some_sensor = contact.entities().into_iter().any(is_sensor);
        !is_some_sensor && !contacts.met_on_the_way(&contact.key)
    };
    contacts.pairs().filter(is_solid).copied()
}

pub(super) fn reverse(
    contacts: Res<Contacts>,
    sensors: Query<(), With<Sensor>>,
    outcomes: Res<Outcomes>,
    answering: Answering,
    mut moving: Query<(&mut Velocity, &Bounce)>,
    mut counters: ResMut<CollisionCounters>,
    mut colliding: Local<Vec<Entity>>,
) {
    colliding.clear();
    let hearing = |contact: ContactPair| {
        let both = contact.entities().into_iter().zip(contact.hears());
        both.filter(|(_, hears)| *hears).map(|(entity, _)| entity)
    };
    let solid = solid(&contacts, &sensors);
    if answering.is_idle() {
        colliding.extend(solid.flat_map(hearing));
    } else {
        // What is part of the same body as the other is not met by it.
        let are_two = |contact: &ContactPair| {
            let [a, b] = contact.entities();
            answering.who(a) != answering.who(b)
        };
        let entities = solid.filter(are_two).flat_map(hearing);
        colliding.extend(entities.map(|entity| answering.who(entity)));
    }
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

/// What moves, and what it hangs on. For a system that [sees disabled entities](disabled::see_disabled): a disabled
/// parent is still where it is, and moves no more.
#[derive(SystemParam)]
pub(super) struct Movers<'w, 's> {
    moving: Query<
        'w,
        's,
        (
            &'static mut Velocity,
            Option<&'static Bounce>,
            &'static Archetype,
        ),
    >,
    places: Query<'w, 's, (&'static Transform, Option<&'static ChildOf>)>,
    filters: Option<Res<'w, DefaultQueryFilters>>,
}

impl Movers<'_, '_> {
    fn bounce(&self, entity: Entity) -> Option<Bounce> {
        let (_, bounce, archetype) = self.moving.get(entity).ok()?;
        bounce.copied().filter(|_| self.moves(archetype))
    }

    /// In the space of its parent.
    fn velocity(&self, entity: Entity) -> Vec3 {
        match self.moving.get(entity) {
            Ok((velocity, _, archetype)) if self.moves(archetype) => velocity.0,
            _ => Vec3::ZERO,
        }
    }

    fn moves(&self, archetype: &Archetype) -> bool {
        !disabled::is_disabled(archetype, self.filters.as_deref())
    }

    /// Leads from the space of an entity's parent to the world; `None` if it has none.
    fn frame(&self, entity: Entity) -> Option<Frame> {
        let (_, parent) = self.places.get(entity).ok()?;
        let look = |entity| {
            let (transform, parent) = self.places.get(entity).ok()?;
            Some(Ancestor {
                transform: *transform,
                velocity: self.velocity(entity),
                parent: parent.map(ChildOf::parent),
            })
        };
        Some(Frame::of(parent?.parent(), look))
    }

    /// An entity as the rule of bounces sees it: in the world.
    fn party(&self, entity: Entity, bounce: Option<Bounce>, frame: Option<&Frame>) -> Party {
        let own = self.velocity(entity);
        // Who is reversed, has been.
        let party = Party {
            velocity: own,
            bounce,
            reversed: true,
            ..default()
        };
        frame.map_or(party, |frame| Party {
            velocity: frame.velocity_in_world(own),
            drift: frame.drift(),
            bounce: bounce.filter(|_| frame.leads_back()),
            ..party
        })
    }

    /// How fast it is in the world.
    fn velocity_in_world(&self, entity: Entity) -> Vec3 {
        let own = self.velocity(entity);
        let frame = self.frame(entity);
        frame.map_or(own, |frame| frame.velocity_in_world(own))
    }

    /// Gives an entity a velocity in the world, if its own leads there. Returns `true` if it has it.
    fn set(&mut self, entity: Entity, velocity: Vec3, frame: Option<&Frame>) -> bool {
        let own = match frame {
            Some(frame) => frame.own_velocity(velocity),
            None => Some(velocity),
        };
        if let (Some(own), Ok((mut velocity, ..))) = (own, self.moving.get_mut(entity)) {
            velocity.0 = own;
            return true;
        }
        false
    }
}

pub(super) fn reflect(
    contacts: Res<Contacts>,
    sensors: Query<(), With<Sensor>>,
    (index, tests): (Res<CollisionIndex>, Res<NarrowPhase>),
    (answering, mut movers): (Answering, Movers),
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    let some_answer_for_others = !answering.is_idle();
    for contact in solid(&contacts, &sensors) {
        let parts = contact.entities();
        let entities = if some_answer_for_others {
            parts.map(|entity| answering.who(entity))
        } else {
            parts
        };
        if entities[0] == entities[1] {
            continue;
        }
        let hears = contact.hears();
        let bounces = [0, 1].map(|which| {
            let entity = Some(entities[which]).filter(|_| hears[which])?;
            movers.bounce(entity)
        });
        if bounces
            .iter()
            .all(|bounce| bounce.and_then(Bounce::restitution).is_none())
        {
            continue;
        }
        let [Some(a), Some(b)] = contact.key.ids.map(|id| index.body(id)) else {
            continue;
        };
        let frames = entities.map(|entity| movers.frame(entity));
        // How much faster parts are than the bodies that answer for them.
        let faster = [0, 1].map(|which| {
            let (part, body) = (parts[which], entities[which]);
            let is_led = part != body;
            is_led.then(|| movers.velocity_in_world(part) - movers.velocity_in_world(body))
        });
        let parties = [0, 1].map(|which| {
            let party = movers.party(entities[which], bounces[which], frames[which].as_ref());
            faster[which].map_or(party, |faster| party.faster(faster))
        });
        // Which of several normals counts is up to the way that the two go, of which the geometry
        // that the contacts may have knows nothing.
        let way = parties[0].velocity - parties[1].velocity;
        let geometry = tests.contact_in_passing(a.placed(), b.placed(), |_| way, &mut workspace);
        let Some(geometry) = geometry else { continue };
        for (which, answer) in respond(parties, geometry.normal).into_iter().enumerate() {
            if let Some(velocity) = answer
                && let velocity = velocity - faster[which].unwrap_or_default()
                && movers.set(entities[which], velocity, frames[which].as_ref())
            {
                counters.tick.bounces += 1;
            }
        }
    }
}
