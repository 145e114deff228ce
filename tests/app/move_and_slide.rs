//! Shapes that move among others end in nothing, and pass through nothing.

use std::f32::consts::{PI, TAU};

use bevy::{ecs::system::SystemState, prelude::*};
use bevy_octree::{
    move_and_slide::{cast_move, depenetrate, move_and_slide, project_velocity},
    narrow_phase::{NarrowPhase, Placed, Workspace},
    prelude::*,
};
use fastrand::Rng;

use crate::common::SIDES;

const ALL: SpatialQueryFilter = SpatialQueryFilter::DEFAULT;

/// So many random moves, unless `RANDOM_MOVES` says another number: a million takes some minutes.
const MOVES: usize = 20_000;

fn moves() -> usize {
    std::env::var("RANDOM_MOVES")
        .ok()
        .and_then(|moves| moves.parse().ok())
        .unwrap_or(MOVES)
}

/// A scene at rest, to be asked.
struct Scene {
    app: App,
    solids: Vec<(Entity, Shape, Transform)>,
}

impl Scene {
    fn new(solids: impl IntoIterator<Item = (Shape, Transform)>) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
        let solids = solids
            .into_iter()
            .map(|(shape, at)| {
                let entity = app
                    .world_mut()
                    .spawn((CollisionShape(shape.clone()), at, StaticShape))
                    .id();
                (entity, shape, at)
            })
            .collect();
        app.update();
        Self { app, solids }
    }

    fn ask<T>(&mut self, question: impl FnOnce(&MoveAndSlide) -> T) -> T {
        let world = self.app.world_mut();
        let mut state = SystemState::<MoveAndSlide>::new(world);
        question(&state.get(world).expect("the plugins are there"))
    }

    /// How deep a shape is in the solids, at most.
    fn depth(&self, shape: &Shape, at: &Transform) -> f32 {
        let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
        let placed = Placed::new(shape, at);
        let depth = |(_, solid, there): &(Entity, Shape, Transform)| {
            let contact = tests.contact(Placed::new(solid, there), placed, &mut workspace);
            contact.map_or(0.0, |contact| contact.depth)
        };
        self.solids.iter().map(depth).fold(0.0, f32::max)
    }
}

fn direction(random: &mut Rng) -> Vec3 {
    loop {
        let some = Vec3::from_array(std::array::from_fn(|_| random.f32() * 2.0 - 1.0));
        if let Some(unit) = some.try_normalize() {
            return unit;
        }
    }
}

fn turn(random: &mut Rng) -> Quat {
    Quat::from_axis_angle(direction(random), random.f32() * TAU)
}

/// The six walls of a room, as boxes.
fn room(half: f32, thickness: f32) -> Vec<(Shape, Transform)> {
    let sides = [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|axis| [axis, -axis]);
    sides
        .map(|side| {
            let across = Vec3::ONE - side.abs();
            let shape =
                Shape::from_half_size(across * (half + thickness) + side.abs() * thickness * 0.5);
            (
                shape,
                Transform::from_translation(side * (half + thickness * 0.5)),
            )
        })
        .collect()
}

/// What moves: all about 1 in size.
fn movers() -> Vec<Shape> {
    let hull = [
        Vec3::new(0.4, 0.0, 0.0),
        Vec3::new(-0.4, 0.0, 0.1),
        Vec3::new(0.0, 0.5, 0.0),
        Vec3::new(0.0, -0.5, 0.1),
        Vec3::new(0.1, 0.0, 0.4),
        Vec3::new(0.0, 0.1, -0.4),
        Vec3::new(0.2, 0.3, 0.2),
    ];
    vec![
        Shape::cuboid(0.6, 0.9, 0.5),
        Shape::sphere(0.4),
        Shape::capsule(0.3, 0.4),
        Shape::convex_hull(hull).unwrap(),
        Shape::cylinder(0.3, 0.8),
    ]
}

