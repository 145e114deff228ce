//! What contacts do to velocities.

use bevy::{ecs::entity_disabling::Disabled, math::DVec3, prelude::*};

use crate::{
    collision_index::CollisionIndex,
    contacts::{ContactPair, Contacts},
    counters::CollisionCounters,
    filters::Sensor,
    frame::{Ancestor, Frame},
    motion::Velocity,
    narrow_phase::{Placed, Workspace},
    schedule::{CollisionSystems, ImpactSystems, add_to_tick},
    settings::NarrowPhaseSettings,
    swept::{Outcomes, apply_outcomes, clear_outcomes, resolve_impacts},
};

/// How an entity's [`Velocity`] answers to contacts. This happens in the world: velocities of entities with a parent are
/// taken there and back, through the whole hierarchy. One whose ancestors are scaled to nothing has no answer. Entities without this component pass through each other, and are
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
    ///
    /// What has no `Bounce` is a wall that moves as its velocity says. One that is [reversed](Self::Reverse) is at rest to
    /// what it comes towards. So bounces make no energy but by the walls that move.
    ///
    /// Where two no more than touch, edge on edge, the normal is the one along which they approach the least: a box that
    /// slides over a floor of flush boxes goes on over the seams.
    Reflect {
        /// The share of the approaching speed that is given back: 0 slides along, 1 loses nothing. A number outside
        /// 0 to 1 is taken as the nearest inside, and NaN as 0.
        restitution: f32,
    },
}

/// Bounce response: contacts to velocities.
#[derive(Clone, Copy, Debug, Default)]
pub struct BouncePlugin;

impl Plugin for BouncePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Outcomes>();
        add_to_tick(app, |app, schedule| {
            // Where nothing bounces, contacts are not looked at.
            let something_bounces = any_with_component::<Bounce>;
            let some_impacts = |contacts: Res<Contacts>| !contacts.impacts().is_empty();
            let some_outcomes = |outcomes: Res<Outcomes>| !outcomes.is_empty();
            // What was not applied in its tick comes too late.
            let clear = clear_outcomes.after(CollisionSystems::BroadPhase).before(CollisionSystems::NarrowPhase);
            let resolve = resolve_impacts.in_set(ImpactSystems).run_if(some_impacts).run_if(something_bounces);
            let at_rest = (reverse, reflect).chain().run_if(something_bounces);
            let answer = (apply_outcomes.run_if(some_outcomes), at_rest, clear_outcomes.run_if(some_outcomes));
            let answer = answer.chain().in_set(CollisionSystems::Response);
            app.add_systems(schedule, (clear.run_if(some_outcomes), resolve, answer));
        });
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

/// One of the two in a contact, as the response sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Party {
    /// In the world.
    pub(crate) velocity: Vec3,
    /// How much of it is that of what the entity hangs on: this part is not its own to change.
    pub(crate) drift: Vec3,
    pub(crate) bounce: Option<Bounce>,
    /// Has it been reversed in this tick? It is so once at most.
    pub(crate) reversed: bool,
}

impl Party {
    fn restitution(&self) -> Option<f32> {
        self.bounce.and_then(Bounce::restitution)
    }

    /// The party after its velocity was reversed, if it is.
    fn turned_around(self) -> Option<Self> {
        let turns = self.bounce == Some(Bounce::Reverse) && !self.reversed && self.velocity != self.drift;
        turns.then(|| Self { velocity: 2.0 * self.drift - self.velocity, reversed: true, ..self })
    }

    /// How fast it is to the other, which is in that direction. Who turns around has given nothing up, and so has nothing
    /// to give: to what it comes towards, it is at rest.
    fn as_a_wall(&self, towards_other: Vec3) -> Vec3 {
        let comes = (self.velocity - self.drift).dot(towards_other) > 0.0;
        if self.bounce == Some(Bounce::Reverse) && comes { self.drift } else { self.velocity }
    }
}

/// The velocities in the world that a contact leaves two with; `None` for those that keep theirs. Who is reversed, is so
/// before the other is reflected. Energy does not grow but by what those do that have no [`Bounce`], or hang on something.
pub(crate) fn respond(parties: [Party; 2], normal: Vec3) -> [Option<Vec3>; 2] {
    let turned = parties.map(Party::turned_around);
    let now = [0, 1].map(|which| turned[which].unwrap_or(parties[which]));
    let mut after = turned.map(|turned| turned.map(|party| party.velocity));
    let walls = [now[0].as_a_wall(normal), now[1].as_a_wall(-normal)];
    if let Some(change) = reflection(now.map(|party| party.restitution()), walls, normal) {
        for (which, change) in [-change, change].into_iter().enumerate() {
            if now[which].restitution().is_some() {
                // A velocity beyond all numbers is none.
                let velocity = (now[which].velocity.as_dvec3() + change).as_vec3();
                after[which] = Some(velocity).filter(|velocity| velocity.is_finite());
            }
        }
    }
    after
}

/// How reflection changes the velocities of those with a restitution: that of the first the other way. `None` if nothing
/// is reflected.
fn reflection(restitutions: [Option<f32>; 2], velocities: [Vec3; 2], normal: Vec3) -> Option<DVec3> {
    let restitution = restitutions.into_iter().flatten().reduce(f32::min)?;
    // In 64 bits, and with the normal's length as rounding left it: bounces by the thousand must not add up to anything.
    let [a, b, normal] = [velocities[0], velocities[1], normal].map(Vec3::as_dvec3);
    let speed = (a - b).dot(normal);
    let sharers = restitutions.iter().flatten().count() as f64;
    let change = speed * (1.0 + f64::from(restitution)) / (sharers * normal.length_squared());
    (speed > 0.0).then(|| normal * change)
}

