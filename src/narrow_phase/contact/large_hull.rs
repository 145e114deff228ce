//! A convex mesh of many faces, around the centre of its box, along its own axes.
//!
//! It is searched by the tree of its mesh: for how far it reaches along a direction, and for the
//! faces near a polygon. At the least translation that parts the two, a point of a face or an edge
//! meets one of the polygon, which is no further away than the translation is long. Where the
//! polygon does not allow that direction, what is next are the faces with normals that it does
//! allow: they are all around the one that faces it.

use std::{
    cell::{Cell, RefCell},
    ops::ControlFlow,
};

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    facet::{Best, Facet, bounds, highest},
    patch::Patch,
    support::highest_vertex,
};
use crate::broad_phase::{Overlap, StillOctree, Sweep};
use crate::narrow_phase::{
    frame::placing::cofactors,
    length::unit,
    mesh::{polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR},
};

/// A mesh of so many faces, or fewer, is looked at as a whole.
const MOST_FACES: usize = 128;

/// Memory that outlives a contact.
#[derive(Clone, Debug, Default)]
pub struct Room {
    polygons: Vec<u32>,
    /// When each was listed.
    listed: Vec<u64>,
    now: u64,
    patch: Patch,
}

impl Room {
    /// Lists none of so many polygons.
    fn begin(&mut self, count: usize) {
        self.polygons.clear();
        if self.listed.len() < count {
            self.listed.resize(count, 0);
        }
        self.begin_again();
    }

    /// What is listed may be so again.
    fn begin_again(&mut self) {
        self.now += 1;
    }

    fn list(&mut self, polygon: u32) {
        let listed = &mut self.listed[polygon as usize];
        if *listed != self.now {
            *listed = self.now;
            self.polygons.push(polygon);
        }
    }
}

/// A convex mesh of many faces, around the centre of its box, along its own axes, scaled.
#[derive(Debug)]
pub struct LargeHull<'a> {
    mesh: &'a PolygonMesh,
    tree: &'a StillOctree,
    middle: Vec3A,
    scale: Vec3A,
    to_normal: Vec3A,
    /// A point inside, in place.
    inside: Vec3A,
    room: RefCell<Room>,
    /// Where it begins along the last two directions: those of a flat floor are always the same.
    begins: Cell<[(Vec3A, f32); 2]>,
}

impl<'a> LargeHull<'a> {
    /// Says where a mesh is, if it has many faces and no scale flattens it. O(corners).
    pub fn new(mesh: &'a PolygonMesh, scale: Vec3A, room: &mut Room) -> Option<Self> {
        let has_many = mesh.polygon_count() > MOST_FACES;
        has_many.then(|| Self::searched(mesh, scale, room))?
    }

    /// The same of any number of faces for which there is a tree.
    fn searched(mesh: &'a PolygonMesh, scale: Vec3A, room: &mut Room) -> Option<Self> {
        let tree = mesh.tree()?;
        let sizes = scale.abs();
        let is_solid = sizes.min_element() > 1e-3 * sizes.max_element();
        if !is_solid {
            return None;
        }
        let (middle, ..) = mesh.local_bounds();
        let (mut sum, mut count) = (Vec3A::ZERO, 0.0);
        for vertex in mesh.polygons().flatten() {
            sum += Vec3A::from(mesh.vertices()[*vertex as usize]) - middle;
            count += 1.0;
        }
        Some(Self {
            mesh,
            tree,
            middle,
            scale,
            to_normal: cofactors(scale),
            inside: sum / count * scale,
            room: RefCell::new(std::mem::take(room)),
            begins: Cell::new([(Vec3A::NAN, 0.0); 2]),
        })
    }

    /// Gives the memory back.
    pub fn into_room(self) -> Room {
        self.room.into_inner()
    }

    #[inline]
    fn place(&self, vertex: u32) -> Vec3A {
        (Vec3A::from(self.mesh.vertices()[vertex as usize]) - self.middle) * self.scale
    }

    #[inline]
    fn normal(&self, polygon: u32) -> Vec3A {
        unit(Vec3A::from(self.mesh.normals()[polygon as usize]) * self.to_normal)
    }

