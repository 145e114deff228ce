//! What a leaf lists: objects, and their boxes in blocks of eight.

use bevy::math::{BVec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*, u32x8};

use crate::broad_phase::{
    block::{ALL, Block, WIDTH},
    boxes::NOWHERE,
};

/// The bits of a number that say which power of two is below it.
const EXPONENT: u32 = 0x7F80_0000;

/// A number that is the same for two boxes only if they fit in the same generations of cells, given
/// half the side of the root.
#[inline]
pub(super) fn size_class(root_half_size: f32, aabb: &Aabb3d) -> u32 {
    let half_extent = (aabb.max * 0.5 - aabb.min * 0.5).max_element();
    (root_half_size / half_extent).to_bits() & EXPONENT
}

/// The objects of a leaf.
///
/// The boxes are kept here, so that a leaf is searched without a look elsewhere: an object has a
/// copy of its box in each leaf that lists it.
#[derive(Clone, Debug, Default)]
pub(super) struct List {
    objects: Vec<u32>,
    eights: Vec<Eight>,
}

/// Eight objects of a leaf.
#[derive(Clone, Debug)]
pub(super) struct Eight {
    boxes: Block,
    classes: [u32; WIDTH],
    /// By axis: which boxes begin below the cell, a bit for each.
    below: [u8; 3],
    /// By axis: which boxes reach the cell's upper border, which is not part of it.
    above: [u8; 3],
}

impl Eight {
    const EMPTY: Self = Self {
        boxes: Block::EMPTY,
        classes: [0; WIDTH],
        below: [0; 3],
        above: [0; 3],
    };

    #[inline(always)]
    pub(super) const fn boxes(&self) -> &Block {
        &self.boxes
    }

    /// By axis: all lanes if the box in this one begins below the cell, or none.
    #[inline(always)]
    pub(super) fn begins_below(&self, lane: usize) -> [u8; 3] {
        self.below
            .map(|lanes| if lanes >> lane & 1 != 0 { u8::MAX } else { 0 })
    }

    /// Which of the eight share a cell along some axis with a box that [begins
    /// below](Self::begins_below) this one: what is common to the two begins there, and is another
    /// cell's. A bit for each.
    #[inline(always)]
    pub(super) fn shared_below(&self, below: [u8; 3]) -> u32 {
        let [x, y, z] = self.below;
        u32::from(x & below[0] | y & below[1] | z & below[2])
    }

    /// Puts a box in a lane. Returns `true` if the object may have left this cell, or entered
    /// another: see [`follow`](Self::follow).
    #[inline]
    fn set(&mut self, lane: usize, aabb: &Aabb3d, class: u32, cell: &Aabb3d) -> bool {
        self.boxes.set(lane, aabb);
        let below = aabb.min.cmplt(cell.min).bitmask();
        let above = aabb.max.cmpge(cell.max).bitmask();
        let has_left = (aabb.min.cmpge(cell.max) | aabb.max.cmplt(cell.min)).any();
        let mut reaches_on = false;
        for (axis, (old, new)) in self
            .below
            .iter_mut()
            .zip([below; 3])
            .chain(self.above.iter_mut().zip([above; 3]))
            .enumerate()
        {
            let new = (new >> (axis % 3) & 1) as u8;
            reaches_on |= new & !(*old >> lane) & 1 != 0;
            *old = *old & !(1 << lane) | new << lane;
        }
        let has_resized = std::mem::replace(&mut self.classes[lane], class) != class;
        has_left | reaches_on | has_resized
    }

    /// Copies the boxes of these objects.
    #[inline(always)]
    fn gather(&mut self, objects: &[u32], boxes: &[Aabb3d]) {
        for (lane, object) in objects.iter().enumerate() {
            self.boxes
                .set(lane, boxes.get(*object as usize).unwrap_or(&NOWHERE));
        }
    }

