use super::*;

fn solids(given: &[&[u32]], junctions: &[(u32, u32)]) -> Vec<Option<bool>> {
    let mut polygons = Polygons::default();
    given
        .iter()
        .for_each(|corners| polygons.push(corners).unwrap());
    let all: Vec<_> = (0..given.len() as u32).collect();
    let junctions: Vec<_> = junctions
        .iter()
        .map(|&(side, vertex)| Junction {
            side,
            vertex,
            at: 0.5,
        })
        .collect();
    let found = find(&polygons, &all, &junctions);
    let flip = |bounding: &Option<Bounding>| {
        bounding.map(|found| {
            assert_eq!(found.first, 0);
            found.flip
        })
    };
    found.iter().map(flip).collect()
}

/// The faces of two cubes side by side; those between them are cut along different diagonals.
fn bricks() -> Vec<&'static [u32]> {
    vec![
        // Between: of the first, and of the second.
        &[0, 1, 2],
        &[0, 2, 3],
        &[1, 0, 3],
        &[1, 3, 2],
        // Around the first, and around the second.
        &[1, 0, 4, 5],
        &[2, 1, 5, 6],
        &[3, 2, 6, 7],
        &[0, 3, 7, 4],
        &[7, 6, 5, 4],
        &[0, 1, 9, 8],
        &[1, 2, 10, 9],
        &[2, 3, 11, 10],
        &[3, 0, 8, 11],
        &[8, 9, 10, 11],
    ]
}

#[test]
fn bricks_face_to_face_are_closed_whichever_way_their_wall_faces() {
    assert_eq!(solids(&bricks(), &[]), [Some(false); 14]);
    // One of the walls the other way.
    let mut turned = bricks();
    (turned[0], turned[1]) = (&[2, 1, 0], &[3, 2, 0]);
    let found = solids(&turned, &[]);
    assert!(found.iter().all(Option::is_some), "{found:?}");
}

#[test]
fn a_part_of_an_edge_joins_what_runs_along_the_whole() {
    // A tetrahedron of which one face knows a vertex on its edge, and the other does not; then with
    // a triangle that hangs on a part of the edge, and one that hangs on all of it.
    let faces: [&[u32]; 6] = [
        &[0, 2, 1],
        &[0, 1, 3],
        &[1, 2, 3, 4],
        &[2, 0, 3],
        &[3, 4, 5],
        &[1, 3, 5],
    ];
    let on_the_edge = [(4, 4), (16, 4)];
    assert_eq!(solids(&faces[..4], &[]), [None; 4]);
    assert_eq!(solids(&faces[..4], &on_the_edge), [Some(false); 4]);
    let found = solids(&faces, &on_the_edge);
    assert_eq!(
        (&found[..4], &found[4..]),
        (&[Some(false); 4][..], &[None; 2][..])
    );
}
