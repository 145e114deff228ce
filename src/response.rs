//! What contacts do to velocities.

use bevy::{ecs::schedule::InternedScheduleLabel, prelude::*};

use crate::{
    collision_index::CollisionIndex,
    contacts::{ContactPair, Contacts, ImpactSystems},
    counters::CollisionCounters,
    filters::Sensor,
    motion::Velocity,
    narrow_phase::{Placed, Workspace},
    plugin::{CollisionSystems, NarrowPhaseSettings},
    swept::{Outcomes, apply_outcomes, clear_outcomes, resolve_impacts},
};

/// How an entity's [`Velocity`] answers to contacts. Entities without this component pass through each other, and are
/// only reported. Those that are [swept](crate::swept::Swept), and what they meet, answer at the time of impact.
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
        let something_bounces = any_with_component::<Bounce>;
        let some_impacts = |contacts: Res<Contacts>| !contacts.impacts().is_empty();
        let some_outcomes = |outcomes: Res<Outcomes>| !outcomes.is_empty();
        let at_rest = (reverse, reflect).chain().run_if(something_bounces);
        let answer = (apply_outcomes.run_if(some_outcomes), at_rest, clear_outcomes.run_if(some_outcomes)).chain();
        app.init_resource::<Outcomes>().add_systems(
            self.0,
            (
                // What was not applied in its tick comes too late.
                clear_outcomes
                    .after(CollisionSystems::BroadPhase)
                    .before(CollisionSystems::NarrowPhase)
                    .run_if(some_outcomes),
                resolve_impacts.in_set(ImpactSystems).run_if(some_impacts).run_if(something_bounces),
                answer.in_set(CollisionSystems::Response),
            ),
        );
    }
}

/// Contacts in which neither is a sensor, but for impacts on the way: these are answered when they happen.
fn solid(contacts: &Contacts, sensors: &Query<(), With<Sensor>>) -> impl Iterator<Item = ContactPair> {
    let some = !sensors.is_empty();
    let is_sensor = move |entity| some && sensors.contains(entity);
    let at_rest = |contact: &ContactPair| contacts.time_of_impact(contact.pair).is_none();
    contacts.iter().copied().filter(at_rest).filter(move |contact| !is_sensor(contact.a) && !is_sensor(contact.b))
}

fn reverse(
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

/// A restitution in its range; 0 for NaN.
fn share(restitution: f32) -> f32 {
    if restitution > 0.0 { restitution.min(1.0) } else { 0.0 }
}

impl Bounce {
    /// The restitution of those that reflect.
    fn restitution(self) -> Option<f32> {
        match self {
            Self::Reverse => None,
            Self::Reflect { restitution } => Some(share(restitution)),
        }
    }
}

/// The velocities that a contact leaves two with which approach each other; `None` for those that keep theirs. Who is
/// reversed, is so before the other is reflected.
pub(crate) fn respond(bounces: [Option<Bounce>; 2], velocities: [Vec3; 2], normal: Vec3) -> [Option<Vec3>; 2] {
    let reversed = |which: usize| bounces[which] == Some(Bounce::Reverse) && velocities[which] != Vec3::ZERO;
    let mut after = [0, 1].map(|which| reversed(which).then_some(-velocities[which]));
    let now = [0, 1].map(|which| after[which].unwrap_or(velocities[which]));
    let restitutions = bounces.map(|bounce| bounce.and_then(Bounce::restitution));
    if let Some(change) = reflection(restitutions, now, normal) {
        for which in [0, 1] {
            if restitutions[which].is_some() {
                after[which] = Some(now[which] + if which == 0 { -change } else { change });
            }
        }
    }
    after
}

/// How reflection changes the velocities of those with a restitution: that of the first the other way. `None` if nothing
/// is reflected.
fn reflection(restitutions: [Option<f32>; 2], velocities: [Vec3; 2], normal: Vec3) -> Option<Vec3> {
    let restitution = restitutions.into_iter().flatten().reduce(f32::min)?;
    let speed = (velocities[0] - velocities[1]).dot(normal);
    let sharers = restitutions.iter().flatten().count() as f32;
    (speed > 0.0).then(|| normal * (speed * (1.0 + restitution) / sharers))
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
        let bounce = |entity| moving.get(entity).ok().and_then(|(_, bounce)| bounce.copied());
        let restitutions = [contact.a, contact.b].map(|entity| bounce(entity).and_then(Bounce::restitution));
        if restitutions == [None; 2] {
            continue;
        }
        let [Some(a), Some(b)] = [contact.pair.a, contact.pair.b].map(|id| index.body(id)) else { continue };
        let placed = [Placed::new(&a.shape, &a.pose), Placed::new(&b.shape, &b.pose)];
        let Some(geometry) = settings.tests().contact(placed[0], placed[1], &mut workspace) else { continue };
        let velocity = |entity| moving.get(entity).map_or(Vec3::ZERO, |(velocity, _)| velocity.0);
        let velocities = [velocity(contact.a), velocity(contact.b)];
        let Some(change) = reflection(restitutions, velocities, geometry.normal) else { continue };
        for (entity, restitution, change) in
            [(contact.a, restitutions[0], -change), (contact.b, restitutions[1], change)]
        {
            if restitution.is_some()
                && let Ok((mut velocity, _)) = moving.get_mut(entity)
            {
                velocity.0 += change;
                counters.tick.bounces += 1;
            }
        }
    }
}
