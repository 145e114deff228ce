//! Shapes of somebody else's without the feature `rapier`: there are none.

use std::{convert::Infallible, marker::PhantomData};

use bevy::math::{DVec3, Dir3, Vec3};

use super::convex::{Convex, Isometry};
use super::probe::{Probe, Search};
use crate::narrow_phase::{answer::Impact, frame::placed::Placed};

#[derive(Clone, Copy)]
#[expect(dead_code, reason = "nobody else is there")]
pub enum ForeignPart<'a> {
    Convex(Convex<'a>),
    HalfSpace(DVec3, Isometry),
    Whole(Foreign<'a>),
}

#[derive(Clone, Copy)]
pub struct Foreign<'a>(Infallible, PhantomData<&'a ()>);

impl Foreign<'_> {
    pub const fn isometry(&self) -> Isometry {
        match self.0 {}
    }

    pub const fn is_compound(&self) -> bool {
        match self.0 {}
    }

    pub const fn has_triangles(&self) -> bool {
        match self.0 {}
    }

    pub const fn local_box(&self) -> [DVec3; 2] {
        match self.0 {}
    }

    pub fn each(&self, _: &Probe, _: &Search, _: &mut dyn FnMut(ForeignPart) -> bool) -> bool {
        match self.0 {}
    }
}

#[inline]
pub fn ray_by_itself(_: Placed, _origin: Vec3, _: Dir3, _: f32, _solid: bool) -> Option<Impact> {
    None
}

#[inline]
pub fn closest_by_itself(_: Placed, _point: Vec3) -> Option<Vec3> {
    None
}
