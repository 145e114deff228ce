//! What is met, and what comes out.

use bevy::{ecs::entity::MapEntities, prelude::*};

/// Something that a shape meets on its way, or starts in.
#[derive(Clone, Copy, Debug, PartialEq, MapEntities, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct MoveHit {
    /// The entity that is met.
    #[entities]
    pub entity: Entity,
    /// A point where the two touch, in the world.
    pub point: Vec3,
    /// A unit vector from the entity to the shape, across the surfaces that touch.
    pub normal: Vec3,
    /// How long the shape has been on its way, in seconds.
    pub time: f32,
    /// How deep the shape is in the entity, if it starts in it; 0 for what it meets on its way.
    pub depth: f32,
    /// The velocity with which the shape comes, in the world.
    pub velocity: Vec3,
}

/// What a shape does where it meets something: the answer of a callback.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AtHit {
    /// It slides along, or is pushed out of what it starts in.
    #[default]
    Slide,
    /// It goes through the entity, for the rest of this move.
    #[doc(alias("one-way platform", "pass through"))]
    Ignore,
    /// It ends there.
    Stop,
}

/// How a move ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Clone, Debug, Default, PartialEq, Hash)]
#[type_path = "bevy_octree"]
pub enum MoveEnd {
    /// It went on for all of its time, wherever it slid to.
    #[default]
    Done,
    /// A callback said [`AtHit::Stop`].
    Stopped,
    /// It is in something that it finds no way out of, as between walls that close in: it stays where it is, with no
    /// velocity, unless a way along these leads out of them.
    #[doc(alias = "crushed")]
    Stuck,
    /// What it was asked is not possible: a pose, velocity or time that is not finite, a negative time, a shape without an
    /// end. It stays where it is, with no velocity.
    Refused,
}

/// What becomes of a shape that moves and slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Where it is in the end.
    pub pose: Transform,
    /// The velocity that is left to it, in the world: without what went into walls.
    pub velocity: Vec3,
    /// How it ended.
    pub end: MoveEnd,
}

/// What becomes of a shape that is pushed out of what it is in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depenetrated {
    /// Where it is in the end.
    pub pose: Transform,
    /// Is it out of everything? If not, it [is stuck](MoveEnd::Stuck).
    pub is_free: bool,
}
