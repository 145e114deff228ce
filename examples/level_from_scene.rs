//! A level from a whole scene: what an artist named is solid, scenery, a trigger or water by a few
//! rules, however late the scene is there. Without a window, and without a file: a system spawns
//! what Bevy's glTF loader would; it prints what happens, and fails if it does not.
//!
//! `cargo run --release --features mesh --example level_from_scene`

use std::time::Duration;

use bevy::{
    asset::AssetPlugin,
    mesh::{Mesh3d, MeshPlugin},
    prelude::*,
};
use bevy_octree::prelude::*;

collision_layers! {
    enum Layer { Ground, Water, Ball }
}

const TICK: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.8;
/// Of the ball.
const RADIUS: f32 = 0.5;
/// In which frame the scene is loaded.
const LOADED: u32 = 5;

/// What the scene will be below: with a file, this entity has a `WorldAssetRoot`, too.
#[derive(Component)]
struct Level;

/// The name of a material. Bevy's loader inserts a `GltfMaterialName`, by which `material` goes.
#[derive(Component)]
struct MaterialName(&'static str);

#[derive(Component)]
struct Rolls;

#[derive(Resource, Default)]
struct Story {
    is_ready: bool,
    switched: u32,
    splashes: u32,
}

fn main() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        MeshPlugin,
        OctreePlugins::new(Update),
    ))
    .insert_resource(MotionSettings {
        step: Step::Seconds(TICK),
    })
    .init_resource::<Story>()
    .add_systems(Startup, open)
    .add_systems(Update, (load_scene, fall).before(CollisionSystems::Motion));

    // A loading screen.
    for _ in 0..10_000 {
        app.update();
        if app.world().resource::<Story>().is_ready {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(app.world().resource::<Story>().is_ready);

    for _ in 0..240 {
        app.update();
    }
    let story = app.world().resource::<Story>();
    assert_eq!([story.switched, story.splashes], [1, 1]);
    let mut balls = app.world_mut().query_filtered::<&Transform, With<Rolls>>();
    let ball = balls.single(app.world()).unwrap().translation;
    println!("the ball lies at {ball:.2}, in front of the wall");
    assert!((ball.y - RADIUS).abs() < 0.01 && ball.x < 8.0);
}

fn open(mut commands: Commands) {
    // With a file, beside it:
    // WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset("level.glb")))
    let rules = ShapesFromMeshes::default()
        .with((
            StaticShape,
            CollisionLayers::new(Layer::Ground, Layer::Ball),
        ))
        .name("Grass*", None)
        .name(
            "Trigger*",
            MeshRule::new(MeshForm::Cuboid).with((Sensor, CollisionEventsEnabled, Switch)),
        )
        .decide(|mesh| {
            let MaterialName(material) = mesh.entity().get()?;
            let water = MeshRule::new(MeshForm::Cuboid)
                .with((Sensor, CollisionEventsEnabled))
                .with(CollisionLayers::new(Layer::Water, Layer::Ball));
            material.starts_with("Water").then_some(water)
        });
    commands.spawn((Level, rules)).observe(start);
}

/// What a game has of its own on what a rule names.
#[derive(Component, Clone)]
struct Switch;

/// All there is to collide with, is there.
fn start(ready: On<ShapesReady>, mut commands: Commands, mut story: ResMut<Story>) {
    let counts = ready.counts;
    println!(
        "the level is there: {} shapes, {} left out, {} errors",
        counts.shapes, counts.left_out, counts.errors
    );
    assert_eq!((counts.shapes, counts.left_out, counts.errors), (4, 20, 1));
    story.is_ready = true;
    commands.spawn((
        Rolls,
        CollisionShape::sphere(RADIUS),
        CollisionLayers::new(Layer::Ball, LayerMask::ALL),
        // Held up by the floor, along which it goes.
        (
            Swept::default(),
            Velocity(Vec3::X * 4.0),
            Bounce::Reflect { restitution: 0.0 },
        ),
        Transform::from_xyz(-6.0, 2.0, 0.0),
    ));
    commands.add_observer(
        |on: On<CollisionStarted>, switches: Query<&Switch>, mut story: ResMut<Story>| {
            if switches.contains(on.a) {
                println!("the ball is on the switch");
                story.switched += 1;
            } else {
                println!("the ball is in the water");
                story.splashes += 1;
            }
        },
    );
}

fn fall(mut falling: Query<&mut Velocity, With<Rolls>>) {
    for mut velocity in &mut falling {
        velocity.y -= GRAVITY * TICK;
    }
}

/// As Bevy's loader does: an entity for each node, and below it one for each material of its mesh.
fn load_scene(
    mut frames: Local<u32>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    level: Single<Entity, With<Level>>,
) {
    *frames += 1;
    if *frames != LOADED {
        return;
    }
    let cube = meshes.add(Cuboid::default());
    let lines = meshes.add(Segment3d::new(Vec3::ZERO, Vec3::Y));
    let group = commands.spawn((Name::new("Scene"), ChildOf(*level), Transform::default()));
    let group = group.id();
    let mut node = |name: String, at: Transform, mesh: &Handle<Mesh>, material| {
        let node = commands.spawn((Name::new(name), at, ChildOf(group))).id();
        commands.spawn((
            Name::new("Cube"),
            Mesh3d(mesh.clone()),
            MaterialName(material),
            ChildOf(node),
        ));
    };
    let block = |x: f32, y: f32, size: Vec3| Transform::from_xyz(x, y, 0.0).with_scale(size);
    let floor = block(0.0, -0.5, Vec3::new(30.0, 1.0, 10.0));
    node("Floor".into(), floor, &cube, "Stone");
    let wall = block(9.0, 1.0, Vec3::new(2.0, 4.0, 10.0));
    node("Wall".into(), wall, &cube, "Stone");
    let switch = block(0.0, 0.1, Vec3::new(1.0, 0.2, 1.0));
    node("Trigger.door".into(), switch, &cube, "Stone");
    let pond = block(5.0, 0.1, Vec3::new(2.0, 0.2, 4.0));
    node("Pond".into(), pond, &cube, "Water_deep");
    for number in 0..20 {
        let blade = block(number as f32 - 10.0, 0.5, Vec3::new(0.1, 1.0, 0.1));
        node(format!("Grass.{number:03}"), blade, &cube, "Grass");
    }
    // Somebody left a guide in the file, which is no surface: the log says so.
    node("Guide".into(), Transform::default(), &lines, "Stone");
}
