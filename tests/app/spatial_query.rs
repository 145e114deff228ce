//! Queries by entity, in headless apps: against brute force over the exact shapes, in the frame of
//! a spawn, while time is paused, with filters, and on bad input.

use crate::common;

use std::{f32::consts::FRAC_PI_4, ops::ControlFlow};

use bevy::{
    ecs::{entity::EntityHashSet, system::RunSystemOnce},
    math::{
        Vec3A,
        bounding::Aabb3d,
        primitives::{HalfSpace, ViewFrustum},
    },
    prelude::*,
};
use bevy_octree::{
    components::BroadPhaseProxy,
    motion::CollisionClock,
    narrow_phase::{NarrowPhase, Placed, Shape, Workspace},
    prelude::*,
    scene::Cube,
};
use common::*;
use fastrand::Rng;

pub const ALL: SpatialQueryFilter = SpatialQueryFilter::DEFAULT;

/// Asks something of an app.
pub fn ask<T: 'static>(
    app: &mut App,
    question: impl FnMut(SpatialQuery) -> T + Send + Sync + 'static,
) -> T {
    app.world_mut()
        .run_system_once(question)
        .expect("the plugins are there")
}

pub fn vector(rng: &mut Rng, reach: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| (rng.f32() * 2.0 - 1.0) * reach))
}

pub fn direction(rng: &mut Rng) -> Dir3 {
    Dir3::new(vector(rng, 1.0)).unwrap_or(Dir3::X)
}

pub fn rotation(rng: &mut Rng) -> Quat {
    Quat::from_axis_angle(*direction(rng), rng.f32() * 6.0)
}

fn tetrahedron() -> CollisionShape {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    Shape::convex(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        .unwrap()
        .into()
}

/// A star of six corners, one deep.
fn star() -> CollisionShape {
    let level = |z: f32| {
        (0..12).map(move |i| {
            let radius = if i % 2 == 0 { 1.0 } else { 0.4 };
            (Quat::from_rotation_z(FRAC_PI_4 * i as f32 / 1.5) * Vec3::X * radius).with_z(z)
        })
    };
    let mut sides = vec![(0..12).rev().collect::<Vec<u32>>(), (12..24).collect()];
    sides.extend((0..12).map(|i| vec![i, (i + 1) % 12, (i + 1) % 12 + 12, i + 12]));
    Shape::mesh(level(0.0).chain(level(1.0)).collect::<Vec<_>>(), sides)
        .unwrap()
        .into()
}

pub fn random_shape(rng: &mut Rng) -> CollisionShape {
    match rng.u8(..5) {
        0 => CollisionShape::sphere(0.2 + rng.f32()),
        1 => tetrahedron(),
        2 => star(),
        #[cfg(feature = "rapier")]
        3 => Shape::from(&bevy_rapier3d::geometry::Collider::capsule_y(0.5, 0.3)).into(),
        _ => CollisionShape::from_half_size(vector(rng, 1.0).abs() + 0.1),
    }
}

/// An app with `count` random shapes within ten units of the origin, after a tick.
pub fn random_app(rng: &mut Rng, method: BroadPhaseMethod, count: usize) -> App {
    let mut app = app(method);
    for _ in 0..count {
        let place = Transform::from_translation(vector(rng, 10.0)).with_rotation(rotation(rng));
        let scale = vector(rng, 0.5) + 1.0;
        app.world_mut()
            .spawn((random_shape(rng), place.with_scale(scale)));
    }
    tick(&mut app, 1);
    app
}

/// All shapes and where they are, in the order of their entities.
pub fn everything(app: &mut App) -> Vec<(Entity, Shape, Transform)> {
    let mut shapes = app
        .world_mut()
        .query::<(Entity, &CollisionShape, &Transform)>();
    shapes
        .iter(app.world())
        .map(|(entity, shape, at)| (entity, shape.0.clone(), *at))
        .collect()
}

pub fn methods() -> [BroadPhaseMethod; 3] {
    ["linear", "object", "exhaustive"].map(|name| name.parse().expect("a method"))
}

#[test]
fn rays_and_neighbours_are_those_of_brute_force() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut rng = Rng::with_seed(seed as u64);
        let mut app = random_app(&mut rng, method, 400);
        let (objects, tests) = (everything(&mut app), *app.world().resource::<NarrowPhase>());
        let mut ray = || {
            let (origin, target) = (vector(&mut rng, 12.0), vector(&mut rng, 6.0));
            Ray3d::new(origin, Dir3::new(target - origin).unwrap_or(Dir3::X))
        };
        let rays: Vec<_> = (0..200).map(|_| ray()).collect();
        ask(&mut app, move |spatial| {
            let mut workspace = Workspace::default();
            let (mut hits, mut near, mut batch) = (vec![], vec![], vec![]);
            spatial.cast_rays(&rays, 15.0, &ALL, &mut batch);
            let mut met = 0;
            for (ray, in_batch) in rays.iter().zip(&batch) {
                let impact = |(entity, shape, at): &(Entity, Shape, Transform)| {
                    let impact =
                        tests.cast_ray(Placed::new(shape, at), ray.origin, ray.direction, 15.0)?;
                    Some((impact.distance, *entity))
                };
                let mut expected: Vec<_> = objects.iter().filter_map(impact).collect();
                expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                spatial.ray_hits(*ray, 15.0, &ALL, &mut hits);
                assert_eq!(
                    hits.iter()
                        .map(|hit| (hit.distance, hit.entity))
                        .collect::<Vec<_>>(),
                    expected
                );
                let first = spatial.cast_ray(*ray, 15.0, &ALL);
                assert_eq!(
                    first.map(|hit| hit.distance),
                    expected.first().map(|hit| hit.0)
                );
                assert_eq!(first, *in_batch);
                met += hits.len();

                let mut distances: Vec<_> = objects
                    .iter()
                    .map(|(entity, shape, at)| {
                        let closest =
                            tests.closest_point(Placed::new(shape, at), ray.origin, &mut workspace);
                        (closest.unwrap().distance(ray.origin), *entity)
                    })
                    .collect();
                distances.sort_by(|a, b| a.0.total_cmp(&b.0));
                spatial.k_nearest(ray.origin, 7, f32::INFINITY, &ALL, &mut near);
                let found: Vec<_> = near.iter().map(|hit| hit.distance).collect();
                assert_eq!(
                    found,
                    distances[..7].iter().map(|hit| hit.0).collect::<Vec<_>>()
                );
                assert_eq!(
                    spatial.nearest(ray.origin, f32::INFINITY, &ALL),
                    near.first().copied()
                );
            }
            assert!(met > 100, "{met}");
        });
    }
}

