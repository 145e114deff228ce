//! Random histories of everything that may happen to bodies and their parts, tick by tick beside
//! what follows from the hierarchy alone, and beside an app that looks at all anew in each tick.

use crate::common::*;

use bevy::{ecs::entity_disabling::Disabled, prelude::*};
use bevy_octree::{
    components::WorldAabb,
    motion::{MotionSettings, Step},
    prelude::*,
};
use fastrand::Rng;

const BODIES: usize = 6;
const PARTS: usize = 22;
const TICKS: usize = 40;
const REACH: f32 = 2.0;

/// Two bodies, and whether it is sensors that see it.
type BodyContact = (EntityPair, bool);

/// What bodies were told, as strings, and which are in contact by that.
#[derive(Resource, Default)]
struct Told {
    open: Vec<BodyContact>,
    last: Vec<String>,
}

fn follow(
    mut told: ResMut<Told>,
    mut started: MessageReader<BodyCollisionStarted>,
    mut ended: MessageReader<BodyCollisionEnded>,
    mut parts: (
        MessageReader<CollisionStarted>,
        MessageReader<CollisionEnded>,
    ),
) {
    told.last.clear();
    for message in ended.read() {
        let pair = (pair(message.a, message.b), message.is_sensor);
        let place = told.open.iter().position(|other| *other == pair);
        told.open.swap_remove(place.expect("what ends has started"));
        told.last.push(format!("{message:?}"));
    }
    for message in started.read() {
        let pair = (pair(message.a, message.b), message.is_sensor);
        assert!(!told.open.contains(&pair), "{pair:?} started twice");
        told.open.push(pair);
        told.last.push(format!("{message:?}"));
    }
    let ended = parts.1.read().map(|message| format!("{message:?}"));
    told.last.extend(ended);
    let started = parts.0.read().map(|message| format!("{message:?}"));
    told.last.extend(started);
}

struct History {
    app: App,
    rng: Rng,
    bodies: Vec<Entity>,
    parts: Vec<Entity>,
    moves: bool,
    log: Vec<String>,
}

