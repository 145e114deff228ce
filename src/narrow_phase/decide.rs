//! The chain of decisions for a pair of shapes.

use bevy::math::{Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::cores::{Balls, Bodies, QuickPair};
use super::error::BoundsError;
use super::frame::case::Case;
use super::frame::edge_polygon;
use super::frame::placed::{Placed, PlacedPair, ROUNDING, in_order};
use super::frame::separation::Separation;
use super::frame::smaller::Smaller;
use super::frame::workspace::Workspace;
use super::settings::{Exactness, NarrowPhase};
use super::shape::{Kind, Shape};
use super::stage::Stage;
use super::support;

impl NarrowPhase {
    /// Returns `true` if two shapes are in contact. The order of the two makes no difference.
    ///
    /// Shapes that are not finite are in contact with nothing.
    ///
    /// Cuboids, spheres: O(1); meshes: O(log n) for each polygon that is near the other shape, and
    /// two meshes: for each two that are near each other, until two touch.
    #[doc(alias = "overlap")]
    #[doc(alias = "collide")]
    #[doc(alias = "intersection")]
    #[inline]
    #[must_use]
    pub fn intersects(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> bool {
        let verdict = match (a.shape, b.shape) {
            (Shape::Cuboid { half_size: half_a }, Shape::Cuboid { half_size: half_b }) => {
                self.alike((a, *half_a), (b, *half_b), workspace)
            }
            _ => self.without_frame(a, b, workspace),
        };
        if let Some(verdict) = verdict {
            return verdict;
        }
        let (a, b, _) = in_order(a, b);
        match PlacedPair::new(a, b, self.tolerance()) {
            Ok(pair) if pair.is_large() => self.decide_large(&pair, workspace),
            Ok(pair) => self.decide(&pair, workspace),
            Err(BoundsError::Unbounded) => unbounded(a, b, self.tolerance(), workspace),
            Err(BoundsError::NonFinite) => false,
        }
    }

    /// Two cuboids, if they are turned alike and the cheapest test is asked for.
    #[inline]
    fn alike(
        &self,
        (a, half_a): (Placed, Vec3),
        (b, half_b): (Placed, Vec3),
        workspace: &mut Workspace,
    ) -> Option<bool> {
        if a.transform.rotation != b.transform.rotation || self.exactness() != Exactness::Cheapest {
            return None;
        }
        let half_a = (Vec3A::from(half_a) * Vec3A::from(a.transform.scale)).abs();
        let half_b = (Vec3A::from(half_b) * Vec3A::from(b.transform.scale)).abs();
        let verdict = self.aligned(a.transform, half_a, b.transform, half_b);
        workspace.counters.count(Stage::Boxes, Some(verdict))
    }

    /// Two that need no frame of their own: of a closed form, or Rapier's that are ours.
    #[inline]
    fn without_frame(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> Option<bool> {
        if let Some(balls) = Balls::of(a, b) {
            return Some(balls.intersects(self.tolerance(), &mut workspace.counters));
        }
        let (first, second, _) = in_order(a, b);
        if let Some(pair) = self.quick(first, second) {
            let verdict = pair.intersects(self.tolerance());
            pair.count(self.tolerance(), verdict, &mut workspace.counters);
            return Some(verdict);
        }
        support::with_own(a, b, |a, b| self.intersects(a, b, workspace))
    }

    /// Two of which all is told in closed form.
    #[inline]
    pub(super) fn quick(&self, a: Placed, b: Placed) -> Option<QuickPair> {
        if self.exactness() == Exactness::Cheapest {
            QuickPair::of(a, b)
        } else {
            None
        }
    }

    /// Two cuboids turned alike: in their common axes, the distance of two upright boxes.
    #[inline]
    fn aligned(&self, a: &Transform, half_a: Vec3A, b: &Transform, half_b: Vec3A) -> bool {
        let turned_back = a.rotation.normalize().inverse();
        let offset = Vec3A::from(turned_back * (b.translation - a.translation));
        let reach = half_a + half_b;
        let gaps = (offset.abs() - reach).max(Vec3A::ZERO);
        let tolerance = self.tolerance().max(ROUNDING * reach.max_element());
        // Measured by the tolerance, so that the squares of huge sizes do not overflow. The last is
        // for what is not finite: `max` drops a NaN, and infinity reaches everything.
        (gaps / tolerance).length_squared() <= 1.0 && (offset.abs() + reach).is_finite()
    }

    #[cold]
    fn decide_large(&self, pair: &PlacedPair, workspace: &mut Workspace) -> bool {
        if let Some(smaller) = Smaller::of(pair, self) {
            let [a, b] = smaller.placed(pair);
            return smaller.tests.intersects(a, b, workspace);
        }
        let verdict = complete(pair, workspace);
        workspace.counters.count(Stage::Complete, Some(verdict));
        verdict
    }

    fn decide(&self, pair: &PlacedPair, workspace: &mut Workspace) -> bool {
        self.decide_early(pair, workspace).unwrap_or_else(|| {
            let verdict = complete(pair, workspace);
            workspace.counters.count(Stage::Complete, Some(verdict));
            verdict
        })
    }

    /// What the stages before the last say.
    #[inline]
    pub(super) fn decide_early(
        &self,
        pair: &PlacedPair,
        workspace: &mut Workspace,
    ) -> Option<bool> {
        let counters = &mut workspace.counters;
        let mut verdict = counters
            .count(Stage::Bounds, bounds(pair))
            .or_else(|| counters.count(Stage::Spheres, spheres(pair)));
        if self.exactness() == Exactness::Cheapest || pair.case() != Case::Cuboids {
            verdict = verdict.or_else(|| counters.count(Stage::Boxes, boxes(pair)));
        }
        verdict
    }
}

/// How wide a gap has to be for an early stage to reject: wider than the tolerance by more than
/// rounding, so that no stage rejects what a later one would accept.
#[inline]
fn slack(pair: &PlacedPair) -> f32 {
    2.0 * pair.tolerance
}

#[inline]
fn bounds(pair: &PlacedPair) -> Option<bool> {
    let offset = pair.box_b.center - pair.box_a.center;
    let gaps = offset.abs() - (pair.box_a.reach() + pair.box_b.reach());
    (gaps.max_element() > slack(pair)).then_some(false)
}

#[inline]
fn spheres(pair: &PlacedPair) -> Option<bool> {
    let distance = pair.box_a.center.distance(pair.box_b.center);
    let gap = distance - (pair.box_a.radius + pair.box_b.radius);
    match pair.case() {
        Case::Spheres => Some(gap <= pair.tolerance),
        _ => (gap > slack(pair)).then_some(false),
    }
}

#[inline]
fn boxes(pair: &PlacedPair) -> Option<bool> {
    match (pair.a.shape.kind(), pair.b.shape.kind()) {
        (Kind::Sphere, _) => sphere_box(pair),
        (_, Kind::Sphere) => sphere_box(&pair.swapped()),
        _ => match Separation::of(&pair.box_a, &pair.box_b, slack(pair)) {
            None => Some(false),
            // Boxes that overlap along every axis overlap; those within the tolerance may still be
            // further apart from corner to corner.
            Some(found) => {
                (pair.case() == Case::Cuboids && found.gap <= -found.doubt).then_some(true)
            }
        },
    }
}

/// A sphere against the box of another shape.
#[inline]
fn sphere_box(pair: &PlacedPair) -> Option<bool> {
    let center = pair.box_a.center;
    let gap = pair.box_b.closest_point(center).distance(center) - pair.box_a.radius;
    match pair.b.shape.kind() {
        Kind::Cuboid => Some(gap <= pair.tolerance),
        _ => (gap > slack(pair)).then_some(false),
    }
}

fn complete(pair: &PlacedPair, workspace: &mut Workspace) -> bool {
    if let Some(verdict) = Bodies::of_case(pair).and_then(|bodies| bodies.intersects()) {
        return verdict;
    }
    match pair.case() {
        Case::Spheres => spheres(pair) == Some(true),
        Case::SphereFirst => edge_polygon::sphere_intersects(pair, workspace),
        Case::SphereSecond => edge_polygon::sphere_intersects(&pair.swapped(), workspace),
        Case::Cuboids | Case::Convex | Case::Polygons => edge_polygon::intersects(pair, workspace),
        // What is one of ours has been asked as such.
        Case::Parts | Case::Foreign => parts(pair, workspace),
    }
}

/// Two that the support functions are asked about.
fn parts(pair: &PlacedPair, workspace: &mut Workspace) -> bool {
    support::intersects(pair.a, pair.b, pair.tolerance, workspace)
        || support::enclosed(pair, workspace).is_some()
}

/// What each stage by itself says about a pair.
#[cfg(test)]
pub(super) fn stages(pair: &PlacedPair, workspace: &mut Workspace) -> ([Option<bool>; 3], bool) {
    let early = [bounds(pair), spheres(pair), boxes(pair)];
    (early, complete(pair, workspace))
}

/// A pair of which one has no bounds goes straight to the last stage.
fn unbounded(a: Placed, b: Placed, tolerance: f32, workspace: &mut Workspace) -> bool {
    if !(a.transform.is_finite() && b.transform.is_finite()) {
        return false;
    }
    let verdict = support::intersects(a, b, tolerance, workspace);
    workspace.counters.count(Stage::Complete, Some(verdict));
    verdict
}
