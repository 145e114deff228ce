//! What is accepted as a mesh, and how it hangs together.

use super::*;

/// A cube of side 2; its last polygon is turned the wrong way.
pub fn cube() -> PolygonMesh {
    let bits = |i: u8| [i & 1, i >> 1 & 1, i >> 2 & 1];
    let corner = |i| Vec3::from(bits(i).map(|bit| f32::from(bit) * 2.0 - 1.0));
    let vertices: Vec<_> = (0..8).map(corner).collect();
    let polygons = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [7, 3, 1, 5],
    ];
    PolygonMesh::new(vertices, polygons).unwrap()
}

#[test]
fn cube_is_closed_and_faces_outwards() {
    let cube = cube();
    assert!(cube.is_closed());
    assert_eq!((cube.edges().len(), cube.shells().len()), (12, 1));
    for (polygon, normal) in cube.polygons().zip(cube.normals()) {
        let corner = cube.vertices()[polygon[0] as usize];
        assert!(
            (normal.dot(corner) - 1.0).abs() < 1e-6,
            "{polygon:?} {normal}"
        );
    }
    assert_eq!(cube.local_bounds(), (Vec3A::ZERO, Vec3A::ONE, 3f32.sqrt()));
}

#[test]
fn missing_polygon_leaves_the_mesh_open() {
    let cube = cube();
    let open = PolygonMesh::new(cube.vertices(), cube.polygons().skip(1)).unwrap();
    assert!(!open.is_closed());
    assert_eq!(open.edges().len(), 12);
    assert!(!open.surface_only().is_closed());
}

#[test]
fn a_surface_only_is_as_closed_as_before() {
    let room = cube().surface_only();
    assert!(room.is_closed() && room.open_edge().is_none());
    assert!(!room.has_inside() && (0..6).all(|polygon| !room.bounds_solid(polygon)));
}

#[test]
fn bad_input_is_named() {
    let square = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::Y,
        Vec3::X * 2.0,
    ];
    let build = |polygons: &[&[u32]]| PolygonMesh::new(square, polygons).unwrap_err();
    let good: &[u32] = &[0, 1, 2, 3];
    assert_eq!(build(&[]), ShapeError::Empty);
    let error = ShapeError::TooFewCorners {
        polygon: 1,
        corners: 2,
    };
    assert_eq!(build(&[good, &[0, 1]]), error);
    let error = ShapeError::IndexOutOfRange {
        polygon: 1,
        vertex: 9,
        vertices: 5,
    };
    assert_eq!(build(&[good, &[0, 1, 9]]), error);
    let error = ShapeError::RepeatedVertex {
        polygon: 1,
        vertex: 0,
    };
    assert_eq!(build(&[good, &[0, 1, 2, 0]]), error);
    assert_eq!(
        build(&[good, &[0, 1, 4]]),
        ShapeError::ZeroArea { polygon: 1 }
    );

    let mut bent = square;
    bent[2].z = 0.1;
    let error = PolygonMesh::new(bent, [good]).unwrap_err();
    assert!(
        matches!(error, ShapeError::NotPlanar { polygon: 0, .. }),
        "{error}"
    );

    bent[2].z = f32::NAN;
    let error = PolygonMesh::new(bent, [good]).unwrap_err();
    assert!(
        matches!(error, ShapeError::NonFiniteVertex { vertex: 2, .. }),
        "{error}"
    );
    let mut unused = square;
    unused[4].z = f32::NAN;
    let error = PolygonMesh::new(unused, [good]).unwrap_err();
    assert!(
        matches!(error, ShapeError::NonFiniteVertex { vertex: 4, .. }),
        "{error}"
    );
}

#[test]
fn tiny_and_far_polygons_are_fine() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let tiny = triangle.map(|v| v * 1e-25);
    let far = triangle.map(|v| v + Vec3::splat(1e5));
    for vertices in [tiny, far] {
        let mesh = PolygonMesh::new(vertices, [[0, 1, 2]]).unwrap();
        assert!((mesh.normals()[0] - Vec3::Z).length() < 1e-5);
    }
}

