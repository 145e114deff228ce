//! How polygons hang together: neighbours, shells, orientation, and what bounds a solid.
//!
//! A polygon bounds a solid if it is part of a closed surface: one along each of whose edges as many
//! polygons run one way as the other. Most meshes are decided by [`Shells`], from neighbour to
//! neighbour: each shell whose edges all join two polygons is closed. What is left has edges of
//! more than two polygons, or vertices that lie on the edges of others, and is for
//! [`solids`](super::solids).

use bevy::math::Vec3;

use super::{
    duplicates::{self, Twin},
    edges::{Bits, Edges},
    junctions::{Junction, Junctions},
    polygons::Polygons,
    solids,
};
use crate::broad_phase::StillOctree;

pub use super::edges::NO_NEIGHBOR;

/// What [`Topology::of`] finds out.
pub struct Topology {
    /// Each edge once.
    pub edges: Vec<[u32; 2]>,
    /// For each side of the polygons as given, the polygon across.
    pub across: Vec<u32>,
    /// The first polygon of each part of the surface that hangs together, in their order.
    pub shells: Vec<u32>,
    /// The polygons to turn around so that neighbours agree.
    pub flipped: Vec<u32>,
    /// The polygons that bound solids.
    pub solid: Solid,
    /// The vertices that lie on sides of polygons that bound solids: by side, in the order in which
    /// they lie on it.
    pub junctions: Vec<Junction>,
    /// For each polygon that bounds a solid, the first one of its closed surface; [`NO_NEIGHBOR`]
    /// for others.
    pub surface: Vec<u32>,
    /// Polygons with the same corners as others.
    pub twins: Vec<Twin>,
    /// An edge of a polygon that bounds no solid, walls and copies aside.
    pub open_edge: Option<[u32; 2]>,
}

/// Which polygons bound solids.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Solid {
    All,
    None,
    Some(Bits),
}

impl Solid {
    #[inline]
    pub fn contains(&self, polygon: u32) -> bool {
        match self {
            Self::All => true,
            Self::None => false,
            Self::Some(polygons) => polygons.contains(polygon),
        }
    }
}

impl Topology {
    /// Linear in the number of corners, but for hubs, which are sorted, and for what lies on the
    /// edges of others, which is searched for.
    ///
    /// A vertex is on an edge if it is nearer to it than rounding, and `slack`, explain.
    pub fn of(
        vertices: &[Vec3],
        polygons: &Polygons,
        tree: Option<&StillOctree>,
        slack: f64,
    ) -> Self {
        let mut edges = Edges::of(polygons, vertices.len());
        let mut shells = Shells::of(polygons, &edges);
        let twins = duplicates::find(polygons, &edges);
        let search = Junctions {
            vertices,
            polygons,
            tree,
            slack,
        };
        let at_odd_edges = edges.at_odd_edges.take();
        let mut junctions = at_odd_edges.map_or_else(Vec::new, |vertices| search.find(vertices));
        let undecided = shells.undecided(&edges, &twins, !junctions.is_empty());
        if !undecided.is_empty() {
            let found = solids::find(polygons, &undecided, &junctions);
            for (polygon, verdict) in undecided.iter().zip(found) {
                if let Some(bounding) = verdict {
                    shells.surface[*polygon as usize] = undecided[bounding.first as usize];
                    shells.flip[*polygon as usize] = bounding.flip;
                }
            }
        }
        for twin in &twins {
            if let Some(first) = twin.of {
                shells.flip[twin.polygon as usize] = shells.flip[first as usize];
            }
        }
        junctions.retain(|junction| shells.is_solid(polygons.owner(junction.side)));

        let is_accounted_for = |polygon: u32| {
            shells.is_solid(polygon)
                || twins
                    .binary_search_by_key(&polygon, |twin| twin.polygon)
                    .is_ok_and(|at| match twins[at].of {
                        Some(first) => shells.is_solid(first),
                        None => true,
                    })
        };
        let count = polygons.len() as u32;
        let solids = (0..count)
            .filter(|polygon| shells.is_solid(*polygon))
            .count();
        let solid = match solids {
            0 => Solid::None,
            all if all == polygons.len() => Solid::All,
            _ => {
                let mut bits = Bits::none(polygons.len());
                (0..count)
                    .filter(|polygon| shells.is_solid(*polygon))
                    .for_each(|polygon| bits.insert(polygon));
                Solid::Some(bits)
            }
        };
        let open = (0..count).find(|polygon| !is_accounted_for(*polygon));
        let open_edge = open.map(|polygon| shells.open_edge(polygons, &edges, polygon));
        edges.across.shrink_to_fit();
        Self {
            edges: edges.ends,
            across: edges.across,
            flipped: (0..count)
                .filter(|polygon| shells.flip[*polygon as usize])
                .collect(),
            surface: shells.surface,
            twins,
            shells: shells.firsts,
            solid,
            junctions,
            open_edge,
        }
    }
}

