//! Settings of the stages, as resources.

use bevy::prelude::*;

use crate::{
    broad_phase::{BroadPhaseMethod, PairKinds},
    narrow_phase::NarrowPhase,
};

/// Settings of the broad phase. Changes take effect at the next tick.
#[derive(Resource, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct BroadPhaseSettings {
    /// How overlapping boxes are searched for.
    pub method: BroadPhaseMethod,
    /// Which kinds of pairs are sought at all, by which of the two is a
    /// [`StaticCollider`](crate::filters::StaticCollider). Contacts of a kind that is no longer sought end.
    pub pair_kinds: PairKinds,
}

/// Settings of the exact tests: see [`NarrowPhase`]. Changes take effect at the next tick, for all pairs.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut, Reflect)]
#[reflect(opaque)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct NarrowPhaseSettings(pub NarrowPhase);

impl NarrowPhaseSettings {
    pub(crate) const fn tests(&self) -> &NarrowPhase {
        &self.0
    }
}

pub(crate) fn register(app: &mut App) {
    app.init_resource::<BroadPhaseSettings>()
        .init_resource::<NarrowPhaseSettings>()
        .register_type::<BroadPhaseSettings>()
        .register_type::<NarrowPhaseSettings>();
}