#[test]
fn what_is_across_a_side_shares_it() {
    use crate::narrow_phase::mesh::topology::NO_NEIGHBOR;
    let cube = cube();
    let open = PolygonMesh::new(cube.vertices(), cube.polygons().skip(1)).unwrap();
    let (mut turned, fan) = (cube.clone(), [[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    turned.flip();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::Z];
    let fan = PolygonMesh::new(corners, fan).unwrap();
    for (mesh, borders) in [(cube, 0), (turned, 0), (open, 4), (fan, 9)] {
        let mut alone = 0;
        for (polygon, corners) in mesh.polygons().enumerate() {
            let across = mesh.across(polygon);
            assert_eq!(across.len(), corners.len());
            for (side, &other) in across.iter().enumerate() {
                if other == NO_NEIGHBOR {
                    alone += 1;
                    continue;
                }
                let ends = [corners[side], corners[(side + 1) % corners.len()]];
                let others = mesh.polygon(other as usize);
                assert!(other as usize != polygon && ends.iter().all(|end| others.contains(end)));
            }
        }
        assert_eq!(alone, borders);
    }
}

/// A box, in its given size and place, with its polygons turned around or not.
type Nested = (f32, Vec3, bool);

/// Boxes, where along x is inside and where is not, and which of the boxes face outwards then.
type Case<'a> = (&'a [Nested], &'a [(f32, bool)], &'a [bool]);

fn boxes(given: &[Nested]) -> PolygonMesh {
    let cube = cube();
    let (mut vertices, mut polygons) = (Vec::new(), Vec::new());
    for &(size, offset, is_turned) in given {
        let first = vertices.len() as u32;
        vertices.extend(cube.vertices().iter().map(|at| *at * size + offset));
        polygons.extend(cube.polygons().map(|corners| {
            let mut corners: Vec<u32> = corners.iter().map(|corner| corner + first).collect();
            if is_turned {
                corners.reverse();
            }
            corners
        }));
    }
    PolygonMesh::new(vertices, polygons).unwrap()
}

#[test]
fn solids_face_outwards_however_they_are_given() {
    let zero = Vec3::ZERO;
    // Where a point is inside, and which of the boxes then face away from their middle.
    let cases: [Case; 5] = [
        (&[(1.0, zero, true)], &[(0.1, true), (1.5, false)], &[true]),
        // Side by side, and overlapping.
        (
            &[(1.0, zero, false), (1.0, Vec3::X * 1.5, true)],
            &[(0.1, true), (0.7, true), (2.0, true)],
            &[true, true],
        ),
        // A room in a block, whichever way the two face; and a stone in it.
        (
            &[(1.0, zero, false), (3.0, zero, true), (0.3, zero, true)],
            &[(0.1, true), (0.5, false), (2.0, true)],
            &[false, true, true],
        ),
        (
            &[(1.0, zero, true), (3.0, zero, false), (0.3, zero, true)],
            &[(0.1, true), (0.5, false), (2.0, true)],
            &[false, true, true],
        ),
        // A block in a block, which makes no difference.
        (
            &[(3.0, zero, true), (1.0, zero, true)],
            &[(0.1, true), (2.0, true)],
            &[true, true],
        ),
    ];
    for (given, inside, outwards) in cases {
        let mesh = boxes(given);
        assert!(mesh.is_closed());
        for &(x, expected) in inside {
            let at = DVec3::new(x.into(), 0.11, 0.13);
            assert_eq!(mesh.winds_around(at), expected, "{given:?} at {x}");
        }
        let room = mesh.clone().surface_only();
        for (polygon, corners) in mesh.polygons().enumerate() {
            let (index, way) = (polygon / 6, mesh.normals()[polygon]);
            let from_middle = mesh.vertices()[corners[0] as usize] - given[index].1;
            assert_eq!(
                way.dot(from_middle) > 0.0,
                outwards[index],
                "{given:?} {polygon}"
            );
            assert!(mesh.bounds_solid(polygon) && !room.bounds_solid(polygon));
            // As given, again.
            let as_given = room.normals()[polygon].dot(from_middle) < 0.0;
            assert_eq!(as_given, given[index].2, "{given:?} {polygon}");
        }
    }
}

#[test]
fn memory_is_told() {
    let cube = cube();
    let vertices = cube.vertices().len() + cube.normals().len();
    let lists = vertices * size_of::<Vec3>() + cube.edges().len() * 8 + (2 * 24 + 1) * 4;
    assert_eq!(cube.memory_bytes(), size_of::<PolygonMesh>() + lists);
}
