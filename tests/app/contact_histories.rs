//! Random histories of everything that may happen to contacts: what is kept from tick to tick is
//! what comes out where all is looked at anew in each tick, by another broad phase.

use crate::common;

use bevy::{
    ecs::{entity::EntityHashSet, entity_disabling::Disabled},
    prelude::*,
};
use bevy_octree::{
    components::WorldAabb,
    diagnostics::STAGES,
    motion::{MotionSettings, Step},
    narrow_phase::NarrowPhase,
    prelude::*,
};
use common::{interrupted::*, *};
use fastrand::Rng;

const COUNT: usize = 24;
const TICKS: usize = 30;
const REACH: f32 = 2.5;

#[derive(Resource, Default)]
struct Tricks {
    rng: Option<Rng>,
    boxes: bool,
    flush: bool,
}

fn enlarge(mut tricks: ResMut<Tricks>, mut boxes: Query<&mut WorldAabb>) {
    if !tricks.boxes {
        return;
    }
    let Some(rng) = &mut tricks.rng else { return };
    for mut aabb in &mut boxes {
        if rng.u8(0..8) == 0 && aabb.min.is_finite() && aabb.max.x < 1e9 {
            aabb.0.min -= 0.5;
            aabb.0.max += 0.5;
        }
    }
}

/// Without Rapier, there are no half-spaces: a slab takes its place.
#[cfg(not(feature = "rapier"))]
fn half_space() -> CollisionShape {
    CollisionShape::from_half_size(Vec3::new(50.0, 0.5, 50.0))
}

#[cfg(feature = "rapier")]
fn half_space() -> CollisionShape {
    let normal = Vec3::new(0.3, 1.0, 0.1).normalize();
    Shape::from(&bevy_rapier3d::prelude::Collider::halfspace(normal).unwrap()).into()
}

struct History {
    app: App,
    rng: Rng,
    objects: Vec<Entity>,
    bounces: bool,
    log: Vec<String>,
    worlds: Vec<Entity>,
}

fn make_app(method: BroadPhaseMethod) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / 64.0),
        })
        .init_resource::<Tricks>();
    let_sets_be_skipped(&mut app);
    app.world_mut().resource_mut::<BroadPhaseSettings>().method = method;
    for gap in 1..SETS.len() {
        let flush = |world: &mut World| {
            let mut tricks = world.resource_mut::<Tricks>();
            if !tricks.flush {
                return;
            }
            let count = tricks
                .rng
                .as_mut()
                .map_or(0, |rng| rng.u8(0..8).saturating_sub(5));
            for _ in 0..count {
                update_spatial_index(world);
            }
        };
        app.add_systems(Update, flush.after(SETS[gap - 1]).before(SETS[gap]));
    }
    app.add_systems(
        Update,
        enlarge
            .after(CollisionSystems::Bounds)
            .before(CollisionSystems::Maintenance),
    );
    app
}

impl History {
    fn new(method: BroadPhaseMethod, seed: u64, bounces: bool) -> Self {
        let mut history = Self {
            app: make_app(method),
            rng: Rng::with_seed(seed),
            objects: Vec::new(),
            bounces,
            log: Vec::new(),
            worlds: Vec::new(),
        };
        // It spawns what it keeps of its systems.
        update_spatial_index(history.app.world_mut());
        history.worlds = (0..2)
            .map(|_| history.app.world_mut().spawn_empty().id())
            .collect();
        for _ in 0..COUNT {
            let new = history.spawn();
            history.objects.push(new);
        }
        history
    }

