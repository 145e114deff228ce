//! How a mesh gets from its own space to the frame of a pair, and what is asked of it back.
//!
//! Scale, mirrors and turns are put on what is asked, not on the mesh: a box of the frame becomes
//! a box around it in the space of the mesh, in which its tree is.

use bevy::math::{DVec3, Mat3A, Vec3, Vec3A, bounding::Aabb3d};

use super::local_aabb::LocalAabb;
use super::oriented_box::OrientedBox;
use super::placed::Placed;
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// The least scale along an axis by which is divided, as a share of the greatest. A mesh that a
/// scale of zero makes flat is looked for as if it were so thick, which is less than rounding.
const FLAT: f32 = 1e-7;

/// How a mesh gets from its own space to the frame of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub struct Placing {
    axes: Mat3A,
    center: Vec3A,
    scale: Vec3A,
    /// What to divide by on the way back: the scale, but for zeros.
    divisor: Vec3A,
    /// The centre of the mesh, in its own space, and half its size.
    middle: Vec3A,
    half: Vec3A,
}

impl Placing {
    /// That of a shape made of polygons, at a size of its own beside its scale.
    #[inline]
    pub fn of((mesh, size): (&PolygonMesh, Vec3A), placed: Placed, bounds: &OrientedBox) -> Self {
        let scale = placed.shape.effective_scale(placed.transform.scale) * size;
        let (middle, half, _) = mesh.local_bounds();
        let least = f32::MIN_POSITIVE.max(FLAT * scale.abs().max_element());
        let is_flat = scale.abs().cmplt(Vec3A::splat(least));
        Self {
            axes: bounds.axes,
            center: bounds.center,
            scale,
            divisor: Vec3A::select(is_flat, Vec3A::splat(least), scale),
            middle,
            half,
        }
    }

    pub fn scale(&self) -> Vec3A {
        self.scale
    }

    /// The scale along all axes, whatever its sign, if it is the same and not zero.
    pub fn uniform_scale(&self) -> Option<f32> {
        let scale = self.scale.abs();
        (scale.x == scale.y && scale.y == scale.z && scale.x > 0.0).then_some(scale.x)
    }

    /// Whether the mesh is much thinner along one axis than along another for its scale.
    pub fn is_flat(&self) -> bool {
        let scale = self.scale.abs();
        scale.min_element() < 1e-3 * scale.max_element()
    }

    /// Whether the mesh is not much thinner along one axis than along another for its scale, so that
    /// what is apart in it is so in the frame.
    pub fn is_even(&self) -> bool {
        let scale = self.scale.abs();
        scale.min_element() >= 0.25 * scale.max_element()
    }

    /// How large the mesh is along the axis along which it is largest, from its centre.
    pub fn size(&self) -> f32 {
        (self.half * self.scale.abs()).max_element()
    }

    /// Whether a point of the frame is certainly beyond the box of the mesh.
    pub fn is_beyond(&self, point: Vec3A) -> bool {
        let (_, around) = self.near(point);
        let (min, max) = (self.middle - self.half, self.middle + self.half);
        (around.min.cmpgt(max) | around.max.cmplt(min)).any()
    }

    /// The box of the mesh in its own space.
    pub fn bounds(&self) -> Aabb3d {
        Aabb3d {
            min: self.middle - self.half,
            max: self.middle + self.half,
        }
    }

    #[inline]
    pub fn place(&self, vertex: Vec3) -> Vec3A {
        self.center + self.axes * ((Vec3A::from(vertex) - self.middle) * self.scale)
    }

    /// How vertices get to the frame: by what they are multiplied, from which point on, and where
    /// that gets.
    #[inline]
    pub fn linear(&self) -> (Mat3A, Vec3A, Vec3A) {
        let linear = self.axes * Mat3A::from_diagonal(self.scale.into());
        (linear, self.middle, self.center)
    }

    /// Normals scale with the cofactors, that is inversely, but without dividing by zero. A mirror
    /// would turn them inside out.
    #[inline]
    pub fn normal(&self, normal: Vec3) -> Vec3A {
        if self.uniform_scale().is_some() {
            return self.axes * (Vec3A::from(normal) * self.scale.signum());
        }
        self.axes * unit_or_zero(Vec3A::from(normal) * cofactors(self.scale))
    }

    /// The way from one mesh to another, both in the frame of a pair.
    pub fn to(&self, other: &Self) -> Way {
        let back = other.axes.transpose();
        let linear = Mat3A::from_diagonal(other.divisor.recip().into())
            * (back * self.axes)
            * Mat3A::from_diagonal(self.scale.into());
        let apart = self.center - other.center;
        let around = self.axes.abs() * (self.half * self.scale.abs());
        Way {
            linear,
            abs: linear.abs(),
            from: self.middle,
            to: back * apart / other.divisor + other.middle,
            grow: other.grown(0.0, apart, around),
        }
    }

