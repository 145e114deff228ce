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
/// polygon has found, if that clears its polygon too. Of several that are hardly less deep, that
/// which was the shallowest before.
///
/// `depth` tells how far it is along a way, which it is told by number and direction, until a
/// claim's polygon is cleared; anything more than a limit, if it is more than that.
pub fn settle(
    buffers: &mut Buffers,
    bias: f32,
    mut depth: impl FnMut(&Claim, &[Vec3A], usize, Vec3A, f32) -> f32,
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
    // Takes a way, if it is shorter; whether it is.
    let mut shorten = |claim: &mut Claim, index: usize, direction: Vec3A| {
        let own = &corners[claim.corners[0] as usize..claim.corners[1] as usize];
        let limit = claim.way.depth - bias;
        let depth = depth(claim, own, index, direction, limit);
        if depth < limit {
            claim.way = WayOut { direction, depth };
        }
        depth < limit
    };
    let mut ways = [Vec3A::ZERO; MOST_WAYS];
    let mut count = 0;
    let mut deepest = f32::NEG_INFINITY;
    // Shallow ones first, as long as they find ways.
    let mut done = 0;
    while done < order.len() && count < MOST_WAYS {
        let claim = &mut claims[order[done] as usize];
        let mut is_new = true;
        for (index, direction) in ways[..count].iter().enumerate() {
            is_new &= direction.dot(claim.way.direction) < ALONG;
            is_new &= !shorten(claim, index, *direction);
        }
        if is_new {
            ways[count] = claim.way.direction;
            count += 1;
        }
        deepest = deepest.max(claim.way.depth);
        done += 1;
    }
    // Then deep ones first, as long as there may be a deeper one.
    let mut first = order.len();
    let mut last_way = 0;
    while first > done {
        let claim = &mut claims[order[first - 1] as usize];
        if claim.way.depth < deepest - bias {
            break;
        }
        first -= 1;
        // What helped the one before may help this one.
        for step in 0..count {
            if claim.way.depth < deepest - bias {
                break;
            }
            let index = (last_way + step) % count;
            if shorten(claim, index, ways[index]) {
                last_way = index;
            }
        }
        deepest = deepest.max(claim.way.depth);
    }
    let looked_at = order[..done].iter().chain(&order[first..]);
    let mut indices = looked_at.map(|index| *index as usize);
    indices.find(|index| claims[*index].way.depth >= deepest - bias)
}
