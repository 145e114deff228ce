//! All contacts, and how they are brought from one tick to the next.

use std::sync::OnceLock;

use bevy::{ecs::entity::EntityHashMap, prelude::*};

use super::{
    adjacency::Adjacency,
    arrangement::{Arrangement, InOrder},
    bodies::{Audience, BodyCollision, BodyContacts, BodyPair, Owners, Places},
    ledger::{Changes, Ledger},
    manifolds::Manifolds,
    pair::{Collision, ContactKey, ContactPair, SweptContact, seek},
    settings::EventScope,
    verdicts::Verdicts,
    watched::{self, WatchedContact},
};
use crate::{
    broad_phase::ProxyId,
    collision_index::{CollisionIndex, IndexState},
    narrow_phase::{Contact, Manifold},
};

/// All pairs of entities in contact, in the order of the entities: by the index of the one that has
/// the lower, then by that of the other. That order does not depend on the broad phase, on the
/// number of threads, or on who else came and went. Entities with a
/// [`CollisionOrder`](crate::collision_order::CollisionOrder) stand where that says.
///
/// After [`NarrowPhase`](crate::CollisionSystems::NarrowPhase), those of this tick; before it,
/// those of the last. A contact is a [`Collision`], as seen from one of the two.
///
/// For systems there is the parameter [`Collisions`](super::Collisions), which answers without the
/// look at all contacts that the first question about an entity costs here.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{prelude::*, scene::Cube};
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// let [a, b] = [0.0, 0.75].map(|x| app.world_mut().spawn((Cube, Transform::from_xyz(x, 0.0, 0.0))).id());
/// app.update();
/// let contacts = app.world().resource::<Contacts>();
/// assert!(contacts.contains(a, b));
/// assert_eq!(contacts.between(b, a).unwrap().b, a); // as seen from the first
/// assert_eq!(contacts.of(a).count(), 1);
/// ```
#[doc(alias("collisions", "contact graph"))]
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource, Debug, Default)]
#[type_path = "bevy_octree"]
pub struct Contacts {
    all: Ledger,
    /// In which order they are told.
    #[reflect(ignore)]
    arrangement: Arrangement,
    /// The search for pairs that they are the verdicts on, by its number in the index.
    search: u64,
    /// Which index that was.
    #[reflect(ignore)]
    index: u64,
    /// The state of the index then, if it was that of the search.
    #[reflect(ignore)]
    state: Option<IndexState>,
    /// Those of which more is known, in the order of keys; of the last report; and of the last
    /// tick, unreported.
    #[reflect(ignore)]
    watched: Vec<WatchedContact>,
    #[reflect(ignore)]
    watched_before: Vec<WatchedContact>,
    #[reflect(ignore)]
    watched_unreported: Vec<WatchedContact>,
    /// Whom messages were for at the last report.
    scope_reported: Option<EventScope>,
    /// Those of parts of bodies, now and at the last report.
    #[reflect(ignore)]
    bodies: BodyContacts,
    #[reflect(ignore)]
    bodies_before: BodyContacts,
    /// Where those lie on each other of which somebody asked, in the order of keys.
    #[reflect(ignore)]
    manifolds: Manifolds,
    /// When and how those met of which one is swept, in the order of keys.
    #[reflect(ignore)]
    impacts: Vec<SweptContact>,
    /// Made when they are first asked for in a tick.
    #[reflect(ignore)]
    by_object: OnceLock<Adjacency>,
    #[reflect(ignore)]
    handles: OnceLock<EntityHashMap<ProxyId>>,
}

/// # By entity
///
/// Whatever is asked about an entity takes O(contacts) for the first question in a tick.
impl Contacts {
    /// Returns all contacts, each as seen from the entity with the lower index. O(1) for each; O(log n),
    /// if there is a [`CollisionOrder`](crate::collision_order::CollisionOrder).
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Collision> {
        let mut watched = self.watched.iter().peekable();
        let mut bodies = self.bodies.walk();
        let is_by_key = !self.arrangement.is_own();
        self.in_order().map(move |contact| {
            if !is_by_key {
                return self.collision(contact);
            }
            let watched = seek(&mut watched, &contact.key, WatchedContact::key);
            contact.collision(
                watched.map(|watched| watched.geometry),
                bodies(&contact.key),
            )
        })
    }

