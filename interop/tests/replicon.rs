//! Replication by `bevy_replicon`: a client that is sent shapes, layers, velocities and places sees
//! the contacts that the server sees.

use bevy::{prelude::*, state::app::StatesPlugin};
use bevy_octree::{
    motion::Step,
    plugins::{BouncePlugin, MotionPlugin, SweptPlugin},
    prelude::*,
    shape_data::CoreDescription,
};
use bevy_replicon::{
    prelude::*, shared::backend::channels::ServerChannel, test_app::ServerTestAppExt,
};
use fastrand::Rng;

/// What an app is to do with what it has.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    /// It says what moves where.
    Server,
    /// It tells what touches what, and moves nothing.
    Mirror,
    /// It goes on from what it was sent, as the server does meanwhile.
    Predicting,
}

fn app(role: Role) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        StatesPlugin,
        RepliconPlugins.set(ServerPlugin::new(PostUpdate)),
    ));
    let ticks = OctreePlugins::new(Update).build();
    if role == Role::Mirror {
        let looks_on = ticks.disable::<MotionPlugin>().disable::<BouncePlugin>();
        app.add_plugins(looks_on.disable::<SweptPlugin>());
    } else {
        app.add_plugins(ticks);
    }
    app.insert_resource(MotionSettings {
        step: Step::Seconds(1.0 / 64.0),
    })
    .insert_resource(CollisionEventSettings {
        geometry: EventScope::All,
        ..default()
    })
    .replicate::<CollisionOrder>()
    .replicate::<ShapeDescription>()
    .replicate::<Transform>()
    .replicate::<ChildOf>()
    .replicate::<Velocity>()
    .replicate::<CollisionLayers>()
    .replicate::<CollisionBody>()
    .replicate::<StaticShape>()
    .replicate::<Sensor>()
    .replicate::<Detector>()
    .replicate::<Swept>()
    .replicate::<Bounce>();
    app.finish();
    app.cleanup();
    app
}

fn description(luck: &mut Rng) -> ShapeDescription {
    let size = luck.f32().mul_add(0.5, 0.3);
    match luck.u32(..8) {
        0 => ShapeDescription::Capsule {
            radius: size * 0.5,
            length: size,
        },
        1 => ShapeDescription::Cylinder {
            radius: size * 0.5,
            height: size,
        },
        2 => ShapeDescription::Cone {
            radius: size * 0.5,
            height: size,
        },
        3 => ShapeDescription::ConvexHull {
            points: (0..12).map(|_| within(luck, size)).collect(),
        },
        4 => ShapeDescription::Rounded {
            core: CoreDescription::Cuboid {
                half_size: Vec3::splat(size * 0.3),
            },
            radius: size * 0.2,
        },
        5 => ShapeDescription::Cuboid {
            half_size: Vec3::new(size, size * 0.7, size * 0.5),
        },
        _ => ShapeDescription::Sphere { radius: size * 0.6 },
    }
}

fn within(luck: &mut Rng, half: f32) -> Vec3 {
    let mut share = || luck.f32().mul_add(2.0, -1.0);
    Vec3::new(share(), share(), share()) * half
}

/// The game that the server plays.
struct Game {
    server: App,
    luck: Rng,
    next: u64,
    movers: Vec<Entity>,
    /// Is something to be looked at all along its way?
    swept: bool,
}

