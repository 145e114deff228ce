//! What slides or rolls over flush boxes goes on over the seams.

use crate::common;

use bevy::prelude::*;
use bevy_octree::{narrow_phase::Shape, prelude::*};
use common::*;

const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };

/// The kinds of shapes that floors and sliders are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Made {
    Cuboid,
    Convex,
    Mesh,
    Ball,
}

/// The corners and faces of a box.
fn faces(half: Vec3) -> (Vec<Vec3>, [[u32; 4]; 6]) {
    let corner = |bits: u32| {
        Vec3::new(
            (bits & 1) as f32,
            (bits >> 1 & 1) as f32,
            (bits >> 2) as f32,
        ) * 2.0
            - 1.0
    };
    let sides = SIDES;
    ((0..8).map(|bits| corner(bits) * half).collect(), sides)
}

fn shape(made: Made, half: Vec3) -> CollisionShape {
    let (corners, sides) = faces(half);
    CollisionShape(match made {
        Made::Cuboid => Shape::from_half_size(half),
        Made::Convex => Shape::convex(corners, sides).unwrap(),
        Made::Mesh => Shape::mesh(corners, sides).unwrap(),
        Made::Ball => Shape::sphere(half.y),
    })
}

/// A floor of flush boxes along x, below y = 0, turned and moved as a whole, and what slides over
/// it.
struct Slide {
    floor: Made,
    slider: Made,
    /// Half the length of a box of the floor.
    spacing: f32,
    /// The way per tick.
    step: Vec3,
    /// Where the slider begins, along x.
    start: f32,
    swept: bool,
    turned: Quat,
    /// Are the boxes unit boxes, scaled?
    scaled: bool,
}

impl Default for Slide {
    fn default() -> Self {
        Self {
            floor: Made::Cuboid,
            slider: Made::Cuboid,
            spacing: 0.5,
            step: Vec3::X * 0.25,
            start: 0.0,
            swept: true,
            turned: Quat::IDENTITY,
            scaled: false,
        }
    }
}

impl Slide {
    /// Where the slider is after so many ticks, and how fast, along the floor and upwards.
    fn run(&self, ticks: usize) -> (Vec3, Vec3) {
        let mut app = app(BroadPhaseMethod::default());
        let place = |app: &mut App, made, half: Vec3, at: Vec3| {
            let (half, scale) = if self.scaled {
                (Vec3::ONE * 0.25, half * 4.0)
            } else {
                (half, Vec3::ONE)
            };
            let at = Transform {
                translation: self.turned * at,
                rotation: self.turned,
                scale,
            };
            app.world_mut().spawn((shape(made, half), at)).id()
        };
        let reach =
            (self.start.abs() + self.step.length() * ticks as f32 + 3.0) / (2.0 * self.spacing);
        for i in -reach as i32..=reach as i32 {
            place(
                &mut app,
                self.floor,
                Vec3::new(self.spacing, 0.5, 1.5),
                Vec3::new(i as f32 * 2.0 * self.spacing, -0.5, 0.0),
            );
        }
        let slider = place(
            &mut app,
            self.slider,
            Vec3::splat(0.5),
            Vec3::new(self.start, 0.5, 0.0),
        );
        let velocity = Velocity(self.turned * self.step * TICKS_PER_SECOND);
        app.world_mut()
            .entity_mut(slider)
            .insert((velocity, ELASTIC));
        if self.swept {
            app.world_mut().entity_mut(slider).insert(Swept::default());
        }
        tick(&mut app, ticks);
        let back = self.turned.inverse();
        let step = get::<Velocity>(&app, slider).0 / TICKS_PER_SECOND;
        (
            back * get::<Transform>(&app, slider).translation,
            back * step,
        )
    }

    fn check(&self, ticks: usize) {
        let (place, step) = self.run(ticks);
        let expected = Vec3::new(self.start, 0.5, 0.0) + self.step * ticks as f32;
        let name = format!(
            "{:?} over {:?}, spacing {}, step {}, from {}, swept {}, turned {}, scaled {}",
            self.slider,
            self.floor,
            self.spacing,
            self.step,
            self.start,
            self.swept,
            self.turned,
            self.scaled
        );
        assert!(step.distance(self.step) < 1e-4, "{name}: {step} at {place}");
        assert!(
            place.distance(expected) < 2e-3 + 1e-5 * expected.length(),
            "{name}: at {place}, expected {expected}"
        );
    }
}

#[test]
fn a_box_slides_over_flush_boxes() {
    for swept in [true, false] {
        for (step, start) in [
            (0.25, 0.0),
            (0.25, 0.1),
            (0.5, 0.0),
            (1.0, 0.0),
            (1.0, 0.3),
            (0.1, 0.0),
            (3.7, 0.2),
        ] {
            for spacing in [0.5, 0.25, 0.35, 2.0] {
                Slide {
                    swept,
                    step: Vec3::X * step,
                    start,
                    spacing,
                    ..default()
                }
                .check(24);
            }
        }
    }
}

#[test]
fn whatever_both_are_made_of() {
    for swept in [true, false] {
        for floor in [Made::Cuboid, Made::Convex, Made::Mesh] {
            for slider in [Made::Cuboid, Made::Convex, Made::Mesh, Made::Ball] {
                for (step, start) in [
                    (0.25, 0.0),
                    (-0.25, 0.0),
                    (0.3, 0.1),
                    (2.0, 0.25),
                    (-2.0, -0.3),
                ] {
                    Slide {
                        swept,
                        floor,
                        slider,
                        step: Vec3::X * step,
                        start,
                        ..default()
                    }
                    .check(16);
                    Slide {
                        swept,
                        floor,
                        slider,
                        step: Vec3::X * step,
                        start,
                        scaled: true,
                        ..default()
                    }
                    .check(16);
                }
            }
        }
    }
}

