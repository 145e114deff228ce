//! A convex solid and a mesh of any form.
//!
//! Each polygon in touch says how far the solid has to go to be clear of it, along a normal that
//! the surface has there: see [`Facet`]. What the deepest of them says counts, but for polygons
//! that the way out of another clears as well, on a shorter way.

use bevy::math::Vec3A;

use super::{
    around::{Around, Look},
    body::Body,
    buffers::{Buffers, Claim, Touching},
    claims::settle,
    facet::{Facet, bounds, highest},
    large_hull::LargeHull,
    place::MeshPlace,
};
use crate::narrow_phase::{
    answer::LocalContact,
    frame::{
        closest,
        common_point::{middle, reach},
        edge_polygon,
        placed::PlacedPair,
        workspace::Workspace,
    },
    mesh::polygon_mesh::PolygonMesh,
    shape::Shape,
};

/// How much less another translation has to be to be preferred to that along a polygon's normal, as
/// a share of the solid's size.
const BIAS: f32 = 1e-4;

/// The cosine of the angle up to which a polygon shares the normal of another.
const ALIKE: f32 = 0.985;

/// The cosine of the angle up to which a face lies flat.
const ALONG: f32 = 0.9999;

/// The contact of a convex solid, the first of the pair, and a mesh. Leaves the points where they
/// meet, in the frame of the pair, in the workspace.
pub fn contact(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let Shape::Mesh(mesh) = pair.b.shape else {
        return None;
    };
    let contact = workspace.contact.of::<Buffers>();
    contact.patch.clear();
    let mut hull = std::mem::take(&mut contact.hull);
    let mut large = None;
    let (body, middle) = match pair.a.shape {
        Shape::Convex(solid) => {
            let scale = Vec3A::from(pair.a.transform.scale);
            large = LargeHull::new(solid, scale, &mut contact.room);
            let body = if let Some(large) = &large {
                Body::Large(large)
            } else {
                hull.fill(solid, scale);
                Body::Hull(&hull)
            };
            (body, solid.local_bounds().0)
        }
        _ => (Body::Cuboid(pair.box_a.half), Vec3A::ZERO),
    };
    let place = MeshPlace::new(pair.a, middle, pair.b, mesh.local_bounds().0);
    let found = OnMesh {
        pair,
        body,
        mesh,
        place,
    }
    .contact(contact);
    contact.hull = hull;
    if let Some(large) = large {
        contact.room = large.into_room();
    }
    let Some(found) = found else {
        return nested(pair, mesh, workspace);
    };
    let (axes, center) = (pair.box_a.axes, pair.box_a.center);
    for point in &mut contact.patch.points {
        point.point = center + axes * point.point;
    }
    Some(LocalContact {
        normal: (axes * found.normal).normalize(),
        point: center + axes * found.point,
        depth: found.depth,
    })
}

/// A solid inside a mesh, whose surface it does not touch: out through what is nearest to its
/// centre.
pub fn nested(
    pair: &PlacedPair,
    mesh: &PolygonMesh,
    workspace: &mut Workspace,
) -> Option<LocalContact> {
    if !mesh.has_inside() {
        return None;
    }
    let (closest, is_inside) = edge_polygon::sphere_closest(pair, workspace)?;
    let solid = &pair.box_a;
    let out = (closest.point - solid.center).try_normalize()?;
    is_inside.then(|| LocalContact {
        normal: -out,
        point: middle(pair.a, solid),
        depth: closest.distance + reach(pair.a, solid, -out),
    })
}

struct OnMesh<'a> {
    pair: &'a PlacedPair<'a>,
    body: Body<'a>,
    mesh: &'a PolygonMesh,
    place: MeshPlace,
}

