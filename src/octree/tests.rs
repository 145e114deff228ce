//! Random trees against simpler models of them.

use std::collections::BTreeMap;

use bevy::math::IVec3;
use proptest::prelude::*;

use super::{Direction, NodeId, Octree, Vertex};

/// What to do to the node that `Pick` chooses.
#[derive(Clone, Debug)]
enum Step {
    /// Split a leaf, join another node.
    Toggle,
    Split,
    Clear,
    Swap(u32),
    Grow(Vertex),
    Reset(u32),
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        2 => Just(Step::Toggle),
        6 => Just(Step::Split),
        1 => Just(Step::Clear),
        6 => (1..u32::MAX).prop_map(Step::Swap),
        1 => (0..8_u32).prop_map(|bits| Step::Grow(Vertex::from_bits(bits))),
        1 => (1..u32::MAX).prop_map(Step::Reset),
    ]
}

/// The octants from the root down to the node.
fn path(tree: &Octree<u32>, node: NodeId) -> Vec<Vertex> {
    let ancestry = std::iter::successors(Some(node), |&node| tree.parent(node));
    let mut path: Vec<_> = ancestry.filter_map(|node| tree.child_type(node)).collect();
    path.reverse();
    path
}

/// A tree as a sorted map from paths to data: its order is the depth-first order.
type Model = BTreeMap<Vec<Vertex>, u32>;

/// Does the same to a tree and its model, and compares what was removed.
fn apply(tree: &mut Octree<u32>, model: &mut Model, node: NodeId, step: &Step) {
    let at = path(tree, node);
    let is_inside = |path: &Vec<Vertex>| path.starts_with(&at);
    let mut removed = Vec::new();
    let mut expected = Vec::new();
    match step {
        Step::Toggle if tree.is_split(node) => {
            tree.join(node, |datum| removed.push(datum));
            model.retain(|path, datum| {
                let is_below = is_inside(path) && *path != at;
                if is_below {
                    expected.push(*datum);
                }
                !is_below
            });
        }
        Step::Toggle | Step::Split if tree.is_leaf(node) => {
            let children = tree.split(node);
            assert_eq!(children.len(), 8);
            for octant in Vertex::ALL {
                model.insert([&at[..], &[octant]].concat(), 0);
            }
        }
        Step::Toggle | Step::Split => {}
        Step::Clear => {
            tree.clear(node, |datum| removed.push(datum));
            for (_, datum) in model.iter_mut().filter(|(path, _)| is_inside(path)) {
                expected.push(std::mem::take(datum));
            }
            assert_eq!(removed, expected, "in depth-first order");
        }
        Step::Swap(datum) => {
            assert_eq!(tree.swap_data(node, *datum), model[&at]);
            model.insert(at, *datum);
        }
        Step::Grow(octant) => {
            tree.grow(*octant);
            *model = std::mem::take(model)
                .into_iter()
                .map(|(path, datum)| ([&[*octant][..], &path].concat(), datum))
                .chain([(Vec::new(), 0)])
                .collect();
            for octant in Vertex::ALL {
                model.entry(vec![octant]).or_insert(0);
            }
        }
        Step::Reset(datum) => {
            tree.reset(*datum);
            *model = Model::from([(Vec::new(), *datum)]);
        }
    }
    removed.sort();
    expected.sort();
    assert_eq!(removed, expected);
}

/// Compares every observation of a tree with the model's.
fn compare(tree: &Octree<u32>, model: &Model) {
    tree.assert_well_formed();
    let nodes = Vec::from_iter(tree.subtree(NodeId::ROOT));
    assert_eq!(nodes.len(), model.len());
    assert_eq!(tree.node_count(), model.len());
    assert_eq!(tree.leaf_count(), tree.leaves(NodeId::ROOT).count());
    for (&node, (at, datum)) in nodes.iter().zip(model) {
        assert!(tree.contains(node) && node.index() < tree.index_bound());
        assert_eq!(path(tree, node), *at);
        assert_eq!(tree.data(node), datum);
        assert_eq!(tree.generation(node) as usize, at.len());
        let is_split = model.contains_key(&[&at[..], &[Vertex::LDF]].concat());
        assert_eq!(
            (tree.is_split(node), tree.is_leaf(node)),
            (is_split, !is_split)
        );
        let children = Vertex::ALL
            .into_iter()
            .filter_map(|octant| tree.child(node, octant));
        assert!(tree.children(node).eq(children));
        assert!(
            tree.children(node)
                .all(|child| tree.parent(child) == Some(node))
        );
    }
}

