//! The lines of each kind of shape, by its sizes. All are placed by a transform: scale first, then
//! rotation, then translation, as shapes are.

use std::f32::consts::TAU;

use bevy::{gizmos::gizmos::GizmoBuffer, prelude::*};

/// So many lines are drawn of a mesh at most: of one that has more edges, some of them.
pub(super) const MOST_LINES: usize = 2048;
/// So many boxes are drawn of voxels at most, and so many lines of a height field each way.
pub(super) const MOST_BOXES: usize = 256;
const MOST_ROWS: usize = 48;
/// So many lines join the ends of a frustum.
const SIDES: u8 = 8;
/// So many make a quarter of a circle.
const ARC: u8 = 6;
/// A half-space is drawn as so many cells of its plane each way, each one unit wide.
const PATCH: u32 = 8;

/// What is drawn into, and how: each function adds to it.
pub(super) struct Pen<'a, Config: GizmoConfigGroup, Clear: Send + Sync + 'static> {
    pub(super) gizmos: &'a mut GizmoBuffer<Config, Clear>,
    pub(super) color: Color,
}

/// Where something is, without its scale.
fn pose(at: &Transform) -> Isometry3d {
    Isometry3d::new(at.translation, at.rotation.normalize())
}

/// Where a part of a compound is. Of a scale that differs by axis, a part that is turned against it
/// takes the components along its own axes.
pub(super) fn of_part(at: &Transform, part: Isometry3d) -> Transform {
    at.mul_transform(Transform::from_isometry(part))
}

impl<Config: GizmoConfigGroup, Clear: Send + Sync + 'static> Pen<'_, Config, Clear> {
    pub(super) fn cuboid(&mut self, at: &Transform, half_size: Vec3) {
        let half_size = half_size * at.scale;
        let cuboid = Cuboid { half_size };
        self.gizmos.primitive_3d(&cuboid, pose(at), self.color);
    }

    /// Of a scale that differs by axis, the largest component counts, as everywhere.
    pub(super) fn sphere(&mut self, at: &Transform, radius: f32) {
        let sphere = Sphere::new(radius * at.scale.abs().max_element());
        self.gizmos.primitive_3d(&sphere, pose(at), self.color);
    }

    /// Along the y axis; of a scale, the second component is for the length.
    pub(super) fn capsule(&mut self, at: &Transform, radius: f32, half_length: f32) {
        let Vec3 { x, y, z } = at.scale.abs();
        let capsule = Capsule3d {
            radius: radius * x.max(z),
            half_length: half_length * y,
        };
        self.gizmos.primitive_3d(&capsule, pose(at), self.color);
    }

    /// Around the y axis: a cylinder, a cone, or what is between; with elliptic ends, if the scale
    /// makes them so.
    pub(super) fn frustum(&mut self, at: &Transform, top: f32, bottom: f32, half_height: f32) {
        self.rounded_frustum(at, [top, bottom, half_height], 0.0);
    }

    /// What is no further from a frustum than a radius, of which the largest component of the scale
    /// counts.
    pub(super) fn rounded_frustum(
        &mut self,
        at: &Transform,
        [top, bottom, half_height]: [f32; 3],
        radius: f32,
    ) {
        let grown = radius * at.scale.abs().max_element();
        // Of its outline, beside the axis: corners, and the directions in which they are rounded.
        let side = Vec2::new(2.0 * half_height, bottom - top).normalize_or(Vec2::X);
        let arcs = [
            (Vec2::new(top, half_height), Vec2::Y, side),
            (Vec2::new(bottom, -half_height), side, Vec2::NEG_Y),
        ];
        let mut outline: Vec<(Vec2, Vec2)> = Vec::new();
        for (corner, from, to) in arcs {
            let steps = if radius > 0.0 { ARC } else { 0 };
            let angle = from.angle_to(to);
            outline.extend((0..=steps).map(|step| {
                let share = f32::from(step) / f32::from(steps.max(1));
                (corner, Vec2::from_angle(angle * share).rotate(from))
            }));
        }
        // What is mirrored is put out the other way.
        let (rotation, mirror) = (at.rotation.normalize(), at.scale.signum());
        let place = |(corner, out): (Vec2, Vec2), angle: f32| {
            let (sin, cos) = angle.sin_cos();
            let around = |v: Vec2| Vec3::new(v.x * cos, v.y, v.x * sin);
            at.transform_point(around(corner)) + rotation * (mirror * around(out)) * grown
        };
        for side in 0..SIDES {
            let angle = f32::from(side) / f32::from(SIDES) * TAU;
            let points = outline.iter().map(|point| place(*point, angle));
            self.gizmos.linestrip(points, self.color);
        }
        // A ring where an arc begins and where it ends, which is the same without a radius.
        let last = outline.len() - 1;
        let mut rings = vec![0, last];
        if radius > 0.0 {
            rings.extend([usize::from(ARC), last - usize::from(ARC)]);
        }
        for ring in rings.into_iter().map(|index| outline[index]) {
            if ring.0.x > 0.0 || ring.1.x * grown > 0.0 {
                let steps = 4 * ARC;
                let angle = |step: u8| f32::from(step) / f32::from(steps) * TAU;
                let points = (0..=steps).map(|step| place(ring, angle(step)));
                self.gizmos.linestrip(points, self.color);
            }
        }
    }

