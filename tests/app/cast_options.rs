//! Casts by their options, in headless apps.

use crate::common;

use bevy::{ecs::system::RunSystemOnce, prelude::*};
use bevy_octree::{
    narrow_phase::{Placed, Shape},
    prelude::*,
};
use common::*;

const ALL: SpatialQueryFilter = SpatialQueryFilter::DEFAULT;
const OPTIONS: RayCastOptions = RayCastOptions::DEFAULT;

fn ask<T: 'static>(
    app: &mut App,
    question: impl FnMut(SpatialQuery) -> T + Send + Sync + 'static,
) -> T {
    app.world_mut()
        .run_system_once(question)
        .expect("the plugins are there")
}

/// A cube, a ball, and an open square, two apart along x.
fn row() -> (App, [Entity; 3]) {
    let mut app = app(BroadPhaseMethod::default());
    let square = [[0., -1., -1.], [0., 1., -1.], [0., 1., 1.], [0., -1., 1.]].map(Vec3::from);
    let shapes = [
        CollisionShape::default(),
        CollisionShape::sphere(0.5),
        Shape::mesh(square, [[0, 1, 2], [0, 2, 3]]).unwrap().into(),
    ];
    let mut x = 0.0;
    let entities = shapes.map(|shape| {
        x += 2.0;
        app.world_mut()
            .spawn((shape, Transform::from_xyz(x, 0.0, 0.0)))
            .id()
    });
    tick(&mut app, 1);
    (app, entities)
}

#[test]
fn a_ray_goes_on_from_where_it_left() {
    let (mut app, [cube, ball, _]) = row();
    ask(&mut app, move |spatial| {
        let from = |point| Ray3d::new(point, Dir3::X);
        let through = |point| spatial.cast_ray_through(from(point), 100.0, &ALL).unwrap();
        let left = through(Vec3::new(0.0, 0.1, 0.0)).leave.unwrap();
        assert_eq!((left.entity, left.point.x), (cube, 2.5));
        // It is on the cube still.
        assert_eq!(through(left.point).entity, cube);
        let next = spatial.cast_ray_with(from(left.point), 100.0, &ALL, &OPTIONS.ignore_start());
        assert_eq!(next.unwrap().entity, ball);
    });
}

#[test]
fn rays_by_faces() {
    let (mut app, [cube, ball, square]) = row();
    ask(&mut app, move |spatial| {
        let mut hits = vec![];
        let mut cast = |x: f32, options: RayCastOptions| {
            let ray = Ray3d::new(Vec3::new(x, 0.1, 0.0), Dir3::X);
            spatial.ray_hits_with(ray, 100.0, &ALL, &options, &mut hits);
            let first = spatial.cast_ray_with(ray, 100.0, &ALL, &options);
            assert_eq!(first, hits.first().copied());
            let (mut batch, mut each) = (vec![], vec![]);
            spatial.cast_rays_with(&[ray; 3], 100.0, &ALL, &options, &mut batch);
            assert_eq!(batch, [first; 3]);
            spatial.for_each_ray_hit_with(ray, 100.0, &ALL, &options, |hit| each.push(hit));
            assert_eq!(each.len(), hits.len());
            if options == OPTIONS {
                assert_eq!(first, spatial.cast_ray(ray, 100.0, &ALL));
            }
            let about = |hit: &RayHit| {
                (
                    hit.entity,
                    (hit.distance * 10.0).round() / 10.0,
                    hit.is_back_face(),
                )
            };
            hits.iter().map(about).collect::<Vec<_>>()
        };
        // By the right-hand rule, the square faces along x.
        let all = [(cube, 1.5, false), (ball, 3.5, false), (square, 6.0, true)];
        assert_eq!(cast(0.0, OPTIONS), all);
        assert_eq!(cast(0.0, OPTIONS.front_faces()), all[..2]);
        assert_eq!(
            cast(0.0, OPTIONS.back_faces()),
            [(cube, 2.5, true), (ball, 4.5, true), (square, 6.0, true)]
        );
        // From inside.
        assert_eq!(cast(2.0, OPTIONS)[0], (cube, 0.0, false));
        assert_eq!(cast(2.0, OPTIONS.hollow())[0], (cube, 0.5, true));
        assert_eq!(
            cast(2.0, OPTIONS.hollow().front_faces())[0],
            (ball, 1.5, false)
        );
        // From what it starts on.
        assert_eq!(cast(2.5, OPTIONS)[0], (cube, 0.0, false));
        assert_eq!(cast(2.5, OPTIONS.ignore_start())[0], (ball, 1.0, false));
        assert_eq!(cast(1.5, OPTIONS.ignore_start())[0], (cube, 0.0, false));
        assert_eq!(cast(6.0, OPTIONS.ignore_start()), []);
    });
}

