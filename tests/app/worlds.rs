//! Independent worlds in one app: against an app for each, as entities come, go and move between
//! them.

use crate::common;

use std::collections::HashMap;

use bevy::{ecs::system::RunSystemOnce, math::bounding::Aabb3d, prelude::*};
use bevy_octree::prelude::*;
use common::*;
use fastrand::Rng;

const RED: CollisionLayers = CollisionLayers::from_bits(0b10, 0b101);

fn worlds<const N: usize>(app: &mut App) -> [Entity; N] {
    std::array::from_fn(|_| app.world_mut().spawn_empty().id())
}

/// A cube in the place of all others.
fn cube(app: &mut App, parts: impl Bundle) -> Entity {
    app.world_mut()
        .spawn((CollisionShape::default(), parts))
        .id()
}

/// The contacts after a tick; the log checks that each starts and ends once.
fn ticked(app: &mut App) -> Vec<EntityPair> {
    tick(app, 1);
    contacts(app)
}

#[test]
fn entities_of_different_worlds_never_meet() {
    let mut app = app(BroadPhaseMethod::default());
    let [first, second] = worlds(&mut app);
    let [a, b] = [first; 2].map(|world| cube(&mut app, InCollisionWorld(world)));
    let [c, d] = [second; 2].map(|world| cube(&mut app, InCollisionWorld(world)));
    let [e, f] = [(); 2].map(|()| cube(&mut app, ()));
    assert_eq!(ticked(&mut app), [[a, b], [c, d], [e, f]]);
    // From one world to another, out of all of them, and into one.
    app.world_mut()
        .entity_mut(a)
        .insert(InCollisionWorld(second));
    assert_eq!(ticked(&mut app), [[a, c], [a, d], [c, d], [e, f]]);
    app.world_mut().entity_mut(a).remove::<InCollisionWorld>();
    assert_eq!(ticked(&mut app), [[a, e], [a, f], [c, d], [e, f]]);
    app.world_mut()
        .entity_mut(e)
        .insert(InCollisionWorld(first));
    assert_eq!(ticked(&mut app), [[a, f], [b, e], [c, d]]);
    assert_eq!(
        ticked(&mut app),
        [[a, f], [b, e], [c, d]],
        "nothing changes while nothing does"
    );
    assert_eq!(get::<CollisionWorld>(&app, first).entities().len(), 2);
}

#[test]
fn a_world_that_goes_leaves_no_ghost() {
    let mut app = app(BroadPhaseMethod::default());
    let [first, second] = worlds(&mut app);
    for world in [first, first, second, second] {
        cube(&mut app, InCollisionWorld(world));
    }
    let outside = cube(&mut app, ());
    assert_eq!(ticked(&mut app).len(), 2);
    app.world_mut().despawn(first);
    assert_eq!(
        index(&app).proxies().len(),
        3,
        "they are out of the index at once"
    );
    assert_eq!(ticked(&mut app).len(), 1);
    // Another world in its place.
    let [third] = worlds(&mut app);
    let of_third = [third; 2].map(|world| cube(&mut app, InCollisionWorld(world)));
    assert!(ticked(&mut app).contains(&pair(of_third[0], of_third[1])));
    assert_eq!(contacts(&app).len(), 2);
    // Without its list, a world is none: its entities are in the default one.
    app.world_mut()
        .entity_mut(second)
        .remove::<CollisionWorld>();
    let met = ticked(&mut app);
    assert_eq!(met.len(), 4, "{met:?}");
    assert_eq!(met.iter().filter(|pair| pair.contains(&outside)).count(), 2);
}

#[test]
fn a_world_that_never_was_is_the_default_one() {
    let mut app = app(BroadPhaseMethod::default());
    let [gone] = worlds(&mut app);
    app.world_mut().despawn(gone);
    let a = cube(&mut app, InCollisionWorld(gone));
    let b = cube(&mut app, ());
    assert_eq!(ticked(&mut app), [[a, b]]);
    app.world_mut().entity_mut(a).insert(InCollisionWorld(gone));
    assert_eq!(ticked(&mut app), [[a, b]]);
}