    /// Returns the contact of two entities, as seen from the first, if they are in contact. O(log
    /// n).
    #[must_use]
    pub fn between(&self, a: Entity, b: Entity) -> Option<Collision> {
        Some(self.collision(self.find([a, b])?).seen_from(a))
    }

    /// Returns the contacts of an entity, as seen from it, in the order of all; not those with a
    /// [detector](crate::filters::Detector) that it does not hear of. O(log n) for each.
    pub fn of(&self, entity: Entity) -> impl Iterator<Item = Collision> {
        let id = self.handles().get(&entity);
        let contacts = id
            .map(|id| self.of_handle(entity, *id))
            .into_iter()
            .flatten();
        contacts.map(move |contact| self.collision(contact).seen_from(entity))
    }

    /// Returns `true` if two entities are in contact. O(log n).
    #[must_use]
    pub fn contains(&self, a: Entity, b: Entity) -> bool {
        self.find([a, b]).is_some()
    }

    /// Returns the share of the tick after which two entities came into contact of which one is
    /// [swept](crate::swept::Swept): 0 to 1; that of the first time, if there were several. `None`
    /// for others: they are looked at where they are at the end of a tick. O(log n).
    #[must_use]
    pub fn time_of_impact(&self, a: Entity, b: Entity) -> Option<f32> {
        time_of_impact(&self.impacts, &self.find([a, b])?.key)
    }

    /// Returns the points at which two entities lie on each other, with the normal from the first to
    /// the second. `None` unless they are in contact, and one of them has
    /// [`ManifoldsEnabled`](super::ManifoldsEnabled), or
    /// [`CollisionEventSettings::manifolds`](super::CollisionEventSettings::manifolds) asks for all.
    /// O(log n).
    ///
    /// Of two that met on the way, since one of them is [swept](crate::swept::Swept), they are those
    /// of that moment; after an impact that turned one of them, the one point of the impact.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::{prelude::*, scene::Cube};
    ///
    /// let mut app = App::new();
    /// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    /// let [a, b] = [0.0, 0.75].map(|y| {
    ///     let cube = (Cube, ManifoldsEnabled, Transform::from_xyz(0.0, y, 0.0));
    ///     app.world_mut().spawn(cube).id()
    /// });
    /// app.update();
    /// let manifold = app.world().resource::<Contacts>().manifold(a, b).unwrap();
    /// assert_eq!((manifold.normal, manifold.points().len()), (Vec3::Y, 4));
    /// ```
    #[must_use]
    pub fn manifold(&self, a: Entity, b: Entity) -> Option<Manifold> {
        self.manifold_of(self.find([a, b])?, a)
    }

    /// Returns the number of contacts.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.all.len()
    }

    /// Returns `true` if nothing is in contact.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The handles of all that have contacts.
    fn handles(&self) -> &EntityHashMap<ProxyId> {
        self.handles.get_or_init(|| {
            let both = |contact: &ContactPair| {
                let ContactKey { a, b, ids } = contact.key;
                [(a, ids[0]), (b, ids[1])]
            };
            self.all.iter().flat_map(both).collect()
        })
    }
}

/// # By body
///
/// Of things [made of parts](crate::parts).
impl Contacts {
    /// Returns all pairs of bodies in contact, by the index of the one that has the lower, then by
    /// that of the other; of two whose solid parts touch and of which sensors see each other, both
    /// contacts, in this order. O(1) for each.
    #[must_use]
    pub fn body_pairs(&self) -> impl ExactSizeIterator<Item = BodyCollision> {
        self.bodies.pairs().iter().map(|pair| pair.collision)
    }

