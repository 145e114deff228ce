//! How far a mesh reaches along a direction, on the summit that is nearest to a polygon.
//!
//! The way there leads from polygon to polygon, each higher than the one before. Ways along one
//! direction that meet go on together: so the summit is noted for each polygon on them, and most
//! ways are short.

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Course {
    pub is_second: bool,
    pub direction: u32,
    /// Against the direction?
    pub is_back: bool,
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
    known: HashMap<(Course, u32), Summit>,
    /// The polygons on a way, each higher than the one before.
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
        let mut found = Summit {
            height: f32::NEG_INFINITY,
            is_beyond: true,
        };
        self.way.clear();
        if let Some(known) = self.known(course, polygon, limit) {
            return known.height;
        }
        found.height = slope.top(polygon);
        self.way.push(polygon);
        let mut steps = 0;
        'up: while found.height <= limit {
            if next == seen || steps >= MOST_STEPS {
                found.is_beyond = false;
                break;
            }
            let polygon = plateau[next];
            next += 1;
            for &other in slope.mesh.across(polygon as usize) {
                if other == NO_NEIGHBOR || plateau[..seen].contains(&other) {
                    continue;
                }
                steps += 1;
                let height = slope.top(other);
                if height > found.height + tolerance {
                    if let Some(known) = self.known(course, other, limit) {
                        found = known;
                        break 'up;
                    }
                    plateau[0] = other;
                    (seen, next) = (1, 0);
                    found.height = height;
                    self.way.push(other);
                    break;
                }
                if height >= found.height - tolerance && seen < WIDEST_PLATEAU {
                    plateau[seen] = other;
                    seen += 1;
                    found.height = found.height.max(height);
                }
            }
        }
        for &polygon in &self.way {
            self.known.insert((course, polygon), found);
        }
        found.height
    }

    /// What is known of a polygon, if that is enough.
    fn known(&self, course: Course, polygon: u32, limit: f32) -> Option<Summit> {
        let known = self.known.get(&(course, polygon)).copied();
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

    /// How high the highest corner of a polygon is.
    #[inline]
    pub fn top(&self, polygon: u32) -> f32 {
        let vertices = self.mesh.vertices();
        let corners = self.mesh.polygon(polygon as usize).iter();
        let heights = corners.map(|vertex| {
            let offset = Vec3A::from(vertices[*vertex as usize]) - self.middle;
            offset.dot(self.up)
        });
        self.base + heights.fold(f32::NEG_INFINITY, f32::max)
    }
}
