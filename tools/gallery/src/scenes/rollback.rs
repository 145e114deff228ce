//! A game that goes back in time, while one watches: it guessed what another player does, hears what that
//! was, and simulates again.

use bevy::prelude::*;
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
    rollback::{CollisionSnapshot, RestoreSystems, RollbackPlugin},
};

use crate::{
    look::{OwnLook, State as Looks, YELLOW},
    play::{TICKS_PER_SECOND, Tick},
    scene::{AddScene as _, Scene, showing},
};

const NAME: &str = "rollback";
/// For how many frames nothing is heard of the other player: far more than in a game, to be seen.
const LATE: u64 = 64;
/// For how many frames the other player holds a key.
const KEY: u64 = 16;
/// Half the sides of the table.
const TABLE: Vec2 = Vec2::new(11.0, 7.0);
const RADIUS: f32 = 0.4;
const FASTEST: f32 = 14.0;
const BLUE: Color = Looks::Moving.color();
const RED: Color = Looks::Hit.color();

/// Adds the scene.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "back in time, and again",
        "The yellow one is steered by somebody far away. For 64 frames the game guesses that the same key is held; \
         then it hears which ones were, goes back, and simulates again. Red is what was guessed and never was. \
         A second game, which never goes back, must agree in every bit.",
        spawn,
    );
    app.add_plugins(RollbackPlugin)
        .init_resource::<Game>()
        .add_scene(
            scene
                .view(Vec3::new(0.0, 17.0, 13.0), Vec3::new(0.0, 0.0, 0.6))
                .objects(36, 90)
                .best_tick(236)
                .caption(say),
        )
        .add_systems(
            Tick,
            (
                go_back.before(RestoreSystems),
                (remember, steer)
                    .chain()
                    .after(RestoreSystems)
                    .before(CollisionSystems::First),
                look_at_both.after(CollisionSystems::Last),
            )
                .run_if(showing(NAME)),
        )
        .add_systems(Update, draw.run_if(showing(NAME)));
}

/// Who is steered from far away.
#[derive(Component)]
struct Player;

/// A game of which somebody far away steers a part.
#[derive(Resource, Default)]
struct Game {
    /// The frame that comes next.
    frame: u64,
    /// What was done before this frame is known.
    known: u64,
    /// How things were before the first frame of which nothing was known.
    saved: Option<Saved>,
    /// Where all were in each frame since.
    trails: Vec<Vec<Vec3>>,
    /// What was guessed, and never was.
    guessed: Vec<Vec<Vec3>>,
    rollbacks: u32,
    /// How many frames were simulated again, and compared.
    again: u64,
    /// In how many of these was anything not as in a game that never goes back?
    different: u64,
}

impl Game {
    /// Is what happens now guessed?
    const fn is_guess(&self) -> bool {
        self.frame >= self.known
    }

    /// The key of the other player, or what it is taken for.
    fn key(&self) -> Vec3 {
        key(self.frame.min(self.known.saturating_sub(1)))
    }
}

/// All that has to be saved.
struct Saved {
    bodies: Vec<(Entity, Transform, Velocity)>,
    snapshot: CollisionSnapshot,
}

/// The same game, by somebody who always knows what the other does.
struct Straight {
    app: App,
    frame: u64,
}

/// The key that the other player holds in a frame.
fn key(frame: u64) -> Vec3 {
    let turn = fastrand::Rng::with_seed(frame / KEY + 5).f32() * std::f32::consts::TAU;
    Vec3::new(turn.cos(), 0.0, turn.sin())
}

fn accelerate(velocity: &mut Velocity, key: Vec3) {
    velocity.0 = (velocity.0 + key * 0.8).clamp_length_max(FASTEST);
}

fn spawn(world: &mut World, objects: usize) {
    spawn_table(world, objects);
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / TICKS_PER_SECOND),
        });
    spawn_table(app.world_mut(), objects);
    world.insert_non_send(Straight { app, frame: 0 });
    world.insert_resource(Game::default());
    // What was in contact in the scene before is no part of this.
    world.insert_resource(CollisionSnapshot::default());

    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Sphere::new(RADIUS));
    let yellow = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial::from(YELLOW));
    let mut player = world.query_filtered::<Entity, With<Player>>();
    for player in player.iter(world).collect::<Vec<_>>() {
        let look = (
            OwnLook,
            Mesh3d(mesh.clone()),
            MeshMaterial3d(yellow.clone()),
        );
        world.entity_mut(player).insert(look);
    }
}

