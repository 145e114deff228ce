//! Where a convex shape and a mesh are deepest in each other.
//!
//! Each triangle in touch says how far the shape has to go to be clear of it: along the least way
//! of all, if that is a normal of the surface there, or else along the triangle's own normal. At a
//! side between triangles in one plane, or on the inner side of a fold, a shape that is pushed
//! across the side would run into the neighbour: that is no normal there. Of what they say, the
//! deepest counts, but for triangles that the way out of another clears as well, on a shorter way.

use bevy::math::DVec3;
use smallvec::SmallVec;

use super::convex::{Convex, Isometry};
use super::gap::Gap;
use super::gjk;
use super::pairs;
use super::parts::Part;
use super::posed::PosedShape;
use super::posed_mesh::PosedMesh;
use super::probe::Search;
use crate::narrow_phase::mesh::topology::NO_NEIGHBOR;

/// The sine of the angle up to which two triangles count as in one plane, and the share of a length
/// that is more than rounding.
const FLAT: f64 = 1e-3;
/// The cosine of the angle up to which two directions count as one.
const ALIKE: f64 = 0.9999;
/// How much less another way has to be to be preferred, as a share of the shape's size.
const BIAS: f64 = 1e-4;
/// So many ways out are tried on all triangles.
const MOST_WAYS: usize = 8;

/// What a triangle says: the gap, as the shape sees it.
struct Claim {
    polygon: u32,
    corners: [DVec3; 3],
    gap: Gap,
}

/// The contact of a shape and a mesh, as the shape sees it.
pub fn contact(body: &Convex, mesh: &PosedMesh, tolerance: f64) -> Option<Gap> {
    let mut claims = SmallVec::<[Claim; 8]>::new();
    let probe = PosedShape::Part(Part::Convex(*body)).probe(mesh.at, DVec3::ZERO);
    mesh.each(
        &probe,
        &Search::within(tolerance),
        &mut |polygon, corners| {
            let triangle = Convex::triangle(corners, 0.0, Isometry::IDENTITY);
            if let Some(gap) = gjk::gap(body, &triangle, tolerance, true) {
                let gap = along_a_normal(body, mesh, polygon, corners, gap);
                claims.push(Claim {
                    polygon,
                    corners,
                    gap,
                });
            }
        },
    );
    let [_, half] = body.local_box();
    settle(body, &mut claims, BIAS * half.length())
}

/// The way out of a mesh, of a shape inside that does not touch it: through what is nearest.
pub fn from_inside(body: &Convex, mesh: &PosedMesh) -> Option<Gap> {
    if !mesh.mesh.has_inside() {
        return None;
    }
    let [body_shape, mesh_shape] = [
        PosedShape::Part(Part::Convex(*body)),
        PosedShape::Mesh(*mesh),
    ];
    let gap = pairs::nearest(&body_shape, &mesh_shape)?;
    let out = gap.normal;
    let depth = gap.points[1].dot(out) - lowest(body, out);
    Some(Gap {
        distance: -depth,
        normal: -out,
        between: gap.points[0],
        ..gap
    })
}

/// The same gap, if its normal is one of the surface; otherwise that along the triangle's own.
fn along_a_normal(
    body: &Convex,
    mesh: &PosedMesh,
    polygon: u32,
    [a, b, c]: [DVec3; 3],
    gap: Gap,
) -> Gap {
    let Some(up) = (b - a).cross(c - a).try_normalize() else {
        return gap;
    };
    let is_solid = mesh.mesh.bounds_solid(polygon as usize);
    let way = -gap.normal;
    let along = way.dot(up);
    let is_out = !is_solid || along >= -FLAT;
    if is_out && (along.abs() > ALIKE || is_highest(mesh, polygon, way)) {
        return gap;
    }
    let to_side = |way: DVec3| Gap {
        distance: lowest(body, way) - way.dot(a),
        normal: -way,
        ..gap
    };
    let (front, back) = (to_side(up), to_side(-up));
    if is_solid || front.distance >= back.distance {
        front
    } else {
        back
    }
}

/// Is the surface nowhere higher along a way, just beyond where a polygon of it is highest?
fn is_highest(mesh: &PosedMesh, polygon: u32, way: DVec3) -> bool {
    let (corners, across) = (
        mesh.mesh.polygon(polygon as usize),
        mesh.mesh.across(polygon as usize),
    );
    let heights = corners.iter().map(|corner| way.dot(mesh.place(*corner)));
    let heights: SmallVec<[f64; 8]> = heights.collect();
    let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let is_top = |i: usize| heights[i] >= highest - FLAT * (highest - lowest);
    across.iter().enumerate().all(|(side, &other)| {
        let next = (side + 1) % corners.len();
        if other == NO_NEIGHBOR || !(is_top(side) || is_top(next)) {
            return true;
        }
        let ends = [corners[side], corners[next]];
        let from = mesh.place(ends[usize::from(!is_top(side))]);
        let others = mesh.mesh.polygon(other as usize).iter();
        let mut beyond = others.filter(|corner| !ends.contains(corner));
        beyond.all(|corner| {
            let along = mesh.place(*corner) - from;
            way.dot(along) <= FLAT * along.length()
        })
    })
}

/// Where a shape begins along a direction.
fn lowest(body: &Convex, direction: DVec3) -> f64 {
    body.furthest(-direction).dot(direction) - body.radius
}

/// The claim that counts: the deepest, after each was replaced by a shorter way that another has
/// found, if that clears its triangle too.
fn settle(body: &Convex, claims: &mut [Claim], bias: f64) -> Option<Gap> {
    // Whatever the order in which the tree found them.
    claims.sort_unstable_by(|a, b| {
        let by_depth = b.gap.distance.total_cmp(&a.gap.distance);
        by_depth.then(a.polygon.cmp(&b.polygon))
    });
    let mut ways = SmallVec::<[(DVec3, f64); MOST_WAYS]>::new();
    let mut deepest: Option<Gap> = None;
    for Claim { corners, gap, .. } in claims {
        let mut is_new = ways.len() < MOST_WAYS;
        for &(way, lowest) in &ways {
            is_new &= -way.dot(gap.normal) < ALIKE;
            let heights = corners.map(|corner| way.dot(corner));
            let depth = heights.into_iter().fold(f64::NEG_INFINITY, f64::max) - lowest;
            if depth < -gap.distance - bias {
                (gap.normal, gap.distance) = (-way, -depth);
                is_new = false;
            }
        }
        if is_new {
            ways.push((-gap.normal, lowest(body, -gap.normal)));
        }
        if deepest.is_none_or(|deepest| gap.distance < deepest.distance - bias) {
            deepest = Some(*gap);
        }
    }
    deepest
}

#[cfg(all(test, feature = "rapier"))]
mod tests;
