//! The 26 directions of a cubical lattice, by kind, and their names.
//!
//! A cube touches its equals across six faces, along twelve edges and at eight vertices. Each of
//! these is a direction, named by the letters of the faces that meet there: `RU` is the edge
//! between the right and the upper face.
//!
//! | letter | face  | axis in Bevy's right-handed, −Z-forward space |
//! |--------|-------|-----------------------------------------------|
//! | `L`    | left  | −x |
//! | `R`    | right | +x |
//! | `D`    | down  | −y |
//! | `U`    | up    | +y |
//! | `F`    | front | −z |
//! | `B`    | back  | +z |
//!
//! The names are those of Swan, *Fast Collision Detection with an N-Objects Octree*, 1994, section
//! 2.1, after Samet, *Applications of Spatial Data Structures*, 1990. Their undefined direction Ω
//! is [`None`] here.

use std::fmt;
use std::str::FromStr;

use bevy::math::IVec3;
use thiserror::Error;

/// The text is not the name of a direction of the kind that was asked for.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "unknown {expected} `{text}`; a name is one of L, R, then D, U, then B, F, such as R, RU or RUF"
)]
pub struct ParseDirectionError {
    /// The text that was refused.
    pub text: String,
    /// The kind of direction that was expected: "face", "edge", "vertex" or "direction".
    pub expected: &'static str,
}

/// The sign along x, y and z of the direction with this name.
const fn signs_of(name: &str) -> [i8; 3] {
    let name = name.as_bytes();
    let mut signs = [0; 3];
    let mut i = 0;
    while i < name.len() {
        match name[i] {
            b'L' => signs[0] = -1,
            b'R' => signs[0] = 1,
            b'D' => signs[1] = -1,
            b'U' => signs[1] = 1,
            b'F' => signs[2] = -1,
            b'B' => signs[2] = 1,
            _ => panic!("a direction's name consists of the letters L, R, D, U, B, F"),
        }
        i += 1;
    }
    signs
}

/// Whether two directions point opposite ways.
const fn are_opposite(a: [i8; 3], b: [i8; 3]) -> bool {
    a[0] == -b[0] && a[1] == -b[1] && a[2] == -b[2]
}

