//! What shapes of many consist of, for the exact tests: one way to walk all of them.

use bevy::math::{DVec3, Vec3A};

use super::composite::{
    box_tree::BoxTree,
    height_field::{FieldTriangle, HeightField},
    parts::Part,
    voxels::{Cells, Voxels},
};
use super::shape::{Compound, Shape};

/// A shape that consists of many.
#[derive(Clone, Copy, Debug)]
pub(super) enum Composite<'a> {
    Compound(&'a Compound),
    HeightField(&'a HeightField),
    Voxels(&'a Voxels),
}

/// One of the many.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leaf<'a> {
    /// A shape in its pose.
    Part(&'a Part<Shape>),
    /// A triangle.
    Triangle(FieldTriangle),
    /// A box of full cells.
    Cells(Cells),
}

impl<'a> Composite<'a> {
    /// A shape, if it consists of many.
    pub(super) fn of(shape: &'a Shape) -> Option<Self> {
        match shape {
            Shape::Compound(compound) => Some(Self::Compound(compound)),
            Shape::HeightField(field) => Some(Self::HeightField(field)),
            Shape::Voxels(voxels) => Some(Self::Voxels(voxels)),
            _ => None,
        }
    }

    /// Visits all that is in boxes that are admitted, by their lower and upper corners in the
    /// shape's own coordinates, in no particular order. What is not admitted is skipped with all
    /// below. Who has found enough admits nothing more.
    pub(super) fn walk(
        self,
        admits: &mut dyn FnMut(Vec3A, Vec3A) -> bool,
        visit: &mut dyn FnMut(Leaf<'a>),
    ) {
        match self {
            Self::Compound(compound) => {
                (&compound.0).walk(admits, &mut |part| visit(Leaf::Part(part)));
            }
            Self::HeightField(field) => {
                field.walk(admits, &mut |triangle| visit(Leaf::Triangle(triangle)));
            }
            Self::Voxels(voxels) => {
                voxels.walk(admits, &mut |cells| visit(Leaf::Cells(cells)));
            }
        }
    }

    /// Visits what is in boxes that have a distance, near ones first. It is asked again for what
    /// waited while others were visited, so that a limit may shrink.
    pub(super) fn walk_near(
        self,
        distance: &mut dyn FnMut(Vec3A, Vec3A) -> Option<f32>,
        visit: &mut dyn FnMut(Leaf<'a>),
    ) {
        match self {
            Self::Compound(compound) => {
                (&compound.0).walk_near(distance, &mut |part| visit(Leaf::Part(part)));
            }
            Self::HeightField(field) => {
                field.walk_near(distance, &mut |triangle| visit(Leaf::Triangle(triangle)));
            }
            Self::Voxels(voxels) => {
                voxels.walk_near(distance, &mut |cells| visit(Leaf::Cells(cells)));
            }
        }
    }

    /// Centre and half extents at a scale.
    pub(super) fn box_at(self, scale: DVec3) -> [DVec3; 2] {
        if let Self::Compound(compound) = self {
            let (center, half, _) = compound.bounds_at(scale.as_vec3a());
            return [center.as_dvec3(), half.as_dvec3()];
        }
        let (center, half, _) = self.local_bounds();
        [center.as_dvec3() * scale, half.as_dvec3() * scale.abs()]
    }

    /// How far what it consists of may be beyond its boxes at a scale.
    pub(super) fn stray_at(self, scale: DVec3) -> f64 {
        match self {
            Self::Compound(compound) => compound.0.stray_at(scale.as_vec3a()).into(),
            Self::HeightField(_) | Self::Voxels(_) => 0.0,
        }
    }

    /// Centre, half extents and bounding radius, of its own coordinates.
    pub(super) fn local_bounds(self) -> (Vec3A, Vec3A, f32) {
        match self {
            Self::Compound(compound) => compound.local_bounds(),
            Self::HeightField(field) => field.local_bounds(),
            Self::Voxels(voxels) => voxels.local_bounds(),
        }
    }
}

#[cfg(test)]
mod tests;
