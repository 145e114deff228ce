//! Ground as a grid of heights, with a tree of the lowest and highest of its tiles.

use bevy::math::{Vec2, Vec3A};

use super::box_tree::{Below, BoxTree, Child};
use crate::narrow_phase::{error::ShapeError, length::length};

/// A grid of heights over the x–z plane, joined by triangles: ground, as a terrain has it.
///
/// * Rows follow each other along z and the heights of a row along x, both ascending; y is up. The
///   grid is centred at the origin: of 3 rows, the second is at z = 0.
/// * Between four heights is a *cell* of two triangles. Its diagonal always runs from the next row
///   in the same column to the same row in the next column, as Rapier's does unless told otherwise.
///   Seen from above, that is from the corner at (−x, +z) to the one at (+x, −z). Triangles are
///   wound counter-clockwise as seen from above.
/// * Triangles are numbered by cells, these row by row: cell (r, c) of a grid with n columns of
///   heights has the numbers 2 (r (n − 1) + c), with the corner at the lower x and z, and the one
///   after it.
/// * It is a surface that is met from both sides, without an inside. A cell may be a
///   [hole](Self::set_hole).
///
/// Heights can be [changed](Self::set_height), each in logarithmic time. It takes 4 bytes per
/// height, and somewhat less than 3 for the tree.
///
/// ```
/// use bevy::math::Vec2;
/// use bevy_octree::narrow_phase::HeightField;
///
/// // A slope of 3 by 3 cells of 2 by 2 each, that rises towards +x.
/// let mut slope = HeightField::from_fn(4, 4, Vec2::splat(2.0), |x, _| 0.5 * x)?;
/// assert_eq!(slope.height_at(2.5, -1.0), Some(1.25));
/// assert_eq!(slope.height_at(3.5, 0.0), None);
///
/// slope.set_hole(2, 2, true)?;
/// assert_eq!(slope.height_at(1.5, 1.5), None);
/// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
/// ```
///
/// Those of an entity are shared with all clones of its shape; how they are changed is on the page
/// about [shapes](crate::guide::shapes#what-is-dug-and-built).
#[doc(alias("terrain", "heightmap", "heightfield"))]
#[derive(Clone, Debug)]
pub struct HeightField {
    rows: usize,
    columns: usize,
    cell_size: Vec2,
    heights: Vec<f32>,
    /// A bit for each cell, row by row; nothing as long as there was no hole.
    holes: Vec<u64>,
    /// Tiles of 2 by 2 cells, of 2 by 2 of these, and so on, up to a single one.
    levels: Vec<Level>,
}

/// Between which heights tiles are, row by row.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    rows: usize,
    columns: usize,
    ranges: Vec<Range>,
}

/// The lowest and the highest in a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    low: f32,
    high: f32,
}

impl Range {
    /// Of a tile without triangles.
    const NOTHING: Self = Self {
        low: f32::INFINITY,
        high: f32::NEG_INFINITY,
    };

    fn or(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn is_nothing(self) -> bool {
        self.low > self.high
    }
}

/// A tile: a cell on level 0, and twice as large on each level above.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    level: u32,
    row: usize,
    column: usize,
}

/// A triangle of a height field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldTriangle {
    /// Its number: see [`HeightField`].
    pub number: u32,
    /// Its corners, counter-clockwise as seen from above.
    pub corners: [Vec3A; 3],
}

/// Do 32 bits not number the triangles?
fn is_too_large(rows: usize, columns: usize) -> bool {
    let cells = (rows - 1).checked_mul(columns - 1);
    let triangles = cells.and_then(|cells| cells.checked_mul(2));
    triangles.is_none_or(|triangles| u32::try_from(triangles).is_err())
}

impl HeightField {
    /// Makes a field of so many rows and columns of heights, row by row, by the size of a cell along
    /// x and z.
    ///
    /// The whole is as large as one cell less than there are heights: 11 columns of cells 2 wide are
    /// 20 wide. Linear in the number of heights.
    ///
    /// # Errors
    /// [`ShapeError::FewHeights`] with less than two rows or columns,
    /// [`ShapeError::HeightCount`] if there are not as many heights as rows times columns,
    /// [`ShapeError::NonFiniteHeight`], [`ShapeError::FieldCellSize`] for a size that is not greater
    /// than zero and finite or makes the field infinite, and [`ShapeError::TooLarge`] if 32 bits
    /// cannot number the triangles.
    pub fn new(
        rows: usize,
        columns: usize,
        heights: Vec<f32>,
        cell_size: Vec2,
    ) -> Result<Self, ShapeError> {
        if rows < 2 || columns < 2 {
            return Err(ShapeError::FewHeights { rows, columns });
        }
        if is_too_large(rows, columns) {
            return Err(ShapeError::TooLarge);
        }
        if Some(heights.len()) != rows.checked_mul(columns) {
            let heights = heights.len();
            return Err(ShapeError::HeightCount {
                rows,
                columns,
                heights,
            });
        }
        let sides = cell_size * Vec2::new((columns - 1) as f32, (rows - 1) as f32);
        if !(cell_size.min_element() > 0.0 && sides.is_finite()) {
            return Err(ShapeError::FieldCellSize(cell_size));
        }
        if let Some(index) = heights.iter().position(|height| !height.is_finite()) {
            return Err(ShapeError::NonFiniteHeight {
                row: index / columns,
                column: index % columns,
                height: heights[index],
            });
        }
        let mut field = Self {
            rows,
            columns,
            cell_size,
            heights,
            holes: Vec::new(),
            levels: Vec::new(),
        };
        field.measure();
        Ok(field)
    }

