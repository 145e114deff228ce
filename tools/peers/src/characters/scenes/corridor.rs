//! Long walls.

use bevy::math::{Vec2, Vec3};

use super::{Aim, Course, Extent, Place, Solid, Walker, block, standing};
use crate::{
    characters::{RADIUS, SPEED, TICK},
    meshes::scenes::Mesh,
};

/// Between the way and the wall, in degrees.
const ANGLES: [f32; 9] = [1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 80.0];
/// What a wall is made of: one box, boxes side by side, triangles.
const WALLS: [&str; 3] = ["one box", "boxes", "mesh"];
/// Between two walls.
const LANE: f32 = 6.0;
/// Of a wall, before who walks along it, and behind where it gets to.
const SPARE: f32 = 5.0;
const HEIGHT: f32 = 3.0;
/// Between a character and the wall, at first.
const GAP: f32 = 0.05;

pub fn place(extent: Extent) -> Place {
    let length = (SPEED * TICK * extent.ticks as f32).ceil() + SPARE;
    let lanes = (WALLS.len() * ANGLES.len()) as f32;
    let mut solids = vec![block(
        Vec3::new(-2.0 * SPARE, -1.0, -LANE),
        Vec3::new(length + SPARE, 0.0, lanes * LANE),
    )];
    let mut walkers = vec![];
    for (kind, wall) in WALLS.into_iter().enumerate() {
        for (number, angle) in ANGLES.into_iter().enumerate() {
            let face = LANE * (kind * ANGLES.len() + number) as f32;
            match kind {
                0 => solids.push(part(-SPARE, length, face)),
                1 => {
                    let parts = -SPARE as i32..length as i32;
                    solids.extend(parts.map(|from| part(from as f32, from as f32 + 1.0, face)));
                }
                _ => solids.push(Solid::Mesh(triangles(length, face))),
            }
            let heading = Vec2::from_angle(angle.to_radians());
            let walker = Walker {
                start: standing(0.0, 0.0, face - RADIUS - GAP),
                course: Course::Straight(heading),
                aim: Aim::Along(Vec2::X, heading.x * SPEED * TICK),
            };
            walkers.push((wall, walker));
        }
    }
    Place {
        solids,
        walkers,
        lowest: 0.0,
        ticks: extent.ticks,
    }
}

/// Of a wall along x, which faces to the side of the smaller z.
fn part(from: f32, to: f32, face: f32) -> Solid {
    block(
        Vec3::new(from, 0.0, face),
        Vec3::new(to, HEIGHT, face + 1.0),
    )
}

fn triangles(length: f32, face: f32) -> Mesh {
    let (columns, rows) = ((length + SPARE) as u32, HEIGHT as u32);
    let mut vertices = vec![];
    for row in 0..=rows {
        for column in 0..=columns {
            vertices.push(Vec3::new(column as f32 - SPARE, row as f32, face));
        }
    }
    Mesh::of_grid(vertices, columns + 1, rows + 1, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_of_triangles_face_who_comes() {
        let mesh = triangles(10.0, 3.0);
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            assert!((b - a).cross(c - a).z < 0.0);
        }
    }
}
