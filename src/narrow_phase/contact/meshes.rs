//! Two meshes of any form.
//!
//! Each two polygons in touch say how far the first mesh has to go to be clear of the second there:
//! along the normal of one of them, or across two edges that both may have a normal of their own.
//! How far the mesh without that normal reaches beyond is found by walking over its polygons to the
//! nearest summit. As with a convex solid, what the deepest says counts.

use std::ops::ControlFlow;

use bevy::math::Vec3A;

use super::{
    buffers::Claim,
    claims::settle,
    facet::{Best, Facet, highest, look_beyond},
    mesh,
};
use crate::narrow_phase::{
    answer::LocalContact,
    frame::{
        near_faces::{Touching, for_each_near},
        placed::PlacedPair,
        surface::{PlacedFace, Surface, border},
        workspace::Workspace,
    },
    mesh::{polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR},
    shape::Shape,
};

/// How much less another translation has to be to be preferred to that along a polygon's normal, as
/// a share of the smaller mesh's size.
const BIAS: f32 = 1e-4;

/// The cosine of the angle up to which a polygon shares the normal of another.
const ALIKE: f32 = 0.985;

/// So many polygons at most are looked at on the way to a summit, and so many of a plateau.
const MOST_STEPS: usize = 256;
const WIDEST_PLATEAU: usize = 24;

/// The contact of two meshes.
pub fn contact(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let bias = BIAS * pair.box_a.radius.min(pair.box_b.radius);
    let (Shape::Mesh(mesh_a), Shape::Mesh(mesh_b)) = (pair.a.shape, pair.b.shape) else {
        return None;
    };
    let meshes: [&PolygonMesh; 2] = [mesh_a, mesh_b];
    let mut buffers = std::mem::take(&mut workspace.contact);
    buffers.patch.clear();
    buffers.claims.clear();
    let (mut count, mut points) = (0.0, Vec3A::ZERO);
    for_each_two(pair, pair.tolerance, workspace, |[a, b], face, other| {
        if let Some(touch) = touch(a, face, b, other, pair.tolerance) {
            count += 1.0;
            points += touch;
            let sides = Sides::new(meshes, [a, b], pair.tolerance);
            buffers.claims.extend(sides.claim(face, other, bias));
        }
    });
    let [a, b] = &workspace.surfaces;
    let Sides([first, second]) = Sides::new(meshes, [a, b], pair.tolerance);
    let deepest = settle(&mut buffers, bias, |claim, _, direction, limit| {
        let back = first.summit(claim.polygons[0], -direction, f32::INFINITY);
        back + second.summit(claim.polygons[1], direction, limit - back)
    });
    let way = deepest.map(|deepest| buffers.claims[deepest].way);
    workspace.contact = buffers;
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
/// both that have the normal of the contact. None where there are none.
pub fn gather(pair: &PlacedPair, normal: Vec3A, depth: f32, workspace: &mut Workspace) {
    workspace.contact.patch.clear();
    let margin = depth + pair.tolerance;
    let mut buffers = std::mem::take(&mut workspace.contact);
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
            patch.add(-normal, pair.tolerance, deep);
        }
    });
    workspace.contact = buffers;
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
/// centre.
fn nested(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let (Shape::Mesh(a), Shape::Mesh(b)) = (pair.a.shape, pair.b.shape) else {
        return None;
    };
    mesh::nested(pair, b, workspace)
        .or_else(|| mesh::nested(&pair.swapped(), a, workspace).map(LocalContact::reversed))
}

/// The mean of the points at which the sides of one of two faces touch the other.
fn touch(
    a: &Surface,
    face: &PlacedFace,
    b: &Surface,
    other: &PlacedFace,
    tolerance: f32,
) -> Option<Vec3A> {
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
}

