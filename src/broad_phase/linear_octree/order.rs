//! The order of the boxes: along a space-filling curve, large boxes apart from small ones.

use std::ops::Range;

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{Level, dispatch, prelude::*};

use super::{
    list::{Packed, pack},
    skin::Anchor,
};
use crate::broad_phase::{
    block::WIDTH,
    boxes::NOWHERE,
    halving::{self, Item},
    proxy::Proxies,
};

/// The order, what it was like when it was made, and the lists that it is made with.
#[derive(Clone, Debug, Default)]
pub(super) struct Order {
    is_known: bool,
    /// Was it made for skins, or for the boxes themselves?
    for_skins: bool,
    /// How many objects came or went since it was made.
    changes: usize,
    /// In which update it was made, and whether that was because so many came or went.
    made: u32,
    was_for_others: bool,
    /// How much looser than at first the tree was, summed over the times at which it was searched
    /// as a whole since.
    excess: f64,
    items: Vec<Packed>,
    scratch: Vec<Packed>,
    halves: Vec<Item>,
    /// A list to put anchors in order with.
    pub(super) spare_anchors: Vec<Anchor>,
}

impl Order {
    /// Searching a loose tree costs more, and so does putting it in order. Once the first has cost
    /// about as much as the second would have, it is time.
    const WORTH_A_SORT: f64 = 1.0;

    /// An order that lasts for so many ticks may take several times as long to make.
    const LONG: u32 = 256;

    /// One in so many may come or go.
    const CHANGED_SHARE: usize = 8;

    /// Returns `true` if it is time for a new order.
    pub(super) fn is_stale(&self, slots: usize, for_skins: bool) -> bool {
        !self.is_known
            || self.for_skins != for_skins
            || self.changes * Self::CHANGED_SHARE > slots
            || self.excess > Self::WORTH_A_SORT
    }

    /// Makes it stale.
    pub(super) fn forget(&mut self) {
        self.is_known = false;
    }

    /// Returns `true` if a new order is made because so many of the objects came or went, or is the
    /// first after such a one; or if the last has lasted for long.
    pub(super) fn is_worth_care(&self, new: usize, all: usize, tick: u32) -> bool {
        self.is_for_others(new, all)
            || self.was_for_others
            || tick.wrapping_sub(self.made) >= Self::LONG
    }

    fn is_for_others(&self, new: usize, all: usize) -> bool {
        (self.changes + new) * Self::CHANGED_SHARE > all
    }

    /// Notes when an order is made, and for how many objects that are new.
    pub(super) fn note_sort(&mut self, new: usize, all: usize, tick: u32) {
        (self.was_for_others, self.made) = (self.is_for_others(new, all), tick);
    }

    /// Notes that an object came or went.
    pub(super) fn note_change(&mut self) {
        self.changes += 1;
    }

    /// Notes how loose the tree is that will be searched as a whole.
    pub(super) fn note_looseness(&mut self, looseness: f64) {
        self.excess += (looseness - 1.0).max(0.0);
    }

    /// Sorts all objects: their indices are the second numbers of the items.
    pub(super) fn sort(
        &mut self,
        level: Level,
        proxies: &Proxies,
        for_skins: bool,
        detail: Detail,
    ) -> &[Packed] {
        (self.is_known, self.for_skins, self.changes) = (true, for_skins, 0);
        self.excess = 0.0;
        let boxes = proxies.boxes();
        let Self {
            items,
            scratch,
            halves,
            ..
        } = self;
        items.clear();
        items.extend(proxies.iter().map(|(id, _)| u64::from(id.get())));
        dispatch!(level, simd => set_keys(simd, boxes, items));
        sort(items, scratch);
        let groups = groups(items);
        match detail {
            Detail::Boxes => {
                sort_runs(level, boxes, items, |key| key == FAR);
                // Not kept: it is as large as all else here, and seldom needed.
                let mut halves = Vec::new();
                for group in groups {
                    halve(boxes, &mut items[group.clone()], group.start, &mut halves);
                }
            }
            Detail::Curve => sort_runs(level, boxes, items, |_| true),
            Detail::Blocks => {
                sort_runs(level, boxes, items, |_| true);
                scratch.clear();
                scratch.extend_from_slice(items);
                for group in groups {
                    halve_blocks(boxes, scratch, group, items, halves);
                }
            }
        }
        items
    }

