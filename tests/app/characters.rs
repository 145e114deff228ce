//! Characters walk: on ground, steps and platforms, in crowds, within the tick.

use std::f32::consts::FRAC_PI_2;

use bevy::prelude::*;
use bevy_octree::{
    character::{change_shape, has_room, walk},
    narrow_phase::{NarrowPhase, Workspace},
    prelude::*,
};
use fastrand::Rng;

const STEP: f32 = 1.0 / 60.0;

fn new_app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(STEP),
        });
    app
}

fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn(bundle).id()
}

fn solid(app: &mut App, size: Vec3, at: Vec3) -> Entity {
    let shape = CollisionShape::from_half_size(size / 2.0);
    spawn(app, (shape, Transform::from_translation(at), StaticShape))
}

/// A floor whose top is at a height of 0.
fn floor(app: &mut App) -> Entity {
    solid(app, Vec3::new(100.0, 1.0, 100.0), Vec3::Y * -0.5)
}

/// All of them 1.8 high, and 0.8 wide.
fn shapes() -> [Shape; 4] {
    let ring = |y: f32, r: f32| {
        (0..6).map(move |i| {
            let angle = i as f32 * FRAC_PI_2 / 1.5;
            Vec3::new(r * angle.cos(), y, r * angle.sin())
        })
    };
    [
        Shape::capsule(0.4, 1.0),
        Shape::cuboid(0.8, 1.8, 0.8),
        Shape::sphere(0.9),
        Shape::convex_hull(ring(-0.9, 0.3).chain(ring(0.0, 0.4)).chain(ring(0.9, 0.3))).unwrap(),
    ]
}

fn character(app: &mut App, shape: Shape, at: Vec3) -> Entity {
    let at = Transform::from_translation(at);
    spawn(
        app,
        (KinematicCharacter::default(), CollisionShape(shape), at),
    )
}

fn state(app: &App, entity: Entity) -> KinematicCharacter {
    *app.world().get(entity).unwrap()
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<Transform>(entity).unwrap().translation
}

/// Has a character go by a velocity along the horizontal for some ticks, under gravity.
fn go(app: &mut App, entity: Entity, way: Vec3, ticks: usize) {
    for _ in 0..ticks {
        let mut walking = app
            .world_mut()
            .get_mut::<KinematicCharacter>(entity)
            .unwrap();
        walking.velocity = way + Vec3::Y * (walking.velocity.y - 9.8 * STEP);
        app.update();
    }
}

/// How deep a character is in others, at most.
fn depth(app: &mut App, entity: Entity) -> f32 {
    let world = app.world_mut();
    let mut solids = world.query::<(Entity, &CollisionShape, &GlobalTransform)>();
    let mut placed: Vec<_> = solids
        .iter(world)
        .map(|(e, s, t)| (e, s.0.clone(), t.compute_transform()))
        .collect();
    for solid in &mut placed {
        if let Some(at) = world.get::<Transform>(solid.0)
            && world.get::<ChildOf>(solid.0).is_none()
        {
            solid.2 = *at;
        }
    }
    let own = placed
        .iter()
        .find(|solid| solid.0 == entity)
        .unwrap()
        .clone();
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let depths = placed
        .iter()
        .filter(|solid| solid.0 != entity)
        .map(|solid| {
            let contact = tests.contact(
                Placed::new(&solid.1, &solid.2),
                Placed::new(&own.1, &own.2),
                &mut workspace,
            );
            contact.map_or(0.0, |contact| contact.depth)
        });
    depths.fold(0.0, f32::max)
}

#[test]
fn it_falls_lands_and_stands() {
    for shape in shapes() {
        let mut app = new_app();
        let ground = floor(&mut app);
        let walker = character(&mut app, shape.clone(), Vec3::Y * 3.0);
        app.update();
        assert!(!state(&app, walker).is_on_ground());
        go(&mut app, walker, Vec3::ZERO, 90);
        let at = place(&app, walker);
        assert!(at.distance(Vec3::Y * 0.91) < 2e-3, "{shape:?} {at}");
        let standing = state(&app, walker);
        assert_eq!(standing.velocity, Vec3::ZERO);
        assert_eq!(standing.ground.unwrap().entity, ground);
        assert!(standing.ground.unwrap().normal.distance(Vec3::Y) < 1e-3);
        // And trembles not at all.
        go(&mut app, walker, Vec3::ZERO, 1);
        let before = place(&app, walker);
        go(&mut app, walker, Vec3::ZERO, 60);
        assert_eq!(place(&app, walker), before, "{shape:?}");
    }
}

