//! Which entities may meet: layers, owners to ignore, sensors and a hook of one's own. Run it with
//! `cargo run --release --example filters`.

use bevy::{ecs::system::SystemParam, prelude::*};
use bevy_octree::{
    motion::{CollisionClock, MotionSettings, Step},
    prelude::*,
};

collision_layers! {
    /// The layers of this game.
    enum Layer {
        Ship,
        Bullet,
        Zone,
    }
}

#[derive(Component)]
struct Cloaked;

/// Bullets do not hit what is cloaked.
#[derive(SystemParam)]
struct Cloaking<'w, 's> {
    cloaked: Query<'w, 's, (), With<Cloaked>>,
    bullets: Query<'w, 's, (), With<Velocity>>,
}

impl PairHook for Cloaking<'static, 'static> {
    fn admits(hook: &Cloaking, a: Entity, b: Entity) -> bool {
        let misses =
            |bullet, target| hook.bullets.contains(bullet) && hook.cloaked.contains(target);
        !misses(a, b) && !misses(b, a)
    }
}

fn main() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        OctreePlugins::new(Update),
        PairHookPlugin::<Cloaking>::default(),
    ));
    app.insert_resource(MotionSettings {
        step: Step::Seconds(1.0),
    });
    app.add_systems(Startup, spawn);
    app.add_systems(Update, report.after(CollisionSystems::Report));
    for _ in 0..12 {
        app.update();
    }
}

fn spawn(mut commands: Commands) {
    // Ships meet everything but other ships; the zone is entered by ships only, and nothing bounces
    // off it.
    let ship = CollisionLayers::new(Layer::Ship, Layer::Bullet | Layer::Zone);
    let cube = CollisionShape::default();
    let shooter = commands
        .spawn((Name::new("shooter"), cube.clone(), ship))
        .id();
    let target = Transform::from_xyz(8.0, 0.0, 0.0);
    commands.spawn((Name::new("target"), cube.clone(), ship, target));
    commands.spawn((
        Name::new("wingman"),
        cube.clone(),
        ship,
        target.with_translation(Vec3::new(8.0, 0.5, 0.0)),
    ));
    commands.spawn((
        Name::new("cloaked ship"),
        cube.clone(),
        ship,
        Cloaked,
        Transform::from_xyz(4.0, 0.0, 0.0),
    ));
    commands.spawn((
        Name::new("zone"),
        cube.clone(),
        CollisionLayers::new(Layer::Zone, Layer::Ship),
        Sensor,
        Transform::from_xyz(8.0, 0.0, 0.0).with_scale(Vec3::splat(3.0)),
    ));
    // It begins within the ship that fired it, and ignores it; other bullets are not on a layer
    // that it may meet.
    for height in [0.0, 0.25] {
        commands.spawn((
            Name::new("bullet"),
            CollisionShape::sphere(0.125),
            CollisionLayers::new(Layer::Bullet, Layer::Ship),
            IgnoreCollisions::from([shooter]),
            Velocity(Vec3::X),
            Transform::from_xyz(0.0, height, 0.0),
        ));
    }
}

fn report(
    mut started: MessageReader<CollisionStarted>,
    names: Query<&Name>,
    clock: Res<CollisionClock>,
) {
    for contact in started.read() {
        if let Ok([a, b]) = names.get_many([contact.a, contact.b]) {
            println!("tick {}: {a} meets {b}", clock.tick());
        }
    }
}
