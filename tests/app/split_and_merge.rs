//! The three frames of Swan, *Fast Collision Detection with an N-Objects Octree*, 1994, Figures 5
//! to 7.

use crate::common;

use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_octree::{
    broad_phase::{BroadPhaseStats, ObjectOctreeSettings, ProxyId, Visitor},
    prelude::*,
    scene::Cube,
};
use common::*;

/// Three unit cubes in a row along x. The root is 150 % of their bounding box: from -4.5 to 4.5.
/// Both outer cubes reach the central one, which lies left of the middle plane, at tick 24.
fn three_in_a_row() -> (App, [Entity; 3]) {
    let mut app = app(BroadPhaseMethod::ObjectOctree(
        ObjectOctreeSettings::with_max_objects(2),
    ));
    let row = [(-2.5, 1.0 / 32.0), (-0.75, 0.0), (2.5, -3.0 / 32.0)].map(|(x, step)| {
        let velocity = Velocity(Vec3::X * step * TICKS_PER_SECOND);
        app.world_mut()
            .spawn((Cube, Transform::from_xyz(x, 0.0, 0.0), velocity))
            .id()
    });
    (app, row)
}

/// The generations of the leaves that list an entity, from the size of their cells.
fn generations(app: &App, entity: Entity) -> Vec<u32> {
    struct Leaves(ProxyId, Vec<u32>);
    impl Visitor for Leaves {
        fn enter(&mut self, _: &Aabb3d) -> bool {
            true
        }
        fn object(&mut self, id: ProxyId, _: &Aabb3d, cell: &Aabb3d) {
            if id == self.0 {
                // All of them reach from the row outward in y: by half the root in generation 1, a
                // quarter in 2.
                let side = cell.min.y.abs().max(cell.max.y.abs()).min(4.5);
                self.1.push((9.0 / side).log2().round() as u32);
            }
        }
    }
    let proxy = get::<bevy_octree::components::BroadPhaseProxy>(app, entity);
    let mut leaves = Leaves(proxy.id().unwrap(), Vec::new());
    index(app).traverse(&mut leaves);
    leaves.1.sort_unstable();
    leaves.1
}

#[test]
fn the_right_object_crosses_the_middle_and_goes_back() {
    let (mut app, row) = three_in_a_row();
    let mut mirror = Mirror::new(ObjectOctreeSettings::with_max_objects(2));
    for number in 1..=40 {
        tick(&mut app, 1);
        mirror.follow(&mut app);
        let left_side = get::<Transform>(&app, row[2]).translation.x - 0.5;
        let crossed = (22..27).contains(&number);
        assert_eq!(left_side < 0.0, crossed, "tick {number}");
        let stats = index(&app).stats();
        // Crossing, it is the third in each of the four left octants along the row: they split, and
        // so does the one of their children in which all three still are.
        let (nodes, depth, entries) = if crossed {
            (1 + 8 + 4 * 8 + 4 * 8, 3, 24)
        } else {
            (1 + 8, 1, 12)
        };
        assert_eq!(
            (stats.nodes, stats.depth, stats.entries),
            (nodes, depth, entries),
            "tick {number}"
        );
        // The app's index knows the order of entities, too.
        let bytes = stats.bytes;
        let expected = BroadPhaseStats {
            bytes,
            ..mirror.stats()
        };
        assert_eq!(stats, expected, "tick {number}");
        assert_eq!(
            contacts(&app).len(),
            if number == 24 { 2 } else { 0 },
            "tick {number}"
        );
    }
    assert_eq!(
        app.world().resource::<CollisionCounters>().total.bounces,
        2,
        "the central cube is at rest"
    );
}

#[test]
fn the_leaves_of_each_object_follow_the_three_frames() {
    let (mut app, row) = three_in_a_row();
    // Ticks to go, and the generations of the leaves that list the left, the central and the right
    // object.
    let frames = [
        (21, [vec![1; 4], vec![1; 4], vec![1; 4]]),
        (
            1,
            [
                vec![2, 2, 2, 2, 3, 3, 3, 3],
                vec![3; 8],
                vec![1, 1, 1, 1, 3, 3, 3, 3],
            ],
        ),
        (5, [vec![1; 4], vec![1; 4], vec![1; 4]]),
    ];
    for (frame, (ticks, expected)) in frames.into_iter().enumerate() {
        tick(&mut app, ticks);
        assert_eq!(
            row.map(|entity| generations(&app, entity)),
            expected,
            "frame {}",
            frame + 1
        );
    }
}
