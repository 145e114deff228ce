//! What walks.

mod avian;
mod ours;
mod rapier;

use std::{fmt, str::FromStr};

use bevy::math::Vec3;

use super::scenes::Solid;

/// A way to walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contestant {
    /// This crate's `walk`.
    Ours,
    /// Rapier's `KinematicCharacterController`.
    Rapier,
    /// Avian's `MoveAndSlide`, and what its example of a character makes of it.
    Avian,
}

/// A character, as an engine moves it.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// The middle of the capsule.
    pub position: Vec3,
    /// What the engine keeps from tick to tick.
    pub velocity: Vec3,
    /// Does the engine say that there is ground below it?
    pub is_grounded: bool,
}

impl Body {
    /// One that does not move yet.
    pub const fn new(position: Vec3) -> Self {
        Self {
            position,
            velocity: Vec3::ZERO,
            is_grounded: false,
        }
    }
}

/// A world in which characters walk. They do not meet each other.
pub trait Engine {
    /// Moves all characters for one tick. Each wants to go in the plane with the velocity at its number.
    fn tick(&mut self, bodies: &mut [Body], wishes: &[Vec3]);
}

impl Contestant {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 3] = [Self::Ours, Self::Rapier, Self::Avian];

    /// The name in tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Rapier => "rapier",
            Self::Avian => "avian",
        }
    }

    /// Is it this crate?
    pub const fn is_ours(self) -> bool {
        matches!(self, Self::Ours)
    }

    /// Its world, ready to be asked.
    pub fn engine(self, solids: &[Solid]) -> Box<dyn Engine> {
        match self {
            Self::Ours => Box::new(ours::Ours::new(solids)),
            Self::Rapier => Box::new(rapier::Rapier::new(solids)),
            Self::Avian => Box::new(avian::Avian::new(solids)),
        }
    }
}

impl fmt::Display for Contestant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Contestant {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = Self::ALL.map(Self::name);
        Self::ALL
            .into_iter()
            .find(|contestant| contestant.name() == name)
            .ok_or_else(|| format!("unknown engine: expected one of {}", all.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use bevy::transform::components::Transform;

    use super::*;
    use crate::characters::{HALF_HEIGHT, SPEED, TICK, judge::Judge};

    fn solids() -> Vec<Solid> {
        let floor = Transform::from_xyz(0.0, -0.5, 0.0);
        let wall = Transform::from_xyz(3.0, 1.5, 0.0);
        vec![
            Solid::Box(Vec3::new(30.0, 0.5, 30.0), floor),
            Solid::Box(Vec3::new(0.5, 1.5, 3.0), wall),
        ]
    }

    fn walk(contestant: Contestant, wish: Vec3, ticks: usize) -> Vec3 {
        let solids = solids();
        let judge = Judge::new(&solids);
        let mut engine = contestant.engine(&solids);
        let position = Vec3::Y * (HALF_HEIGHT + 0.02);
        let mut bodies = [Body::new(position)];
        for _ in 0..ticks {
            engine.tick(&mut bodies, &[wish]);
            assert!(judge.gap(bodies[0].position) > -1e-3, "{contestant}");
        }
        bodies[0].position
    }

    #[test]
    fn all_walk_on_a_floor() {
        for contestant in Contestant::ALL {
            let end = walk(contestant, Vec3::NEG_X * SPEED, 60);
            let way = 60.0 * TICK * SPEED;
            // Some lose a little of it to the floor.
            assert!((end.x + way).abs() < 0.1 * way, "{contestant}: {end}");
            assert!((end.y - HALF_HEIGHT).abs() < 0.05, "{contestant}: {end}");
        }
    }

    #[test]
    fn all_stop_at_a_wall_and_stand_where_they_are() {
        for contestant in Contestant::ALL {
            let end = walk(contestant, Vec3::X * SPEED, 120);
            assert!((end.x - 2.1).abs() < 0.05, "{contestant}: {end}");
            let end = walk(contestant, Vec3::ZERO, 120);
            assert!(end.x.abs() + end.z.abs() < 0.01, "{contestant}: {end}");
        }
    }
}
