//! What constructors make of numbers, good and bad.

use bevy::math::primitives::{
    Circle, ConvexPolygon, Cuboid, Extrusion, Plane3d, Rectangle, RegularPolygon, Rhombus, Sphere,
    Tetrahedron, Triangle2d, Triangle3d,
};
use bevy::math::{Dir3, Quat, Vec2, Vec3};
use bevy::transform::components::Transform;

use crate::narrow_phase::*;

/// How far a shape at the origin reaches along an axis, by rays from both sides.
fn extent(shape: &Shape, axis: Vec3) -> f32 {
    let (here, tests) = (Transform::IDENTITY, NarrowPhase::default());
    let reach = |towards: Vec3| {
        let direction = Dir3::new(-towards).unwrap();
        let hit = tests.cast_ray(Placed::new(shape, &here), towards * 10.0, direction, 20.0);
        10.0 - hit.unwrap().distance
    };
    reach(axis) + reach(-axis)
}

fn assert_sizes(shape: impl Into<Shape>, sizes: Vec3) {
    let shape = shape.into();
    let found = Vec3::AXES.map(|axis| extent(&shape, axis));
    assert!(
        (Vec3::from(found) - sizes).abs().max_element() < 1e-5,
        "{shape:?}: {found:?}, not {sizes}"
    );
}

fn is_nothing(shape: impl Into<Shape>) -> bool {
    shape.into().world_aabb(&Transform::IDENTITY) == Err(BoundsError::NonFinite)
}

#[test]
fn sides_are_whole_and_halves_are_halves() {
    let size = Vec3::new(1.0, 2.0, 3.0);
    assert_sizes(Shape::cuboid(1.0, 2.0, 3.0), size);
    assert_sizes(Shape::try_cuboid(1.0, 2.0, 3.0).unwrap(), size);
    assert_sizes(Shape::from_half_size(size / 2.0), size);
    assert_sizes(Shape::try_from_half_size(size / 2.0).unwrap(), size);
    assert_sizes(Cuboid::new(1.0, 2.0, 3.0), size);
    assert_sizes(Extrusion::new(Rectangle::new(1.0, 2.0), 3.0), size);
    for ball in [
        Shape::sphere(0.5),
        Shape::try_sphere(0.5).unwrap(),
        Sphere::new(0.5).into(),
    ] {
        assert_sizes(ball, Vec3::ONE);
    }
}

#[test]
fn polyhedra_are_those_of_bevy() {
    let diamond = Extrusion::new(Rhombus::new(2.0, 1.0), 0.5);
    assert_sizes(diamond, Vec3::new(2.0, 1.0, 0.5));
    let square = [
        Vec2::NEG_ONE,
        Vec2::new(1.0, -1.0),
        Vec2::ONE,
        Vec2::new(-1.0, 1.0),
    ];
    assert_sizes(
        Extrusion::new(ConvexPolygon::new(square).unwrap(), 0.5),
        Vec3::new(2.0, 2.0, 0.5),
    );
    let hexagon = Shape::from(Extrusion::new(RegularPolygon::new(1.0, 6), 2.0));
    assert!(
        (extent(&hexagon, Vec3::Y) - 2.0).abs() < 1e-5
            && (extent(&hexagon, Vec3::X) - 3f32.sqrt()).abs() < 1e-5
    );
    for turned in [[0, 1, 2], [0, 2, 1]] {
        let corners = [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::Y];
        let [a, b, c] = turned.map(|corner| corners[corner]);
        let wedge = Shape::from(Extrusion::new(Triangle2d::new(a, b, c), 4.0));
        assert_sizes(wedge, Vec3::new(1.0, 2.0, 4.0));
    }

    let simplex = Tetrahedron::default();
    let Shape::Convex(mesh) = Shape::from(simplex) else {
        panic!("a tetrahedron is convex")
    };
    assert_eq!(mesh.vertices(), simplex.vertices);
    let outwards = mesh.polygons().zip(mesh.normals());
    assert!(
        outwards
            .into_iter()
            .all(|(corners, normal)| mesh.vertices()[corners[0] as usize].dot(*normal) > 0.0)
    );

    let triangle = Shape::from(Triangle3d::new(Vec3::NEG_X, Vec3::X, Vec3::Y));
    assert!(matches!(&triangle, Shape::Mesh(mesh) if !mesh.is_closed()));
    let normal = Vec3::new(1.0, 2.0, -0.5).normalize();
    let plane = Shape::from(Plane3d::new(normal, Vec2::new(2.0, 1.0)));
    let Shape::Mesh(mesh) = &plane else {
        panic!("a plane is a surface")
    };
    assert!(mesh.normals()[0].distance(normal) < 1e-6);
    let upright = Quat::from_rotation_arc(normal, Vec3::Y);
    for corner in mesh.vertices() {
        let found = (upright * corner).abs();
        assert!(
            found.distance(Vec3::new(2.0, 0.0, 1.0)) < 1e-5,
            "{corner}, upright {found}"
        );
    }
}

