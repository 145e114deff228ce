//! Layers, static entities, lists of entities to ignore, sensors and hooks.

use bevy::{
    ecs::{
        schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel},
        system::SystemParam,
    },
    prelude::*,
};
use bevy_octree::{
    broad_phase::PairKinds,
    motion::{MotionSettings, Step},
    prelude::*,
};

use crate::{common::warnings::warnings, hook::*};

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    app
}

/// So many cubes in one place.
fn cubes(app: &mut App, count: usize, parts: impl Bundle + Clone) -> Vec<Entity> {
    (0..count).map(|_| cube(app, parts.clone())).collect()
}

/// A cube in the place of all others.
fn cube(app: &mut App, parts: impl Bundle) -> Entity {
    app.world_mut()
        .spawn((CollisionShape::default(), parts))
        .id()
}

fn contacts(app: &mut App) -> usize {
    app.update();
    app.world().resource::<Contacts>().len()
}

#[derive(Clone, Copy)]
enum Layer {
    Ground,
    Bullet,
    Beyond,
}

impl CollisionLayer for Layer {
    fn index(self) -> u32 {
        match self {
            Self::Ground => 0,
            Self::Bullet => 31,
            Self::Beyond => 32,
        }
    }
}

collision_layers! {
    #[derive(PartialOrd, Reflect)]
    enum Team {
        Neutral,
        Red = 4,
        Blue,
    }
}

/// Where nothing but the names of crates is known, and some names mean something else.
mod strangers {
    #![no_implicit_prelude]

    use ::core::primitive::u32;

    #[expect(dead_code, reason = "the macro must not take these names for its own")]
    mod names {
        pub struct Into;
        pub struct Clone;
        pub struct Copy;
        pub struct Debug;
        pub struct Hash;
        pub struct LayerMask;
    }
    #[expect(unused_imports, reason = "as above")]
    use self::names::*;

    ::bevy_octree::collision_layers! {
        #[derive(::core::default::Default)]
        pub enum L {
            /// Has attributes.
            #[default]
            First,
            #[cfg(any())]
            Never = 99,
            #[cfg(all())]
            #[cfg(not(any()))]
            /// Has several.
            Second,
            #[expect(non_camel_case_types, reason = "an attribute that is no `cfg`")]
            last = 31,
        }
    }

    pub const NUMBERS: [u32; 3] = [L::First.mask().0, L::Second.mask().0, L::last.mask().0];
}

/// Masks are made where constants are.
const RED: CollisionLayers = CollisionLayers {
    memberships: Team::Red.mask(),
    filters: LayerMask::layer(5),
};

#[test]
fn an_enum_of_layers_needs_no_code_of_its_own() {
    assert_eq!(
        [Team::Neutral, Team::Red, Team::Blue].map(Team::mask),
        [1, 1 << 4, 1 << 5].map(LayerMask)
    );
    assert!(Team::Neutral < Team::Red);
    assert_eq!(RED, CollisionLayers::new(Team::Red, Team::Blue));
    assert_eq!(
        Team::Red | Team::Blue,
        LayerMask::from([Team::Blue, Team::Red])
    );
    assert_eq!(Team::Neutral.mask(), CollisionLayers::default().memberships);
    let mut app = app();
    cubes(&mut app, 2, RED);
    cubes(
        &mut app,
        3,
        CollisionLayers::new(Team::Blue, Team::Red | Team::Neutral),
    );
    assert_eq!(contacts(&mut app), 6);
}

