//! Where the cores of two shapes are closest to each other, and what follows from it.

use bevy::math::Vec3A;

use crate::narrow_phase::{answer::LocalContact, length::length};

/// The points of two cores that are closest to each other, and the radii around the cores.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    pub points: [Vec3A; 2],
    /// From the first to the second: more exact than their difference, where they are far away.
    pub offset: Vec3A,
    pub radii: [f32; 2],
}

/// Where two shapes are closest to each other: the same point twice, if they overlap.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    pub points: [Vec3A; 2],
    /// From the first to the second.
    pub offset: Vec3A,
    pub distance: f32,
}

impl From<[Vec3A; 2]> for Closest {
    fn from(points: [Vec3A; 2]) -> Self {
        let offset = points[1] - points[0];
        let distance = length(offset);
        Self {
            points,
            offset,
            distance,
        }
    }
}

impl Nearest {
    #[inline]
    pub fn between(points: [Vec3A; 2], radii: [f32; 2]) -> Self {
        Self {
            points,
            offset: points[1] - points[0],
            radii,
        }
    }

    #[inline]
    pub fn reversed(self) -> Self {
        let ([a, b], [radius_a, radius_b]) = (self.points, self.radii);
        Self {
            points: [b, a],
            offset: -self.offset,
            radii: [radius_b, radius_a],
        }
    }

    /// How far the cores are apart.
    #[inline]
    pub fn distance(&self) -> f32 {
        self.offset.length()
    }

    /// How far the shapes are apart; negative if they overlap.
    #[inline]
    pub fn gap(&self) -> f32 {
        self.distance() - (self.radii[0] + self.radii[1])
    }

    /// The contact of two shapes whose cores are apart.
    #[inline]
    pub fn contact(&self) -> LocalContact {
        let distance = self.distance();
        let normal = self.offset / distance;
        LocalContact {
            normal,
            point: self.points[0] + normal * self.middle(distance),
            depth: (self.radii[0] + self.radii[1] - distance).max(0.0),
        }
    }

    /// How far it is from the first core to the middle between the two surfaces, or of what the two
    /// share: between the cores, and so in both.
    #[inline]
    fn middle(&self, distance: f32) -> f32 {
        let [a, b] = self.radii;
        (0.5 * (a + distance - b)).clamp(0.0, distance)
    }

    /// Where the shapes are closest to each other.
    #[inline]
    pub fn of_surfaces(&self) -> Closest {
        let [on_a, on_b] = self.points;
        let [a, b] = self.radii;
        let distance = self.distance();
        let gap = distance - (a + b);
        if gap > 0.0 {
            let normal = self.offset / distance;
            let offset = normal * gap;
            return Closest {
                points: [on_a + normal * a, on_b - normal * b],
                offset,
                distance: offset.length(),
            };
        }
        let common = if distance > 0.0 {
            on_a + self.offset * (self.middle(distance) / distance)
        } else {
            on_a
        };
        Closest {
            points: [common; 2],
            offset: Vec3A::ZERO,
            distance: 0.0,
        }
    }
}
