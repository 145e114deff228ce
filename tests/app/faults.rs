//! What goes wrong in the app around it: panics in hooks and observers, everything gone at once,
//! resources that are taken away, plugins that come twice, late or alone, and a time that jumps.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    time::Duration,
};

use bevy::{
    ecs::{
        entity_disabling::Disabled, error::ignore, lifecycle::HookContext, world::DeferredWorld,
    },
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_octree::{
    collision_index::{CandidatePairs, CollisionIndex},
    motion::{CollisionClock, MotionSettings, PositionTrack, Step},
    narrow_phase::NarrowPhase,
    plugins::{BouncePlugin, MotionPlugin},
    prelude::*,
    scene::Cube,
};

use crate::common::*;

/// Does what panics, and says whether it did.
fn panics(act: impl FnOnce()) -> bool {
    catch_unwind(AssertUnwindSafe(act)).is_err()
}

/// Panics as it comes or goes.
#[derive(Component)]
#[component(on_add = Self::on_add, on_remove = Self::on_remove)]
struct Bomb {
    comes: bool,
}

impl Bomb {
    fn on_add(world: DeferredWorld, context: HookContext) {
        Self::strike(&world, context.entity, true);
    }

    fn on_remove(world: DeferredWorld, context: HookContext) {
        Self::strike(&world, context.entity, false);
    }

    fn strike(world: &DeferredWorld, entity: Entity, comes: bool) {
        let own = world.get::<Self>(entity);
        assert!(own.is_none_or(|own| own.comes != comes), "a hook panics");
    }
}

/// What a spawn or a despawn leaves behind that a hook of the app's broke off is half done, as Bevy
/// leaves it. Ticks go on, all others are as they were, and once it is gone nothing is left of it.
#[test]
fn a_hook_that_panics_breaks_nothing_but_its_own_entity() {
    for method in [BroadPhaseMethod::default(), BroadPhaseMethod::Exhaustive] {
        for first in [true, false] {
            for comes in [true, false] {
                let (mut app, cubes) = in_contact();
                app.world_mut().resource_mut::<BroadPhaseSettings>().method = method.clone();
                let at = Transform::from_xyz(0.0, 0.9, 0.0);
                let broken = panics(|| {
                    let world = app.world_mut();
                    let broken = if first {
                        world
                            .spawn((Bomb { comes }, CollisionShape::default(), at))
                            .id()
                    } else {
                        world
                            .spawn((CollisionShape::default(), at, Bomb { comes }))
                            .id()
                    };
                    app.update();
                    app.world_mut().despawn(broken);
                });
                assert!(broken);
                tick(&mut app, 3);
                assert!(contacts(&app).contains(&cubes));
                assert_eq!(messages_about(&app, cubes), (1, 0));
                // Whatever is left of it goes.
                let world = app.world_mut();
                let mut left = world.query_filtered::<Entity, With<CollisionShape>>();
                let left: Vec<_> = left
                    .iter(world)
                    .filter(|left| !cubes.contains(left))
                    .collect();
                for left in left {
                    world.entity_mut(left).insert(Bomb { comes: true });
                    _ = world.try_despawn(left);
                }
                tick(&mut app, 2);
                assert_eq!(
                    (contacts(&app), index(&app).proxies().len()),
                    (vec![cubes], 2)
                );
            }
        }
    }
}

#[derive(Resource, Default)]
struct Heard(Vec<[Entity; 2]>);

/// An observer that panics breaks off the tick, and Bevy's schedule with it. All that is the
/// crate's is still there: nothing is lost, queries answer, the world may be taken elsewhere.
#[test]
fn an_observer_that_panics_leaves_the_world_whole() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes = [block(&mut app, 0.0), block(&mut app, 0.9)];
    for cube in cubes {
        let mut cube = app.world_mut().entity_mut(cube);
        cube.insert(CollisionEventsEnabled)
            .observe(|_: On<CollisionStarted>| panic!("an observer panics"));
    }
    assert!(panics(|| app.update()));
    let world = app.world_mut();
    update_spatial_index(world);
    assert!(world.contains_resource::<CollisionIndex>());
    assert!(world.contains_resource::<CandidatePairs>());
    assert_eq!(world.resource::<Contacts>().len(), 1);
    let look = |spatial: SpatialQuery| {
        let mut found = Vec::new();
        let all = SpatialQueryFilter::DEFAULT;
        spatial.sphere_intersections(Vec3::ZERO, 0.1, &all, &mut found);
        found
    };
    assert_eq!(world.run_system_cached(look).unwrap(), [cubes[0]]);
    for cube in cubes {
        world.despawn(cube);
    }
    assert_eq!(index(&app).proxies().len(), 0);
}

