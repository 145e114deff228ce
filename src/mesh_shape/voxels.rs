//! The voxels that a mesh fills.

use bevy::math::{DVec3, IVec3, Vec3};

use crate::narrow_phase::{Shape, ShapeError, Voxels};

/// How many voxels the box around a mesh may have.
const MOST: usize = 1 << 24;
/// As near to a border between voxels as this share of their side, a corner is on it.
const ON_BORDER: f64 = 1e-4;

/// The voxels of a side of `size` that triangles pass through, and those that are enclosed by these.
/// Voxel (0, 0, 0) is from the origin to `size` along each axis.
///
/// # Errors
/// [`ShapeError::VoxelSize`]; [`ShapeError::TooManyVoxels`]; [`ShapeError::Empty`] if no triangle
/// has an area.
pub(super) fn voxels(triangles: &[[Vec3; 3]], size: f32) -> Result<Shape, ShapeError> {
    Ok(Voxels::from_cells(size, filled(triangles, size)?)?.into())
}

/// The cells that are filled, in the order of z, y, x.
fn filled(triangles: &[[Vec3; 3]], size: f32) -> Result<Vec<IVec3>, ShapeError> {
    if !(size.is_finite() && size > 0.0) {
        return Err(ShapeError::VoxelSize(size));
    }
    let too_many = ShapeError::TooManyVoxels { size, most: MOST };
    let triangles: Vec<[DVec3; 3]> = triangles
        .iter()
        .filter_map(|corners| in_cells(*corners, size))
        .collect();
    let corners = || triangles.iter().flatten();
    let low = corners().fold(DVec3::INFINITY, |low, corner| low.min(*corner));
    let high = corners().fold(DVec3::NEG_INFINITY, |high, corner| high.max(*corner));
    if triangles.is_empty() {
        return Err(ShapeError::Empty);
    }
    // Cells are counted from the origin, and by 32 bits.
    if low.min_element() < -1e9 || high.max_element() > 1e9 {
        return Err(too_many);
    }
    let mut grid = Grid::around(low, high).ok_or(too_many)?;
    for triangle in &triangles {
        grid.pass(triangle);
    }
    grid.flood();
    Ok(grid.filled())
}

/// A triangle in the coordinates of cells; `None` if it has no area. One that lies on a border
/// between cells is put into the middle of those behind it.
fn in_cells(corners: [Vec3; 3], size: f32) -> Option<[DVec3; 3]> {
    let exact = corners.map(|corner| corner.as_dvec3() / f64::from(size));
    let snapped = exact.map(|corner| {
        let border = corner.round();
        let is_on = (corner - border).abs().cmple(DVec3::splat(ON_BORDER));
        DVec3::select(is_on, border, corner)
    });
    let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).try_normalize();
    // What is that small beside a cell stays where it is.
    let Some(normal) = normal(snapped) else {
        return normal(exact).map(|_| exact);
    };
    let mut corners = snapped;
    for axis in 0..3 {
        let [a, b, c] = snapped.map(|corner| corner[axis]);
        if a == b && a == c && a == a.round() {
            for corner in &mut corners {
                corner[axis] -= 0.5_f64.copysign(normal[axis]);
            }
        }
    }
    Some(corners)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cell {
    /// Nobody has been there.
    Unknown,
    Surface,
    Outside,
}

/// The cells of a box, with one more on each side, which is outside.
struct Grid {
    low: IVec3,
    size: IVec3,
    cells: Vec<Cell>,
}

impl Grid {
    fn around(low: DVec3, high: DVec3) -> Option<Self> {
        let low = low.floor().as_ivec3() - 1;
        let size = high.floor().as_ivec3() + 2 - low;
        let count = (size.to_array().into_iter())
            .try_fold(1_usize, |count, side| {
                count.checked_mul(usize::try_from(side).ok()?)
            })
            .filter(|count| *count <= MOST)?;
        let cells = vec![Cell::Unknown; count];
        Some(Self { low, size, cells })
    }

