use bevy::math::{IVec3, Vec2, Vec3};
use proptest::{collection::vec, prelude::*};

use super::*;
use crate::components::CollisionShape;

const CUBE: ShapeDescription = ShapeDescription::Cuboid {
    half_size: Vec3::ONE,
};

fn corners() -> Vec<Vec3> {
    vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]
}

fn faces() -> Vec<Vec<u32>> {
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        .map(Vec::from)
        .into()
}

/// One compound around another, so many times, and a shape in the innermost.
fn nested(depth: usize, shape: ShapeDescription) -> ShapeDescription {
    (0..depth).fold(shape, |shape, _| ShapeDescription::Compound {
        parts: vec![PartDescription::at(Vec3::X, shape)],
    })
}

#[test]
fn what_is_described_is_what_is_built() {
    let Ok(Shape::Cuboid { half_size }) = CUBE.build() else {
        panic!("a box is built");
    };
    assert_eq!(half_size, Vec3::ONE);
    let ball = ShapeDescription::Sphere { radius: 2.0 }.build();
    assert!(matches!(ball, Ok(Shape::Sphere { radius: 2.0 })));
    let (vertices, polygons) = (corners(), faces());
    let solid = ShapeDescription::Convex { vertices, polygons }.build();
    assert!(matches!(solid, Ok(Shape::Convex(mesh)) if mesh.polygon_count() == 4));
    for surface_only in [false, true] {
        let mesh = ShapeDescription::Mesh {
            vertices: corners(),
            polygons: faces(),
            surface_only,
        };
        let Ok(Shape::Mesh(mesh)) = mesh.build() else {
            panic!("a mesh is built");
        };
        assert_eq!(mesh.has_inside(), !surface_only);
    }
    let mut vertices = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    for _ in 0..2 {
        let solid = ShapeDescription::Tetrahedron { vertices }.build();
        assert!(matches!(solid, Ok(Shape::Convex(mesh)) if mesh.has_inside()));
        vertices.swap(0, 1); // the other way round
    }
}

#[test]
fn what_bsn_begins_with_makes_a_shape_or_is_a_list_to_fill() {
    use ShapeDescription as Data;
    let whole = [
        Data::default(),
        Data::default_cuboid(),
        Data::default_sphere(),
        Data::default_capsule(),
        Data::default_capsulebetween(),
        Data::default_cylinder(),
        Data::default_cone(),
        Data::default_conicalfrustum(),
        Data::default_tetrahedron(),
        Data::default_triangle(),
        Data::default_segment(),
        Data::default_halfspace(),
        Data::default_convexhull(),
        Data::default_rounded(),
        Data::default_heightfield(),
        Data::default_voxels(),
    ];
    for data in whole {
        let built = data.build();
        assert!(built.is_ok(), "{data:?}: {built:?}");
    }
    for data in [Data::default_convex(), Data::default_mesh()] {
        assert_eq!(data.build().unwrap_err(), ShapeError::Empty);
    }
    assert_eq!(
        Data::default(),
        Data::Cuboid {
            half_size: Vec3::splat(0.5)
        }
    );
    for core in [
        CoreDescription::default_segment(),
        CoreDescription::default_triangle(),
        CoreDescription::default_cuboid(),
        CoreDescription::default_cylinder(),
        CoreDescription::default_cone(),
        CoreDescription::default_conicalfrustum(),
        CoreDescription::default_convexhull(),
    ] {
        let built = core.build();
        assert!(built.is_ok(), "{core:?}: {built:?}");
    }
}

/// Each with its number: what goes wrong deep in a scene is found there.
#[test]
fn what_is_wrong_with_a_part_is_said_of_that_part() {
    let wrong = ShapeDescription::Sphere { radius: -1.0 };
    let parts = vec![
        PartDescription::default(),
        PartDescription::at(Vec3::X, nested(1, wrong)),
    ];
    let error = ShapeDescription::Compound { parts }.build().unwrap_err();
    assert_eq!(
        error.to_string(),
        "part 1: part 0: the radius of a sphere must be finite and not negative, got -1"
    );
}