/// One that catches its own panic is an observer like all others.
#[test]
fn an_observer_that_catches_its_panic_is_told_of_the_end_too() {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Heard>();
    let cubes = [block(&mut app, 0.0), block(&mut app, 0.9)];
    for cube in cubes {
        let mut cube = app.world_mut().entity_mut(cube);
        cube.insert(CollisionEventsEnabled)
            .observe(|event: On<CollisionStarted>, mut heard: ResMut<Heard>| {
                heard.0.push([event.a, event.b]);
                assert!(panics(|| panic!("it is caught")));
            })
            .observe(|event: On<CollisionEnded>, mut heard: ResMut<Heard>| {
                heard.0.retain(|pair| *pair != [event.a, event.b]);
            });
    }
    tick(&mut app, 2);
    assert_eq!(app.world().resource::<Heard>().0.len(), 2);
    get_mut::<Transform>(&mut app, cubes[1]).translation.x = 5.0;
    tick(&mut app, 1);
    assert!(app.world().resource::<Heard>().0.is_empty());
}

/// Some of everything, all in contact.
fn crowd(app: &mut App) -> Vec<Entity> {
    let world = app.world_mut();
    let body = world
        .spawn((CollisionBody::default(), Transform::default()))
        .id();
    let other_world = world.spawn_empty().id();
    let mut all = vec![body, other_world];
    let bounce = Bounce::Reflect { restitution: 1.0 };
    for number in 0..12_u8 {
        let at = Transform::from_xyz(f32::from(number) * 0.4, 0.0, 0.0);
        let mut entity = world.spawn((CollisionShape::sphere(0.5), at, CollisionEventsEnabled));
        match number % 6 {
            0 => _ = entity.insert((Velocity(Vec3::X * 90.0), bounce, Swept::default())),
            1 => _ = entity.insert((ChildOf(body), Sensor)),
            2 => _ = entity.insert((CollidingEntities::default(), ManifoldsEnabled)),
            3 => _ = entity.insert(InCollisionWorld(other_world)),
            4 => _ = entity.insert((Velocity(Vec3::Y), KinematicCharacter::default())),
            _ => _ = entity.insert((RayCaster::default(), Velocity(Vec3::Y * 9.0), bounce)),
        }
        all.push(entity.id());
    }
    all
}

/// An app without a log of its own, which does not mind resources that are not there.
fn lenient_app() -> App {
    let mut app = App::new();
    app.set_error_handler(ignore)
        .add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / 64.0),
        });
    app
}

/// Everything that the tick is about goes between any two sets.
#[test]
fn all_may_go_between_any_two_sets() {
    #[derive(Resource, Default)]
    struct Doomed(Vec<Entity>);

    for set in SETS {
        for disable in [false, true] {
            let mut app = app(BroadPhaseMethod::default());
            app.init_resource::<Doomed>();
            let strike = move |world: &mut World| {
                for entity in std::mem::take(&mut world.resource_mut::<Doomed>().0) {
                    if disable {
                        world.entity_mut(entity).insert(Disabled);
                    } else {
                        _ = world.try_despawn(entity);
                    }
                }
            };
            app.add_systems(FixedPostUpdate, strike.in_set(set));
            for round in 0..3 {
                let all = crowd(&mut app);
                tick(&mut app, 1);
                app.world_mut().resource_mut::<Doomed>().0 = all;
                tick(&mut app, 2);
                let left = (contacts(&app).len(), index(&app).proxies().len());
                assert_eq!(left, (0, 0), "{set:?}, round {round}");
            }
        }
    }
}

