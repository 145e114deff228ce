//! A polygon of a mesh and what is beside it: the normals that a surface has there.
//!
//! Not every axis along which a solid and a polygon can be parted is a normal of the mesh. At a
//! side between polygons in one plane, or on the inner side of a fold, a solid that is pushed
//! across the side runs into the neighbour: that is how things trip over the seams of a floor. The
//! normals at a point of the surface are the directions in which it is highest there, neighbours
//! included: those of Voronoi regions, which Bullet's utility for internal edges and Jolt's active
//! edges go by.

use bevy::math::Vec3A;

/// The sine of the angle up to which two polygons count as in one plane, and the share of a length
/// that is more than rounding.
const FLAT: f32 = 1e-3;

/// The sine of the angle below which two edges span no plane.
const PARALLEL: f32 = 1e-2;

/// A translation that takes a solid off a polygon.
#[derive(Clone, Copy, Debug)]
pub struct WayOut {
    /// A unit vector.
    pub direction: Vec3A,
    pub depth: f32,
}

/// The least translation so far.
pub struct Best {
    pub way: Option<WayOut>,
    pub bias: f32,
}

impl Best {
    /// Would a translation be better?
    #[inline]
    pub fn is_beaten_by(&self, depth: f32) -> bool {
        self.way.is_none_or(|way| depth < way.depth - self.bias)
    }

    #[inline]
    pub fn take(&mut self, direction: Vec3A, depth: f32) {
        self.way = Some(WayOut { direction, depth });
    }
}

/// How far points reach along a direction.
#[inline]
pub fn highest(points: &[Vec3A], direction: Vec3A) -> f32 {
    let heights = points.iter().map(|point| point.dot(direction));
    heights.fold(f32::NEG_INFINITY, f32::max)
}

/// What is beyond a side of a polygon: the next corners of the neighbour at the side's two ends.
/// `None` at a border.
pub type Beyond = Option<[Vec3A; 2]>;

/// A polygon and what is beside it.
#[derive(Clone, Copy, Debug)]
pub struct Facet<'a> {
    pub corners: &'a [Vec3A],
    /// Zero for one that a scale of zero flattened.
    pub normal: Vec3A,
    /// What is beyond each side, from a corner to the next.
    pub beyond: &'a [Beyond],
    /// Is only the side that the normal points to outside?
    pub is_solid: bool,
}

impl<'a> Facet<'a> {
    #[inline]
    fn ends(&self, side: usize) -> [Vec3A; 2] {
        let next = if side + 1 == self.corners.len() {
            0
        } else {
            side + 1
        };
        [self.corners[side], self.corners[next]]
    }

    /// Is a direction a normal of the surface where the polygon is highest along it?
    pub fn allows(&self, direction: Vec3A) -> bool {
        let top = highest(self.corners, direction);
        (0..self.corners.len()).all(|side| {
            let ends = self.ends(side);
            let slack = FLAT * (ends[1] - ends[0]).abs().element_sum();
            let is_top = ends.map(|end| top - end.dot(direction) <= slack);
            if is_top == [false; 2] {
                return true;
            }
            let Some(beyond) = self.beyond[side] else {
                return !self.is_solid || direction.dot(self.normal) >= 0.0;
            };
            let is_below = |end: usize| {
                let way = beyond[end] - ends[end];
                way.dot(direction) <= FLAT * way.abs().element_sum()
            };
            let rises = |end: usize| is_top[end] && !is_below(end);
            !(rises(0) || rises(1)) && (!self.is_solid || self.is_outside(ends, beyond, direction))
        })
    }

    /// Of the directions along which a solid is highest at a side, those that point out of it.
    fn is_outside(&self, ends: [Vec3A; 2], beyond: [Vec3A; 2], direction: Vec3A) -> bool {
        let bend = bend(ends, beyond, self.normal);
        bend < -FLAT || (bend <= FLAT && direction.dot(self.normal) >= 0.0)
    }

    /// A side that may have normals of its own: not one between polygons in one plane, nor, of a
    /// solid, the bottom of a fold.
    #[inline]
    pub fn ridge(&self, side: usize) -> Option<Ridge<'a>> {
        let ends = self.ends(side);
        let beyond = self.beyond[side];
        if let Some(beyond) = beyond {
            let bend = bend(ends, beyond, self.normal);
            if bend.abs() <= FLAT || (self.is_solid && bend > 0.0) {
                return None;
            }
        }
        Some(Ridge {
            corners: self.corners,
            ends,
            beyond,
            outside: if self.is_solid && beyond.is_none() {
                self.normal
            } else {
                Vec3A::ZERO
            },
        })
    }
}

/// The sine of the angle by which the surface bends up beyond a side.
#[inline]
fn bend(ends: [Vec3A; 2], beyond: [Vec3A; 2], normal: Vec3A) -> f32 {
    let ways = [beyond[0] - ends[0], beyond[1] - ends[1]];
    let steeper = |way: Vec3A| way.dot(normal) / way.length().max(f32::MIN_POSITIVE);
    let slopes = ways.map(steeper);
    if slopes[0].abs() > slopes[1].abs() {
        slopes[0]
    } else {
        slopes[1]
    }
}

/// A side of a polygon that may have normals of its own.
#[derive(Clone, Copy, Debug)]
pub struct Ridge<'a> {
    corners: &'a [Vec3A],
    pub ends: [Vec3A; 2],
    beyond: Beyond,
    /// Its normals point here; zero if both ways are outside.
    outside: Vec3A,
}

impl Ridge<'_> {
    /// The normal that it has at a right angle to an edge of that direction, if it has one.
    #[inline]
    pub fn across(&self, edge: Vec3A) -> Option<Vec3A> {
        let along = self.ends[1] - self.ends[0];
        let cross = along.cross(edge);
        let squared = cross.length_squared();
        if squared <= PARALLEL * PARALLEL * along.length_squared() * edge.length_squared() {
            return None;
        }
        let axis = cross / squared.sqrt();
        let from = self.ends[0];
        let [mut low, mut high] = [0f32; 2];
        for corner in self.corners {
            let height = (*corner - from).dot(axis);
            (low, high) = (low.min(height), high.max(height));
        }
        // Turned so that the polygon is below.
        let (axis, rises) = if high > -low {
            (-axis, -low)
        } else {
            (axis, high)
        };
        let slack = FLAT * low.abs().max(high);
        let is_below = |end: usize, beyond: [Vec3A; 2]| {
            let way = beyond[end] - self.ends[end];
            way.dot(axis) <= FLAT * way.abs().element_sum()
        };
        let is_normal = rises <= slack
            && axis.dot(self.outside) >= 0.0
            && self
                .beyond
                .is_none_or(|beyond| is_below(0, beyond) && is_below(1, beyond));
        is_normal.then_some(axis)
    }
}
