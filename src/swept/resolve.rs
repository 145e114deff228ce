//! Impacts in the order of time, each with what follows from it.

use std::{
    cmp::{Ordering, Reverse},
    collections::BinaryHeap,
};

use bevy::{platform::collections::HashMap, prelude::*};

use super::track::{Track, meet};
use crate::{
    broad_phase::{Method, ObjectOctreeSettings, Pair, ProxyId, SpatialIndex},
    collision_index::CollisionIndex,
    components::BroadPhaseProxy,
    contacts::{Contacts, SweptContact},
    counters::CollisionCounters,
    filters,
    motion::{MotionSettings, Velocity},
    narrow_phase::{Contact, Moving, NarrowPhase, Placed, TimedContact, Workspace},
    plugin::NarrowPhaseSettings,
};

/// Two bodies meet, if neither changes course before.
#[derive(Clone, Copy, Debug)]
struct Impact {
    pair: Pair,
    met: TimedContact,
    /// How often each had changed course when this was found.
    versions: [u32; 2],
    /// Is neither on a way? Then they touch at the end of the tick, if nothing happens before.
    at_end: bool,
}

/// By time, and by pair where times are equal.
impl Ord for Impact {
    fn cmp(&self, other: &Self) -> Ordering {
        self.met
            .time
            .total_cmp(&other.met.time)
            .then(self.pair.cmp(&other.pair))
            .then(self.versions.cmp(&other.versions))
    }
}

impl PartialOrd for Impact {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Impact {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Impact {}

/// What becomes of bodies that met something on the way.
#[derive(Resource, Debug, Default)]
pub(crate) struct Outcomes {
    /// In the order of their entities.
    bodies: Vec<Outcome>,
}

#[derive(Clone, Copy, Debug)]
struct Outcome {
    entity: Entity,
    velocity: Vec3,
    bounces: u64,
    /// Where it is at the end of the tick, if it changed course.
    place: Option<Vec3>,
    /// Does it go there by itself, rather than with what it hangs on?
    has_turned: bool,
}

impl Outcomes {
    pub(crate) const fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Has the velocity of this entity answered to an impact in this tick?
    pub(crate) fn has_bounced(&self, entity: Entity) -> bool {
        self.bodies.binary_search_by_key(&entity, |body| body.entity).is_ok_and(|place| self.bodies[place].bounces > 0)
    }
}

/// The state of the search: impacts to come, and what has become of bodies so far.
///
/// Bodies that changed course are in an index of their own, the N-objects octree, which takes up one change as fast as
/// there are few; all others are in the main index, with the boxes of their whole way.
#[derive(Debug)]
pub(crate) struct Resolver {
    tracks: HashMap<ProxyId, Track>,
    to_come: BinaryHeap<Reverse<Impact>>,
    happened: Vec<SweptContact>,
    /// What those touch, at the end of the tick, that are on no way, and are elsewhere than they would have been.
    at_end: Vec<(Pair, Contact)>,
    /// Those who change course at an impact.
    turned: Vec<ProxyId>,
    diverted: SpatialIndex,
    /// By handle in `diverted`, that in the main index.
    diverted_ids: Vec<ProxyId>,
    candidates: Vec<ProxyId>,
    workspace: Workspace,
}

impl Default for Resolver {
    fn default() -> Self {
        Self {
            tracks: HashMap::default(),
            to_come: BinaryHeap::new(),
            happened: Vec::new(),
            at_end: Vec::new(),
            turned: Vec::new(),
            diverted: SpatialIndex::new(&Method::Octree(ObjectOctreeSettings::default())),
            diverted_ids: Vec::new(),
            candidates: Vec::new(),
            workspace: Workspace::default(),
        }
    }
}

/// Goes through the impacts of a tick: each may change the course of the two that meet, and so what they meet after it.
/// Impacts that thereby come to nothing are no contacts; those that come of it are.
pub(crate) fn resolve_impacts(world: &mut World, mut resolver: Local<Resolver>) {
    let resolver = &mut *resolver;
    let time = world.get_resource::<Time>().copied();
    let seconds = world.resource::<MotionSettings>().step.seconds(time.as_ref()).unwrap_or(0.0);
    resolver.begin(world.resource::<Contacts>());
    while let Some(Reverse(impact)) = resolver.to_come.pop() {
        let Impact { pair, met, versions, at_end } = impact;
        if [pair.a, pair.b].map(|id| resolver.version(id)) != versions {
            continue;
        }
        if at_end {
            resolver.at_end.push((pair, met.contact));
            continue;
        }
        resolver.happened.push(SweptContact { pair, met });
        let changes = resolver.answer(world, &impact, seconds);
        for (id, change) in [pair.a, pair.b].into_iter().zip(changes) {
            if let Some(change) = change
                && let Some(entity) = world.resource::<CollisionIndex>().entity(id)
            {
                resolver.turned.push(id);
                resolver.carry(world, entity, change, met.time);
            }
        }
        resolver.look_ahead(world, met.time);
    }
    resolver.tell(&mut world.resource_mut::<Outcomes>().bodies);
    let displaced = resolver.tracks.iter().filter(|(_, track)| track.is_displaced()).map(|(id, _)| *id);
    world.resource_mut::<Contacts>().set_impacts(resolver.happened.drain(..), displaced, resolver.at_end.drain(..));
    resolver.end();
}

impl Resolver {
    fn begin(&mut self, contacts: &Contacts) {
        let impact = |&SweptContact { pair, met }: &SweptContact| Impact { pair, met, versions: [0; 2], at_end: false };
        self.to_come.extend(contacts.impacts().iter().map(impact).map(Reverse));
    }