/// Layers, arrays, masks, bits and nothing at all, in any order.
#[test]
fn layers_are_written_as_they_come() {
    let bits = CollisionLayers::from_bits;
    let (red, blue) = (1 << 4, 1 << 5);
    for (written, expected) in [
        (CollisionLayers::new([Team::Red], []), bits(red, 0)),
        (CollisionLayers::new([], [Team::Red]), bits(0, red)),
        (CollisionLayers::new([], []), CollisionLayers::NONE),
        (CollisionLayers::new(Team::Red, []), bits(red, 0)),
        (CollisionLayers::new([], LayerMask::ALL), bits(0, u32::MAX)),
        (CollisionLayers::new(3, []), bits(3, 0)),
        (CollisionLayers::new(1, 2), bits(1, 2)),
        (
            CollisionLayers::new(Team::Red, [Team::Red, Team::Blue]),
            bits(red, red | blue),
        ),
        (
            CollisionLayers::new([Team::Red], LayerMask::layer(5)),
            bits(red, blue),
        ),
        (
            CollisionLayers::from_masks(Team::Red.mask(), LayerMask::NONE),
            bits(red, 0),
        ),
    ] {
        assert_eq!(written, expected);
    }
    let all: [Team; 32] = [Team::Blue; 32];
    assert_eq!(LayerMask::from(all), LayerMask(blue));
    assert!(LayerMask(blue).contains([]) && !LayerMask::ALL.intersects([]));
    assert_eq!(LayerMask::ALL & [], LayerMask::NONE);
}

#[test]
fn who_is_on_a_layer_and_meets_none_is_met_by_nobody() {
    let mut app = app();
    cubes(&mut app, 2, CollisionLayers::new([Team::Red], []));
    cubes(&mut app, 2, CollisionLayers::new([], [Team::Red]));
    assert_eq!(contacts(&mut app), 0);
    let detector = CollisionLayers::new([], [Team::Red]);
    cube(&mut app, (Detector, detector));
    assert_eq!(contacts(&mut app), 2);
}

#[test]
fn an_enum_of_layers_may_have_any_name_and_attributes() {
    use strangers::{L, NUMBERS};
    assert_eq!(NUMBERS, [1, 2, 1 << 31]);
    assert_eq!(L::default() | L::Second | Team::Red, LayerMask(0b1_0011));
}

#[test]
fn layers_come_go_and_change() {
    let mut app = app();
    let bullets = CollisionLayers::new([Layer::Bullet], [Layer::Ground]);
    let (a, b) = (cube(&mut app, bullets), cube(&mut app, bullets));
    cube(&mut app, ());
    assert_eq!(contacts(&mut app), 2, "each bullet with the ground");
    app.world_mut().entity_mut(a).remove::<CollisionLayers>();
    assert_eq!(contacts(&mut app), 3, "one is like the ground now");
    app.world_mut().entity_mut(a).insert(bullets);
    assert_eq!(contacts(&mut app), 2, "and no longer");
    *app.world_mut().get_mut::<CollisionLayers>(b).unwrap() = CollisionLayers::NONE;
    assert_eq!(contacts(&mut app), 1);
    assert_eq!(contacts(&mut app), 1, "nothing changes while nothing does");
    app.world_mut().despawn(a);
    assert_eq!(contacts(&mut app), 0);
}

#[test]
fn layers_beyond_the_last_match_nothing() {
    let mut app = app();
    let layers = CollisionLayers::new([Layer::Beyond], [Layer::Beyond]);
    assert_eq!(layers, CollisionLayers::NONE);
    cubes(&mut app, 3, layers);
    assert_eq!(contacts(&mut app), 0);
}

#[test]
fn an_entity_in_the_place_of_one_that_went_has_no_filter_of_it() {
    let mut app = app();
    let none = cubes(&mut app, 40, CollisionLayers::NONE);
    assert_eq!(contacts(&mut app), 0);
    for entity in none {
        app.world_mut().despawn(entity);
    }
    for _ in 0..4 {
        app.update();
    }
    cubes(&mut app, 40, ());
    assert_eq!(contacts(&mut app), 40 * 39 / 2);
}

