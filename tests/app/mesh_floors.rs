//! What falls on floors of triangles, and what slides over them.

use crate::common;

use bevy::prelude::*;
use bevy_octree::{narrow_phase::Shape, prelude::*};
use common::*;

/// How triangles make up a floor.
#[derive(Clone, Copy, Debug)]
enum Floor {
    /// Two, joined along a diagonal.
    Upwards,
    Downwards,
    /// Around a vertex off the middle.
    Fan,
    Grid,
}

const FLOORS: [Floor; 4] = [Floor::Upwards, Floor::Downwards, Floor::Fan, Floor::Grid];

/// From −`half` to `half` along x and z.
fn floor(floor: Floor, half: f32) -> Shape {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z) * half;
    let mut corners = vec![
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    let triangles = match floor {
        Floor::Upwards => vec![[0, 1, 2], [0, 2, 3]],
        Floor::Downwards => vec![[0, 2, 1], [0, 3, 2]],
        Floor::Fan => {
            corners.push(corner(-0.025, 0.025));
            vec![[4, 0, 1], [4, 1, 2], [4, 2, 3], [4, 3, 0]]
        }
        Floor::Grid => {
            let n = half as u32;
            let vertex = |i: u32| i as f32 * 2.0 / n as f32 - 1.0;
            let at = |x: u32, z: u32| z * (n + 1) + x;
            corners = (0..=n)
                .flat_map(|z| (0..=n).map(move |x| corner(vertex(x), vertex(z))))
                .collect();
            let squares = (0..n).flat_map(|z| (0..n).map(move |x| (x, z)));
            squares
                .flat_map(|(x, z)| {
                    let [a, b, c, d] = [at(x, z), at(x, z + 1), at(x + 1, z), at(x + 1, z + 1)];
                    [[a, b, c], [c, b, d]]
                })
                .collect()
        }
    };
    Shape::mesh(corners, triangles).unwrap()
}

/// A box, as a cuboid, a convex mesh and a mesh.
fn boxes() -> [Shape; 3] {
    let half = 0.5;
    let corner = |bits: u32| {
        Vec3::new(
            (bits & 1) as f32 - 0.5,
            (bits >> 1 & 1) as f32 - 0.5,
            (bits >> 2) as f32 - 0.5,
        )
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    let sides = SIDES;
    [
        Shape::from_half_size(Vec3::splat(half)),
        Shape::convex(corners.clone(), sides).unwrap(),
        Shape::mesh(corners, sides).unwrap(),
    ]
}

fn on_floor(kind: Floor, half: f32, gravity: bool) -> App {
    let mut app = app(BroadPhaseMethod::default());
    if gravity {
        app.add_systems(FixedUpdate, |mut falling: Query<&mut Velocity>| {
            falling
                .iter_mut()
                .for_each(|mut velocity| velocity.y -= 9.81 / TICKS_PER_SECOND);
        });
    }
    app.world_mut().spawn((
        CollisionShape(floor(kind, half)),
        StaticShape,
        Transform::IDENTITY,
    ));
    app
}

#[test]
fn a_box_slides_straight_over_the_seams() {
    for kind in FLOORS {
        for shape in boxes() {
            for (gravity, ticks) in [(false, 1000), (true, 1000)] {
                let mut app = on_floor(kind, 32.0, gravity);
                let slider = (
                    CollisionShape(shape.clone()),
                    Swept::default(),
                    Bounce::Reflect { restitution: 0.0 },
                    Velocity(Vec3::X * 3.0),
                    Transform::from_xyz(-23.0, 0.5, -0.3),
                );
                let slider = app.world_mut().spawn(slider).id();
                tick(&mut app, ticks);
                let place = get::<Transform>(&app, slider).translation;
                let way = 3.0 * ticks as f32 / TICKS_PER_SECOND;
                let expected = Vec3::new(-23.0 + way, 0.5, -0.3);
                assert!(
                    place.distance(expected) < 0.01,
                    "{kind:?} {shape:?} gravity {gravity}: {place}, expected {expected}"
                );
            }
        }
    }
}

#[test]
fn what_falls_straight_down_stays_there() {
    for kind in FLOORS {
        for shape in boxes() {
            for swept in [true, false] {
                for (x, z) in [(0.3, 0.1), (-0.8, 0.8), (5.0, 2.0)] {
                    let mut app = on_floor(kind, 32.0, true);
                    let body = (
                        CollisionShape(shape.clone()),
                        Bounce::Reflect { restitution: 0.4 },
                        Velocity(Vec3::ZERO),
                        Transform::from_xyz(x, 2.0, z),
                    );
                    let body = app.world_mut().spawn(body).id();
                    if swept {
                        app.world_mut().entity_mut(body).insert(Swept::default());
                    }
                    // What is not swept sinks in while it rests: nothing pushes it back.
                    tick(&mut app, if swept { 400 } else { 100 });
                    let place = get::<Transform>(&app, body).translation;
                    let aside = (place.x - x).abs().max((place.z - z).abs());
                    let lowest = if swept { 0.49 } else { 0.1 };
                    assert!(
                        aside < 1e-3 && (lowest..0.6).contains(&place.y),
                        "{kind:?} {shape:?} swept {swept} over ({x}, {z}): {place}"
                    );
                }
            }
        }
    }
}
