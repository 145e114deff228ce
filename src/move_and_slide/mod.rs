//! Shapes that move among others, slide along what they meet, and pass through nothing.
//!
//! [`move_and_slide`] takes a shape, a pose, a velocity and a time, and says where it gets to: for characters, cameras,
//! ghosts, whatever is moved by hand and is not to go through walls. [`MoveAndSlide`] is the same as a parameter of systems.
//! What walks on a ground, with slopes, steps and platforms, is a [character](crate::character), which is built on it.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
//! let wall = app.world_mut().spawn((CollisionShape::cuboid(1.0, 10.0, 10.0), Transform::from_xyz(3.0, 0.0, 0.0))).id();
//! app.update();
//!
//! let ask = move |mover: MoveAndSlide| {
//!     let (ball, settings) = (Shape::sphere(0.5), MoveSettings::default());
//!     // To the wall, which is 2 away, and along it for the rest of the second.
//!     let mut met = Vec::new();
//!     let moved = mover.move_and_slide(&ball, &Transform::IDENTITY, Vec3::new(4.0, 1.0, 0.0), 1.0, &settings, &SpatialQueryFilter::DEFAULT, |hit| {
//!         met.push(hit.entity);
//!         AtHit::Slide
//!     });
//!     assert!(moved.pose.translation.distance(Vec3::new(1.99, 1.0, 0.0)) < 1e-4);
//!     assert!(moved.velocity.distance(Vec3::Y) < 1e-4);
//!     assert_eq!(met, [wall]);
//! };
//! # use bevy::ecs::system::RunSystemOnce;
//! app.world_mut().run_system_once(ask).unwrap();
//! ```
//!
//! # How it goes
//!
//! A shape is cast along its way, exactly, however long that is. Where it would come nearer to something than the
//! [skin](MoveSettings::skin), it stops, and what its velocity has against the surface is
//! [taken away](project_velocity); with the rest of it, and of the time, it goes on. All surfaces that it has met count
//! together, so that it does not tremble in corners, until it has left them behind.
//!
//! Kept off by its skin, a shape starts each move in touch with nothing: walls that it slides along, seams of a floor
//! and edges between its triangles do not hold it. What was put into it, or came to it, it is [pushed out](depenetrate) of.
//!
//! # The parts
//!
//! | function | what it does |
//! |---|---|
//! | [`move_and_slide`] | all of it |
//! | [`cast_move`] | how far may it go? |
//! | [`depenetrate`] | out of what it is in |
//! | [`project_velocity`] | what is left of a velocity on some surfaces |

mod hit;
mod mover;
mod planes;
mod push_out;
mod slide;
mod surroundings;

pub use hit::{AtHit, Depenetrated, MoveEnd, MoveHit, Moved};
pub use mover::{MoveAndSlide, MoveSettings, cast_move, depenetrate, move_and_slide};
pub use slide::project_velocity;
pub(crate) use slide::{Answer, Plain, Slide, Surface, along_all};
pub(crate) use surroundings::{Crowd, Met, Surroundings};
