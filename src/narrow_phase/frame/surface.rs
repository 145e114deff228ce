//! A polygon mesh put in place: what the last stage computes with.

use bevy::math::{DVec3, Mat3A, Vec3, Vec3A, bounding::Aabb3d};

use super::closest;
use super::oriented_box::OrientedBox;
use super::placed::Placed;
use crate::narrow_phase::{length::unit, mesh::polygon_mesh::PolygonMesh};

/// A box along the axes of the frame of a pair, by its corners. May be empty.
#[derive(Clone, Copy, Debug)]
pub struct LocalAabb {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl LocalAabb {
    pub const EVERYWHERE: Self = Self {
        min: Vec3A::NEG_INFINITY,
        max: Vec3A::INFINITY,
    };
    pub const NOWHERE: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    /// Returns `true` if nothing is outside.
    pub fn is_everywhere(&self) -> bool {
        self.min == Self::EVERYWHERE.min && self.max == Self::EVERYWHERE.max
    }

    /// What two boxes share, given by centre and half extents, grown by `margin`. May be empty.
    pub fn shared(a: (Vec3A, Vec3A), b: (Vec3A, Vec3A), margin: f32) -> Self {
        Self {
            min: (a.0 - a.1).max(b.0 - b.1) - margin,
            max: (a.0 + a.1).min(b.0 + b.1) + margin,
        }
    }

    /// The smallest box around points, grown by `margin`.
    fn around(points: impl Iterator<Item = Vec3A>, margin: f32) -> Self {
        let (mut min, mut max) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for point in points {
            min = min.min(point);
            max = max.max(point);
        }
        let (min, max) = (min - margin, max + margin);
        Self { min, max }
    }

    #[inline]
    fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The square of the distance of the two.
    #[inline]
    pub fn gap_squared(&self, other: &Self) -> f32 {
        (self.min - other.max)
            .max(other.min - self.max)
            .max(Vec3A::ZERO)
            .length_squared()
    }
}

/// An edge in place, grown by the tolerance in `bounds`.
#[derive(Clone, Copy, Debug)]
pub struct PlacedEdge {
    pub ends: [Vec3A; 2],
    pub bounds: LocalAabb,
}

/// A polygon in place.
#[derive(Clone, Copy, Debug)]
pub struct PlacedFace {
    pub polygon: u32,
    /// Where its corners begin and end among those of the surface.
    corners: [u32; 2],
    /// A unit vector; zero for a polygon that a scale of zero flattened to a segment or point,
    /// which its border is enough to describe.
    pub normal: Vec3A,
    /// The corners lie between `plane - thickness` and `plane + thickness` along the normal.
    pub plane: f32,
    thickness: f32,
    pub bounds: LocalAabb,
}

/// The point of a surface that is closest to another point.
#[derive(Clone, Copy, Debug)]
pub struct ClosestPoint {
    pub point: Vec3A,
    pub distance: f32,
    /// That of the face, or of one of the faces, that it is on.
    pub normal: Vec3A,
}

/// A mesh in place: the edges and polygons within a region.
///
/// Filled anew for each pair; the buffers stay.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    placing: Placing,
    /// The corners of the faces, one face after the other, those that were dropped included.
    corners: Vec<Vec3A>,
    pub edges: Vec<PlacedEdge>,
    pub faces: Vec<PlacedFace>,
    /// All vertices in place, where all polygons are looked at.
    vertices: Vec<Vec3A>,
    /// What of the mesh is in the region, by index.
    polygons: Vec<u32>,
    sides: Vec<[u32; 2]>,
}

/// How a mesh gets from its own space to the frame of a pair.
#[derive(Clone, Copy, Debug, Default)]
struct Placing {
    axes: Mat3A,
    center: Vec3A,
    scale: Vec3A,
    /// The centre of the mesh, in its own space.
    middle: Vec3A,
}

impl Placing {
    #[inline]
    fn place(&self, vertex: Vec3) -> Vec3A {
        self.center + self.axes * ((Vec3A::from(vertex) - self.middle) * self.scale)
    }