    /// Puts some objects in order, as [`sort`](Self::sort) does all.
    pub(super) fn sort_some(
        &mut self,
        level: Level,
        proxies: &Proxies,
        objects: impl Iterator<Item = u32>,
    ) -> &[Packed] {
        order(
            level,
            proxies.boxes(),
            objects,
            &mut self.items,
            &mut self.scratch,
        );
        &self.items
    }

    pub(super) fn memory_bytes(&self) -> usize {
        (self.items.capacity() + self.scratch.capacity()) * size_of::<Packed>()
            + self.halves.capacity() * size_of::<Item>()
            + self.spare_anchors.capacity() * size_of::<Anchor>()
    }
}

/// With how much care an order is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Detail {
    /// Along the curve, and no more.
    Curve,
    /// Along the curve, and then the blocks are halved: above them, halves are more compact than
    /// what follows each other on the curve. Takes half as long again.
    Blocks,
    /// All boxes of about the same size are halved: takes four times as long, and queries half as
    /// long.
    Boxes,
}

/// Sorts by the key in the upper half: three passes of a radix sort, stable.
fn sort(items: &mut Vec<u64>, scratch: &mut Vec<u64>) {
    const BITS: u32 = 11;
    const BUCKETS: usize = 1 << BITS;
    scratch.clear();
    scratch.resize(items.len(), 0);
    let mut counts = [[0_u32; BUCKETS]; 3];
    for item in &*items {
        for (pass, counts) in counts.iter_mut().enumerate() {
            counts[(item >> (32 + pass as u32 * BITS)) as usize % BUCKETS] += 1;
        }
    }
    for (pass, counts) in counts.iter_mut().enumerate() {
        // Nothing to do where all keys agree.
        if counts.iter().any(|count| *count as usize == items.len()) {
            continue;
        }
        let mut start = 0;
        for count in counts.iter_mut() {
            start += std::mem::replace(count, start);
        }
        for item in &*items {
            let end = &mut counts[(item >> (32 + pass as u32 * BITS)) as usize % BUCKETS];
            scratch[*end as usize] = *item;
            *end += 1;
        }
        std::mem::swap(items, scratch);
    }
}

/// How many keys are computed side by side.
const LANES: usize = 16;
/// Bits of each coordinate in a key.
const CELL_BITS: u32 = 9;

/// A run of objects in the same cell that is longer than this is put in order within the cell.
const LONG_RUN: usize = 2 * WIDTH;

/// Fills `items` with the objects in their order on the curve, in the lower halves.
pub(super) fn order(
    level: Level,
    boxes: &[Aabb3d],
    objects: impl Iterator<Item = u32>,
    items: &mut Vec<u64>,
    scratch: &mut Vec<u64>,
) {
    items.clear();
    items.extend(objects.map(u64::from));
    dispatch!(level, simd => set_keys(simd, boxes, items));
    sort(items, scratch);
    sort_runs(level, boxes, items, |_| true);
}

/// Puts long runs of objects with the same key in order among themselves: where objects are apart
/// by more than cells can tell, many share one. Of the keys, only those that are wanted.
fn sort_runs(level: Level, boxes: &[Aabb3d], items: &mut [u64], wanted: impl Fn(u32) -> bool) {
    let mut long_runs: Vec<Range<usize>> = runs(items, 0)
        .into_iter()
        .filter(|run| wanted((items[run.start] >> 32) as u32))
        .collect();
    while let Some(run) = long_runs.pop() {
        let items = &mut items[run.clone()];
        dispatch!(level, simd => set_keys(simd, boxes, items));
        items.sort_unstable();
        let whole = 0..items.len();
        long_runs.extend(
            runs(items, run.start)
                .into_iter()
                .filter(|inner| inner.len() < whole.len()),
        );
    }
}

