//! Two meshes of any form.
//!
//! Each two polygons in touch say how far the first mesh has to go to be clear of the second there:
//! along the normal of one of them, or across two edges that both may have a normal of their own.
//! How far the mesh without that normal reaches beyond is found by walking over its polygons to the
//! nearest summit. As with a convex solid, what the deepest says counts.

use std::ops::ControlFlow;

use bevy::math::Vec3A;

use super::{
    around::{Around, FLAT, Look},
    buffers::Buffers,
    buffers::Claim,
    claims::settle,
    facet::{Best, Facet, PARALLEL, WayOut, bounds, highest},
    mesh,
    summit::{Course, Slope, Summits},
};
use crate::narrow_phase::{
    answer::LocalContact,
    frame::{
        local_aabb::LocalAabb,
        near_faces::{Touching, for_each_near},
        placed::PlacedPair,
        surface::{PlacedFace, Surface, border},
        workspace::Workspace,
    },
    mesh::polygon_mesh::PolygonMesh,
    shape::Shape,
};

/// How much less another translation has to be to be preferred to that along a polygon's normal, as
/// a share of the smaller mesh's size.
const BIAS: f32 = 1e-4;

/// The cosine of the angle up to which a polygon shares the normal of another.
const ALIKE: f32 = 0.985;

/// The contact of two meshes.
pub fn contact(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let bias = BIAS * pair.box_a.radius.min(pair.box_b.radius);
    let (Shape::Mesh(mesh_a), Shape::Mesh(mesh_b)) = (pair.a.shape, pair.b.shape) else {
        return None;
    };
    let meshes: [&PolygonMesh; 2] = [mesh_a, mesh_b];
    let mut buffers = std::mem::take(workspace.contact.of::<Buffers>());
    buffers.patch.clear();
    buffers.claims.clear();
    buffers.summits.clear();
    let (mut count, mut points) = (0.0, Vec3A::ZERO);
    for_each_two(pair, pair.tolerance, workspace, |[a, b], face, other| {
        if let Some(touch) = touch(a, face, b, other, pair.tolerance) {
            count += 1.0;
            points += touch;
            let sides = Sides::new(pair, meshes, [a, b]);
            let claim = sides.claim(face, other, bias, &mut buffers.summits);
            buffers.claims.extend(claim);
        }
    });
    let [a, b] = &workspace.surfaces;
    let sides = Sides::new(pair, meshes, [a, b]);
    let mut summits = std::mem::take(&mut buffers.summits);
    summits.clear();
    let deepest = settle(&mut buffers, bias, |claim, _, index, direction, limit| {
        sides.depth(
            claim.polygons,
            (index as u32, direction),
            limit,
            &mut summits,
        )
    });
    buffers.summits = summits;
    let way = deepest.map(|deepest| buffers.claims[deepest].way);
    *workspace.contact.of() = buffers;
    let Some(way) = way else {
        return nested(pair, workspace);
    };
    Some(LocalContact {
        normal: -way.direction,
        point: points / count,
        depth: way.depth.max(0.0),
    })
}

/// Puts the points at which two meshes lie on each other into the workspace: those of polygons of
/// both that have the normal of the contact. None where there are none, as of one inside the other.
/// The workspace is as [`contact`] left it.
pub fn gather(pair: &PlacedPair, normal: Vec3A, depth: f32, workspace: &mut Workspace) {
    let buffers = workspace.contact.of::<Buffers>();
    buffers.patch.clear();
    if buffers.claims.is_empty() {
        return;
    }
    let margin = depth + pair.tolerance;
    let mut buffers = std::mem::take(workspace.contact.of::<Buffers>());
    let patch = &mut buffers.patch;
    for_each_two(pair, margin, workspace, |[a, b], face, other| {
        let [along, along_other] = [face, other].map(|face| face.normal.dot(normal));
        if along.abs() < ALIKE || along_other.abs() < ALIKE {
            return;
        }
        let (own, theirs) = (a.corners(face), b.corners(other));
        patch.piece.clear();
        patch.piece.extend_from_slice(own);
        patch.cut_to(theirs, normal);
        let up = other.normal * 1f32.copysign(along_other);
        let plane = theirs[0].dot(up);
        let deep = |point: Vec3A| (point.dot(up) - plane) / along_other.abs();
        // The far side of what is deeper than the contact lies on nothing.
        if patch.piece.iter().all(|point| deep(*point) <= margin) {
            patch.add_up_to(depth, -normal, pair.tolerance, deep);
        }
    });
    *workspace.contact.of() = buffers;
}

/// Calls `visit` with each two faces that may be as near each other as `margin`, and the meshes, in
/// place. Each two come once.
fn for_each_two(
    pair: &PlacedPair,
    margin: f32,
    workspace: &mut Workspace,
    mut visit: impl FnMut([&Surface; 2], &PlacedFace, &PlacedFace),
) {
    for_each_near(&Touching(2.0 * margin), pair, workspace, 0.0, |[a, b]| {
        for face in &a.faces {
            for other in &b.faces {
                if face.bounds.gap_squared(&other.bounds) <= margin * margin {
                    visit([a, b], face, other);
                }
            }
        }
        ControlFlow::Continue(0.0)
    });
}

