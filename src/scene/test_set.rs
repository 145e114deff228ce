//! The test sets: two planes of cubes that move toward each other and bounce off in the middle.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A generator of the test sets t0, t1, … of Swan, *Fast Collision Detection with an N-Objects
/// Octree*, 1994, section 3.1 and Figure 8.
///
/// Two parallel planes of cubes face each other across the plane x = 0. Each holds a central cube
/// and `rings` concentric square rings of cubes around it, ring k being the 8k places at Chebyshev
/// distance k in a lattice along y and z. Each ring is set back from the one inside it, away from
/// the other plane, so that the centres meet first and the ripple runs outward. Opposite cubes are
/// aligned face to face.
///
/// # Arithmetic
///
/// The default lengths are multiples of 1/32 and the default velocity is 1/16 per tick: positions
/// stay exact in `f32` at 64 ticks per second. The distance between opposite faces of ring k is an
/// odd number of half closing steps, 2 1/16 + k/2 = (16 + 4k + 1/2) · 1/8, so every pair first
/// overlaps half a step deep, and is half a step apart again one tick after its directions are
/// reversed. No pair is ever within rounding of touching at the end of a tick.
///
/// ```
/// use bevy_octree::scene::TestSet;
///
/// let t3 = TestSet::new(3);
/// assert_eq!(t3.name(), "t3");
/// assert_eq!(t3.object_count(), 98);
/// assert_eq!(t3.cubes().count(), 98);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[serde(deny_unknown_fields, default)]
pub struct TestSet {
    /// How many rings surround each central cube, at most [`TestSet::MAX_RINGS`].
    pub rings: u32,
    /// The side of a cube.
    pub side: f32,
    /// The distance between the centres of neighbours in a plane, larger than `side`.
    pub spacing: f32,
    /// The distance between the facing sides of the two central cubes at the start.
    pub gap: f32,
    /// How far a ring lies behind the one inside it.
    pub setback: f32,
    /// How far each cube moves per tick. Keep it below half of `side`, or cubes may pass through
    /// each other unseen.
    pub speed: f32,
}

impl Default for TestSet {
    /// The test set of Figure 8, t3.
    fn default() -> Self {
        Self {
            rings: 3,
            side: 1.0,
            spacing: 1.5,
            gap: 2.0625,
            setback: 0.25,
            speed: 0.0625,
        }
    }
}

/// One of the two planes of a [`TestSet`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Plane {
    /// The plane at negative x, which moves toward positive x.
    Left,
    /// The plane at positive x, which moves toward negative x.
    Right,
}

impl Plane {
    /// The sign of x on this plane's side.
    fn sign(self) -> f32 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }

    /// Returns `left` or `right`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// One cube of a [`TestSet`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestCube {
    /// The plane that it belongs to.
    pub plane: Plane,
    /// Its index within the plane, from the centre outward. Opposite cubes have the same index.
    pub index: usize,
    /// The ring that it belongs to, 0 for the central cube.
    pub ring: u32,
    /// Where its centre starts.
    pub position: Vec3,
    /// How it moves, in units per tick.
    pub velocity: Vec3,
}

/// What is wrong with the parameters of a [`TestSet`].
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TestSetError {
    /// More rings than [`TestSet::MAX_RINGS`].
    #[error("rings is {0}, expected at most {max}", max = TestSet::MAX_RINGS)]
    TooManyRings(u32),
    /// A length or speed is out of its range.
    #[error("{parameter} is {value}, expected {expected}")]
    OutOfRange {
        /// The name of the field.
        parameter: &'static str,
        /// Its value.
        value: f32,
        /// What it should have been.
        expected: &'static str,
    },
}

impl TestSet {
    /// The largest number of rings: 8 million cubes.
    pub const MAX_RINGS: u32 = 1000;

    /// Returns the test set with `rings` rings, all else at its default.
    #[must_use]
    pub fn new(rings: u32) -> Self {
        Self {
            rings,
            ..Self::default()
        }
    }

    /// Returns the report's name for the set: `t` and the number of rings.
    #[must_use]
    pub fn name(&self) -> String {
        format!("t{}", self.rings)
    }