impl Game {
    fn new(seed: u64, swept: bool) -> Self {
        let mut game = Self {
            server: app(Role::Server),
            luck: Rng::with_seed(seed),
            next: 0,
            movers: Vec::new(),
            swept,
        };
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for side in [-5.5, 5.5] {
                let half_size = (Vec3::splat(12.0) * (Vec3::ONE - axis) + axis) * 0.5;
                let place = Transform::from_translation(axis * side);
                game.spawn((ShapeDescription::Cuboid { half_size }, StaticShape, place));
            }
        }
        let corners = [(-4.0, -4.0), (-4.0, 4.0), (4.0, 4.0), (4.0, -4.0)];
        let ground = ShapeDescription::Mesh {
            vertices: corners.map(|(x, z)| Vec3::new(x, x * 0.2, z)).to_vec(),
            polygons: vec![vec![0, 1, 2], vec![0, 2, 3]],
            surface_only: false,
        };
        game.spawn((ground, StaticShape, Transform::from_xyz(0.0, -3.0, 0.0)));
        let zone = ShapeDescription::Sphere { radius: 1.5 };
        game.spawn((zone.clone(), Sensor, Transform::from_xyz(2.0, 2.0, 0.0)));
        game.spawn((zone, Detector, Transform::from_xyz(-2.0, 2.0, 0.0)));
        for _ in 0..40 {
            game.spawn_mover();
        }
        for _ in 0..4 {
            game.spawn_ship();
        }
        game
    }

    fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.next += 1;
        let all = (Replicated, CollisionOrder(self.next), bundle);
        self.server.world_mut().spawn(all).id()
    }

    fn spawn_mover(&mut self) {
        let shape = description(&mut self.luck);
        let place = Transform::from_translation(within(&mut self.luck, 4.0));
        let velocity = Velocity(within(&mut self.luck, 6.0));
        let bounce = Bounce::Reflect { restitution: 1.0 };
        let mover = self.spawn((shape, velocity, bounce, place));
        if self.swept && self.luck.u32(..3) == 0 {
            let fast = (Swept::default(), Velocity(velocity.0 * 20.0));
            self.server.world_mut().entity_mut(mover).insert(fast);
        }
        self.movers.push(mover);
    }

    fn spawn_ship(&mut self) {
        let place = Transform::from_translation(within(&mut self.luck, 3.0));
        let velocity = Velocity(within(&mut self.luck, 6.0));
        let bounce = Bounce::Reflect { restitution: 1.0 };
        let ship = self.spawn((CollisionBody::default(), velocity, bounce, place));
        for z in [-0.5_f32, 0.0, 0.5] {
            let half_size = Vec3::new(0.5 - z.abs() * 0.5, 0.1, 0.2);
            let part = ShapeDescription::Cuboid { half_size };
            self.spawn((part, Transform::from_xyz(0.0, 0.0, z), ChildOf(ship)));
        }
    }

    /// One tick, before which something may happen to somebody.
    fn tick(&mut self) {
        let Some(&one) = self.luck.choice(&self.movers) else {
            return;
        };
        match self.luck.u32(..40) {
            0 => {
                self.server.world_mut().despawn(one);
                self.movers.retain(|mover| *mover != one);
            }
            1 => self.spawn_mover(),
            2 => {
                let shape = description(&mut self.luck);
                self.server.world_mut().entity_mut(one).insert(shape);
            }
            3 => {
                let layers = [self.luck.u32(1..4), self.luck.u32(1..4)];
                let layers = CollisionLayers::from_bits(layers[0], layers[1]);
                self.server.world_mut().entity_mut(one).insert(layers);
            }
            4 => {
                let mut one = self.server.world_mut().entity_mut(one);
                one.remove::<CollisionLayers>();
            }
            _ => {}
        }
        self.server.update();
    }
}

/// All contacts in their order, with the numbers of the two, and how they touch.
fn contacts(app: &mut App) -> Vec<([u64; 2], [u32; 4])> {
    let numbers = app.world_mut().query::<&CollisionOrder>();
    let world = app.world();
    let number = |entity| {
        let number = numbers.get_manual(world, entity);
        number.map_or(0, |number| number.0)
    };
    let contacts = world.resource::<Contacts>().iter().map(|collision| {
        let normal = collision
            .contact
            .map_or(Vec3::ZERO, |contact| contact.normal);
        let [x, y, z] = normal.to_array().map(f32::to_bits);
        let who = [number(collision.a), number(collision.b)];
        (who, [collision.time.to_bits(), x, y, z])
    });
    contacts.collect()
}

