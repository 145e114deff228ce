//! Which polygon of a mesh a point is on.

use std::ops::ControlFlow;

use bevy::math::{DVec3, Vec3A, bounding::Aabb3d};

use super::local_ray::vertex;
use crate::{broad_phase::ScaledDistance, narrow_phase::mesh::polygon_mesh::PolygonMesh};

/// What is nearer together is as near, as a share of the lengths at hand.
const AS_NEAR: f64 = 1e-5;

/// The nearest polygon so far.
struct Nearest {
    distance: f64,
    /// How much it faces the direction.
    facing: f64,
    polygon: u32,
    normal: DVec3,
}

/// The polygon that is nearest to a point, of a mesh at a scale, and its normal: of several as near,
/// the one that faces a direction most, on either side if it bounds no solid.
///
/// O(log n) in a mesh with a tree.
pub fn nearest_polygon(
    mesh: &PolygonMesh,
    point: DVec3,
    scale: DVec3,
    towards: DVec3,
) -> Option<(u32, DVec3)> {
    let (center, half, radius) = mesh.local_bounds();
    let size = f64::from(radius) * scale.abs().max_element();
    let as_near = AS_NEAR * (size + point.length());
    let mut best: Option<Nearest> = None;
    let mut look = |polygon: u32| -> f64 {
        let (distance, normal) = distance(mesh, polygon, point, scale);
        let facing = normal.dot(towards);
        let facing = if mesh.bounds_solid(polygon as usize) {
            facing
        } else {
            facing.abs()
        };
        let is_better = best.as_ref().is_none_or(|best| {
            let is_as_near = (distance - best.distance).abs() <= as_near;
            let rank = (facing - best.facing).abs() <= 1e-6;
            if !is_as_near {
                distance < best.distance
            } else if rank {
                polygon < best.polygon
            } else {
                facing > best.facing
            }
        });
        if is_better {
            best = Some(Nearest {
                distance,
                facing,
                polygon,
                normal,
            });
        }
        best.as_ref()
            .map_or(f64::INFINITY, |best| best.distance + as_near)
    };
    let local = (point / scale).as_vec3a();
    match mesh.tree() {
        Some(tree) if local.is_finite() => {
            let at = Aabb3d {
                min: local,
                max: local,
            };
            let measure = ScaledDistance::new(at, scale.as_vec3().into());
            let reach = (center - local).abs() + half;
            let everywhere = (reach * Vec3A::from(scale.as_vec3())).length() * 2.0;
            // Squared, as the measure is.
            tree.search(&measure, everywhere * everywhere, |polygon, _| {
                let distance = look(polygon) as f32;
                ControlFlow::Continue(distance * distance * (1.0 + 8.0 * f32::EPSILON))
            });
        }
        _ => (0..mesh.polygon_count() as u32).for_each(|polygon| _ = look(polygon)),
    }
    best.map(|best| (best.polygon, best.normal))
}

/// How far a point is from a polygon, and the normal of that.
fn distance(mesh: &PolygonMesh, polygon: u32, point: DVec3, scale: DVec3) -> (f64, DVec3) {
    let corners = mesh.polygon(polygon as usize);
    let at = |corner: u32| vertex(mesh, corner) * scale - point;
    let normal = (mesh.normals()[polygon as usize].as_dvec3() / scale).normalize_or_zero();
    let height = normal.dot(at(corners[0]));
    let (x, y) = match normal.abs().max_position() {
        0 => (1, 2),
        1 => (2, 0),
        _ => (0, 1),
    };
    let foot = normal * height;
    let (mut covers, mut nearest) = (false, f64::INFINITY);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (a, b) = (at(*a), at(*b));
        let along = b - a;
        let share = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min((a + along * share).length());
        let [from, to] = [a - foot, b - foot];
        if (from[y] > 0.0) != (to[y] > 0.0) {
            covers ^= from[x] - along[x] * (from[y] / along[y]) > 0.0;
        }
    }
    (if covers { height.abs() } else { nearest }, normal)
}
