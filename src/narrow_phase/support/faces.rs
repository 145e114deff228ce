//! Rays against shapes by what they are to meet of them, and through them: part by part.

use std::cell::Cell;

use bevy::math::{DVec3, Dir3, Vec3};

use super::convex::Convex;
use super::foreign::ray_by_itself;
use super::pairs;
use super::parts::{self, Part};
use super::posed::{PosedShape, posed};
use super::probe::Search;
use crate::narrow_phase::{
    answer::{Impact, Passage, against, slack},
    cast_options::{Faces, RayCastOptions},
    frame::{
        chord::{ALONG_START, Chord, Met},
        placed::Placed,
    },
};

/// How near something on its way comes to what it is going to touch before the rest is taken as
/// straight, as a share of the sizes.
const NEAR: f64 = 1e-7;
/// So far before something is met, as a share of its size, its normal is looked at.
const BEFORE: f64 = 1e-5;

/// A ray from the origin, with what is uncertain of its start.
struct Ray {
    direction: DVec3,
    slack: f64,
}

/// Where a ray meets a shape, by its options.
pub fn cast_ray_with(
    target: Placed,
    origin: Vec3,
    direction: Dir3,
    max_distance: f32,
    options: &RayCastOptions,
) -> Option<Impact> {
    let Some(body) = posed(target, origin) else {
        let solid = options.meets_inside();
        return ray_by_itself(target, origin, direction, max_distance, solid);
    };
    let ray = Ray::new(target, origin, direction);
    let mut first: Option<Met> = None;
    ray.each_part(&body, max_distance, |part, triangle, limit| {
        let met = ray.part(part, options);
        if let Some(met) = met.filter(|met| met.distance <= limit.get())
            && first.is_none_or(|first| met.distance < first.distance)
        {
            limit.set(met.distance);
            first = Some(Met {
                polygon: triangle,
                ..met
            });
        }
    });
    impact(origin, direction, max_distance, first?)
}

/// Where a ray that enters a shape leaves it; `None` if there is no solid where it does.
pub fn passage(
    target: Placed,
    origin: Vec3,
    direction: Dir3,
    max_distance: f32,
    enter: Impact,
) -> Option<Passage> {
    let body = posed(target, origin)?;
    let ray = Ray::new(target, origin, direction);
    let mut is_inside = false;
    let mut wall: Option<Met> = None;
    let mut place = f64::from(enter.distance);
    let together = ray.slack.max(f64::from(f32::EPSILON) * place.abs());
    // Parts that hang together are one solid.
    loop {
        let mut goes_on = false;
        ray.each_part(&body, f32::MAX, |part, _, _| {
            let Some(chord) = ray.chord(part) else {
                return;
            };
            is_inside |= chord.height < -ray.slack;
            let Some([enters, leaves]) = chord.ends else {
                return;
            };
            let is_further = wall.is_none_or(|wall| leaves.distance > wall.distance);
            if enters.distance <= place + together && leaves.distance >= place && is_further {
                goes_on |= leaves.distance > place;
                (place, wall) = (leaves.distance.max(place), Some(leaves));
            }
        });
        if !goes_on {
            break;
        }
    }
    let leave = wall?;
    Some(Passage {
        enter: (!is_inside).then_some(enter),
        leave: impact(origin, direction, max_distance, leave),
    })
}

fn impact(origin: Vec3, direction: Dir3, max_distance: f32, met: Met) -> Option<Impact> {
    let distance = met.distance as f32;
    let face = met.face.and_then(|face| face.as_vec3().try_normalize());
    (distance <= max_distance && distance.is_finite()).then(|| Impact {
        distance,
        point: (origin.as_dvec3() + direction.as_dvec3() * met.distance).as_vec3(),
        normal: face.map_or(-*direction, |face| against(face, direction)),
        face_normal: face.unwrap_or(-*direction),
        polygon: met.polygon,
        depth: 0.0,
    })
}

impl Ray {
    fn new(target: Placed, origin: Vec3, direction: Dir3) -> Self {
        let from_shape = origin.as_dvec3() - target.transform.translation.as_dvec3();
        Self {
            direction: direction.as_dvec3(),
            slack: slack(origin, from_shape),
        }
    }