#[test]
fn it_jumps_and_comes_down() {
    let mut app = new_app();
    floor(&mut app);
    let walker = character(&mut app, Shape::capsule(0.4, 1.0), Vec3::Y * 0.91);
    go(&mut app, walker, Vec3::ZERO, 2);
    app.world_mut()
        .get_mut::<KinematicCharacter>(walker)
        .unwrap()
        .velocity
        .y = 4.0;
    app.update();
    assert!(!state(&app, walker).is_on_ground());
    go(&mut app, walker, Vec3::X, 20);
    let height = place(&app, walker).y;
    assert!(height > 1.5, "{height}");
    go(&mut app, walker, Vec3::X, 60);
    assert!(state(&app, walker).is_on_ground());
}

fn slope(app: &mut App, degrees: f32) {
    let lean = Quat::from_rotation_z(degrees.to_radians());
    let at = Transform::from_translation(lean * Vec3::new(10.0, -0.5, 0.0)).with_rotation(lean);
    spawn(
        app,
        (CollisionShape::cuboid(20.0, 1.0, 20.0), at, StaticShape),
    );
}

#[test]
fn slopes_are_climbed_up_to_an_angle() {
    for shape in shapes() {
        for degrees in [10.0_f32, 30.0, 45.0] {
            let mut app = new_app();
            floor(&mut app);
            slope(&mut app, degrees);
            let walker = character(&mut app, shape.clone(), Vec3::new(-3.0, 0.92, 0.0));
            go(&mut app, walker, Vec3::X * 4.0, 120);
            let at = place(&app, walker);
            // As fast along the horizontal as on the level.
            assert!(
                (at.x - 5.0).abs() < 0.25,
                "{shape:?} at {degrees}° gets to {at}"
            );
            assert!(state(&app, walker).is_on_ground());
            // It stands still there.
            go(&mut app, walker, Vec3::ZERO, 2);
            let before = place(&app, walker);
            go(&mut app, walker, Vec3::ZERO, 60);
            assert!(
                place(&app, walker).distance(before) < 1e-3,
                "{shape:?} at {degrees}°"
            );
            // Down again, it never loses the ground.
            for _ in 0..120 {
                go(&mut app, walker, Vec3::X * -4.0, 1);
                assert!(
                    state(&app, walker).is_on_ground(),
                    "{shape:?} at {degrees}°, {}",
                    place(&app, walker)
                );
            }
            assert!((place(&app, walker).x + 3.0).abs() < 0.3);
        }
        let mut app = new_app();
        floor(&mut app);
        slope(&mut app, 60.0);
        let walker = character(&mut app, shape.clone(), Vec3::new(-3.0, 0.92, 0.0));
        go(&mut app, walker, Vec3::X * 4.0, 240);
        let at = place(&app, walker);
        assert!(at.x < 0.6 && at.y < 1.6, "{shape:?} climbs 60° to {at}");
        // Put on it, it slides down.
        let mut transform = app.world_mut().get_mut::<Transform>(walker).unwrap();
        transform.translation = Vec3::new(2.0, 6.0, 0.0);
        go(&mut app, walker, Vec3::ZERO, 600);
        let at = place(&app, walker);
        assert!(
            at.y < 1.5 && state(&app, walker).is_on_ground(),
            "{shape:?} {at}"
        );
    }
}

fn stairs(app: &mut App, height: f32, count: u32) {
    for i in 0..count {
        let top = height * (i + 1) as f32;
        solid(
            app,
            Vec3::new(20.0, top, 6.0),
            Vec3::new(10.0 + 0.3 * i as f32, top / 2.0, 0.0),
        );
    }
}