#[test]
fn layers_and_static_entities_are_of_a_world_too() {
    let mut app = app(BroadPhaseMethod::default());
    let [first, second] = worlds(&mut app);
    let mut red = |world| cube(&mut app, (InCollisionWorld(world), RED));
    let reds = [red(first), red(first), red(second)];
    let [wall, floor] = [(); 2].map(|()| cube(&mut app, (InCollisionWorld(first), StaticShape)));
    let plain = cube(&mut app, InCollisionWorld(second));
    let expected = [
        [reds[0], wall],
        [reds[0], floor],
        [reds[1], wall],
        [reds[1], floor],
        [reds[2], plain],
    ];
    assert_eq!(ticked(&mut app), expected);
    // What they were stays with them.
    app.world_mut()
        .entity_mut(wall)
        .insert(InCollisionWorld(second));
    app.world_mut()
        .entity_mut(reds[0])
        .insert(InCollisionWorld(second));
    let expected = [
        [reds[0], wall],
        [reds[0], plain],
        [reds[1], floor],
        [reds[2], wall],
        [reds[2], plain],
        [wall, plain],
    ];
    assert_eq!(ticked(&mut app), expected);
    app.world_mut()
        .entity_mut(reds[0])
        .remove::<CollisionLayers>();
    assert!(ticked(&mut app).contains(&[reds[0], reds[2]]));
}

#[test]
fn queries_see_one_world() {
    let mut app = app(BroadPhaseMethod::default());
    let [first, second, empty] = worlds(&mut app);
    let mut at = |x: f32, parts: &dyn Fn(EntityWorldMut)| {
        let entity = cube(&mut app, Transform::from_xyz(x, 0.0, 0.0));
        parts(app.world_mut().entity_mut(entity));
        entity
    };
    let plain = at(8.0, &|_| {});
    let a = at(2.0, &|mut entity| {
        _ = entity.insert(InCollisionWorld(first));
    });
    let b = at(4.0, &|mut entity| {
        _ = entity.insert((InCollisionWorld(first), RED));
    });
    let c = at(6.0, &|mut entity| {
        _ = entity.insert(InCollisionWorld(second));
    });
    tick(&mut app, 1);
    let found = |app: &mut App, filter: SpatialQueryFilter<'static>| {
        app.world_mut()
            .run_system_once(move |spatial: SpatialQuery| {
                let ray = spatial
                    .cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &filter)
                    .map(|hit| hit.entity);
                let nearest = spatial
                    .nearest(Vec3::ZERO, 100.0, &filter)
                    .map(|hit| hit.entity);
                let mut inside = vec![];
                spatial.for_each_box_intersection(
                    &Aabb3d::new(Vec3::ZERO, Vec3::splat(9.0)),
                    &filter,
                    |e| inside.push(e),
                );
                inside.sort_by_key(|entity| entity.index_u32());
                assert_eq!(
                    (ray, inside.contains(&ray.unwrap_or(Entity::PLACEHOLDER))),
                    (nearest, ray.is_some())
                );
                assert_eq!(ray.is_none(), inside.is_empty());
                inside
            })
            .unwrap()
    };
    let all = SpatialQueryFilter::DEFAULT;
    assert_eq!(found(&mut app, SpatialQueryFilter::default()), [plain]);
    assert_eq!(found(&mut app, all.in_world(first)), [a, b]);
    assert_eq!(found(&mut app, all.in_world(second)), [c]);
    assert_eq!(found(&mut app, all.in_world(empty)), []);
    assert_eq!(found(&mut app, all.in_any_world()), [plain, a, b, c]);
    assert_eq!(found(&mut app, all.in_any_world().on(RED.memberships)), [b]);
    assert_eq!(found(&mut app, all.in_any_world().in_world(second)), [c]);
    assert_eq!(
        found(&mut app, all.in_world(first).on(RED.memberships)),
        [b]
    );
    assert_eq!(
        found(&mut app, all.in_world(second).on(RED.memberships)),
        []
    );
    assert_eq!(
        found(
            &mut app,
            SpatialQueryFilter::DEFAULT.except(b).in_world(first)
        ),
        [a]
    );
    // Without a tick, or a flush.
    app.world_mut()
        .entity_mut(c)
        .insert(InCollisionWorld(first));
    assert_eq!(found(&mut app, all.in_world(first)), [a, b, c]);
    app.world_mut().entity_mut(a).remove::<InCollisionWorld>();
    assert_eq!(found(&mut app, all), pair(plain, a));
    // Layers change under a mutable reference: seen after a flush.
    app.world_mut()
        .get_mut::<CollisionLayers>(b)
        .unwrap()
        .memberships = LayerMask(0b100);
    update_spatial_index(app.world_mut());
    assert_eq!(found(&mut app, all.in_world(first).on(0b100)), [b]);
}

/// An object of a random history, by its number: where it is in each app.
#[derive(Clone, Copy)]
struct Object {
    shared: Entity,
    alone: Entity,
    world: usize,
}

