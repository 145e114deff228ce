//! Impacts in the order of time, each with what follows from it.

use std::{
    cmp::{Ordering, Reverse},
    collections::BinaryHeap,
};

use bevy::{platform::collections::HashMap, prelude::*};

use super::{
    course::{Track, meet},
    outcomes::{Outcome, Outcomes},
};
use crate::{
    broad_phase::{BroadPhaseMethod, ObjectOctreeSettings, Pair, ProxyId, SpatialIndex},
    collision_index::CollisionIndex,
    components::BroadPhaseProxy,
    contacts::{SweptContact, Verdicts},
    filters,
    frame::{Ancestor, Frame},
    motion::MotionSettings,
    narrow_phase::{Contact, Moving, NarrowPhase, Placed, TimedContact, Workspace},
    settings::NarrowPhaseSettings,
};

/// Two bodies meet, if neither changes course before.
#[derive(Clone, Copy, Debug)]
struct Impact {
    pair: Pair,
    met: TimedContact,
    /// How fast the two come nearer to each other, per tick.
    closing: f32,
    /// How often each had changed course when this was found.
    versions: [u32; 2],
    /// Is neither on a way? Then they touch at the end of the tick, if nothing happens before.
    at_end: bool,
}

/// By time; where times are equal, those first that come nearer to each other the least, and then by pair. What slides into
/// a corner, or falls a little while it slides, thus answers to what it is on before it answers to what it is up against.
impl Ord for Impact {
    fn cmp(&self, other: &Self) -> Ordering {
        self.met
            .time
            .total_cmp(&other.met.time)
            .then(self.closing.total_cmp(&other.closing))
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

/// The state of the search: impacts to come, and what has become of bodies so far.
///
/// Bodies that changed course are in an index of their own, the N-objects octree, which takes up one change as fast as
/// there are few; all others are in the main index, with the boxes of their whole way.
#[derive(Debug)]
pub(super) struct Resolver {
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
            diverted: SpatialIndex::new(&BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::default())),
            diverted_ids: Vec::new(),
            candidates: Vec::new(),
            workspace: Workspace::default(),
        }
    }
}

/// Goes through the impacts of a tick: each may change the course of the two that meet, and so what they meet after it.
/// Impacts that thereby come to nothing are no contacts; those that come of it are.
pub(super) fn resolve_impacts(world: &mut World, mut resolver: Local<Resolver>) {
    let resolver = &mut *resolver;
    let time = world.get_resource::<Time>().copied();
    let seconds = world.resource::<MotionSettings>().step.seconds(time.as_ref()).unwrap_or(0.0);
    resolver.begin(world.resource::<Verdicts>(), world.resource::<CollisionIndex>());
    // Impacts are found for those who changed course, and nobody does so more often than its sub-steps say, plus once.
    while let Some(Reverse(impact)) = resolver.to_come.pop() {
        let Impact { pair, met, versions, at_end, .. } = impact;
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
                resolver.carry(world, entity, change, (met.time, seconds));
            }
        }
        resolver.look_ahead(world, met.time);
    }
    let mut outcomes = std::mem::take(&mut world.resource_mut::<Outcomes>().bodies);
    resolver.tell(world, &mut outcomes);
    world.resource_mut::<Outcomes>().bodies = outcomes;
    let displaced = resolver.tracks.iter().filter(|(_, track)| track.is_displaced()).map(|(id, _)| *id);
    world.resource_mut::<Verdicts>().replace_impacts(resolver.happened.drain(..), displaced, resolver.at_end.drain(..));
    resolver.end();
}

impl Resolver {
    fn begin(&mut self, verdicts: &Verdicts, index: &CollisionIndex) {
        let impact = |&SweptContact { pair, met }: &SweptContact| {
            let closing = closing(&index.moving(pair.a)?, &index.moving(pair.b)?, &met);
            Some(Reverse(Impact { pair, met, closing, versions: [0; 2], at_end: false }))
        };
        self.to_come.extend(verdicts.impacts().iter().filter_map(impact));
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
        let index = world.resource::<CollisionIndex>();
        let contact =
            Contact { normal: self.normal(index, impact, world.resource::<NarrowPhaseSettings>()), ..contact };
        let [Some(a), Some(b)] = self.tracks.get_disjoint_mut([&pair.a, &pair.b]) else { return [None; 2] };
        let ways = [a.way(), b.way()];
        let [a_turned, b_turned] = meet([a, b], &contact, time, seconds);
        [a_turned.then(|| a.way() - ways[0]), b_turned.then(|| b.way() - ways[1])]
    }

