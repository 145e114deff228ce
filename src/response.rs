//! What contacts do to velocities.

use bevy::{ecs::schedule::InternedScheduleLabel, prelude::*};

use crate::{
    collision_index::CollisionIndex,
    contacts::{ContactPair, Contacts},
    counters::CollisionCounters,
    filters::Sensor,
    motion::Velocity,
    narrow_phase::{Placed, Workspace},
    plugin::{CollisionSystems, NarrowPhaseSettings},
};

/// How an entity's [`Velocity`] answers to contacts. Entities without this component pass through each other, and are
/// only reported.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
pub enum Bounce {
    /// The velocity is reversed, once per tick at most, however many contacts there are (Swan 1994, section 1.2).
    ///
    /// It is reversed in every tick in which there is a contact, so that objects which do not get out of each other
    /// within one tick tremble in place: steps must be small against sizes, and starting positions free of overlap.
    #[default]
    Reverse,
    /// The velocity is reflected about the contact's normal, if the two approach each other: as between bodies of
    /// equal mass if both reflect, and as from a wall otherwise. Contacts act one after the other, in the order of the
    /// [`Contacts`].
    Reflect {
        /// The share of the approaching speed that is given back: 0 slides along, 1 loses nothing. A number outside
        /// 0 to 1 is taken as the nearest inside, and NaN as 0.
        restitution: f32,
    },
}

/// Bounce response: contacts to velocities.
#[derive(Clone, Debug)]
pub struct BouncePlugin(pub(crate) InternedScheduleLabel);

impl Plugin for BouncePlugin {
    fn build(&self, app: &mut App) {
        // Where nothing bounces, contacts are not looked at.
        let something_bounces = |bouncing: Query<(), With<Bounce>>| !bouncing.is_empty();
        let respond = (reverse, reflect).chain().run_if(something_bounces);
        app.add_systems(self.0, respond.in_set(CollisionSystems::Response));
    }
}

/// Contacts in which neither is a sensor.
fn solid(contacts: &Contacts, sensors: &Query<(), With<Sensor>>) -> impl Iterator<Item = ContactPair> {
    let some = !sensors.is_empty();
    let is_sensor = move |entity| some && sensors.contains(entity);
    contacts.iter().copied().filter(move |contact| !is_sensor(contact.a) && !is_sensor(contact.b))
}

fn reverse(
    contacts: Res<Contacts>,
    sensors: Query<(), With<Sensor>>,
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
        {
            velocity.0 = -velocity.0;
            counters.tick.bounces += 1;
        }
    }
}

/// A restitution in its range; 0 for NaN.
fn share(restitution: f32) -> f32 {
    if restitution > 0.0 { restitution.min(1.0) } else { 0.0 }
}

fn reflect(
    contacts: Res<Contacts>,
    sensors: Query<(), With<Sensor>>,
    index: Res<CollisionIndex>,
    settings: Res<NarrowPhaseSettings>,
    mut moving: Query<(&mut Velocity, Option<&Bounce>)>,
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    for contact in solid(&contacts, &sensors) {
        let responses = [contact.a, contact.b].map(|entity| match moving.get(entity) {
            Ok((_, Some(Bounce::Reflect { restitution }))) => Some(share(*restitution)),
            _ => None,
        });
        let Some(restitution) = responses.into_iter().flatten().reduce(f32::min) else { continue };
        let velocity = |entity| moving.get(entity).map_or(Vec3::ZERO, |(velocity, _)| velocity.0);
        let approach = velocity(contact.a) - velocity(contact.b);
        let [Some(a), Some(b)] = [contact.pair.a, contact.pair.b].map(|id| index.body(id)) else { continue };
        let placed = [Placed::new(&a.shape, &a.pose), Placed::new(&b.shape, &b.pose)];
        let Some(geometry) = settings.tests().contact(placed[0], placed[1], &mut workspace) else { continue };
        let speed = approach.dot(geometry.normal);
        if speed.is_nan() || speed <= 0.0 {
            continue;
        }
        let sharers = responses.iter().flatten().count() as f32;
        let change = geometry.normal * (speed * (1.0 + restitution) / sharers);
        for (entity, response, change) in [(contact.a, responses[0], -change), (contact.b, responses[1], change)] {
            if response.is_some()
                && let Ok((mut velocity, _)) = moving.get_mut(entity)
            {
                velocity.0 += change;
                counters.tick.bounces += 1;
            }
        }
    }
}
