//! Hills.

use std::f32::consts::TAU;

use bevy::math::{Vec2, Vec3};

use super::{Aim, Course, Extent, Place, Solid, Walker};
use crate::{
    characters::{HALF_HEIGHT, RADIUS},
    meshes::scenes::Mesh,
};

/// Triangles, about, whose legs are one length unit.
const TRIANGLES: f32 = 100_000.0;
/// How long the waves are that hills are made of.
const WAVES: [f32; 7] = [70.0, 45.0, 30.0, 21.0, 14.0, 9.0, 6.0];
/// How steep each wave is, at most.
const STEEPNESS: f32 = 0.27;
/// How far from its rim nobody walks.
const RIM: f32 = 8.0;

/// The heights of the ground: a sum of waves of different lengths, each in a direction of its own.
struct Hills(Vec<Wave>);

struct Wave {
    /// The direction, as phase per length unit.
    along: Vec2,
    phase: f32,
    height: f32,
}

impl Hills {
    fn new(seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        let wave = |length: f32| Wave {
            along: Vec2::from_angle(random.f32() * TAU) * TAU / length,
            phase: random.f32() * TAU,
            height: STEEPNESS * length / TAU,
        };
        Self(WAVES.map(wave).into())
    }

    fn height(&self, at: Vec2) -> f32 {
        let of = |wave: &Wave| wave.height * (wave.along.dot(at) + wave.phase).sin();
        self.0.iter().map(of).sum()
    }
}

pub fn place(extent: Extent) -> Place {
    let hills = Hills::new(extent.seed);
    let cells = (TRIANGLES / 2.0).sqrt().round() as u32;
    let half = cells as f32 / 2.0;
    let mut vertices = vec![];
    for row in 0..=cells {
        for column in 0..=cells {
            let at = Vec2::new(column as f32, row as f32) - half;
            vertices.push(Vec3::new(at.x, hills.height(at), at.y));
        }
    }
    let lowest = vertices.iter().map(|vertex| vertex.y);
    let lowest = lowest.fold(f32::INFINITY, f32::min);
    let reach = half - RIM;
    // Not the numbers that the hills were drawn from.
    let mut random = fastrand::Rng::with_seed(!extent.seed);
    let walkers = (0..extent.characters).map(|_| {
        let at = Vec2::from([0; 2].map(|_| random.f32() * 2.0 - 1.0)) * reach;
        // Above the slope, too.
        let start = Vec3::new(at.x, hills.height(at) + HALF_HEIGHT + RADIUS, at.y);
        let course = Course::wander(random.u64(..), reach);
        let aim = Aim::Way;
        ("", Walker { start, course, aim })
    });
    Place {
        walkers: walkers.collect(),
        lowest,
        ticks: extent.ticks,
        solids: vec![Solid::Ground(Mesh::of_grid(
            vertices,
            cells + 1,
            cells + 1,
            false,
        ))],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_slopes_are_steep() {
        let extent = Extent {
            characters: 10,
            ticks: 1,
            seed: 1,
        };
        let place = place(extent);
        let [Solid::Ground(mesh)] = &place.solids[..] else {
            panic!("one mesh");
        };
        assert!((mesh.triangles.len() as f32 / TRIANGLES - 1.0).abs() < 0.01);
        let slope = |triangle: usize| {
            let [a, b, c] = mesh.corners(triangle);
            (b - a).cross(c - a).normalize().y.acos().to_degrees()
        };
        let slopes: Vec<f32> = (0..mesh.triangles.len()).map(slope).collect();
        let share = |least: f32| {
            slopes.iter().filter(|slope| **slope > least).count() as f32 / slopes.len() as f32
        };
        assert!(slopes.iter().all(|slope| *slope < 70.0));
        assert!(share(35.0) > 0.05 && share(35.0) < 0.25, "{}", share(35.0));
        assert!(share(45.0) > 0.003 && share(45.0) < 0.06, "{}", share(45.0));
    }
}
