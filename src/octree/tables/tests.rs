use bevy::math::IVec3;

use super::*;

/// The lower corner of the unit cell that is the octant of the block from 0 to 2.
fn cell(octant: Vertex) -> IVec3 {
    (octant.offset() + IVec3::ONE) / 2
}

/// The cell that the step leads to, and the lattice place of the block it belongs to.
fn step(direction: Direction, octant: Vertex) -> (IVec3, IVec3) {
    let cell = cell(octant) + direction.offset();
    (
        cell.rem_euclid(IVec3::splat(2)),
        cell.div_euclid(IVec3::splat(2)),
    )
}

/// Every direction with every octant.
fn entries() -> impl Iterator<Item = (Direction, Vertex)> {
    Direction::ALL
        .into_iter()
        .flat_map(|direction| Vertex::ALL.map(|octant| (direction, octant)))
}

#[test]
fn adj_is_contact_with_the_feature() {
    for (direction, octant) in entries() {
        // The feature is where the block's closed cell meets the one in that direction.
        let block = direction.offset() * 2;
        let (low, high) = (block.max(IVec3::ZERO), (block + 2).min(IVec3::splat(2)));
        let cell = cell(octant);
        let overlap = high.min(cell + 1) - low.max(cell);
        let touches = overlap.min_element() >= 0;
        assert_eq!(direction.adj(octant), touches, "{direction} of {octant}");
    }
}

#[test]
fn reflect_is_the_place_in_the_block_that_is_reached() {
    for (direction, octant) in entries() {
        let (place, _) = step(direction, octant);
        assert_eq!(
            cell(direction.reflect(octant)),
            place,
            "{direction} of {octant}"
        );
    }
}

#[test]
fn common_face_and_edge_lie_between_the_blocks() {
    for (direction, octant) in entries() {
        let (_, block) = step(direction, octant);
        let face = Face::ALL.into_iter().find(|face| face.offset() == block);
        let edge = Edge::ALL.into_iter().find(|edge| edge.offset() == block);
        match direction {
            Direction::Face(_) => {}
            Direction::Edge(step) => assert_eq!(step.common_face(octant), face),
            Direction::Vertex(step) => {
                assert_eq!(step.common_face(octant), face);
                assert_eq!(step.common_edge(octant), edge);
            }
        }
    }
}

#[test]
fn an_exit_is_one_of_the_four_cases() {
    for (direction, octant) in entries() {
        let (_, block) = step(direction, octant);
        let exit = direction.exit(octant);
        assert_eq!(exit.map_or(IVec3::ZERO, Direction::offset), block);
        assert_eq!(exit == Some(direction), direction.adj(octant));
    }
}
