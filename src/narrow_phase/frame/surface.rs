//! A polygon mesh put in place: what the last stage computes with.

use bevy::math::{Vec3A, ops};

use super::closest;
use super::local_aabb::LocalAabb;
use super::oriented_box::OrientedBox;
use super::placed::Placed;
use super::placing::Placing;
use crate::narrow_phase::{length::unit, mesh::polygon_mesh::PolygonMesh};

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
    /// The number of that face in the mesh.
    pub polygon: u32,
}

/// A mesh in place: the edges and polygons within a region.
///
/// Filled anew for each pair; the buffers stay.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    placing: Placing,
    /// The polygon that alone is selected.
    only: Option<u32>,
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

impl Surface {
    /// Says where a mesh is, and selects nothing of it.
    pub fn place(&mut self, mesh: (&PolygonMesh, Vec3A), placed: Placed, bounds: &OrientedBox) {
        self.placing = Placing::of(mesh, placed, bounds);
        self.only = None;
        self.polygons.clear();
        self.sides.clear();
        self.vertices.clear();
        self.edges.clear();
        self.faces.clear();
        self.corners.clear();
    }

    /// Where the mesh is.
    pub fn placing(&self) -> &Placing {
        &self.placing
    }

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
        self.place((mesh, size), placed, bounds);
        let placing = self.placing;
        let tree = mesh.tree().filter(|_| !region.is_everywhere());
        if let Some(tree) = tree {
            // An edge in the region is grown by the tolerance.
            let grown = LocalAabb {
                min: region.min - tolerance,
                max: region.max + tolerance,
            };
            if let Some(near) = placing.back(&grown) {
                tree.for_each_overlapping(&near, |polygon| self.polygons.push(polygon));
            }
            // In the order of the mesh, whatever that of the tree.
            self.polygons.sort_unstable();
            for &polygon in &self.polygons {
                for (other, side) in sides(mesh, polygon) {
                    // Of two that share a side, the first has it.
                    if other > polygon || self.polygons.binary_search(&other).is_err() {
                        self.sides.push(side);
                    }
                }
            }
        } else {
            self.list_all(mesh);
        }
        self.take(mesh, region, tolerance);
    }

    /// Lists all polygons and sides, and puts all vertices in place.
    fn list_all(&mut self, mesh: &PolygonMesh) {
        let placing = self.placing;
        self.polygons.extend(0..mesh.polygon_count() as u32);
        self.sides.extend_from_slice(mesh.edges());
        self.vertices
            .extend(mesh.vertices().iter().map(|vertex| placing.place(*vertex)));
    }

    /// Puts in place what of the polygons and sides that are listed is in a region.
    fn take(&mut self, mesh: &PolygonMesh, region: &LocalAabb, tolerance: f32) {
        let placing = self.placing;
        let vertices = &self.vertices;
        let at = |vertex: u32| match vertices.get(vertex as usize) {
            Some(placed) => *placed,
            None => placing.place(mesh.vertices()[vertex as usize]),
        };

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

    /// Selects all of the mesh.
    pub fn select_all(&mut self, mesh: &PolygonMesh, tolerance: f32) {
        self.list_all(mesh);
        self.take(mesh, &LocalAabb::EVERYWHERE, tolerance);
    }

    /// Selects one polygon of the mesh, with its sides.
    pub fn select(&mut self, mesh: &PolygonMesh, polygon: u32, tolerance: f32) {
        if self.only == Some(polygon) {
            return;
        }
        self.only = Some(polygon);
        self.edges.clear();
        self.faces.clear();
        self.corners.clear();
        let (placing, vertices) = (self.placing, mesh.vertices());
        let corners = mesh.polygon(polygon as usize).iter();
        self.corners
            .extend(corners.map(|vertex| placing.place(vertices[*vertex as usize])));
        let edges = border(&self.corners).map(|ends| PlacedEdge {
            ends,
            bounds: LocalAabb::around(ends.into_iter(), tolerance),
        });
        self.edges.extend(edges);
        let bounds = LocalAabb::around(self.corners.iter().copied(), 0.0);
        let face = self.face(mesh, polygon, 0, bounds);
        self.faces.push(face);
    }

    /// A vertex of the mesh, in place.
    pub fn vertex(&self, mesh: &PolygonMesh, vertex: u32) -> Vec3A {
        self.placing.place(mesh.vertices()[vertex as usize])
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

    /// Returns `true` if points are all on one side of the plane of a face, further from it than the
    /// tolerance, so that nothing between them [touches](Self::touch) the face.
    #[inline]
    pub fn is_off_plane(&self, face: &PlacedFace, points: &[Vec3A], tolerance: f32) -> bool {
        let reach = tolerance + face.thickness;
        let heights = points
            .iter()
            .map(|point| point.dot(face.normal) - face.plane);
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        face.normal != Vec3A::ZERO && (low > reach || high < -reach)
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
            if !edge
                .bounds
                .overlaps(&LocalAabb::around(border.into_iter(), 0.0))
            {
                return None;
            }
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
                    polygon: face.polygon,
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

/// The sides of a polygon of a mesh, each with the polygon across it.
fn sides(mesh: &PolygonMesh, polygon: u32) -> impl Iterator<Item = (u32, [u32; 2])> {
    let corners = mesh.polygon(polygon as usize);
    let next = corners.iter().cycle().skip(1);
    let sides = corners.iter().zip(next).map(|(from, to)| [*from, *to]);
    mesh.across(polygon as usize).iter().copied().zip(sides)
}

/// The sides of a polygon, given by its corners.
#[inline]
pub fn border<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 2]> {
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
    if !mesh.has_inside() {
        return false;
    }
    // The angles of a fan of triangles are signed, and add up for polygons that are not convex
    // too.
    let mut half_angles = 0.0;
    mesh.for_each_solid(|corners| {
        let seen = |vertex: u32| unit(way_to(vertex));
        let a = seen(corners[0]);
        for pair in corners[1..].windows(2) {
            let (b, c) = (seen(pair[0]), seen(pair[1]));
            let cosines = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
            half_angles += ops::atan2(a.dot(b.cross(c)), cosines);
        }
    });
    // Once around is 4π, or 2π in half angles.
    f32::abs(half_angles) > std::f32::consts::PI
}
