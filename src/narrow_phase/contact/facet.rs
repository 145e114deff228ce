//! A polygon of a mesh and what is beside it: the normals that a surface has there.
//!
//! Not every axis along which a solid and a polygon can be parted is a normal of the mesh. At a
//! side between polygons in one plane, or on the inner side of a fold, a solid that is pushed
//! across the side runs into the neighbour: that is how things trip over the seams of a floor. The
//! normals at a point of the surface are the directions in which it is highest there, neighbours
//! included: those of Voronoi regions, which Bullet's utility for internal edges and Jolt's active
//! edges go by.

use bevy::math::Vec3A;

use super::around::{Around, FLAT, is_up};

/// The sine of the angle below which two edges span no plane.
pub const PARALLEL: f32 = 1e-2;

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

/// A polygon and what is beside it.
#[derive(Clone, Copy)]
pub struct Facet<'a> {
    pub corners: &'a [Vec3A],
    /// Zero for one that a scale of zero flattened.
    pub normal: Vec3A,
    pub around: Around<'a>,
    /// Is only the side that the normal points to outside?
    pub is_solid: bool,
}

impl Facet<'_> {
    #[inline]
    pub fn ends(&self, side: usize) -> [Vec3A; 2] {
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
        let is_highest_of_neighbours = (0..self.corners.len()).all(|side| {
            let ends = self.ends(side);
            let slack = FLAT * (ends[1] - ends[0]).abs().element_sum();
            let is_top = ends.map(|end| top - end.dot(direction) <= slack);
            if is_top == [false; 2] {
                return true;
            }
            let Some(beyond) = self.around.beyond(side) else {
                return !self.is_solid || direction.dot(self.normal) >= 0.0;
            };
            let rises = |end: usize| is_top[end] && is_up(beyond[end] - ends[end], direction, 0.0);
            !(rises(0) || rises(1)) && (!self.is_solid || self.is_outside(ends, beyond, direction))
        });
        is_highest_of_neighbours && !self.is_topped(top, direction)
    }

    /// Is anything else around the corners that are highest along a direction higher?
    fn is_topped(&self, top: f32, direction: Vec3A) -> bool {
        let rises = |side: usize| {
            let [from, to] = self.ends(side);
            let slack = FLAT * (to - from).abs().element_sum();
            top - from.dot(direction) <= slack && self.around.rises_at(side, direction)
        };
        (0..self.corners.len()).any(rises) || self.is_flush(direction)
    }

    /// Where it is highest along a direction, does it lie against what is no neighbour and higher?
    pub fn is_flush(&self, direction: Vec3A) -> bool {
        let top = highest(self.corners, direction);
        let is_top = |corner: Vec3A, slack: f32| top - corner.dot(direction) <= slack;
        let mut is_line = false;
        for side in 0..self.corners.len() {
            let ends = self.ends(side);
            let slack = FLAT * (ends[1] - ends[0]).abs().element_sum();
            if is_top(ends[0], slack) && is_top(ends[1], slack) {
                is_line = true;
                if self.around.is_topped(ends, direction) {
                    return true;
                }
            }
        }
        let mut tops = self.corners.iter().filter(|corner| is_top(**corner, 0.0));
        !is_line && tops.any(|corner| self.around.is_topped([*corner; 2], direction))
    }

    /// Of the directions along which a solid is highest at a side, those that point out of it.
    fn is_outside(&self, ends: [Vec3A; 2], beyond: [Vec3A; 2], direction: Vec3A) -> bool {
        let bend = bend(ends, beyond, self.normal);
        bend < -FLAT || (bend <= FLAT && direction.dot(self.normal) >= 0.0)
    }

    /// From where to where it reaches along an axis, as seen from one of its corners.
    #[inline]
    pub fn heights(&self, from: Vec3A, axis: Vec3A) -> [f32; 2] {
        let heights = self.corners.iter().map(|corner| (*corner - from).dot(axis));
        heights.fold([0.0, 0.0], |[low, high]: [f32; 2], height| {
            [low.min(height), high.max(height)]
        })
    }

    /// The direction at right angles to a side and to an edge along which the polygon is highest at
    /// that side, if there is one.
    #[inline]
    pub fn across(&self, side: usize, edge: Vec3A) -> Option<Vec3A> {
        let [from, to] = self.ends(side);
        let along = to - from;
        let cross = along.cross(edge);
        let squared = cross.length_squared();
        if squared <= PARALLEL * PARALLEL * along.length_squared() * edge.length_squared() {
            return None;
        }
        let axis = cross / squared.sqrt();
        let [low, high] = self.heights(from, axis);
        // Turned so that the polygon is below.
        let (axis, rises, falls) = if high > -low {
            (-axis, -low, high)
        } else {
            (axis, high, -low)
        };
        (rises <= FLAT * falls).then_some(axis)
    }

    /// Can a side have normals of its own? See [`is_ridge`](Self::is_ridge).
    pub fn is_bent(&self, side: usize) -> bool {
        self.around.beyond(side).is_none_or(|beyond| {
            let bend = bend(self.ends(side), beyond, self.normal);
            bend.abs() > FLAT && !(self.is_solid && bend > 0.0)
        })
    }

    /// Is such a direction a normal that the side has of its own? Not between polygons in one plane,
    /// nor, of a solid, at the bottom of a fold, nor where anything else that lies against the side
    /// is higher.
    pub fn is_ridge(&self, side: usize, direction: Vec3A) -> bool {
        let Some(beyond) = self.around.beyond(side) else {
            return (!self.is_solid || direction.dot(self.normal) >= 0.0)
                && !self.around.is_topped(self.ends(side), direction);
        };
        let ends = self.ends(side);
        let bend = bend(ends, beyond, self.normal);
        if bend.abs() <= FLAT || (self.is_solid && bend > 0.0) {
            return false;
        }
        ![0, 1]
            .iter()
            .any(|end| is_up(beyond[*end] - ends[*end], direction, 0.0))
            && !self.around.is_topped(ends, direction)
    }
}

/// The components of a vector, smallest and greatest of all points, one by one.
#[inline]
pub fn bounds(points: impl Iterator<Item = Vec3A>) -> [Vec3A; 2] {
    points.fold(
        [Vec3A::INFINITY, Vec3A::NEG_INFINITY],
        |[min, max], point| [min.min(point), max.max(point)],
    )
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