#[test]
fn a_part_has_to_be_somewhere() {
    let at = |position, rotation| {
        let shape = CUBE;
        let parts = vec![PartDescription {
            position,
            rotation,
            shape,
        }];
        ShapeDescription::Compound { parts }.build().unwrap_err()
    };
    let nowhere = [
        (Vec3::NAN, Quat::IDENTITY),
        (Vec3::X * f32::INFINITY, Quat::IDENTITY),
        (Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
        (Vec3::ZERO, Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        (Vec3::ZERO, Quat::from_xyzw(0.0, f32::INFINITY, 0.0, 1.0)),
    ];
    for (position, rotation) in nowhere {
        let error = at(position, rotation);
        assert!(
            matches!(error, ShapeError::PartPose { part: 0, .. }),
            "{error}"
        );
    }
}

#[test]
fn turns_of_any_length_are_turns() {
    let turn = Quat::from_rotation_z(1.0);
    for length in [1e-30, 0.5, 1.0, 7.0, 1e30] {
        let part = PartDescription {
            rotation: turn * length,
            ..Default::default()
        };
        let pose = pose(&part).expect("it is one");
        assert!(pose.rotation.angle_between(turn) < 1e-3, "{length}");
        assert!(pose.rotation.is_normalized(), "{length}");
    }
}

#[test]
fn compounds_in_compounds_have_an_end() {
    let most = ShapeDescription::MAX_DEPTH;
    let fits = nested(most, CUBE).build();
    assert!(!matches!(fits, Err(ShapeError::TooDeep(_))), "{fits:?}");
    for depth in [most + 1, 100] {
        assert_eq!(
            nested(depth, CUBE).build().unwrap_err(),
            ShapeError::TooDeep(most)
        );
    }
}

#[test]
fn sizes_that_are_none_are_refused() {
    let is_refused = |data: ShapeDescription| data.build().is_err();
    for bad in [-1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(is_refused(ShapeDescription::Sphere { radius: bad }));
        assert!(is_refused(ShapeDescription::Cuboid {
            half_size: Vec3::new(1.0, bad, 1.0)
        }));
        assert!(is_refused(ShapeDescription::Capsule {
            radius: bad,
            length: 1.0
        }));
        assert!(is_refused(ShapeDescription::Rounded {
            core: CoreDescription::Cuboid {
                half_size: Vec3::splat(bad)
            },
            radius: 1.0
        }));
        assert!(is_refused(ShapeDescription::Voxels {
            cell_size: bad,
            cells: vec![IVec3::ZERO]
        }));
    }
    assert!(is_refused(ShapeDescription::Compound { parts: vec![] }));
    assert!(is_refused(ShapeDescription::ConvexHull { points: vec![] }));
    assert!(is_refused(ShapeDescription::HalfSpace {
        normal: Vec3::ZERO
    }));
    assert!(is_refused(ShapeDescription::HeightField {
        rows: 2,
        columns: 2,
        heights: vec![0.0; 3],
        cell_size: Vec2::ONE,
        holes: vec![],
    }));
}

fn size() -> impl Strategy<Value = f32> {
    0.01..10f32
}

fn point() -> impl Strategy<Value = Vec3> {
    [-10.0..10f32, -10.0..10f32, -10.0..10f32].prop_map(Vec3::from)
}

fn sizes() -> impl Strategy<Value = Vec3> {
    [size(), size(), size()].prop_map(Vec3::from)
}

/// A box somewhere, by its corners and sides.
fn brick() -> impl Strategy<Value = (Vec<Vec3>, Vec<Vec<u32>>)> {
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    (point(), sizes()).prop_map(move |(at, half)| {
        let corner = |i: u8| {
            let sign = [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 });
            at + half * Vec3::from(sign)
        };
        ((0..8).map(corner).collect(), sides.map(Vec::from).into())
    })
}

fn core() -> impl Strategy<Value = CoreDescription> {
    prop_oneof![
        (point(), point()).prop_map(|(a, b)| CoreDescription::Segment { a, b }),
        (point(), point(), point()).prop_map(|(a, b, c)| CoreDescription::Triangle { a, b, c }),
        sizes().prop_map(|half_size| CoreDescription::Cuboid { half_size }),
        (size(), size()).prop_map(|(radius, height)| CoreDescription::Cylinder { radius, height }),
        (size(), size()).prop_map(|(radius, height)| CoreDescription::Cone { radius, height }),
        (size(), size(), size()).prop_map(|(radius_top, radius_bottom, height)| {
            CoreDescription::ConicalFrustum {
                radius_top,
                radius_bottom,
                height,
            }
        }),
        brick().prop_map(|(vertices, polygons)| CoreDescription::Convex { vertices, polygons }),
        vec(point(), 4..20).prop_map(|points| CoreDescription::ConvexHull { points }),
    ]
}

/// What may be part of a compound.
fn bounded() -> impl Strategy<Value = ShapeDescription> {
    prop_oneof![
        (size(), size()).prop_map(|(radius, length)| ShapeDescription::Capsule { radius, length }),
        (point(), point(), size()).prop_map(|(a, b, radius)| ShapeDescription::CapsuleBetween {
            a,
            b,
            radius
        }),
        size().prop_map(|radius| ShapeDescription::Sphere { radius }),
        [point(), point(), point(), point()]
            .prop_map(|vertices| ShapeDescription::Tetrahedron { vertices }),
        (brick(), any::<bool>()).prop_map(|((vertices, polygons), surface_only)| {
            ShapeDescription::Mesh {
                vertices,
                polygons,
                surface_only,
            }
        }),
        (core(), size()).prop_map(|(core, radius)| ShapeDescription::Rounded { core, radius }),
        core().prop_map(ShapeDescription::from),
        (vec(-9.0..9f32, 12), sizes(), vec([0..2u32, 0..3u32], 0..3)).prop_map(
            |(heights, size, holes)| ShapeDescription::HeightField {
                rows: 3,
                columns: 4,
                heights,
                cell_size: size.truncate(),
                holes,
            }
        ),
        (
            size(),
            vec([-9..9, -9..9, -9..9].prop_map(IVec3::from), 1..30)
        )
            .prop_map(|(cell_size, cells)| ShapeDescription::Voxels { cell_size, cells }),
    ]
}

pub fn description() -> impl Strategy<Value = ShapeDescription> {
    let turn = (point(), 0.0..6f32)
        .prop_map(|(axis, angle)| Quat::from_axis_angle(axis.normalize_or(Vec3::Y), angle));
    let part = (point(), turn, bounded()).prop_map(|(position, rotation, shape)| PartDescription {
        position,
        rotation,
        shape,
    });
    prop_oneof![
        4 => bounded(),
        1 => point().prop_map(|normal| ShapeDescription::HalfSpace { normal }),
        1 => vec(part, 1..5).prop_map(|parts| ShapeDescription::Compound { parts }),
    ]
}

proptest! {
    /// The data of what was built builds the same, and is the data of that. It need not be what
    /// somebody wrote.
    #[test]
    fn shapes_give_their_data_back(data in description()) {
        // Corners on one line.
        let Ok(built) = data.build() else { return Ok(()) };
        let given = ShapeDescription::of(&built).unwrap();
        let again = given.build().unwrap();
        prop_assert_eq!(CollisionShape(again.clone()), CollisionShape(built));
        prop_assert_eq!(ShapeDescription::of(&again).unwrap(), given);
    }

    /// So do JSON and RON.
    #[cfg(all(feature = "reports", feature = "scene_files"))]
    #[test]
    fn text_gives_data_back(data in description()) {
        let json = serde_json::to_string(&data).unwrap();
        prop_assert_eq!(&serde_json::from_str::<ShapeDescription>(&json).unwrap(), &data);
        let ron = ron::to_string(&data).unwrap();
        prop_assert_eq!(&ron::from_str::<ShapeDescription>(&ron).unwrap(), &data);
    }
}
