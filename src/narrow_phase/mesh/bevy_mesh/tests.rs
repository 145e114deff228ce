use super::*;
use bevy::asset::RenderAssetUsages;
use bevy::math::primitives::{Cuboid, Sphere, Torus};
use bevy::mesh::Indices;

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
    use bevy::transform::components::Transform;
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
