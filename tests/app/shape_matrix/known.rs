//! Shapes as a test knows them, by formulas in 64-bit numbers.

use std::f32::consts::TAU;

use bevy::{
    math::{DMat3, DVec3},
    prelude::*,
};
use bevy_octree::narrow_phase::{Placed, Shape};
use fastrand::Rng;

/// A convex shape in its own coordinates: a core at a scale, and a radius around it.
#[derive(Clone, Debug)]
pub(crate) enum Core {
    Points(Vec<DVec3>),
    Frustum {
        bottom: f64,
        top: f64,
        half: f64,
    },
    /// All that is behind the plane through the origin with this normal.
    Behind(DVec3),
}

#[derive(Clone, Debug)]
pub(crate) struct Known {
    pub(crate) name: &'static str,
    pub(crate) shape: Shape,
    pub(super) core: Core,
    radius: f64,
    /// What the scale makes of the radius.
    radius_scale: fn(DVec3) -> f64,
}

/// One of them in its place.
pub(super) struct PartAt<'a> {
    pub(super) known: &'a Known,
    pub(super) transform: Transform,
    pub(super) turn: DMat3,
    pub(super) scale: DVec3,
    pub(super) position: DVec3,
}

fn largest(scale: DVec3) -> f64 {
    scale.abs().max_element()
}

impl Known {
    pub(super) fn new(name: &'static str, shape: Shape, core: Core, radius: f32) -> Self {
        Self {
            name,
            shape,
            core,
            radius: f64::from(radius),
            radius_scale: largest,
        }
    }

    /// What is bounded by the hull of points.
    pub(super) fn of_points(name: &'static str, shape: Shape, points: &[Vec3]) -> Self {
        let points = points.iter().map(|point| point.as_dvec3()).collect();
        Self::new(name, shape, Core::Points(points), 0.0)
    }

    pub(super) fn cuboid(name: &'static str, half: Vec3, radius: f32) -> Self {
        let solid = Shape::from_half_size(half);
        let signs = [-1.0, 1.0];
        let mut points = vec![];
        for x in signs {
            for y in signs {
                for z in signs {
                    points.push((half * Vec3::new(x, y, z)).as_dvec3());
                }
            }
        }
        Self::new(name, around(solid, radius), Core::Points(points), radius)
    }

    fn frustum(name: &'static str, [top, bottom, height]: [f32; 3], radius: f32) -> Self {
        let core = Core::Frustum {
            bottom: bottom.into(),
            top: top.into(),
            half: f64::from(height) * 0.5,
        };
        let solid = Shape::conical_frustum(top, bottom, height);
        Self::new(name, around(solid, radius), core, radius)
    }
}

fn around(solid: Shape, radius: f32) -> Shape {
    if radius > 0.0 {
        Shape::rounded(&solid, radius).unwrap()
    } else {
        solid
    }
}

pub(super) fn point(rng: &mut Rng, reach: f32) -> Vec3 {
    let mut number = || (rng.f32() * 2.0 - 1.0) * reach;
    Vec3::new(number(), number(), number())
}

/// One of each convex kind, of random sizes.
pub(crate) fn kinds(rng: &mut Rng) -> Vec<Known> {
    let mut size = || 0.2 + 1.8 * rng.f32();
    let mut all = vec![];
    let radius = size();
    all.push(Known::new(
        "sphere",
        Shape::sphere(radius),
        Core::Points(vec![DVec3::ZERO]),
        radius,
    ));
    let half = Vec3::new(size(), size(), size());
    all.push(Known::cuboid("cuboid", half, 0.0));
    all.push(Known::cuboid("wall", Vec3::new(0.5, 30.0, 100.0), 0.0));
    let (radius, length) = (size(), size());
    let ends = [-0.5, 0.5].map(|side| (Vec3::Y * length * side).as_dvec3());
    all.push(Known {
        radius_scale: |scale| scale.x.abs().max(scale.z.abs()),
        ..Known::new(
            "capsule",
            Shape::capsule(radius, length),
            Core::Points(ends.to_vec()),
            radius,
        )
    });
    let mut frustum = |name, top: f32, bottom: f32, radius: f32| {
        Known::frustum(name, [top, bottom, 0.3 + rng.f32() * 2.0], radius)
    };
    all.push(frustum("cylinder", 0.7, 0.7, 0.0));
    all.push(frustum("cone", 0.0, 0.9, 0.0));
    all.push(frustum("frustum", 1.1, 0.4, 0.0));
    all.push(frustum("rounded cylinder", 0.5, 0.5, 0.2));
    all.push(frustum("rounded cone", 0.0, 0.6, 0.15));
    let [a, b, c, d] = std::array::from_fn(|_| point(rng, 1.5));
    all.push(Known::of_points(
        "segment",
        Shape::segment(a, b).unwrap(),
        &[a, b],
    ));
    all.push(triangle([a, b, c]));
    all.push(Known {
        radius: f64::from(0.4f32),
        ..Known::of_points(
            "leaning capsule",
            Shape::capsule_between(a, c, 0.4).unwrap(),
            &[a, c],
        )
    });
    all.push(Known::of_points(
        "tetrahedron",
        Shape::tetrahedron([a, b, c, d]).unwrap(),
        &[a, b, c, d],
    ));
    all.push(Known::cuboid(
        "rounded cuboid",
        Vec3::new(0.4, 0.9, 0.6),
        0.3,
    ));
    // Of few enough edges for the depth of two to be exact.
    let points: Vec<Vec3> = (0..24).map(|_| point(rng, 1.2)).collect();
    let hull = Shape::convex_hull(points.iter().copied()).unwrap();
    let round = Shape::rounded(&hull, 0.2).unwrap();
    all.push(Known::of_points("hull", hull, &points));
    all.push(Known {
        radius: f64::from(0.2f32),
        ..Known::of_points("rounded hull", round, &points)
    });
    let normal = point(rng, 1.0).normalize_or(Vec3::Y);
    all.push(half_space("half-space", normal));
    all
}

