//! Shapes as a game writes them.

use bevy::{
    math::{bounding::Bounded3d, primitives::Primitive2d},
    prelude::*,
};
use bevy_octree::{components::WorldAabb, prelude::*};

use crate::common::warnings::{told, warnings};

/// The shape of each entity, with what is known of its box after a tick.
fn boxes(shapes: Vec<CollisionShape>) -> Vec<WorldAabb> {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    let entities = shapes
        .into_iter()
        .map(|shape| app.world_mut().spawn(shape).id())
        .collect::<Vec<_>>();
    app.update();
    entities
        .into_iter()
        .map(|entity| *app.world().get(entity).unwrap())
        .collect()
}

#[test]
fn shapes_are_as_large_as_the_primitives_of_bevy() {
    let (brick, ball, simplex) = (
        Cuboid::new(1.0, 2.0, 3.0),
        Sphere::new(0.5),
        Tetrahedron::default(),
    );
    let triangle = Triangle3d::new(Vec3::NEG_X, Vec3::X, Vec3::Y);
    let expected = [
        brick.aabb_3d(Isometry3d::IDENTITY),
        brick.aabb_3d(Isometry3d::IDENTITY),
        ball.aabb_3d(Isometry3d::IDENTITY),
        ball.aabb_3d(Isometry3d::IDENTITY),
        bevy::math::bounding::Aabb3d::from_point_cloud(
            Isometry3d::IDENTITY,
            simplex.vertices.into_iter(),
        ),
        triangle.aabb_3d(Isometry3d::IDENTITY),
    ];
    let found = boxes(vec![
        brick.into(),
        CollisionShape::cuboid(1.0, 2.0, 3.0),
        CollisionShape::from(ball),
        CollisionShape::sphere(0.5),
        simplex.into(),
        triangle.into(),
    ]);
    for (found, expected) in found.into_iter().zip(expected) {
        let off = (found.min - expected.min)
            .abs()
            .max((found.max - expected.max).abs())
            .max_element();
        assert!(off < 1e-3, "{found:?} {expected:?}");
    }
}

#[test]
fn bad_numbers_are_logged_and_never_panic() {
    for good in [0.0, 1.0, f32::MAX / 4.0] {
        let made = || {
            drop((
                CollisionShape::sphere(good),
                CollisionShape::cuboid(good, good, good),
            ));
        };
        assert_eq!(warnings(made), 0, "{good}");
    }
    for bad in [-1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(warnings(|| drop(CollisionShape::sphere(bad))), 1, "{bad}");
        assert_eq!(
            warnings(|| drop(CollisionShape::cuboid(1.0, bad, 1.0))),
            1,
            "{bad}"
        );
        assert_eq!(
            warnings(|| drop(CollisionShape::from_half_size(Vec3::splat(bad)))),
            1,
            "{bad}"
        );
        assert_eq!(
            warnings(|| drop(CollisionShape::from(Cuboid::new(bad, 1.0, 1.0)))),
            1,
            "{bad}"
        );
        let refused = || assert!(CollisionShape::try_sphere(bad).is_err());
        assert_eq!(warnings(refused), 0, "{bad}");
    }
    let flat = || {
        drop(CollisionShape::from(Tetrahedron::new(
            Vec3::X,
            Vec3::Y,
            Vec3::ZERO,
            Vec3::ONE.with_z(0.0),
        )));
    };
    assert_eq!(warnings(flat), 1);
    let found = boxes(vec![
        CollisionShape::sphere(f32::NAN),
        CollisionShape::sphere(-1.0),
    ]);
    assert_eq!(found[0], WorldAabb::NONE, "it takes no part");
    assert!((found[1].max.x - 1.0).abs() < 1e-3, "{found:?}");
}

/// A name, and what is made of a size.
type Made = (&'static str, fn(f32) -> CollisionShape);

/// Each primitive that has sizes, one of which is given.
const OF_SIZES: [Made; 10] = [
    ("cuboid", |x| {
        Cuboid {
            half_size: Vec3::new(1.0, x, 1.0),
        }
        .into()
    }),
    ("sphere", |radius| Sphere { radius }.into()),
    ("plane", |x| plane(Vec2::new(x, 1.0)).into()),
    ("square plane", |x| plane(Vec2::splat(x)).into()),
    ("rectangle", |x| {
        prism(
            Rectangle {
                half_size: Vec2::new(1.0, x),
            },
            1.0,
        )
        .into()
    }),
    ("triangle", |depth| {
        prism(Triangle2d::default(), depth).into()
    }),
    ("rhombus", |x| {
        prism(
            Rhombus {
                half_diagonals: Vec2::new(1.0, x),
            },
            1.0,
        )
        .into()
    }),
    ("flat rhombus", |depth| {
        prism(Rhombus::default(), depth).into()
    }),
    ("polygon", |radius| {
        let circumcircle = Circle { radius };
        prism(
            RegularPolygon {
                circumcircle,
                sides: 5,
            },
            1.0,
        )
        .into()
    }),
    ("convex polygon", |depth| {
        prism(
            ConvexPolygon::new(Triangle2d::default().vertices).unwrap(),
            depth,
        )
        .into()
    }),
];

fn plane(half_size: Vec2) -> Plane3d {
    Plane3d {
        normal: Dir3::Y,
        half_size,
    }
}

fn prism<T: Primitive2d>(base_shape: T, half_depth: f32) -> Extrusion<T> {
    Extrusion {
        base_shape,
        half_depth,
    }
}

#[test]
fn every_bad_size_of_a_primitive_is_logged_once() {
    for (name, made) in OF_SIZES {
        assert_eq!(told(|| drop(made(1.0))), [""; 0], "{name}");
        for bad in [-1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let logged = told(|| drop(made(bad)));
            assert_eq!(logged.len(), 1, "{name} {bad}: {logged:?}");
            let expected = if bad.is_finite() {
                "the absolute value is used"
            } else {
                "the shape is in contact with nothing"
            };
            assert!(logged[0].ends_with(expected), "{name} {bad}: {logged:?}");
            assert!(logged[0].contains(&bad.to_string()), "{name}: {logged:?}");
        }
    }
}

#[test]
fn warnings_name_the_sizes_that_were_given() {
    let logged = told(|| drop(CollisionShape::cuboid(-2.0, 4.0, 6.0)));
    assert_eq!(
        logged,
        [
            "the sides of a cuboid must be finite and not negative, got [-2, 4, 6]: the absolute value is used"
        ]
    );
    let both = told(|| drop(CollisionShape::from(plane(Vec2::new(-2.0, 0.0)))));
    assert_eq!(both.len(), 1, "{both:?}");
}
