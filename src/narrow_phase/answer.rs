//! What the exact tests answer.

use bevy::math::{DVec3, Dir3, Vec3, Vec3A};
use bevy::reflect::Reflect;

/// How far from a shape a place may be that is said to be on it, as a share of the lengths at hand: what rounding leaves
/// uncertain of a place in 32-bit floats.
const ON: f32 = f32::EPSILON;

/// The geometry of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct Contact {
    /// A unit vector from the first shape to the second: to part the two, push the second along it.
    pub normal: Vec3,
    /// A point where the two meet, in the world.
    pub point: Vec3,
    /// How far the shapes overlap along the normal, in world units. Zero if they touch, or are
    /// apart by no more than the tolerance.
    pub depth: f32,
}

impl Contact {
    /// The contact as the other shape sees it: with the normal turned around.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { normal: -self.normal, ..self }
    }
}

/// A contact in the frame of a pair.
#[derive(Clone, Copy, Debug)]
pub struct LocalContact {
    pub normal: Vec3A,
    pub point: Vec3A,
    pub depth: f32,
}

impl LocalContact {
    /// That of the pair with its two shapes swapped.
    pub fn reversed(self) -> Self {
        let normal = -self.normal;
        Self { normal, ..self }
    }
}

/// Where something on its way meets a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// How far along the way; 0 if it starts in touch.
    pub distance: f32,
    /// A point of the shape that is met, in the world; for shapes that overlap from the start, one where they meet.
    pub point: Vec3,
    /// A unit vector that points away from the shape that is met, and never along the way: against the way itself if it
    /// starts inside, where nothing better is known.
    pub normal: Vec3,
}

/// A normal, turned against what comes along a direction.
pub fn against(normal: Vec3, direction: Dir3) -> Vec3 {
    if normal.dot(*direction) > 0.0 { -normal } else { normal }
}

/// See [`ON`]: that of the place in the world, and of the place relative to that of the shape, from which it may come.
pub fn slack(origin: Vec3, from_place: DVec3) -> f64 {
    f64::from(ON) * (f64::from(origin.abs().max_element()) + 2.0 * from_place.length())
}