    /// The normal that counts for the velocities of the two: what is left of their ways may be too short to tell.
    fn normal(&mut self, index: &CollisionIndex, impact: &Impact, settings: &NarrowPhaseSettings) -> Vec3 {
        let Impact { pair, met: TimedContact { time, contact }, .. } = *impact;
        let moving = [pair.a, pair.b].map(|id| self.moving(index, id, time));
        let velocities = [pair.a, pair.b].map(|id| self.tracks.get(&id).map_or(Vec3::ZERO, Track::velocity));
        let [Some(a), Some(b)] = moving else { return contact.normal };
        let (at_a, at_b) = (a.at(0.0), b.at(0.0));
        let placed = [Placed::new(a.shape(), &at_a), Placed::new(b.shape(), &at_b)];
        let velocity = velocities[0] - velocities[1];
        settings.tests().normal_in_passing(placed[0], placed[1], contact.normal, velocity, &mut self.workspace)
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
    fn carry(&mut self, world: &World, entity: Entity, change: Vec3, (time, seconds): (f32, f32)) {
        let children = |entity| world.get::<Children>(entity).into_iter().flatten().copied();
        let mut open: Vec<_> = children(entity).collect();
        while let Some(child) = open.pop() {
            let id = world.get::<BroadPhaseProxy>(child).and_then(BroadPhaseProxy::id);
            if let Some(id) = id.filter(|id| self.know(*id, world))
                && let Some(track) = self.tracks.get_mut(&id)
            {
                track.carry(change, time, seconds);
                self.turned.push(id);
            }
            open.extend(children(child));
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
        index.index().for_each_overlapping(&aabb, |other| {
            if self.tracks.get(&other).is_none_or(|track| track.diverted.is_none()) {
                consider(other);
            }
        });
        self.diverted.for_each_overlapping(&aabb, |other| consider(self.diverted_ids[other.index()]));
        // Other than the order in which they are found, that of handles depends on no index.
        candidates.sort_unstable();
        for other in candidates.drain(..) {
            let pair = Pair::new(id, other);
            if filters::may_meet(world, pair)
                && let Some((met, closing, at_end)) = self.meeting(world.resource(), pair, time, tests)
            {
                let versions = [pair.a, pair.b].map(|id| self.version(id));
                self.to_come.push(Reverse(Impact { pair, met, closing, versions, at_end }));
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
    ) -> Option<(TimedContact, f32, bool)> {
        let (a, b) = (self.moving(index, pair.a, from)?, self.moving(index, pair.b, from)?);
        if [pair.a, pair.b].iter().any(|id| self.is_on_its_way(index, *id)) {
            let met = tests.time_of_impact(&a, &b, &mut self.workspace)?;
            // The ways are those of what is left of the tick.
            let left = (1.0 - from).max(f32::MIN_POSITIVE);
            return Some((met.after(from), closing(&a, &b, &met) / left, false));
        }
        let (at_a, at_b) = (a.at(1.0), b.at(1.0));
        let (a, b) = (Placed::new(a.shape(), &at_a), Placed::new(b.shape(), &at_b));
        let contact = tests.contact(a, b, &mut self.workspace)?;
        Some((TimedContact { time: 1.0, contact }, 0.0, true))
    }

    /// Tells what has become of all who met something, in the order of their entities.
    fn tell(&self, world: &World, outcomes: &mut Vec<Outcome>) {
        outcomes.clear();
        let changed = self.tracks.values().filter(|track| track.bounces > 0 || track.version > 0);
        let (mut children, mut places) = (Vec::new(), HashMap::<Entity, Vec3>::default());
        for track in changed {
            match track.frame {
                None => outcomes.push(Outcome::of(track, Some)),
                Some(frame) => children.push((frame.depth(), track)),
            }
        }
        if !children.is_empty() {
            // Who hangs on another that was put elsewhere has its own place by that.
            places.extend(outcomes.iter().filter_map(|outcome| Some((outcome.entity, outcome.place?.own?))));
            children.sort_unstable_by_key(|(depth, track)| (*depth, track.entity));
        }
        for (_, track) in children {
            let outcome = Outcome::of(track, |in_world| {
                let parent = world.get::<ChildOf>(track.entity)?.parent();
                let look = |entity| {
                    let mut ancestor = Ancestor::of(entity, world)?;
                    ancestor.transform.translation =
                        places.get(&entity).copied().unwrap_or(ancestor.transform.translation);
                    Some(ancestor)
                };
                Frame::of(parent, look).own_place(in_world)
            });
            places.extend(outcome.place.and_then(|place| Some((track.entity, place.own?))));
            outcomes.push(outcome);
        }
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

/// How fast two come nearer to each other where they meet.
fn closing(a: &Moving, b: &Moving, met: &TimedContact) -> f32 {
    let velocity = |moving: &Moving| moving.velocity_at(met.time, met.contact.point);
    (velocity(a) - velocity(b)).dot(met.contact.normal)
}
