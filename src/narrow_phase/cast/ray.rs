//! Rays against placed shapes.

use std::ops::ControlFlow;

use bevy::math::{DVec3, Dir3, Vec3, Vec3A};

use super::local_ray::{BORDER, LocalRay, ROUGHLY, exact_normal, is_on_polygon, limit, vertex};
use crate::broad_phase::Sweep;
use crate::narrow_phase::{
    answer::Impact,
    cast_options::RayCastOptions,
    frame::{apart, chord::Met, placed::Placed},
    mesh::polygon_mesh::PolygonMesh,
    settings::NarrowPhase,
    shape::Shape,
    support,
};

/// How near to its border a polygon is met that does not tell from which side, as a share of the size of
/// the mesh: where it joins another, the numbers do not say for sure which of the two is met first.
const BESIDE: f64 = 1e-5;
/// The sine of the angle below which the same holds for what is met.
const GRAZING: f64 = 0.02;
/// The sine of the angle below which a ray counts as along a plane.
pub const ALONG: f64 = 1e-12;

impl NarrowPhase {
    /// Casts a ray against a shape: returns where it first meets it, if it does so within
    /// `max_distance`.
    ///
    /// Exact for every kind of shape, wherever the ray starts. One rule holds for all: a shape has
    /// its border, and is solid if it is closed. A ray that starts inside or on it meets it at
    /// once, whichever way it goes, as does a shape [on its way](Self::sweep) that touches another
    /// at the start; on it is what is so but for the rounding of 32-bit floats. To go on from a
    /// surface that was met, see [`RayCastOptions::ignore_start`]. Polygons that bound no
    /// solid are met from both sides, and at their border by rays that run along them. A shape that
    /// a scale of zero shrinks to a point is met by rays that start there only. `None` too if
    /// anything is not finite, but for `max_distance`, or that is negative or NaN.
    ///
    /// Allocates nothing, but for a mesh that is a shape of Rapier's. Cuboids, spheres: O(1); convex
    /// meshes: linear in their polygons; meshes: O(log n) for each polygon that comes into question.
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
        if !(max_distance >= 0.0 && target.shape.is_finite()) {
            return None;
        }
        if target.shape.is_cast_by_support() {
            if !is_askable(target, origin, direction, max_distance) {
                return None;
            }
            return match support::as_own(target) {
                Some((own, at)) => {
                    self.cast_ray(Placed::new(&own, &at), origin, direction, max_distance)
                }
                None => support::cast_ray(target, origin, direction, roomy(max_distance))
                    .filter(|hit| hit.distance <= max_distance),
            };
        }
        if let Shape::Mesh(mesh) = target.shape
            && mesh.tree().is_none()
            && !LocalRay::may_meet(mesh, target, origin, direction, max_distance)
        {
            return None;
        }
        let ray = LocalRay::new(target, origin, direction)?;
        let met = match target.shape {
            Shape::Cuboid { half_size } => ray.cuboid(half_size.abs().as_dvec3()),
            Shape::Sphere { radius } => ray.sphere(f64::from(radius.abs())),
            Shape::Convex(mesh) => ray.convex(mesh),
            Shape::Mesh(mesh) => ray.mesh(mesh, limit(max_distance)),
            _ => ray.chord(target)?.met(&RayCastOptions::DEFAULT, ray.slack),
        }?;
        ray.impact(target, (origin, direction), max_distance, met)
    }

    /// Casts a ray as [`cast_ray`](Self::cast_ray) does, but meets of the shape what the options
    /// say. With the default ones, it does the same, for the same price.
    ///
    /// A shape of Rapier's that is none of cuboid and ball is met by its parts: where the parts of
    /// a compound overlap, the walls inside are walls. Of shapes of somebody else's making that have
    /// no parts, only whether they are hollow can be asked.
    ///
    /// Allocates nothing. Meshes: O(log n) for each polygon that comes into question, for solids
    /// that may be twice as many as for [`cast_ray`](Self::cast_ray).
    ///
    /// ```
    /// use bevy::{math::{Dir3, Vec3}, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, RayCastOptions, Shape};
    ///
    /// let (brick, at) = (Shape::cuboid(2.0, 2.0, 2.0), Transform::from_xyz(5.0, 0.0, 0.0));
    /// let (brick, back) = (Placed::new(&brick, &at), RayCastOptions::DEFAULT.back_faces());
    /// let hit = NarrowPhase::default().cast_ray_with(brick, Vec3::ZERO, Dir3::X, 100.0, &back).unwrap();
    /// assert_eq!((hit.distance, hit.normal, hit.face_normal), (6.0, Vec3::NEG_X, Vec3::X));
    /// ```
    #[must_use]
    pub fn cast_ray_with(
        &self,
        target: Placed,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
        options: &RayCastOptions,
    ) -> Option<Impact> {
        if *options == RayCastOptions::DEFAULT {
            return self.cast_ray(target, origin, direction, max_distance);
        }
        if !is_askable(target, origin, direction, max_distance) {
            return None;
        }
        if target.shape.is_cast_by_support() {
            return match support::as_own(target) {
                Some((own, at)) => {
                    let own = Placed::new(&own, &at);
                    self.cast_ray_with(own, origin, direction, max_distance, options)
                }
                None => {
                    let within = roomy(max_distance);
                    support::cast_ray_with(target, origin, direction, within, options)
                        .filter(|hit| hit.distance <= max_distance)
                }
            };
        }
        let ray = LocalRay::new(target, origin, direction)?;
        let met = match target.shape {
            Shape::Mesh(mesh) => ray.mesh_with(mesh, limit(max_distance), options),
            _ => ray.chord(target)?.met(options, ray.slack),
        }?;
        ray.impact(target, (origin, direction), max_distance, met)
    }
}