/// A bumpy sheet, as one mesh that bounds nothing.
fn sheet(random: &mut Rng, cells: u32, size: f32, height: f32) -> Shape {
    let row = cells + 1;
    let vertices: Vec<_> = (0..row * row)
        .map(|i| {
            let (x, z) = ((i % row) as f32, (i / row) as f32);
            let scale = size / cells as f32;
            Vec3::new(
                x * scale - size / 2.0,
                random.f32() * height,
                z * scale - size / 2.0,
            )
        })
        .collect();
    let corners = |i: u32| i / cells * row + i % cells;
    let triangles = (0..cells * cells).flat_map(|i| {
        let a = corners(i);
        [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]
    });
    Shape::mesh(vertices, triangles).unwrap()
}

/// A room with all kinds of things in it, and walls that meet at 1°.
fn random_scene(random: &mut Rng) -> Scene {
    let mut solids = room(6.0, 0.05);
    solids.push((
        sheet(random, 8, 12.0, 1.5),
        Transform::from_xyz(0.0, -5.5, 0.0),
    ));
    for _ in 0..14 {
        let size = |random: &mut Rng| 0.2 + random.f32() * 2.0;
        let shape = match random.u32(0..6) {
            0 => Shape::cuboid(size(random), size(random), size(random)),
            1 => Shape::sphere(size(random) * 0.5),
            2 => Shape::capsule(size(random) * 0.3, size(random)),
            3 => Shape::cylinder(size(random) * 0.4, size(random)),
            4 => Shape::convex_hull((0..12).map(|_| direction(random) * 0.8)).unwrap(),
            _ => sheet(random, 4, 2.5, 0.8),
        };
        let at = direction(random) * random.f32() * 5.5;
        solids.push((
            shape,
            Transform::from_translation(at).with_rotation(turn(random)),
        ));
    }
    // A wedge of 1°, open to the middle of the room.
    let height = random.f32() * 6.0 - 3.0;
    let around = Quat::from_rotation_y(random.f32() * TAU);
    for half in [0.5_f32, -0.5] {
        let lean = Quat::from_rotation_z(half.to_radians());
        let up = half.signum() * 0.25;
        let wall = Shape::cuboid(5.0, 0.5, 2.0);
        let at = lean * Vec3::new(2.5, up, 0.0) + Vec3::new(-2.5, 0.0, 0.0);
        let at = around * at + Vec3::Y * height;
        solids.push((
            wall,
            Transform::from_translation(at).with_rotation(around * lean),
        ));
    }
    Scene::new(solids)
}

/// Somewhere in the room where a shape is in nothing.
fn free_place(scene: &Scene, shape: &Shape, random: &mut Rng) -> Transform {
    loop {
        let there = direction(random) * random.f32() * 5.0;
        let at = Transform::from_translation(there).with_rotation(turn(random));
        if scene.depth(shape, &at) == 0.0 {
            return at;
        }
    }
}

/// What became of many random moves.
#[derive(Debug, Default)]
struct Counts {
    moves: usize,
    hits: usize,
    began_inside: usize,
    stuck: usize,
    deepest: f32,
}