proptest! {
    #[test]
    fn a_tree_behaves_as_its_model(
        steps in prop::collection::vec((any::<prop::sample::Index>(), step()), 0..40),
    ) {
        let mut tree = Octree::new(1);
        let mut model = Model::from([(Vec::new(), 1)]);
        for (pick, step) in steps {
            let nodes = Vec::from_iter(tree.subtree(NodeId::ROOT));
            apply(&mut tree, &mut model, nodes[pick.index(nodes.len())], &step);
            compare(&tree, &model);
        }
    }
}

/// A node's cube in a lattice so fine that no coordinate is halved.
#[derive(Clone, Copy)]
struct Cube {
    node: NodeId,
    low: IVec3,
    side: i32,
}

/// The cubes of all nodes, if the root's lower corner is 0 and its side is 2^`height`.
fn cubes(tree: &Octree<u32>, height: u32) -> Vec<Cube> {
    let cube = |node| {
        let mut low = IVec3::ZERO;
        let mut side = 1 << height;
        for octant in path(tree, node) {
            side /= 2;
            low += (octant.offset() + 1) / 2 * side;
        }
        Cube { node, low, side }
    };
    tree.subtree(NodeId::ROOT).map(cube).collect()
}

/// The smallest cube, not smaller than the given one, just beyond the middle of its face, edge or
/// vertex in the given direction.
fn neighbor_by_search(cubes: &[Cube], of: Cube, direction: Direction) -> Option<NodeId> {
    // In half units, so that the middle of a cube has a coordinate.
    let middle = 2 * of.low + of.side;
    let beyond = middle + (of.side + 1) * direction.offset();
    cubes
        .iter()
        .filter(|cube| cube.side >= of.side)
        .filter(|cube| {
            let (low, high) = (2 * cube.low, 2 * (cube.low + cube.side));
            beyond.cmpgt(low).all() && beyond.cmplt(high).all()
        })
        .min_by_key(|cube| cube.side)
        .map(|cube| cube.node)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn neighbors_are_those_found_by_search(
        // Few splits spread over the tree, and some chains of splits that go deep.
        splits in prop::collection::vec((any::<prop::sample::Index>(), 1..4_u32), 0..8),
        joined in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut tree = Octree::new(0);
        for (pick, chain) in splits {
            for _ in 0..chain {
                let leaves = Vec::from_iter(tree.leaves(NodeId::ROOT));
                let deepest = leaves.iter().map(|&leaf| tree.generation(leaf)).max().unwrap();
                let near = leaves.iter().filter(|&&leaf| tree.generation(leaf) + 1 >= deepest);
                let near = Vec::from_iter(near);
                tree.split(*near[pick.index(near.len())]);
            }
        }
        if let Some(pick) = joined {
            let nodes = tree.subtree(NodeId::ROOT).filter(|&node| tree.is_split(node));
            let nodes = Vec::from_iter(nodes);
            if !nodes.is_empty() {
                tree.join(nodes[pick.index(nodes.len())], drop);
            }
        }
        let cubes = cubes(&tree, 28);
        for &cube in &cubes {
            for direction in Direction::ALL {
                prop_assert_eq!(
                    tree.neighbor(cube.node, direction),
                    neighbor_by_search(&cubes, cube, direction),
                    "{:?} in direction {}", path(&tree, cube.node), direction
                );
            }
        }
    }
}

#[test]
fn a_full_tree_has_every_equal_neighbor() {
    let mut tree = Octree::new(0);
    for _ in 0..3 {
        for leaf in Vec::from_iter(tree.leaves(NodeId::ROOT)) {
            tree.split(leaf);
        }
    }
    let cubes = cubes(&tree, 3);
    for &cube in cubes.iter().filter(|cube| cube.side == 1) {
        for direction in Direction::ALL {
            let low = cube.low + direction.offset();
            let expected = cubes
                .iter()
                .find(|other| other.side == 1 && other.low == low);
            assert_eq!(
                tree.neighbor(cube.node, direction),
                expected.map(|other| other.node)
            );
        }
    }
}

#[test]
fn memory_is_flat_over_splitting_and_joining() {
    let mut tree = Octree::new(0);
    let mut memory = None;
    for round in 0..50_u32 {
        for turn in 0..40 {
            let leaf = tree
                .leaves(NodeId::ROOT)
                .nth((turn * 7 + round) as usize % tree.leaf_count());
            tree.split(leaf.unwrap());
        }
        tree.join(NodeId::ROOT, drop);
        tree.assert_well_formed();
        assert_eq!(
            *memory.get_or_insert(tree.memory_bytes()),
            tree.memory_bytes()
        );
    }
}
