//! Sets of faces of a cube.

use bevy::math::{BVec3, IVec3};

use crate::octree::Face;

/// A set of the six faces of a cube.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Faces(u8);

impl Faces {
    /// No face.
    pub const NONE: Self = Self(0);
    /// All six.
    pub const ALL: Self = Self(0b11_1111);

    /// Returns `true` if a face is in the set.
    #[inline]
    #[must_use]
    pub const fn contains(self, face: Face) -> bool {
        self.0 >> face.index() & 1 != 0
    }

    /// Puts a face into the set.
    #[inline]
    pub const fn insert(&mut self, face: Face) {
        self.0 |= 1 << face.index();
    }

    /// The set, mirrored along some axes.
    pub(in crate::narrow_phase) fn mirrored(self, axes: BVec3) -> Self {
        if !axes.any() {
            return self;
        }
        let mut mirrored = Self::NONE;
        for face in self.iter() {
            let flips = (face.offset().abs().cmpeq(IVec3::ONE) & axes).any();
            mirrored.insert(if flips { face.opposite() } else { face });
        }
        mirrored
    }

    /// Returns `true` if no face is in the set.
    #[inline]
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the faces in the set, in the order of [`Face::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Face> {
        Face::ALL
            .into_iter()
            .filter(move |face| self.contains(*face))
    }
}

impl FromIterator<Face> for Faces {
    fn from_iter<I: IntoIterator<Item = Face>>(faces: I) -> Self {
        let mut all = Self::NONE;
        for face in faces {
            all.insert(face);
        }
        all
    }
}
