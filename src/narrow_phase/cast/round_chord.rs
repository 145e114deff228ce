//! The lines of rays and round solids: capsules, cylinders, cones and their frusta.

use bevy::math::DVec3;

use super::local_ray::LocalRay;
use crate::narrow_phase::frame::chord::{Chord, Met};

/// The square of a direction across the axis that counts as none, as a share of the whole.
const ALONG_AXIS: f64 = 1e-24;

/// A part of a line, by where its ends are.
type Span = [f64; 2];

const LINE: Span = [f64::NEG_INFINITY, f64::INFINITY];

fn common(a: Span, b: Span) -> Option<Span> {
    let span = [a[0].max(b[0]), a[1].min(b[1])];
    (span[0] <= span[1]).then_some(span)
}

/// A face that the ray may start on: how high over it, its normal.
struct Start {
    height: f64,
    normal: DVec3,
}

impl LocalRay {
    /// That of a frustum of a cone around the second axis.
    pub fn chord_of_frustum(&self, [bottom, top, half]: [f64; 3]) -> Chord {
        // How fast the radius grows with the height.
        let growth = if half > 0.0 {
            (top - bottom) / (2.0 * half)
        } else {
            0.0
        };
        let radius_at = |y: f64| {
            let share = if half > 0.0 { y / half } else { 0.0 };
            let middle = 0.5 * (top + bottom);
            if half > 0.0 {
                middle + 0.5 * (top - bottom) * share
            } else {
                top.max(bottom)
            }
        };
        let outwards = |point: DVec3| {
            let across = point.with_y(0.0).try_normalize().unwrap_or(DVec3::X);
            across.with_y(-growth)
        };
        let span = self
            .between_caps(half)
            .and_then(|caps| common(caps, self.in_cone(growth, radius_at(self.origin.y), caps)?));
        let across = self.origin.with_y(0.0).length();
        let faces = [DVec3::Y, -DVec3::Y]
            .map(|normal| Start {
                height: normal.y * self.origin.y - half,
                normal,
            })
            .into_iter()
            .chain([Start {
                height: across - radius_at(self.origin.y),
                normal: outwards(self.origin),
            }]);
        // Of an end, the face that it is on: a cap, but for its rim.
        let face_at = |distance: f64, way: f64| {
            let point = self.origin + self.direction * distance;
            let over_cap = point.y.abs() - half;
            let over_side = point.with_y(0.0).length() - radius_at(point.y);
            let goes_through_cap = self.direction.y * point.y * way < 0.0;
            if over_cap >= over_side && goes_through_cap {
                DVec3::Y * point.y.signum()
            } else {
                outwards(point)
            }
        };
        let ends = span.map(|[enters, leaves]| {
            [
                Met::crossing(enters, face_at(enters, 1.0), None),
                Met::crossing(leaves, face_at(leaves, -1.0), None),
            ]
        });
        self.chord_of(faces, ends)
    }

    /// That of a capsule along the second axis.
    pub fn chord_of_capsule(&self, radius: f64, half_length: f64) -> Chord {
        let on_axis = |point: DVec3| DVec3::Y * point.y.clamp(-half_length, half_length);
        let outwards = |point: DVec3| (point - on_axis(point)).try_normalize().unwrap_or(DVec3::X);
        let face = Start {
            height: (self.origin - on_axis(self.origin)).length() - radius,
            normal: outwards(self.origin),
        };
        let end = |distance: f64| {
            let point = self.origin + self.direction * distance;
            Met::crossing(distance, outwards(point), None)
        };
        let ends = self
            .in_capsule(radius, half_length)
            .map(|span| span.map(end));
        self.chord_of([face].into_iter(), ends)
    }

