//! What of a convex shape is furthest along a direction: a face, an edge or a point.
//!
//! Of the core it is a list of points: the corners of the face that faces the direction most, the
//! ends of a side, or a single point. A radius around the core moves each of them out, to where the
//! surface around that point comes closest to the direction.

use std::f64::consts::FRAC_PI_4;

use bevy::math::DVec3;
use smallvec::{SmallVec, smallvec};

use super::{Convex, Core, wide};
use crate::narrow_phase::{composite::voxels::Faces, mesh::polygon_mesh::PolygonMesh};

/// The sine of the angle between an edge and a plane up to which it lies flat.
const STEEP: f64 = 0.17;
/// How far a cap may lean before a corner of it is put where it is lowest.
const LEANING: f64 = 1e-3;
/// How much a face of a cell has to face a direction to count, where the next cell hides others.
const LEAST_FACING: f64 = 0.5;
/// The corners of a cap: so many points of its circle.
const CAP_CORNERS: u32 = 8;

type Points = SmallVec<[DVec3; 8]>;

/// What a [`Feature`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureKind {
    /// All of the border of a half-space, with a point of it.
    Plane,
    Face,
    Edge,
    Point,
}

/// What of a shape is furthest along a direction.
#[derive(Clone, Debug)]
pub struct Feature {
    pub kind: FeatureKind,
    /// A unit vector out of the shape; of an edge or a point, next to the direction.
    pub normal: DVec3,
    /// Of the core, around the border of a face.
    core: Points,
    radius: f64,
    towards: DVec3,
}

impl Feature {
    /// The border of a half-space.
    pub fn plane(normal: DVec3, offset: f64) -> Self {
        Self {
            kind: FeatureKind::Plane,
            normal,
            core: smallvec![normal * offset],
            radius: 0.0,
            towards: normal,
        }
    }

    fn face(normal: DVec3, core: Points, radius: f64, towards: DVec3) -> Self {
        let kind = FeatureKind::Face;
        Self {
            kind,
            normal,
            core,
            radius,
            towards,
        }
    }

    fn segment(ends: [DVec3; 2], radius: f64, towards: DVec3) -> Self {
        Self {
            kind: FeatureKind::Edge,
            normal: square_to(towards, ends[1] - ends[0]).unwrap_or(towards),
            core: ends.into_iter().collect(),
            radius,
            towards,
        }
    }

    fn point(core: DVec3, radius: f64, towards: DVec3) -> Self {
        Self {
            kind: FeatureKind::Point,
            normal: towards,
            core: smallvec![core],
            radius,
            towards,
        }
    }

    /// Is it flat, and how much does it face the direction? The cosine of the angle.
    pub fn flatness(&self) -> Option<f64> {
        let is_flat = matches!(self.kind, FeatureKind::Plane | FeatureKind::Face);
        is_flat.then(|| self.normal.dot(self.towards))
    }

    /// How far the plane along its normal is from the origin.
    pub fn offset(&self) -> f64 {
        highest(&self.core, self.normal) + self.radius
    }

    /// Two points of the core, by which it is known again.
    pub fn first_two(&self) -> [DVec3; 2] {
        [self.core[0], self.core[1 % self.core.len()]]
    }

    /// How large it is: the distance of its furthest points, or about that; infinite for a plane.
    pub fn size(&self) -> f64 {
        if self.kind == FeatureKind::Plane {
            return f64::INFINITY;
        }
        let first = self.core[0];
        let others = self.core.iter().map(|point| point.distance(first));
        others.fold(0.0, f64::max)
    }

    /// The points on the surface of the shape.
    pub fn points(&self) -> impl Iterator<Item = DVec3> {
        let count = self.core.len();
        (0..count).map(move |i| {
            let neighbors = [(i + count - 1) % count, (i + 1) % count];
            self.core[i] + self.outwards(i, neighbors) * self.radius
        })
    }

    /// The border of a face, or the ends of an edge, all in the plane along the normal.
    pub fn border(&self) -> impl Iterator<Item = DVec3> {
        let out = self.normal * self.radius;
        self.core.iter().map(move |point| *point + out)
    }

