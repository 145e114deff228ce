//! Whether two on their way never come near each other: by the balls and boxes around them, which
//! rules out most of those whose ways lead through the same place.

use bevy::math::{Vec3A, Vec3Swizzles};

use super::{moments::Moments, moving::Moving};
use crate::narrow_phase::frame::{oriented_box::OrientedBox, placed::ROUNDING};

/// Sizes beyond this have squares that 32-bit floats do not hold.
const LARGE: f32 = 1e9;

/// A component of a way that is less, is as good as none, and may be divided by.
const LEAST: f32 = 1e-20;

impl Moments<'_> {
    /// Returns `true` if the two are certainly not in contact at any moment.
    pub fn pass_by(&self) -> bool {
        let (origin, way) = (self.a.start.translation, Vec3A::from(self.velocity()));
        let around = |moving: &Moving| OrientedBox::of(moving.shape(), &moving.start, origin).ok();
        let (Some(a), Some(b)) = (around(self.a), around(self.b)) else {
            return false;
        };
        // Wherever it turns, it is in a ball around what it turns about.
        let ball = |moving: &Moving, bounds: &OrientedBox| {
            let middle = Vec3A::from(moving.start.translation - origin);
            if moving.turns() {
                (middle, middle.distance(bounds.center) + bounds.radius)
            } else {
                (bounds.center, bounds.radius)
            }
        };
        let ((center_a, radius_a), (center_b, radius_b)) = (ball(self.a, &a), ball(self.b, &b));
        let offset = center_b - center_a;
        let positions = [self.a.start, self.a.end, self.b.start, self.b.end];
        let far = positions.iter().fold(0.0, |far: f32, pose| {
            far.max(pose.translation.abs().max_element())
        });
        let radii = radius_a + radius_b;
        let extent = radii + far;
        if extent.is_nan() || extent >= LARGE {
            return false;
        }
        // What counts as contact anywhere, and what rounding makes of positions and times.
        let slack = 2.0 * self.tests.tolerance() + ROUNDING * (2.0 * radii + 4.0 * far);
        let along = offset.dot(way) / way.length_squared();
        let nearest = offset - way * if along > 0.0 { along.min(1.0) } else { 0.0 };
        let reach = radii + slack;
        if nearest.length_squared() > reach * reach {
            return true;
        }
        !self.turn() && are_apart(&a, &b, way, slack)
    }
}

/// Whether two boxes never come nearer to each other than a slack, of which the first goes a way
/// without turning: whether planes of the 15 directions that may part two boxes do so all the time,
/// one after the other.
fn are_apart(a: &OrientedBox, b: &OrientedBox, way: Vec3A, slack: f32) -> bool {
    let mut window = Window {
        slack,
        enter: Vec3A::ZERO,
        leave: Vec3A::ONE,
    };
    let (to_a, to_b) = (a.axes.transpose(), b.axes.transpose());
    let offset = b.center - a.center;
    let (t, d) = (to_a * offset, to_a * way);
    // In the frame of the first: columns are the axes of the second.
    let axes = to_a * b.axes;
    let abs = axes.abs();
    window.ask(t, d, a.half + abs * b.half);
    if window.is_closed() {
        return true;
    }
    if a.axes == b.axes {
        return false;
    }
    window.ask(to_b * offset, to_b * way, b.half + abs.transpose() * a.half);
    if window.is_closed() {
        return true;
    }
    for j in 0..3 {
        // The directions across edges are the columns e0×c, e1×c and e2×c, with one lane for each;
        // they are no longer than 1, so that the slack is no less than it should be.
        let (c, c_abs) = (axes.col(j), abs.col(j));
        let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
        let reach_a = a.half.yzx() * c_abs.zxy() + a.half.zxy() * c_abs.yzx();
        let reach_b = abs.col(j2) * b.half[j1] + abs.col(j1) * b.half[j2];
        window.ask(c.cross(t), c.cross(d), reach_a + reach_b);
    }
    window.is_closed()
}

