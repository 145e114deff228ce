//! Entities with parents, entities that are disabled, and an index that is away: who takes part,
//! where, and what it costs to know.

use crate::common;

use std::{
    sync::mpsc,
    time::{Duration, Instant},
};

use bevy::{
    ecs::entity_disabling::Disabled,
    math::{DAffine3, bounding::BoundingVolume},
    prelude::*,
};
use bevy_octree::{collision_index::CollisionIndex, components::WorldAabb, prelude::*};
use common::{warnings::warnings, *};

/// A component that disables, as those of rollback crates.
#[derive(Component)]
struct Parked;

/// Another, of which the app comes to know late.
#[derive(Component)]
struct Late;

fn plain_app(plugins: bool) -> App {
    let mut app = App::new();
    app.add_plugins(MinimalPlugins);
    if plugins {
        app.add_plugins(OctreePlugins::new(Update));
    }
    app
}

/// Each the child of the one before. Their distance is 2.
fn chain(app: &mut App, length: usize, bundle: impl Bundle + Copy) -> Vec<Entity> {
    let mut chain = vec![app.world_mut().spawn((Transform::default(), bundle)).id()];
    while chain.len() < length {
        let parent = ChildOf(*chain.last().unwrap());
        chain.push(
            app.world_mut()
                .spawn((Transform::from_xyz(2.0, 0.0, 0.0), bundle, parent))
                .id(),
        );
    }
    chain
}

/// The shortest of some runs.
fn shortest(mut run: impl FnMut()) -> Duration {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed()
    };
    (0..7).map(time).min().unwrap()
}

const MANY: usize = 4000;

/// What is quadratic takes hundreds of times as long as what is linear; a machine that is busy, some times as long.
const MUCH: u32 = 60;

#[derive(Component, Clone, Copy)]
struct Part;

#[test]
fn deep_hierarchies_cost_what_flat_ones_do() {
    let mut flat = plain_app(true);
    let row = (0..MANY).map(|i| {
        (
            CollisionShape::default(),
            Transform::from_xyz(i as f32 * 2.0, 0.0, 0.0),
        )
    });
    let row: Vec<_> = flat
        .world_mut()
        .spawn_batch(row.collect::<Vec<_>>())
        .collect();
    let mut deep = plain_app(true);
    let chain = chain(&mut deep, MANY, Part);
    for entity in &chain {
        deep.world_mut()
            .entity_mut(*entity)
            .insert(CollisionShape::default());
    }
    for app in [&mut flat, &mut deep] {
        tick(app, 3);
    }
    let resting = [&mut flat, &mut deep].map(|app| shortest(|| tick(app, 1)));
    assert!(
        resting[1] < resting[0] * MUCH + Duration::from_micros(100),
        "at rest: {resting:?}"
    );

    // All of them move: each by itself, and all with the first.
    let moving_flat = shortest(|| {
        for entity in &row {
            get_mut::<Transform>(&mut flat, *entity).translation.y += 0.5;
        }
        tick(&mut flat, 1);
    });
    let moving_deep = shortest(|| {
        get_mut::<Transform>(&mut deep, chain[0]).translation.y += 0.5;
        tick(&mut deep, 1);
    });
    assert_eq!(counters(&deep).moved, MANY as u64);
    assert!(
        moving_deep < moving_flat * MUCH,
        "with the first: {moving_deep:?}, {moving_flat:?}"
    );
    let moving_all = shortest(|| {
        for entity in &chain {
            get_mut::<Transform>(&mut deep, *entity).set_changed();
        }
        tick(&mut deep, 1);
    });
    assert!(
        moving_all < moving_flat * MUCH,
        "each by itself: {moving_all:?}, {moving_flat:?}"
    );
}

#[test]
fn chains_are_despawned_in_linear_time() {
    // Bevy despawns a chain by recursion, which takes a stack as deep as the build is plain.
    let test = std::thread::Builder::new().stack_size(64 << 20);
    let test = test.spawn(despawn_chains).unwrap();
    test.join().unwrap();
}

