//! Each operation against what it is said to ensure.

use super::*;

/// A tree whose root and first child are split, every node numbered in the order of
/// [`Octree::subtree`].
fn numbered() -> (Octree<u32>, NodeId) {
    let mut tree = Octree::new(0);
    let first = tree.split(NodeId::ROOT).next().unwrap();
    tree.split_with(first, |octant| octant.bits() + 2);
    tree.swap_data(first, 1);
    for (i, child) in (10..).zip(tree.children(NodeId::ROOT).skip(1)) {
        tree.swap_data(child, i);
    }
    (tree, first)
}

#[test]
fn a_new_tree_is_one_leaf() {
    let tree = Octree::new(7);
    assert_eq!(tree.root(), NodeId::ROOT);
    assert_eq!(*tree.data(tree.root()), 7);
    assert_eq!(tree.parent(tree.root()), None);
    assert_eq!(tree.child_type(tree.root()), None);
    assert_eq!(tree.generation(tree.root()), 0);
    assert!(tree.is_leaf(tree.root()) && !tree.is_split(tree.root()));
    assert_eq!((tree.node_count(), tree.leaf_count()), (1, 1));
    assert_eq!(tree.children(tree.root()).len(), 0);
    assert!(
        Vertex::ALL
            .into_iter()
            .all(|octant| tree.child(tree.root(), octant).is_none())
    );
}

#[test]
fn split_gives_eight_empty_children_and_keeps_the_datum() {
    let mut tree = Octree::new(7);
    let children = tree.split(NodeId::ROOT);
    assert!(tree.is_split(NodeId::ROOT));
    assert_eq!(*tree.data(NodeId::ROOT), 7);
    assert_eq!((tree.node_count(), tree.leaf_count()), (9, 8));
    for (octant, child) in Vertex::ALL.into_iter().zip(children) {
        assert_eq!(tree.child(NodeId::ROOT, octant), Some(child));
        assert_eq!(tree.child_type(child), Some(octant));
        assert_eq!(tree.parent(child), Some(NodeId::ROOT));
        assert_eq!(tree.generation(child), 1);
        assert_eq!(*tree.data(child), 0);
        assert!(tree.is_leaf(child) && tree.contains(child));
    }
    tree.assert_well_formed();
}

#[test]
fn join_hands_out_descendants_children_first_and_keeps_the_datum() {
    let (mut tree, first) = numbered();
    let mut removed = Vec::new();
    tree.join(NodeId::ROOT, |datum| removed.push(datum));
    let expected: Vec<u32> = (2..10).chain([1]).chain(10..17).collect();
    assert_eq!(removed, expected);
    assert!(tree.is_leaf(NodeId::ROOT) && !tree.contains(first));
    assert_eq!((tree.node_count(), *tree.data(NodeId::ROOT)), (1, 0));
    tree.assert_well_formed();
}

#[test]
fn join_of_an_inner_node_leaves_the_rest() {
    let (mut tree, first) = numbered();
    let mut removed = 0;
    tree.join(first, |_| removed += 1);
    assert_eq!((removed, tree.node_count()), (8, 9));
    let left: Vec<u32> = tree
        .subtree(NodeId::ROOT)
        .map(|node| *tree.data(node))
        .collect();
    assert_eq!(left, [0, 1, 10, 11, 12, 13, 14, 15, 16]);
    tree.assert_well_formed();
}

#[test]
fn clear_takes_the_data_and_leaves_the_nodes() {
    let (mut tree, first) = numbered();
    let mut removed = Vec::new();
    tree.clear(first, |datum| removed.push(datum));
    assert_eq!(removed, Vec::from_iter(1..10));
    assert_eq!(tree.node_count(), 17);
    assert!(tree.subtree(first).all(|node| *tree.data(node) == 0));
    assert_eq!(
        tree.subtree(NodeId::ROOT)
            .map(|node| *tree.data(node))
            .sum::<u32>(),
        (10..17).sum::<u32>()
    );
    tree.assert_well_formed();
}

#[test]
fn walks_are_depth_first_and_stay_in_the_subtree() {
    let (tree, first) = numbered();
    let data = |nodes: &mut dyn Iterator<Item = NodeId>| {
        Vec::from_iter(nodes.map(|node| *tree.data(node)))
    };
    assert_eq!(data(&mut tree.subtree(NodeId::ROOT)), Vec::from_iter(0..17));
    assert_eq!(data(&mut tree.subtree(first)), Vec::from_iter(1..10));
    assert_eq!(data(&mut tree.leaves(NodeId::ROOT)), Vec::from_iter(2..17));
    assert_eq!(data(&mut tree.leaves(first)), Vec::from_iter(2..10));
    assert_eq!(
        data(&mut tree.children(first).rev()),
        Vec::from_iter((2..10).rev())
    );
    assert_eq!(tree.leaves(NodeId::ROOT).count(), tree.leaf_count());
    let leaf = tree.child(first, Vertex::RUB).unwrap();
    assert_eq!(Vec::from_iter(tree.subtree(leaf)), [leaf]);
    assert_eq!(Vec::from_iter(tree.leaves(leaf)), [leaf]);
}