#[test]
fn negative_sizes_count_as_absolute_ones() {
    let size = Vec3::new(1.0, 2.0, 3.0);
    assert_sizes(Shape::cuboid(1.0, -2.0, 3.0), size);
    assert_sizes(Shape::from_half_size(-size / 2.0), size);
    assert_sizes(
        Cuboid {
            half_size: -size / 2.0,
        },
        size,
    );
    assert_sizes(Shape::sphere(-0.5), Vec3::ONE);
    assert_sizes(
        Extrusion::new(
            Rhombus {
                half_diagonals: Vec2::new(-1.0, 0.5),
            },
            -0.5,
        ),
        Vec3::new(2.0, 1.0, 0.5),
    );
}

/// A polygon with an odd number of sides is not its own image, upside down.
#[test]
fn solids_of_negative_sizes_are_those_of_absolute_ones() {
    let polygon = |radius, sides| RegularPolygon {
        circumcircle: Circle { radius },
        sides,
    };
    let rhombus = |x, y| Rhombus {
        half_diagonals: Vec2::new(x, y),
    };
    let plane = |x, y| Plane3d {
        half_size: Vec2::new(x, y),
        ..Plane3d::default()
    };
    let triangle = Triangle2d::default();
    let hull = ConvexPolygon::new(triangle.vertices).unwrap();
    let prism = |half_depth| Extrusion {
        base_shape: hull.clone(),
        half_depth,
    };
    let wedge = |half_depth| Extrusion {
        base_shape: triangle,
        half_depth,
    };
    let pairs: [[Shape; 2]; 11] = [
        [-1.0, 1.0].map(|r| Extrusion::new(polygon(r, 3), 2.0).into()),
        [-1.0, 1.0].map(|r| Extrusion::new(polygon(r, 5), 2.0 * r).into()),
        [-2.0, 2.0].map(|depth| Extrusion::new(polygon(1.0, 5), depth).into()),
        [-1.0, 1.0].map(|x| Extrusion::new(rhombus(x, 0.5), 2.0).into()),
        [-1.0, 1.0].map(|y| Extrusion::new(rhombus(0.5, y), 2.0).into()),
        [-2.0, 2.0].map(|depth| Extrusion::new(rhombus(1.0, 0.5), depth).into()),
        [-1.0, 1.0].map(|x| plane(x, 2.0).into()),
        [-1.0, 1.0].map(|y| plane(2.0, y).into()),
        [-1.0, 1.0].map(|both| plane(both, both).into()),
        [-1.0, 1.0].map(|half_depth| prism(half_depth).into()),
        [-1.0, 1.0].map(|half_depth| wedge(half_depth).into()),
    ];
    for (index, [negative, positive]) in pairs.iter().enumerate() {
        let parts = |shape: &Shape| {
            let (mesh, _) = shape.polygons().unwrap();
            let polygons: Vec<_> = mesh.polygons().map(<[u32]>::to_vec).collect();
            (mesh.vertices().to_vec(), polygons, mesh.normals().to_vec())
        };
        assert_eq!(parts(negative), parts(positive), "{index}");
    }
}

#[test]
fn what_is_no_size_makes_nothing() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(is_nothing(Shape::cuboid(1.0, bad, 1.0)) && is_nothing(Shape::sphere(bad)));
        assert!(is_nothing(Cuboid::new(bad, 1.0, 1.0)) && is_nothing(Sphere::new(bad)));
        assert!(is_nothing(Triangle3d::new(
            Vec3::X,
            Vec3::splat(bad),
            Vec3::Y
        )));
        assert!(is_nothing(Extrusion::new(Rectangle::new(1.0, 1.0), bad)));
        assert!(is_nothing(Extrusion::new(RegularPolygon::new(1.0, 5), bad)));
    }
    assert!(is_nothing(Triangle3d::new(
        Vec3::X,
        Vec3::ZERO,
        Vec3::NEG_X
    )));
    assert!(is_nothing(Tetrahedron::new(
        Vec3::X,
        Vec3::ZERO,
        Vec3::NEG_X,
        Vec3::Y
    )));
    assert!(is_nothing(Plane3d::new(Vec3::Y, Vec2::new(0.0, 1.0))));
}

#[test]
fn those_that_try_name_what_is_wrong() {
    let sizes = [
        Vec3::new(-1.0, 1.0, 1.0),
        Vec3::new(1.0, f32::INFINITY, 1.0),
    ];
    for size in sizes {
        assert_eq!(
            Shape::try_cuboid(size.x, size.y, size.z).unwrap_err(),
            ShapeError::Size(size)
        );
        assert_eq!(
            Shape::try_from_half_size(size).unwrap_err(),
            ShapeError::HalfSize(size)
        );
    }
    assert_eq!(
        Shape::try_sphere(-1.0).unwrap_err(),
        ShapeError::Radius(-1.0)
    );
    assert!(Shape::try_cuboid(0.0, f32::MAX, 0.0).is_ok() && Shape::try_sphere(0.0).is_ok());
}
