//! Printing a tree: a line for each node, indented by generation.

use std::fmt;

use super::node::NodeId;
use super::tree::Octree;

/// A subtree to be printed. Made by [`Octree::display_with`].
struct DisplaySubtree<'a, T, F> {
    tree: &'a Octree<T>,
    top: NodeId,
    print: F,
}

impl<T, F: Fn(&T, &mut fmt::Formatter<'_>) -> fmt::Result> fmt::Display
    for DisplaySubtree<'_, T, F>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tree = self.tree;
        let top = tree.generation(self.top);
        for node in tree.subtree(self.top) {
            if node != self.top {
                f.write_str("\n")?;
            }
            let indent = 2 * (tree.generation(node) - top) as usize;
            let name = tree.child_type(node).map_or("root", |octant| octant.name());
            let kind = if tree.is_split(node) { "split" } else { "leaf" };
            write!(f, "{:indent$}{name} {kind} ", "")?;
            (self.print)(tree.data(node), f)?;
        }
        Ok(())
    }
}

impl<T> Octree<T> {
    /// Returns the subtree at `node`, to be printed with `print` for each datum.
    ///
    /// There is a line for each node, in the order of [`subtree`](Self::subtree): the name of its
    /// octant, or `root`, whether it is split or a leaf, and its datum. Lines are indented by
    /// generation. The last line is not ended.
    ///
    /// ```
    /// use bevy_octree::octree::Octree;
    ///
    /// let tree = Octree::new(vec!["anvil", "bell"]);
    /// let text = tree.display_with(tree.root(), |objects, f| f.write_str(&objects.join(", ")));
    /// assert_eq!(text.to_string(), "root leaf anvil, bell");
    /// ```
    pub fn display_with(
        &self,
        node: NodeId,
        print: impl Fn(&T, &mut fmt::Formatter<'_>) -> fmt::Result,
    ) -> impl fmt::Display {
        DisplaySubtree {
            tree: self,
            top: node,
            print,
        }
    }
}

impl<T: fmt::Display> Octree<T> {
    /// Returns the subtree at `node`, to be printed as by [`display_with`](Self::display_with) with
    /// the data's own [`Display`](fmt::Display), to which width and precision are passed on.
    pub fn display(&self, node: NodeId) -> impl fmt::Display {
        self.display_with(node, T::fmt)
    }
}

/// Prints the whole tree; as [`Octree::display`] of the root.
impl<T: fmt::Display> fmt::Display for Octree<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.display(self.root()).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octree::Vertex;

    #[test]
    fn a_line_for_each_node_indented_by_generation() {
        let mut tree = Octree::new(1.5);
        tree.split(NodeId::ROOT);
        let child = tree.child(NodeId::ROOT, Vertex::RUB).unwrap();
        tree.split_with(child, |octant| f64::from(octant.bits()));
        let text = tree.to_string();
        let lines = Vec::from_iter(text.lines());
        assert_eq!(lines.len(), tree.node_count());
        assert_eq!(lines[..2], ["root split 1.5", "  LDF leaf 0"]);
        assert_eq!(lines[8..10], ["  RUB split 0", "    LDF leaf 0"]);
        assert_eq!(lines[16], "    RUB leaf 7");
    }

    #[test]
    fn a_subtree_starts_without_indentation() {
        let mut tree = Octree::new(0);
        let child = tree.split(NodeId::ROOT).next_back().unwrap();
        tree.split(child);
        let text = tree
            .display_with(child, |_, f| f.write_str("-"))
            .to_string();
        assert!(text.starts_with("RUB split -\n  LDF leaf -\n  RDF leaf -\n"));
        assert_eq!(text.lines().count(), 9);
    }

    #[test]
    fn format_settings_reach_the_data() {
        assert_eq!(format!("{:.2}", Octree::new(0.123)), "root leaf 0.12");
    }
}