/// The long runs of items with equal keys, as indices from `start` on.
fn runs(items: &[u64], start: usize) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut begin = 0;
    for run in items.chunk_by(|a, b| a >> 32 == b >> 32) {
        let end = begin + run.len();
        // Objects far away may be so in all directions.
        let is_far = run[0] >> 32 == u64::from(FAR);
        if run.len() > if is_far { WIDTH } else { LONG_RUN } {
            runs.push(start + begin..start + end);
        }
        begin = end;
    }
    runs
}

/// The groups of items that are of about the same size, and not far away, in their order along the
/// curve: as indices.
fn groups(items: &[u64]) -> Vec<Range<usize>> {
    let class = |item: &u64| item >> (32 + 3 * CELL_BITS);
    let mut begin = items.partition_point(|item| item >> 32 == u64::from(FAR));
    let mut groups = Vec::new();
    for group in items[begin..].chunk_by(|a, b| class(a) == class(b)) {
        groups.push(begin..begin + group.len());
        begin += group.len();
    }
    groups
}

/// Halves objects that go into the slots from `first` on.
fn halve(boxes: &[Aabb3d], items: &mut [u64], first: usize, halves: &mut Vec<Item>) {
    let index = |item: &u64| *item as u32;
    halves.clear();
    halves.extend(
        items
            .iter()
            .map(|item| Item::new(&boxes[index(item) as usize], index(item))),
    );
    halving::sort(halves, first);
    for (item, half) in items.iter_mut().zip(&*halves) {
        *item = u64::from(half.index);
    }
}

/// Halves the blocks that are all of one group, given the items of all groups in order.
fn halve_blocks(
    boxes: &[Aabb3d],
    sorted: &[u64],
    group: Range<usize>,
    items: &mut [u64],
    halves: &mut Vec<Item>,
) {
    let blocks = group.start.div_ceil(WIDTH)..group.end / WIDTH;
    if blocks.len() <= 1 {
        return;
    }
    let slots = |block: usize| block * WIDTH..(block + 1) * WIDTH;
    let bounds = |block: usize| {
        let boxes = sorted[slots(block)]
            .iter()
            .map(|item| &boxes[*item as u32 as usize]);
        boxes.fold(NOWHERE, |bounds, aabb| Aabb3d {
            min: bounds.min.min(aabb.min),
            max: bounds.max.max(aabb.max),
        })
    };
    halves.clear();
    halves.extend(
        blocks
            .clone()
            .map(|block| Item::new(&bounds(block), block as u32)),
    );
    halving::sort(halves, blocks.start);
    for (block, half) in blocks.zip(&*halves) {
        items[slots(block)].copy_from_slice(&sorted[slots(half.index as usize)]);
    }
}

/// Half the centre of a box: sums of large numbers may overflow.
#[inline(always)]
fn half_center(aabb: &Aabb3d) -> Vec3A {
    aabb.min * 0.25 + aabb.max * 0.25
}

/// Half the sides of a box.
#[inline(always)]
fn half_sides(aabb: &Aabb3d) -> Vec3A {
    aabb.max * 0.5 - aabb.min * 0.5
}

/// Where objects are, and how large: by half their centres, and half their longest sides.
struct Spread {
    low: Vec3A,
    high: Vec3A,
    /// The largest size of the largest class.
    largest: f32,
    /// Are all of them there?
    holds_all: bool,
}

