//! Rapier's shapes as what they are of ours.

use bevy::transform::components::Transform;

#[cfg(feature = "rapier")]
use crate::narrow_phase::shape::without_scale;
use crate::narrow_phase::{
    frame::{case::Case, placed::Placed},
    shape::Shape,
};

/// A shape of Rapier's as one of ours, if it is one.
#[cfg(feature = "rapier")]
pub fn as_own(placed: Placed) -> Option<(Shape, Transform)> {
    let Shape::Rapier(shape) = placed.shape else {
        return None;
    };
    // Its scale is in it.
    let scale = without_scale(placed.transform.scale);
    let transform = placed.transform.with_scale(scale);
    Some((shape.own()?.clone(), transform))
}

/// There are none.
#[cfg(not(feature = "rapier"))]
#[inline]
pub const fn as_own(_: Placed) -> Option<(Shape, Transform)> {
    None
}

/// Calls `f` with two shapes, of which one or both are Rapier's, as what they are of ours. `None` if
/// neither is Rapier's, or one is none of ours.
#[inline]
pub fn with_own<T>(a: Placed, b: Placed, f: impl FnOnce(Placed, Placed) -> T) -> Option<T> {
    if Case::of(a.shape, b.shape) != Case::Foreign {
        return None;
    }
    let known = |placed: Placed| {
        as_own(placed).or_else(|| {
            let is_foreign = Case::of(placed.shape, placed.shape) == Case::Foreign;
            (!is_foreign).then(|| (placed.shape.clone(), *placed.transform))
        })
    };
    let ((a, at_a), (b, at_b)) = (known(a)?, known(b)?);
    Some(f(Placed::new(&a, &at_a), Placed::new(&b, &at_b)))
}