fn despawn_chains() {
    let despawn = |plugins: bool, with_shapes: bool| {
        let mut app = plain_app(plugins);
        let mut spawn = || {
            let chain = chain(&mut app, MANY, Part);
            for entity in chain.iter().filter(|_| with_shapes) {
                app.world_mut()
                    .entity_mut(*entity)
                    .insert(CollisionShape::default());
            }
            tick(&mut app, 1);
            let start = Instant::now();
            app.world_mut().despawn(chain[0]);
            start.elapsed()
        };
        (0..5).map(|_| spawn()).min().unwrap()
    };
    for with_shapes in [false, true] {
        // Once is enough: others may use the machine at the time.
        let is_linear = (0..10).any(|_| despawn(true, with_shapes) < despawn(false, false) * 8);
        assert!(
            is_linear,
            "more than eight times what it takes without the plugins, with shapes: {with_shapes}"
        );
    }
}

/// What is in a circle of parents is nowhere, until somebody breaks it.
#[test]
fn a_cycle_of_parents_never_hangs() {
    let (done, is_done) = mpsc::channel();
    std::thread::spawn(move || {
        let mut app = app(BroadPhaseMethod::default());
        let at = |x: f32| (CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0));
        let [a, b, c] = [1.0, 2.0, 4.0].map(|x| app.world_mut().spawn(at(x)).id());
        let hanging = app
            .world_mut()
            .spawn((at(8.0), ChildOf(c), Swept::default()))
            .id();
        let beside = app.world_mut().spawn(at(15.5)).id();
        app.world_mut().entity_mut(b).insert(ChildOf(a));
        app.world_mut().entity_mut(c).insert(ChildOf(b));
        tick(&mut app, 2);
        assert_eq!(
            (index(&app).proxies().len(), contacts(&app)),
            (5, vec![pair(hanging, beside)])
        );
        let told = warnings(|| {
            app.world_mut().entity_mut(a).insert(ChildOf(c));
            tick(&mut app, 2);
        });
        assert_eq!(told, 1);
        assert_eq!((index(&app).proxies().len(), contacts(&app)), (1, vec![]));
        // What comes to it later is nowhere too.
        let late = app
            .world_mut()
            .spawn((at(1.0), ChildOf(hanging), Swept::default()))
            .id();
        get_mut::<Transform>(&mut app, b).translation.x = 3.0;
        tick(&mut app, 2);
        update_spatial_index(app.world_mut());
        assert_eq!(index(&app).proxies().len(), 1);
        app.world_mut().entity_mut(b).remove::<ChildOf>();
        tick(&mut app, 1);
        assert_eq!(index(&app).proxies().len(), 6);
        let found =
            [a, b, c, hanging, late].map(|entity| get::<WorldAabb>(&app, entity).center().x);
        assert_eq!(found, [8.0, 3.0, 7.0, 15.0, 16.0]);
        done.send(()).unwrap();
    });
    assert_eq!(is_done.recv_timeout(Duration::from_secs(60)), Ok(()));
}

fn local(transform: &Transform) -> DAffine3 {
    let Transform {
        translation,
        rotation,
        scale,
    } = *transform;
    DAffine3::from_scale_rotation_translation(
        scale.as_dvec3(),
        rotation.as_dquat(),
        translation.as_dvec3(),
    )
}

/// Where an entity is, by the rules: a parent without a transform is the world's origin, and who is
/// its own ancestor is nowhere.
fn place(world: &World, entity: Entity) -> Option<DAffine3> {
    let (mut place, mut next) = (local(world.get::<Transform>(entity)?), entity);
    for _ in 0..1000 {
        let Some(parent) = world.get::<ChildOf>(next).map(ChildOf::parent) else {
            return Some(place);
        };
        let Some(transform) = world.get::<Transform>(parent) else {
            return Some(place);
        };
        (place, next) = (local(transform) * place, parent);
    }
    None
}

/// Who takes part, and the centres of their boxes.
fn in_index(app: &App) -> Vec<(Entity, Vec3)> {
    let collisions = app.world().resource::<CollisionIndex>();
    let boxes = collisions.index().proxies().iter();
    let mut all: Vec<_> = boxes
        .map(|(id, aabb)| (collisions.entity(id).unwrap(), aabb.center().into()))
        .collect();
    all.sort_by_key(|(entity, _)| *entity);
    all
}

