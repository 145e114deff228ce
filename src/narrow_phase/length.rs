//! Lengths and directions of vectors whose squares may overflow, or underflow.

use bevy::math::{Dir3, Vec3, Vec3A};

/// Of a length below this, squares have lost digits.
const UNDERFLOW: f32 = 1e-15;

/// The length of a vector whose squares may overflow.
#[inline]
pub(super) fn length(v: Vec3A) -> f32 {
    let length = v.length();
    if length.is_finite() {
        length
    } else {
        safe_length(v)
    }
}

/// The length of a vector whose squares may overflow, or underflow.
pub(super) fn any_length(v: Vec3A) -> f32 {
    let length = v.length();
    if length.is_finite() && length > UNDERFLOW || v == Vec3A::ZERO {
        length
    } else {
        safe_length(v)
    }
}

/// The direction and length of a vector whose squares may overflow.
pub(super) fn direction_and_length(v: Vec3) -> Option<(Dir3, f32)> {
    let length = length(v.into());
    Some((Dir3::new(v / length).ok()?, length))
}

/// The direction of a vector whose squares may overflow, or underflow; zero for zero.
#[inline]
pub(super) fn unit(v: Vec3A) -> Vec3A {
    let unit = v.normalize_or_zero();
    if unit == Vec3A::ZERO {
        safe_unit(v)
    } else {
        unit
    }
}

#[cold]
fn safe_unit(v: Vec3A) -> Vec3A {
    (v / v.abs().max_element()).normalize_or_zero()
}

#[cold]
fn safe_length(v: Vec3A) -> f32 {
    let greatest = v.abs().max_element();
    (v / greatest).length() * greatest
}