#[test]
fn stairs_are_climbed_and_come_down() {
    for shape in shapes() {
        for height in [0.1, 0.2, 0.28] {
            let mut app = new_app();
            floor(&mut app);
            stairs(&mut app, height, 8);
            let walker = character(&mut app, shape.clone(), Vec3::new(-1.0, 0.92, 0.0));
            go(&mut app, walker, Vec3::X * 3.0, 150);
            let at = place(&app, walker);
            assert!(
                (at.y - 0.91 - 8.0 * height).abs() < 0.05,
                "{shape:?} at {height}: {at}"
            );
            let mut in_air = 0;
            for _ in 0..150 {
                go(&mut app, walker, Vec3::X * -3.0, 1);
                in_air += usize::from(!state(&app, walker).is_on_ground());
                assert!(depth(&mut app, walker) < 1e-3);
            }
            let at = place(&app, walker);
            assert!(
                at.x < -0.95 && at.y < 1.0 && in_air <= 8,
                "{shape:?} at {height}: {at}, {in_air}"
            );
        }
        // Too high.
        let mut app = new_app();
        floor(&mut app);
        stairs(&mut app, 0.5, 3);
        let walker = character(&mut app, shape.clone(), Vec3::new(-1.0, 0.92, 0.0));
        go(&mut app, walker, Vec3::X * 3.0, 150);
        let at = place(&app, walker);
        assert!(at.y < 1.0 && at.x < 0.3, "{shape:?}: {at}");
    }
}

#[test]
fn edges_between_tiles_do_not_catch() {
    for shape in shapes() {
        let mut app = new_app();
        for x in 0..20 {
            for z in 0..3 {
                solid(
                    &mut app,
                    Vec3::ONE,
                    Vec3::new(x as f32, -0.5, z as f32 - 1.0),
                );
            }
        }
        let walker = character(&mut app, shape.clone(), Vec3::new(0.0, 0.91, 0.1));
        go(&mut app, walker, Vec3::new(5.0, 0.0, 0.1), 180);
        let at = place(&app, walker);
        assert!(
            (at.x - 15.0).abs() < 0.02 && (at.y - 0.91).abs() < 5e-3,
            "{shape:?} {at}"
        );
    }
}

#[test]
fn ledges_are_fallen_from_or_stopped_at() {
    for (stops, shape) in [false, true]
        .into_iter()
        .flat_map(|stops| shapes().map(|shape| (stops, shape)))
    {
        let mut app = new_app();
        solid(
            &mut app,
            Vec3::new(10.0, 1.0, 10.0),
            Vec3::new(-5.0, 4.5, 0.0),
        );
        let walker = character(&mut app, shape.clone(), Vec3::new(-2.0, 5.91, 0.0));
        app.world_mut()
            .get_mut::<KinematicCharacter>(walker)
            .unwrap()
            .settings
            .stop_at_ledges = stops;
        go(&mut app, walker, Vec3::X * 3.0, 90);
        let at = place(&app, walker);
        if stops {
            assert!(
                (at.y - 5.91).abs() < 0.35 && at.x > -0.5 && at.x < 0.95,
                "{shape:?} {at}"
            );
            assert!(state(&app, walker).is_on_ground());
        } else {
            assert!(at.y < 4.0, "{shape:?} {at}");
        }
    }
}

