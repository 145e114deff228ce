//! Histories at random.

use proptest::prelude::*;

use super::ops::{Act, Op, Part, Place, Step, Who};

fn place() -> impl Strategy<Value = Place> {
    prop_oneof![3 => prop::array::uniform3(-8_i8..9), 3 => prop::array::uniform3(-3_i8..4)]
}

fn part() -> impl Strategy<Value = Part> {
    prop_oneof![
        prop::sample::select(Part::PLAIN.to_vec()),
        any::<bool>().prop_map(Part::World),
        Just(Part::Events),
        Just(Part::Colliding),
    ]
}

fn act() -> impl Strategy<Value = Act> {
    prop::sample::select(Act::ALL.to_vec())
}

pub fn op() -> impl Strategy<Value = Op> {
    let who = any::<Who>;
    let frequent = prop_oneof![
        (0_u8..12, place()).prop_map(|(kind, at)| Op::Spawn(kind, at)),
        (0_u8..12, place(), place()).prop_map(|(kind, at, way)| Op::SpawnMoving(kind, at, way)),
        (who(), place()).prop_map(|(who, to)| Op::Move(who, to)),
        (who(), part()).prop_map(|(who, part)| Op::Give(who, part)),
        (who(), part()).prop_map(|(who, part)| Op::Take(who, part)),
        (place(), place()).prop_map(|(from, to)| Op::Query(from, to)),
    ];
    let objects = prop_oneof![
        who().prop_map(Op::Despawn),
        who().prop_map(Op::Clone),
        (who(), 0_u8..8).prop_map(|(who, far)| Op::Teleport(who, far)),
        (who(), place()).prop_map(|(who, turn)| Op::Turn(who, turn)),
        (who(), 0_u8..6).prop_map(|(who, scale)| Op::Scale(who, scale)),
        (who(), 0_u8..12).prop_map(|(who, size)| Op::Resize(who, size)),
        (who(), 0_u8..12).prop_map(|(who, kind)| Op::Swap(who, kind)),
        who().prop_map(Op::Renew),
        (who(), who()).prop_map(|(who, on)| Op::Reparent(who, on)),
        who().prop_map(Op::Orphan),
        (who(), any::<bool>()).prop_map(|(who, own)| Op::Disable(who, own)),
        who().prop_map(Op::Enable),
        (who(), who()).prop_map(|(who, other)| Op::Ignore(who, other)),
        (who(), 0_u8..8, 0_u8..8).prop_map(|(who, on, meets)| Op::Layers(who, on, meets)),
        (who(), place()).prop_map(|(who, way)| Op::Velocity(who, way)),
    ];
    let rest = prop_oneof![
        3 => (who(), any::<bool>(), act()).prop_map(|(who, end, act)| Op::Watch(who, end, act)),
        1 => (0_u8..7).prop_map(Op::Method),
        1 => (0_u8..8).prop_map(Op::Kinds),
        1 => any::<bool>().prop_map(Op::Tolerance),
        1 => any::<bool>().prop_map(Op::Messages),
        2 => Just(Op::Flush),
    ];
    let rare = prop_oneof![any::<bool>().prop_map(Op::EndWorld), Just(Op::Clear)];
    prop_oneof![60 => frequent, 50 => objects, 20 => rest, 1 => rare]
}

fn crowd() -> impl Strategy<Value = Vec<Step>> {
    let near = || prop::array::uniform3(-5_i8..6);
    let one = prop_oneof![
        2 => (0_u8..12, near()).prop_map(|(kind, at)| Op::Spawn(kind, at)),
        1 => (0_u8..12, near(), near()).prop_map(|(kind, at, way)| Op::SpawnMoving(kind, at, way)),
        1 => any::<Who>().prop_map(|who| Op::Give(who, Part::Events)),
        1 => any::<Who>().prop_map(|who| Op::Give(who, Part::Colliding)),
        1 => (any::<Who>(), any::<bool>(), act()).prop_map(|(who, end, act)| Op::Watch(who, end, act)),
    ];
    prop::collection::vec(one.prop_map(Step::Do), 0..28)
}

/// Some that are there at first, and what befalls them.
pub fn history(length: usize) -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        12 => op().prop_map(Step::Do),
        5 => Just(Step::Tick),
        1 => any::<u8>().prop_map(Step::TickWithout),
        1 => (0_u8..9, op()).prop_map(|(gap, op)| Step::TickWith(gap, op)),
    ];
    (crowd(), prop::collection::vec(step, 1..length))
        .prop_map(|(crowd, steps)| [crowd, steps].concat())
}
