//! What is handed from the walk to who puts characters in their places.

use bevy::prelude::*;

/// Where a character has come to in this tick, in the world.
#[derive(Component, Clone, Copy, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub(super) struct Gone(pub Option<Transform>);
