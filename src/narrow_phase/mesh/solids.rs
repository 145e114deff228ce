//! Closed surfaces among polygons that share edges with more than one other, or parts of edges.
//!
//! Edges are cut where vertices lie on them; then polygons that run along the same *piece* are
//! counted.
//!
//! 1. A polygon with a piece that no other runs along bounds nothing. It is taken away, and so are
//!    those that are then alone along a piece.
//! 2. What hangs together by pieces that join two is a *patch*, which is turned to one orientation;
//!    one that cannot be is taken away.
//! 3. A patch along whose pieces as many run one way as the other is closed, whatever it shares an
//!    edge with. So is a group of patches that does so together.
//! 4. In any other group, a patch that would be in balance the other way round is turned around. If
//!    there is none, the smallest along a piece out of balance is a wall that bounds nothing, and is
//!    taken away.
//!
//! All that is done again with what is left.

use std::{collections::HashMap, ops::Range};

use super::{junctions::Junction, polygons::Polygons};

/// After so many rounds, all patches out of balance are taken away at once.
const PATIENCE: usize = 32;

/// A polygon along a piece of an edge.
#[derive(Clone, Copy, Debug)]
struct Use {
    /// The ends of the piece.
    piece: [u32; 2],
    /// The polygon, as an index of those looked at.
    polygon: u32,
    /// Does it run from the lower to the upper vertex?
    upwards: bool,
}

/// What is known of a polygon that bounds a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounding {
    /// Has it to be turned around?
    pub flip: bool,
    /// The first polygon of the closed surface that it is of, as an index of those looked at.
    pub first: u32,
}

/// Of each of some polygons, in ascending order: what is known of it if it bounds a solid.
pub fn find(polygons: &Polygons, which: &[u32], junctions: &[Junction]) -> Vec<Option<Bounding>> {
    let mut search = Search::new(polygons, which, junctions);
    let mut round = 0;
    while search.alive > 0 {
        search.peel();
        // Else, there are fewer now.
        if let Some(mut patches) = search.patches() {
            search.settle(&mut patches, round >= PATIENCE);
            round += 1;
        }
    }
    search.verdicts
}

struct Search {
    /// By piece.
    uses: Vec<Use>,
    /// Where the uses of each piece begin and end.
    starts: Vec<u32>,
    /// How many polygons run along each piece, of those that are left.
    counts: Vec<u32>,
    /// The pieces of each polygon, and whether it runs upwards there.
    pieces: Vec<(u32, bool)>,
    /// Where those of each polygon begin and end.
    piece_starts: Vec<u32>,
    is_alive: Vec<bool>,
    alive: usize,
    /// Pieces along which one polygon may be alone.
    queue: Vec<u32>,
    verdicts: Vec<Option<Bounding>>,
}

/// Polygons that hang together by pieces that join two.
struct Patches {
    /// Which patch each polygon is of.
    of: Vec<u32>,
    /// Has the polygon to be turned around?
    flip: Vec<bool>,
    /// The polygons, patch by patch, and where each patch ends.
    members: Vec<u32>,
    ends: Vec<u32>,
}

impl Search {
    fn new(polygons: &Polygons, which: &[u32], junctions: &[Junction]) -> Self {
        let mut uses = Vec::new();
        let mut note = |polygon: usize, from: u32, to: u32| {
            uses.push(Use {
                piece: [from.min(to), from.max(to)],
                polygon: polygon as u32,
                upwards: from < to,
            });
        };
        for (index, polygon) in which.iter().enumerate() {
            let sides = polygons.sides(*polygon as usize);
            let corners = polygons.get(*polygon as usize);
            for (i, &start) in corners.iter().enumerate() {
                let (mut from, side) = (start, (sides.start + i) as u32);
                let begin = junctions.partition_point(|junction| junction.side < side);
                let on_side = junctions[begin..].iter();
                for junction in on_side.take_while(|junction| junction.side == side) {
                    note(index, from, junction.vertex);
                    from = junction.vertex;
                }
                note(index, from, corners[(i + 1) % corners.len()]);
            }
        }
        uses.sort_unstable_by_key(|used| (used.piece, used.polygon, used.upwards));

        let mut starts = vec![0];
        let mut of_polygon: Vec<(u32, u32, bool)> = Vec::with_capacity(uses.len());
        for same in uses.chunk_by(|a, b| a.piece == b.piece) {
            let piece = starts.len() as u32 - 1;
            of_polygon.extend(same.iter().map(|used| (used.polygon, piece, used.upwards)));
            starts.push(starts[piece as usize] + same.len() as u32);
        }
        of_polygon.sort_unstable();
        let mut piece_starts = vec![0; which.len() + 1];
        for (polygon, ..) in &of_polygon {
            piece_starts[*polygon as usize + 1] += 1;
        }
        for polygon in 0..which.len() {
            piece_starts[polygon + 1] += piece_starts[polygon];
        }
        Self {
            counts: starts.array_windows().map(|[a, b]| b - a).collect(),
            queue: (0..starts.len() as u32 - 1).collect(),
            uses,
            starts,
            pieces: of_polygon
                .into_iter()
                .map(|(_, piece, upwards)| (piece, upwards))
                .collect(),
            piece_starts,
            is_alive: vec![true; which.len()],
            alive: which.len(),
            verdicts: vec![None; which.len()],
        }
    }

