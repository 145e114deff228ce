//! Which polygons of two shapes come near each other: by the trees of the meshes that have one.
//!
//! The tests of two surfaces compare all that is selected of the one with all that is selected of
//! the other. What they are shown here is
//!
//! | first \ second | without a tree | with a tree |
//! |---|---|---|
//! | without a tree | all of both, once | all of the first, and polygons of the second |
//! | with a tree | polygons of the first, and all of the second | polygons of both, by a join of the trees |
//!
//! and of all these what their boxes do not rule out, for the question that is asked: a [`Near`].

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::placed::PlacedPair;
use super::placing::{Placing, Way};
use super::surface::Surface;
use super::workspace::Workspace;
use crate::broad_phase::{Measure, Overlap, ScaledDistance, Sweep};
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// What makes two polygons near enough to be looked at.
pub trait Near {
    type Measure: Measure;

    /// How much larger boxes are, for that they need not touch.
    fn margin(&self) -> f32;

    /// What is asked of the boxes in the tree of a mesh, of which a box of the other shape is in
    /// its space. The box is one of the first shape if it is `first`.
    fn measure(&self, of: &Aabb3d, tree: &Placing, first: bool) -> Self::Measure;

    /// Whether two triangles may be near, the first of the first shape, by how high the corners of
    /// the one are over the plane of the other. In doubt, they may.
    fn may_be(&self, heights: &Heights, limit: f32) -> bool;
}

/// How high the corners of a triangle are over the plane of another.
pub struct Heights {
    low: f32,
    high: f32,
    /// Of the plane.
    normal: Vec3A,
    /// Are the corners those of the first?
    of_first: bool,
}

impl Heights {
    /// `None` if the other has no plane.
    #[inline(always)]
    fn of(corners: &[Vec3A; 3], [a, b, c]: &[Vec3A; 3], of_first: bool) -> Option<Self> {
        let normal = (*b - *a).cross(*c - *a);
        let length = normal.length();
        let normal = normal / length;
        let heights = corners.map(|corner| (corner - *a).dot(normal));
        // More than rounding makes of them.
        let far = corners
            .iter()
            .fold(Vec3A::ZERO, |far, corner| far.max((*corner - *a).abs()));
        let doubt = 8.0 * f32::EPSILON * far.max_element();
        (length > f32::MIN_POSITIVE).then(|| Self {
            low: heights[0].min(heights[1]).min(heights[2]) - doubt,
            high: heights[0].max(heights[1]).max(heights[2]) + doubt,
            normal,
            of_first,
        })
    }

    /// How far the corners are at least from the plane.
    #[inline(always)]
    fn gap(&self) -> f32 {
        self.low.max(-self.high)
    }
}

/// Those that touch, or are no further apart than a margin along each axis.
pub struct Touching(pub f32);

impl Near for Touching {
    type Measure = Overlap;

    fn margin(&self) -> f32 {
        self.0
    }

    #[inline(always)]
    fn measure(&self, of: &Aabb3d, _: &Placing, _: bool) -> Overlap {
        Overlap::new(*of)
    }

    #[inline(always)]
    fn may_be(&self, heights: &Heights, _: f32) -> bool {
        heights.gap() <= self.0
    }
}

/// Those that the first meets on its way in a direction, the first ones first. The limit is how far
/// it goes.
pub struct OnTheWay {
    pub direction: Vec3A,
    pub margin: f32,
}

impl Near for OnTheWay {
    type Measure = Sweep;

    fn margin(&self) -> f32 {
        self.margin
    }

    #[inline(always)]
    fn measure(&self, of: &Aabb3d, tree: &Placing, first: bool) -> Sweep {
        let direction = tree.direction_back(self.direction);
        let direction = if first { direction } else { -direction };
        Sweep::along(Vec3A::ZERO, direction, of.min, of.max, f32::INFINITY).0
    }

    #[inline(always)]
    fn may_be(&self, heights: &Heights, limit: f32) -> bool {
        let gap = heights.gap() - self.margin;
        if gap <= 0.0 {
            return true;
        }
        // How fast the corners come to the plane from their side.
        let climbs = heights.normal.dot(self.direction);
        let climbs = if heights.of_first { climbs } else { -climbs };
        let closing = if heights.low > 0.0 { -climbs } else { climbs };
        closing > 0.0 && gap <= closing * limit * (1.0 + 1e-5)
    }
}

/// Those within a distance, near ones first. The limit is the square of the distance.
pub struct Within;