    /// Sees where the boxes have gone. Returns the lanes of those that may have left this cell or
    /// entered another, or changed the size of cells that they fit in.
    ///
    /// The report tests whether a box lies completely within its node; this is the same test for
    /// boxes that straddle borders too. An object is in the same leaves as before if none of them
    /// sees it leave, or reach a border that it did not reach. For, take any point of the new box,
    /// and the nearest point to it of the old one, which lies in one of the leaves: along each axis
    /// in which the two differ, the old box did not reach that leaf's border on the way from the
    /// one to the other. If the new one does not either, the leaf has both points.
    #[inline(always)]
    fn follow<S: Simd>(&mut self, simd: S, cell: &Aabb3d, root_half_size: f32) -> u32 {
        let (low, high) = (cell.min.to_array(), cell.max.to_array());
        let mut changed = 0;
        let mut half_extent = f32x8::splat(simd, 0.0);
        let half = f32x8::splat(simd, 0.5);
        for axis in 0..3 {
            let min = self.boxes.side(simd, false, axis);
            let max = self.boxes.side(simd, true, axis);
            let (low, high) = (f32x8::splat(simd, low[axis]), f32x8::splat(simd, high[axis]));
            let below = min.simd_lt(low).to_bitmask() as u8;
            let above = max.simd_ge(high).to_bitmask() as u8;
            let left = (min.simd_ge(high) | max.simd_lt(low)).to_bitmask() as u8;
            changed |= left | below & !self.below[axis] | above & !self.above[axis];
            self.below[axis] = below;
            self.above[axis] = above;
            half_extent = half_extent.max(max * half - min * half);
        }
        let ratio = f32x8::splat(simd, root_half_size) / half_extent;
        let classes: u32x8<S> = ratio.bitcast::<u32x8<S>>() & u32x8::splat(simd, EXPONENT);
        let same = classes.simd_eq(u32x8::from_slice(simd, &self.classes));
        classes.store_slice(&mut self.classes);
        u32::from(changed) | !(same.to_bitmask() as u32)
    }

    /// Returns `true` if one of the boxes is not within another.
    #[inline(always)]
    fn sticks_out<S: Simd>(&self, simd: S, of: &Aabb3d) -> bool {
        let (low, high) = (of.min.to_array(), of.max.to_array());
        (0..3).any(|axis| {
            let below = self
                .boxes
                .side(simd, false, axis)
                .simd_lt(f32x8::splat(simd, low[axis]));
            let above = self
                .boxes
                .side(simd, true, axis)
                .simd_gt(f32x8::splat(simd, high[axis]));
            (below | above).any_true()
        })
    }
}

impl List {
    #[inline]
    pub(super) fn objects(&self) -> &[u32] {
        &self.objects
    }

    #[inline]
    pub(super) fn eights(&self) -> &[Eight] {
        &self.eights
    }

    /// The box of the object at an index of the list.
    #[inline]
    pub(super) fn aabb(&self, index: usize) -> Aabb3d {
        self.eights[index / WIDTH].boxes.get(index % WIDTH)
    }