    /// Normals scale with the cofactors, that is inversely, but without dividing by zero. A mirror
    /// would turn them inside out.
    fn normal(&self, normal: Vec3) -> Vec3A {
        let largest = self.scale.abs().max_element();
        let relative = if largest > 0.0 {
            self.scale / largest
        } else {
            self.scale
        };
        let cofactors = Vec3A::new(
            relative.y * relative.z,
            relative.z * relative.x,
            relative.x * relative.y,
        );
        let mirror = 1f32.copysign(self.scale.x * self.scale.y * self.scale.z);
        self.axes * unit_or_zero(Vec3A::from(normal) * cofactors * mirror)
    }

    /// A box in the space of the mesh, around all that is in a region of the frame: a little larger
    /// than it has to be.
    fn back(&self, region: &LocalAabb) -> Aabb3d {
        let (center, half) = (
            (region.min + region.max) * 0.5,
            (region.max - region.min) * 0.5,
        );
        let inverse = self.axes.transpose();
        let from_center = inverse * (center - self.center);
        let reach = self.axes.abs().transpose() * half;
        let rounding = 8.0 * f32::EPSILON * (center.abs() + self.center.abs() + half).element_sum();
        // Along an axis of no scale, everything is in the region, or nothing.
        let scale = self.scale.abs();
        let grow = (reach + rounding) / scale;
        let at = from_center / self.scale;
        let (low, high) = (self.middle + at - grow, self.middle + at + grow);
        let wide = 8.0 * f32::EPSILON * (self.middle.abs() + low.abs() + high.abs());
        let known = low.is_finite_mask() & high.is_finite_mask();
        Aabb3d {
            min: Vec3A::select(known, low - wide, Vec3A::MIN),
            max: Vec3A::select(known, high + wide, Vec3A::MAX),
        }
    }

    /// The way of a box through the space of the mesh: where it begins, how it moves, and how far it
    /// reaches, a little more than it does.
    fn way_back(&self, origin: Vec3A, direction: Vec3A, reach: Vec3A) -> (Vec3A, Vec3A, Vec3A) {
        // A scale of zero makes all of its axis one point, which is met there, or never.
        let least = f32::MIN_POSITIVE.max(1e-7 * self.scale.abs().max_element());
        let scale = Vec3A::select(
            self.scale.abs().cmplt(Vec3A::splat(least)),
            Vec3A::splat(least),
            self.scale,
        );
        let inverse = self.axes.transpose();
        let start = inverse * (origin - self.center) / scale + self.middle;
        let around = self.axes.abs().transpose() * reach;
        let rounding = 16.0
            * f32::EPSILON
            * ((origin - self.center).abs().max_element() + around.max_element());
        let grown = (around + rounding) / scale.abs()
            + 8.0 * f32::EPSILON * (self.middle.abs() + start.abs());
        (start, inverse * direction / scale, grown)
    }

    /// A point of the frame in the space of the mesh; `None` where a scale of zero has no way back.
    fn point_back(&self, point: Vec3A) -> Option<DVec3> {
        let inverse = self.axes.transpose();
        let from_center = inverse.as_dmat3() * (point.as_dvec3() - self.center.as_dvec3());
        let local = from_center / self.scale.as_dvec3() + self.middle.as_dvec3();
        local.is_finite().then_some(local)
    }
}