    /// How often a body has changed course.
    fn version(&self, id: ProxyId) -> u32 {
        self.tracks.get(&id).map_or(0, |track| track.version)
    }

    /// Has the two that meet answer. Returns by how much the ways of those change that change course, per tick.
    fn answer(&mut self, world: &World, impact: &Impact, seconds: f32) -> [Option<Vec3>; 2] {
        let Impact { pair, met: TimedContact { time, contact }, .. } = *impact;
        if !(self.know(pair.a, world) && self.know(pair.b, world)) {
            return [None; 2];
        }
        let [Some(a), Some(b)] = self.tracks.get_disjoint_mut([&pair.a, &pair.b]) else { return [None; 2] };
        let ways = [a.way(), b.way()];
        let [a_turned, b_turned] = meet([a, b], contact.normal, time, seconds);
        [a_turned.then(|| a.way() - ways[0]), b_turned.then(|| b.way() - ways[1])]
    }

    /// Begins to follow a body, unless that was done. False if it is gone.
    fn know(&mut self, id: ProxyId, world: &World) -> bool {
        if !self.tracks.contains_key(&id) {
            let Some(track) = Track::of(id, world) else { return false };
            self.tracks.insert(id, track);
        }
        true
    }

    /// All that hangs on an entity which changed course goes with it.
    fn carry(&mut self, world: &World, entity: Entity, change: Vec3, time: f32) {
        for &child in world.get::<Children>(entity).into_iter().flatten() {
            let id = world.get::<BroadPhaseProxy>(child).and_then(BroadPhaseProxy::id);
            if let Some(id) = id.filter(|id| self.know(*id, world))
                && let Some(track) = self.tracks.get_mut(&id)
            {
                track.carry(change, time);
                self.turned.push(id);
            }
            self.carry(world, child, change, time);
        }
    }

    /// Looks for what those meet on their new course that have just changed it.
    fn look_ahead(&mut self, world: &mut World, time: f32) {
        let mut turned = std::mem::take(&mut self.turned);
        let tests = world.resource::<NarrowPhaseSettings>().0;
        for id in &turned {
            self.put(*id, world.resource(), time, &tests);
        }
        self.diverted.update();
        for (place, id) in turned.iter().enumerate() {
            // Those before it have looked at it already.
            self.seek(world, *id, time, &turned[..place], &tests);
        }
        turned.clear();
        self.turned = turned;
    }

    /// Looks for what a body meets on its new course, `except` for some.
    fn seek(&mut self, world: &mut World, id: ProxyId, time: f32, except: &[ProxyId], tests: &NarrowPhase) {
        let handle = self.tracks.get(&id).and_then(|track| track.diverted);
        let Some(&aabb) = handle.and_then(|handle| self.diverted.proxies().get(handle)) else { return };
        let index = world.resource::<CollisionIndex>();
        let mut candidates = std::mem::take(&mut self.candidates);
        let proxies = index.index().proxies();
        let mut consider = |other: ProxyId| {
            if other != id && !except.contains(&other) && proxies.admits(id, other) {
                candidates.push(other);
            }
        };
        index.index().overlapping(&aabb, |other| {
            if self.tracks.get(&other).is_none_or(|track| track.diverted.is_none()) {
                consider(other);
            }
        });
        self.diverted.overlapping(&aabb, |other| consider(self.diverted_ids[other.index()]));
        // Other than the order in which they are found, that of handles depends on no index.
        candidates.sort_unstable();
        for other in candidates.drain(..) {
            let pair = Pair::new(id, other);
            if filters::may_meet(world, pair)
                && let Some((met, at_end)) = self.meeting(world.resource(), pair, time, tests)
            {
                let versions = [pair.a, pair.b].map(|id| self.version(id));
                self.to_come.push(Reverse(Impact { pair, met, versions, at_end }));
            }
        }
        self.candidates = candidates;
    }

