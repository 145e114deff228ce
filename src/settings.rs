//! Settings of the broad phase, as a resource. Those of the exact tests are [`NarrowPhase`] itself.

use bevy::prelude::*;

use crate::{
    broad_phase::{BroadPhaseMethod, PairKinds},
    narrow_phase::NarrowPhase,
};

/// Settings of the broad phase. Changes take effect at the next tick.
#[doc(alias = "broad phase")]
#[derive(Resource, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct BroadPhaseSettings {
    /// How overlapping boxes are searched for.
    pub method: BroadPhaseMethod,
    /// Which kinds of pairs are sought at all, by which of the two is a
    /// [`StaticShape`](crate::filters::StaticShape). Contacts of a kind that is no longer sought
    /// end.
    pub pair_kinds: PairKinds,
}

pub(crate) fn register(app: &mut App) {
    app.init_resource::<BroadPhaseSettings>()
        .init_resource::<NarrowPhase>()
        .register_type::<BroadPhaseSettings>()
        .register_type::<NarrowPhase>();
}