impl Surface {
    /// Puts the polygons of a shape where its box is, and selects what is in `region`.
    ///
    /// A mesh with a tree is looked at where the region is, and nowhere else.
    pub fn fill(
        &mut self,
        (mesh, size): (&PolygonMesh, Vec3A),
        placed: Placed,
        bounds: &OrientedBox,
        region: &LocalAabb,
        tolerance: f32,
    ) {
        let scale = placed.shape.effective_scale(placed.transform.scale) * size;
        let axes = bounds.axes;
        let (middle, ..) = mesh.local_bounds();
        self.placing = Placing {
            axes,
            center: bounds.center,
            scale,
            middle,
        };
        let placing = self.placing;

        self.polygons.clear();
        self.sides.clear();
        self.vertices.clear();
        let tree = mesh.tree().filter(|_| !region.is_everywhere());
        if let Some(tree) = tree {
            // An edge in the region is grown by the tolerance.
            let grown = LocalAabb {
                min: region.min - tolerance,
                max: region.max + tolerance,
            };
            if grown.min.cmple(grown.max).all() {
                tree.for_each_overlapping(&placing.back(&grown), |polygon| {
                    self.polygons.push(polygon)
                });
            }
            // In the order of the mesh, whatever that of the tree.
            self.polygons.sort_unstable();
            for &polygon in &self.polygons {
                let corners = mesh.polygon(polygon as usize);
                let sides = corners.iter().zip(corners.iter().cycle().skip(1));
                for (&other, (from, to)) in mesh.across(polygon as usize).iter().zip(sides) {
                    // Of two that share a side, the first has it.
                    if other > polygon || self.polygons.binary_search(&other).is_err() {
                        self.sides.push([*from, *to]);
                    }
                }
            }
        } else {
            self.polygons.extend(0..mesh.polygon_count() as u32);
            self.sides.extend_from_slice(mesh.edges());
            self.vertices
                .extend(mesh.vertices().iter().map(|vertex| placing.place(*vertex)));
        }
        let vertices = &self.vertices;
        let at = |vertex: u32| match vertices.get(vertex as usize) {
            Some(placed) => *placed,
            None => placing.place(mesh.vertices()[vertex as usize]),
        };

        self.edges.clear();
        for side in &self.sides {
            let ends = side.map(at);
            let edge = PlacedEdge {
                ends,
                bounds: LocalAabb::around(ends.into_iter(), tolerance),
            };
            if edge.bounds.overlaps(region) {
                self.edges.push(edge);
            }
        }

        self.faces.clear();
        self.corners.clear();
        for index in 0..self.polygons.len() {
            let polygon = self.polygons[index];
            let start = self.corners.len();
            let corners = mesh.polygon(polygon as usize).iter();
            let vertices = &self.vertices;
            self.corners
                .extend(corners.map(|&vertex| match vertices.get(vertex as usize) {
                    Some(placed) => *placed,
                    None => placing.place(mesh.vertices()[vertex as usize]),
                }));
            let bounds = LocalAabb::around(self.corners[start..].iter().copied(), 0.0);
            if bounds.overlaps(region) {
                let face = self.face(mesh, polygon, start, bounds);
                self.faces.push(face);
            } else {
                self.corners.truncate(start);
            }
        }
    }

    /// A polygon in place, of which the corners have been from `start` on.
    fn face(
        &self,
        mesh: &PolygonMesh,
        polygon: u32,
        start: usize,
        bounds: LocalAabb,
    ) -> PlacedFace {
        let corners = &self.corners[start..];
        let normal = self.placing.normal(mesh.normals()[polygon as usize]);
        let heights = corners.iter().map(|corner| corner.dot(normal));
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        PlacedFace {
            polygon,
            corners: [start as u32, self.corners.len() as u32],
            normal,
            plane: (low + high) * 0.5,
            thickness: (high - low) * 0.5,
            bounds,
        }
    }

    /// Calls `found` with each face that a box on its way may meet, the first ones first; it tells
    /// how far the way goes from then on. For meshes with a tree.
    ///
    /// The box is `reach` around `origin`, and moves by `direction` in each unit of distance.
    pub fn on_the_way(
        &mut self,
        mesh: &PolygonMesh,
        (origin, direction): (Vec3A, Vec3A),
        reach: Vec3A,
        limit: f32,
        mut found: impl FnMut(&Self, &PlacedFace) -> f32,
    ) {
        let Some(tree) = mesh.tree() else {
            debug_assert!(false, "it is looked at polygon by polygon");
            return;
        };
        let (origin, direction, reach) = self.placing.way_back(origin, direction, reach);
        tree.on_the_way((origin, direction), reach, limit, |polygon, _| {
            let face = self.only(mesh, polygon);
            found(self, &face)
        });
    }

    /// Puts a polygon in place, and nothing else.
    fn only(&mut self, mesh: &PolygonMesh, polygon: u32) -> PlacedFace {
        let placing = self.placing;
        let corners = mesh.polygon(polygon as usize).iter();
        self.corners.clear();
        self.corners
            .extend(corners.map(|vertex| placing.place(mesh.vertices()[*vertex as usize])));
        let bounds = LocalAabb::around(self.corners.iter().copied(), 0.0);
        self.face(mesh, polygon, 0, bounds)
    }

