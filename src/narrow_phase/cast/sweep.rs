//! Shapes on their way against others at rest: the first time of impact, solved for rather than approached by steps.

use bevy::math::{Dir3, Vec3, Vec3A};
use bevy::transform::components::Transform;

use crate::narrow_phase::{
    answer::Impact,
    frame::{
        closest, edge_polygon,
        large::Smaller,
        oriented_box::OrientedBox,
        placed::{Pair, Placed},
        surface::{Face, Surface},
        workspace::Workspace,
    },
    mesh::polygon_mesh::PolygonMesh,
    settings::NarrowPhase,
    shape::Shape,
};
#[cfg(feature = "rapier")]
use crate::narrow_phase::{
    error::BoundsError,
    parry::{cast, own},
};

impl NarrowPhase {
    /// Where a shape that moves without turning first meets another, if it does so within `max_distance`.
    ///
    /// Exact for every kind of shape, up to the rounding of 32-bit floats, and as exact after a long way as after a short
    /// one. Shapes [in contact](Self::intersects) at the start meet at once, whichever way they go. Those that only graze each
    /// other, closer than the tolerance, may count as meeting or not. `None` too if anything is not finite, but for
    /// `max_distance`, or that is negative or NaN.
    ///
    /// Two shapes made of polygons: linear in the pairs of their edges; a sphere and one of these: linear in its edges; two
    /// spheres: O(1). Allocates nothing once the workspace is warm, but when a mesh first meets a shape of Rapier's.
    ///
    /// ```
    /// use bevy::{math::{Dir3, Vec3}, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
    ///
    /// let (brick, ball) = (Shape::cuboid(Vec3::ONE)?, Shape::sphere(0.5)?);
    /// let (here, there) = (Transform::IDENTITY, Transform::from_xyz(8.0, 0.0, 0.0));
    /// let (moving, target) = (Placed::new(&ball, &here), Placed::new(&brick, &there));
    /// let hit = NarrowPhase::default().sweep(moving, Dir3::X, 10.0, target, &mut Workspace::default()).unwrap();
    /// assert_eq!((hit.distance, hit.point, hit.normal), (6.5, Vec3::X * 7.0, Vec3::NEG_X));
    /// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
    /// ```
    #[must_use]
    pub fn sweep(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        target: Placed,
        workspace: &mut Workspace,
    ) -> Option<Impact> {
        if !(max_distance >= 0.0 && direction.is_finite()) {
            return None;
        }
        #[cfg(feature = "rapier")]
        if let Some(impact) = own::with_own(moving, target, |a, b| self.sweep(a, direction, max_distance, b, workspace))
        {
            return impact;
        }
        if self.intersects(moving, target, workspace) {
            return Some(self.at_the_start(moving, direction, target, workspace));
        }
        let pair = Pair::new(moving, target, self.tolerance());
        #[cfg(feature = "rapier")]
        if matches!(moving.shape, Shape::Rapier(_)) || matches!(target.shape, Shape::Rapier(_)) {
            let is_finite = !matches!(pair, Err(BoundsError::NonFinite));
            return is_finite.then(|| cast::sweep(moving, direction, max_distance, target)).flatten();
        }
        // Up to where their bounding spheres touch: what follows is as exact after a long way as after a short one.
        let (free, nearer) = nearer(&pair.ok()?, direction).filter(|(free, _)| *free <= f64::from(max_distance))?;
        let left = (f64::from(max_distance) - free) as f32;
        let in_all = |rest: f32| (free + f64::from(rest)) as f32;
        // Relative to the target, so that neither place costs exactness.
        let (origin, moving) = (target.transform.translation, Placed::new(moving.shape, &nearer));
        let here = Transform { translation: Vec3::ZERO, ..*target.transform };
        let target = Placed::new(target.shape, &here);
        let pair = Pair::new(moving, target, self.tolerance()).ok()?;
        if pair.is_large()
            && let Some(smaller) = Smaller::of(&pair, self)
        {
            let ([moving, target], factor) = (smaller.placed(&pair), smaller.factor);
            let found = smaller.tests.sweep(moving, direction, left / factor, target, workspace)?;
            return Some(Impact {
                distance: in_all(found.distance * factor),
                point: origin + found.point * factor,
                ..found
            });
        }
        let mut first = First::new((*direction).into(), left);
        match (moving.shape, target.shape) {
            (Shape::Sphere { .. }, Shape::Sphere { .. }) => {
                first.ball(pair.box_a.center, pair.box_b.center, pair.box_a.radius, pair.box_b.radius);
            }
            (Shape::Sphere { .. }, _) => {
                let (mesh, surface) = edge_polygon::fill_second_all(&pair, workspace)?;
                first.ball_surface(pair.box_a.center, pair.box_a.radius, mesh, surface);
            }
            (_, Shape::Sphere { .. }) => {
                // As seen from the moving shape, the ball comes to it.
                let pair = pair.swapped();
                let (mesh, surface) = edge_polygon::fill_second_all(&pair, workspace)?;
                let mut reversed = First::new(-first.direction, first.limit);
                reversed.ball_surface(pair.box_a.center, pair.box_a.radius, mesh, surface);
                first.found = reversed.found.map(|found| found.reversed(first.direction));
            }
            _ => {
                let meshes = edge_polygon::fill_all(&pair, workspace)?;
                first.surfaces(meshes, &workspace.surfaces, pair.tolerance);
            }
        }
        first.found.map(|found| Impact {
            distance: in_all(found.distance),
            point: origin + nearer.translation + Vec3::from(found.point),
            normal: found.normal.into(),
        })
    }