#[test]
fn static_entities_do_not_meet_each_other_however_they_move() {
    let mut app = app();
    let wall = cube(&mut app, StaticShape);
    cube(&mut app, StaticShape);
    let mover = cube(&mut app, Velocity(Vec3::ZERO));
    assert_eq!(contacts(&mut app), 2);
    app.world_mut()
        .get_mut::<Transform>(wall)
        .unwrap()
        .translation
        .x += 0.25;
    assert_eq!(contacts(&mut app), 2);
    app.world_mut().despawn(mover);
    assert_eq!(contacts(&mut app), 0);
    app.world_mut().entity_mut(wall).remove::<StaticShape>();
    assert_eq!(contacts(&mut app), 1);
}

const NO_PAIRS: PairKinds = PairKinds {
    moving_moving: false,
    moving_static: false,
    static_static: false,
};

fn with_kinds(app: &mut App, pair_kinds: PairKinds) -> usize {
    app.world_mut()
        .resource_mut::<BroadPhaseSettings>()
        .pair_kinds = pair_kinds;
    contacts(app)
}

#[test]
fn kinds_of_pairs_come_and_go_though_nothing_moves() {
    for (method, count) in [
        (BroadPhaseMethod::LinearOctree, 2),
        (BroadPhaseMethod::ObjectOctree(default()), 2),
        (BroadPhaseMethod::Exhaustive, 2),
        (default(), 60),
    ] {
        let mut app = app();
        app.insert_resource(BroadPhaseSettings {
            method,
            ..default()
        });
        cubes(&mut app, count, StaticShape);
        cubes(&mut app, 3, ());
        let (fixed, mixed, moving) = (count * (count - 1) / 2, 3 * count, 3);
        for _ in 0..2 {
            assert_eq!(with_kinds(&mut app, PairKinds::default()), mixed + moving);
            assert_eq!(
                with_kinds(
                    &mut app,
                    PairKinds {
                        static_static: true,
                        ..NO_PAIRS
                    }
                ),
                fixed
            );
            assert_eq!(
                with_kinds(
                    &mut app,
                    PairKinds {
                        static_static: true,
                        ..default()
                    }
                ),
                fixed + mixed + moving
            );
            assert_eq!(
                contacts(&mut app),
                fixed + mixed + moving,
                "nothing changes while nothing does"
            );
            assert_eq!(
                with_kinds(
                    &mut app,
                    PairKinds {
                        moving_static: false,
                        ..default()
                    }
                ),
                moving
            );
            assert_eq!(
                with_kinds(
                    &mut app,
                    PairKinds {
                        moving_moving: false,
                        ..default()
                    }
                ),
                mixed
            );
            assert_eq!(with_kinds(&mut app, NO_PAIRS), 0);
        }
    }
}

#[test]
fn kinds_count_where_nothing_else_is_filtered() {
    for count in [3, 80] {
        let mut app = app();
        cubes(&mut app, count, ());
        let all = count * (count - 1) / 2;
        assert_eq!(contacts(&mut app), all);
        assert_eq!(
            with_kinds(
                &mut app,
                PairKinds {
                    moving_moving: false,
                    ..default()
                }
            ),
            0
        );
        assert_eq!(
            with_kinds(
                &mut app,
                PairKinds {
                    moving_static: false,
                    ..default()
                }
            ),
            all
        );
    }
}

#[test]
fn what_is_removed_many_frames_before_the_next_tick_is_gone() {
    // Frames without a tick: the messages about removed components are kept for two of them.
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Ticks)));
    app.init_schedule(Ticks);
    let tick = |app: &mut App| {
        app.world_mut().run_schedule(Ticks);
        app.world().resource::<Contacts>().len()
    };
    let layers = cube(&mut app, CollisionLayers::NONE);
    let walls = cubes(&mut app, 2, StaticShape);
    assert_eq!(tick(&mut app), 0);
    app.world_mut()
        .entity_mut(layers)
        .remove::<CollisionLayers>();
    app.world_mut().entity_mut(walls[0]).remove::<StaticShape>();
    for _ in 0..5 {
        app.update();
    }
    assert_eq!(tick(&mut app), 3);
}

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Ticks;

