//! Solids of equal cubes, in an octree.

mod brick;
mod faces;
mod slabs;
mod walk;

use bevy::math::{I64Vec3, IVec3, Vec3, Vec3A};

use crate::{
    narrow_phase::{error::ShapeError, length::length},
    octree::{Face, NodeId, Octree, Vertex},
};
use brick::{FULL, bit};
use slabs::Slabs;

pub use faces::Faces;
pub use walk::Cells;

/// Cells larger than this could be infinitely far away.
const LARGEST_CELL: f32 = 1e28;

/// A solid made of full cells of a cubic grid: what a game of blocks, or a scan, has.
///
/// * Cell (0, 0, 0) is the cube from the origin to the size of a cell along each axis; cells are
///   named by how many they are away from it, with any 32-bit numbers.
/// * Cells are in an octree over bricks of 4 × 4 × 4, each a mask of 64 bits; what is full or empty
///   as a whole is one node, however large. To fill or clear a cell takes a walk down the tree, and
///   so does the question whether it is full.
/// * Faces between two full cells are inside of the solid, and of no account: see
///   [`exposed`](Self::exposed).
///
/// ```
/// use bevy::math::IVec3;
/// use bevy_octree::{narrow_phase::Voxels, octree::Face};
///
/// let floor = (0..16).flat_map(|x| (0..16).map(move |z| IVec3::new(x, 0, z)));
/// let mut ground = Voxels::from_cells(0.5, floor)?;
/// assert_eq!(ground.len(), 256);
///
/// // Dig a hole, and pile up what came out of it.
/// assert!(ground.clear(IVec3::new(3, 0, 3)));
/// assert!(ground.set(IVec3::new(4, 1, 3)));
/// let beside = ground.exposed(IVec3::new(4, 0, 3)).unwrap();
/// assert!(beside.contains(Face::L) && !beside.contains(Face::U));
/// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
/// ```
///
/// Those of an entity are shared with all clones of its shape; how they are dug is on the page
/// about [shapes](crate::guide::shapes#what-is-dug-and-built).
#[doc(alias("blocks", "minecraft", "voxel grid"))]
#[derive(Clone, Debug)]
pub struct Voxels {
    cell_size: f32,
    /// Leaves have masks; nodes that are split have 0. A leaf that is no brick is full or empty, and
    /// so no node has eight children that are all full, or all empty.
    tree: Octree<u64>,
    /// The lowest brick in the root.
    corner: I64Vec3,
    /// The root is as many bricks wide as 2 to the power of this.
    height: u32,
    len: u64,
    /// By axis, which coordinates there are.
    slabs: [Slabs; 3],
    /// The ends of these.
    extents: Option<[IVec3; 2]>,
}

impl Voxels {
    /// Makes a set of no cells, which are to be as large as told. As long as it is empty it is in
    /// contact with nothing.
    ///
    /// # Errors
    /// [`ShapeError::VoxelSize`] unless the size is greater than zero and at most 10²⁸.
    pub fn new(cell_size: f32) -> Result<Self, ShapeError> {
        // Not for a size that is not a number, either.
        if !(cell_size > 0.0 && cell_size <= LARGEST_CELL) {
            return Err(ShapeError::VoxelSize(cell_size));
        }
        Ok(Self {
            cell_size,
            tree: Octree::new(0),
            corner: I64Vec3::ZERO,
            height: 0,
            len: 0,
            slabs: Default::default(),
            extents: None,
        })
    }