impl Near for Within {
    type Measure = ScaledDistance;

    fn margin(&self) -> f32 {
        0.0
    }

    #[inline(always)]
    fn measure(&self, of: &Aabb3d, tree: &Placing, _: bool) -> ScaledDistance {
        ScaledDistance::new(*of, tree.scale())
    }

    #[inline(always)]
    fn may_be(&self, heights: &Heights, limit: f32) -> bool {
        let gap = heights.gap();
        gap <= 0.0 || gap * gap <= limit
    }
}

/// Has both meshes in place, and calls `visit` with what of the two may be near, until it breaks;
/// it tells the limit from then on. `None` if one of the two is not made of polygons.
pub fn for_each_near<'a, N: Near>(
    near: &N,
    pair: &PlacedPair<'a>,
    workspace: &mut Workspace,
    limit: f32,
    mut visit: impl FnMut(&[Surface; 2]) -> ControlFlow<(), f32>,
) -> Option<[&'a PolygonMesh; 2]> {
    let [(a, size_a), (b, size_b)] = [pair.a.shape.polygons()?, pair.b.shape.polygons()?];
    let tolerance = pair.tolerance;
    let Workspace {
        surfaces, stack, ..
    } = workspace;
    surfaces[0].place((a, size_a), pair.a, &pair.box_a);
    surfaces[1].place((b, size_b), pair.b, &pair.box_b);
    let placings = [*surfaces[0].placing(), *surfaces[1].placing()];
    match (a.tree(), b.tree()) {
        (None, None) => {
            surfaces[0].select_all(a, tolerance);
            surfaces[1].select_all(b, tolerance);
            let _ = visit(surfaces);
        }
        (None, Some(tree)) => {
            surfaces[0].select_all(a, tolerance);
            let around = around(&placings, 0, near.margin());
            let measure = near.measure(&around, &placings[1], true);
            tree.search(&measure, limit, |polygon, _| {
                surfaces[1].select(b, polygon, tolerance);
                visit(surfaces)
            });
        }
        (Some(tree), None) => {
            surfaces[1].select_all(b, tolerance);
            let around = around(&placings, 1, near.margin());
            let measure = near.measure(&around, &placings[0], false);
            tree.search(&measure, limit, |polygon, _| {
                surfaces[0].select(a, polygon, tolerance);
                visit(surfaces)
            });
        }
        (Some(tree), Some(other)) => {
            let way: Way = placings[0]
                .to(&placings[1])
                .with_margin(near.margin(), &placings[1]);
            let mut left = limit;
            tree.join(
                other,
                stack,
                limit,
                |aabb| way.place(aabb),
                |aabb| near.measure(aabb, &placings[1], true),
                |polygon, other, _| {
                    let corners = [
                        triangle(a, &placings[0], polygon),
                        triangle(b, &placings[1], other),
                    ];
                    if let [Some(one), Some(other)] = &corners
                        && !may_be(near, one, other, left)
                    {
                        return ControlFlow::Continue(left);
                    }
                    surfaces[0].select(a, polygon, tolerance);
                    surfaces[1].select(b, other, tolerance);
                    left = visit(surfaces)?;
                    ControlFlow::Continue(left)
                },
            );
        }
    }
    Some([a, b])
}

/// The corners of a polygon in place, if it is a triangle.
#[inline(always)]
fn triangle(mesh: &PolygonMesh, placing: &Placing, polygon: u32) -> Option<[Vec3A; 3]> {
    let vertices = mesh.vertices();
    match mesh.polygon(polygon as usize) {
        &[a, b, c] => Some([a, b, c].map(|vertex| placing.place(vertices[vertex as usize]))),
        _ => None,
    }
}

/// Whether two triangles may be near, by the planes of both.
#[inline(always)]
fn may_be(near: &impl Near, one: &[Vec3A; 3], other: &[Vec3A; 3], limit: f32) -> bool {
    let by_plane =
        |heights: Option<Heights>| heights.is_none_or(|heights| near.may_be(&heights, limit));
    by_plane(Heights::of(one, other, true)) && by_plane(Heights::of(other, one, false))
}

/// The box of one of two meshes, in the space of the other.
pub fn around(placings: &[Placing; 2], of: usize, margin: f32) -> Aabb3d {
    let (one, other) = (&placings[of], &placings[1 - of]);
    one.to(other)
        .with_margin(margin, other)
        .place(&one.bounds())
}

#[cfg(test)]
mod tests;