#[test]
fn overlaps_and_sweeps_are_those_of_brute_force() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut rng = Rng::with_seed(100 + seed as u64);
        let mut app = random_app(&mut rng, method, 400);
        let (objects, tests) = (everything(&mut app), *app.world().resource::<NarrowPhase>());
        ask(&mut app, move |spatial| {
            let (mut workspace, mut rng) = (Workspace::default(), Rng::with_seed(7));
            let (mut overlaps, mut sweeps) = (0, 0);
            for _ in 0..100 {
                let shape = random_shape(&mut rng);
                let place = Transform::from_translation(vector(&mut rng, 10.0))
                    .with_rotation(rotation(&mut rng));
                let (placed, way) = (Placed::new(&shape, &place), direction(&mut rng));
                let meets = |(entity, shape, at): &(Entity, Shape, Transform)| {
                    tests
                        .intersects(placed, Placed::new(shape, at), &mut workspace)
                        .then_some(*entity)
                };
                let mut expected: Vec<_> = objects.iter().filter_map(meets).collect();
                expected.sort();
                let mut found = vec![];
                spatial
                    .for_each_shape_intersection(&shape, &place, &ALL, |entity| found.push(entity));
                found.sort();
                overlaps += found.len();
                assert_eq!(found, expected);

                let impact = |(_, shape, at): &(Entity, Shape, Transform)| {
                    let impact =
                        tests.sweep(placed, way, 8.0, Placed::new(shape, at), &mut workspace)?;
                    Some(impact.distance)
                };
                let first = objects.iter().filter_map(impact).min_by(f32::total_cmp);
                let hit = spatial.cast_shape(&shape, &place, way, 8.0, &ALL);
                assert_eq!(hit.map(|hit| hit.distance), first);
                sweeps += usize::from(first.is_some_and(|distance| distance > 0.0));
            }
            assert!(overlaps > 20 && sweeps > 20, "{overlaps} {sweeps}");
        });
    }
}

