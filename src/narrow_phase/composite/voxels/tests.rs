//! Voxels against sets of cells.

use std::collections::BTreeSet;

use bevy::{math::Vec3, transform::components::Transform};
use proptest::prelude::*;

use super::*;
use crate::narrow_phase::{NarrowPhase, Placed, Shape, Workspace, composite::box_tree::BoxTree};

type Key = [i32; 3];

fn cells(voxels: &Voxels) -> BTreeSet<Key> {
    voxels.iter().map(|cell| cell.to_array()).collect()
}

fn block(from: IVec3, to: IVec3) -> impl Iterator<Item = IVec3> {
    (from.z..to.z).flat_map(move |z| {
        (from.y..to.y).flat_map(move |y| (from.x..to.x).map(move |x| IVec3::new(x, y, z)))
    })
}

/// All boxes of a set, which are to be its cells, with the faces that these have.
fn checked_boxes(voxels: &Voxels, admits: &mut dyn FnMut(Vec3A, Vec3A) -> bool) -> Vec<Cells> {
    let mut boxes = Vec::new();
    voxels.walk(admits, &mut |cells| boxes.push(cells));
    let mut seen = BTreeSet::new();
    for of in &boxes {
        let size = voxels.cell_size();
        assert_eq!(of.low, of.first.as_vec3a() * size);
        assert_eq!(of.high, (of.last + 1).as_vec3a() * size);
        for cell in block(of.first, of.last + 1) {
            assert!(seen.insert(cell.to_array()), "{cell} once");
            let exposed = voxels.exposed(cell).expect("it is full");
            for face in Face::ALL {
                let beside = cell + face.offset();
                let is_inner = beside.cmpge(of.first).all() && beside.cmple(of.last).all();
                let expected = of.faces.contains(face) && !is_inner;
                assert_eq!(exposed.contains(face), expected, "{cell} {face} {of:?}");
            }
        }
    }
    boxes
}

#[test]
fn bad_numbers_are_refused() {
    for size in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e29] {
        assert!(
            matches!(Voxels::new(size), Err(ShapeError::VoxelSize(_))),
            "{size}"
        );
    }
    for bad in [Vec3::NAN, Vec3::X * 3e9, Vec3::NEG_Y * f32::INFINITY] {
        let error = Voxels::from_points(1.0, [Vec3::ZERO, bad]).unwrap_err();
        assert!(matches!(error, ShapeError::VoxelPoint { point: 1, .. }));
    }
    let found = Voxels::from_points(0.5, [Vec3::splat(-0.1), Vec3::splat(0.5), Vec3::ONE * 0.9]);
    assert_eq!(cells(&found.unwrap()), [[-1; 3], [1; 3]].into());
}

#[test]
fn nothing_is_nowhere() {
    let mut voxels = Voxels::new(2.0).unwrap();
    let nothing = (Vec3A::ZERO, Vec3A::ZERO, 0.0);
    assert_eq!((voxels.local_bounds(), voxels.extents()), (nothing, None));
    assert!(voxels.set(IVec3::splat(-7)) && !voxels.set(IVec3::splat(-7)));
    assert_eq!(voxels.local_bounds().0, Vec3A::splat(-13.0));
    assert!(voxels.clear(IVec3::splat(-7)) && !voxels.clear(IVec3::splat(-7)));
    assert_eq!((voxels.local_bounds(), voxels.len()), (nothing, 0));
    assert!(checked_boxes(&voxels, &mut |_, _| true).is_empty());
    voxels.assert_well_formed();
}

#[test]
fn the_ends_of_numbers_are_cells() {
    let ends = [i32::MIN, i32::MIN + 1, -1, 0, i32::MAX - 1, i32::MAX];
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..20 {
        let mut voxels = Voxels::new(1e-3).unwrap();
        let mut expected = BTreeSet::new();
        for _ in 0..30 {
            let cell = IVec3::from([(); 3].map(|()| ends[random.usize(0..ends.len())]));
            assert_eq!(voxels.set(cell), expected.insert(cell.to_array()));
            assert!(voxels.exposed(cell).is_some());
        }
        voxels.assert_well_formed();
        assert_eq!(cells(&voxels), expected);
        assert!(voxels.local_bounds().1.is_finite());
        let mut count = 0;
        voxels.walk(
            &mut |low, high| low.is_finite() && high.is_finite(),
            &mut |of: Cells| {
                count += (of.last - of.first + 1).element_product();
            },
        );
        assert_eq!(count as u64, voxels.len());
        for cell in expected {
            assert!(voxels.clear(cell.into()));
        }
        voxels.assert_well_formed();
        assert!(voxels.is_empty());
    }
}

