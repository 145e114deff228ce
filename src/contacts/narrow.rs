//! The exact tests of all candidate pairs.

use bevy::prelude::*;

use super::{CollisionEventSettings, CollisionEventsEnabled, Contacts, SweptContact};
use crate::{
    broad_phase::Pair,
    collision_index::{CandidatePairs, CollisionIndex, find_candidates},
    components::BroadPhaseProxy,
    counters::CollisionCounters,
    narrow_phase::{NarrowPhase, Placed, TimedContact, Workspace},
    schedule::{CollisionSystems, ImpactSystems, add_to_tick},
    settings::NarrowPhaseSettings,
};

/// The exact tests of all candidate pairs.
#[derive(Clone, Copy, Debug, Default)]
pub struct NarrowPhasePlugin;

impl Plugin for NarrowPhasePlugin {
    fn build(&self, app: &mut App) {
        add_to_tick(app, |app, schedule| {
            app.add_systems(
                schedule,
                (
                    search_all.in_set(CollisionSystems::BroadPhase).before(find_candidates).run_if(is_out_of_step),
                    (test_candidates.before(ImpactSystems), take_up_verdicts.after(ImpactSystems))
                        .in_set(CollisionSystems::NarrowPhase),
                ),
            );
        });
    }
}

/// Did the exact tests miss a search, since they did not run, or are the contacts those of another time?
fn is_out_of_step(contacts: Option<Res<Contacts>>, index: Option<Res<CollisionIndex>>) -> bool {
    contacts.zip(index).is_some_and(|(contacts, index)| contacts.are_out_of_step(&index))
}

/// Has all pairs looked at again.
fn search_all(mut index: ResMut<CollisionIndex>) {
    index.search_all();
}

/// The two shapes of a pair, where they are. Entities may have gone since the pair was found.
fn placed(index: &CollisionIndex, pair: Pair) -> Option<[Placed<'_>; 2]> {
    let (a, b) = (index.body(pair.a)?, index.body(pair.b)?);
    Some([Placed::new(&a.shape, &a.pose), Placed::new(&b.shape, &b.pose)])
}

/// When and how two meet in a tick.
fn impact(index: &CollisionIndex, pair: Pair, tests: &NarrowPhase, workspace: &mut Workspace) -> Option<TimedContact> {
    tests.time_of_impact(&index.moving(pair.a)?, &index.moving(pair.b)?, workspace)
}

/// A pair as contacts have it. Those who write candidates may have it the wrong way round, or one entity twice.
fn in_order(pair: Pair) -> Option<Pair> {
    (pair.a != pair.b).then(|| Pair::new(pair.a, pair.b))
}

/// Where no search was made since, there is nothing new to test: all contacts stay.
fn test_candidates(
    index: Res<CollisionIndex>,
    candidates: Res<CandidatePairs>,
    (settings, event_settings): (Res<NarrowPhaseSettings>, Res<CollisionEventSettings>),
    enabled: Query<&BroadPhaseProxy, With<CollisionEventsEnabled>>,
    mut contacts: ResMut<Contacts>,
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    if !contacts.are_out_of_step(&index) {
        return;
    }
    let contacts = &mut *contacts;
    let tests = settings.tests();
    contacts.tracking.refresh(&event_settings, enabled.iter().filter_map(BroadPhaseProxy::id));
    let may_repeat = !index.has_listed(&candidates);
    contacts.clear_found(index.search(), may_repeat);
    if contacts.tracking.is_idle() && !index.has_swept() {
        let mut touch =
            |pair: &Pair| placed(&index, *pair).is_some_and(|[a, b]| tests.intersects(a, b, &mut workspace));
        let touching = candidates.iter().copied().filter(|pair| touch(pair));
        if may_repeat {
            contacts.found.extend(touching.filter_map(in_order));
        } else {
            contacts.found.extend(touching);
        }
    } else {
        for pair in candidates.iter().copied().filter_map(in_order) {
            if index.is_swept(pair) {
                let met = impact(&index, pair, tests, &mut workspace);
                contacts.impacts.extend(met.map(|met| SweptContact { pair, met }));
                continue;
            }
            let Some([a, b]) = placed(&index, pair) else { continue };
            if contacts.tracking.wants(pair) {
                let Some(geometry) = tests.contact(a, b, &mut workspace) else { continue };
                contacts.found_geometry.push((pair, geometry));
            } else if !tests.intersects(a, b, &mut workspace) {
                continue;
            }
            contacts.found.push(pair);
        }
        contacts.sort_impacts();
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
    let is_unknown = |pair: &&Pair| placed(index, **pair).is_some_and(|[a, b]| !crate::narrow_phase::is_known(a, b));
    let Some(pair) = candidates.iter().find(is_unknown) else { return };
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

fn take_up_verdicts(
    index: Res<CollisionIndex>,
    settings: Res<NarrowPhaseSettings>,
    mut contacts: ResMut<Contacts>,
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    if contacts.has_verdicts() {
        let contacts = &mut *contacts;
        contacts.take_up(&index);
        contacts.track(|pair| placed(&index, pair).and_then(|[a, b]| settings.tests().contact(a, b, &mut workspace)));
        contacts.has_news = true;
    }
    counters.tick.contacts = contacts.len() as u64;
}
