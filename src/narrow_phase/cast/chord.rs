//! The lines of rays and the convex shapes of ours.

use bevy::math::DVec3;

use super::local_ray::{LocalRay, vertex};
use crate::narrow_phase::{
    frame::{
        chord::{Chord, Met},
        placed::Placed,
    },
    shape::Shape,
};

impl LocalRay {
    /// That of a convex shape of ours, but for those that are known by their support functions alone.
    pub fn chord(&self, target: Placed) -> Option<Chord> {
        let wide = |size: f32| f64::from(size.abs());
        Some(match target.shape {
            Shape::Cuboid { half_size } => {
                let half = half_size.abs().as_dvec3();
                let planes = (0..3).flat_map(|axis| {
                    [DVec3::AXES[axis], -DVec3::AXES[axis]]
                        .map(|unit| (unit, unit.dot(self.origin) - half[axis], None))
                });
                self.chord_of_planes(planes)
            }
            Shape::Convex(mesh) => {
                let planes = mesh.polygons().zip(mesh.normals()).enumerate();
                self.chord_of_planes(planes.map(|(polygon, (corners, normal))| {
                    let normal = normal.as_dvec3();
                    let height = normal.dot(self.origin - vertex(mesh, corners[0]));
                    (normal, height, Some(polygon as u32))
                }))
            }
            Shape::Sphere { radius } => self.chord_of_sphere(f64::from(radius.abs())),
            Shape::Capsule {
                radius,
                half_length,
            } => {
                // Its ends stay round.
                let scale = target.shape.effective_scale(target.transform.scale);
                let [radius, half_length] = [
                    radius.abs() * scale.x.abs(),
                    half_length.abs() * scale.y.abs(),
                ];
                self.chord_of_capsule(wide(radius), wide(half_length))
            }
            Shape::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => self.chord_of_frustum([*radius_bottom, *radius_top, *half_height].map(wide)),
            _ => return None,
        })
    }

    /// By normals, heights over the planes, and numbers.
    fn chord_of_planes(&self, planes: impl Iterator<Item = (DVec3, f64, Option<u32>)>) -> Chord {
        let nowhere = Met::crossing(0.0, DVec3::ZERO, None);
        let (mut enters, mut leaves) = (
            Met::crossing(f64::NEG_INFINITY, DVec3::ZERO, None),
            Met::crossing(f64::INFINITY, DVec3::ZERO, None),
        );
        let (mut highest, mut rise, mut start) = (f64::NEG_INFINITY, f64::NEG_INFINITY, nowhere);
        let mut passes = true;
        for (normal, height, polygon) in planes {
            let climb = normal.dot(self.direction);
            let (height, steep) = (self.height(height, normal), self.height(climb, normal));
            highest = highest.max(height);
            if height.abs() <= self.slack && steep > rise {
                (rise, start) = (steep, Met::crossing(0.0, normal, polygon));
            }
            let end = Met::crossing(-height / steep, normal, polygon);
            if steep < 0.0 && end.distance >= enters.distance {
                enters = end;
            } else if steep > 0.0 && end.distance <= leaves.distance {
                leaves = end;
            } else if steep == 0.0 && height > self.slack {
                passes = false;
            }
        }
        // A closed solid has both.
        passes &= enters.distance <= leaves.distance
            && enters.distance.is_finite()
            && leaves.distance.is_finite();
        Chord {
            height: highest,
            rise,
            start,
            ends: passes.then_some([enters, leaves]),
        }
    }

    fn chord_of_sphere(&self, radius: f64) -> Chord {
        let scale = self.scale.x.abs();
        let squared = self.direction.length_squared();
        // From the point of the line that is closest to the centre.
        let along = -self.origin.dot(self.direction);
        let closest = self.origin + self.direction * (along / squared);
        let room = radius * radius - closest.length_squared();
        let end =
            |distance: f64| Met::crossing(distance, self.origin + self.direction * distance, None);
        let half = (room.max(0.0) * squared).sqrt();
        let from_center = self.origin.length();
        Chord {
            height: (from_center - radius) * scale,
            rise: -along / (from_center * squared.sqrt()),
            start: end(0.0),
            ends: (room >= 0.0).then(|| [along - half, along + half].map(|t| end(t / squared))),
        }
    }
}
