//! Each two parts of two shapes that are near each other, and what of them lies on what.

use bevy::math::{DVec3, Vec3};

use super::convex::{Convex, Isometry, feature::Feature};
use super::parts::{self, Part};
use super::posed::{PosedShape, posed};
use super::probe::{Probe, Search};
use crate::narrow_phase::frame::placed::Placed;

/// A part of one of two shapes.
pub struct NearPart<'a> {
    part: Part<'a>,
    /// Is it a triangle that has a solid behind it?
    is_one_sided: bool,
}

impl NearPart<'_> {
    /// What of it is furthest along a unit vector. `None` if that is not the border of what it is
    /// part of.
    pub fn feature(&self, towards: DVec3) -> Option<Feature> {
        match self.part {
            Part::Convex(convex) => {
                let is_behind = || self.part.face().is_some_and(|up| up.dot(towards) <= 0.0);
                if self.is_one_sided && is_behind() {
                    return None;
                }
                convex.feature(towards)
            }
            Part::HalfSpace { normal, offset } => Some(Feature::plane(normal, offset)),
        }
    }

    /// Is a point no further away than a limit?
    pub fn reaches(&self, point: DVec3, limit: f64) -> bool {
        let point = Part::Convex(Convex::point(point));
        parts::gap(&self.part, &point, limit, false).is_ok_and(|gap| gap.is_some())
    }
}

/// Calls `visit` with each two parts of two shapes whose boxes are no further apart than a margin,
/// all relative to an origin. None if nothing can be said about one of the two.
pub fn each_two(
    a: Placed,
    b: Placed,
    origin: Vec3,
    margin: f64,
    visit: &mut dyn FnMut(&NearPart, &NearPart),
) {
    if let (Some(a), Some(b)) = (posed(a, origin), posed(b, origin)) {
        each_pair(&Search::within(margin), (&a, false), (&b, false), visit);
    }
}

/// The size of the smaller of two shapes, half the diagonal of its box; `None` if nothing can be
/// said about one of the two.
pub fn smaller_size(a: Placed, b: Placed, origin: Vec3) -> Option<f64> {
    let sizes = [posed(a, origin)?.size(), posed(b, origin)?.size()];
    Some(sizes[0].min(sizes[1]))
}

/// The same, of two of which it is known whether there is a solid behind them.
fn each_pair(
    search: &Search,
    (a, a_has_back): (&PosedShape, bool),
    (b, b_has_back): (&PosedShape, bool),
    visit: &mut dyn FnMut(&NearPart, &NearPart),
) {
    match (a, b) {
        (PosedShape::Part(one), PosedShape::Part(other)) => {
            let [one, other] =
                [(one, a_has_back), (other, b_has_back)].map(|(part, is_one_sided)| NearPart {
                    part: *part,
                    is_one_sided,
                });
            visit(&one, &other);
        }
        // A mesh of ours is searched for each part of the other.
        (PosedShape::Part(_), _)
        | (PosedShape::Mesh(_), PosedShape::Foreign(_) | PosedShape::Composite { .. }) => {
            let probe = a.probe(b.isometry(), DVec3::ZERO);
            each_part(b, &probe, search, &mut |part, has_back| {
                each_pair(search, (a, a_has_back), (part, has_back), visit);
            });
        }
        _ => {
            let probe = b.probe(a.isometry(), DVec3::ZERO);
            each_part(a, &probe, search, &mut |part, has_back| {
                each_pair(search, (part, has_back), (b, b_has_back), visit);
            });
        }
    }
}

/// Calls `visit` with all parts of a shape that a probe admits, and whether there is a solid behind
/// them.
fn each_part(
    shape: &PosedShape,
    probe: &Probe,
    search: &Search,
    visit: &mut dyn FnMut(&PosedShape, bool),
) {
    let PosedShape::Mesh(mesh) = shape else {
        shape.each(probe, search, &mut |part| {
            visit(part, false);
            true
        });
        return;
    };
    mesh.each(probe, search, &mut |polygon, corners| {
        let part = Convex::triangle(corners, 0.0, Isometry::IDENTITY);
        let is_solid = mesh.mesh.bounds_solid(polygon as usize);
        visit(&PosedShape::Part(Part::Convex(part)), is_solid);
    });
}
