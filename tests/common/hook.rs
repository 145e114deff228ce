//! A hook that vetoes pairs.

use bevy::{ecs::system::SystemParam, prelude::*};
use bevy_octree::prelude::*;

/// An entity that meets nothing, says [`NoGhosts`].
#[derive(Component)]
pub struct Ghost;

#[derive(SystemParam)]
pub struct NoGhosts<'w, 's>(Query<'w, 's, (), With<Ghost>>);

impl PairHook for NoGhosts<'static, 'static> {
    fn admits(hook: &NoGhosts, a: Entity, b: Entity) -> bool {
        !hook.0.contains(a) && !hook.0.contains(b)
    }
}
