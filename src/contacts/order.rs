//! The order of pairs.

use crate::broad_phase::Pair;

/// Puts pairs in their order, with memory that outlives it.
///
/// By a counting sort on the first of the two, if there are enough pairs for the number of handles,
/// and by comparisons within what that leaves together: O(n), but for those that many others touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorter {
    /// By the first handle: where its pairs begin, and end once they are put there.
    ends: Vec<u32>,
    sorted: Vec<Pair>,
}

/// So many handles for each pair make a counting sort slower than comparisons.
const HANDLES_PER_PAIR: usize = 8;

impl Sorter {
    /// Sorts pairs whose handles are below a number.
    pub(super) fn sort(&mut self, pairs: &mut Vec<Pair>, handles: usize) {
        let is_countable =
            u32::try_from(pairs.len()).is_ok() && pairs.iter().all(|pair| pair.a.index() < handles);
        if !is_countable || handles > pairs.len().saturating_mul(HANDLES_PER_PAIR) {
            pairs.sort_unstable_by_key(|pair| pair.key());
            return;
        }
        self.ends.clear();
        self.ends.resize(handles, 0);
        for pair in &*pairs {
            self.ends[pair.a.index()] += 1;
        }
        let mut start = 0;
        for end in &mut self.ends {
            start += std::mem::replace(end, start);
        }
        self.sorted.clear();
        self.sorted.extend_from_slice(pairs);
        for pair in &*pairs {
            let end = &mut self.ends[pair.a.index()];
            self.sorted[*end as usize] = *pair;
            *end += 1;
        }
        for of_one in self.sorted.chunk_by_mut(|one, other| one.a == other.a) {
            if of_one.len() > 1 {
                of_one.sort_unstable_by_key(|pair| pair.b);
            }
        }
        std::mem::swap(pairs, &mut self.sorted);
    }
}

#[cfg(test)]
mod tests {
    use fastrand::Rng;

    use super::*;
    use crate::broad_phase::ProxyId;

    #[test]
    fn pairs_are_sorted_whatever_their_number() {
        let mut sorter = Sorter::default();
        let mut rng = Rng::with_seed(4);
        for (handles, count) in [
            (2, 0),
            (2, 3),
            (1000, 10),
            (1000, 125),
            (1000, 5000),
            (3, 9000),
        ] {
            let mut pairs: Vec<Pair> = (0..count)
                .map(|_| {
                    let a = rng.u32(0..handles - 1);
                    Pair::new(ProxyId::new(a), ProxyId::new(rng.u32(a + 1..handles)))
                })
                .collect();
            let mut expected = pairs.clone();
            expected.sort();
            sorter.sort(&mut pairs, handles as usize);
            assert_eq!(pairs, expected);
        }
    }

    #[test]
    fn handles_beyond_their_number_are_sorted_too() {
        let mut pairs = vec![
            Pair::new(ProxyId::new(7), ProxyId::new(9)),
            Pair::new(ProxyId::new(0), ProxyId::new(9)),
        ];
        Sorter::default().sort(&mut pairs, 2);
        assert!(pairs.is_sorted());
    }
}
