//! Shapes on their way against others at rest: the first time of impact, solved for rather than
//! approached by steps.

use bevy::math::{Dir3, Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::{
    first_impact::{FirstImpact, LocalImpact},
    parting_planes::{self, Answer},
};
use crate::narrow_phase::{
    answer::{Contact, Impact},
    cores::Balls,
    error::BoundsError,
    frame::{
        case::Case,
        oriented_box::OrientedBox,
        placed::{Placed, PlacedPair},
        smaller::{Smaller, unit},
        workspace::Workspace,
    },
    settings::NarrowPhase,
    support,
};

impl NarrowPhase {
    /// Casts a shape that moves without turning against another: returns where it first meets it,
    /// if it does so within `max_distance`.
    ///
    /// Exact for every kind of shape, up to the rounding of 32-bit floats, and as exact after a
    /// long way as after a short one. Shapes [in contact](Self::intersects) at the start meet at
    /// once, whichever way they go. Those that only graze each other, closer than the tolerance,
    /// may count as meeting or not. `None` too if anything is not finite, but for `max_distance`,
    /// or that is negative or NaN.
    ///
    /// Two spheres: O(1); a sphere or a cuboid and a mesh: O(log n) for each polygon that comes into
    /// question, which is what the box of the moving shape meets before the shape meets anything;
    /// two meshes: the same for each two polygons. Of shapes of a few polygons, cuboids included,
    /// each two edges are looked at. Allocates nothing once the workspace is warm.
    ///
    /// ```
    /// use bevy::{math::{Dir3, Vec3}, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
    ///
    /// let (brick, ball) = (Shape::cuboid(2.0, 2.0, 2.0), Shape::sphere(0.5));
    /// let (here, there) = (Transform::IDENTITY, Transform::from_xyz(8.0, 0.0, 0.0));
    /// let (moving, target) = (Placed::new(&ball, &here), Placed::new(&brick, &there));
    /// let hit = NarrowPhase::default().sweep(moving, Dir3::X, 10.0, target, &mut Workspace::default()).unwrap();
    /// assert_eq!((hit.distance, hit.point, hit.normal), (6.5, Vec3::X * 7.0, Vec3::NEG_X));
    /// ```
    #[doc(alias = "shapecast")]
    #[doc(alias = "cast_shape")]
    #[doc(alias = "ccd")]
    #[must_use]
    pub fn sweep(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        target: Placed,
        workspace: &mut Workspace,
    ) -> Option<Impact> {
        self.sweep_from(false, moving, direction, max_distance, target, workspace)
    }

    /// The same, of two of which it may be known that they are not in contact at the start.
    pub(super) fn sweep_from(
        &self,
        are_apart: bool,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        target: Placed,
        workspace: &mut Workspace,
    ) -> Option<Impact> {
        if !(max_distance >= 0.0 && direction.is_finite()) {
            return None;
        }
        if let Some(impact) = support::with_own(moving, target, |a, b| {
            self.sweep_from(are_apart, a, direction, max_distance, b, workspace)
        }) {
            return impact;
        }
        if !are_apart && let Some(contact) = self.contact(moving, target, workspace) {
            return Some(at_the_start(&contact, direction));
        }
        if let Some(found) = Balls::of(moving, target) {
            let radii = found.nearest.radii;
            return balls(moving, direction, max_distance, target, radii);
        }
        match PlacedPair::new(moving, target, self.tolerance()) {
            Ok(pair) if !matches!(pair.case(), Case::Parts | Case::Foreign) => {
                self.sweep_apart(&pair, direction, max_distance, workspace)
            }
            Ok(_) | Err(BoundsError::Unbounded) => {
                support::sweep(moving, direction, max_distance, target)
            }
            Err(BoundsError::NonFinite) => None,
        }
    }

    /// Two shapes of ours that are apart, the moving one first.
    fn sweep_apart(
        &self,
        pair: &PlacedPair,
        direction: Dir3,
        max_distance: f32,
        workspace: &mut Workspace,
    ) -> Option<Impact> {
        // Up to where their bounding spheres touch: what follows is as exact after a long way as
        // after a short one.
        let (free, nearer) =
            nearer(pair, direction).filter(|(free, _)| *free <= f64::from(max_distance))?;
        let left = (f64::from(max_distance) - free) as f32;
        let in_all = |rest: f32| (free + f64::from(rest)) as f32;
        // Relative to the target, so that neither position costs exactness.
        let (origin, moving) = (
            pair.b.transform.translation,
            Placed::new(pair.a.shape, &nearer),
        );
        let here = Transform {
            translation: Vec3::ZERO,
            ..*pair.b.transform
        };
        let target = Placed::new(pair.b.shape, &here);
        let pair = PlacedPair::new(moving, target, self.tolerance()).ok()?;
        if pair.is_large()
            && let Some(smaller) = Smaller::of(&pair, self)
        {
            let ([moving, target], factor) = (smaller.placed(&pair), smaller.factor);
            let found = smaller
                .tests
                .sweep(moving, direction, left / factor, target, workspace)?;
            return Some(Impact {
                distance: in_all(found.distance * factor),
                point: origin + found.point * factor,
                normal: unit(found.normal),
                face_normal: unit(found.face_normal),
                ..found
            });
        }
        let found = first_impact(&pair, (*direction).into(), left, workspace)?;
        Some(Impact {
            distance: in_all(found.distance),
            point: origin + nearer.translation + Vec3::from(found.point),
            normal: found.normal.into(),
            face_normal: found.normal.into(),
            polygon: None,
            depth: 0.0,
        })
    }
}

/// The impact of two that are in contact before the first has moved.
fn at_the_start(contact: &Contact, direction: Dir3) -> Impact {
    let normal = -contact.normal;
    Impact {
        distance: 0.0,
        point: contact.point,
        normal: if normal.dot(*direction) > 0.0 {
            -*direction
        } else {
            normal
        },
        face_normal: normal,
        polygon: None,
        depth: contact.depth,
    }
}

/// The first impact of two balls that are apart.
fn balls(
    moving: Placed,
    direction: Dir3,
    max_distance: f32,
    target: Placed,
    [radius, target_radius]: [f32; 2],
) -> Option<Impact> {
    let (way, reach) = (direction.as_dvec3(), f64::from(radius + target_radius));
    let [from, to] = [moving, target].map(|placed| placed.transform.translation.as_dvec3());
    let (offset, squared) = (to - from, way.length_squared());
    let along = offset.dot(way) / squared;
    let aside = offset - way * along;
    let room = reach * reach - aside.length_squared();
    // Ahead, or just left behind by rounding.
    if !(room >= 0.0 && along >= 0.0) {
        return None;
    }
    let distance = (along - (room / squared).sqrt()).max(0.0);
    let normal = (way * distance - offset).try_normalize()?.as_vec3();
    let distance = distance as f32;
    (distance <= max_distance).then(|| Impact {
        distance,
        point: target.transform.translation + normal * target_radius,
        normal,
        face_normal: normal,
        polygon: None,
        depth: 0.0,
    })
}

/// Where the first of two, on its way, meets the second, in the frame of the pair.
fn first_impact(
    pair: &PlacedPair,
    direction: Vec3A,
    limit: f32,
    workspace: &mut Workspace,
) -> Option<LocalImpact> {
    let first = FirstImpact::new(direction, limit);
    match pair.case() {
        Case::Spheres => first.of_spheres(pair),
        Case::SphereFirst => first.of_sphere(pair, workspace),
        // As seen from the moving shape, the ball comes to it.
        Case::SphereSecond => {
            let met = FirstImpact::new(-direction, limit).of_sphere(&pair.swapped(), workspace)?;
            Some(met.reversed(direction))
        }
        Case::Cuboids | Case::Convex => {
            match parting_planes::first_impact(pair, direction, limit, workspace) {
                Answer::Apart => None,
                Answer::Met(met) => Some(met),
                Answer::Unknown => first.of_polygons(pair, workspace),
            }
        }
        Case::Polygons => first.of_polygons(pair, workspace),
        // The support functions have been asked before.
        Case::Parts | Case::Foreign => None,
    }
}

/// How far the first of two goes before their bounding spheres touch, and where it is then,
/// relative to that of the second; `None` if they do not.
fn nearer(pair: &PlacedPair, direction: Dir3) -> Option<(f64, Transform)> {
    let way = direction.as_dvec3();
    let [a, b] = [pair.a, pair.b].map(|placed| (placed.transform.translation, placed));
    let center =
        |(origin, placed): (Vec3, Placed)| OrientedBox::of(placed.shape, placed.transform, origin);
    let [center_a, center_b] = [
        center(a).ok()?.center.as_dvec3(),
        center(b).ok()?.center.as_dvec3(),
    ];
    let start = a.0.as_dvec3() - b.0.as_dvec3();
    let offset = center_b - center_a - start;
    // A little more than they are, for rounding.
    let radii = f64::from(pair.box_a.radius) + f64::from(pair.box_b.radius);
    let reach = 1.0001 * radii + f64::from(pair.tolerance);
    if offset.length_squared() <= reach * reach {
        return Some((
            0.0,
            Transform {
                translation: start.as_vec3(),
                ..*pair.a.transform
            },
        ));
    }
    let squared = way.length_squared();
    let along = offset.dot(way) / squared;
    let aside = offset - way * along;
    let room = reach * reach - aside.length_squared();
    if !(room >= 0.0 && along >= 0.0) {
        return None;
    }
    let back = (room / squared).sqrt();
    let translation = center_b - center_a - aside - way * back;
    Some((
        along - back,
        Transform {
            translation: translation.as_vec3(),
            ..*pair.a.transform
        },
    ))
}
