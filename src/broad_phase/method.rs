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

/// The way in which overlapping boxes are searched for. Which one to take: see the
/// [guide](crate::guide::broad_phases).
///
/// It has one name in text, which [`FromStr`] reads in either case, `Display` prints, and the broad
/// phase itself [tells](BroadPhase::name):
///
/// | name | method |
/// |---|---|
/// | `auto` | [`Auto`](Self::Auto), the default |
/// | `linear` | [`LinearOctree`](Self::LinearOctree) |
/// | `object` | [`ObjectOctree`](Self::ObjectOctree), with default settings where it is read |
/// | `exhaustive` | [`Exhaustive`](Self::Exhaustive) |
///
/// ```
/// use bevy_octree::broad_phase::{BroadPhaseMethod, SpatialIndex};
///
/// let method: BroadPhaseMethod = "object".parse()?;
/// assert_eq!(method.to_string(), "object");
/// assert_eq!(SpatialIndex::new(&method).engine().name(), "object");
/// # Ok::<(), bevy_octree::broad_phase::UnknownMethod>(())
/// ```
#[doc(alias(
    "spatial hash",
    "quadtree",
    "octree",
    "sweep and prune",
    "k-d tree",
    "kdtree",
    "bvh",
    "uniform grid",
    "spatial partitioning"
))]
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub enum BroadPhaseMethod {
    /// Exhaustive search for a handful of objects, the pointerless octree beyond: see [`Auto`]. The
    /// name that the broad phase tells is that of the method at work.
    #[default]
    Auto,
    /// The pointerless octree: see [`LinearOctree`].
    #[doc(alias = "bvh")]
    LinearOctree,
    /// The report's N-objects octree: see [`ObjectOctree`].
    ObjectOctree(ObjectOctreeSettings),
    /// Every box against every other: see [`Exhaustive`].
    #[doc(alias = "brute force")]
    Exhaustive,
}

impl BroadPhaseMethod {
    /// Checks the settings.
    ///
    /// # Errors
    /// Those of [`ObjectOctreeSettings::check`].
    pub fn check(&self) -> Result<(), SettingsError> {
        match self {
            Self::ObjectOctree(settings) => settings.check(),
            Self::Auto | Self::LinearOctree | Self::Exhaustive => Ok(()),
        }
    }

    /// Creates a new, empty broad phase of this kind. Settings out of range are taken as the
    /// nearest that is in range, with a warning in the log; [`check`](Self::check) first for an
    /// error instead.
    #[must_use]
    pub fn engine(&self) -> Box<dyn BroadPhase> {
        match self {
            Self::Auto => Box::new(Auto::default()),
            Self::LinearOctree => Box::new(LinearOctree::default()),
            Self::ObjectOctree(settings) => Box::new(ObjectOctree::new(settings.clamped())),
            Self::Exhaustive => Box::new(Exhaustive::default()),
        }
    }
}

impl fmt::Display for BroadPhaseMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Auto => "auto",
            Self::LinearOctree => "linear",
            Self::ObjectOctree(_) => "object",
            Self::Exhaustive => "exhaustive",
        })
    }
}

/// The error of a name that is that of no [`BroadPhaseMethod`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("unknown method `{0}`: expected `auto`, `linear`, `object` or `exhaustive`")]
pub struct UnknownMethod(pub String);

impl FromStr for BroadPhaseMethod {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name.to_ascii_lowercase().as_str() {
            "auto" => Ok(Self::Auto),
            "linear" => Ok(Self::LinearOctree),
            "object" => Ok(Self::ObjectOctree(ObjectOctreeSettings::default())),
            "exhaustive" => Ok(Self::Exhaustive),
            _ => Err(UnknownMethod(name.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::reflect::TypePath;

    use super::*;
    use crate::broad_phase::{Pair, PairFilter, PairKinds, PairSearch, ProxyId, RootPolicy};

    /// What is saved by reflection is found again wherever the types' files are.
    #[test]
    fn reflected_paths_are_those_that_users_write() {
        let paths = [
            BroadPhaseMethod::type_path(),
            ObjectOctreeSettings::type_path(),
            RootPolicy::type_path(),
            Pair::type_path(),
            PairFilter::type_path(),
            PairKinds::type_path(),
            PairSearch::type_path(),
            ProxyId::type_path(),
        ];
        for path in paths {
            let name = path.strip_prefix("bevy_octree::").unwrap();
            assert!(!name.contains("::"), "{path}");
        }
    }

    #[test]
    fn names_go_in_and_out() {
        let octree = BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::default());
        for method in [
            BroadPhaseMethod::Auto,
            BroadPhaseMethod::LinearOctree,
            octree,
            BroadPhaseMethod::Exhaustive,
        ] {
            assert_eq!(method.to_string().to_uppercase().parse(), Ok(method));
        }
        let error = "quadtree".parse::<BroadPhaseMethod>().unwrap_err();
        assert!(error.to_string().contains("`quadtree`"));
    }
}