    /// Makes a set of some cells, each of which may be named more than once.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn from_cells(
        cell_size: f32,
        cells: impl IntoIterator<Item = IVec3>,
    ) -> Result<Self, ShapeError> {
        let mut voxels = Self::new(cell_size)?;
        voxels.extend(cells);
        Ok(voxels)
    }

    /// Makes a set of the cells in which there are points, as those of a scan.
    ///
    /// # Errors
    /// As for [`new`](Self::new), and [`ShapeError::VoxelPoint`] for a point that is not finite, or
    /// so far away that 32 bits cannot number its cell.
    pub fn from_points(
        cell_size: f32,
        points: impl IntoIterator<Item = Vec3>,
    ) -> Result<Self, ShapeError> {
        let mut voxels = Self::new(cell_size)?;
        for (point, position) in points.into_iter().enumerate() {
            let Some(cell) = voxels.cell_at(position) else {
                return Err(ShapeError::VoxelPoint { point, position });
            };
            voxels.set(cell);
        }
        Ok(voxels)
    }

    /// Returns the length of a side of a cell.
    #[must_use]
    pub const fn cell_size(&self) -> f32 {
        self.cell_size
    }

    /// Returns how many cells are full.
    #[must_use]
    pub const fn len(&self) -> u64 {
        self.len
    }

    /// Returns `true` if no cell is full.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns the cell in which a point is, full or not; `None` if 32 bits cannot number it. Points
    /// on faces are in the cell with the greater numbers.
    #[must_use]
    pub fn cell_at(&self, point: Vec3) -> Option<IVec3> {
        let cell = (point.as_dvec3() / f64::from(self.cell_size)).floor();
        let (low, high) = (f64::from(i32::MIN), f64::from(i32::MAX));
        // Not for what is not a number, either.
        let is_there = cell.min_element() >= low && cell.max_element() <= high;
        is_there.then(|| cell.as_ivec3())
    }

    /// Returns `true` if a cell is full.
    #[must_use]
    pub fn contains(&self, cell: IVec3) -> bool {
        self.mask_of(brick_of(cell)) & bit(cell) != 0
    }

    /// Fills a cell; tells whether it was empty.
    ///
    /// The time taken is that of a walk down the tree, whose depth is logarithmic in how far apart
    /// cells are.
    pub fn set(&mut self, cell: IVec3) -> bool {
        let brick = brick_of(cell);
        let offset = self.make_room(brick);
        let (mut node, mut height) = (NodeId::ROOT, self.height);
        while height > 0 {
            if self.tree.is_leaf(node) {
                if *self.tree.data(node) == FULL {
                    return false;
                }
                self.tree.split(node);
            }
            height -= 1;
            node = self.child(node, octant(offset, height));
        }
        let mask = self.tree.data_mut(node);
        let before = *mask;
        *mask |= bit(cell);
        let after = *mask;
        if after == before {
            return false;
        }
        self.len += 1;
        self.note_slabs(before, cell, Slabs::add);
        if after == FULL {
            self.join_above(node, FULL);
        }
        true
    }

    /// Clears a cell; tells whether it was full. In the time that [`set`](Self::set) takes.
    pub fn clear(&mut self, cell: IVec3) -> bool {
        let Some(offset) = self.offset(brick_of(cell)) else {
            return false;
        };
        let (mut node, mut height) = (NodeId::ROOT, self.height);
        while height > 0 {
            if self.tree.is_leaf(node) {
                if *self.tree.data(node) != FULL {
                    return false;
                }
                self.tree.swap_data(node, 0);
                self.tree.split_with(node, |_| FULL);
            }
            height -= 1;
            node = self.child(node, octant(offset, height));
        }
        let mask = self.tree.data_mut(node);
        let before = *mask;
        *mask &= !bit(cell);
        let after = *mask;
        if after == before {
            return false;
        }
        self.len -= 1;
        self.note_slabs(after, cell, Slabs::remove);
        if after == 0 {
            self.join_above(node, 0);
        }
        true
    }

    /// Returns the faces of a full cell that are the border of the solid: those to empty cells.
    /// `None` if the cell is not full.
    #[must_use]
    pub fn exposed(&self, cell: IVec3) -> Option<Faces> {
        let mask = self.mask_of(brick_of(cell));
        if mask & bit(cell) == 0 {
            return None;
        }
        let is_exposed = |face: &Face| {
            let offset = face.offset();
            let Some(beside) = cell.checked_add(offset) else {
                // Beyond the last number there is nothing.
                return true;
            };
            let mask = match brick_of(beside) == brick_of(cell) {
                true => mask,
                false => self.mask_of(brick_of(beside)),
            };
            mask & bit(beside) == 0
        };
        Some(Face::ALL.into_iter().filter(is_exposed).collect())
    }

    /// Returns all full cells, near ones one after the other.
    pub fn iter(&self) -> impl Iterator<Item = IVec3> {
        self.bricks()
            .flat_map(|(brick, mask)| brick::cells(brick, mask))
    }

    /// Returns the lowest and the highest coordinates of full cells; `None` if there are none.
    #[must_use]
    pub const fn extents(&self) -> Option<[IVec3; 2]> {
        self.extents
    }

    /// Returns how much memory the set takes, but for a little by how far it reaches.
    #[must_use]
    pub const fn memory_bytes(&self) -> usize {
        size_of::<Self>() + self.tree.memory_bytes()
    }

    /// Centre, half extents and bounding radius. Of an empty set, the origin.
    pub(in crate::narrow_phase) fn local_bounds(&self) -> (Vec3A, Vec3A, f32) {
        let Some([low, high]) = self.corners() else {
            return (Vec3A::ZERO, Vec3A::ZERO, 0.0);
        };
        let center = low * 0.5 + high * 0.5;
        let half = (high - center).max(center - low);
        (center, half, length(half))
    }

    /// The corners of the box around all cells.
    fn corners(&self) -> Option<[Vec3A; 2]> {
        let [low, high] = self.extents()?;
        Some([
            self.place(low.as_i64vec3()),
            self.place(high.as_i64vec3() + 1),
        ])
    }

    /// Where the lower corner of a cell is.
    #[inline]
    fn place(&self, cell: I64Vec3) -> Vec3A {
        Vec3A::new(cell.x as f32, cell.y as f32, cell.z as f32) * self.cell_size
    }

    /// How far a brick is from the lowest one in the root, if it is in there.
    #[inline]
    fn offset(&self, brick: IVec3) -> Option<I64Vec3> {
        let offset = brick.as_i64vec3() - self.corner;
        let bits = offset.x | offset.y | offset.z;
        // Negative numbers have the highest bit.
        (bits as u64 >> self.height == 0).then_some(offset)
    }

    /// Makes the root large enough for a brick, and tells how far that is from its corner.
    fn make_room(&mut self, brick: IVec3) -> I64Vec3 {
        if self.len == 0 {
            (self.corner, self.height) = (brick.as_i64vec3(), 0);
        }
        loop {
            if let Some(offset) = self.offset(brick) {
                return offset;
            }
            // Towards the brick: the old root is on the far side.
            let is_below = brick.as_i64vec3().cmplt(self.corner);
            self.corner -= I64Vec3::select(is_below, I64Vec3::ONE, I64Vec3::ZERO) << self.height;
            self.height += 1;
            let [x, y, z] = is_below.into();
            self.tree.grow(Vertex::from_sides(x, y, z));
        }
    }

    #[inline]
    fn child(&self, node: NodeId, octant: Vertex) -> NodeId {
        let child = self.tree.child(node, octant);
        child.expect("the node is split")
    }

    /// The mask of a brick.
    #[inline]
    fn mask_of(&self, brick: IVec3) -> u64 {
        let Some(offset) = self.offset(brick) else {
            return 0;
        };
        let (mut node, mut height) = (NodeId::ROOT, self.height);
        while height > 0 {
            let Some(child) = self.tree.child(node, octant(offset, height - 1)) else {
                break;
            };
            (node, height) = (child, height - 1);
        }
        *self.tree.data(node)
    }

    /// Tells those slabs of a cell in which there is nothing else of its brick, which has the mask
    /// without the cell.
    #[inline]
    fn note_slabs(&mut self, others: u64, cell: IVec3, note: impl Fn(&mut Slabs, i32)) {
        let mut is_changed = false;
        for (axis, slabs) in self.slabs.iter_mut().enumerate() {
            if others & brick::slab(axis, cell[axis]) == 0 {
                note(slabs, cell[axis]);
                is_changed = true;
            }
        }
        if is_changed {
            let ends = [0, 1, 2].map(|axis| self.slabs[axis].ends());
            self.extents = match ends {
                [Some(x), Some(y), Some(z)] => {
                    Some([0, 1].map(|end| IVec3::new(x[end], y[end], z[end])))
                }
                _ => None,
            };
        }
    }

    /// A leaf became full or empty: so may be what it is in.
    fn join_above(&mut self, mut node: NodeId, mask: u64) {
        while let Some(parent) = self.tree.parent(node) {
            let is_alike = |of: NodeId| self.tree.is_leaf(of) && *self.tree.data(of) == mask;
            if !self.tree.children(parent).all(is_alike) {
                return;
            }
            self.tree.join(parent, |_| {});
            self.tree.swap_data(parent, mask);
            node = parent;
        }
    }

    /// Checks that the tree is as small as it can be, and that all counts are right.
    ///
    /// # Panics
    /// If it is not so.
    #[cfg(test)]
    fn assert_well_formed(&self) {
        for node in self.tree.subtree(NodeId::ROOT) {
            if self.tree.is_split(node) {
                assert_eq!(*self.tree.data(node), 0);
                let mask = *self.tree.data(self.child(node, Vertex::ALL[0]));
                let mut children = self.tree.children(node);
                let is_alike = |of: NodeId| self.tree.is_leaf(of) && *self.tree.data(of) == mask;
                assert!(!children.all(is_alike) || ![0, FULL].contains(&mask));
            } else if self.tree.generation(node) < self.height {
                assert!([0, FULL].contains(self.tree.data(node)));
            }
        }
        assert_eq!(self.iter().count() as u64, self.len);
        let all = |pick: fn(IVec3, IVec3) -> IVec3| self.iter().reduce(pick);
        let ends = all(IVec3::min).zip(all(IVec3::max));
        assert_eq!(self.extents(), ends.map(|(low, high)| [low, high]));
    }
}

impl Extend<IVec3> for Voxels {
    fn extend<I: IntoIterator<Item = IVec3>>(&mut self, cells: I) {
        for cell in cells {
            self.set(cell);
        }
    }
}

/// The same cells, of the same size.
impl PartialEq for Voxels {
    fn eq(&self, other: &Self) -> bool {
        self.cell_size == other.cell_size
            && self.len == other.len
            && self
                .bricks()
                .all(|(brick, mask)| other.mask_of(brick) == mask)
    }
}

/// The brick in which a cell is.
#[inline]
fn brick_of(cell: IVec3) -> IVec3 {
    cell >> 2
}

/// In which child of a node a brick is, if children are as high as told.
#[inline]
fn octant(offset: I64Vec3, height: u32) -> Vertex {
    let bit = |coordinate: i64, place: u32| ((coordinate >> height) as u32 & 1) << place;
    Vertex::from_bits(bit(offset.x, 0) | bit(offset.y, 1) | bit(offset.z, 2))
}

#[cfg(test)]
mod tests;
