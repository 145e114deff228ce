//! Boxes in random motion, each in its room.

use bevy::math::{DVec4, Vec3, Vec3A, bounding::Aabb3d};
use fastrand::Rng;

use super::random::{cube_root, log_uniform, point_in};

/// Each velocity is drawn anew once in so many ticks, those of a few objects in each.
const REDRAW_TICKS: usize = 32;
/// The least and the largest speed along an axis, in sides of the box per tick.
const SPEED: [f32; 2] = [0.05, 0.1];
/// The largest side in `sizes`; the smallest is 1.
const LARGEST: f32 = 1000.0;
/// One object in so many is different from the others, in `static90` and `clusters`.
const SHARE: usize = 10;
/// How wide the ground is in `ground`.
const GROUND: f32 = 20_000.0;
/// How far away the outlier goes in `outlier`, along each axis, and in which tick.
const FAR: f32 = 1e6;
const DEPARTURE: usize = 4;
/// How far the rooms are apart in `rooms`.
const BETWEEN_ROOMS: f32 = 10_000.0;

/// Boxes in random motion. The objects are dealt to the rooms in turn.
#[derive(Clone, Debug)]
pub(super) struct Drift {
    drifters: Vec<Drifter>,
    rooms: Vec<Room>,
    rng: Rng,
    /// The first object whose velocity is drawn anew in the next tick.
    redrawn: usize,
    /// In how many ticks the last object goes far away and rests there, if it ever does.
    departure: Option<usize>,
}

#[derive(Clone, Debug)]
struct Drifter {
    velocity: Vec3,
    side: f32,
}

/// Where the centres of boxes are. A box that leaves turns round, at most a tick's way beyond the
/// wall.
#[derive(Clone, Copy, Debug)]
struct Room {
    low: Vec3A,
    high: Vec3A,
    /// Nothing moves in here.
    still: bool,
}

/// Cubes in one room, each overlapping one other.
pub(super) fn brownian(objects: usize, rng: Rng) -> (Vec<Aabb3d>, Drift) {
    let sides = vec![1.0; objects];
    let room = Room::new(Vec3A::ZERO, room_side(&sides, 1.0));
    Drift::new(&sides, vec![room], rng)
}

/// The same, but only one in ten moves.
pub(super) fn static90(objects: usize, rng: Rng) -> (Vec<Aabb3d>, Drift) {
    let sides = vec![1.0; objects];
    let room = Room::new(Vec3A::ZERO, room_side(&sides, 1.0));
    let mut rooms = vec![
        Room {
            still: true,
            ..room
        };
        SHARE
    ];
    rooms[SHARE - 1].still = false;
    Drift::new(&sides, rooms, rng)
}

/// Cubes of all sizes, each overlapping four others.
pub(super) fn sizes(objects: usize, mut rng: Rng) -> (Vec<Aabb3d>, Drift) {
    let sides: Vec<_> = (0..objects)
        .map(|_| log_uniform(&mut rng, LARGEST))
        .collect();
    let room = Room::new(Vec3A::ZERO, room_side(&sides, 4.0));
    Drift::new(&sides, vec![room], rng)
}

/// Nine clusters, each with a tenth of the cubes, each of which overlaps two others; the last tenth
/// is anywhere.
pub(super) fn clusters(objects: usize, mut rng: Rng) -> (Vec<Aabb3d>, Drift) {
    let sides = vec![1.0; objects];
    let cluster = room_side(&sides[..objects.div_ceil(SHARE)], 2.0);
    // Nine clusters take a hundredth of the space.
    let space = cluster * cube_root(900.0) as f32;
    // Each has one cell of a 3 by 3 by 3 grid to itself: those with x + y + z = 0, modulo 3.
    let cell = space / 3.0;
    let mut rooms: Vec<_> = (0..9)
        .map(|place| {
            let (x, y) = (place % 3, place / 3);
            let corner = Vec3A::new(x as f32, y as f32, ((6 - x - y) % 3) as f32) * cell;
            Room::new(
                point_in(&mut rng, corner, corner + (cell - cluster)),
                cluster,
            )
        })
        .collect();
    rooms.push(Room::new(Vec3A::ZERO, space));
    Drift::new(&sides, rooms, rng)
}

/// The same as `brownian`, on a ground that never moves and is much wider than the room.
pub(super) fn ground(objects: usize, rng: Rng) -> (Vec<Aabb3d>, Drift) {
    let cubes = objects.saturating_sub(1);
    let (mut boxes, drift) = brownian(cubes, rng);
    if cubes < objects {
        // Its top is the floor of the room: cubes dip into it as they do into the walls.
        let middle = drift.rooms[0].high.x * 0.5;
        let [low, high] = [-0.5, 0.5].map(|half| middle + half * GROUND);
        boxes.push(Aabb3d {
            min: Vec3A::new(low, -1.0, low),
            max: Vec3A::new(high, 0.0, high),
        });
    }
    (boxes, drift)
}