impl History {
    fn new(method: BroadPhaseMethod, seed: u64, moves: bool) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
            .insert_resource(MotionSettings {
                step: Step::Seconds(1.0 / 64.0),
            })
            .init_resource::<Told>()
            .add_systems(Update, follow.in_set(CollisionSystems::Last));
        app.world_mut().resource_mut::<BroadPhaseSettings>().method = method;
        // It spawns what it keeps of its systems; so does the first body.
        update_spatial_index(app.world_mut());
        let mut history = Self {
            app,
            rng: Rng::with_seed(seed),
            bodies: Vec::new(),
            parts: Vec::new(),
            moves,
            log: Vec::new(),
        };
        for _ in 0..BODIES {
            let body = history.body();
            history.bodies.push(body);
        }
        for _ in 0..PARTS {
            let part = history.part();
            history.parts.push(part);
        }
        history
    }

    fn vector(&mut self, reach: f32) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| (self.rng.f32() * 2.0 - 1.0) * reach))
    }

    fn place(&mut self, reach: f32) -> Transform {
        let place = Transform::from_translation(self.vector(reach));
        let turns = self.rng.bool();
        let turn = Quat::from_scaled_axis(self.vector(2.0));
        if turns {
            place.with_rotation(turn)
        } else {
            place
        }
    }

    fn body(&mut self) -> Entity {
        let (place, velocity) = (self.place(REACH), self.vector(30.0));
        let (swept, bounces) = (self.rng.u8(0..3), self.rng.u8(0..3));
        let mut body = self
            .app
            .world_mut()
            .spawn((CollisionBody::default(), place));
        if self.moves {
            body.insert(Velocity(velocity));
            match swept {
                0 => _ = body.insert(Swept::default()),
                1 => _ = body.insert(Swept::stopping()),
                _ => {}
            }
            match bounces {
                0 => _ = body.insert(Bounce::Reverse),
                1 => _ = body.insert(Bounce::Reflect { restitution: 0.8 }),
                _ => {}
            }
        }
        body.id()
    }

    fn part(&mut self) -> Entity {
        let shape = match self.rng.u8(0..3) {
            0 => CollisionShape::default(),
            1 => CollisionShape::sphere(0.2 + 0.4 * self.rng.f32()),
            _ => CollisionShape::from_half_size(self.vector(0.6).abs() + 0.1),
        };
        let place = self.place(1.0);
        let on = self.bodies[self.rng.usize(0..BODIES)];
        let hangs = self.rng.u8(0..5) > 0;
        let mut part = self.app.world_mut().spawn((shape, place));
        if hangs {
            part.insert(ChildOf(on));
        }
        part.id()
    }

    fn edit(&mut self) {
        let body = self.rng.usize(0..BODIES);
        let part = self.rng.usize(0..PARTS);
        let other = self.parts[self.rng.usize(0..PARTS)];
        let (kind, to, place) = (self.rng.u8(0..28), self.vector(1.0), self.place(REACH));
        let (own, own_part) = (self.bodies[body], self.parts[part]);
        self.log
            .push(format!("{kind} {own} {own_part} {other} {to}"));
        let world = self.app.world_mut();
        match kind {
            0..3 => _ = world.entity_mut(own_part).insert(ChildOf(own)),
            3 => _ = world.entity_mut(own_part).remove::<ChildOf>(),
            4 if own_part != other => {
                let would_be_circle = std::iter::successors(Some(other), |entity| {
                    world.get::<ChildOf>(*entity).map(ChildOf::parent)
                })
                .any(|entity| entity == own_part);
                if !would_be_circle {
                    world.entity_mut(own_part).insert(ChildOf(other));
                }
            }
            5 => {
                // A body on a body.
                let on = self.bodies[(body + 1) % BODIES];
                let is_circle = std::iter::successors(Some(on), |entity| {
                    world.get::<ChildOf>(*entity).map(ChildOf::parent)
                })
                .any(|entity| entity == own);
                if !is_circle {
                    world.entity_mut(own).insert(ChildOf(on));
                }
            }
            6 | 7 => _ = world.entity_mut(own).remove::<ChildOf>(),
            8 => _ = world.entity_mut(own).remove::<CollisionBody>(),
            9 => _ = world.entity_mut(own).insert(CollisionBody::default()),
            10 => {
                let asks = CollisionBody {
                    inner_contacts: true,
                };
                world.entity_mut(own).insert(asks);
            }
            11 => _ = world.entity_mut(own_part).insert(Disabled),
            12 | 13 => _ = world.entity_mut(own_part).remove::<Disabled>(),
            14 => _ = world.entity_mut(own_part).remove::<CollisionShape>(),
            15 | 16 => _ = world.entity_mut(own_part).insert(CollisionShape::default()),
            17 => _ = world.entity_mut(own).insert(CollisionShape::sphere(0.4)),
            18 => _ = world.entity_mut(own).remove::<CollisionShape>(),
            19 => *world.get_mut::<Transform>(own).unwrap() = place,
            20 => world.get_mut::<Transform>(own_part).unwrap().translation = to,
            21 => _ = world.entity_mut(own_part).insert(CollisionBody::default()),
            22 => _ = world.entity_mut(own_part).remove::<CollisionBody>(),
            23 if self.moves => _ = world.entity_mut(own).insert(Swept::default()),
            24 if self.moves => _ = world.entity_mut(own).remove::<Swept>(),
            26 => _ = world.entity_mut(own_part).insert(Sensor),
            27 => _ = world.entity_mut(own_part).remove::<Sensor>(),
            _ => {
                let target = if kind == 25 && to.x > 0.5 {
                    own
                } else {
                    own_part
                };
                world.despawn(target);
                for place in 0..BODIES {
                    if self.app.world().get_entity(self.bodies[place]).is_err() {
                        self.bodies[place] = self.body();
                    }
                }
                for place in 0..PARTS {
                    if self.app.world().get_entity(self.parts[place]).is_err() {
                        self.parts[place] = self.part();
                    }
                }
            }
        }
    }

    fn edit_some(&mut self) {
        for _ in 0..self.rng.u8(0..5) {
            self.edit();
        }
    }

    fn all(&self) -> impl Iterator<Item = Entity> {
        self.bodies.iter().chain(&self.parts).copied()
    }

    /// Checks all that follows from the hierarchy.
    fn check(&mut self, what: &str) {
        let what = &format!(
            "{what}: {:#?}",
            &self.log[self.log.len().saturating_sub(12)..]
        );
        let app = &mut self.app;
        let world = app.world();
        let body_of = |entity: Entity| {
            std::iter::successors(Some(entity), |entity| {
                world.get::<ChildOf>(*entity).map(ChildOf::parent)
            })
            .find(|entity| world.get::<CollisionBody>(*entity).is_some())
        };
        let shaped = |entity: &Entity| world.get::<CollisionShape>(*entity).is_some();
        for entity in self.bodies.iter().chain(&self.parts) {
            let expected = body_of(*entity).filter(|_| shaped(entity));
            let found = world.get::<PartOf>(*entity).map(PartOf::body);
            assert_eq!(found, expected, "{entity} {what}");
            let parts = world.get::<BodyParts>(*entity);
            let mut parts: Vec<_> = parts
                .into_iter()
                .flat_map(BodyParts::entities)
                .copied()
                .collect();
            parts.sort();
            let own = |part: &Entity| shaped(part) && body_of(*part) == Some(*entity);
            let mut expected: Vec<_> = self
                .bodies
                .iter()
                .chain(&self.parts)
                .copied()
                .filter(own)
                .collect();
            expected.sort();
            assert_eq!(parts, expected, "{entity} {what}");
        }
        // Contacts name bodies, and those of bodies are what these come to.
        let all = world.resource::<Contacts>();
        let mut expected = Vec::new();
        for contact in all.iter() {
            let [a, b] = [contact.a, contact.b].map(body_of);
            let bodies = [a.unwrap_or(contact.a), b.unwrap_or(contact.b)];
            assert_eq!(contact.bodies, bodies, "{what}");
            if bodies[0] == bodies[1] {
                let asks = world.get::<CollisionBody>(bodies[0]).unwrap();
                assert!(asks.inner_contacts, "{contact:?} {what}");
            } else if a.is_some() || b.is_some() {
                let is_sensor = [contact.a, contact.b]
                    .into_iter()
                    .any(|part| world.get::<Sensor>(part).is_some());
                expected.push((pair(bodies[0], bodies[1]), is_sensor));
            }
        }
        expected.sort();
        let total = expected.len();
        expected.dedup();
        let found: Vec<_> = all.body_pairs().collect();
        assert_eq!(
            found.iter().map(|c| c.contacts as usize).sum::<usize>(),
            total
        );
        for pair in &found {
            let same = found.iter().filter(|c| (c.a, c.b) == (pair.a, pair.b));
            let expected = same.map(|c| c.contacts as usize).sum::<usize>();
            let between = all.between_bodies(pair.b, pair.a);
            assert_eq!(between.count(), expected, "{what}");
        }
        let mut found: Vec<_> = found
            .iter()
            .map(|c| (pair(c.a, c.b), c.is_sensor))
            .collect();
        found.sort();
        assert_eq!(found, expected, "{what}");
        let mut open = world.resource::<Told>().open.clone();
        open.sort();
        assert_eq!(open, expected, "{what}");
        if self.moves {
            return;
        }
        // Where nothing is swept, contacts are what overlaps at the end.
        let mut expected = brute_force_contacts(app);
        let world = app.world();
        let number = |entity: Entity| world.get::<PartOf>(entity).map(PartOf::body);
        let asks = |body: Entity| {
            world
                .get::<CollisionBody>(body)
                .is_some_and(|body| body.inner_contacts)
        };
        expected.retain(|[a, b]| match (number(*a), number(*b)) {
            (Some(a), Some(b)) => a != b || asks(a),
            _ => true,
        });
        assert_eq!(contacts(app), expected, "{what}");
    }
}

