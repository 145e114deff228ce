//! The order of boxes that stay: halved again and again, across where they reach farthest.

use bevy::math::{Vec4, bounding::Aabb3d};

use crate::broad_phase::block::WIDTH;

/// A box as it is sorted: half its centre, and half of its longest side, as a fourth coordinate.
/// So a few large boxes amid small ones end up by themselves, and not in blocks with these.
#[derive(Clone, Copy)]
struct Item {
    place: Vec4,
    index: u32,
}

/// The indices of the boxes, so that all blocks of eight, and blocks of these, are compact.
///
/// Packs what is known as a kd-tree with as many boxes on either side as whole blocks hold: O(n log n).
pub fn order(boxes: &[Aabb3d]) -> Vec<u32> {
    let mut items: Vec<Item> = (0..)
        .zip(boxes)
        .map(|(index, aabb)| {
            let center = aabb.min * 0.25 + aabb.max * 0.25;
            let size = (aabb.max * 0.5 - aabb.min * 0.5).max_element();
            let place = center.extend(size);
            Item { place, index }
        })
        .collect();
    let mut block = WIDTH;
    while block < items.len() {
        block *= WIDTH;
    }
    split(&mut items, block);
    items.iter().map(|item| item.index).collect()
}

/// Puts boxes in order of which `block` go into a block at most.
fn split(items: &mut [Item], block: usize) {
    let mut child = block;
    while child >= items.len() && child > 1 {
        child /= WIDTH;
    }
    if child <= 1 {
        return;
    }
    halve(items, child);
}

fn halve(items: &mut [Item], child: usize) {
    let children = items.len().div_ceil(child);
    if children <= 1 {
        split(items, child);
        return;
    }
    let first = items[0].place;
    let (low, high) = items.iter().fold((first, first), |(low, high), item| {
        (low.min(item.place), high.max(item.place))
    });
    let axis = (high - low).max_position();
    let middle = children / 2 * child;
    items.select_nth_unstable_by(middle, |a, b| a.place[axis].total_cmp(&b.place[axis]));
    let (before, after) = items.split_at_mut(middle);
    halve(before, child);
    halve(after, child);
}