    /// Makes a field as [`new`](Self::new) does, with the heights that a function tells of x and z.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn from_fn(
        rows: usize,
        columns: usize,
        cell_size: Vec2,
        mut height: impl FnMut(f32, f32) -> f32,
    ) -> Result<Self, ShapeError> {
        if rows < 2 || columns < 2 {
            return Err(ShapeError::FewHeights { rows, columns });
        }
        // Before a height is asked for.
        if is_too_large(rows, columns) {
            return Err(ShapeError::TooLarge);
        }
        let mut heights = Vec::new();
        for row in 0..rows {
            let z = at(row, rows, cell_size.y);
            heights.extend((0..columns).map(|column| height(at(column, columns, cell_size.x), z)));
        }
        Self::new(rows, columns, heights, cell_size)
    }

    /// Returns the field with holes in some of its cells, by their rows and columns.
    ///
    /// # Errors
    /// [`ShapeError::OutsideField`] for a cell that there is not.
    pub fn with_holes(
        mut self,
        cells: impl IntoIterator<Item = (usize, usize)>,
    ) -> Result<Self, ShapeError> {
        for (row, column) in cells {
            self.set_hole(row, column, true)?;
        }
        Ok(self)
    }

    /// Returns how many rows of heights there are: one more than of cells.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Returns how many heights a row has: one more than cells.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the size of a cell along x and z.
    #[must_use]
    pub const fn cell_size(&self) -> Vec2 {
        self.cell_size
    }

    /// Returns all heights, row by row.
    #[must_use]
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// Returns the cells that are holes, by their rows and columns.
    pub fn holes(&self) -> impl Iterator<Item = (usize, usize)> {
        let columns = self.columns - 1;
        let all = 0..(self.rows - 1) * columns;
        let all = if self.holes.is_empty() { 0..0 } else { all };
        all.filter(|cell| self.holes[cell / 64] >> (cell % 64) & 1 != 0)
            .map(move |cell| (cell / columns, cell % columns))
    }

    /// Returns how high the ground is at a point, by its x and z in the coordinates of the field;
    /// `None` beside the field and in holes.
    #[must_use]
    pub fn height_at(&self, x: f32, z: f32) -> Option<f32> {
        let (column, right) = cell_of(x, self.columns, self.cell_size.x)?;
        let (row, back) = cell_of(z, self.rows, self.cell_size.y)?;
        if self.is_hole(row, column) {
            return None;
        }
        let [near, far] = [row, row + 1].map(|row| {
            let first = row * self.columns + column;
            [first, first + 1].map(|index| f64::from(self.heights[index]))
        });
        // On either side of the diagonal, from the corner that is on that side alone.
        let height = if right + back <= 1.0 {
            near[0] * (1.0 - right - back) + near[1] * right + far[0] * back
        } else {
            far[1] * (right + back - 1.0) + far[0] * (1.0 - right) + near[1] * (1.0 - back)
        };
        Some(height as f32)
    }

    /// Changes a height; the time taken is that of looking at the tiles that it is in.
    ///
    /// # Errors
    /// [`ShapeError::OutsideField`] if there is no such height, [`ShapeError::NonFiniteHeight`].
    pub fn set_height(&mut self, row: usize, column: usize, height: f32) -> Result<(), ShapeError> {
        if row >= self.rows || column >= self.columns {
            return Err(ShapeError::OutsideField { row, column });
        }
        if !height.is_finite() {
            return Err(ShapeError::NonFiniteHeight {
                row,
                column,
                height,
            });
        }
        self.heights[row * self.columns + column] = height;
        let cells = |at: usize, count: usize| [at.saturating_sub(1), at.min(count - 2)];
        self.refit(cells(row, self.rows), cells(column, self.columns));
        Ok(())
    }

    /// Makes a cell a hole, or ground again, by the row and column of its lower corner; in the time
    /// that [`set_height`](Self::set_height) takes.
    ///
    /// # Errors
    /// [`ShapeError::OutsideField`] for a cell that there is not.
    pub fn set_hole(&mut self, row: usize, column: usize, is_hole: bool) -> Result<(), ShapeError> {
        let (rows, columns) = (self.rows - 1, self.columns - 1);
        if row >= rows || column >= columns {
            return Err(ShapeError::OutsideField { row, column });
        }
        if self.holes.is_empty() {
            if !is_hole {
                return Ok(());
            }
            self.holes = vec![0; (rows * columns).div_ceil(64)];
        }
        let cell = row * columns + column;
        let (word, bit) = (&mut self.holes[cell / 64], 1 << (cell % 64));
        *word = if is_hole { *word | bit } else { *word & !bit };
        self.refit([row; 2], [column; 2]);
        Ok(())
    }

    /// Returns `true` if a cell is a hole, or if there is no such cell.
    #[must_use]
    pub fn is_hole(&self, row: usize, column: usize) -> bool {
        let columns = self.columns - 1;
        if row >= self.rows - 1 || column >= columns {
            return true;
        }
        let cell = row * columns + column;
        let word = self.holes.get(cell / 64);
        word.is_some_and(|word| word >> (cell % 64) & 1 != 0)
    }

    /// Returns how many triangles there would be without holes.
    #[must_use]
    pub const fn triangle_count(&self) -> usize {
        2 * (self.rows - 1) * (self.columns - 1)
    }

    /// Returns the corners of a triangle by its [number](HeightField); `None` in a hole, or if there
    /// is none of that number.
    #[must_use]
    pub fn triangle(&self, number: u32) -> Option<[Vec3A; 3]> {
        let cell = number as usize / 2;
        let (row, column) = (cell / (self.columns - 1), cell % (self.columns - 1));
        let is_there = !self.is_hole(row, column);
        is_there.then(|| self.triangles_of(row, column)[number as usize % 2])
    }

    /// Returns how much memory the field takes.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        let levels = self.levels.iter();
        let ranges: usize = levels.map(|level| level.ranges.capacity()).sum();
        size_of::<Self>()
            + self.heights.capacity() * size_of::<f32>()
            + self.holes.capacity() * size_of::<u64>()
            + self.levels.capacity() * size_of::<Level>()
            + ranges * size_of::<Range>()
    }

    /// Centre, half extents and bounding radius. Of a field of holes alone, those of its outline.
    pub(in crate::narrow_phase) fn local_bounds(&self) -> (Vec3A, Vec3A, f32) {
        let mut range = self.range(self.whole());
        if range.is_nothing() {
            range = Range {
                low: 0.0,
                high: 0.0,
            };
        }
        let middle = range.low * 0.5 + range.high * 0.5;
        let half = Vec3A::new(
            at(self.columns - 1, self.columns, self.cell_size.x),
            (range.high - middle).max(middle - range.low),
            at(self.rows - 1, self.rows, self.cell_size.y),
        );
        (Vec3A::Y * middle, half, length(half))
    }

    /// Where a height is.
    #[inline]
    fn corner(&self, row: usize, column: usize) -> Vec3A {
        Vec3A::new(
            at(column, self.columns, self.cell_size.x),
            self.heights[row * self.columns + column],
            at(row, self.rows, self.cell_size.y),
        )
    }

    /// The triangles of a cell.
    #[inline]
    fn triangles_of(&self, row: usize, column: usize) -> [[Vec3A; 3]; 2] {
        let near = self.corner(row, column);
        let right = self.corner(row, column + 1);
        let back = self.corner(row + 1, column);
        let far = self.corner(row + 1, column + 1);
        [[near, back, right], [back, far, right]]
    }

    /// The tile that is all of it.
    fn whole(&self) -> Tile {
        Tile {
            level: self.levels.len() as u32,
            row: 0,
            column: 0,
        }
    }

    /// How many tiles a level has.
    fn tiles(&self, level: u32) -> [usize; 2] {
        match (level as usize).checked_sub(1) {
            None => [self.rows - 1, self.columns - 1],
            Some(level) => [self.levels[level].rows, self.levels[level].columns],
        }
    }

    #[inline]
    fn range(&self, tile: Tile) -> Range {
        let Tile { level, row, column } = tile;
        if let Some(above) = (level as usize).checked_sub(1) {
            let level = &self.levels[above];
            return level.ranges[row * level.columns + column];
        }
        if self.is_hole(row, column) {
            return Range::NOTHING;
        }
        let first = row * self.columns + column;
        let corners = [
            first,
            first + 1,
            first + self.columns,
            first + self.columns + 1,
        ];
        corners.iter().fold(Range::NOTHING, |range, index| {
            let height = self.heights[*index];
            range.or(Range {
                low: height,
                high: height,
            })
        })
    }

    /// The tiles that a tile consists of.
    #[inline]
    fn quarters(&self, tile: Tile) -> impl Iterator<Item = Tile> {
        let level = tile.level - 1;
        let [rows, columns] = self.tiles(level);
        let twice = |at: usize, count: usize| 2 * at..(2 * at + 2).min(count);
        twice(tile.row, rows).flat_map(move |row| {
            twice(tile.column, columns).map(move |column| Tile { level, row, column })
        })
    }

    fn joined(&self, tile: Tile) -> Range {
        let quarters = self.quarters(tile).map(|quarter| self.range(quarter));
        quarters.fold(Range::NOTHING, Range::or)
    }

    /// Builds all levels.
    fn measure(&mut self) {
        let [mut rows, mut columns] = self.tiles(0);
        while rows > 1 || columns > 1 {
            (rows, columns) = (rows.div_ceil(2), columns.div_ceil(2));
            self.levels.push(Level {
                rows,
                columns,
                ranges: Vec::new(),
            });
            let level = self.levels.len() as u32;
            let tiles = (0..rows)
                .flat_map(|row| (0..columns).map(move |column| Tile { level, row, column }));
            let ranges = tiles.map(|tile| self.joined(tile)).collect();
            self.levels[level as usize - 1].ranges = ranges;
        }
        self.levels.shrink_to_fit();
    }

    /// Brings the tiles up to date that are around some cells: from the first row to the last, and
    /// so for columns.
    fn refit(&mut self, mut rows: [usize; 2], mut columns: [usize; 2]) {
        for level in 1..=self.levels.len() as u32 {
            (rows, columns) = (rows.map(|row| row / 2), columns.map(|column| column / 2));
            for row in rows[0]..=rows[1] {
                for column in columns[0]..=columns[1] {
                    let range = self.joined(Tile { level, row, column });
                    let level = &mut self.levels[level as usize - 1];
                    level.ranges[row * level.columns + column] = range;
                }
            }
        }
    }

    /// A tile in its box; `None` if it has no triangles.
    #[inline]
    fn child(&self, tile: Tile) -> Option<Child<Tile, FieldTriangle>> {
        let range = self.range(tile);
        let last = |first: usize, count: usize| ((first + 1) << tile.level).min(count - 1);
        let x = |column: usize| at(column, self.columns, self.cell_size.x);
        let z = |row: usize| at(row, self.rows, self.cell_size.y);
        let (row, column) = (tile.row << tile.level, tile.column << tile.level);
        let child = || Child {
            low: Vec3A::new(x(column), range.low, z(row)),
            high: Vec3A::new(
                x(last(tile.column, self.columns)),
                range.high,
                z(last(tile.row, self.rows)),
            ),
            below: Below::Node(tile),
        };
        (!range.is_nothing()).then(child)
    }
}

