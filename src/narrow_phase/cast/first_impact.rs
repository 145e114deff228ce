//! The first time of impact of something that moves along a line, as the least of those of its
//! parts: each the solution of an equation.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use crate::narrow_phase::frame::{
    closest,
    cuboid_mesh::{CuboidMesh, Found},
    cuboid_triangle::{self, Met},
    edge_polygon,
    near_faces::{Near, OnTheWay, for_each_near},
    placed::PlacedPair,
    surface::{PlacedFace, Surface, border, covers},
    workspace::Workspace,
};

/// An impact in the frame of a pair.
#[derive(Clone, Copy, Debug)]
pub struct LocalImpact {
    pub distance: f32,
    pub point: Vec3A,
    pub normal: Vec3A,
}

impl LocalImpact {
    /// That of the other shape on its way, along `direction`, with this one at rest.
    pub fn reversed(self, direction: Vec3A) -> Self {
        Self {
            point: self.point + direction * self.distance,
            normal: -self.normal,
            ..self
        }
    }
}

/// The first impact so far of something that moves in a direction, no further than to a limit.
pub struct FirstImpact {
    direction: Vec3A,
    limit: f32,
    found: Option<LocalImpact>,
}

impl FirstImpact {
    pub fn new(direction: Vec3A, limit: f32) -> Self {
        Self {
            direction,
            limit,
            found: None,
        }
    }

    /// Of two spheres.
    pub fn of_spheres(mut self, pair: &PlacedPair) -> Option<LocalImpact> {
        self.ball(
            pair.box_a.center,
            pair.box_b.center,
            pair.box_a.radius,
            pair.box_b.radius,
        );
        self.found
    }

    /// Of a sphere, the first of the pair, and a shape made of polygons.
    pub fn of_sphere(
        mut self,
        pair: &PlacedPair,
        workspace: &mut Workspace,
    ) -> Option<LocalImpact> {
        let (mesh, surface) = edge_polygon::fill_second_to_search(pair, workspace)?;
        let (center, radius) = (pair.box_a.center, pair.box_a.radius);
        let Some(tree) = mesh.tree() else {
            self.ball_surface(center, radius, surface);
            return self.found;
        };
        let (placing, tolerance) = (*surface.placing(), pair.tolerance);
        let reach = Vec3A::splat(radius + tolerance);
        let around = placing
            .way_back(center, reach)
            .place(&Aabb3d::new(center, reach));
        let near = OnTheWay {
            direction: self.direction,
            margin: 0.0,
        };
        let measure = near.measure(&around, &placing, true);
        tree.search(&measure, self.limit, |polygon, _| {
            surface.select(mesh, polygon, tolerance);
            self.ball_surface(center, radius, surface);
            ControlFlow::Continue(self.limit)
        });
        self.found
    }

    /// Of two shapes made of polygons.
    pub fn of_polygons(
        mut self,
        pair: &PlacedPair,
        workspace: &mut Workspace,
    ) -> Option<LocalImpact> {
        let near = OnTheWay {
            direction: self.direction,
            margin: 2.0 * pair.tolerance,
        };
        if let Some(both) = CuboidMesh::of(pair) {
            self.cuboid_mesh(&both, &near, pair, workspace);
            return self.found;
        }
        for_each_near(&near, pair, workspace, self.limit, |surfaces| {
            self.surfaces(surfaces, pair.tolerance);
            ControlFlow::Continue(self.limit)
        })?;
        self.found
    }

    /// A cuboid and a mesh with a tree, of which the first of the pair moves.
    fn cuboid_mesh(
        &mut self,
        both: &CuboidMesh,
        near: &OnTheWay,
        pair: &PlacedPair,
        workspace: &mut Workspace,
    ) {
        // As seen from the triangles, the cuboid comes.
        let towards = if both.cuboid_first { 1.0 } else { -1.0 };
        let direction = both.direction_to_cuboid(self.direction * towards);
        let (half, way) = (both.half(), direction.as_dvec3());
        let mut is_placed = false;
        let mut first: Option<(Met, [Vec3A; 3])> = None;
        both.for_each(near, self.limit, |found| {
            match found {
                Found::Triangle(corners) => {
                    let limit = f64::from(self.limit);
                    let met = cuboid_triangle::sweep(
                        half.as_dvec3(),
                        corners.map(Vec3A::as_dvec3),
                        way,
                        limit,
                    );
                    if let Some(met) = met {
                        self.limit = met.distance as f32;
                        first = Some((met, corners));
                    }
                }
                Found::Polygon(polygon) => {
                    let surfaces = &mut workspace.surfaces;
                    if !is_placed {
                        is_placed = true;
                        edge_polygon::place_both(pair, surfaces);
                    }
                    edge_polygon::select_polygon(both, polygon, pair.tolerance, surfaces);
                    let before = self.limit;
                    self.surfaces(surfaces, pair.tolerance);
                    if self.limit < before {
                        first = None;
                    }
                }
            }
            ControlFlow::Continue(self.limit)
        });
        let Some((met, corners)) = first else { return };
        let distance = met.distance as f32;
        // There, the triangle has come so far to the cuboid.
        let corners = corners.map(|corner| corner - direction * distance);
        let on_cuboid = cuboid_triangle::meeting(half, corners, pair.tolerance);
        let normal = both.direction_to_frame(met.normal.normalize_or_zero().as_vec3a());
        let moved = self.direction * distance;
        let point = both.to_frame(on_cuboid);
        // In the frame, the first shape has moved: a cuboid that is second has not.
        let point = if both.cuboid_first {
            point + moved
        } else {
            point
        };
        self.consider(distance, || point, normal);
    }

