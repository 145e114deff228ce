//! Shapes as plain data, for whatever makes entities of text: scene files, exporters, editors,
//! inspectors, Bevy's remote protocol and its `bsn!`.
//!
//! A [`ShapeDescription`] is a component that says what shape its entity has, and has it made. The
//! [guide](crate::guide::shapes_as_data) shows how it is written in each of these ways.
//!
//! The [`CollisionShape`](crate::components::CollisionShape) that is made of it is written and read as
//! data, too. A scene that has both has the data twice; it is enough to write one of them.

mod build;
mod collision_shape;
mod describe;
mod description;
mod error;
mod follow;
#[cfg(feature = "rapier")]
mod foreign;

pub use description::{CoreDescription, PartDescription, ShapeDescription};
pub use error::NoDescriptionError;
pub use follow::ShapeDescriptionError;
pub(crate) use follow::register;
