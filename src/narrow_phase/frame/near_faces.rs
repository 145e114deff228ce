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
            tree.join(
                other,
                stack,
                limit,
                |aabb| way.place(aabb),
                |aabb| near.measure(aabb, &placings[1], true),
                |polygon, other, _| {
                    surfaces[0].select(a, polygon, tolerance);
                    surfaces[1].select(b, other, tolerance);
                    visit(surfaces)
                },
            );
        }
    }
    Some([a, b])
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