    /// The slot of a cell; `None` if it is not in the box.
    fn slot(&self, cell: IVec3) -> Option<usize> {
        let from_low = cell - self.low;
        let is_in = from_low.cmpge(IVec3::ZERO).all() && from_low.cmplt(self.size).all();
        let [x, y, z] = from_low.to_array().map(|number| number as usize);
        let [width, height, _] = self.size.to_array().map(|number| number as usize);
        is_in.then(|| (z * height + y) * width + x)
    }

    fn cell(&self, slot: usize) -> IVec3 {
        let [width, height, _] = self.size.to_array().map(|number| number as usize);
        let [x, y, z] = [slot % width, slot / width % height, slot / width / height];
        self.low + IVec3::new(x as i32, y as i32, z as i32)
    }

    /// Marks the cells that a triangle passes through.
    fn pass(&mut self, triangle: &[DVec3; 3]) {
        let [a, b, c] = *triangle;
        let low = a.min(b).min(c).floor().as_ivec3();
        let high = a.max(b).max(c).floor().as_ivec3();
        let mut is_anywhere = false;
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let cell = IVec3::new(x, y, z);
                    if touches(triangle, cell)
                        && let Some(slot) = self.slot(cell)
                    {
                        self.cells[slot] = Cell::Surface;
                        is_anywhere = true;
                    }
                }
            }
        }
        // So small on a border that rounding has it in none: where its corners are.
        if !is_anywhere {
            for corner in triangle {
                if let Some(slot) = self.slot(corner.floor().as_ivec3()) {
                    self.cells[slot] = Cell::Surface;
                }
            }
        }
    }

    /// Goes from cell to cell on the outside, as far as there is a way through faces.
    fn flood(&mut self) {
        let mut next = vec![0];
        self.cells[0] = Cell::Outside;
        while let Some(slot) = next.pop() {
            let cell = self.cell(slot);
            for direction in DIRECTIONS {
                if let Some(slot) = self.slot(cell + direction)
                    && self.cells[slot] == Cell::Unknown
                {
                    self.cells[slot] = Cell::Outside;
                    next.push(slot);
                }
            }
        }
    }

    fn filled(&self) -> Vec<IVec3> {
        let is_filled = |slot: &usize| self.cells[*slot] != Cell::Outside;
        let slots = (0..self.cells.len()).filter(is_filled);
        slots.map(|slot| self.cell(slot)).collect()
    }
}

const DIRECTIONS: [IVec3; 6] = [
    IVec3::NEG_X,
    IVec3::X,
    IVec3::NEG_Y,
    IVec3::Y,
    IVec3::NEG_Z,
    IVec3::Z,
];

/// Do a triangle and a cell of side 1 overlap? To touch is not enough. By the 13 axes that may part them (Akenine-Möller,
/// *Fast 3D Triangle-Box Overlap Testing*, 2001).
fn touches(triangle: &[DVec3; 3], cell: IVec3) -> bool {
    let corners = triangle.map(|corner| corner - (cell.as_dvec3() + 0.5));
    let [a, b, c] = corners;
    let edges = [b - a, c - b, a - c];
    let is_parting = |axis: DVec3| {
        let reach = axis.abs().element_sum() * 0.5;
        let along = corners.map(|corner| corner.dot(axis));
        let [low, high] = [
            along.into_iter().fold(f64::INFINITY, f64::min),
            along.into_iter().fold(f64::NEG_INFINITY, f64::max),
        ];
        // Edges along an axis have no cross product with it.
        reach > 1e-12 && (low >= reach || high <= -reach)
    };
    let crosses = DVec3::AXES
        .into_iter()
        .flat_map(|axis| edges.map(|edge| axis.cross(edge)));
    !(DVec3::AXES.into_iter())
        .chain([edges[0].cross(edges[1])])
        .chain(crosses)
        .any(is_parting)
}

#[cfg(test)]
mod tests;
