//! What can be chosen for a scene: how many objects, how pairs are searched for, what is drawn.

use bevy::prelude::*;
use bevy_octree::{broad_phase::ObjectOctreeSettings, debug_draw::LeafColors, prelude::*};
use clap::ValueEnum;

use crate::scene::Scene;

/// How pairs of boxes are searched for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Search {
    /// The report's N-objects octree, whose leaves can be drawn.
    #[default]
    Octree,
    /// The pointerless octree, made for speed.
    Linear,
    /// Every object against every other.
    Exhaustive,
}

impl Search {
    /// All of them, with the names in the panel.
    pub const ALL: [(Self, &str); 3] = [
        (Self::Octree, "N-objects octree"),
        (Self::Linear, "pointerless octree"),
        (Self::Exhaustive, "exhaustive search"),
    ];

    /// Returns the one after it.
    pub const fn next(self) -> Self {
        match self {
            Self::Octree => Self::Linear,
            Self::Linear => Self::Exhaustive,
            Self::Exhaustive => Self::Octree,
        }
    }
}

/// Which leaves of the octree are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Leaves {
    /// None.
    #[default]
    None,
    /// All, the deeper the greener.
    Generation,
    /// All, the fuller the greener.
    Fill,
}

impl Leaves {
    /// All of them, with the names in the panel.
    pub const ALL: [(Self, &str); 3] = [
        (Self::None, "none"),
        (Self::Generation, "by generation"),
        (Self::Fill, "by fill"),
    ];

    /// Returns the one after it.
    pub const fn next(self) -> Self {
        match self {
            Self::None => Self::Generation,
            Self::Generation => Self::Fill,
            Self::Fill => Self::None,
        }
    }
}

/// What is chosen.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The number of objects; takes effect when the scene begins anew.
    pub objects: usize,
    /// How many objects a leaf lists before it splits.
    pub max_objects: u32,
    /// How pairs are searched for.
    pub search: Search,
    /// Which leaves are drawn.
    pub leaves: Leaves,
    /// What was asked for at the start, until the first scene begins.
    wishes: Wishes,
}

/// What differs from how the first scene is set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wishes {
    /// The number of objects.
    pub objects: Option<usize>,
    /// How many objects a leaf lists before it splits.
    pub max_objects: Option<u32>,
    /// How pairs are searched for.
    pub search: Option<Search>,
    /// Which leaves are drawn.
    pub leaves: Option<Leaves>,
}

impl From<Wishes> for Settings {
    fn from(wishes: Wishes) -> Self {
        Self {
            objects: 0,
            max_objects: 8,
            search: Search::default(),
            leaves: Leaves::default(),
            wishes,
        }
    }
}

impl Settings {
    /// The smallest number of objects that can be chosen.
    pub const LEAST_OBJECTS: usize = 10;
    /// The largest N that can be chosen.
    pub const MOST_MAX_OBJECTS: u32 = 256;

    /// Sets it as the scene is at its start.
    pub fn begin(&mut self, scene: &Scene) {
        let wishes = std::mem::take(&mut self.wishes);
        self.objects = scene.objects.map_or(0, |objects| {
            let wish = wishes.objects.unwrap_or(objects.default);
            wish.clamp(Self::LEAST_OBJECTS, objects.most)
        });
        let max_objects = wishes.max_objects.unwrap_or(scene.max_objects);
        self.max_objects = max_objects.min(Self::MOST_MAX_OBJECTS);
        self.search = wishes.search.unwrap_or(self.search);
        self.leaves = wishes.leaves.unwrap_or(scene.leaves);
    }

    /// Doubles the number of objects, or halves it, within the limits of the scene. Returns whether
    /// it changed.
    pub fn scale_objects(&mut self, is_more: bool, scene: &Scene) -> bool {
        let Some(limits) = scene.objects else {
            return false;
        };
        let wish = if is_more {
            self.objects * 2
        } else {
            self.objects / 2
        };
        let wish = wish.clamp(Self::LEAST_OBJECTS, limits.most);
        std::mem::replace(&mut self.objects, wish) != wish
    }
}

/// Hands what is chosen to the library.
pub fn apply(
    settings: Res<Settings>,
    mut broad_phase: ResMut<BroadPhaseSettings>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    let method = match settings.search {
        Search::Octree => BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(
            settings.max_objects,
        )),
        Search::Linear => BroadPhaseMethod::LinearOctree,
        Search::Exhaustive => BroadPhaseMethod::Exhaustive,
    };
    if broad_phase.method != method {
        broad_phase.method = method;
    }
    let (lines, drawn) = gizmos.config_mut::<CollisionGizmos>();
    lines.line.width = 1.5;
    drawn.leaves = match settings.leaves {
        Leaves::None => None,
        Leaves::Generation => Some(LeafColors::Generation),
        Leaves::Fill => Some(LeafColors::Fill),
    };
}

/// Of what the debug plugin can draw, leaves alone: shapes are there as solids.
pub fn draw_leaves_alone(mut gizmos: ResMut<GizmoConfigStore>) {
    let (_, drawn) = gizmos.config_mut::<CollisionGizmos>();
    *drawn = CollisionGizmos {
        moving: None,
        resting: None,
        shapes: None,
        contacts: None,
        sweeps: None,
        leaves: None,
        ..default()
    };
}
