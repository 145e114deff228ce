//! The chain of decisions for a pair of shapes.

use bevy::math::Vec3A;
use bevy::math::bounding::Aabb3d;
use bevy::math::primitives::HalfSpace;
use bevy::prelude::{Reflect, ReflectDefault, ReflectResource, Resource};
use bevy::transform::components::Transform;

use super::large::Smaller;
use super::pair::{Pair, ROUNDING, in_order};
use super::separation::Separation;
use super::{BoundsError, Placed, Shape, Stage, ToleranceError, Workspace, edge_polygon};

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
/// Two shapes are in contact when their distance is no more than the [tolerance](Self::tolerance),
/// so that touching counts, whatever touches: faces in one plane, edges along edges, corners. For
/// pairs so large that rounding exceeds the tolerance it is raised: to 16 times `f32::EPSILON`
/// times the sum of their greatest half extents, or 2·10⁻⁴ where these add up to 100.
///
/// In an app, this is a resource: the tests that all contacts and queries go by. Changes take effect at the next tick, for all
/// pairs.
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
        Self { tolerance: Self::DEFAULT_TOLERANCE, exactness: Exactness::default() }
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
            Ok(Self { tolerance, ..Self::default() })
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

    /// The box to feed to a broad phase: that of [`Shape::world_aabb`], grown by half the tolerance
    /// and by rounding. The boxes of two shapes that are in contact are never apart.
    ///
    /// # Errors
    /// As for [`Shape::world_aabb`].
    #[inline]
    pub fn world_aabb(&self, placed: Placed) -> Result<Aabb3d, BoundsError> {
        let Aabb3d { min, max } = placed.shape.world_aabb(placed.transform)?;
        // However it is turned, a box is wider than its greatest half extent, from which the
        // tolerance of a pair may come.
        let size = (max - min).max_element();
        let far = min.abs().max(max.abs()).max_element();
        let grown = self.tolerance * 0.5 + ROUNDING * size + f32::EPSILON * far;
        let (min, max) = (min - grown, max + grown);
        if min.is_finite() && max.is_finite() { Ok(Aabb3d { min, max }) } else { Err(BoundsError::NonFinite) }
    }

    /// The half-space that holds all that may be in contact with a shape without bounds, if one does: what a broad phase
    /// is to know of it, as of others their [`world_aabb`](Self::world_aabb). Both are grown by half the tolerance.
    #[must_use]
    #[cfg_attr(not(feature = "rapier"), expect(unused_variables, reason = "only Rapier shapes can be unbounded"))]
    pub fn side(&self, placed: Placed) -> Option<HalfSpace> {
        #[cfg(feature = "rapier")]
        if let Shape::Rapier(shape) = placed.shape {
            return super::parry::side(shape, placed.transform, self.tolerance * 0.5);
        }
        None
    }

    /// Whether two shapes are in contact. The order of the two makes no difference.
    ///
    /// Shapes that are not finite are in contact with nothing.
    #[inline]
    #[must_use]
    pub fn intersects(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> bool {
        if let (Shape::Cuboid { half_size: half_a }, Shape::Cuboid { half_size: half_b }) = (a.shape, b.shape)
            && a.transform.rotation == b.transform.rotation
            && self.exactness == Exactness::Cheapest
        {
            let half_a = (Vec3A::from(*half_a) * Vec3A::from(a.transform.scale)).abs();
            let half_b = (Vec3A::from(*half_b) * Vec3A::from(b.transform.scale)).abs();
            let verdict = self.aligned(a.transform, half_a, b.transform, half_b);
            workspace.counters.count(Stage::Boxes, Some(verdict));
            return verdict;
        }
        let (a, b, _) = in_order(a, b);
        match Pair::new(a, b, self.tolerance) {
            Ok(pair) if pair.is_large() => self.decide_large(&pair, workspace),
            Ok(pair) => self.decide(&pair, workspace),
            Err(BoundsError::Unbounded) => unbounded(a, b, self.tolerance, workspace),
            Err(BoundsError::NonFinite) => false,
        }
    }

    /// Two cuboids turned alike: in their common axes, the distance of two upright boxes.
    #[inline]
    fn aligned(&self, a: &Transform, half_a: Vec3A, b: &Transform, half_b: Vec3A) -> bool {
        let turned_back = a.rotation.normalize().inverse();
        let offset = Vec3A::from(turned_back * (b.translation - a.translation));
        let reach = half_a + half_b;
        let gaps = (offset.abs() - reach).max(Vec3A::ZERO);
        let tolerance = self.tolerance.max(ROUNDING * reach.max_element());
        // Measured by the tolerance, so that the squares of huge sizes do not overflow. The last is for what is not finite:
        // `max` drops a NaN, and infinity reaches everything.
        (gaps / tolerance).length_squared() <= 1.0 && (offset.abs() + reach).is_finite()
    }

    #[cold]
    fn decide_large(&self, pair: &Pair, workspace: &mut Workspace) -> bool {
        if let Some(smaller) = Smaller::of(pair, self) {
            let [a, b] = smaller.placed(pair);
            return smaller.tests.intersects(a, b, workspace);
        }
        #[cfg(feature = "rapier")]
        {
            if let Some(own) = super::parry::with_own(pair.a, pair.b, |a, b| self.intersects(a, b, workspace)) {
                return own;
            }
        }
        let verdict = complete(pair, workspace);
        workspace.counters.count(Stage::Complete, Some(verdict));
        verdict
    }

    /// The same tests, with a tolerance that comes from theirs.
    pub(super) fn with_tolerance(self, tolerance: f32) -> Self {
        Self { tolerance, ..self }
    }

    fn decide(&self, pair: &Pair, workspace: &mut Workspace) -> bool {
        let counters = &mut workspace.counters;
        let mut verdict =
            counters.count(Stage::Bounds, bounds(pair)).or_else(|| counters.count(Stage::Spheres, spheres(pair)));
        if self.exactness == Exactness::Cheapest || !are_cuboids(pair) {
            verdict = verdict.or_else(|| counters.count(Stage::Boxes, boxes(pair)));
        }
        verdict.unwrap_or_else(|| {
            let verdict = complete(pair, workspace);
            workspace.counters.count(Stage::Complete, Some(verdict));
            verdict
        })
    }
}

