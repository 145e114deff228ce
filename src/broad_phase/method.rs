//! The choice of a broad phase by name.

use std::{fmt, str::FromStr};

use bevy::prelude::*;
use thiserror::Error;

use super::{
    auto::Auto,
    engine::BroadPhase,
    exhaustive::Exhaustive,
    linear_octree::LinearOctree,
    object_octree::{ObjectOctree, ObjectOctreeSettings, SettingsError},
};

/// How overlapping boxes are searched for.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
pub enum Method {
    /// Exhaustive search for a handful of objects, the pointerless octree beyond: see [`Auto`].
    #[default]
    Auto,
    /// The pointerless octree: see [`LinearOctree`].
    Linear,
    /// The report's N-objects octree.
    Octree(ObjectOctreeSettings),
    /// Every box against every other.
    Exhaustive,
}

impl Method {
    /// Checks the settings.
    ///
    /// # Errors
    /// Those of [`ObjectOctreeSettings::check`].
    pub fn check(&self) -> Result<(), SettingsError> {
        match self {
            Self::Octree(settings) => settings.check(),
            Self::Auto | Self::Linear | Self::Exhaustive => Ok(()),
        }
    }

    /// A new, empty broad phase of this kind. Settings out of range are taken as the nearest that is in range, with a
    /// warning in the log; [`check`](Self::check) first for an error instead.
    #[must_use]
    pub fn engine(&self) -> Box<dyn BroadPhase> {
        match self {
            Self::Auto => Box::new(Auto::default()),
            Self::Linear => Box::new(LinearOctree::default()),
            Self::Octree(settings) => Box::new(ObjectOctree::new(settings.clamped())),
            Self::Exhaustive => Box::new(Exhaustive::default()),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Auto => "auto",
            Self::Linear => "linear",
            Self::Octree(_) => "octree",
            Self::Exhaustive => "exhaustive",
        })
    }
}

/// The name of a method that does not exist.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("unknown method `{0}`: expected `auto`, `linear`, `octree` or `exhaustive`")]
pub struct UnknownMethod(pub String);

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name.to_ascii_lowercase().as_str() {
            "auto" => Ok(Self::Auto),
            "linear" => Ok(Self::Linear),
            "octree" | "object" => Ok(Self::Octree(ObjectOctreeSettings::default())),
            "exhaustive" => Ok(Self::Exhaustive),
            _ => Err(UnknownMethod(name.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_in_and_out() {
        let octree = Method::Octree(ObjectOctreeSettings::default());
        for method in [Method::Auto, Method::Linear, octree, Method::Exhaustive] {
            assert_eq!(method.to_string().to_uppercase().parse(), Ok(method));
        }
        let error = "quadtree".parse::<Method>().unwrap_err();
        assert!(error.to_string().contains("`quadtree`"));
    }
}
