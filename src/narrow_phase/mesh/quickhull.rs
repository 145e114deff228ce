//! The convex hull of points, by faces with any number of corners.
//!
//! Quickhull (Barber, Dobkin and Huhdanpaa, *The quickhull algorithm for convex hulls*, 1996), in 64
//! bits, with a tolerance that is far above their rounding: faces that are not clearly convex
//! against a neighbour are merged with it, as Lloyd's `QuickHull3D` does. So points in one plane make
//! one polygon, slivers vanish in what they are beside, and no decision hangs on the last bit.

mod surface;

use std::collections::VecDeque;

use bevy::math::DVec3;

use surface::{Broken, Surface};

/// A first tetrahedron has to be so many times as high as the tolerance.
const CLEAR: f64 = 4.0;

/// Why there is no hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoHull {
    /// All points are in a plane, about.
    Flat,
    /// What was merged is no surface any more: the tolerance does not fit the points.
    Broken,
}

impl From<Broken> for NoHull {
    fn from(_: Broken) -> Self {
        Self::Broken
    }
}

/// Returns the polygons of the convex hull of points, each counter-clockwise as seen from outside. No
/// point is outside by much more than the tolerance, and what is within the tolerance of a plane is
/// in it.
pub(super) fn hull(points: &[DVec3], tolerance: f64) -> Result<Vec<Vec<u32>>, NoHull> {
    let corners = first_corners(points, tolerance).ok_or(NoHull::Flat)?;
    let mut hull = Hull {
        surface: Surface::tetrahedron(points, corners),
        outside: vec![Vec::new(); 4],
        waiting: VecDeque::new(),
        tolerance,
    };
    let others = (0..points.len() as u32).filter(|point| !corners.contains(point));
    hull.share_out(others, &[0, 1, 2, 3]);
    while let Some(face) = hull.waiting.pop_front() {
        hull.raise(face)?;
    }
    hull.surface.polygons().ok_or(NoHull::Broken)
}

/// Four points that are far off each other, of which the last is behind the plane of the others.
fn first_corners(points: &[DVec3], tolerance: f64) -> Option<[u32; 4]> {
    let most = |measure: &dyn Fn(DVec3) -> f64| {
        let all = (0..)
            .zip(points)
            .map(|(index, point)| (index, measure(*point)));
        all.max_by(|a: &(u32, f64), b| a.1.total_cmp(&b.1))
    };
    let ends = DVec3::AXES.map(|axis| {
        let [low, high] = [-axis, axis].map(|axis| most(&|point| point.dot(axis)));
        low.zip(high)
    });
    let ends = ends.into_iter().flatten();
    let longest = ends.max_by(|a, b| (a.0.1 + a.1.1).total_cmp(&(b.0.1 + b.1.1)))?;
    let ((a, _), (b, _)) = longest;
    let at = |index: u32| points[index as usize];
    let line = (at(b) - at(a)).try_normalize()?;
    let (c, off_line) = most(&|point| (point - at(a)).cross(line).length())?;
    if off_line <= CLEAR * tolerance {
        return None;
    }
    let normal = line.cross(at(c) - at(a)).try_normalize()?;
    let (d, off_plane) = most(&|point| (point - at(a)).dot(normal).abs())?;
    if off_plane <= CLEAR * tolerance {
        return None;
    }
    let is_behind = (at(d) - at(a)).dot(normal) < 0.0;
    Some(if is_behind {
        [a, b, c, d]
    } else {
        [b, a, c, d]
    })
}

struct Hull<'a> {
    surface: Surface<'a>,
    /// The points that are outside of each face, and known to it alone.
    outside: Vec<Vec<u32>>,
    /// Faces that have, or had, points outside. The first ones are the largest, more or less.
    waiting: VecDeque<u32>,
    tolerance: f64,
}

impl Hull<'_> {
    /// Gives points to the faces that they are farthest outside of. The others are inside.
    fn share_out(&mut self, points: impl IntoIterator<Item = u32>, faces: &[u32]) {
        for point in points {
            let (mut farthest, mut most) = (None, self.tolerance);
            for face in faces {
                let height = self.surface.height(*face, point);
                if height > most {
                    (farthest, most) = (Some(*face), height);
                }
            }
            if let Some(face) = farthest {
                self.give(face, point);
            }
        }
    }

    fn give(&mut self, face: u32, point: u32) {
        let outside = &mut self.outside[face as usize];
        if outside.is_empty() {
            self.waiting.push_back(face);
        }
        outside.push(point);
    }

    /// Makes the point that is farthest outside of a face a corner of the hull.
    fn raise(&mut self, face: u32) -> Result<(), Broken> {
        if !self.surface.is_alive(face) {
            return Ok(());
        }
        let heights = self.outside[face as usize].iter().map(|point| {
            let height = self.surface.height(face, *point);
            (*point, height)
        });
        let farthest = heights.max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((eye, height)) = farthest else {
            return Ok(());
        };
        if height <= self.tolerance {
            // The face has been tilted by merging: it may be that others have to take them.
            let points = std::mem::take(&mut self.outside[face as usize]);
            let beside = self.surface.beside(face);
            self.share_out(points, &beside);
            return Ok(());
        }
        let mut orphans = Vec::new();
        let horizon = self.surface.horizon(face, eye, self.tolerance);
        for face in &horizon.seen {
            orphans.append(&mut self.outside[*face as usize]);
        }
        let new = self.surface.fan(eye, &horizon.sides)?;
        self.outside.resize(self.surface.face_count(), Vec::new());

        // The smaller of two faces may be too small to have a plane of its own: at first, that of
        // the larger decides, and then both.
        let mut doubtful = Vec::new();
        for face in &new {
            let mut is_doubtful = false;
            while self.surface.is_alive(*face)
                && self.merge_one(*face, true, &mut is_doubtful, &mut orphans)?
            {
                is_doubtful = false;
            }
            if is_doubtful {
                doubtful.push(*face);
            }
        }
        for face in doubtful {
            while self.surface.is_alive(face)
                && self.merge_one(face, false, &mut false, &mut orphans)?
            {}
        }
        let mut alive = new;
        alive.retain(|face| self.surface.is_alive(*face));
        orphans.retain(|point| *point != eye);
        self.share_out(orphans, &alive);
        Ok(())
    }

    /// Merges a face with the first of those beside it against which it is not convex. Tells whether
    /// there was one. If the larger one is asked alone, `is_doubtful` is set where the smaller one
    /// would have said so.
    fn merge_one(
        &mut self,
        face: u32,
        larger_alone: bool,
        is_doubtful: &mut bool,
        orphans: &mut Vec<u32>,
    ) -> Result<bool, Broken> {
        let sides: Vec<u32> = self.surface.sides(face).collect();
        for side in sides {
            let other = self.surface.across(side);
            let reaches = |of: u32, over: u32| self.surface.reach(of, over) > -self.tolerance;
            let is_larger = self.surface.area(face) > self.surface.area(other);
            let (large, small) = if is_larger {
                (face, other)
            } else {
                (other, face)
            };
            let by_large = reaches(small, large);
            let by_small = reaches(large, small);
            if by_large || (by_small && !larger_alone) {
                for gone in self.surface.merge(side)? {
                    let points = std::mem::take(&mut self.outside[gone as usize]);
                    for point in points {
                        if self.surface.height(face, point) > self.tolerance {
                            self.give(face, point);
                        } else {
                            orphans.push(point);
                        }
                    }
                }
                return Ok(true);
            }
            *is_doubtful |= by_small;
        }
        Ok(false)
    }
}