/// How wide a gap has to be for an early stage to reject: wider than the tolerance by more than
/// rounding, so that no stage rejects what a later one would accept.
#[inline]
fn slack(pair: &Pair) -> f32 {
    2.0 * pair.tolerance
}

#[inline]
fn are_cuboids(pair: &Pair) -> bool {
    matches!((pair.a.shape, pair.b.shape), (Shape::Cuboid { .. }, Shape::Cuboid { .. }))
}

#[inline]
fn bounds(pair: &Pair) -> Option<bool> {
    let offset = pair.box_b.center - pair.box_a.center;
    let gaps = offset.abs() - (pair.box_a.reach() + pair.box_b.reach());
    (gaps.max_element() > slack(pair)).then_some(false)
}

#[inline]
fn spheres(pair: &Pair) -> Option<bool> {
    let distance = pair.box_a.center.distance(pair.box_b.center);
    let gap = distance - (pair.box_a.radius + pair.box_b.radius);
    match (pair.a.shape, pair.b.shape) {
        (Shape::Sphere { .. }, Shape::Sphere { .. }) => Some(gap <= pair.tolerance),
        _ => (gap > slack(pair)).then_some(false),
    }
}

#[inline]
fn boxes(pair: &Pair) -> Option<bool> {
    match (pair.a.shape, pair.b.shape) {
        (Shape::Sphere { .. }, _) => sphere_box(pair),
        (_, Shape::Sphere { .. }) => sphere_box(&pair.swapped()),
        _ => match Separation::of(&pair.box_a, &pair.box_b, slack(pair)) {
            None => Some(false),
            // Boxes that overlap along every axis overlap; those within the tolerance may still be
            // further apart from corner to corner.
            Some(found) => (are_cuboids(pair) && found.gap <= -found.doubt).then_some(true),
        },
    }
}

/// A sphere against the box of another shape.
#[inline]
fn sphere_box(pair: &Pair) -> Option<bool> {
    let center = pair.box_a.center;
    let gap = pair.box_b.closest_point(center).distance(center) - pair.box_a.radius;
    match pair.b.shape {
        Shape::Cuboid { .. } => Some(gap <= pair.tolerance),
        _ => (gap > slack(pair)).then_some(false),
    }
}

fn complete(pair: &Pair, workspace: &mut Workspace) -> bool {
    match (pair.a.shape, pair.b.shape) {
        #[cfg(feature = "rapier")]
        (Shape::Rapier(_), _) | (_, Shape::Rapier(_)) => {
            let cuboids = super::parry::cuboids(pair, |pair| boxes(pair).unwrap_or_else(|| complete(pair, workspace)));
            cuboids.unwrap_or_else(|| {
                workspace.known(super::parry::intersects(pair.a, pair.b, pair.tolerance))
                    || super::parry::enclosed(pair, workspace).is_some()
            })
        }
        (Shape::Sphere { .. }, _) => edge_polygon::sphere_intersects(pair, workspace),
        (_, Shape::Sphere { .. }) => edge_polygon::sphere_intersects(&pair.swapped(), workspace),
        _ => edge_polygon::intersects(pair, workspace),
    }
}

/// What each stage by itself says about a pair.
#[cfg(test)]
pub(super) fn stages(pair: &Pair, workspace: &mut Workspace) -> ([Option<bool>; 3], bool) {
    let early = [bounds(pair), spheres(pair), boxes(pair)];
    (early, complete(pair, workspace))
}

/// A pair of which one has no bounds goes straight to the last stage.
#[cfg_attr(not(feature = "rapier"), expect(unused_variables, reason = "only Rapier shapes can be unbounded"))]
fn unbounded(a: Placed, b: Placed, tolerance: f32, workspace: &mut Workspace) -> bool {
    #[cfg(feature = "rapier")]
    if a.transform.is_finite() && b.transform.is_finite() {
        let verdict = workspace.known(super::parry::intersects(a, b, tolerance));
        workspace.counters.count(Stage::Complete, Some(verdict));
        return verdict;
    }
    false
}