    /// All objects, and their boxes.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, Aabb3d)> {
        (0..)
            .zip(&self.objects)
            .map(|(index, object)| (*object, self.aabb(index)))
    }

    #[inline]
    pub(super) fn push(&mut self, object: u32, aabb: &Aabb3d, class: u32, cell: &Aabb3d) {
        let index = self.objects.len();
        self.objects.push(object);
        if index.is_multiple_of(WIDTH) {
            self.eights.push(Eight::EMPTY);
        }
        self.eights[index / WIDTH].set(index % WIDTH, aabb, class, cell);
    }

    /// Where an object is in the list: maybe at `hint`.
    #[inline]
    pub(super) fn find(&self, object: u32, hint: u8) -> Option<usize> {
        if self.objects.get(usize::from(hint)) == Some(&object) {
            return Some(usize::from(hint));
        }
        self.objects.iter().position(|listed| *listed == object)
    }

    /// Takes an object off the list; the last one takes its index.
    pub(super) fn swap_remove(&mut self, index: usize) {
        let last = self.objects.len() - 1;
        self.objects.swap_remove(index);
        let (to, from) = ((index / WIDTH, index % WIDTH), (last / WIDTH, last % WIDTH));
        let source = &mut self.eights[from.0];
        let (aabb, class) = (source.boxes.get(from.1), source.classes[from.1]);
        let bits = |lanes: [u8; 3]| lanes.map(|lanes| lanes >> from.1 & 1);
        let (below, above) = (bits(source.below), bits(source.above));
        source.boxes.set(from.1, &NOWHERE);
        for lanes in source.below.iter_mut().chain(&mut source.above) {
            *lanes &= !(1 << from.1);
        }
        if index != last {
            let target = &mut self.eights[to.0];
            target.boxes.set(to.1, &aabb);
            target.classes[to.1] = class;
            for (lanes, bit) in target
                .below
                .iter_mut()
                .chain(&mut target.above)
                .zip(below.into_iter().chain(above))
            {
                *lanes = *lanes & !(1 << to.1) | bit << to.1;
            }
        }
        if from.1 == 0 {
            self.eights.pop();
        }
    }

    /// The box of the object at an index is this now. Returns `true` if its leaves may have
    /// changed.
    #[inline]
    pub(super) fn set(&mut self, index: usize, aabb: &Aabb3d, class: u32, cell: &Aabb3d) -> bool {
        self.eights[index / WIDTH].set(index % WIDTH, aabb, class, cell)
    }

    /// Copies all boxes anew, and appends the objects whose leaves may have changed. Returns `true`
    /// if one is not within the root, where that is asked.
    #[inline(always)]
    pub(super) fn follow<S: Simd>(
        &mut self,
        simd: S,
        boxes: &[Aabb3d],
        cell: &Aabb3d,
        root_half_size: f32,
        root: Option<&Aabb3d>,
        restless: &mut Vec<u32>,
    ) -> bool {
        for (eight, objects) in self.eights.iter_mut().zip(self.objects.chunks(WIDTH)) {
            eight.gather(objects, boxes);
        }
        let mut sticks_out = false;
        for (eight, objects) in self.eights.iter_mut().zip(self.objects.chunks(WIDTH)) {
            let mut changed = eight.follow(simd, cell, root_half_size) & ALL >> (WIDTH - objects.len());
            while changed != 0 {
                restless.push(objects[changed.trailing_zeros() as usize]);
                changed &= changed - 1;
            }
            if let Some(root) = root {
                sticks_out |= eight.sticks_out(simd, root);
            }
        }
        sticks_out
    }

    pub(super) fn clear(&mut self) {
        self.objects.clear();
        self.eights.clear();
    }

    pub(super) const fn capacity(&self) -> usize {
        self.objects.capacity()
    }

    pub(super) const fn memory_bytes(&self) -> usize {
        self.objects.capacity() * size_of::<u32>() + self.eights.capacity() * size_of::<Eight>()
    }

    /// Checks that all that is kept of a box agrees. For tests.
    ///
    /// # Panics
    /// If it does not.
    pub(super) fn assert_well_formed(&self, cell: &Aabb3d, root_half_size: f32) {
        assert_eq!(self.eights.len(), self.objects.len().div_ceil(WIDTH));
        for (index, eight) in self.eights.iter().enumerate() {
            for lane in 0..WIDTH {
                let aabb = eight.boxes.get(lane);
                if index * WIDTH + lane >= self.objects.len() {
                    assert_eq!(aabb, NOWHERE, "a lane without an object has no box");
                    continue;
                }
                let bits = |lanes: [u8; 3]| lanes.map(|lanes| lanes >> lane & 1 != 0);
                let sides = |mask: BVec3A| [0, 1, 2].map(|axis| mask.test(axis));
                assert_eq!(bits(eight.below), sides(aabb.min.cmplt(cell.min)));
                assert_eq!(bits(eight.above), sides(aabb.max.cmpge(cell.max)));
                assert_eq!(eight.classes[lane], size_class(root_half_size, &aabb));
            }
        }
    }
}
