//! Where a character is, told by nobody who takes part: each triangle near it looked at, in 64-bit floats, slow and plain.

use std::collections::HashMap;

use bevy::math::{DQuat, DVec2, DVec3, Vec3};

use super::{HALF_LENGTH, RADIUS, scenes::Solid};
use crate::meshes::reference::segment_triangle;

/// The side of a cell of the grid in the plane, by which what is near is found.
const CELL: f64 = 2.0;
/// Nothing further from a character than this counts as near it.
const NEAR: f64 = 0.2;
/// The corners of a box, by the sign along each axis, of each of its triangles.
const FACES: [[usize; 3]; 12] = [
    [0, 2, 6],
    [0, 6, 4],
    [1, 5, 7],
    [1, 7, 3],
    [0, 4, 5],
    [0, 5, 1],
    [2, 3, 7],
    [2, 7, 6],
    [0, 1, 3],
    [0, 3, 2],
    [4, 6, 7],
    [4, 7, 5],
];

/// Something that a character may be in touch with.
enum Piece {
    Triangle([DVec3; 3]),
    /// A triangle of a ground: what is below it, is in the ground.
    Ground([DVec3; 3]),
    /// What a box encloses.
    Inside {
        half: DVec3,
        center: DVec3,
        turn: DQuat,
    },
}

/// All that stays, in a grid.
pub struct Judge {
    pieces: Vec<Piece>,
    cells: HashMap<[i32; 2], Vec<u32>>,
}

impl Judge {
    pub fn new(solids: &[Solid]) -> Self {
        let mut judge = Self {
            pieces: vec![],
            cells: HashMap::new(),
        };
        for solid in solids {
            let (mesh, is_ground) = match solid {
                Solid::Box(half, at) => {
                    let (half, center) = (half.as_dvec3(), at.translation.as_dvec3());
                    let turn = at.rotation.as_dquat().normalize();
                    judge.add_box(half, center, turn);
                    continue;
                }
                Solid::Mesh(mesh) => (mesh, false),
                Solid::Ground(mesh) => (mesh, true),
            };
            for triangle in 0..mesh.triangles.len() {
                let corners = mesh.corners(triangle).map(Vec3::as_dvec3);
                let piece = if is_ground {
                    Piece::Ground(corners)
                } else {
                    Piece::Triangle(corners)
                };
                judge.add(piece, &corners);
            }
        }
        judge
    }

    /// How far a character in this place is from the nearest; less than zero if it is in it. Infinite where nothing is
    /// near. Never deeper than its radius, which says that its axis is in something, or below the ground.
    pub fn gap(&self, center: Vec3) -> f64 {
        let center = center.as_dvec3();
        let (radius, half) = (f64::from(RADIUS), DVec3::Y * f64::from(HALF_LENGTH));
        let ends = [center - half, center + half];
        let [low, high] = [-1.0, 1.0].map(|sign| center + DVec3::splat(sign * (radius + NEAR)));
        let mut least = f64::INFINITY;
        for cell in cells(low, high) {
            for &number in self.cells.get(&cell).into_iter().flatten() {
                least = least.min(self.pieces[number as usize].distance(ends));
            }
        }
        least - radius
    }

    fn add_box(&mut self, half: DVec3, center: DVec3, turn: DQuat) {
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: usize| {
            let sign = |axis: usize| [-1.0, 1.0][corner >> axis & 1];
            center + turn * (half * DVec3::new(sign(0), sign(1), sign(2)))
        });
        for face in FACES {
            let corners = face.map(|corner| corners[corner]);
            self.add(Piece::Triangle(corners), &corners);
        }
        self.add(Piece::Inside { half, center, turn }, &corners);
    }

    fn add(&mut self, piece: Piece, corners: &[DVec3]) {
        let number = self.pieces.len() as u32;
        self.pieces.push(piece);
        let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = corners
            .iter()
            .copied()
            .fold(DVec3::NEG_INFINITY, DVec3::max);
        for cell in cells(low, high) {
            self.cells.entry(cell).or_default().push(number);
        }
    }
}

