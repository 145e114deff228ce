//! Rays against placed shapes.

use std::ops::ControlFlow;

use bevy::math::{DVec3, Dir3, Vec3, Vec3A};

use crate::broad_phase::Sweep;
use crate::narrow_phase::{
    answer::{Impact, against, slack},
    frame::{placed::Placed, surface::winds_around},
    mesh::polygon_mesh::PolygonMesh,
    parry,
    settings::NarrowPhase,
    shape::{Kind, Shape},
};

/// How close to its border a point counts as on a polygon, as a share of the distances at hand:
/// more than the rounding of 64-bit floats, so that no ray slips through where polygons join.
const BORDER: f64 = 1e-9;
/// The sine of the angle below which a ray counts as along a plane.
const ALONG: f64 = 1e-12;
/// The least scale along an axis, as a share of the greatest: a shape flattened by a scale of zero
/// is so thick to rays.
const FLAT: f64 = 1e-7;

impl NarrowPhase {
    /// Casts a ray against a shape: returns where it first meets it, if it does so within
    /// `max_distance`.
    ///
    /// Exact for every kind of shape, wherever the ray starts. One rule holds for all: a shape has
    /// its border, and is solid if it is closed. A ray that starts inside or on it meets it at
    /// once, whichever way it goes, as does a shape [on its way](Self::sweep) that touches another
    /// at the start; on it is what is so but for the rounding of 32-bit floats. To go on from a
    /// surface that was met, leave its entity out, or start a little off. Polygons that bound no
    /// solid are met from both sides, and at their border by rays that run along them. A shape that
    /// a scale of zero shrinks to a point is met by rays that start there only. `None` too if
    /// anything is not finite, but for `max_distance`, or that is negative or NaN.
    ///
    /// Allocates nothing, but for a mesh that is a shape of Rapier's. Cuboids, spheres: O(1);
    /// meshes: linear in their polygons.
    ///
    /// ```
    /// use bevy::{math::{Dir3, Vec3}, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape};
    ///
    /// let (ball, at) = (Shape::sphere(1.0), Transform::from_xyz(5.0, 0.0, 0.0));
    /// let hit = NarrowPhase::default().cast_ray(Placed::new(&ball, &at), Vec3::ZERO, Dir3::X, 100.0).unwrap();
    /// assert_eq!((hit.distance, hit.point, hit.normal), (4.0, Vec3::X * 4.0, Vec3::NEG_X));
    /// ```
    #[doc(alias = "raycast")]
    #[must_use]
    pub fn cast_ray(
        &self,
        target: Placed,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
    ) -> Option<Impact> {
        if !(max_distance >= 0.0
            && origin.is_finite()
            && direction.is_finite()
            && target.transform.is_finite()
            && target.shape.is_finite())
        {
            return None;
        }
        if target.shape.kind() == Kind::Foreign {
            return match parry::as_own(target) {
                Some((own, at)) => {
                    self.cast_ray(Placed::new(&own, &at), origin, direction, max_distance)
                }
                None => parry::cast_ray(target, origin, direction, max_distance),
            };
        }
        let ray = LocalRay::new(target, origin, direction)?;
        let met = match target.shape {
            Shape::Cuboid { half_size } => ray.cuboid(half_size.abs().as_dvec3()),
            Shape::Sphere { radius } => ray.sphere(f64::from(radius.abs())),
            Shape::Convex(mesh) => ray.convex(mesh),
            Shape::Mesh(mesh) => ray.mesh(mesh, f64::from(max_distance)),
            #[cfg(feature = "rapier")]
            Shape::Rapier(_) => None,
        }?;
        let distance = met.distance as f32;
        (distance <= max_distance && distance.is_finite()).then(|| Impact {
            distance,
            point: (origin.as_dvec3() + direction.as_dvec3() * met.distance).as_vec3(),
            normal: met.normal.map_or(-*direction, |normal| {
                ray.to_world(normal, target, direction)
            }),
        })
    }
}

