//! Shapes of Rapier's that are none of ours: taken apart by the trees of parry, or known by their
//! support functions alone.

use bevy::math::{DVec3, Dir3, Vec3};
use bevy_rapier3d::parry::{
    bounding_volume::Aabb,
    math::Pose,
    partitioning::BvhNode,
    query,
    shape::{self, CompositeShape, HeightField, TypedShape, Voxels},
};

use super::convex::{Convex, Isometry, wide};
use super::foreign_core::ForeignCore;
use super::probe::{Probe, Search, passage};
use crate::narrow_phase::{
    answer::{Impact, against},
    frame::placed::Placed,
    shape::Shape,
};

/// In so many pieces is a way over a grid of somebody else's cut at most, to look at what is along it.
const MOST_PIECES: f64 = 4096.0;

/// What a shape is, or a part of one.
#[derive(Clone, Copy)]
pub enum ForeignPart<'a> {
    Convex(Convex<'a>),
    /// By its normal, in its own axes.
    HalfSpace(DVec3, Isometry),
    Whole(Foreign<'a>),
}

/// What consists of parts.
#[derive(Clone, Copy)]
pub enum Foreign<'a> {
    /// What has a tree: a mesh; or a compound, whose parts need not hang together.
    Tree {
        parts: &'a dyn CompositeShape,
        is_compound: bool,
        at: Isometry,
    },
    HeightField(&'a HeightField, Isometry),
    Voxels(&'a Voxels, Isometry),
}

impl<'a> Foreign<'a> {
    pub const fn isometry(&self) -> Isometry {
        match self {
            Self::Tree { at, .. } | Self::HeightField(_, at) | Self::Voxels(_, at) => *at,
        }
    }

    pub const fn is_compound(&self) -> bool {
        match self {
            Self::Tree { is_compound, .. } => *is_compound,
            Self::HeightField(..) => false,
            // Its cells need not hang together.
            Self::Voxels(..) => true,
        }
    }

    /// Is it made of triangles that have numbers?
    pub const fn has_triangles(&self) -> bool {
        matches!(self, Self::Tree { .. })
    }

    /// Centre and half extents of the box around it, in its own axes.
    pub fn local_box(&self) -> [DVec3; 2] {
        let [low, high] = corners(&match self {
            Self::Tree { parts, .. } => parts.bvh().root_aabb(),
            Self::HeightField(field, _) => field.local_aabb(),
            Self::Voxels(voxels, _) => voxels.local_aabb(),
        });
        [(low + high) * 0.5, (high - low) * 0.5]
    }

    /// Calls `visit` with all parts that a probe admits. False if there is one about which nothing
    /// can be said.
    pub fn each(
        &self,
        probe: &Probe,
        search: &Search,
        visit: &mut dyn FnMut(ForeignPart) -> bool,
    ) -> bool {
        match *self {
            Self::Tree {
                parts,
                is_compound,
                at,
            } => {
                let mut is_known = true;
                let may_be = |node: &BvhNode| {
                    probe.admits(node.mins().as_dvec3(), node.maxs().as_dvec3(), search)
                };
                for index in parts.bvh().leaves(may_be) {
                    parts.map_part_at(index, &mut |pose, part, _| {
                        let triangle = part.as_triangle().filter(|_| !is_compound);
                        search.triangle.set(triangle.map(|_| index));
                        let part = posed(part, of_part(&at, pose));
                        is_known &= part.is_some_and(&mut *visit);
                    });
                }
                is_known
            }
            Self::HeightField(field, at) => {
                let cell = f64::from(field.cell_width().max(field.cell_height()));
                let mut is_known = true;
                probe.each_piece(corners(&field.local_aabb()), cell, search, |low, high| {
                    let piece = Aabb::new(low.as_vec3(), high.as_vec3());
                    field.map_elements_in_local_aabb(&piece, &mut |_, part| {
                        let corners = [part.a, part.b, part.c].map(Vec3::as_dvec3);
                        let [a, b, c] = corners;
                        if probe.admits(a.min(b).min(c), a.max(b).max(c), search) {
                            let part = Convex::triangle(corners, 0.0, at);
                            is_known &= visit(ForeignPart::Convex(part));
                        }
                    });
                });
                is_known
            }
            Self::Voxels(voxels, at) => {
                let half = voxels.voxel_size() * 0.5;
                let cell = f64::from(half.max_element());
                let mut is_known = true;
                probe.each_piece(corners(&voxels.local_aabb()), cell, search, |low, high| {
                    let piece = Aabb::new(low.as_vec3(), high.as_vec3());
                    for voxel in voxels.voxels_intersecting_local_aabb(&piece) {
                        let [low, high] =
                            [voxel.center - half, voxel.center + half].map(Vec3::as_dvec3);
                        if !voxel.state.is_empty() && probe.admits(low, high, search) {
                            let at = Isometry {
                                translation: at.to_world(voxel.center.as_dvec3()),
                                ..at
                            };
                            let part = Convex::cuboid(wide(half), at);
                            is_known &= visit(ForeignPart::Convex(part));
                        }
                    }
                });
                is_known
            }
        }
    }
}

impl Probe {
    /// Calls `visit` with boxes that cover what is near within bounds: one after the other along
    /// the way.
    fn each_piece(
        &self,
        [low, high]: [DVec3; 2],
        cell: f64,
        search: &Search,
        mut visit: impl FnMut(DVec3, DVec3),
    ) {
        let margin = search.margin.get();
        let Self::Box {
            center,
            half,
            direction,
        } = *self
        else {
            return if search.goes_on() {
                visit(low, high);
            };
        };
        // What is as near as rounding, too.
        let reach = half + margin + f64::from(f32::EPSILON) * (low.abs().max(high.abs()));
        let Some([start, end]) = passage(
            low - reach - center,
            high + reach - center,
            direction,
            search.limit.get(),
        ) else {
            return;
        };
        let step = (4.0 * cell)
            .max(2.0 * half.max_element())
            .max((end - start) / MOST_PIECES);
        let mut from = start;
        while search.goes_on() && from <= search.limit.get() && from <= end {
            let to = (from + step).min(end);
            let ends = [from, to].map(|along| center + direction * along);
            let piece_low = (ends[0].min(ends[1]) - reach).max(low).min(high);
            let piece_high = (ends[0].max(ends[1]) + reach).min(high).max(low);
            visit(piece_low, piece_high);
            if to >= end {
                break;
            }
            from = to;
        }
    }
}

fn corners(aabb: &Aabb) -> [DVec3; 2] {
    [aabb.mins, aabb.maxs].map(wide)
}

fn of_part(at: &Isometry, pose: Option<&Pose>) -> Isometry {
    pose.map_or(*at, |pose| {
        at.of_part(pose.rotation.as_dquat(), wide(pose.translation))
    })
}

/// A shape of Rapier's as something that can be asked; `None` for what parry knows no more of than
/// its name.
pub fn foreign(shape: &Shape, at: Isometry) -> Option<ForeignPart<'_>> {
    match shape {
        Shape::Rapier(shape) => posed(&*shape.raw().0, at),
        _ => None,
    }
}

/// A shape of parry's in its place; `None` if nothing can be said about it.
fn posed(shape: &dyn shape::Shape, at: Isometry) -> Option<ForeignPart<'_>> {
    if let Some(convex) = convex(shape, at) {
        return Some(ForeignPart::Convex(convex));
    }
    if let Some(side) = shape.as_halfspace() {
        return Some(ForeignPart::HalfSpace(wide(side.normal), at));
    }
    let tree = |parts| Foreign::Tree {
        parts,
        is_compound: shape.as_compound().is_some(),
        at,
    };
    let field = shape.as_heightfield();
    let voxels = || shape.as_voxels().map(|voxels| Foreign::Voxels(voxels, at));
    field
        .map(|field| Foreign::HeightField(field, at))
        .or_else(voxels)
        .or_else(|| shape.as_composite_shape().map(tree))
        .map(ForeignPart::Whole)
}