    /// Returns the contacts between the parts of two bodies, as seen from those of the first: those of
    /// solid parts, then those that sensors see, each in the order of all. O(pairs of bodies in contact),
    /// and O(log n) for each.
    pub fn between_bodies(&self, a: Entity, b: Entity) -> impl Iterator<Item = Collision> {
        self.collisions(self.bodies.between(a, b), a)
    }

    /// Returns the contacts of all parts of a body with what is not part of it, as seen from these,
    /// one body that it meets after the other. O(pairs of bodies in contact), and O(log n) for each.
    pub fn of_body(&self, body: Entity) -> impl Iterator<Item = Collision> {
        let pairs = self.bodies.pairs().iter();
        let own = pairs.filter(move |pair| pair.collision.other(body).is_some());
        own.flat_map(move |pair| self.collisions(self.bodies.keys(pair), body))
            .filter(|collision| collision.hears()[0])
    }

    /// Contacts of parts, as seen from a body.
    fn collisions<'a>(
        &'a self,
        keys: impl IntoIterator<Item = &'a ContactKey>,
        body: Entity,
    ) -> impl Iterator<Item = Collision> {
        let found = keys.into_iter();
        let found = found.filter_map(|key| self.find([key.a, key.b]));
        found.map(move |contact| {
            let collision = self.collision(contact);
            if collision.bodies[0] == body {
                collision
            } else {
                collision.reversed()
            }
        })
    }

    /// Brings what is known of bodies up to date with all contacts.
    pub(super) fn merge_bodies(
        &mut self,
        owners: &Owners,
        is_sensor: impl Fn(Entity) -> bool,
        places: &Places,
        audience: &Audience,
    ) {
        self.bodies
            .refresh(self.all.iter(), owners, is_sensor, places, audience);
    }

    /// Are parts of bodies in contact, or were they at the last report?
    pub(super) const fn some_bodies(&self) -> bool {
        !(self.bodies.is_empty() && self.bodies_before.is_empty())
    }

    /// Those of the last report, and those of now.
    pub(super) fn body_pairs_before_and_now(&self) -> (&[BodyPair], &[BodyPair]) {
        (self.bodies_before.pairs(), self.bodies.pairs())
    }

    /// The same, of all their parts.
    pub(super) const fn bodies_before_and_now(&self) -> (&BodyContacts, &BodyContacts) {
        (&self.bodies_before, &self.bodies)
    }

    /// All that is known of bodies was told.
    pub(super) fn note_bodies_reported(&mut self) {
        self.bodies_before.copy(&self.bodies);
    }
}

/// # By handle
impl Contacts {
    /// All of them, in order.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = &ContactPair> {
        self.in_order()
    }

    fn in_order(&self) -> InOrder<'_> {
        self.arrangement.iter(&self.all)
    }

    /// Did the two meet on the way, in this tick?
    pub(crate) fn met_on_the_way(&self, key: &ContactKey) -> bool {
        time_of_impact(&self.impacts, key).is_some()
    }

    /// The contact of two entities. O(log n).
    pub(super) fn find(&self, entities: [Entity; 2]) -> Option<&ContactPair> {
        self.all.find(entities)
    }

    /// The contacts that an entity hears of, in order. O(1) for each, and O(contacts + objects) for
    /// the first call in a tick.
    pub(super) fn of_handle(
        &self,
        entity: Entity,
        id: ProxyId,
    ) -> impl Iterator<Item = &ContactPair> {
        let adjacency = self
            .by_object
            .get_or_init(|| Adjacency::new(&self.all, &self.arrangement));
        let all = adjacency.of(id).iter().map(|number| self.all.at(*number));
        // The handle may have been another's.
        all.filter(move |contact| contact.is_heard_by(entity))
    }

    /// Where the two lie on each other, as seen from one of them, if somebody asked. O(log n).
    pub(super) fn manifold_of(&self, contact: &ContactPair, entity: Entity) -> Option<Manifold> {
        let found = self.manifolds.find(contact)?;
        Some(if contact.key.a == entity {
            found
        } else {
            found.reversed()
        })
    }

    /// All contacts, each with whether it was found in this tick; when and how those met of which
    /// one is swept; the manifolds.
    pub(super) fn split_manifolds(
        &mut self,
    ) -> (
        impl Iterator<Item = (&ContactPair, bool)>,
        &[SweptContact],
        &mut Manifolds,
    ) {
        (self.all.with_found(), &self.impacts, &mut self.manifolds)
    }

    /// With what is known of it. O(log n).
    pub(super) fn collision(&self, contact: &ContactPair) -> Collision {
        let watched = watched::find(&self.watched, &contact.key);
        contact.collision(
            watched.map(|watched| watched.geometry),
            self.bodies.bodies(&contact.key),
        )
    }
}

