//! A shooting range: what is fast passes through what is thin, unless it is `Swept`.
//!
//! Five walls as thin as paper; bullets that cover from half their own length to a thousand times
//! that in a tick. `cargo run --example bullets`

use bevy::prelude::*;
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
};

/// The diameter of a bullet.
const CALIBER: f32 = 0.1;
const WALLS: usize = 5;

fn main() {
    println!("calibers per tick   walls hit without, with Swept   bounced off the first");
    for calibers in [0.5, 2.0, 10.0, 100.0, 1000.0] {
        let without = shoot(calibers, |_| {});
        let with = shoot(calibers, |bullet| _ = bullet.insert(Swept::default()));
        // One that bounces does so when it touches, and has gone back for the rest of the tick.
        let bounced = shoot(calibers, |bullet| {
            bullet.insert((Swept::default(), Bounce::Reflect { restitution: 1.0 }));
        });
        let place = bounced.end.x;
        println!(
            "{calibers:17}   {:17}, {:10}   {}",
            without.hits,
            with.hits,
            if place < 0.0 { "yes" } else { "no" }
        );
    }

    println!("\nthe walls of a bullet's way in one tick, by the time of impact:");
    for (wall, time) in shoot(1000.0, |bullet| _ = bullet.insert(Swept::default())).times {
        println!("  {wall} after {time:.4} of the tick");
    }
}

struct Shot {
    /// How many walls were hit.
    hits: usize,
    /// Which, and after which share of the tick.
    times: Vec<(String, f32)>,
    /// Where the bullet was in the end.
    end: Vec3,
}

/// Shoots a bullet at the walls, for as many ticks as it takes to get past them.
fn shoot(calibers_per_tick: f32, prepare: impl Fn(&mut EntityWorldMut)) -> Shot {
    let mut app = App::new();
    // A tick per update, of a second each: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0),
        })
        .init_resource::<Hits>()
        .add_systems(Update, count_hits.in_set(CollisionSystems::Last));
    let paper = CollisionShape::cuboid(0.002, 10.0, 10.0);
    for number in 0..WALLS {
        let place = Transform::from_xyz(number as f32 * 0.77, 0.0, 0.0);
        app.world_mut().spawn((
            Name::new(format!("wall {}", number + 1)),
            paper.clone(),
            place,
        ));
    }
    let (start, step) = (-1.0, calibers_per_tick * CALIBER);
    let mut bullet = app.world_mut().spawn((
        CollisionShape::sphere(CALIBER / 2.0),
        Velocity(Vec3::X * step),
        Transform::from_xyz(start, 0.0, 0.0),
    ));
    prepare(&mut bullet);
    let bullet = bullet.id();
    let ticks = (6.0_f32 / step).ceil() as usize;
    for _ in 0..ticks {
        app.update();
    }
    let end = app
        .world()
        .get::<Transform>(bullet)
        .map_or(Vec3::ZERO, |transform| transform.translation);
    let Hits(times) = app.world_mut().remove_resource().unwrap_or_default();
    Shot {
        hits: times.len(),
        times,
        end,
    }
}

#[derive(Resource, Default)]
struct Hits(Vec<(String, f32)>);

fn count_hits(
    mut started: MessageReader<CollisionStarted>,
    names: Query<&Name>,
    mut hits: ResMut<Hits>,
) {
    for CollisionStarted { a, b, time, .. } in started.read() {
        if let Ok(wall) = names.get(*a).or(names.get(*b)) {
            hits.0.push((wall.to_string(), *time));
        }
    }
}