/// A convex shape of parry's; `None` if it is not convex, or has no end.
fn convex(shape: &dyn shape::Shape, at: Isometry) -> Option<Convex<'_>> {
    let frustum = |sizes: [f32; 3], radius: f32| {
        Convex::frustum(sizes.map(f64::from), DVec3::ONE, f64::from(radius), at)
    };
    let cylinder = |cylinder: &shape::Cylinder, radius| {
        frustum(
            [cylinder.radius, cylinder.radius, cylinder.half_height],
            radius,
        )
    };
    let cone = |cone: &shape::Cone, radius| frustum([cone.radius, 0.0, cone.half_height], radius);
    let triangle = |triangle: &shape::Triangle, radius: f32| {
        let corners = [triangle.a, triangle.b, triangle.c].map(wide);
        Convex::triangle(corners, f64::from(radius), at)
    };
    Some(match shape.as_typed_shape() {
        TypedShape::Ball(ball) => Convex::ball(f64::from(ball.radius), at),
        TypedShape::Cuboid(cuboid) => Convex::cuboid(wide(cuboid.half_extents), at),
        TypedShape::Capsule(capsule) => {
            let ends = [capsule.segment.a, capsule.segment.b].map(wide);
            Convex::segment(ends, f64::from(capsule.radius), at)
        }
        TypedShape::Segment(segment) => Convex::segment([segment.a, segment.b].map(wide), 0.0, at),
        TypedShape::Triangle(inner) => triangle(inner, 0.0),
        TypedShape::ConvexPolyhedron(hull) => {
            Convex::foreign(ForeignCore::Hull(hull.points()), 0.0, at)
        }
        TypedShape::Cylinder(inner) => cylinder(inner, 0.0),
        TypedShape::Cone(inner) => cone(inner, 0.0),
        TypedShape::RoundCuboid(round) => {
            let mut inner = Convex::cuboid(wide(round.inner_shape.half_extents), at);
            inner.radius = f64::from(round.border_radius);
            inner
        }
        TypedShape::RoundTriangle(round) => triangle(&round.inner_shape, round.border_radius),
        TypedShape::RoundCylinder(round) => cylinder(&round.inner_shape, round.border_radius),
        TypedShape::RoundCone(round) => cone(&round.inner_shape, round.border_radius),
        TypedShape::RoundConvexPolyhedron(round) => {
            let hull = ForeignCore::Hull(round.inner_shape.points());
            Convex::foreign(hull, f64::from(round.border_radius), at)
        }
        TypedShape::Custom(shape) => {
            Convex::foreign(ForeignCore::Support(shape.as_support_map()?), 0.0, at)
        }
        _ => return None,
    })
}

