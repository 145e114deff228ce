//! Vertices at one position, made one.

use bevy::math::{DVec3, Vec3};

use super::polygon_mesh::PolygonMesh;
use crate::narrow_phase::error::ShapeError;

/// How close two vertices have to be to be one, as a share of the mesh's extent: a few times what
/// sines and cosines of a full turn leave open.
const REACH: f64 = 2e-6;
/// The same, as a share of the largest coordinate: what 32-bit floats leave of two sums that are
/// the same.
const ROUNDING: f64 = 1.5 * f32::EPSILON as f64;
/// The width of a cell of the grid in which vertices are sought, in reaches: of eight vertices, one
/// or two have others in reach beyond a side of their cell.
const CELL: f64 = 8.0;

impl PolygonMesh {
    /// Makes a mesh of triangles with vertices of their own, by their positions: those at one
    /// position, or closer than can be told apart, are one. Triangles which then have no area are
    /// left out.
    ///
    /// Indices have to be in range.
    pub(super) fn from_triangles(
        positions: &[[f32; 3]],
        triangles: impl IntoIterator<Item = [usize; 3]>,
    ) -> Result<Self, ShapeError> {
        if let Some(vertex) = positions.iter().position(|at| !Vec3::from(*at).is_finite()) {
            let position = positions[vertex].into();
            return Err(ShapeError::NonFiniteVertex { vertex, position });
        }
        let Welded {
            vertices,
            indices,
            reach,
        } = Welded::of(positions)?;
        let triangles = triangles
            .into_iter()
            .map(|triangle| triangle.map(|vertex| indices[vertex]));
        let refuse = |error| match error {
            ShapeError::RepeatedVertex { .. } | ShapeError::ZeroArea { .. } => None,
            other => Some(other),
        };
        Self::build(vertices, triangles, refuse, reach)
    }
}

/// Distinct positions.
struct Welded {
    vertices: Vec<Vec3>,
    /// For each position given, the index of the one it is at: that of the first close enough.
    indices: Vec<u32>,
    /// How close that is, along each axis.
    reach: f64,
}

impl Welded {
    /// Linear: a hash table of the cells of a grid, in which lists of vertices begin.
    ///
    /// The positions have to be finite.
    fn of(positions: &[[f32; 3]]) -> Result<Self, ShapeError> {
        if u32::try_from(positions.len()).is_err() {
            return Err(ShapeError::TooLarge);
        }
        let at = |position: &[f32; 3]| Vec3::from(*position).as_dvec3();
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = positions
            .iter()
            .map(at)
            .fold(nothing, |(min, max), at| (min.min(at), max.max(at)));
        let largest = min.abs().max(max.abs()).max_element();
        let reach = REACH * (max - min).max_element() + ROUNDING * largest;
        // All positions may be the origin.
        let reach = reach.max(f64::from(f32::MIN_POSITIVE));
        // There are so few cells that those of a coordinate fit into 21 bits. All in 64 bits: the
        // cell of a position lies between those of the corners of its reach.
        let cells = |at: DVec3| ((at - min) / (CELL * reach)).floor().as_i64vec3();

        let mut grid = Grid::with_capacity(positions.len());
        let mut vertices: Vec<Vec3> = Vec::new();
        let mut indices = Vec::with_capacity(positions.len());
        for position in positions {
            let here = at(position);
            let (low, high) = (cells(here - reach), cells(here + reach));
            let mut known: Option<u32> = None;
            for x in low.x..=high.x {
                for y in low.y..=high.y {
                    for z in low.z..=high.z {
                        for vertex in grid.list(key([x, y, z])) {
                            let there = vertices[vertex as usize].as_dvec3();
                            let is_close = (there - here).abs().max_element() <= reach;
                            if is_close && known.is_none_or(|known| vertex < known) {
                                known = Some(vertex);
                            }
                        }
                    }
                }
            }
            indices.push(known.unwrap_or_else(|| {
                let cell = cells(here);
                vertices.push(Vec3::from(*position));
                grid.add(key(cell.to_array()))
            }));
        }
        vertices.shrink_to_fit();
        Ok(Self {
            vertices,
            indices,
            reach,
        })
    }
}

/// The coordinates of a cell as one number.
fn key(cell: [i64; 3]) -> u64 {
    // One below the first may be asked for.
    let [x, y, z] = cell.map(|along| (along + 1) as u64);
    debug_assert!(x.max(y).max(z) < 1 << 21, "there are more cells than that");
    x << 42 | y << 21 | z
}

/// Lists of numbers, which are given in order, by cell.
struct Grid {
    /// Cells and the last numbers in them, with open addressing; there are twice as many at least
    /// as there are cells.
    slots: Vec<(u64, u32)>,
    /// How many bits of a hash are not used.
    shift: u32,
    /// The number before in the cell of each.
    before: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Grid {
    fn with_capacity(count: usize) -> Self {
        let slots = (2 * count).next_power_of_two().max(2);
        Self {
            slots: vec![(0, NONE); slots],
            shift: 64 - slots.trailing_zeros(),
            before: Vec::new(),
        }
    }

    /// The slot of a cell, or the one that is free for it.
    fn slot(&self, cell: u64) -> usize {
        // Fibonacci hashing (Knuth, The Art of Computer Programming 3, 6.4), of what has its upper
        // bits mixed into the lower ones.
        let mixed = (cell ^ cell >> 32).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mut slot = (mixed >> self.shift) as usize;
        while self.slots[slot].1 != NONE && self.slots[slot].0 != cell {
            slot = (slot + 1) % self.slots.len();
        }
        slot
    }

    /// The numbers in a cell.
    fn list(&self, cell: u64) -> impl Iterator<Item = u32> {
        let known = |number: u32| (number != NONE).then_some(number);
        let last = self.slots[self.slot(cell)].1;
        std::iter::successors(known(last), move |number| {
            known(self.before[*number as usize])
        })
    }

    /// Puts the next number into a cell.
    fn add(&mut self, cell: u64) -> u32 {
        let (number, slot) = (self.before.len() as u32, self.slot(cell));
        self.before.push(self.slots[slot].1);
        self.slots[slot] = (cell, number);
        number
    }
}

#[cfg(test)]
mod tests;