#[test]
fn a_full_block_is_few_nodes() {
    let side = 32;
    let mut voxels = Voxels::from_cells(1.0, block(IVec3::ZERO, IVec3::splat(side))).unwrap();
    voxels.assert_well_formed();
    assert_eq!(voxels.tree.node_count(), 1);
    assert!(voxels.clear(IVec3::splat(9)));
    voxels.assert_well_formed();
    assert_eq!(voxels.tree.node_count(), 1 + 3 * 8);
    assert!(
        voxels
            .exposed(IVec3::new(8, 9, 9))
            .unwrap()
            .contains(Face::R)
    );
    assert!(voxels.set(IVec3::splat(9)));
    assert_eq!(voxels.tree.node_count(), 1);
    assert_eq!(voxels.iter().count(), (side * side * side) as usize);
    // Inner bricks are one box each, those at the border a few.
    let boxes = checked_boxes(&voxels, &mut |_, _| true);
    let inner = boxes
        .iter()
        .filter(|of| of.faces.is_empty() && of.last - of.first == IVec3::splat(3));
    assert_eq!(inner.count(), 6 * 6 * 6);
}

#[test]
fn floors_are_few_boxes() {
    let voxels = Voxels::from_cells(1.0, block(IVec3::ZERO, IVec3::new(16, 1, 16))).unwrap();
    let boxes = checked_boxes(&voxels, &mut |_, _| true);
    // One for each brick.
    assert_eq!(boxes.len(), 16);
}

#[test]
fn the_same_cells_are_equal_whatever_was_there_before() {
    let mut random = fastrand::Rng::with_seed(3);
    let mut all: Vec<IVec3> = block(IVec3::splat(-5), IVec3::splat(5)).collect();
    let a = Voxels::from_cells(1.0, all.iter().copied()).unwrap();
    random.shuffle(&mut all);
    let mut b = Voxels::new(1.0).unwrap();
    assert!(b.set(IVec3::new(900, -80_000, 3)));
    b.extend(all.iter().copied());
    assert_ne!(a, b);
    assert!(b.clear(IVec3::new(900, -80_000, 3)));
    assert_eq!(a, b);
    assert_eq!(b, a);
    assert!(b.clear(IVec3::ZERO) && b.set(IVec3::splat(7)));
    assert_ne!(a, b);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn edits_are_those_of_a_set(seed: u64, reach in 1_i32..24, steps in 1_usize..2000) {
        let mut random = fastrand::Rng::with_seed(seed);
        let origin = IVec3::from([(); 3].map(|()| random.i32(-100..100)));
        let (mut voxels, mut expected) = (Voxels::new(0.25).unwrap(), BTreeSet::new());
        let mostly = random.f32();
        for _ in 0..steps {
            let cell = origin + IVec3::from([(); 3].map(|()| random.i32(-reach..reach)));
            let key = cell.to_array();
            prop_assert_eq!(voxels.contains(cell), expected.contains(&key));
            if random.f32() < mostly {
                prop_assert_eq!(voxels.set(cell), expected.insert(key));
            } else {
                prop_assert_eq!(voxels.clear(cell), expected.remove(&key));
            }
        }
        voxels.assert_well_formed();
        prop_assert_eq!(&cells(&voxels), &expected);
        prop_assert_eq!(voxels.len(), expected.len() as u64);
        let mut count = 0;
        for of in checked_boxes(&voxels, &mut |_, _| true) {
            count += (of.last - of.first + 1).element_product();
        }
        prop_assert_eq!(count as u64, voxels.len());
    }

    #[test]
    fn dense_blocks_with_a_few_holes(seed: u64, side in 1_i32..20) {
        let mut random = fastrand::Rng::with_seed(seed);
        let from = IVec3::from([(); 3].map(|()| random.i32(-9..9)));
        let mut voxels = Voxels::from_cells(1.0, block(from, from + side)).unwrap();
        for _ in 0..random.usize(0..20) {
            let cell = from + IVec3::from([(); 3].map(|()| random.i32(0..side)));
            voxels.clear(cell);
        }
        voxels.assert_well_formed();
        checked_boxes(&voxels, &mut |_, _| true);
        // What overlaps a box, by cells.
        let mut corner = || (from + IVec3::from([(); 3].map(|()| random.i32(-2..side + 2)))).as_vec3a() + 0.5;
        let (a, b) = (corner(), corner());
        let (low, high) = (a.min(b), a.max(b));
        let overlaps = |l: Vec3A, h: Vec3A| l.cmple(high).all() && h.cmpge(low).all();
        let mut found = BTreeSet::new();
        voxels.walk(&mut |l, h| overlaps(l, h), &mut |of: Cells| {
            found.extend(block(of.first, of.last + 1).map(|cell| cell.to_array()));
        });
        found.retain(|cell| overlaps(IVec3::from(*cell).as_vec3a(), (IVec3::from(*cell) + 1).as_vec3a()));
        let all = voxels.iter().filter(|cell| overlaps(cell.as_vec3a(), (*cell + 1).as_vec3a()));
        prop_assert_eq!(found, all.map(|cell| cell.to_array()).collect::<BTreeSet<_>>());
    }
}

#[test]
fn nothing_is_closest_where_there_is_nothing() {
    let (empty, at) = (Shape::from(Voxels::new(1.0).unwrap()), Transform::IDENTITY);
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let empty = Placed::new(&empty, &at);
    assert_eq!(tests.closest_point(empty, Vec3::ZERO, &mut workspace), None);
    let point = Shape::sphere(0.0);
    for other in [Placed::new(&point, &at), empty] {
        assert_eq!(tests.closest_points(empty, other, &mut workspace), None);
    }
}
