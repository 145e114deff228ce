//! What characters walk in: one description, of which each engine builds its own world.

mod boxes;
mod corridor;
mod course;
mod rest;
mod stairs;
mod terrain;

use std::{fmt, str::FromStr};

use bevy::math::{Vec2, Vec3};
use bevy::transform::components::Transform;

pub use course::Course;

use super::{HALF_HEIGHT, SKIN};
use crate::meshes::scenes::Mesh;

/// A scene by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// Hills: one mesh.
    Terrain,
    /// A floor with boxes on it, to step on and to slide along.
    Boxes,
    /// Long walls, met at grazing angles and at others.
    Corridor,
    /// Flights of steps, up and down.
    Stairs,
    /// Pressed into corners, and standing where others slip.
    Rest,
}

/// How much of a scene there is.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Characters of those scenes that do not say how many.
    pub characters: usize,
    /// Ticks of those scenes that do not say how long.
    pub ticks: usize,
    /// Another seed gives another scene of the same kind.
    pub seed: u64,
}

/// Something that stays where it is.
#[derive(Debug)]
pub enum Solid {
    /// Of half its size along each axis, and where it is; not scaled.
    Box(Vec3, Transform),
    /// A surface.
    Mesh(Mesh),
    /// A surface of which all that is below is solid.
    Ground(Mesh),
}

/// Who walks, and what is looked at.
#[derive(Clone, Debug)]
pub struct Walker {
    /// The middle of the capsule at first.
    pub start: Vec3,
    /// Where it wants to go.
    pub course: Course,
    /// What it is there for.
    pub aim: Aim,
}

/// What a character is there for: what is told of it.
#[derive(Clone, Copy, Debug)]
pub enum Aim {
    /// To get around: how much of its way it covers.
    Way,
    /// To slide along a wall: how far it gets along this unit vector, as a share of what it should, in length units per
    /// tick.
    Along(Vec2, f32),
    /// To climb so many steps of so large a height, from the level 0.
    Climb(u32, f32),
    /// To walk down: for how many ticks it touches nothing.
    Descend,
    /// To stay.
    Stay,
}

/// A scene with all that is in it.
pub struct Place {
    /// What stays.
    pub solids: Vec<Solid>,
    /// Who walks, with the name of their group: those of a group are told of together.
    pub walkers: Vec<(&'static str, Walker)>,
    /// Below that, there is nothing to stand on.
    pub lowest: f32,
    /// For so long they walk.
    pub ticks: usize,
}

impl Scene {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 5] = [
        Self::Terrain,
        Self::Boxes,
        Self::Corridor,
        Self::Stairs,
        Self::Rest,
    ];

    /// The name on the command line, and above the table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Terrain => "terrain",
            Self::Boxes => "boxes",
            Self::Corridor => "corridor",
            Self::Stairs => "stairs",
            Self::Rest => "rest",
        }
    }

    /// Is it one whose times are compared? In the others there are few characters, in odd places.
    pub const fn is_timed(self) -> bool {
        matches!(self, Self::Terrain | Self::Boxes)
    }

    /// All that is in it.
    pub fn place(self, extent: Extent) -> Place {
        match self {
            Self::Terrain => terrain::place(extent),
            Self::Boxes => boxes::place(extent),
            Self::Corridor => corridor::place(extent),
            Self::Stairs => stairs::place(extent),
            Self::Rest => rest::place(),
        }
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Scene {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = Self::ALL.map(Self::name);
        Self::ALL
            .into_iter()
            .find(|scene| scene.name() == name)
            .ok_or_else(|| format!("unknown scene: expected one of {}", all.join(", ")))
    }
}

/// A box between two corners.
fn block(low: Vec3, high: Vec3) -> Solid {
    let center = Transform::from_translation((low + high) * 0.5);
    Solid::Box((high - low) * 0.5, center)
}

/// Where a character is that stands on a level.
fn standing(x: f32, level: f32, z: f32) -> Vec3 {
    Vec3::new(x, level + HALF_HEIGHT + SKIN, z)
}