/// A little more than a distance: tests in 32 bits do not find again within a distance what they
/// met as far away.
fn roomy(distance: f32) -> f32 {
    (distance * (1.0 + 8.0 * f32::EPSILON)).next_up()
}

/// Is all finite that has to be?
pub fn is_askable(target: Placed, origin: Vec3, direction: Dir3, max_distance: f32) -> bool {
    max_distance >= 0.0
        && origin.is_finite()
        && direction.is_finite()
        && target.transform.is_finite()
        && target.shape.is_finite()
}

impl LocalRay {
    fn cuboid(&self, half: DVec3) -> Option<Met> {
        if ((self.origin.abs() - half) * self.scale.abs()).max_element() <= self.slack {
            return Some(Met::INSIDE);
        }
        let mut pass = Passage::default();
        for axis in 0..3 {
            let unit = DVec3::AXES[axis];
            pass.clip(
                self.origin[axis] - half[axis],
                self.direction[axis],
                unit,
                None,
            )?;
            pass.clip(
                -self.origin[axis] - half[axis],
                -self.direction[axis],
                -unit,
                None,
            )?;
        }
        Some(pass.met())
    }

    fn convex(&self, mesh: &PolygonMesh) -> Option<Met> {
        let mut pass = Some(Passage::default());
        let mut highest = f64::NEG_INFINITY;
        for (polygon, (corners, normal)) in mesh.polygons().zip(mesh.normals()).enumerate() {
            let normal = normal.as_dvec3();
            let height = normal.dot(self.origin - vertex(mesh, corners[0]));
            highest = highest.max(self.height(height, normal));
            let climb = normal.dot(self.direction);
            pass = pass.and_then(|pass| pass.clipped(height, climb, normal, Some(polygon as u32)));
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
        let face = self.origin + self.direction * distance;
        Some(Met::crossing(distance, face, None))
    }

    fn mesh(&self, mesh: &PolygonMesh, max_distance: f64) -> Option<Met> {
        let (center, half, radius) = mesh.local_bounds();
        let from_center = self.origin - center.as_dvec3();
        // A rounded box may leave out what is on its side.
        let slack = BORDER * (f64::from(radius) + from_center.abs().element_sum());
        let within = from_center.abs().cmple(half.as_dvec3() + slack).all();
        // The face that is met may say from which side it is. Of polygons that are not quite in one plane,
        // a ray may pass between two.
        let is_told = within && mesh.triangles().is_some() && apart::tells_sides(mesh);
        if within && !is_told && self.is_inside(mesh) {
            return Some(Met::INSIDE);
        }
        let (met, is_doubtful) = self.surface(mesh, max_distance, slack);
        if !is_told {
            return met;
        }
        let side = match met {
            _ if is_doubtful => None,
            Some(met) => self.is_from_inside(mesh, &met),
            None => self.leaves(mesh, max_distance).then_some(false),
        };
        if side.unwrap_or_else(|| self.is_inside(mesh)) {
            Some(Met::INSIDE)
        } else {
            met
        }
    }

    /// Whether the ray, which starts in the box of a mesh, certainly ends beyond it.
    fn leaves(&self, mesh: &PolygonMesh, max_distance: f64) -> bool {
        let (_, half, _) = mesh.local_bounds();
        // The way through the box is no longer than its diagonal, nor that than its sides.
        let (through, speed) = (half.element_sum(), self.direction.abs().max_element());
        max_distance * speed > 2.0 * f64::from(through) * (1.0 + f64::from(ROUGHLY))
    }

    /// Whether a triangle of a solid is met from within; `None` if that is not certain.
    fn is_from_inside(&self, mesh: &PolygonMesh, met: &Met) -> Option<bool> {
        let corners = mesh.polygon(met.polygon? as usize).try_into().ok()?;
        let steep = met.face?.dot(self.direction);
        let (_, _, radius) = mesh.local_bounds();
        let least = BESIDE * f64::from(radius) * self.direction.abs().element_sum();
        let is_clear = met.crosses
            && steep * steep > self.grazing()
            && self.passes_within(mesh, corners, least) == Some(true);
        is_clear.then_some(steep > 0.0)
    }

    /// The square of how much the ray rises over a plane that it grazes, at most.
    fn grazing(&self) -> f64 {
        GRAZING * GRAZING * self.direction.length_squared()
    }

    /// Where the ray first meets the surface of a mesh, and whether it is uncertain that nothing of it is
    /// met before.
    fn surface(&self, mesh: &PolygonMesh, max_distance: f64, slack: f64) -> (Option<Met>, bool) {
        let (center, _, radius) = mesh.local_bounds();
        let from_center = self.origin - center.as_dvec3();
        let doubt = Doubt::of(self, slack);
        let mut first = First::within(max_distance);
        let Some(tree) = mesh.tree() else {
            for polygon in 0..mesh.polygon_count() {
                let flow = self.polygon(mesh, polygon, &doubt, &mut first);
                if let ControlFlow::Break(start) = flow {
                    return (Some(start), false);
                }
            }
            return (first.met, first.is_doubtful);
        };
        // The tree's numbers are of 32 bits: from near the mesh, they are exact enough.
        let near = 2.0 * f64::from(radius);
        let squared = from_center.length_squared();
        let skipped = if squared > near * near {
            ((squared.sqrt() - near) / self.direction.length()).max(0.0)
        } else {
            0.0
        };
        let origin = self.origin + self.direction * skipped;
        let reach = doubt.start.max(
            8.0 * f64::from(f32::EPSILON) * (center.as_dvec3().length() + 4.0 * f64::from(radius)),
        );
        // It is a little off.
        let left = |limit: f64| (limit - skipped) as f32 * (1.0 + 4.0 * f32::EPSILON);
        if left(max_distance) < 0.0 {
            return (None, false);
        }
        let (mut start, reach) = (None, Vec3A::splat(reach as f32));
        let (origin, way) = (origin.as_vec3a(), self.direction.as_vec3a());
        let (measure, mut limit) = Sweep::along(origin, way, -reach, reach, left(max_distance));
        tree.search(&measure, limit, |polygon, _| {
            let before = first.limit;
            let flow = self.polygon(mesh, polygon as usize, &doubt, &mut first);
            if let ControlFlow::Break(found) = flow {
                start = Some(found);
                return ControlFlow::Break(());
            }
            if first.limit < before {
                limit = left(first.limit);
            }
            ControlFlow::Continue(limit)
        });
        (start.or(first.met), first.is_doubtful)
    }

    /// Meets a polygon, if it is the first so far; breaks if the ray starts on it.
    #[inline]
    fn polygon(
        &self,
        mesh: &PolygonMesh,
        polygon: usize,
        doubt: &Doubt,
        first: &mut First,
    ) -> ControlFlow<Met> {
        let (corners, normal) = (mesh.polygon(polygon), mesh.normals()[polygon].as_dvec3());
        let steep = normal.dot(self.direction);
        let height = normal.dot(self.origin - vertex(mesh, corners[0]));
        let distance = -height / steep;
        if height.abs() <= doubt.plane && self.height(height, normal).abs() <= self.slack {
            if is_on_polygon(mesh, corners, normal, self.origin, doubt.start) {
                let start = Met::touching(0.0, normal, Some(polygon as u32));
                return ControlFlow::Break(start);
            }
            // Along the plane.
            if steep.abs() <= ALONG * self.direction.length()
                && let Some(distance) = self.border(mesh, corners, normal, doubt.border)
                && distance <= first.limit
            {
                first.meet(Met::touching(distance, normal, Some(polygon as u32)));
                return ControlFlow::Continue(());
            }
        }
        // Not for a ray within the plane, for which this is not a number, or infinite.
        let is_in_reach = distance >= 0.0 && distance <= first.limit;
        let is_grazed = steep * steep <= doubt.grazing;
        if !is_in_reach && !is_grazed {
            return ControlFlow::Continue(());
        }
        let passes = match *corners {
            [a, b, c] => self.passes_within(mesh, [a, b, c], doubt.volume),
            _ => None,
        };
        if passes == Some(false) {
            return ControlFlow::Continue(());
        }
        // Where it is met may be far off then.
        first.is_doubtful |= is_grazed;
        if !is_in_reach {
            return ControlFlow::Continue(());
        }
        let mut distance = distance;
        if is_grazed || passes.is_none() {
            let exact = exact_normal(mesh, corners).unwrap_or(normal);
            let height = exact.dot(self.origin - vertex(mesh, corners[0]));
            distance = -height / exact.dot(self.direction);
            let point = self.origin + self.direction * distance;
            let is_on =
                || passes.is_some() || is_on_polygon(mesh, corners, exact, point, doubt.border);
            if !(distance >= 0.0 && distance <= first.limit && is_on()) {
                return ControlFlow::Continue(());
            }
        }
        first.meet(Met::crossing(distance, normal, Some(polygon as u32)));
        ControlFlow::Continue(())
    }

    /// Whether the line of the ray passes through a triangle, if that is certain: further than is
    /// in doubt from all of its sides.
    ///
    /// Which side of a segment it passes is the sign of the volume that the two span, if that is larger
    /// than what is in doubt of the ray and a segment of length 1.
    #[inline]
    fn passes_within(&self, mesh: &PolygonMesh, corners: [u32; 3], doubt: f64) -> Option<bool> {
        let [a, b, c] = corners.map(|corner| vertex(mesh, corner) - self.origin);
        let volume = |from: DVec3, to: DVec3| self.direction.dot(from.cross(to));
        let volumes = [volume(a, b), volume(b, c), volume(c, a)];
        // No side is longer than the sum of two others.
        let (one, other) = ((b - a).abs(), (c - a).abs());
        let least = doubt * (one + other).element_sum();
        let [over, under] = [
            volumes.map(|volume| volume > least),
            volumes.map(|volume| volume < -least),
        ];
        let (all, any) = (
            |of: [bool; 3]| of[0] & of[1] & of[2],
            |of: [bool; 3]| of[0] | of[1] | of[2],
        );
        if all(over) | all(under) {
            Some(true)
        } else if any(over) & any(under) {
            Some(false)
        } else {
            None
        }
    }
}

/// What is in doubt of a ray and the polygons of a mesh, in the coordinates of the mesh.
struct Doubt {
    /// How near to its border a point counts as on a polygon.
    border: f64,
    /// The same for the start.
    start: f64,
    /// How high over a plane the start may be, at most, that counts as on it.
    plane: f64,
    /// How large a volume is certain, of the ray and a segment of length 1.
    volume: f64,
    grazing: f64,
}

impl Doubt {
    fn of(ray: &LocalRay, border: f64) -> Self {
        let scale = ray.scale.abs();
        Self {
            border,
            start: border.max(ray.slack / scale.max_element()),
            plane: ray.slack / scale.min_element(),
            volume: border * ray.direction.abs().element_sum(),
            grazing: ray.grazing(),
        }
    }
}

/// What a ray meets first, of what it was asked about so far.
pub struct First {
    pub met: Option<Met>,
    pub limit: f64,
    /// May something be met before that was not?
    is_doubtful: bool,
}

impl First {
    pub fn within(limit: f64) -> Self {
        Self {
            met: None,
            limit,
            is_doubtful: false,
        }
    }

