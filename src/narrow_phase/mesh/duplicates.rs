//! Polygons that are there more than once.

use std::cmp::Ordering;

use super::{edges::Edges, polygons::Polygons};

/// A polygon with the same corners as an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Twin {
    pub polygon: u32,
    /// The one that it is a copy of; `None` if there is one that faces the other way: together they
    /// are a wall that is nothing but surface.
    pub of: Option<u32>,
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
        if rest.iter().any(|key| key.turned != first.turned) {
            twins.extend(same.iter().map(|key| Twin {
                polygon: key.polygon,
                of: None,
            }));
        } else {
            twins.extend(rest.iter().map(|key| Twin {
                polygon: key.polygon,
                of: Some(first.polygon),
            }));
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
        let found = find(&polygons, &Edges::of(&polygons, 6));
        let twin = |polygon, of| Twin { polygon, of };
        let expected = [
            twin(2, Some(1)),
            twin(3, Some(1)),
            twin(4, None),
            twin(5, None),
        ];
        assert_eq!(found, expected);
    }
}
