//! What comes of a tick does not depend on what entities are called, where they have an order of their own.

use bevy::prelude::*;
use bevy_octree::{broad_phase::BroadPhaseMethod, prelude::*};

use crate::common::{self, fnv::Fnv};

/// The number of no entity.
const NOTHING: u64 = u64::MAX - 1;

/// Where somebody is, how turned, and how fast.
type Place = (u64, [u32; 3], [u32; 4], [u32; 3]);

/// On what somebody stands, and what was met when.
type Walker = (u64, u64, Vec<(u64, u32)>);

/// What somebody sees of a scene, by the numbers of its entities.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    pub contacts: Vec<(u64, u64, u32)>,
    pub started: Vec<(u64, u64, u32)>,
    pub ended: Vec<(u64, u64)>,
    pub events: Vec<(u64, u64)>,
    bodies: Vec<(u64, u64)>,
    places: Vec<Place>,
    /// Who walks, on what, and against what.
    walkers: Vec<Walker>,
    nearest: Vec<u64>,
}

impl Seen {
    /// How many of those who walk stand on something.
    pub fn walking(&self) -> usize {
        let stands = |(_, ground, _): &&Walker| *ground != NOTHING;
        self.walkers.iter().filter(stands).count()
    }

    /// All of it, number by number.
    pub fn add_to(&self, hash: &mut Fnv) {
        let Self {
            contacts,
            started,
            ended,
            events,
            bodies,
            places,
            walkers,
            nearest,
        } = self;
        for list in [contacts, started] {
            hash.add(list.len() as u64);
            for (a, b, time) in list {
                hash.add_all([*a, *b, u64::from(*time)]);
            }
        }
        for list in [ended, events, bodies] {
            hash.add(list.len() as u64);
            list.iter().for_each(|(a, b)| hash.add_all([*a, *b]));
        }
        for (number, at, turn, velocity) in places {
            hash.add(*number);
            let words = at.iter().chain(turn).chain(velocity);
            hash.add_all(words.copied().map(u64::from));
        }
        for (number, ground, hits) in walkers {
            hash.add_all([*number, *ground, hits.len() as u64]);
            for (other, time) in hits {
                hash.add_all([*other, u64::from(*time)]);
            }
        }
        hash.add_all(nearest.iter().copied());
    }
}

#[derive(Resource, Default)]
pub struct Events(Vec<[Entity; 2]>);

fn bits(vector: Vec3) -> [u32; 3] {
    vector.to_array().map(f32::to_bits)
}

