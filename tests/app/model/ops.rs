//! What may happen, as plain data, so that a history that failed can be kept as it was printed.

use proptest::prelude::*;

/// Coordinates in quarters of a unit.
pub type Place = [i8; 3];

/// One of the entities that are there, counted around.
pub type Who = u8;

/// What befalls the world, in a tick or between two.
#[derive(Clone, Debug)]
pub enum Op {
    Spawn(u8, Place),
    SpawnMoving(u8, Place, Place),
    Clone(Who),
    Despawn(Who),
    Move(Who, Place),
    /// To a place far away, or none.
    Teleport(Who, u8),
    Turn(Who, Place),
    Scale(Who, u8),
    /// The shape is changed where it is.
    Resize(Who, u8),
    /// The shape is overwritten by another.
    Swap(Who, u8),
    /// The shape goes, and comes at once.
    Renew(Who),
    Reparent(Who, Who),
    Orphan(Who),
    Disable(Who, bool),
    Enable(Who),
    Give(Who, Part),
    Take(Who, Part),
    Ignore(Who, Who),
    Layers(Who, u8, u8),
    Velocity(Who, Place),
    Method(u8),
    Kinds(u8),
    Tolerance(bool),
    Messages(bool),
    /// The observers of an entity act from now on.
    Watch(Who, bool, Act),
    /// All in a world go with it.
    EndWorld(bool),
    Clear,
    Flush,
    /// A ray, a ball and a point are asked about.
    Query(Place, Place),
}

/// Components that come and go.
#[derive(Clone, Copy, Debug)]
pub enum Part {
    Shape,
    Sensor,
    Detector,
    Static,
    Swept,
    SweptStopping,
    Reverse,
    Reflect,
    World(bool),
    Ignored,
    Layers,
    Events,
    Manifolds,
    Colliding,
    Body,
    InnerBody,
    Velocity,
    Proxy,
    Box,
    Transform,
}

/// What an observer does when it is told.
#[derive(Clone, Copy, Debug)]
pub enum Act {
    DespawnOther,
    DespawnSelf,
    OptOut,
    DisableOther,
    PushOther,
    Reshape,
    Spawn,
    Adopt,
}

/// A step of a history.
#[derive(Clone, Debug)]
pub enum Step {
    Do(Op),
    Tick,
    /// A tick without the stages whose bits are set.
    TickWithout(u8),
    /// A tick in which something happens before the set of this number.
    TickWith(u8, Op),
}

fn place() -> impl Strategy<Value = Place> {
    prop_oneof![3 => prop::array::uniform3(-8_i8..9), 3 => prop::array::uniform3(-3_i8..4)]
}

fn part() -> impl Strategy<Value = Part> {
    prop_oneof![
        prop::sample::select(vec![
            Part::Shape,
            Part::Sensor,
            Part::Detector,
            Part::Static,
            Part::Swept,
            Part::SweptStopping,
            Part::Reverse,
            Part::Reflect,
            Part::Ignored,
            Part::Layers,
            Part::Manifolds,
            Part::Body,
            Part::InnerBody,
            Part::Velocity,
            Part::Proxy,
            Part::Box,
            Part::Transform,
        ]),
        any::<bool>().prop_map(Part::World),
        Just(Part::Events),
        Just(Part::Colliding),
    ]
}

fn act() -> impl Strategy<Value = Act> {
    prop::sample::select(vec![
        Act::DespawnOther,
        Act::DespawnSelf,
        Act::OptOut,
        Act::DisableOther,
        Act::PushOther,
        Act::Reshape,
        Act::Spawn,
        Act::Adopt,
    ])
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
