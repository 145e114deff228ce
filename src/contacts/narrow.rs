//! The exact tests of all candidate pairs.

use bevy::{ecs::schedule::InternedScheduleLabel, prelude::*};

use super::{CollisionEventSettings, CollisionEventsEnabled, Contacts, SweptContact};
use crate::{
    broad_phase::Pair,
    collision_index::{CandidatePairs, CollisionIndex},
    components::BroadPhaseProxy,
    counters::CollisionCounters,
    narrow_phase::{NarrowPhase, Placed, TimedContact, Workspace},
    plugin::{CollisionSystems, NarrowPhaseSettings},
};

/// The exact tests of all candidate pairs.
#[derive(Clone, Debug)]
pub struct NarrowPhasePlugin(pub(crate) InternedScheduleLabel);

impl Plugin for NarrowPhasePlugin {
    fn build(&self, app: &mut App) {
        app.configure_sets(self.0, ImpactSystems.in_set(CollisionSystems::NarrowPhase)).add_systems(
            self.0,
            (test_candidates.before(ImpactSystems), take_up_verdicts.after(ImpactSystems))
                .in_set(CollisionSystems::NarrowPhase),
        );
    }
}

/// What happens to verdicts before they are taken up: impacts on the way change what comes after them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ImpactSystems;

/// The two shapes of a pair, where they are. Entities may have gone since the pair was found.
fn placed(index: &CollisionIndex, pair: Pair) -> Option<[Placed<'_>; 2]> {
    let (a, b) = (index.body(pair.a)?, index.body(pair.b)?);
    Some([Placed::new(&a.shape, &a.pose), Placed::new(&b.shape, &b.pose)])
}

/// When and how two meet in a tick.
fn impact(index: &CollisionIndex, pair: Pair, tests: &NarrowPhase, workspace: &mut Workspace) -> Option<TimedContact> {
    tests.time_of_impact(&index.moving(pair.a)?, &index.moving(pair.b)?, workspace)
}

fn test_candidates(
    index: Res<CollisionIndex>,
    candidates: Res<CandidatePairs>,
    (settings, event_settings): (Res<NarrowPhaseSettings>, Res<CollisionEventSettings>),
    enabled: Query<&BroadPhaseProxy, With<CollisionEventsEnabled>>,
    mut contacts: ResMut<Contacts>,
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    let contacts = &mut *contacts;
    let tests = settings.tests();
    contacts.tracking.refresh(&event_settings, enabled.iter().filter_map(BroadPhaseProxy::id));
    contacts.clear_found();
    if contacts.tracking.is_idle() && !index.has_swept() {
        contacts.found.extend(
            candidates
                .iter()
                .filter(|pair| placed(&index, **pair).is_some_and(|[a, b]| tests.intersects(a, b, &mut workspace))),
        );
    } else {
        for &pair in candidates.iter() {
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
        contacts.impacts.sort_unstable_by_key(|impact| impact.pair);
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
    contacts.take_up(&index);
    counters.tick.contacts = contacts.len() as u64;
    contacts.track(|pair| placed(&index, pair).and_then(|[a, b]| settings.tests().contact(a, b, &mut workspace)));
}
