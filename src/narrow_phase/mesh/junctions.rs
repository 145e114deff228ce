//! Vertices that lie on the edges of other polygons.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};

use super::{edges::Bits, polygons::Polygons};
use crate::broad_phase::StillOctree;

/// How far off an edge a vertex on it may be, as a share of the edge's length.
const OFF_EDGE: f64 = 1e-5;
/// The same, as a share of the largest coordinate: what 32-bit floats and six digits leave.
const ROUNDING: f64 = 1e-6;
/// So many sides, or fewer, are looked at one by one.
const FEW: usize = 64;
/// Polygons of more corners than this, on average, are searched by their sides.
const LONG: usize = 8;

/// So many vertices are searched for at once.
const TOGETHER: usize = 4;

/// A vertex that lies on a side of a polygon that does not know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Junction {
    pub side: u32,
    pub vertex: u32,
    /// Where on the side, from 0 to 1.
    pub at: f32,
}

/// Where junctions are searched for.
pub struct Junctions<'a> {
    pub vertices: &'a [Vec3],
    pub polygons: &'a Polygons,
    /// That of the polygons, if there is one.
    pub tree: Option<&'a StillOctree>,
    /// How far off an edge a vertex may be beyond what rounding explains.
    pub slack: f64,
}

impl Junctions<'_> {
    /// Finds the sides on which some vertices lie, by side, in the order in which they lie on it.
    ///
    /// Vertices may be left out that could close nothing.
    pub fn find(&self, candidates: Bits) -> Vec<Junction> {
        let mut found = Vec::new();
        let (polygons, reach) = (self.polygons, self.reach());
        let sides = polygons.corners().len();
        if sides <= FEW {
            for vertex in candidates.iter() {
                for polygon in 0..polygons.len() {
                    self.on_polygon(polygon, vertex, &mut found);
                }
            }
        } else if let Some(tree) = self.tree.filter(|_| sides <= LONG * polygons.len()) {
            self.by_tree(tree, candidates, reach, &mut found);
        } else {
            let mut boxes = Vec::with_capacity(sides);
            let mut ends = Vec::with_capacity(sides);
            polygons.for_each_side(|polygon, _, from, to| {
                let (a, b) = (self.at(from), self.at(to));
                boxes.push(Aabb3d {
                    min: a.min(b),
                    max: a.max(b),
                });
                ends.push((polygon, to));
            });
            let tree = StillOctree::new(&boxes);
            for vertex in candidates.iter() {
                tree.for_each_overlapping(&self.around(vertex, reach), |side| {
                    let (polygon, to) = ends[side as usize];
                    let from = polygons.corners()[side as usize];
                    if let Some(at) = self.on_side([from, to], vertex)
                        && !polygons.get(polygon as usize).contains(&vertex)
                    {
                        found.push(Junction { side, vertex, at });
                    }
                });
            }
        }
        found.sort_unstable_by(|a, b| {
            let by_side = a.side.cmp(&b.side).then(a.at.total_cmp(&b.at));
            by_side.then(a.vertex.cmp(&b.vertex))
        });
        found
    }

    /// Near vertices together, and those of hopeless polygons not at all: a corner that no other
    /// polygon has must be on an edge of one, or the polygon is alone along both sides there.
    fn by_tree(
        &self,
        tree: &StillOctree,
        mut candidates: Bits,
        reach: f32,
        found: &mut Vec<Junction>,
    ) {
        let mut uses = vec![0_u8; self.vertices.len()];
        for corner in self.polygons.corners() {
            let uses = &mut uses[*corner as usize];
            *uses = uses.saturating_add(1);
        }
        let is_its_own = |corner: &u32| uses[*corner as usize] == 1;
        let mut together: Vec<u32> = Vec::with_capacity(TOGETHER);
        for polygons in tree.in_order().chunks(TOGETHER) {
            let corners = |polygon: &u32| self.polygons.get(*polygon as usize).iter().copied();
            together.clear();
            together.extend(polygons.iter().filter_map(|p| corners(p).find(is_its_own)));
            let before = found.len();
            self.search(tree, &together, reach, found);
            for polygon in polygons {
                let mut its_own = corners(polygon).filter(is_its_own);
                if let Some(first) = its_own.next() {
                    candidates.remove(first);
                    if found[before..].iter().all(|found| found.vertex != first) {
                        its_own.for_each(|corner| candidates.remove(corner));
                    }
                }
            }
        }
        together.clear();
        for polygon in tree.in_order() {
            for corner in self.polygons.get(*polygon as usize) {
                if candidates.contains(*corner) {
                    candidates.remove(*corner);
                    together.push(*corner);
                }
            }
            if together.len() >= TOGETHER {
                self.search(tree, &together, reach, found);
                together.clear();
            }
        }
        self.search(tree, &together, reach, found);
    }

    /// Searches for the sides that some vertices, which are near each other, lie on.
    fn search(&self, tree: &StillOctree, vertices: &[u32], reach: f32, found: &mut Vec<Junction>) {
        let Some((first, others)) = vertices.split_first() else {
            return;
        };
        let around = others
            .iter()
            .fold(self.around(*first, reach), |around, vertex| {
                let other = self.around(*vertex, reach);
                Aabb3d {
                    min: around.min.min(other.min),
                    max: around.max.max(other.max),
                }
            });
        tree.for_each_overlapping(&around, |polygon| {
            let corners = self.polygons.get(polygon as usize);
            let nothing = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
            let (min, max) = corners.iter().fold(nothing, |(min, max), corner| {
                (min.min(self.at(*corner)), max.max(self.at(*corner)))
            });
            let (min, max) = (min - reach, max + reach);
            for vertex in vertices {
                let at = self.at(*vertex);
                if (at.cmpge(min) & at.cmple(max)).all() {
                    self.on_polygon(polygon as usize, *vertex, found);
                }
            }
        });
    }

    fn at(&self, vertex: u32) -> Vec3A {
        self.vertices[vertex as usize].into()
    }

    /// How far off an edge a vertex on it may be, whichever edge it is.
    fn reach(&self) -> f32 {
        let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (min, max) = self.vertices.iter().fold(nothing, |(min, max), vertex| {
            (min.min(*vertex), max.max(*vertex))
        });
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        let largest = min.abs().max(max.abs()).max_element();
        // A little more, as boxes are of 32-bit floats.
        let reach = OFF_EDGE * (max - min).length() + 2.0 * ROUNDING * largest + self.slack;
        reach as f32 + f32::MIN_POSITIVE
    }

    fn around(&self, vertex: u32, reach: f32) -> Aabb3d {
        let at = self.at(vertex);
        Aabb3d {
            min: at - reach,
            max: at + reach,
        }
    }

    fn on_polygon(&self, polygon: usize, vertex: u32, found: &mut Vec<Junction>) {
        let corners = self.polygons.get(polygon);
        if corners.contains(&vertex) {
            return;
        }
        let start = self.polygons.sides(polygon).start;
        let next = corners[1..].iter().chain(&corners[..1]);
        for (i, (from, to)) in corners.iter().zip(next).enumerate() {
            if let Some(at) = self.on_side([*from, *to], vertex) {
                let side = (start + i) as u32;
                found.push(Junction { side, vertex, at });
            }
        }
    }

    /// Where between its ends a vertex is on an edge, if it is.
    fn on_side(&self, ends: [u32; 2], vertex: u32) -> Option<f32> {
        let [a, b] = ends.map(|end| self.at(end).as_dvec3());
        let point = self.at(vertex).as_dvec3();
        let (along, offset) = (b - a, point - a);
        let share = offset.dot(along) / along.length_squared();
        if !(share > 0.0 && share < 1.0) {
            return None;
        }
        let off = (offset - along * share).length();
        let size = a.abs().max(b.abs()).max_element();
        let may_be_off = OFF_EDGE * along.length() + ROUNDING * size + self.slack;
        (off <= may_be_off).then_some(share as f32)
    }
}
