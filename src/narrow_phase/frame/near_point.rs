//! Which polygon of a mesh is closest to a point: by its tree.
//!
//! Triangles are looked at for nothing but their distance; where on it the point is closest is asked
//! of the closest alone. In the space of the mesh, where all axes have one scale, those of a block of
//! the tree are looked at side by side; in the frame, one by one.

use std::ops::ControlFlow;

use bevy::math::{Mat3A, Vec3, Vec3A};
use fearless_simd::{f32x8, prelude::*};

use super::closest;
use super::near_triangles::squared_distances;
use super::placing::Placing;
use super::surface::{ClosestPoint, Surface};
use crate::broad_phase::{BLOCK_WIDTH, ScaledDistance, TriangleBlock, Visit};
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// A mesh at a scale between its inverse and this is looked at in its own space, where no number is
/// so large or so small that its powers are lost.
const MOST_SCALE: f32 = 128.0;

impl Surface {
    /// The point of the mesh, all of it, that is closest to a point of the frame, of those within
    /// `limit`. What is selected counts for meshes without a tree alone: it has to be everything.
    pub fn closest_of_all(
        &mut self,
        mesh: &PolygonMesh,
        point: Vec3A,
        limit: f32,
    ) -> Option<ClosestPoint> {
        if mesh.tree().is_none() {
            return self
                .closest_point(point)
                .filter(|found| found.distance <= limit);
        }
        let (squared, polygon) = self.search_near(mesh, point, limit * limit, false)?;
        let placing = self.placing();
        let (point, normal) = match *mesh.polygon(polygon as usize) {
            [a, b, c] => {
                let corners = [a, b, c].map(|v| placing.place(mesh.vertices()[v as usize]));
                let normal = placing.normal(mesh.normals()[polygon as usize]);
                (closest::point_triangle(point, corners), normal)
            }
            _ => {
                self.select(mesh, polygon, 0.0);
                let face = &self.faces[0];
                (self.closest_point_of(face, point)?, face.normal)
            }
        };
        Some(ClosestPoint {
            point,
            distance: squared.sqrt(),
            normal,
            polygon,
        })
    }

    /// Returns `true` if a point of the frame is as near to the mesh as `limit`. As for
    /// [`closest_of_all`](Self::closest_of_all).
    pub fn is_near(&mut self, mesh: &PolygonMesh, point: Vec3A, limit: f32) -> bool {
        if mesh.tree().is_none() {
            return self
                .closest_point(point)
                .is_some_and(|found| found.distance <= limit);
        }
        self.search_near(mesh, point, limit * limit, true).is_some()
    }

    /// The square of the distance of the closest polygon, and its number, if it is no further from
    /// a point of the frame than the root of `most`; of any that is so near, if it is `any`.
    fn search_near(
        &mut self,
        mesh: &PolygonMesh,
        point: Vec3A,
        most: f32,
        any: bool,
    ) -> Option<(f32, u32)> {
        let tree = mesh.tree()?;
        let placing = *self.placing();
        let (at, around) = placing.near(point);
        let is_usual = |scale: &f32| (MOST_SCALE.recip()..=MOST_SCALE).contains(scale);
        let found = if let Some(scale) = placing.uniform_scale().filter(is_usual) {
            // What is closest in the space of the mesh is so here.
            let square = scale * scale;
            let measure = ScaledDistance::unscaled(around);
            let most = most / square;
            let (best, polygon) = if let Some(blocks) = tree.triangles() {
                let mut nearest = NearestOfBlocks {
                    blocks,
                    polygons: tree.in_order(),
                    from: at,
                    best: most,
                    polygon: NONE,
                    any,
                };
                tree.search_with(&measure, most, &mut nearest);
                (nearest.best, nearest.polygon)
            } else {
                let near = InMesh(mesh.vertices());
                let mut nearest = Nearest::new(self, mesh, near, [at, point], most, any);
                nearest.square = square;
                tree.search_with(&measure, most, &mut nearest);
                (nearest.best, nearest.polygon)
            };
            (best * square, polygon)
        } else {
            let near = InFrame::new(mesh.vertices(), &placing);
            let mut nearest = Nearest::new(self, mesh, near, [point; 2], most, any);
            let measure = ScaledDistance::new(around, placing.scale());
            tree.search_with(&measure, most, &mut nearest);
            (nearest.best, nearest.polygon)
        };
        (found.1 != NONE).then_some(found)
    }
}

/// No polygon.
const NONE: u32 = u32::MAX;

/// Where vertices are looked at.
trait Corners {
    fn at(&self, vertex: u32) -> Vec3A;
}

/// In the space of the mesh.
struct InMesh<'a>(&'a [Vec3]);

impl Corners for InMesh<'_> {
    #[inline(always)]
    fn at(&self, vertex: u32) -> Vec3A {
        self.0[vertex as usize].into()
    }
}

