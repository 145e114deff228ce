//! Where shapes lie on each other that are known by their support functions, or taken apart: what
//! of each two parts faces the other along the contact's normal, one cut to the other.
//!
//! A face takes what is over it: of another face the corners of what they share, of an edge its two
//! ends, of a point itself. Of two edges side by side, the longer one takes what is beside it.

use bevy::math::{DVec3, Vec3A};
use smallvec::SmallVec;

use super::{
    flush::{Flush, Lying},
    patch::{Patch, PatchPoint},
};
use crate::narrow_phase::{
    answer::Contact,
    frame::{closest, placed::Placed},
    support::{self, Feature, FeatureKind, NearPart, each_two},
};

/// The cosine of the angle up to which a face or an edge lies flat along the contact's normal.
const ALIKE: f64 = 0.985;
/// How much flatter one of two faces has to be for the other to be cut to it, by the cosines: those
/// of nothing and of a hundredth of a degree differ by this.
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
    (a, b): (Placed, Placed),
    contact: &Contact,
    tolerance: f32,
    (patch, flush): (&mut Patch, &mut Flush),
) -> Option<Measure> {
    patch.clear();
    flush.clear();
    let normal = contact.normal.as_dvec3().try_normalize()?;
    let origin = contact.point;
    let size = support::smaller_size(a, b, origin)?;
    let unit = power_of_two(size);
    let tolerance = f64::from(tolerance);
    let mut laying = Laying {
        normal,
        unit,
        tolerance: tolerance / unit,
        depth: f64::from(contact.depth) / unit,
        patch,
        flush,
    };
    each_two(a, b, origin, tolerance, &mut |one, other| {
        laying.lay(one, other);
    });
    flush.gather((tolerance / unit) as f32, patch);
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

/// Lengths are in units, but for those of features.
struct Laying<'a> {
    normal: DVec3,
    unit: f64,
    tolerance: f64,
    /// Of the contact.
    depth: f64,
    patch: &'a mut Patch,
    flush: &'a mut Flush,
}

impl Laying<'_> {
    /// Takes up where one part lies on another.
    fn lay(&mut self, a: &NearPart, b: &NearPart) {
        let normal = self.normal;
        let (Some(on_a), Some(on_b)) = (a.feature(normal), b.feature(-normal)) else {
            return;
        };
        let flat = |feature: &Feature| feature.flatness().filter(|flatness| *flatness >= ALIKE);
        let is_under = match (flat(&on_a), flat(&on_b)) {
            (None, None) => return self.beside((a, &on_a.edge()), (b, &on_b.edge())),
            (Some(flat_a), Some(flat_b)) if (flat_a - flat_b).abs() > EVEN => flat_a > flat_b,
            // Numbers of something small are more exact.
            (Some(_), Some(_)) => on_a.size() >= on_b.size(),
            (flat_a, _) => flat_a.is_some(),
        };
        if is_under {
            self.cut(&on_a, &on_b, normal, None);
        } else {
            self.cut(&on_b, &on_a, -normal, None);
        }
    }

    /// Takes up what of two edges or points, of which none is part of a flat face, is at one place.
    fn beside(&mut self, (a, on_a): (&NearPart, &Feature), (b, on_b): (&NearPart, &Feature)) {
        let is_under = match (direction(on_a), direction(on_b)) {
            (Some(one), Some(other)) if one.cross(other).length() > PARALLEL => {
                return self.cross(on_a, on_b);
            }
            (Some(_), Some(_)) => on_a.size() >= on_b.size(),
            (of_a, _) => of_a.is_some(),
        };
        if is_under {
            self.cut(on_a, on_b, self.normal, Some(a));
        } else {
            self.cut(on_b, on_a, -self.normal, Some(b));
        }
    }

    /// Takes up what of one feature is over another, which is on the near side of it along an axis.
    /// Beside an edge, where a surface falls off, only what is in the part that has it.
    fn cut(&mut self, under: &Feature, over: &Feature, axis: DVec3, part: Option<&NearPart>) {
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
                let [from, to] = ends(under).map(small);
                let along = to - from;
                patch.cut(along, to.dot(along));
                patch.cut(-along, -from.dot(along));
            }
        }
        let (offset, normal) = (under.offset() / unit, under.normal);
        let along = normal.dot(axis);
        let (plane, slope) = ((offset / along) as f32, (normal / along).as_vec3a());
        let deep = |point: Vec3A| plane - point.dot(slope);
        let most = (self.depth * (1.0 + DEEPER) + self.tolerance) as f32;
        if patch.piece.iter().any(|point| deep(*point) > most) {
            return;
        }
        let lying = Lying {
            normal,
            offset,
            over: over.first_two(),
        };
        let depth = self.depth as f32;
        let halfway = |point: &Vec3A| {
            let deep = deep(*point);
            let (point, depth) = (*point + up * (deep * 0.5), deep.min(depth));
            PatchPoint { point, depth }
        };
        let lengths = [unit, self.tolerance];
        let is_there = |found: &PatchPoint| {
            part.is_none_or(|part| is_below(part, found.point, found.depth, lengths))
        };
        let piece = patch.piece.iter().map(halfway).filter(is_there);
        self.flush
            .add(lying, self.tolerance, self.normal.as_vec3a(), piece);
    }

    /// Takes up the point where two edges cross, if the way from one to the other is along the normal.
    fn cross(&mut self, on_a: &Feature, on_b: &Feature) {
        let small = |point: DVec3| (point / self.unit).as_vec3a();
        let [one, other] = [on_a, on_b].map(|edge| ends(edge).map(small));
        let (one, other) = closest::segments(one, other);
        let deep = (one - other).dot(self.normal.as_vec3a());
        let (depth, apart) = (f64::from(deep), f64::from(one.distance(other)));
        let most = self.depth * (1.0 + DEEPER) + self.tolerance;
        let is_along = apart <= depth.abs() * (1.0 + DEEPER) + self.tolerance;
        if is_along && depth >= -self.tolerance && depth <= most {
            let halfway = one.midpoint(other);
            self.patch.add_point(halfway, deep.min(self.depth as f32));
        }
    }
}

/// Is a point halfway between the surface of a part and one that is below it by a depth? Not beside
/// an edge, where the surface is further down.
fn is_below(part: &NearPart, halfway: Vec3A, depth: f32, [unit, tolerance]: [f64; 2]) -> bool {
    let limit = tolerance + 0.5 * f64::from(depth).max(0.0);
    part.reaches(halfway.as_dvec3() * unit, limit * unit)
}

/// The two ends of an edge; of a point, itself.
fn ends(edge: &Feature) -> [DVec3; 2] {
    let mut ends = edge.border();
    let first = ends.next().unwrap_or(DVec3::ZERO);
    [first, ends.next().unwrap_or(first)]
}

/// The direction of an edge; `None` for a point.
fn direction(edge: &Feature) -> Option<DVec3> {
    let [from, to] = ends(edge);
    (to - from).try_normalize()
}

#[cfg(test)]
mod tests;
