//! The chain of decisions for a pair of shapes.

use std::cmp::Ordering;

use bevy::math::Vec3A;
use bevy::math::bounding::Aabb3d;
use bevy::transform::components::Transform;

use super::oriented_box::OrientedBox;
use super::separation::Separation;
use super::{BoundsError, Shape, Stage, ToleranceError, Workspace};

/// Rounding, as a share of the size of a pair: no tolerance can be less.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// A shape and where it is.
///
/// Rotations are normalised before use. In a hierarchy of entities the transform is that in the
/// world: `GlobalTransform::compute_transform()`, which drops shear.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// What the object is made of.
    pub shape: &'a Shape,
    /// Scale, rotation and place in the world.
    pub transform: &'a Transform,
}

impl<'a> Placed<'a> {
    /// Puts a shape at a place.
    #[inline]
    #[must_use]
    pub fn new(shape: &'a Shape, transform: &'a Transform) -> Self {
        Self { shape, transform }
    }
}

/// Which way cuboids are decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Exactness {
    /// Each pair by the cheapest test that is exact for it.
    #[default]
    Cheapest,
    /// Pairs of cuboids go through [`Stage::Complete`] as polygon meshes, and [`Stage::Boxes`] is
    /// skipped, as in the report's system: for study, and to check one test against the other.
    EdgePolygon,
}

/// The exact tests: whether two placed shapes are in contact, and where.
///
/// Two shapes are in contact when their distance is no more than the [tolerance](Self::tolerance).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NarrowPhase {
    tolerance: f32,
    exactness: Exactness,
}

impl Default for NarrowPhase {
    fn default() -> Self {
        Self {
            tolerance: Self::DEFAULT_TOLERANCE,
            exactness: Exactness::default(),
        }
    }
}

impl NarrowPhase {
    /// The distance, in world units, up to which shapes are in contact unless told otherwise.
    pub const DEFAULT_TOLERANCE: f32 = 1e-4;

    /// Tests with a tolerance of one's own, in world units.
    ///
    /// # Errors
    /// [`ToleranceError`] unless it is finite and greater than zero.
    pub fn new(tolerance: f32) -> Result<Self, ToleranceError> {
        if tolerance.is_finite() && tolerance > 0.0 {
            Ok(Self {
                tolerance,
                ..Self::default()
            })
        } else {
            Err(ToleranceError(tolerance))
        }
    }

    /// The same tests, with another way to decide cuboids.
    #[must_use]
    pub fn with_exactness(self, exactness: Exactness) -> Self {
        Self { exactness, ..self }
    }

    /// The distance up to which two shapes are in contact, in world units.
    #[must_use]
    pub fn tolerance(&self) -> f32 {
        self.tolerance
    }

    /// Which way cuboids are decided.
    #[must_use]
    pub fn exactness(&self) -> Exactness {
        self.exactness
    }

    /// The box to feed to a broad phase: that of [`Shape::world_aabb`], grown by half the tolerance and by
    /// rounding. The boxes of two shapes that are in contact are never apart.
    ///
    /// # Errors
    /// As for [`Shape::world_aabb`].
    pub fn world_aabb(&self, placed: Placed) -> Result<Aabb3d, BoundsError> {
        let Aabb3d { min, max } = placed.shape.world_aabb(placed.transform)?;
        let size = ROUNDING * (max - min).max_element();
        let grown = self.tolerance * 0.5 + size + f32::EPSILON * min.abs().max(max.abs());
        let (min, max) = (min - grown, max + grown);
        if min.is_finite() && max.is_finite() {
            Ok(Aabb3d { min, max })
        } else {
            Err(BoundsError::NonFinite)
        }
    }