    /// The point of the mesh, all of it, that is closest to a point of the frame, of those within
    /// `limit`. The faces are those that were looked at last.
    pub fn closest_of_all(
        &mut self,
        mesh: &PolygonMesh,
        point: Vec3A,
        limit: f32,
    ) -> Option<ClosestPoint> {
        let Some((tree, local)) = mesh.tree().zip(self.placing.point_back(point)) else {
            return self
                .closest_point(point)
                .filter(|found| found.distance <= limit);
        };
        let mut best: Option<(ClosestPoint, u32)> = None;
        tree.near(local.as_vec3a(), self.placing.scale, limit, |polygon, _| {
            let face = self.only(mesh, polygon);
            if let Some(closest) = self.closest_point_of(&face, point) {
                let distance = closest.distance(point);
                // Of several that are as close, the first in the order of the mesh.
                let is_closer =
                    best.is_none_or(|(best, of)| (distance, polygon) < (best.distance, of));
                if is_closer && distance <= limit {
                    let found = ClosestPoint {
                        point: closest,
                        distance,
                        normal: face.normal,
                    };
                    best = Some((found, polygon));
                }
            }
            best.map_or(limit, |(best, _)| best.distance)
        });
        best.map(|(found, _)| found)
    }

    /// Drops the edges and polygons that are not in `region`.
    pub fn keep(&mut self, region: &LocalAabb) {
        self.edges.retain(|edge| edge.bounds.overlaps(region));
        self.faces.retain(|face| face.bounds.overlaps(region));
    }

    /// A vertex of the mesh, in place.
    pub fn vertex(&self, mesh: &PolygonMesh, vertex: u32) -> Vec3A {
        self.placing.place(mesh.vertices()[vertex as usize])
    }

    /// A place in the space of the mesh, in the frame.
    pub fn place(&self, vertex: Vec3) -> Vec3A {
        self.placing.place(vertex)
    }

    /// The same as [`touch`](Self::touch) of a segment.
    pub fn touch_segment(
        &self,
        face: &PlacedFace,
        ends: [Vec3A; 2],
        tolerance: f32,
    ) -> Option<Vec3A> {
        let bounds = LocalAabb::around(ends.into_iter(), tolerance);
        self.touch(face, &PlacedEdge { ends, bounds }, tolerance)
    }

    /// The corners of a face, in place.
    #[inline]
    pub fn corners(&self, face: &PlacedFace) -> &[Vec3A] {
        let [start, end] = face.corners;
        &self.corners[start as usize..end as usize]
    }

    /// A point at which an edge comes as close to a face as the tolerance, if it does: where it
    /// crosses the polygon, where it ends on it, or where it meets the border.
    #[inline]
    pub fn touch(&self, face: &PlacedFace, edge: &PlacedEdge, tolerance: f32) -> Option<Vec3A> {
        if !edge.bounds.overlaps(&face.bounds) {
            return None;
        }
        let corners = self.corners(face);
        let [start, end] = edge.ends;
        if face.normal != Vec3A::ZERO {
            let reach = tolerance + face.thickness;
            let heights = edge.ends.map(|point| point.dot(face.normal) - face.plane);
            let [low, high] = [heights[0].min(heights[1]), heights[0].max(heights[1])];
            if low > reach || high < -reach {
                return None;
            }
            if low < 0.0 && high > 0.0 {
                let crossing = start.lerp(end, heights[0] / (heights[0] - heights[1]));
                if covers(corners, face.normal, crossing) {
                    return Some(crossing);
                }
            }
            for (point, height) in [(start, heights[0]), (end, heights[1])] {
                if height.abs() <= reach && covers(corners, face.normal, point) {
                    return Some(point);
                }
            }
        }
        // Rounding may put a point beside a polygon that it is on, but then the border is this
        // close.
        border(corners).find_map(|border| {
            let (on_edge, on_border) = closest::segments(edge.ends, border);
            let close = on_edge.distance_squared(on_border) <= tolerance * tolerance;
            close.then(|| on_edge.midpoint(on_border))
        })
    }

    /// How far the edges of another surface are beyond those of this one along a unit vector;
    /// negative if they overlap.
    pub fn gap(&self, other: &Self, axis: Vec3A) -> f32 {
        let furthest = |surface: &Self, axis: Vec3A| {
            let ends = surface.edges.iter().flat_map(|edge| edge.ends);
            ends.fold(f32::NEG_INFINITY, |reach, end| reach.max(end.dot(axis)))
        };
        -furthest(other, -axis) - furthest(self, axis)
    }

