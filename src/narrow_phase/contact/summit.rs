//! How far a mesh reaches along a direction, on the summit that is nearest to a polygon.
//!
//! The way there leads from polygon to polygon, each higher than the one before. Ways along one
//! direction that meet go on together: so the summit is noted for each vertex that was the highest
//! of a polygon on them, and most ways are short.

use bevy::math::Vec3A;
use bevy::platform::collections::HashMap;

use crate::narrow_phase::{
    frame::placing::Placing,
    mesh::{polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR},
};

/// So many polygons at most are looked at on the way to a summit, and so many of a plateau.
const MOST_STEPS: usize = 256;
const WIDEST_PLATEAU: usize = 24;

/// One of the two meshes, and one of the directions along which it is asked about.
#[derive(Clone, Copy, Debug)]
pub struct Course(u64);

impl Course {
    /// Directions have numbers, less than that of all polygons can be; and there is the way back.
    #[inline]
    pub fn new(is_second: bool, direction: u32, is_back: bool) -> Self {
        debug_assert!(direction < 1 << 30, "polygons have three sides, each a u32");
        let flags = u64::from(is_second) | u64::from(is_back) << 1;
        Self(u64::from(direction) << 34 | flags << 32)
    }

    #[inline]
    fn at(self, vertex: u32) -> u64 {
        self.0 | u64::from(vertex)
    }
}

/// How high a summit is.
#[derive(Clone, Copy, Debug)]
struct Summit {
    height: f32,
    /// Or higher: the way ended before.
    is_beyond: bool,
}

/// The summits that are known.
#[derive(Clone, Debug, Default)]
pub struct Summits {
    known: HashMap<u64, Summit>,
    /// The vertices on a way, each higher than the one before.
    way: Vec<u32>,
}

impl Summits {
    /// Forgets all, so that directions can get other names.
    pub fn clear(&mut self) {
        self.known.clear();
    }

    /// How far a mesh reaches along a direction on the summit that is nearest to a polygon; or
    /// somewhere beyond `limit`.
    pub fn find(
        &mut self,
        course: Course,
        slope: &Slope,
        polygon: u32,
        limit: f32,
        tolerance: f32,
    ) -> f32 {
        // Those of a plateau that have been looked at, and those beside which the way up may go on.
        let mut plateau = [polygon; WIDEST_PLATEAU];
        let (mut seen, mut next) = (1, 0);
        let (height, top) = slope.top(polygon);
        if height > limit {
            return height;
        }
        if let Some(known) = self.known(course, top, limit) {
            return known.height;
        }
        let mut found = Summit {
            height,
            is_beyond: true,
        };
        self.way.clear();
        self.way.push(top);
        let mut steps = 0;
        let mut came_from = NO_NEIGHBOR;
        'up: while found.height <= limit {
            if next == seen || steps >= MOST_STEPS {
                found.is_beyond = false;
                break;
            }
            let polygon = plateau[next];
            next += 1;
            for &other in slope.mesh.across(polygon as usize) {
                let is_known = other == came_from || plateau[..seen].iter().any(|p| *p == other);
                if other == NO_NEIGHBOR || is_known {
                    continue;
                }
                steps += 1;
                let (height, top) = slope.top(other);
                if height > found.height + tolerance {
                    if let Some(known) = self.known(course, top, limit) {
                        found = known;
                        break 'up;
                    }
                    came_from = polygon;
                    plateau[0] = other;
                    (seen, next) = (1, 0);
                    found.height = height;
                    self.way.push(top);
                    break;
                }
                if height >= found.height - tolerance && seen < WIDEST_PLATEAU {
                    plateau[seen] = other;
                    seen += 1;
                    found.height = found.height.max(height);
                }
            }
        }
        for &vertex in &self.way {
            self.known.insert(course.at(vertex), found);
        }
        found.height
    }

    /// What is known of a vertex, if that is enough.
    #[inline]
    fn known(&self, course: Course, vertex: u32, limit: f32) -> Option<Summit> {
        let known = self.known.get(&course.at(vertex)).copied();
        known.filter(|known| !known.is_beyond || known.height > limit)
    }
}

/// A mesh in place, seen along a direction.
pub struct Slope<'a> {
    mesh: &'a PolygonMesh,
    /// The direction in the space of the mesh, as long as heights are there.
    up: Vec3A,
    middle: Vec3A,
    /// How high the middle is.
    base: f32,
}

impl<'a> Slope<'a> {
    pub fn new(mesh: &'a PolygonMesh, placing: &Placing, direction: Vec3A) -> Self {
        let (linear, middle, center) = placing.linear();
        Self {
            mesh,
            up: linear.transpose() * direction,
            middle,
            base: center.dot(direction),
        }
    }

    /// How high the highest corner of a polygon is, and which vertex that is.
    #[inline(always)]
    pub fn top(&self, polygon: u32) -> (f32, u32) {
        let vertices = self.mesh.vertices();
        let mut best = (f32::NEG_INFINITY, 0);
        for &vertex in self.mesh.polygon(polygon as usize) {
            let offset = Vec3A::from(vertices[vertex as usize]) - self.middle;
            let height = offset.dot(self.up);
            if height > best.0 {
                best = (height, vertex);
            }
        }
        (self.base + best.0, best.1)
    }
}
