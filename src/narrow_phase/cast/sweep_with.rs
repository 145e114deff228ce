//! Shapes on their way, by options.

use bevy::math::{Dir3, Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::{lift, nearest_polygon::nearest_polygon};
use crate::narrow_phase::{
    answer::{Contact, Impact},
    cast_options::ShapeCastOptions,
    frame::{
        edge_polygon,
        placed::{Placed, PlacedPair, in_order},
        workspace::Workspace,
    },
    settings::NarrowPhase,
    shape::Kind,
};

/// The sine of the angle up to which a shape goes along what it touches: what it then sinks by more
/// than rounding is met on the way.
const ALONG: f32 = 1e-3;

/// So many normals are tried where two meshes meet.
const MOST_NORMALS: usize = 8;
/// The cosine of the angle between normals that are as one.
const ALIKE: f32 = 0.9999;

impl NarrowPhase {
    /// Casts a shape that moves without turning against another, as [`sweep`](Self::sweep) does, but
    /// by these options. With the default ones, it does the same, for the same price.
    ///
    /// What is [ignored at the start](ShapeCastOptions::ignore_start) is so by the normal of the
    /// [contact](Self::contact): if the shape does not go against it, it counts as lifted off the
    /// other by the depth of the contact and some tolerances, and goes on from there. So a shape
    /// that stands on a floor meets the wall at its end, though both are one mesh, and no seams on
    /// the way; and all else is met to within these tolerances.
    ///
    /// ```
    /// use bevy::{math::{Dir3, Vec3}, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, ShapeCastOptions, Workspace};
    ///
    /// let (floor, ball) = (Shape::cuboid(9.0, 1.0, 9.0), Shape::sphere(0.5));
    /// let (below, here) = (Transform::from_xyz(0.0, -1.0, 0.0), Transform::IDENTITY);
    /// let (floor, ball) = (Placed::new(&floor, &below), Placed::new(&ball, &here));
    /// let (tests, onward) = (NarrowPhase::default(), ShapeCastOptions::DEFAULT.ignore_start());
    /// let mut workspace = Workspace::default();
    /// let mut hit = |way, options| tests.sweep_with(ball, way, 9.0, floor, options, &mut workspace).map(|hit| hit.distance);
    /// assert_eq!(hit(Dir3::X, &ShapeCastOptions::DEFAULT), Some(0.0));
    /// assert_eq!(hit(Dir3::X, &onward), None);
    /// assert_eq!(hit(Dir3::NEG_Y, &onward), Some(0.0)); // into it
    /// ```
    #[must_use]
    pub fn sweep_with(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        target: Placed,
        options: &ShapeCastOptions,
        workspace: &mut Workspace,
    ) -> Option<Impact> {
        let met = if options.ignores_start && direction.is_finite() && max_distance >= 0.0 {
            self.sweep_off(moving, direction, max_distance, target, workspace)
        } else {
            self.sweep(moving, direction, max_distance, target, workspace)
        }?;
        Some(if options.finds_polygon {
            on_polygon(met, target)
        } else {
            met
        })
    }

    /// From where the shape touches nothing that it does not go into.
    fn sweep_off(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        target: Placed,
        workspace: &mut Workspace,
    ) -> Option<Impact> {
        let sweep = |moving: Placed, distance: f32, workspace: &mut Workspace| {
            self.sweep(moving, direction, distance, target, workspace)
        };
        let counters = workspace.counters;
        if !self.intersects(moving, target, workspace) {
            workspace.counters = counters;
            return sweep(moving, max_distance, workspace);
        }
        let are_convex = [moving, target]
            .iter()
            .all(|one| one.shape.kind().is_convex());
        let are_meshes = [moving, target]
            .iter()
            .all(|one| one.shape.kind() == Kind::Mesh);
        let margin = lift::margin(self, moving.transform.translation);
        let mut lifted = *moving.transform;
        for _ in 0..lift::MOST_LIFTS {
            let now = Placed::new(moving.shape, &lifted);
            let contact = self.contact_in_passing(now, target, |_| *direction, workspace);
            let Some(Contact {
                normal,
                point,
                depth,
            }) = contact
            else {
                break;
            };
            let way_off = if are_meshes {
                self.way_off(now, target, margin, workspace)
            } else {
                Some(-normal * (depth + margin))
            };
            let Some(way) = way_off else {
                return sweep(moving, max_distance, workspace);
            };
            let out = way.normalize();
            if out.dot(*direction) < -ALONG {
                return Some(Impact {
                    distance: 0.0,
                    point,
                    normal: out,
                    face_normal: out,
                    polygon: None,
                    depth: (way.length() - margin).max(0.0),
                });
            }
            // Two that are convex, and part, do not meet again.
            if are_convex {
                return None;
            }
            lifted.translation += way;
        }
        // How much nearer it is to what is ahead, by that.
        let ahead = (lifted.translation - moving.transform.translation).dot(*direction);
        let now = Placed::new(moving.shape, &lifted);
        let met = sweep(now, (max_distance - ahead).max(0.0), workspace)?;
        Some(Impact {
            distance: if met.distance > 0.0 {
                (met.distance + ahead).max(0.0)
            } else {
                0.0
            },
            ..met
        })
    }

    /// A way off another mesh, no shorter than given: about the shortest of those along the normals
    /// of faces where the two meet. The contact of two meshes of any form only has an estimate.
    fn way_off(
        &self,
        moving: Placed,
        target: Placed,
        shortest: f32,
        workspace: &mut Workspace,
    ) -> Option<Vec3> {
        let (first, second, _) = in_order(moving, target);
        let pair = PlacedPair::new(first, second, self.tolerance()).ok()?;
        let (mut normals, mut count) = ([Vec3A::ZERO; MOST_NORMALS], 0);
        edge_polygon::touches(&pair, workspace, |hit| {
            let is_new = normals[..count]
                .iter()
                .all(|normal| normal.dot(hit.normal).abs() < ALIKE);
            if is_new && count < MOST_NORMALS {
                normals[count] = hit.normal;
                count += 1;
            }
        });
        let longest = pair.box_a.radius.min(pair.box_b.radius);
        let mut length = shortest;
        loop {
            for normal in &normals[..count] {
                for way in [*normal * length, -*normal * length].map(Vec3::from) {
                    let there = Transform {
                        translation: moving.transform.translation + way,
                        ..*moving.transform
                    };
                    if !self.intersects(Placed::new(moving.shape, &there), target, workspace) {
                        return Some(way);
                    }
                }
            }
            if length > longest || !length.is_finite() {
                return None;
            }
            length *= 2.0;
        }
    }
}

/// With the polygon that the point of an impact is on: of several, the one that faces most as the
/// impact's normal does.
fn on_polygon(met: Impact, target: Placed) -> Impact {
    let found = target.shape.own_mesh().and_then(|mesh| {
        let Transform {
            translation,
            rotation,
            scale,
        } = *target.transform;
        let (turn, scale) = (rotation.as_dquat().normalize(), scale.as_dvec3());
        let back = |v: Vec3| turn.inverse() * v.as_dvec3();
        let point = turn.inverse() * (met.point.as_dvec3() - translation.as_dvec3());
        let (polygon, normal) = nearest_polygon(mesh, point, scale, back(met.normal))?;
        let normal = (turn * normal).as_vec3().try_normalize()?;
        Some((polygon, normal))
    });
    found.map_or(met, |(polygon, face_normal): (u32, Vec3)| Impact {
        face_normal,
        polygon: Some(target.shape.source(polygon)),
        ..met
    })
}

#[cfg(test)]
mod tests;
