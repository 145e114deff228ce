//! Shapes on their way.

use bevy::math::bounding::{Aabb3d, BoundingVolume};
use bevy::math::{Vec3, Vec3A};
use bevy::transform::components::Transform;

use crate::narrow_phase::{
    error::BoundsError,
    frame::{approach::approach, oriented_box::OrientedBox, placed::Placed},
    settings::NarrowPhase,
    shape::Shape,
};

/// A shape on its way: from one position to another in a straight line, at constant speed, turning
/// at a constant rate by the shorter way.
///
/// Its size is that which it has at the end, all the way.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    shape: &'a Shape,
    pub(super) start: Transform,
    pub(super) end: Transform,
}

impl<'a> Moving<'a> {
    /// Makes a shape move from `start` to `end`.
    #[must_use]
    pub fn new(shape: &'a Shape, start: &Transform, end: &Transform) -> Self {
        Self {
            shape,
            start: start.with_scale(end.scale),
            end: *end,
        }
    }

    /// Makes a shape stay where it is.
    #[must_use]
    pub fn resting(placed: Placed<'a>) -> Self {
        Self::new(placed.shape, placed.transform, placed.transform)
    }

    /// Returns the shape that moves.
    #[must_use]
    pub const fn shape(&self) -> &'a Shape {
        self.shape
    }

    /// Returns where the shape is after a share of its way, 0 to 1.
    #[must_use]
    pub fn at(&self, time: f32) -> Transform {
        let rotation = if self.turns() {
            self.start.rotation.slerp(self.end.rotation, time)
        } else {
            self.end.rotation
        };
        Transform {
            translation: self.start.translation + self.way() * time,
            rotation,
            scale: self.end.scale,
        }
    }

    /// From the start to the end, but for turns.
    pub(super) fn way(&self) -> Vec3 {
        self.end.translation - self.start.translation
    }

    pub(super) fn turns(&self) -> bool {
        self.start.rotation != self.end.rotation
    }

    /// What is left of the way after a share of it.
    pub(crate) fn after(&self, time: f32) -> Self {
        Self {
            start: self.at(time),
            ..*self
        }
    }

    /// On a way beside its own.
    pub(super) fn beside(self, by: Vec3) -> Self {
        self.along(self.start.translation + by, self.end.translation + by)
    }

    /// Turning as it does, on another way.
    pub(crate) fn along(self, from: Vec3, to: Vec3) -> Self {
        let (start, end) = (
            Transform {
                translation: from,
                ..self.start
            },
            Transform {
                translation: to,
                ..self.end
            },
        );
        Self { start, end, ..self }
    }

    /// The axis about which it turns, in its origin, times the angle in radians.
    fn turn(&self) -> Vec3 {
        if !self.turns() {
            return Vec3::ZERO;
        }
        let turn = self.end.rotation.normalize() * self.start.rotation.normalize().inverse();
        let shorter = if turn.w < 0.0 { -turn } else { turn };
        shorter.to_scaled_axis()
    }

    /// How fast, per whole way, the part of it moves that turning moves fastest; infinite if it has
    /// no end.
    pub(super) fn turning_speed(&self) -> f32 {
        if self.turns() {
            self.turn().length() * self.reach().unwrap_or(f32::INFINITY)
        } else {
            0.0
        }
    }

    /// How fast, per whole way, a point moves that is part of the shape after a share of it.
    pub(crate) fn velocity_at(&self, time: f32, point: Vec3) -> Vec3 {
        self.way() + self.turn().cross(point - self.at(time).translation)
    }

    /// Returns `true` if two that meet with a normal, from this one to the other, do not meet again on
    /// their ways: two convex shapes that do not turn, and do not come nearer to each other.
    pub(crate) fn parts_from(&self, other: &Moving, normal: Vec3) -> bool {
        let is_straight = |moving: &Moving| moving.shape.kind().is_convex() && !moving.turns();
        is_straight(self) && is_straight(other) && !approach([self.way(), other.way()], normal)
    }

    /// How far the shape reaches from the point about which it turns.
    fn reach(&self) -> Result<f32, BoundsError> {
        let around_origin = OrientedBox::of(self.shape, &self.end, self.end.translation)?;
        Ok(around_origin.center.length() + around_origin.radius)
    }
}