/// A cube of side 2 that is turned by an eighth: its box reaches further than it does.
fn turned_cube(app: &mut App) -> Entity {
    let turned =
        Transform::from_xyz(10.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(FRAC_PI_4));
    app.world_mut()
        .spawn((CollisionShape::from_half_size(Vec3::ONE), turned))
        .id()
}

#[test]
fn what_is_in_the_box_but_not_in_the_shape_is_not_met() {
    let mut app = app(BroadPhaseMethod::default());
    let cube = turned_cube(&mut app);
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let corner = Vec3::new(8.7, 1.3, 0.0);
        let count = |query: &dyn Fn(&mut Vec<Entity>)| {
            let mut found = vec![];
            query(&mut found);
            assert!(found.iter().all(|entity| *entity == cube));
            found.len()
        };
        let at = |point: Vec3| {
            count(&|found| {
                spatial.for_each_point_intersection(point, &ALL, |entity| found.push(entity));
            })
        };
        assert_eq!(
            (at(corner), at(Vec3::X * 8.6), at(Vec3::X * 10.0)),
            (0, 1, 1)
        );
        let ball = |radius| {
            count(&|found| {
                spatial.for_each_sphere_intersection(corner, radius, &ALL, |entity| {
                    found.push(entity);
                });
            })
        };
        assert_eq!((ball(0.8), ball(0.9)), (0, 1));
        let cuboid = |half: f32| {
            let aabb = Aabb3d::new(corner, Vec3::splat(half));
            count(&|found| {
                spatial.for_each_box_intersection(&aabb, &ALL, |entity| found.push(entity));
            })
        };
        assert_eq!((cuboid(0.5), cuboid(0.7)), (0, 1));
        // Half-spaces and frustums see boxes.
        let beyond = |x: f32| [HalfSpace::new(Vec4::new(-1.0, 0.0, 0.0, x))];
        let planes = |x| {
            count(&|found| {
                spatial.for_each_half_space_intersection(&beyond(x), &ALL, |entity| {
                    found.push(entity);
                });
            })
        };
        assert_eq!((planes(8.0), planes(9.0)), (0, 1));
        let frustum = ViewFrustum::from_clip_from_world(&Mat4::orthographic_rh(
            8.7, 20.0, 1.3, 3.0, -5.0, 5.0,
        ));
        assert_eq!(
            count(&|found| spatial
                .for_each_frustum_intersection(&frustum, &ALL, |entity| found.push(entity))),
            1
        );

        let diagonal = 2f32.sqrt();
        let hit = spatial
            .cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &ALL)
            .unwrap();
        assert!(
            (hit.distance - (10.0 - diagonal)).abs() < 1e-4 && hit.entity == cube,
            "{hit:?}"
        );
        let hit = spatial.nearest(Vec3::ZERO, 100.0, &ALL).unwrap();
        assert!(
            (hit.distance - (10.0 - diagonal)).abs() < 1e-4 && hit.point.y.abs() < 1e-4,
            "{hit:?}"
        );
        assert_eq!(
            spatial.cast_ray(Ray3d::new(Vec3::new(8.7, 1.3, -5.0), Dir3::Z), 100.0, &ALL),
            None
        );
        let hit = spatial
            .cast_sphere(Vec3::ZERO, 0.5, Dir3::X, 100.0, &ALL)
            .unwrap();
        assert!((hit.distance - (9.5 - diagonal)).abs() < 1e-4, "{hit:?}");
        let unit = Aabb3d::new(Vec3::ZERO, Vec3::splat(0.5));
        let hit = spatial.cast_box(&unit, Dir3::X, 100.0, &ALL).unwrap();
        assert!(
            (hit.distance - (9.5 - diagonal)).abs() < 1e-3 && hit.normal.x < -0.5,
            "{hit:?}"
        );
    });
}

