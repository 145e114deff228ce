//! Impacts in the order of time, each with what follows from it.

use std::{
    cmp::{Ordering, Reverse},
    collections::BinaryHeap,
};

use bevy::{platform::collections::HashMap, prelude::*};

use super::{
    answering::is_lead,
    course::{Course, Turn, meet},
    outcomes::Outcomes,
};
use crate::{
    broad_phase::{
        BroadPhaseMethod, ObjectOctreeSettings, Pair, PairSearch, ProxyId, SpatialIndex,
    },
    collision_index::CollisionIndex,
    components::BroadPhaseProxy,
    contacts::{ContactKey, SweptContact, Verdicts},
    filters,
    motion::MotionSettings,
    narrow_phase::{Contact, Moving, NarrowPhase, Placed, TimedContact, Workspace, approach},
    parts::{BodyParts, CollisionBody},
};

/// Two bodies meet, if neither changes course before.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    /// The two, in the order of all: handles decide neither who answers first nor how numbers are
    /// rounded.
    key: ContactKey,
    /// Where that stands among others, if entities have places of their own.
    place: [u64; 2],
    /// When and how, in that order.
    met: TimedContact,
    /// How fast the two come nearer to each other, per tick.
    closing: f32,
    /// How often each had changed course when this was found: it comes to nothing if one does so
    /// again.
    versions: [u32; 2],
    /// Is neither on a way? Then they touch at the end of the tick, if nothing happens before.
    at_end: bool,
}

/// By time; where times are equal, those first that come nearer to each other the least, and then
/// by entities. What slides into a corner, or falls a little while it slides, thus answers to what it
/// is on before it answers to what it is up against.
impl Ord for Meeting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.met
            .time
            .total_cmp(&other.met.time)
            .then(self.closing.total_cmp(&other.closing))
            .then(self.place.cmp(&other.place))
            .then(self.key.cmp(&other.key))
            .then(self.versions.cmp(&other.versions))
    }
}

impl PartialOrd for Meeting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Meeting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Meeting {}

/// The state of the search: meetings to come, and what has become of bodies so far.
///
/// Bodies that changed course are in an index of their own, the N-objects octree, which follows one
/// change as fast as there are few; all others are in the main index, with the boxes of their whole
/// way.
#[derive(Debug)]
pub(super) struct Resolver {
    courses: HashMap<ProxyId, Course>,
    /// Those of bodies that answer for their parts, by entity: such a body need not have a shape.
    leads: HashMap<Entity, Course>,
    to_come: BinaryHeap<Reverse<Meeting>>,
    happened: Vec<SweptContact>,
    /// What those touch, at the end of the tick, that are on no way, and are elsewhere than they
    /// would have been.
    at_end: Vec<(ContactKey, Contact)>,
    /// Those who change course at an impact.
    turned: Vec<ProxyId>,
    diverted: SpatialIndex,
    /// By handle in `diverted`, that in the main index.
    diverted_ids: Vec<ProxyId>,
    candidates: Vec<ProxyId>,
    /// The two that met last, if they do not meet again on their new ways.
    parted: Option<Pair>,
    workspace: Workspace,
}

impl Default for Resolver {
    fn default() -> Self {
        Self {
            courses: HashMap::default(),
            leads: HashMap::default(),
            to_come: BinaryHeap::new(),
            happened: Vec::new(),
            at_end: Vec::new(),
            turned: Vec::new(),
            // One at a time is inserted, moved and asked about: that is what leaves are quick at.
            diverted: SpatialIndex::new(&BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings {
                max_objects: 64,
                search: PairSearch::Leaves,
                ..ObjectOctreeSettings::default()
            })),
            diverted_ids: Vec::new(),
            candidates: Vec::new(),
            parted: None,
            workspace: Workspace::default(),
        }
    }
}

