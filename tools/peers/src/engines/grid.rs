//! A uniform sorted grid: cells as large as the largest box, so that whatever overlaps is in the
//! same cell or in one of its neighbours.
//!
//! Boxes are sorted by the cell of their lower corner, by a radix sort of keys, and copied in that
//! order. A cell is compared with itself and with the half of its neighbours that come later in the
//! order. Cells that follow each other along x follow each other in memory too, so that these are
//! five runs: one of its own row, and one in each of four rows beyond, whose ends only ever move
//! forward.

use bevy::math::{UVec3, Vec3A, bounding::Aabb3d};

use super::{Engine, Pair};

/// Cells along an axis: more bits would take another pass of sorting, and more precision than
/// centimetres at kilometres have.
const MOST_CELLS: u32 = 1022;
/// Bits of a digit of the radix sort.
const DIGIT: u32 = 11;

/// A box in the order of the grid.
#[derive(Clone, Copy)]
struct Item {
    aabb: Aabb3d,
}

/// The boxes in the order of their cells.
#[derive(Default)]
pub struct Grid {
    /// Keys in the upper half, numbers of objects in the lower.
    keys: Vec<u64>,
    spare: Vec<u64>,
    items: Vec<Item>,
    /// From a key to that of the next cell along y and z.
    row: u32,
    layer: u32,
}

/// Sorts by the upper half, whose largest value is `most`.
fn radix_sort(keys: &mut Vec<u64>, spare: &mut Vec<u64>, most: u32) {
    spare.resize(keys.len(), 0);
    let mut shift = 0;
    while shift < u32::BITS && most >> shift > 0 {
        let digit = |key: u64| (key >> (32 + shift)) as usize & ((1 << DIGIT) - 1);
        let mut places = [0_u32; 1 << DIGIT];
        for &key in keys.iter() {
            places[digit(key)] += 1;
        }
        let mut sum = 0;
        for place in &mut places {
            (*place, sum) = (sum, sum + *place);
        }
        for &key in keys.iter() {
            let place = &mut places[digit(key)];
            spare[*place as usize] = key;
            *place += 1;
        }
        std::mem::swap(keys, spare);
        shift += DIGIT;
    }
}

fn key_of(key: u64) -> u32 {
    (key >> 32) as u32
}

impl Engine for Grid {
    fn update(&mut self, boxes: &[Aabb3d]) {
        let (mut low, mut high, mut largest) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY, Vec3A::ZERO);
        for aabb in boxes {
            low = low.min(aabb.min);
            high = high.max(aabb.min);
            largest = largest.max(aabb.max - aabb.min);
        }
        // A little larger, so that rounding puts no two boxes that touch two cells apart.
        let cell = (largest * 1.001)
            .max((high - low) / MOST_CELLS as f32)
            .max(Vec3A::splat(f32::MIN_POSITIVE));
        let scale = cell.recip();
        let cells: UVec3 = ((high - low) * scale).as_uvec3() + 1;
        // An empty cell at the end of each row and layer keeps neighbours from wrapping around.
        self.row = cells.x + 1;
        self.layer = self.row * (cells.y + 1);
        self.keys.clear();
        self.keys.extend(boxes.iter().enumerate().map(|(i, aabb)| {
            let at = ((aabb.min - low) * scale).as_uvec3();
            u64::from(at.x + at.y * self.row + at.z * self.layer) << 32 | i as u64
        }));
        radix_sort(
            &mut self.keys,
            &mut self.spare,
            self.layer.saturating_mul(cells.z),
        );
        self.items.clear();
        self.items.extend(self.keys.iter().map(|&key| Item {
            aabb: boxes[key as u32 as usize],
        }));
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        let (keys, items) = (&self.keys[..], &self.items[..]);
        let rows = [
            self.row,
            self.layer - self.row,
            self.layer,
            self.layer + self.row,
        ];
        let mut runs = [(0, 0); 4];
        let (mut start, mut next) = (0, 0);
        let mut found = 0;
        let mut compare = |i: usize, run: std::ops::Range<usize>| {
            if pairs.len() < found + run.len() {
                pairs.resize((found + run.len()).max(2 * found), (0, 0));
            }
            let a = &items[i].aabb;
            for (key, item) in keys[run.clone()].iter().zip(&items[run]) {
                pairs[found] = (keys[i] as u32, *key as u32);
                found +=
                    usize::from((a.min.cmple(item.aabb.max) & item.aabb.min.cmple(a.max)).all());
            }
        };
        while start < keys.len() {
            let key = key_of(keys[start]);
            let end = start
                + keys[start..]
                    .iter()
                    .take_while(|other| key_of(**other) == key)
                    .count();
            // The next cell of its own row.
            next = usize::max(next, end);
            next += keys[next..]
                .iter()
                .take_while(|other| key_of(**other) <= key + 1)
                .count();
            for i in start..end {
                compare(i, i + 1..next);
            }
            // Three cells in each of the rows beyond.
            for (run, row) in runs.iter_mut().zip(rows) {
                run.0 += keys[run.0..]
                    .iter()
                    .take_while(|other| key_of(**other) + 1 < key + row)
                    .count();
                run.1 = usize::max(run.0, run.1);
                run.1 += keys[run.1..]
                    .iter()
                    .take_while(|other| key_of(**other) <= key + row + 1)
                    .count();
                for i in start..end {
                    compare(i, run.0..run.1);
                }
            }
            start = end;
        }
        pairs.truncate(found);
    }
}