fn random_moves(seed: u64, count: usize) -> Counts {
    let mut random = Rng::with_seed(seed);
    let mut scene = random_scene(&mut random);
    let mut counts = Counts::default();
    for shape in movers() {
        let mut at = free_place(&scene, &shape, &mut random);
        for _ in 0..count / movers().len() {
            if random.u32(0..30) == 0 {
                let there = direction(&mut random) * random.f32() * 5.0;
                at = Transform::from_translation(there).with_rotation(turn(&mut random));
            }
            let before = scene.depth(&shape, &at);
            let speed = 10.0_f32.powf(random.f32() * 4.0 - 1.0);
            let velocity = direction(&mut random) * speed;
            let mut hits = 0;
            let moved = scene.ask(|mover| {
                mover.move_and_slide(
                    &shape,
                    &at,
                    velocity,
                    0.1,
                    &MoveSettings::default(),
                    &ALL,
                    |_| {
                        hits += 1;
                        AtHit::Slide
                    },
                )
            });
            counts.moves += 1;
            counts.hits += hits;
            counts.began_inside += usize::from(before > 1e-3);
            let depth = scene.depth(&shape, &moved.pose);
            let case = || {
                format!(
                    "seed {seed}, move {}, {shape:?} from {at:?} by {velocity}, {before} deep: {moved:?}",
                    counts.moves
                )
            };
            if moved.end == MoveEnd::Stuck {
                assert!(before > 0.0, "{}", case());
                assert_eq!(moved.velocity, Vec3::ZERO);
                counts.stuck += 1;
                at = free_place(&scene, &shape, &mut random);
                continue;
            }
            assert_eq!(moved.end, MoveEnd::Done, "{}", case());
            assert!(depth <= 1e-3, "{depth} deep: {}", case());
            assert!(
                moved.velocity.length() <= velocity.length() * 1.0001,
                "{}",
                case()
            );
            // Not through the walls of the room, which are a tenth as thick as anything that moves.
            if before <= 1e-3 {
                assert!(
                    moved.pose.translation.abs().max_element() < 6.0,
                    "{}",
                    case()
                );
            }
            counts.deepest = counts.deepest.max(depth);
            at = moved.pose;
            if at.translation.abs().max_element() > 6.0 {
                at = free_place(&scene, &shape, &mut random);
            }
        }
    }
    counts
}

#[test]
fn random_moves_end_in_nothing_and_pass_through_nothing() {
    let scenes = (moves() / 2_500).max(1);
    let mut all = Counts::default();
    for seed in 0..scenes as u64 {
        let counts = random_moves(seed, moves() / scenes);
        all.moves += counts.moves;
        all.hits += counts.hits;
        all.began_inside += counts.began_inside;
        all.stuck += counts.stuck;
        all.deepest = all.deepest.max(counts.deepest);
    }
    println!("{all:?} in {scenes} scenes");
    assert!(
        all.hits > all.moves && all.began_inside > all.moves / 200,
        "{all:?}"
    );
    // In the midst of five things that contradict each other, there may be no way out.
    assert!(all.stuck < all.began_inside / 3, "{all:?}");
}

#[test]
fn out_of_one_thing_there_is_always_a_way() {
    let mut random = Rng::with_seed(11);
    let corners = [Vec3::NEG_ONE, Vec3::ONE].map(|corner| corner * Vec3::new(1.0, 0.7, 1.2));
    let mut sides = Vec::new();
    for side in SIDES {
        sides.push([side[0], side[1], side[2]]);
        sides.push([side[0], side[2], side[3]]);
    }
    let vertices: Vec<_> = (0..8)
        .map(|i| Vec3::from_array(std::array::from_fn(|axis| corners[i >> axis & 1][axis])))
        .collect();
    let solids = [
        Shape::cuboid(2.0, 1.5, 1.0),
        Shape::sphere(1.0),
        Shape::capsule(0.5, 1.5),
        Shape::cylinder(0.8, 1.5),
        Shape::convex_hull((0..20).map(|_| direction(&mut random))).unwrap(),
        Shape::mesh(vertices, sides).unwrap(),
    ];
    for solid in solids {
        let at = Transform::from_rotation(turn(&mut random));
        let mut scene = Scene::new([(solid.clone(), at)]);
        for shape in movers() {
            for _ in 0..40 {
                let there = direction(&mut random) * random.f32() * 0.8;
                let start = Transform::from_translation(there).with_rotation(turn(&mut random));
                let moved = scene.ask(|mover| {
                    mover.move_and_slide(
                        &shape,
                        &start,
                        Vec3::ZERO,
                        0.1,
                        &MoveSettings::default(),
                        &ALL,
                        |_| AtHit::Slide,
                    )
                });
                let depth = scene.depth(&shape, &moved.pose);
                assert!(
                    moved.end == MoveEnd::Done && depth < 1e-4,
                    "{shape:?} in {solid:?} at {at:?} from {start:?}: {moved:?}, {depth}"
                );
            }
        }
    }
}