/// A ray in the coordinates of a shape, in which distances along it are those in the world. In
/// double precision, so that neither the scale nor the way from afar costs exactness.
struct LocalRay {
    origin: DVec3,
    direction: DVec3,
    scale: DVec3,
    /// How far off a shape the ray may start and count as on it, in the world.
    slack: f64,
}

/// Where a ray meets a shape, in the shape's coordinates. No normal, if the ray starts inside.
struct Met {
    distance: f64,
    normal: Option<DVec3>,
}

impl Met {
    const INSIDE: Self = Self {
        distance: 0.0,
        normal: None,
    };
}

impl LocalRay {
    fn new(target: Placed, origin: Vec3, direction: Dir3) -> Option<Self> {
        let scale = target
            .shape
            .effective_scale(target.transform.scale)
            .as_dvec3();
        let least = FLAT * scale.abs().max_element();
        let scale = DVec3::select(
            scale.abs().cmplt(DVec3::splat(least)),
            DVec3::splat(least),
            scale,
        );
        let back = target
            .transform
            .rotation
            .normalize()
            .as_dquat()
            .normalize()
            .inverse();
        let from_center = origin.as_dvec3() - target.transform.translation.as_dvec3();
        let (origin_in_shape, along) = (
            back * from_center / scale,
            back * direction.as_dvec3() / scale,
        );
        let slack = slack(origin, from_center);
        let ray = Self {
            origin: origin_in_shape,
            direction: along,
            scale,
            slack,
        };
        (ray.origin.is_finite() && ray.direction.is_finite()).then_some(ray)
    }

    /// Normals scale inversely. Turned against the ray, whichever side of a polygon it meets.
    fn to_world(&self, normal: DVec3, target: Placed, direction: Dir3) -> Vec3 {
        let scaled = (normal / self.scale).normalize_or_zero().as_vec3();
        against(
            (target.transform.rotation.normalize() * scaled).normalize_or(-*direction),
            direction,
        )
    }

    /// How high the start is over a plane, in the world.
    fn height(&self, height: f64, normal: DVec3) -> f64 {
        height / (normal / self.scale).length()
    }

    fn cuboid(&self, half: DVec3) -> Option<Met> {
        if ((self.origin.abs() - half) * self.scale.abs()).max_element() <= self.slack {
            return Some(Met::INSIDE);
        }
        let mut pass = Passage::default();
        for axis in 0..3 {
            let unit = DVec3::AXES[axis];
            pass.clip(self.origin[axis] - half[axis], self.direction[axis], unit)?;
            pass.clip(
                -self.origin[axis] - half[axis],
                -self.direction[axis],
                -unit,
            )?;
        }
        Some(pass.met())
    }

    fn convex(&self, mesh: &PolygonMesh) -> Option<Met> {
        let mut pass = Some(Passage::default());
        let mut highest = f64::NEG_INFINITY;
        for (corners, normal) in mesh.polygons().zip(mesh.normals()) {
            let normal = normal.as_dvec3();
            let height = normal.dot(self.origin - vertex(mesh, corners[0]));
            highest = highest.max(self.height(height, normal));
            pass = pass.and_then(|pass| pass.clipped(height, normal.dot(self.direction), normal));
            if pass.is_none() && highest > self.slack {
                return None;
            }
        }
        if highest <= self.slack {
            Some(Met::INSIDE)
        } else {
            pass.map(Passage::met)
        }
    }

    fn sphere(&self, radius: f64) -> Option<Met> {
        if (self.origin.length() - radius) * self.scale.x.abs() <= self.slack {
            return Some(Met::INSIDE);
        }
        // From the point of the ray that is closest to the centre.
        let (squared, along) = (
            self.direction.length_squared(),
            -self.origin.dot(self.direction),
        );
        let closest = self.origin + self.direction * (along / squared);
        let room = radius * radius - closest.length_squared();
        if along < 0.0 || room < 0.0 {
            return None;
        }
        let distance = ((along - (room * squared).sqrt()) / squared).max(0.0);
        Some(Met {
            distance,
            normal: Some(self.origin + self.direction * distance),
        })
    }

