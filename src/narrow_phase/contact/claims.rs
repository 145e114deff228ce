//! What the polygons in touch say, and which of them counts.

use bevy::math::Vec3A;

use super::{
    buffers::{Buffers, Claim},
    facet::WayOut,
};

/// So many ways out are tried on all polygons.
const MOST_WAYS: usize = 8;

/// The cosine of the angle up to which two directions count as one.
const ALONG: f32 = 0.9999;

/// The claim that counts: the deepest, after each was replaced by a shorter way that another
/// polygon has found, if that clears its polygon too.
///
/// `depth` tells how far it is along a direction until a claim's polygon is cleared; anything more
/// than a limit, if it is more than that.
pub fn settle(
    buffers: &mut Buffers,
    bias: f32,
    depth: impl Fn(&Claim, &[Vec3A], Vec3A, f32) -> f32,
) -> Option<usize> {
    let Buffers {
        corners,
        claims,
        order,
        ..
    } = buffers;
    order.clear();
    order.extend(0..claims.len() as u32);
    order.sort_unstable_by(|a, b| {
        let deep = |index: &u32| claims[*index as usize].way.depth;
        deep(a).total_cmp(&deep(b)).then(a.cmp(b))
    });
    let mut ways = [Vec3A::ZERO; MOST_WAYS];
    let mut count = 0;
    let mut deepest: Option<usize> = None;
    for &index in &*order {
        let claim = &mut claims[index as usize];
        let own = &corners[claim.corners[0] as usize..claim.corners[1] as usize];
        let mut is_new = count < MOST_WAYS;
        for direction in &ways[..count] {
            is_new &= direction.dot(claim.way.direction) < ALONG;
            let limit = claim.way.depth - bias;
            let depth = depth(claim, own, *direction, limit);
            if depth < limit {
                claim.way = WayOut {
                    direction: *direction,
                    depth,
                };
                is_new = false;
            }
        }
        if is_new {
            ways[count] = claim.way.direction;
            count += 1;
        }
        let depth = claim.way.depth;
        if deepest.is_none_or(|deepest| depth > claims[deepest].way.depth + bias) {
            deepest = Some(index as usize);
        }
    }
    deepest
}
