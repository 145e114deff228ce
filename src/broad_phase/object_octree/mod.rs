//! The report's N-objects octree, over moving boxes.
//!
//! A cube of space, the *root*, is divided into eight, and each part again, until no leaf lists
//! more than N objects (Swan 1994, section 2.2, after Shaffer and Herb). An object is listed in
//! every leaf that its box overlaps, so that two boxes overlap only if a leaf lists both. As
//! objects move, they leave leaves and enter others; leaves that come to list more than N objects
//! split, and eight that list no more than N between them merge (section 2.4).
//!
//! ```
//! use bevy::math::{Vec3, bounding::Aabb3d};
//! use bevy_octree::broad_phase::{BroadPhaseMethod, ObjectOctreeSettings, SpatialIndex};
//!
//! let mut index = SpatialIndex::new(&BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(2)));
//! for x in [-4.0, -2.0, 3.0] {
//!     index.insert(Aabb3d::new(Vec3::new(x, 1.0, 1.0), Vec3::splat(0.5)))?;
//! }
//! index.update();
//! assert_eq!(index.stats().nodes, 9); // three objects are more than two: the root has split
//! # Ok::<(), bevy_octree::broad_phase::BoxError>(())
//! ```
//!
//! # What holds
//!
//! 1. **Tiling.** Leaves tile space. A cell holds its lower borders and not its upper ones; the
//!    outermost cells reach to infinity, so that no box is ever outside, and an object is listed in
//!    exactly the leaves that its box overlaps.
//! 2. **N objects.** A leaf lists at most N objects unless it is at the depth limit. The limit is a
//!    [generation](ObjectOctreeSettings::max_depth), and the objects' own size: a cell is at its
//!    limit for an object that is larger than the cell (by its longest side), for splitting it
//!    would only list that object again in most of its children. Such objects are listed, and not
//!    counted. Without this rule, N + 1 boxes in one spot would split every cell along their
//!    borders down to the last generation, and memory would not be linear.
//! 3. **Canonical shape.** After an update the tree equals, node for node, the tree built from
//!    scratch over the same boxes and root (with a [merge slack](ObjectOctreeSettings::merge_slack)
//!    of 0): a node is split if, and only if, it is above the depth limit and more than N objects
//!    that fit in it overlap it.
//! 4. **The root.** It starts as 150 % of the bounding box of all objects and doubles toward an
//!    object that leaves it. When searches and maintenance have cost far more than a look at all
//!    objects, it is seen whether it still fits: where it is four times as large as the objects
//!    need or more, or may not double any more and leaves out more than one in eight, it is laid
//!    anew. So neither does an excursion spoil it for good, nor is it laid anew at each step across
//!    its border.
//!
//! [`ObjectOctree::assert_well_formed`] checks the first three.
//!
//! # Cost
//!
//! An update looks at the objects that moved and at no others. One comparison of a box with its
//! *stay region*, the region within which its list of leaves cannot change, spares most of them any
//! further work. Those that are left visit their leaves, and whatever is below the lowest node that
//! holds all of the box. Each node counts the objects that overlap it, so that whether eight leaves
//! merge is known without a look at their lists.
//!
//! Pairs, and answers to queries, come from one of [two structures](PairSearch):
//!
//! - By default, from the blocks of a [pointerless octree](super::linear_octree) over the same boxes,
//!   which the tree keeps beside it: objects in the order of space, boxes eight side by side, skins
//!   that last several ticks. The search takes what it takes there; the tree costs its upkeep.
//! - As in the report, from the leaves that list an object that moved: its box is compared with
//!   eight others at a time. This takes less memory, and more time.
//!
//! A leaf lists at most N objects that fit in it, and beside them every larger one that overlaps
//! it, or all that share a cell at the depth limit: rods side by side, plates upon plates, and
//! scenes of which the root is more than 2^[`max_depth`](ObjectOctreeSettings::max_depth) times as
//! large as what is in them are not told apart by cells. Where leaves are searched, and 512 objects
//! or more that move share one, they are therefore put in order before they are compared, as in the
//! linear octree: a leaf of n objects takes O(n log n) and its pairs, not n². Lists take memory for
//! each leaf that an object overlaps: at most eight for one that is smaller than the leaves around
//! it; a large one is listed in each of the small leaves that smaller objects have brought about
//! within it. Pairs that filters rule out take none.
//!
//! # When to use it
//!
//! For its shape: leaves tile space, and how deep they lie says where objects crowd, whatever the
//! history; with [`tree`](ObjectOctree::tree) and [`leaves_of`](ObjectOctree::leaves_of) that is a
//! map to build on. For speed alone, prefer the [linear octree](super::LinearOctree), which this
//! one's upkeep comes on top of: together 1.2 to 2.1 times its time at 1 000 and 8 000 objects, up
//! to 2.4 times at 64 000.

mod cell;
mod maintain;
mod octree;
mod pairs;
mod restructure;
mod root;
mod root_cell;
mod settings;
mod stay;
mod validate;

#[cfg(test)]
mod tests;

pub use cell::Cell;
pub use octree::ObjectOctree;
pub use settings::{ObjectOctreeSettings, PairSearch, RootPolicy, SettingsError};
