//! The exact tests as a value: how near counts as contact, and which way cuboids are decided.

use bevy::prelude::{Reflect, ReflectDefault, ReflectResource, Resource};

use super::error::ToleranceError;

/// The way in which pairs of cuboids are decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Exactness {
    /// Each pair by the cheapest test that is exact for it.
    #[default]
    Cheapest,
    /// Pairs of cuboids go through [`Stage::Complete`](super::Stage::Complete) as polygon meshes,
    /// and [`Stage::Boxes`](super::Stage::Boxes) is skipped, as in the report's system: for study,
    /// and to check one test against the other.
    EdgePolygon,
}

/// The exact tests: whether two placed shapes are in contact, and where.
///
/// Two shapes are in contact when their distance is no more than the [tolerance](Self::tolerance),
/// so that touching counts, whatever touches: faces in one plane, edges along edges, corners. For
/// pairs so large that rounding exceeds the tolerance it is raised: to 16 times `f32::EPSILON`
/// times the sum of their greatest half extents, or 2·10⁻⁴ where these add up to 100.
///
/// In an app, this is a resource: the tests that all contacts and queries go by. Changes take
/// effect at the next tick, for all pairs.
#[doc(alias("gjk", "separating axis", "sat", "intersection test", "exact test"))]
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(opaque)]
#[reflect(Resource, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
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

    /// Makes tests with a tolerance of one's own, in world units.
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

    /// Returns the same tests, with another way to decide cuboids.
    #[must_use]
    pub fn with_exactness(self, exactness: Exactness) -> Self {
        Self { exactness, ..self }
    }

    /// Returns the distance up to which two shapes are in contact, in world units.
    #[inline]
    #[must_use]
    pub fn tolerance(&self) -> f32 {
        self.tolerance
    }

    /// Returns which way cuboids are decided.
    #[inline]
    #[must_use]
    pub fn exactness(&self) -> Exactness {
        self.exactness
    }

    /// The same tests, with a tolerance that comes from theirs.
    pub(super) fn with_tolerance(self, tolerance: f32) -> Self {
        Self { tolerance, ..self }
    }
}
