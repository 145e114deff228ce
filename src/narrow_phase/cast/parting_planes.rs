//! The first time of impact of two convex solids that do not turn, by the planes that may part them:
//! those of the faces of both, and those along an edge of each.
//!
//! Two convex solids are apart as long as one of these planes is between them (the separating axes
//! of Gottschalk, Lin and Manocha, 1996). Each says from when on it no longer is, and when it is
//! again: see [`Window`].

use bevy::math::{DMat3, DVec3, Vec3A};

use super::{
    first_impact::LocalImpact,
    flat_meeting::{Foremost, foremost, shared_point},
    window::Window,
};
use crate::narrow_phase::frame::{
    case::Case,
    oriented_box::OrientedBox,
    placed::PlacedPair,
    two_solids::{self, may_part},
    workspace::Workspace,
};

/// The square of the sine of the angle below which two edges span no plane.
const PARALLEL: f64 = 1e-12;

/// How near to a plane corners count as on it, and to each other as touching, in tolerances.
const SAME_PLACE: f32 = 1.5;

/// What the planes say.
pub enum Answer {
    /// The two do not meet.
    Apart,
    Met(LocalImpact),
    /// They are not asked for such shapes, or none is between the two at the start, or where they say
    /// that the two meet, these do not touch.
    Unknown,
}

/// Asks the planes between two solids, of which the first moves in a direction.
pub fn first_impact(
    pair: &PlacedPair,
    direction: Vec3A,
    limit: f32,
    workspace: &mut Workspace,
) -> Answer {
    let window = Window::new(f64::from(limit), f64::from(pair.tolerance));
    match pair.case() {
        Case::Cuboids => of_boxes(pair, direction, window),
        Case::Convex => of_solids(pair, direction, window, workspace),
        _ => Answer::Unknown,
    }
}

fn of_boxes(pair: &PlacedPair, direction: Vec3A, mut window: Window<DVec3>) -> Answer {
    ask_boxes(&pair.box_a, &pair.box_b, direction, &mut window);
    answer(pair, direction, &window, |normal, slack, by| {
        [
            foremost(&corners(&pair.box_a), normal, slack, by),
            foremost(&corners(&pair.box_b), -normal, slack, Vec3A::ZERO),
        ]
    })
}

/// Of two cuboids, 15 normals at most. In 64 bits, for those of edges that are nearly parallel would
/// be lost in rounding.
fn ask_boxes(a: &OrientedBox, b: &OrientedBox, direction: Vec3A, window: &mut Window<DVec3>) {
    let axes_of = |bounds: &OrientedBox| {
        let [x, y, z] = [0, 1, 2].map(|axis| bounds.axes.col(axis).as_dvec3());
        DMat3::from_cols(x, y, z)
    };
    let (axes_a, axes_b) = (axes_of(a), axes_of(b));
    let (half_a, half_b) = (a.half.as_dvec3(), b.half.as_dvec3());
    let (offset, way) = ((b.center - a.center).as_dvec3(), direction.as_dvec3());
    let (to_a, to_b) = (axes_a.transpose(), axes_b.transpose());
    let (offset_a, way_a) = (to_a * offset, to_a * way);
    // Columns are the axes of the second, as the first sees them.
    let axes = to_a * axes_b;
    let abs = axes.abs();
    let reach = half_a + abs * half_b;
    for axis in 0..3 {
        let normal = axes_a.col(axis) * 1f64.copysign(offset_a[axis]);
        window.ask_slab(offset_a[axis], way_a[axis], reach[axis], normal);
    }
    if a.axes == b.axes || !window.is_open() {
        return;
    }
    let (offset_b, way_b) = (to_b * offset, to_b * way);
    let reach = half_b + abs.transpose() * half_a;
    for axis in 0..3 {
        let normal = axes_b.col(axis) * 1f64.copysign(offset_b[axis]);
        window.ask_slab(offset_b[axis], way_b[axis], reach[axis], normal);
    }
    if !window.is_open() {
        return;
    }
    for (i, j) in (0..9).map(|pair| (pair / 3, pair % 3)) {
        let cross = DVec3::AXES[i].cross(axes.col(j));
        let squared = cross.length_squared();
        if squared <= PARALLEL {
            continue;
        }
        let normal = cross / squared.sqrt();
        let along = normal.dot(offset_a);
        let of_b = axes.transpose() * normal;
        let reach = normal.abs().dot(half_a) + of_b.abs().dot(half_b);
        let towards = axes_a * normal * 1f64.copysign(along);
        window.ask_slab(along, normal.dot(way_a), reach, towards);
    }
}

