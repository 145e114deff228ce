//! How polygons hang together: edges, shells, orientation.

use std::collections::HashMap;

use smallvec::SmallVec;

/// What is across a side which no other polygon shares, or more than one.
pub const NO_NEIGHBOR: u32 = u32::MAX;

/// What [`Topology::of`] finds out.
pub struct Topology {
    /// Each edge once, in the order of first use.
    pub edges: Vec<[u32; 2]>,
    /// The polygons across the sides of the polygons as given, one polygon after the other: side i
    /// is that from corner i to the next.
    pub across: Vec<u32>,
    /// A polygon of each connected part of the surface.
    pub shells: Vec<usize>,
    /// The polygons to turn around so that neighbours agree.
    pub flipped: Vec<usize>,
    /// An edge which does not join exactly two polygons that run along it in opposite directions.
    pub open_edge: Option<[u32; 2]>,
}

/// A polygon along an edge, and whether it runs from the lower to the higher vertex.
#[derive(Clone, Copy)]
struct Use {
    polygon: usize,
    upwards: bool,
}

impl Topology {
    /// Linear in the number of corners.
    pub fn of<'a>(polygons: impl ExactSizeIterator<Item = &'a [u32]>) -> Self {
        let count = polygons.len();
        let mut edges = Vec::new();
        let mut uses: Vec<SmallVec<[Use; 2]>> = Vec::new();
        let mut edges_of: Vec<SmallVec<[usize; 4]>> = Vec::with_capacity(count);
        let mut known = HashMap::new();
        for (polygon, corners) in polygons.enumerate() {
            let next = corners.iter().cycle().skip(1);
            let along = corners.iter().zip(next).map(|(&from, &to)| {
                let key = [from.min(to), from.max(to)];
                let edge = *known.entry(key).or_insert_with(|| {
                    edges.push(key);
                    uses.push(SmallVec::new());
                    edges.len() - 1
                });
                let upwards = from < to;
                uses[edge].push(Use { polygon, upwards });
                edge
            });
            edges_of.push(along.collect());
        }
        debug_assert_eq!((uses.len(), edges_of.len()), (edges.len(), count));

        // Walk over each shell from its first polygon, crossing only edges that join two.
        let mut flip: Vec<Option<bool>> = vec![None; count];
        let mut shells = Vec::new();
        let mut front = Vec::new();
        for start in 0..count {
            if flip[start].is_some() {
                continue;
            }
            shells.push(start);
            flip[start] = Some(false);
            front.push((start, false));
            while let Some((polygon, flipped)) = front.pop() {
                for &edge in &edges_of[polygon] {
                    let &[one, two] = uses[edge].as_slice() else {
                        continue;
                    };
                    let other = if one.polygon == polygon { two } else { one };
                    if flip[other.polygon].is_none() {
                        let other_flipped = flipped ^ (one.upwards == two.upwards);
                        flip[other.polygon] = Some(other_flipped);
                        front.push((other.polygon, other_flipped));
                    }
                }
            }
        }

        let other = |polygon: usize, edge: usize| match uses[edge].as_slice() {
            [one, two] if one.polygon == polygon => two.polygon as u32,
            [one, _] => one.polygon as u32,
            _ => NO_NEIGHBOR,
        };
        let across = edges_of
            .iter()
            .enumerate()
            .flat_map(|(polygon, edges)| edges.iter().map(move |&edge| (polygon, edge)))
            .map(|(polygon, edge)| other(polygon, edge))
            .collect();
        let turned = |used: &Use| used.upwards ^ (flip[used.polygon] == Some(true));
        let closes = |uses: &[Use]| matches!(uses, [one, two] if turned(one) != turned(two));
        let open = uses.iter().position(|uses| !closes(uses));
        Self {
            open_edge: open.map(|edge| edges[edge]),
            edges,
            across,
            shells,
            flipped: (0..count)
                .filter(|&polygon| flip[polygon] == Some(true))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topology(polygons: &[[u32; 3]]) -> Topology {
        Topology::of(polygons.iter().map(|polygon| &polygon[..]))
    }

    #[test]
    fn neighbours_are_turned_alike() {
        // A tetrahedron whose third face is turned around, and one more beside it.
        let one = [[0, 2, 1], [0, 1, 3], [2, 1, 3], [2, 0, 3]];
        let two = one.map(|polygon| polygon.map(|vertex| vertex + 4));
        let found = topology(&[one, two].concat());
        assert_eq!((found.flipped, found.open_edge), (vec![2, 6], None));
        assert_eq!((found.edges.len(), found.shells), (12, vec![0, 4]));
    }

    #[test]
    fn edge_of_three_polygons_is_open() {
        let found = topology(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert_eq!(found.open_edge, Some([0, 1]));
        assert_eq!(found.shells.len(), 3);
    }

    #[test]
    fn a_moebius_strip_is_open() {
        // Five triangles in a ring, each sharing an edge with the next, with half a turn.
        let found = topology(&[[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]]);
        assert!(found.open_edge.is_some());
    }
}
