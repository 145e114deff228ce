//! The shapes that the exact tests know.
use bevy::math::Vec3;

/// What an object is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A box, by its half extents along its own axes.
    Cuboid {
        /// Half the side along each axis.
        half_size: Vec3,
    },
    /// A ball around the origin.
    Sphere {
        /// Its radius.
        radius: f32,
    },
}