#[test]
fn rays_through_entities() {
    let (mut app, [cube, ball, square]) = row();
    ask(&mut app, move |spatial| {
        let mut passages = vec![];
        let mut cast = |x: f32, length: f32| {
            let ray = Ray3d::new(Vec3::X * x, Dir3::X);
            spatial.ray_passages(ray, length, &ALL, &mut passages);
            let first = spatial.cast_ray_through(ray, length, &ALL);
            assert_eq!(first, passages.first().copied());
            let ends = |passage: &RayPassage| {
                let [enter, leave] =
                    [passage.enter, passage.leave].map(|end| end.map(|end| end.distance));
                (passage.entity, enter, leave)
            };
            passages.iter().map(ends).collect::<Vec<_>>()
        };
        let all = [
            (cube, Some(1.5), Some(2.5)),
            (ball, Some(3.5), Some(4.5)),
            (square, Some(6.0), None),
        ];
        assert_eq!(cast(0.0, 100.0), all);
        assert_eq!(cast(0.0, 4.0), [all[0], (ball, Some(3.5), None)]);
        assert_eq!(
            cast(2.0, 2.0),
            [(cube, None, Some(0.5)), (ball, Some(1.5), None)]
        );
        assert_eq!(cast(9.0, 100.0), []);
        let ray = Ray3d::new(Vec3::ZERO, Dir3::X);
        let through = spatial
            .cast_ray_through(ray, 100.0, &ALL.except(cube))
            .unwrap();
        assert_eq!(
            (through.entity, through.start(), through.length()),
            (ball, 3.5, Some(1.0))
        );
    });
}

#[test]
fn hits_name_the_polygon() {
    let (mut app, [_, _, square]) = row();
    ask(&mut app, move |spatial| {
        let polygon = |y: f32, z: f32| {
            let ray = Ray3d::new(Vec3::new(9.0, y, z), Dir3::NEG_X);
            let hit = spatial.cast_ray(ray, 100.0, &ALL).unwrap();
            assert_eq!(
                (hit.entity, hit.face_normal, hit.normal),
                (square, Vec3::X, Vec3::X)
            );
            hit.polygon
        };
        assert_eq!([polygon(0.7, 0.2), polygon(0.2, 0.7)], [Some(0), Some(1)]);
    });
}

#[test]
fn what_stands_on_the_ground_is_cast_along_it() {
    let mut app = app(BroadPhaseMethod::default());
    let at = Transform::from_translation;
    let ground = CollisionShape::cuboid(20.0, 1.0, 20.0);
    let ground = app.world_mut().spawn((ground, at(Vec3::Y * -0.5))).id();
    let wall = app
        .world_mut()
        .spawn((CollisionShape::default(), at(Vec3::new(5.0, 0.5, 0.0))))
        .id();
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let (ball, start) = (Shape::sphere(0.5), at(Vec3::Y * 0.5));
        let moving = Placed::new(&ball, &start);
        let options = ShapeCastOptions::DEFAULT;
        let cast = |way, options| {
            let hit = spatial.cast_shape_with(moving, way, 9.0, &ALL, &options)?;
            Some((hit.entity, hit.distance))
        };
        let same = spatial.cast_shape(&ball, &start, Dir3::X, 9.0, &ALL);
        assert_eq!(
            same.map(|hit| (hit.entity, hit.distance)),
            Some((ground, 0.0))
        );
        assert_eq!(cast(Dir3::X, options), Some((ground, 0.0)));
        assert_eq!(cast(Dir3::X, options.ignore_start()), Some((wall, 4.0)));
        assert_eq!(cast(Dir3::Z, options.ignore_start()), None);
        assert_eq!(cast(Dir3::Y, options.ignore_start()), None);
        assert_eq!(
            cast(Dir3::NEG_Y, options.ignore_start()),
            Some((ground, 0.0))
        );
        let deeper = at(Vec3::Y * 0.25);
        let hit =
            spatial.cast_shape_with(Placed::new(&ball, &deeper), Dir3::Y, 9.0, &ALL, &options);
        let hit = hit.unwrap();
        assert!(
            (hit.depth - 0.25).abs() < 1e-5
                && hit.face_normal == Vec3::Y
                && hit.normal == Vec3::NEG_Y
        );
    });
}