pub fn seen(app: &mut App) -> Seen {
    let world = app.world_mut();
    let mut numbers = world.query::<(Entity, &CollisionOrder)>();
    let of: bevy::platform::collections::HashMap<_, _> = numbers
        .iter(world)
        .map(|(entity, order)| (entity, order.0))
        .collect();
    let number = |entity: Entity| of.get(&entity).copied().unwrap_or(u64::MAX);
    type Placed<'a> = (
        &'a CollisionOrder,
        &'a Transform,
        Option<&'a Velocity>,
        Option<&'a KinematicCharacter>,
    );
    let mut places = world.query::<Placed>();
    let mut places: Vec<_> = places
        .iter(world)
        .map(|(order, at, velocity, walking)| {
            let velocity = velocity.map(|velocity| velocity.0);
            let velocity = velocity.or(walking.map(|walking| walking.velocity));
            let turn = at.rotation.to_array().map(f32::to_bits);
            let velocity = velocity.unwrap_or_default();
            (order.0, bits(at.translation), turn, bits(velocity))
        })
        .collect();
    places.sort_unstable();
    let mut walkers = world.query::<(&CollisionOrder, &KinematicCharacter, &CharacterHits)>();
    let mut walkers: Vec<_> = walkers
        .iter(world)
        .map(|(order, walking, hits)| {
            let ground = walking
                .ground
                .map_or(NOTHING, |ground| number(ground.entity));
            let hits = hits
                .iter()
                .map(|hit| (number(hit.entity), hit.time.to_bits()));
            (order.0, ground, hits.collect())
        })
        .collect();
    walkers.sort_unstable();
    let started = world
        .resource_mut::<Messages<CollisionStarted>>()
        .drain()
        .collect::<Vec<_>>();
    let ended = world
        .resource_mut::<Messages<CollisionEnded>>()
        .drain()
        .collect::<Vec<_>>();
    let events = std::mem::take(&mut world.resource_mut::<Events>().0);
    let mut state = bevy::ecs::system::SystemState::<SpatialQuery>::new(world);
    let spatial = state.get(world).unwrap();
    let mut nearest = Vec::new();
    spatial.k_nearest(
        Vec3::ZERO,
        30,
        50.0,
        &SpatialQueryFilter::DEFAULT,
        &mut nearest,
    );
    let nearest = nearest.iter().map(|hit| number(hit.entity)).collect();
    let contacts = world.resource::<Contacts>();
    Seen {
        contacts: contacts
            .iter()
            .map(|contact| (number(contact.a), number(contact.b), contact.time.to_bits()))
            .collect(),
        started: started
            .iter()
            .map(|start| (number(start.a), number(start.b), start.time.to_bits()))
            .collect(),
        ended: ended
            .iter()
            .map(|end| (number(end.a), number(end.b)))
            .collect(),
        events: events
            .iter()
            .map(|[a, b]| (number(*a), number(*b)))
            .collect(),
        bodies: contacts
            .body_pairs()
            .map(|pair| (number(pair.a), number(pair.b)))
            .collect(),
        places,
        walkers,
        nearest,
    }
}

/// An app that may go back in time, which the log of others takes amiss.
pub fn plain_app(method: BroadPhaseMethod) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / 64.0),
        });
    app.world_mut().resource_mut::<BroadPhaseSettings>().method = method;
    app
}

/// Turns as it goes.
#[derive(Component)]
struct Turning;

/// By square roots alone, which all machines agree on.
fn turn(mut turning: Query<&mut Transform, With<Turning>>) {
    for mut at in &mut turning {
        let by = Quat::from_xyzw(0.04, 0.06, 0.02, 1.0).normalize();
        at.rotation = (at.rotation * by).normalize();
    }
}

/// Whoever walks goes around the middle, and falls.
fn walk(mut walking: Query<(&Transform, &mut KinematicCharacter)>) {
    for (at, mut walking) in &mut walking {
        let Vec3 { x, z, .. } = at.translation;
        let around = Vec3::new(-z - 0.2 * x, 0.0, x - 0.2 * z).normalize_or_zero();
        walking.velocity = around * 3.0 + Vec3::Y * (walking.velocity.y - 0.15);
    }
}

/// All that there is by the dozen in a room: swept, with parts, on foot, in layers, turning; many meet in one tick.
/// `order` says in which order they are spawned.
pub fn room(order: &[u64], method: BroadPhaseMethod) -> App {
    let mut app = plain_app(method);
    app.init_resource::<Events>();
    let moves = (turn, walk).chain().before(CollisionSystems::First);
    app.add_systems(Update, moves);
    app.add_observer(|event: On<CollisionStarted>, mut events: ResMut<Events>| {
        events.0.push([event.a, event.b]);
    });
    app.add_observer(|event: On<CollisionEnded>, mut events: ResMut<Events>| {
        events.0.push([event.a, event.b]);
    });
    for number in order {
        spawn(&mut app, *number);
    }
    app
}

/// So many there are.
pub const COUNT: u64 = 150;

/// A turn whose quaternion is exact.
const LEANING: Quat = Quat::from_xyzw(0.5, 0.5, 0.5, 0.5);