/// Where everything is, and how fast; and all that was told.
fn state(history: &History) -> Vec<String> {
    let world = history.app.world();
    let mut state = world.resource::<Told>().last.clone();
    state.extend(history.all().map(|entity| {
        let (place, velocity) = (
            world.get::<Transform>(entity),
            world.get::<Velocity>(entity),
        );
        format!("{entity} {place:?} {velocity:?}")
    }));
    state.extend(
        world
            .resource::<Contacts>()
            .iter()
            .map(|contact| format!("{contact:?}")),
    );
    state
}

fn outdate_all(app: &mut App) {
    let world = app.world_mut();
    let mut transforms = world.query_filtered::<&mut Transform, Allow<Disabled>>();
    for mut transform in transforms.iter_mut(world) {
        transform.set_changed();
    }
    let mut boxes = world.query::<&mut WorldAabb>();
    for mut aabb in boxes.iter_mut(world) {
        aabb.set_changed();
    }
}

fn run(seeds: std::ops::Range<u64>, moves: bool) {
    let mut seen = 0;
    for seed in seeds {
        let mut one = History::new(BroadPhaseMethod::default(), seed, moves);
        let mut other = History::new(BroadPhaseMethod::Exhaustive, seed, moves);
        for number in 0..TICKS {
            let what = format!("seed {seed}, tick {number}");
            one.edit_some();
            other.edit_some();
            outdate_all(&mut other.app);
            if seed % 3 == 0 {
                update_spatial_index(one.app.world_mut());
            }
            one.app.update();
            other.app.update();
            one.check(&what);
            let (found, expected) = (state(&one), state(&other));
            for (found, expected) in found.iter().zip(&expected) {
                assert_eq!(
                    found,
                    expected,
                    "{what}: {:#?}",
                    &one.log[one.log.len().saturating_sub(12)..]
                );
            }
            assert_eq!(found.len(), expected.len(), "{what}");
            seen += one.app.world().resource::<Contacts>().body_pairs().len();
        }
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn bodies_at_rest_are_what_the_hierarchy_says() {
    run(0..60, false);
}

#[test]
fn bodies_that_move_and_bounce_are_what_the_hierarchy_says() {
    run(100..180, true);
}
