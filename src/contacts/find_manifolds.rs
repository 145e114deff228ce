//! Finds where those in contact lie on each other, of which somebody asked.

use bevy::prelude::*;

use super::{
    list::Contacts,
    manifolds::Manifolds,
    pair::{ContactKey, SweptContact, seek},
    settings::{CollisionEventSettings, EventScope, ManifoldsEnabled},
    verdicts::Verdicts,
};
use crate::{
    collision_index::{Candidate, CollisionIndex},
    components::BroadPhaseProxy,
    narrow_phase::{Manifold, NarrowPhase, Placed, Workspace},
};

/// The cosine of the angle up to which a normal that is found for the moment of an impact is that of
/// the impact.
const SAME_NORMAL: f32 = 0.999;

/// Has somebody asked, or had by the last tick?
pub(super) fn wants_manifolds(
    settings: Res<CollisionEventSettings>,
    enabled: Query<(), With<ManifoldsEnabled>>,
    mut asked: Local<bool>,
) -> bool {
    let asks = settings.manifolds == EventScope::All || !enabled.is_empty();
    std::mem::replace(&mut *asked, asks) || asks
}

/// Finds those of all contacts that somebody asked about. Of two at rest they are kept.
pub(super) fn find_manifolds(
    (settings, tests): (Res<CollisionEventSettings>, Res<NarrowPhase>),
    enabled: Query<&BroadPhaseProxy, With<ManifoldsEnabled>>,
    (index, verdicts): (Res<CollisionIndex>, Res<Verdicts>),
    mut contacts: ResMut<Contacts>,
    mut workspace: Local<Workspace>,
) {
    // That nobody sees change but who asked.
    let (pairs, impacts, manifolds) = contacts.bypass_change_detection().split_manifolds();
    let Manifolds {
        known,
        last,
        enabled: by_handle,
        search,
    } = manifolds;
    std::mem::swap(known, last);
    known.clear();
    by_handle.clear();
    for id in enabled.iter().filter_map(BroadPhaseProxy::id) {
        if by_handle.len() <= id.index() {
            by_handle.resize(id.index() + 1, false);
        }
        by_handle[id.index()] = true;
    }
    let is_enabled = |key: &ContactKey| {
        key.ids
            .iter()
            .any(|id| by_handle.get(id.index()).is_some_and(|enabled| *enabled))
    };
    // What was found anew, was so in the last search; no search, nothing new.
    let is_old = std::mem::replace(search, index.search()) == index.search();
    let mut impacts = impacts.iter().peekable();
    let mut last = last.iter().peekable();
    for (contact, is_of_this_tick) in pairs {
        let key = &contact.key;
        if settings.manifolds != EventScope::All && !is_enabled(key) {
            continue;
        }
        let is_new = is_of_this_tick && !is_old;
        let kept = seek(&mut last, key, |(last, _)| last.key).filter(|_| !is_new);
        let impact = seek(&mut impacts, key, |impact| impact.key);
        let manifold = match (kept, impact) {
            (Some((_, kept)), _) => Some(*kept),
            (None, Some(impact)) => Some(on_the_way(impact, &index, &tests, &mut workspace)),
            (None, None) if verdicts.is_displaced(key) => verdicts
                .geometry()
                .iter()
                .find(|(found, _)| found == key)
                .map(|(_, contact)| Manifold::from(*contact)),
            (None, None) => index
                .placed(key.ids)
                .and_then(|[a, b]| tests.manifold(a, b, &mut workspace)),
        };
        known.extend(manifold.map(|manifold| (*contact, manifold)));
    }
}

/// Where two met on the way: at that moment, unless one of them was elsewhere by then, since it
/// changed course.
fn on_the_way(
    impact: &SweptContact,
    index: &CollisionIndex,
    tests: &NarrowPhase,
    workspace: &mut Workspace,
) -> Manifold {
    let met = impact.met;
    let single = Manifold::from(met.contact);
    let Some(Candidate::OnTheWay([a, b])) = index.candidate(impact.key.ids) else {
        return single;
    };
    let (at_a, at_b) = (a.at(met.time), b.at(met.time));
    let (a, b) = (Placed::new(a.shape(), &at_a), Placed::new(b.shape(), &at_b));
    let found = tests.manifold(a, b, workspace);
    found
        .filter(|found| found.normal.dot(met.contact.normal) > SAME_NORMAL)
        .unwrap_or(single)
}