#[test]
fn filters_and_callbacks() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes: Vec<_> = (1..=5)
        .map(|x| {
            app.world_mut()
                .spawn((Cube, Transform::from_xyz(x as f32 * 2.0, 0.0, 0.0)))
                .id()
        })
        .collect();
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let first = |filter: &SpatialQueryFilter| {
            spatial
                .cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, filter)
                .map(|hit| hit.entity)
        };
        let set = EntityHashSet::from_iter([cubes[1], cubes[2]]);
        let odd = |entity| entity != cubes[3];
        let except = SpatialQueryFilter::DEFAULT.except(cubes[0]);
        assert_eq!(first(&ALL), Some(cubes[0]));
        assert_eq!(first(&except), Some(cubes[1]));
        assert_eq!(first(&except.excluding(&set)), Some(cubes[3]));
        assert_eq!(first(&except.excluding(&set).only(&odd)), Some(cubes[4]));
        assert_eq!(first(&ALL.only(&|_| false)), None);
        let nearest = spatial.nearest(Vec3::ZERO, 100.0, &except).unwrap();
        assert_eq!((nearest.entity, nearest.distance), (cubes[1], 3.5));

        let mut seen = 0;
        let ray = Ray3d::new(Vec3::ZERO, Dir3::X);
        spatial.for_each_ray_hit(ray, 100.0, &ALL, |_| {
            seen += 1;
            if seen == 2 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        assert_eq!(seen, 2);
        // A query within a query.
        let mut neighbours = 0;
        spatial.for_each_box_intersection(
            &Aabb3d::new(Vec3::ZERO, Vec3::splat(20.0)),
            &ALL,
            |entity| {
                let found = spatial.nearest(
                    Vec3::ZERO,
                    100.0,
                    &SpatialQueryFilter::DEFAULT.except(entity),
                );
                neighbours += usize::from(found.is_some());
            },
        );
        assert_eq!(neighbours, 5);
    });
}

#[test]
fn vectors_are_filled_with_what_callbacks_are_called_with() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut app = random_app(&mut Rng::with_seed(seed as u64), method, 200);
        ask(&mut app, |spatial| {
            // What is in them goes.
            let (mut filled, mut called) = (vec![Entity::PLACEHOLDER], Vec::new());
            let mut total = 0;
            let mut compare = |filled: &[Entity], called: &mut Vec<Entity>| {
                called.sort();
                assert_eq!(filled, *called);
                total += called.len();
                called.clear();
            };
            let (cube, place) = (
                Shape::from_half_size(Vec3::splat(3.0)),
                Transform::from_rotation(Quat::from_rotation_y(0.7)),
            );
            let aabb = Aabb3d::new(Vec3::ONE, Vec3::splat(4.0));
            let frustum = ViewFrustum {
                half_spaces: [HalfSpace::new(Vec4::X); 6],
            };
            spatial.box_intersections(&aabb, &ALL, &mut filled);
            spatial.for_each_box_intersection(&aabb, &ALL, |entity| called.push(entity));
            compare(&filled, &mut called);
            spatial.sphere_intersections(Vec3::ONE, 4.0, &ALL, &mut filled);
            spatial
                .for_each_sphere_intersection(Vec3::ONE, 4.0, &ALL, |entity| called.push(entity));
            compare(&filled, &mut called);
            spatial.point_intersections(Vec3::ONE, &ALL, &mut filled);
            spatial.for_each_point_intersection(Vec3::ONE, &ALL, |entity| called.push(entity));
            compare(&filled, &mut called);
            spatial.shape_intersections(&cube, &place, &ALL, &mut filled);
            spatial.for_each_shape_intersection(&cube, &place, &ALL, |entity| called.push(entity));
            compare(&filled, &mut called);
            spatial.frustum_intersections(&frustum, &ALL, &mut filled);
            spatial.for_each_frustum_intersection(&frustum, &ALL, |entity| called.push(entity));
            compare(&filled, &mut called);
            spatial.half_space_intersections(&frustum.half_spaces, &ALL, &mut filled);
            spatial.for_each_half_space_intersection(&frustum.half_spaces, &ALL, |entity| {
                called.push(entity);
            });
            compare(&filled, &mut called);
            assert!(total > 100, "{total}");

            let (mut filled, mut called) = (Vec::new(), Vec::new());
            spatial.pairs_within(1.0, &ALL, &ALL, &mut filled);
            spatial.for_each_pair_within(1.0, &ALL, &ALL, |pair| called.push(pair));
            called.sort_by(|a, b| {
                a.distance
                    .total_cmp(&b.distance)
                    .then((a.a, a.b).cmp(&(b.a, b.b)))
            });
            assert_eq!(filled, called);
            assert!(filled.len() > 20, "{}", filled.len());
        });
    }
}

