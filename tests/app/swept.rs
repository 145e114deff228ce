//! Continuous detection: what moves far in a tick is met on the way.

use crate::hook;
use crate::{bullets::*, common};

use bevy::prelude::*;
use bevy_octree::{
    broad_phase::ObjectOctreeSettings,
    components::WorldAabb,
    motion::{MotionSettings, Step},
    narrow_phase::Shape,
    prelude::*,
};
use common::*;
use hook::*;

/// The way per tick.
fn step(app: &App, entity: Entity) -> Vec3 {
    get::<Velocity>(app, entity).0 / TICKS_PER_SECOND
}

fn assert_near(found: Vec3, expected: Vec3, within: f32) {
    assert!(
        found.distance(expected) <= within,
        "{found}, expected {expected}"
    );
}

/// The time of impact of two in contact.
fn time(app: &App, a: Entity, b: Entity) -> Option<f32> {
    app.world().resource::<Contacts>().time_of_impact(a, b)
}

#[test]
fn a_bullet_at_a_thousand_sides_per_tick_does_not_pass_through_paper() {
    let mut app = app(BroadPhaseMethod::default());
    let wall = paper(&mut app, 0.0);
    let without = bullet(&mut app, Vec3::new(-30.0, 1.0, 0.0), Vec3::X * 100.0);
    app.world_mut()
        .entity_mut(without)
        .remove::<Swept>()
        .insert(ELASTIC);
    let with = elastic_bullet(&mut app, Vec3::X * -30.0, Vec3::X * 100.0);
    tick(&mut app, 1);
    assert_near(place(&app, without), Vec3::new(70.0, 1.0, 0.0), 1e-3);
    let touch = -0.051;
    assert_near(place(&app, with), Vec3::X * (touch - (70.0 - touch)), 1e-3);
    assert_near(step(&app, with), Vec3::X * -100.0, 1e-3);
    assert_eq!(
        (contacts(&app), counters(&app).bounces),
        (vec![pair(with, wall)], 1)
    );
    assert!((time(&app, with, wall).unwrap() - (30.0 + touch) / 100.0).abs() < 1e-5);
    tick(&mut app, 1);
    assert_near(place(&app, with), Vec3::X * (touch - (170.0 - touch)), 1e-3);
    assert_eq!(messages_about(&app, pair(with, wall)), (1, 1));
}

#[test]
fn two_bullets_meet_head_on() {
    let mut app = app(BroadPhaseMethod::default());
    let bullets = [1.0, -1.0]
        .map(|side| elastic_bullet(&mut app, Vec3::X * -60.0 * side, Vec3::X * 100.0 * side));
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [bullets]);
    assert!((time(&app, bullets[0], bullets[1]).unwrap() - 0.5995).abs() < 1e-5);
    for (bullet, side) in bullets.into_iter().zip([-1.0, 1.0]) {
        assert_near(place(&app, bullet), Vec3::X * (40.0 + 0.1) * side, 1e-3);
        assert_near(step(&app, bullet), Vec3::X * 100.0 * side, 1e-3);
    }
    assert_eq!(counters(&app).bounces, 2);
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, bullets), (1, 1));
}

#[test]
fn without_bounce_all_that_is_on_the_way_is_met_in_time() {
    let mut app = app(BroadPhaseMethod::default());
    let walls = [0.0, 10.0, 40.0].map(|x| paper(&mut app, x));
    let behind = paper(&mut app, 80.0);
    let bullet = bullet(&mut app, Vec3::X * -30.0, Vec3::X * 100.0);
    tick(&mut app, 1);
    assert_eq!(contacts(&app), walls.map(|wall| pair(bullet, wall)));
    for (wall, x) in walls.into_iter().zip([0.0, 10.0, 40.0]) {
        assert!((time(&app, bullet, wall).unwrap() - (x + 30.0 - 0.051) / 100.0).abs() < 1e-5);
    }
    assert_near(place(&app, bullet), Vec3::X * 70.0, 1e-3);
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(bullet, behind)]);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    for wall in walls.into_iter().chain([behind]) {
        assert_eq!(messages_about(&app, pair(bullet, wall)), (1, 1));
    }
}

/// What is behind the first wall is not met, though the way as it began leads there.
#[test]
fn what_a_bounce_prevents_is_no_contact_and_what_it_leads_to_is() {
    let mut app = app(BroadPhaseMethod::default());
    let (front, behind) = (paper(&mut app, 0.0), paper(&mut app, 1.0));
    let back = paper(&mut app, -5.0);
    let bullet = elastic_bullet(&mut app, Vec3::X * -2.0, Vec3::X * 4.0);
    tick(&mut app, 1);
    assert_eq!(
        contacts(&app),
        [pair(bullet, front)],
        "of {behind} and {back} neither"
    );
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(bullet, back)]);
    assert!(place(&app, bullet).x > -5.0);
}