/// # From tick to tick
impl Contacts {
    /// Are the contacts the verdicts on some other search than the last one of this index? If so,
    /// none of them can be kept: what moved since is not known.
    pub(super) const fn are_out_of_step(&self, index: &CollisionIndex) -> bool {
        self.search != index.search() || self.index != index.number()
    }

    /// Brings the contacts up to date with the verdicts of a tick, which are all new; of last
    /// tick's contacts, those between two at rest stay. What is to be known of them and is not,
    /// `geometry` computes.
    pub(super) fn merge(
        &mut self,
        search: u64,
        verdicts: &mut Verdicts,
        index: &CollisionIndex,
        geometry: impl FnMut(&ContactKey) -> Option<Contact>,
    ) {
        (self.search, self.index) = (search, index.number());
        self.by_object.take();
        self.handles.take();
        let had_news = self.all.has_news();
        self.merge_pairs(verdicts, index);
        self.arrangement.renew(&self.all, index);
        self.merge_watched(verdicts, had_news, geometry);
    }

    fn merge_pairs(&mut self, verdicts: &mut Verdicts, index: &CollisionIndex) {
        let proxies = index.index().proxies();
        let state = index.state_of_search();
        let last = std::mem::replace(&mut self.state, state);
        let at_the_end = |key: &ContactKey| ContactPair {
            key: *key,
            layers: key.ids.map(|id| proxies.filter(id).into()),
            time: 1.0,
        };
        let rests =
            |contact: &ContactPair| contact.key.ids.iter().all(|id| proxies.is_resting(*id));
        // Nearly always, what was at rest still is.
        let is_known = index.is_as_searched() && !verdicts.displaces();
        let changes = if is_known
            && state
                .zip(last)
                .is_some_and(|(state, last)| state.follows(last))
        {
            Changes {
                // What went since the last update, is gone now.
                some_woke: proxies.some_woke() || proxies.has_pending(),
                some_slept: proxies.some_slept(),
                some_found_at_rest: verdicts.may_repeat(),
            }
        } else {
            Changes::ANY
        };
        if !changes.some_found_at_rest
            && let Some(found) = verdicts.by_job()
        {
            self.impacts.clear();
            return self.all.enter_by_job(found, at_the_end, rests, changes);
        }
        verdicts.sort(&mut self.impacts);
        let impacts = &self.impacts;
        let contact = |key: &ContactKey| ContactPair {
            time: time_of_impact(impacts, key).unwrap_or(1.0),
            ..at_the_end(key)
        };
        let found = verdicts.found();
        if is_known {
            self.all.enter(found, contact, rests, changes);
        } else {
            let rests = |contact: &ContactPair| {
                let ContactKey { a, b, ids } = contact.key;
                index.rested(ids, [a, b]) && !verdicts.is_displaced(&contact.key)
            };
            self.all.enter(found, contact, rests, changes);
        }
    }

