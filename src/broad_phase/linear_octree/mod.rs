//! The pointerless octree: a sorted array instead of a tree of nodes.
//!
//! The boxes are put in order along a space-filling curve, which visits an octant of space before
//! it goes on to the next, at every scale. Eight boxes that follow each other make a *block*; the
//! bounds of eight blocks make a block one level up, and so on. Where a block's parent and children
//! are follows from its position: there are no pointers, and one box is compared with the eight of
//! a block by a few vector instructions. (The report mentions pointerless octrees, Swan 1994,
//! section 2, after Samet 1990.)
//!
//! ```
//! use bevy::math::{Vec3, bounding::Aabb3d};
//! use bevy_octree::broad_phase::{BroadPhaseMethod, SpatialIndex};
//!
//! let mut index = SpatialIndex::new(&BroadPhaseMethod::LinearOctree);
//! for x in 0..1000 {
//!     index.insert(Aabb3d::new(Vec3::X * x as f32, Vec3::splat(0.5)))?;
//! }
//! index.update();
//! assert_eq!(index.find_pairs().len(), 999); // each touches the next
//! # Ok::<(), bevy_octree::broad_phase::BoxError>(())
//! ```
//!
//! # What makes it fast
//!
//! - **Skins.** What is indexed is not the box but its *skin*: the box swept along its recent
//!   motion for some ticks ahead. While an object stays in its skin, the index stays as it is, and
//!   so does the list of *near pairs*, those whose skins overlap; a tick then compares the boxes of
//!   near pairs, and nothing else. How far ahead is chosen from the speeds: where many are fast,
//!   none has a skin, and near pairs are then the pairs themselves. A few that are much faster than
//!   others have none, and are kept at the end, apart from these.
//! - **Sorted seldom.** When more than a share of the objects have left their skins, all get new
//!   ones, in their old order: neighbours mostly stay neighbours. Only when the bounds of blocks
//!   have become so loose that searching them has cost as much as sorting would are all objects put
//!   in order anew. Each block is compared with itself as it was after the last sort, so that a few
//!   objects of any size, anywhere, do not hide what has become of all others.
//! - **Halved where it lasts.** Along the curve, blocks high up are of odd forms, into which all
//!   queries go. What has come and rests is halved again and again instead, which takes longer, once;
//!   of what moves within skins, blocks are halved, which are an eighth as many.
//! - **No branches.** The tree is joined with itself level by level, and objects that left their
//!   skins go down the tree side by side. One comparison gives the verdict on eight boxes as a
//!   mask; a table turns the mask into a list of those to look at next. Branches on single verdicts
//!   would be mispredicted at every other one, and cost more than all else.
//! - **What rests costs nothing.** Near pairs are kept only of objects that move.
//! - **The order in memory is the order in space.** Boxes are gathered in the order of the curve
//!   once a tick, many at a time; all else finds its neighbours in the cache.
//! - **Sizes apart.** Objects four times smaller than others are sorted apart from them, so that a
//!   large box does not blow up the bounds of a block of small ones. So are a few that are far away
//!   from most, for which the cells of the curve would have to be large.
//! - **All threads.** With the feature `multi_threaded`, each step is divided into jobs for the
//!   threads of Bevy's `ComputeTaskPool`. The pairs come in the same order at any number of
//!   threads.

mod apart;
mod compare;
mod crowd;
mod follow;
mod join;
pub(super) mod levels;
mod list;
mod looseness;
mod near;
mod neighbors;
mod octree;
pub(super) mod order;
pub(super) mod query;
mod skin;
mod upkeep;
mod validate;

#[cfg(test)]
mod outlier_tests;
#[cfg(test)]
mod tests;

pub(super) use crowd::Crowd;
pub(super) use neighbors::NeighborBuffers;
pub use octree::LinearOctree;
