//! Where shapes lie on each other that are known by their support functions, or taken apart: what
//! of each two parts faces the other along the contact's normal, one cut to the other.
//!
//! A face takes what is over it: of another face the corners of what they share, of an edge its two
//! ends, of a point itself. Of two edges side by side, the longer one takes what is beside it.

use bevy::math::{DVec3, Vec3A};
use smallvec::SmallVec;

use super::patch::Patch;
use crate::narrow_phase::{
    answer::Contact,
    frame::{closest, placed::Placed},
    support::{self, Feature, FeatureKind, NearPart, each_two},
};

/// The cosine of the angle up to which a face or an edge lies flat along the contact's normal.
const ALIKE: f64 = 0.985;
/// How much flatter one of two faces has to be for the other to be cut to it: the difference of two
/// such cosines, of which more than a hundredth of a degree apart.
const EVEN: f64 = 1e-8;
/// The sine of the angle up to which two edges are side by side.
const PARALLEL: f64 = 0.05;
/// How much deeper than the contact two parts may be along its normal, as a share of its depth. What
/// is further in meets on some other side.
const DEEPER: f64 = 0.02;

/// How the points in a [`Patch`] are to the world: from the contact's point, and at which scale, so
/// that no size is too large or too small for 32-bit floats.
pub struct Measure {
    /// What counts as one.
    pub unit: f32,
    /// The size of the smaller shape, in that.
    pub size: f32,
}

/// Puts the points at which two shapes lie on each other into a patch; `None` if nothing can be said
/// about one of them.
pub fn gather(
    a: Placed,
    b: Placed,
    contact: &Contact,
    tolerance: f32,
    patch: &mut Patch,
) -> Option<Measure> {
    patch.clear();
    let normal = contact.normal.as_dvec3().try_normalize()?;
    let origin = contact.point;
    let size = support::smaller_size(a, b, origin)?;
    let unit = power_of_two(size);
    let mut laying = Laying {
        normal,
        unit,
        tolerance: f64::from(tolerance),
        depth: f64::from(contact.depth),
        patch,
    };
    each_two(a, b, origin, f64::from(tolerance), &mut |one, other| {
        laying.lay(one, other);
    });
    Some(Measure {
        unit: unit as f32,
        size: (size / unit) as f32,
    })
}

/// The power of two next below a size; 1 for none.
fn power_of_two(size: f64) -> f64 {
    let power = f64::from_bits(size.to_bits() & f64::INFINITY.to_bits());
    if power.is_normal() { power } else { 1.0 }
}

struct Laying<'a> {
    normal: DVec3,
    unit: f64,
    tolerance: f64,
    /// Of the contact.
    depth: f64,
    patch: &'a mut Patch,
}