    fn mesh(&self, mesh: &PolygonMesh, max_distance: f64) -> Option<Met> {
        let (center, half, radius) = mesh.local_bounds();
        let from_center = self.origin - center.as_dvec3();
        // A rounded box may leave out what is on its side.
        let slack = BORDER * (f64::from(radius) + from_center.length());
        let within = from_center.abs().cmple(half.as_dvec3() + slack).all();
        if within && self.is_inside(mesh) {
            return Some(Met::INSIDE);
        }
        let on = slack.max(self.slack / self.scale.abs().max_element());
        let mut first = First {
            met: None,
            polygon: 0,
            limit: max_distance,
        };
        let Some(tree) = mesh.tree() else {
            for polygon in 0..mesh.polygon_count() {
                if self
                    .polygon(mesh, polygon, slack, on, &mut first)
                    .is_break()
                {
                    return Some(Met::INSIDE);
                }
            }
            return first.met;
        };
        // The tree's numbers are of 32 bits: from near the mesh, they are exact enough.
        let speed = self.direction.length();
        let skipped = ((from_center.length() - f64::from(radius)) / speed
            - f64::from(radius) / speed)
            .max(0.0);
        let origin = self.origin + self.direction * skipped;
        let reach = on.max(
            8.0 * f64::from(f32::EPSILON) * (center.as_dvec3().length() + 4.0 * f64::from(radius)),
        );
        let left = |limit: f64| ((limit - skipped) as f32).next_up();
        if left(max_distance) < 0.0 {
            return None;
        }
        let (mut inside, reach) = (false, Vec3A::splat(reach as f32));
        let (origin, way) = (origin.as_vec3a(), self.direction.as_vec3a());
        let (measure, limit) = Sweep::along(origin, way, -reach, reach, left(max_distance));
        tree.search(&measure, limit, |polygon, _| {
            inside |= self
                .polygon(mesh, polygon as usize, slack, on, &mut first)
                .is_break();
            if inside {
                return ControlFlow::Break(());
            }
            // It is a little off.
            ControlFlow::Continue(left(first.limit) * (1.0 + 4.0 * f32::EPSILON))
        });
        if inside { Some(Met::INSIDE) } else { first.met }
    }

    fn is_inside(&self, mesh: &PolygonMesh) -> bool {
        if mesh.tree().is_some() {
            return mesh.winds_around(self.origin);
        }
        winds_around(mesh, |corner| {
            (vertex(mesh, corner) - self.origin)
                .normalize_or_zero()
                .as_vec3a()
        })
    }

    /// Meets a polygon, if it is the first so far; breaks if the ray starts on it.
    fn polygon(
        &self,
        mesh: &PolygonMesh,
        polygon: usize,
        slack: f64,
        on: f64,
        first: &mut First,
    ) -> ControlFlow<()> {
        let (corners, normal) = (mesh.polygon(polygon), mesh.normals()[polygon].as_dvec3());
        let steep = normal.dot(self.direction);
        let height = normal.dot(self.origin - vertex(mesh, corners[0]));
        let distance = -height / steep;
        if self.height(height, normal).abs() <= self.slack {
            if is_on_polygon(mesh, corners, normal, self.origin, on) {
                return ControlFlow::Break(());
            }
            // Along the plane.
            if steep.abs() <= ALONG * self.direction.length()
                && let Some(distance) = self.border(mesh, corners, normal, slack)
                && distance <= first.limit
            {
                first.meet(
                    polygon,
                    Met {
                        distance,
                        normal: None,
                    },
                );
                return ControlFlow::Continue(());
            }
        }
        // Not for a ray within the plane, for which this is not a number, or infinite.
        if distance >= 0.0 && distance <= first.limit {
            let point = self.origin + self.direction * distance;
            if is_on_polygon(mesh, corners, normal, point, slack) {
                first.meet(
                    polygon,
                    Met {
                        distance,
                        normal: Some(normal),
                    },
                );
            }
        }
        ControlFlow::Continue(())
    }
}

