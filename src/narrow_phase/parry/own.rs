//! Rapier's cuboids and balls as shapes of our own.

use bevy::math::Vec3;
use bevy::transform::components::Transform;

use crate::narrow_phase::{
    frame::{
        case::Case,
        placed::{Placed, PlacedPair},
    },
    shape::Shape,
};

/// Two cuboids, of which one or both are Rapier's, as cuboids of our own: parry's test for them
/// asserts in debug builds that rounding is kind, which it is not where they touch.
pub fn with_own_cuboids<T>(pair: &PlacedPair, f: impl FnOnce(&PlacedPair) -> T) -> Option<T> {
    let own = |placed: Placed| match placed.shape {
        Shape::Cuboid { .. } => Some((placed.shape.clone(), *placed.transform)),
        Shape::Rapier(shape) => {
            let half_size = shape.as_cuboid()?.half_extents;
            let transform = placed.transform.with_scale(Vec3::ONE);
            Some((Shape::Cuboid { half_size }, transform))
        }
        _ => None,
    };
    let ((a, at_a), (b, at_b)) = (own(pair.a)?, own(pair.b)?);
    // Boxes and tolerance are the same.
    Some(f(&PlacedPair {
        a: Placed::new(&a, &at_a),
        b: Placed::new(&b, &at_b),
        ..*pair
    }))
}

/// A shape of Rapier's as one of ours, if it is a cuboid or a ball.
pub fn as_own(placed: Placed) -> Option<(Shape, Transform)> {
    let Shape::Rapier(shape) = placed.shape else {
        return None;
    };
    let cuboid = shape.as_cuboid().map(|cuboid| Shape::Cuboid {
        half_size: cuboid.half_extents,
    });
    let own = cuboid.or_else(|| {
        shape.as_ball().map(|ball| Shape::Sphere {
            radius: ball.radius,
        })
    })?;
    Some((own, placed.transform.with_scale(Vec3::ONE)))
}

/// Calls `f` with two shapes, of which one or both are Rapier's cuboids or balls, as ours. `None`
/// if neither is, or one is another shape of Rapier's.
pub fn with_own<T>(a: Placed, b: Placed, f: impl FnOnce(Placed, Placed) -> T) -> Option<T> {
    let known = |placed: Placed| match placed.shape {
        Shape::Rapier(_) => as_own(placed),
        shape => Some((shape.clone(), *placed.transform)),
    };
    if Case::of(a.shape, b.shape) != Case::Foreign {
        return None;
    }
    let ((a, at_a), (b, at_b)) = (known(a)?, known(b)?);
    Some(f(Placed::new(&a, &at_a), Placed::new(&b, &at_b)))
}