/// How a shape is turned, at the origin.
fn turn(placed: Placed) -> Pose {
    Pose::from_parts(Vec3::ZERO, placed.transform.rotation.normalize())
}

/// What a shape says of a ray of which nothing else is known.
pub fn ray_by_itself(
    target: Placed,
    origin: Vec3,
    direction: Dir3,
    max_distance: f32,
    solid: bool,
) -> Option<Impact> {
    let Shape::Rapier(shape) = target.shape else {
        return None;
    };
    let ray = query::Ray::new(origin - target.transform.translation, *direction);
    let max_distance = max_distance.min(f32::MAX);
    let raw = shape.raw();
    let met = raw.cast_ray_and_get_normal(&turn(target), &ray, max_distance, solid)?;
    let distance = met.time_of_impact;
    // No normal inside.
    let normal = met
        .normal
        .try_normalize()
        .filter(|_| distance > 0.0)
        .unwrap_or(-*direction);
    let is_within = distance >= 0.0 && distance <= max_distance;
    is_within.then(|| Impact {
        distance,
        point: origin + direction * distance,
        normal: against(normal, direction),
        face_normal: normal,
        polygon: None,
        depth: 0.0,
    })
}

/// The point of a shape that is closest to another, of which nothing else is known.
pub fn closest_by_itself(target: Placed, point: Vec3) -> Option<Vec3> {
    let Shape::Rapier(shape) = target.shape else {
        return None;
    };
    let at = target.transform.translation;
    let found = shape.raw().project_point(&turn(target), point - at, true);
    Some(at + found.point)
}