/// In the frame.
struct InFrame<'a> {
    vertices: &'a [Vec3],
    linear: Mat3A,
    from: Vec3A,
    to: Vec3A,
}

impl<'a> InFrame<'a> {
    fn new(vertices: &'a [Vec3], placing: &Placing) -> Self {
        let (linear, from, to) = placing.linear();
        Self {
            vertices,
            linear,
            from,
            to,
        }
    }
}

impl Corners for InFrame<'_> {
    #[inline(always)]
    fn at(&self, vertex: u32) -> Vec3A {
        let vertex = Vec3A::from(self.vertices[vertex as usize]);
        self.to + self.linear * (vertex - self.from)
    }
}

/// The polygon that is closest to a point, so far.
struct Nearest<'a, C> {
    surface: &'a mut Surface,
    mesh: &'a PolygonMesh,
    triangles: Option<&'a [[u32; 3]]>,
    corners: C,
    /// The point, where corners are looked at and in the frame.
    from: Vec3A,
    point: Vec3A,
    /// What makes squares of distances in the frame of those where corners are looked at.
    square: f32,
    /// No further than this, and there the first in the order of the mesh.
    best: f32,
    polygon: u32,
    /// Is it enough to know of one?
    any: bool,
}

impl<'a, C: Corners> Nearest<'a, C> {
    fn new(
        surface: &'a mut Surface,
        mesh: &'a PolygonMesh,
        corners: C,
        [from, point]: [Vec3A; 2],
        most: f32,
        any: bool,
    ) -> Self {
        Self {
            surface,
            mesh,
            triangles: mesh.triangles(),
            corners,
            from,
            point,
            square: 1.0,
            best: most,
            polygon: NONE,
            any,
        }
    }

    /// How far a triangle is, squared.
    #[inline(always)]
    fn of_triangle(&self, corners: [u32; 3]) -> f32 {
        let corners = corners.map(|vertex| self.corners.at(vertex));
        closest::point_triangle_squared(self.from, corners)
    }

    /// How far a polygon of a mesh is that does not consist of triangles alone.
    #[inline(never)]
    fn of_polygon(&mut self, polygon: u32) -> f32 {
        if let &[a, b, c] = self.mesh.polygon(polygon as usize) {
            return self.of_triangle([a, b, c]);
        }
        let (surface, point) = (&mut *self.surface, self.point);
        surface.select(self.mesh, polygon, 0.0);
        surface
            .closest_point_of(&surface.faces[0], point)
            .map_or(f32::INFINITY, |closest| {
                closest.distance_squared(point) / self.square
            })
    }
}

impl<C: Corners> Visit for Nearest<'_, C> {
    #[inline(always)]
    fn visit(&mut self, polygon: u32, _: f32) -> ControlFlow<(), f32> {
        let squared = match self.triangles {
            Some(triangles) => self.of_triangle(triangles[polygon as usize]),
            None => self.of_polygon(polygon),
        };
        // Of several that are as close, the first in the order of the mesh.
        let is_first = squared < self.best || (squared == self.best && polygon < self.polygon);
        if is_first {
            (self.best, self.polygon) = (squared, polygon);
            if self.any {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(self.best)
    }
}

/// The triangle that is closest to a point, so far: eight at a time, in the space of the mesh.
struct NearestOfBlocks<'a> {
    blocks: &'a [TriangleBlock],
    /// Their numbers in the mesh.
    polygons: &'a [u32],
    from: Vec3A,
    /// As for one by one.
    best: f32,
    polygon: u32,
    any: bool,
}

impl Visit for NearestOfBlocks<'_> {
    const BLOCKS: bool = true;

    #[inline(always)]
    fn visit(&mut self, _: u32, _: f32) -> ControlFlow<(), f32> {
        ControlFlow::Continue(self.best)
    }

    #[inline(always)]
    fn visit_block<S: Simd>(&mut self, simd: S, block: u32) -> ControlFlow<(), f32> {
        let triangles = &self.blocks[block as usize];
        let Some(squared) = squared_distances(simd, triangles, self.from, self.best) else {
            return ControlFlow::Continue(self.best);
        };
        let least = squared.reduce_min();
        if least <= self.best {
            let nearest = squared.simd_le(f32x8::splat(simd, least)).to_bitmask();
            let first = block as usize * BLOCK_WIDTH;
            let lanes = self.polygons[first..].iter().take(BLOCK_WIDTH).enumerate();
            // Of several that are as close, the first in the order of the mesh.
            let polygon = lanes
                .filter(|(lane, _)| nearest >> lane & 1 != 0)
                .fold(NONE, |first, (_, polygon)| first.min(*polygon));
            if least < self.best || polygon < self.polygon {
                (self.best, self.polygon) = (least, polygon);
                if self.any {
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(self.best)
    }
}
