//! A cuboid against the triangles of a mesh that has a tree, each in the axes of the cuboid.
//!
//! Polygons that are no triangles are looked at as those of any two surfaces.

use std::ops::ControlFlow;

use bevy::math::{Mat3A, Vec3A};

use super::cuboid_triangle as triangle;
use super::near_faces::{Near, around};
use super::oriented_box::OrientedBox;
use super::placed::PlacedPair;
use super::placing::Placing;
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;
use crate::narrow_phase::shape::Shape;

/// A cuboid and a mesh with a tree, in either order.
pub struct CuboidMesh<'a> {
    pub mesh: &'a PolygonMesh,
    /// Is the cuboid the first of the pair?
    pub cuboid_first: bool,
    cuboid: OrientedBox,
    placings: [Placing; 2],
    /// From the space of the mesh into the axes of the cuboid, around its centre.
    linear: Mat3A,
    from: Vec3A,
    to: Vec3A,
}

impl<'a> CuboidMesh<'a> {
    /// `None` if the pair is another one, or the mesh has no tree.
    #[inline]
    pub fn of(pair: &PlacedPair<'a>) -> Option<Self> {
        match (pair.a.shape, pair.b.shape) {
            (Shape::Cuboid { .. }, Shape::Convex(_) | Shape::Mesh(_)) => Self::ordered(pair, true),
            (Shape::Convex(_) | Shape::Mesh(_), Shape::Cuboid { .. }) => {
                Self::ordered(&pair.swapped(), false)
            }
            _ => None,
        }
    }

    /// The cuboid first.
    fn ordered(pair: &PlacedPair<'a>, cuboid_first: bool) -> Option<Self> {
        let polygons = pair.b.shape.polygons()?;
        polygons.0.tree()?;
        let placings = [
            Placing::of(pair.a.shape.polygons()?, pair.a, &pair.box_a),
            Placing::of(polygons, pair.b, &pair.box_b),
        ];
        let (linear, from, to) = placings[1].linear();
        let back = pair.box_a.axes.transpose();
        Some(Self {
            mesh: polygons.0,
            cuboid_first,
            cuboid: pair.box_a,
            placings,
            linear: back * linear,
            from,
            to: back * (to - pair.box_a.center),
        })
    }

    /// Calls `visit` with the triangles, in the axes of the cuboid, and the other polygons that are
    /// near; it tells the limit from then on.
    #[inline]
    pub fn for_each(
        &self,
        near: &impl Near,
        limit: f32,
        mut visit: impl FnMut(Found) -> ControlFlow<(), f32>,
    ) {
        let Some(tree) = self.mesh.tree() else { return };
        let around = around(&self.placings, 0, near.margin());
        let measure = near.measure(&around, &self.placings[1], self.cuboid_first);
        let vertices = self.mesh.vertices();
        let at = |vertex: u32| {
            let vertex = Vec3A::from(vertices[vertex as usize]);
            self.to + self.linear * (vertex - self.from)
        };
        tree.search(&measure, limit, |polygon, _| {
            visit(match self.mesh.polygon(polygon as usize) {
                &[a, b, c] => Found::Triangle([at(a), at(b), at(c)]),
                _ => Found::Polygon(polygon),
            })
        });
    }

    /// Half the sides of the cuboid.
    pub fn half(&self) -> Vec3A {
        self.cuboid.half
    }

    /// Puts a direction of the frame into the axes of the cuboid.
    pub fn direction_to_cuboid(&self, direction: Vec3A) -> Vec3A {
        self.cuboid.axes.transpose() * direction
    }

    /// Puts a direction in the axes of the cuboid into the frame.
    pub fn direction_to_frame(&self, direction: Vec3A) -> Vec3A {
        self.cuboid.axes * direction
    }

    /// Puts a point in the axes of the cuboid into the frame.
    pub fn to_frame(&self, point: Vec3A) -> Vec3A {
        self.cuboid.center + self.cuboid.axes * point
    }

    /// The order of the pair, for something of the cuboid and of the mesh.
    pub fn in_order<T>(&self, of_cuboid: T, of_mesh: T) -> [T; 2] {
        if self.cuboid_first {
            [of_cuboid, of_mesh]
        } else {
            [of_mesh, of_cuboid]
        }
    }
}

/// A polygon of the mesh that may be near.
pub enum Found {
    /// A triangle, by its corners in the axes of the cuboid.
    Triangle([Vec3A; 3]),
    /// Another polygon, by its number.
    Polygon(u32),
}

/// Whether a triangle is no further from a cuboid than a tolerance.
#[inline]
pub fn touches(half: Vec3A, corners: [Vec3A; 3], tolerance: f32) -> bool {
    match triangle::gap(half, corners, 2.0 * tolerance) {
        None => false,
        Some(gap) if gap.widest <= -gap.doubt => true,
        Some(_) => {
            let limit = tolerance * tolerance * (1.0 + 2.0 * f32::EPSILON);
            triangle::closest(half, corners, limit.next_up()).is_some()
        }
    }
}