/// Between two walls, `2 * half` apart as a ball's centre sees it, the place is a triangle wave of
/// the distance covered.
fn between(half: f32, covered: f32) -> f32 {
    let phase = (covered + half).rem_euclid(4.0 * half);
    if phase < 2.0 * half {
        phase - half
    } else {
        3.0 * half - phase
    }
}

#[test]
fn a_bullet_bounces_many_times_in_a_tick() {
    let mut app = app(BroadPhaseMethod::default());
    for x in [-1.0, 1.0] {
        paper(&mut app, x);
    }
    let bullet = elastic_bullet(&mut app, Vec3::ZERO, Vec3::X * 12.5);
    let half = 1.0 - 0.051;
    for n in 1..=20 {
        tick(&mut app, 1);
        let expected = Vec3::X * between(half, 12.5 * n as f32);
        assert_near(place(&app, bullet), expected, 2e-3);
        assert!((6..=7).contains(&counters(&app).bounces));
        assert_eq!(contacts(&app).len(), 2);
    }
}

#[test]
fn a_bound_on_the_bounces_of_a_tick_holds() {
    for bound in [0, 1, 5] {
        let mut app = app(BroadPhaseMethod::default());
        for x in [-1.0, 1.0] {
            paper(&mut app, x);
        }
        let bullet = elastic_bullet(&mut app, Vec3::ZERO, Vec3::X * 1000.0);
        app.world_mut().entity_mut(bullet).insert(Swept::new(bound));
        for n in 1..=3_u64 {
            tick(&mut app, 1);
            assert_eq!(counters(&app).bounces, u64::from(bound));
            // At the wall of the last impact, on whose side it is by turns.
            let impacts = if bound == 0 {
                1
            } else {
                n * u64::from(bound) + 1
            };
            let side = if impacts % 2 == 1 { 1.0 } else { -1.0 };
            assert_near(place(&app, bullet), Vec3::X * side * (1.0 - 0.051), 1e-3);
            assert!((step(&app, bullet).length() - 1000.0).abs() < 1e-2);
        }
    }
}

/// Sixteen bodies in a room, with full steps and with a thousandth of them: the places after
/// `ticks` ticks, and how often something bounced in each of them.
fn in_a_room(
    shape: &CollisionShape,
    ticks: usize,
    steps: u32,
    swept: bool,
) -> (Vec<u64>, Vec<Vec3>) {
    let mut app = app(BroadPhaseMethod::default());
    app.insert_resource(MotionSettings {
        step: Step::Seconds(1.0 / TICKS_PER_SECOND / steps as f32),
    });
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-1.0, 1.0] {
            wall(
                &mut app,
                axis * side * 10.5,
                Vec3::splat(20.0) * (Vec3::ONE - axis) + axis * 0.5,
            );
        }
    }
    let mut random = fastrand::Rng::with_seed(7);
    let mut vector =
        |size: f32| Vec3::from_array([0; 3].map(|_| (random.f32() * 2.0 - 1.0) * size));
    let bodies: Vec<_> = (0..16)
        .map(|number| {
            let grid = Vec3::new((number % 4) as f32, (number / 4) as f32, 0.0) * 4.0
                - Vec3::new(6.0, 6.0, 0.0);
            let body = elastic_bullet(&mut app, grid + vector(1.0), vector(8.0));
            app.world_mut().entity_mut(body).insert(shape.clone());
            if !swept {
                app.world_mut().entity_mut(body).remove::<Swept>();
            }
            body
        })
        .collect();
    let mut bounces = Vec::new();
    for _ in 0..ticks {
        let before = app.world().resource::<CollisionCounters>().total.bounces;
        tick(&mut app, steps as usize);
        bounces.push(app.world().resource::<CollisionCounters>().total.bounces - before);
    }
    (
        bounces,
        bodies.iter().map(|body| place(&app, *body)).collect(),
    )
}

/// Small steps find contacts up to a step too late, by which places differ; and where round things
/// meet, directions do.
#[test]
fn it_comes_to_the_same_as_a_thousand_small_steps() {
    let cube = CollisionShape::from_half_size(Vec3::splat(0.9));
    let ball = CollisionShape::sphere(0.9);
    for (shape, ticks, within) in [(cube, 4, 0.05), (ball, 1, 0.25)] {
        let (coarse, fine) = (
            in_a_room(&shape, ticks, 1, true),
            in_a_room(&shape, ticks, 1000, false),
        );
        assert!(
            fine.0.iter().sum::<u64>() > 10 * ticks as u64,
            "{:?}",
            fine.0
        );
        assert_eq!(coarse.0, fine.0);
        for (coarse, fine) in coarse.1.into_iter().zip(fine.1) {
            assert_near(coarse, fine, within);
        }
    }
}