/// Goes through the impacts of a tick: each may change the course of the two that meet, and so what
/// they meet after it. Meetings that thereby come to nothing are no contacts; those that come of it
/// are.
pub(super) fn resolve_impacts(world: &mut World, mut resolver: Local<Resolver>) {
    let resolver = &mut *resolver;
    let time = world.get_resource::<Time>().copied();
    let seconds = world
        .resource::<MotionSettings>()
        .step
        .seconds(time.as_ref())
        .unwrap_or(0.0);
    resolver.begin(
        world.resource::<Verdicts>(),
        world.resource::<CollisionIndex>(),
    );
    // Meetings are found for those who changed course, and nobody does so more often than its
    // sub-steps say, plus once.
    while let Some(Reverse(meeting)) = resolver.to_come.pop() {
        let Meeting {
            key,
            met,
            versions,
            at_end,
            ..
        } = meeting;
        if key.ids.map(|id| resolver.version(id)) != versions {
            continue;
        }
        if at_end {
            resolver.at_end.push((key, met.contact));
            continue;
        }
        resolver.happened.push(SweptContact { key, met });
        let turns = resolver.answer(world, &meeting, seconds);
        for (id, turn) in key.ids.into_iter().zip(turns) {
            resolver.follow(world, id, turn, (met.time, seconds));
        }
        resolver.note_parted(world.resource(), &meeting);
        resolver.look_ahead(world, met.time);
    }
    world.resource_scope(|world, mut outcomes: Mut<Outcomes>| {
        // A body with a shape that answers for it is one.
        let courses = resolver.courses.values();
        let others = courses.filter(|course| !course.is_own_lead());
        outcomes.note(others.chain(resolver.leads.values()), world);
    });
    let displaced = resolver
        .courses
        .iter()
        .filter(|(_, course)| course.is_displaced())
        .map(|(id, _)| *id);
    let mut verdicts = world.resource_mut::<Verdicts>();
    verdicts.replace_impacts(
        resolver.happened.drain(..),
        displaced,
        resolver.at_end.drain(..),
    );
    resolver.end();
}

impl Resolver {
    fn begin(&mut self, verdicts: &Verdicts, index: &CollisionIndex) {
        debug_assert!(
            self.courses.is_empty() && self.leads.is_empty() && self.to_come.is_empty(),
            "nothing is left of the last tick"
        );
        let meeting = |&SweptContact { key, met }: &SweptContact| {
            let [a, b] = key.ids.map(|id| index.moving(id));
            Some(Reverse(Meeting {
                key,
                place: index.places(key.ids),
                met,
                closing: closing(&a?, &b?, &met),
                versions: [0; 2],
                at_end: false,
            }))
        };
        self.to_come
            .extend(verdicts.impacts().iter().filter_map(meeting));
    }

    /// How often a body has changed course.
    fn version(&self, id: ProxyId) -> u32 {
        self.courses.get(&id).map_or(0, |course| course.version)
    }

    /// Has the two that meet answer.
    fn answer(&mut self, world: &World, meeting: &Meeting, seconds: f32) -> [Turn; 2] {
        let Meeting {
            key,
            met: TimedContact { time, contact },
            ..
        } = *meeting;
        if !key.ids.iter().all(|id| self.know(*id, world)) {
            return [Turn::Keeps; 2];
        }
        let index = world.resource::<CollisionIndex>();
        let proxies = index.index().proxies();
        let hears = filters::hear(key.ids.map(|id| proxies.filter(id).into()));
        let ways = key.ids.map(|id| self.moving(index, id, time));
        let [Some(way_a), Some(way_b)] = ways else {
            return [Turn::Keeps; 2];
        };
        let normal = self.normal([&way_a, &way_b], meeting, world.resource::<NarrowPhase>());
        let at_point = [&way_a, &way_b].map(|way| way.velocity_at(0.0, contact.point));
        let come_nearer = approach(at_point, normal);
        let contact = Contact { normal, ..contact };
        let [Some(a), Some(b)] = self.courses.get_disjoint_mut(key.ids.each_ref()) else {
            return [Turn::Keeps; 2];
        };
        let leads = [a.lead, b.lead];
        match leads.map(|lead| lead.map(|lead| lead.body)) {
            [None, None] => meet([a, b], hears, &contact, come_nearer, (time, seconds)),
            // What two parts do to each other changes nothing about how their body moves.
            [a, b] if a == b => [Turn::Keeps; 2],
            _ => {
                let mut both = [*a, *b];
                for (course, lead) in both.iter_mut().zip(&leads) {
                    if let Some(lead) = lead
                        && let Some(body) = self.leads.get(&lead.body)
                    {
                        *course = course.led(lead, body);
                    }
                }
                let turns = meet(
                    both.each_mut(),
                    hears,
                    &contact,
                    come_nearer,
                    (time, seconds),
                );
                for ((course, id), lead) in both.into_iter().zip(key.ids).zip(leads) {
                    match lead {
                        Some(lead) => _ = self.leads.insert(lead.body, course.alone()),
                        None => _ = self.courses.insert(id, course),
                    }
                }
                turns
            }
        }
    }

