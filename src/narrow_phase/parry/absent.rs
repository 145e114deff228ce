//! What the exact tests hear of Rapier's shapes without the feature `rapier`: there are none.

use bevy::math::{Dir3, Vec3, Vec3A, primitives::HalfSpace};
use bevy::transform::components::Transform;

use crate::narrow_phase::{
    answer::{Impact, LocalContact, Passage},
    cast_options::RayCastOptions,
    frame::{
        placed::{Placed, PlacedPair},
        workspace::Workspace,
    },
    shape::Shape,
};

#[inline]
pub fn as_own(_: Placed) -> Option<(Shape, Transform)> {
    None
}

#[inline]
pub fn with_own<T>(_: Placed, _: Placed, _: impl FnOnce(Placed, Placed) -> T) -> Option<T> {
    None
}

#[inline]
pub fn with_own_cuboids<T>(_: &PlacedPair, _: impl FnOnce(&PlacedPair) -> T) -> Option<T> {
    None
}

#[inline]
pub fn side(_: Placed, _margin: f32) -> Option<HalfSpace> {
    None
}

#[inline]
pub fn intersects(_: Placed, _: Placed, _tolerance: f32, _: &mut Workspace) -> bool {
    false
}

#[inline]
pub fn enclosed(_: &PlacedPair, _: &mut Workspace) -> Option<Vec3A> {
    None
}

#[inline]
pub fn contact(_: Placed, _: Placed, _tolerance: f32) -> Option<LocalContact> {
    None
}

#[inline]
pub fn closest_point(_: Placed, _point: Vec3) -> Option<Vec3> {
    None
}

#[inline]
pub fn closest_points(_: Placed, _: Placed) -> Option<[Vec3A; 2]> {
    None
}

#[inline]
pub fn cast_ray(_: Placed, _origin: Vec3, _: Dir3, _max_distance: f32) -> Option<Impact> {
    None
}

#[inline]
pub fn sweep(_: Placed, _: Dir3, _max_distance: f32, _: Placed) -> Option<Impact> {
    None
}

#[inline]
pub fn cast_ray_with(
    _: Placed,
    _origin: Vec3,
    _: Dir3,
    _max_distance: f32,
    _: &RayCastOptions,
) -> Option<Impact> {
    None
}

#[inline]
pub fn passage(
    _: Placed,
    _origin: Vec3,
    _: Dir3,
    _max_distance: f32,
    _enter: Impact,
) -> Option<Passage> {
    None
}
