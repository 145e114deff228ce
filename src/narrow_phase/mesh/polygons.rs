//! Lists of corners: what the polygons of a mesh are.

use std::ops::Range;

use crate::narrow_phase::error::ShapeError;

/// The corners of all polygons, one polygon after the other.
///
/// A *side* is an index of a corner: the side from there to the next corner of the polygon.
#[derive(Clone, Debug, Default)]
pub struct Polygons {
    corners: Vec<u32>,
    count: usize,
    /// How many corners each polygon has; 0 if they differ.
    stride: usize,
    /// Where each polygon ends in `corners`, if they differ.
    ends: Vec<u32>,
}

impl Polygons {
    /// An empty list with room for so many triangles.
    pub fn with_capacity(count: usize) -> Self {
        Self {
            corners: Vec::with_capacity(3 * count),
            ..Self::default()
        }
    }

    /// Appends a polygon.
    ///
    /// # Errors
    /// [`ShapeError::TooLarge`] if 32 bits cannot name its corners.
    pub fn push(&mut self, corners: &[u32]) -> Result<(), ShapeError> {
        if self.count == 0 {
            self.stride = corners.len();
        } else if self.stride != 0 && self.stride != corners.len() {
            let ends = (1..=self.count).map(|polygon| (polygon * self.stride) as u32);
            self.ends = ends.collect();
            self.stride = 0;
        }
        self.corners.extend_from_slice(corners);
        let end = u32::try_from(self.corners.len()).map_err(|_| ShapeError::TooLarge)?;
        if self.stride == 0 {
            self.ends.push(end);
        }
        self.count += 1;
        Ok(())
    }

    /// Gives back the room that is not needed.
    pub fn shrink_to_fit(&mut self) {
        self.corners.shrink_to_fit();
        self.ends.shrink_to_fit();
    }

    #[inline]
    pub const fn len(&self) -> usize {
        self.count
    }

    /// The corners of all polygons.
    #[inline]
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The sides of a polygon.
    #[inline]
    pub fn sides(&self, polygon: usize) -> Range<usize> {
        debug_assert!(polygon < self.count, "polygon {polygon} of {}", self.count);
        if self.stride != 0 {
            let start = polygon * self.stride;
            return start..start + self.stride;
        }
        let start = polygon.checked_sub(1).map_or(0, |last| self.ends[last]);
        start as usize..self.ends[polygon] as usize
    }

    #[inline]
    pub fn get(&self, polygon: usize) -> &[u32] {
        &self.corners[self.sides(polygon)]
    }

    /// The corners by polygon, if all are triangles.
    #[inline]
    pub fn triangles(&self) -> Option<&[[u32; 3]]> {
        (self.stride == 3).then(|| self.corners.as_chunks().0)
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.count).map(|polygon| self.get(polygon))
    }

    /// Calls `found` with each side: its polygon, its number, and where it begins and ends.
    #[inline]
    pub fn for_each_side(&self, mut found: impl FnMut(u32, u32, u32, u32)) {
        let mut side = 0;
        for (polygon, corners) in self.iter().enumerate() {
            let ends = corners[1..].iter().chain(&corners[..1]);
            for (from, to) in corners.iter().zip(ends) {
                found(polygon as u32, side, *from, *to);
                side += 1;
            }
        }
    }

    /// The polygon that a side belongs to, in logarithmic time if they differ in size.
    #[inline]
    pub fn owner(&self, side: u32) -> u32 {
        match self.stride {
            3 => side / 3,
            0 => self.ends.partition_point(|end| *end <= side) as u32,
            stride => side / stride as u32,
        }
    }

    /// Where a side ends.
    pub fn end_of(&self, side: u32) -> u32 {
        let sides = self.sides(self.owner(side) as usize);
        let next = side as usize + 1;
        self.corners[if next == sides.end { sides.start } else { next }]
    }

    /// Turns a polygon around. Its last side stays the last, and the others are reversed.
    pub fn flip(&mut self, polygon: usize) {
        let sides = self.sides(polygon);
        self.corners[sides].reverse();
    }

    pub const fn memory_bytes(&self) -> usize {
        (self.corners.capacity() + self.ends.capacity()) * size_of::<u32>()
    }
}