/// Bevy's `clear_entities` takes all resources with it, Bevy's own too, and no hook hears of it:
/// there is nothing left to tick, as where the plugins never were. An update does no harm.
#[test]
fn a_world_that_was_cleared_is_a_world_without_the_plugins() {
    let mut app = lenient_app();
    crowd(&mut app);
    app.update();
    let world = app.world_mut();
    world.clear_entities();
    update_spatial_index(world);
    assert!(!world.contains_resource::<CollisionIndex>());
}

type Taken = (&'static str, fn(&mut World), fn(&mut World));

const fn resource<R: Resource + Default>(name: &'static str) -> Taken {
    let take = |world: &mut World| _ = world.remove_resource::<R>();
    let give = |world: &mut World| world.insert_resource(R::default());
    (name, take, give)
}

/// All that is public, and may be made anew.
const RESOURCES: [Taken; 9] = [
    resource::<CollisionIndex>("CollisionIndex"),
    resource::<CandidatePairs>("CandidatePairs"),
    resource::<Contacts>("Contacts"),
    resource::<CollisionEventSettings>("CollisionEventSettings"),
    resource::<NarrowPhase>("NarrowPhase"),
    resource::<CollisionClock>("CollisionClock"),
    resource::<MotionSettings>("MotionSettings"),
    resource::<CollisionCounters>("CollisionCounters"),
    resource::<BroadPhaseSettings>("BroadPhaseSettings"),
];

fn check_at_rest(app: &mut App, what: &str) {
    let expected = brute_force_contacts(app);
    assert_eq!(contacts(app), expected, "{what}");
    assert_eq!(index(app).proxies().len(), 4, "{what}");
}

/// A system that needs a resource which is not there does not run; whether that is an error, is up
/// to the app's error handler. Once it is there again, everything is right by the next tick but one.
#[test]
fn resources_may_be_taken_away_and_come_back() {
    for (name, take, give) in RESOURCES {
        for gap in 0..3 {
            let mut app = lenient_app();
            let blocks: Vec<_> = (0..4).map(|x| block(&mut app, x as f32 * 0.9)).collect();
            app.update();
            take(app.world_mut());
            // Ticks, and what may happen meanwhile.
            for _ in 0..gap {
                app.update();
            }
            get_mut::<Transform>(&mut app, blocks[0]).translation.x = 1.8;
            app.world_mut().despawn(blocks[1]);
            let world = app.world_mut();
            world
                .entity_mut(blocks[2])
                .insert((Disabled, Sensor, CollisionLayers::NONE));
            update_spatial_index(world);
            world
                .entity_mut(blocks[2])
                .remove::<(Disabled, Sensor, CollisionLayers)>();
            block(&mut app, 4.4);
            for _ in 0..gap {
                app.update();
            }
            give(app.world_mut());
            app.update();
            app.update();
            check_at_rest(&mut app, &format!("{name}, {gap} ticks without it"));
        }
    }
}

/// In the middle of a tick too.
#[test]
fn resources_may_be_taken_away_between_any_two_sets() {
    for (name, take, give) in RESOURCES {
        for place in 1..SETS.len() {
            let mut app = lenient_app();
            for x in 0..4 {
                block(&mut app, x as f32 * 0.9);
            }
            app.update();
            let armed = |place: usize| {
                move |world: &mut World| {
                    let now = world
                        .get_resource::<Armed>()
                        .is_some_and(|armed| armed.0 == place);
                    if now {
                        world.remove_resource::<Armed>();
                    }
                    now
                }
            };
            let system = move |world: &mut World| {
                if armed(place)(world) {
                    take(world);
                }
            };
            app.add_systems(Update, system.after(SETS[place - 1]).before(SETS[place]));
            app.insert_resource(Armed(place));
            app.update();
            app.update();
            give(app.world_mut());
            app.update();
            app.update();
            check_at_rest(&mut app, &format!("{name}, taken before {:?}", SETS[place]));
        }
    }
}

#[derive(Resource)]
struct Armed(usize);

/// Bevy itself refuses it, before anything is built twice.
#[test]
#[should_panic(expected = "plugin was already added")]
fn plugins_that_come_twice_are_refused() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    app.add_plugins(OctreePlugins::new(Update));
}