#[test]
fn along_a_wall_nothing_is_lost() {
    let wall = (
        Shape::cuboid(100.0, 10.0, 1.0),
        Transform::from_xyz(0.0, 0.0, -1.5),
    );
    let mut scene = Scene::new([wall]);
    for shape in movers() {
        let mut at = Transform::from_xyz(-40.0, 0.0, 1.0);
        let velocity = Vec3::new(5.0, 0.0, -3.0);
        for _ in 0..300 {
            let moved = scene.ask(|mover| {
                mover.move_and_slide(
                    &shape,
                    &at,
                    velocity,
                    1.0 / 60.0,
                    &MoveSettings::default(),
                    &ALL,
                    |_| AtHit::Slide,
                )
            });
            at = moved.pose;
        }
        let x = at.translation.x;
        assert!((x - (-40.0 + 25.0)).abs() < 0.01, "{shape:?} gets to {x}");
    }
}

#[test]
fn in_corners_nothing_trembles() {
    for degrees in [90.0_f32, 45.0, 20.0, 5.0, 1.0] {
        let half = degrees.to_radians() / 2.0;
        let walls = [half, -half].map(|angle| {
            let lean = Quat::from_rotation_y(angle);
            let side = -angle.signum();
            let at = lean * Vec3::new(100.0, 0.0, side * 0.5);
            (
                Shape::cuboid(200.0, 10.0, 1.0),
                Transform::from_translation(at).with_rotation(lean),
            )
        });
        let mut scene = Scene::new(walls);
        for shape in movers() {
            let mut at = Transform::from_xyz(15.0, 0.0, 0.0);
            let reach = 15.0 * half.tan();
            if reach < 1.0 {
                // There is no room at all; it goes in from where there is.
                at.translation.x = 1.0 / half.tan();
            }
            let mut places = Vec::new();
            for _ in 0..120 {
                let velocity = Vec3::new(-3.0, 0.0, 0.4);
                let moved = scene.ask(|mover| {
                    mover.move_and_slide(
                        &shape,
                        &at,
                        velocity,
                        0.5,
                        &MoveSettings::default(),
                        &ALL,
                        |_| AtHit::Slide,
                    )
                });
                assert_eq!(moved.end, MoveEnd::Done, "{shape:?} at {degrees}°");
                at = moved.pose;
                places.push(at.translation);
            }
            let rest = &places[110..];
            let unrest = rest
                .windows(2)
                .map(|two| two[0].distance(two[1]))
                .sum::<f32>();
            assert!(unrest < 1e-3, "{shape:?} at {degrees}°: {rest:?}");
        }
    }
}

#[test]
fn callbacks_decide_and_hear_in_order() {
    let walls = [1.0, 2.0, 3.0].map(|x| {
        (
            Shape::cuboid(0.1, 9.0, 9.0),
            Transform::from_xyz(x, 0.0, 0.0),
        )
    });
    let mut scene = Scene::new(walls);
    let [first, second, third] = [0, 1, 2].map(|i| scene.solids[i].0);
    let ball = Shape::sphere(0.25);
    let mut met = Vec::new();
    let moved = scene.ask(|mover| {
        mover.move_and_slide(
            &ball,
            &Transform::IDENTITY,
            Vec3::X * 10.0,
            1.0,
            &MoveSettings::default(),
            &ALL,
            |hit| {
                met.push((hit.entity, hit.time));
                if hit.entity == second {
                    AtHit::Stop
                } else {
                    AtHit::Ignore
                }
            },
        )
    });
    assert_eq!(
        met.iter().map(|met| met.0).collect::<Vec<_>>(),
        [first, second]
    );
    assert!(met[0].1 < met[1].1);
    assert_eq!(moved.end, MoveEnd::Stopped);
    assert!(
        (moved.pose.translation.x - (2.0 - 0.05 - 0.25 - 0.01)).abs() < 1e-4,
        "{moved:?}"
    );
    assert_ne!(first, third);
}