    /// Files a body that changed course under the box of what is left of its way.
    fn put(&mut self, id: ProxyId, index: &CollisionIndex, time: f32, tests: &NarrowPhase) {
        let Some(aabb) = self.moving(index, id, time).and_then(|moving| tests.swept_aabb(&moving).ok()) else { return };
        let Some(track) = self.tracks.get_mut(&id) else { return };
        match track.diverted {
            // Boxes that are refused came from nothing finite.
            Some(handle) => {
                let _ = self.diverted.set(handle, &aabb);
            }
            None => {
                let Ok(handle) = self.diverted.insert(aabb) else { return };
                track.diverted = Some(handle);
                if self.diverted_ids.len() <= handle.index() {
                    self.diverted_ids.resize(handle.index() + 1, id);
                }
                self.diverted_ids[handle.index()] = id;
            }
        }
    }

    /// Is a body looked for all along its way?
    fn is_on_its_way(&self, index: &CollisionIndex, id: ProxyId) -> bool {
        index.is_on_its_way(id) || self.tracks.get(&id).is_some_and(Track::is_diverted)
    }

    /// The way of a body from a moment on.
    fn moving<'a>(&self, index: &'a CollisionIndex, id: ProxyId, time: f32) -> Option<Moving<'a>> {
        let whole = index.moving(id)?;
        Some(self.tracks.get(&id).map_or_else(|| whole.after(time), |track| track.after(time, &whole)))
    }

    /// When and how two meet, from a moment on; and whether that is at the end of the tick, since neither is on a way.
    fn meeting(
        &mut self,
        index: &CollisionIndex,
        pair: Pair,
        from: f32,
        tests: &NarrowPhase,
    ) -> Option<(TimedContact, bool)> {
        let (a, b) = (self.moving(index, pair.a, from)?, self.moving(index, pair.b, from)?);
        if [pair.a, pair.b].iter().any(|id| self.is_on_its_way(index, *id)) {
            return Some((tests.time_of_impact(&a, &b, &mut self.workspace)?.after(from), false));
        }
        let (at_a, at_b) = (a.at(1.0), b.at(1.0));
        let (a, b) = (Placed::new(a.shape(), &at_a), Placed::new(b.shape(), &at_b));
        let contact = tests.contact(a, b, &mut self.workspace)?;
        Some((TimedContact { time: 1.0, contact }, true))
    }

    /// Tells what has become of all who met something.
    fn tell(&self, outcomes: &mut Vec<Outcome>) {
        let changed = self.tracks.values().filter(|track| track.bounces > 0 || track.version > 0);
        let outcome = |track: &Track| Outcome {
            entity: track.entity,
            velocity: track.velocity,
            bounces: track.bounces,
            place: (track.version > 0).then(|| track.place(1.0)),
            has_turned: track.has_turned,
        };
        outcomes.clear();
        outcomes.extend(changed.map(outcome));
        outcomes.sort_unstable_by_key(|body| body.entity);
    }

    /// Forgets all of it.
    fn end(&mut self) {
        for handle in self.tracks.drain().filter_map(|(_, track)| track.diverted) {
            self.diverted.remove(handle);
        }
        self.diverted.update();
        // Sums nobody reads.
        self.workspace.counters = Default::default();
    }
}

/// Velocities and places become what the impacts have made of them.
pub(crate) fn apply_outcomes(
    outcomes: Res<Outcomes>,
    mut bodies: Query<(Option<&mut Velocity>, &mut Transform, &mut BroadPhaseProxy)>,
    settings: Res<NarrowPhaseSettings>,
    mut index: ResMut<CollisionIndex>,
    mut counters: ResMut<CollisionCounters>,
) {
    for outcome in &outcomes.bodies {
        // It may be gone.
        let Ok((velocity, mut transform, mut proxy)) = bodies.get_mut(outcome.entity) else { continue };
        if outcome.bounces > 0
            && let Some(mut velocity) = velocity
        {
            velocity.0 = outcome.velocity;
            counters.tick.bounces += outcome.bounces;
        }
        if let Some(place) = outcome.place
            && let Some(id) = proxy.id
        {
            if outcome.has_turned {
                transform.translation = place;
            }
            let proxy = proxy.bypass_change_detection();
            proxy.pose.translation = place;
            index.place(id, &proxy.pose, settings.tests());
        }
    }
    if outcomes.bodies.iter().any(|outcome| outcome.place.is_some()) {
        index.update();
    }
}

/// Each outcome is applied once.
pub(crate) fn clear_outcomes(mut outcomes: ResMut<Outcomes>) {
    outcomes.bodies.clear();
}