    fn at_the_start(&self, moving: Placed, direction: Dir3, target: Placed, workspace: &mut Workspace) -> Impact {
        let contact = self.contact(moving, target, workspace);
        let against = |normal: Vec3| if normal.dot(*direction) > 0.0 { -*direction } else { normal };
        Impact {
            distance: 0.0,
            point: contact.map_or(moving.transform.translation, |contact| contact.point),
            normal: contact.map_or(-*direction, |contact| against(-contact.normal)),
        }
    }
}

/// How far the first of two goes before their bounding spheres touch, and its place there, relative to that of the second;
/// `None` if they do not.
fn nearer(pair: &Pair, direction: Dir3) -> Option<(f64, Transform)> {
    let way = direction.as_dvec3();
    let [a, b] = [pair.a, pair.b].map(|placed| (placed.transform.translation, placed));
    let center = |(origin, placed): (Vec3, Placed)| OrientedBox::of(placed.shape, placed.transform, origin);
    let [center_a, center_b] = [center(a).ok()?.center.as_dvec3(), center(b).ok()?.center.as_dvec3()];
    let start = a.0.as_dvec3() - b.0.as_dvec3();
    let offset = center_b - center_a - start;
    // A little more than they are, for rounding.
    let radii = f64::from(pair.box_a.radius) + f64::from(pair.box_b.radius);
    let reach = 1.0001 * radii + f64::from(pair.tolerance);
    if offset.length_squared() <= reach * reach {
        return Some((0.0, Transform { translation: start.as_vec3(), ..*pair.a.transform }));
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
    Some((along - back, Transform { translation: translation.as_vec3(), ..*pair.a.transform }))
}

/// An impact in the frame of a pair.
#[derive(Clone, Copy, Debug)]
struct LocalImpact {
    distance: f32,
    point: Vec3A,
    normal: Vec3A,
}

impl LocalImpact {
    /// That of the other shape on its way, along `direction`, with this one at rest.
    fn reversed(self, direction: Vec3A) -> Self {
        Self { point: self.point + direction * self.distance, normal: -self.normal, ..self }
    }
}

/// The first impact so far.
struct First {
    direction: Vec3A,
    limit: f32,
    found: Option<LocalImpact>,
}

impl First {
    fn new(direction: Vec3A, limit: f32) -> Self {
        Self { direction, limit, found: None }
    }

    /// Takes up an impact if it is the first so far.
    fn consider(&mut self, distance: f32, point: impl FnOnce() -> Vec3A, normal: Vec3A) {
        if distance >= 0.0 && distance <= self.limit {
            let normal = if normal.dot(self.direction) > 0.0 { -normal } else { normal };
            self.limit = distance;
            self.found = Some(LocalImpact { distance, point: point(), normal });
        }
    }

    /// A moving ball against a resting one.
    fn ball(&mut self, center: Vec3A, target: Vec3A, radius: f32, target_radius: f32) {
        let Some(distance) = self.reach(target - center, radius + target_radius) else { return };
        let Some(normal) = (center + self.direction * distance - target).try_normalize() else { return };
        self.consider(distance, || target + normal * target_radius, normal);
    }

    /// How far to go until something that is `offset` away is at a distance of `radius`.
    fn reach(&self, offset: Vec3A, radius: f32) -> Option<f32> {
        let along = offset.dot(self.direction);
        let aside = offset - self.direction * along;
        let room = radius * radius - aside.length_squared();
        // Ahead, or just left behind by rounding.
        (room >= 0.0 && along >= 0.0).then(|| (along - room.sqrt()).max(0.0))
    }

    /// A moving ball against faces, edges and corners.
    fn ball_surface(&mut self, center: Vec3A, radius: f32, mesh: &PolygonMesh, surface: &Surface) {
        for face in &surface.faces {
            let height = center.dot(face.normal) - face.plane;
            let outwards = face.normal * 1f32.copysign(height);
            let sinks = -outwards.dot(self.direction);
            // If it is over the plane of the face, and comes nearer.
            if sinks > 0.0 && height.abs() >= radius {
                let distance = (height.abs() - radius) / sinks;
                let touched = center + self.direction * distance - outwards * radius;
                if surface.covers(mesh.polygon(face.polygon as usize), face.normal, touched) {
                    self.consider(distance, || touched, outwards);
                }
            }
        }
        for edge in &surface.edges {
            self.ball_edge(center, radius, edge.ends);
        }
    }

    /// A moving ball against a segment, ends included.
    fn ball_edge(&mut self, center: Vec3A, radius: f32, [start, end]: [Vec3A; 2]) {
        self.ball(center, start, radius, 0.0);
        self.ball(center, end, radius, 0.0);
        let along = end - start;
        let Some(axis) = along.try_normalize() else { return };
        // In the plane across the edge, it is a point.
        let across = |v: Vec3A| v - axis * v.dot(axis);
        let (offset, velocity) = (across(start - center), across(self.direction));
        let squared = velocity.length_squared();
        let closest = offset.dot(velocity) / squared;
        let room = radius * radius - (offset - velocity * closest).length_squared();
        if !(closest >= 0.0 && room >= 0.0 && squared > 0.0) {
            return;
        }
        let distance = (closest - (room / squared).sqrt()).max(0.0);
        let center = center + self.direction * distance;
        let place = (center - start).dot(axis);
        if (0.0..=along.length()).contains(&place) {
            let point = start + axis * place;
            let normal = (center - point).try_normalize().unwrap_or(-self.direction);
            self.consider(distance, || point, normal);
        }
    }

    /// A moving surface, the first, against a resting one: corners against faces, both ways, and edges against edges.
    fn surfaces(&mut self, meshes: [&PolygonMesh; 2], [moving, resting]: &[Surface; 2], tolerance: f32) {
        let direction = self.direction;
        for corner in moving.edges.iter().flat_map(|edge| edge.ends) {
            for face in &resting.faces {
                if let Some(distance) = corner_to_face(corner, direction, meshes[1], resting, face, tolerance) {
                    self.consider(distance, || corner + direction * distance, face.normal);
                }
            }
        }
        for corner in resting.edges.iter().flat_map(|edge| edge.ends) {
            for face in &moving.faces {
                if let Some(distance) = corner_to_face(corner, -direction, meshes[0], moving, face, tolerance) {
                    self.consider(distance, || corner, face.normal);
                }
            }
        }
        for a in &moving.edges {
            for b in &resting.edges {
                self.edges(a.ends, b.ends, tolerance);
            }
        }
    }

    /// A moving edge against a resting one. Those that move within the plane that both span meet at their ends, which are
    /// corners.
    fn edges(&mut self, a: [Vec3A; 2], b: [Vec3A; 2], slack: f32) {
        let (u, v, offset) = (a[1] - a[0], b[1] - b[0], b[0] - a[0]);
        let normal = u.cross(v);
        let volume = normal.dot(self.direction);
        let (length_u, length_v) = (u.length(), v.length());
        if volume.abs() <= 1e-6 * length_u * length_v {
            return;
        }
        // By Cramer's rule: a[0] + u·s + direction·distance = b[0] + v·t.
        let distance = offset.dot(normal) / volume;
        let s = offset.cross(v).dot(self.direction) / volume;
        let t = offset.cross(u).dot(self.direction) / volume;
        let within = |place: f32, length: f32| place * length >= -slack && (place - 1.0) * length <= slack;
        if within(s, length_u) && within(t, length_v) {
            self.consider(distance, || b[0] + v * t, normal.normalize());
        }
    }
}

/// How far a corner has to go to a face, border included: corners that come to meet are where no edges cross.
fn corner_to_face(
    corner: Vec3A,
    way: Vec3A,
    mesh: &PolygonMesh,
    surface: &Surface,
    face: &Face,
    tolerance: f32,
) -> Option<f32> {
    let distance = (face.plane - corner.dot(face.normal)) / way.dot(face.normal);
    if !(distance >= 0.0 && distance.is_finite()) {
        return None;
    }
    let (corners, point) = (mesh.polygon(face.polygon as usize), corner + way * distance);
    let is_on =
        |[a, b]: [Vec3A; 2]| closest::point_segment(point, a, b).distance_squared(point) <= tolerance * tolerance;
    (surface.covers(corners, face.normal, point) || surface.border(corners).any(is_on)).then_some(distance)
}