    /// Takes up an impact if it is the first so far.
    fn consider(&mut self, distance: f32, point: impl FnOnce() -> Vec3A, normal: Vec3A) {
        if distance >= 0.0 && distance <= self.limit {
            let normal = if normal.dot(self.direction) > 0.0 {
                -normal
            } else {
                normal
            };
            self.limit = distance;
            self.found = Some(LocalImpact {
                distance,
                point: point(),
                normal,
            });
        }
    }

    /// A moving ball against a resting one.
    fn ball(&mut self, center: Vec3A, target: Vec3A, radius: f32, target_radius: f32) {
        let Some(distance) = self.reach(target - center, radius + target_radius) else {
            return;
        };
        let Some(normal) = (center + self.direction * distance - target).try_normalize() else {
            return;
        };
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
    fn ball_surface(&mut self, center: Vec3A, radius: f32, surface: &Surface) {
        for face in &surface.faces {
            self.ball_face(center, radius, surface, face);
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
        let Some(axis) = along.try_normalize() else {
            return;
        };
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
        let height = (center - start).dot(axis);
        if (0.0..=along.length()).contains(&height) {
            let point = start + axis * height;
            let normal = (center - point).try_normalize().unwrap_or(-self.direction);
            self.consider(distance, || point, normal);
        }
    }

    /// A moving ball against the inside of a face.
    fn ball_face(&mut self, center: Vec3A, radius: f32, surface: &Surface, face: &PlacedFace) {
        let height = center.dot(face.normal) - face.plane;
        let outwards = face.normal * 1f32.copysign(height);
        let sinks = -outwards.dot(self.direction);
        // If it is over the plane of the face, and comes nearer.
        if sinks > 0.0 && height.abs() >= radius {
            let distance = (height.abs() - radius) / sinks;
            let touched = center + self.direction * distance - outwards * radius;
            if covers(surface.corners(face), face.normal, touched) {
                self.consider(distance, || touched, outwards);
            }
        }
    }

    /// A moving surface, the first, against a resting one: corners against faces, both ways, and
    /// edges against edges.
    fn surfaces(&mut self, [moving, resting]: &[Surface; 2], tolerance: f32) {
        let direction = self.direction;
        for corner in moving.edges.iter().flat_map(|edge| edge.ends) {
            for face in &resting.faces {
                if let Some(distance) = corner_to_face(corner, direction, resting, face, tolerance)
                {
                    self.consider(distance, || corner + direction * distance, face.normal);
                }
            }
        }
        for corner in resting.edges.iter().flat_map(|edge| edge.ends) {
            for face in &moving.faces {
                if let Some(distance) = corner_to_face(corner, -direction, moving, face, tolerance)
                {
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

    /// A moving edge against a resting one. Those that move within the plane that both span meet at
    /// their ends, which are corners.
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
        let within =
            |share: f32, length: f32| share * length >= -slack && (share - 1.0) * length <= slack;
        if within(s, length_u) && within(t, length_v) {
            self.consider(distance, || b[0] + v * t, normal.normalize());
        }
    }
}

/// How far a corner has to go to a face, border included: corners that come to meet are where no
/// edges cross.
fn corner_to_face(
    corner: Vec3A,
    way: Vec3A,
    surface: &Surface,
    face: &PlacedFace,
    tolerance: f32,
) -> Option<f32> {
    let distance = (face.plane - corner.dot(face.normal)) / way.dot(face.normal);
    if !(distance >= 0.0 && distance.is_finite()) {
        return None;
    }
    let (corners, point) = (surface.corners(face), corner + way * distance);
    let is_on = |[a, b]: [Vec3A; 2]| {
        closest::point_segment(point, a, b).distance_squared(point) <= tolerance * tolerance
    };
    (covers(corners, face.normal, point) || border(corners).any(is_on)).then_some(distance)
}
