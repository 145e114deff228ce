//! A ray in the coordinates of a shape, and what it meets there.

use bevy::math::{DVec3, Dir3, Quat, Vec3, Vec3A};

use crate::narrow_phase::{
    answer::{Impact, against, slack},
    frame::{chord::Met, placed::Placed, surface::winds_around},
    mesh::polygon_mesh::PolygonMesh,
    shape::Shape,
};

/// How close to its border a point counts as on a polygon, as a share of the distances at hand:
/// more than the rounding of 64-bit floats, so that no ray slips through where polygons join.
pub const BORDER: f64 = 1e-9;
/// The least scale along an axis, as a share of the greatest: a shape flattened by a scale of zero
/// is so thick to rays.
const FLAT: f64 = 1e-7;

/// How far the square of the length of a rotation may be from 1 that is not made shorter.
const UNIT: f32 = 1e-5;
/// How much larger a box is taken that a ray is to miss, as a share of the distances at hand: more
/// than the rounding of 32-bit floats.
pub const ROUGHLY: f32 = 1e-5;

/// A distance, in double precision, that is beyond all that are within a distance, or round to it.
///
/// What is found beyond it is left out by the [impact](LocalRay::impact).
pub fn limit(max_distance: f32) -> f64 {
    f64::from(max_distance) * (1.0 + f64::from(f32::EPSILON)) + f64::from(f32::MIN_POSITIVE)
}

/// A ray in the coordinates of a shape, in which distances along it are those in the world. In
/// double precision, so that neither the scale nor the way from afar costs exactness.
#[derive(Clone, Copy, Debug)]
pub struct LocalRay {
    pub origin: DVec3,
    pub direction: DVec3,
    pub scale: DVec3,
    /// How far off a shape the ray may start and count as on it, in the world.
    pub slack: f64,
}

impl LocalRay {
    /// `None` if anything is not finite.
    pub fn new(target: Placed, origin: Vec3, direction: Dir3) -> Option<Self> {
        let from_center = origin.as_dvec3() - target.transform.translation.as_dvec3();
        let mut ray = Self {
            origin: from_center,
            direction: direction.as_dvec3(),
            scale: DVec3::ONE,
            slack: slack(origin, from_center),
        };
        // Much of a level is neither turned nor scaled.
        if target.transform.rotation != Quat::IDENTITY {
            let back = target.transform.rotation.as_dquat().normalize().conjugate();
            (ray.origin, ray.direction) = (back * ray.origin, back * ray.direction);
        }
        if target.transform.scale != Vec3::ONE {
            if !target.transform.scale.is_finite() {
                return None;
            }
            // That of a capsule is in its sizes.
            if matches!(target.shape, Shape::Capsule { .. }) {
                return ray.is_finite().then_some(ray);
            }
            let scale = target.shape.effective_scale(target.transform.scale);
            let scale = scale.as_dvec3();
            let least = DVec3::splat(FLAT * scale.abs().max_element());
            ray.scale = DVec3::select(scale.abs().cmplt(least), least, scale);
            (ray.origin, ray.direction) = (ray.origin / ray.scale, ray.direction / ray.scale);
        }
        ray.is_finite().then_some(ray)
    }

    fn is_finite(&self) -> bool {
        (self.origin + self.direction).is_finite()
    }

    /// Whether a ray may meet the box of a mesh, quickly. In doubt, it may.
    #[inline]
    pub fn may_meet(
        mesh: &PolygonMesh,
        target: Placed,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
    ) -> bool {
        let (center, half, _) = mesh.local_bounds();
        let scale = Vec3A::from(target.transform.scale);
        let rotation = target.transform.rotation;
        if (rotation.length_squared() - 1.0).abs() > UNIT {
            return true;
        }
        let back = rotation.conjugate();
        let from = back * Vec3A::from(origin - target.transform.translation);
        let way = back * Vec3A::from(*direction);
        let (center, half) = (center * scale, half * scale.abs());
        let sizes = from.abs() + center.abs() + half + origin.abs().max_element();
        let reach = half + ROUGHLY * sizes.max_element();
        let least = Vec3A::splat(f32::MIN_POSITIVE);
        let way = Vec3A::select(way.abs().cmplt(least), least, way);
        let (one, other) = ((center - reach - from) / way, (center + reach - from) / way);
        let enters = one.min(other).max_element();
        let leaves = one.max(other).min_element();
        // Not a number in doubt.
        let misses = enters > leaves || leaves < 0.0 || enters > max_distance * (1.0 + ROUGHLY);
        !misses
    }