fn expected(app: &mut App, is_disabled: impl Fn(EntityRef) -> bool) -> Vec<(Entity, Vec3)> {
    let world = app.world();
    let all = world.iter_entities().filter(|entity| {
        entity.contains::<CollisionShape>()
            && entity.contains::<WorldAabb>()
            && !is_disabled(*entity)
    });
    let centers = all.filter_map(|entity| {
        Some((
            entity.id(),
            place(world, entity.id())?.translation.as_vec3(),
        ))
    });
    let mut centers: Vec<_> = centers.collect();
    centers.sort_by_key(|(entity, _)| *entity);
    centers
}

/// Something that befalls an entity, or two.
fn befall(world: &mut World, rng: &mut fastrand::Rng, entities: &mut Vec<Entity>) {
    let (one, other) = (
        entities[rng.usize(..entities.len())],
        entities[rng.usize(..entities.len())],
    );
    let at = Vec3::new(rng.f32(), rng.f32(), rng.f32()) * 4.0;
    let turned = Quat::from_euler(EulerRot::XYZ, rng.f32(), rng.f32(), rng.f32());
    let at = Transform::from_translation(at)
        .with_rotation(turned)
        .with_scale(Vec3::splat(0.75 + rng.f32() * 0.5));
    let mut one = world.entity_mut(one);
    match rng.u8(0..24) {
        0..4 => {
            entities.push(
                world
                    .spawn((at, CollisionShape::default(), ChildOf(other)))
                    .id(),
            );
        }
        4 | 5 => entities.push(world.spawn(at).id()),
        6..9 => {
            one.insert(at);
        }
        9 => {
            one.remove::<Transform>();
        }
        10..13 if one.id() != other => {
            one.insert(ChildOf(other));
        }
        13 => {
            one.remove::<ChildOf>();
        }
        14 => {
            one.insert(CollisionShape::default());
        }
        15 => {
            one.remove::<CollisionShape>();
        }
        16 => {
            one.insert(Disabled);
        }
        17 => {
            one.insert((Parked, Late));
        }
        18 | 19 => {
            one.remove::<(Disabled, Late)>();
        }
        20 => {
            one.remove::<Parked>();
        }
        21 => {
            one.remove::<WorldAabb>();
        }
        22 if one.contains::<CollisionShape>() => {
            one.insert(WorldAabb::default());
        }
        23 if rng.bool() => one.despawn(),
        _ => {}
    }
    entities.retain(|entity| world.get_entity(*entity).is_ok());
    if entities.is_empty() {
        entities.push(world.spawn(at).id());
    }
}

/// Whatever happens, whatever of it while the index is away: after the tick, all are in the index
/// that should be, and where they are.
#[test]
fn random_histories() {
    for seed in 0..200 {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut app = app(BroadPhaseMethod::default());
        app.world_mut().register_disabling_component::<Parked>();
        let mut entities = vec![app.world_mut().spawn(Transform::default()).id()];
        for time in 0..30 {
            if time == 15 {
                // Only from then on.
                app.world_mut().register_disabling_component::<Late>();
            }
            for _ in 0..rng.usize(0..6) {
                if rng.u8(0..4) == 0 {
                    app.world_mut()
                        .resource_scope::<CollisionIndex, _>(|world, _| {
                            befall(world, &mut rng, &mut entities);
                        });
                } else {
                    befall(app.world_mut(), &mut rng, &mut entities);
                }
            }
            match rng.u8(0..10) {
                0 => app.insert_resource(CollisionIndex::default()),
                1 => {
                    update_spatial_index(app.world_mut());
                    &mut app
                }
                _ => &mut app,
            };
            tick(&mut app, 1);
            let is_late = time >= 15;
            let found = in_index(&app);
            let expected = expected(&mut app, |entity| {
                entity.contains::<Disabled>()
                    || entity.contains::<Parked>()
                    || is_late && entity.contains::<Late>()
            });
            let entities_of = |list: &[(Entity, Vec3)]| {
                list.iter().map(|(entity, _)| *entity).collect::<Vec<_>>()
            };
            assert_eq!(
                entities_of(&found),
                entities_of(&expected),
                "seed {seed}, tick {time}"
            );
            for ((entity, found), (_, expected)) in found.iter().zip(&expected) {
                assert!(
                    found.distance(*expected) < 1e-3 * (1.0 + expected.length()),
                    "seed {seed}, tick {time}: {entity}"
                );
            }
        }
    }
}