    /// Has all that goes with a body do what it does.
    fn follow(&mut self, world: &World, id: ProxyId, turn: Turn, at: (f32, f32)) {
        let lead = self.courses.get(&id).and_then(|course| course.lead);
        match (turn, lead) {
            (Turn::Keeps, _) | (Turn::Ends, None) => {}
            (Turn::Diverts(change), None) => {
                if let Some(entity) = world.resource::<CollisionIndex>().entity(id) {
                    self.turned.push(id);
                    self.carry(world, children(world, entity).collect(), change, at);
                }
            }
            (Turn::Diverts(change), Some(lead)) => {
                self.carry_body(world, lead.body, change, at);
            }
            (Turn::Ends, Some(lead)) => {
                let parts = world.get::<BodyParts>(lead.body);
                for part in parts.into_iter().flat_map(BodyParts::entities) {
                    if let Some(course) = self.course_of(world, *part)
                        && course.lead.is_some_and(|own| own.body == lead.body)
                    {
                        course.end();
                    }
                }
            }
        }
    }

    /// The normal that counts for the velocities of the two: what is left of their ways may be too
    /// short to tell.
    fn normal(&mut self, [a, b]: [&Moving; 2], meeting: &Meeting, tests: &NarrowPhase) -> Vec3 {
        let Meeting { key, met, .. } = *meeting;
        let velocity = |id| {
            self.courses
                .get(&id)
                .map_or(Vec3::ZERO, |course| self.velocity(course))
        };
        let velocities = key.ids.map(velocity);
        let (at_a, at_b) = (a.at(0.0), b.at(0.0));
        let placed = [Placed::new(a.shape(), &at_a), Placed::new(b.shape(), &at_b)];
        let velocity = velocities[0] - velocities[1];
        tests.normal_in_passing(
            placed[0],
            placed[1],
            met.contact.normal,
            velocity,
            &mut self.workspace,
        )
    }

    /// How fast a body is that is followed, in the world.
    fn velocity(&self, course: &Course) -> Vec3 {
        let lead = course
            .lead
            .and_then(|lead| Some(self.leads.get(&lead.body)?.velocity_of_part(&lead)));
        lead.unwrap_or_else(|| course.velocity())
    }

    /// Begins to follow a body, and the one that answers for it, unless that was done. False if it
    /// is gone.
    fn know(&mut self, id: ProxyId, world: &World) -> bool {
        if !self.courses.contains_key(&id) {
            let Some(course) = Course::of(id, world) else {
                return false;
            };
            if let Some(lead) = course.lead {
                self.know_lead(lead.body, world);
            }
            self.courses.insert(id, course);
        }
        true
    }

    /// Begins to follow a body that answers for its parts, unless that was done.
    fn know_lead(&mut self, body: Entity, world: &World) -> Option<&mut Course> {
        if !self.leads.contains_key(&body) {
            self.leads.insert(body, Course::of_body(body, world)?);
        }
        self.leads.get_mut(&body)
    }

    /// The course of an entity that takes part.
    fn course_of(&mut self, world: &World, entity: Entity) -> Option<&mut Course> {
        let id = world.get::<BroadPhaseProxy>(entity)?.id()?;
        self.know(id, world);
        self.courses.get_mut(&id)
    }

