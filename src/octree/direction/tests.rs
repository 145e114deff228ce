use super::*;

#[test]
fn names_round_trip_in_either_case() {
    for direction in Direction::ALL {
        let name = direction.to_string();
        assert_eq!(name, name.to_uppercase());
        assert_eq!(name.parse(), Ok(direction));
        assert_eq!(name.to_lowercase().parse(), Ok(direction));
    }
    assert_eq!("rUf".parse(), Ok(Vertex::RUF));
}

#[test]
fn kinds_read_only_their_own_names() {
    assert_eq!("d".parse(), Ok(Face::D));
    assert_eq!("UB".parse(), Ok(Edge::UB));
    assert!("UB".parse::<Face>().is_err());
    assert!("R".parse::<Edge>().is_err());
    assert!("RU".parse::<Vertex>().is_err());
}

#[test]
fn unknown_names_are_named_in_the_error() {
    for text in ["", "OMEGA", "UR", "LR", "RUFF", " R", "É"] {
        let error = text.parse::<Direction>().unwrap_err();
        assert_eq!(error.text, text);
        assert!(error.to_string().contains(&format!("`{text}`")));
    }
}

#[test]
fn offsets_follow_bevys_axes() {
    assert_eq!(Face::R.offset(), IVec3::X);
    assert_eq!(Face::L.offset(), IVec3::NEG_X);
    assert_eq!(Face::U.offset(), IVec3::Y);
    assert_eq!(Face::D.offset(), IVec3::NEG_Y);
    assert_eq!(Face::F.offset(), IVec3::NEG_Z);
    assert_eq!(Face::B.offset(), IVec3::Z);
}

#[test]
fn offset_is_the_sum_of_the_letters() {
    for direction in Direction::ALL {
        let letters = direction
            .name()
            .chars()
            .map(|c| c.to_string().parse::<Face>().unwrap().offset());
        assert_eq!(letters.sum::<IVec3>(), direction.offset());
    }
}

#[test]
fn from_offset_inverts_offset_and_refuses_the_rest() {
    for x in -2..=2 {
        for y in -2..=2 {
            for z in -2..=2 {
                let offset = IVec3::new(x, y, z);
                let expected = Direction::ALL.into_iter().find(|d| d.offset() == offset);
                assert_eq!(Direction::from_offset(offset), expected);
            }
        }
    }
    assert_eq!(Direction::from_offset(IVec3::MAX), None);
    assert_eq!(Direction::from_offset(IVec3::MIN), None);
}

#[test]
fn all_is_complete_ordered_and_indexed() {
    for (i, direction) in Direction::ALL.into_iter().enumerate() {
        assert_eq!(direction.index(), i);
        assert_eq!(
            Direction::ALL
                .iter()
                .filter(|d| d.offset() == direction.offset())
                .count(),
            1
        );
    }
    assert!(Direction::ALL.is_sorted());
}

#[test]
fn opposite_negates_the_offset() {
    for direction in Direction::ALL {
        assert_eq!(direction.opposite().offset(), -direction.offset());
    }
}

#[test]
fn a_vertex_counts_its_positive_sides_in_bits() {
    for vertex in Vertex::ALL {
        let positive = vertex.offset().cmpgt(IVec3::ZERO);
        assert_eq!(vertex.bits(), positive.bitmask());
        assert_eq!(Vertex::from_bits(vertex.bits()), vertex);
        assert_eq!(
            Vertex::from_sides(positive.test(0), positive.test(1), positive.test(2)),
            vertex
        );
    }
}
