//! Who meets whom: the one table of which test is for which two shapes.

use super::placed::PlacedPair;
use crate::narrow_phase::shape::{Kind, Shape};

/// Which way a pair is computed, whatever is asked about it.
///
/// | first \\ second | sphere | cuboid | convex | mesh | curved, parts | Rapier's |
/// |---|---|---|---|---|---|---|
/// | sphere | `Spheres` | `SphereFirst` | `SphereFirst` | `SphereFirst` | `Parts` | `Foreign` |
/// | cuboid | `SphereSecond` | `Cuboids` | `Convex` | `Polygons` | `Parts` | `Foreign` |
/// | convex | `SphereSecond` | `Convex` | `Convex` | `Polygons` | `Parts` | `Foreign` |
/// | mesh | `SphereSecond` | `Polygons` | `Polygons` | `Polygons` | `Parts` | `Foreign` |
/// | curved, parts | `Parts` | `Parts` | `Parts` | `Parts` | `Parts` | `Foreign` |
/// | Rapier's | `Foreign` | `Foreign` | `Foreign` | `Foreign` | `Foreign` | `Foreign` |
///
/// Each exact test has one `match` of it, without a `_`: a new kind of shape gets a row and a
/// column here, and if these need a new case, the compiler asks every test for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    Spheres,
    /// A sphere and a shape made of polygons.
    SphereFirst,
    /// A shape made of polygons and a sphere.
    SphereSecond,
    Cuboids,
    /// Two convex shapes made of polygons, but for two cuboids.
    Convex,
    /// Two shapes made of polygons, of which one may be of any form.
    Polygons,
    /// Two of which one is known by its support function, or taken apart into such: one question
    /// to each two parts.
    Parts,
    /// Two of which one is of Rapier's: computed as what it is of ours, and else as `Parts`.
    Foreign,
}

impl Case {
    #[inline]
    pub fn of(a: &Shape, b: &Shape) -> Self {
        use Kind::{Convex, Cuboid, Curved, Foreign, Mesh, Parts, Sphere};
        match (a.kind(), b.kind()) {
            (Foreign, _) | (_, Foreign) => Self::Foreign,
            (Curved | Parts, _) | (_, Curved | Parts) => Self::Parts,
            (Sphere, Sphere) => Self::Spheres,
            (Sphere, Cuboid | Convex | Mesh) => Self::SphereFirst,
            (Cuboid | Convex | Mesh, Sphere) => Self::SphereSecond,
            (Cuboid, Cuboid) => Self::Cuboids,
            (Cuboid, Convex) | (Convex, Cuboid | Convex) => Self::Convex,
            (Mesh, Cuboid | Convex | Mesh) | (Cuboid | Convex, Mesh) => Self::Polygons,
        }
    }
}

impl PlacedPair<'_> {
    /// Which way the two are computed.
    #[inline]
    pub fn case(&self) -> Case {
        Case::of(self.a.shape, self.b.shape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::narrow_phase::tests::{box_of, mesh_of};
    use bevy::math::Vec3;

    #[test]
    fn swapping_two_swaps_the_case() {
        let convex = match mesh_of(Vec3::ONE) {
            Shape::Mesh(mesh) => crate::narrow_phase::ConvexMesh::new((*mesh).clone())
                .unwrap()
                .into(),
            _ => unreachable!(),
        };
        let shapes = [
            box_of(1.0, 1.0, 1.0),
            Shape::Sphere { radius: 1.0 },
            convex,
            mesh_of(Vec3::ONE),
        ];
        for a in &shapes {
            for b in &shapes {
                let swapped = match Case::of(b, a) {
                    Case::SphereFirst => Case::SphereSecond,
                    Case::SphereSecond => Case::SphereFirst,
                    case => case,
                };
                assert_eq!(Case::of(a, b), swapped, "{a:?} {b:?}");
            }
        }
    }
}
