//! Shapes that are read and written as their data.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};

use super::description::ShapeDescription;
use crate::{components::CollisionShape, narrow_phase::Shape};

/// As its [`ShapeDescription`].
///
/// # Errors
/// A shape of Rapier's that has [no data](super::NoDescriptionError).
impl Serialize for CollisionShape {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let data = ShapeDescription::of(self).map_err(ser::Error::custom)?;
        data.serialize(serializer)
    }
}

/// From a [`ShapeDescription`].
///
/// # Errors
/// Data that makes no shape: here, where nothing can be left on an entity that would tell.
impl<'de> Deserialize<'de> for CollisionShape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let data = ShapeDescription::deserialize(deserializer)?;
        data.build().map(Self).map_err(de::Error::custom)
    }
}

/// Whether the two are of the same kind and size: of the same mesh, or of meshes that have the same
/// vertices and polygons, in the same order. Shapes of Rapier's are equal if they are the very same.
impl PartialEq for CollisionShape {
    fn eq(&self, other: &Self) -> bool {
        if self.is_same(other) {
            return true;
        }
        match (&self.0, &other.0) {
            (Shape::Convex(a), Shape::Convex(b)) => {
                a.vertices() == b.vertices() && a.polygons().eq(b.polygons())
            }
            (Shape::Mesh(a), Shape::Mesh(b)) => {
                a.is_surface_only() == b.is_surface_only()
                    && a.vertices() == b.vertices()
                    && a.polygons().eq(b.polygons())
            }
            (Shape::Rounded(_), Shape::Rounded(_)) => {
                ShapeDescription::of(self) == ShapeDescription::of(other)
            }
            (Shape::Compound(a), Shape::Compound(b)) => {
                a.len() == b.len()
                    && a.parts().zip(b.parts()).all(|((at_a, a), (at_b, b))| {
                        at_a == at_b && Self(a.clone()) == Self(b.clone())
                    })
            }
            (Shape::HeightField(a), Shape::HeightField(b)) => a == b,
            (Shape::Voxels(a), Shape::Voxels(b)) => a == b,
            _ => false,
        }
    }
}
