//! The arguments that say which stress scene is meant.

use bevy_octree::scene::stress::StressScene;
use clap::Args;

/// A stress scene.
#[derive(Args, Clone, Copy)]
pub struct WhichScene {
    /// Which scene: brownian, freefall, gravity, planes, static90, sizes, clusters, ground, outlier
    /// or rooms.
    #[arg(long)]
    pub scene: StressScene,
    /// How many objects there are.
    #[arg(long, default_value_t = 10_000, allow_negative_numbers = true)]
    pub objects: usize,
    /// Another seed gives another scene of the same kind.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    pub seed: u64,
}