impl Spread {
    /// With so many objects or more, a few of them may be left out.
    const MANY: usize = 128;
    /// How many are then looked at to see where most of them are. One in eight may be far away, on
    /// each side.
    const SAMPLE: usize = 32;
    /// How many classes of larger sizes than most have there may be.
    const LARGER_CLASSES: usize = 15;

    #[inline(always)]
    fn of(boxes: &[Aabb3d], items: &[u64]) -> Self {
        let (mut low, mut high, mut largest) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY, Vec3A::ZERO);
        for item in items {
            let aabb = &boxes[*item as u32 as usize];
            let center = half_center(aabb);
            low = low.min(center);
            high = high.max(center);
            largest = largest.max(half_sides(aabb));
        }
        let mut extent = Self {
            low,
            high,
            largest: largest.max_element(),
            holds_all: true,
        };
        if items.len() >= Self::MANY {
            extent.leave_out_a_few(boxes, items);
        }
        extent
    }

    /// A few objects far away would make cells so large that all others share a few of these, and a
    /// few large ones would leave no class of size to tell the others apart.
    fn leave_out_a_few(&mut self, boxes: &[Aabb3d], items: &[u64]) {
        let mut samples = [[0.0; Self::SAMPLE]; 4];
        for number in 0..Self::SAMPLE {
            // By the golden ratio: objects may come in turns.
            let index =
                ((number as u32).wrapping_mul(0x9E37_79B9) as u64 * items.len() as u64) >> 32;
            let aabb = &boxes[items[index as usize] as u32 as usize];
            let [x, y, z] = half_center(aabb).to_array();
            for (sample, value) in samples
                .iter_mut()
                .zip([x, y, z, half_sides(aabb).max_element()])
            {
                sample[number] = value;
            }
        }
        samples
            .iter_mut()
            .for_each(|sample| sample.sort_unstable_by(f32::total_cmp));
        let ranked =
            |rank: usize| Vec3A::from_array(std::array::from_fn(|axis| samples[axis][rank]));
        let (low, high) = (
            ranked(Self::SAMPLE / 8),
            ranked(Self::SAMPLE - 1 - Self::SAMPLE / 8),
        );
        let beyond = (high - low).max_element();
        let (low, high) = (low - beyond, high + beyond);
        self.holds_all = (low.cmple(self.low) & high.cmpge(self.high)).all();
        if !self.holds_all {
            let centers = items
                .iter()
                .map(|item| half_center(&boxes[*item as u32 as usize]));
            let near = centers.filter(|center| (center.cmpge(low) & center.cmple(high)).all());
            let nothing = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
            (self.low, self.high) = near.fold(nothing, |(low, high), center| {
                (low.min(center), high.max(center))
            });
        }
        // The typical size is in the middle of its class: otherwise, rounding might part objects of
        // the same size.
        let mut size = samples[3][Self::SAMPLE / 2] * 2.0;
        if size > 0.0 {
            for _ in 0..Self::LARGER_CLASSES {
                size *= if size < self.largest { 4.0 } else { 1.0 };
            }
            self.largest = size;
        }
    }
}

/// The key of objects that are far away from most. The least: pairs of blocks are joined from the
/// first, of which then no box reaches into the second.
const FAR: u32 = 0;

/// Gives items, which have their objects in the lower halves, keys in the upper halves.
#[inline(always)]
fn set_keys<S: Simd>(_: S, boxes: &[Aabb3d], items: &mut [u64]) {
    const CELLS: f32 = (1 << CELL_BITS) as f32;
    let Spread {
        low,
        high,
        largest,
        holds_all,
    } = Spread::of(boxes, items);
    let scale = CELLS / (high - low).max_element();
    let scale = if scale.is_finite() { scale } else { 0.0 };
    for items in items.chunks_mut(LANES) {
        let mut cells = [[0_u32; LANES]; 3];
        let mut classes = [0_u32; LANES];
        for (lane, item) in items.iter().enumerate() {
            let aabb = &boxes[*item as u32 as usize];
            let cell = ((half_center(aabb) - low) * scale)
                .min(Vec3A::splat(CELLS - 1.0))
                .to_array();
            for axis in 0..3 {
                cells[axis][lane] = cell[axis] as u32;
            }
            classes[lane] = size_class(largest / half_sides(aabb).max_element());
        }
        let positions = hilbert(cells);
        for (lane, item) in items.iter_mut().enumerate() {
            *item = pack(
                classes[lane] << (3 * CELL_BITS) | positions[lane],
                *item as u32,
            );
        }
    }
    if !holds_all {
        for item in items {
            let center = half_center(&boxes[*item as u32 as usize]);
            if (center.cmplt(low) | center.cmpgt(high)).any() {
                *item = pack(FAR, *item as u32);
            }
        }
    }
}