    /// Whether two shapes are in contact. The order of the two makes no difference.
    ///
    /// Shapes that are not finite are in contact with nothing.
    #[inline]
    #[must_use]
    pub fn intersects(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> bool {
        if let (Shape::Cuboid { half_size: half_a }, Shape::Cuboid { half_size: half_b }) =
            (a.shape, b.shape)
            && a.transform.rotation == b.transform.rotation
            && self.exactness == Exactness::Cheapest
        {
            let half_a = (Vec3A::from(*half_a) * Vec3A::from(a.transform.scale)).abs();
            let half_b = (Vec3A::from(*half_b) * Vec3A::from(b.transform.scale)).abs();
            let verdict = self.aligned_cuboids(a.transform, half_a, b.transform, half_b);
            workspace.counters.count(Stage::Boxes, Some(verdict));
            return verdict;
        }
        let (a, b) = if in_order(a, b) { (a, b) } else { (b, a) };
        self.decide(a, b, workspace)
    }

    /// Two cuboids turned alike: their distance is that of two boxes along the axes.
    #[inline]
    fn aligned_cuboids(&self, a: &Transform, half_a: Vec3A, b: &Transform, half_b: Vec3A) -> bool {
        let offset = a.rotation.normalize().inverse() * (b.translation - a.translation);
        let reach = half_a + half_b;
        let gaps = Vec3A::from(offset).abs() - reach;
        let tolerance = self.tolerance.max(ROUNDING * reach.max_element());
        // False if anything is NaN.
        gaps.max(Vec3A::ZERO).length_squared() <= tolerance * tolerance && gaps.is_finite()
    }

    /// The tolerance for a pair: at least what rounding leaves uncertain at its size.
    pub(super) fn pair_tolerance(&self, a: &OrientedBox, b: &OrientedBox) -> f32 {
        let size = a.half.max_element() + b.half.max_element();
        self.tolerance.max(ROUNDING * size)
    }

    fn decide(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> bool {
        let origin = a.transform.translation;
        let box_a = OrientedBox::of(a.shape, a.transform, origin);
        let box_b = OrientedBox::of(b.shape, b.transform, origin);
        let (box_a, box_b) = match (box_a, box_b) {
            (Ok(box_a), Ok(box_b)) => (box_a, box_b),
            (Err(BoundsError::NonFinite), _) | (_, Err(BoundsError::NonFinite)) => return false,
            _ => return self.complete_unbounded(a, b, workspace),
        };
        let tolerance = self.pair_tolerance(&box_a, &box_b);
        // Wider than the tolerance of the last stage, so that rounding rejects nothing too early.
        let slack = 2.0 * tolerance;

        let offset = box_b.center - box_a.center;
        let gaps = offset.abs() - (box_a.reach() + box_b.reach());
        let apart = gaps.max_element() > slack;
        workspace
            .counters
            .count(Stage::Bounds, apart.then_some(false));
        if apart {
            return false;
        }

        let gap = offset.length() - (box_a.radius + box_b.radius);
        let verdict = match (a.shape, b.shape) {
            _ if gap > slack => Some(false),
            (Shape::Sphere { .. }, Shape::Sphere { .. }) => Some(gap <= tolerance),
            _ => None,
        };
        workspace.counters.count(Stage::Spheres, verdict);
        if let Some(verdict) = verdict {
            return verdict;
        }

        let cuboids = matches!(
            (a.shape, b.shape),
            (Shape::Cuboid { .. }, Shape::Cuboid { .. })
        );
        if !(cuboids && self.exactness == Exactness::EdgePolygon) {
            let verdict = match (a.shape, b.shape) {
                (Shape::Sphere { .. }, other) => sphere_box(&box_a, other, &box_b, tolerance),
                (other, Shape::Sphere { .. }) => sphere_box(&box_b, other, &box_a, tolerance),
                _ => match Separation::of(&box_a, &box_b, slack) {
                    None => Some(false),
                    Some(found) if cuboids && found.gap <= -found.doubt => Some(true),
                    Some(_) => None,
                },
            };
            workspace.counters.count(Stage::Boxes, verdict);
            if let Some(verdict) = verdict {
                return verdict;
            }
        }

        let verdict = self.complete(a, b, workspace);
        workspace.counters.count(Stage::Complete, Some(verdict));
        verdict
    }

    fn complete_unbounded(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> bool {
        let verdict = self.complete(a, b, workspace);
        workspace.counters.count(Stage::Complete, Some(verdict));
        verdict
    }

    fn complete(&self, _a: Placed, _b: Placed, _workspace: &mut Workspace) -> bool {
        true
    }
}

/// A sphere against the box of another shape: a verdict if that is all the other shape is, or if they
/// are apart.
#[inline]
fn sphere_box(
    sphere: &OrientedBox,
    other: &Shape,
    bounds: &OrientedBox,
    tolerance: f32,
) -> Option<bool> {
    let gap = bounds.closest_point(sphere.center).distance(sphere.center) - sphere.radius;
    if matches!(other, Shape::Cuboid { .. }) {
        Some(gap <= tolerance)
    } else {
        (gap > 2.0 * tolerance).then_some(false)
    }
}

/// Whether the two are in the order in which a pair is computed, so that swapping them changes nothing.
pub(super) fn in_order(a: Placed, b: Placed) -> bool {
    fn key(placed: Placed) -> ([f32; 3], [f32; 4], [f32; 3], [f32; 4]) {
        let t = placed.transform;
        let shape = match placed.shape {
            Shape::Cuboid { half_size } => [0.0, half_size.x, half_size.y, half_size.z],
            Shape::Sphere { radius } => [1.0, *radius, 0.0, 0.0],
            Shape::Convex(_) => [2.0; 4],
            Shape::Mesh(_) => [3.0; 4],
            #[cfg(feature = "rapier")]
            Shape::Rapier(_) => [4.0; 4],
        };
        (
            t.translation.into(),
            t.rotation.into(),
            t.scale.into(),
            shape,
        )
    }
    let ordering = a
        .transform
        .translation
        .x
        .partial_cmp(&b.transform.translation.x);
    match ordering {
        Some(Ordering::Less) => true,
        Some(Ordering::Greater) => false,
        _ => key(a) <= key(b),
    }
}
