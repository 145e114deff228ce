//! Sort and sweep along one axis, the one on which the boxes are spread most.
//!
//! The order of the last frame is kept: where it is nearly right, insertion sort mends it, and a
//! radix sort where it is not. The two other axes are tested without branches, four planes per
//! instruction.

use bevy::math::{Vec3A, Vec4, bounding::Aabb3d};

use super::{Engine, Pair};

/// A box in the order of the sweep.
#[derive(Clone, Copy, Default)]
struct Item {
    low: f32,
    high: f32,
    number: u32,
}

/// The items in order, and their planes on the other two axes.
#[derive(Default)]
pub struct Sweep {
    axis: usize,
    items: Vec<Item>,
    /// The lower planes, and the upper ones with their sign changed.
    lows: Vec<Vec4>,
}

/// Moves in insertion sort that it may take per item before a radix sort is the better choice.
const PATIENCE: usize = 8;

/// Insertion sort that gives up when it takes too long. True if all is in order.
fn mend(items: &mut [Item]) -> bool {
    let mut moves = items.len() * PATIENCE;
    for i in 1..items.len() {
        let item = items[i];
        let mut hole = i;
        while hole > 0 && items[hole - 1].low > item.low {
            items[hole] = items[hole - 1];
            hole -= 1;
        }
        items[hole] = item;
        moves = moves.saturating_sub(i - hole);
        if moves == 0 {
            return false;
        }
    }
    true
}

/// The axis of the largest variance of centres.
fn widest_axis(boxes: &[Aabb3d]) -> usize {
    let count = boxes.len() as f32;
    let mean = boxes
        .iter()
        .fold(Vec3A::ZERO, |sum, aabb| sum + (aabb.min + aabb.max) / count);
    let variance = boxes.iter().fold(Vec3A::ZERO, |sum, aabb| {
        let offset = aabb.min + aabb.max - mean;
        sum + offset * offset / count
    });
    variance.max_position()
}

impl Engine for Sweep {
    fn update(&mut self, boxes: &[Aabb3d]) {
        let axis = widest_axis(boxes);
        if self.items.len() != boxes.len() {
            self.items = (0..boxes.len() as u32)
                .map(|number| Item {
                    number,
                    ..Item::default()
                })
                .collect();
        }
        let kept = self.axis == axis;
        self.axis = axis;
        for item in &mut self.items {
            let aabb = &boxes[item.number as usize];
            (item.low, item.high) = (aabb.min[axis], aabb.max[axis]);
        }
        if !(kept && mend(&mut self.items)) {
            radsort::sort_by_key(&mut self.items, |item| item.low);
        }
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        self.lows.clear();
        self.lows.extend(self.items.iter().map(|item| {
            let aabb = &boxes[item.number as usize];
            Vec4::new(aabb.min[u], aabb.min[v], -aabb.max[u], -aabb.max[v])
        }));
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        let mut found = pairs.len();
        for (i, item) in self.items.iter().enumerate() {
            let rest = &self.items[i + 1..];
            let reach = rest
                .iter()
                .take_while(|other| other.low <= item.high)
                .count();
            // Their lower planes must not lie above this box's upper ones, nor their upper ones
            // below its lower ones.
            let low = self.lows[i];
            let high = Vec4::new(-low.z, -low.w, -low.x, -low.y);
            if pairs.len() < found + reach {
                pairs.resize((found + reach).max(2 * found), (0, 0));
            }
            for (other, lows) in rest[..reach].iter().zip(&self.lows[i + 1..]) {
                pairs[found] = (item.number, other.number);
                found += usize::from(lows.cmple(high).all());
            }
        }
        pairs.truncate(found);
    }
}
