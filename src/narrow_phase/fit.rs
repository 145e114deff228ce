//! What is decided by boxes in the world alone.
//!
//! The exact tests need where a shape is, how it is turned and what it is: two lines of memory each,
//! in no order. The box of an upright cuboid, or of a ball, says all of that, but for how much it
//! was grown; and of the boxes that a broad phase finds, most overlap by more.

use bevy::math::{Quat, Vec3A, bounding::Aabb3d};

use super::{
    frame::placed::{Placed, ROUNDING},
    settings::{Exactness, NarrowPhase},
    shape::Shape,
    stage::{Stage, StageCounters},
};

/// What the box of a shape in the world says of the shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Fit {
    /// That it is inside, and no more.
    #[default]
    Loose,
    /// It is the box, but for what that was grown by.
    Cuboid,
    /// It is the ball in the box, but for the same.
    Ball,
}

/// Sizes up to which no square overflows: of larger ones, boxes say nothing.
const LARGEST: f32 = 1e18;

impl Fit {
    /// What the box [around](NarrowPhase::world_aabb) a shape says of it. Another box, stretched
    /// along the way of the shape, says no more than that it is inside.
    #[inline]
    pub(crate) fn of(placed: Placed) -> Self {
        match placed.shape {
            Shape::Cuboid { .. } if placed.transform.rotation == Quat::IDENTITY => Self::Cuboid,
            Shape::Sphere { .. } => Self::Ball,
            _ => Self::Loose,
        }
    }
}

/// The core of a box: what is certainly part of the shape.
struct Core {
    min: Vec3A,
    max: Vec3A,
}

impl Core {
    #[inline]
    fn of(aabb: &Aabb3d, growth: f32) -> Self {
        Self {
            min: aabb.min + growth,
            max: aabb.max - growth,
        }
    }

    /// Twice the centre and twice the least radius of the ball in it.
    #[inline]
    fn ball(&self) -> (Vec3A, f32) {
        (self.min + self.max, (self.max - self.min).min_element())
    }

    #[inline]
    fn overlaps(&self, other: &Self) -> bool {
        let sizes = (self.max - self.min).abs() + (other.max - other.min).abs();
        let are_some = self.min.cmple(self.max) & other.min.cmple(other.max);
        let meet = self.min.cmple(other.max) & self.max.cmpge(other.min);
        (are_some & meet & sizes.cmple(Vec3A::splat(LARGEST))).all()
    }
}

impl NarrowPhase {
    /// More than a box around a shape was grown by.
    #[inline]
    fn most_growth(&self, aabb: &Aabb3d) -> f32 {
        let size = (aabb.max - aabb.min).max_element();
        let far = aabb.min.abs().max(aabb.max.abs()).max_element();
        self.tolerance() + 4.0 * (ROUNDING * size + f32::EPSILON * far)
    }

    /// Returns `true` if two shapes are in contact for certain, by the boxes
    /// [around](Self::world_aabb) them; counted at the stages at which [`intersects`](Self::intersects) would find out.
    #[inline]
    pub(crate) fn certainly_intersect(
        &self,
        (fit_a, a): (Fit, &Aabb3d),
        (fit_b, b): (Fit, &Aabb3d),
        counters: &mut StageCounters,
    ) -> bool {
        if self.exactness() != Exactness::Cheapest {
            return false;
        }
        let (core_a, core_b) = (
            Core::of(a, self.most_growth(a)),
            Core::of(b, self.most_growth(b)),
        );
        match (fit_a, fit_b) {
            (Fit::Loose, _) | (_, Fit::Loose) => false,
            (Fit::Cuboid, Fit::Cuboid) => {
                let certain = core_a.overlaps(&core_b);
                if certain {
                    counters.count(Stage::Boxes, Some(true));
                }
                certain
            }
            (Fit::Ball, Fit::Ball) => {
                let ((center_a, radius_a), (center_b, radius_b)) = (core_a.ball(), core_b.ball());
                let reach = radius_a + radius_b;
                let certain = radius_a >= 0.0
                    && radius_b >= 0.0
                    && reach <= LARGEST
                    && center_a.distance_squared(center_b) <= reach * reach * (1.0 - ROUNDING);
                if certain {
                    counters.count(Stage::Bounds, None);
                    counters.count(Stage::Spheres, Some(true));
                }
                certain
            }
            (Fit::Cuboid, Fit::Ball) => ball_in_cuboid(&core_a, &core_b, counters),
            (Fit::Ball, Fit::Cuboid) => ball_in_cuboid(&core_b, &core_a, counters),
        }
    }
}

#[inline]
fn ball_in_cuboid(cuboid: &Core, ball: &Core, counters: &mut StageCounters) -> bool {
    let (center, radius) = ball.ball();
    let (min, max) = (cuboid.min * 2.0, cuboid.max * 2.0);
    let size = radius + (max - min).max_element();
    let certain = radius >= 0.0
        && min.cmple(max).all()
        && size <= LARGEST
        && center.distance_squared(center.max(min).min(max)) <= radius * radius * (1.0 - ROUNDING);
    if certain {
        counters.count(Stage::Bounds, None);
        counters.count(Stage::Spheres, None);
        counters.count(Stage::Boxes, Some(true));
    }
    certain
}

#[cfg(test)]
mod tests {
    use bevy::{math::Vec3, transform::components::Transform};
    use fastrand::Rng;

    use super::*;
    use crate::narrow_phase::Workspace;

    /// What is certain is so, counted alike; and most is certain.
    #[test]
    fn what_is_certain_is_so() {
        let mut rng = Rng::with_seed(7);
        let tests = NarrowPhase::default();
        let mut workspace = Workspace::default();
        let (mut touching, mut certain) = (0, 0);
        for round in 0..200_000 {
            let size = 10_f32.powi(rng.i32(-3..4));
            let far = if rng.bool() {
                0.0
            } else {
                size * 10_f32.powi(rng.i32(0..5))
            };
            let mut vector = |size: f32| Vec3::from_array([0; 3].map(|_| (rng.f32() - 0.5) * size));
            let origin = vector(far);
            let [a, b] = [0, 1].map(|of| {
                let shape = if (round >> of) & 1 == 0 {
                    Shape::from_half_size(vector(size))
                } else {
                    Shape::sphere(vector(size).x.abs())
                };
                (
                    shape,
                    Transform::from_translation(origin + vector(size * 0.9))
                        .with_scale(vector(3.0)),
                )
            });
            let [a, b] = [&a, &b].map(|(shape, at)| Placed::new(shape, at));
            let (Ok(box_a), Ok(box_b)) = (tests.world_aabb(a), tests.world_aabb(b)) else {
                panic!("all is finite");
            };
            let fits = (Fit::of(a), Fit::of(b));
            assert!(fits.0 != Fit::Loose && fits.1 != Fit::Loose);
            workspace.counters = StageCounters::default();
            let verdict = tests.intersects(a, b, &mut workspace);
            let mut counters = StageCounters::default();
            let is_certain =
                tests.certainly_intersect((fits.0, &box_a), (fits.1, &box_b), &mut counters);
            touching += u32::from(verdict);
            certain += u32::from(is_certain);
            if is_certain {
                assert!(verdict, "{a:?} {b:?}");
                assert_eq!(counters, workspace.counters, "{a:?} {b:?}");
            }
        }
        assert!(certain * 5 > touching * 4, "{certain} of {touching}");
    }
}