    /// Returns how many cubes there are: 2 · (2r + 1)².
    #[must_use]
    pub fn object_count(&self) -> usize {
        // More than the most is an error of `check`, and no more than a large number here.
        let edge = (self.rings as usize).saturating_mul(2).saturating_add(1);
        edge.saturating_mul(edge).saturating_mul(2)
    }

    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the first parameter that is out of range: more rings than [`TestSet::MAX_RINGS`]; a
    /// value that is not finite and positive (`setback` may be 0); neighbours in a plane that touch
    /// (`spacing` not above `side`); or parameters that place the outermost cubes at infinity.
    pub fn check(&self) -> Result<(), TestSetError> {
        if self.rings > Self::MAX_RINGS {
            return Err(TestSetError::TooManyRings(self.rings));
        }
        let ensure = |holds: bool, parameter, value, expected| {
            holds.then_some(()).ok_or(TestSetError::OutOfRange {
                parameter,
                value,
                expected,
            })
        };
        for (parameter, value) in [
            ("side", self.side),
            ("spacing", self.spacing),
            ("gap", self.gap),
            ("speed", self.speed),
        ] {
            let holds = value.is_finite() && value > 0.0;
            ensure(holds, parameter, value, "a positive number")?;
        }
        let holds = self.setback.is_finite() && self.setback >= 0.0;
        ensure(holds, "setback", self.setback, "0 or a positive number")?;
        let holds = self.spacing > self.side;
        ensure(holds, "spacing", self.spacing, "more than side")?;
        // The outermost corner bounds every other coordinate.
        let outermost = self.center_x(self.rings) + self.side;
        ensure(
            outermost.is_finite(),
            "setback",
            self.setback,
            "rings at a finite distance",
        )?;
        let outermost = self.rings as f32 * self.spacing + self.side;
        ensure(
            outermost.is_finite(),
            "spacing",
            self.spacing,
            "cubes at a finite distance",
        )
    }

    /// Returns the cubes: the left plane from the centre outward, then the right plane in the same
    /// order.
    pub fn cubes(&self) -> impl Iterator<Item = TestCube> + use<> {
        let set = *self;
        [Plane::Left, Plane::Right]
            .into_iter()
            .flat_map(move |plane| set.plane(plane))
    }

    /// Returns the first tick at whose end ring `ring` of one plane touches that of the other, if
    /// nothing turns it away before.
    #[must_use]
    pub fn first_contact_tick(&self, ring: u32) -> u64 {
        let gap = f64::from(self.gap) + 2.0 * f64::from(ring) * f64::from(self.setback);
        (gap / (2.0 * f64::from(self.speed))).ceil() as u64
    }

    fn plane(self, plane: Plane) -> impl Iterator<Item = TestCube> {
        let velocity = Vec3::X * (-plane.sign() * self.speed);
        let cubes = (0..=self.rings).flat_map(move |ring| {
            let x = plane.sign() * self.center_x(ring);
            ring_places(ring)
                .map(move |place| (ring, (place.as_vec2() * self.spacing).extend(x).zxy()))
        });
        cubes
            .enumerate()
            .map(move |(index, (ring, position))| TestCube {
                plane,
                index,
                ring,
                position,
                velocity,
            })
    }

    /// How far the centres of a ring start from the plane x = 0.
    fn center_x(&self, ring: u32) -> f32 {
        0.5 * (self.gap + self.side) + ring as f32 * self.setback
    }
}

/// The lattice places (y, z) at Chebyshev distance `ring` from the origin.
fn ring_places(ring: u32) -> impl Iterator<Item = IVec2> {
    let ring = ring as i32;
    (-ring..=ring).flat_map(move |y| {
        // Rows at the rim are full; the others have their two ends only.
        let step = if y.abs() == ring { 1 } else { 2 * ring };
        (-ring..=ring)
            .step_by(step as usize)
            .map(move |z| IVec2::new(y, z))
    })
}

pub(super) fn register(app: &mut App) {
    app.register_type::<TestSet>();
}

#[cfg(test)]
mod tests;