    fn pieces(&self, polygon: u32) -> &[(u32, bool)] {
        let [start, end] = [0, 1].map(|next| self.piece_starts[polygon as usize + next] as usize);
        &self.pieces[start..end]
    }

    /// The polygons left along a piece.
    fn along(&self, piece: u32) -> impl Iterator<Item = &Use> {
        let [start, end] = [0, 1].map(|next| self.starts[piece as usize + next] as usize);
        let uses = self.uses[start..end].iter();
        uses.filter(|used| self.is_alive[used.polygon as usize])
    }

    /// Takes a polygon away.
    fn remove(&mut self, polygon: u32) {
        if !std::mem::replace(&mut self.is_alive[polygon as usize], false) {
            return;
        }
        self.alive -= 1;
        let [start, end] = [0, 1].map(|next| self.piece_starts[polygon as usize + next] as usize);
        for (piece, _) in &self.pieces[start..end] {
            let count = &mut self.counts[*piece as usize];
            *count -= 1;
            if *count == 1 {
                self.queue.push(*piece);
            }
        }
    }

    /// Takes away all that is alone along a piece, and all that is then.
    fn peel(&mut self) {
        while let Some(piece) = self.queue.pop() {
            if self.counts[piece as usize] == 1 {
                let alone = self.along(piece).next().map(|used| used.polygon);
                if let Some(polygon) = alone {
                    self.remove(polygon);
                }
            }
        }
    }

    /// Finds the patches; or takes away those that have one side only, and finds none.
    fn patches(&mut self) -> Option<Patches> {
        const UNKNOWN: u32 = u32::MAX;
        let count = self.is_alive.len();
        let mut patches = Patches {
            of: vec![UNKNOWN; count],
            flip: vec![false; count],
            members: Vec::with_capacity(self.alive),
            ends: Vec::new(),
        };
        let mut one_sided = Vec::new();
        for start in 0..count as u32 {
            if !self.is_alive[start as usize] || patches.of[start as usize] != UNKNOWN {
                continue;
            }
            let patch = patches.ends.len() as u32;
            let first = patches.members.len();
            let (mut next, mut flipped, mut is_one_sided) = (first, 0, false);
            patches.of[start as usize] = patch;
            patches.members.push(start);
            while let Some(&polygon) = patches.members.get(next) {
                next += 1;
                let flip = patches.flip[polygon as usize];
                flipped += usize::from(flip);
                for &(piece, upwards) in self.pieces(polygon) {
                    if self.counts[piece as usize] != 2 {
                        continue;
                    }
                    let other = self.along(piece).find(|used| used.polygon != polygon);
                    let Some(other) = other else {
                        continue;
                    };
                    let flip = flip ^ (upwards == other.upwards);
                    let other = other.polygon as usize;
                    if patches.of[other] == UNKNOWN {
                        patches.of[other] = patch;
                        patches.flip[other] = flip;
                        patches.members.push(other as u32);
                    } else {
                        is_one_sided |= patches.flip[other] != flip;
                    }
                }
            }
            let members = &patches.members[first..];
            if 2 * flipped > members.len() {
                for polygon in members {
                    patches.flip[*polygon as usize] ^= true;
                }
            }
            if is_one_sided {
                one_sided.extend_from_slice(members);
            }
            patches.ends.push(patches.members.len() as u32);
        }
        let none = one_sided.is_empty();
        one_sided
            .into_iter()
            .for_each(|polygon| self.remove(polygon));
        none.then_some(patches)
    }

