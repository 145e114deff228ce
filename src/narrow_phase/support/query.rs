//! Whether, where and how deep two shapes meet, part by part, and how far they are apart.

use bevy::math::{DVec3, Vec3, Vec3A, primitives::HalfSpace};

use super::convex::Convex;
use super::foreign::closest_by_itself;
use super::gap::Gap;
use super::mesh_contact;
use super::pairs;
use super::parts::{self, Part};
use super::posed::{PosedShape, posed};
use super::posed_mesh::PosedMesh;
use super::probe::Search;
use crate::narrow_phase::{
    answer::LocalContact,
    composite::voxels::Faces,
    frame::{
        edge_polygon,
        placed::{Placed, PlacedPair, ROUNDING},
        workspace::Workspace,
    },
    settings::NarrowPhase,
    shape::Shape,
};
use crate::octree::Face;

/// A half-space where it is in the world, grown by a margin and by rounding. `None` for other
/// shapes.
pub fn side(placed: Placed, margin: f32) -> Option<HalfSpace> {
    let at = placed.transform;
    let PosedShape::Part(Part::HalfSpace { normal, .. }) = posed(placed, at.translation)? else {
        return None;
    };
    let outwards = normal.as_vec3();
    let grown = margin + ROUNDING * at.translation.abs().element_sum();
    // Bevy's normals point inside.
    Some(HalfSpace::new(
        (-outwards).extend(outwards.dot(at.translation) + grown),
    ))
}

/// Whether two shapes are no further apart than the tolerance. Two of which nothing is known are
/// not, and the workspace keeps it in mind.
pub fn intersects(a: Placed, b: Placed, tolerance: f32, workspace: &mut Workspace) -> bool {
    workspace.known(touch(a, b, tolerance))
}

/// Whether two shapes are no further apart than the tolerance; `None` if nothing can be said about
/// the two.
fn touch(a: Placed, b: Placed, tolerance: f32) -> Option<bool> {
    let tolerance = f64::from(tolerance);
    let search = Search::within(tolerance);
    let mut found = false;
    let origin = a.transform.translation;
    let is_known = pairs::pairs(
        &search,
        &posed(a, origin)?,
        &posed(b, origin)?,
        &mut |a, b| {
            let Ok(gap) = parts::gap(a, b, tolerance, false) else {
                return false;
            };
            if gap.is_some() {
                found = true;
                search.end();
            }
            true
        },
    );
    (found || is_known).then_some(found)
}

/// The contact of two shapes that [touch](intersects), or of which a mesh is around the other: where
/// they are deepest in each other.
pub fn contact(a: Placed, b: Placed, tolerance: f32) -> Option<LocalContact> {
    let tolerance = f64::from(tolerance);
    let origin = a.transform.translation;
    let (a, b) = (posed(a, origin)?, posed(b, origin)?);
    let in_mesh = |other: &PosedShape, mesh: &PosedMesh| {
        deepest_in_mesh(other, mesh, tolerance).or_else(|| match other {
            PosedShape::Part(Part::Convex(convex)) => mesh_contact::from_inside(convex, mesh),
            _ => None,
        })
    };
    let deepest = match (&a, &b) {
        (PosedShape::Mesh(mesh), other) => in_mesh(other, mesh).map(Gap::reversed),
        (other, PosedShape::Mesh(mesh)) => in_mesh(other, mesh),
        _ => deepest(&a, &b, tolerance),
    };
    deepest.map(|gap| LocalContact {
        // What has no extent in some direction, and lies in itself, has no way out.
        normal: gap.normal.as_vec3a().try_normalize().unwrap_or(Vec3A::Y),
        point: gap.between.as_vec3a(),
        depth: (-gap.distance).max(0.0) as f32,
    })
}

/// Where those parts of two shapes meet that are deepest in each other.
fn deepest(a: &PosedShape, b: &PosedShape, tolerance: f64) -> Option<Gap> {
    let search = Search::within(tolerance);
    // What another part would stop counts if nothing else does: in a corner between a floor and a
    // wall that are one, the way out of the part that both join is through all of it.
    let [mut deepest, mut forced] = [None::<Gap>; 2];
    pairs::pairs(&search, a, b, &mut |a, b| {
        let Ok(found) = parts::gap(a, b, tolerance, true) else {
            return false;
        };
        let found = found.and_then(|gap| by_border(gap, a, b));
        let Some((gap, is_forced)) = found else {
            return true;
        };
        let best = if is_forced { &mut forced } else { &mut deepest };
        if best.is_none_or(|best| gap.distance < best.distance) {
            *best = Some(gap);
            // Beside a plane, what is further is less deep.
            if matches!(
                (a, b),
                (Part::HalfSpace { .. }, _) | (_, Part::HalfSpace { .. })
            ) {
                search.margin.set(gap.distance);
            }
        }
        true
    });
    deepest.or(forced)
}

/// The least direction that counts as one to a face of a cuboid.
const TO_FACE: f64 = 1e-3;

