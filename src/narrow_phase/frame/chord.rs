//! Where the line of a ray passes through a convex solid, and what of that its options let it meet.

use bevy::math::DVec3;

use crate::narrow_phase::cast_options::{Faces, RayCastOptions};

/// The sine of the angle below which something counts as going along what it starts on: more than
/// the rounding of directions and normals as 32-bit floats.
pub const ALONG_START: f64 = 1e-6;

/// The line of a ray and a convex solid. Normals are of any length, in the coordinates of whoever
/// asks.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    /// How high the ray starts over the border, in the world; below zero inside.
    pub height: f64,
    /// If it starts on the border: the sine of the angle by which it rises over the face that it
    /// starts on; the greatest, where these are several.
    pub rise: f64,
    /// That face.
    pub start: Met,
    /// Where the line enters, and where it leaves, maybe behind the start; `None` if it passes by.
    pub ends: Option<[Met; 2]>,
}

impl Chord {
    /// Where the ray meets the solid, by its options; it counts as on the border within `slack`.
    pub fn met(self, options: &RayCastOptions, slack: f64) -> Option<Met> {
        let leaves = self.ends.map(|[_, leaves]| leaves);
        if self.height < -slack {
            return match options.faces {
                _ if options.meets_inside() => Some(Met::INSIDE),
                Faces::Front => None,
                Faces::Both | Faces::Back => leaves,
            };
        }
        if self.height <= slack {
            let goes_in = self.rise < -ALONG_START;
            return match options.faces {
                _ if options.ignores_start && !goes_in => None,
                Faces::Back if goes_in => leaves,
                Faces::Back => leaves.map(Met::ahead).or(Some(self.start)),
                Faces::Front if options.hollow && !goes_in => None,
                Faces::Both | Faces::Front => Some(self.start),
            };
        }
        let met = match options.faces {
            Faces::Both | Faces::Front => self.ends?[0],
            Faces::Back => self.ends?[1],
        };
        (self.ends?[0].distance >= 0.0).then_some(met)
    }
}

/// Where a ray meets a shape, in the shape's coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    pub distance: f64,
    /// The normal of the face that is met, out of a solid, not of unit length; `None` inside.
    pub face: Option<DVec3>,
    /// By its place in the mesh.
    pub polygon: Option<u32>,
    /// Is the face crossed there, so that its normal is that of the impact?
    pub crosses: bool,
}

impl Met {
    pub const INSIDE: Self = Self {
        distance: 0.0,
        face: None,
        polygon: None,
        crosses: false,
    };

    /// A face that is crossed.
    pub fn crossing(distance: f64, face: DVec3, polygon: Option<u32>) -> Self {
        Self {
            distance,
            face: Some(face),
            polygon,
            crosses: true,
        }
    }

    /// A polygon that the ray runs along, or starts on.
    pub fn touching(distance: f64, face: DVec3, polygon: Option<u32>) -> Self {
        Self {
            crosses: false,
            ..Self::crossing(distance, face, polygon)
        }
    }

    /// The same, not behind the start.
    pub fn ahead(self) -> Self {
        Self {
            distance: self.distance.max(0.0),
            ..self
        }
    }
}
