//! The names of the scenes.

use std::{fmt, str::FromStr};

use thiserror::Error;

/// A rule by which boxes move: see the [module's documentation](super) for figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StressScene {
    /// Cubes in random motion: everything moves, and little changes from tick to tick.
    Brownian,
    /// Cubes fall onto a floor, pile up and rest.
    Freefall,
    /// Cubes fly about a moving attractor: everything moves fast.
    Gravity,
    /// The report's planes of cubes: everything moves, and next to nothing meets.
    Planes,
    /// Nine cubes in ten never move.
    Static90,
    /// Sides from 1 to 1 000.
    Sizes,
    /// Nine cubes in ten share a hundredth of the space.
    Clusters,
    /// Cubes in random motion over a ground that is much larger than all of them.
    Ground,
    /// Cubes in random motion, one of which goes far away.
    Outlier,
    /// Cubes in random motion, in rooms far from each other.
    Rooms,
}

impl StressScene {
    /// All scenes.
    pub const ALL: [Self; 10] = [
        Self::Brownian,
        Self::Freefall,
        Self::Gravity,
        Self::Planes,
        Self::Static90,
        Self::Sizes,
        Self::Clusters,
        Self::Ground,
        Self::Outlier,
        Self::Rooms,
    ];

    /// Returns the name in lower case, by which [`FromStr`] knows the scene.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Brownian => "brownian",
            Self::Freefall => "freefall",
            Self::Gravity => "gravity",
            Self::Planes => "planes",
            Self::Static90 => "static90",
            Self::Sizes => "sizes",
            Self::Clusters => "clusters",
            Self::Ground => "ground",
            Self::Outlier => "outlier",
            Self::Rooms => "rooms",
        }
    }
}

impl fmt::Display for StressScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The error of a name that is no scene's.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("unknown scene `{0}`: expected one of {names}", names = StressScene::ALL.map(StressScene::name).join(", "))]
pub struct UnknownScene(pub String);

impl FromStr for StressScene {
    type Err = UnknownScene;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let known = Self::ALL
            .into_iter()
            .find(|scene| scene.name().eq_ignore_ascii_case(name));
        known.ok_or_else(|| UnknownScene(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_in_and_out() {
        for scene in StressScene::ALL {
            assert_eq!(scene.to_string().parse(), Ok(scene));
            assert_eq!(scene.to_string().to_uppercase().parse(), Ok(scene));
        }
        let error = "quake".parse::<StressScene>().unwrap_err().to_string();
        assert!(
            error.contains("`quake`") && error.contains("brownian, freefall, gravity"),
            "{error}"
        );
    }
}
