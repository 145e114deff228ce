//! What a node of the N-objects octree stores.

use bevy::math::{Vec3A, bounding::Aabb3d};

use crate::octree::Vertex;

/// The cell of a node: its part of space and, in a leaf, the objects whose boxes overlap it.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// Lower corner, part of the cell; −∞ where the cell is one of the outermost.
    lo: Vec3A,
    /// Upper corner, not part of the cell; +∞ where the cell is one of the outermost.
    hi: Vec3A,
    /// Where the cell divides. Planes are computed once, when the cell is made, and inherited from
    /// then on, so that neighbours agree on their common border to the bit.
    mid: Vec3A,
    /// From `mid` to the borders of the cell as it would be without infinity.
    half_size: f32,
    generation: u32,
    objects: Vec<u32>,
    /// How many of the objects that overlap the cell count against N; kept for all nodes, so that it
    /// is known without a look at the leaves whether these have to merge.
    counted: u32,
    /// The last turn in which this cell was known to list the object, and in which it was searched
    /// for pairs.
    pub(super) held: u64,
    pub(super) searched: u64,
    /// Does the node wait for a split or a merge?
    pub(super) queued: bool,
}

impl Cell {
    /// The cell of the root, which is all of space.
    pub(super) fn root(center: Vec3A, half_size: f32) -> Self {
        Self {
            lo: Vec3A::NEG_INFINITY,
            hi: Vec3A::INFINITY,
            mid: center,
            half_size,
            ..Self::default()
        }
    }

    /// Makes this the cell of a child, with an empty list.
    pub(super) fn set_child_of(&mut self, parent: &CellFrame, octant: Vertex, objects: Vec<u32>) {
        debug_assert!(objects.is_empty());
        let bits = octant.bits();
        let upper = bevy::math::BVec3A::new(bits & 1 != 0, bits & 2 != 0, bits & 4 != 0);
        let half_size = parent.half_size * 0.5;
        *self = Self {
            lo: Vec3A::select(upper, parent.mid, parent.lo),
            hi: Vec3A::select(upper, parent.hi, parent.mid),
            mid: parent.mid
                + Vec3A::select(upper, Vec3A::splat(half_size), Vec3A::splat(-half_size)),
            half_size,
            generation: parent.generation + 1,
            objects,
            ..Self::default()
        };
    }

    /// What children are made from.
    pub(super) const fn frame(&self) -> CellFrame {
        CellFrame {
            lo: self.lo,
            hi: self.hi,
            mid: self.mid,
            half_size: self.half_size,
            generation: self.generation,
        }
    }

    /// Returns the cell as a box. The corners of outermost cells are infinite; the upper borders
    /// are not part of the cell.
    #[inline]
    #[must_use]
    pub const fn bounds(&self) -> Aabb3d {
        Aabb3d {
            min: self.lo,
            max: self.hi,
        }
    }

    /// Returns the cell's cube, without the reach to infinity of the outermost cells.
    #[must_use]
    pub fn cube(&self) -> Aabb3d {
        Aabb3d {
            min: self.mid - self.half_size,
            max: self.mid + self.half_size,
        }
    }

    /// Returns the generation of the node: 0 for the root.
    #[inline]
    #[must_use]
    pub const fn generation(&self) -> u32 {
        self.generation
    }

    /// Returns the indices of the objects listed here, in no particular order. Empty for a node
    /// that is split.
    #[inline]
    #[must_use]
    pub fn listed(&self) -> &[u32] {
        &self.objects
    }

    /// Returns how many of the objects that overlap the cell count against N: those that are not
    /// larger than the cell.
    #[inline]
    #[must_use]
    pub const fn counted(&self) -> u32 {
        self.counted
    }

    /// Returns `true` if a box overlaps the cell. Touching the lower borders counts, touching the
    /// upper ones does not.
    #[inline]
    #[must_use]
    pub fn overlaps(&self, aabb: &Aabb3d) -> bool {
        aabb.min.cmplt(self.hi).all() && aabb.max.cmpge(self.lo).all()
    }

    /// Returns `true` if all of a box is in the cell.
    #[inline]
    pub(super) fn holds(&self, aabb: &Aabb3d) -> bool {
        (aabb.min.cmpge(self.lo) & aabb.max.cmplt(self.hi)).all()
    }

    /// Returns `true` if a point is in the cell.
    #[inline]
    #[must_use]
    pub fn contains(&self, point: Vec3A) -> bool {
        point.cmpge(self.lo).all() && point.cmplt(self.hi).all()
    }

    /// The child next to a point, which may be outside of the cell.
    #[inline]
    pub(super) fn octant_towards(&self, point: Vec3A) -> Vertex {
        Vertex::from_bits(point.cmpge(self.mid).bitmask())
    }

    /// The children that a box overlaps, given that it overlaps the cell: one bit for each octant.
    #[inline]
    pub(super) fn octants(&self, aabb: &Aabb3d) -> u32 {
        const X: [u32; 4] = [0, 0x55, 0xAA, 0xFF];
        const Y: [u32; 4] = [0, 0x33, 0xCC, 0xFF];
        const Z: [u32; 4] = [0, 0x0F, 0xF0, 0xFF];
        let low = aabb.min.cmplt(self.mid).bitmask() as usize;
        let high = aabb.max.cmpge(self.mid).bitmask() as usize;
        let side = |axis: usize| (low >> axis & 1) | (high >> axis & 1) << 1;
        X[side(0)] & Y[side(1)] & Z[side(2)]
    }

    #[inline]
    pub(super) fn list(&mut self, object: u32, counts: bool) {
        self.objects.push(object);
        self.counted += u32::from(counts);
    }

    /// Takes an object off the list; false if it was not on it.
    #[inline]
    pub(super) fn unlist(&mut self, object: u32, counts: bool) -> bool {
        let Some(index) = position(&self.objects, object) else {
            return false;
        };
        self.objects.swap_remove(index);
        self.counted -= u32::from(counts);
        true
    }

    /// One object more overlaps the cell of a split node that counts against N there.
    #[inline]
    pub(super) const fn count_in(&mut self) {
        self.counted += 1;
    }

    /// One object fewer does.
    #[inline]
    pub(super) const fn count_out(&mut self) {
        debug_assert!(self.counted > 0);
        self.counted -= 1;
    }

    /// Gives the list away; what is counted stays.
    pub(super) fn take_list(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.objects)
    }

    /// Puts a whole list in, of objects that are counted already.
    pub(super) fn put_list(&mut self, objects: Vec<u32>) {
        self.objects = objects;
    }

    /// Memory that hangs off this node, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        self.objects.capacity() * size_of::<u32>()
    }
}

/// Where a number is in a list. Eight at a time, for the lists are long.
#[inline]
fn position(list: &[u32], number: u32) -> Option<usize> {
    let is_in = |eight: &[u32; 8]| {
        eight
            .iter()
            .fold(false, |found, listed| found | (*listed == number))
    };
    let (eights, rest) = list.as_chunks();
    let (start, part) = match eights.iter().position(is_in) {
        Some(index) => (index * 8, &eights[index][..]),
        None => (list.len() - rest.len(), rest),
    };
    let index = part.iter().position(|listed| *listed == number)?;
    Some(start + index)
}

/// The geometry of a cell that its children inherit.
pub(super) struct CellFrame {
    lo: Vec3A,
    hi: Vec3A,
    mid: Vec3A,
    half_size: f32,
    generation: u32,
}