pub(super) fn half_space(name: &'static str, normal: Vec3) -> Known {
    let shape = Shape::half_space(normal).unwrap();
    let Shape::HalfSpace { normal } = shape else {
        unreachable!();
    };
    Known::new(name, shape, Core::Behind(normal.as_dvec3()), 0.0)
}

pub(super) fn triangle([a, b, c]: [Vec3; 3]) -> Known {
    let shape = Shape::triangle(a, b, c).unwrap();
    Known::of_points("triangle", shape, &[a, b, c])
}

impl PartAt<'_> {
    pub(super) fn placed(&self) -> Placed<'_> {
        Placed::new(&self.known.shape, &self.transform)
    }

    fn radius(&self) -> f64 {
        self.known.radius * (self.known.radius_scale)(self.scale)
    }

    /// Is it bounded by nothing but faces?
    pub(super) fn has_faces(&self) -> bool {
        let are_corners = matches!(&self.known.core, Core::Points(points) if points.len() > 3);
        are_corners && self.known.radius == 0.0
    }

    /// The normal of a half-space, and how far along it its plane is.
    pub(super) fn plane(&self) -> Option<(DVec3, f64)> {
        let Core::Behind(normal) = self.known.core else {
            return None;
        };
        let normal = (self.turn * (normal / self.scale)).normalize();
        Some((normal, normal.dot(self.position)))
    }

    /// How far it reaches along a unit vector.
    pub(super) fn reach(&self, direction: DVec3) -> f64 {
        let scaled = (self.turn.transpose() * direction) * self.scale;
        let core = match &self.known.core {
            Core::Points(points) => points
                .iter()
                .map(|point| point.dot(scaled))
                .fold(f64::NEG_INFINITY, f64::max),
            Core::Frustum { bottom, top, half } => {
                let across = scaled.with_y(0.0).length();
                (top * across + half * scaled.y).max(bottom * across - half * scaled.y)
            }
            Core::Behind(_) => {
                let (normal, offset) = self.plane().unwrap();
                let is_along = normal.dot(direction) > 1.0 - 1e-12;
                return if is_along { offset } else { f64::INFINITY };
            }
        };
        core + self.radius() + direction.dot(self.position)
    }

    /// No point is in it that is further than the reach along one of these.
    pub(super) fn excess(&self, point: DVec3, directions: &[DVec3]) -> f64 {
        if let Some((normal, offset)) = self.plane() {
            return normal.dot(point) - offset;
        }
        directions
            .iter()
            .map(|direction| direction.dot(point) - self.reach(*direction))
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// How far the second is beyond the first along a direction, or along what is known of half-spaces.
pub(super) fn gap(a: &PartAt, b: &PartAt, direction: DVec3) -> f64 {
    match (a.plane(), b.plane()) {
        (Some((normal, offset)), _) => -b.reach(-normal) - offset,
        (None, Some((normal, offset))) => -a.reach(-normal) - offset,
        _ => -b.reach(-direction) - a.reach(direction),
    }
}

/// Directions all around, evenly.
pub(super) fn directions(count: usize) -> Vec<DVec3> {
    (0..count)
        .map(|number| {
            let y = 1.0 - 2.0 * (number as f64 + 0.5) / count as f64;
            let angle = number as f64 * 2.399_963_229_728_653;
            let across = (1.0 - y * y).sqrt();
            DVec3::new(across * angle.cos(), y, across * angle.sin())
        })
        .collect()
}

pub(crate) fn pose(rng: &mut Rng, reach: f32, scaled: bool) -> Transform {
    let mut number = |reach: f32| (rng.f32() * 2.0 - 1.0) * reach;
    let translation = Vec3::new(number(reach), number(reach), number(reach));
    let axis = Vec3::new(number(1.0), number(1.0), number(1.0));
    let rotation = Quat::from_scaled_axis(axis * TAU / 2.0);
    let scale = if scaled {
        Vec3::new(1.0 + number(0.6), 1.0 + number(0.6), -1.0 + number(0.6))
    } else {
        Vec3::ONE
    };
    Transform {
        translation,
        rotation,
        scale,
    }
}