pub fn spawn(app: &mut App, number: u64) -> Entity {
    let order = CollisionOrder(number);
    if number < 6 {
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][number as usize / 2]
            * if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        let half_size = Vec3::splat(5.0) * (Vec3::ONE - axis.abs()) + axis.abs() * 0.5;
        let wall = (
            CollisionShape::from_half_size(half_size),
            StaticShape,
            order,
        );
        return app
            .world_mut()
            .spawn((wall, Transform::from_translation(axis * 5.0)))
            .id();
    }
    // On a lattice, so that distances and times are alike.
    let mut random = fastrand::Rng::with_seed(number);
    let mut vector = |size: i32| Vec3::from_array([0; 3].map(|_| random.i32(-size..=size) as f32));
    let (at, velocity) = (vector(3), vector(4) * 16.0);
    let moving = (Velocity(velocity), Transform::from_translation(at), order);
    let mut entity = app.world_mut().spawn(moving);
    match number % 8 {
        0 => entity.insert((
            CollisionShape::sphere(0.3),
            Bounce::Reflect { restitution: 1.0 },
            Swept::default(),
        )),
        1 => entity.insert((CollisionShape::cuboid(0.6, 0.6, 0.6), Bounce::Reverse)),
        2 => entity.insert((
            CollisionBody::default(),
            Bounce::Reflect { restitution: 0.5 },
            CollisionEventsEnabled,
            children![
                (
                    CollisionShape::sphere(0.3),
                    Transform::from_xyz(0.3, 0.0, 0.0),
                    CollisionOrder(1000 + number)
                ),
                (
                    CollisionShape::sphere(0.3),
                    Transform::from_xyz(-0.3, 0.0, 0.0),
                    CollisionOrder(2000 + number)
                ),
            ],
        )),
        3 => entity.insert((
            CollisionShape::cuboid(0.6, 0.6, 0.6),
            Bounce::Reflect { restitution: 1.0 },
            CollisionEventsEnabled,
        )),
        4 => entity.insert((
            CollisionShape::capsule(0.2, 0.4),
            Bounce::Reflect { restitution: 0.8 },
            Swept::default(),
            CollisionEventsEnabled,
        )),
        5 => entity.insert((CollisionShape::sphere(0.3), Sensor)),
        6 => entity.remove::<Velocity>().insert((
            KinematicCharacter::default(),
            CharacterHits::default(),
            CollisionShape::capsule(0.25, 0.6),
        )),
        _ => entity.insert((
            CollisionBody::default(),
            Bounce::Reflect { restitution: 0.9 },
            Swept::default(),
            Turning,
            CollisionEventsEnabled,
            children![
                (
                    CollisionShape::cuboid(0.3, 0.6, 0.2),
                    Transform::from_xyz(0.2, 0.1, 0.0).with_rotation(LEANING),
                    // They pass through each other.
                    CollisionLayers::from_bits(2, !2),
                    CollisionOrder(1000 + number)
                ),
                (
                    CollisionShape::sphere(0.25),
                    Transform::from_xyz(-0.3, 0.0, 0.1),
                    CollisionOrder(2000 + number)
                ),
            ],
        )),
    };
    entity.id()
}

/// As many numbers, shuffled.
pub fn shuffled(seed: u64) -> Vec<u64> {
    shuffled_of(COUNT, seed)
}

/// So many numbers, shuffled.
pub fn shuffled_of(count: u64, seed: u64) -> Vec<u64> {
    let mut numbers: Vec<_> = (0..count).collect();
    fastrand::Rng::with_seed(seed).shuffle(&mut numbers);
    numbers
}

#[test]
fn the_order_of_spawning_decides_nothing() {
    let methods = [
        BroadPhaseMethod::default(),
        BroadPhaseMethod::Exhaustive,
        BroadPhaseMethod::ObjectOctree(default()),
    ];
    let mut rooms: Vec<_> = methods
        .into_iter()
        .zip([None, Some(1), Some(2)])
        .map(|(method, seed)| {
            let order = seed.map_or_else(|| (0..COUNT).collect(), shuffled);
            room(&order, method)
        })
        .collect();
    let mut told = 0;
    for tick in 0..300 {
        let mut all = rooms.iter_mut().map(|app| {
            app.update();
            seen(app)
        });
        let first = all.next().unwrap();
        told += first.started.len() + first.events.len() + first.bodies.len();
        assert!(
            first.started.is_sorted_by_key(|(a, b, time)| (
                f32::from_bits(*time),
                *a.min(b),
                *a.max(b)
            )
                .0)
        );
        for other in all {
            assert_eq!(first, other, "in tick {tick}");
        }
        // Some go, and come back, in another order in each.
        if tick % 10 == 9 {
            for (number, app) in rooms.iter_mut().enumerate() {
                respawn(app, COUNT, tick, number % 2 == 0);
            }
        }
    }
    assert!(told > 1000, "{told} are told");
}

