//! The pairs of overlapping boxes without any index, to check those of an index against.

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_octree::broad_phase::overlap;

/// All pairs of overlapping boxes, touching included, as indices: the lower one first, in ascending
/// order.
///
/// The boxes are sorted along the axis on which they are spread most, and each is compared with
/// those that begin before it ends.
pub fn overlapping_pairs(boxes: &[Aabb3d]) -> Vec<[u32; 2]> {
    let axis = widest_axis(boxes);
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    order.sort_unstable_by(|a, b| {
        boxes[*a as usize].min[axis].total_cmp(&boxes[*b as usize].min[axis])
    });
    let sorted: Vec<Aabb3d> = order.iter().map(|object| boxes[*object as usize]).collect();

    let mut pairs = Vec::new();
    for (place, aabb) in sorted.iter().enumerate() {
        let end = aabb.max[axis];
        let rest = sorted[place + 1..].iter().zip(&order[place + 1..]);
        for (other, &object) in rest.take_while(|(other, _)| other.min[axis] <= end) {
            if overlap(aabb, other) {
                let first = order[place];
                pairs.push([first.min(object), first.max(object)]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Compares pairs that were found, in ascending order, with those that overlap; fails with a
/// description of the first difference.
pub fn compare(found: &[[u32; 2]], expected: &[[u32; 2]]) -> Result<(), String> {
    if let Some([[a, b], _]) = found.array_windows().find(|[pair, next]| pair == next) {
        return Err(format!("the pair ({a}, {b}) was found twice"));
    }
    let place = found
        .iter()
        .zip(expected)
        .take_while(|(a, b)| a == b)
        .count();
    // The lower of the two that differ is in one list only.
    match (found.get(place), expected.get(place)) {
        (None, None) => Ok(()),
        (Some(pair @ [a, b]), missed) if missed.is_none_or(|missed| pair < missed) => Err(format!(
            "the pair ({a}, {b}) was found, but its boxes do not overlap"
        )),
        (_, missed) => {
            let [a, b] = missed.copied().unwrap_or_default();
            Err(format!("the pair ({a}, {b}) was not found"))
        }
    }
}

/// The axis along which the lower corners vary most.
fn widest_axis(boxes: &[Aabb3d]) -> usize {
    let count = boxes.len() as f32;
    let mean = boxes.iter().map(|aabb| aabb.min / count).sum::<Vec3A>();
    let variance = boxes
        .iter()
        .map(|aabb| (aabb.min - mean) * (aabb.min - mean))
        .sum::<Vec3A>();
    variance.max_position()
}