#[test]
fn every_broad_phase_gives_the_same() {
    let run = |method: BroadPhaseMethod| {
        let mut app = app(method);
        paper(&mut app, -12.0);
        paper(&mut app, 12.0);
        let mut random = fastrand::Rng::with_seed(3);
        let mut vector =
            |size: f32| Vec3::from_array([0; 3].map(|_| (random.f32() * 2.0 - 1.0) * size));
        let balls: Vec<_> = (0..200)
            .map(|_| {
                let (start, step) = (vector(10.0), vector(5.0));
                elastic_bullet(&mut app, start, step)
            })
            .collect();
        for ball in &balls {
            app.world_mut()
                .entity_mut(*ball)
                .insert(CollisionShape::sphere(0.5));
        }
        tick(&mut app, 10);
        let places: Vec<_> = balls.iter().map(|ball| place(&app, *ball)).collect();
        (
            app.world().resource::<Log>().clone(),
            app.world().resource::<CollisionCounters>().total.bounces,
            places,
        )
    };
    let expected = run(BroadPhaseMethod::Exhaustive);
    assert!(expected.1 > 300, "{}", expected.1);
    for method in [
        BroadPhaseMethod::LinearOctree,
        BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::default()),
    ] {
        let found = run(method);
        assert_eq!((found.1, &found.2), (expected.1, &expected.2));
        assert!(found.0 == expected.0);
    }
}

/// It has no tick behind it from which its way could begin.
#[test]
fn the_first_tick_of_a_bullet_counts() {
    let mut app = app(BroadPhaseMethod::default());
    let wall = paper(&mut app, 0.0);
    tick(&mut app, 3);
    let bullet = bullet(&mut app, Vec3::X * -1.0, Vec3::X * 100.0);
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(bullet, wall)]);
}

#[test]
fn whoever_moves_it_it_is_swept_unless_it_is_put_elsewhere() {
    let mut app = app(BroadPhaseMethod::default());
    let wall = paper(&mut app, 0.0);
    let bullet = bullet(&mut app, Vec3::X * -10.0, Vec3::ZERO);
    tick(&mut app, 1);
    get_mut::<Transform>(&mut app, bullet).translation.x = 10.0;
    tick(&mut app, 1);
    assert_eq!(
        (contacts(&app), place(&app, bullet).x),
        (vec![pair(bullet, wall)], 10.0)
    );
    // At rest, its box shrinks.
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    let aabb = get::<WorldAabb>(&app, bullet).0;
    assert!((aabb.max - aabb.min).max_element() < 0.101);
    get_mut::<Transform>(&mut app, bullet).translation.x = -10.0;
    app.world_mut().entity_mut(bullet).insert(Swept::default());
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    // What is no longer swept has no way either.
    get_mut::<Transform>(&mut app, bullet).translation.x = 10.0;
    app.world_mut().entity_mut(bullet).remove::<Swept>();
    tick(&mut app, 2);
    assert!(contacts(&app).is_empty());
    let aabb = get::<WorldAabb>(&app, bullet).0;
    assert!((aabb.max - aabb.min).max_element() < 0.101);
}

#[test]
fn who_was_away_has_not_passed_through_what_is_between() {
    use bevy::ecs::entity_disabling::Disabled;
    let mut app = app(BroadPhaseMethod::default());
    paper(&mut app, 0.0);
    let bullets = [0.0, 1.0].map(|y| bullet(&mut app, Vec3::new(-10.0, y, 0.0), Vec3::ZERO));
    tick(&mut app, 1);
    app.world_mut().entity_mut(bullets[0]).insert(Disabled);
    let shape = app
        .world_mut()
        .entity_mut(bullets[1])
        .take::<CollisionShape>()
        .unwrap();
    tick(&mut app, 1);
    for bullet in bullets {
        get_mut::<Transform>(&mut app, bullet).translation.x = 10.0;
    }
    tick(&mut app, 1);
    app.world_mut().entity_mut(bullets[0]).remove::<Disabled>();
    app.world_mut().entity_mut(bullets[1]).insert(shape);
    tick(&mut app, 2);
    assert_eq!(app.world().resource::<CollisionCounters>().total.started, 0);
    for bullet in bullets {
        assert_near(
            Vec3::from(get::<WorldAabb>(&app, bullet).0.max),
            place(&app, bullet) + Vec3::splat(0.05),
            1e-3,
        );
    }
}