    /// The normal of a face, and how far its plane is.
    #[inline]
    fn face(&self, polygon: u32) -> (Vec3A, f32) {
        #[cfg(test)]
        super::support::visited::count();
        let normal = self.normal(polygon);
        let corners = self.mesh.polygon(polygon as usize).iter();
        let heights = corners.map(|vertex| self.place(*vertex).dot(normal));
        (normal, heights.fold(f32::NEG_INFINITY, f32::max))
    }

    /// A box in the space of the mesh around one that is in place, a little larger.
    fn back([min, max]: [Vec3A; 2], scale: Vec3A, middle: Vec3A) -> Aabb3d {
        let (one, other) = (min / scale, max / scale);
        let wide = 8.0 * f32::EPSILON * (middle.abs() + one.abs() + other.abs());
        Aabb3d {
            min: one.min(other) + middle - wide,
            max: one.max(other) + middle + wide,
        }
    }

    fn near(&self, corners: &[Vec3A], margin: f32) -> Overlap {
        let [min, max] = bounds(corners.iter().copied());
        let region = [min - margin, max + margin];
        Overlap::new(Self::back(region, self.scale, self.middle))
    }

    /// Where it begins along a direction.
    pub fn lowest(&self, direction: Vec3A) -> f32 {
        let known = self.begins.get();
        if let Some((_, height)) = known.iter().find(|known| known.0 == direction) {
            return *height;
        }
        let height = -highest_vertex(self.mesh, -direction * self.scale).1;
        self.begins.set([(direction, height), known[0]]);
        height
    }

    /// A corner that is as far along a direction as any.
    pub fn furthest(&self, direction: Vec3A) -> Vec3A {
        let (vertex, _) = highest_vertex(self.mesh, direction * self.scale);
        (Vec3A::from(vertex) - self.middle) * self.scale
    }