    /// All parts of a body which changed course, and all else that hangs on it, go with it.
    fn carry_body(&mut self, world: &World, body: Entity, change: Vec3, at: (f32, f32)) {
        self.carry_one(world, body, change, at);
        self.carry(world, children(world, body).collect(), change, at);
    }

    /// These, and all that hangs on them, go with what they hang on, which changed course.
    fn carry(&mut self, world: &World, mut open: Vec<Entity>, change: Vec3, at: (f32, f32)) {
        while let Some(child) = open.pop() {
            if world.get::<CollisionBody>(child).is_some()
                && is_lead(child, world)
                && let Some(lead) = self.know_lead(child, world)
            {
                lead.carry(change, at.0, at.1);
            }
            self.carry_one(world, child, change, at);
            open.extend(children(world, child));
        }
    }

    fn carry_one(&mut self, world: &World, entity: Entity, change: Vec3, at: (f32, f32)) {
        if let Some(course) = self.course_of(world, entity) {
            course.carry(change, at.0, at.1);
            let id = world.get::<BroadPhaseProxy>(entity);
            self.turned.extend(id.and_then(BroadPhaseProxy::id));
        }
    }

    /// Takes note of two that have met, if they part.
    fn note_parted(&mut self, index: &CollisionIndex, &Meeting { key, met, .. }: &Meeting) {
        let [a, b] = key.ids.map(|id| self.moving(index, id, met.time));
        let parts = |(a, b): (Moving, Moving)| a.parts_from(&b, met.contact.normal);
        self.parted = a.zip(b).is_some_and(parts).then_some(key.pair());
    }

    /// Looks for what those meet on their new course that have just changed it.
    fn look_ahead(&mut self, world: &mut World, time: f32) {
        let mut turned = std::mem::take(&mut self.turned);
        let mut candidates = std::mem::take(&mut self.candidates);
        let tests = *world.resource::<NarrowPhase>();
        for id in &turned {
            self.file(*id, world.resource(), time, &tests);
        }
        self.diverted.update();
        for (index, id) in turned.iter().enumerate() {
            // Those before it have looked at all that is on its way, and so at this one: a pair is
            // sought once.
            self.seek(world.resource(), *id, &turned[..index], &mut candidates);
            self.meet_all(world, *id, time, &tests, &mut candidates);
        }
        turned.clear();
        (self.turned, self.candidates) = (turned, candidates);
    }

    /// Files a body that changed course under the box of what is left of its way.
    fn file(&mut self, id: ProxyId, index: &CollisionIndex, time: f32, tests: &NarrowPhase) {
        let Some(aabb) = self
            .moving(index, id, time)
            .and_then(|moving| tests.swept_aabb(&moving).ok())
        else {
            return;
        };
        let Some(course) = self.courses.get_mut(&id) else {
            return;
        };
        match course.diverted {
            // Boxes that are refused came from nothing finite.
            Some(handle) => {
                debug_assert_eq!(
                    self.diverted_ids[handle.index()],
                    id,
                    "a handle is that of one body"
                );
                let _ = self.diverted.set(handle, &aabb);
            }
            None => {
                let Ok(handle) = self.diverted.insert(aabb) else {
                    return;
                };
                course.diverted = Some(handle);
                if self.diverted_ids.len() <= handle.index() {
                    self.diverted_ids.resize(handle.index() + 1, id);
                }
                self.diverted_ids[handle.index()] = id;
            }
        }
    }

    /// Who may be met by a body that is [filed](Self::file), `except` for some: those on a new
    /// course by that, all others by their whole way.
    fn seek(
        &self,
        index: &CollisionIndex,
        id: ProxyId,
        except: &[ProxyId],
        candidates: &mut Vec<ProxyId>,
    ) {
        let handle = self.courses.get(&id).and_then(|course| course.diverted);
        let Some(&aabb) = handle.and_then(|handle| self.diverted.proxies().get(handle)) else {
            return;
        };
        let proxies = index.index().proxies();
        let mut consider = |other: ProxyId| {
            if other != id && !except.contains(&other) && proxies.admits(id, other) {
                candidates.push(other);
            }
        };
        index.index().for_each_overlapping(&aabb, |other| {
            if self
                .courses
                .get(&other)
                .is_none_or(|course| course.diverted.is_none())
            {
                consider(other);
            }
        });
        self.diverted
            .for_each_overlapping(&aabb, |other| consider(self.diverted_ids[other.index()]));
        // Other than the order in which they are found, that of handles depends on no index.
        candidates.sort_unstable();
        debug_assert!(
            candidates.is_sorted_by(|a, b| a < b),
            "each is in one of the two"
        );
    }