impl Laying<'_> {
    /// Takes up where one part lies on another.
    fn lay(&mut self, a: &NearPart, b: &NearPart) {
        let normal = self.normal;
        let (Some(on_a), Some(on_b)) = (a.feature(normal), b.feature(-normal)) else {
            return;
        };
        let flat = |feature: &Feature| feature.flatness().filter(|flatness| *flatness >= ALIKE);
        match (flat(&on_a), flat(&on_b)) {
            (None, None) => self.beside((a, &on_a.edge()), (b, &on_b.edge())),
            (Some(_), None) => self.cut(&on_a, &on_b, normal),
            (None, Some(_)) => self.cut(&on_b, &on_a, -normal),
            (Some(flat_a), Some(flat_b)) => {
                let is_even = (flat_a - flat_b).abs() <= EVEN;
                // Numbers of something small are more exact.
                if if is_even {
                    on_a.size() >= on_b.size()
                } else {
                    flat_a > flat_b
                } {
                    self.cut(&on_a, &on_b, normal);
                } else {
                    self.cut(&on_b, &on_a, -normal);
                }
            }
        }
    }

    /// Takes up what of one feature is over another, which is on the near side of it along an axis.
    fn cut(&mut self, under: &Feature, over: &Feature, axis: DVec3) {
        if over.kind == FeatureKind::Plane {
            return;
        }
        let unit = self.unit;
        let small = |point: DVec3| (point / unit).as_vec3a();
        let patch = &mut *self.patch;
        patch.piece.clear();
        patch.piece.extend(over.points().map(small));
        let up = axis.as_vec3a();
        match under.kind {
            FeatureKind::Plane | FeatureKind::Point => {}
            FeatureKind::Face => {
                let border: SmallVec<[Vec3A; 8]> = under.border().map(small).collect();
                patch.cut_to(&border, up);
            }
            FeatureKind::Edge => {
                if let [Some(from), Some(to)] = ends(under).map(|end| end.map(small)) {
                    let along = to - from;
                    patch.cut(along, to.dot(along));
                    patch.cut(-along, -from.dot(along));
                }
            }
        }
        let (offset, normal) = (under.offset() / unit, under.normal);
        let along = normal.dot(axis);
        let (offset, normal) = ((offset / along) as f32, (normal / along).as_vec3a());
        let deep = |point: Vec3A| offset - point.dot(normal);
        let (depth, tolerance) = (self.depth / unit, self.tolerance / unit);
        let most = (depth * (1.0 + DEEPER) + tolerance) as f32;
        if patch.piece.iter().all(|point| deep(*point) <= most) {
            patch.add_up_to(depth as f32, up, tolerance as f32, deep);
        }
    }

    /// Takes up what of two edges or points, of which none is part of a flat face, is at one place.
    fn beside(&mut self, (a, on_a): (&NearPart, &Feature), (b, on_b): (&NearPart, &Feature)) {
        let known = self.patch.points.len();
        let normal = self.normal;
        match (direction(on_a), direction(on_b)) {
            (Some(one), Some(other)) if one.cross(other).length() > PARALLEL => {
                self.cross(on_a, on_b);
            }
            (Some(_), None) => self.cut(on_a, on_b, normal),
            (None, Some(_)) => self.cut(on_b, on_a, -normal),
            _ if on_a.size() >= on_b.size() => self.cut(on_a, on_b, normal),
            _ => self.cut(on_b, on_a, -normal),
        }
        // Surfaces that are round fall off beside an edge.
        let (unit, tolerance) = (self.unit, 2.0 * self.tolerance);
        let is_in = |part: &NearPart, point: Vec3A| {
            part.reaches(point.as_dvec3() * unit, tolerance)
        };
        let mut index = 0;
        self.patch.points.retain(|point| {
            index += 1;
            index <= known || (is_in(a, point.point) && is_in(b, point.point))
        });
    }

    /// Takes up the point where two edges cross.
    fn cross(&mut self, on_a: &Feature, on_b: &Feature) {
        let small = |point: DVec3| (point / self.unit).as_vec3a();
        let ends = [on_a, on_b].map(|edge| ends(edge).map(|end| end.map_or(Vec3A::ZERO, small)));
        let (on_a, on_b) = closest::segments(ends[0], ends[1]);
        let deep = (on_a - on_b).dot(self.normal.as_vec3a());
        let (depth, tolerance) = (self.depth / self.unit, self.tolerance / self.unit);
        if deep >= -tolerance as f32 && f64::from(deep) <= depth * (1.0 + DEEPER) + tolerance {
            self.patch.add_point(on_a.midpoint(on_b), deep.min(depth as f32));
        }
    }
}

/// The two ends of an edge.
fn ends(edge: &Feature) -> [Option<DVec3>; 2] {
    let mut ends = edge.border();
    [ends.next(), ends.next()]
}

/// The direction of an edge; `None` for a point.
fn direction(edge: &Feature) -> Option<DVec3> {
    let [from, to] = ends(edge);
    (to? - from?).try_normalize()
}

#[cfg(test)]
mod tests;
