//! Random solids on random ground, against all triangles in 64-bit floats.

use bevy::math::{DQuat, DVec3, EulerRot, Quat, Vec3};
use bevy::transform::components::Transform;

use super::tests::{contact, grid};
use crate::narrow_phase::mesh::polygon_mesh::tests::cube;
use crate::narrow_phase::tests::box_of;
use crate::narrow_phase::*;

/// A convex solid in the world: corners, normals of faces, directions of edges.
struct Solid {
    corners: Vec<DVec3>,
    normals: Vec<DVec3>,
    edges: Vec<DVec3>,
}

impl Solid {
    fn new(mesh: &PolygonMesh, size: Vec3, at: &Transform) -> Self {
        let turn = DQuat::from_xyzw(
            at.rotation.x.into(),
            at.rotation.y.into(),
            at.rotation.z.into(),
            at.rotation.w.into(),
        )
        .normalize();
        let place = |v: &Vec3| turn * (*v * size).as_dvec3() + at.translation.as_dvec3();
        let corners: Vec<_> = mesh.vertices().iter().map(place).collect();
        let normal = |corners: &[u32]| {
            let [a, b, c] = [0, 1, 2].map(|i| place(&mesh.vertices()[corners[i] as usize]));
            (b - a).cross(c - a).normalize()
        };
        let along = |[a, b]: &[u32; 2]| corners[*b as usize] - corners[*a as usize];
        Self {
            normals: mesh.polygons().map(normal).collect(),
            edges: mesh.edges().iter().map(along).collect(),
            corners,
        }
    }

    fn lowest(&self, axis: DVec3) -> f64 {
        let heights = self.corners.iter().map(|corner| corner.dot(axis));
        heights.fold(f64::INFINITY, f64::min)
    }

    /// How far it has to go along an axis to be clear of a triangle.
    fn depth(&self, triangle: &[DVec3; 3], axis: DVec3) -> f64 {
        let heights = triangle.iter().map(|corner| corner.dot(axis));
        heights.fold(f64::NEG_INFINITY, f64::max) - self.lowest(axis)
    }

    /// How far it has to go at least: negative, if it is clear of it.
    fn least(&self, triangle: &[DVec3; 3]) -> f64 {
        let sides = [0, 1, 2].map(|i| triangle[(i + 1) % 3] - triangle[i]);
        let normal = sides[0].cross(sides[1]).normalize();
        let products = self
            .edges
            .iter()
            .flat_map(|edge| sides.map(|side| side.cross(*edge)))
            .filter(|product| product.length_squared() > 1e-12)
            .map(DVec3::normalize);
        let axes = self.normals.iter().copied().chain([normal]).chain(products);
        axes.flat_map(|axis| [axis, -axis])
            .map(|axis| self.depth(triangle, axis))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Twenty faces, not very regular.
fn ball() -> ConvexMesh {
    let g = 1.618;
    let mut vertices = Vec::new();
    for [a, b] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        vertices.push(Vec3::new(0.0, a, b * g));
        vertices.push(Vec3::new(a, b * g, 0.0));
        vertices.push(Vec3::new(b * g, 0.0, a));
    }
    let mut list = Vec::new();
    for a in 0..12u32 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [a, b, c].map(|i| vertices[i as usize]);
                let sides = [p.distance(q), q.distance(r), r.distance(p)];
                if sides.iter().all(|side| *side < 2.2) {
                    list.push([a, b, c]);
                }
            }
        }
    }
    assert_eq!(list.len(), 20);
    let squeezed = vertices.iter().map(|v| *v * Vec3::new(0.3, 0.25, 0.35));
    ConvexMesh::new(PolygonMesh::new(squeezed.collect::<Vec<_>>(), list).unwrap()).unwrap()
}

#[test]
fn the_way_out_is_between_the_least_and_that_along_normals() {
    let mut random = fastrand::Rng::with_seed(11);
    let cube = cube();
    let round = ball();
    let round_shape = Shape::from(round.clone());
    let mut checked = 0;
    for _ in 0..40 {
        let steep = random.f32() * 0.8;
        let heights: Vec<f32> = (0..81).map(|_| random.f32() * steep).collect();
        let height = |x: f32, z: f32| heights[(z * 9.0 + x) as usize];
        let ground = grid(8, height);
        let Shape::Mesh(mesh) = &ground else {
            unreachable!()
        };
        let triangles: Vec<[DVec3; 3]> = mesh
            .polygons()
            .map(|corners| [0, 1, 2].map(|i| mesh.vertices()[corners[i] as usize].as_dvec3()))
            .collect();
        for _ in 0..40 {
            let mut unit = || random.f32() * 2.0 - 1.0;
            let turn = Quat::from_euler(EulerRot::XYZ, unit() * 3.0, unit() * 3.0, unit() * 3.0);
            let place = Vec3::new(4.0 + unit() * 3.0, 0.6 + unit() * 0.4, 4.0 + unit() * 3.0);
            let at = Transform::from_translation(place).with_rotation(turn);
            let half = Vec3::new(unit(), unit(), unit()) * 0.3 + 0.4;
            let cuboid = box_of(half.x, half.y, half.z);
            for (shape, solid) in [
                (&cuboid, Solid::new(&cube, half, &at)),
                (&round_shape, Solid::new(&round, Vec3::ONE, &at)),
            ] {
                let depths: Vec<f64> = triangles.iter().map(|t| solid.least(t)).collect();
                let touched = || {
                    triangles
                        .iter()
                        .zip(&depths)
                        .filter(|(_, depth)| **depth > 1e-4)
                };
                if touched().count() == 0 {
                    continue;
                }
                checked += 1;
                let found = contact((&ground, Transform::IDENTITY), (shape, at));
                let (depth, normal) = (f64::from(found.depth), found.normal.as_dvec3());
                // None of them asks for more.
                let least = touched().map(|(_, depth)| *depth).fold(0.0, f64::max);
                // Along their own normals they all get clear.
                let own = touched().map(|(triangle, _)| {
                    let up = (triangle[1] - triangle[0])
                        .cross(triangle[2] - triangle[0])
                        .normalize();
                    solid.depth(triangle, up).min(solid.depth(triangle, -up))
                });
                let most = own.fold(0.0, f64::max);
                assert!(
                    least - 2e-4 < depth && depth < most + 2e-4,
                    "{shape:?} {at:?}: {found:?}, least {least}, most {most}"
                );
                // One is cleared by just that, and what lies along it is no deeper.
                let clears = touched().map(|(triangle, _)| solid.depth(triangle, normal) - depth);
                let nearest = clears.fold(f64::INFINITY, |near, off| near.min(off.abs()));
                assert!(
                    nearest < 2e-4,
                    "{shape:?} {at:?}: {found:?}, off by {nearest}"
                );
            }
        }
    }
    assert!(checked > 1500, "{checked}");
}
