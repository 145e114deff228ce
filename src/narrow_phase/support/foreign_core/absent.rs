//! The cores of somebody else's shapes without the feature `rapier`: there are none.

use std::{convert::Infallible, marker::PhantomData};

use bevy::math::DVec3;

#[derive(Clone, Copy)]
pub struct ForeignCore<'a>(Infallible, PhantomData<&'a ()>);

impl ForeignCore<'_> {
    pub const fn furthest(self, _: DVec3) -> DVec3 {
        match self.0 {}
    }
}