    /// Calls `visit` with the parts along the ray, and the triangle of a mesh that each is; it may
    /// bring the limit nearer.
    fn each_part(
        &self,
        body: &PosedShape,
        max_distance: f32,
        mut visit: impl FnMut(&Part, Option<u32>, &Cell<f64>),
    ) {
        let point = PosedShape::Part(Part::Convex(Convex::point(DVec3::ZERO)));
        let near = Some(NEAR * body.size()).filter(|near| near.is_finite());
        let search = Search {
            direction: self.direction,
            limit: Cell::new(max_distance.into()),
            ..Search::within(near.unwrap_or(0.0).max(self.slack))
        };
        pairs::pairs(&search, &point, body, &mut |_, part| {
            visit(part, search.triangle.get(), &search.limit);
            true
        });
    }

    /// Where the ray meets what has no parts.
    fn part(&self, part: &Part, options: &RayCastOptions) -> Option<Met> {
        if let Part::Convex(convex) = part
            && let Some(corners) = convex.as_triangle()
        {
            return self.triangle(part, corners, options);
        }
        self.chord(part)?.met(options, self.slack)
    }

    /// As a polygon that bounds no solid.
    fn triangle(
        &self,
        part: &Part,
        [a, b, c]: [DVec3; 3],
        options: &RayCastOptions,
    ) -> Option<Met> {
        let normal = (b - a).cross(c - a).try_normalize()?;
        let (height, steep) = (-normal.dot(a), normal.dot(self.direction));
        let point = Part::Convex(Convex::point(DVec3::ZERO));
        let near = [self.slack, NEAR * self.slack];
        let found = parts::first_impact(&point, part, self.direction, f64::INFINITY, near);
        let (distance, _) = found.ok()??;
        let is_level = height.abs() <= self.slack;
        let starts_on = is_level && distance == 0.0;
        let is_left = options.ignores_start
            && if steep.abs() <= ALONG_START {
                is_level
            } else {
                starts_on && options.faces == Faces::Both
            };
        (options.meets(steep) && !is_left).then(|| Met::crossing(distance, normal, None))
    }

    /// The line of the ray and what has no parts, and is solid.
    fn chord(&self, part: &Part) -> Option<Chord> {
        let nowhere = Met::crossing(0.0, DVec3::ZERO, None);
        if let Part::HalfSpace { normal, offset } = part {
            let (height, steep) = (-offset, normal.dot(self.direction));
            let crossed = Met::crossing(-height / steep, *normal, None);
            let beyond = |distance: f64| Met::crossing(distance, *normal, None);
            let ends = if steep < 0.0 {
                Some([crossed, beyond(f64::INFINITY)])
            } else if steep > 0.0 {
                Some([beyond(f64::NEG_INFINITY), crossed])
            } else {
                (height <= self.slack).then(|| [f64::NEG_INFINITY, f64::INFINITY].map(beyond))
            };
            return Some(Chord {
                height,
                rise: steep,
                start: beyond(0.0),
                ends,
            });
        }
        let Part::Convex(convex) = part else {
            return None;
        };
        if convex.as_triangle().is_some() {
            return None;
        }
        let point = Part::Convex(Convex::point(DVec3::ZERO));
        let gap = parts::gap(&point, part, f64::INFINITY, true).ok()??;
        // From where the shape is, far enough to be outside on either side.
        let [center, half] = convex.local_box();
        let size = half.length();
        let center = convex.at.to_world(center);
        let along = center.dot(self.direction);
        let near = NEAR * size;
        let from = |way: DVec3, start: f64| {
            let start = self.direction * start;
            let point = Part::Convex(Convex::point(start));
            let found = parts::first_impact(&point, part, way, 8.0 * size + near, [near; 2]);
            let (distance, there) = found.ok().flatten()?;
            // From a little before it: where the two all but touch, rounding has its way.
            let before = start + way * (distance - BEFORE * size);
            let before = Part::Convex(Convex::point(before));
            let gap = parts::gap(&before, part, f64::INFINITY, false)
                .ok()
                .flatten();
            let gap = gap.filter(|gap| gap.distance > 0.0).unwrap_or(there);
            Some((distance, -gap.normal))
        };
        let far = 2.0 * size + near;
        let enters = from(self.direction, along - far);
        let leaves = from(-self.direction, along + far);
        let ends = enters
            .zip(leaves)
            .map(|((enters, face), (leaves, behind))| {
                [
                    Met::crossing(along - far + enters, face, None),
                    Met::crossing(along + far - leaves, behind, None),
                ]
            });
        let outwards = -gap.normal;
        Some(Chord {
            height: gap.distance,
            rise: outwards.dot(self.direction),
            start: Met {
                face: Some(outwards),
                ..nowhere
            },
            ends,
        })
    }
}

#[cfg(all(test, feature = "rapier"))]
mod tests;
