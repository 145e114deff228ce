//! Things in poses, with a tree: what a compound consists of.

use bevy::math::{Isometry3d, Vec3A, bounding::Aabb3d};

use super::box_tree::{Below, BoxTree, Child};
use crate::{broad_phase::StillOctree, narrow_phase::length::length};

/// A thing in its pose, as a part of something.
#[derive(Clone, Debug)]
pub struct Part<S> {
    /// Which one it is of those that were given.
    pub number: u32,
    /// Where it is, in the axes of the whole.
    pub pose: Isometry3d,
    /// What it is.
    pub shape: S,
    /// The middle of the box around it, along the axes of the whole.
    pub center: Vec3A,
    /// Half the sides of that box.
    pub half: Vec3A,
    /// The radius of a ball around that middle, in which it is.
    pub radius: f32,
    /// How far from where it is in the axes of the whole a point of it may be that does not follow a
    /// scale along these; 0 if all do.
    pub stray: f32,
    /// Whether no scale has an effect on it, but for where it is.
    pub is_rigid: bool,
}

impl<S> Part<S> {
    fn aabb(&self) -> Aabb3d {
        Aabb3d {
            min: self.center - self.half,
            max: self.center + self.half,
        }
    }
}

/// Parts in the order of their tree: near ones one after the other.
#[derive(Clone, Debug)]
pub struct Parts<S> {
    parts: Box<[Part<S>]>,
    /// The slot of each, by its number.
    slots: Box<[u32]>,
    tree: StillOctree,
    center: Vec3A,
    half: Vec3A,
    radius: f32,
    stray: f32,
    /// Of those that are rigid.
    rigid_stray: f32,
}

impl<S> Parts<S> {
    /// Puts parts in order, which have their numbers and finite boxes. There is to be one at least.
    pub fn new(parts: Vec<Part<S>>) -> Self {
        debug_assert!(!parts.is_empty(), "the box of nothing is nowhere");
        let boxes: Vec<_> = parts.iter().map(Part::aabb).collect();
        let tree = StillOctree::new(&boxes);
        let mut parts: Vec<_> = parts.into_iter().map(Some).collect();
        let in_order = tree.in_order().iter().map(|index| {
            let part = parts[*index as usize].take();
            part.expect("each is in one slot")
        });
        let in_order: Box<[Part<S>]> = in_order.collect();
        let mut slots = vec![0; in_order.len()].into_boxed_slice();
        for (slot, part) in in_order.iter().enumerate() {
            slots[part.number as usize] = slot as u32;
        }
        let (min, max) = boxes.iter().fold(
            (Vec3A::INFINITY, Vec3A::NEG_INFINITY),
            |(min, max), aabb| (min.min(aabb.min), max.max(aabb.max)),
        );
        // Halving first cannot overflow.
        let center = min * 0.5 + max * 0.5;
        let half = (max - center).max(center - min);
        let reach = |part: &Part<S>| length(part.center - center) + part.radius;
        let radius = in_order.iter().map(reach).fold(0.0, f32::max);
        let furthest = |of: &dyn Fn(&Part<S>) -> bool| {
            let found = in_order.iter().filter(|part| of(part));
            found.map(|part| part.stray).fold(0.0, f32::max)
        };
        let (stray, rigid_stray) = (furthest(&|_| true), furthest(&|part| part.is_rigid));
        Self {
            parts: in_order,
            slots,
            tree,
            center,
            half,
            radius: radius.min(length(half)),
            stray,
            rigid_stray,
        }
    }

    /// How far a part may be beyond its box, once that is scaled: between the least and the largest
    /// of three factors is all that a point may be moved by, away from where its part is.
    pub fn stray_at(&self, scale: Vec3A) -> f32 {
        let size = scale.abs();
        let (largest, least) = (size.max_element(), size.min_element());
        let of_rigid = if scale == Vec3A::ONE {
            0.0
        } else {
            (largest + 1.0) * self.rigid_stray
        };
        ((largest - least) * self.stray).max(of_rigid)
    }

    /// How many there are; at least one.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// The part of a number.
    pub fn get(&self, number: u32) -> Option<&Part<S>> {
        let slot = *self.slots.get(number as usize)?;
        Some(&self.parts[slot as usize])
    }

    /// All parts, by their numbers.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Part<S>> {
        self.slots.iter().map(|slot| &self.parts[*slot as usize])
    }

    /// Centre, half extents and bounding radius.
    pub fn local_bounds(&self) -> (Vec3A, Vec3A, f32) {
        (self.center, self.half, self.radius)
    }

    /// Without what the parts have elsewhere.
    pub fn memory_bytes(&self) -> usize {
        size_of_val::<[_]>(&self.parts) + size_of_val::<[_]>(&self.slots) + self.tree.memory_bytes()
    }
}

/// A block of the tree: how far above those of the parts' boxes, and which one there.
type InTree = (u32, u32);

impl<'a, S> BoxTree for &'a Parts<S> {
    type Node = InTree;
    type Leaf = &'a Part<S>;

    fn top(&self) -> Option<Child<InTree, &'a Part<S>>> {
        Some(Child {
            low: self.center - self.half,
            high: self.center + self.half,
            below: Below::Node((self.tree.height() - 1, 0)),
        })
    }

    #[inline]
    fn for_each_child(
        &self,
        (height, index): InTree,
        mut found: impl FnMut(Child<InTree, &'a Part<S>>),
    ) {
        self.tree.for_each_in_block(height, index, |aabb, below| {
            found(Child {
                low: aabb.min,
                high: aabb.max,
                below: match height {
                    0 => Below::Leaf(&self.parts[below as usize]),
                    _ => Below::Node((height - 1, below)),
                },
            });
        });
    }
}
