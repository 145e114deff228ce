//! Comparing all boxes of a group with each other.

use bevy::math::Vec3A;
use fearless_simd::{Level, prelude::*, u32x8};

use super::{
    block::{Block, WIDTH},
    boxes::ProxyId,
    filter::{PairFilter, PairKinds},
    linear_octree::Crowd,
    pairs::Pair,
    proxy::Proxies,
};

/// So many objects that moved in one leaf are a crowd, which is put in order before its boxes are
/// compared.
const CROWD: usize = 512;

/// All three axes.
const ALL_AXES: u8 = 0b111;

/// A group of objects, those that moved first, their boxes in blocks of eight.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    ids: Vec<ProxyId>,
    blocks: Vec<Block>,
    /// By object: the axes along which its box begins in the group's cell, a bit for each.
    begins: Vec<u8>,
    moved: usize,
    /// By block; none where nothing is filtered.
    filters: Vec<Filters>,
    kinds: PairKinds,
    /// May some be detectors, or parts of bodies? The comparison of all others knows nothing of it.
    has_special: bool,
    crowd: Crowd,
}

/// What the eight objects of a block are, and what they may meet.
#[derive(Clone, Debug)]
struct Filters {
    memberships: [u32; WIDTH],
    filters: [u32; WIDTH],
    worlds: [u32; WIDTH],
    /// A bit for each that is static.
    statics: u32,
    /// A bit for each that is a detector.
    detectors: u32,
    bodies: [u32; WIDTH],
}

impl Filters {
    /// Eight objects that admit nothing.
    const NONE: Self = Self {
        memberships: [0; WIDTH],
        filters: [0; WIDTH],
        worlds: [0; WIDTH],
        statics: 0,
        detectors: 0,
        bodies: [PairFilter::NO_BODY; WIDTH],
    };

    fn set(&mut self, lane: usize, filter: PairFilter) {
        self.memberships[lane] = filter.memberships;
        self.filters[lane] = filter.filters;
        self.worlds[lane] = filter.world;
        self.statics |= u32::from(filter.is_static) << lane;
    }

    fn get(&self, lane: usize) -> PairFilter {
        PairFilter {
            memberships: self.memberships[lane],
            filters: self.filters[lane],
            world: self.worlds[lane],
            is_static: self.statics >> lane & 1 != 0,
            is_detector: self.detectors >> lane & 1 != 0,
            body: self.bodies[lane],
        }
    }

    /// Which of the eight make a pair with an object, if their boxes overlap: a bit for each.
    #[inline(always)]
    fn admit<S: Simd, const SPECIAL: bool>(
        &self,
        simd: S,
        own: &PairFilter,
        kinds: PairKinds,
    ) -> u32 {
        let shared = |own: u32, lanes: &[u32; WIDTH]| {
            u32x8::splat(simd, own) & u32x8::from_slice(simd, lanes)
        };
        let nothing = u32x8::splat(simd, 0);
        let [deaf, unheard] = [
            shared(own.filters, &self.memberships).simd_eq(nothing),
            shared(own.memberships, &self.filters).simd_eq(nothing),
        ];
        let mut refused = (deaf | unheard).to_bitmask() as u32;
        if SPECIAL {
            // Of two of which one hears, only the other has to be a detector to be refused.
            let [deaf, unheard] = [deaf, unheard].map(|lanes| lanes.to_bitmask() as u32);
            let detects = u32::from(own.is_detector).wrapping_neg();
            refused &= !(!deaf & detects) & !(!unheard & self.detectors);
            if own.body != PairFilter::NO_BODY {
                let bodies = u32x8::from_slice(simd, &self.bodies);
                let of_own = bodies.simd_eq(u32x8::splat(simd, own.body));
                refused |= of_own.to_bitmask() as u32;
            }
        }
        let same_world =
            u32x8::from_slice(simd, &self.worlds).simd_eq(u32x8::splat(simd, own.world));
        let [moving, fixed] = [false, true].map(|is_static| {
            let sought = kinds.include(
                own,
                &PairFilter {
                    is_static,
                    ..PairFilter::default()
                },
            );
            u32::from(sought).wrapping_neg()
        });
        let of_kind = (moving & !self.statics) | (fixed & self.statics);
        same_world.to_bitmask() as u32 & !refused & of_kind
    }
}

