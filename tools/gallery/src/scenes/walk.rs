//! A character that walks a course: by itself, until the keys take it over.

use bevy::prelude::*;
use bevy_octree::prelude::*;
use course::Script;

use crate::{
    camera::Eye,
    look::{OwnLook, YELLOW},
    play::{Play, TICKS_PER_SECOND, Tick},
    scene::{AddScene as _, Scene, showing},
};

#[expect(
    dead_code,
    reason = "how long the walk may take is for those who judge it"
)]
#[path = "../../../../examples/common/course.rs"]
mod course;

const NAME: &str = "walk";
const TICK: f32 = 1.0 / TICKS_PER_SECOND;
/// What is left of the speed in the air, when another one is wanted, after a second.
const AIR_CONTROL: f32 = 0.02;
/// Whoever is below has fallen off the course.
const ABYSS: f32 = -15.0;
/// The corners, along x and z, of where the crowd goes about: between the start and the maze.
const CROWD: [Vec2; 2] = [Vec2::new(-5.4, -7.4), Vec2::new(12.4, 7.4)];
const CROWD_SPEED: f32 = 1.6;
/// How far apart the crowd is at first.
const ELBOWS: f32 = 0.95;
/// How many ticks apart the points of the trail are, and how many there are at most.
const TRAIL_STEP: u64 = 4;
const TRAIL: usize = 1500;
/// How fast the camera catches up: after so much of a second, a third of the way is left.
const LAG: f32 = 0.15;

/// Adds the scene.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "stairs, a maze, a lift, hills, on foot",
        "The yellow one walks, through nothing and without a physics engine: in a crowd, on stairs, a lift, \
         a platform that turns, and hills of 100 000 triangles. The arrow keys take it over, J jumps; R \
         lets it go by itself again.",
        spawn,
    );
    app.add_scene(
        scene
            .view(Vec3::new(4.0, 17.0, 30.0), Vec3::new(-3.0, -1.0, -1.0))
            .objects(40, 120)
            .best_tick(680)
            .caption(say),
    )
    .add_systems(
        Tick,
        (
            (move_platforms, wander, steer, put_back)
                .chain()
                .before(CollisionSystems::Motion),
            (trail, follow).in_set(CollisionSystems::Last),
        )
            .run_if(showing(NAME)),
    )
    .add_systems(PreUpdate, take_over.run_if(showing(NAME)))
    .add_systems(Update, draw.run_if(showing(NAME)));
}

/// Who walks the course, and what says where to.
#[derive(Component)]
enum Walker {
    Script(Script),
    Keys,
}

/// Where it has been, last tick last.
#[derive(Component, Default)]
struct Trail(Vec<Vec3>);

/// What the camera goes along with: the walker, a little late.
#[derive(Component)]
struct Followed(Vec3);

/// One of the crowd: goes somewhere, until it is there, something is in its way, or that has taken too long.
#[derive(Component)]
struct Wanderer {
    random: fastrand::Rng,
    goal: Vec2,
    until: u64,
}

/// Where somebody is put who has fallen off.
#[derive(Component)]
struct Home(Vec3);

#[derive(Component)]
struct Lift;

#[derive(Component)]
struct Disk;