    /// The direction along which the radius moves a point out: the one next to that asked about of
    /// those that no side leads along.
    fn outwards(&self, point: usize, neighbors: [usize; 2]) -> DVec3 {
        if self.radius == 0.0 {
            return self.towards;
        }
        let along = neighbors.map(|other| self.core[other] - self.core[point]);
        match along.map(|along| along.dot(self.towards) > 0.0) {
            [false, false] => self.towards,
            [true, false] => square_to(self.towards, along[0]).unwrap_or(self.normal),
            [false, true] => square_to(self.towards, along[1]).unwrap_or(self.normal),
            [true, true] => self.normal,
        }
    }

    /// The edge of it that lies flat along the direction and is furthest; the furthest point, if
    /// none does.
    pub fn edge(&self) -> Self {
        let height = |point: DVec3| point.dot(self.towards);
        let is_flat = |[from, to]: [DVec3; 2]| {
            let along = to - from;
            along != DVec3::ZERO && height(along).abs() <= STEEP * along.length()
        };
        let count = if self.kind == FeatureKind::Edge {
            1
        } else {
            self.core.len()
        };
        let sides = (0..count).map(|i| [self.core[i], self.core[(i + 1) % self.core.len()]]);
        let low = |side: &[DVec3; 2]| height(side[0]).min(height(side[1]));
        let top = sides.filter(|side| is_flat(*side));
        match top.max_by(|a, b| low(a).total_cmp(&low(b))) {
            Some(side) => Self::segment(side, self.radius, self.towards),
            None => {
                let points = self.core.iter().copied();
                let top = points.max_by(|a, b| height(*a).total_cmp(&height(*b)));
                Self::point(top.unwrap_or(DVec3::ZERO), self.radius, self.towards)
            }
        }
    }
}

impl Convex<'_> {
    /// What is furthest along a unit vector. `None` if that is a face which bounds no solid.
    pub fn feature(&self, towards: DVec3) -> Option<Feature> {
        let (at, radius) = (self.at, self.radius);
        let direction = at.direction_to_local(towards);
        let face = |normal: DVec3, mut corners: Points| {
            for corner in &mut corners {
                *corner = at.to_world(*corner);
            }
            Feature::face(at.rotation * normal, corners, radius, towards)
        };
        let edge = |ends: [DVec3; 2]| {
            let ends = ends.map(|end| at.to_world(end));
            Feature::segment(ends, radius, towards)
        };
        Some(match self.core {
            Core::Point => Feature::point(at.translation, radius, towards),
            Core::Foreign(_) => Feature::point(self.furthest(towards), radius, towards),
            Core::Segment([a, b]) if a == b => Feature::point(at.to_world(a), radius, towards),
            Core::Segment(ends) => edge(ends),
            Core::Triangle([a, b, c]) => match (b - a).cross(c - a).try_normalize() {
                Some(up) => {
                    let up = up * 1f64.copysign(up.dot(direction));
                    face(up, smallvec![a, b, c])
                }
                None => edge(longest([[a, b], [b, c], [c, a]])),
            },
            Core::Cuboid(half) => {
                let (normal, corners) = cuboid_face(half, self.faces, direction)?;
                face(normal, corners)
            }
            Core::Frustum {
                bottom,
                top,
                half_height,
                scale,
            } => match frustum_part([bottom, top, half_height], scale, direction) {
                FrustumPart::Cap(normal, corners) => face(normal, corners),
                FrustumPart::Side(ends) => edge(ends),
                FrustumPart::Neither => Feature::point(self.furthest(towards), radius, towards),
            },
            Core::Mesh(mesh, scale) => match mesh_face(mesh, scale, direction) {
                Some((normal, corners)) => face(normal, corners),
                None => Feature::point(self.furthest(towards), radius, towards),
            },
        })
    }
}

/// The unit vector at right angles to another that is next to a direction.
fn square_to(direction: DVec3, along: DVec3) -> Option<DVec3> {
    let along = along.try_normalize()?;
    (direction - along * along.dot(direction)).try_normalize()
}

fn highest(points: &[DVec3], normal: DVec3) -> f64 {
    let heights = points.iter().map(|point| point.dot(normal));
    heights.fold(f64::NEG_INFINITY, f64::max)
}

