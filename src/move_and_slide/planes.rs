//! The shortest way to the right side of several planes.

use bevy::math::DVec3;
use smallvec::SmallVec;

/// So many planes count at most: of more, those that are most alike are taken as one.
pub const MOST_PLANES: usize = 10;

/// How far on the wrong side of a plane counts as on it, as a share of the lengths at hand.
const ROUNDING: f64 = 1e-9;
/// Two planes whose angle has a sine below this meet nowhere.
const PARALLEL: f64 = 1e-7;

/// All points `x` with `normal · x >= offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    pub normal: DVec3,
    pub offset: f64,
}

/// A few planes.
pub type Planes = SmallVec<[Plane; MOST_PLANES]>;

/// Adds a plane. One that is as good as there is replaces it if it asks for more; of too many, the one that is most
/// like it goes.
pub fn add(planes: &mut Planes, plane: Plane) {
    // A unit vector of 32-bit floats is none of 64.
    let Some(normal) = plane.normal.try_normalize() else {
        return;
    };
    let plane = Plane { normal, ..plane };
    const ALIKE: f64 = 1.0 - 1e-7;
    let is_full = planes.len() >= MOST_PLANES;
    let likeness = |other: &Plane| other.normal.dot(plane.normal);
    let alike = planes
        .iter_mut()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    match alike {
        Some(alike) if likeness(alike) > ALIKE => {
            alike.offset = alike.offset.max(plane.offset);
        }
        Some(alike) if is_full => *alike = plane,
        _ => planes.push(plane),
    }
}

/// The shortest vector that is on the right side of all planes; `None` if there is none.
///
/// It is zero, or the foot of the perpendicular on one plane, on the line where two of them meet, or the point where three
/// do: each is tried. O(n⁴), for the few that there are.
pub fn shortest(planes: &[Plane]) -> Option<DVec3> {
    let size = planes
        .iter()
        .fold(0.0_f64, |size, plane| size.max(plane.offset.abs()));
    let slack = ROUNDING * size;
    let is_inside = |x: DVec3| {
        planes
            .iter()
            .all(|plane| plane.normal.dot(x) >= plane.offset - slack * 4.0)
    };
    if is_inside(DVec3::ZERO) {
        return Some(DVec3::ZERO);
    }
    let mut best: Option<DVec3> = None;
    let mut offer = |x: Option<DVec3>| {
        if let Some(x) = x
            && best.is_none_or(|best| x.length_squared() < best.length_squared())
            && is_inside(x)
        {
            best = Some(x);
        }
    };
    for (i, a) in planes.iter().enumerate() {
        offer(Some(a.normal * a.offset));
        for (j, b) in planes.iter().enumerate().skip(i + 1) {
            offer(on_two(a, b));
            for c in &planes[j + 1..] {
                offer(on_three(a, b, c));
            }
        }
    }
    best
}

/// The shortest vector to the line where two planes meet.
fn on_two(a: &Plane, b: &Plane) -> Option<DVec3> {
    let cosine = a.normal.dot(b.normal);
    let determinant = a.normal.cross(b.normal).length_squared();
    (determinant > PARALLEL * PARALLEL).then(|| {
        let of_a = (a.offset - cosine * b.offset) / determinant;
        let of_b = (b.offset - cosine * a.offset) / determinant;
        a.normal * of_a + b.normal * of_b
    })
}

/// The point where three planes meet.
fn on_three(a: &Plane, b: &Plane, c: &Plane) -> Option<DVec3> {
    let (bc, ca, ab) = (
        b.normal.cross(c.normal),
        c.normal.cross(a.normal),
        a.normal.cross(b.normal),
    );
    let determinant = a.normal.dot(bc);
    (determinant.abs() > PARALLEL)
        .then(|| (bc * a.offset + ca * b.offset + ab * c.offset) / determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(normal: DVec3, offset: f64) -> Plane {
        Plane {
            normal: normal.normalize(),
            offset,
        }
    }

    #[test]
    fn the_shortest_is_no_longer_than_any_that_is_inside() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut some = || DVec3::from_array(std::array::from_fn(|_| random.f64() * 2.0 - 1.0));
        let mut solved = 0;
        for count in (1..7).cycle().take(600) {
            let planes: Vec<_> = (0..count).map(|_| plane(some(), some().x.abs())).collect();
            let Some(found) = shortest(&planes) else {
                continue;
            };
            solved += 1;
            assert!(
                planes
                    .iter()
                    .all(|plane| plane.normal.dot(found) > plane.offset - 1e-7)
            );
            for _ in 0..300 {
                let other = some() * 3.0;
                if planes
                    .iter()
                    .all(|plane| plane.normal.dot(other) >= plane.offset)
                {
                    assert!(other.length() >= found.length() - 1e-9, "{planes:?}");
                }
            }
        }
        assert!(solved > 300, "{solved}");
    }

    #[test]
    fn what_closes_in_from_two_sides_has_no_way_out() {
        let planes = [plane(DVec3::X, 0.1), plane(DVec3::NEG_X, 0.1)];
        assert_eq!(shortest(&planes), None);
    }

    #[test]
    fn a_corner_of_one_degree_is_left_along_its_middle() {
        let angle = 0.5_f64.to_radians();
        let walls =
            [1.0, -1.0].map(|side| plane(DVec3::new(angle.sin(), side * angle.cos(), 0.0), 0.01));
        let found = shortest(&walls).unwrap();
        assert!(
            (found.x - 0.01 / angle.sin()).abs() < 1e-6 && found.y.abs() < 1e-9,
            "{found}"
        );
    }

    #[test]
    fn planes_stay_few() {
        let mut planes = Planes::new();
        for i in 0..50 {
            let angle = f64::from(i) * 0.1;
            add(
                &mut planes,
                plane(DVec3::new(angle.sin(), angle.cos(), 0.0), 0.0),
            );
            add(
                &mut planes,
                plane(DVec3::new(angle.sin(), angle.cos(), 0.0), 0.5),
            );
        }
        assert!(planes.len() <= MOST_PLANES && !planes.spilled());
        assert!(planes.iter().all(|plane| plane.offset == 0.5));
    }
}
