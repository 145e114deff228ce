//! The settings of the N-objects octree.

use bevy::prelude::*;
use thiserror::Error;

/// How the root cell of an [`ObjectOctree`](super::ObjectOctree) is laid.
#[derive(Clone, Copy, Debug, Reflect)]
#[type_path = "bevy_octree"]
pub enum RootPolicy {
    /// A cube around the centre of the bounding box of all objects, its side this multiple of the
    /// box's longest side. The report's heuristic is 1.5.
    Fit {
        /// Side of the root over the longest side of the bounding box; at least 1.
        scale: f32,
    },
    /// A cube that the user lays, where the extent of the scene is known.
    Cube {
        /// Its centre.
        center: Vec3,
        /// Half its side; more than 0.
        half_size: f32,
    },
}

/// A number that is not one is equal to itself: settings that stay the same are the same.
impl PartialEq for RootPolicy {
    fn eq(&self, other: &Self) -> bool {
        let same = |a: f32, b: f32| a == b || (a.is_nan() && b.is_nan());
        match (*self, *other) {
            (Self::Fit { scale: a }, Self::Fit { scale: b }) => same(a, b),
            (
                Self::Cube {
                    center: a,
                    half_size: r,
                },
                Self::Cube {
                    center: b,
                    half_size: s,
                },
            ) => {
                same(r, s)
                    && a.to_array()
                        .into_iter()
                        .zip(b.to_array())
                        .all(|(a, b)| same(a, b))
            }
            (Self::Fit { .. }, Self::Cube { .. }) | (Self::Cube { .. }, Self::Fit { .. }) => false,
        }
    }
}

impl Default for RootPolicy {
    fn default() -> Self {
        Self::Fit { scale: 1.5 }
    }
}

/// In what an [`ObjectOctree`](super::ObjectOctree) looks for pairs, and for the answers to queries.
/// These are the same either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[type_path = "bevy_octree"]
pub enum PairSearch {
    /// In the blocks of a pointerless octree over the same boxes, which is kept beside the tree: the
    /// pairs take the time that they take with [`LinearOctree`](crate::broad_phase::LinearOctree),
    /// and the tree its upkeep.
    #[default]
    Blocks,
    /// In the leaves of the tree, one after the other, as in the report (Swan 1994, section 2.3).
    /// Takes less memory, and two to four times as long.
    Leaves,
}

/// The parameters of an [`ObjectOctree`](super::ObjectOctree).
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub struct ObjectOctreeSettings {
    /// The report's N: a leaf that lists more objects than this splits, unless it is at the depth
    /// limit. At least 1.
    ///
    /// Small values make many small leaves, and a fine map of where objects crowd; large ones are
    /// cheaper to keep, for objects cross fewer borders. With 8 000 boxes of the scenes in
    /// [`stress`](crate::scene::stress), 64 takes 1.1 to 1.6 times, and 128 takes 1.0 to 1.3 times
    /// what the default, 256, does. Where [leaves are searched](PairSearch::Leaves), boxes are
    /// compared eight at a time, and 64 to 128 are best.
    pub max_objects: u32,
    /// The depth limit: no node has a generation above this. From 1 to
    /// [`MAX_DEPTH`](Self::MAX_DEPTH).
    ///
    /// Without it, objects in one spot would split for ever.
    pub max_depth: u32,
    /// How the root cell is laid.
    pub root: RootPolicy,
    /// How often the root cell may double toward objects that leave it, since it was laid. Objects
    /// beyond the root are still found: they are listed in the outermost cells, which reach to
    /// infinity. The bound keeps a single runaway from making the root so large that all others
    /// share a few cells at the depth limit. When the objects need no more than a quarter of the
    /// root any longer, or more than an eighth of them are beyond it, the root is [laid
    /// anew](super#what-holds).
    pub max_doublings: u32,
    /// Eight leaves merge when they list at most `max_objects - merge_slack` distinct objects
    /// between them. With a slack above 0, objects that wander to and fro across a border do not
    /// split and merge the same nodes at each crossing; the tree then depends on its history. Below
    /// `max_objects`.
    pub merge_slack: u32,
    /// In what pairs are looked for. An engine that is at work does not change it: install another.
    pub search: PairSearch,
}

