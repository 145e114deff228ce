//! The closest points of two shapes made of polygons.

use std::ops::ControlFlow;

use bevy::math::Vec3A;

use crate::narrow_phase::frame::{
    closest,
    cuboid_mesh::{CuboidMesh, Found},
    cuboid_triangle, edge_polygon,
    near_faces::{Within, for_each_near},
    placed::PlacedPair,
    surface::{Surface, covers},
    workspace::Workspace,
};
use crate::narrow_phase::mesh::{cube::CUBE, polygon_mesh::PolygonMesh};

/// The closest pair of points so far.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    pub points: [Vec3A; 2],
    squared: f32,
}

impl Default for Nearest {
    fn default() -> Self {
        Self {
            points: [Vec3A::NAN; 2],
            squared: f32::INFINITY,
        }
    }
}

impl Nearest {
    /// Takes up a pair of points if it is the closest so far.
    #[inline]
    pub fn consider(&mut self, points: [Vec3A; 2]) {
        let squared = points[0].distance_squared(points[1]);
        if squared < self.squared {
            *self = Self { points, squared };
        }
    }

    /// What is further away than that need not be looked at: nothing at all, if the two meet.
    fn go_on(&self) -> ControlFlow<(), f32> {
        if self.squared > 0.0 {
            ControlFlow::Continue(self.squared)
        } else {
            ControlFlow::Break(())
        }
    }

    /// Takes up the closest points of what is selected of two surfaces.
    fn surfaces(&mut self, a: &Surface, b: &Surface) {
        edges_to_faces(a, b, self, |on_edge, on_face| [on_edge, on_face]);
        edges_to_faces(b, a, self, |on_edge, on_face| [on_face, on_edge]);
        for edge in &a.edges {
            for other in &b.edges {
                if edge.bounds.gap_squared(&other.bounds) < self.squared {
                    self.consider(closest::segments(edge.ends, other.ends).into());
                }
            }
        }
    }
}

/// The closest points of two shapes made of polygons: the same one twice, if they overlap. `None`
/// if one is not.
///
/// Where no edge crosses a polygon, either one of the closest points is a corner, or both are on
/// edges.
pub fn closest_points(pair: &PlacedPair, workspace: &mut Workspace) -> Option<[Vec3A; 2]> {
    if let Some(both) = CuboidMesh::of(pair) {
        return of_cuboid(&both, pair, workspace);
    }
    let (mut nearest, mut limit) = (Nearest::default(), f32::INFINITY);
    let meshes = for_each_near(&Within, pair, workspace, limit, |[a, b]| {
        if a.faces.len().min(b.faces.len()) > 1 && limit == f32::INFINITY {
            // Back and forth: what is further away than that need not be looked at.
            let seed = seed(a, b, pair.box_a.center);
            seed.into_iter().for_each(|points| nearest.consider(points));
        }
        nearest.surfaces(a, b);
        limit = nearest.squared;
        nearest.go_on()
    })?;
    Some(nearest.or_nested(pair, meshes, workspace))
}

impl Nearest {
    /// The closest points of two whose surfaces have been looked at: the same one twice, if one is
    /// inside the other.
    fn or_nested(
        self,
        pair: &PlacedPair,
        meshes: [&PolygonMesh; 2],
        workspace: &Workspace,
    ) -> [Vec3A; 2] {
        let nested = || edge_polygon::nested(pair, meshes, workspace);
        let touch = self.squared == 0.0;
        match if touch { None } else { nested() } {
            Some(point) => [point; 2],
            None => self.points,
        }
    }
}

/// Those of a cuboid and a mesh with a tree.
fn of_cuboid(
    both: &CuboidMesh,
    pair: &PlacedPair,
    workspace: &mut Workspace,
) -> Option<[Vec3A; 2]> {
    edge_polygon::place_both(pair, &mut workspace.surfaces);
    let mut nearest = Nearest::default();
    let half = both.half();
    both.for_each(&Within, f32::INFINITY, |found| {
        match found {
            Found::Triangle(corners) => {
                if let Some(([on_cuboid, on_mesh], _)) =
                    cuboid_triangle::closest(half, corners, nearest.squared)
                {
                    nearest.consider(both.in_order(on_cuboid, on_mesh).map(|p| both.to_frame(p)));
                }
            }
            Found::Polygon(polygon) => {
                let surfaces = &mut workspace.surfaces;
                edge_polygon::select_polygon(both, polygon, pair.tolerance, surfaces);
                let [a, b] = surfaces;
                nearest.surfaces(a, b);
            }
        }
        nearest.go_on()
    });
    let meshes = both.in_order(&*CUBE, both.mesh);
    Some(nearest.or_nested(pair, meshes, workspace))
}

/// Two points that are not far from each other, as a start.
fn seed(a: &Surface, b: &Surface, near: Vec3A) -> Option<[Vec3A; 2]> {
    let on_b = b.closest_point(near)?.point;
    let on_a = a.closest_point(on_b)?.point;
    Some([on_a, b.closest_point(on_a)?.point])
}

/// Where edges cross polygons, and the distances of their ends from these.
fn edges_to_faces(
    edges: &Surface,
    faces: &Surface,
    nearest: &mut Nearest,
    in_order: impl Fn(Vec3A, Vec3A) -> [Vec3A; 2],
) {
    for edge in &edges.edges {
        // A polygon without a normal is no more than its border.
        for face in faces.faces.iter().filter(|face| face.normal != Vec3A::ZERO) {
            if edge.bounds.gap_squared(&face.bounds) >= nearest.squared {
                continue;
            }
            let corners = faces.corners(face);
            let heights = edge.ends.map(|end| end.dot(face.normal) - face.plane);
            if heights[0] * heights[1] < 0.0 {
                let crossing =
                    edge.ends[0].lerp(edge.ends[1], heights[0] / (heights[0] - heights[1]));
                if covers(corners, face.normal, crossing) {
                    nearest.consider([crossing; 2]);
                }
            }
            for (end, height) in edge.ends.into_iter().zip(heights) {
                let below = end - face.normal * height;
                if height * height < nearest.squared && covers(corners, face.normal, below) {
                    nearest.consider(in_order(end, below));
                }
            }
        }
    }
}