#[test]
fn a_child_is_swept_by_the_way_of_its_parent() {
    for bounces in [false, true] {
        let mut app = app(BroadPhaseMethod::default());
        let wall = paper(&mut app, 0.0);
        let velocity = Velocity(Vec3::X * 100.0 * TICKS_PER_SECOND);
        let parent = app
            .world_mut()
            .spawn((Transform::from_xyz(-50.0, 0.0, 0.0), velocity))
            .id();
        let child = bullet(&mut app, Vec3::Y, Vec3::ZERO);
        if bounces {
            app.world_mut().entity_mut(child).insert(ELASTIC);
        }
        app.world_mut().entity_mut(parent).add_child(child);
        tick(&mut app, 1);
        assert_eq!(contacts(&app), [pair(wall, child)]);
        assert!((time(&app, wall, child).unwrap() - 0.49949).abs() < 1e-5);
        // Where the parent goes on to 50, one that bounces goes back to the other side, and on from
        // there.
        let expected = if bounces {
            Vec3::new(-100.102, 1.0, 0.0)
        } else {
            Vec3::Y
        };
        assert_near(place(&app, child), expected, 1e-3);
        tick(&mut app, 1);
        assert!(contacts(&app).is_empty());
        let expected = if bounces {
            Vec3::new(-300.102, 1.0, 0.0)
        } else {
            Vec3::Y
        };
        assert_near(place(&app, child), expected, 1e-2);
    }
}

#[test]
fn what_is_filtered_is_passed_through_after_a_bounce_too() {
    for kind in 0..4 {
        let mut app = app(BroadPhaseMethod::default());
        app.add_plugins(PairHookPlugin::<NoGhosts>::default());
        let bullet = elastic_bullet(&mut app, Vec3::X * -1.0, Vec3::X * 10.0);
        let front = paper(&mut app, 0.0);
        let between = paper(&mut app, -3.0);
        match kind {
            0 => app
                .world_mut()
                .entity_mut(between)
                .insert(CollisionLayers::NONE),
            1 => app
                .world_mut()
                .entity_mut(between)
                .insert(IgnoreCollisions::from([bullet])),
            2 => app.world_mut().entity_mut(between).insert(Ghost),
            _ => app.world_mut().entity_mut(between).insert(Sensor),
        };
        let back = paper(&mut app, -5.0);
        tick(&mut app, 1);
        let mut expected = vec![pair(bullet, front), pair(bullet, back)];
        if kind == 3 {
            expected.insert(1, pair(bullet, between));
        }
        assert_eq!(
            (contacts(&app), counters(&app).bounces),
            (expected, 2),
            "kind {kind}"
        );
        // -1 to the front, to the back, and what is left.
        let x = -5.0 + 0.051 + (10.0 - (1.0 - 0.051) - (5.0 - 0.102));
        assert_near(place(&app, bullet), Vec3::X * x, 2e-3);
    }
}

#[test]
fn an_update_of_the_index_between_ticks_changes_nothing() {
    let run = |flush: bool| {
        let mut app = app(BroadPhaseMethod::default());
        let wall = paper(&mut app, 0.0);
        let bullet = elastic_bullet(&mut app, Vec3::X * -250.0, Vec3::X * 100.0);
        let mut places = Vec::new();
        for _ in 0..4 {
            if flush {
                update_spatial_index(app.world_mut());
            }
            tick(&mut app, 1);
            places.push(place(&app, bullet));
        }
        (places, messages_about(&app, pair(bullet, wall)))
    };
    let (with, without) = (run(true), run(false));
    assert_eq!(with, without);
    assert_eq!(with.1, (1, 1));
}

#[test]
fn queries_find_it_where_it_has_come_to() {
    let mut app = app(BroadPhaseMethod::default());
    paper(&mut app, 0.0);
    let bullet = elastic_bullet(&mut app, Vec3::X * -30.0, Vec3::X * 100.0);
    app.add_systems(
        FixedPostUpdate,
        look.after(CollisionSystems::Response)
            .before(CollisionSystems::Report),
    );
    app.init_resource::<Found>();
    tick(&mut app, 3);
    let found = &app.world().resource::<Found>().0;
    assert_eq!(
        found.iter().map(|hit| hit.entity).collect::<Vec<_>>(),
        [bullet; 3]
    );
    assert_near(found[0].point, Vec3::X * (-70.102 + 0.05), 1e-2);

    #[derive(Resource, Default)]
    struct Found(Vec<PointHit>);

    fn look(
        spatial: SpatialQuery,
        bullets: Query<(Entity, &Transform), With<Swept>>,
        mut found: ResMut<Found>,
    ) {
        for (bullet, transform) in &bullets {
            let only = |entity| entity == bullet;
            let near = transform.translation + Vec3::X;
            found
                .0
                .extend(spatial.nearest(near, 1.1, &SpatialQueryFilter::DEFAULT.only(&only)));
        }
    }
}