#[test]
fn data_are_swapped_and_changed_in_place() {
    let (mut tree, first) = numbered();
    assert_eq!(tree.swap_data(first, 99), 1);
    *tree.data_mut(NodeId::ROOT) += 5;
    let (root, child) = tree.data_pair_mut(NodeId::ROOT, first).unwrap();
    mem::swap(root, child);
    assert_eq!((*tree.data(NodeId::ROOT), *tree.data(first)), (99, 5));
    assert!(tree.data_pair_mut(first, first).is_none());
}

#[test]
fn grow_puts_the_old_root_below_the_new_one() {
    let (mut tree, first) = numbered();
    *tree.data_mut(NodeId::ROOT) = 50;
    let old = tree.grow(Vertex::RUF);
    assert_eq!(tree.child(NodeId::ROOT, Vertex::RUF), Some(old));
    assert_eq!((*tree.data(NodeId::ROOT), *tree.data(old)), (0, 50));
    assert_eq!((tree.parent(first), tree.generation(first)), (Some(old), 2));
    assert_eq!(tree.node_count(), 25);
    tree.assert_well_formed();
}

#[test]
fn grow_of_a_leaf_keeps_it_a_leaf() {
    let mut tree = Octree::new(3);
    let old = tree.grow(Vertex::LDB);
    assert!(tree.is_leaf(old));
    assert_eq!(*tree.data(old), 3);
    tree.assert_well_formed();
}

#[test]
fn reset_keeps_the_memory() {
    let (mut tree, first) = numbered();
    let memory = tree.memory_bytes();
    tree.reset(4);
    assert_eq!((tree.node_count(), *tree.data(NodeId::ROOT)), (1, 4));
    assert!(!tree.contains(first));
    assert_eq!(tree.memory_bytes(), memory);
    tree.assert_well_formed();
}

#[test]
fn freed_blocks_are_used_again() {
    let mut tree = Octree::with_capacity(0, 17);
    let memory = tree.memory_bytes();
    for _ in 0..1000 {
        let first = tree.split_with(NodeId::ROOT, |_| 1).next().unwrap();
        tree.split_with(first, |_| 1);
        tree.join(NodeId::ROOT, drop);
    }
    assert_eq!(tree.memory_bytes(), memory);
    assert_eq!(tree.index_bound(), 24);
    assert!(tree.split(NodeId::ROOT).all(|child| *tree.data(child) == 0));
    tree.assert_well_formed();
}

#[test]
fn very_deep_trees_are_walked_without_recursion() {
    let mut tree = Octree::new(0_u8);
    let mut node = NodeId::ROOT;
    for _ in 0..100_000 {
        node = tree.split(node).next_back().unwrap();
    }
    assert_eq!(tree.generation(node), 100_000);
    assert_eq!(tree.subtree(NodeId::ROOT).count(), tree.node_count());
    let mut removed = 0;
    tree.join(NodeId::ROOT, |_| removed += 1);
    assert_eq!(removed, 800_000);
}

#[test]
fn an_unwinding_closure_leaves_the_tree_in_order() {
    for allowed in 0..16 {
        let (mut tree, _) = numbered();
        let mut calls = 0;
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            tree.join(NodeId::ROOT, |_| {
                calls += 1;
                if calls > allowed {
                    std::panic::resume_unwind(Box::new(()));
                }
            });
        }));
        assert!(result.is_err());
        tree.assert_well_formed();
    }
}

#[test]
fn handles_are_four_bytes_with_or_without_option() {
    assert_eq!(size_of::<NodeId>(), 4);
    assert_eq!(size_of::<Option<NodeId>>(), 4);
    assert_eq!(size_of::<Node<u32>>(), 8);
}

#[test]
#[cfg(debug_assertions)]
#[should_panic(expected = "was removed")]
fn dead_handles_are_detected() {
    let (mut tree, first) = numbered();
    tree.join(NodeId::ROOT, drop);
    let _ = tree.data(first);
}

#[test]
#[cfg(debug_assertions)]
#[should_panic(expected = "is split already")]
fn splitting_twice_is_detected() {
    let (mut tree, _) = numbered();
    tree.split(NodeId::ROOT);
}

#[test]
#[cfg(not(debug_assertions))]
fn unmet_requirements_change_nothing() {
    let (mut tree, first) = numbered();
    assert!(tree.split(first).eq(tree.children(first)));
    let leaf = tree.children(first).next().unwrap();
    tree.join(leaf, |_| panic!("nothing is removed"));
    assert_eq!(tree.node_count(), 17);
    assert!(
        tree.subtree(NodeId::ROOT)
            .map(|node| *tree.data(node))
            .eq(0..17)
    );
    tree.assert_well_formed();
}
