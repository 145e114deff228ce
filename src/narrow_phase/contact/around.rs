//! What is around a polygon of a mesh: its neighbours, and others that merely lie against it.
//!
//! Neighbours share vertices by index. Bricks side by side, tiles with vertices of their own and
//! sides that end in the middle of others do not, though the surface goes on there just as well.

use bevy::math::Vec3A;

use crate::narrow_phase::{
    frame::{
        closest::point_segment,
        surface::{border, covers},
    },
    mesh::{polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR},
};

/// The sine of the angle up to which two polygons count as in one plane, and the share of a length
/// that is more than rounding.
pub const FLAT: f32 = 1e-3;

/// So many polygons around a corner are looked at.
const MOST_AROUND: usize = 64;

/// The share of a line at its ends that belongs to the corners there.
const AT_ENDS: f32 = 0.02;

/// What is beyond a side of a polygon: the next corners of the neighbour at the side's two ends.
/// `None` at a border.
pub type Beyond = Option<[Vec3A; 2]>;

/// Is told a polygon by its number, its corners and its normal; whether it is the one looked for.
pub type Look<'a> = &'a mut dyn FnMut(u32, &[Vec3A], Vec3A) -> bool;

/// What is around a polygon of a mesh. Most of it is not asked about: it is far away in memory.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    pub mesh: &'a PolygonMesh,
    pub polygon: u32,
    /// Where a vertex is.
    pub place: &'a dyn Fn(u32) -> Vec3A,
    /// The part of a line that matters.
    pub clip: &'a dyn Fn([Vec3A; 2]) -> [Vec3A; 2],
    /// Shows polygons in touch that may be near a line, until one is the one looked for; whether
    /// one was.
    pub others: &'a dyn Fn([Vec3A; 2], Look) -> bool,
    /// How near is on it.
    pub reach: f32,
}

impl Around<'_> {
    /// What is beyond a side, from a corner to the next.
    pub fn beyond(&self, side: usize) -> Beyond {
        let mesh = self.mesh;
        let other = mesh.across(self.polygon as usize)[side];
        if other == NO_NEIGHBOR {
            return None;
        }
        let corners = mesh.polygon(self.polygon as usize);
        let ends = [corners[side], corners[(side + 1) % corners.len()]];
        let others = mesh.polygon(other as usize);
        let count = others.len();
        let at = others.iter().position(|vertex| *vertex == ends[0])?;
        // The neighbour runs along the side the other way, if the two are turned alike.
        let near = if others[(at + count - 1) % count] == ends[1] {
            [at + 1, at + count - 2]
        } else {
            [at + count - 1, at + 2]
        };
        Some(near.map(|at| (self.place)(others[at % count])))
    }

    /// Does a polygon that has this corner too rise from there along a direction?
    pub fn rises_at(&self, corner: usize, direction: Vec3A) -> bool {
        let corners = self.mesh.polygon(self.polygon as usize);
        let count = corners.len();
        let vertex = corners[corner];
        let from = (self.place)(vertex);
        let rises = |other: u32| is_up((self.place)(other) - from, direction, 0.0);
        // One way around and, up to a border, the other way.
        [corner, (corner + count - 1) % count]
            .into_iter()
            .any(|first| {
                let (mut polygon, mut side) = (self.polygon, first);
                for _ in 0..MOST_AROUND {
                    let next = self.mesh.across(polygon as usize)[side];
                    if next == NO_NEIGHBOR || next == self.polygon {
                        return false;
                    }
                    let own = self.mesh.polygon(polygon as usize);
                    let shared = own[side] ^ own[(side + 1) % own.len()] ^ vertex;
                    let theirs = self.mesh.polygon(next as usize);
                    let Some(at) = theirs.iter().position(|other| *other == vertex) else {
                        return false;
                    };
                    let (after, before) = (
                        (at + 1) % theirs.len(),
                        (at + theirs.len() - 1) % theirs.len(),
                    );
                    // Out over the side that they did not come in by.
                    let (end, out) = if theirs[after] == shared {
                        (before, before)
                    } else {
                        (after, at)
                    };
                    if rises(theirs[end]) {
                        return true;
                    }
                    (polygon, side) = (next, out);
                }
                false
            })
    }

    /// Does a polygon that is no neighbour, but lies against a line on this one, rise from there
    /// along a direction?
    pub fn is_topped(&self, line: [Vec3A; 2], direction: Vec3A) -> bool {
        let [from, to] = (self.clip)(line);
        let (from, to) = (from.lerp(to, AT_ENDS), to.lerp(from, AT_ENDS));
        let neighbours = self.mesh.across(self.polygon as usize);
        (self.others)([from, to], &mut |polygon, corners, normal| {
            if polygon == self.polygon || neighbours.contains(&polygon) {
                return false;
            }
            let rises = |point: Vec3A| {
                let mut ways = corners.iter().map(|corner| *corner - point);
                ways.any(|way| is_up(way, direction, self.reach))
            };
            let is_on = |point: Vec3A| self.is_on(point, corners, normal);
            let is_beside = |corner: Vec3A| {
                let nearest = point_segment(corner, from, to);
                nearest.distance_squared(corner) <= self.reach * self.reach
            };
            let mut points = [from, from.midpoint(to), to].into_iter();
            points.any(|point| rises(point) && is_on(point))
                || corners.iter().any(|c| rises(*c) && is_beside(*c))
        })
    }

    fn is_on(&self, point: Vec3A, corners: &[Vec3A], normal: Vec3A) -> bool {
        let is_near = |[from, to]: [Vec3A; 2]| {
            let nearest = point_segment(point, from, to);
            nearest.distance_squared(point) <= self.reach * self.reach
        };
        ((point - corners[0]).dot(normal).abs() <= self.reach
            && normal != Vec3A::ZERO
            && covers(corners, normal, point))
            || border(corners).any(is_near)
    }
}

/// Does a way lead up along a direction, by more than rounding?
#[inline]
pub fn is_up(way: Vec3A, direction: Vec3A, slack: f32) -> bool {
    way.dot(direction) > FLAT * way.abs().element_sum() + slack
}