/// One that is not swept answers too, once, and stays where it is.
#[test]
fn a_cube_that_is_hit_answers() {
    for (bounce, expected) in [(Bounce::Reverse, 0.25), (ELASTIC, 100.0)] {
        let mut app = app(BroadPhaseMethod::default());
        let cube = wall(&mut app, Vec3::ZERO, Vec3::splat(0.5));
        app.world_mut()
            .entity_mut(cube)
            .insert((bounce, Velocity(Vec3::X * -0.25 * TICKS_PER_SECOND)));
        let bullet = elastic_bullet(&mut app, Vec3::X * -30.0, Vec3::X * 100.0);
        tick(&mut app, 1);
        assert_eq!(
            (contacts(&app), place(&app, cube).x),
            (vec![pair(bullet, cube)], -0.25)
        );
        assert_near(step(&app, cube), Vec3::X * expected, 1e-2);
        assert_eq!(counters(&app).bounces, 2);
        assert!(place(&app, bullet).x < -0.8);
    }
}

/// One mesh all around: it is left and met again within one tick.
#[test]
fn a_room_that_is_one_mesh_keeps_a_bullet() {
    let mut app = app(BroadPhaseMethod::default());
    let corner = |bits: u32| {
        Vec3::new(
            (bits & 1) as f32,
            (bits >> 1 & 1) as f32,
            (bits >> 2) as f32,
        ) * 4.0
            - 2.0
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    // Without one side, so that it is a surface and no solid.
    let sides = [
        [0, 2, 3, 1],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let room = app
        .world_mut()
        .spawn(CollisionShape(Shape::mesh(corners, sides).unwrap()))
        .id();
    let bullet = elastic_bullet(&mut app, Vec3::new(0.0, 0.3, 0.0), Vec3::new(7.0, 4.3, 0.0));
    for n in 1..=40 {
        tick(&mut app, 1);
        let expected = Vec3::new(
            between(1.95, 7.0 * n as f32),
            between(1.95, 0.3 + 4.3 * n as f32),
            0.0,
        );
        assert_near(place(&app, bullet), expected, 2e-2);
        assert_eq!(contacts(&app), [pair(room, bullet)]);
    }
    assert_eq!(messages_about(&app, pair(room, bullet)), (1, 0));
}

#[test]
fn what_cannot_move_on_is_left_where_it_is() {
    for step in [f32::NAN, f32::INFINITY] {
        let mut app = app(BroadPhaseMethod::default());
        paper(&mut app, 0.0);
        let bullet = elastic_bullet(&mut app, Vec3::X * -30.0, Vec3::X * 100.0);
        get_mut::<Velocity>(&mut app, bullet).0.y = step;
        tick(&mut app, 2);
        assert_near(place(&app, bullet), Vec3::X * -30.0, 0.0);
        get_mut::<Transform>(&mut app, bullet).translation.x = step;
        tick(&mut app, 2);
        assert!(contacts(&app).is_empty());
        // From nowhere there is no way.
        get_mut::<Transform>(&mut app, bullet).translation.x = 30.0;
        tick(&mut app, 1);
        assert!(contacts(&app).is_empty());
    }
}

#[test]
fn it_may_go_at_any_moment() {
    fn with_bullet(world: &mut World, change: fn(EntityWorldMut)) {
        if let Ok(bullet) = world.query_filtered::<Entity, With<Swept>>().single(world) {
            change(world.entity_mut(bullet));
        }
    }
    let systems: [fn(&mut World); 3] = [
        |world| with_bullet(world, |bullet| bullet.despawn()),
        |world| with_bullet(world, |mut bullet| _ = bullet.remove::<Velocity>()),
        |world| with_bullet(world, |mut bullet| _ = bullet.remove::<Swept>()),
    ];
    for system in systems {
        for (earlier, later) in SETS.into_iter().zip(&SETS[1..]) {
            let mut app = app(BroadPhaseMethod::default());
            paper(&mut app, 0.0);
            elastic_bullet(&mut app, Vec3::X * -30.0, Vec3::X * 100.0);
            app.add_systems(FixedPostUpdate, system.after(earlier).before(*later));
            tick(&mut app, 3);
            assert!(contacts(&app).is_empty());
        }
    }
}
