//! The axis along which two convex solids overlap least.

use bevy::math::Vec3A;

use super::{buffers::Buffers, facet::highest, support::highest_vertex};
use crate::narrow_phase::{
    answer::LocalContact,
    frame::{
        common_point::{mean_touch, middle},
        edge_polygon,
        local_aabb::LocalAabb,
        placed::PlacedPair,
        placing::Placing,
        surface::{PlacedFace, Surface},
        workspace::Workspace,
    },
    mesh::polygon_mesh::PolygonMesh,
};

/// Up to so many pairs of edges, their cross products are tried as axes.
const MOST_EDGE_PAIRS: usize = 1024;
/// All faces of a mesh of so many, or fewer, are tried.
const FEW_FACES: usize = 64;
/// How much less the overlap along a later axis has to be to be preferred, as a share of the pair's
/// size.
const BIAS: f32 = 1e-3;

/// The cosine of the angle up to which a face lies flat along a normal, and how much flatter the
/// second's has to be to be preferred.
const FLAT: f32 = 0.9999;
const LEAST_BETTER: f32 = 1e-4;

/// The contact of two convex shapes made of polygons, cuboids among them.
pub fn contact(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let meeting = mean_touch(pair, workspace);
    let bias = BIAS * (pair.box_a.radius + pair.box_b.radius);
    let (normal, gap) = if has_large(pair) {
        least_overlap_near(pair, bias, workspace)?
    } else {
        edge_polygon::fill_all(pair, workspace)?;
        let [a, b] = &workspace.surfaces;
        least_overlap(a, b, bias)?
    };
    let inner = || {
        if pair.box_b.radius < pair.box_a.radius {
            middle(pair.b, &pair.box_b)
        } else {
            middle(pair.a, &pair.box_a)
        }
    };
    Some(LocalContact {
        normal,
        // One inside the other: nothing crosses.
        point: meeting.unwrap_or_else(inner),
        depth: (-gap).max(0.0),
    })
}

/// Is one of the two so large that not all faces are looked at, and no products of edges?
fn has_large(pair: &PlacedPair) -> bool {
    let meshes = [pair.a, pair.b].map(|placed| placed.shape.polygons());
    let [Some((a, _)), Some((b, _))] = meshes else {
        return false;
    };
    a.polygon_count().max(b.polygon_count()) > FEW_FACES
        && a.edges().len() * b.edges().len() > MOST_EDGE_PAIRS
}

/// A convex mesh in place, to be asked how far it reaches.
struct Reach<'a> {
    mesh: &'a PolygonMesh,
    placing: Placing,
    /// The vertex that was the highest the last time.
    last: Vec3A,
}

impl Reach<'_> {
    /// How far it reaches along a direction, if that is less than `limit`.
    fn below(&mut self, direction: Vec3A, limit: f32) -> Option<f32> {
        if self.last.dot(direction) >= limit {
            return None;
        }
        let (linear, ..) = self.placing.linear();
        let (vertex, _) = highest_vertex(self.mesh, linear.transpose() * direction);
        self.last = self.placing.place(vertex);
        let height = self.last.dot(direction);
        (height < limit).then_some(height)
    }
}

/// The same as [`least_overlap`], along the normals of the faces that are near the other shape: that
/// of the least overlap is no further from it than that is deep.
fn least_overlap_near(
    pair: &PlacedPair,
    bias: f32,
    workspace: &mut Workspace,
) -> Option<(Vec3A, f32)> {
    let (a, b) = (pair.a.shape.polygons()?, pair.b.shape.polygons()?);
    let [mut of_a, mut of_b] =
        [(a, pair.a, &pair.box_a), (b, pair.b, &pair.box_b)].map(|(polygons, placed, bounds)| {
            Reach {
                mesh: polygons.0,
                placing: Placing::of(polygons, placed, bounds),
                // No vertex has been asked for.
                last: Vec3A::NAN,
            }
        });
    // Some overlap, and hardly more than the least if both are round.
    let apart = pair.box_b.center - pair.box_a.center;
    let towards = apart.try_normalize().unwrap_or(Vec3A::Y);
    let reach = of_a.below(towards, f32::INFINITY)? + of_b.below(-towards, f32::INFINITY)?;
    let region = LocalAabb::shared(
        (pair.box_a.center, pair.box_a.reach()),
        (pair.box_b.center, pair.box_b.reach()),
        2.0 * pair.tolerance + reach.max(0.0),
    );
    let [on_a, on_b] = &mut workspace.surfaces;
    on_a.fill(a, pair.a, &pair.box_a, &region, pair.tolerance);
    on_b.fill(b, pair.b, &pair.box_b, &region, pair.tolerance);
    let mut best: Option<(Vec3A, f32)> = None;
    for (surface, other, turn) in [(&*on_a, &mut of_b, 1.0), (&*on_b, &mut of_a, -1.0)] {
        for face in surface.faces.iter().filter(|f| f.normal != Vec3A::ZERO) {
            let top = highest(surface.corners(face), face.normal);
            let widest = best.map_or(f32::NEG_INFINITY, |(_, widest)| widest + bias);
            if let Some(reach) = other.below(-face.normal, -top - widest) {
                best = Some((face.normal * turn, -top - reach));
            }
        }
    }
    best.or(Some((towards, -reach)))
}