impl NarrowPhase {
    /// Returns the box of a shape's way, given [that](Self::world_aabb) of its end and where it starts:
    /// [`swept_aabb`](Self::swept_aabb), but for rounding, without another look at the shape. `None`
    /// if it turns, or nothing finite comes of it.
    #[inline]
    pub(crate) fn stretched(
        &self,
        (shape, aabb): (&Shape, &Aabb3d),
        start: &Transform,
        end: &Transform,
    ) -> Option<Aabb3d> {
        let is_ball = matches!(shape, Shape::Sphere { .. });
        if start.rotation != end.rotation && !is_ball {
            return None;
        }
        let (start, end) = (Vec3A::from(start.translation), Vec3A::from(end.translation));
        let far = start.abs().max(aabb.min.abs()).max(aabb.max.abs());
        let rounding = 4.0 * f32::EPSILON * far.max_element();
        // Where it started, it was as far from its position as where it ends.
        let back = start - end;
        let stretched = Aabb3d {
            min: aabb.min + back.min(Vec3A::ZERO) - rounding,
            max: aabb.max + back.max(Vec3A::ZERO) + rounding,
        };
        (stretched.max - stretched.min)
            .is_finite()
            .then_some(stretched)
    }

    /// Returns the box to feed to a broad phase for all of a shape's way: see
    /// [`world_aabb`](Self::world_aabb). The smallest one if the shape does not turn.
    ///
    /// # Errors
    /// As for [`Shape::world_aabb`].
    #[doc(alias = "aabb")]
    pub fn swept_aabb(&self, moving: &Moving) -> Result<Aabb3d, BoundsError> {
        // Whatever a shape turns through is in a ball around the point that it turns about.
        let ball = if moving.turns() {
            Some(Shape::Sphere {
                radius: moving.reach()?,
            })
        } else {
            None
        };
        let aabb = |at: &Transform| match &ball {
            Some(ball) => self.world_aabb(Placed::new(
                ball,
                &Transform::from_translation(at.translation),
            )),
            None => self.world_aabb(Placed::new(moving.shape, at)),
        };
        Ok(aabb(&moving.start)?.merge(&aabb(&moving.end)?))
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;
    use proptest::prelude::*;

    use super::*;
    use crate::narrow_phase::cast::tests::{placed, vectors};

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 512, ..ProptestConfig::default() })]

        /// The box of the end, stretched, is that of the whole way.
        #[test]
        fn stretched_boxes_are_those_of_ways((shape, end) in placed(), way in vectors(6.0), far in prop_oneof![Just(0f32), Just(1e4)]) {
            let end = end.with_translation(end.translation + Vec3::new(far, far, -far));
            let start = end.with_translation(end.translation - way);
            let tests = NarrowPhase::default();
            let aabb = tests.world_aabb(Placed::new(&shape, &end)).unwrap();
            let expected = tests.swept_aabb(&Moving::new(&shape, &start, &end)).unwrap();
            let found = tests.stretched((&shape, &aabb), &start, &end).unwrap();
            let most = Vec3A::splat(16.0 * f32::EPSILON * (far + 16.0));
            prop_assert!((found.min - expected.min).abs().cmple(most).all(), "{found:?} {expected:?}");
            prop_assert!((found.max - expected.max).abs().cmple(most).all(), "{found:?} {expected:?}");
            for at in [&start, &end] {
                let exact = shape.world_aabb(at).unwrap();
                prop_assert!(found.min.cmple(exact.min).all() && found.max.cmpge(exact.max).all());
            }
            let turned = start.with_rotation(Quat::from_rotation_y(1.0) * start.rotation);
            let is_ball = matches!(shape, Shape::Sphere { .. });
            prop_assert_eq!(tests.stretched((&shape, &aabb), &turned, &end).is_some(), is_ball);
        }
    }
}