    /// The way from the frame of the pair into the space of the mesh, for boxes that reach no
    /// further than so from a point.
    pub fn way_back(&self, from: Vec3A, reach: Vec3A) -> Way {
        let linear = Mat3A::from_diagonal(self.divisor.recip().into()) * self.axes.transpose();
        Way {
            linear,
            abs: linear.abs(),
            from,
            to: linear * (from - self.center) + self.middle,
            grow: self.grown(0.0, from - self.center, reach),
        }
    }

    /// A point of the frame in the space of the mesh, and a box there that it is in whatever
    /// rounding does.
    #[inline]
    pub fn near(&self, point: Vec3A) -> (Vec3A, Aabb3d) {
        let apart = point - self.center;
        let at = self.axes.transpose() * apart / self.divisor + self.middle;
        (at, Aabb3d::new(at, self.grown(0.0, apart, Vec3A::ZERO)))
    }

    /// How much larger a box has to be in the space of the mesh for a margin in the frame, and for
    /// rounding: of one that is so far from the centre of the mesh, and reaches so far.
    fn grown(&self, margin: f32, apart: Vec3A, reach: Vec3A) -> Vec3A {
        let size = apart.abs() + reach;
        let rounding = 16.0 * f32::EPSILON * size.max_element();
        let divisor = self.divisor.abs();
        let local = self.middle.abs() + self.half + size.max_element() / divisor;
        (margin + rounding) / divisor + 4.0 * f32::EPSILON * local
    }

    /// A box in the space of the mesh, around all that is in a region of the frame: a little larger
    /// than it has to be. `None` if the region is empty.
    pub fn back(&self, region: &LocalAabb) -> Option<Aabb3d> {
        if !region.min.cmple(region.max).all() {
            return None;
        }
        let (center, half) = (
            (region.min + region.max) * 0.5,
            (region.max - region.min) * 0.5,
        );
        Some(
            self.way_back(center, half)
                .place(&Aabb3d::new(center, half)),
        )
    }

    /// A direction of the frame in the space of the mesh, where it is of another length.
    #[inline]
    pub fn direction_back(&self, direction: Vec3A) -> Vec3A {
        self.axes.transpose() * direction / self.divisor
    }

    /// A point of the frame in the space of the mesh; `None` where a scale of zero has no way back.
    pub fn point_back(&self, point: Vec3A) -> Option<DVec3> {
        let inverse = self.axes.transpose();
        let from_center = inverse.as_dmat3() * (point.as_dvec3() - self.center.as_dvec3());
        let local = from_center / self.scale.as_dvec3() + self.middle.as_dvec3();
        local.is_finite().then_some(local)
    }
}

/// How boxes get into the space of a mesh, from that of another or from the frame of the pair.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    linear: Mat3A,
    abs: Mat3A,
    /// A point, and where it gets.
    from: Vec3A,
    to: Vec3A,
    grow: Vec3A,
}

impl Way {
    /// The box around a box, a little larger than it has to be.
    #[inline(always)]
    pub fn place(&self, aabb: &Aabb3d) -> Aabb3d {
        let (center, half) = ((aabb.min + aabb.max) * 0.5, (aabb.max - aabb.min) * 0.5);
        let center = self.to + self.linear * (center - self.from);
        let reach = self.abs * half + self.grow;
        Aabb3d {
            min: center - reach,
            max: center + reach,
        }
    }

    /// The same, with boxes grown by a margin in the frame of the pair.
    pub fn with_margin(self, margin: f32, target: &Placing) -> Self {
        Self {
            grow: self.grow + margin / target.divisor.abs(),
            ..self
        }
    }
}

/// By these, normals scale: inversely to lengths, but without dividing by zero, and mirrors do not
/// turn them inside out.
#[inline]
pub fn cofactors(scale: Vec3A) -> Vec3A {
    let largest = scale.abs().max_element();
    let relative = if largest > 0.0 {
        scale / largest
    } else {
        scale
    };
    let mirror = 1f32.copysign(scale.x * scale.y * scale.z);
    mirror
        * Vec3A::new(
            relative.y * relative.z,
            relative.z * relative.x,
            relative.x * relative.y,
        )
}

/// The direction of a vector whose length may underflow; zero for zero.
#[inline]
fn unit_or_zero(v: Vec3A) -> Vec3A {
    let largest = v.abs().max_element();
    if largest > f32::MIN_POSITIVE {
        (v / largest).normalize()
    } else {
        Vec3A::ZERO
    }
}