    /// See [`Body::touches`](super::body::Body::touches).
    ///
    /// What is left of the polygon below all faces near it is inside, if the solid has any part
    /// there; and if not, none of the polygon is.
    pub fn touches(&self, corners: &[Vec3A], tolerance: f32) -> bool {
        let Room { patch, .. } = &mut *self.room.borrow_mut();
        patch.piece.clear();
        patch.piece.extend_from_slice(corners);
        let near = self.near(corners, tolerance);
        self.tree.search(&near, 0.0, |polygon, _| {
            let (normal, plane) = self.face(polygon);
            patch.cut(normal, plane + tolerance);
            if patch.piece.is_empty() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(0.0)
            }
        });
        let count = patch.piece.len() as f32;
        count > 0.0 && self.holds(patch.piece.iter().sum::<Vec3A>() / count, tolerance)
    }

    /// Is a point inside, to within a tolerance? The way from there to a point that is so comes in
    /// through a face, if not.
    fn holds(&self, point: Vec3A, tolerance: f32) -> bool {
        let [from, to] = [point, self.inside].map(|point| point / self.scale + self.middle);
        let size = self.middle.abs() + from.abs() + to.abs();
        let around = 8.0 * f32::EPSILON * size;
        let (measure, limit) = Sweep::along(from, to - from, -around, around, 1.0);
        let mut is_inside = true;
        self.tree.search(&measure, limit, |polygon, _| {
            let (normal, plane) = self.face(polygon);
            is_inside = point.dot(normal) <= plane + tolerance;
            if is_inside {
                ControlFlow::Continue(limit)
            } else {
                ControlFlow::Break(())
            }
        });
        is_inside
    }

    /// Lists the faces within a distance of a polygon, and maybe some more.
    fn list_near(&self, corners: &[Vec3A], reach: f32, room: &mut Room) {
        let near = self.near(corners, reach);
        self.tree.search(&near, 0.0, |polygon, _| {
            room.list(polygon);
            ControlFlow::Continue(0.0)
        });
    }

    /// Lists the faces with normals that a polygon allows, from that which faces it on, and those
    /// beside them.
    fn list_facing(&self, facet: &Facet, normal: Vec3A, size: f32, room: &mut Room) {
        if normal == Vec3A::ZERO {
            return;
        }
        let mut next = room.polygons.len();
        room.begin_again();
        self.list_near(&[self.furthest(-normal)], 1e-6 * size, room);
        while let Some(&polygon) = room.polygons.get(next) {
            next += 1;
            if facet.allows(-self.face(polygon).0) {
                for &other in self.mesh.across(polygon as usize) {
                    if other != NO_NEIGHBOR {
                        room.list(other);
                    }
                }
            }
        }
    }

    /// Ways off a polygon along normals of faces, and of edges: of those that are near enough for
    /// a shorter one, or that face the polygon.
    pub fn ways(&self, facet: &Facet, best: &mut Best) {
        let room = &mut *self.room.borrow_mut();
        room.begin(self.mesh.polygon_count());
        let (_, half, _) = self.mesh.local_bounds();
        let size = 2.0 * (half * self.scale).length();
        let reach = best.way.map_or(size, |way| way.depth.min(size));
        self.list_near(facet.corners, reach, room);
        self.list_facing(facet, facet.normal, size, room);
        if !facet.is_solid {
            self.list_facing(facet, -facet.normal, size, room);
        }
        let Room { polygons, .. } = room;
        // In the order of the mesh, whatever that of the tree.
        polygons.sort_unstable();
        polygons.dedup();
        for &polygon in &*polygons {
            let (normal, plane) = self.face(polygon);
            let depth = plane + highest(facet.corners, -normal);
            if best.is_beaten_by(depth) && facet.allows(-normal) {
                best.take(-normal, depth);
            }
        }
        for side in 0..facet.corners.len() {
            // Most sides of a floor have no normals of their own.
            if !facet.is_bent(side) {
                continue;
            }
            let [from, to] = facet.ends(side);
            for &polygon in &*polygons {
                let own = self.normal(polygon);
                let along = own.dot(to - from);
                let corners = self.mesh.polygon(polygon as usize);
                let next = corners.iter().cycle().skip(1);
                let edges = corners.iter().zip(next);
                for (&other, (start, end)) in self.mesh.across(polygon as usize).iter().zip(edges) {
                    // Of two that share an edge, the first has it.
                    if other < polygon && polygons.binary_search(&other).is_ok() {
                        continue;
                    }
                    let beside = if other == NO_NEIGHBOR {
                        -own
                    } else {
                        self.normal(other)
                    };
                    if along * beside.dot(to - from) >= 0.0 {
                        continue;
                    }
                    let ends = [*start, *end].map(|vertex| self.place(vertex));
                    let Some(direction) = facet.across(side, ends[1] - ends[0]) else {
                        continue;
                    };
                    if direction.dot(own + beside) < 0.0 {
                        let depth = (from - ends[0]).dot(direction);
                        if best.is_beaten_by(depth) && facet.is_ridge(side, direction) {
                            best.take(direction, depth);
                        }
                    }
                }
            }
        }
    }

    /// See [`Body::face_towards`](super::body::Body::face_towards). O(faces).
    pub fn face_towards(&self, direction: Vec3A, corners: &mut Vec<Vec3A>) -> Vec3A {
        let along = |polygon: &u32| self.normal(*polygon).dot(direction);
        let all = 0..self.mesh.polygon_count() as u32;
        let face = all.max_by(|a, b| along(a).total_cmp(&along(b)));
        let Some(face) = face else {
            return Vec3A::ZERO;
        };
        let own = self.mesh.polygon(face as usize).iter();
        corners.extend(own.map(|vertex| self.place(*vertex)));
        self.normal(face)
    }

    /// See [`Body::for_each_plane`](super::body::Body::for_each_plane). O(faces).
    pub fn for_each_plane(&self, mut cut: impl FnMut(Vec3A, f32)) {
        for polygon in 0..self.mesh.polygon_count() as u32 {
            let (normal, plane) = self.face(polygon);
            cut(normal, plane);
        }
    }
}

#[cfg(test)]
pub mod tests;
