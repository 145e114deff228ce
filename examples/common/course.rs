//! A course to walk: stairs, a ramp, a maze of crates, a lift, a platform that turns, a gap to jump, and hills of 100 000
//! triangles; and who walks it. Plain data, so that whoever walks may be anybody.

use std::f32::consts::TAU;

use bevy::prelude::*;

/// The length of a tick, in seconds.
pub const TICK: f32 = 1.0 / 60.0;
/// How far the walker's middle is over its feet, and how wide it is.
pub const HALF_HEIGHT: f32 = 0.9;
pub const RADIUS: f32 = 0.35;
/// Where it starts.
pub const START: Vec3 = Vec3::new(0.0, HALF_HEIGHT + 0.02, 0.0);
pub const SPEED: f32 = 4.0;
pub const JUMP: f32 = 4.5;
pub const GRAVITY: f32 = 9.8;

/// Squares of the hills, of a length unit each, cut into two triangles.
const SQUARES: [u32; 2] = [250, 200];
/// Where the hills begin, and how high that is.
const HILLS: Vec3 = Vec3::new(42.0, 3.0, -100.0);
const DECK: f32 = 3.0;
const LIFT: Vec3 = Vec3::new(23.4, 0.0, 0.0);
const DISK: Vec3 = Vec3::new(33.0, DECK, 0.0);
pub const DISK_RADIUS: f32 = 3.0;
const DISK_SPEED: f32 = 0.8;

/// A box of the course: its sides, and where it is.
pub type Block = (Vec3, Transform);

/// All that does not move, but the hills.
pub fn blocks() -> Vec<Block> {
    let block = |min: [f32; 3], max: [f32; 3]| {
        let (min, max) = (Vec3::from(min), Vec3::from(max));
        (max - min, Transform::from_translation((min + max) / 2.0))
    };
    let mut blocks = vec![block([-6.0, -1.0, -8.0], [27.0, 0.0, 8.0])];
    // Ten steps up, and a ramp of 25° down.
    blocks.extend((0..10).map(|i| {
        let i = i as f32;
        block([3.0 + 0.3 * i, 0.0, -2.0], [8.0, 0.2 * (i + 1.0), 2.0])
    }));
    let lean = 25_f32.to_radians();
    let ramp = Vec3::new(2.0 / lean.sin(), 0.5, 4.0);
    let turn = Quat::from_rotation_z(-lean);
    let top = Vec3::new(8.0 + 1.0 / lean.tan(), 1.0, 0.0);
    let middle = top + turn * Vec3::NEG_Y * 0.25;
    blocks.push((
        ramp,
        Transform::from_translation(middle).with_rotation(turn),
    ));
    // Three rows of crates, each with a gap, between two walls.
    for (row, gap) in [2.5, -2.5, 1.5].into_iter().enumerate() {
        for crate_ in 0..11 {
            let z = crate_ as f32 - 5.0;
            if (z - gap).abs() > 1.0 {
                let at = Vec3::new(14.0 + 2.2 * row as f32, 0.5, z);
                let turn = Quat::from_rotation_y(0.1 * ((row * 11 + crate_) as f32).sin());
                blocks.push((
                    Vec3::ONE,
                    Transform::from_translation(at).with_rotation(turn),
                ));
            }
        }
    }
    blocks.extend([-6.0, 5.0].map(|z| block([8.5, 0.0, z], [27.0, 2.0, z + 1.0])));
    // A kerb, the deck that the lift goes to, and the one behind the platform that turns.
    blocks.push(block([20.4, 0.0, -5.0], [21.0, 0.25, 5.0]));
    blocks.push(block([25.0, DECK - 0.5, -5.0], [29.95, DECK, 5.0]));
    blocks.push(block([36.05, DECK - 0.5, -5.0], [40.8, DECK, 5.0]));
    blocks
}

/// How high the hills are.
pub fn height(x: f32, z: f32) -> f32 {
    let inwards = ((x - HILLS.x - 1.0) / 10.0).clamp(0.0, 1.0);
    let waves = 3.0 * (x / 8.0).sin() * (z / 7.0).cos() + 0.3 * (x / 1.7 + z / 2.1).sin();
    HILLS.y + inwards * waves
}

/// The vertices and triangles of the hills.
pub fn hills() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let row = SQUARES[0] + 1;
    let vertices = (0..row * (SQUARES[1] + 1)).map(|i| {
        let (x, z) = (HILLS.x + (i % row) as f32, HILLS.z + (i / row) as f32);
        Vec3::new(x, height(x, z), z)
    });
    let triangles = (0..SQUARES[0] * SQUARES[1]).flat_map(|i| {
        let a = i / SQUARES[0] * row + i % SQUARES[0];
        [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]
    });
    (vertices.collect(), triangles.collect())
}