#[test]
#[cfg(feature = "rapier")]
fn shapes_of_rapier() {
    use bevy_rapier3d::prelude::Collider;
    let mut app = app(BroadPhaseMethod::default());
    let square = [[0., -1., -1.], [0., 1., -1.], [0., 1., 1.], [0., -1., 1.]].map(Vec3::from);
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let two = |x: f32| (Vec3::X * x, Quat::IDENTITY, Collider::capsule_y(1.0, 0.5));
    let shapes = [
        Collider::capsule_y(1.0, 0.5),
        Collider::compound(vec![two(-0.25), two(0.25)]),
        Collider::trimesh(square.to_vec(), triangles).unwrap(),
    ];
    let mut x = 0.0;
    let [capsule, both, mesh] = shapes.map(|shape| {
        x += 2.0;
        let shape = CollisionShape::from(Shape::from(&shape));
        app.world_mut()
            .spawn((shape, Transform::from_xyz(x, 0.0, 0.0)))
            .id()
    });
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let cast = |x: f32, way: Vec3, options| {
            let ray = Ray3d::new(Vec3::new(x, 0.1, -0.05), Dir3::new(way).unwrap());
            let hit = spatial.cast_ray_with(ray, 100.0, &ALL, &options)?;
            Some((
                hit.entity,
                (hit.distance * 100.0).round() / 100.0,
                hit.is_back_face(),
            ))
        };
        let (there, back) = (Vec3::X, Vec3::NEG_X);
        assert_eq!(cast(2.0, there, OPTIONS), Some((capsule, 0.0, false)));
        assert_eq!(
            cast(2.0, there, OPTIONS.hollow()),
            Some((capsule, 0.5, true))
        );
        assert_eq!(
            cast(0.0, there, OPTIONS.back_faces()),
            Some((capsule, 2.5, true))
        );
        assert_eq!(
            cast(0.0, there, OPTIONS.front_faces()),
            Some((capsule, 1.5, false))
        );
        assert_eq!(cast(5.0, there, OPTIONS.front_faces()), None);
        assert_eq!(
            cast(5.0, there, OPTIONS.back_faces()),
            Some((mesh, 1.0, true))
        );
        assert_eq!(
            cast(9.0, back, OPTIONS.front_faces()),
            Some((mesh, 3.0, false))
        );
        assert_eq!(cast(6.0, there, OPTIONS), Some((mesh, 0.0, true)));
        assert_eq!(cast(6.0, there, OPTIONS.ignore_start()), None);
        assert_eq!(
            cast(6.0, back, OPTIONS.ignore_start()),
            Some((both, 1.25, false))
        );
        let mut passages = vec![];
        spatial.ray_passages(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &ALL, &mut passages);
        let lengths: Vec<_> = passages
            .iter()
            .map(|passage| (passage.entity, passage.length()))
            .collect();
        let is_near = |found: Option<f32>, expected: f32| {
            found.is_some_and(|found| (found - expected).abs() < 1e-4)
        };
        assert!(
            matches!(lengths[..], [(a, one), (b, union), (c, None)]
                if [a, b, c] == [capsule, both, mesh] && is_near(one, 1.0) && is_near(union, 1.5)),
            "{lengths:?}"
        );
        let triangle = |y: f32, z: f32| {
            let ray = Ray3d::new(Vec3::new(9.0, y, z), Dir3::NEG_X);
            let hit = spatial.cast_ray(ray, 100.0, &ALL).unwrap();
            let same = spatial
                .cast_ray_with(ray, 100.0, &ALL, &OPTIONS.hollow())
                .unwrap();
            assert_eq!(
                (hit.face_normal, hit.polygon),
                (same.face_normal, same.polygon)
            );
            hit.polygon
        };
        assert_eq!([triangle(0.7, 0.2), triangle(0.2, 0.7)], [Some(0), Some(1)]);
    });
}