/// One mesh inside the other, whose surfaces do not touch: out through what is nearest to its
/// centre. The centre of the outer one may be in the inner one too; that way is longer.
fn nested(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let (Shape::Mesh(a), Shape::Mesh(b)) = (pair.a.shape, pair.b.shape) else {
        return None;
    };
    let first = mesh::nested(pair, b, workspace);
    let second = mesh::nested(&pair.swapped(), a, workspace).map(LocalContact::reversed);
    match (first, second) {
        (Some(first), Some(second)) if second.depth < first.depth => Some(second),
        (first, second) => first.or(second),
    }
}

/// The mean of the points at which the sides of one of two faces touch the other.
fn touch(
    a: &Surface,
    face: &PlacedFace,
    b: &Surface,
    other: &PlacedFace,
    tolerance: f32,
) -> Option<Vec3A> {
    if b.is_off_plane(other, a.corners(face), tolerance)
        || a.is_off_plane(face, b.corners(other), tolerance)
    {
        return None;
    }
    let (mut count, mut points) = (0.0, Vec3A::ZERO);
    for (edges, edged, faces, faced) in [(a, face, b, other), (b, other, a, face)] {
        for side in border(edges.corners(edged)) {
            if let Some(point) = faces.touch_segment(faced, side, tolerance) {
                count += 1.0;
                points += point;
            }
        }
    }
    (count > 0.0).then(|| points / count)
}

/// One of the two meshes.
struct Side<'a> {
    mesh: &'a PolygonMesh,
    surface: &'a Surface,
    tolerance: f32,
    /// Has it parts that share no vertices?
    is_in_parts: bool,
}

impl Side<'_> {
    /// The normal of a face; and whether only that way is outside.
    fn normal(&self, face: &PlacedFace) -> (Vec3A, bool) {
        let is_solid = self.mesh.bounds_solid(face.polygon as usize);
        (face.normal, is_solid)
    }

    /// Shows the faces that may be as near a line as `reach`, until one is the one looked for;
    /// whether one was.
    fn any_near(&self, line: [Vec3A; 2], reach: f32, is_it: Look) -> bool {
        let [low, high] = bounds(line.into_iter());
        self.surface.faces.iter().any(|face| {
            face.bounds.min.cmple(high + reach).all()
                && face.bounds.max.cmpge(low - reach).all()
                && is_it(face.polygon, self.surface.corners(face), face.normal)
        })
    }

    /// The mesh, seen along a direction.
    fn slope(&self, direction: Vec3A) -> Slope<'_> {
        Slope::new(self.mesh, self.surface.placing(), direction)
    }
}

/// Both meshes, and how far it may be worth to go: along an endless surface, a way does not end.
struct Sides<'a> {
    of: [Side<'a>; 2],
    most: f32,
}

impl<'a> Sides<'a> {
    fn new(pair: &PlacedPair, meshes: [&'a PolygonMesh; 2], surfaces: [&'a Surface; 2]) -> Self {
        Self {
            of: [0, 1].map(|i| Side {
                mesh: meshes[i],
                surface: surfaces[i],
                tolerance: pair.tolerance,
                is_in_parts: meshes[i].is_in_parts(),
            }),
            // The whole of the smaller one, and more.
            most: 2.5 * pair.box_a.radius.min(pair.box_b.radius),
        }
    }

    /// How far it is along a direction until two polygons are clear of each other, each mesh as far
    /// as it reaches there; anything more than `limit`, if it is more than that. Directions are
    /// known by their numbers.
    fn depth(
        &self,
        polygons: [u32; 2],
        (index, direction): (u32, Vec3A),
        limit: f32,
        summits: &mut Summits,
    ) -> f32 {
        let [a, b] = &self.of;
        let courses = [false, true].map(|is_second| Course::new(is_second, index, false));
        let [back, forth] = [a.slope(-direction), b.slope(direction)];
        let (least, _) = forth.top(polygons[1]);
        let start = summits.find(courses[0], &back, polygons[0], limit - least, a.tolerance);
        if start > limit - least {
            return start + least;
        }
        start + summits.find(courses[1], &forth, polygons[1], limit - start, b.tolerance)
    }

