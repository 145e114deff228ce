//! Placed shapes, and two of them in a frame of their own.

use std::cmp::Ordering;

use bevy::transform::components::Transform;

use super::oriented_box::OrientedBox;
use crate::narrow_phase::{error::BoundsError, shape::Shape};

/// Rounding, as a share of the size of a pair: no tolerance can be less.
pub const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// A shape and where it is.
///
/// Rotations are normalised before use. In a hierarchy of entities the transform is the one in the
/// world: `GlobalTransform::compute_transform()`, which drops shear; the plugins do
/// [without that loss](crate::plugins::BoundsPlugin#sheared-shapes).
#[doc(alias = "pose")]
#[doc(alias = "isometry")]
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// What the object is made of.
    pub shape: &'a Shape,
    /// Its scale, rotation and position in the world.
    pub transform: &'a Transform,
}

impl<'a> Placed<'a> {
    /// Puts a shape where a transform says.
    #[inline]
    #[must_use]
    pub fn new(shape: &'a Shape, transform: &'a Transform) -> Self {
        Self { shape, transform }
    }
}

/// The two and whether they had to be swapped, in the order in which pairs are computed: it does
/// not depend on the order given, and so neither do verdicts. Only if all of position, turn, scale
/// and shape are equal does the order given remain.
#[inline]
pub fn in_order<'a>(a: Placed<'a>, b: Placed<'a>) -> (Placed<'a>, Placed<'a>, bool) {
    let key = |placed: Placed| {
        let Transform {
            translation,
            rotation,
            scale,
        } = *placed.transform;
        (
            translation.to_array(),
            rotation.to_array(),
            scale.to_array(),
            placed.shape.order_key(),
        )
    };
    // Most pairs differ in the first number.
    let (x_a, x_b) = (a.transform.translation.x, b.transform.translation.x);
    let ordering = x_a.partial_cmp(&x_b).filter(|ordering| ordering.is_ne());
    let by_key = || match key(a).partial_cmp(&key(b)) {
        Some(Ordering::Equal) => Some(a.shape.content_order(b.shape)),
        ordering => ordering,
    };
    match ordering.or_else(by_key) {
        Some(Ordering::Greater) => (b, a, true),
        _ => (a, b, false),
    }
}

/// Two placed shapes with their boxes, in a frame whose origin is the position of the first: 32-bit
/// floats are then as exact far from the world's origin as close to it.
#[derive(Clone, Copy, Debug)]
pub struct PlacedPair<'a> {
    pub a: Placed<'a>,
    pub b: Placed<'a>,
    pub box_a: OrientedBox,
    pub box_b: OrientedBox,
    /// The sum of the greatest half extents.
    pub size: f32,
    /// At least what rounding leaves uncertain at the size of the pair.
    pub tolerance: f32,
}

impl<'a> PlacedPair<'a> {
    #[inline]
    pub fn new(a: Placed<'a>, b: Placed<'a>, tolerance: f32) -> Result<Self, BoundsError> {
        let origin = a.transform.translation;
        let box_a = OrientedBox::of(a.shape, a.transform, origin);
        let box_b = OrientedBox::of(b.shape, b.transform, origin);
        let (box_a, box_b) = match (box_a, box_b) {
            (Ok(box_a), Ok(box_b)) => (box_a, box_b),
            // Of two errors, the one that says that nothing can be computed.
            (Err(BoundsError::NonFinite), _) => return Err(BoundsError::NonFinite),
            (_, Err(error)) | (Err(error), _) => return Err(error),
        };
        let size = box_a.half.max_element() + box_b.half.max_element();
        Ok(Self {
            a,
            b,
            box_a,
            box_b,
            size,
            tolerance: tolerance.max(ROUNDING * size),
        })
    }

    /// The pair of a point, as a sphere without size whose transform is a translation, and a shape.
    #[inline]
    pub fn of_point(point: Placed<'a>, b: Placed<'a>, tolerance: f32) -> Result<Self, BoundsError> {
        let origin = point.transform.translation;
        if !origin.is_finite() {
            return Err(BoundsError::NonFinite);
        }
        let box_b = OrientedBox::of(b.shape, b.transform, origin)?;
        let size = box_b.half.max_element();
        Ok(Self {
            a: point,
            b,
            box_a: OrientedBox::POINT,
            box_b,
            size,
            tolerance: tolerance.max(ROUNDING * size),
        })
    }

    /// The same pair with the two swapped; the frame stays.
    #[inline]
    pub fn swapped(self) -> Self {
        Self {
            a: self.b,
            b: self.a,
            box_a: self.box_b,
            box_b: self.box_a,
            ..self
        }
    }
}