#[test]
#[should_panic(expected = "plugin was already added")]
fn a_stage_that_comes_twice_is_refused() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, BouncePlugin, OctreePlugins::new(Update)));
}

/// A stage alone has no ticks, and does nothing. What was there before the plugins is taken up.
#[test]
fn plugins_may_come_late_or_alone() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, MotionPlugin));
    app.world_mut().spawn((Cube, Velocity(Vec3::X)));
    app.update();

    let mut app = App::new();
    app.add_plugins(MinimalPlugins);
    let all = [0.0, 0.9].map(|x| block(&mut app, x));
    let body = app
        .world_mut()
        .spawn((CollisionBody::default(), Transform::default()))
        .id();
    app.world_mut()
        .entity_mut(all[1])
        .insert((ChildOf(body), Swept::default(), Sensor));
    app.update();
    app.add_plugins(OctreePlugins::new(Update));
    app.update();
    assert_eq!(contacts(&app), [all]);
    assert_eq!(get::<PartOf>(&app, all[1]).body(), body);
    app.update();
    assert_eq!(contacts(&app), [all]);
}

/// Steps of any number, by a crowd that does all that is done by the length of a tick.
#[test]
fn a_step_of_any_length_does_no_harm() {
    let steps = [
        f32::NAN,
        -1.0,
        f32::NEG_INFINITY,
        f32::INFINITY,
        f32::MAX,
        f32::MIN_POSITIVE,
        1e-45,
        -0.0,
        1e20,
    ];
    for method in [
        BroadPhaseMethod::default(),
        BroadPhaseMethod::ObjectOctree(default()),
    ] {
        for step in steps {
            let mut app = app(method.clone());
            crowd(&mut app);
            let track = PositionTrack::new([(0, Vec3::ZERO), (10, Vec3::Y)]);
            app.world_mut().spawn((Cube, track.unwrap()));
            tick(&mut app, 2);
            app.insert_resource(MotionSettings {
                step: Step::Seconds(step),
            });
            tick(&mut app, 5);
            // And all is as ever once it is right again.
            app.insert_resource(MotionSettings::default());
            tick(&mut app, 5);
            let fresh = [0.0, 0.9].map(|x| {
                let at = Transform::from_xyz(x, 700.0, 0.0);
                app.world_mut().spawn((CollisionShape::default(), at)).id()
            });
            tick(&mut app, 1);
            assert!(contacts(&app).contains(&fresh), "{step}");
        }
    }
}

/// Time may stop, jump, and begin again; the clock of ticks may be set to any tick.
#[test]
fn a_time_that_jumps_does_no_harm() {
    let mut app = app_with(OctreePlugins::new(Update), Update);
    crowd(&mut app);
    let track = PositionTrack::new([(0, Vec3::ZERO), (10, Vec3::Y)]);
    let tracked = app.world_mut().spawn((Cube, track.unwrap())).id();
    for (number, millis) in [0, 1, 16, 1000, 60_000, 0, 5000, 16]
        .into_iter()
        .enumerate()
    {
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(
            millis,
        )));
        // Virtual time lets no more pass than it is told.
        app.world_mut()
            .resource_mut::<Time<Virtual>>()
            .set_max_delta(Duration::from_millis(millis.max(1)));
        tick(&mut app, 1);
        let tick_to = [0, u64::MAX, 7, 3, u64::MAX - 1, 0, 1 << 40, 5][number];
        app.world_mut()
            .resource_mut::<CollisionClock>()
            .set_tick(tick_to);
        tick(&mut app, 1);
        assert!(get::<Transform>(&app, tracked).is_finite());
        if millis == 5000 {
            // It begins again: what is read of it goes backwards.
            app.insert_resource(Time::<Real>::default());
            app.insert_resource(Time::<Virtual>::default());
            app.insert_resource(Time::<()>::default());
        }
    }
    let fresh = [0.0, 0.9].map(|x| {
        let at = Transform::from_xyz(x, 700.0, 0.0);
        app.world_mut().spawn((CollisionShape::default(), at)).id()
    });
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(
        16,
    )));
    tick(&mut app, 1);
    assert!(contacts(&app).contains(&fresh));
}