impl Group {
    /// Makes this the group of some objects, each of them in the index and given once. They are
    /// those whose boxes overlap a cell of space; `low` is its lower corner.
    #[inline]
    pub(super) fn gather(
        &mut self,
        objects: impl Iterator<Item = ProxyId>,
        low: Vec3A,
        proxies: &Proxies,
    ) {
        self.ids.clear();
        self.blocks.clear();
        self.begins.clear();
        self.filters.clear();
        self.kinds = proxies.pair_kinds();
        self.ids.extend(objects);
        self.moved = self.ids.len();
        if !proxies.all_moved() {
            self.moved = 0;
            for index in 0..self.ids.len() {
                // Without a branch, which would be mispredicted often: to swap two that rest does
                // no harm.
                let moved = proxies.is_moved(self.ids[index]);
                self.ids.swap(self.moved, index);
                self.moved += usize::from(moved);
            }
        }
        if self.moved == 0 {
            return;
        }
        for eight in self.ids.chunks(WIDTH) {
            let mut block = Block::EMPTY;
            for (lane, id) in eight.iter().enumerate() {
                let aabb = &proxies.boxes()[id.index()];
                block.set(lane, aabb);
                self.begins.push(aabb.min.cmpge(low).bitmask() as u8);
            }
            self.blocks.push(block);
        }
        if proxies.are_filtered() {
            for eight in self.ids.chunks(WIDTH) {
                let mut filters = Filters::NONE;
                for (lane, id) in eight.iter().enumerate() {
                    filters.set(lane, proxies.filter(*id));
                }
                self.filters.push(filters);
            }
            self.has_special = proxies.has_detectors() || proxies.has_bodies();
            if self.has_special {
                self.gather_special(proxies);
            }
        }
    }

    #[cold]
    fn gather_special(&mut self, proxies: &Proxies) {
        for (eight, filters) in self.ids.chunks(WIDTH).zip(&mut self.filters) {
            for (lane, id) in eight.iter().enumerate() {
                let filter = proxies.filter(*id);
                filters.detectors |= u32::from(filter.is_detector) << lane;
                filters.bodies[lane] = filter.body;
            }
        }
    }

    /// Returns `true` if there are so many objects that they had better be put in order.
    #[inline]
    pub(super) const fn is_crowd(&self) -> bool {
        self.moved >= CROWD
    }

    /// Appends each pair of overlapping boxes of which at least one moved, which admit each other,
    /// and whose overlap has its lower corner in the group's cell: of the cells that two boxes
    /// share, that is one. Returns the number of pairs compared.
    ///
    /// The corner is the larger of the two lower corners, axis by axis. It is below the upper
    /// borders of every cell that both boxes overlap, and above the lower borders if one of the
    /// boxes begins there.
    #[inline(always)]
    pub(super) fn overlaps<S: Simd>(&self, simd: S, pairs: &mut Vec<Pair>) -> u64 {
        if self.has_special {
            self.overlaps_with::<S, true>(simd, pairs)
        } else {
            self.overlaps_with::<S, false>(simd, pairs)
        }
    }

    #[inline(always)]
    fn overlaps_with<S: Simd, const SPECIAL: bool>(&self, simd: S, pairs: &mut Vec<Pair>) -> u64 {
        let mut compared = 0;
        for first in 0..self.moved {
            compared += (self.ids.len() - first - 1) as u64;
            let (own, lane) = (first / WIDTH, first % WIDTH);
            let aabb = self.blocks[own].get(lane);
            let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
            // In its own block, those that follow.
            let mut lanes = !1 << lane;
            for (number, block) in self.blocks.iter().enumerate().skip(own) {
                let mut hits = block.overlaps(simd, min, max) & lanes;
                lanes = !0;
                if hits != 0
                    && let Some(filters) = self.filters.get(number)
                {
                    let own = self.filters[own].get(lane);
                    hits &= filters.admit::<S, SPECIAL>(simd, &own, self.kinds);
                }
                while hits != 0 {
                    let other = number * WIDTH + hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    if self.begins[first] | self.begins[other] == ALL_AXES {
                        pairs.push(Pair::new(self.ids[first], self.ids[other]));
                    }
                }
            }
        }
        compared
    }

    /// As [`overlaps`](Self::overlaps), for a crowd: in O(n log n) and the pairs, whatever the
    /// boxes look like. Pairs that are told apart by the bounds of many boxes do not count as
    /// compared.
    pub(super) fn overlaps_in_crowd(
        &mut self,
        level: Level,
        proxies: &Proxies,
        pairs: &mut Vec<Pair>,
    ) -> u64 {
        let Self {
            ids,
            blocks,
            begins,
            moved,
            crowd,
            ..
        } = self;
        let boxes = (0..ids.len()).map(|index| blocks[index / WIDTH].get(index % WIDTH));
        let is_filtered = proxies.are_filtered();
        let keep = |a: usize, b: usize| {
            a.min(b) < *moved
                && begins[a] | begins[b] == ALL_AXES
                && (!is_filtered || proxies.admits(ids[a], ids[b]))
        };
        let before = pairs.len();
        pairs.extend(
            crowd
                .overlaps(level, boxes, keep)
                .map(|[a, b]| Pair::new(ids[a], ids[b])),
        );
        (pairs.len() - before) as u64
    }

    /// The memory taken, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Block>()
            + self.filters.capacity() * size_of::<Filters>()
            + self.crowd.memory_bytes()
            + self.ids.capacity() * size_of::<ProxyId>()
            + self.begins.capacity()
    }
}