#[test]
fn platforms_take_along_who_stands_on_them() {
    for shape in shapes() {
        // It moves along and up.
        let mut app = new_app();
        let lift = (
            CollisionShape::cuboid(4.0, 0.5, 4.0),
            Velocity(Vec3::new(1.0, 2.0, -0.5)),
            Transform::from_xyz(0.0, -0.25, 0.0),
        );
        let lift = spawn(&mut app, lift);
        let walker = character(&mut app, shape.clone(), Vec3::new(0.5, 0.91, 0.5));
        go(&mut app, walker, Vec3::ZERO, 120);
        let offset = place(&app, walker) - place(&app, lift);
        assert!(
            offset.distance(Vec3::new(0.5, 1.16, 0.5)) < 0.1,
            "{shape:?} {offset}"
        );
        let ground = state(&app, walker).ground.unwrap();
        assert!(
            ground.velocity.distance(Vec3::new(1.0, 2.0, -0.5)) < 1e-2,
            "{ground:?}"
        );
        assert!(depth(&mut app, walker) < 1e-3);
        // And down, faster than gravity has it fall in a tick.
        app.world_mut().get_mut::<Velocity>(lift).unwrap().0 = Vec3::NEG_Y * 3.0;
        go(&mut app, walker, Vec3::ZERO, 60);
        assert!(
            (place(&app, walker).y - place(&app, lift).y - 1.16).abs() < 0.02,
            "{shape:?}"
        );
    }
}

#[test]
fn platforms_turn_and_grow_and_hang_on_others() {
    let mut app = new_app();
    let hub = spawn(&mut app, Transform::from_xyz(3.0, 2.0, 1.0));
    let arm = spawn(&mut app, (Transform::from_xyz(0.0, 0.0, 0.0), ChildOf(hub)));
    let disk = (
        CollisionShape::cuboid(8.0, 0.5, 8.0),
        Transform::from_xyz(0.0, -0.25, 0.0),
        ChildOf(arm),
    );
    spawn(&mut app, disk);
    let walker = character(
        &mut app,
        Shape::capsule(0.4, 1.0),
        Vec3::new(5.0, 2.92, 1.0),
    );
    go(&mut app, walker, Vec3::ZERO, 5);
    let mut turned = 0.0;
    for _ in 0..90 {
        turned += 0.01;
        app.world_mut().get_mut::<Transform>(hub).unwrap().rotation = Quat::from_rotation_y(turned);
        app.world_mut()
            .get_mut::<Transform>(arm)
            .unwrap()
            .translation
            .y += 0.005;
        go(&mut app, walker, Vec3::ZERO, 1);
    }
    let expected = Vec3::new(3.0, 2.91 + 0.45, 1.0) + Quat::from_rotation_y(turned) * Vec3::X * 2.0;
    let at = *app.world().get::<Transform>(walker).unwrap();
    assert!(
        at.translation.distance(expected) < 0.05,
        "{at:?}, not {expected}"
    );
    assert!(
        at.rotation.angle_between(Quat::from_rotation_y(turned)) < 0.02,
        "{at:?}"
    );
    for _ in 0..60 {
        app.world_mut().get_mut::<Transform>(hub).unwrap().scale *= 1.005;
        go(&mut app, walker, Vec3::ZERO, 1);
    }
    let scale = app.world().get::<Transform>(hub).unwrap().scale.x;
    let at = place(&app, walker);
    let expected = Vec3::new(3.0, 2.0, 1.0) + Quat::from_rotation_y(turned) * Vec3::X * 2.0 * scale;
    assert!(
        (at - expected).reject_from(Vec3::Y).length() < 0.1,
        "{at}, not {expected}"
    );
    assert!(state(&app, walker).is_on_ground());
}

#[test]
fn who_hangs_on_a_platform_is_taken_along_once() {
    let mut app = new_app();
    let cart = (
        CollisionShape::cuboid(6.0, 0.5, 6.0),
        Velocity(Vec3::X * 2.0),
        Transform::from_xyz(0.0, -0.25, 0.0),
    );
    let cart = spawn(&mut app, cart);
    let walker = character(
        &mut app,
        Shape::capsule(0.4, 1.0),
        Vec3::new(1.0, 1.17, 0.0),
    );
    app.world_mut().entity_mut(walker).insert(ChildOf(cart));
    go(&mut app, walker, Vec3::ZERO, 60);
    let at = place(&app, walker);
    assert!(at.distance(Vec3::new(1.0, 1.16, 0.0)) < 0.02, "{at}");
    go(&mut app, walker, Vec3::Z, 60);
    let at = place(&app, walker);
    assert!(at.distance(Vec3::new(1.0, 1.16, 1.0)) < 0.03, "{at}");
}