fn corners(bounds: &OrientedBox) -> [Vec3A; 8] {
    let [x, y, z] = [0, 1, 2].map(|axis| bounds.axes.col(axis) * bounds.half[axis]);
    let side = |corner: usize, bit: usize, along: Vec3A| {
        if corner >> bit & 1 == 0 {
            along
        } else {
            -along
        }
    };
    [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|corner| bounds.center + side(corner, 0, x) + side(corner, 1, y) + side(corner, 2, z))
}

fn of_solids(
    pair: &PlacedPair,
    direction: Vec3A,
    mut window: Window<DVec3>,
    workspace: &mut Workspace,
) -> Answer {
    let Some([a, b]) = two_solids::place_both(pair, workspace) else {
        return Answer::Unknown;
    };
    let way = direction.as_dvec3();
    for (normals, turn) in [(&a.normals, 1.0), (&b.normals, -1.0)] {
        for normal in normals {
            let normal = *normal * turn;
            window.ask(
                f64::from(a.gap(b, normal)),
                f64::from(normal.dot(direction)),
                normal.as_dvec3(),
            );
        }
        if !window.is_open() {
            return Answer::Apart;
        }
    }
    for one in &a.edges {
        for other in &b.edges {
            if !may_part(one, other) {
                continue;
            }
            let [[from, to], [start, end]] =
                [a.ends(one), b.ends(other)].map(|ends| ends.map(Vec3A::as_dvec3));
            let (u, v) = (to - from, end - start);
            let cross = u.cross(v);
            let squared = cross.length_squared();
            if squared <= PARALLEL * u.length_squared() * v.length_squared() {
                continue;
            }
            let outwards = cross.dot((one.normals[0] + one.normals[1]).as_dvec3());
            let normal = cross / (squared.sqrt() * 1f64.copysign(outwards));
            let closing = normal.dot(way);
            // Other corners may reach further, if the edges are hardly bent.
            if window.counts(normal.dot(start - from), closing) {
                let gap = f64::from(a.gap(b, normal.as_vec3a()));
                window.ask(gap, closing, normal);
            }
        }
        if !window.is_open() {
            return Answer::Apart;
        }
    }
    answer(pair, direction, &window, |normal, slack, by| {
        [
            foremost(&a.corners, normal, slack, by),
            foremost(&b.corners, -normal, slack, Vec3A::ZERO),
        ]
    })
}

/// What the planes have left, given what reaches furthest along the normal of the last of them, to
/// within a slack, of the first solid, moved by so much, and of the second the other way.
fn answer(
    pair: &PlacedPair,
    direction: Vec3A,
    window: &Window<DVec3>,
    foremost: impl FnOnce(Vec3A, f32, Vec3A) -> [Foremost; 2],
) -> Answer {
    if window.begins_open() {
        return Answer::Unknown;
    }
    let Some((distance, normal)) = window.first() else {
        return Answer::Apart;
    };
    let (distance, normal) = (distance as f32, normal.as_vec3a());
    let slack = SAME_PLACE * pair.tolerance;
    let [a, b] = foremost(normal, slack, direction * distance);
    match shared_point(a, b, normal, slack) {
        Some(point) => Answer::Met(LocalImpact {
            distance,
            point,
            normal: -normal,
        }),
        None => Answer::Unknown,
    }
}

#[cfg(test)]
mod tests;
