//! The broad phase that chooses by itself.

use super::{
    engine::{BroadPhase, BroadPhaseStats, Leaf, Visitor},
    exhaustive::Exhaustive,
    linear_octree::LinearOctree,
    pairs::Pair,
    proxy::Proxies,
};

/// With more objects than this, a sorted index is worth its upkeep.
const MANY: usize = 64;

/// With fewer than this, it no longer is. Apart from [`MANY`], so that objects that come and go do
/// not change the method at each tick.
const FEW: usize = 48;

/// [`Exhaustive`] search for a handful of objects, a [`LinearOctree`] beyond.
#[derive(Debug, Default)]
pub struct Auto {
    exhaustive: Exhaustive,
    linear: Option<LinearOctree>,
}

impl Auto {
    fn engine(&self) -> &dyn BroadPhase {
        match &self.linear {
            Some(linear) => linear,
            None => &self.exhaustive,
        }
    }
}

impl BroadPhase for Auto {
    /// The name of the method chosen.
    fn name(&self) -> &'static str {
        self.engine().name()
    }

    fn maintain(&mut self, proxies: &Proxies) {
        match &mut self.linear {
            Some(_) if proxies.len() < FEW => self.linear = None,
            Some(linear) => linear.maintain(proxies),
            None if proxies.len() > MANY => self
                .linear
                .insert(LinearOctree::default())
                .maintain(proxies),
            None => {}
        }
    }

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        match &mut self.linear {
            Some(linear) => linear.find_pairs(proxies, pairs),
            None => self.exhaustive.find_pairs(proxies, pairs),
        }
    }

    fn asks_filters(&self) -> bool {
        self.engine().asks_filters()
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        self.engine().traverse(proxies, visitor);
    }

    fn for_each_leaf(&self, found: &mut dyn FnMut(Leaf)) {
        self.engine().for_each_leaf(found);
    }

    fn inner(&self) -> Option<&dyn BroadPhase> {
        Some(self.engine())
    }

    fn stats(&self) -> BroadPhaseStats {
        self.engine().stats()
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{Vec3, bounding::Aabb3d};

    use super::*;
    use crate::broad_phase::checked::Checked;

    #[test]
    fn the_method_follows_the_number_of_objects() {
        let mut checked = Checked::new(Box::new(Auto::default()));
        let mut names = Vec::new();
        let mut ids = Vec::new();
        for (count, step) in [(10, 3), (100, 30), (50, 25), (10, 10), (70, 15)] {
            while ids.len() != count {
                for _ in 0..step.min(ids.len().abs_diff(count)) {
                    if ids.len() < count {
                        let at = Vec3::X * (ids.len() as f32 * 0.75);
                        ids.push(
                            checked
                                .index
                                .insert(Aabb3d::new(at, Vec3::splat(0.5)))
                                .unwrap(),
                        );
                    } else {
                        checked.index.remove(ids.pop().unwrap());
                    }
                }
                checked.step();
            }
            names.push(checked.index.engine().name());
        }
        assert_eq!(
            names,
            ["exhaustive", "linear", "linear", "exhaustive", "linear"]
        );
    }
}
