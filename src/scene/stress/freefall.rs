//! Boxes that fall onto a floor, pile up and rest.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fastrand::Rng;

/// How many boxes a column holds in the end, on average.
const PER_COLUMN: usize = 8;
/// The distance between the middles of neighbouring columns, and how far to either side of it boxes
/// are put: one pair of neighbouring boxes in eight overlaps sideways.
const SPACING: f32 = 1.1;
const SCATTER: f32 = 0.1;
/// How high boxes start: below the first, except that one in ten starts anywhere below the second.
const HEIGHTS: [f32; 2] = [40.0, 520.0];
const LATE: u8 = 10;
/// Speeds rise by the first each tick, up to the second.
const GRAVITY: f32 = 0.02;
const TERMINAL: f32 = 0.5;

/// Boxes over a floor that is divided into columns. A box falls until it meets the top of its
/// column, and is the top from then on.
#[derive(Clone, Debug)]
pub(super) struct Freefall {
    /// Those in the air, in the order of the objects.
    falling: Vec<Falling>,
    /// How many boxes lie in each column.
    heights: Vec<u32>,
    speed: f32,
}

#[derive(Clone, Copy, Debug)]
struct Falling {
    object: u32,
    column: u32,
}

pub(super) fn new(objects: usize, mut rng: Rng) -> (Vec<Aabb3d>, Freefall) {
    let edge = ((objects / PER_COLUMN).isqrt() as u32).max(1);
    let columns = edge * edge;
    let falling: Vec<_> = (0..objects as u32)
        .map(|object| Falling {
            object,
            column: rng.u32(0..columns),
        })
        .collect();
    let place = |falling: &Falling| {
        let mut scatter = || SCATTER * (2.0 * rng.f32() - 1.0);
        let x = (falling.column % edge) as f32 * SPACING + scatter();
        let z = (falling.column / edge) as f32 * SPACING + scatter();
        let limit = HEIGHTS[usize::from(rng.u8(0..LATE) == 0)];
        let min = Vec3A::new(x, limit * rng.f32(), z);
        Aabb3d {
            min,
            max: min + 1.0,
        }
    };
    let boxes = falling.iter().map(place).collect();
    (
        boxes,
        Freefall {
            falling,
            heights: vec![0; columns as usize],
            speed: 0.0,
        },
    )
}

impl Freefall {
    pub(super) fn step(&mut self, boxes: &mut [Aabb3d]) {
        self.speed = (self.speed + GRAVITY).min(TERMINAL);
        self.falling.retain(|falling| {
            let aabb = &mut boxes[falling.object as usize];
            let height = &mut self.heights[falling.column as usize];
            let top = *height as f32;
            let fallen = aabb.min.y - self.speed;
            let lands = fallen <= top;
            *height += u32::from(lands);
            aabb.min.y = fallen.max(top);
            aabb.max.y = aabb.min.y + 1.0;
            !lands
        });
    }
}