    /// What two polygons in touch say: the way by which the first mesh gets clear of the second.
    fn claim(
        &self,
        face: &PlacedFace,
        other: &PlacedFace,
        bias: f32,
        summits: &mut Summits,
    ) -> Option<Claim> {
        let [a, b] = &self.of;
        let (own, theirs) = (a.surface.corners(face), b.surface.corners(other));
        let mut best = Best { way: None, bias };
        // Along the normal of the second's polygon, and against that of the first's.
        let ((normal_a, solid_a), (normal_b, solid_b)) = (a.normal(face), b.normal(other));
        let place = |vertex| a.surface.vertex(a.mesh, vertex);
        let place_other = |vertex| b.surface.vertex(b.mesh, vertex);
        let reach = a.tolerance.max(bias);
        let near = |line: [Vec3A; 2], is_it: Look| a.any_near(line, reach, is_it);
        let near_other = |line: [Vec3A; 2], is_it: Look| b.any_near(line, reach, is_it);
        let clip = |line| clip(line, &other.bounds);
        let clip_other = |line| self::clip(line, &face.bounds);
        let first = Facet {
            corners: own,
            normal: normal_a,
            around: Around {
                mesh: a.mesh,
                polygon: face.polygon,
                place: &place,
                clip: &clip,
                others: &near,
                reach,
            },
            is_solid: solid_a,
        };
        let second = Facet {
            corners: theirs,
            normal: normal_b,
            around: Around {
                mesh: b.mesh,
                polygon: other.polygon,
                place: &place_other,
                clip: &clip_other,
                others: &near_other,
                reach,
            },
            is_solid: solid_b,
        };
        // Not over the edge of what lies flush with another surface, if there is another way.
        let mut spare = None;
        let normal = normal_b;
        for (direction, allowed) in [(normal, true), (-normal, !solid_b)] {
            if allowed && normal != Vec3A::ZERO {
                let top = highest(theirs, direction);
                let limit = best.way.map_or(self.most, |way| way.depth) - top;
                // No way up is needed where the polygon alone is too high.
                if highest(own, -direction) > limit {
                    continue;
                }
                let course = Course::new(false, other.polygon, direction == normal);
                let slope = a.slope(-direction);
                let depth = top + summits.find(course, &slope, face.polygon, limit, a.tolerance);
                if best.way.is_none_or(|way| depth < way.depth) {
                    if depth > bias && a.is_in_parts && first.is_flush(-direction) {
                        spare = spare.or(Some(WayOut { direction, depth }));
                    } else {
                        best.take(direction, depth);
                    }
                }
            }
        }
        let normal = normal_a;
        for (direction, allowed) in [(-normal, true), (normal, !solid_a)] {
            if allowed && normal != Vec3A::ZERO {
                let top = highest(own, -direction);
                let limit = best.way.map_or(self.most, |way| way.depth) - top;
                if highest(theirs, direction) > limit - bias {
                    continue;
                }
                let course = Course::new(true, face.polygon, direction != normal);
                let slope = b.slope(direction);
                let depth = top + summits.find(course, &slope, other.polygon, limit, b.tolerance);
                if best.is_beaten_by(depth) {
                    if depth > bias && b.is_in_parts && second.is_flush(direction) {
                        spare = spare.or(Some(WayOut { direction, depth }));
                    } else {
                        best.take(direction, depth);
                    }
                }
            }
        }
        best.way = best.way.or(spare);
        if best.way.is_none_or(|way| way.depth > bias) {
            across_edges(&first, &second, &mut best);
        }
        best.way.map(|way| Claim {
            corners: [0; 2],
            polygons: [face.polygon, other.polygon],
            normal: other.normal,
            way,
        })
    }
}

/// The part of a line in a box; all of it, if there is none.
fn clip(line: [Vec3A; 2], bounds: &LocalAabb) -> [Vec3A; 2] {
    let [from, to] = line;
    let way = to - from;
    let [mut start, mut end] = [0f32, 1f32];
    for axis in 0..3 {
        let at = |side: f32| (side - from[axis]) / way[axis];
        let [one, other] = [at(bounds.min[axis]), at(bounds.max[axis])];
        // Along a box, the two are no numbers, or infinite.
        if one.is_finite() && other.is_finite() {
            start = start.max(one.min(other));
            end = end.min(one.max(other));
        }
    }
    if start <= end {
        [from.lerp(to, start), from.lerp(to, end)]
    } else {
        line
    }
}

/// Across two edges, where both polygons are highest there towards each other.
fn across_edges(first: &Facet, second: &Facet, best: &mut Best) {
    for side in 0..second.corners.len() {
        let [from, to] = second.ends(side);
        for other in 0..first.corners.len() {
            let [start, end] = first.ends(other);
            let (along, edge) = (to - from, end - start);
            let cross = along.cross(edge);
            let squared = cross.length_squared();
            if squared <= PARALLEL * PARALLEL * along.length_squared() * edge.length_squared() {
                continue;
            }
            let ([low, high], [least, most]) =
                (second.heights(from, cross), first.heights(start, cross));
            let turn = if high > -low { -1.0 } else { 1.0 };
            // The second is below, and the first above.
            let (rises, falls) = if turn < 0.0 {
                (-low, high)
            } else {
                (high, -low)
            };
            let (drops, climbs) = if turn < 0.0 {
                (most, -least)
            } else {
                (-least, most)
            };
            if rises > FLAT * falls || drops > FLAT * climbs {
                continue;
            }
            let direction = cross * (turn / squared.sqrt());
            let depth = (from - start).dot(direction);
            if best.is_beaten_by(depth)
                && second.is_ridge(side, direction)
                && first.is_ridge(other, -direction)
            {
                best.take(direction, depth);
            }
        }
    }
}