#[test]
fn a_lift_that_crushes_makes_it_stuck() {
    let mut app = new_app();
    let lift = (
        CollisionShape::cuboid(4.0, 0.5, 4.0),
        Velocity(Vec3::Y),
        Transform::from_xyz(0.0, -0.25, 0.0),
    );
    let lift = spawn(&mut app, lift);
    solid(&mut app, Vec3::new(4.0, 1.0, 4.0), Vec3::Y * 3.0);
    let walker = character(&mut app, Shape::capsule(0.4, 1.0), Vec3::Y * 0.92);
    let mut ends = Vec::new();
    for _ in 0..80 {
        go(&mut app, walker, Vec3::ZERO, 1);
        ends.push(state(&app, walker).end);
    }
    assert!(place(&app, lift).y > 1.0);
    assert_eq!(*ends.last().unwrap(), MoveEnd::Stuck);
    let at = place(&app, walker);
    assert!(at.is_finite() && at.length() < 3.0, "{at}");
    // Once there is room again, all is well.
    app.world_mut().get_mut::<Velocity>(lift).unwrap().0 = Vec3::NEG_Y;
    go(&mut app, walker, Vec3::ZERO, 120);
    assert_eq!(state(&app, walker).end, MoveEnd::Done);
    assert!(depth(&mut app, walker) < 1e-3);
}

#[test]
fn one_way_platforms_by_the_callback() {
    let mut app = new_app();
    floor(&mut app);
    let shelf = solid(&mut app, Vec3::new(4.0, 0.2, 4.0), Vec3::Y * 2.5);
    app.update();
    let shape = Shape::capsule(0.4, 1.0);
    let (mut at, mut velocity, mut ground) =
        (Transform::from_xyz(0.0, 0.92, 0.0), Vec3::Y * 9.0, None);
    let mut highest = 0.0_f32;
    for _ in 0..180 {
        let world = app.world_mut();
        velocity.y -= 9.8 * STEP;
        let mut asked = bevy::ecs::system::SystemState::<SpatialQuery>::new(world);
        let spatial = asked.get(world).unwrap();
        let filter = SpatialQueryFilter::DEFAULT;
        let walked = walk(
            &spatial,
            &shape,
            &at,
            velocity,
            STEP,
            ground.as_ref(),
            &WalkSettings::default(),
            &filter,
            |hit| {
                if hit.entity == shelf && (hit.depth > 0.0 || hit.normal.y < 0.5) {
                    AtHit::Ignore
                } else {
                    AtHit::Slide
                }
            },
        );
        (at, velocity, ground) = (walked.pose, walked.velocity, walked.ground);
        highest = highest.max(at.translation.y);
    }
    assert!(highest > 4.0, "{highest}");
    assert_eq!(ground.map(|ground| ground.entity), Some(shelf));
    assert!((at.translation.y - 3.51).abs() < 0.01, "{at:?}");
}

#[test]
fn it_crouches_and_stands_up_where_there_is_room() {
    let mut app = new_app();
    floor(&mut app);
    solid(&mut app, Vec3::new(4.0, 1.0, 4.0), Vec3::new(4.0, 1.8, 0.0));
    app.update();
    let (tall, small) = (Shape::capsule(0.4, 1.0), Shape::capsule(0.4, 0.2));
    let world = app.world_mut();
    let mut asked = bevy::ecs::system::SystemState::<SpatialQuery>::new(world);
    let spatial = asked.get(world).unwrap();
    let (settings, all) = (WalkSettings::default(), SpatialQueryFilter::DEFAULT);
    let at = Transform::from_xyz(0.0, 0.91, 0.0);
    let crouched = change_shape(&spatial, &tall, &small, &at, &settings, &all).unwrap();
    assert!((crouched.translation.y - 0.51).abs() < 1e-4, "{crouched:?}");
    assert_eq!(
        change_shape(&spatial, &small, &tall, &crouched, &settings, &all)
            .map(|at| at.translation.y.round()),
        Some(1.0)
    );
    let below = Transform::from_xyz(4.0, 0.51, 0.0);
    assert!(has_room(
        &spatial,
        Placed::new(&small, &below),
        &settings.moves,
        &all
    ));
    assert_eq!(
        change_shape(&spatial, &small, &tall, &below, &settings, &all),
        None
    );
}