    /// The impact in the world; `None` if it is further than that, or nowhere.
    pub fn impact(
        &self,
        target: Placed,
        (origin, direction): (Vec3, Dir3),
        max_distance: f32,
        met: Met,
    ) -> Option<Impact> {
        let distance = met.distance as f32;
        let face = met.face.and_then(|face| self.to_world(face, target));
        (distance <= max_distance && distance.is_finite()).then(|| Impact {
            distance,
            point: (origin.as_dvec3() + direction.as_dvec3() * met.distance).as_vec3(),
            normal: face
                .filter(|_| met.crosses)
                .map_or(-*direction, |face| against(face, direction)),
            face_normal: face.unwrap_or(-*direction),
            polygon: met.polygon.map(|polygon| target.shape.source(polygon)),
            depth: 0.0,
        })
    }

    /// Normals scale inversely.
    fn to_world(self, normal: DVec3, target: Placed) -> Option<Vec3> {
        let scaled = if self.scale == DVec3::ONE {
            normal
        } else {
            normal / self.scale
        };
        let unit = scaled.try_normalize()?.as_vec3();
        if target.transform.rotation == Quat::IDENTITY {
            return Some(unit);
        }
        (target.transform.rotation.normalize() * unit).try_normalize()
    }

    /// How high the start is over a plane, in the world.
    pub fn height(&self, height: f64, normal: DVec3) -> f64 {
        height / (normal / self.scale).length()
    }

    pub fn is_inside(&self, mesh: &PolygonMesh) -> bool {
        if mesh.tree().is_some() || mesh.has_junctions() {
            return mesh.winds_around(self.origin);
        }
        winds_around(mesh, |corner| {
            (vertex(mesh, corner) - self.origin)
                .normalize_or_zero()
                .as_vec3a()
        })
    }

    /// How far a ray in the plane of a polygon, but not on it, goes to its border.
    pub fn border(
        &self,
        mesh: &PolygonMesh,
        corners: &[u32],
        normal: DVec3,
        slack: f64,
    ) -> Option<f64> {
        let across = normal.cross(self.direction);
        let distances = corners
            .iter()
            .zip(corners.iter().cycle().skip(1))
            .filter_map(|(a, b)| {
                let (a, b) = (
                    vertex(mesh, *a) - self.origin,
                    vertex(mesh, *b) - self.origin,
                );
                let [at_a, at_b] = [a, b].map(|end| end.dot(across));
                let is_ahead = at_a.min(at_b) <= slack * across.length()
                    && at_a.max(at_b) >= -slack * across.length();
                // Those along the ray have neighbours that are not.
                let share = (at_a / (at_a - at_b)).clamp(0.0, 1.0);
                let met = a.lerp(b, share).dot(self.direction) / self.direction.length_squared();
                (is_ahead && met >= 0.0).then_some(met)
            });
        distances.min_by(f64::total_cmp)
    }
}

pub fn vertex(mesh: &PolygonMesh, index: u32) -> DVec3 {
    mesh.vertices()[index as usize].as_dvec3()
}

/// The normal of a triangle, not of unit length and as exact as its corners, or else none: where a ray
/// meets its plane by the normal as 32-bit floats, it may pass between two that join.
pub fn exact_normal(mesh: &PolygonMesh, corners: &[u32]) -> Option<DVec3> {
    let &[a, b, c] = corners else {
        return None;
    };
    let [a, b, c] = [a, b, c].map(|corner| vertex(mesh, corner));
    Some((b - a).cross(c - a))
}

/// Is a point in the plane of a polygon inside its border, by the even-odd rule, or on it?
pub fn is_on_polygon(
    mesh: &PolygonMesh,
    corners: &[u32],
    normal: DVec3,
    point: DVec3,
    slack: f64,
) -> bool {
    // Seen along the axis that shows most of it.
    let (x, y) = match normal.abs().max_position() {
        0 => (1, 2),
        1 => (2, 0),
        _ => (0, 1),
    };
    let mut inside = false;
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (a, b) = (vertex(mesh, *a), vertex(mesh, *b));
        let (along, to_point) = (b - a, point - a);
        let closest = a + along * (to_point.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        if closest.distance_squared(point) <= slack * slack {
            return true;
        }
        if (a[y] > point[y]) != (b[y] > point[y]) {
            inside ^= a[x] + along[x] * ((point[y] - a[y]) / along[y]) > point[x];
        }
    }
    inside
}
