//! A shooting range: what is fast passes through what is thin, unless it is `Swept`.
//!
//! Five walls as thin as paper; bullets that cover from half their own length to a thousand times
//! that in a tick. At last, bullets that stop at the first thing that they hit, which ends them, and
//! tell which of its triangles that was; a sensor before it counts them. `cargo run --example
//! bullets`

use bevy::prelude::*;
use bevy_octree::prelude::*;

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

    println!("\nbullets that end at their first hit:");
    hit_the_target();
}

/// The walls.
fn range() -> App {
    let mut app = App::new();
    // A tick per update, of a second each: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0),
        });
    let paper = CollisionShape::cuboid(0.002, 10.0, 10.0);
    for number in 0..WALLS {
        let place = Transform::from_xyz(number as f32 * 0.77, 0.0, 0.0);
        app.world_mut().spawn((
            Name::new(format!("wall {}", number + 1)),
            paper.clone(),
            place,
        ));
    }
    app
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
    let mut app = range();
    app.init_resource::<Hits>()
        .add_systems(Update, count_hits.in_set(CollisionSystems::Last));
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

/// What is gone once it has hit something.
#[derive(Component)]
struct Bullet;

/// Shoots at a square of four triangles in front of the walls, above, below and beside its middle,
/// and past it.
fn hit_the_target() {
    let mut app = range();
    // Where bullets hit is asked for all.
    app.insert_resource(CollisionEventSettings {
        geometry: EventScope::All,
        ..default()
    })
    .add_systems(Update, end_at_first_hit.in_set(CollisionSystems::Last));
    let corners = [
        (-1.0, -1.0),
        (-1.0, 1.0),
        (1.0, 1.0),
        (1.0, -1.0),
        (0.0, 0.0),
    ];
    let corners = corners.map(|(y, z)| Vec3::new(-0.5, y, z));
    let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let target = CollisionShape::mesh(corners, triangles).expect("its triangles have an area");
    app.world_mut().spawn((Name::new("target"), target));
    let gate = CollisionShape::cuboid(0.002, 10.0, 10.0);
    let at_gate = Transform::from_xyz(-0.75, 0.0, 0.0);
    app.world_mut()
        .spawn((Name::new("gate"), gate, Sensor, at_gate));
    let aims = [(0.5, 0.1), (-0.5, 0.1), (0.1, -0.5), (0.1, 0.5), (2.0, 0.0)];
    for (number, (y, z)) in (1..).zip(aims) {
        app.world_mut().spawn((
            Bullet,
            Name::new(format!("bullet {number}")),
            CollisionShape::sphere(CALIBER / 2.0),
            // They do not meet each other.
            CollisionLayers::new(LayerMask::layer(1), LayerMask::layer(0)),
            Swept::stopping(),
            Velocity(Vec3::X * 100.0 * CALIBER),
            Transform::from_xyz(-1.0, y, z),
        ));
    }
    app.update();
    let mut left = app.world_mut().query_filtered::<(), With<Bullet>>();
    assert_eq!(left.iter(app.world()).count(), 0, "each has hit something");
}

/// Of what a bullet meets in a tick, it is told in the order of time, up to the first solid: that is
/// what it hits.
fn end_at_first_hit(
    mut started: MessageReader<CollisionStarted>,
    bullets: Query<&Name, With<Bullet>>,
    names: Query<(&Name, Has<Sensor>)>,
    spatial: SpatialQuery,
    mut commands: Commands,
) {
    let mut through_gate = 0;
    for message in started.read() {
        let hit = if bullets.contains(message.a) {
            *message
        } else {
            message.reversed()
        };
        let (Ok(bullet), Ok((target, is_sensor))) = (bullets.get(hit.a), names.get(hit.b)) else {
            continue;
        };
        if is_sensor {
            through_gate += 1;
            continue;
        }
        match polygon_hit(&hit, &spatial) {
            Some(triangle) => println!("  {bullet} hits triangle {triangle} of the {target}"),
            None => println!("  {bullet} hits {target}"),
        }
        commands.entity(hit.a).despawn();
    }
    if through_gate > 0 {
        println!("  {through_gate} of them came through the gate");
    }
}

/// Which polygon of `b` has `a` hit? A short ray along the normal tells, from just before the
/// surface to just behind it.
fn polygon_hit(hit: &CollisionStarted, spatial: &SpatialQuery) -> Option<u32> {
    const REACH: f32 = 0.01;
    let contact = hit.contact?;
    let direction = Dir3::new(contact.normal).ok()?;
    let ray = Ray3d::new(contact.point - REACH * contact.normal, direction);
    let is_hit = |entity| entity == hit.b;
    let filter = SpatialQueryFilter::DEFAULT.only(&is_hit);
    spatial.cast_ray(ray, 2.0 * REACH, &filter)?.polygon
}
