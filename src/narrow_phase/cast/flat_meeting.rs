//! Where two convex solids touch that are on two sides of a plane.

use bevy::math::{Vec3A, ops};
use smallvec::SmallVec;

use crate::narrow_phase::frame::{closest, surface::border};

/// Corners of a solid that are as near to a plane as any.
pub type Foremost = SmallVec<[Vec3A; 8]>;

/// Those of some corners that reach furthest along a direction, to within a slack, moved by so much;
/// of several at one place, as a flat solid has, one.
pub fn foremost(corners: &[Vec3A], direction: Vec3A, slack: f32, by: Vec3A) -> Foremost {
    let height = |corner: &Vec3A| corner.dot(direction);
    let highest = corners.iter().map(height).fold(f32::NEG_INFINITY, f32::max);
    let mut found = Foremost::new();
    for corner in corners {
        let moved = *corner + by;
        let is_same = |known: &Vec3A| known.distance_squared(moved) <= slack * slack;
        if height(corner) >= highest - slack && !found.iter().any(is_same) {
            found.push(moved);
        }
    }
    found
}

/// A point that the hulls of two sets of corners share, which are both about in one plane with this
/// normal: the middle of all that they share. `None` if they are further apart than some slack.
pub fn shared_point(mut a: Foremost, mut b: Foremost, normal: Vec3A, slack: f32) -> Option<Vec3A> {
    if a.len() > b.len() {
        std::mem::swap(&mut a, &mut b);
    }
    let near = |one: Vec3A, other: Vec3A| {
        let is_near = one.distance_squared(other) <= slack * slack;
        is_near.then(|| one.midpoint(other))
    };
    match (a.as_slice(), b.as_slice()) {
        ([one], [other]) => near(*one, *other),
        ([one], [from, to]) => near(*one, closest::point_segment(*one, *from, *to)),
        (&[from, to], &[start, end]) => {
            let (u, v) = (
                (to - from).normalize_or_zero(),
                (end - start).normalize_or_zero(),
            );
            if u.cross(v).length_squared() > closest::PARALLEL {
                let (one, other) = closest::segments([from, to], [start, end]);
                return near(one, other);
            }
            // Along each other: the middle of what they share.
            let place = |point: Vec3A| (point - from).dot(u);
            let (low, high) = (place(start).min(place(end)), place(start).max(place(end)));
            let middle = low.max(0.0).midpoint(high.min(place(to)));
            let one = from + u * middle;
            near(one, closest::point_segment(one, start, end))
        }
        _ => {
            order_around(&mut b, normal);
            if a.len() > 2 {
                order_around(&mut a, normal);
            }
            cut_to(&mut a, &b, normal, slack);
            (!a.is_empty()).then(|| a.iter().sum::<Vec3A>() / a.len() as f32)
        }
    }
}

/// Puts the corners of a convex polygon in order, counter-clockwise as seen against a normal.
fn order_around(corners: &mut Foremost, normal: Vec3A) {
    let middle = corners.iter().sum::<Vec3A>() / corners.len() as f32;
    let (x, y) = normal.any_orthonormal_pair();
    let angle = |corner: &Vec3A| {
        let offset = *corner - middle;
        ops::atan2(offset.dot(y), offset.dot(x))
    };
    corners.sort_by(|one, other| angle(one).total_cmp(&angle(other)));
}

/// Cuts a polygon, a segment or a point to what is over a convex polygon, or within a slack of it
/// (Sutherland and Hodgman, *Reentrant Polygon Clipping*, 1974).
fn cut_to(piece: &mut Foremost, corners: &[Vec3A], normal: Vec3A, slack: f32) {
    for [from, to] in border(corners) {
        let Some(outwards) = (to - from).cross(normal).try_normalize() else {
            continue;
        };
        let height = |point: Vec3A| (point - from).dot(outwards) - slack;
        if piece.iter().all(|point| height(*point) <= 0.0) {
            continue;
        }
        let whole = std::mem::take(piece);
        // A segment has one side, and an end that begins none.
        let sides = if whole.len() > 2 {
            whole.len()
        } else {
            whole.len() - 1
        };
        if let Some(end) = whole.get(sides)
            && height(*end) <= 0.0
        {
            piece.push(*end);
        }
        for [from, to] in border(&whole).take(sides) {
            let [at_from, at_to] = [height(from), height(to)];
            if at_from <= 0.0 {
                piece.push(from);
            }
            if (at_from < 0.0 && at_to > 0.0) || (at_from > 0.0 && at_to < 0.0) {
                piece.push(from.lerp(to, at_from / (at_from - at_to)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f32, y: f32, half: f32) -> Foremost {
        // Not in order.
        [(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)]
            .map(|(right, up)| Vec3A::new(x + right * half, y + up * half, 2.0))
            .into_iter()
            .collect()
    }

    #[track_caller]
    fn check(a: Foremost, b: Foremost, expected: Option<Vec3A>) {
        for found in [
            shared_point(a.clone(), b.clone(), Vec3A::Z, 1e-5),
            shared_point(b, a, Vec3A::NEG_Z, 1e-5),
        ] {
            match (found, expected) {
                (Some(found), Some(expected)) => {
                    assert!(found.distance(expected) < 1e-4, "{found} {expected}");
                }
                _ => assert_eq!(found.is_some(), expected.is_some()),
            }
        }
    }

    #[test]
    fn corners_edges_and_faces_share_their_middle() {
        let at = |x: f32, y: f32| Vec3A::new(x, y, 2.0);
        let set = |points: &[Vec3A]| Foremost::from_slice(points);
        let whole = || square(0.0, 0.0, 1.0);
        check(whole(), square(1.5, 0.5, 1.0), Some(at(0.75, 0.25)));
        check(whole(), square(0.5, 0.0, 0.25), Some(at(0.5, 0.0)));
        check(whole(), square(3.0, 0.0, 1.0), None);
        check(whole(), set(&[at(0.5, 0.5)]), Some(at(0.5, 0.5)));
        check(whole(), set(&[at(0.5, 1.5)]), None);
        check(
            whole(),
            set(&[at(0.0, 0.0), at(3.0, 0.0)]),
            Some(at(0.5, 0.0)),
        );
        check(
            whole(),
            set(&[at(-3.0, 0.5), at(3.0, 0.5)]),
            Some(at(0.0, 0.5)),
        );
        check(whole(), set(&[at(-3.0, 5.0), at(3.0, 5.0)]), None);
        let edge = || set(&[at(-1.0, 0.0), at(1.0, 0.0)]);
        check(
            edge(),
            set(&[at(0.5, -1.0), at(0.5, 3.0)]),
            Some(at(0.5, 0.0)),
        );
        check(
            edge(),
            set(&[at(0.0, 0.0), at(3.0, 0.0)]),
            Some(at(0.5, 0.0)),
        );
        check(edge(), set(&[at(9.0, 0.0), at(2.0, 0.0)]), None);
        check(edge(), set(&[at(0.0, 1.0), at(0.0, 2.0)]), None);
        check(edge(), set(&[at(1.0, 0.0)]), Some(at(1.0, 0.0)));
        check(
            set(&[at(1.0, 0.0)]),
            set(&[at(1.0, 0.0)]),
            Some(at(1.0, 0.0)),
        );
    }
}
