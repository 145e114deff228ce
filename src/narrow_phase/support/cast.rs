//! Rays and shapes on their way, part by part.

use std::cell::Cell;

use bevy::math::{DVec3, Dir3, Vec3};

use super::convex::Convex;
use super::foreign::ray_by_itself;
use super::gap::Gap;
use super::pairs;
use super::parts::{self, Part};
use super::posed::{PosedShape, posed};
use super::probe::Search;
use crate::narrow_phase::{
    answer::{Impact, against, slack},
    frame::placed::Placed,
};

/// How near something on its way comes to what it is going to touch before the rest is taken as
/// straight, as a share of the sizes of both.
const NEAR: f64 = 1e-7;

/// Where a ray meets a shape. Solids are solid.
pub fn cast_ray(
    target: Placed,
    origin: Vec3,
    direction: Dir3,
    max_distance: f32,
) -> Option<Impact> {
    let Some(body) = posed(target, origin) else {
        return ray_by_itself(target, origin, direction, max_distance, true);
    };
    let ray = PosedShape::Part(Part::Convex(Convex::point(DVec3::ZERO)));
    let from_shape = origin.as_dvec3() - target.transform.translation.as_dvec3();
    impact(
        &ray,
        (origin, slack(origin, from_shape)),
        direction,
        max_distance,
        &body,
    )
}

/// Where a shape on its way meets another that it does not touch at the start.
pub fn sweep(moving: Placed, direction: Dir3, max_distance: f32, target: Placed) -> Option<Impact> {
    let origin = moving.transform.translation;
    impact(
        &posed(moving, origin)?,
        (origin, 0.0),
        direction,
        max_distance,
        &posed(target, origin)?,
    )
}

/// Where a body on its way meets another. Both are given relative to an origin, beside which is how
/// far apart two may be at the start and count as touching.
fn impact(
    moving: &PosedShape,
    (origin, touching): (Vec3, f64),
    direction: Dir3,
    max_distance: f32,
    target: &PosedShape,
) -> Option<Impact> {
    let way = direction.as_dvec3();
    let sizes = [moving, target]
        .map(PosedShape::size)
        .into_iter()
        .filter(|size| size.is_finite());
    let near = NEAR * sizes.sum::<f64>();
    let search = Search {
        direction: way,
        limit: Cell::new(max_distance.into()),
        ..Search::within(near.max(touching))
    };
    let mut first: Option<(f64, Gap)> = None;
    let (mut face, mut triangle) = (None, None);
    let has_triangles = target.has_triangles();
    pairs::pairs(&search, moving, target, &mut |a, b| {
        let Ok(found) =
            parts::first_impact(a, b, way, search.limit.get(), [near.max(touching), near])
        else {
            return false;
        };
        if let Some((distance, _)) =
            found.filter(|found| first.is_none_or(|first| found.0 < first.0))
        {
            search.limit.set(distance);
            first = found;
            face = b.face();
            triangle = search.triangle.get().filter(|_| has_triangles);
        }
        true
    });
    let (distance, gap) = first?;
    let normal = if distance > 0.0 {
        -gap.normal.as_vec3()
    } else {
        -*direction
    };
    // What overlaps at the start meets where both are: a ray from inside, where it starts.
    let met = if gap.distance < 0.0 {
        gap.between
    } else {
        gap.points[1]
    };
    let point = (origin.as_dvec3() + met).as_vec3();
    let (distance, normal) = (distance as f32, against(normal, direction));
    (distance.is_finite() && point.is_finite()).then_some(Impact {
        distance,
        point,
        normal,
        face_normal: face.map_or(normal, DVec3::as_vec3),
        polygon: triangle,
        depth: 0.0,
    })
}

#[cfg(all(test, feature = "rapier"))]
mod tests;
