//! A convex solid around the centre of its box, along its own axes: how polygons meet it, and how
//! far it has to go to be clear of them.
//!
//! A cuboid is three numbers there, and all axes that may part it from a triangle have closed forms
//! (Akenine-Möller, *Fast 3D Triangle-Box Overlap Testing*, 2001). Of the edges of a convex mesh,
//! those count whose normals an edge of the polygon can meet, by the Gauss map (Gregorius, *The
//! Separating Axis Test between Convex Polyhedra*, 2013). Of a mesh of many faces, those near the
//! polygon are looked for.

use bevy::math::{Vec3A, Vec3Swizzles};

use super::{
    facet::{Best, Facet, WayOut, bounds, highest},
    hull::Hull,
    large_hull::LargeHull,
};
use crate::narrow_phase::frame::surface::{border, covers};

/// A convex solid around the centre of its box, along its own axes.
#[derive(Clone, Copy, Debug)]
pub enum Body<'a> {
    /// By half its sides.
    Cuboid(Vec3A),
    Hull(&'a Hull),
    /// One of many faces.
    Large(&'a LargeHull<'a>),
}

/// Do all corners of a polygon turn the same way?
fn is_convex(corners: &[Vec3A], normal: Vec3A) -> bool {
    let count = corners.len();
    let turn = |i: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % count]);
        (b - a).cross(c - b).dot(normal)
    };
    let turns = || (0..count).map(turn);
    let largest = turns().fold(0f32, |largest, turn| largest.max(turn.abs()));
    let low = -1e-4 * largest;
    turns().all(|turn| turn >= low) || turns().all(|turn| turn <= -low)
}

impl Body<'_> {
    /// Where it begins along a direction.
    #[inline]
    pub fn lowest(&self, direction: Vec3A) -> f32 {
        match self {
            Self::Cuboid(half) => -half.dot(direction.abs()),
            Self::Hull(hull) => hull.lowest(direction),
            Self::Large(hull) => hull.lowest(direction),
        }
    }

    /// Does a polygon come as near as `tolerance`, or a little more? A polygon that is not convex
    /// is taken for its hull.
    #[inline]
    pub fn touches(&self, corners: &[Vec3A], normal: Vec3A, tolerance: f32) -> bool {
        match self {
            Self::Cuboid(half) => cuboid_touches(*half, corners, normal, tolerance),
            Self::Hull(hull) => hull.touches(corners, normal, tolerance),
            Self::Large(hull) => hull.touches(corners, tolerance),
        }
    }

    /// The same of a polygon that need not be convex.
    pub fn touches_polygon(&self, corners: &[Vec3A], normal: Vec3A, tolerance: f32) -> bool {
        self.touches(corners, normal, tolerance)
            && (corners.len() == 3
                || is_convex(corners, normal)
                || border(corners).any(|side| self.touches(&side, Vec3A::ZERO, tolerance))
                || self.is_cut_inside(corners, normal))
    }

    /// Is the place where the plane of a polygon cuts it inside the polygon? None of its sides
    /// touches it.
    fn is_cut_inside(&self, corners: &[Vec3A], normal: Vec3A) -> bool {
        let plane = highest(corners, normal);
        let ends = [normal, -normal].map(|direction| self.furthest(direction));
        let [above, below] = ends.map(|end| end.dot(normal) - plane);
        let share = if above > below {
            above / (above - below)
        } else {
            0.0
        };
        let point = ends[0].lerp(ends[1], share.clamp(0.0, 1.0));
        covers(corners, normal, point)
    }

    /// A point of it that is as far along a direction as any.
    fn furthest(&self, direction: Vec3A) -> Vec3A {
        match self {
            Self::Cuboid(half) => *half * direction.signum(),
            Self::Hull(hull) => hull.furthest(direction),
            Self::Large(hull) => hull.furthest(direction),
        }
    }

    /// The least translation that takes it off a polygon that it touches, of those along directions
    /// that are normals of the surface there. Later ones have to be less by `bias`.
    #[inline]
    pub fn way_out(&self, facet: &Facet, bias: f32) -> Option<WayOut> {
        let mut best = Best {
            way: self.along_normal(facet),
            bias,
        };
        if best.way.is_none_or(|way| way.depth > bias) {
            match self {
                Self::Cuboid(half) => cuboid_ways(*half, facet, &mut best),
                Self::Hull(hull) => hull.ways(facet, &mut best),
                Self::Large(hull) => hull.ways(facet, &mut best),
            }
        }
        best.way
    }

    /// Along the polygon's own normal, to the nearer side, unless only one is outside.
    #[inline]
    fn along_normal(&self, facet: &Facet) -> Option<WayOut> {
        let along = |direction: Vec3A| WayOut {
            direction,
            depth: highest(facet.corners, direction) - self.lowest(direction),
        };
        if facet.normal == Vec3A::ZERO {
            return None;
        }
        let (up, down) = (along(facet.normal), along(-facet.normal));
        let turns = !facet.is_solid && down.depth < up.depth;
        Some(if turns { down } else { up })
    }

    /// Puts the corners of the face that faces a direction most, into `corners`; its normal.
    pub fn face_towards(&self, direction: Vec3A, corners: &mut Vec<Vec3A>) -> Vec3A {
        corners.clear();
        match self {
            Self::Hull(hull) => hull.face_towards(direction, corners),
            Self::Large(hull) => hull.face_towards(direction, corners),
            Self::Cuboid(half) => {
                let axis = direction.abs().max_position();
                let sign = 1f32.copysign(direction[axis]);
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                corners.extend([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(
                    |[at_u, at_v]| {
                        let mut corner = Vec3A::ZERO;
                        corner[axis] = sign * half[axis];
                        corner[u] = at_u * half[u];
                        corner[v] = at_v * half[v];
                        corner
                    },
                ));
                Vec3A::AXES[axis] * sign
            }
        }
    }

    /// Calls `cut` with the planes that bound it: unit normals outwards, and how far they are.
    pub fn for_each_plane(&self, mut cut: impl FnMut(Vec3A, f32)) {
        match self {
            Self::Hull(hull) => hull.for_each_plane(cut),
            Self::Large(hull) => hull.for_each_plane(cut),
            Self::Cuboid(half) => {
                for axis in 0..3 {
                    cut(Vec3A::AXES[axis], half[axis]);
                    cut(-Vec3A::AXES[axis], half[axis]);
                }
            }
        }
    }
}