    fn chord_of(&self, faces: impl Iterator<Item = Start>, ends: Option<[Met; 2]>) -> Chord {
        let mut chord = Chord {
            height: f64::NEG_INFINITY,
            rise: f64::NEG_INFINITY,
            start: Met::crossing(0.0, DVec3::ZERO, None),
            ends,
        };
        for Start { height, normal } in faces {
            let height = self.height(height, normal);
            let rise = self.height(normal.dot(self.direction), normal);
            chord.height = chord.height.max(height);
            if height.abs() <= self.slack && rise > chord.rise {
                (chord.rise, chord.start) = (rise, Met::crossing(0.0, normal, None));
            }
        }
        chord
    }

    /// Where the line is between two planes across the second axis.
    fn between_caps(&self, half: f64) -> Option<Span> {
        let (y, climb) = (self.origin.y, self.direction.y);
        if climb == 0.0 {
            return (y.abs() <= half).then_some(LINE);
        }
        let [one, other] = [(-half - y) / climb, (half - y) / climb];
        Some([one.min(other), one.max(other)])
    }

    /// Where the line is within a cone, which is as wide as `radius` where the ray starts. Between
    /// the caps alone; beyond the tip is another cone.
    fn in_cone(&self, growth: f64, radius: f64, caps: Span) -> Option<Span> {
        let (o, d) = (self.origin, self.direction);
        let rate = growth * d.y;
        let a = d.x * d.x + d.z * d.z - rate * rate;
        let b = o.x * d.x + o.z * d.z - rate * radius;
        let c = o.x * o.x + o.z * o.z - radius * radius;
        if a.abs() <= ALONG_AXIS * d.length_squared() {
            // Along the side of it.
            let crossing = -c / (2.0 * b);
            return if b == 0.0 {
                (c <= 0.0).then_some(LINE)
            } else if b > 0.0 {
                Some([f64::NEG_INFINITY, crossing])
            } else {
                Some([crossing, f64::INFINITY])
            };
        }
        let room = b * b - a * c;
        if room < 0.0 {
            return (a < 0.0).then_some(LINE);
        }
        // Without the cancellation of two numbers that are nearly equal.
        let sum = -(b + room.sqrt().copysign(b));
        let (one, other) = (sum / a, if sum == 0.0 { 0.0 } else { c / sum });
        let [low, high] = [one.min(other), one.max(other)];
        if a > 0.0 {
            return Some([low, high]);
        }
        // Steeper than the side: on one of the two cones before, on the other after. That between
        // the caps is ours.
        let before = common([f64::NEG_INFINITY, low], caps);
        let after = common([high, f64::INFINITY], caps);
        let length = |span: Option<Span>| span.map_or(-1.0, |[from, to]| to - from);
        if length(before) >= length(after) {
            before
        } else {
            after
        }
    }

    fn in_capsule(&self, radius: f64, half_length: f64) -> Option<Span> {
        let (o, d) = (self.origin, self.direction);
        let in_ball = |center: f64| {
            let from = o - DVec3::Y * center;
            let (squared, along) = (d.length_squared(), -from.dot(d));
            let closest = from + d * (along / squared);
            let room = radius * radius - closest.length_squared();
            let half = (room.max(0.0) * squared).sqrt();
            (room >= 0.0).then(|| [(along - half) / squared, (along + half) / squared])
        };
        let squared = d.x * d.x + d.z * d.z;
        if squared <= ALONG_AXIS * d.length_squared() {
            let [low, high] = [in_ball(-half_length)?, in_ball(half_length)?];
            return Some([low[0].min(high[0]), low[1].max(high[1])]);
        }
        let along = -(o.x * d.x + o.z * d.z) / squared;
        let closest = o + d * along;
        let room = radius * radius - closest.with_y(0.0).length_squared();
        if room < 0.0 {
            return None;
        }
        let half = (room / squared).sqrt();
        // Beyond the segment, the round end counts.
        let end = |distance: f64, which: usize| {
            let y = o.y + d.y * distance;
            if y.abs() <= half_length {
                Some(distance)
            } else {
                Some(in_ball(half_length.copysign(y))?[which])
            }
        };
        let (enters, leaves) = (end(along - half, 0), end(along + half, 1));
        match (enters, leaves) {
            (Some(enters), Some(leaves)) => Some([enters, leaves]),
            _ => None,
        }
    }
}
