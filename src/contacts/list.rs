//! All contacts, and how they are brought from one tick to the next.

use std::sync::OnceLock;

use bevy::{ecs::entity::EntityHashMap, prelude::*};

use super::{
    adjacency::Adjacency,
    manifolds::Manifolds,
    pair::{Collision, ContactPair, SweptContact, seek},
    verdicts::Verdicts,
    watched::{self, WatchedContact},
};
use crate::{
    broad_phase::{Pair, Proxies, ProxyId},
    collision_index::CollisionIndex,
    narrow_phase::{Contact, Manifold},
};

/// All pairs of entities in contact, in the order of their handles in the [`CollisionIndex`].
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
    pairs: Vec<ContactPair>,
    /// Those of the last report, for comparison; and those of the last tick, if they were not
    /// reported.
    before: Vec<ContactPair>,
    unreported: Vec<ContactPair>,
    /// Is there anything to report that was not?
    has_news: bool,
    /// The search for pairs that `pairs` are the verdicts on, by its number in the index.
    search: u64,
    /// Those of which more is known, in the order of `pairs`; of the last report; and of the last
    /// tick, unreported.
    #[reflect(ignore)]
    watched: Vec<WatchedContact>,
    #[reflect(ignore)]
    watched_before: Vec<WatchedContact>,
    #[reflect(ignore)]
    watched_unreported: Vec<WatchedContact>,
    /// Where those lie on each other of which somebody asked, in the order of pairs.
    #[reflect(ignore)]
    manifolds: Manifolds,
    /// When and how those met of which one is swept, in the order of pairs.
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
    /// Returns all contacts, each as seen from the entity with the lower handle. O(1) for each.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Collision> {
        let mut watched = self.watched.iter().peekable();
        self.pairs.iter().map(move |contact| {
            let watched = seek(&mut watched, contact.pair, WatchedContact::pair);
            contact.collision(watched.map(|watched| watched.geometry))
        })
    }

    /// Returns the contact of two entities, as seen from the first, if they are in contact. O(log
    /// n).
    #[must_use]
    pub fn between(&self, a: Entity, b: Entity) -> Option<Collision> {
        let contact = self.find(self.pair(a, b)?, [a, b])?;
        Some(self.collision(contact).seen_from(a))
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
        self.pair(a, b)
            .is_some_and(|pair| self.find(pair, [a, b]).is_some())
    }

    /// Returns the share of the tick after which two entities came into contact of which one is
    /// [swept](crate::swept::Swept): 0 to 1; that of the first time, if there were several. `None`
    /// for others: they are looked at where they are at the end of a tick. O(log n).
    #[must_use]
    pub fn time_of_impact(&self, a: Entity, b: Entity) -> Option<f32> {
        time_of_impact(&self.impacts, self.pair(a, b)?)
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
        let contact = self.find(self.pair(a, b)?, [a, b])?;
        self.manifold_of(contact, a)
    }

    /// Returns the number of contacts.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Returns `true` if nothing is in contact.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// The two, as a pair of handles, if both have contacts.
    fn pair(&self, a: Entity, b: Entity) -> Option<Pair> {
        let handles = self.handles();
        let (a, b) = (*handles.get(&a)?, *handles.get(&b)?);
        (a != b).then(|| Pair::new(a, b))
    }

    /// The handles of all that have contacts.
    fn handles(&self) -> &EntityHashMap<ProxyId> {
        self.handles.get_or_init(|| {
            let both =
                |contact: &ContactPair| [(contact.a, contact.pair.a), (contact.b, contact.pair.b)];
            self.pairs.iter().flat_map(both).collect()
        })
    }
}

/// # By handle
impl Contacts {
    pub(crate) fn pairs(&self) -> &[ContactPair] {
        &self.pairs
    }

    /// Did the two meet on the way, in this tick?
    pub(crate) fn met_on_the_way(&self, pair: Pair) -> bool {
        time_of_impact(&self.impacts, pair).is_some()
    }

    /// The contact of a pair, if it is that of these entities: their handles may have been those of
    /// others.
    pub(super) fn find(&self, pair: Pair, entities: [Entity; 2]) -> Option<&ContactPair> {
        let index = self
            .pairs
            .binary_search_by_key(&pair, |contact| contact.pair)
            .ok()?;
        Some(&self.pairs[index])
            .filter(|contact| entities.iter().all(|entity| contact.is_of(*entity)))
    }

    /// The contacts that an entity hears of, in the order of their pairs. O(1) for each, and O(contacts +
    /// objects) for the first call in a tick.
    pub(super) fn of_handle(
        &self,
        entity: Entity,
        id: ProxyId,
    ) -> impl Iterator<Item = &ContactPair> {
        let adjacency = self.by_object.get_or_init(|| Adjacency::new(&self.pairs));
        let all = adjacency
            .of(id)
            .iter()
            .map(|index| &self.pairs[*index as usize]);
        // The handle may have been another's.
        all.filter(move |contact| contact.is_heard_by(entity))
    }

    /// Where the two lie on each other, as seen from one of them, if somebody asked. O(log n).
    pub(super) fn manifold_of(&self, contact: &ContactPair, entity: Entity) -> Option<Manifold> {
        let found = self.manifolds.find(contact)?;
        Some(if contact.a == entity {
            found
        } else {
            found.reversed()
        })
    }

    /// The pairs in contact of which one is swept, when and how they met; the manifolds.
    pub(super) fn split_manifolds(&mut self) -> (&[ContactPair], &[SweptContact], &mut Manifolds) {
        (&self.pairs, &self.impacts, &mut self.manifolds)
    }

