//! All that consists of many, walked by the one interface.

use std::cell::Cell;

use bevy::math::{IVec3, Isometry3d, Quat, Vec2};

use super::*;

/// A box of a leaf, and what tells leaves apart.
fn describe(leaf: Leaf) -> (Vec3A, Vec3A, [i64; 4]) {
    match leaf {
        Leaf::Part(part) => {
            let (low, high) = (part.center - part.half, part.center + part.half);
            (low, high, [part.number.into(), 0, 0, 0])
        }
        Leaf::Triangle(FieldTriangle {
            number,
            corners: [a, b, c],
        }) => (a.min(b).min(c), a.max(b).max(c), [number.into(), 0, 0, 0]),
        Leaf::Cells(of) => {
            let [x, y, z] = of.first.as_i64vec3().to_array();
            (of.low, of.high, [0, x, y, z])
        }
    }
}

fn all(of: Composite) -> Vec<(Vec3A, Vec3A, [i64; 4])> {
    let mut leaves = Vec::new();
    of.walk(&mut |_, _| true, &mut |leaf| leaves.push(describe(leaf)));
    leaves
}

fn gap(low: Vec3A, high: Vec3A, point: Vec3A) -> f32 {
    (low - point).max(point - high).max(Vec3A::ZERO).length()
}

fn some(random: &mut fastrand::Rng) -> (Compound, HeightField, Voxels) {
    let mut any = || random.f32() * 20.0 - 10.0;
    let mut parts = Vec::new();
    for _ in 0..random_count(any()) {
        let rotation = Quat::from_xyzw(any(), any(), any(), any()).normalize();
        let pose = Isometry3d::new([any(), any(), any()], rotation);
        parts.push((pose, Shape::cuboid(1.0, any().abs() * 0.1, 2.0)));
    }
    let compound = Compound::new(parts).unwrap();
    let field = HeightField::from_fn(9, 14, Vec2::new(2.0, 1.5), |_, _| any() * 0.1).unwrap();
    let cells = (0..400).map(|_| IVec3::from([(); 3].map(|()| any() as i32)));
    (compound, field, Voxels::from_cells(0.75, cells).unwrap())
}

fn random_count(any: f32) -> usize {
    (any.abs() * any.abs() * 6.0) as usize + 1
}

#[test]
fn all_leaves_are_found_by_what_is_near() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..60 {
        let (compound, field, voxels) = some(&mut random);
        let composites = [
            Composite::Compound(&compound),
            Composite::HeightField(&field),
            Composite::Voxels(&voxels),
        ];
        for of in composites {
            let (center, half, radius) = of.local_bounds();
            let leaves = all(of);
            for (low, high, _) in &leaves {
                assert!((center - half).cmple(*low + 1e-4).all());
                assert!((center + half).cmpge(*high - 1e-4).all());
            }
            assert!(radius <= half.length() * 1.000_001);
            let point = Vec3A::from([(); 3].map(|()| random.f32() * 30.0 - 15.0));
            let mut keys: Vec<_> = leaves.iter().map(|leaf| leaf.2).collect();
            keys.sort_unstable();
            keys.dedup();
            assert_eq!(keys.len(), leaves.len(), "each once");

            // Within a distance.
            let limit = random.f32() * 10.0;
            let mut found = Vec::new();
            of.walk(
                &mut |low, high| gap(low, high, point) <= limit,
                &mut |leaf| {
                    found.push(describe(leaf).2);
                },
            );
            let near = leaves
                .iter()
                .filter(|leaf| gap(leaf.0, leaf.1, point) <= limit);
            let mut expected: Vec<_> = near.map(|leaf| leaf.2).collect();
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected);

            // The nearest, by a limit that shrinks.
            let best = Cell::new(f32::INFINITY);
            let mut visits = 0;
            of.walk_near(
                &mut |low, high| {
                    let gap = gap(low, high, point);
                    (gap < best.get()).then_some(gap)
                },
                &mut |leaf| {
                    let (low, high, _) = describe(leaf);
                    assert!(gap(low, high, point) < best.get(), "it was asked about");
                    best.set(gap(low, high, point));
                    visits += 1;
                },
            );
            let nearest = leaves.iter().map(|leaf| gap(leaf.0, leaf.1, point));
            assert_eq!(best.get(), nearest.fold(f32::INFINITY, f32::min));
            assert!(visits <= 12, "{visits} of {}", leaves.len());
        }
    }
}

#[test]
fn nothing_more_is_visited_once_nothing_is_admitted() {
    let mut random = fastrand::Rng::with_seed(2);
    let (compound, field, voxels) = some(&mut random);
    for of in [
        Composite::Compound(&compound),
        Composite::HeightField(&field),
        Composite::Voxels(&voxels),
    ] {
        let found = Cell::new(0);
        of.walk(&mut |_, _| found.get() == 0, &mut |_| {
            found.set(found.get() + 1);
        });
        assert_eq!(found.get(), 1);
    }
}
