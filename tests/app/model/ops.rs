//! What may happen, as plain data, so that a history that failed can be kept as it was printed.

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

impl Part {
    /// Those that are told of by nobody, and of one kind each.
    pub const PLAIN: [Self; 17] = [
        Self::Shape,
        Self::Sensor,
        Self::Detector,
        Self::Static,
        Self::Swept,
        Self::SweptStopping,
        Self::Reverse,
        Self::Reflect,
        Self::Ignored,
        Self::Layers,
        Self::Manifolds,
        Self::Body,
        Self::InnerBody,
        Self::Velocity,
        Self::Proxy,
        Self::Box,
        Self::Transform,
    ];
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

impl Act {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::DespawnOther,
        Self::DespawnSelf,
        Self::OptOut,
        Self::DisableOther,
        Self::PushOther,
        Self::Reshape,
        Self::Spawn,
        Self::Adopt,
    ];
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