    /// With what is known of it. O(log n).
    pub(super) fn collision(&self, contact: &ContactPair) -> Collision {
        let watched = watched::find(&self.watched, contact.pair);
        contact.collision(watched.map(|watched| watched.geometry))
    }
}

/// # From tick to tick
impl Contacts {
    /// Are the contacts the verdicts on some other search than the last one of this index? If so,
    /// none of them can be kept: what moved since is not known.
    pub(super) const fn are_out_of_step(&self, index: &CollisionIndex) -> bool {
        self.search != index.search()
    }

    /// Brings the contacts up to date with the verdicts of a tick, which are all new; of last
    /// tick's contacts, those between two at rest stay. What is to be known of them and is not,
    /// `geometry` computes.
    pub(super) fn merge(
        &mut self,
        search: u64,
        verdicts: &mut Verdicts,
        index: &CollisionIndex,
        geometry: impl FnMut(Pair) -> Option<Contact>,
    ) {
        self.search = search;
        self.by_object.take();
        self.handles.take();
        verdicts.sort(index.index().proxies().capacity());
        verdicts.swap_impacts(&mut self.impacts);
        self.merge_pairs(verdicts, index);
        self.merge_watched(verdicts, geometry);
        self.has_news = true;
    }

    fn merge_pairs(&mut self, verdicts: &Verdicts, index: &CollisionIndex) {
        let proxies = index.index().proxies();
        let impacts = &self.impacts;
        let found = |pair: Pair| {
            let [a, b] = index.entities(pair);
            let layers = [pair.a, pair.b].map(|id| proxies.filter(id).into());
            ContactPair {
                pair,
                a,
                b,
                layers,
                time: time_of_impact(impacts, pair).unwrap_or(1.0),
            }
        };
        let last = turn(
            &mut self.pairs,
            &mut self.before,
            &mut self.unreported,
            self.has_news,
        );
        let contacts = &mut self.pairs;
        // Nearly always, what was at rest still is.
        if index.is_as_searched() && !verdicts.displaces() {
            let kept = last.iter().filter(|contact| rest(contact.pair, proxies));
            merge(contacts, kept, verdicts.found(), found);
        } else {
            let rested = |contact: &ContactPair| index.rested(contact.pair, [contact.a, contact.b]);
            let stays =
                |contact: &&ContactPair| rested(contact) && !verdicts.is_displaced(contact.pair);
            merge(contacts, last.iter().filter(stays), verdicts.found(), found);
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
        mut geometry: impl FnMut(Pair) -> Option<Contact>,
    ) {
        let (watched, before) = (&mut self.watched, &mut self.watched_before);
        let last = turn(watched, before, &mut self.watched_unreported, self.has_news);
        let watch = &verdicts.watch;
        if watch.is_idle() {
            return;
        }
        let mut found = verdicts.geometry().iter().peekable();
        let mut impacts = self.impacts.iter().peekable();
        let mut last = last.iter().peekable();
        for contact in self
            .pairs
            .iter()
            .filter(|contact| watch.wants(contact.pair))
        {
            let pair = contact.pair;
            let on_the_way =
                seek(&mut impacts, pair, |impact| impact.pair).map(|impact| impact.met.contact);
            let at_the_end =
                seek(&mut found, pair, |(found, _)| *found).map(|(_, geometry)| *geometry);
            let kept = seek(&mut last, pair, WatchedContact::pair)
                .filter(|kept| kept.contact.key() == contact.key())
                .map(|kept| kept.geometry);
            let known = on_the_way.or(at_the_end).or(kept);
            if let Some(geometry) = known.or_else(|| geometry(pair)) {
                watched.push(watch.watched(*contact, geometry));
            }
        }
    }
}

/// # The report
impl Contacts {
    pub(super) const fn has_news(&self) -> bool {
        self.has_news
    }

    /// All that happened until now was told.
    pub(super) const fn note_reported(&mut self) {
        self.has_news = false;
    }

    /// The contacts of the last report, and those of which more is known.
    pub(super) fn before(&self) -> (&[ContactPair], &[WatchedContact]) {
        (&self.before, &self.watched_before)
    }

    /// The contacts of now, and those of which more is known.
    pub(super) fn now(&self) -> (&[ContactPair], &[WatchedContact]) {
        (&self.pairs, &self.watched)
    }
}

/// All contacts of a tick: those that are kept, and those that were found; all in the order of
/// pairs.
fn merge<'a>(
    contacts: &mut Vec<ContactPair>,
    kept: impl Iterator<Item = &'a ContactPair>,
    found: &[Pair],
    contact: impl Fn(Pair) -> ContactPair,
) {
    let mut found = found.iter().copied().peekable();
    for kept in kept {
        while let Some(pair) = found.next_if(|pair| *pair < kept.pair) {
            contacts.push(contact(pair));
        }
        contacts.push(*kept);
        // One of them rested until it was hit.
        found.next_if_eq(&kept.pair);
    }
    contacts.extend(found.map(contact));
    debug_assert!(
        contacts.is_sorted_by(|a, b| a.pair < b.pair),
        "each pair is one contact"
    );
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

fn rest(pair: Pair, proxies: &Proxies) -> bool {
    proxies.is_resting(pair.a) && proxies.is_resting(pair.b)
}

fn time_of_impact(impacts: &[SweptContact], pair: Pair) -> Option<f32> {
    let index = impacts
        .binary_search_by_key(&pair, |impact| impact.pair)
        .ok()?;
    Some(impacts[index].met.time)
}

pub(super) fn register(app: &mut App) {
    app.init_resource::<Contacts>().register_type::<Contacts>();
}
