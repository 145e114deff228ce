//! Lists of pairs of numbers, written eight at a time.

use crate::broad_phase::block::{ALL, WIDTH};

/// Two 32-bit numbers in one: they are compared, copied and written together.
pub(super) type Packed = u64;

/// Puts two numbers in one.
#[inline(always)]
pub(super) const fn pack(first: u32, second: u32) -> Packed {
    (first as u64) << 32 | second as u64
}

/// Takes two numbers apart again.
#[inline(always)]
pub(super) const fn unpack(packed: Packed) -> [u32; 2] {
    [(packed >> 32) as u32, packed as u32]
}

/// One more in the first number, and in the second.
pub(super) const FIRST: Packed = pack(1, 0);
pub(super) const SECOND: Packed = pack(0, 1);

/// By mask of eight lanes: the lanes in the mask, packed to the front.
const LANES: [[u8; WIDTH]; 1 << WIDTH] = {
    let mut table = [[0; WIDTH]; 1 << WIDTH];
    let mut mask = 0;
    while mask < table.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < WIDTH {
            if mask >> lane & 1 == 1 {
                table[mask][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// A list to which a mask of lanes is appended without a branch: eight items are written, and as
/// many of them count as there are lanes in the mask. Branches on what a mask holds would be
/// mispredicted at every other mask.
#[derive(Clone, Debug, Default)]
pub(super) struct List {
    /// Those that count, and then room for more.
    items: Vec<Packed>,
    len: usize,
}

impl List {
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    pub(super) fn as_slice(&self) -> &[Packed] {
        &self.items[..self.len]
    }

    /// Makes room for so many masks.
    #[inline]
    pub(super) fn reserve(&mut self, masks: usize) {
        let needed = self.len + masks * WIDTH;
        if self.items.len() < needed {
            self.items.resize(needed.max(self.len * 2), 0);
        }
    }

    /// Appends an item. There must be room for a mask.
    #[inline(always)]
    pub(super) fn push(&mut self, item: Packed) {
        self.items[self.len] = item;
        self.len += 1;
    }

    /// Appends `base + lane * step` for each lane of the mask. There must be room.
    #[inline(always)]
    pub(super) fn push_lanes(&mut self, mask: u32, base: Packed, step: Packed) {
        debug_assert!(mask <= ALL, "{mask:#b} is a mask of eight lanes");
        let lanes = &LANES[mask as usize % LANES.len()];
        let room: &mut [Packed] = &mut self.items[self.len..self.len + WIDTH];
        for (item, lane) in room.iter_mut().zip(lanes) {
            *item = base + u64::from(*lane) * step;
        }
        self.len += mask.count_ones() as usize;
    }

    /// Appends what another list holds.
    pub(super) fn extend(&mut self, items: &[Packed]) {
        self.items.truncate(self.len);
        self.items.extend_from_slice(items);
        self.len = self.items.len();
    }

    /// Keeps the pairs from `start` on for which `keep` is true, the lower number first.
    #[inline]
    pub(super) fn retain_from(&mut self, start: usize, keep: impl Fn(u32, u32) -> bool) {
        debug_assert!(start <= self.len);
        let mut end = start;
        for index in start..self.len {
            let [a, b] = unpack(self.items[index]);
            self.items[end] = pack(a.min(b), a.max(b));
            end += usize::from(keep(a, b));
        }
        self.len = end;
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.items.capacity() * size_of::<Packed>()
    }
}