/// Only who touches whom.
fn pairs(app: &mut App) -> Vec<[u64; 2]> {
    contacts(app).into_iter().map(|(pair, _)| pair).collect()
}

#[test]
fn a_client_sees_the_same_contacts() {
    let (mut game, mut client) = (Game::new(1, false), app(Role::Mirror));
    game.server.connect_client(&mut client);
    let mut seen = 0;
    for tick in 0..1000 {
        game.tick();
        game.server.exchange_with_client(&mut client);
        client.update();
        let expected = contacts(&mut game.server);
        assert_eq!(contacts(&mut client), expected, "tick {tick}");
        seen += expected.len();
        // Acknowledgements.
        game.server.exchange_with_client(&mut client);
    }
    assert!(seen > 3000, "{seen}");
}

#[test]
fn a_client_that_comes_late_is_told_of_all_that_touches() {
    let (mut game, mut client) = (Game::new(2, false), app(Role::Mirror));
    for _ in 0..100 {
        game.tick();
    }
    game.server.connect_client(&mut client);
    game.tick();
    game.server.exchange_with_client(&mut client);
    client.update();
    let expected = pairs(&mut game.server);
    assert!(!expected.is_empty());
    assert_eq!(pairs(&mut client), expected);
    let mut messages = client
        .world_mut()
        .resource_mut::<Messages<CollisionStarted>>();
    let started: Vec<_> = messages.drain().collect();
    let mut ended = client
        .world_mut()
        .resource_mut::<Messages<CollisionEnded>>();
    assert_eq!(started.len() - ended.drain().count(), expected.len());
}

#[test]
fn what_was_lost_is_made_up_for() {
    let (mut game, mut client) = (Game::new(3, false), app(Role::Mirror));
    game.server.connect_client(&mut client);
    let mut luck = Rng::with_seed(4);
    let (mut lost, mut missed) = (0, 0);
    for round in 0..100 {
        for _ in 0..8 {
            game.tick();
            let mut messages = game.server.world_mut().resource_mut::<ServerMessages>();
            messages.retain_sent(|(_, channel, _)| {
                let is_lost = *channel == usize::from(ServerChannel::Mutations) && luck.bool();
                lost += usize::from(is_lost);
                !is_lost
            });
            game.server.exchange_with_client(&mut client);
            client.update();
            missed += usize::from(pairs(&mut client) != pairs(&mut game.server));
            game.server.exchange_with_client(&mut client);
        }
        // Now nothing is.
        game.tick();
        game.server.exchange_with_client(&mut client);
        client.update();
        let expected = contacts(&mut game.server);
        assert_eq!(contacts(&mut client), expected, "round {round}");
        game.server.exchange_with_client(&mut client);
    }
    assert!(lost > 100 && missed > 50, "{lost} lost, {missed} missed");
}

#[test]
fn a_client_that_goes_on_by_itself_foresees_the_next_contacts() {
    let (mut game, mut client) = (Game::new(5, true), app(Role::Predicting));
    game.server.connect_client(&mut client);
    let (mut right, mut wrong, mut touching) = (0, 0, 0);
    let mut foreseen = None;
    for _ in 0..1000 {
        game.server.update();
        touching += contacts(&mut game.server).len();
        match foreseen {
            Some(foreseen) if foreseen == contacts(&mut game.server) => right += 1,
            Some(_) => wrong += 1,
            None => {}
        }
        game.server.exchange_with_client(&mut client);
        // What it was sent is the state after this tick, and it makes the next of it.
        client.update();
        foreseen = Some(contacts(&mut client));
        game.server.exchange_with_client(&mut client);
    }
    println!("{right} ticks foreseen, {wrong} not, {touching} contacts");
    assert_eq!((right, wrong), (999, 0));
    assert!(touching > 1000, "{touching} contacts");
}