fn longest(sides: [[DVec3; 2]; 3]) -> [DVec3; 2] {
    let mut longest = sides[0];
    for side in sides {
        if side[0].distance_squared(side[1]) > longest[0].distance_squared(longest[1]) {
            longest = side;
        }
    }
    longest
}

/// The normal and the corners of the face of a cuboid that faces a direction most.
fn cuboid_face(half: DVec3, faces: Faces, direction: DVec3) -> Option<(DVec3, Points)> {
    let facing = |normal: DVec3| normal.dot(direction);
    let normals = faces.iter().map(|face| face.offset().as_dvec3());
    let normal = normals.max_by(|a, b| facing(*a).total_cmp(&facing(*b)))?;
    if faces != Faces::ALL && facing(normal) < LEAST_FACING {
        return None;
    }
    let side = DVec3::new(normal.y.abs() + normal.z.abs(), normal.x.abs(), 0.0) * half;
    let other = DVec3::new(0.0, normal.z.abs(), normal.x.abs() + normal.y.abs()) * half;
    let middle = normal * half;
    let corners = [-side - other, side - other, side + other, other - side];
    Some((
        normal,
        corners.map(|corner| middle + corner).into_iter().collect(),
    ))
}

/// What of a frustum faces a direction.
enum FrustumPart {
    Cap(DVec3, Points),
    Side([DVec3; 2]),
    Neither,
}

fn frustum_part(
    [bottom, top, half_height]: [f64; 3],
    scale: DVec3,
    direction: DVec3,
) -> FrustumPart {
    // As for its support function: the normal of what is scaled, in the space before that.
    let stretched = direction * scale;
    let is_top = stretched.y > 0.0;
    let (radius, height) = if is_top {
        (top, half_height)
    } else {
        (bottom, -half_height)
    };
    let around = stretched.with_y(0.0);
    let azimuth = if around.length() > LEANING * stretched.length() {
        around.normalize()
    } else {
        DVec3::X
    };
    let ends = [
        (azimuth * bottom).with_y(-half_height) * scale,
        (azimuth * top).with_y(half_height) * scale,
    ];
    let side = (ends[1] - ends[0]).try_normalize();
    let leaning = side.map_or(f64::INFINITY, |side| side.dot(direction).abs());
    // The sine of the angle to the plane of the cap.
    let lean = direction.with_y(0.0).length();
    if radius > 0.0 && lean <= leaning {
        let across = azimuth.cross(DVec3::Y);
        let corners = (0..CAP_CORNERS).map(|i| {
            let (sin, cos) = (f64::from(i) * FRAC_PI_4).sin_cos();
            ((azimuth * cos + across * sin) * radius).with_y(height) * scale
        });
        let normal = DVec3::Y * 1f64.copysign(direction.y);
        return FrustumPart::Cap(normal, corners.collect());
    }
    match side {
        Some(_) => FrustumPart::Side(ends),
        None => FrustumPart::Neither,
    }
}

/// The normal and the corners of the face of a mesh at a scale that faces a direction most.
fn mesh_face(mesh: &PolygonMesh, scale: DVec3, direction: DVec3) -> Option<(DVec3, Points)> {
    let mut best: Option<(f64, DVec3, usize)> = None;
    for (polygon, normal) in mesh.normals().iter().enumerate() {
        let Some(normal) = stretched_normal(wide(*normal), scale) else {
            continue;
        };
        let facing = normal.dot(direction);
        if best.is_none_or(|(most, ..)| facing > most) {
            best = Some((facing, normal, polygon));
        }
    }
    let (_, normal, polygon) = best?;
    let corners = mesh.polygon(polygon).iter();
    let place = |corner: &u32| wide(mesh.vertices()[*corner as usize]) * scale;
    Some((normal, corners.map(place).collect()))
}

/// The normal of a plane, outwards, that a scale stretches; `None` if that leaves no plane of it.
pub fn stretched_normal(normal: DVec3, scale: DVec3) -> Option<DVec3> {
    let DVec3 { x, y, z } = scale;
    let cofactors = DVec3::new(y * z, x * z, x * y) * 1f64.copysign(x * y * z);
    (normal * cofactors).try_normalize()
}