#[test]
fn within_the_tick() {
    // A trigger hears of it in the tick in which it walks in, and a door that closes in the tick is closed.
    let mut app = new_app();
    floor(&mut app);
    let trigger = (
        CollisionShape::cuboid(1.0, 4.0, 4.0),
        Sensor,
        Transform::from_xyz(1.0, 0.0, 0.0),
    );
    let trigger = spawn(&mut app, trigger);
    let walker = character(
        &mut app,
        Shape::capsule(0.4, 1.0),
        Vec3::new(0.0, 0.91, 0.0),
    );
    go(&mut app, walker, Vec3::ZERO, 3);
    assert!(!app.world().resource::<Contacts>().contains(walker, trigger));
    go(&mut app, walker, Vec3::X * 12.0, 1);
    assert!((place(&app, walker).x - 0.2).abs() < 1e-4);
    assert!(app.world().resource::<Contacts>().contains(walker, trigger));
    let door = (
        CollisionShape::cuboid(0.2, 4.0, 4.0),
        Velocity(Vec3::Z * -600.0),
        Transform::from_xyz(1.5, 2.01, 10.0),
    );
    spawn(&mut app, door);
    app.world_mut()
        .get_mut::<Transform>(walker)
        .unwrap()
        .translation
        .x = 0.9;
    go(&mut app, walker, Vec3::X * 30.0, 1);
    let at = place(&app, walker);
    assert!((at.x - 0.99).abs() < 1e-2, "{at}");
}

/// Many walk towards each other in a room; where they get to.
fn crowd(count: usize, ticks: usize) -> (Vec<Vec3>, f32) {
    let mut app = new_app();
    floor(&mut app);
    let mut random = Rng::with_seed(5);
    let walkers: Vec<_> = (0..count)
        .map(|i| {
            let (x, z) = ((i % 12) as f32, (i / 12) as f32);
            let at = Vec3::new(x * 1.2 - 6.6, 0.92, z * 1.2 - 6.0);
            let shape = shapes()[i % 2].clone();
            character(&mut app, shape, at + Vec3::X * random.f32() * 0.2)
        })
        .collect();
    let mut deepest = 0.0_f32;
    for tick in 0..ticks {
        for walker in &walkers {
            let at = place(&app, *walker);
            let mut walking = app
                .world_mut()
                .get_mut::<KinematicCharacter>(*walker)
                .unwrap();
            let to = -at.reject_from(Vec3::Y).normalize_or_zero();
            walking.velocity = to * 3.0 + Vec3::Y * (walking.velocity.y - 9.8 * STEP);
        }
        app.update();
        if tick % 20 == 19 {
            for walker in &walkers {
                deepest = deepest.max(depth(&mut app, *walker));
            }
        }
    }
    (
        walkers.iter().map(|walker| place(&app, *walker)).collect(),
        deepest,
    )
}

#[test]
fn crowds_push_and_stay_out_of_each_other() {
    let (places, deepest) = crowd(60, 120);
    assert!(deepest < 0.05, "{deepest}");
    // They have come together, and none has climbed another.
    let spread = places
        .iter()
        .map(|at| at.reject_from(Vec3::Y).length())
        .fold(0.0, f32::max);
    assert!(spread < 6.0, "{spread}");
    assert!(
        places.iter().all(|at| (at.y - 0.91).abs() < 0.05),
        "{places:?}"
    );
    assert_eq!(crowd(60, 120).0, places);
}

