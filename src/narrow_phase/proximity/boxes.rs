//! The closest points of two cuboids.

use bevy::math::Vec3A;

use super::polygons::{self, Nearest};
use crate::narrow_phase::frame::{
    closest, common_point::common_point, oriented_box::OrientedBox, placed::PlacedPair,
    separation::Separation, workspace::Workspace,
};

/// The cosine, with two edges of length 1 at right angles, of an angle that may be a right one but
/// for rounding.
const DOUBT: f32 = 1e-5;

/// The closest points of two cuboids: the same one twice, if they overlap.
pub fn closest_points(pair: &PlacedPair, workspace: &mut Workspace) -> Option<[Vec3A; 2]> {
    let (a, b) = (&pair.box_a, &pair.box_b);
    if a.axes == b.axes {
        return Some(aligned(a, b));
    }
    let found = Separation::of(a, b, f32::INFINITY)?;
    if found.gap > 0.0 {
        return Some(apart(a, b));
    }
    let common = if found.gap <= -found.doubt {
        common_point(pair)
    } else {
        None
    };
    // Few are that close to touching, or meet in a point so hard to find.
    common
        .map(|point| [point; 2])
        .or_else(|| polygons::closest_points(pair, workspace))
}

/// Two boxes turned alike: axis by axis, the middle of what they share, or of the gap.
fn aligned(a: &OrientedBox, b: &OrientedBox) -> [Vec3A; 2] {
    let offset = a.axes.transpose() * (b.center - a.center);
    let (low, high) = (offset - b.half, offset + b.half);
    let middle = (low.max(-a.half) + high.min(a.half)) * 0.5;
    [middle.max(-a.half).min(a.half), middle.max(low).min(high)]
        .map(|point| a.center + a.axes * point)
}

/// Two boxes that do not overlap.
///
/// Of the closest points, one is a corner, or else they are within two edges. Then the line between
/// them is at right angles to both edges, and each edge is the one that reaches furthest along it:
/// few pairs of edges have to be tried, not 144.
fn apart(a: &OrientedBox, b: &OrientedBox) -> [Vec3A; 2] {
    let mut nearest = Nearest::default();
    for corner in corners(b) {
        nearest.consider([a.closest_point(corner), corner]);
    }
    for corner in corners(a) {
        nearest.consider([corner, b.closest_point(corner)]);
    }
    let offset = b.center - a.center;
    for (i, j) in (0..9).map(|pair| (pair / 3, pair % 3)) {
        let normal = a.axes.col(i).cross(b.axes.col(j));
        // Where edges run alongside, a corner is as close.
        if normal.length_squared() <= closest::PARALLEL {
            continue;
        }
        let towards_b = if normal.dot(offset) < 0.0 {
            -normal
        } else {
            normal
        };
        for on_a in edges_towards(a, i, towards_b) {
            for on_b in edges_towards(b, j, -towards_b) {
                nearest.consider(closest::segments(on_a, on_b).into());
            }
        }
    }
    nearest.points
}

fn corners(bounds: &OrientedBox) -> impl Iterator<Item = Vec3A> {
    let [x, y, z] = [0, 1, 2].map(|axis| bounds.axes.col(axis) * bounds.half[axis]);
    let center = bounds.center;
    let along_x = [center - x, center + x].into_iter();
    along_x
        .flat_map(move |at| [at - y, at + y])
        .flat_map(move |at| [at - z, at + z])
}

/// The edge along an axis that reaches furthest along a vector, or all that may.
fn edges_towards(
    bounds: &OrientedBox,
    axis: usize,
    towards: Vec3A,
) -> impl Iterator<Item = [Vec3A; 2]> {
    let half = |axis: usize| bounds.axes.col(axis) * bounds.half[axis];
    let sides = |axis: usize| {
        let slope = bounds.axes.col(axis).dot(towards);
        let side = half(axis);
        [
            (slope >= -DOUBT).then_some(side),
            (slope <= DOUBT).then_some(-side),
        ]
        .into_iter()
        .flatten()
    };
    let (center, along) = (bounds.center, half(axis));
    let (one, other) = (sides((axis + 1) % 3), sides((axis + 2) % 3));
    let middles = one.flat_map(move |one| other.clone().map(move |other| center + one + other));
    middles.map(move |middle| [middle - along, middle + along])
}