    /// Takes note of when a body meets these, from a moment on, if lists and hooks let it.
    fn meet_all(
        &mut self,
        world: &mut World,
        id: ProxyId,
        time: f32,
        tests: &NarrowPhase,
        candidates: &mut Vec<ProxyId>,
    ) {
        for other in candidates.drain(..) {
            let pair = Pair::new(id, other);
            if self.parted != Some(pair)
                && filters::may_meet(world, pair)
                && let Some(meeting) = self.meeting(world.resource(), pair, time, tests)
            {
                self.to_come.push(Reverse(meeting));
            }
        }
    }

    /// Is a body looked for all along its way?
    fn is_on_its_way(&self, index: &CollisionIndex, id: ProxyId) -> bool {
        index.is_on_its_way(id) || self.courses.get(&id).is_some_and(Course::is_diverted)
    }

    /// The way of a body from a moment on.
    fn moving<'a>(&self, index: &'a CollisionIndex, id: ProxyId, time: f32) -> Option<Moving<'a>> {
        let whole = index.moving(id)?;
        Some(
            self.courses
                .get(&id)
                .map_or_else(|| whole.after(time), |course| course.after(time, &whole)),
        )
    }

    /// When and how two meet, from a moment on.
    fn meeting(
        &mut self,
        index: &CollisionIndex,
        pair: Pair,
        from: f32,
        tests: &NarrowPhase,
    ) -> Option<Meeting> {
        let key = ContactKey::of(pair, index);
        let has_ended = |id| self.courses.get(id).is_some_and(|course| course.has_ended);
        if key.ids.iter().any(has_ended) {
            return None;
        }
        let [a, b] = key.ids.map(|id| self.moving(index, id, from));
        let (a, b) = (a?, b?);
        let versions = key.ids.map(|id| self.version(id));
        if key.ids.iter().any(|id| self.is_on_its_way(index, *id)) {
            let met = tests.time_of_impact(&a, &b, &mut self.workspace)?;
            // The ways are those of what is left of the tick.
            let left = (1.0 - from).max(f32::MIN_POSITIVE);
            let closing = closing(&a, &b, &met) / left;
            return Some(Meeting {
                key,
                place: index.places(key.ids),
                met: met.after(from),
                closing,
                versions,
                at_end: false,
            });
        }
        let (at_a, at_b) = (a.at(1.0), b.at(1.0));
        let (a, b) = (Placed::new(a.shape(), &at_a), Placed::new(b.shape(), &at_b));
        let met = TimedContact {
            time: 1.0,
            contact: tests.contact(a, b, &mut self.workspace)?,
        };
        Some(Meeting {
            key,
            place: index.places(key.ids),
            met,
            closing: 0.0,
            versions,
            at_end: true,
        })
    }

    /// Forgets all of it.
    fn end(&mut self) {
        for handle in self
            .courses
            .drain()
            .filter_map(|(_, course)| course.diverted)
        {
            self.diverted.remove(handle);
        }
        self.leads.clear();
        self.diverted.update();
        // Sums nobody reads.
        self.workspace.counters = Default::default();
    }
}

fn children(world: &World, entity: Entity) -> impl Iterator<Item = Entity> {
    world.get::<Children>(entity).into_iter().flatten().copied()
}

/// How fast two come nearer to each other where they meet.
fn closing(a: &Moving, b: &Moving, met: &TimedContact) -> f32 {
    let velocity = |moving: &Moving| moving.velocity_at(met.time, met.contact.point);
    (velocity(a) - velocity(b)).dot(met.contact.normal)
}