impl Side<'_> {
    /// The normal of a face; and whether only that way is outside.
    fn normal(&self, face: &PlacedFace) -> (Vec3A, bool) {
        let is_solid = self.mesh.bounds_solid(face.polygon as usize);
        (face.normal, is_solid)
    }

    /// How far the mesh reaches along a direction on the summit that is nearest to a polygon; or
    /// somewhere beyond `limit`.
    fn summit(&self, polygon: u32, direction: Vec3A, limit: f32) -> f32 {
        let top = |polygon: u32| {
            let corners = self.mesh.polygon(polygon as usize).iter();
            let heights = corners.map(|vertex| self.surface.vertex(self.mesh, *vertex));
            heights.fold(f32::NEG_INFINITY, |top, corner| {
                top.max(corner.dot(direction))
            })
        };
        // Those of a plateau that have been looked at, and those beside which the way up may go on.
        let mut plateau = [polygon; WIDEST_PLATEAU];
        let (mut known, mut next) = (1, 0);
        let mut reached = top(polygon);
        let mut steps = 0;
        while next < known && steps < MOST_STEPS && reached <= limit {
            let polygon = plateau[next];
            next += 1;
            for &other in self.mesh.across(polygon as usize) {
                if other == NO_NEIGHBOR || plateau[..known].contains(&other) {
                    continue;
                }
                steps += 1;
                let height = top(other);
                if height > reached + self.tolerance {
                    plateau[0] = other;
                    (known, next) = (1, 0);
                    reached = height;
                    break;
                }
                if height >= reached - self.tolerance && known < WIDEST_PLATEAU {
                    plateau[known] = other;
                    known += 1;
                    reached = reached.max(height);
                }
            }
        }
        reached
    }
}

/// Both meshes.
struct Sides<'a>([Side<'a>; 2]);

impl<'a> Sides<'a> {
    fn new(meshes: [&'a PolygonMesh; 2], surfaces: [&'a Surface; 2], tolerance: f32) -> Self {
        Self([0, 1].map(|i| Side {
            mesh: meshes[i],
            surface: surfaces[i],
            tolerance,
        }))
    }

    /// What two polygons in touch say: the way by which the first mesh gets clear of the second.
    fn claim(&self, face: &PlacedFace, other: &PlacedFace, bias: f32) -> Option<Claim> {
        let Self([a, b]) = self;
        let (own, theirs) = (a.surface.corners(face), b.surface.corners(other));
        let mut best = Best { way: None, bias };
        // Along the normal of the second's polygon, and against that of the first's.
        let ((normal_a, solid_a), (normal_b, solid_b)) = (a.normal(face), b.normal(other));
        let normal = normal_b;
        for (direction, allowed) in [(normal, true), (-normal, !solid_b)] {
            if allowed && normal != Vec3A::ZERO {
                let top = highest(theirs, direction);
                let limit = best.way.map_or(f32::INFINITY, |way| way.depth) - top;
                let depth = top + a.summit(face.polygon, -direction, limit);
                if best.way.is_none_or(|way| depth < way.depth) {
                    best.take(direction, depth);
                }
            }
        }
        let normal = normal_a;
        for (direction, allowed) in [(-normal, true), (normal, !solid_a)] {
            if allowed && normal != Vec3A::ZERO {
                let top = highest(own, -direction);
                let limit = best.way.map_or(f32::INFINITY, |way| way.depth) - top;
                let depth = top + b.summit(other.polygon, direction, limit);
                if best.is_beaten_by(depth) {
                    best.take(direction, depth);
                }
            }
        }
        if best.way.is_none_or(|way| way.depth > bias) {
            let beyond =
                |side| look_beyond(a.mesh, face.polygon, side, |v| a.surface.vertex(a.mesh, v));
            let other_beyond =
                |side| look_beyond(b.mesh, other.polygon, side, |v| b.surface.vertex(b.mesh, v));
            let first = Facet {
                corners: own,
                normal: normal_a,
                beyond: &beyond,
                is_solid: solid_a,
            };
            let second = Facet {
                corners: theirs,
                normal: normal_b,
                beyond: &other_beyond,
                is_solid: solid_b,
            };
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

/// Across two edges, where both polygons are highest there towards each other.
fn across_edges(first: &Facet, second: &Facet, best: &mut Best) {
    for side in 0..second.corners.len() {
        for other in 0..first.corners.len() {
            let [from, to] = second.ends(side);
            let [start, end] = first.ends(other);
            let (Some(direction), Some(back)) = (
                second.across(side, end - start),
                first.across(other, to - from),
            ) else {
                continue;
            };
            let depth = (from - start).dot(direction);
            if direction.dot(back) < 0.0
                && best.is_beaten_by(depth)
                && second.is_ridge(side, direction)
                && first.is_ridge(other, back)
            {
                best.take(direction, depth);
            }
        }
    }
}
