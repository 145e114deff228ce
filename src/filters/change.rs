//! Changes of filters, taken up at once.

use bevy::ecs::{lifecycle::HookContext, world::DeferredWorld};

use crate::{broad_phase::PairFilter, collision_index::in_index};

/// Changes which pairs an entity makes, if it is in the index.
pub(crate) fn change_filter(mut world: DeferredWorld, context: HookContext, change: impl FnOnce(&mut PairFilter)) {
    in_index(&mut world, context.entity, |index, id| index.change_filter(id, change));
}