/// Despawns a few of so many, and spawns them where they began, in one order or the other.
pub fn respawn(app: &mut App, count: u64, tick: u64, reversed: bool) {
    let mut numbers: Vec<_> = (0..7)
        .map(|i| 6 + (tick * 13 + i * 17) % (count - 6))
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    if reversed {
        numbers.reverse();
    }
    let world = app.world_mut();
    let mut all = world.query::<(Entity, &CollisionOrder)>();
    let gone: Vec<_> = all
        .iter(world)
        .filter(|(_, order)| numbers.contains(&order.0))
        .map(|(entity, _)| entity)
        .collect();
    gone.into_iter()
        .for_each(|entity| _ = app.world_mut().despawn(entity));
    numbers
        .into_iter()
        .for_each(|number| _ = spawn(app, number));
}

#[test]
fn another_number_is_another_contact() {
    let mut app = common::app(BroadPhaseMethod::default());
    let [a, b] = [(5, 0.0), (6, 0.5)].map(|(number, x)| {
        app.world_mut()
            .spawn((
                CollisionShape::default(),
                CollisionOrder(number),
                Transform::from_xyz(x, 0.0, 0.0),
            ))
            .id()
    });
    app.update();
    let pair = |app: &App| {
        app.world()
            .resource::<Contacts>()
            .iter()
            .map(|contact| [contact.a, contact.b])
            .collect::<Vec<_>>()
    };
    assert_eq!(pair(&app), [[a, b]]);
    app.world_mut().entity_mut(a).insert(CollisionOrder(7));
    app.update();
    assert_eq!(pair(&app), [[b, a]]);
    // Either way they are found.
    let contacts = app.world().resource::<Contacts>();
    assert!(contacts.contains(a, b) && contacts.contains(b, a));
    assert_eq!(contacts.between(a, b).unwrap().b, b);
    // The same number again changes nothing.
    let id = |app: &App| {
        app.world()
            .get::<bevy_octree::components::BroadPhaseProxy>(a)
            .unwrap()
            .id()
    };
    let before = id(&app);
    app.world_mut().entity_mut(a).insert(CollisionOrder(7));
    app.update();
    assert_eq!(id(&app), before);
    // Without one, it stands where its entity does.
    app.world_mut().entity_mut(a).remove::<CollisionOrder>();
    app.update();
    assert_eq!(pair(&app).len(), 1);
}

/// A body that has lost its number stands where its entity does, at once and for good.
#[test]
fn a_number_that_a_body_has_lost_is_forgotten_at_once() {
    let mut app = plain_app(BroadPhaseMethod::default());
    let body = (
        CollisionBody::default(),
        CollisionOrder(5),
        Transform::default(),
    );
    let body = app
        .world_mut()
        .spawn((body, children![CollisionShape::default()]))
        .id();
    app.world_mut().spawn(CollisionShape::default());
    app.update();
    app.world_mut().entity_mut(body).remove::<CollisionOrder>();
    app.update();
    let told = |app: &mut App| {
        let world = app.world_mut();
        let started = world
            .resource_mut::<Messages<BodyCollisionStarted>>()
            .drain()
            .count();
        (
            started,
            world
                .resource_mut::<Messages<BodyCollisionEnded>>()
                .drain()
                .count(),
        )
    };
    told(&mut app);
    for tick in 0..1100 {
        app.update();
        assert_eq!(told(&mut app), (0, 0), "in tick {tick}");
    }
}
