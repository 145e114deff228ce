use bevy::asset::RenderAssetUsages;
use bevy::math::primitives::{
    Annulus, Capsule2d, Capsule3d, Circle, CircularSegment, Cone, ConicalFrustum, Cuboid, Cylinder,
    Extrusion, Rectangle, Sphere, Tetrahedron, Torus,
};
use bevy::math::{Quat, Vec3};
use bevy::mesh::{Indices, MeshBuilder, Meshable};
use bevy::transform::components::Transform;

use super::*;
use crate::narrow_phase::ConvexMesh;

fn strip() -> Mesh {
    let corners = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    Mesh::new(PrimitiveTopology::TriangleStrip, RenderAssetUsages::all())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
}

#[test]
fn welded_primitives_are_closed() {
    let cube = PolygonMesh::from_mesh(&Mesh::from(Cuboid::default())).unwrap();
    assert_eq!((cube.vertices().len(), cube.polygon_count()), (8, 12));
    assert!(cube.is_closed());
    let ball = PolygonMesh::from_mesh(&Mesh::from(Sphere::new(2.0))).unwrap();
    assert!(ball.is_closed());
    let flat = Mesh::from(Cuboid::default()).with_duplicated_vertices();
    assert!(PolygonMesh::try_from(&flat).unwrap().is_closed());
}

#[test]
fn primitives_of_any_size_are_closed() {
    let mut rng = fastrand::Rng::with_seed(1);
    for _ in 0..300 {
        let [a, b, c] = [(); 3].map(|()| 0.2 + 2.0 * rng.f32());
        let frustum = ConicalFrustum {
            radius_top: a,
            radius_bottom: b,
            height: c,
        };
        let torus = Torus::new(a * 0.3, a);
        for (name, mesh) in [
            ("cuboid", Cuboid::new(a, b, c).mesh().build()),
            ("sphere", Sphere::new(a).mesh().build()),
            ("uv sphere", Sphere::new(a).mesh().uv(32, 18)),
            ("capsule", Capsule3d::new(a, b).mesh().build()),
            ("cylinder", Cylinder::new(a, b).mesh().build()),
            (
                "cylinder, segments",
                Cylinder::new(a, b).mesh().segments(4).build(),
            ),
            ("cone", Cone::new(a, b).mesh().build()),
            ("frustum", frustum.mesh().build()),
            ("torus", torus.mesh().build()),
            ("circle", Extrusion::new(Circle::new(a), b).mesh().build()),
            (
                "annulus",
                Extrusion::new(Annulus::new(a * 0.4, a), b).mesh().build(),
            ),
            (
                "rectangle",
                Extrusion::new(Rectangle::new(a, b), c).mesh().build(),
            ),
            (
                "capsule of 2",
                Extrusion::new(Capsule2d::new(a, b), c).mesh().build(),
            ),
            (
                "segment",
                Extrusion::new(CircularSegment::new(a, 1.0), c)
                    .mesh()
                    .build(),
            ),
            ("tetrahedron", Tetrahedron::default().mesh().build()),
        ] {
            let found = PolygonMesh::from_mesh(&mesh).unwrap();
            assert!(
                found.is_closed() && found.has_inside(),
                "{name} of {a}, {b}, {c}"
            );
        }
    }
}

#[test]
fn spheres_wherever_they_are_and_however_they_are_shaded_are_closed() {
    let mut rng = fastrand::Rng::with_seed(1);
    for (subdivisions, count) in [(1, 200), (3, 100), (10, 30), (40, 5)] {
        for _ in 0..count {
            let [x, y, z] = [(); 3].map(|()| rng.f32());
            let place = Transform::from_xyz(x, y, z)
                .with_rotation(Quat::from_scaled_axis(Vec3::new(y, z, x) * 4.0));
            let mesh = Sphere::new(1.0).mesh().ico(subdivisions).unwrap();
            let mesh = mesh.transformed_by(place).with_duplicated_vertices();
            let found = PolygonMesh::from_mesh(&mesh).unwrap();
            assert!(found.is_closed());
            assert_eq!(found.vertices().len(), found.polygon_count() / 2 + 2);
        }
    }
    for sectors in (8..=400).step_by(56) {
        for stacks in [4, 18, 125] {
            let mesh = Sphere::new(10.0).mesh().uv(sectors, stacks);
            let found = PolygonMesh::from_mesh(&mesh).unwrap();
            assert!(found.is_closed());
            assert_eq!(found.polygon_count() as u32, sectors * (stacks - 1) * 2);
        }
    }
}

