//! A polygon mesh put in place: what the last stage computes with.

use bevy::math::{Vec3, Vec3A};

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

/// A mesh in place: all of its vertices, and the edges and polygons within a region.
///
/// Filled anew for each pair; the buffers stay.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    vertices: Vec<Vec3A>,
    pub edges: Vec<PlacedEdge>,
    pub faces: Vec<PlacedFace>,
}

impl Surface {
    /// Puts the polygons of a shape where its box is, and selects what is in `region`.
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
        let (center, ..) = mesh.local_bounds();
        let to_frame =
            |vertex: &Vec3| bounds.center + axes * ((Vec3A::from(*vertex) - center) * scale);
        self.vertices.clear();
        self.vertices.extend(mesh.vertices().iter().map(to_frame));
        debug_assert_eq!(
            self.vertices.len(),
            mesh.vertices().len(),
            "indices of the mesh are those of the surface"
        );

        self.edges.clear();
        for edge in mesh.edges() {
            let ends = edge.map(|vertex| self.vertices[vertex as usize]);
            let edge = PlacedEdge {
                ends,
                bounds: LocalAabb::around(ends.into_iter(), tolerance),
            };
            if edge.bounds.overlaps(region) {
                self.edges.push(edge);
            }
        }

        // Normals scale with the cofactors, that is inversely, but without dividing by zero. A
        // mirror would turn them inside out.
        let largest = scale.abs().max_element();
        let relative = if largest > 0.0 {
            scale / largest
        } else {
            scale
        };
        let cofactors = Vec3A::new(
            relative.y * relative.z,
            relative.z * relative.x,
            relative.x * relative.y,
        );
        let mirror = 1f32.copysign(scale.x * scale.y * scale.z);
        self.faces.clear();
        for (polygon, (corners, normal)) in mesh.polygons().zip(mesh.normals()).enumerate() {
            let at = |vertex: &u32| self.vertices[*vertex as usize];
            let bounds = LocalAabb::around(corners.iter().map(at), 0.0);
            if bounds.overlaps(region) {
                let normal = axes * unit_or_zero(Vec3A::from(*normal) * cofactors * mirror);
                let heights = corners.iter().map(|corner| at(corner).dot(normal));
                let (low, high) = heights
                    .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| {
                        (low.min(h), high.max(h))
                    });
                self.faces.push(PlacedFace {
                    polygon: polygon as u32,
                    normal,
                    plane: (low + high) * 0.5,
                    thickness: (high - low) * 0.5,
                    bounds,
                });
            }
        }
    }

    /// Drops the edges and polygons that are not in `region`.
    pub fn keep(&mut self, region: &LocalAabb) {
        self.edges.retain(|edge| edge.bounds.overlaps(region));
        self.faces.retain(|face| face.bounds.overlaps(region));
    }

    /// All vertices, by the indices of the mesh.
    pub fn vertices(&self) -> &[Vec3A] {
        &self.vertices
    }

    /// A point at which an edge comes as close to a face as the tolerance, if it does: where it
    /// crosses the polygon, where it ends on it, or where it meets the border.
    #[inline]
    pub fn touch(
        &self,
        mesh: &PolygonMesh,
        face: &PlacedFace,
        edge: &PlacedEdge,
        tolerance: f32,
    ) -> Option<Vec3A> {
        if !edge.bounds.overlaps(&face.bounds) {
            return None;
        }
        let corners = mesh.polygon(face.polygon as usize);
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
                if self.covers(corners, face.normal, crossing) {
                    return Some(crossing);
                }
            }
            for (point, height) in [(start, heights[0]), (end, heights[1])] {
                if height.abs() <= reach && self.covers(corners, face.normal, point) {
                    return Some(point);
                }
            }
        }
        // Rounding may put a point beside a polygon that it is on, but then the border is this
        // close.
        self.border(corners).find_map(|border| {
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
    pub fn closest_point(&self, mesh: &PolygonMesh, point: Vec3A) -> Option<ClosestPoint> {
        let candidates = self.faces.iter().flat_map(|face| {
            self.closest_points_of(mesh, face, point)
                .map(move |closest| ClosestPoint {
                    point: closest,
                    distance: closest.distance(point),
                    normal: face.normal,
                })
        });
        candidates.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// The point closest to `point` on a face.
    pub fn closest_point_of(
        &self,
        mesh: &PolygonMesh,
        face: &PlacedFace,
        point: Vec3A,
    ) -> Option<Vec3A> {
        let squared = |closest: &Vec3A| closest.distance_squared(point);
        self.closest_points_of(mesh, face, point)
            .min_by(|a, b| squared(a).total_cmp(&squared(b)))
    }

    /// The points of a face of which one is the closest to `point`: one on each side of it, and the
    /// one below.
    fn closest_points_of<'a>(
        &'a self,
        mesh: &'a PolygonMesh,
        face: &PlacedFace,
        point: Vec3A,
    ) -> impl Iterator<Item = Vec3A> + use<'a> {
        let corners = mesh.polygon(face.polygon as usize);
        let projected = point - face.normal * (point.dot(face.normal) - face.plane);
        let within = face.normal != Vec3A::ZERO && self.covers(corners, face.normal, projected);
        let border = self.border(corners);
        let on_border = border.map(move |[a, b]| closest::point_segment(point, a, b));
        on_border.chain(within.then_some(projected))
    }

    /// The corners of a face.
    pub fn corners<'a>(
        &'a self,
        mesh: &'a PolygonMesh,
        face: &PlacedFace,
    ) -> impl Iterator<Item = Vec3A> + Clone + use<'a> {
        mesh.polygon(face.polygon as usize)
            .iter()
            .map(|&vertex| self.vertices[vertex as usize])
    }

    /// Whether the mesh winds around a point that is not on its surface (closer than rounding).
    pub fn encloses(&self, mesh: &PolygonMesh, point: Vec3A) -> bool {
        winds_around(mesh, |vertex| self.vertices[vertex as usize] - point)
    }

    pub fn border(&self, corners: &[u32]) -> impl Iterator<Item = [Vec3A; 2]> {
        let next = corners.iter().cycle().skip(1);
        let at = |vertex: &u32| self.vertices[*vertex as usize];
        corners.iter().zip(next).map(move |(a, b)| [at(a), at(b)])
    }

    /// Whether a point in the plane of a polygon is inside its border, by the even-odd rule.
    #[inline]
    pub fn covers(&self, corners: &[u32], normal: Vec3A, point: Vec3A) -> bool {
        // Seen along the axis that shows most of it.
        let (x, y) = match normal.abs().max_position() {
            0 => (1, 2),
            1 => (2, 0),
            _ => (0, 1),
        };
        let mut inside = false;
        for [a, b] in self.border(corners) {
            if (a[y] > point[y]) != (b[y] > point[y]) {
                let crossing = a[x] + (b[x] - a[x]) * ((point[y] - a[y]) / (b[y] - a[y]));
                inside ^= crossing > point[x];
            }
        }
        inside
    }
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
