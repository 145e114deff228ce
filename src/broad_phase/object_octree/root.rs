//! The root cell: how it is laid, and how it grows.

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{Cell, Entry, ObjectOctree, ObjectOctreeSettings, RootPolicy};
use crate::{broad_phase::Proxies, octree::NodeId};

/// A cube, and how often it has doubled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RootCell {
    center: Vec3A,
    half_size: f32,
    doublings: u32,
}

impl RootCell {
    /// Half sizes end here, so that no arithmetic on cells overflows.
    const LARGEST: f32 = f32::MAX / 8.0;

    /// Lays the root around the bounding box of the first objects.
    fn lay(policy: RootPolicy, bounds: &Aabb3d) -> Self {
        match policy {
            RootPolicy::Cube { center, half_size } => {
                Self { center: center.into(), half_size: half_size.min(Self::LARGEST), doublings: 0 }
            }
            RootPolicy::Fit { scale } => {
                // Halves first: the difference of two large numbers may overflow.
                let center = bounds.min * 0.5 + bounds.max * 0.5;
                let half_extent = (bounds.max * 0.5 - bounds.min * 0.5).max_element();
                // Objects in a single point, or as good as, get a root that still divides.
                let smallest = center.abs().max_element() * f32::EPSILON * 1024.0;
                let half_size = match (half_extent * scale).max(smallest) {
                    0.0 => 1.0,
                    half_size => half_size.min(Self::LARGEST),
                };
                Self { center, half_size, doublings: 0 }
            }
        }
    }

    pub(super) fn bounds(&self) -> Aabb3d {
        Aabb3d { min: self.center - self.half_size, max: self.center + self.half_size }
    }

    fn contains(&self, aabb: &Aabb3d) -> bool {
        let bounds = self.bounds();
        aabb.min.cmpge(bounds.min).all() && aabb.max.cmple(bounds.max).all()
    }

    /// Doubles toward a box until the root contains it or the limit is reached. Each doubling keeps the old cube as
    /// one of the eight children of the new.
    fn grow_to(&mut self, aabb: &Aabb3d, max_doublings: u32) {
        while self.doublings < max_doublings && self.half_size < Self::LARGEST && !self.contains(aabb) {
            let downward = aabb.min.cmplt(self.bounds().min);
            self.center += Vec3A::select(downward, Vec3A::splat(-self.half_size), Vec3A::splat(self.half_size));
            self.half_size *= 2.0;
            self.doublings += 1;
        }
    }

    /// In how many generations, from the root down, is a cell at least as large as the box's longest side?
    #[inline]
    pub(super) fn levels(&self, aabb: &Aabb3d, settings: &ObjectOctreeSettings) -> u32 {
        let half_extent = (aabb.max * 0.5 - aabb.min * 0.5).max_element();
        let ratio = self.half_size / half_extent;
        if ratio >= 1.0 {
            // The exponent is the number of halvings; for a box without extent it is that of infinity.
            ((ratio.to_bits() >> 23) - 126).min(settings.max_depth + 1)
        } else {
            0
        }
    }
}

/// How much more work than one look at each object there must have been before it is seen again whether the root fits. A
/// unit is about what it takes to compare two boxes.
const WORK_PER_LOOK: u64 = 1024;

/// How much of that is the turn of an object that moved.
const WORK_PER_TURN: u64 = 8;

/// The root is laid anew where that makes it so many times smaller: two doublings, so that an object that wanders to and
/// fro across its border does not have it laid anew each time.
const TOO_LARGE: f32 = 4.0;

/// It is laid anew too where more than one object in so many lies beyond it, since it may not double any more, and fewer
/// would then.
const SHARE_BEYOND: usize = 8;

impl ObjectOctree {
    /// Sees to the root before objects move: lays it, grows it, or forgets it. True if the tree was emptied for that,
    /// and all objects must be entered anew.
    pub(super) fn fit_root(&mut self, proxies: &Proxies) -> bool {
        if proxies.is_empty() {
            let planted = self.root.take().is_some();
            if planted {
                self.plant();
            }
            return planted;
        }
        self.work += WORK_PER_TURN * proxies.moved().len() as u64;
        let before = self.root;
        let root = match before {
            None => self.fitting_root(proxies),
            // Doublings get rarer as the root grows, so that beginning anew costs little in the long run.
            Some(mut root) => {
                if root.doublings < self.settings.max_doublings {
                    for aabb in proxies.moved().iter().filter_map(|id| proxies.get(*id)) {
                        root.grow_to(aabb, self.settings.max_doublings);
                    }
                }
                if self.work > WORK_PER_LOOK * proxies.len() as u64 {
                    self.work = 0;
                    let fitting = self.fitting_root(proxies);
                    let leaves_out_many = |root: &RootCell| {
                        let beyond = proxies.iter().filter(|(_, aabb)| !root.contains(aabb)).count();
                        beyond * SHARE_BEYOND > proxies.len()
                    };
                    let is_too_large = fitting.half_size * TOO_LARGE <= root.half_size;
                    if is_too_large || (leaves_out_many(&root) && !leaves_out_many(&fitting)) {
                        root = fitting;
                    }
                }
                root
            }
        };
        let changed = before != Some(root);
        if changed {
            self.root = Some(root);
            self.plant();
        }
        changed
    }