/// The parts of a surface that hang together by edges that join two polygons.
struct Shells {
    /// The first polygon of each.
    firsts: Vec<u32>,
    /// Which polygons have to be turned around.
    flip: Vec<bool>,
    /// The first polygon of the closed surface that each is of, as far as is known.
    surface: Vec<u32>,
    /// The polygons, shell by shell, and where each shell ends.
    members: Vec<u32>,
    ends: Vec<u32>,
    /// Which shells have sides without a neighbour.
    has_border: Vec<bool>,
}

impl Shells {
    /// Walks over each shell from its first polygon, from neighbour to neighbour.
    ///
    /// Neighbours are turned alike, as most of them are.
    fn of(polygons: &Polygons, edges: &Edges) -> Self {
        let count = polygons.len();
        let mut shells = Self {
            firsts: Vec::new(),
            flip: vec![false; count],
            surface: vec![NO_NEIGHBOR; count],
            members: Vec::with_capacity(count),
            ends: Vec::new(),
            has_border: Vec::new(),
        };
        let mut is_known = vec![false; count];
        for start in 0..count {
            if std::mem::replace(&mut is_known[start], true) {
                continue;
            }
            let first = shells.members.len();
            let (mut next, mut flipped) = (first, 0);
            let (mut has_border, mut is_one_sided) = (false, false);
            shells.members.push(start as u32);
            while let Some(&polygon) = shells.members.get(next) {
                next += 1;
                let flip = shells.flip[polygon as usize];
                flipped += usize::from(flip);
                for side in polygons.sides(polygon as usize) {
                    let other = edges.across[side] as usize;
                    if other == NO_NEIGHBOR as usize {
                        has_border = true;
                        continue;
                    }
                    let flip = flip ^ edges.alike.contains(side as u32);
                    if std::mem::replace(&mut is_known[other], true) {
                        is_one_sided |= shells.flip[other] != flip;
                    } else {
                        shells.flip[other] = flip;
                        shells.members.push(other as u32);
                    }
                }
            }
            let members = &shells.members[first..];
            if 2 * flipped > members.len() {
                for polygon in members {
                    shells.flip[*polygon as usize] ^= true;
                }
            }
            // Two polygons with the same sides have nothing between them.
            if !has_border && !is_one_sided && members.len() > 2 {
                for polygon in members {
                    shells.surface[*polygon as usize] = start as u32;
                }
            }
            shells.firsts.push(start as u32);
            shells.ends.push(shells.members.len() as u32);
            shells.has_border.push(has_border);
        }
        shells
    }

    fn is_solid(&self, polygon: u32) -> bool {
        self.surface[polygon as usize] != NO_NEIGHBOR
    }

    /// The polygons, in their order, of which neighbours alone cannot tell whether they bound a
    /// solid: of shells with a border that others may close.
    fn undecided(&self, edges: &Edges, twins: &[Twin], has_junctions: bool) -> Vec<u32> {
        let mut undecided = Vec::new();
        if edges.crowded.is_empty() && !has_junctions {
            return undecided;
        }
        let mut begin = 0;
        for (end, has_border) in self.ends.iter().zip(&self.has_border) {
            let members = &self.members[begin..*end as usize];
            begin = *end as usize;
            if *has_border {
                let members = members.iter().filter(|polygon| {
                    let twin = twins.binary_search_by_key(*polygon, |twin| twin.polygon);
                    twin.is_err()
                });
                undecided.extend(members);
            }
        }
        undecided.sort_unstable();
        undecided
    }

    /// An edge of a polygon that bounds no solid: one of those that keep it from it, if it has one.
    fn open_edge(&self, polygons: &Polygons, edges: &Edges, first: u32) -> [u32; 2] {
        let is_open = |polygon: u32, side: u32| {
            let other = edges.across[side as usize];
            other == NO_NEIGHBOR
                || (self.flip[polygon as usize] ^ self.flip[other as usize])
                    != edges.alike.contains(side)
        };
        let sides = |polygon: u32| polygons.sides(polygon as usize).map(|side| side as u32);
        let open = (first..polygons.len() as u32)
            .filter(|polygon| !self.is_solid(*polygon))
            .flat_map(|polygon| sides(polygon).map(move |side| (polygon, side)))
            .find(|(polygon, side)| is_open(*polygon, *side));
        let (_, side) = open.unwrap_or((first, polygons.sides(first as usize).start as u32));
        let ends = [polygons.corners()[side as usize], polygons.end_of(side)];
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    }
}

#[cfg(test)]
mod tests;