/// A gap whose normal leads out of what parts are part of. One that leads into the next part is
/// replaced by the least way out through a face that is one of the whole, and it is told so; `None`
/// if there is none.
fn by_border(gap: Gap, a: &Part, b: &Part) -> Option<(Gap, bool)> {
    let (Part::Convex(a), Part::Convex(b)) = (a, b) else {
        return Some((gap, false));
    };
    if a.faces == Faces::ALL && b.faces == Faces::ALL {
        return Some((gap, false));
    }
    if a.faces != Faces::ALL {
        return out_of(gap, a, b);
    }
    let found = out_of(gap.reversed(), b, a);
    found.map(|(gap, is_forced)| (gap.reversed(), is_forced))
}

/// The gap of a cuboid, of which not all faces bound a solid, and another part; and whether it was
/// replaced.
fn out_of(gap: Gap, cell: &Convex, other: &Convex) -> Option<(Gap, bool)> {
    let way = cell.at.direction_to_local(gap.normal);
    let leads_out = (0..3).all(|axis| {
        way[axis].abs() < TO_FACE
            || cell.faces.iter().any(|face| {
                let out = face.offset().as_dvec3();
                out[axis] * way[axis] > 0.0
            })
    });
    if leads_out {
        return Some((gap, false));
    }
    let by_face = |face: Face| {
        let normal = cell.at.rotation * face.offset().as_dvec3();
        let on_other = other.furthest(-normal) - normal * other.radius;
        let distance = on_other.dot(normal) - cell.furthest(normal).dot(normal);
        Gap {
            distance,
            normal,
            points: [on_other - normal * distance, on_other],
            between: gap.between,
        }
    };
    let ways = cell.faces.iter().map(by_face);
    let least = ways.max_by(|one, other| one.distance.total_cmp(&other.distance));
    least.map(|gap| (gap, true))
}

/// Where that part of a shape meets a mesh of ours that is deepest in it.
fn deepest_in_mesh(shape: &PosedShape, mesh: &PosedMesh, tolerance: f64) -> Option<Gap> {
    match shape {
        PosedShape::Part(Part::Convex(convex)) => mesh_contact::contact(convex, mesh, tolerance),
        PosedShape::Part(Part::HalfSpace { .. }) => {
            deepest(shape, &PosedShape::Mesh(*mesh), tolerance)
        }
        _ => {
            let probe = PosedShape::Mesh(*mesh).probe(shape.isometry(), DVec3::ZERO);
            let mut deepest: Option<Gap> = None;
            shape.each(&probe, &Search::within(tolerance), &mut |part| {
                if let Some(gap) = deepest_in_mesh(part, mesh, tolerance)
                    && deepest.is_none_or(|deepest| gap.distance < deepest.distance)
                {
                    deepest = Some(gap);
                }
                true
            });
            deepest
        }
    }
}

/// The point of a shape that is closest to another; that one itself, if it is inside.
pub fn closest_point(target: Placed, point: Vec3) -> Option<Vec3> {
    let Some(body) = posed(target, point) else {
        return closest_by_itself(target, point);
    };
    let at_point = PosedShape::Part(Part::Convex(Convex::point(DVec3::ZERO)));
    let gap = pairs::nearest(&body, &at_point)?;
    Some(if gap.distance > 0.0 {
        (point.as_dvec3() + gap.points[0]).as_vec3()
    } else {
        point
    })
}

/// The closest points of two shapes, relative to the position of the first: the same one twice, if
/// the two overlap.
pub fn closest_points(a: Placed, b: Placed) -> Option<[Vec3A; 2]> {
    let origin = a.transform.translation;
    let gap = pairs::nearest(&posed(a, origin)?, &posed(b, origin)?)?;
    let points = if gap.distance > 0.0 {
        gap.points
    } else {
        [gap.between; 2]
    };
    Some(points.map(DVec3::as_vec3a))
}

/// A point of a shape, if a mesh is around it, given that the surfaces do not meet: parts of meshes
/// are surfaces, without an inside.
pub fn enclosed(pair: &PlacedPair, workspace: &mut Workspace) -> Option<Vec3A> {
    // The mesh second.
    let pair = match (pair.a.shape, pair.b.shape) {
        (Shape::Mesh(_), Shape::Mesh(_)) => return None,
        (_, Shape::Mesh(mesh)) if mesh.has_inside() => *pair,
        (Shape::Mesh(mesh), _) if mesh.has_inside() => pair.swapped(),
        _ => return None,
    };
    // In the frame of the pair, by way of the centre of the box.
    let inner = posed(pair.a, pair.a.transform.translation)?;
    let [center, _] = inner.local_box()?;
    let at = inner.isometry();
    let mut found = None;
    inner.each_point(&mut |point| {
        let from_center = (point - at.to_world(center)).as_vec3a();
        let point = pair.box_a.center + from_center;
        if found.is_none()
            && (pair.box_b.axes.transpose() * (point - pair.box_b.center))
                .abs()
                .cmple(pair.box_b.half)
                .all()
            && edge_polygon::encloses(&pair, point, workspace)
        {
            found = Some(point);
        }
    });
    found
}

/// Whether there is an answer to where two shapes meet.
pub fn is_known(a: Placed, b: Placed) -> bool {
    touch(a, b, NarrowPhase::DEFAULT_TOLERANCE).is_some()
}

#[cfg(all(test, feature = "rapier"))]
pub mod tests;