/// The unit axis from the first to the second of the greatest gap (the least overlap), and that
/// gap.
fn least_overlap(a: &Surface, b: &Surface, bias: f32) -> Option<(Vec3A, f32)> {
    let mut best: Option<(Vec3A, f32)> = None;
    let mut consider = |axis: Vec3A| {
        let gap = a.gap(b, axis);
        if best.is_none_or(|(_, widest)| gap > widest + bias) {
            best = Some((axis, gap));
        }
    };
    // A polygon that was flattened has no normal.
    let normals = |faces: &[PlacedFace], turn: f32, consider: &mut dyn FnMut(Vec3A)| {
        let normals = faces.iter().map(|face| face.normal * turn);
        normals.filter(|n| *n != Vec3A::ZERO).for_each(consider);
    };
    normals(&a.faces, 1.0, &mut consider);
    normals(&b.faces, -1.0, &mut consider);
    if a.edges.len() * b.edges.len() <= MOST_EDGE_PAIRS {
        for one in &a.edges {
            for other in &b.edges {
                let (u, v) = (one.ends[1] - one.ends[0], other.ends[1] - other.ends[0]);
                let cross = u.cross(v);
                // Edges that are nearly parallel span no plane.
                if cross.length_squared() > 1e-4 * u.length_squared() * v.length_squared() {
                    let axis = cross.normalize();
                    consider(axis);
                    consider(-axis);
                }
            }
        }
    }
    best
}

/// Puts the points at which two convex shapes lie on each other into the workspace: those of a face
/// of one over a face of the other. None where two edges cross.
pub fn gather(pair: &PlacedPair, normal: Vec3A, workspace: &mut Workspace) {
    workspace.contact.of::<Buffers>().patch.clear();
    if edge_polygon::fill_all(pair, workspace).is_none() {
        return;
    }
    let Workspace {
        contact,
        surfaces: [a, b],
        ..
    } = workspace;
    let patch = &mut contact.of::<Buffers>().patch;
    let (Some((along_a, on_a)), Some((along_b, on_b))) = (facing(a, normal), facing(b, -normal))
    else {
        return;
    };
    if along_a.max(along_b) < FLAT {
        return;
    }
    let (on_a, on_b) = (a.corners(on_a), b.corners(on_b));
    patch.piece.clear();
    if along_a >= along_b - LEAST_BETTER {
        let plane = highest(on_a, normal);
        patch.piece.extend_from_slice(on_b);
        patch.cut_to(on_a, normal);
        let depth = |point: Vec3A| plane - point.dot(normal);
        patch.add(normal, pair.tolerance, depth);
    } else {
        let plane = -highest(on_b, -normal);
        patch.piece.extend_from_slice(on_a);
        patch.cut_to(on_b, normal);
        let depth = |point: Vec3A| point.dot(normal) - plane;
        patch.add(-normal, pair.tolerance, depth);
    }
}

/// The face that faces a direction most, and how much: the cosine.
fn facing(surface: &Surface, direction: Vec3A) -> Option<(f32, &PlacedFace)> {
    let faces = surface.faces.iter();
    let along = faces.map(|face| (face.normal.dot(direction), face));
    along.max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests;
