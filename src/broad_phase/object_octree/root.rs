//! When the root is laid, grows, and is laid anew.

use super::{
    cell::Cell,
    octree::{Entry, ObjectOctree},
    root_cell::{RootCell, bounding_box},
    stay::StayRegion,
};
use crate::{broad_phase::proxy::Proxies, octree::NodeId};

/// How much more work than one look at each object there must have been before it is seen again
/// whether the root fits. A unit is about what it takes to compare two boxes.
const WORK_PER_LOOK: u64 = 1024;

/// How much of that is the turn of an object that moved.
const WORK_PER_TURN: u64 = 8;

/// The root is laid anew where that makes it so many times smaller: two doublings, so that an
/// object that wanders to and fro across its border does not have it laid anew each time.
const TOO_LARGE: f32 = 4.0;

/// It is laid anew too where more than one object in so many lies beyond it, since it may not
/// double any more, and fewer would then.
const SHARE_BEYOND: usize = 8;

impl ObjectOctree {
    /// Sees to the root before objects take their turns: lays it, grows it, or forgets it. True if
    /// the tree was emptied for that, and all objects must be entered anew.
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
            // Doublings get rarer as the root grows, so that beginning anew costs little in the
            // long run.
            Some(mut root) => {
                if root.doublings < self.settings.max_doublings {
                    for object in &self.restless {
                        let aabb = &proxies.boxes()[*object as usize];
                        root.grow_to(aabb, self.settings.max_doublings);
                    }
                }
                if self.work > WORK_PER_LOOK * proxies.len() as u64 {
                    self.work = 0;
                    let fitting = self.fitting_root(proxies);
                    let leaves_out_many = |root: &RootCell| {
                        let beyond = proxies
                            .iter()
                            .filter(|(_, aabb)| !root.contains(aabb))
                            .count();
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
        self.entries.fill(Entry::ABSENT);
        self.stays.fill(StayRegion::NOWHERE);
        self.levels.fill(0);
        for node in self.tree.subtree(NodeId::ROOT).collect::<Vec<_>>() {
            let list = self.tree.data_mut(node).take_list();
            self.recycle(list);
        }
        let mut cell = self.root.map_or_else(Cell::default, |root| {
            Cell::root(root.center, root.half_size)
        });
        cell.put_list(self.spare.pop().unwrap_or_default());
        self.tree.reset(cell);
    }
}
