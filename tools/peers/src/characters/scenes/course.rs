//! Where a character wants to go.

use bevy::math::{Vec2, Vec3};

use crate::characters::SPEED;

/// A turn comes no sooner than after so many ticks, and no later than after the second.
const TURNS: [u32; 2] = [40, 160];

/// Where a character wants to go.
#[derive(Clone, Debug)]
pub enum Course {
    /// The same way always; or nowhere, if that is zero.
    Straight(Vec2),
    /// Straight on, and now and then another way.
    Wander(Wander),
}

/// A course of straight lines.
#[derive(Clone, Debug)]
pub struct Wander {
    random: fastrand::Rng,
    heading: Vec2,
    /// Ticks until it turns.
    left: u32,
    /// It turns back where it is further than this from the middle along an axis.
    reach: f32,
}

impl Course {
    /// One of straight lines. Those of different seeds have nothing to do with each other.
    pub fn wander(seed: u64, reach: f32) -> Self {
        Self::Wander(Wander {
            random: fastrand::Rng::with_seed(seed),
            heading: Vec2::X,
            left: 0,
            reach,
        })
    }

    /// The velocity that is wanted in the next tick, in the plane.
    pub fn wish(&mut self, position: Vec3) -> Vec3 {
        let heading = match self {
            Self::Straight(heading) => *heading,
            Self::Wander(wander) => wander.heading(Vec2::new(position.x, position.z)),
        };
        Vec3::new(heading.x, 0.0, heading.y) * SPEED
    }
}

impl Wander {
    fn heading(&mut self, position: Vec2) -> Vec2 {
        if self.left == 0 {
            self.heading = Vec2::from_angle(self.random.f32() * std::f32::consts::TAU);
            self.left = self.random.u32(TURNS[0]..TURNS[1]);
        }
        self.left -= 1;
        for axis in 0..2 {
            let is_leaving = position[axis] * self.heading[axis] > 0.0;
            if position[axis].abs() > self.reach && is_leaving {
                self.heading[axis] = -self.heading[axis];
            }
        }
        self.heading
    }
}
