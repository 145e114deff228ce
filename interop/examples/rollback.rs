//! Two players, each on a machine of its own, over a network that is late and loses packets: each goes
//! on with what it guesses of the other, and goes back when it guessed wrong. What they see is the same.
//!
//! `cargo run -p interop --example rollback`

use std::{process::ExitCode, thread, time::Duration};

use bevy::{platform::collections::HashMap, prelude::*, time::TimeUpdateStrategy};
use bevy_ggrs::{
    ConfirmedFrameCount, LocalInputs, LocalPlayers, RollbackFrameCount, checksum_hasher,
    ggrs::DesyncDetection, prelude::*,
};
use bevy_octree::{
    prelude::*,
    rollback::{CollisionSnapshot, RestoreSystems, RollbackPlugin},
};
use fastrand::Rng;
use interop::network::{Conditions, LossyNetwork};
use std::hash::{Hash, Hasher};

/// One byte of keys for each player; players are known by numbers.
type Game = GgrsConfig<u8, usize>;

const FRAMES: i32 = 600;
/// How many frames a player may be ahead of what is known of the other.
const WINDOW: usize = 12;
const AN_HOUR: Duration = Duration::from_secs(3600);

/// Who is steered by which player.
#[derive(Component)]
struct Player(usize);

/// How many frames were simulated, those that were simulated again included.
#[derive(Resource, Default)]
struct Simulated(i32);

fn main() -> ExitCode {
    let (loss, doubled, delay) = (0.1, 0.05, 1..=4);
    let network = LossyNetwork::new(
        Conditions {
            loss,
            doubled,
            delay,
        },
        1,
    );
    let mut peers = [0, 1].map(|own| peer(&network, own));
    while peers.iter().any(|peer| confirmed(peer) < FRAMES) {
        network.step();
        for (number, peer) in peers.iter_mut().enumerate() {
            peer.update();
            if let Some(what) = complaint(peer) {
                println!("peer {number}: {what}");
                return ExitCode::FAILURE;
            }
        }
        // Packets of the handshake that were lost are sent again after some real time.
        if confirmed(&peers[0]) < 0 {
            thread::sleep(Duration::from_millis(2));
        }
    }
    for (number, peer) in peers.iter().enumerate() {
        let frames = peer.world().resource::<RollbackFrameCount>().0;
        let again = peer.world().resource::<Simulated>().0 - frames;
        println!("peer {number}: {frames} frames, of which {again} were simulated again");
    }
    println!("{:?}; at no frame did the two differ", network.counts());
    ExitCode::SUCCESS
}

fn peer(network: &LossyNetwork, own: usize) -> App {
    let other = 1 - own;
    let session = SessionBuilder::<Game>::new()
        .with_input_delay(2)
        .with_max_prediction_window(WINDOW)
        .with_desync_detection_mode(DesyncDetection::On { interval: 1 })
        // However slow the machine is.
        .with_disconnect_timeout(AN_HOUR)
        .with_disconnect_notify_delay(AN_HOUR)
        .add_player(PlayerType::Local, own)
        .and_then(|session| session.add_player(PlayerType::Remote(other), other))
        .and_then(|session| session.start_p2p_session(network.socket(own)))
        .expect("two players, each with a number of its own");
    let mut app = App::new();
    // The ticks of collision detection are the frames of the session.
    app.add_plugins((MinimalPlugins, GgrsPlugin::<Game>::default()))
        .add_plugins((OctreePlugins::new(GgrsSchedule), RollbackPlugin))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_nanos(
            16_666_666,
        )))
        .insert_resource(Session::P2P(session))
        .init_resource::<Simulated>()
        .add_systems(Startup, spawn)
        .add_systems(ReadInputs, read_keys)
        .add_systems(
            GgrsSchedule,
            steer.after(RestoreSystems).before(CollisionSystems::First),
        );
    // What changes about entities, and what this crate keeps from tick to tick.
    app.rollback_component_with_clone::<Transform>()
        .rollback_component_with_clone::<Velocity>()
        .rollback_resource_with_clone::<CollisionSnapshot>()
        .update_resource_with_map_entities::<CollisionSnapshot>();
    // Which has to be the same on both.
    app.checksum_component::<Transform>(|place| hash(place.translation))
        .checksum_component::<Velocity>(|velocity| hash(velocity.0));
    app
}

fn hash(v: Vec3) -> u64 {
    let mut hasher = checksum_hasher();
    v.to_array().map(f32::to_bits).hash(&mut hasher);
    hasher.finish()
}

fn spawn(mut commands: Commands) {
    let mut numbers = (1..).map(CollisionOrder);
    let mut number = move || numbers.next();
    for (x, z, width, depth) in [(-8.0, 0.0, 1.0, 17.0), (8.0, 0.0, 1.0, 17.0)]
        .into_iter()
        .chain([(0.0, -8.0, 17.0, 1.0), (0.0, 8.0, 17.0, 1.0)])
    {
        let wall = (CollisionShape::cuboid(width, 2.0, depth), StaticShape);
        let place = Transform::from_xyz(x, 0.0, z);
        commands.spawn((number().unwrap_or_default(), wall, place));
    }
    for index in 0..20_u8 {
        let place = Vec3::new(
            f32::from(index % 5) * 2.0 - 4.0,
            0.0,
            f32::from(index / 5) * 2.0 - 3.0,
        );
        let ball = (
            CollisionShape::sphere(0.5),
            Swept::default(),
            Bounce::Reflect { restitution: 1.0 },
        );
        let velocity = Velocity(Vec3::new(place.z, 0.0, -place.x) * 3.0);
        let place = Transform::from_translation(place);
        let ball = (
            number().unwrap_or_default(),
            Rollback,
            ball,
            velocity,
            place,
        );
        let mut ball = commands.spawn(ball);
        if index < 2 {
            ball.insert(Player(usize::from(index)));
        }
    }
}

/// What somebody plays: another key every few frames.
fn read_keys(mut commands: Commands, frame: Res<RollbackFrameCount>, players: Res<LocalPlayers>) {
    let keys = players.0.iter().map(|player| {
        let seed = (frame.0 / 8) as u64 * 2 + *player as u64;
        (*player, Rng::with_seed(seed).u8(..4))
    });
    commands.insert_resource(LocalInputs::<Game>(keys.collect::<HashMap<_, _>>()));
}

fn steer(
    mut players: Query<(&Player, &mut Velocity)>,
    keys: Res<PlayerInputs<Game>>,
    mut simulated: ResMut<Simulated>,
) {
    simulated.0 += 1;
    for (player, mut velocity) in &mut players {
        let (key, _) = keys[player.0];
        let way = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z][usize::from(key % 4)];
        velocity.0 = (velocity.0 + way).clamp_length_max(40.0);
    }
}

fn confirmed(peer: &App) -> i32 {
    peer.world().resource::<ConfirmedFrameCount>().0
}

fn complaint(peer: &mut App) -> Option<String> {
    let Session::P2P(session) = &mut *peer.world_mut().resource_mut::<Session<Game>>() else {
        return None;
    };
    let is_bad = |event: &GgrsEvent<Game>| {
        matches!(
            event,
            GgrsEvent::DesyncDetected { .. } | GgrsEvent::Disconnected { .. }
        )
    };
    session
        .events()
        .find(is_bad)
        .map(|event| format!("{event:?}"))
}