#[derive(Clone, Copy)]
enum Layer {
    Ground,
    Foe,
    Beyond,
}

impl CollisionLayer for Layer {
    fn index(self) -> u32 {
        match self {
            Self::Ground => 0,
            Self::Foe => 7,
            Self::Beyond => 32,
        }
    }
}

#[test]
fn queries_by_layer() {
    for method in methods() {
        let mut app = app(method);
        // Whatever an entity may meet: a query asks what it is.
        let foe = CollisionLayers::from_bits(1 << 7, 0);
        let mut cube = |x: f32| {
            app.world_mut()
                .spawn((CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0)))
                .id()
        };
        let (plain, foes) = (cube(2.0), [cube(4.0), cube(6.0)]);
        for entity in foes {
            app.world_mut().entity_mut(entity).insert(foe);
        }
        tick(&mut app, 1);
        let found = |app: &mut App, filter: SpatialQueryFilter<'static>| {
            ask(app, move |spatial| {
                let ray = spatial
                    .cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &filter)
                    .map(|hit| hit.entity);
                let sphere = spatial
                    .cast_sphere(Vec3::ZERO, 0.5, Dir3::X, 100.0, &filter)
                    .map(|hit| hit.entity);
                let nearest = spatial
                    .nearest(Vec3::ZERO, 100.0, &filter)
                    .map(|hit| hit.entity);
                assert_eq!((ray, sphere), (nearest, nearest));
                let (mut inside, mut seen, mut hits) = (vec![], vec![], vec![]);
                spatial.for_each_box_intersection(
                    &Aabb3d::new(Vec3::ZERO, Vec3::splat(9.0)),
                    &filter,
                    |e| inside.push(e),
                );
                spatial.for_each_half_space_intersection(
                    &[HalfSpace::new(Vec4::X)],
                    &filter,
                    |entity| seen.push(entity),
                );
                spatial.k_nearest(Vec3::ZERO, 9, 100.0, &filter, &mut hits);
                inside.sort_by_key(|entity| entity.index_u32());
                seen.sort_by_key(|entity| entity.index_u32());
                assert_eq!(inside, seen);
                assert_eq!(
                    hits.iter().map(|hit| hit.entity).collect::<Vec<_>>(),
                    inside
                );
                assert_eq!(inside.first().copied(), nearest);
                inside
            })
        };
        let on = |layers: &[Layer]| ALL.on(layers.iter().copied().collect::<LayerMask>());
        assert_eq!(found(&mut app, ALL), [plain, foes[0], foes[1]]);
        assert_eq!(found(&mut app, on(&[Layer::Ground])), [plain]);
        assert_eq!(found(&mut app, on(&[Layer::Foe])), foes);
        assert_eq!(
            found(&mut app, on(&[Layer::Foe, Layer::Ground])),
            [plain, foes[0], foes[1]]
        );
        assert_eq!(found(&mut app, on(&[Layer::Beyond])), []);
        assert_eq!(found(&mut app, ALL.on(0)), []);
        // With other conditions, and in any order of them.
        assert_eq!(
            found(
                &mut app,
                SpatialQueryFilter::DEFAULT.except(foes[0]).on([Layer::Foe])
            ),
            [foes[1]]
        );
        assert_eq!(found(&mut app, on(&[Layer::Ground]).only(&|_| false)), []);
        // Layers that change are seen at the next tick.
        app.world_mut()
            .entity_mut(foes[0])
            .remove::<CollisionLayers>();
        tick(&mut app, 1);
        assert_eq!(found(&mut app, on(&[Layer::Ground])), [plain, foes[0]]);
        assert_eq!(found(&mut app, on(&[Layer::Foe])), [foes[1]]);
    }
}

#[test]
fn predicates_are_not_asked_about_other_layers() {
    let mut app = app(BroadPhaseMethod::default());
    let plain = app.world_mut().spawn(CollisionShape::default()).id();
    app.world_mut().spawn((
        CollisionShape::default(),
        CollisionLayers::from_bits(1 << 7, 0),
    ));
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let is_plain = |entity| {
            assert_eq!(entity, plain);
            true
        };
        let filter = ALL.only(&is_plain).on([Layer::Ground]);
        assert!(spatial.nearest(Vec3::ZERO, 1.0, &filter).is_some());
    });
}