#[test]
fn what_is_impossible_is_refused() {
    let mut scene = Scene::new([(
        Shape::cuboid(1.0, 1.0, 1.0),
        Transform::from_xyz(3.0, 0.0, 0.0),
    )]);
    let ball = Shape::sphere(0.5);
    let settings = MoveSettings::default();
    let mut go = |shape: &Shape, at: Transform, velocity: Vec3, time: f32| {
        scene.ask(|mover| {
            mover.move_and_slide(shape, &at, velocity, time, &settings, &ALL, |_| {
                AtHit::Slide
            })
        })
    };
    let here = Transform::IDENTITY;
    let bad = [
        (Vec3::NAN, 1.0),
        (Vec3::X * f32::INFINITY, 1.0),
        (Vec3::X, f32::NAN),
        (Vec3::X, f32::INFINITY),
        (Vec3::X, -1.0),
    ];
    for (velocity, time) in bad {
        let moved = go(&ball, here, velocity, time);
        assert_eq!(
            (moved.end, moved.velocity, moved.pose),
            (MoveEnd::Refused, Vec3::ZERO, here)
        );
    }
    let nowhere = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    assert_eq!(go(&ball, nowhere, Vec3::X, 1.0).end, MoveEnd::Refused);
    let endless = Shape::half_space(Vec3::Y).unwrap();
    assert_eq!(go(&endless, here, Vec3::X, 1.0).end, MoveEnd::Refused);
    // Nothing to do is no error, and what it is in, it leaves all the same.
    for (velocity, time) in [(Vec3::ZERO, 1.0), (Vec3::X, 0.0)] {
        let moved = go(&ball, here, velocity, time);
        assert_eq!(
            (moved.end, moved.velocity, moved.pose),
            (MoveEnd::Done, velocity, here)
        );
        let moved = go(&ball, Transform::from_xyz(2.2, 0.0, 0.0), velocity, time);
        assert!((moved.pose.translation.x - 1.99).abs() < 1e-3, "{moved:?}");
    }
    // The fastest there are.
    for speed in [1e10, 1e30, f32::MAX] {
        let moved = go(&ball, here, Vec3::X * speed, 1.0);
        assert!((moved.pose.translation.x - 1.99).abs() < 1e-3, "{moved:?}");
    }
}

#[test]
fn between_walls_that_close_in_it_is_stuck() {
    for gap in [0.9, 0.6, 0.1] {
        let walls = [-1.0, 1.0].map(|side: f32| {
            let at = Transform::from_xyz(side * (gap / 2.0 + 0.5), 0.0, 0.0);
            (Shape::cuboid(1.0, 50.0, 50.0), at)
        });
        let mut scene = Scene::new(walls);
        let ball = Shape::sphere(0.5);
        let mut ends = Vec::new();
        for velocity in [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)] {
            let moved = scene.ask(|mover| {
                mover.move_and_slide(
                    &ball,
                    &Transform::IDENTITY,
                    velocity,
                    0.1,
                    &MoveSettings::default(),
                    &ALL,
                    |_| AtHit::Slide,
                )
            });
            assert!(moved.pose.translation.x.abs() < 0.1, "{moved:?}");
            assert!(moved.pose.translation.length() < 0.2, "{moved:?}");
            ends.push((moved.end, moved.velocity));
        }
        assert!(
            ends.iter().all(|end| *end == (MoveEnd::Stuck, Vec3::ZERO)),
            "{gap}: {ends:?}"
        );
    }
}