impl Piece {
    /// Of an axis from below to above.
    fn distance(&self, ends: [DVec3; 2]) -> f64 {
        match self {
            Self::Triangle(corners) => segment_triangle(ends, *corners),
            Self::Ground(corners) => {
                if is_below(ends[0], *corners) {
                    0.0
                } else {
                    segment_triangle(ends, *corners)
                }
            }
            Self::Inside { half, center, turn } => {
                let is_inside = |end: DVec3| {
                    let local = turn.inverse() * (end - center);
                    local.abs().cmple(*half).all()
                };
                if ends.into_iter().any(is_inside) {
                    0.0
                } else {
                    f64::INFINITY
                }
            }
        }
    }
}

fn is_below(point: DVec3, corners: [DVec3; 3]) -> bool {
    let flat = |at: DVec3| DVec2::new(at.x, at.z);
    let [a, b, c] = corners.map(|corner| flat(corner) - flat(point));
    let areas = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let whole: f64 = areas.iter().sum();
    if whole == 0.0 || areas.iter().any(|area| area * whole < 0.0) {
        return false;
    }
    let heights = corners.map(|corner| corner.y);
    let height = (0..3).map(|i| areas[i] / whole * heights[i]).sum::<f64>();
    point.y < height
}

/// The cells that a box reaches into, as seen from above.
fn cells(low: DVec3, high: DVec3) -> impl Iterator<Item = [i32; 2]> {
    let number = |at: f64| (at / CELL).floor() as i32;
    let [from, to] = [low, high].map(|at| [number(at.x), number(at.z)]);
    (from[0]..=to[0]).flat_map(move |x| (from[1]..=to[1]).map(move |z| [x, z]))
}

#[cfg(test)]
mod tests {
    use bevy::{math::Quat, transform::components::Transform};

    use super::*;
    use crate::{characters::HALF_HEIGHT, meshes::scenes::Mesh};

    fn gap(solid: Solid, center: Vec3) -> f64 {
        Judge::new(&[solid]).gap(center)
    }

    #[test]
    fn boxes_are_as_far_as_they_are() {
        let turned = Transform::from_xyz(3.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(0.3));
        let solid = || Solid::Box(Vec3::ONE, turned);
        let along = turned.rotation * Vec3::X;
        let of = |distance: f32| gap(solid(), turned.translation + along * distance);
        assert!((of(1.5) - 0.1).abs() < 1e-6);
        assert!((of(1.3) + 0.1).abs() < 1e-6);
        assert!((of(0.9) + 0.4).abs() < 1e-6);
        assert!((of(0.0) + 0.4).abs() < 1e-6);
        assert_eq!(of(9.0), f64::INFINITY);
        let above = turned.translation + Vec3::Y * (1.05 + HALF_HEIGHT);
        assert!((gap(solid(), above) - 0.05).abs() < 1e-6);
    }

    #[test]
    fn what_is_below_the_ground_is_in_it() {
        let vertices = [[-5.0, -5.0], [5.0, -5.0], [-5.0, 5.0], [5.0, 5.0]];
        let vertices = vertices.map(|[x, z]: [f32; 2]| Vec3::new(x, 0.1 * x, z));
        let ground = || Solid::Ground(Mesh::of_grid(vertices.into(), 2, 2, false));
        let off = Vec3::new(-0.1, 1.0, 0.0).normalize() * (RADIUS + 0.02);
        let above = Vec3::new(1.0, 0.1, 1.0) + off + Vec3::Y * HALF_LENGTH;
        assert!((gap(ground(), above) - 0.02).abs() < 1e-6);
        assert!((gap(ground(), above - Vec3::Y * 5.0) + f64::from(RADIUS)).abs() < 1e-6);
    }
}
