use super::*;

fn lists(given: &[&[u32]]) -> Polygons {
    let mut polygons = Polygons::default();
    given
        .iter()
        .for_each(|corners| polygons.push(corners).unwrap());
    polygons
}

/// Of triangles whose vertices are far from the edges of others.
fn topology(triangles: &[[u32; 3]]) -> Topology {
    let polygons = lists(
        &triangles
            .iter()
            .map(|corners| &corners[..])
            .collect::<Vec<_>>(),
    );
    let count = polygons.corners().iter().max().unwrap() + 1;
    let vertices = (0..count)
        .map(|i| i as f32)
        .map(|i| Vec3::new(i, i * i, i * i * i));
    Topology::of(&vertices.collect::<Vec<_>>(), &polygons, None, 0.0)
}

/// A tetrahedron; the outer side of each face is where it runs counter-clockwise.
const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

#[test]
fn neighbours_are_turned_alike() {
    // A tetrahedron whose third face is turned around, and one more beside it, whose first is.
    let mut one = TETRAHEDRON;
    one[2].reverse();
    let mut two = TETRAHEDRON.map(|polygon| polygon.map(|vertex| vertex + 4));
    two[0].reverse();
    let found = topology(&[one, two].concat());
    assert_eq!((found.flipped, found.open_edge), (vec![2, 4], None));
    assert_eq!((found.edges.len(), found.shells), (12, vec![0, 4]));
    assert_eq!(found.solid, Solid::All);
}

#[test]
fn edge_of_three_polygons_is_open() {
    let found = topology(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    assert_eq!(found.open_edge, Some([0, 1]));
    assert_eq!((found.shells.len(), found.solid), (3, Solid::None));
    assert_eq!(found.across, [NO_NEIGHBOR; 9]);
}

#[test]
fn a_moebius_strip_is_open() {
    // Five triangles in a ring, each sharing an edge with the next, with half a turn.
    let found = topology(&[[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]]);
    assert_eq!(found.solid, Solid::None);
    assert!(found.open_edge.is_some());
}

#[test]
fn what_hangs_on_a_solid_is_no_part_of_it() {
    // Two triangles on one of its edges, one behind the other; and a pair with nothing between.
    let more = [[1, 0, 4], [4, 0, 5], [6, 7, 8], [8, 7, 6]];
    let found = topology(&[&TETRAHEDRON[..], &more].concat());
    let solid: Vec<_> = (0..8)
        .filter(|polygon| found.solid.contains(*polygon))
        .collect();
    assert_eq!(solid, [0, 1, 2, 3]);
    assert_eq!(found.open_edge, Some([0, 1]));
}

#[test]
fn copies_count_once() {
    let twice = [TETRAHEDRON, TETRAHEDRON].concat();
    let found = topology(&twice);
    let solid: Vec<_> = (0..8)
        .filter(|polygon| found.solid.contains(*polygon))
        .collect();
    assert_eq!((solid, found.open_edge), (vec![0, 1, 2, 3], None));
    let back = TETRAHEDRON.map(|[a, b, c]| [b, a, c]);
    // So do two sides of one, which are turned to the front's; with one side of one missing, too.
    for count in [8, 7] {
        let found = topology(&[TETRAHEDRON, back].concat()[..count]);
        let solid: Vec<_> = (0..count as u32)
            .filter(|polygon| found.solid.contains(*polygon))
            .collect();
        assert_eq!((solid, found.open_edge), (vec![0, 1, 2, 3], None));
        assert_eq!(
            (found.flipped, found.twins.len()),
            ((4..count as u32).collect(), count - 4)
        );
    }
    // With a face missing, all sides are surfaces.
    let found = topology(&[&TETRAHEDRON[1..], &back[1..]].concat());
    assert_eq!((found.solid, found.twins.len()), (Solid::None, 6));
}

#[test]
fn a_wall_within_bounds_nothing() {
    // Two tetrahedra on one another, with the triangle between them once, twice or not at all.
    let outside = [
        [0, 1, 3],
        [1, 2, 3],
        [2, 0, 3],
        [1, 0, 4],
        [2, 1, 4],
        [0, 2, 4],
    ];
    let wall: [u32; 3] = [0, 1, 2];
    let closed = topology(&outside);
    assert_eq!((closed.solid, closed.open_edge), (Solid::All, None));
    let once = topology(&[&outside[..], &[wall]].concat());
    let solid: Vec<_> = (0..7)
        .filter(|polygon| once.solid.contains(*polygon))
        .collect();
    assert_eq!(
        (solid, once.open_edge.is_some()),
        (vec![0, 1, 2, 3, 4, 5], true)
    );
    let both = topology(&[&outside[..], &[wall, [2, 1, 0]]].concat());
    let twins: Vec<_> = both
        .twins
        .iter()
        .map(|twin| (twin.polygon, twin.of))
        .collect();
    assert_eq!((twins, both.open_edge), (vec![(6, None), (7, None)], None));
}

#[test]
fn edges_are_listed_by_first_use() {
    let polygons = lists(&[&[5, 3, 4], &[4, 3, 1, 0], &[3, 4, 2], &[7, 8, 9]]);
    let edges = Edges::of(&polygons, 10);
    let expected = [
        [3, 5],
        [3, 4],
        [4, 5],
        [1, 3],
        [0, 1],
        [0, 4],
        [2, 4],
        [2, 3],
        [7, 8],
        [8, 9],
        [7, 9],
    ];
    assert_eq!(edges.ends, expected);
    assert_eq!(edges.crowded, [1, 3, 7]);
    let at_odd_edges: Vec<_> = edges.at_odd_edges.unwrap().iter().collect();
    assert_eq!(at_odd_edges, [0, 1, 2, 3, 4, 5, 7, 8, 9]);
    assert_eq!(
        (polygons.owner(6), polygons.owner(7), polygons.end_of(6)),
        (1, 2, 4)
    );
}
