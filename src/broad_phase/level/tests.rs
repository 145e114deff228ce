//! The same at every level that the machine has.

use std::hash::{Hash, Hasher};

use bevy::{
    math::{
        Dir3, Quat, Vec3, Vec3A,
        bounding::{Aabb3d, AabbCast3d, BoundingSphere, RayCast3d},
        primitives::HalfSpace,
    },
    transform::components::Transform,
};
use fastrand::Rng;

use super::forced;
use crate::{
    broad_phase::{BroadPhaseMethod, ProxyId, SpatialIndex},
    narrow_phase::{Impact, NarrowPhase, Placed, Shape, Workspace},
};

/// What was found, in its order, to the last bit.
#[derive(Debug, Default, PartialEq)]
struct Found(Vec<u64>);

/// Whatever can be hashed is taken down.
impl Hasher for Found {
    fn write(&mut self, bytes: &[u8]) {
        let mut word = [0; 8];
        for part in bytes.chunks(8) {
            word[..part.len()].copy_from_slice(part);
            self.0.push(u64::from_le_bytes(word));
        }
    }

    fn finish(&self) -> u64 {
        0
    }
}

impl Found {
    fn add(&mut self, what: impl Hash) {
        what.hash(self);
    }
}

/// Asserts that it does the same at every level, with nothing left over of another one, and says at which.
fn assert_same(name: &str, act: impl Fn(&mut Found) + Sync) {
    let at = |level| {
        let run = || {
            let mut found = Found::default();
            forced::at(level, || act(&mut found));
            found
        };
        std::thread::scope(|scope| scope.spawn(run).join().unwrap())
    };
    let levels = forced::all();
    let first = at(levels[0].1);
    assert!(first.0.len() > 1000, "{name}: {}", first.0.len());
    for (level, other) in &levels[1..] {
        let other = at(*other);
        let place = first.0.iter().zip(&other.0).position(|(a, b)| a != b);
        assert_eq!(place, None, "{name}, {level}: the first that differs");
        assert_eq!(first.0.len(), other.0.len(), "{name}, {level}");
    }
    let tried: Vec<_> = levels.iter().map(|(name, _)| *name).collect();
    println!(
        "{name}: {} numbers, the same at {}",
        first.0.len(),
        tried.join(", ")
    );
}

/// Boxes of some sort, by their number.
type Boxes = fn(&mut Rng, usize) -> Aabb3d;

fn vector(rng: &mut Rng) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| rng.f32() * 2.0 - 1.0))
}

const SORTS: [(&str, usize, Boxes); 6] = [
    ("random", 600, |rng, _| {
        let half = (vector(rng).abs() + 0.01) * 0.5;
        Aabb3d::new(vector(rng) * 8.0, half)
    }),
    ("a lattice of what touches", 400, |_, number| {
        let at = [number % 10, number / 10 % 10, number / 100];
        Aabb3d::new(Vec3::from(at.map(|i| i as f32 - 5.0)), Vec3::splat(0.5))
    }),
    (
        "flat ones in one plane, through zero",
        700,
        |rng, number| {
            let at = Vec3::new(
                (number % 27) as f32 - 13.0,
                0.0,
                (number / 27) as f32 - 13.0,
            );
            let half = Vec3::new(0.5, 0.0, [0.0, 0.5][rng.usize(0..2)]);
            Aabb3d::new(if rng.bool() { at } else { -at }, half)
        },
    ),
    ("huge and tiny", 150, |rng, _| {
        let size = 10_f32.powi(rng.i32(-30..30));
        let at = vector(rng) * 10_f32.powi(rng.i32(-30..30));
        Aabb3d::new(at, vector(rng).abs() * size)
    }),
    ("far away", 200, |rng, _| {
        Aabb3d::new(vector(rng) * 4.0 + Vec3::splat(1e6), Vec3::splat(0.3))
    }),
    ("a crowd in one place", 520, |rng, _| {
        Aabb3d::new(vector(rng) * 0.1, Vec3::splat(0.2))
    }),
];

/// Ticks of an index, of which every third object moves, some come and some go; and its answers after each.
fn live(boxes: Boxes, count: usize, method: &BroadPhaseMethod, found: &mut Found) {
    let mut rng = Rng::with_seed(5);
    let mut index = SpatialIndex::new(method);
    let all: Vec<_> = (0..count).map(|number| boxes(&mut rng, number)).collect();
    let ids = all.iter().filter_map(|aabb| index.insert(*aabb).ok());
    let mut ids: Vec<_> = ids.collect();
    for tick in 0..5 {
        index.update();
        for pair in index.find_pairs().iter() {
            found.add((pair.a, pair.b));
        }
        if tick % 4 == 0 {
            ask(&index, &all, found);
        }
        let size = [0.0, 0.02, 1.0][tick % 3];
        for id in ids.iter().skip(tick % 3).step_by(3) {
            let by = Vec3A::from(vector(&mut rng) * size);
            let aabb = *index.proxies().get(*id).unwrap();
            let (min, max) = (aabb.min + by, aabb.max + by);
            index.set(*id, &Aabb3d { min, max }).unwrap();
        }
        index.remove(ids.swap_remove(rng.usize(0..ids.len())));
        ids.extend(index.insert(boxes(&mut rng, tick)).ok());
    }
}

