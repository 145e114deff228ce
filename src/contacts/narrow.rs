//! The exact tests of all candidate pairs.

use bevy::prelude::*;

use super::{
    find_manifolds::{find_manifolds, wants_manifolds},
    list::Contacts,
    pair::SweptContact,
    settings::{CollisionEventSettings, CollisionEventsEnabled},
    verdicts::Verdicts,
};
use crate::{
    broad_phase::Pair,
    collision_index::{Candidate, CandidatePairs, CollisionIndex},
    components::BroadPhaseProxy,
    counters::CollisionCounters,
    maintenance::find_candidates,
    narrow_phase::{NarrowPhase, Workspace},
    schedule::{CollisionSystems, ImpactSystems, add_to_tick},
};

/// The plugin for the exact tests of all candidate pairs.
#[derive(Clone, Copy, Debug, Default)]
pub struct NarrowPhasePlugin;

impl Plugin for NarrowPhasePlugin {
    fn build(&self, app: &mut App) {
        add_to_tick(app, |app, schedule| {
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

/// Where no search was made since, there is nothing new to test: all contacts stay.
fn test_candidates(
    index: Res<CollisionIndex>,
    candidates: Res<CandidatePairs>,
    (tests, event_settings): (Res<NarrowPhase>, Res<CollisionEventSettings>),
    enabled: Query<&BroadPhaseProxy, With<CollisionEventsEnabled>>,
    (contacts, mut verdicts): (Res<Contacts>, ResMut<Verdicts>),
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
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
    if verdicts.watch.is_idle() && !index.has_swept() {
        let mut touch = |pair: &Pair| {
            index.certainly_intersect(*pair, &tests, &mut workspace.counters)
                || index
                    .placed(*pair)
                    .is_some_and(|[a, b]| tests.intersects(a, b, &mut workspace))
        };
        let touching = candidates.iter().copied().filter(|pair| touch(pair));
        if may_repeat {
            verdicts.extend(touching.filter_map(in_order));
        } else {
            verdicts.extend(touching);
        }
    } else {
        for pair in candidates.iter().copied().filter_map(in_order) {
            let contact = match index.candidate(pair) {
                None => continue,
                Some(Candidate::OnTheWay([a, b])) => {
                    if let Some(met) = tests.time_of_impact(&a, &b, &mut workspace) {
                        verdicts.meet(SweptContact { pair, met });
                    }
                    continue;
                }
                Some(Candidate::AtTheEnd([a, b])) if verdicts.watch.wants(pair) => {
                    tests.contact(a, b, &mut workspace).map(Some)
                }
                Some(Candidate::AtTheEnd([a, b])) => {
                    tests.intersects(a, b, &mut workspace).then_some(None)
                }
            };
            if let Some(geometry) = contact {
                verdicts.touch(pair, geometry);
            }
        }
        verdicts.sort_impacts();
    }
    counters.tick.stages = std::mem::take(&mut workspace.counters);
    #[cfg(feature = "rapier")]
    if workspace.is_first_unknown() {
        warn_of_unknown(&index, &candidates);
    }
}

/// Tells of the first pair of shapes about which nothing can be said.
#[cfg(feature = "rapier")]
fn warn_of_unknown(index: &CollisionIndex, candidates: &CandidatePairs) {
    let is_unknown = |pair: &&Pair| {
        index
            .placed(**pair)
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

fn merge_verdicts(
    index: Res<CollisionIndex>,
    tests: Res<NarrowPhase>,
    (mut contacts, mut verdicts): (ResMut<Contacts>, ResMut<Verdicts>),
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    let geometry = |pair| {
        index
            .placed(pair)
            .and_then(|[a, b]| tests.contact(a, b, &mut workspace))
    };
    if let Some(search) = verdicts.take_search() {
        contacts.merge(search, &mut verdicts, &index, geometry);
    }
    counters.tick.contacts = contacts.len() as u64;
}