#[test]
fn out_of_several_at_once() {
    // A corner of three, a valley of two, a ball between two balls.
    let corner = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| {
        (
            Shape::cuboid(4.0, 4.0, 4.0),
            Transform::from_translation(axis * -4.0),
        )
    });
    let mut scene = Scene::new(corner);
    for shape in movers() {
        let at = Transform::from_xyz(-1.9, -1.8, -1.85);
        let out = scene.ask(|mover| {
            mover.depenetrate(Placed::new(&shape, &at), &MoveSettings::default(), &ALL)
        });
        assert!(
            out.is_free && scene.depth(&shape, &out.pose) < 1e-4,
            "{shape:?} {out:?}"
        );
        assert!(
            out.pose.translation.distance(at.translation) < 1.2,
            "{out:?}"
        );
    }
    let balls = [-0.8, 0.8].map(|x| (Shape::sphere(1.0), Transform::from_xyz(x, 0.0, 0.0)));
    let mut scene = Scene::new(balls);
    let ball = Shape::sphere(0.5);
    let at = Transform::from_xyz(0.01, 0.7, 0.0);
    let out = scene.ask(|mover| {
        depenetrate(
            mover,
            Placed::new(&ball, &at),
            &MoveSettings::default(),
            &ALL,
        )
    });
    assert!(
        out.is_free && scene.depth(&ball, &out.pose) < 1e-4,
        "{out:?}"
    );
}

#[test]
fn the_parts_say_how_far_and_how_fast() {
    let mut scene = Scene::new([(
        Shape::cuboid(1.0, 1.0, 1.0),
        Transform::from_xyz(3.0, 0.0, 0.0),
    )]);
    let ball = Shape::sphere(0.5);
    let here = Transform::IDENTITY;
    let cast = scene.ask(|mover| {
        cast_move(
            mover,
            Placed::new(&ball, &here),
            Vec3::X * 4.0,
            &MoveSettings::default(),
            &ALL,
        )
    });
    let hit = cast.unwrap();
    assert!(
        (hit.time - 1.99 / 4.0).abs() < 1e-5 && hit.normal.distance(Vec3::NEG_X) < 1e-5,
        "{hit:?}"
    );
    let none = scene.ask(|mover| {
        cast_move(
            mover,
            Placed::new(&ball, &here),
            Vec3::NAN,
            &MoveSettings::default(),
            &ALL,
        )
    });
    assert_eq!(none, None);
    let mut random = Rng::with_seed(3);
    for _ in 0..2_000 {
        let normals: Vec<_> = (0..random.usize(0..6))
            .map(|_| direction(&mut random))
            .collect();
        let velocity = direction(&mut random) * random.f32() * 9.0;
        let left = project_velocity(velocity, &normals);
        assert!(
            normals.iter().all(|normal| normal.dot(left) > -1e-4),
            "{velocity} {normals:?} {left}"
        );
        assert!(left.length() <= velocity.length() + 1e-4 && left.dot(velocity) > -1e-4);
    }
    assert_eq!(project_velocity(Vec3::NAN, &[Vec3::Y]), Vec3::ZERO);
    assert_eq!(project_velocity(Vec3::X, &[Vec3::NAN]), Vec3::X);
}

#[test]
fn the_function_is_the_parameter() {
    let mut scene = Scene::new(room(3.0, 0.1));
    let shape = Shape::capsule(0.3, 0.5);
    let at = Transform::from_rotation(Quat::from_rotation_x(PI / 5.0));
    let velocity = Vec3::new(20.0, -7.0, 3.0);
    let settings = MoveSettings::default();
    let (by_function, by_method) = scene.ask(|mover| {
        let by_method = mover.move_and_slide(&shape, &at, velocity, 1.0, &settings, &ALL, |_| {
            AtHit::Slide
        });
        (
            move_and_slide(mover, &shape, &at, velocity, 1.0, &settings, &ALL, |_| {
                AtHit::Slide
            }),
            by_method,
        )
    });
    assert_eq!(by_function, by_method);
}