fn ask(index: &SpatialIndex, all: &[Aabb3d], found: &mut Found) {
    let mut rng = Rng::with_seed(6);
    let mut hits = Vec::new();
    for aabb in all.iter().step_by(all.len() / 16 + 1) {
        let center = Vec3::from((aabb.min + aabb.max) * 0.5);
        // From corners, so that sides are met exactly, and both zeros.
        let corner = Vec3::from(if rng.bool() { aabb.min } else { aabb.max });
        let random = Dir3::new(vector(&mut rng)).unwrap_or(Dir3::X);
        index.for_each_overlapping(aabb, |id| found.add(id));
        index.for_each_overlapping(&corner, |id| found.add(id));
        index.for_each_overlapping(&BoundingSphere::new(center, 1.5), |id| found.add(id));
        let planes = [Dir3::X, Dir3::NEG_Y, random]
            .map(|normal| HalfSpace::new(normal.extend(-normal.dot(corner))));
        index.for_each_overlapping(&planes[..], |id| found.add(id));
        for point in [center, corner] {
            index.for_each_within(point, 2.0, |hit| {
                found.add((hit.proxy, hit.distance.to_bits()));
            });
            let nearest = index.nearest(point, f32::INFINITY);
            found.add(nearest.map(|hit| (hit.proxy, hit.distance.to_bits())));
            index.k_nearest(point, 7, f32::INFINITY, &mut hits);
            hits.iter()
                .for_each(|hit| found.add((hit.proxy, hit.distance.to_bits())));
        }
        let axes = [Dir3::X, Dir3::NEG_X, Dir3::NEG_Y, Dir3::Z, random];
        for (from, direction) in axes.into_iter().flat_map(|d| [(corner, d), (-center, d)]) {
            let ray = RayCast3d::new(from, direction, 40.0);
            let size = Aabb3d::new(Vec3::ZERO, Vec3::new(0.25, 0.0, 0.5));
            let moving = AabbCast3d::new(size, from, direction, 40.0);
            let mut add = |hit: crate::broad_phase::Hit| {
                found.add((hit.proxy, hit.distance.to_bits()));
            };
            index.for_each_hit(&ray, &mut add);
            index.for_each_hit(&moving, &mut add);
            index.cast(&ray).into_iter().for_each(&mut add);
            index.cast(&moving).into_iter().for_each(&mut add);
        }
    }
    let is_member = |id: ProxyId| !id.get().is_multiple_of(3);
    index.for_each_pair_among(0.05, is_member, |a, b, distance| {
        found.add((a, b, distance.to_bits()));
    });
}

#[test]
fn boxes_are_the_same_at_every_level() {
    for (name, count, boxes) in SORTS {
        for method in ["linear", "object", "exhaustive", "auto"] {
            let method: BroadPhaseMethod = method.parse().unwrap();
            assert_same(&format!("{name}, {method}"), |found| {
                live(boxes, count, &method, found);
            });
        }
    }
}

/// A hilly ground, wound upwards, whose vertices are on a lattice.
fn hills(count: u32) -> Shape {
    let side = count + 1;
    let at = |i: u32, k: u32| {
        let height = ((i * 7 + k * 5) % 4) as f32 * 0.25;
        Vec3::new(i as f32, height, k as f32) - Vec3::new(1.0, 0.0, 1.0) * count as f32 / 2.0
    };
    let vertices: Vec<_> = (0..side * side).map(|i| at(i % side, i / side)).collect();
    let triangles = (0..count * count).flat_map(|i| {
        let first = i % count + i / count * side;
        let (right, down) = (first + 1, first + side);
        [[first, down, right], [right, down, down + 1]]
    });
    Shape::mesh(vertices, triangles).unwrap()
}

fn add_impact(found: &mut Found, impact: Option<Impact>) {
    found.add(impact.map(|impact| {
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        (
            impact.distance.to_bits(),
            bits(impact.point),
            bits(impact.normal),
            impact.polygon,
        )
    }));
}

#[test]
fn meshes_are_the_same_at_every_level() {
    assert_same("meshes", |found| {
        let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
        let ground = hills(24);
        let (other, mut rng) = (hills(5), Rng::with_seed(8));
        let others = [
            Shape::sphere(0.6),
            Shape::cuboid(1.0, 0.5, 2.0),
            Shape::capsule(0.3, 1.0),
            other,
        ];
        let here = Transform::from_xyz(0.5, 0.0, -0.5);
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        for round in 0..150 {
            let shape = &others[round % others.len()];
            let mut at = Transform::from_translation(vector(&mut rng) * Vec3::new(9.0, 2.0, 9.0));
            if round % 3 == 0 {
                // On the lattice, where much is as near.
                at.translation = at.translation.round();
            } else {
                at.rotation = Quat::from_scaled_axis(vector(&mut rng) * 3.0);
            }
            let (ground, placed) = (Placed::new(&ground, &here), Placed::new(shape, &at));
            let contact = tests.contact(placed, ground, &mut workspace);
            found.add(contact.map(|contact| {
                (
                    bits(contact.point),
                    bits(contact.normal),
                    contact.depth.to_bits(),
                )
            }));
            let near = tests.closest_points(placed, ground, &mut workspace);
            found.add(near.map(|near| (near.points.map(bits), near.distance.to_bits())));
            let closest = tests.closest_point(ground, at.translation, &mut workspace);
            found.add(closest.map(bits));
            for direction in [Dir3::NEG_Y, Dir3::X, Dir3::new(vector(&mut rng)).unwrap()] {
                add_impact(
                    found,
                    tests.sweep(placed, direction, 9.0, ground, &mut workspace),
                );
                add_impact(
                    found,
                    tests.cast_ray(ground, at.translation, direction, 9.0),
                );
            }
        }
    });
}