/// The same heights and holes, in cells of the same size.
impl PartialEq for HeightField {
    fn eq(&self, other: &Self) -> bool {
        let size = |field: &Self| (field.rows, field.columns, field.cell_size);
        size(self) == size(other) && self.heights == other.heights && self.holes().eq(other.holes())
    }
}

impl BoxTree for HeightField {
    type Node = Tile;
    type Leaf = FieldTriangle;

    fn top(&self) -> Option<Child<Tile, FieldTriangle>> {
        self.child(self.whole())
    }

    #[inline]
    fn for_each_child(&self, tile: Tile, mut found: impl FnMut(Child<Tile, FieldTriangle>)) {
        if tile.level > 0 {
            return self
                .quarters(tile)
                .filter_map(|quarter| self.child(quarter))
                .for_each(found);
        }
        let first = 2 * (tile.row * (self.columns - 1) + tile.column) as u32;
        for (number, corners) in (first..).zip(self.triangles_of(tile.row, tile.column)) {
            let [a, b, c] = corners;
            found(Child {
                low: a.min(b).min(c),
                high: a.max(b).max(c),
                below: Below::Leaf(FieldTriangle { number, corners }),
            });
        }
    }
}

/// Where a row or column is, of so many.
#[inline]
fn at(index: usize, count: usize, size: f32) -> f32 {
    (index as f32 - (count - 1) as f32 * 0.5) * size
}

/// The cell in which a coordinate is, and how far in it, as a share.
fn cell_of(coordinate: f32, count: usize, size: f32) -> Option<(usize, f64)> {
    // The border as it is rounded to 32 bits is on the field.
    if coordinate.is_nan() || coordinate.abs() > at(count - 1, count, size) {
        return None;
    }
    let last = (count - 1) as f64;
    let along = (f64::from(coordinate) / f64::from(size) + last * 0.5).clamp(0.0, last);
    let cell = (along as usize).min(count - 2);
    Some((cell, along - cell as f64))
}

#[cfg(test)]
mod tests;