#[test]
fn entities_that_are_ignored_do_not_meet_while_they_are() {
    let mut app = app();
    let owner = cube(&mut app, ());
    let bullet = cube(
        &mut app,
        IgnoreCollisions::from([owner, Entity::PLACEHOLDER]),
    );
    cube(&mut app, ());
    assert_eq!(contacts(&mut app), 2);
    assert_eq!(contacts(&mut app), 2, "nothing moved");
    app.world_mut()
        .entity_mut(bullet)
        .remove::<IgnoreCollisions>();
    assert_eq!(contacts(&mut app), 3);
    app.world_mut()
        .entity_mut(owner)
        .insert(IgnoreCollisions::from([bullet]));
    assert_eq!(contacts(&mut app), 2, "a list in a contact ends it");
    app.world_mut().despawn(owner);
    assert_eq!(contacts(&mut app), 1);
}

#[test]
fn nothing_bounces_off_a_sensor() {
    let mut app = app();
    app.insert_resource(MotionSettings {
        step: Step::Seconds(1.0),
    });
    for bounce in [Bounce::Reverse, Bounce::Reflect { restitution: 1.0 }] {
        let sensor = cube(&mut app, (Sensor, Velocity(Vec3::ZERO), bounce));
        let at = Transform::from_xyz(-0.75, 0.0, 0.0);
        let ball = cube(&mut app, (Velocity(Vec3::X * 0.125), bounce, at));
        assert_eq!(contacts(&mut app), 1, "it is reported");
        assert_eq!(
            app.world().get::<Velocity>(ball).unwrap().0,
            Vec3::X * 0.125
        );
        app.world_mut().entity_mut(sensor).remove::<Sensor>();
        app.update();
        assert!(
            app.world().get::<Velocity>(ball).unwrap().0.x <= 0.0,
            "{bounce:?}"
        );
        app.world_mut().despawn(ball);
        app.world_mut().despawn(sensor);
    }
}

#[test]
fn a_hook_has_the_last_word() {
    let mut app = app();
    app.add_plugins(PairHookPlugin::<NoGhosts>::default());
    cube(&mut app, Ghost);
    cubes(&mut app, 3, ());
    assert_eq!(contacts(&mut app), 3);
}

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Elsewhere;

#[test]
fn a_hook_may_be_added_first_and_goes_where_the_ticks_are() {
    let mut app = App::new();
    app.init_schedule(Elsewhere);
    app.add_plugins((
        PairHookPlugin::<NoGhosts>::default(),
        MinimalPlugins,
        OctreePlugins::new(Elsewhere),
    ));
    assert_eq!(warnings(|| app.finish()), 0);
    cube(&mut app, Ghost);
    cubes(&mut app, 3, ());
    app.world_mut().run_schedule(Elsewhere);
    assert_eq!(app.world().resource::<Contacts>().len(), 3);
}

/// A hook that has nothing against anyone.
#[derive(SystemParam)]
struct Anyone;

impl PairHook for Anyone {
    fn admits(_: &Self, _: Entity, _: Entity) -> bool {
        true
    }
}

#[test]
fn hooks_and_lists_leave_no_order_open() {
    let mut app = App::new();
    app.add_plugins((
        PairHookPlugin::<NoGhosts>::default(),
        PairHookPlugin::<Anyone>::default(),
    ));
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Elsewhere)));
    app.edit_schedule(Elsewhere, |ticks| {
        ticks.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Error,
            ..default()
        });
    });
    let ghost = cube(&mut app, Ghost);
    cube(&mut app, IgnoreCollisions::from([ghost]));
    cube(&mut app, ());
    app.world_mut().run_schedule(Elsewhere);
    assert_eq!(app.world().resource::<Contacts>().len(), 1);
}

#[test]
fn a_hook_without_ticks_says_so() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, PairHookPlugin::<NoGhosts>::default()));
    assert_eq!(warnings(|| app.finish()), 1);
    app.update();
}