#[derive(Resource, Default)]
struct Seen(Vec<Option<RayHit>>);

fn look(spatial: SpatialQuery, mut seen: ResMut<Seen>) {
    seen.0
        .push(spatial.cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &ALL));
}

#[test]
fn a_spawn_is_seen_in_its_frame_even_if_time_is_paused() {
    let spawn = |mut commands: Commands| {
        let parent = commands.spawn(Transform::from_xyz(3.0, 0.0, 0.0)).id();
        commands.spawn((Cube, Transform::from_xyz(2.0, 0.0, 0.0), ChildOf(parent)));
    };
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Seen>();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.add_systems(Startup, (spawn, look, update_spatial_index, look).chain());
    app.update();
    let seen = &app.world().resource::<Seen>().0;
    assert_eq!(seen[0], None, "nothing is seen before");
    assert_eq!(seen[1].map(|hit| hit.distance), Some(4.5));
    assert_eq!(
        app.world().resource::<CollisionClock>().tick(),
        0,
        "no time has passed"
    );

    // Moved, and gone, still without time.
    let cube = seen[1].unwrap().entity;
    get_mut::<Transform>(&mut app, cube).translation.x = 4.0;
    app.world_mut().commands().queue(update_spatial_index);
    app.world_mut().flush();
    let distance = |app: &mut App| {
        ask(app, |spatial| {
            spatial
                .cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &ALL)
                .map(|hit| hit.distance)
        })
    };
    assert_eq!(distance(&mut app), Some(6.5));
    app.world_mut().despawn(cube);
    assert_eq!(distance(&mut app), None, "without any flush");
}

#[test]
fn contacts_do_not_depend_on_flushes() {
    let mut rng = Rng::with_seed(5);
    let mut app = app(BroadPhaseMethod::default());
    let spawn = |app: &mut App, rng: &mut Rng| {
        let place = Transform::from_translation(vector(rng, 3.0));
        app.world_mut().spawn((random_shape(rng), place)).id()
    };
    let mut objects: Vec<_> = (0..40).map(|_| spawn(&mut app, &mut rng)).collect();
    for round in 0..30 {
        for _ in 0..rng.usize(..4) {
            let gone = objects.swap_remove(rng.usize(..objects.len()));
            app.world_mut().despawn(gone);
            for _ in 0..round % 4 {
                update_spatial_index(app.world_mut());
            }
            let place = Transform::from_translation(vector(&mut rng, 3.0));
            objects.push(spawn(&mut app, &mut rng));
            *get_mut(&mut app, objects[0]) = place;
        }
        update_spatial_index(app.world_mut());
        tick(&mut app, 1);
        // The log checks that each contact starts and ends once.
        assert_eq!(contacts(&app), brute_force_contacts(&mut app));
    }
}

#[test]
fn a_handle_that_is_used_again_between_two_ticks_brings_no_contact_with_it() {
    let mut app = app(BroadPhaseMethod::default());
    let spawn = |app: &mut App| app.world_mut().spawn(CollisionShape::default()).id();
    let (stays, goes) = (spawn(&mut app), spawn(&mut app));
    tick(&mut app, 1);
    let handle = get::<BroadPhaseProxy>(&app, goes).id();
    app.world_mut().despawn(goes);
    for _ in 0..2 {
        update_spatial_index(app.world_mut());
    }
    let comes = spawn(&mut app);
    tick(&mut app, 1);
    assert_eq!(get::<BroadPhaseProxy>(&app, comes).id(), handle);
    assert_eq!(messages_about(&app, pair(stays, goes)), (1, 1));
    assert_eq!(messages_about(&app, pair(stays, comes)), (1, 0));
}