    fn vector(&mut self, reach: f32) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| (self.rng.f32() * 2.0 - 1.0) * reach))
    }

    fn spawn(&mut self) -> Entity {
        let shape = match self.rng.u8(0..12) {
            0..5 => CollisionShape::default(),
            5..10 => CollisionShape::sphere(0.2 + self.rng.f32() * 0.5),
            10 => CollisionShape::from_half_size(Vec3::splat(0.1) + self.vector(0.5).abs()),
            _ => half_space(),
        };
        let mut transform = Transform::from_translation(self.vector(REACH));
        if self.rng.bool() {
            transform.rotation = Quat::from_scaled_axis(self.vector(2.0));
        }
        let velocity = Velocity(self.vector(40.0));
        let (moves, swept) = (self.rng.u8(0..3) == 0, self.rng.u8(0..3) == 0);
        let stops = self.rng.bool();
        let bounce = self.bounces && self.rng.bool();
        let mut entity = self.app.world_mut().spawn((shape, transform));
        if moves {
            entity.insert(velocity);
        }
        if swept {
            entity.insert(if stops {
                Swept::stopping()
            } else {
                Swept::default()
            });
        }
        if bounce {
            entity.insert(Bounce::Reflect { restitution: 0.7 });
        }
        entity.id()
    }

    fn edit(&mut self) {
        let which = self.rng.usize(0..COUNT);
        let other = self.objects[self.rng.usize(0..COUNT)];
        let entity = self.objects[which];
        let to = self.vector(REACH);
        let kind = self.rng.u8(0..28);
        let number = self.rng.u32(1..4);
        let collision_world = self.worlds[self.rng.usize(0..2)];
        self.log.push(format!("{kind} {entity} {other} {to}"));
        let mut object = self.app.world_mut().entity_mut(entity);
        match kind {
            0 | 1 => object.get_mut::<Transform>().unwrap().translation = to,
            2 => object.get_mut::<Transform>().unwrap().set_changed(),
            3 => {
                object.get_mut::<CollisionShape>().unwrap().0 =
                    Shape::from_half_size(to.abs() * 0.3 + 0.1);
            }
            4 => _ = object.insert(IgnoreCollisions::from([other])),
            5 => _ = object.remove::<IgnoreCollisions>(),
            6 => _ = object.insert(CollisionLayers::from_bits(number, 2)),
            7 => _ = object.remove::<CollisionLayers>(),
            8 => _ = object.insert(CollisionEventsEnabled),
            9 => _ = object.remove::<CollisionEventsEnabled>(),
            10 => _ = object.insert(InCollisionWorld(collision_world)),
            11 => _ = object.remove::<InCollisionWorld>(),
            12 | 13 if object.contains::<Disabled>() => _ = object.remove::<Disabled>(),
            12 => _ = object.insert(Disabled),
            14 => _ = object.insert(ManifoldsEnabled),
            15 => _ = object.remove::<ManifoldsEnabled>(),
            16 => _ = object.insert(StaticShape),
            17 => _ = object.remove::<StaticShape>(),
            18 => _ = object.insert(Detector),
            19 => _ = object.remove::<(Detector, Sensor)>(),
            20 => _ = object.insert(Sensor),
            21 => _ = object.remove::<Swept>(),
            22 => _ = object.insert(Swept::default()),
            23 => _ = object.insert(CollidingEntities::default()),
            24 if entity != other && !object.contains::<Children>() => {
                let parented = object.world().get::<ChildOf>(other).is_some();
                if !parented {
                    object.insert(ChildOf(other));
                }
            }
            25 => _ = object.remove::<ChildOf>(),
            26 => {
                let rest = Velocity(Vec3::ZERO);
                object.insert(rest);
            }
            _ => {
                object.despawn();
                for place in 0..COUNT {
                    if self.app.world().get_entity(self.objects[place]).is_err() {
                        self.objects[place] = self.spawn();
                    }
                }
            }
        }
    }

    fn edit_some(&mut self) {
        for _ in 0..self.rng.u8(0..5) {
            self.edit();
        }
        match self.rng.u8(0..30) {
            0 => {
                self.log.push("mass despawn".to_string());
                for place in 0..COUNT / 2 {
                    self.app.world_mut().despawn(self.objects[place]);
                }
                for place in 0..COUNT {
                    if self.app.world().get_entity(self.objects[place]).is_err() {
                        self.objects[place] = self.spawn();
                    }
                }
            }
            1 => {
                let scope = |rng: &mut Rng| {
                    if rng.bool() {
                        EventScope::All
                    } else {
                        EventScope::Enabled
                    }
                };
                let rng = &mut self.rng;
                let settings = CollisionEventSettings {
                    geometry: scope(rng),
                    observers: scope(rng),
                    manifolds: scope(rng),
                    ..default()
                };
                self.app.insert_resource(settings);
                self.log.push("settings".to_string());
            }
            2 => {
                let tolerance = if self.rng.bool() { 1e-4 } else { 1e-2 };
                self.app
                    .insert_resource(NarrowPhase::new(tolerance).unwrap());
                self.log.push("tolerance".to_string());
            }
            _ => {}
        }
    }

    fn seen(&mut self) -> Vec<String> {
        let world = self.app.world_mut();
        let contacts = world.resource::<Contacts>();
        let mut seen: Vec<_> = contacts
            .iter()
            .map(|contact| {
                assert_eq!(contacts.between(contact.a, contact.b), Some(contact));
                assert!(contacts.contains(contact.b, contact.a));
                // How many steps a way was cut into shows in the last bits.
                format!(
                    "{contact:.3?} {:.3?} {:.3?}",
                    contacts.manifold(contact.a, contact.b),
                    contacts.time_of_impact(contact.a, contact.b)
                )
            })
            .collect();
        let mut entities: Vec<Entity> = contacts.iter().flat_map(|c| [c.a, c.b]).collect();
        entities.sort();
        entities.dedup();
        for entity in entities {
            let of: Vec<_> = contacts.of(entity).map(|c| c.b).collect();
            let expected: Vec<_> = contacts
                .iter()
                .filter_map(|c| {
                    let hears = c.hears();
                    ((c.a == entity && hears[0]) || (c.b == entity && hears[1]))
                        .then(|| c.other(entity).unwrap())
                })
                .collect();
            assert_eq!(of, expected);
        }
        for entity in &self.objects {
            if world.get::<Disabled>(*entity).is_some() {
                continue;
            }
            if let Some(colliding) = world.get::<CollidingEntities>(*entity) {
                let expected: EntityHashSet = contacts.of(*entity).map(|c| c.b).collect();
                let mut found: Vec<_> = colliding.iter().copied().collect();
                let mut expected: Vec<_> = expected.into_iter().collect();
                found.sort();
                expected.sort();
                assert_eq!(found, expected, "{entity}");
            }
            seen.push(format!(
                "{:.3?} {:.3?}",
                world.get::<Transform>(*entity),
                world.get::<Velocity>(*entity)
            ));
        }
        seen
    }
}

