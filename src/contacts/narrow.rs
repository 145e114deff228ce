//! The exact tests of all candidate pairs.

use bevy::{
    ecs::{archetype::Archetype, entity_disabling::DefaultQueryFilters},
    prelude::*,
};

use super::{
    bodies::{Audience, Owners, Places},
    buckets::{Buckets, Found},
    find_manifolds::{find_manifolds, wants_manifolds},
    list::Contacts,
    pair::{ContactKey, SweptContact},
    settings::{CollisionEventSettings, CollisionEventsEnabled, EventScope},
    verdicts::Verdicts,
    watched::Watch,
};
use crate::{
    broad_phase::{EVERYWHERE, Pair},
    collision_index::{Candidate, CandidatePairs, CollisionIndex},
    collision_order::CollisionOrder,
    components::BroadPhaseProxy,
    counters::CollisionCounters,
    disabled::{is_disabled, see_disabled},
    filters::Sensor,
    maintenance::find_candidates,
    narrow_phase::{Fit, NarrowPhase, StageCounters, Workspace},
    parallel,
    parts::PartOf,
    schedule::{CollisionSystems, ImpactSystems, add_to_tick},
};

/// The plugin for the exact tests of all candidate pairs.
#[derive(Clone, Copy, Debug, Default)]
pub struct NarrowPhasePlugin;

impl Plugin for NarrowPhasePlugin {
    fn build(&self, app: &mut App) {
        add_to_tick(app, |app, schedule| {
            let merge_verdicts = see_disabled(app.world_mut(), merge_verdicts);
            app.add_systems(
                schedule,
                (
                    search_all
                        .in_set(CollisionSystems::BroadPhase)
                        .before(find_candidates)
                        .run_if(is_out_of_step),
                    (
                        test_candidates.before(ImpactSystems),
                        (merge_verdicts, find_manifolds.run_if(wants_manifolds))
                            .chain()
                            .after(ImpactSystems),
                    )
                        .in_set(CollisionSystems::NarrowPhase),
                ),
            );
        });
    }
}

/// Did the exact tests miss a search, since they did not run, or are the contacts those of another
/// time?
fn is_out_of_step(contacts: Option<Res<Contacts>>, index: Option<Res<CollisionIndex>>) -> bool {
    contacts
        .zip(index)
        .is_some_and(|(contacts, index)| contacts.are_out_of_step(&index))
}

/// Has all pairs looked at again.
fn search_all(mut index: ResMut<CollisionIndex>) {
    index.search_all();
}

/// A pair as contacts have it. Those who write candidates may have it the wrong way round, or one
/// entity twice.
fn in_order(pair: Pair) -> Option<Pair> {
    (pair.a != pair.b).then(|| Pair::new(pair.a, pair.b))
}

/// So many candidates make a job of their own.
const CANDIDATES: usize = 2048;
/// The boxes of so many are gathered from memory before they are worked on.
const GATHERED: usize = 64;

/// What a job needs: memory that outlives the tick.
#[derive(Default)]
struct Job {
    workspace: Workspace,
    /// Pairs of which more is to be found out than whether they are in contact at the end of the
    /// tick.
    aside: Vec<Pair>,
}

/// The memory of the exact tests.
#[derive(Default)]
struct Jobs {
    jobs: Vec<Job>,
    /// Was it told that there are shapes about which nothing can be said?
    is_told: bool,
}

/// Where no search was made since, there is nothing new to test: all contacts stay.
fn test_candidates(
    index: Res<CollisionIndex>,
    candidates: Res<CandidatePairs>,
    (tests, event_settings): (Res<NarrowPhase>, Res<CollisionEventSettings>),
    enabled: Query<&BroadPhaseProxy, With<CollisionEventsEnabled>>,
    (contacts, mut verdicts): (Res<Contacts>, ResMut<Verdicts>),
    mut counters: ResMut<CollisionCounters>,
    mut memory: Local<Jobs>,
) {
    if !contacts.are_out_of_step(&index) {
        return;
    }
    let verdicts = &mut *verdicts;
    verdicts.watch.refresh(
        &event_settings,
        enabled.iter().filter_map(BroadPhaseProxy::id),
    );
    let may_repeat = !index.has_listed(&candidates);
    verdicts.begin(index.search(), may_repeat);
    let needed = candidates.len().div_ceil(CANDIDATES);
    if memory.jobs.len() < needed {
        memory.jobs.resize_with(needed, Job::default);
    }
    let buckets = if parallel::is_on() {
        Buckets::up_to(index.highest_entity())
    } else {
        Buckets::ONE
    };
    let (watch, found) = verdicts.begin_jobs(needed, buckets);
    let jobs = memory.jobs.iter_mut().zip(found);
    let jobs = candidates.chunks(CANDIDATES).zip(jobs);
    parallel::for_each(jobs, |(candidates, (job, found))| {
        for candidates in candidates.chunks(GATHERED) {
            test_some((&index, &tests, watch), candidates, job, found);
        }
        found.divide(buckets);
    });
    for job in &mut memory.jobs[..needed] {
        let Job { workspace, aside } = job;
        for pair in aside.drain(..).filter_map(in_order) {
            test_with_care(&index, &tests, pair, workspace, verdicts);
        }
    }
    verdicts.sort_impacts();
    counters.tick.stages = StageCounters::default();
    for job in &mut memory.jobs {
        counters.tick.stages += std::mem::take(&mut job.workspace.counters);
    }
    let is_unknown = |job: &mut Job| job.workspace.is_first_unknown();
    // Each of them is asked.
    let found = memory.jobs.iter_mut().map(is_unknown).filter(|is| *is);
    if found.count() > 0 && !std::mem::replace(&mut memory.is_told, true) {
        warn_of_unknown(&index, &candidates);
    }
}

