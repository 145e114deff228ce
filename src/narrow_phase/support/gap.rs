//! What the search for a distance answers.

use bevy::math::DVec3;

/// How two shapes are to each other.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// The distance of the two; less than zero if they overlap: how far one has to be pushed along
    /// the normal to part them.
    pub distance: f64,
    /// A unit vector from the first to the second.
    pub normal: DVec3,
    /// Of the first and of the second: those that are closest to each other, or deepest in each
    /// other.
    pub points: [DVec3; 2],
    /// A point of both, if they overlap, and between the two if not.
    pub between: DVec3,
}

impl Gap {
    /// As the other one sees it.
    pub fn reversed(self) -> Self {
        let [a, b] = self.points;
        Self {
            normal: -self.normal,
            points: [b, a],
            ..self
        }
    }

    /// From cores to shapes with a radius around them.
    pub fn grown(self, [a, b]: [f64; 2]) -> Self {
        let Self {
            distance,
            normal,
            points: [on_a, on_b],
            between,
        } = self;
        // Cores that are apart have a line between them that is in both shapes where these overlap.
        let between = if distance > 0.0 {
            on_a + normal * (0.5 * (a + distance - b)).clamp(0.0, distance)
        } else {
            between
        };
        Self {
            distance: distance - a - b,
            normal,
            points: [on_a + normal * a, on_b - normal * b],
            between,
        }
    }
}
