//! From a vector to the directions near it.
//!
//! An object that moves along a vector can enter the cells ahead of it: across the vertex of the
//! octant that the vector points into, and across the faces and edges that meet there. These seven
//! directions are what Swan, *Fast Collision Detection with an N-Objects Octree*, 1994, Figure 3,
//! quantises a vector to.

use bevy::math::Vec3;

use super::direction::{Direction, Vertex};

/// The seven directions of each octant.
const DIRECTIONS: [[Direction; 7]; 8] = {
    let mut table = [[Direction::ALL[0]; 7]; 8];
    let mut i = 0;
    while i < 8 {
        let [x, y, z] = Vertex::ALL[i].signs();
        let signs = [
            [x, y, z],
            [x, 0, 0],
            [0, y, 0],
            [0, 0, z],
            [x, y, 0],
            [x, 0, z],
            [0, y, z],
        ];
        let mut j = 0;
        while j < 7 {
            table[i][j] = Direction::from_signs(signs[j]).expect("not all signs are 0");
            j += 1;
        }
        i += 1;
    }
    table
};

impl Vertex {
    /// Returns the octant that a vector from the centre points into: `R` if x > 0, else `L`; `U` if
    /// y > 0, else `D`; `F` if z < 0, else `B`.
    ///
    /// A component that is zero, of either sign, or NaN thus counts as `L`, `D` or `B`.
    #[inline]
    #[must_use]
    pub fn toward(v: Vec3) -> Self {
        let is_front = v.z < 0.0;
        Self::from_sides(v.x > 0.0, v.y > 0.0, !is_front)
    }

    /// Returns the directions of the faces, edges and vertex that meet at this vertex: the vertex,
    /// the faces along x, y, z, then the edges along xy, xz, yz.
    ///
    /// ```
    /// use bevy_octree::octree::{Direction, Vertex};
    ///
    /// let names = Vertex::RUF.directions().map(Direction::name);
    /// assert_eq!(names, ["RUF", "R", "U", "F", "RU", "RF", "UF"]);
    /// ```
    #[inline]
    #[must_use]
    pub const fn directions(self) -> &'static [Direction; 7] {
        &DIRECTIONS[self.index()]
    }
}

/// Returns the seven directions that lie near a vector: [`Vertex::directions`] of
/// [`Vertex::toward`] it.
///
/// ```
/// use bevy::math::Vec3;
/// use bevy_octree::octree::{Direction, directions_toward};
///
/// // Bevy looks along −z, so that −z is the front; a component of zero is left, down or back.
/// let names = directions_toward(Vec3::new(0.0, 2.0, -1.0)).map(Direction::name);
/// assert_eq!(names, ["LUF", "L", "U", "F", "LU", "LF", "UF"]);
/// ```
#[inline]
#[must_use]
pub fn directions_toward(v: Vec3) -> &'static [Direction; 7] {
    Vertex::toward(v).directions()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names in the figure, row by row.
    #[test]
    fn the_table_is_that_of_the_report() {
        let figure = [
            (Vec3::new(1.0, 1.0, -1.0), "RUF R U F RU RF UF"),
            (Vec3::new(1.0, 1.0, 1.0), "RUB R U B RU RB UB"),
            (Vec3::new(1.0, -1.0, -1.0), "RDF R D F RD RF DF"),
            (Vec3::new(1.0, -1.0, 1.0), "RDB R D B RD RB DB"),
            (Vec3::new(-1.0, 1.0, -1.0), "LUF L U F LU LF UF"),
            (Vec3::new(-1.0, 1.0, 1.0), "LUB L U B LU LB UB"),
            (Vec3::new(-1.0, -1.0, -1.0), "LDF L D F LD LF DF"),
            (Vec3::new(-1.0, -1.0, 1.0), "LDB L D B LD LB DB"),
        ];
        for (v, names) in figure {
            assert_eq!(directions_toward(v).map(Direction::name).join(" "), names);
        }
    }

    #[test]
    fn directions_are_those_with_no_sign_against_the_octant() {
        for octant in Vertex::ALL {
            let near = Direction::ALL.into_iter().filter(|direction| {
                let product = direction.offset() * octant.offset();
                product.min_element() >= 0
            });
            let mut directions = *octant.directions();
            directions.sort();
            assert_eq!(Vec::from_iter(near), directions);
        }
    }

    #[test]
    fn zero_and_nan_are_left_down_and_back() {
        for component in [0.0, -0.0, f32::NAN, -f32::NAN] {
            assert_eq!(Vertex::toward(Vec3::splat(component)), Vertex::LDB);
        }
        assert_eq!(Vertex::toward(Vec3::new(0.0, 1.0, -1.0)), Vertex::LUF);
        assert_eq!(Vertex::toward(Vec3::new(1.0, 0.0, -1.0)), Vertex::RDF);
        assert_eq!(Vertex::toward(Vec3::new(1.0, 1.0, 0.0)), Vertex::RUB);
    }

    #[test]
    fn the_smallest_and_largest_components_count() {
        let tiny = f32::from_bits(1);
        assert_eq!(Vertex::toward(Vec3::new(tiny, tiny, -tiny)), Vertex::RUF);
        assert_eq!(Vertex::toward(Vec3::new(-tiny, -tiny, tiny)), Vertex::LDB);
        assert_eq!(Vertex::toward(Vec3::INFINITY), Vertex::RUB);
        assert_eq!(Vertex::toward(Vec3::NEG_INFINITY), Vertex::LDF);
    }
}
