//! Polygons that are there more than once.

use std::cmp::Ordering;

use super::{edges::Edges, polygons::Polygons};

/// A polygon with the same corners as an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Twin {
    pub polygon: u32,
    /// The one that it is a copy of; `None` if there is one that faces the other way: together they
    /// are a wall that is nothing but surface, unless [`resolve`] finds that they bound a solid.
    pub of: Option<u32>,
    /// The first with the same corners; this one, maybe.
    pub first: u32,
    /// Does it face the other way than the first?
    pub is_turned: bool,
}

/// The first polygons of walls.
pub fn fronts(twins: &[Twin]) -> impl Iterator<Item = u32> {
    let is_front = |twin: &&Twin| twin.of.is_none() && twin.polygon == twin.first;
    twins.iter().filter(is_front).map(|twin| twin.polygon)
}

/// Makes copies of walls whose first polygon bounds a solid.
pub fn resolve(twins: &mut Vec<Twin>, is_solid: impl Fn(u32) -> bool) {
    for twin in twins.iter_mut().filter(|twin| is_solid(twin.first)) {
        twin.of = Some(twin.first);
    }
    twins.retain(|twin| twin.of != Some(twin.polygon));
}

/// Finds polygons with the same corners, in their order. The first of several that face the same
/// way is not listed.
///
/// Only what shares edges with more than two polygons is looked at: two that have no more than each
/// other are a shell of their own.
pub fn find(polygons: &Polygons, edges: &Edges) -> Vec<Twin> {
    let mut crowded: Vec<u32> = edges
        .crowded
        .iter()
        .map(|side| polygons.owner(*side))
        .collect();
    crowded.sort_unstable();
    crowded.dedup();
    let mut keyed: Vec<_> = crowded
        .iter()
        .map(|&polygon| Key::of(polygons, polygon))
        .collect();
    keyed.sort_unstable_by(|a, b| a.compare(b, polygons).then(a.polygon.cmp(&b.polygon)));
    let mut twins = Vec::new();
    for same in keyed.chunk_by(|a, b| a.compare(b, polygons).is_eq()) {
        let (first, rest) = (&same[0], &same[1..]);
        let twin = |key: &Key, of| Twin {
            polygon: key.polygon,
            of,
            first: first.polygon,
            is_turned: key.turned != first.turned,
        };
        if rest.iter().any(|key| key.turned != first.turned) {
            twins.extend(same.iter().map(|key| twin(key, None)));
        } else {
            twins.extend(rest.iter().map(|key| twin(key, Some(first.polygon))));
        }
    }
    twins.sort_unstable_by_key(|twin| twin.polygon);
    twins
}

/// The corners of a polygon, from the lowest on towards its lower neighbour.
struct Key {
    polygon: u32,
    start: usize,
    turned: bool,
}

impl Key {
    fn of(polygons: &Polygons, polygon: u32) -> Self {
        let corners = polygons.get(polygon as usize);
        let count = corners.len();
        let start = (0..count).min_by_key(|i| corners[*i]).unwrap_or(0);
        let turned = corners[(start + count - 1) % count] < corners[(start + 1) % count];
        Self {
            polygon,
            start,
            turned,
        }
    }

    fn corners<'a>(&self, polygons: &'a Polygons) -> impl Iterator<Item = u32> + use<'a> {
        let corners = polygons.get(self.polygon as usize);
        let (count, start, turned) = (corners.len(), self.start, self.turned);
        (0..count).map(move |i| corners[(start + if turned { count - i } else { i }) % count])
    }

    fn compare(&self, other: &Self, polygons: &Polygons) -> Ordering {
        self.corners(polygons).cmp(other.corners(polygons))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_and_backs_are_found() {
        let mut polygons = Polygons::default();
        // Once, thrice the same way round, twice each way round, and other corners.
        for corners in [
            [0_u32, 1, 2],
            [3, 1, 0],
            [1, 0, 3],
            [0, 3, 1],
            [4, 0, 1],
            [1, 0, 4],
            [0, 1, 5],
        ] {
            polygons.push(&corners).unwrap();
        }
        let mut found = find(&polygons, &Edges::of(&polygons, 6));
        let twin = |polygon, of, first, is_turned| Twin {
            polygon,
            of,
            first,
            is_turned,
        };
        let copies = [twin(2, Some(1), 1, false), twin(3, Some(1), 1, false)];
        let wall = [twin(4, None, 4, false), twin(5, None, 4, true)];
        assert_eq!(found, [copies, wall].concat());
        resolve(&mut found, |polygon| polygon == 4);
        assert_eq!(found[2..], [twin(5, Some(4), 4, true)]);
    }
}
