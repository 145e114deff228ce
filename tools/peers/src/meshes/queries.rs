//! What is asked, and the poses at which it is.

use std::{f32::consts::TAU, fmt, str::FromStr};

use bevy::math::{Dir3, Quat, Vec3};
use serde::{Serialize, Serializer};

use super::scenes::Mesh;

/// The radius of the ball.
pub const BALL: f32 = 0.5;
/// The half extents of the cuboid.
pub const CUBOID: Vec3 = Vec3::new(0.5, 0.3, 0.4);
/// The half length of the capsule, without its ends, and its radius.
pub const CAPSULE: [f32; 2] = [0.5, 0.3];
/// About the radius of the small mesh.
pub const ROCK: f32 = 2.0;
/// How far shapes are swept.
pub const SWEEP: f32 = 20.0;

/// What is asked of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    Ray,
    BallContact,
    BallSweep,
    CuboidContact,
    CuboidIntersects,
    CuboidSweep,
    CapsuleContact,
    CapsuleSweep,
    ClosestPoint,
    Distance,
    Contains,
    MeshIntersects,
    MeshContact,
    MeshSweep,
    Build,
    BuildClosed,
}

impl Operation {
    pub const ALL: [Self; 16] = [
        Self::Ray,
        Self::BallContact,
        Self::BallSweep,
        Self::CuboidContact,
        Self::CuboidIntersects,
        Self::CuboidSweep,
        Self::CapsuleContact,
        Self::CapsuleSweep,
        Self::ClosestPoint,
        Self::Distance,
        Self::Contains,
        Self::MeshIntersects,
        Self::MeshContact,
        Self::MeshSweep,
        Self::Build,
        Self::BuildClosed,
    ];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Ray => "ray",
            Self::BallContact => "ball-contact",
            Self::BallSweep => "ball-sweep",
            Self::CuboidContact => "cuboid-contact",
            Self::CuboidIntersects => "cuboid-intersects",
            Self::CuboidSweep => "cuboid-sweep",
            Self::CapsuleContact => "capsule-contact",
            Self::CapsuleSweep => "capsule-sweep",
            Self::ClosestPoint => "closest-point",
            Self::Distance => "distance",
            Self::Contains => "contains",
            Self::MeshIntersects => "mesh-intersects",
            Self::MeshContact => "mesh-contact",
            Self::MeshSweep => "mesh-sweep",
            Self::Build => "build",
            Self::BuildClosed => "build-closed",
        }
    }

    /// Whether it is asked of closed meshes alone.
    pub const fn is_for_closed(self) -> bool {
        matches!(self, Self::Contains | Self::BuildClosed)
    }

    /// Whether nothing is asked, but a mesh built.
    pub const fn is_build(self) -> bool {
        matches!(self, Self::Build | Self::BuildClosed)
    }

    /// Where in the neighbourhood of the surface it is asked: from how far on its inner side to how
    /// far on its outer side.
    fn reach(self) -> [f32; 2] {
        match self {
            Self::BallContact => [-0.5 * BALL, 2.5 * BALL],
            Self::CuboidContact | Self::CuboidIntersects => [-0.2, 1.2],
            Self::CapsuleContact => [-0.25, 1.5],
            Self::MeshIntersects | Self::MeshContact => [-0.5, 2.0 * ROCK],
            Self::BallSweep | Self::CuboidSweep | Self::CapsuleSweep => [1.0, 12.0],
            Self::MeshSweep => [ROCK, 12.0],
            Self::Ray => [0.1, 40.0],
            Self::ClosestPoint | Self::Distance => [0.5, 10.0],
            Self::Contains => [-5.0, 5.0],
            Self::Build | Self::BuildClosed => [0.0; 2],
        }
    }
}

impl fmt::Display for Operation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Operation {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = Self::ALL.map(Self::name);
        Self::ALL
            .into_iter()
            .find(|operation| operation.name() == name)
            .ok_or_else(|| format!("unknown operation: expected one of {}", all.join(", ")))
    }
}

impl Serialize for Operation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// One question: where a shape is, and where it goes.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    pub position: Vec3,
    pub rotation: Quat,
    pub direction: Dir3,
}

/// So many questions near the surface of a mesh, of which some hit and some miss.
pub fn queries(operation: Operation, mesh: &Mesh, count: usize, seed: u64) -> Vec<Query> {
    let mut random = fastrand::Rng::with_seed(seed ^ 0x5eed << operation as u32);
    let [inner, outer] = operation.reach();
    let query = |_| {
        let [a, b, c] = mesh.corners(random.usize(0..mesh.triangles.len()));
        let [mut u, mut v] = [random.f32(), random.f32()];
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
        let away = inner + (outer - inner) * random.f32();
        // Towards the surface more often than not.
        let aside = sphere(&mut random);
        let direction = Dir3::new(aside - normal * 0.5).unwrap_or(Dir3::X);
        Query {
            position: a + (b - a) * u + (c - a) * v + normal * away,
            rotation: turn(&mut random),
            direction,
        }
    };
    (0..count).map(query).collect()
}

/// A direction, each as likely.
fn sphere(random: &mut fastrand::Rng) -> Vec3 {
    let (height, around) = (random.f32() * 2.0 - 1.0, random.f32() * TAU);
    let ring = (1.0 - height * height).max(0.0).sqrt();
    Vec3::new(ring * around.cos(), height, ring * around.sin())
}

fn turn(random: &mut fastrand::Rng) -> Quat {
    let axis = sphere(random);
    Quat::from_axis_angle(axis, random.f32() * TAU)
}