/// From when on, and until when, planes let two touch; three of them at a time.
struct Window {
    slack: f32,
    enter: Vec3A,
    leave: Vec3A,
}

impl Window {
    /// Asks the slabs of three directions: how far the first is from the middle of each, how fast it
    /// comes there, and how far the two reach.
    #[inline]
    fn ask(&mut self, from_middle: Vec3A, velocity: Vec3A, reach: Vec3A) {
        let reach = reach + self.slack;
        let stands = velocity.abs().cmplt(Vec3A::splat(LEAST));
        let velocity = Vec3A::select(stands, Vec3A::splat(LEAST), velocity);
        let (one, other) = (
            (from_middle - reach) / velocity,
            (from_middle + reach) / velocity,
        );
        self.enter = self.enter.max(one.min(other));
        self.leave = self.leave.min(one.max(other));
    }

    #[inline]
    fn is_closed(&self) -> bool {
        self.enter.max_element() > self.leave.min_element()
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{Quat, Vec3};
    use bevy::transform::components::Transform;
    use proptest::prelude::*;

    use super::*;
    use crate::narrow_phase::{
        NarrowPhase, Placed, Workspace,
        cast::tests::{placed, vectors},
    };

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 1024, ..ProptestConfig::default() })]

        /// What is ruled out is in contact at no moment; and most that is not near is ruled out.
        #[test]
        fn those_that_pass_by_are_never_in_contact(
            (one, at_one) in placed(),
            (two, at_two) in placed(),
            (way, other) in (vectors(6.0), vectors(2.0)),
            (turns, axis, far) in (any::<bool>(), vectors(3.0), prop_oneof![Just(0.0f32), Just(1e4)]),
        ) {
            let moved = |at: Transform, way: Vec3| at.with_translation(at.translation + way);
            let away = Vec3::new(far, -far, far);
            let (at_one, at_two) = (moved(at_one, away), moved(at_two, away));
            let mut end = moved(at_one, way);
            if turns {
                end.rotation = Quat::from_scaled_axis(axis) * end.rotation;
            }
            let (a, b) = (Moving::new(&one, &at_one, &end), Moving::new(&two, &at_two, &moved(at_two, other)));
            let tests = NarrowPhase::default();
            let moments = Moments { tests: &tests, a: &a, b: &b };
            let pass_by = moments.pass_by();
            let workspace = &mut Workspace::default();
            for time in (0..=256).map(|moment| moment as f32 / 256.0) {
                let (there_a, there_b) = (a.at(time), b.at(time));
                let touch = tests.intersects(Placed::new(&one, &there_a), Placed::new(&two, &there_b), workspace);
                prop_assert!(!(touch && pass_by), "in contact at {time}");
            }
        }
    }

    #[test]
    fn those_whose_ways_cross_are_told_apart() {
        let shape = crate::narrow_phase::Shape::cuboid(1.0, 1.0, 1.0);
        let turn =
            |angle| Transform::from_rotation(Quat::from_axis_angle(Vec3::ONE.normalize(), angle));
        let tests = NarrowPhase::default();
        for angle in [0.0, 1.0] {
            let go = |from: Vec3, to: Vec3| [from, to].map(|at| turn(angle).with_translation(at));
            // One is there when the other is not yet.
            let ([from, to], [start, end]) = (
                go(Vec3::X * -4.0, Vec3::X * 4.0),
                go(Vec3::Y * -1.0, Vec3::Y * -8.0),
            );
            let (a, b) = (
                Moving::new(&shape, &from, &to),
                Moving::new(&shape, &start, &end),
            );
            assert!(
                Moments {
                    tests: &tests,
                    a: &a,
                    b: &b
                }
                .pass_by()
            );
            let [start, end] = go(Vec3::Y * -4.0, Vec3::Y * 4.0);
            let b = Moving::new(&shape, &start, &end);
            assert!(
                !Moments {
                    tests: &tests,
                    a: &a,
                    b: &b
                }
                .pass_by()
            );
        }
    }
}