fn spawn(world: &mut World, objects: usize) {
    // Of several things that are as near, the first is met: it is the same whatever was spawned before.
    let mut orders = (0..).map(CollisionOrder);
    let mut next = || orders.next().unwrap_or_default();
    for (size, place) in course::blocks() {
        let shape = CollisionShape::from_half_size(size / 2.0);
        world.spawn((shape, place, StaticShape, next()));
    }
    let (vertices, triangles) = course::hills();
    match CollisionShape::mesh(vertices, triangles) {
        Ok(hills) => _ = world.spawn((hills, StaticShape, next())),
        Err(error) => error!("the hills: {error}"),
    }
    let (size, place) = course::lift(0.0);
    let shape = CollisionShape::from_half_size(size / 2.0);
    world.spawn((Lift, shape, place, next()));
    let (height, place) = course::disk(0.0);
    let shape = CollisionShape::cylinder(course::DISK_RADIUS, height);
    world.spawn((Disk, shape, place, next()));

    let length = 2.0 * (course::HALF_HEIGHT - course::RADIUS);
    let body = CollisionShape::capsule(course::RADIUS, length);
    let mesh = Capsule3d::new(course::RADIUS, length);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let yellow = StandardMaterial::from(YELLOW);
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let yellow = materials.add(yellow);
    world.spawn((
        Walker::Script(Script::default()),
        KinematicCharacter::default(),
        (body.clone(), next()),
        (Trail::default(), Followed(course::START)),
        (OwnLook, Mesh3d(mesh), MeshMaterial3d(yellow)),
        Home(course::START),
        Transform::from_translation(course::START),
    ));
    let careful = WalkSettings {
        stop_at_ledges: true,
        ..default()
    };
    let mut homes: Vec<_> = homes().collect();
    fastrand::Rng::with_seed(6).shuffle(&mut homes);
    for (number, home) in homes.into_iter().take(objects).enumerate() {
        let wanderer = Wanderer {
            random: fastrand::Rng::with_seed(number as u64),
            goal: home.xz(),
            until: 0,
        };
        world.spawn((
            wanderer,
            KinematicCharacter::new(careful),
            (body.clone(), next()),
            Home(home),
            Transform::from_translation(home),
        ));
    }
}

/// Where the crowd may stand at first: in rows before the stairs, and clear of who walks by the script.
fn homes() -> impl Iterator<Item = Vec3> {
    let [least, most] = CROWD;
    let along = |from: f32, to: f32| {
        let count = ((to - from) / ELBOWS) as usize;
        (0..=count).map(move |at| from + at as f32 * ELBOWS)
    };
    along(least.x, 2.4)
        .flat_map(move |x| along(least.y, most.y).map(move |z| course::START.with_x(x).with_z(z)))
        .filter(|home| home.distance(course::START) > 2.0 * ELBOWS)
}

/// Platforms are moved by whatever moves them: those who stand on them are taken along.
fn move_platforms(
    mut lift: Single<&mut Transform, (With<Lift>, Without<Disk>)>,
    mut disk: Single<&mut Transform, With<Disk>>,
    play: Res<Play>,
) {
    let seconds = (play.tick + 1) as f32 * TICK;
    **lift = course::lift(seconds).1;
    **disk = course::disk(seconds).1;
}

fn wander(mut crowd: Query<(&Transform, &mut KinematicCharacter, &mut Wanderer)>, play: Res<Play>) {
    for (at, mut walking, mut wanderer) in &mut crowd {
        let at = at.translation.xz();
        let is_there = wanderer.goal.distance(at) < 0.5;
        // Who is in the way goes elsewhere too, by and by.
        let is_held = walking.velocity.xz().length() < 0.2 * CROWD_SPEED;
        if is_there || is_held || play.tick >= wanderer.until {
            let [least, most] = CROWD;
            let mut share = || wanderer.random.f32();
            let share = Vec2::new(share(), share());
            wanderer.goal = least + share * (most - least);
            wanderer.until = play.tick + 400;
        }
        let way = (wanderer.goal - at).normalize_or_zero() * CROWD_SPEED;
        go(&mut walking, Vec3::new(way.x, 0.0, way.y), None);
    }
}

fn steer(
    walker: Single<(&Transform, &mut KinematicCharacter, &mut Walker)>,
    camera: Single<&GlobalTransform, With<Eye>>,
    keys: Res<ButtonInput<KeyCode>>,
    play: Res<Play>,
) {
    let (at, mut walking, mut walker) = walker.into_inner();
    let (way, jump) = match &mut *walker {
        Walker::Script(script) => {
            let seconds = (play.tick + 1) as f32 * TICK;
            script.steer(at.translation, walking.is_on_ground(), seconds)
        }
        Walker::Keys => {
            // As the view is turned; also where it is from right above.
            let aside = *camera.right();
            let ahead = Vec3::Y.cross(aside);
            let axis = |more, less| {
                f32::from(u8::from(keys.pressed(more))) - f32::from(u8::from(keys.pressed(less)))
            };
            let way = aside * axis(KeyCode::ArrowRight, KeyCode::ArrowLeft)
                + ahead * axis(KeyCode::ArrowUp, KeyCode::ArrowDown);
            let jump = keys.pressed(KeyCode::KeyJ).then_some(course::JUMP);
            (way.with_y(0.0).normalize_or_zero() * course::SPEED, jump)
        }
    };
    go(&mut walking, way, jump);
}

