//! What is in the index already, and moved: brought up to date table by table.

use std::ops::Range;

use bevy::{
    ecs::change_detection::{ContiguousRef, Tick},
    prelude::*,
};

use crate::{
    broad_phase::ProxyId,
    change_ticks::{GROUP, ROWS, SinceLastRun},
    collision_index::{
        CollisionIndex,
        follow::{Followers, Following},
    },
    components::{BroadPhaseProxy, CollisionShape, WorldAabb},
    parallel,
    shear::Sheared,
    swept::{Swept, SweptWithBody},
    way::SweptWay,
};

/// What is looked at in each tick, of everything that moved: no more than that.
pub(super) type Boxed<'a> = (
    Entity,
    Ref<'a, WorldAabb>,
    Ref<'a, CollisionShape>,
    &'a mut BroadPhaseProxy,
    (Has<Swept>, Has<SweptWithBody>, Option<&'a SweptWay>),
    Has<Sheared>,
);

pub(super) type Table<'a> = (
    &'a [Entity],
    ContiguousRef<'a, WorldAabb>,
    ContiguousRef<'a, CollisionShape>,
    &'a [BroadPhaseProxy],
    (bool, bool, Option<&'a [SweptWay]>),
    bool,
);

/// What a job has found out: memory that outlives the tick.
#[derive(Debug, Default)]
pub(super) struct Job {
    /// Who followed.
    moved: Vec<ProxyId>,
    /// Who did not.
    left: Vec<Entity>,
}

/// Rows of a table that follow each other.
struct Rows<'a> {
    entities: &'a [Entity],
    boxes: &'a [WorldAabb],
    boxed: &'a [Tick],
    reshaped: &'a [Tick],
    proxies: &'a [BroadPhaseProxy],
    ways: Option<&'a [SweptWay]>,
    is_sheared: bool,
}

impl<'a> Rows<'a> {
    /// Cuts a table into the rows of the jobs.
    fn of(table: &'a Table) -> impl ExactSizeIterator<Item = Self> + Clone {
        let (entities, boxes, shapes, proxies, (is_swept, goes_along, ways), is_sheared) = table;
        let ways = ways.filter(|_| *is_swept || *goes_along);
        let (reshaped, boxed) = (shapes.changed_ticks_slice(), boxes.changed_ticks_slice());
        (0..entities.len().div_ceil(ROWS)).map(move |job| {
            let rows = job * ROWS..entities.len().min((job + 1) * ROWS);
            Self {
                entities: &entities[rows.clone()],
                boxes: &boxes[rows.clone()],
                boxed: &boxed[rows.clone()],
                reshaped: &reshaped[rows.clone()],
                proxies: &proxies[rows.clone()],
                ways: ways.map(|ways| &ways[rows]),
                is_sheared: *is_sheared,
            }
        })
    }

    /// The handles that they have, if these ascend. Who has another is left.
    fn handles(&self) -> Option<Range<usize>> {
        let first = self.proxies.first()?.id()?.index();
        let last = self.proxies.last()?.id()?.index();
        (first <= last).then_some(first..last + 1)
    }

    /// Has those that moved follow, and lists them and those that do not.
    fn follow(&self, since: SinceLastRun, followers: &mut Followers, job: &mut Job) {
        for (group, boxed) in self.boxed.chunks(GROUP).enumerate() {
            if !since.any_changed(boxed) {
                continue;
            }
            for (row, boxed) in (group * GROUP..).zip(boxed) {
                if since.changed(*boxed) && !self.row_follows(row, followers, &mut job.moved) {
                    job.left.push(self.entities[row]);
                }
            }
        }
    }

    #[inline]
    fn row_follows(&self, row: usize, followers: &mut Followers, moved: &mut Vec<ProxyId>) -> bool {
        let (entity, proxy) = (self.entities[row], &self.proxies[row]);
        let Some(id) = proxy.id() else {
            return false;
        };
        let now = Following {
            entity,
            id,
            aabb: &self.boxes[row].0,
            pose: proxy.pose(),
            fit: proxy.fit(self.boxed[row], self.reshaped[row]),
            reshaped: self.reshaped[row],
            start: start(
                (true, false, self.ways.map(|ways| &ways[row])),
                entity,
                proxy,
            ),
        };
        !self.is_sheared && followers.follow(&now, moved)
    }
}

/// Where the way of an entity in this tick begins, if it is on one.
#[inline]
pub(super) fn start<'a>(
    (is_swept, goes_along, way): (bool, bool, Option<&'a SweptWay>),
    entity: Entity,
    proxy: &BroadPhaseProxy,
) -> Option<&'a Transform> {
    // The way of who is not swept any more may still be there.
    way.filter(|way| (is_swept || goes_along) && way.belongs_to(entity, proxy.id()))
        .and_then(|way| way.to(proxy.pose()))
}

/// Brings the index up to date with those of a table that moved and can [follow](Followers), and
/// lists those that cannot.
///
/// Handles mostly ascend with the rows, for entities get theirs in that order. Each job then has the
/// part of the index that is behind its own handles to itself; where they do not, one job does all.
pub(super) fn follow(
    index: &mut CollisionIndex,
    table: Table,
    jobs: &mut Vec<Job>,
    left: &mut Vec<Entity>,
) {
    let since = SinceLastRun::of(&table.1);
    if table.4.0 || table.4.1 {
        index.make_room_for_starts();
    }
    let rows = Rows::of(&table);
    if jobs.len() < rows.len() {
        jobs.resize_with(rows.len(), Job::default);
    }
    let handles = rows.clone().map(|rows| rows.handles());
    if ascend(handles.clone()) {
        let parts = index.followers(handles.flatten());
        let work: Vec<_> = rows.clone().zip(parts).zip(&mut *jobs).collect();
        parallel::for_each(work.into_iter(), |((rows, mut followers), job)| {
            rows.follow(since, &mut followers, job);
        });
    } else {
        for followers in &mut index.followers(std::iter::once(0..usize::MAX)) {
            let mut followers = followers;
            for (rows, job) in rows.clone().zip(&mut *jobs) {
                rows.follow(since, &mut followers, job);
            }
        }
    }
    for job in &mut jobs[..rows.len()] {
        index.note_moved(&job.moved);
        job.moved.clear();
        left.append(&mut job.left);
    }
}

/// Does each range begin behind the end of the one before?
fn ascend(mut ranges: impl Iterator<Item = Option<Range<usize>>>) -> bool {
    let mut end = 0;
    ranges.all(|range| {
        range.is_some_and(|range| {
            let follows = end <= range.start;
            end = range.end;
            follows
        })
    })
}