/// The sides of the lift, and where it is after a time.
pub fn lift(seconds: f32) -> Block {
    let rise = (1.0 - (TAU * seconds / 8.0).cos()) / 2.0;
    let at = LIFT + Vec3::Y * (rise * (DECK - 0.1));
    (Vec3::new(3.0, 0.2, 3.0), Transform::from_translation(at))
}

/// Where the platform that turns, a cylinder of this height, is after a time.
pub fn disk(seconds: f32) -> (f32, Transform) {
    let height = 0.4;
    let turn = Quat::from_rotation_y((DISK_SPEED * seconds) % TAU);
    (
        height,
        Transform::from_translation(DISK - Vec3::Y * height / 2.0).with_rotation(turn),
    )
}

/// What is done next.
#[derive(Clone, Copy, Debug)]
enum Act {
    /// Goes there, along the horizontal.
    To(f32, f32),
    /// Jumps on the way there.
    JumpTo(f32, f32),
    /// Waits until the lift is down.
    LiftDown,
    /// Stands until it has been lifted.
    LiftUp,
    /// Stands until the platform has turned it around.
    Turned,
}

const SCRIPT: [(&str, Act); 20] = [
    ("the foot of the stairs", Act::To(2.0, 0.0)),
    ("the head of the stairs", Act::To(7.0, 0.0)),
    ("the foot of the ramp", Act::To(12.8, 0.0)),
    ("the maze", Act::To(13.0, 2.5)),
    ("behind the first row", Act::To(15.1, 2.5)),
    ("along the second", Act::To(15.1, -2.5)),
    ("behind the second", Act::To(17.3, -2.5)),
    ("along the third", Act::To(17.3, 1.5)),
    ("out of the maze", Act::To(19.6, 1.5)),
    ("over the kerb", Act::To(21.4, 0.0)),
    ("the lift is down", Act::LiftDown),
    ("on the lift", Act::To(LIFT.x, 0.0)),
    ("lifted", Act::LiftUp),
    ("the upper deck", Act::To(28.0, 0.0)),
    ("on the platform", Act::To(31.2, 0.0)),
    ("turned around", Act::Turned),
    ("the deck behind", Act::To(39.0, 0.0)),
    ("over the gap", Act::JumpTo(44.0, 0.0)),
    ("the first hill", Act::To(70.0, 12.0)),
    ("the goal", Act::To(110.0, -9.0)),
];

/// Walks the course: says how fast to go, given where it has got to.
#[derive(Clone, Debug, Default)]
pub struct Script {
    next: usize,
    has_jumped: bool,
    tick: u32,
    /// What was reached, when, and where.
    pub reached: Vec<(&'static str, u32, Vec3)>,
}

impl Script {
    /// Is all of it walked?
    pub fn is_done(&self) -> bool {
        self.next == SCRIPT.len()
    }

    /// What is to be reached next.
    pub fn aim(&self) -> &'static str {
        SCRIPT.get(self.next).map_or("nothing", |(name, _)| name)
    }

    /// How many parts there are.
    pub const fn parts() -> usize {
        SCRIPT.len()
    }

    /// The velocity along the horizontal for the next tick, and the speed of a jump if it jumps, given where its middle is,
    /// whether it stands, and how much time has passed.
    pub fn steer(&mut self, at: Vec3, is_on_ground: bool, seconds: f32) -> (Vec3, Option<f32>) {
        self.tick += 1;
        let Some((name, act)) = SCRIPT.get(self.next).copied() else {
            return (Vec3::ZERO, None);
        };
        let feet = at.y - HALF_HEIGHT;
        let is_reached = match act {
            Act::To(x, z) | Act::JumpTo(x, z) => {
                Vec2::new(x - at.x, z - at.z).length() < 0.25 && is_on_ground
            }
            Act::LiftDown => lift(seconds).1.translation.y < 0.05,
            Act::LiftUp => feet > DECK - 0.1,
            Act::Turned => at.x > DISK.x + 1.2 && at.z.abs() < 1.3,
        };
        if is_reached {
            self.reached.push((name, self.tick, at));
            self.next += 1;
            self.has_jumped = false;
        }
        let mut jump = None;
        let way = match act {
            Act::To(x, z) => towards(at, x, z),
            Act::JumpTo(x, z) => {
                // At the edge.
                if !self.has_jumped && is_on_ground && at.x > 40.3 {
                    self.has_jumped = true;
                    jump = Some(JUMP);
                }
                towards(at, x, z)
            }
            Act::LiftDown | Act::LiftUp | Act::Turned => Vec3::ZERO,
        };
        (way, jump)
    }
}

/// At full speed, and slower where it is nearly there.
fn towards(at: Vec3, x: f32, z: f32) -> Vec3 {
    let way = Vec3::new(x - at.x, 0.0, z - at.z);
    (way / TICK / 2.0).clamp_length_max(SPEED)
}

/// How long the walk may take, in ticks.
pub const PATIENCE: u32 = (90.0 / TICK) as u32;