fn reflect(
    contacts: Res<Contacts>,
    sensors: Query<(), With<Sensor>>,
    (index, settings): (Res<CollisionIndex>, Res<NarrowPhaseSettings>),
    mut moving: Query<(&mut Velocity, Option<&Bounce>)>,
    // A disabled parent is still where it is.
    places: Query<(&Transform, Option<&ChildOf>), Allow<Disabled>>,
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    for contact in solid(&contacts, &sensors) {
        let bounce = |entity| moving.get(entity).ok().and_then(|(_, bounce)| bounce.copied());
        let bounces = [contact.a, contact.b].map(bounce);
        if bounces.iter().all(|bounce| bounce.and_then(Bounce::restitution).is_none()) {
            continue;
        }
        let [Some(a), Some(b)] = [contact.pair.a, contact.pair.b].map(|id| index.body(id)) else { continue };
        let frames = [contact.a, contact.b].map(|entity| {
            let parent = places.get(entity).ok().and_then(|(_, parent)| parent)?.parent();
            let velocity = |entity| moving.get(entity).map_or(Vec3::ZERO, |(velocity, _)| velocity.0);
            let look = |entity| {
                let (transform, parent) = places.get(entity).ok()?;
                let parent = parent.map(ChildOf::parent);
                Some(Ancestor { transform: *transform, velocity: velocity(entity), parent })
            };
            Some(Frame::of(parent, look))
        });
        let party = |which: usize, entity| {
            let own = moving.get(entity).map_or(Vec3::ZERO, |(velocity, _)| velocity.0);
            // Who is reversed, has been.
            let party = Party { velocity: own, bounce: bounces[which], reversed: true, ..default() };
            frames[which].map_or(party, |frame| Party {
                velocity: frame.velocity_in_world(own),
                drift: frame.drift(),
                bounce: party.bounce.filter(|_| frame.leads_back()),
                ..party
            })
        };
        let parties = [party(0, contact.a), party(1, contact.b)];
        let placed = [Placed::new(&a.shape, &a.pose), Placed::new(&b.shape, &b.pose)];
        let way = parties[0].velocity - parties[1].velocity;
        let geometry = settings.tests().contact_in_passing(placed[0], placed[1], |_| way, &mut workspace);
        let Some(geometry) = geometry else { continue };
        for ((entity, frame), velocity) in
            [contact.a, contact.b].into_iter().zip(frames).zip(respond(parties, geometry.normal))
        {
            let own = velocity.and_then(|velocity| frame.map_or(Some(velocity), |frame| frame.own_velocity(velocity)));
            if let (Some(own), Ok((mut velocity, _))) = (own, moving.get_mut(entity)) {
                velocity.0 = own;
                counters.tick.bounces += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bounces() -> impl Strategy<Value = Option<Bounce>> {
        let reflect = (0f32..=1.0).prop_map(|restitution| Some(Bounce::Reflect { restitution }));
        prop_oneof![Just(Some(Bounce::Reverse)), Just(Some(Bounce::Reflect { restitution: 1.0 })), reflect, Just(None)]
    }

    fn parties() -> impl Strategy<Value = Party> {
        let velocity = prop::array::uniform3(-9f32..9.0).prop_map(Vec3::from);
        (velocity, bounces(), any::<bool>()).prop_map(|(velocity, bounce, reversed)| Party {
            // Who has no answer is a wall at rest.
            velocity: if bounce.is_some() { velocity } else { Vec3::ZERO },
            drift: Vec3::ZERO,
            bounce,
            reversed,
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 4096, ..ProptestConfig::default() })]

        #[test]
        fn no_contact_makes_energy(a in parties(), b in parties(), normal in prop::array::uniform3(-1f32..1.0)) {
            let Some(normal) = Vec3::from(normal).try_normalize() else { return Ok(()) };
            let energy = |velocities: [Vec3; 2]| velocities.iter().map(|v| v.as_dvec3().length_squared()).sum::<f64>();
            let before = [a.velocity, b.velocity];
            let answers = respond([a, b], normal);
            let after = [0, 1].map(|which| answers[which].unwrap_or(before[which]));
            prop_assert!(energy(after) <= energy(before) * (1.0 + 1e-6), "{before:?} {after:?}");
            let is_elastic = |party: Party| party.bounce == Some(Bounce::Reflect { restitution: 1.0 });
            if is_elastic(a) && is_elastic(b) {
                prop_assert!(energy(after) >= energy(before) * (1.0 - 1e-6), "{before:?} {after:?}");
                prop_assert!((after[0] + after[1]).distance(before[0] + before[1]) < 1e-5);
            }
        }
    }

    #[test]
    fn what_is_too_fast_for_numbers_keeps_its_velocity() {
        let elastic = Some(Bounce::Reflect { restitution: 1.0 });
        let party = |x: f32, bounce| Party { velocity: Vec3::X * x, bounce, ..default() };
        assert_eq!(
            respond([party(3e38, elastic), party(-3e38, elastic)], Vec3::X),
            [Some(Vec3::X * -3e38), Some(Vec3::X * 3e38)]
        );
        assert_eq!(respond([party(3e38, elastic), party(-3e38, None)], Vec3::X), [None; 2]);
    }
}