/// What a game does with its keys: speed on the ground, gravity, a jump, some control in the air.
fn go(walking: &mut KinematicCharacter, way: Vec3, jump: Option<f32>) {
    let fall = walking.velocity.y - course::GRAVITY * TICK;
    walking.velocity = if walking.is_on_ground() {
        way + Vec3::Y * jump.unwrap_or(fall)
    } else {
        let kept = AIR_CONTROL.powf(TICK);
        (walking.velocity * kept + way * (1.0 - kept)).with_y(fall)
    };
}

/// From the first key on, the script steers no longer.
fn take_over(walker: Single<&mut Walker>, keys: Res<ButtonInput<KeyCode>>) {
    let ours = [
        KeyCode::ArrowUp,
        KeyCode::ArrowDown,
        KeyCode::ArrowLeft,
        KeyCode::ArrowRight,
        KeyCode::KeyJ,
    ];
    if keys.any_just_pressed(ours) {
        *walker.into_inner() = Walker::Keys;
    }
}

fn put_back(mut walking: Query<(&mut Transform, &mut KinematicCharacter, &Home)>) {
    for (mut at, mut walking, home) in &mut walking {
        if at.translation.y < ABYSS {
            at.translation = home.0;
            walking.velocity = Vec3::ZERO;
        }
    }
}

fn trail(walker: Single<(&Transform, &mut Trail)>, play: Res<Play>) {
    let (at, mut trail) = walker.into_inner();
    if play.tick.is_multiple_of(TRAIL_STEP) {
        if trail.0.len() == TRAIL {
            trail.0.remove(0);
        }
        // A little above its feet.
        let above = 0.1 - course::HALF_HEIGHT;
        trail.0.push(at.translation + Vec3::Y * above);
    }
}

fn follow(walker: Single<(&Transform, &mut Followed)>, mut eye: Single<&mut Eye>) {
    let (at, mut followed) = walker.into_inner();
    let left = (-TICK / LAG).exp();
    followed.0 = at.translation.lerp(followed.0, left);
    eye.along = followed.0 - course::START;
}

/// Where it has been; and a cross on the platform, by which one sees it turn.
fn draw(trail: Single<&Trail>, disk: Single<&Transform, With<Disk>>, mut gizmos: Gizmos) {
    gizmos.linestrip(trail.0.iter().copied(), YELLOW);
    let (height, _) = course::disk(0.0);
    for spoke in [Vec3::X, Vec3::Z] {
        let ends = [-1.0, 1.0].map(|side| {
            let end = spoke * (side * course::DISK_RADIUS);
            disk.transform_point(end + Vec3::Y * (height / 2.0 + 0.02))
        });
        gizmos.line(ends[0], ends[1], Color::WHITE);
    }
}

fn say(world: &mut World) -> String {
    let mut walker = world.query::<(&Walker, &KinematicCharacter)>();
    let Ok((walker, walking)) = walker.single(world) else {
        return String::new();
    };
    match walker {
        Walker::Script(script) if script.is_done() => "it has walked all of the course".to_owned(),
        Walker::Script(script) => format!(
            "{} of {} parts are walked; next: {}",
            script.reached.len(),
            Script::parts(),
            script.aim()
        ),
        Walker::Keys => {
            let place = if walking.is_on_ground() {
                "on the ground"
            } else {
                "in the air"
            };
            format!("by the keys: {place}")
        }
    }
}
