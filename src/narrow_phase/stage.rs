//! The stages of the decision, and the counters that tell what each of them does.

use std::ops::{AddAssign, Index, IndexMut};

use bevy::prelude::Reflect;

/// A stage of the chain of decisions, from cheap to complete.
///
/// Each rejects only pairs which every later stage would reject too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// Diverging axis-aligned boxes. Rejects only.
    Bounds,
    /// Bounding spheres. Rejects; accepts two spheres, whose decision is complete here.
    Spheres,
    /// Oriented boxes by separating axes, and the closest point of a box to a sphere. Rejects;
    /// accepts cuboids and spheres that overlap.
    Boxes,
    /// Every edge of one mesh against every polygon of the other, both ways, as far as these are near
    /// each other, then the test whether one is inside the other; or the distance of what the two
    /// consist of, if one is a Rapier shape. Decides all that is left.
    Complete,
}

impl Stage {
    /// All stages, in the order in which a pair meets them.
    pub const ALL: [Self; 4] = [Self::Bounds, Self::Spheres, Self::Boxes, Self::Complete];
}

/// The numbers of pairs that came to a stage and that left the chain there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[type_path = "bevy_octree"]
pub struct StageCount {
    /// Pairs that the stage has tested.
    pub reached: u64,
    /// Pairs found to be apart.
    pub rejected: u64,
    /// Pairs found to be in contact.
    pub accepted: u64,
}

impl StageCount {
    /// Returns how many pairs were passed on to the next stage.
    #[must_use]
    pub fn passed(&self) -> u64 {
        self.reached - self.rejected - self.accepted
    }
}

impl AddAssign for StageCount {
    fn add_assign(&mut self, other: Self) {
        self.reached += other.reached;
        self.rejected += other.rejected;
        self.accepted += other.accepted;
    }
}

/// A [`StageCount`] for each [`Stage`].
///
/// A stage that cannot help is skipped and not counted: two cuboids turned alike go to
/// [`Stage::Boxes`] at once, where they cost no more than bounds would; a pair with an unbounded
/// shape goes to [`Stage::Complete`]; a pair that is not finite may go nowhere.
///
/// ```
/// use bevy_octree::narrow_phase::{Stage, StageCounters};
///
/// let mut total = StageCounters::default();
/// let mut task = StageCounters::default();
/// task[Stage::Spheres].reached = 2;
/// total += task;
/// assert_eq!(total[Stage::Spheres].passed(), 2);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[type_path = "bevy_octree"]
pub struct StageCounters([StageCount; 4]);

impl StageCounters {
    /// Counts a pair that came to a stage. Returns the verdict there: `None` if the pair passes on.
    #[inline]
    pub(super) fn count(&mut self, stage: Stage, verdict: Option<bool>) -> Option<bool> {
        let count = &mut self[stage];
        count.reached += 1;
        count.rejected += u64::from(verdict == Some(false));
        count.accepted += u64::from(verdict == Some(true));
        verdict
    }

    /// Returns how many pairs were found to be in contact, whatever the stage.
    #[must_use]
    pub fn accepted(&self) -> u64 {
        self.0.iter().map(|count| count.accepted).sum()
    }

    /// Returns how many pairs were found to be apart, whatever the stage.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.0.iter().map(|count| count.rejected).sum()
    }
}

impl Index<Stage> for StageCounters {
    type Output = StageCount;

    #[inline]
    fn index(&self, stage: Stage) -> &StageCount {
        &self.0[stage as usize]
    }
}

impl IndexMut<Stage> for StageCounters {
    #[inline]
    fn index_mut(&mut self, stage: Stage) -> &mut StageCount {
        &mut self.0[stage as usize]
    }
}

impl AddAssign for StageCounters {
    fn add_assign(&mut self, other: Self) {
        for stage in Stage::ALL {
            self[stage] += other[stage];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_is_counted_once_per_stage() {
        let mut counters = StageCounters::default();
        counters.count(Stage::Bounds, None);
        counters.count(Stage::Bounds, Some(false));
        counters.count(Stage::Spheres, Some(true));
        assert_eq!(counters[Stage::Bounds].passed(), 1);
        assert_eq!((counters.accepted(), counters.rejected()), (1, 1));
        let mut twice = counters;
        twice += counters;
        assert_eq!(twice[Stage::Bounds].reached, 4);
        assert_eq!(twice[Stage::Complete], StageCount::default());
    }
}