    /// A box with round edges.
    pub(super) fn rounded_cuboid(&mut self, at: &Transform, half_size: Vec3, radius: f32) {
        let grown = radius * at.scale.abs().max_element();
        let size = 2.0 * ((half_size * at.scale).abs() + grown);
        self.gizmos
            .rounded_cuboid(pose(at), size, self.color)
            .edge_radius(grown);
    }

    /// A patch of the plane, and its normal.
    pub(super) fn half_space(&mut self, at: &Transform, normal: Vec3) {
        let turned = (normal / at.scale).try_normalize().unwrap_or(normal);
        if let Ok(normal) = Dir3::new(turned) {
            let plane = Plane3d::new(*normal, Vec2::ONE);
            self.gizmos
                .primitive_3d(&plane, pose(at), self.color)
                .cell_count(UVec2::splat(PATCH));
        }
    }

    pub(super) fn segment(&mut self, at: &Transform, ends: [Vec3; 2]) {
        let [a, b] = ends.map(|end| at.transform_point(end));
        self.gizmos.line(a, b, self.color);
    }

    pub(super) fn triangle(&mut self, at: &Transform, corners: [Vec3; 3]) {
        let [a, b, c] = corners.map(|corner| at.transform_point(corner));
        self.gizmos.linestrip([a, b, c, a], self.color);
    }

    /// A capsule from one point to another: the radius grows by the largest component of the scale.
    pub(super) fn rounded_segment(&mut self, at: &Transform, ends: [Vec3; 2], radius: f32) {
        let [a, b] = ends.map(|end| at.transform_point(end));
        let along = (b - a).normalize_or(Vec3::Y);
        let upright = Transform {
            translation: a.midpoint(b),
            rotation: Quat::from_rotation_arc(Vec3::Y, along),
            scale: Vec3::ONE,
        };
        let radius = radius * at.scale.abs().max_element();
        self.capsule(&upright, radius, 0.5 * a.distance(b));
    }

    /// The edges of a mesh. Of many, each second one, each third one, and so on.
    pub(super) fn edges(&mut self, at: &Transform, vertices: &[Vec3], edges: &[[u32; 2]]) {
        let step = edges.len().div_ceil(MOST_LINES).max(1);
        for ends in edges.iter().step_by(step) {
            self.segment(at, ends.map(|end| vertices[end as usize]));
        }
    }

    /// The polygons of a convex solid, or the two sides of one polygon, put out by a radius, of
    /// which the largest component of the scale counts. Of many, some.
    pub(super) fn rounded_polygons<'p>(
        &mut self,
        at: &Transform,
        vertices: &[Vec3],
        polygons: impl ExactSizeIterator<Item = &'p [u32]>,
        radius: f32,
    ) {
        let grown = radius * at.scale.abs().max_element();
        // Mirrored, it is the other way round.
        let mirror = at.scale.x * at.scale.y * at.scale.z;
        let step = polygons.len().div_ceil(MOST_LINES / 4).max(1);
        for polygon in polygons.step_by(step) {
            let corners: Vec<Vec3> = polygon
                .iter()
                .map(|corner| at.transform_point(vertices[*corner as usize]))
                .collect();
            let [a, b, c, ..] = corners[..] else { continue };
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let out = normal * grown.copysign(mirror);
            let put_out = corners.iter().map(|corner| *corner + out);
            self.gizmos.lineloop(put_out, self.color);
        }
    }

    /// The lines of a grid of heights, and of many some of them.
    pub(super) fn height_field(
        &mut self,
        at: &Transform,
        [rows, columns]: [usize; 2],
        cell_size: Vec2,
        height: impl Fn(usize, usize) -> f32,
    ) {
        let middle = Vec2::new(columns as f32 - 1.0, rows as f32 - 1.0) * 0.5;
        let point = |row: usize, column: usize| {
            let on_ground = (Vec2::new(column as f32, row as f32) - middle) * cell_size;
            let local = Vec3::new(on_ground.x, height(row, column), on_ground.y);
            at.transform_point(local)
        };
        let (along_z, along_x) = (some_of(rows), some_of(columns));
        for row in &along_z {
            let line = along_x.iter().map(|column| point(*row, *column));
            self.gizmos.linestrip(line, self.color);
        }
        for column in &along_x {
            let line = along_z.iter().map(|row| point(*row, *column));
            self.gizmos.linestrip(line, self.color);
        }
    }

    /// The boxes of cells. Of many, some.
    pub(super) fn voxels(
        &mut self,
        at: &Transform,
        cell_size: f32,
        count: usize,
        cells: impl Iterator<Item = IVec3>,
    ) {
        for cell in cells.step_by(count.div_ceil(MOST_BOXES).max(1)) {
            let middle = (cell.as_vec3() + 0.5) * cell_size;
            let there = Transform {
                translation: at.transform_point(middle),
                ..*at
            };
            self.cuboid(&there, Vec3::splat(0.5 * cell_size));
        }
    }
}

/// The first and the last of so many, and some between.
fn some_of(count: usize) -> Vec<usize> {
    let step = count.div_ceil(MOST_ROWS).max(1);
    let mut some: Vec<usize> = (0..count).step_by(step).collect();
    if some.last().is_some_and(|last| last + 1 < count) {
        some.push(count - 1);
    }
    some
}

#[cfg(test)]
mod tests;