/// What a ray meets first, of what it was asked about so far.
struct First {
    met: Option<Met>,
    polygon: usize,
    limit: f64,
}

impl First {
    /// Of several at the same distance, the last in the order of the mesh counts, in whatever order
    /// they come.
    fn meet(&mut self, polygon: usize, met: Met) {
        if met.distance < self.limit || self.met.is_none() || polygon > self.polygon {
            (self.limit, self.polygon) = (met.distance, polygon);
            self.met = Some(met);
        }
    }
}

impl LocalRay {
    /// How far a ray in the plane of a polygon, but not on it, goes to its border.
    fn border(
        &self,
        mesh: &PolygonMesh,
        corners: &[u32],
        normal: DVec3,
        slack: f64,
    ) -> Option<f64> {
        let across = normal.cross(self.direction);
        let distances = corners
            .iter()
            .zip(corners.iter().cycle().skip(1))
            .filter_map(|(a, b)| {
                let (a, b) = (
                    vertex(mesh, *a) - self.origin,
                    vertex(mesh, *b) - self.origin,
                );
                let [at_a, at_b] = [a, b].map(|end| end.dot(across));
                let is_ahead = at_a.min(at_b) <= slack * across.length()
                    && at_a.max(at_b) >= -slack * across.length();
                // Those along the ray have neighbours that are not.
                let share = (at_a / (at_a - at_b)).clamp(0.0, 1.0);
                let met = a.lerp(b, share).dot(self.direction) / self.direction.length_squared();
                (is_ahead && met >= 0.0).then_some(met)
            });
        distances.min_by(f64::total_cmp)
    }
}

fn vertex(mesh: &PolygonMesh, index: u32) -> DVec3 {
    mesh.vertices()[index as usize].as_dvec3()
}

/// Is a point in the plane of a polygon inside its border, by the even-odd rule, or on it?
fn is_on_polygon(
    mesh: &PolygonMesh,
    corners: &[u32],
    normal: DVec3,
    point: DVec3,
    slack: f64,
) -> bool {
    // Seen along the axis that shows most of it.
    let (x, y) = match normal.abs().max_position() {
        0 => (1, 2),
        1 => (2, 0),
        _ => (0, 1),
    };
    let mut inside = false;
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (a, b) = (vertex(mesh, *a), vertex(mesh, *b));
        let (along, to_point) = (b - a, point - a);
        let closest = a + along * (to_point.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        if closest.distance_squared(point) <= slack * slack {
            return true;
        }
        if (a[y] > point[y]) != (b[y] > point[y]) {
            inside ^= a[x] + along[x] * ((point[y] - a[y]) / along[y]) > point[x];
        }
    }
    inside
}

/// The part of a ray inside all half-spaces so far.
struct Passage {
    enter: f64,
    leave: f64,
    normal: Option<DVec3>,
}

impl Default for Passage {
    fn default() -> Self {
        Self {
            enter: 0.0,
            leave: f64::INFINITY,
            normal: None,
        }
    }
}

impl Passage {
    fn clipped(mut self, height: f64, climb: f64, normal: DVec3) -> Option<Self> {
        self.clip(height, climb, normal)?;
        Some(self)
    }

    /// Goes on with the part that is in a half-space too, if there is one: the origin is at a
    /// height above its plane, and climbs.
    fn clip(&mut self, height: f64, climb: f64, normal: DVec3) -> Option<()> {
        if climb < 0.0 {
            let enter = -height / climb;
            if height > 0.0 && enter >= self.enter {
                (self.enter, self.normal) = (enter, Some(normal));
            }
        } else if climb > 0.0 {
            self.leave = self.leave.min(-height / climb);
        } else if height > 0.0 {
            return None;
        }
        (self.enter <= self.leave).then_some(())
    }

    fn met(self) -> Met {
        Met {
            distance: self.enter,
            normal: self.normal,
        }
    }
}