impl OnMesh<'_> {
    /// In the frame of the solid.
    fn contact(&self, buffers: &mut Buffers) -> Option<LocalContact> {
        self.find_claims(buffers);
        let bias = self.bias();
        let deepest = settle(buffers, bias, |_, corners, _, direction, _| {
            highest(corners, direction) - self.body.lowest(direction)
        })?;
        let way = buffers.claims[deepest].way;
        buffers.patch.clear();
        self.gather(deepest, buffers);
        let size = self.pair.box_a.radius;
        let point = buffers.patch.middle(size);
        let point = point.unwrap_or_else(|| self.some_point(deepest, buffers));
        Some(LocalContact {
            normal: -way.direction,
            point,
            depth: way.depth.max(0.0),
        })
    }

    fn bias(&self) -> f32 {
        BIAS * self.pair.box_a.radius
    }

    /// Finds the polygons in touch.
    fn find_touching(&self, buffers: &mut Buffers) {
        let Buffers {
            polygons,
            touching,
            corners,
            ..
        } = buffers;
        let (mesh, tolerance) = (self.mesh, self.pair.tolerance);
        let half = self.pair.box_a.half + 2.0 * tolerance;
        polygons.clear();
        self.place
            .for_each_near(mesh, half, |polygon| polygons.push(polygon));
        // In the order of the mesh, whatever that of the tree.
        polygons.sort_unstable();
        corners.clear();
        touching.clear();
        for &polygon in &*polygons {
            let start = corners.len();
            let vertices = mesh.polygon(polygon as usize).iter();
            corners.extend(vertices.map(|v| self.place.place(mesh.vertices()[*v as usize])));
            let own = &corners[start..];
            let normal = self.place.normal(mesh.normals()[polygon as usize]);
            // More than rounding may make of it: there has to be one, if the two are in contact.
            if !self.body.touches_polygon(own, normal, 2.0 * tolerance) {
                corners.truncate(start);
                continue;
            }
            touching.push(Touching {
                polygon,
                corners: [start as u32, corners.len() as u32],
                normal,
                bounds: bounds(corners[start..].iter().copied()),
            });
        }
    }

    /// What each polygon in touch says.
    fn find_claims(&self, buffers: &mut Buffers) {
        self.find_touching(buffers);
        let Buffers {
            touching,
            corners,
            claims,
            ..
        } = buffers;
        let (mesh, reach) = (self.mesh, self.pair.tolerance.max(self.bias()));
        let corners_of =
            |[start, end]: [u32; 2]| -> &[Vec3A] { &corners[start as usize..end as usize] };
        let place = |vertex: u32| self.place.place(mesh.vertices()[vertex as usize]);
        let clip = |line| self.clip(line);
        let others = |line: [Vec3A; 2], is_it: Look| {
            let [low, high] = bounds(line.into_iter());
            touching.iter().any(|other| {
                let [min, max] = other.bounds;
                min.cmple(high + reach).all()
                    && max.cmpge(low - reach).all()
                    && is_it(other.polygon, corners_of(other.corners), other.normal)
            })
        };
        claims.clear();
        for own in touching.iter() {
            let facet = Facet {
                corners: corners_of(own.corners),
                normal: own.normal,
                around: Around {
                    mesh,
                    polygon: own.polygon,
                    place: &place,
                    clip: &clip,
                    others: &others,
                    reach,
                },
                is_solid: mesh.bounds_solid(own.polygon as usize),
            };
            if let Some(way) = self.body.way_out(&facet, self.bias()) {
                claims.push(Claim {
                    corners: own.corners,
                    polygons: [0; 2],
                    normal: own.normal,
                    way,
                });
            }
        }
    }

    /// The part of a line inside the solid; all of it, if there is none.
    fn clip(&self, line: [Vec3A; 2]) -> [Vec3A; 2] {
        let [from, to] = line;
        let [mut start, mut end] = [0f32, 1f32];
        self.body.for_each_plane(|normal, plane| {
            let [first, last] = line.map(|point| point.dot(normal) - plane);
            if first > 0.0 && last > 0.0 {
                end = -1.0;
            } else if first > 0.0 {
                start = start.max(first / (first - last));
            } else if last > 0.0 {
                end = end.min(first / (first - last));
            }
        });
        if start <= end {
            [from.lerp(to, start), from.lerp(to, end)]
        } else {
            line
        }
    }

    /// The points where the solid and the polygons meet that have the normal that counts.
    fn gather(&self, deepest: usize, buffers: &mut Buffers) {
        let Buffers {
            corners,
            claims,
            patch,
            face,
            ..
        } = buffers;
        let tolerance = self.pair.tolerance;
        let way = claims[deepest].way;
        let direction = way.direction;
        let corners_of =
            |claim: &Claim| &corners[claim.corners[0] as usize..claim.corners[1] as usize];
        let towards = |claim: &Claim| {
            let along = claim.normal.dot(direction);
            (claim.normal * 1f32.copysign(along), along.abs())
        };
        let against = self.body.face_towards(-direction, face);
        if towards(&claims[deepest]).1 > ALONG {
            // The solid's face over polygons.
            for claim in claims.iter() {
                let (up, along) = towards(claim);
                if along < ALIKE {
                    continue;
                }
                let own = corners_of(claim);
                let plane = highest(own, up);
                patch.piece.clone_from(face);
                patch.cut_to(own, direction);
                patch.add_up_to(way.depth, direction, tolerance, |point| {
                    (plane - point.dot(up)) / along
                });
            }
        } else if -against.dot(direction) > ALONG {
            // Polygons over the solid's face.
            let plane = self.body.lowest(direction);
            for claim in claims.iter() {
                patch.piece.clear();
                patch.piece.extend_from_slice(corners_of(claim));
                patch.cut_to(face, direction);
                patch.add_up_to(way.depth, -direction, tolerance, |point| {
                    point.dot(direction) - plane
                });
            }
        } else {
            // Edge on edge.
            let top = |points: &[Vec3A], up: Vec3A| {
                let [mut first, mut second] = [(f32::NEG_INFINITY, Vec3A::ZERO); 2];
                for point in points {
                    let height = point.dot(up);
                    if height > first.0 {
                        (second, first) = (first, (height, *point));
                    } else if height > second.0 {
                        second = (height, *point);
                    }
                }
                [first.1, second.1]
            };
            let ours = top(face, -direction);
            let theirs = top(corners_of(&claims[deepest]), direction);
            let (on_solid, on_mesh) = closest::segments(ours, theirs);
            patch.add_point(on_solid.midpoint(on_mesh), way.depth);
        }
    }

    /// A point of a polygon that is in the solid too, or nearly so.
    fn some_point(&self, claim: usize, buffers: &mut Buffers) -> Vec3A {
        let Buffers {
            corners,
            claims,
            patch,
            ..
        } = buffers;
        let [start, end] = claims[claim].corners;
        patch.piece.clear();
        patch
            .piece
            .extend_from_slice(&corners[start as usize..end as usize]);
        let tolerance = self.pair.tolerance;
        let mut best = patch.piece.iter().sum::<Vec3A>() / patch.piece.len() as f32;
        self.body.for_each_plane(|normal, plane| {
            patch.cut(normal, plane + tolerance);
            if !patch.piece.is_empty() {
                best = patch.piece.iter().sum::<Vec3A>() / patch.piece.len() as f32;
            }
        });
        patch.add_point(best, claims[claim].way.depth);
        best
    }
}

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;
