//! The exact tests of all candidate pairs.

use bevy::{ecs::schedule::InternedScheduleLabel, prelude::*};

use super::{CollisionEventSettings, CollisionEventsEnabled, Contacts, tracking::Tracking};
use crate::{
    broad_phase::Pair,
    collision_index::{CandidatePairs, CollisionIndex},
    components::BroadPhaseProxy,
    counters::CollisionCounters,
    narrow_phase::{Placed, StageCounters, Workspace},
    plugin::{CollisionSystems, NarrowPhaseSettings},
};

/// The exact tests of all candidate pairs.
#[derive(Clone, Debug)]
pub struct NarrowPhasePlugin(pub(crate) InternedScheduleLabel);

impl Plugin for NarrowPhasePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(self.0, test_candidates.in_set(CollisionSystems::NarrowPhase));
    }
}

/// The two shapes of a pair, where they are. Entities may have gone since the pair was found.
fn placed(index: &CollisionIndex, pair: Pair) -> Option<[Placed<'_>; 2]> {
    let (a, b) = (index.body(pair.a)?, index.body(pair.b)?);
    Some([Placed::new(&a.shape, &a.pose), Placed::new(&b.shape, &b.pose)])
}

fn test_candidates(
    index: Res<CollisionIndex>,
    candidates: Res<CandidatePairs>,
    (settings, event_settings): (Res<NarrowPhaseSettings>, Res<CollisionEventSettings>),
    enabled: Query<&BroadPhaseProxy, With<CollisionEventsEnabled>>,
    mut contacts: ResMut<Contacts>,
    mut counters: ResMut<CollisionCounters>,
    (mut workspace, mut tracking): (Local<Workspace>, Local<Tracking>),
) {
    let contacts = &mut *contacts;
    let tests = settings.tests();
    tracking.refresh(&event_settings, enabled.iter().filter_map(BroadPhaseProxy::id));
    contacts.clear_found();
    if tracking.is_idle() {
        contacts.found.extend(
            candidates
                .iter()
                .filter(|pair| placed(&index, **pair).is_some_and(|[a, b]| tests.intersects(a, b, &mut workspace))),
        );
    } else {
        for &pair in candidates.iter() {
            let Some([a, b]) = placed(&index, pair) else { continue };
            if tracking.wants(pair) {
                let Some(geometry) = tests.contact(a, b, &mut workspace) else { continue };
                contacts.found_geometry.push((pair, geometry));
            } else if !tests.intersects(a, b, &mut workspace) {
                continue;
            }
            contacts.found.push(pair);
        }
    }
    contacts.take_up(&index);
    counters.tick.stages = std::mem::take(&mut workspace.counters);
    counters.tick.contacts = contacts.len() as u64;
    contacts.track(&tracking, |pair| placed(&index, pair).and_then(|[a, b]| tests.contact(a, b, &mut workspace)));
    // Only candidates count.
    workspace.counters = StageCounters::default();
}