impl Default for ObjectOctreeSettings {
    fn default() -> Self {
        Self {
            max_objects: 256,
            max_depth: 16,
            root: RootPolicy::default(),
            max_doublings: 16,
            merge_slack: 0,
            search: PairSearch::default(),
        }
    }
}

impl ObjectOctreeSettings {
    /// The largest depth limit: an `f32` tells no more than 2²⁴ cells apart along an axis.
    pub const MAX_DEPTH: u32 = 24;

    /// Returns the defaults, with another N.
    #[must_use]
    pub fn with_max_objects(max_objects: u32) -> Self {
        Self {
            max_objects,
            ..Self::default()
        }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// Names the setting that is out of range, its value, and the range.
    pub fn check(&self) -> Result<(), SettingsError> {
        if self.max_objects == 0 {
            return Err(SettingsError::MaxObjects);
        }
        if !(1..=Self::MAX_DEPTH).contains(&self.max_depth) {
            return Err(SettingsError::MaxDepth(self.max_depth));
        }
        if self.merge_slack >= self.max_objects {
            return Err(SettingsError::MergeSlack {
                slack: self.merge_slack,
                max_objects: self.max_objects,
            });
        }
        match self.root {
            RootPolicy::Fit { scale } if !(scale.is_finite() && scale >= 1.0) => {
                Err(SettingsError::RootScale(scale))
            }
            RootPolicy::Cube { center, half_size }
                if !(center.is_finite() && half_size.is_finite() && half_size > 0.0) =>
            {
                Err(SettingsError::RootCube { center, half_size })
            }
            _ => Ok(()),
        }
    }

    /// Returns the nearest settings that pass the [`check`](Self::check), with a warning in the log
    /// for what was out of range.
    #[must_use]
    pub fn clamped(&self) -> Self {
        let mut settings = *self;
        while let Err(error) = settings.check() {
            tracing::warn!("{error}; the nearest allowed value is used");
            match error {
                SettingsError::MaxObjects => settings.max_objects = 1,
                SettingsError::MaxDepth(depth) => {
                    settings.max_depth = depth.clamp(1, Self::MAX_DEPTH);
                }
                SettingsError::MergeSlack { .. } => settings.merge_slack = settings.max_objects - 1,
                SettingsError::RootScale(scale) if scale < 1.0 => {
                    settings.root = RootPolicy::Fit { scale: 1.0 }
                }
                SettingsError::RootScale(_) | SettingsError::RootCube { .. } => {
                    settings.root = RootPolicy::default();
                }
            }
        }
        settings
    }
}

/// A setting of the N-objects octree that is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SettingsError {
    /// N is 0.
    #[error("max_objects is 0: a leaf must be able to list at least 1 object")]
    MaxObjects,
    /// The depth limit is 0 or too large.
    #[error("max_depth is {0}: expected 1 to {max}", max = ObjectOctreeSettings::MAX_DEPTH)]
    MaxDepth(u32),
    /// The slack leaves nothing to merge.
    #[error("merge_slack is {slack}: expected less than max_objects, which is {max_objects}")]
    MergeSlack {
        /// The slack given.
        slack: u32,
        /// N.
        max_objects: u32,
    },
    /// The root would not hold all objects, or be infinite.
    #[error("the root's scale is {0}: expected a finite number, at least 1")]
    RootScale(f32),
    /// The root is no cube.
    #[error(
        "the root cube has the centre {center} and half size {half_size}: expected finite numbers, half size above 0"
    )]
    RootCube {
        /// The centre given.
        center: Vec3,
        /// The half size given.
        half_size: f32,
    },
}

#[cfg(test)]
mod tests;
