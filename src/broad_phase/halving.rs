//! An order of boxes in which blocks of eight are compact, and blocks of these, too: halved again
//! and again, across where they reach farthest.
//!
//! A kd-tree (Bentley, 1975) whose halves are as many boxes as whole blocks hold: O(n log n). Along
//! a space-filling curve, boxes are put in order faster, but blocks overlap more, and the more so
//! the higher up they are.

use bevy::math::{Vec4, bounding::Aabb3d};

use super::block::WIDTH;
use crate::parallel;

/// So many items are put in order by one job.
const JOB: usize = 8192;

/// What is put in order: half the centre of a box, and half of its longest side as a fourth
/// coordinate. So a few large boxes amid small ones end up by themselves, and not in blocks with
/// these.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    place: [f32; 4],
    /// Which one it is.
    pub index: u32,
}

impl Item {
    /// Returns what stands for a box, which is to be finite.
    #[inline(always)]
    pub fn new(aabb: &Aabb3d, index: u32) -> Self {
        let center = aabb.min * 0.25 + aabb.max * 0.25;
        let size = (aabb.max * 0.5 - aabb.min * 0.5).max_element();
        let place = center.extend(size).to_array();
        Self { place, index }
    }
}

/// Returns the indices of boxes in the order in which they had best go into blocks.
pub fn order(boxes: &[Aabb3d]) -> Vec<u32> {
    let mut items: Vec<Item> = (0..)
        .zip(boxes)
        .map(|(index, aabb)| Item::new(aabb, index))
        .collect();
    sort(&mut items, 0);
    items.iter().map(|item| item.index).collect()
}

/// Puts items in order that go into slots from `first` on, in jobs for all threads.
pub fn sort(items: &mut [Item], first: usize) {
    let (mut large, mut jobs) = (vec![(first, items)], Vec::new());
    while let Some((first, items)) = large.pop() {
        if items.len() <= JOB {
            jobs.push((first, items));
        } else if let Some(middle) = halve(items, first) {
            let (before, after) = items.split_at_mut(middle);
            large.extend([(first, before), (first + middle, after)]);
        }
    }
    parallel::for_each(jobs.into_iter(), |(first, items)| {
        sort_alone(items, first);
    });
}

fn sort_alone(items: &mut [Item], first: usize) {
    if let Some(middle) = halve(items, first) {
        let (before, after) = items.split_at_mut(middle);
        sort_alone(before, first);
        sort_alone(after, first + middle);
    }
}

/// Puts those items first that belong into the first half; returns how many. `None` if all are of
/// one block.
fn halve(items: &mut [Item], first: usize) -> Option<usize> {
    let middle = border(first, items.len())? - first;
    let start = Vec4::from(items[0].place);
    let (low, high) = items.iter().fold((start, start), |(low, high), item| {
        let place = Vec4::from(item.place);
        (low.min(place), high.max(place))
    });
    let axis = (high - low).max_position();
    items.select_nth_unstable_by(middle, |a, b| a.place[axis].total_cmp(&b.place[axis]));
    Some(middle)
}

/// The slot that is nearest to the middle of so many slots from `first` on, of those that begin a
/// block as large as there is one; `None` if they are all of one block of boxes.
fn border(first: usize, count: usize) -> Option<usize> {
    let last = (first + count).checked_sub(1)?;
    // Where the octal digits begin to differ.
    let digit = (first ^ last).checked_ilog2()? / WIDTH.ilog2();
    let child = WIDTH.pow(digit);
    let nearest = (2 * first + count + child - 1) / (2 * child);
    (digit > 0).then(|| nearest.clamp(first / child + 1, last / child) * child)
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
    #[test]
    fn halves_are_of_whole_blocks_wherever_they_begin() {
        assert_eq!(border(0, 8), None);
        assert_eq!(border(13, 3), None);
        assert_eq!(border(13, 4), Some(16));
        assert_eq!(border(0, 64), Some(32));
        assert_eq!(border(0, 65), Some(64));
        assert_eq!(border(50, 100), Some(128));
        assert_eq!(border(63, 4), Some(64));
        for count in 9..600_usize {
            // As many blocks on both sides, or one more in the second half.
            let blocks = |child: usize| count.div_ceil(child);
            let child = [8, 64, 512].into_iter().rfind(|child| blocks(*child) > 1);
            assert_eq!(
                border(0, count),
                child.map(|child| blocks(child) / 2 * child)
            );
        }
        assert_eq!(border(0, 0), None);
    }
}
