//! Up to four points at which two entities lie on each other, for those who ask.

use crate::common;

use bevy::prelude::*;
use bevy_octree::{
    narrow_phase::{HeightField, Manifold, Shape, Voxels},
    prelude::*,
};
use common::*;

/// Two triangles, from (-4, 0, -4) to (4, 0, 4).
fn floor() -> CollisionShape {
    let corners = [[-4., -4.], [-4., 4.], [4., 4.], [4., -4.]];
    let corners = corners.map(|[x, z]| Vec3::new(x, 0.0, z));
    CollisionShape(Shape::mesh(corners, [[0, 1, 2], [0, 2, 3]]).unwrap())
}

fn cube() -> CollisionShape {
    CollisionShape(Shape::from_half_size(Vec3::splat(0.5)))
}

fn manifold(app: &App, a: Entity, b: Entity) -> Option<Manifold> {
    let contacts = app.world().resource::<Contacts>();
    let found = contacts.manifold(a, b);
    assert_eq!(found.map(Manifold::reversed), contacts.manifold(b, a));
    found
}

#[track_caller]
fn assert_stands(found: Option<Manifold>, place: Vec3, depth: f32) {
    let found = found.unwrap();
    let feet = [[1., 1.], [1., -1.], [-1., 1.], [-1., -1.]];
    let feet = feet.map(|[x, z]| place + Vec3::new(x, -1.0, z) * 0.5 + Vec3::Y * depth * 0.5);
    let is_there = |foot: &Vec3| {
        found
            .points()
            .iter()
            .any(|point| point.point.distance(*foot) < 1e-3 && (point.depth - depth).abs() < 1e-3)
    };
    assert!(
        found.points().len() == 4 && feet.iter().all(is_there),
        "{found:?}, expected {feet:?}"
    );
    assert!(found.normal.distance(Vec3::Y) < 1e-4, "{found:?}");
}

#[test]
fn who_asks_is_told_while_it_asks() {
    let mut app = app(BroadPhaseMethod::default());
    let floor = app.world_mut().spawn((floor(), StaticShape)).id();
    let place = Vec3::new(0.3, 0.45, 0.2);
    let at = Transform::from_translation(place);
    let body = app.world_mut().spawn((cube(), at)).id();
    tick(&mut app, 2);
    assert!(app.world().resource::<Contacts>().contains(floor, body));
    assert_eq!(manifold(&app, floor, body), None);

    // Of two at rest, too.
    app.world_mut().entity_mut(body).insert(ManifoldsEnabled);
    tick(&mut app, 1);
    assert_stands(manifold(&app, floor, body), place, 0.05);
    tick(&mut app, 3);
    assert_stands(manifold(&app, floor, body), place, 0.05);

    // It moves, and with it the points.
    let moved = place + Vec3::new(0.1, -0.01, -0.4);
    app.world_mut()
        .get_mut::<Transform>(body)
        .unwrap()
        .translation = moved;
    tick(&mut app, 1);
    assert_stands(manifold(&app, floor, body), moved, 0.06);
    tick(&mut app, 1);
    assert_stands(manifold(&app, floor, body), moved, 0.06);

    app.world_mut()
        .entity_mut(body)
        .remove::<ManifoldsEnabled>();
    tick(&mut app, 1);
    assert_eq!(manifold(&app, floor, body), None);
    app.world_mut()
        .resource_mut::<CollisionEventSettings>()
        .manifolds = EventScope::All;
    tick(&mut app, 1);
    assert_stands(manifold(&app, floor, body), moved, 0.06);

    app.world_mut().entity_mut(body).despawn();
    tick(&mut app, 1);
    assert_eq!(manifold(&app, floor, body), None);
}

#[test]
fn round_shapes_lie_on_grounds_of_all_kinds() {
    let cells = (-8..8).flat_map(|x| (-8..8).map(move |z| IVec3::new(x, -1, z)));
    let field = HeightField::new(9, 9, vec![0.0; 81], Vec2::ONE).unwrap();
    let grounds = [
        floor(),
        CollisionShape(Voxels::from_cells(0.5, cells).unwrap().into()),
        CollisionShape(field.into()),
        CollisionShape(Shape::half_space(Vec3::Y).unwrap()),
    ];
    for ground in grounds {
        let mut app = app(BroadPhaseMethod::default());
        let ground = app.world_mut().spawn((ground, StaticShape)).id();
        let lying = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let bodies = [
            (Shape::capsule(0.2, 1.0), 0.2, lying, 2),
            (Shape::cylinder(0.2, 1.0), 0.2, lying, 2),
            (Shape::cylinder(0.3, 1.0), 0.5, Quat::IDENTITY, 4),
            (Shape::sphere(0.4), 0.4, Quat::IDENTITY, 1),
        ];
        for (shape, height, turn, count) in bodies {
            let at = Transform::from_xyz(0.3, height - 0.01, 0.2).with_rotation(turn);
            let body = (CollisionShape(shape), ManifoldsEnabled, at);
            let body = app.world_mut().spawn(body).id();
            tick(&mut app, 1);
            let found = manifold(&app, ground, body).unwrap();
            assert_eq!(found.points().len(), count, "{found:?}");
            for point in found.points() {
                assert!((point.depth - 0.01).abs() < 1e-4, "{found:?}");
            }
            app.world_mut().entity_mut(body).despawn();
        }
    }
}

#[test]
fn what_slides_or_lands_on_the_way_has_them_too() {
    for (height, velocity) in [(0.5, Vec3::X), (0.9, Vec3::new(0.0, -32.0, 0.0))] {
        let mut app = app(BroadPhaseMethod::default());
        let floor = app.world_mut().spawn((floor(), StaticShape)).id();
        let body = (
            cube(),
            Swept::default(),
            Bounce::Reflect { restitution: 0.0 },
            ManifoldsEnabled,
            Velocity(velocity),
            Transform::from_xyz(0.1, height, 0.0),
        );
        let body = app.world_mut().spawn(body).id();
        for n in 0..20 {
            tick(&mut app, 1);
            let place = get::<Transform>(&app, body).translation;
            let found = manifold(&app, floor, body);
            assert!(found.is_some() || n == 0, "{height} {velocity}, tick {n}");
            if let Some(found) = found {
                let near = found
                    .points()
                    .iter()
                    .all(|point| point.point.y.abs() < 1e-3 && point.point.distance(place) < 0.95);
                assert!(found.points().len() == 4 && near, "{found:?} {place}");
            }
        }
    }
}