    /// The root as it would be laid now.
    fn fitting_root(&self, proxies: &Proxies) -> RootCell {
        let everything = bounding_box(proxies.iter().map(|(_, aabb)| aabb));
        let mut root = RootCell::lay(self.settings.root, &everything);
        root.grow_to(&everything, self.settings.max_doublings);
        root
    }

    /// Empties the tree, down to a root that lists nothing.
    pub(super) fn plant(&mut self) {
        for entry in &mut self.entries {
            *entry = Entry::ABSENT;
        }
        for node in self.tree.subtree(NodeId::ROOT).collect::<Vec<_>>() {
            let list = self.tree.data_mut(node).take_list();
            self.recycle(list);
        }
        let mut cell = self.root.map_or_else(Cell::default, |root| Cell::root(root.center, root.half_size));
        cell.put_list(self.spare.pop().unwrap_or_default(), 0);
        self.tree.reset(cell);
    }
}

/// The smallest box around some boxes; inverted if there are none.
fn bounding_box<'a>(boxes: impl Iterator<Item = &'a Aabb3d>) -> Aabb3d {
    boxes.fold(Aabb3d { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY }, |sum, aabb| Aabb3d {
        min: sum.min.min(aabb.min),
        max: sum.max.max(aabb.max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec3;

    fn lay(bounds: &Aabb3d) -> RootCell {
        RootCell::lay(RootPolicy::default(), bounds)
    }

    #[test]
    fn the_root_is_half_as_large_again_as_the_bounding_box() {
        let root = lay(&Aabb3d::new(Vec3::new(3.0, 0.0, 0.0), Vec3::new(4.0, 1.0, 2.0)));
        assert_eq!(root.bounds(), Aabb3d::new(Vec3::new(3.0, 0.0, 0.0), Vec3::splat(6.0)));
    }

    #[test]
    fn the_root_doubles_toward_what_leaves_it() {
        let mut root = lay(&Aabb3d::new(Vec3::ZERO, Vec3::splat(2.0)));
        let old = root.bounds();
        let leaver = Aabb3d::new(Vec3::new(-7.0, 2.0, 0.0), Vec3::splat(0.5));
        root.grow_to(&leaver, 16);
        assert_eq!(root.doublings, 1);
        assert_eq!(root.bounds(), Aabb3d { min: Vec3A::new(-9.0, -3.0, -3.0), max: Vec3A::new(3.0, 9.0, 9.0) });
        assert!(root.contains(&old) && root.contains(&leaver));
        root.grow_to(&Aabb3d::new(Vec3::splat(1e30), Vec3::ONE), 5);
        assert_eq!(root.doublings, 5);
    }

    #[test]
    fn a_point_and_the_largest_numbers_have_roots_too() {
        let point = lay(&Aabb3d { min: Vec3A::ZERO, max: Vec3A::ZERO });
        assert!(point.half_size > 0.0);
        let vast = lay(&Aabb3d { min: Vec3A::MIN, max: Vec3A::MAX });
        assert!(vast.half_size.is_finite() && vast.bounds().max.is_finite());
    }

    #[test]
    fn levels_count_the_generations_that_an_object_fits_in() {
        let root = lay(&Aabb3d::new(Vec3::ZERO, Vec3::splat(4.0 / 1.5)));
        let settings = ObjectOctreeSettings::default();
        let levels = |side: f32| root.levels(&Aabb3d::new(Vec3::ZERO, Vec3::splat(side * 0.5)), &settings);
        assert_eq!(root.half_size, 4.0);
        assert_eq!([16.0, 8.0, 5.0, 4.0, 1.0].map(levels), [0, 1, 1, 2, 4]);
        assert_eq!(levels(0.0), settings.max_depth + 1);
    }
}