#[inline]
fn cuboid_touches(half: Vec3A, corners: &[Vec3A], normal: Vec3A, tolerance: f32) -> bool {
    let [min, max] = bounds(corners.iter().copied());
    let reach = half + tolerance;
    if min.cmpgt(reach).any() || max.cmplt(-reach).any() {
        return false;
    }
    let extent = half.dot(normal.abs()) + tolerance;
    let heights = corners.iter().map(|corner| corner.dot(normal));
    let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| {
        (low.min(h), high.max(h))
    });
    if low > extent || high < -extent {
        return false;
    }
    // The products of a side with the three axes, in one lane each: all of a point's heights along
    // them are the components of one product.
    border(corners).all(|[from, to]| {
        let side = to - from;
        let [min, max] = bounds(corners.iter().map(|corner| side.cross(*corner)));
        let lengths = side.abs();
        let extents = half.yzx() * lengths.zxy()
            + half.zxy() * lengths.yzx()
            + tolerance * lengths.element_sum();
        !(min.cmpgt(extents).any() || max.cmplt(-extents).any())
    })
}

#[inline]
fn cuboid_ways(half: Vec3A, facet: &Facet, best: &mut Best) {
    let [min, max] = bounds(facet.corners.iter().copied());
    let (upwards, downwards) = (half + max, half - min);
    for axis in 0..3 {
        for (direction, depth) in [
            (Vec3A::AXES[axis], upwards[axis]),
            (-Vec3A::AXES[axis], downwards[axis]),
        ] {
            if best.is_beaten_by(depth) && facet.allows(direction) {
                best.take(direction, depth);
            }
        }
    }
    for side in 0..facet.corners.len() {
        for axis in Vec3A::AXES {
            if let Some(direction) = facet.across(side, axis) {
                let depth = facet.corners[side].dot(direction) + half.dot(direction.abs());
                if best.is_beaten_by(depth) && facet.is_ridge(side, direction) {
                    best.take(direction, depth);
                }
            }
        }
    }
}
