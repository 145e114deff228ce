//! What can be wrong with a scene.

use std::{io, path::PathBuf};

use bevy::math::Vec3;
use thiserror::Error;

use super::test_set::TestSetError;
use crate::narrow_phase::ShapeError;

/// Why a scene could not be loaded, saved or spawned.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file is missing or unreadable, or not UTF-8.
    #[error("{}: cannot read the scene: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file cannot be written.
    #[error("{}: cannot write the scene: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The text is not a scene.
    #[error("{origin}:{line}:{column}: {message}")]
    Parse {
        /// The file, or `scene text`.
        origin: String,
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What was found, and what was expected instead.
        message: String,
    },
    /// The scene is well-formed but makes no sense.
    #[error("{origin}: {problem}")]
    Invalid {
        /// The file, `scene text`, or the name of the scene.
        origin: String,
        /// What is wrong.
        #[source]
        problem: SceneProblem,
    },
}

/// What makes a well-formed scene invalid.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneProblem {
    /// There is nothing in it.
    #[error("the scene has no objects, expected at least one")]
    NoObjects,
    /// A tick that lasts less than a nanosecond, for ever, or a negative time.
    #[error("ticks_per_second is {0}, expected a positive number")]
    TicksPerSecond(f64),
    /// The parameters of the test set are out of range.
    #[error("test set: {0}")]
    TestSet(#[from] TestSetError),
    /// Two objects go by the same name.
    #[error("objects {first} and {second} are both named \"{name}\", expected unique names")]
    SameName {
        /// The index of the first one, from 0.
        first: usize,
        /// The index of the second one.
        second: usize,
        /// Their name.
        name: String,
    },
    /// An object is invalid.
    #[error("object {index} (\"{name}\"): {problem}")]
    Object {
        /// Its index, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong with it.
        #[source]
        problem: ObjectProblem,
    },
}

/// What makes an object invalid.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ObjectProblem {
    /// NaN or infinity.
    #[error("{field} is {value}, expected finite numbers")]
    NotFinite {
        /// The field.
        field: &'static str,
        /// Its value.
        value: Vec3,
    },
    /// A scale that flattens the object.
    #[error("scale is {0}, expected no component to be 0")]
    FlatScale(Vec3),
    /// Both a position and a track are given.
    #[error("position is {0}, expected none beside a track, which gives all positions")]
    PositionBesideTrack(Vec3),
    /// The shape is invalid.
    #[error("shape: {0}")]
    Shape(#[from] ShapeError),
}
