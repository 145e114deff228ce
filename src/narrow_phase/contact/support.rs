//! How far a mesh reaches along a direction, all of it.

use std::ops::ControlFlow;

use bevy::math::{Vec3, Vec3A};

use crate::broad_phase::Height;
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// The vertex that is as high as any along a direction in the space of the mesh, and how high it is
/// above the middle of its box. By its tree, if it has one: O(log n), unless much of the mesh lies
/// in a plane there.
pub fn highest_vertex(mesh: &PolygonMesh, up: Vec3A) -> (Vec3, f32) {
    let (middle, half, _) = mesh.local_bounds();
    let vertices = mesh.vertices();
    let mut best = (f32::NEG_INFINITY, Vec3::ZERO);
    let mut look = |polygon: u32| {
        #[cfg(test)]
        visited::count();
        for &vertex in mesh.polygon(polygon as usize) {
            let vertex = vertices[vertex as usize];
            let height = (Vec3A::from(vertex) - middle).dot(up);
            if height > best.0 {
                best = (height, vertex);
            }
        }
        best.0
    };
    match mesh.tree() {
        Some(tree) => {
            let offset = middle.dot(up);
            let size = (middle.abs() + half).dot(up.abs());
            let top = offset + half.dot(up.abs());
            let rounding = 8.0 * f32::EPSILON * size;
            tree.search(&Height::new(up, top), f32::INFINITY, |polygon, _| {
                // What is hardly higher does not matter: so much of a flat face is not looked at.
                ControlFlow::Continue(top - (look(polygon) + offset) - rounding)
            });
        }
        None => (0..mesh.polygon_count() as u32).for_each(|polygon| {
            look(polygon);
        }),
    }
    (best.1, best.0)
}

/// How many polygons were looked at, for tests.
#[cfg(test)]
pub mod visited {
    use std::cell::Cell;

    thread_local!(static COUNT: Cell<usize> = const { Cell::new(0) });

    pub fn count() {
        COUNT.set(COUNT.get() + 1);
    }

    /// The number since the last time.
    pub fn take() -> usize {
        COUNT.take()
    }
}
