//! The boxes of the tree that a mesh is searched by, for whoever wants to see them.

use bevy::math::bounding::Aabb3d;

use super::polygon_mesh::PolygonMesh;
use crate::broad_phase::StillOctree;

impl PolygonMesh {
    /// Returns the number of levels of boxes in the tree of the polygons: the lowest has the boxes of
    /// the polygons themselves, each box of a higher one is around eight of the level below, but for
    /// the last. 0 where there are so few polygons that they have no tree.
    #[must_use]
    pub fn tree_height(&self) -> u32 {
        self.tree().map_or(0, StillOctree::height)
    }

    /// Calls `found` with each box on a level of the tree, 0 for the lowest, in the mesh's own space:
    /// to draw them, or to tell how well a mesh can be searched. There are none from
    /// [`tree_height`](Self::tree_height) on.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// // A strip of 64 triangles.
    /// let corners: Vec<_> = (0..66).map(|at| Vec3::new((at / 2) as f32, (at % 2) as f32, 0.0)).collect();
    /// let triangles = (0..64).map(|at| [at, at + 1, at + 2]);
    /// let mesh = PolygonMesh::new(corners, triangles)?;
    /// let mut eighths = 0;
    /// mesh.for_each_tree_box(1, |_| eighths += 1);
    /// assert_eq!((mesh.tree_height(), eighths), (2, 8));
    /// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
    /// ```
    #[doc(alias = "bvh")]
    pub fn for_each_tree_box(&self, level: u32, mut found: impl FnMut(&Aabb3d)) {
        if let Some(tree) = self.tree().filter(|tree| level < tree.height()) {
            for index in 0..tree.blocks_on(level) {
                tree.for_each_in_block(level, index, |aabb, _| found(aabb));
            }
        }
    }
}