fn spawn_table(world: &mut World, objects: usize) {
    // The same number for the same thing, in both games.
    let mut orders = (0..).map(CollisionOrder);
    let mut next = || orders.next().unwrap_or_default();
    for (size, at) in [
        (Vec2::new(TABLE.x + 0.5, 0.25), Vec2::new(0.0, TABLE.y)),
        (Vec2::new(TABLE.x + 0.5, 0.25), Vec2::new(0.0, -TABLE.y)),
        (Vec2::new(0.25, TABLE.y), Vec2::new(TABLE.x + 0.25, 0.0)),
        (Vec2::new(0.25, TABLE.y), Vec2::new(-TABLE.x - 0.25, 0.0)),
    ] {
        let wall = CollisionShape::from_half_size(Vec3::new(size.x, 0.5, size.y));
        let place = Transform::from_xyz(at.x, 0.0, at.y);
        world.spawn((wall, StaticShape, place, next()));
    }
    let columns = 9;
    let rows = objects.div_ceil(columns) as f32;
    let apart = (12.0 / rows).min(1.7);
    for number in 0..objects {
        let [column, row] = [number % columns, number / columns].map(|at| at as f32);
        let middle = (rows - 1.0) / 2.0;
        let at = Vec3::new((column - 4.0) * 1.7, 0.0, (row - middle) * apart);
        let mut random = fastrand::Rng::with_seed(number as u64);
        let mut share = || random.f32() * 2.0 - 1.0;
        let velocity = Vec3::new(share(), 0.0, share()) * 2.0;
        let ball = (
            CollisionShape::sphere(RADIUS),
            Swept::default(),
            Bounce::Reflect { restitution: 1.0 },
            Velocity(velocity),
            Transform::from_translation(at),
            next(),
        );
        let is_player = number == columns / 2;
        let mut ball = world.spawn(ball);
        if is_player {
            ball.insert(Player);
        }
    }
}

type Bodies<'w, 's> = Query<'w, 's, (Entity, &'static mut Transform, &'static mut Velocity)>;

/// The keys of the other player have come: back to where nothing was known of them.
fn go_back(mut game: ResMut<Game>, mut bodies: Bodies, mut snapshot: ResMut<CollisionSnapshot>) {
    if game.frame < game.known + LATE {
        return;
    }
    let Some(saved) = game.saved.take() else {
        return;
    };
    for &(entity, place, velocity) in &saved.bodies {
        if let Ok((_, mut at, mut way)) = bodies.get_mut(entity) {
            (*at, *way) = (place, velocity);
        }
    }
    *snapshot = saved.snapshot;
    game.frame = game.known;
    game.known += LATE;
    game.guessed = std::mem::take(&mut game.trails);
    game.rollbacks += 1;
}

/// From here on, the other player's keys are guessed: this is where to go back to.
fn remember(mut game: ResMut<Game>, bodies: Bodies, snapshot: Res<CollisionSnapshot>) {
    if game.frame != game.known {
        return;
    }
    let bodies = bodies.iter();
    game.saved = Some(Saved {
        bodies: bodies
            .map(|(entity, place, velocity)| (entity, *place, *velocity))
            .collect(),
        snapshot: snapshot.clone(),
    });
    game.trails.clear();
    game.guessed.clear();
}

fn steer(game: Res<Game>, mut player: Single<&mut Velocity, With<Player>>) {
    accelerate(&mut player, game.key());
}

type State = (CollisionOrder, Transform, Velocity);

/// The state of all bodies, by their numbers.
fn state<'a>(
    bodies: impl Iterator<Item = (&'a CollisionOrder, &'a Transform, &'a Velocity)>,
) -> Vec<State> {
    let mut state: Vec<_> = bodies
        .map(|(order, place, velocity)| (*order, *place, *velocity))
        .collect();
    state.sort_unstable_by_key(|(order, ..)| order.0);
    state
}

/// Notes where all are, and whether they are there in the other game too.
fn look_at_both(
    mut game: ResMut<Game>,
    bodies: Query<(&CollisionOrder, &Transform, &Velocity)>,
    mut straight: NonSendMut<Straight>,
) {
    let now = state(bodies.iter());
    if !game.is_guess() {
        straight.step();
        game.again += 1;
        game.different += u64::from(straight.state() != now || straight.frame != game.frame + 1);
    }
    let places = now.iter().map(|(_, place, _)| place.translation);
    game.trails.push(places.collect());
    game.frame += 1;
}

impl Straight {
    fn step(&mut self) {
        let world = self.app.world_mut();
        let mut player = world.query_filtered::<&mut Velocity, With<Player>>();
        for mut velocity in player.iter_mut(world) {
            accelerate(&mut velocity, key(self.frame));
        }
        self.app.update();
        self.frame += 1;
    }

    fn state(&mut self) -> Vec<State> {
        let world = self.app.world_mut();
        let mut bodies = world.query::<(&CollisionOrder, &Transform, &Velocity)>();
        state(bodies.iter(world))
    }
}

fn draw(game: Res<Game>, mut gizmos: Gizmos) {
    let (guessed, now) = (&game.guessed, &game.trails);
    for body in 0..now.first().map_or(0, Vec::len) {
        let place = |places: &Vec<Vec3>| places[body];
        gizmos.linestrip(now.iter().map(place), BLUE);
        // From where the two part.
        let both = guessed.iter().map(place).zip(now.iter().map(place));
        let parted = both.into_iter().position(|(guessed, now)| guessed != now);
        let Some(parted) = parted else {
            continue;
        };
        let begin = parted.saturating_sub(1);
        gizmos.linestrip(guessed[begin..].iter().map(place), RED);
        if let Some(guessed) = guessed.get(now.len() - 1) {
            gizmos.sphere(guessed[body], RADIUS, RED);
        }
    }
}

fn say(world: &mut World) -> String {
    let game = world.resource::<Game>();
    let what = if game.is_guess() {
        "guessed"
    } else {
        "again, with what is known"
    };
    format!(
        "frame {}, {what}\nrollbacks: {}; of {} frames simulated again, {} differ from a game that never went back",
        game.frame, game.rollbacks, game.again, game.different
    )
}
