//! Two convex solids in place, and the planes that may part them.

use bevy::math::Vec3A;

use super::{
    placed::{Placed, PlacedPair},
    solid::{Solid, SolidEdge},
    workspace::Workspace,
};

/// Of meshes with more pairs of edges, the polygons that are near each other are looked at.
const MOST_EDGE_PAIRS: usize = 1024;

/// Puts two convex solids in place, if they are such that the planes that may part them are few and
/// known.
pub fn place_both<'a>(pair: &PlacedPair, workspace: &'a mut Workspace) -> Option<[&'a Solid; 2]> {
    let edges = |placed: Placed| Some(placed.shape.polygons()?.0.edges().len());
    let pairs = edges(pair.a)?.saturating_mul(edges(pair.b)?);
    let [a, b] = &mut workspace.solids;
    let is_placed =
        pairs <= MOST_EDGE_PAIRS && a.fill(pair.a, &pair.box_a) && b.fill(pair.b, &pair.box_b);
    is_placed.then_some([&*a, &*b])
}

/// The normal of a face of one of two solids along which they are furthest apart, from the first to
/// the second, and how far: no further than they are, and less where edges are closest.
pub fn widest_gap(a: &Solid, b: &Solid) -> (Vec3A, f32) {
    let normals = a.normals.iter().copied();
    let normals = normals.chain(b.normals.iter().map(|normal| -*normal));
    let gaps = normals.map(|normal| (normal, a.gap(b, normal)));
    gaps.fold((Vec3A::ZERO, f32::NEG_INFINITY), |widest, gap| {
        if gap.1 > widest.1 { gap } else { widest }
    })
}

/// Whether a plane along two edges, the second one of another solid, may have both solids on its two
/// sides: whether the arcs of normals that the edges have, the one seen from within, cross each other
/// (Gregorius, *The Separating Axis Test between Convex Polyhedra*, 2013). In doubt, it may.
#[inline]
pub fn may_part(one: &SolidEdge, other: &SolidEdge) -> bool {
    const DOUBT: f32 = -1e-6;
    let [a, b] = one.normals;
    let [c, d] = other.normals;
    let (c_over, d_over) = (-c.dot(one.across), -d.dot(one.across));
    if -c_over * d_over < DOUBT {
        return false;
    }
    let (a_over, b_over) = (a.dot(other.across), b.dot(other.across));
    -a_over * b_over >= DOUBT && c_over * b_over >= DOUBT
}