    /// Brings what is known of contacts up to date with all contacts. The geometry of a contact
    /// that was kept is kept too, or has to be computed, if it was not asked for before.
    ///
    /// Of a pair that was found both on the way and at the end of the tick, the geometry is that of
    /// the way.
    fn merge_watched(
        &mut self,
        verdicts: &Verdicts,
        had_news: bool,
        mut geometry: impl FnMut(&ContactKey) -> Option<Contact>,
    ) {
        let (watched, before) = (&mut self.watched, &mut self.watched_before);
        let last = turn(watched, before, &mut self.watched_unreported, had_news);
        let watch = &verdicts.watch;
        if watch.is_idle() {
            return;
        }
        let mut found = verdicts.geometry().iter().peekable();
        let mut impacts = self.impacts.iter().peekable();
        let mut last = last.iter().peekable();
        for contact in self
            .all
            .iter()
            .filter(|contact| watch.wants(contact.key.ids))
        {
            let key = &contact.key;
            let on_the_way =
                seek(&mut impacts, key, |impact| impact.key).map(|impact| impact.met.contact);
            let at_the_end =
                seek(&mut found, key, |(found, _)| *found).map(|(_, geometry)| *geometry);
            let kept = seek(&mut last, key, WatchedContact::key).map(|kept| kept.geometry);
            let known = on_the_way.or(at_the_end).or(kept);
            if let Some(geometry) = known.or_else(|| geometry(key)) {
                watched.push(watch.watched(*contact, geometry));
            }
        }
    }
}

/// # The report
impl Contacts {
    pub(super) const fn has_news(&self) -> bool {
        self.all.has_news()
    }

    /// Whom messages were for at the last report.
    pub(super) const fn scope_reported(&self) -> Option<EventScope> {
        self.scope_reported
    }

    /// Has all be as it was at another time: what was known then, and what was known at the last report, if another was due.
    pub(super) fn replace(
        &mut self,
        reported: Option<Known>,
        now: Known,
        scope_reported: Option<EventScope>,
        index: &CollisionIndex,
    ) {
        let has_news = reported.is_some();
        let reported = reported.unwrap_or_else(|| now.clone());
        self.all.replace(&reported.contacts, now.contacts, has_news);
        self.arrangement.renew(&self.all, index);
        self.state = None;
        self.watched_unreported.clear();
        // With news to come, those of the last tick are the unreported ones of the next.
        (self.watched_before, self.watched) = (reported.watched, now.watched);
        (self.bodies_before, self.bodies) = (reported.bodies, now.bodies);
        self.manifolds = Manifolds::default();
        self.impacts.clear();
        self.scope_reported = scope_reported;
        self.by_object.take();
        self.handles.take();
    }

    /// All that happened until now was told to these. Returns to whom the last report was.
    pub(super) fn note_reported(&mut self, scope: EventScope) -> EventScope {
        self.all.note_reported();
        self.scope_reported.replace(scope).unwrap_or(scope)
    }

    /// The contacts, with what became of them since the last report.
    pub(super) const fn ledger(&self) -> &Ledger {
        &self.all
    }

    /// Of the last report, those of which more is known.
    pub(super) fn watched_before(&self) -> &[WatchedContact] {
        &self.watched_before
    }

    /// Of now, those of which more is known.
    pub(super) fn watched(&self) -> &[WatchedContact] {
        &self.watched
    }
}

/// All contacts at some moment, in the order of keys, and what is known of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    pub(super) contacts: Vec<ContactPair>,
    pub(super) watched: Vec<WatchedContact>,
    pub(super) bodies: BodyContacts,
}

/// Makes room in `now` for what is known in a new tick, and returns what was known in the last one:
/// that is what the next report compares with, unless one is still due, whose `before` then stays.
fn turn<'a, T>(
    now: &mut Vec<T>,
    before: &'a mut Vec<T>,
    unreported: &'a mut Vec<T>,
    has_news: bool,
) -> &'a [T] {
    let last = if has_news { unreported } else { before };
    std::mem::swap(now, last);
    now.clear();
    last
}

fn time_of_impact(impacts: &[SweptContact], key: &ContactKey) -> Option<f32> {
    let index = impacts
        .binary_search_by_key(key, |impact| impact.key)
        .ok()?;
    Some(impacts[index].met.time)
}

pub(super) fn register(app: &mut App) {
    app.init_resource::<Contacts>().register_type::<Contacts>();
}