fn outdate_all(app: &mut App) {
    let world = app.world_mut();
    let mut transforms = world.query_filtered::<&mut Transform, Allow<Disabled>>();
    for mut transform in transforms.iter_mut(world) {
        transform.set_changed();
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    bounces: bool,
    boxes: bool,
    flush: bool,
    skips: bool,
}

fn check(kind: Kind, seeds: std::ops::Range<u64>) {
    let mut seen_contacts = 0;
    for seed in seeds {
        let mut one = History::new(BroadPhaseMethod::default(), seed, kind.bounces);
        let mut other = History::new(BroadPhaseMethod::Exhaustive, seed, kind.bounces);
        *one.app.world_mut().resource_mut::<Tricks>() = Tricks {
            rng: Some(Rng::with_seed(seed + 77)),
            boxes: kind.boxes,
            flush: kind.flush,
        };
        let mut rng = Rng::with_seed(seed + 999);
        for number in 0..TICKS {
            one.edit_some();
            other.edit_some();
            outdate_all(&mut other.app);
            let mut skipped: Vec<CollisionSystems> = Vec::new();
            if kind.skips && rng.bool() {
                for set in STAGES {
                    if rng.u8(0..3) == 0 {
                        skipped.push(set);
                    }
                }
            }
            one.log.push(format!("tick {number} without {skipped:?}"));
            for app in [&mut one.app, &mut other.app] {
                skip(app, &skipped);
                app.update();
            }
            if skipped.is_empty() {
                let (found, expected) = (one.seen(), other.seen());
                if found != expected {
                    let place = found
                        .iter()
                        .zip(&expected)
                        .position(|(a, b)| a != b)
                        .unwrap_or(found.len().min(expected.len()));
                    panic!(
                        "{kind:?} seed {seed}, tick {number}:\n{:#?}\n{:#?}\n{:#?}",
                        found.get(place),
                        expected.get(place),
                        &one.log[one.log.len().saturating_sub(14)..]
                    );
                }
                if !kind.skips {
                    let last =
                        |history: &History| history.app.world().resource::<Told>().last.clone();
                    assert_eq!(
                        last(&one),
                        last(&other),
                        "{kind:?} seed {seed}, tick {number}"
                    );
                }
                seen_contacts += one.app.world().resource::<Contacts>().len();
            }
            if !skipped.contains(&CollisionSystems::Report) {
                assert_eq!(
                    told(&one.app),
                    contacts(&one.app),
                    "{kind:?} seed {seed}, tick {number}"
                );
            }
        }
    }
    assert!(seen_contacts > 1000, "{seen_contacts}");
}

const PLAIN: Kind = Kind {
    bounces: false,
    boxes: false,
    flush: false,
    skips: false,
};

const SEEDS: u64 = 150;

#[test]
fn all_is_as_if_looked_at_anew() {
    check(PLAIN, 0..SEEDS);
}

#[test]
fn all_is_as_if_looked_at_anew_with_bounces() {
    check(
        Kind {
            bounces: true,
            ..PLAIN
        },
        0..SEEDS,
    );
}

#[test]
fn all_is_as_if_looked_at_anew_where_boxes_are_enlarged() {
    check(
        Kind {
            boxes: true,
            ..PLAIN
        },
        0..SEEDS,
    );
}

#[test]
fn all_is_as_if_looked_at_anew_where_sets_are_skipped() {
    check(
        Kind {
            skips: true,
            ..PLAIN
        },
        0..SEEDS,
    );
}

#[test]
fn all_is_as_if_looked_at_anew_with_bounces_and_updates_between_sets() {
    check(
        Kind {
            flush: true,
            bounces: true,
            ..PLAIN
        },
        0..SEEDS,
    );
}

/// A ball comes between two others, and meets both at the same moment. Which of them it answers to
/// first is decided by who they are, and not by the handles that they got.
#[test]
fn handles_do_not_decide_who_bounces_first() {
    let outcome = |reversed: bool| {
        let mut app = make_app(BroadPhaseMethod::default());
        // They leave their handles, in either order, to those that come later.
        let mut early: Vec<_> = (0..3)
            .map(|x| block(&mut app, 500.0 + 10.0 * x as f32))
            .collect();
        app.update();
        if reversed {
            early.reverse();
        }
        for entity in &early {
            app.world_mut()
                .entity_mut(*entity)
                .remove::<CollisionShape>();
        }
        tick(&mut app, 4);
        let elastic = Bounce::Reflect { restitution: 1.0 };
        let bodies =
            [(-3.0, 0.0, 2.0), (0.0, 0.75, 0.0), (0.0, -0.75, 0.0)].map(|(x, y, speed)| {
                let way = Velocity(Vec3::X * speed * 64.0);
                let body = (CollisionShape::sphere(0.5), elastic, way, Swept::default());
                app.world_mut()
                    .spawn((body, Transform::from_xyz(x, y, 0.0)))
                    .id()
            });
        tick(&mut app, 3);
        bodies.map(|body| {
            (
                get::<Velocity>(&app, body).0,
                get::<Transform>(&app, body).translation,
            )
        })
    };
    assert_eq!(outcome(false), outcome(true));
}