/// Defines one kind of direction. The variants' names are the only source: signs and opposites
/// follow from them.
macro_rules! direction_kind {
    (
        $(#[$kind_doc:meta])*
        $Kind:ident($kind:literal, $count:literal) { $($(#[$doc:meta])* $Name:ident,)* }
    ) => {
        $(#[$kind_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum $Kind {
            $($(#[$doc])* $Name,)*
        }

        impl $Kind {
            #[doc = concat!("Every ", $kind, ", in the order of [`index`](Self::index).")]
            pub const ALL: [Self; $count] = [$(Self::$Name),*];

            const NAMES: [&str; $count] = [$(stringify!($Name)),*];

            const SIGNS: [[i8; 3]; $count] = [$(signs_of(stringify!($Name))),*];

            const OPPOSITES: [Self; $count] = {
                let mut opposites = Self::ALL;
                let mut i = 0;
                while i < $count {
                    let mut j = 0;
                    while !are_opposite(Self::SIGNS[i], Self::SIGNS[j]) {
                        j += 1;
                    }
                    opposites[i] = Self::ALL[j];
                    i += 1;
                }
                opposites
            };

            #[doc = concat!("Returns the index of this ", $kind, " in [`ALL`](Self::ALL).")]
            #[inline]
            #[must_use]
            pub const fn index(self) -> usize {
                self as usize
            }

            /// Returns the upper-case name.
            #[inline]
            #[must_use]
            pub const fn name(self) -> &'static str {
                Self::NAMES[self as usize]
            }

            /// Returns the signs along x, y and z: −1, 0 or 1 each.
            #[inline]
            #[must_use]
            pub const fn signs(self) -> [i8; 3] {
                Self::SIGNS[self as usize]
            }

            /// Returns the step to the neighbouring cell of a unit lattice: [`signs`](Self::signs)
            /// as a vector.
            #[inline]
            #[must_use]
            pub const fn offset(self) -> IVec3 {
                let [x, y, z] = self.signs();
                IVec3::new(x as i32, y as i32, z as i32)
            }

            #[doc = concat!("Returns the ", $kind, " on the far side of the cube.")]
            #[inline]
            #[must_use]
            pub const fn opposite(self) -> Self {
                Self::OPPOSITES[self as usize]
            }
        }

        impl fmt::Display for $Kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }

        /// Reads a name in upper, lower or mixed case.
        impl FromStr for $Kind {
            type Err = ParseDirectionError;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                Self::ALL
                    .into_iter()
                    .find(|direction| direction.name().eq_ignore_ascii_case(text))
                    .ok_or_else(|| ParseDirectionError { text: text.to_owned(), expected: $kind })
            }
        }

        impl From<$Kind> for Direction {
            #[inline]
            fn from(direction: $Kind) -> Self {
                Self::$Kind(direction)
            }
        }
    };
}

direction_kind! {
    /// A direction through one of a cube's six faces.
    ///
    /// The value is the axis times two, plus one on the positive side.
    Face("face", 6) {
        /// Left, −x.
        L,
        /// Right, +x.
        R,
        /// Down, −y.
        D,
        /// Up, +y.
        U,
        /// Front, −z.
        F,
        /// Back, +z.
        B,
    }
}

direction_kind! {
    /// A direction across one of a cube's twelve edges.
    Edge("edge", 12) {
        /// Left and down.
        LD,
        /// Left and up.
        LU,
        /// Left and back.
        LB,
        /// Left and front.
        LF,
        /// Right and down.
        RD,
        /// Right and up.
        RU,
        /// Right and back.
        RB,
        /// Right and front.
        RF,
        /// Down and back.
        DB,
        /// Down and front.
        DF,
        /// Up and back.
        UB,
        /// Up and front.
        UF,
    }
}

direction_kind! {
    /// A direction across one of a cube's eight vertices; equally one of the eight octants that a
    /// cube is split into.
    ///
    /// Bit 0 of the value is set on the right (+x), bit 1 on the upper side (+y), bit 2 at the back
    /// (+z): bit *i* says on which side of axis *i* the octant lies, so that the value is the
    /// octant's place in a Z-order curve.
    Vertex("vertex", 8) {
        /// Left, down, front.
        LDF,
        /// Right, down, front.
        RDF,
        /// Left, up, front.
        LUF,
        /// Right, up, front.
        RUF,
        /// Left, down, back.
        LDB,
        /// Right, down, back.
        RDB,
        /// Left, up, back.
        LUB,
        /// Right, up, back.
        RUB,
    }
}

impl Vertex {
    /// Returns the octant on the positive side of each axis whose bit (0 for x, 1 for y, 2 for z)
    /// is set in `bits`. Higher bits are ignored.
    #[inline]
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self::ALL[(bits & 7) as usize]
    }

    /// Returns the octant on the positive side of the axes that are true.
    #[inline]
    #[must_use]
    pub const fn from_sides(x: bool, y: bool, z: bool) -> Self {
        Self::from_bits(x as u32 | (y as u32) << 1 | (z as u32) << 2)
    }

    /// Bit 0 is set on the right, bit 1 on the upper side, bit 2 at the back.
    #[inline]
    #[must_use]
    pub const fn bits(self) -> u32 {
        self as u32
    }
}

/// One of the 26 directions from a cube to its equals in a cubical lattice.
///
/// ```
/// use bevy::math::IVec3;
/// use bevy_octree::octree::{Direction, Edge};
///
/// let direction: Direction = "ru".parse()?;
/// assert_eq!(direction, Direction::Edge(Edge::RU));
/// assert_eq!(direction.offset(), IVec3::new(1, 1, 0));
/// assert_eq!(direction.opposite().to_string(), "LD");
/// # Ok::<(), bevy_octree::octree::ParseDirectionError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// Through a face: one sign is not zero.
    Face(Face),
    /// Across an edge: two signs are not zero.
    Edge(Edge),
    /// Across a vertex: no sign is zero.
    Vertex(Vertex),
}

impl Direction {
    /// Every direction: the faces, then the edges, then the vertices.
    pub const ALL: [Self; 26] = {
        let mut all = [Self::Face(Face::L); 26];
        let mut i = 0;
        while i < 26 {
            all[i] = match i {
                0..6 => Self::Face(Face::ALL[i]),
                6..18 => Self::Edge(Edge::ALL[i - 6]),
                _ => Self::Vertex(Vertex::ALL[i - 18]),
            };
            i += 1;
        }
        all
    };

    /// The direction of each triple of signs, x fastest; no direction in the middle.
    const BY_SIGNS: [Option<Self>; 27] = {
        let mut table = [None; 27];
        let mut i = 0;
        while i < 26 {
            let [x, y, z] = Self::ALL[i].signs();
            table[Self::index_by_signs(x, y, z)] = Some(Self::ALL[i]);
            i += 1;
        }
        table
    };

    /// Returns the index of this direction in [`ALL`](Self::ALL).
    #[inline]
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Self::Face(face) => face.index(),
            Self::Edge(edge) => 6 + edge.index(),
            Self::Vertex(vertex) => 18 + vertex.index(),
        }
    }

    /// Returns the upper-case name.
    #[inline]
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Face(face) => face.name(),
            Self::Edge(edge) => edge.name(),
            Self::Vertex(vertex) => vertex.name(),
        }
    }

    /// Returns the signs along x, y and z: −1, 0 or 1 each.
    #[inline]
    #[must_use]
    pub const fn signs(self) -> [i8; 3] {
        match self {
            Self::Face(face) => face.signs(),
            Self::Edge(edge) => edge.signs(),
            Self::Vertex(vertex) => vertex.signs(),
        }
    }

    /// Returns the step to the neighbouring cell of a unit lattice: [`signs`](Self::signs) as a
    /// vector.
    #[inline]
    #[must_use]
    pub const fn offset(self) -> IVec3 {
        match self {
            Self::Face(face) => face.offset(),
            Self::Edge(edge) => edge.offset(),
            Self::Vertex(vertex) => vertex.offset(),
        }
    }

    /// Returns the direction whose [`offset`](Self::offset) this is: [`None`] for zero, and if a
    /// component is not −1, 0 or 1.
    #[inline]
    #[must_use]
    pub fn from_offset(offset: IVec3) -> Option<Self> {
        let is_step = offset.min_element() >= -1 && offset.max_element() <= 1;
        if is_step {
            Self::from_signs(offset.to_array().map(|component| component as i8))
        } else {
            None
        }
    }

    /// The direction whose [`signs`](Self::signs) these are, each −1, 0 or 1; [`None`] if all are
    /// 0.
    #[inline]
    pub(super) const fn from_signs([x, y, z]: [i8; 3]) -> Option<Self> {
        Self::BY_SIGNS[Self::index_by_signs(x, y, z)]
    }

    /// The index of these signs in [`BY_SIGNS`](Self::BY_SIGNS).
    #[inline]
    const fn index_by_signs(x: i8, y: i8, z: i8) -> usize {
        ((x + 1) + (y + 1) * 3 + (z + 1) * 9) as usize
    }

    /// Returns the direction that points the other way.
    #[inline]
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Face(face) => Self::Face(face.opposite()),
            Self::Edge(edge) => Self::Edge(edge.opposite()),
            Self::Vertex(vertex) => Self::Vertex(vertex.opposite()),
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Reads a name in upper, lower or mixed case.
impl FromStr for Direction {
    type Err = ParseDirectionError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|direction| direction.name().eq_ignore_ascii_case(text))
            .ok_or_else(|| ParseDirectionError {
                text: text.to_owned(),
                expected: "direction",
            })
    }
}

#[cfg(test)]
mod tests;