    /// Decides about patches that are closed, by themselves or together, and takes away those that
    /// are in the way of others.
    fn settle(&mut self, patches: &mut Patches, is_impatient: bool) {
        let all = 0..patches.ends.len() as u32;
        let alone: Vec<u32> = all
            .clone()
            .filter(|patch| self.sums(patches, *patch).values().all(|sum| *sum == 0))
            .collect();
        if !alone.is_empty() {
            for patch in alone {
                // Two polygons with the same sides have nothing between them.
                let is_solid = patches.members(patch).len() > 2;
                self.close(patches, patch, is_solid, patches.members(patch)[0]);
            }
            return;
        }

        // Patches that share pieces are of one group.
        let mut group: Vec<u32> = all.clone().collect();
        for piece in 0..self.counts.len() as u32 {
            let mut along = self
                .along(piece)
                .map(|used| patches.of[used.polygon as usize]);
            if let Some(first) = along.next() {
                for patch in along {
                    let [one, two] = [first, patch].map(|patch| root(&mut group, patch));
                    group[one.max(two) as usize] = one.min(two);
                }
            }
        }
        let group: Vec<u32> = all.clone().map(|patch| root(&mut group, patch)).collect();

        let mut round = 0;
        let in_the_way = loop {
            let in_the_way = self.out_of_balance(patches, &group);
            let turned = self.turn_into_balance(patches, &group, &in_the_way);
            round += 1;
            if !turned || round > PATIENCE {
                break in_the_way;
            }
        };
        let mut is_open = vec![false; group.len()];
        for &patch in &in_the_way {
            let is_first = !std::mem::replace(&mut is_open[group[patch as usize] as usize], true);
            if is_first {
                self.remove_patch(patches, patch);
            }
        }
        for patch in all {
            if !is_open[group[patch as usize] as usize] {
                // Patches, and groups of them, are known by their first: polygons come in order.
                let first = patches.members(group[patch as usize])[0];
                self.close(patches, patch, true, first);
            } else if is_impatient {
                self.remove_patch(patches, patch);
            }
        }
    }

    /// How often more a patch runs upwards than downwards along each piece that it shares with more
    /// than one.
    fn sums(&self, patches: &Patches, patch: u32) -> HashMap<u32, i64> {
        let mut sums = HashMap::new();
        for &polygon in patches.members(patch) {
            for &(piece, upwards) in self.pieces(polygon) {
                if self.counts[piece as usize] > 2 {
                    *sums.entry(piece).or_default() += patches.sign(polygon, upwards);
                }
            }
        }
        sums
    }

    fn balance(&self, patches: &Patches, piece: u32) -> i64 {
        let signs = self
            .along(piece)
            .map(|used| patches.sign(used.polygon, used.upwards));
        signs.sum()
    }

    /// The patches along pieces where not as many run one way as the other: by group, the smallest
    /// first.
    fn out_of_balance(&self, patches: &Patches, group: &[u32]) -> Vec<u32> {
        let mut found: Vec<u32> = (0..self.counts.len() as u32)
            .filter(|piece| self.balance(patches, *piece) != 0)
            .flat_map(|piece| self.along(piece))
            .map(|used| patches.of[used.polygon as usize])
            .collect();
        let size = |patch: u32| patches.members(patch).len();
        found.sort_unstable_by_key(|&patch| (group[patch as usize], size(patch), patch));
        found.dedup();
        found
    }

    /// Turns patches around that are in balance then: one in each group. Tells whether there are
    /// any.
    fn turn_into_balance(&self, patches: &mut Patches, group: &[u32], candidates: &[u32]) -> bool {
        let mut turned = None;
        for &patch in candidates {
            let is_mended = turned == Some(group[patch as usize]);
            let mends = || {
                let sums = self.sums(patches, patch);
                let mut sums = sums.iter();
                sums.all(|(piece, sum)| self.balance(patches, *piece) == 2 * sum)
            };
            if !is_mended && mends() {
                turned = Some(group[patch as usize]);
                patches.turn(patch);
            }
        }
        turned.is_some()
    }

    fn remove_patch(&mut self, patches: &Patches, patch: u32) {
        for polygon in patches.members(patch) {
            self.remove(*polygon);
        }
    }

    fn close(&mut self, patches: &Patches, patch: u32, is_solid: bool, first: u32) {
        for &polygon in patches.members(patch) {
            let flip = patches.flip[polygon as usize];
            self.verdicts[polygon as usize] = is_solid.then_some(Bounding { flip, first });
            self.remove(polygon);
        }
    }
}

impl Patches {
    fn range(&self, patch: u32) -> Range<usize> {
        let start = patch
            .checked_sub(1)
            .map_or(0, |last| self.ends[last as usize]);
        start as usize..self.ends[patch as usize] as usize
    }

    fn members(&self, patch: u32) -> &[u32] {
        &self.members[self.range(patch)]
    }

    /// Turns a patch around.
    fn turn(&mut self, patch: u32) {
        for &polygon in &self.members[self.range(patch)] {
            self.flip[polygon as usize] ^= true;
        }
    }

    /// 1 for a polygon that runs upwards along a piece once it is turned, or else -1.
    fn sign(&self, polygon: u32, upwards: bool) -> i64 {
        if upwards ^ self.flip[polygon as usize] {
            1
        } else {
            -1
        }
    }
}

/// The least patch of the group that a patch is known to be of.
fn root(group: &mut [u32], mut patch: u32) -> u32 {
    while group[patch as usize] != patch {
        let next = group[group[patch as usize] as usize];
        group[patch as usize] = next;
        patch = next;
    }
    patch
}

#[cfg(test)]
mod tests;
