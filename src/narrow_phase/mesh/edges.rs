//! Which sides of polygons are the same edge.

use super::polygons::Polygons;

/// What is across a side that no other polygon shares, or more than one.
pub const NO_NEIGHBOR: u32 = u32::MAX;

/// The sides of all polygons, brought together by the vertices at their ends.
#[derive(Debug, Default)]
pub struct Edges {
    /// Each edge once, its lower end first, in the order of first use.
    pub ends: Vec<[u32; 2]>,
    /// For each side, the polygon on the other side of it, or [`NO_NEIGHBOR`].
    pub across: Vec<u32>,
    /// For each side with a neighbour, as a bit: do both polygons run along it the same way?
    pub alike: Bits,
    /// The sides of each edge that more than two polygons share, one edge after the other.
    pub crowded: Vec<u32>,
    /// The vertices at the ends of edges along which an odd number of polygons runs; `None` if there
    /// are none.
    pub at_odd_edges: Option<Bits>,
}

/// A set of indices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bits(Vec<u64>);

impl Bits {
    /// An empty set of indices below `count`.
    pub fn none(count: usize) -> Self {
        Self(vec![0; count.div_ceil(64)])
    }

    #[inline]
    pub fn insert(&mut self, index: u32) {
        self.0[index as usize / 64] |= 1 << (index % 64);
    }

    #[inline]
    pub fn remove(&mut self, index: u32) {
        self.0[index as usize / 64] &= !(1 << (index % 64));
    }

    #[inline]
    pub fn toggle(&mut self, index: u32) {
        self.0[index as usize / 64] ^= 1 << (index % 64);
    }

    #[inline]
    pub fn contains(&self, index: u32) -> bool {
        self.0[index as usize / 64] >> (index % 64) & 1 != 0
    }

    /// The indices in the set, in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.0.iter().enumerate().flat_map(|(word, &bits)| {
            let some = |bits: u64| (bits != 0).then_some(bits);
            std::iter::successors(some(bits), move |bits| some(bits & (bits - 1)))
                .map(move |bits| word as u32 * 64 + bits.trailing_zeros())
        })
    }

    pub const fn memory_bytes(&self) -> usize {
        self.0.capacity() * size_of::<u64>()
    }
}

impl Edges {
    /// Finds the edges of polygons with so many vertices.
    ///
    /// Linear where few sides share a vertex: sides are put in the order of their lower ends by
    /// counting, and then in that of their upper ends by sorting those that have the lower one in
    /// common.
    pub fn of(polygons: &Polygons, vertices: usize) -> Self {
        let sides = polygons.corners().len();
        // Where the sides of a lower end begin, once they are all counted.
        let mut starts = vec![0_u32; vertices + 1];
        polygons.for_each_side(|_, _, from, to| starts[from.min(to) as usize] += 1);
        let mut total = 0;
        for start in &mut starts {
            total += std::mem::replace(start, total);
        }
        let mut sorted = vec![0_u64; sides];
        polygons.for_each_side(|_, side, from, to| {
            let next = &mut starts[from.min(to) as usize];
            sorted[*next as usize] = u64::from(from.max(to)) << 32 | u64::from(side);
            *next += 1;
        });

        let mut edges = Self {
            ends: Vec::new(),
            across: vec![NO_NEIGHBOR; sides],
            alike: Bits::none(sides),
            crowded: Vec::new(),
            at_odd_edges: None,
        };
        let mut repeats = Vec::new();
        let mut count = 0;
        let mut begin = 0;
        for (low, end) in starts[..vertices].iter().enumerate() {
            let end = *end as usize;
            let at_low = &mut sorted[begin..end];
            begin = end;
            at_low.sort_unstable();
            for uses in at_low.chunk_by(|a, b| a >> 32 == b >> 32) {
                count += 1;
                edges.note(polygons, uses, &mut repeats);
                if uses.len() % 2 == 1 {
                    let at_odd = &mut edges.at_odd_edges;
                    let at_odd = at_odd.get_or_insert_with(|| Bits::none(vertices));
                    at_odd.insert(low as u32);
                    at_odd.insert((uses[0] >> 32) as u32);
                }
            }
        }
        repeats.sort_unstable();
        let mut repeats = repeats.into_iter().peekable();
        edges.ends.reserve_exact(count);
        polygons.for_each_side(|polygon, side, from, to| {
            let is_first = edges.across[side as usize] > polygon;
            if is_first && repeats.next_if_eq(&side).is_none() {
                edges.ends.push([from.min(to), from.max(to)]);
            }
        });
        debug_assert_eq!(edges.ends.len(), count);
        edges
    }

    /// Notes the sides of one edge, in the lower halves of `uses`, which are sorted.
    #[inline]
    fn note(&mut self, polygons: &Polygons, uses: &[u64], repeats: &mut Vec<u32>) {
        if let &[one, two] = uses {
            let (one, two) = (one as u32, two as u32);
            let corners = polygons.corners();
            self.across[one as usize] = polygons.owner(two);
            self.across[two as usize] = polygons.owner(one);
            if corners[one as usize] == corners[two as usize] {
                self.alike.insert(one);
                self.alike.insert(two);
            }
            return;
        }
        if uses.len() > 2 {
            let sides = uses.iter().map(|used| *used as u32);
            self.crowded.extend(sides.clone());
            repeats.extend(sides.skip(1));
        }
    }
}
