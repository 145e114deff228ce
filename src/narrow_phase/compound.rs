//! Compounds: shapes of shapes.

use bevy::math::{Isometry3d, Quat, Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::composite::parts::{Part, Parts};
use super::error::{BoundsError, ShapeError};
use super::shape::{Compound, Shape};

/// How much larger than computed the box of a part is, as a share of the distances at hand: more
/// than the rounding of what is turned.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

impl Compound {
    /// Puts shapes together, each in a pose.
    ///
    /// Parts are numbered in the order given. A part that is a compound itself is taken apart, and
    /// each of its parts has a number of its own. O(n log n).
    ///
    /// ```
    /// use bevy::math::{Isometry3d, Vec3};
    /// use bevy_octree::narrow_phase::{Compound, Shape};
    ///
    /// let leg = |x: f32, z: f32| (Isometry3d::from_xyz(x, -0.5, z), Shape::cuboid(0.1, 0.9, 0.1));
    /// let top = (Isometry3d::IDENTITY, Shape::cuboid(2.0, 0.1, 1.0));
    /// let table = Compound::new([top, leg(-0.9, -0.4), leg(0.9, -0.4), leg(-0.9, 0.4), leg(0.9, 0.4)])?;
    /// assert_eq!(table.len(), 5);
    /// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
    /// ```
    ///
    /// # Errors
    /// [`ShapeError::NoParts`], and [`ShapeError::Part`] for a part without an end, and for bad
    /// numbers in a part or in its pose. It is named by its number in the input, also if it is a
    /// compound.
    pub fn new(parts: impl IntoIterator<Item = (Isometry3d, Shape)>) -> Result<Self, ShapeError> {
        let given = parts.into_iter();
        let mut parts = Vec::new();
        for (source, (pose, shape)) in given.enumerate() {
            let refused = |error: BoundsError| ShapeError::Part {
                part: source,
                error,
            };
            let mut add = |pose: Isometry3d, shape: Shape| {
                let number = u32::try_from(parts.len()).map_err(|_| ShapeError::TooLarge)?;
                parts.push(measured(number, pose, shape).map_err(refused)?);
                Ok(())
            };
            let shape = owned(shape);
            match nested(&shape) {
                Some(compound) => {
                    for part in compound.0.iter() {
                        add(pose * part.pose, part.shape.clone())?;
                    }
                }
                None => add(pose, shape)?,
            }
        }
        if parts.is_empty() {
            return Err(ShapeError::NoParts);
        }
        Ok(Self(Parts::new(parts)))
    }

    /// Returns the parts in the order of their numbers: what [`new`](Self::new) would make the same
    /// compound of.
    #[must_use]
    pub fn parts(&self) -> impl ExactSizeIterator<Item = (Isometry3d, &Shape)> {
        self.0.iter().map(|part| (part.pose, &part.shape))
    }

    /// Returns the pose and the shape of a part by its number.
    #[must_use]
    pub fn part(&self, number: u32) -> Option<(Isometry3d, &Shape)> {
        self.0.get(number).map(|part| (part.pose, &part.shape))
    }

    /// Returns how many parts there are; at least one.
    #[must_use]
    #[expect(
        clippy::len_without_is_empty,
        reason = "an empty one cannot be made, and asking would be a mistake"
    )]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns how much memory the compound takes, without meshes, which may be shared.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }

    /// Do all parts follow a scale along the axes of the whole? Those that are turned do not: the
    /// scale would shear them.
    pub(super) fn follows_scale(&self) -> bool {
        let mut parts = self.parts();
        parts.all(|(pose, shape)| pose.rotation == Quat::IDENTITY && shape.follows_scale())
    }

    /// Centre, half extents and bounding radius.
    pub(super) fn local_bounds(&self) -> (Vec3A, Vec3A, f32) {
        self.0.local_bounds()
    }
}

/// The same parts in the same poses, in the same order. Meshes are the same if they are shared.
impl PartialEq for Compound {
    fn eq(&self, other: &Self) -> bool {
        let is_same = |((pose, shape), (other_pose, other)): ((_, &Shape), (_, &Shape))| {
            pose == other_pose && shape.is_same(other)
        };
        self.len() == other.len() && self.parts().zip(other.parts()).all(is_same)
    }
}

/// A shape that is a compound.
fn nested(shape: &Shape) -> Option<&Compound> {
    match shape {
        Shape::Compound(compound) => Some(compound),
        _ => None,
    }
}

/// A shape of Rapier's as what it is of ours, if it is one: then, it follows the scale of the whole.
fn owned(shape: Shape) -> Shape {
    match &shape {
        #[cfg(feature = "rapier")]
        Shape::Rapier(inner) => inner.own().cloned().unwrap_or(shape),
        _ => shape,
    }
}

/// A part with its box.
fn measured(number: u32, pose: Isometry3d, shape: Shape) -> Result<Part<Shape>, BoundsError> {
    let (middle, _, radius) = shape.local_bounds()?;
    let pose = Isometry3d {
        rotation: unit(pose.rotation)?,
        ..pose
    };
    let transform = Transform {
        translation: pose.translation.into(),
        rotation: pose.rotation,
        scale: Vec3::ONE,
    };
    let aabb = shape.world_aabb(&transform)?;
    let center = aabb.min * 0.5 + aabb.max * 0.5;
    let half = (aabb.max - center).max(center - aabb.min);
    let far = pose.translation.abs() + middle.abs() + half;
    let slack = ROUNDING * far.max_element();
    let half = half + slack;
    let radius = radius + center.distance(pose * middle) + slack;
    let is_rigid = shape.is_rigid();
    let stray = if pose.rotation == Quat::IDENTITY && shape.follows_scale() {
        0.0
    } else {
        radius + center.distance(pose.translation)
    };
    let is_finite = (center + half).is_finite() && (center - half).is_finite();
    if !(is_finite && radius.is_finite()) {
        return Err(BoundsError::NonFinite);
    }
    Ok(Part {
        number,
        pose,
        shape,
        center,
        half,
        radius,
        stray,
        is_rigid,
    })
}

/// A rotation of length one. What is of that length already is left as it is, so that a compound
/// can be made anew of its parts.
fn unit(rotation: Quat) -> Result<Quat, BoundsError> {
    let length = rotation.length();
    if (length - 1.0).abs() <= f32::EPSILON {
        return Ok(rotation);
    }
    let unit = rotation.normalize();
    // Not for what is not a number, or of no length, either.
    if unit.is_normalized() {
        Ok(unit)
    } else {
        Err(BoundsError::NonFinite)
    }
}

#[cfg(test)]
mod tests;