    /// The point closest to `point` on the faces selected; `None` if there are none.
    pub fn closest_point(&self, point: Vec3A) -> Option<ClosestPoint> {
        let candidates = self.faces.iter().flat_map(|face| {
            self.closest_points_of(face, point)
                .map(move |closest| ClosestPoint {
                    point: closest,
                    distance: closest.distance(point),
                    normal: face.normal,
                })
        });
        candidates.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// The point closest to `point` on a face.
    pub fn closest_point_of(&self, face: &PlacedFace, point: Vec3A) -> Option<Vec3A> {
        let squared = |closest: &Vec3A| closest.distance_squared(point);
        self.closest_points_of(face, point)
            .min_by(|a, b| squared(a).total_cmp(&squared(b)))
    }

    /// The points of a face of which one is the closest to `point`: one on each side of it, and the
    /// one below.
    fn closest_points_of<'a>(
        &'a self,
        face: &PlacedFace,
        point: Vec3A,
    ) -> impl Iterator<Item = Vec3A> + use<'a> {
        let corners = self.corners(face);
        let projected = point - face.normal * (point.dot(face.normal) - face.plane);
        let within = face.normal != Vec3A::ZERO && covers(corners, face.normal, projected);
        let border = border(corners);
        let on_border = border.map(move |[a, b]| closest::point_segment(point, a, b));
        on_border.chain(within.then_some(projected))
    }

    /// Whether the mesh winds around a point that is not on its surface (closer than rounding).
    pub fn encloses(&self, mesh: &PolygonMesh, point: Vec3A) -> bool {
        if mesh.tree().is_some() {
            let local = self.placing.point_back(point);
            return local.is_some_and(|local| mesh.winds_around(local));
        }
        winds_around(mesh, |vertex| self.vertex(mesh, vertex) - point)
    }
}

/// The sides of a polygon, given by its corners.
#[inline]
pub fn border(corners: &[Vec3A]) -> impl Iterator<Item = [Vec3A; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| [*a, *b])
}

/// Whether a point in the plane of a polygon is inside its border, by the even-odd rule.
#[inline]
pub fn covers(corners: &[Vec3A], normal: Vec3A, point: Vec3A) -> bool {
    // Seen along the axis that shows most of it.
    let (x, y) = match normal.abs().max_position() {
        0 => (1, 2),
        1 => (2, 0),
        _ => (0, 1),
    };
    let mut inside = false;
    for [a, b] in border(corners) {
        if (a[y] > point[y]) != (b[y] > point[y]) {
            let crossing = a[x] + (b[x] - a[x]) * ((point[y] - a[y]) / (b[y] - a[y]));
            inside ^= crossing > point[x];
        }
    }
    inside
}

/// Whether a mesh winds around a point that is not on its surface (closer than rounding), by the
/// ways from there to its vertices.
///
/// Sums the solid angles under which the polygons are seen from the point, by the formula of
/// Van Oosterom and Strackee (1983). No direction is special, and so no ray can graze an edge.
pub fn winds_around(mesh: &PolygonMesh, way_to: impl Fn(u32) -> Vec3A) -> bool {
    if !mesh.is_closed() {
        return false;
    }
    // The angles of a fan of triangles are signed, and add up for polygons that are not convex
    // too.
    let mut half_angles = 0.0;
    for corners in mesh.polygons() {
        let seen = |vertex: u32| unit(way_to(vertex));
        let a = seen(corners[0]);
        for pair in corners[1..].windows(2) {
            let (b, c) = (seen(pair[0]), seen(pair[1]));
            let cosines = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
            half_angles += a.dot(b.cross(c)).atan2(cosines);
        }
    }
    // Once around is 4π, or 2π in half angles.
    f32::abs(half_angles) > std::f32::consts::PI
}

/// The direction of a vector whose length may underflow; zero for zero.
fn unit_or_zero(v: Vec3A) -> Vec3A {
    let largest = v.abs().max_element();
    if largest > f32::MIN_POSITIVE {
        (v / largest).normalize()
    } else {
        Vec3A::ZERO
    }
}
