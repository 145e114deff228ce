//! Where, which way and how deep two shapes meet.

use bevy::math::Vec3A;

use super::{buffers::Buffers, convex, mesh, meshes, sphere};
use crate::narrow_phase::{
    answer::{Contact, LocalContact},
    cores::{Balls, Bodies, Closest},
    error::BoundsError,
    frame::{
        case::Case,
        common_point::{common_point, mean_touch},
        oriented_box::OrientedBox,
        placed::{Placed, PlacedPair, in_order},
        separation::Separation,
        smaller::{Smaller, unit},
        workspace::Workspace,
    },
    length::any_length,
    proximity,
    settings::NarrowPhase,
    shape::{Kind, Shape},
    stage::Stage,
    support,
};

impl NarrowPhase {
    /// Returns the contact of two shapes: some if and only if they [intersect](Self::intersects),
    /// which counts the stages once.
    ///
    /// Swapping the two turns the normal around exactly and changes nothing else, unless they are
    /// equal in all things, position included. The normal is
    ///
    /// * for two cuboids or convex meshes, the axis along which they overlap least; normals of
    ///   faces are preferred to products of edges that are hardly better, those of one shape to
    ///   those of the other (all of them of meshes of up to 64 faces; and only they are tried of
    ///   meshes of more than 256 corners that have more than 1 024 pairs of edges);
    /// * for a sphere, the direction of the closest point of the other shape;
    /// * for a capsule and what is rounded, the direction of the closest points of their cores, as
    ///   long as these are apart; where the cores overlap, and for frusta, the direction along which
    ///   the two overlap least, and a depth that is exact to a millionth of their sizes;
    /// * for a cuboid or convex mesh and a mesh of any form, the least translation that takes the
    ///   one off a polygon of the other that it touches: the one that is so deepest, where what the
    ///   way off one polygon clears as well asks for no more than that. Only normals that the
    ///   surface has there count, those of polygons first: across a side between polygons in one
    ///   plane, or at the bottom of a fold, there is none. Off a polygon that bounds a solid the way
    ///   leads outwards, and off any other to the side from where it is shorter: for what has hardly
    ///   gone through a surface, back to where it came from;
    /// * for two such meshes, the same of each two polygons in touch, where each mesh reaches as far
    ///   as its nearest summit that way;
    /// * for shapes that consist of parts, that of the two that are deepest in each other; Rapier's
    ///   shapes are taken for what they are of ours;
    /// * where one is inside the other and touches no polygon, the way out through the surface that
    ///   is nearest to its centre; and if all that fails, the direction from centre to centre, and
    ///   +Y if these coincide. The depth is then the overlap of the two boxes that way.
    ///
    /// The point is the middle of what they share, seen along the normal; of a sphere and a shape with
    /// flat faces, the point of that which is closest to the sphere's centre, or nearest to the way
    /// out; beside a half-space, the deepest one.
    ///
    /// Of a mesh, only the polygons near the other shape are looked at: O(log n) for each of these;
    /// for two meshes, for each two of them that are near each other. A convex mesh of up to 128
    /// faces is looked at as a whole for each polygon that it touches. Of a larger one, O(log n)
    /// tells whether a polygon touches it, and then the faces count that are as near to the polygon
    /// as it is deep, or that face it; all faces are looked at a few times, once per contact. Of two
    /// convex meshes of which one has more than 64, the faces near the other one are looked at, O(log n)
    /// for each, if products of edges do not count. Curved shapes: some hundred steps of support
    /// functions at most. Allocates nothing once the workspace is warm, but for what consists of
    /// parts.
    #[doc(alias = "penetration")]
    #[must_use]
    pub fn contact(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> Option<Contact> {
        let are_cuboids = matches!(
            (a.shape, b.shape),
            (Shape::Cuboid { .. }, Shape::Cuboid { .. })
        );
        if !are_cuboids {
            if let Some(found) = support::with_own(a, b, |a, b| self.contact(a, b, workspace)) {
                return found;
            }
            if let Some(found) = self.at_once(a, b, workspace) {
                return found;
            }
        }
        if !self.intersects(a, b, workspace) {
            return None;
        }
        let (first, second, swapped) = in_order(a, b);
        let found = match PlacedPair::new(first, second, self.tolerance()) {
            Ok(pair) if pair.is_large() => {
                let found = self
                    .large_contact(&pair, workspace)
                    .map(|found| if swapped { found.reversed() } else { found });
                if found.is_some() {
                    return found;
                }
                local_contact(&pair, workspace)
            }
            Ok(pair) => local_contact(&pair, workspace),
            Err(BoundsError::Unbounded) => unbounded(first, second, self.tolerance()),
            // So large that squares are beyond all numbers.
            Err(BoundsError::NonFinite) => straight(first, second),
        };
        Some(in_world(found, first, swapped))
    }
}

/// A contact in the frame of a pair, of which the first is known, as seen from that which was asked
/// about first.
#[inline]
fn in_world(found: LocalContact, first: Placed, swapped: bool) -> Contact {
    let found = if swapped { found.reversed() } else { found };
    let origin = Vec3A::from(first.transform.translation);
    Contact {
        normal: found.normal.into(),
        point: (origin + found.point).into(),
        depth: found.depth,
    }
}

/// # By one search for the verdict and the point
impl NarrowPhase {
    /// The contact of two shapes of which it costs no more to tell where they meet than whether: those
    /// of a closed form, spheres on meshes, and convex shapes by their support functions. `None` if
    /// they are something else, or large.
    #[inline]
    fn at_once(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> Option<Option<Contact>> {
        let (first, second, swapped) = in_order(a, b);
        if let Some(balls) = Balls::of(first, second)
            && balls.have_normal()
        {
            let meet = balls.intersects(self.tolerance(), &mut workspace.counters);
            return Some(meet.then(|| in_world(balls.nearest.contact(), first, swapped)));
        }
        if let Some(pair) = self.quick(first, second) {
            let met = pair.contact(self.tolerance())?;
            pair.count(self.tolerance(), met.is_some(), &mut workspace.counters);
            return Some(met.map(|found| in_world(found, first, swapped)));
        }
        let case = Case::of(a.shape, b.shape);
        let is_cuboid = |placed: Placed| placed.shape.kind() == Kind::Cuboid;
        match case {
            Case::Parts | Case::Convex => {}
            Case::SphereFirst if !is_cuboid(b) => {}
            Case::SphereSecond if !is_cuboid(a) => {}
            _ => return None,
        }
        let pair = PlacedPair::new(first, second, self.tolerance()).ok()?;
        if pair.is_large() {
            return None;
        }
        let bodies = Bodies::of_case(&pair);
        if bodies.is_none() && matches!(case, Case::Parts | Case::Convex) {
            return None;
        }
        let counters = workspace.counters;
        if self.decide_early(&pair, workspace) == Some(false) {
            return Some(None);
        }
        let polytope = &mut workspace.contact.of::<Buffers>().polytope;
        let met = match bodies {
            Some(bodies) => match bodies.contact(polytope) {
                Some(met) => met.map(Some),
                None => {
                    workspace.counters = counters;
                    return None;
                }
            },
            None if pair.case() == Case::SphereFirst => sphere::sphere_mesh(&pair, workspace),
            None => sphere::sphere_mesh(&pair.swapped(), workspace)
                .map(|found| found.map(LocalContact::reversed)),
        };
        let counters = &mut workspace.counters;
        counters.count(Stage::Complete, Some(met.is_some()));
        Some(met.map(|found| {
            let found = found.unwrap_or_else(|| from_centers(&pair));
            in_world(found, first, swapped)
        }))
    }
}

/// # Of what is large
impl NarrowPhase {
    /// That of two shapes of ours at a smaller scale, in the order in which pairs are computed.
    #[cold]
    fn large_contact(&self, pair: &PlacedPair, workspace: &mut Workspace) -> Option<Contact> {
        // The stages have been counted.
        let counters = workspace.counters;
        let smaller = Smaller::of(pair, self)?;
        let [a, b] = smaller.placed(pair);
        let found = smaller.tests.contact(a, b, workspace);
        let found = found.map(|found| {
            let point = found.point * smaller.factor;
            Contact {
                // Where numbers end, the position is as near as any.
                point: if point.is_finite() {
                    point
                } else {
                    pair.a.transform.translation
                },
                depth: (found.depth * smaller.factor).min(f32::MAX),
                normal: unit(found.normal),
            }
        });
        workspace.counters = counters;
        found
    }
}

fn local_contact(pair: &PlacedPair, workspace: &mut Workspace) -> LocalContact {
    by_case(pair, workspace).unwrap_or_else(|| from_between(pair, workspace))
}

fn by_case(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    match pair.case() {
        Case::Spheres => sphere::spheres(pair),
        Case::SphereFirst => sphere::sphere_other(pair, workspace),
        Case::SphereSecond => {
            sphere::sphere_other(&pair.swapped(), workspace).map(LocalContact::reversed)
        }
        Case::Cuboids => cuboids(pair, workspace),
        Case::Convex => convex::contact(pair, workspace),
        Case::Polygons => polygons(pair, workspace),
        Case::Parts | Case::Foreign => support::contact(pair.a, pair.b, pair.tolerance),
    }
}

fn cuboids(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let found = Separation::of(&pair.box_a, &pair.box_b, f32::INFINITY)?;
    let point = common_point(pair).or_else(|| mean_touch(pair, workspace));
    Some(LocalContact {
        normal: found.axis,
        point: point?,
        depth: (-found.along).max(0.0),
    })
}

/// A mesh of any form, and another shape made of polygons.
fn polygons(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    match (
        pair.a.shape.kind().is_convex(),
        pair.b.shape.kind().is_convex(),
    ) {
        (true, _) => mesh::contact(pair, workspace),
        (_, true) => mesh::contact(&pair.swapped(), workspace).map(LocalContact::reversed),
        _ => meshes::contact(pair, workspace),
    }
}

fn center_direction(pair: &PlacedPair) -> Vec3A {
    let offset = pair.box_b.center - pair.box_a.center;
    offset.try_normalize().unwrap_or(Vec3A::Y)
}

/// Of two of which nothing else is known: along what is between them, if they only nearly touch, and
/// else from centre to centre, at a point of both.
fn from_between(pair: &PlacedPair, workspace: &mut Workspace) -> LocalContact {
    let Some(Closest {
        points: [from, to], ..
    }) = proximity::local_points(pair, workspace)
    else {
        return from_centers(pair);
    };
    let offset = to - from;
    match (offset / any_length(offset)).try_normalize() {
        Some(normal) => LocalContact {
            normal,
            point: from.midpoint(to),
            depth: 0.0,
        },
        None => LocalContact {
            point: from,
            ..from_centers(pair)
        },
    }
}

/// The last resort: the boxes, from centre to centre.
fn from_centers(pair: &PlacedPair) -> LocalContact {
    let (a, b) = (&pair.box_a, &pair.box_b);
    let normal = center_direction(pair);
    let reach = |bounds: &OrientedBox| bounds.extent(normal).min(bounds.radius);
    let extents = reach(a) + reach(b);
    let smaller = if b.radius < a.radius { b } else { a };
    LocalContact {
        normal,
        point: smaller.center,
        depth: (extents - (b.center - a.center).dot(normal)).max(0.0),
    }
}

/// Of which one has no bounds.
fn unbounded(a: Placed, b: Placed, tolerance: f32) -> LocalContact {
    support::contact(a, b, tolerance).unwrap_or_else(|| straight(a, b))
}

/// From position to position, for want of bounds.
fn straight(a: Placed, b: Placed) -> LocalContact {
    let offset = Vec3A::from(b.transform.translation - a.transform.translation);
    LocalContact {
        normal: offset.try_normalize().unwrap_or(Vec3A::Y),
        point: offset * 0.5,
        depth: 0.0,
    }
}
