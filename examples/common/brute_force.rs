//! The pairs of overlapping boxes, without any index.

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_octree::broad_phase::overlap;

/// All pairs of overlapping boxes, touching included, as indices: the lower one first, in ascending order.
///
/// The boxes are sorted along the axis on which they are spread most, and each is compared with those that begin
/// before it ends.
pub fn overlapping_pairs(boxes: &[Aabb3d]) -> Vec<[u32; 2]> {
    let axis = widest_axis(boxes);
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    order.sort_unstable_by(|a, b| boxes[*a as usize].min[axis].total_cmp(&boxes[*b as usize].min[axis]));
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

/// The axis along which the lower corners vary most.
fn widest_axis(boxes: &[Aabb3d]) -> usize {
    let count = boxes.len() as f32;
    let mean = boxes.iter().map(|aabb| aabb.min / count).sum::<Vec3A>();
    let variance = boxes.iter().map(|aabb| (aabb.min - mean) * (aabb.min - mean)).sum::<Vec3A>();
    variance.max_position()
}