#[test]
fn turned_primitives_of_many_sides_are_convex() {
    let mut rng = fastrand::Rng::with_seed(1);
    for resolution in [32, 128, 512] {
        for _ in 0..20 {
            let turn = Quat::from_scaled_axis(Vec3::from([(); 3].map(|()| rng.f32() * 4.0)));
            let place = Transform::from_rotation(turn);
            for mesh in [
                Cone::new(1.0, 2.0).mesh().resolution(resolution).build(),
                Cylinder::new(1.0, 2.0)
                    .mesh()
                    .resolution(resolution)
                    .build(),
            ] {
                let mesh = PolygonMesh::from_mesh(&mesh.transformed_by(place)).unwrap();
                let convex = ConvexMesh::new(mesh);
                assert!(convex.is_ok(), "{resolution}: {}", convex.unwrap_err());
            }
        }
    }
}

#[test]
fn indices_of_any_width_and_none_are_the_same() {
    let wide = Mesh::from(Cuboid::default());
    let indices: Vec<u32> = wide.indices().unwrap().iter().map(|i| i as u32).collect();
    let narrow = indices.iter().map(|i| *i as u16).collect();
    let none = wide.clone().with_duplicated_vertices();
    assert!(none.indices().is_none());
    let wide = wide.with_inserted_indices(Indices::U32(indices));
    let narrow = wide.clone().with_inserted_indices(Indices::U16(narrow));
    let normals = |mesh: &Mesh| PolygonMesh::from_mesh(mesh).unwrap().normals().to_vec();
    assert_eq!(normals(&wide), normals(&narrow));
    assert_eq!(normals(&wide), normals(&none));
}

#[test]
fn strip_faces_one_way() {
    let mesh = PolygonMesh::from_mesh(&strip()).unwrap();
    assert_eq!(mesh.normals(), [Vec3::Z, Vec3::Z]);
    assert_eq!(mesh.edges().len(), 5);
    let doubled = strip().with_inserted_indices(Indices::U16(vec![0, 1, 2, 2, 2, 1, 3]));
    let mesh = PolygonMesh::from_mesh(&doubled).unwrap();
    assert_eq!(mesh.polygon_count(), 2);
}

#[test]
fn bad_meshes_are_refused() {
    let refuse = |mesh: Mesh| PolygonMesh::from_mesh(&mesh).unwrap_err();
    let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::all());
    assert_eq!(refuse(lines), ShapeError::NoPositions);
    let points = Mesh::new(PrimitiveTopology::PointList, RenderAssetUsages::all())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0f32; 3]]);
    assert_eq!(
        refuse(points),
        ShapeError::Topology(PrimitiveTopology::PointList)
    );
    let out = strip().with_inserted_indices(Indices::U32(vec![0, 1, 7]));
    let expected = ShapeError::IndexOutOfRange {
        polygon: 0,
        vertex: 7,
        vertices: 4,
    };
    assert_eq!(refuse(out), expected);
    let short = strip().with_inserted_indices(Indices::U32(vec![0, 1]));
    assert_eq!(refuse(short), ShapeError::Empty);
    let list = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0f32; 3]; 4]);
    assert_eq!(
        refuse(list),
        ShapeError::TooFewCorners {
            polygon: 1,
            corners: 1
        }
    );
}

#[test]
fn torus_has_a_hole() {
    use crate::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
    let mesh = PolygonMesh::from_mesh(&Mesh::from(Torus::new(0.5, 1.0))).unwrap();
    assert!(mesh.is_closed());
    let torus = Shape::from(mesh);
    let pea = Shape::from_half_size(Vec3::splat(0.1));
    let meets = |x: f32| {
        let (here, there) = (Transform::IDENTITY, Transform::from_xyz(x, 0.0, 0.0));
        let (torus, pea) = (Placed::new(&torus, &here), Placed::new(&pea, &there));
        NarrowPhase::default().intersects(torus, pea, &mut Workspace::default())
    };
    assert!(!meets(0.0));
    assert!(meets(0.45));
    assert!(meets(0.75));
}