/// Several worlds in one app, and an app for each: the same contacts, whatever comes, goes, moves
/// and changes worlds.
#[test]
fn worlds_are_as_apps_of_their_own() {
    const WORLDS: usize = 4;
    for (seed, method) in ["auto", "linear", "object", "exhaustive"]
        .into_iter()
        .enumerate()
    {
        let (mut rng, method) = (
            Rng::with_seed(seed as u64),
            method.parse::<BroadPhaseMethod>().unwrap(),
        );
        let mut shared = app(method.clone());
        let mut alone: Vec<App> = (0..WORLDS).map(|_| app(method.clone())).collect();
        // The last is the default world.
        let names: [Entity; WORLDS - 1] = worlds(&mut shared);
        let mut objects: Vec<Object> = Vec::new();
        let mut seen = 0;
        for round in 0..40 {
            for _ in 0..if round == 0 { 200 } else { 20 } {
                let place = Transform::from_xyz(rng.f32() * 6.0, rng.f32() * 6.0, rng.f32() * 6.0);
                let world = rng.usize(..WORLDS);
                let number = rng.usize(..objects.len().max(1));
                let parts = (
                    CollisionShape::default(),
                    place,
                    if rng.bool() {
                        RED
                    } else {
                        CollisionLayers::default()
                    },
                );
                match (
                    rng.u8(..if round == 0 { 1 } else { 5 }),
                    objects.get_mut(number),
                ) {
                    (0, _) | (_, None) => {
                        let mut entity = shared.world_mut().spawn(parts.clone());
                        if let Some(name) = names.get(world) {
                            entity.insert(InCollisionWorld(*name));
                        }
                        let shared = entity.id();
                        objects.push(Object {
                            shared,
                            alone: alone[world].world_mut().spawn(parts).id(),
                            world,
                        });
                    }
                    (1, Some(object)) => {
                        shared.world_mut().despawn(object.shared);
                        alone[object.world].world_mut().despawn(object.alone);
                        objects.swap_remove(number);
                    }
                    (2, Some(object)) => {
                        *get_mut(&mut shared, object.shared) = place;
                        *get_mut(&mut alone[object.world], object.alone) = place;
                    }
                    (3, Some(object)) => {
                        shared.world_mut().entity_mut(object.shared).insert(parts.2);
                        alone[object.world]
                            .world_mut()
                            .entity_mut(object.alone)
                            .insert(parts.2);
                    }
                    (_, Some(object)) => {
                        let mut entity = shared.world_mut().entity_mut(object.shared);
                        match names.get(world) {
                            Some(name) => entity.insert(InCollisionWorld(*name)),
                            None => entity.remove::<InCollisionWorld>(),
                        };
                        let kept = (
                            CollisionShape::default(),
                            *entity.get::<Transform>().unwrap(),
                        );
                        let layers = *entity.get::<CollisionLayers>().unwrap();
                        alone[object.world].world_mut().despawn(object.alone);
                        object.world = world;
                        object.alone = alone[world].world_mut().spawn((kept, layers)).id();
                    }
                }
            }
            let by_entity: HashMap<Entity, usize> = objects
                .iter()
                .enumerate()
                .map(|(n, o)| (o.shared, n))
                .collect();
            let mut found: Vec<_> = ticked(&mut shared)
                .iter()
                .map(|pair| numbered(*pair, &by_entity))
                .collect();
            found.sort_unstable();
            let mut expected = Vec::new();
            for (world, app) in alone.iter_mut().enumerate() {
                let of_world = objects
                    .iter()
                    .enumerate()
                    .filter(|(_, object)| object.world == world);
                let by_entity: HashMap<Entity, usize> =
                    of_world.map(|(n, o)| (o.alone, n)).collect();
                expected.extend(ticked(app).iter().map(|pair| numbered(*pair, &by_entity)));
            }
            expected.sort_unstable();
            assert_eq!(found, expected);
            seen += found.len();
        }
        assert!(seen > 1000, "{seen}");
    }
}

fn numbered(pair: EntityPair, numbers: &HashMap<Entity, usize>) -> [usize; 2] {
    let mut pair = pair.map(|entity| numbers[&entity]);
    pair.sort_unstable();
    pair
}

/// What `bsn!` builds entities from.
#[test]
fn worlds_can_be_named_in_templates() {
    let mut app = app(BroadPhaseMethod::default());
    let [world] = worlds(&mut app);
    let template = <InCollisionWorld as FromTemplate>::Template::default();
    let entity = &mut app.world_mut().spawn_empty();
    assert!(
        entity.build_template(&template).is_err(),
        "no world is given"
    );
    let mut template = template;
    template.0 = world.into();
    assert_eq!(
        entity.build_template(&template).unwrap(),
        InCollisionWorld(world)
    );
}

#[test]
fn worlds_are_known_to_reflection() {
    let app = app(BroadPhaseMethod::default());
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for name in ["InCollisionWorld", "CollisionWorld"] {
        let registration = registry
            .get_with_short_type_path(name)
            .expect("it is registered");
        assert!(registration.data::<ReflectComponent>().is_some());
    }
}