/// Finds out when and how two met of which one is swept, or where two touch of which somebody asked.
fn test_with_care(
    index: &CollisionIndex,
    tests: &NarrowPhase,
    pair: Pair,
    workspace: &mut Workspace,
    verdicts: &mut Verdicts,
) {
    // One may be gone.
    if ![pair.a, pair.b].iter().all(|id| index.body(*id).is_some()) {
        return;
    }
    // Which of the two comes first, is not up to their handles.
    let key = ContactKey::of(pair, index);
    match index.candidate(key.ids) {
        None => {}
        Some(Candidate::OnTheWay([a, b])) => {
            if let Some(met) = tests.time_of_impact(&a, &b, workspace) {
                verdicts.meet(SweptContact { key, met });
            }
        }
        Some(Candidate::AtTheEnd([a, b])) => {
            if let Some(geometry) = tests.contact(a, b, workspace) {
                verdicts.touch(key, geometry);
            }
        }
    }
}

/// Lists those of some candidates that are in contact at the end of the tick, and puts those aside
/// of which one is swept, or somebody asked where they touch.
fn test_some(
    (index, tests, watch): (&CollisionIndex, &NarrowPhase, &Watch),
    candidates: &[Pair],
    Job { workspace, aside }: &mut Job,
    found: &mut Found,
) {
    let mut boxes = [[EVERYWHERE; GATHERED]; 2];
    let mut fits = [[Fit::Loose; GATHERED]; 2];
    // In loops that do nothing else, so that the processor runs ahead and waits for many boxes at
    // once.
    for (side, (boxes, fits)) in boxes.iter_mut().zip(&mut fits).enumerate() {
        for ((pair, aabb), fit) in candidates.iter().zip(boxes).zip(fits) {
            let id = if side == 0 { pair.a } else { pair.b };
            *aabb = index.box_of(id);
            *fit = index.fit(id);
        }
    }
    let mut touching = [0; GATHERED];
    let mut count = 0;
    let some_aside = index.has_swept() || !watch.is_idle();
    for (number, pair) in candidates.iter().enumerate() {
        let ids = [pair.a, pair.b];
        if some_aside && (watch.wants(ids) || ids.iter().any(|id| index.is_on_its_way(*id))) {
            aside.push(*pair);
            continue;
        }
        let [a, b] = [0, 1].map(|side| (fits[side][number], &boxes[side][number]));
        let touch = tests.certainly_intersect(a, b, &mut workspace.counters)
            || index.placed(ids).is_some_and(|[a, b]| {
                // What is rounded must not be up to handles either.
                let [a, b] = if index.is_in_order(ids) {
                    [a, b]
                } else {
                    [b, a]
                };
                tests.intersects(a, b, workspace)
            });
        touching[count] = number;
        count += usize::from(touch);
    }
    let touching = touching[..count].iter().map(|number| candidates[*number]);
    let keys = touching
        .filter_map(in_order)
        .map(|pair| ContactKey::of(pair, index));
    found.extend(keys);
}

/// Tells of the first pair of shapes about which nothing can be said.
fn warn_of_unknown(index: &CollisionIndex, candidates: &CandidatePairs) {
    let is_unknown = |pair: &&Pair| {
        index
            .placed([pair.a, pair.b])
            .is_some_and(|[a, b]| !crate::narrow_phase::is_known(a, b))
    };
    let Some(pair) = candidates.iter().find(is_unknown) else {
        return;
    };
    if let (Some(a), Some(b)) = (index.body(pair.a), index.body(pair.b)) {
        tracing::warn!(
            "{} and {} count as apart, as do all others of their kinds: nothing is known of how {:?} and {:?} meet",
            a.entity,
            b.entity,
            a.shape,
            b.shape
        );
    }
}

type Part<'a> = (&'a BroadPhaseProxy, &'a PartOf);

/// The number of somebody who is there, if there is one.
type Numbered = Option<&'static CollisionOrder>;

/// A body may be disabled while its parts are not: it keeps its place, and hears of nothing. For a system that [sees
/// it](see_disabled).
fn merge_verdicts(
    index: Res<CollisionIndex>,
    (tests, filters): (Res<NarrowPhase>, Option<Res<DefaultQueryFilters>>),
    (mut contacts, mut verdicts): (ResMut<Contacts>, ResMut<Verdicts>),
    (parts, sensors, orders): (Query<Part>, Query<(), With<Sensor>>, Query<Numbered>),
    (event_settings, enabled): (
        Res<CollisionEventSettings>,
        Query<&Archetype, With<CollisionEventsEnabled>>,
    ),
    mut counters: ResMut<CollisionCounters>,
    (mut workspace, mut owners): (Local<Workspace>, Local<Owners>),
) {
    let geometry = |key: &ContactKey| {
        index
            .placed(key.ids)
            .and_then(|[a, b]| tests.contact(a, b, &mut workspace))
    };
    if let Some(search) = verdicts.take_search() {
        contacts.merge(search, &mut verdicts, &index, geometry);
        let parts = parts.iter();
        owners.refresh(parts.filter_map(|(proxy, part)| Some((proxy.id()?, part.body()))));
        let audience = Audience {
            is_enabled: &|body| {
                let archetype = enabled.get(body);
                archetype.is_ok_and(|archetype| !is_disabled(archetype, filters.as_deref()))
            },
            messages_for_all: event_settings.messages == EventScope::All,
            events_for_all: event_settings.observers == EventScope::All,
        };
        let places = Places {
            of_body: &|body| Some(orders.get(body).ok()?.map(|order| order.0)),
            index: &index,
        };
        contacts.merge_bodies(&owners, |part| sensors.contains(part), &places, &audience);
    }
    counters.tick.contacts = contacts.len() as u64;
}