/// Of a turned floor, rounding puts each box a little higher or lower.
#[test]
fn turned_whichever_way() {
    for turned in [
        Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_x(0.3),
        Quat::from_rotation_z(0.5),
        Quat::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.7),
    ] {
        for swept in [true, false] {
            for floor in [Made::Cuboid, Made::Convex, Made::Mesh] {
                for slider in [Made::Cuboid, Made::Convex, Made::Mesh, Made::Ball] {
                    Slide {
                        swept,
                        floor,
                        slider,
                        turned,
                        ..default()
                    }
                    .check(16);
                    Slide {
                        swept,
                        floor,
                        slider,
                        turned,
                        step: Vec3::new(0.3, 0.0, 0.01),
                        scaled: true,
                        ..default()
                    }
                    .check(16);
                }
            }
        }
    }
}

/// For as long as rounding lets it, which puts it up to 10⁻⁵ higher or lower per tick.
#[test]
fn a_long_way() {
    for slider in [Made::Cuboid, Made::Ball] {
        for swept in [true, false] {
            Slide {
                slider,
                swept,
                step: Vec3::X * 0.37,
                ..default()
            }
            .check(1000);
        }
    }
}

/// What is pressed down at each tick, as by gravity, slides on too.
#[test]
fn under_gravity() {
    for slider in [Made::Cuboid, Made::Ball] {
        for (swept, restitution) in [(true, 0.0), (true, 0.5)] {
            let mut app = app(BroadPhaseMethod::default());
            app.add_systems(FixedUpdate, |mut falling: Query<&mut Velocity>| {
                falling
                    .iter_mut()
                    .for_each(|mut velocity| velocity.y -= 9.81 / TICKS_PER_SECOND);
            });
            for i in -3..80 {
                let block = shape(Made::Cuboid, Vec3::splat(0.5));
                app.world_mut()
                    .spawn((block, Transform::from_xyz(i as f32, -0.5, 0.0)));
            }
            let slider = (
                shape(slider, Vec3::splat(0.5)),
                Transform::from_xyz(0.0, 0.5, 0.0),
                Swept::default(),
            );
            let slider = app
                .world_mut()
                .spawn((
                    slider,
                    Bounce::Reflect { restitution },
                    Velocity(Vec3::X * 16.0),
                ))
                .id();
            if !swept {
                app.world_mut().entity_mut(slider).remove::<Swept>();
            }
            for n in 1..=256 {
                tick(&mut app, 1);
                let (at, velocity) = (
                    get::<Transform>(&app, slider).translation,
                    get::<Velocity>(&app, slider).0,
                );
                assert!(
                    (0.499..0.51).contains(&at.y) && (velocity.x - 16.0).abs() < 0.05,
                    "tick {n}: {at} {velocity}"
                );
            }
            assert!((get::<Transform>(&app, slider).translation.x - 64.0).abs() < 0.3);
        }
    }
}

/// What is in the way is in the way, from the floor on: a step as high as a hundredth of the box, a
/// wall, and a box that it meets face to face.
#[test]
fn a_real_step_stops_it() {
    for swept in [true, false] {
        for made in [Made::Cuboid, Made::Convex, Made::Mesh] {
            for height in [0.01, 0.3, 1.0, 5.0] {
                let mut app = app(BroadPhaseMethod::default());
                for i in -3..3 {
                    app.world_mut().spawn((
                        shape(made, Vec3::splat(0.5)),
                        Transform::from_xyz(i as f32, -0.5, 0.0),
                    ));
                }
                let half = Vec3::new(0.5, (height + 1.0) / 2.0, 0.5);
                app.world_mut().spawn((
                    shape(made, half),
                    Transform::from_xyz(3.0, half.y - 1.0, 0.0),
                ));
                let slider = (
                    shape(made, Vec3::splat(0.5)),
                    Transform::from_xyz(0.0, 0.5, 0.0),
                    ELASTIC,
                );
                let slider = app
                    .world_mut()
                    .spawn((slider, Velocity(Vec3::X * 16.0)))
                    .id();
                if swept {
                    app.world_mut().entity_mut(slider).insert(Swept::default());
                }
                tick(&mut app, 12);
                let (at, velocity) = (
                    get::<Transform>(&app, slider).translation,
                    get::<Velocity>(&app, slider).0,
                );
                assert!(
                    velocity.distance(Vec3::X * -16.0) < 0.01,
                    "{made:?} {height} swept {swept}: {velocity} at {at}"
                );
            }
        }
    }
}

/// Into a corner of a floor and a wall, straight at both: off both.
#[test]
fn a_corner_throws_back() {
    for made in [Made::Cuboid, Made::Ball] {
        let mut app = app(BroadPhaseMethod::default());
        app.world_mut().spawn((
            shape(Made::Cuboid, Vec3::splat(5.0)),
            Transform::from_xyz(0.0, -5.0, 0.0),
        ));
        app.world_mut().spawn((
            shape(Made::Cuboid, Vec3::splat(5.0)),
            Transform::from_xyz(6.0, 5.0, 0.0),
        ));
        let slider = (
            shape(made, Vec3::splat(0.5)),
            Transform::from_xyz(0.25, 0.75, 0.0),
            Swept::default(),
            ELASTIC,
        );
        let slider = app
            .world_mut()
            .spawn((slider, Velocity(Vec3::new(16.0, -16.0, 0.0))))
            .id();
        tick(&mut app, 2);
        assert!(get::<Velocity>(&app, slider).distance(Vec3::new(-16.0, 16.0, 0.0)) < 0.01);
    }
}
