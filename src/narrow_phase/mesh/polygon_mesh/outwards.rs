//! Closed surfaces, turned to face out of what they enclose.

use bevy::math::DVec3;

use super::{PolygonMesh, winding::AxisRay};
use crate::narrow_phase::mesh::{duplicates::Twin, edges::Bits, topology::NO_NEIGHBOR};

/// So many polygons around surfaces are looked at for each polygon, on average, and so many anyway;
/// what is left then faces outwards. Only thousands of surfaces one in the other need more.
const EFFORT: usize = 64;
const LEAST_EFFORT: usize = 1 << 23;

/// A closed surface.
#[derive(Clone, Copy, Debug)]
struct Part {
    /// One of its polygons.
    first: u32,
    /// Six times what it encloses, positive if it faces outwards.
    volume: f64,
    min: DVec3,
    max: DVec3,
    /// Is it turned around? `None` as long as that is not known.
    turns: Option<bool>,
}

impl Part {
    /// What it counts once it is turned.
    fn sign(&self) -> i32 {
        let faces_inwards = self.volume < 0.0;
        if faces_inwards ^ self.turns.unwrap_or(false) {
            -1
        } else {
            1
        }
    }

    fn holds(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }
}

impl PolygonMesh {
    /// Turns closed surfaces outwards, given the first polygon of the surface of each that is part of
    /// one; and copies of polygons with them.
    ///
    /// A surface that is in empty space faces outwards. In the solid of another, it is a cavity if
    /// the two were given in opposite ways, and stays one.
    pub(super) fn turn_outwards(&mut self, mut part_of: Vec<u32>, twins: &[Twin]) {
        let mut parts = self.parts(&mut part_of);
        if parts.iter().all(|part| part.volume >= 0.0) {
            return;
        }
        // What holds another is larger.
        let mut order: Vec<usize> = (0..parts.len()).collect();
        let size = |part: &usize| parts[*part].volume.abs();
        order.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let mut effort = LEAST_EFFORT + EFFORT * self.polygon_count();
        for part in order {
            parts[part].turns = Some(self.has_to_turn(&parts, &part_of, part, &mut effort));
        }

        let turns = |polygon: u32| {
            let part = parts.get(part_of[polygon as usize] as usize);
            part.is_some_and(|part| part.turns == Some(true))
        };
        let mut inverted = Bits::none(self.polygon_count());
        let originals = (0..self.polygon_count() as u32).map(|polygon| (polygon, polygon));
        let copies = twins
            .iter()
            .filter_map(|twin| Some((twin.polygon, twin.of?)));
        for (polygon, original) in originals.chain(copies) {
            if turns(original) {
                inverted.insert(polygon);
            }
        }
        for polygon in inverted.iter() {
            self.flip_polygon(polygon as usize);
        }
        self.inverted = Some(inverted);
    }

    /// The closed surfaces. Puts the index of that of each polygon in place of its first polygon.
    fn parts(&self, part_of: &mut [u32]) -> Vec<Part> {
        let mut parts: Vec<Part> = Vec::new();
        let center = self.center.as_dvec3();
        for polygon in 0..part_of.len() {
            let first = part_of[polygon];
            if first == NO_NEIGHBOR {
                continue;
            }
            debug_assert!(first as usize <= polygon, "it is the first");
            // The first has its index already.
            let index = if first as usize == polygon {
                parts.push(Part {
                    first,
                    volume: 0.0,
                    min: DVec3::INFINITY,
                    max: DVec3::NEG_INFINITY,
                    turns: None,
                });
                parts.len() as u32 - 1
            } else {
                part_of[first as usize]
            };
            part_of[polygon] = index;
            let part = &mut parts[index as usize];
            let at = |corner: &u32| self.vertices[*corner as usize].as_dvec3() - center;
            let corners = self.polygon(polygon);
            let a = at(&corners[0]);
            for corner in corners {
                part.min = part.min.min(at(corner));
                part.max = part.max.max(at(corner));
            }
            for pair in corners[1..].windows(2) {
                part.volume += a.dot(at(&pair[0]).cross(at(&pair[1])));
            }
        }
        parts
    }

    /// Whether a part has to be turned around, given which of those that are larger do.
    fn has_to_turn(
        &self,
        parts: &[Part],
        part_of: &[u32],
        index: usize,
        effort: &mut usize,
    ) -> bool {
        let part = &parts[index];
        if *effort == 0 {
            return part.sign() < 0;
        }
        let point = self.middle(part.first);
        // How often each that may be around it winds around it.
        let mut around: Vec<(u32, i32)> = Vec::new();
        let ray = AxisRay::along_x(point);
        self.for_each_along(&ray, |polygon| {
            let other = part_of[polygon];
            let may_be_around = |other: &Part| other.turns.is_some() && other.holds(part);
            if parts.get(other as usize).is_some_and(may_be_around) {
                let crossing = self.crossing(polygon, &ray);
                *effort = effort.saturating_sub(1);
                around.push((other, crossing));
            }
        });
        around.sort_unstable();
        around.dedup_by(|(next, crossing), (other, winding)| {
            let is_same = next == other;
            if is_same {
                *winding += *crossing;
            }
            is_same
        });
        around.retain(|(_, winding)| *winding != 0);
        let turned = |other: u32| parts[other as usize].turns == Some(true);
        let winding: i32 = around
            .iter()
            .map(|&(other, winding)| if turned(other) { -winding } else { winding })
            .sum();
        let size = |other: u32| parts[other as usize].volume.abs();
        let closest = around
            .iter()
            .min_by(|(a, _), (b, _)| size(*a).total_cmp(&size(*b)));
        match closest {
            Some((closest, _)) if winding != 0 => turned(*closest),
            _ => part.sign() < 0,
        }
    }
}
