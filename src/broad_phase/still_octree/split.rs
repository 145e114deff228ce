//! The order of boxes that stay: halved again and again, across where they reach farthest.

use bevy::math::{Vec4, bounding::Aabb3d};

use crate::broad_phase::block::WIDTH;

/// A box as it is sorted: half its centre, and half of its longest side, as a fourth coordinate.
/// So a few large boxes amid small ones end up by themselves, and not in blocks with these.
#[derive(Clone, Copy)]
struct Item {
    place: [f32; 4],
    index: u32,
}

/// The indices of the boxes, so that all blocks of eight, and blocks of these, are compact.
///
/// A kd-tree (Bentley, 1975) whose halves are as many boxes as whole blocks hold: O(n log n). Along
/// a space-filling curve, boxes are put in order faster, but blocks overlap more.
pub fn order(boxes: &[Aabb3d]) -> Vec<u32> {
    let mut items: Vec<Item> = (0..)
        .zip(boxes)
        .map(|(index, aabb)| {
            let center = aabb.min * 0.25 + aabb.max * 0.25;
            let size = (aabb.max * 0.5 - aabb.min * 0.5).max_element();
            let place = center.extend(size).to_array();
            Item { place, index }
        })
        .collect();
    split(&mut items);
    items.iter().map(|item| item.index).collect()
}

/// Puts the boxes of a block in order: those of its first child first, and so on.
fn split(items: &mut [Item]) {
    if items.len() > WIDTH {
        let mut child = WIDTH;
        while child * WIDTH < items.len() {
            child *= WIDTH;
        }
        halve(items, child);
    }
}

/// Puts boxes in order that go into some children of a block, each of which holds so many.
fn halve(items: &mut [Item], child: usize) {
    let children = items.len().div_ceil(child);
    if children <= 1 {
        return split(items);
    }
    let first = Vec4::from(items[0].place);
    let (low, high) = items.iter().fold((first, first), |(low, high), item| {
        let place = Vec4::from(item.place);
        (low.min(place), high.max(place))
    });
    let axis = (high - low).max_position();
    let middle = children / 2 * child;
    items.select_nth_unstable_by(middle, |a, b| a.place[axis].total_cmp(&b.place[axis]));
    let (before, after) = items.split_at_mut(middle);
    halve(before, child);
    halve(after, child);
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3A;

    use super::*;

    fn cube(center: Vec3A, half: f32) -> Aabb3d {
        Aabb3d::new(center, Vec3A::splat(half))
    }

    #[test]
    fn blocks_are_compact() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut places: Vec<u32> = (0..100).collect();
        random.shuffle(&mut places);
        let row: Vec<_> = places
            .iter()
            .map(|x| cube(Vec3A::X * *x as f32, 0.4))
            .collect();
        for (block, indices) in order(&row).chunks(WIDTH).enumerate() {
            let mut inside: Vec<u32> = indices
                .iter()
                .map(|index| places[*index as usize])
                .collect();
            inside.sort_unstable();
            let first = (block * WIDTH) as u32;
            assert_eq!(inside, Vec::from_iter(first..first + inside.len() as u32));
        }
    }

    #[test]
    fn large_boxes_are_by_themselves() {
        let large = |index: usize| index % 13 == 5;
        let boxes: Vec<_> = (0..8 * 13)
            .map(|index| {
                cube(
                    Vec3A::X * index as f32,
                    if large(index) { 1000.0 } else { 0.5 },
                )
            })
            .collect();
        let mixed = order(&boxes)
            .chunks(WIDTH)
            .filter(|block| {
                let larger = block.iter().filter(|index| large(**index as usize));
                (1..WIDTH).contains(&larger.count())
            })
            .count();
        assert_eq!(mixed, 0);
    }

    #[test]
    fn every_box_has_its_place_whatever_their_number_and_places() {
        for count in [0, 1, 7, 8, 9, 63, 64, 65, 511, 513] {
            // Many of them are at the same place.
            let boxes: Vec<_> = (0..count)
                .map(|x| cube(Vec3A::X * (x / 40) as f32, 1.0))
                .collect();
            let mut indices = order(&boxes);
            indices.sort_unstable();
            assert_eq!(indices, Vec::from_iter(0..count as u32));
        }
    }
}