#[test]
fn bad_input_finds_nothing() {
    let mut app = app(BroadPhaseMethod::default());
    app.world_mut().spawn((Cube, Transform::IDENTITY));
    app.world_mut()
        .spawn((Cube, Transform::from_xyz(f32::NAN, 0.0, 0.0)));
    tick(&mut app, 1);
    ask(&mut app, |spatial| {
        let (cube, here) = (CollisionShape::default(), Transform::IDENTITY);
        let (mut hits, mut near) = (vec![], vec![]);
        let none = |entity: Entity| assert_eq!(entity, Entity::PLACEHOLDER, "found something");
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let point = Vec3::new(0.0, bad, 0.0);
            assert_eq!(
                spatial.cast_ray(Ray3d::new(point, Dir3::X), 9.0, &ALL),
                None
            );
            spatial.ray_hits(Ray3d::new(point, Dir3::X), 9.0, &ALL, &mut hits);
            assert_eq!(
                spatial.cast_shape(
                    &cube,
                    &Transform::from_translation(point),
                    Dir3::X,
                    9.0,
                    &ALL
                ),
                None
            );
            assert_eq!(
                spatial.cast_sphere(Vec3::ZERO, bad, Dir3::X, 9.0, &ALL),
                None
            );
            assert_eq!(spatial.nearest(point, 9.0, &ALL), None);
            spatial.k_nearest(point, 3, 9.0, &ALL, &mut near);
            spatial.for_each_point_intersection(point, &ALL, none);
            spatial.for_each_sphere_intersection(Vec3::ZERO, bad, &ALL, none);
            spatial.for_each_shape_intersection(
                &cube,
                &Transform::from_translation(point),
                &ALL,
                none,
            );
        }
        for bad in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            assert_eq!(
                spatial.cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), bad, &ALL),
                None
            );
            assert_eq!(spatial.cast_shape(&cube, &here, Dir3::X, bad, &ALL), None);
            assert_eq!(
                spatial.cast_sphere(Vec3::ZERO, bad, Dir3::X, 9.0, &ALL),
                None
            );
            assert_eq!(spatial.nearest(Vec3::ZERO, bad, &ALL), None);
            spatial.k_nearest(Vec3::ZERO, 3, bad, &ALL, &mut near);
            spatial.for_each_sphere_intersection(Vec3::ZERO, bad, &ALL, none);
            spatial.for_each_half_space_intersection(
                &[HalfSpace::new(Vec4::new(bad, f32::NAN, 0.0, 0.0))],
                &ALL,
                none,
            );
            let aabb = Aabb3d {
                min: Vec3A::ZERO,
                max: Vec3A::new(0.0, bad, 0.0),
            };
            spatial.for_each_box_intersection(&aabb, &ALL, none);
            assert_eq!(spatial.cast_box(&aabb, Dir3::X, 9.0, &ALL), None);
        }
        spatial.k_nearest(Vec3::ZERO, 0, 9.0, &ALL, &mut near);
        assert!(hits.is_empty() && near.is_empty());
        // The one that is fine is found.
        assert!(spatial.nearest(Vec3::ZERO, 9.0, &ALL).is_some());
    });
}

/// Squares of distances are beyond the largest numbers from 1.8e19 on.
#[test]
fn what_is_far_away_is_found_at_its_distance() {
    let rotation = Quat::from_rotation_z(0.4);
    for method in methods() {
        for shape in [
            CollisionShape::sphere(1.0),
            CollisionShape::default(),
            tetrahedron(),
            star(),
        ] {
            let mut app = app(method.clone());
            let mut at = |x: f32| {
                let pose = Transform {
                    translation: Vec3::X * x,
                    rotation,
                    ..default()
                };
                app.world_mut().spawn((shape.clone(), pose)).id()
            };
            let [far, near, middle] = [8e25, 2e20, 5e22].map(&mut at);
            tick(&mut app, 1);
            ask(&mut app, move |spatial: SpatialQuery| {
                let is_about =
                    |found: f32, expected: f32| (found - expected).abs() < expected * 1e-5;
                for limit in [f32::INFINITY, 1e21, f32::MAX] {
                    let hit = spatial
                        .nearest(Vec3::ZERO, limit, &ALL)
                        .expect("one is within the limit");
                    assert!(
                        hit.entity == near && is_about(hit.distance, 2e20),
                        "{hit:?}"
                    );
                }
                assert_eq!(spatial.nearest(Vec3::ZERO, 1e20, &ALL), None);
                let mut hits = vec![];
                spatial.k_nearest(Vec3::ZERO, 2, f32::INFINITY, &ALL, &mut hits);
                assert_eq!(
                    hits.iter().map(|hit| hit.entity).collect::<Vec<_>>(),
                    [near, middle]
                );
                let mut pairs = vec![];
                spatial.for_each_pair_within(1e23, &ALL, &ALL, |pair| pairs.push(pair));
                assert_eq!(pairs.len(), 1);
                assert!(
                    [near, middle].contains(&pairs[0].a)
                        && is_about(pairs[0].distance, 5e22 - 2e20)
                );
                assert!(pairs[0].a != far && pairs[0].b != far);
            });
        }
        // As large as far away.
        let mut app = app(method);
        let pose = Transform::from_xyz(2e20, 0.0, 0.0).with_scale(Vec3::splat(1e18));
        let ball = app
            .world_mut()
            .spawn((CollisionShape::sphere(1.0), pose))
            .id();
        tick(&mut app, 1);
        ask(&mut app, move |spatial: SpatialQuery| {
            let ray = spatial
                .cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), f32::INFINITY, &ALL)
                .unwrap();
            assert!(
                ray.entity == ball && (ray.distance - 1.99e20).abs() < 1e16,
                "{ray:?}"
            );
            let hit = spatial
                .cast_sphere(Vec3::ZERO, 1e18, Dir3::X, f32::INFINITY, &ALL)
                .unwrap();
            assert!(
                hit.entity == ball && (hit.distance - 1.98e20).abs() < 1e16,
                "{hit:?}"
            );
        });
    }
}

