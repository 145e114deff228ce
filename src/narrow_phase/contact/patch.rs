//! Where two shapes lie on each other: a face of one, cut to what is over a face of the other
//! (Sutherland and Hodgman, *Reentrant Polygon Clipping*, 1974).

use bevy::math::Vec3A;

use crate::narrow_phase::frame::surface::border;

/// A point at which two overlap, halfway between the two, and how deep.
#[derive(Clone, Copy, Debug)]
pub struct PatchPoint {
    pub point: Vec3A,
    pub depth: f32,
}

/// All that two shapes share along a normal, piece by piece.
#[derive(Clone, Debug, Default)]
pub struct Patch {
    pub points: Vec<PatchPoint>,
    /// The sum of the middles of all pieces, by area, and that of the areas.
    weighted: Vec3A,
    area: f32,
    /// What is being cut, and room for it.
    pub piece: Vec<Vec3A>,
    spare: Vec<Vec3A>,
}

impl Patch {
    pub fn clear(&mut self) {
        self.points.clear();
        self.weighted = Vec3A::ZERO;
        self.area = 0.0;
    }

    /// Cuts the piece to what is below a plane.
    pub fn cut(&mut self, normal: Vec3A, plane: f32) {
        self.cut_by(|point| point.dot(normal) - plane);
    }

    /// Cuts the piece to where a height, which is linear, is not above zero.
    fn cut_by(&mut self, height: impl Fn(Vec3A) -> f32) {
        let Self { piece, spare, .. } = self;
        if piece.iter().all(|point| height(*point) <= 0.0) {
            return;
        }
        spare.clear();
        for [from, to] in border(piece) {
            let [at_from, at_to] = [height(from), height(to)];
            if at_from <= 0.0 {
                spare.push(from);
            }
            if (at_from < 0.0 && at_to > 0.0) || (at_from > 0.0 && at_to < 0.0) {
                spare.push(from.lerp(to, at_from / (at_from - at_to)));
            }
        }
        std::mem::swap(piece, spare);
    }

    /// Cuts the piece to what is over a polygon along an axis; over its hull, if it is not convex.
    pub fn cut_to(&mut self, corners: &[Vec3A], axis: Vec3A) {
        let middle = corners.iter().sum::<Vec3A>() / corners.len() as f32;
        for [from, to] in border(corners) {
            let across = (to - from).cross(axis);
            let outwards = across * 1f32.copysign(across.dot(from - middle));
            let plane = from.dot(outwards);
            let slack = 1e-4 * (middle.dot(outwards) - plane).abs();
            if corners.iter().all(|c| c.dot(outwards) <= plane + slack) {
                self.cut(outwards, plane);
            }
        }
    }

    /// Takes the piece up, or what of it is below the other shape's surface, to within a tolerance:
    /// it is as deep as `depth` says, against `axis`.
    pub fn add(&mut self, axis: Vec3A, tolerance: f32, depth: impl Fn(Vec3A) -> f32) {
        self.add_up_to(f32::INFINITY, axis, tolerance, depth);
    }

    /// The same, with nothing deeper than `most`.
    pub fn add_up_to(
        &mut self,
        most: f32,
        axis: Vec3A,
        tolerance: f32,
        depth: impl Fn(Vec3A) -> f32,
    ) {
        let halfway = |point: Vec3A| {
            let depth = depth(point).min(most);
            PatchPoint {
                point: point + axis * (depth * 0.5),
                depth: depth.max(0.0),
            }
        };
        let piece = &self.piece;
        let deep = piece.iter().filter(|point| depth(**point) >= -tolerance);
        self.points.extend(deep.map(|point| halfway(*point)));
        // The area is that of all that is below, up to where it comes out.
        self.cut_by(|point| -tolerance - depth(point));
        let Some(first) = self.piece.first() else {
            return;
        };
        for pair in self.piece[1..].windows(2) {
            let area = (pair[0] - first).cross(pair[1] - first).dot(axis).abs();
            let corners = [*first, pair[0], pair[1]].map(|corner| halfway(corner).point);
            self.weighted += (corners[0] + corners[1] + corners[2]) * (area / 3.0);
            self.area += area;
        }
    }

    /// Takes up a single point.
    pub fn add_point(&mut self, point: Vec3A, depth: f32) {
        let depth = depth.max(0.0);
        self.points.push(PatchPoint { point, depth });
    }

    /// The middle of all pieces: by area, or, if they have next to none, of their corners.
    pub fn middle(&self, size: f32) -> Option<Vec3A> {
        if self.area > 1e-6 * size * size {
            return Some(self.weighted / self.area);
        }
        let sum: Vec3A = self.points.iter().map(|point| point.point).sum();
        (!self.points.is_empty()).then(|| sum / self.points.len() as f32)
    }
}