    /// Of several at the same distance, the last in the order of the mesh counts, in whatever order
    /// they come.
    pub fn meet(&mut self, met: Met) {
        let is_first = |first: Met| met.distance < self.limit || met.polygon > first.polygon;
        if self.met.is_none_or(is_first) {
            self.limit = met.distance;
            self.met = Some(met);
        }
    }
}

/// The part of a ray inside all half-spaces so far.
struct Passage {
    enter: f64,
    leave: f64,
    normal: Option<DVec3>,
    polygon: Option<u32>,
}

impl Default for Passage {
    fn default() -> Self {
        Self {
            enter: 0.0,
            leave: f64::INFINITY,
            normal: None,
            polygon: None,
        }
    }
}

impl Passage {
    fn clipped(
        mut self,
        height: f64,
        climb: f64,
        normal: DVec3,
        polygon: Option<u32>,
    ) -> Option<Self> {
        self.clip(height, climb, normal, polygon)?;
        Some(self)
    }

    /// Goes on with the part that is in a half-space too, if there is one: the origin is at a
    /// height above its plane, and climbs.
    fn clip(&mut self, height: f64, climb: f64, normal: DVec3, polygon: Option<u32>) -> Option<()> {
        if climb < 0.0 {
            let enter = -height / climb;
            if height > 0.0 && enter >= self.enter {
                (self.enter, self.normal, self.polygon) = (enter, Some(normal), polygon);
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
            face: self.normal,
            polygon: self.polygon,
            crosses: true,
        }
    }
}