#[test]
fn without_the_plugins_a_flush_does_nothing() {
    let mut world = World::new();
    world.spawn(CollisionShape::default());
    update_spatial_index(&mut world);
}

#[test]
fn pairs_within_a_distance_are_those_of_brute_force() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut rng = Rng::with_seed(seed as u64 + 70);
        let mut app = random_app(&mut rng, method, 150);
        let (objects, tests) = (everything(&mut app), *app.world().resource::<NarrowPhase>());
        ask(&mut app, move |spatial| {
            let mut workspace = Workspace::default();
            let is_first = |entity: Entity| entity.index_u32().is_multiple_of(3);
            let is_second = |entity: Entity| entity.index_u32().is_multiple_of(2);
            let (first, second) = (ALL.only(&is_first), ALL.only(&is_second));
            for limit in [0.0, 0.3, 2.0, f32::INFINITY] {
                let mut expected = vec![];
                for (i, (a, shape_a, at_a)) in objects.iter().enumerate() {
                    for (b, shape_b, at_b) in &objects[i + 1..] {
                        let (one, two) = (Placed::new(shape_a, at_a), Placed::new(shape_b, at_b));
                        let apart = tests
                            .closest_points(one, two, &mut workspace)
                            .unwrap()
                            .distance;
                        if apart <= limit
                            && (is_first(*a) && is_second(*b) || is_first(*b) && is_second(*a))
                        {
                            expected.push((pair(*a, *b), apart));
                        }
                    }
                }
                let (mut found, mut again, mut some) = (vec![], vec![], 0);
                spatial.for_each_pair_within(limit, &first, &second, |near| {
                    assert!(is_first(near.a) && is_second(near.b));
                    assert!((near.points[0].distance(near.points[1]) - near.distance).abs() < 1e-4);
                    found.push((pair(near.a, near.b), near.distance));
                });
                spatial.for_each_pair_within(limit, &first, &second, |near| {
                    again.push((pair(near.a, near.b), near.distance));
                });
                assert_eq!(found, again);
                expected.sort_by_key(|(pair, _)| *pair);
                found.sort_by_key(|(pair, _)| *pair);
                assert_eq!(found, expected, "{limit}");
                spatial.for_each_pair_within(limit, &first, &second, |_| {
                    some += 1;
                    ControlFlow::Break(())
                });
                // Who is first and second follows from the numbers of entities, which other plugins shift.
                assert_eq!(some, expected.len().min(1));
            }
            let none = |near| -> () { panic!("{near:?}") };
            spatial.for_each_pair_within(-1.0, &ALL, &ALL, none);
            spatial.for_each_pair_within(f32::NAN, &ALL, &ALL, none);
            let nobody = |_| false;
            spatial.for_each_pair_within(9.0, &ALL, &ALL.only(&nobody), none);
        });
    }
}