/// How many times smaller by four an object is than the largest, at most 31.
#[inline(always)]
fn size_class(ratio: f32) -> u32 {
    // The exponent is the logarithm; that of infinity, for a point, is large too.
    ((ratio.to_bits() >> 23).saturating_sub(127) / 2).min(31)
}

/// The positions of cells on the Hilbert curve, by Skilling's transform (AIP Conference Proceedings
/// 707, 2004) without branches.
#[inline(always)]
fn hilbert(cells: [[u32; LANES]; 3]) -> [u32; LANES] {
    let [mut x, mut y, mut z] = cells;
    let mut positions = [0; LANES];
    for lane in 0..LANES {
        let (mut a, mut b, mut c) = (x[lane], y[lane], z[lane]);
        for bit in (1..CELL_BITS).rev() {
            let low = (1 << bit) - 1;
            // All ones where the bit is set.
            let set = |v: u32| (v >> bit & 1).wrapping_neg();
            a ^= low & set(a);
            let swap = (a ^ b) & low & !set(b);
            a ^= (low & set(b)) | swap;
            b ^= swap;
            let swap = (a ^ c) & low & !set(c);
            a ^= (low & set(c)) | swap;
            c ^= swap;
        }
        b ^= a;
        c ^= b;
        let mut flip = 0;
        for bit in 1..CELL_BITS {
            flip ^= ((1 << bit) - 1) & (c >> bit & 1).wrapping_neg();
        }
        (x[lane], y[lane], z[lane]) = (a ^ flip, b ^ flip, c ^ flip);
        positions[lane] = spread(x[lane]) << 2 | spread(y[lane]) << 1 | spread(z[lane]);
    }
    positions
}

/// Puts two zeros before each of ten bits.
#[inline(always)]
const fn spread(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00FF;
    let v = (v | v << 8) & 0x0300_F00F;
    let v = (v | v << 4) & 0x030C_30C3;
    (v | v << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_neighbours_one_after_the_other() {
        // The lower corner of the cube is a curve of its own: 8 × 8 × 8 cells, each next to the one
        // before.
        let mut cells = Vec::new();
        for x in 0..8_u32 {
            for y in 0..8 {
                for z in 0..8 {
                    let mut lanes = [[0; LANES]; 3];
                    (lanes[0][0], lanes[1][0], lanes[2][0]) = (x, y, z);
                    cells.push((hilbert(lanes)[0], [x, y, z]));
                }
            }
        }
        cells.sort_unstable();
        for (index, pair) in cells.windows(2).enumerate() {
            let distance: u32 = (0..3)
                .map(|axis| pair[0].1[axis].abs_diff(pair[1].1[axis]))
                .sum();
            assert_eq!((pair[0].0 as usize, distance), (index, 1));
        }
    }

    #[test]
    fn sorting_is_stable_and_complete() {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut items: Vec<u64> = (0..5000)
            .map(|index| pack(rng.u32(0..1000) << 20, index))
            .collect();
        let mut expected = items.clone();
        expected.sort_unstable();
        sort(&mut items, &mut Vec::new());
        assert_eq!(items, expected);
    }
}