/// The same as `brownian`, but one cube goes far away and rests there.
pub(super) fn outlier(objects: usize, rng: Rng) -> (Vec<Aabb3d>, Drift) {
    let (boxes, drift) = brownian(objects, rng);
    (
        boxes,
        Drift {
            departure: Some(DEPARTURE),
            ..drift
        },
    )
}

/// The same as `brownian`, in four rooms far from each other.
pub(super) fn rooms(objects: usize, rng: Rng) -> (Vec<Aabb3d>, Drift) {
    let sides = vec![1.0; objects];
    let corners = [Vec3A::ZERO, Vec3A::X, Vec3A::Y, Vec3A::Z];
    let side = room_side(&sides[..objects.div_ceil(corners.len())], 1.0);
    let rooms = corners.map(|corner| Room::new(corner * BETWEEN_ROOMS, side));
    Drift::new(&sides, rooms.to_vec(), rng)
}

impl Drift {
    fn new(sides: &[f32], rooms: Vec<Room>, mut rng: Rng) -> (Vec<Aabb3d>, Self) {
        let drifters: Vec<_> = sides
            .iter()
            .map(|side| Drifter {
                velocity: velocity(&mut rng, *side),
                side: *side,
            })
            .collect();
        let place = |(drifter, room): (&Drifter, &Room)| {
            let min = point_in(&mut rng, room.low, room.high) - 0.5 * drifter.side;
            Aabb3d {
                min,
                max: min + drifter.side,
            }
        };
        let boxes = drifters
            .iter()
            .zip(rooms.iter().cycle())
            .map(place)
            .collect();
        (
            boxes,
            Self {
                drifters,
                rooms,
                rng,
                redrawn: 0,
                departure: None,
            },
        )
    }

    pub(super) fn step(&mut self, boxes: &mut [Aabb3d]) {
        for drifter in self
            .drifters
            .iter_mut()
            .skip(self.redrawn)
            .step_by(REDRAW_TICKS)
        {
            drifter.velocity = velocity(&mut self.rng, drifter.side);
        }
        self.redrawn = (self.redrawn + 1) % REDRAW_TICKS;
        for ((drifter, aabb), room) in self
            .drifters
            .iter_mut()
            .zip(&mut *boxes)
            .zip(self.rooms.iter().cycle())
        {
            if !room.still {
                room.advance(drifter, aabb);
            }
        }
        self.departure = self.departure.and_then(|ticks| ticks.checked_sub(1));
        if self.departure == Some(0)
            && let Some(drifter) = self.drifters.pop()
            && let Some(aabb) = boxes.last_mut()
        {
            aabb.min += FAR;
            aabb.max = aabb.min + drifter.side;
        }
    }
}

impl Room {
    fn new(low: Vec3A, side: f32) -> Self {
        Self {
            low,
            high: low + side,
            still: false,
        }
    }

    #[inline]
    fn advance(&self, drifter: &mut Drifter, aabb: &mut Aabb3d) {
        let center = aabb.min + 0.5 * drifter.side;
        let velocity = Vec3A::from(drifter.velocity);
        let inward = Vec3A::select(center.cmplt(self.low), velocity.abs(), velocity);
        let inward = Vec3A::select(center.cmpgt(self.high), -velocity.abs(), inward);
        drifter.velocity = inward.into();
        aabb.min += inward;
        aabb.max = aabb.min + drifter.side;
    }
}

fn velocity(rng: &mut Rng, side: f32) -> Vec3 {
    let [slow, fast] = SPEED;
    Vec3::from_array(std::array::from_fn(|_| {
        let speed = side * (slow + (fast - slow) * rng.f32());
        if rng.bool() { speed } else { -speed }
    }))
}

/// The side of the cube in which to strew the centres of boxes with these sides, so that each
/// overlaps so many others on average.
///
/// Boxes of sides a and b overlap along an axis of length L if their centres are within r = (a + b)
/// / 2, which happens with the probability (2r/L) · (1 − r/2L), the second factor being the effect
/// of the walls. Over all pairs and three axes that makes (2/L)³ · E(r³) · (1 − w/2L)³, with w =
/// E(r⁴) / E(r³) to first order.
fn room_side(sides: &[f32], overlaps: f64) -> f32 {
    let count = sides.len().max(2) as f64;
    let powers = sides.iter().map(|side| {
        let side = f64::from(*side);
        DVec4::new(
            side,
            side * side,
            side * side * side,
            side * side * side * side,
        )
    });
    let [m1, m2, m3, m4] = (powers.sum::<DVec4>() / count).to_array();
    let cubes = 2.0 * m3 + 6.0 * m2 * m1;
    let wall = (2.0 * m4 + 8.0 * m3 * m1 + 6.0 * m2 * m2) / (2.0 * cubes);
    // That of a room without walls.
    let unwalled = cube_root((count - 1.0) / overlaps * cubes);
    // L = unwalled · (1 − wall / 2L), solved for L.
    let side = 0.5 * (unwalled + (unwalled * (unwalled - 2.0 * wall)).max(0.0).sqrt());
    side.max(1.0) as f32
}