#[test]
fn those_who_press_on_each_other_slide_past() {
    for shape in shapes() {
        let mut app = new_app();
        floor(&mut app);
        let ways = [Vec3::new(3.0, 0.0, 0.6), Vec3::new(-3.0, 0.0, -0.6)];
        let walkers =
            [-1.5, 1.5].map(|x| character(&mut app, shape.clone(), Vec3::new(x, 0.92, 0.0)));
        let mut deepest = 0.0_f32;
        for _ in 0..150 {
            for (walker, way) in walkers.into_iter().zip(ways) {
                let mut walking = app
                    .world_mut()
                    .get_mut::<KinematicCharacter>(walker)
                    .unwrap();
                walking.velocity = way + Vec3::Y * (walking.velocity.y - 9.8 * STEP);
            }
            app.update();
            deepest = deepest.max(depth(&mut app, walkers[0]));
        }
        let [a, b] = walkers.map(|walker| place(&app, walker));
        assert!(a.x > 2.0 && b.x < -2.0, "{shape:?}: {a}, {b}");
        assert!(deepest < 0.02, "{shape:?}: {deepest}");
    }
}

#[test]
fn bad_settings_have_an_answer() {
    let bad = [f32::NAN, f32::INFINITY, -1.0, 0.0];
    for number in bad {
        let mut app = new_app();
        floor(&mut app);
        let walker = character(&mut app, Shape::capsule(0.4, 1.0), Vec3::Y * 0.95);
        let mut walking = app
            .world_mut()
            .get_mut::<KinematicCharacter>(walker)
            .unwrap();
        walking.settings = WalkSettings {
            up: Vec3::Y * number,
            max_slope: number,
            step_height: number,
            snap: number,
            moves: MoveSettings {
                skin: number,
                ..default()
            },
            ..default()
        };
        go(&mut app, walker, Vec3::X, 60);
        let at = place(&app, walker);
        assert!(
            at.is_finite() && at.x > 0.9 && at.y > 0.85 && at.y < 1.0,
            "{number}: {at}"
        );
        let mut walking = app
            .world_mut()
            .get_mut::<KinematicCharacter>(walker)
            .unwrap();
        walking.velocity = Vec3::splat(number * f32::MAX);
        app.update();
        if number.is_nan() {
            assert_eq!(state(&app, walker).end, MoveEnd::Refused);
        }
        assert!(place(&app, walker).is_finite());
    }
    // Up is where it points, however long it is.
    let mut app = new_app();
    solid(&mut app, Vec3::new(1.0, 50.0, 50.0), Vec3::X * -0.5);
    let walker = character(&mut app, Shape::sphere(0.5), Vec3::X * 0.6);
    app.world_mut()
        .get_mut::<KinematicCharacter>(walker)
        .unwrap()
        .settings
        .up = Vec3::X * 7.0;
    for _ in 0..60 {
        app.world_mut()
            .get_mut::<KinematicCharacter>(walker)
            .unwrap()
            .velocity = Vec3::new(-1.0, 2.0, 0.0);
        app.update();
    }
    let at = place(&app, walker);
    assert!(at.distance(Vec3::new(0.51, 2.0, 0.0)) < 0.02, "{at}");
    assert!(state(&app, walker).is_on_ground());
}

#[test]
fn layers_lists_and_sensors_are_heeded() {
    let mut app = new_app();
    floor(&mut app);
    let walls = [1.0, 2.0, 3.0, 4.0].map(|x| {
        solid(
            &mut app,
            Vec3::new(0.1, 4.0, 4.0),
            Vec3::new(x * 2.0, 2.0, 0.0),
        )
    });
    app.world_mut().entity_mut(walls[0]).insert(Sensor);
    app.world_mut()
        .entity_mut(walls[1])
        .insert(CollisionLayers::new(LayerMask(2), LayerMask::ALL));
    let walker = character(&mut app, Shape::capsule(0.4, 1.0), Vec3::Y * 0.95);
    let own = CollisionLayers::new(LayerMask(1), LayerMask(1));
    app.world_mut().entity_mut(walker).insert((
        own,
        IgnoreCollisions::from(walls[2]),
        CharacterHits::default(),
    ));
    go(&mut app, walker, Vec3::X * 5.0, 180);
    let at = place(&app, walker);
    assert!((at.x - (8.0 - 0.05 - 0.41)).abs() < 1e-2, "{at}");
    let hits = app.world().get::<CharacterHits>(walker).unwrap();
    assert!(hits.iter().any(|hit| hit.entity == walls[3]), "{hits:?}");
}
