//! What happened, in numbers.

use std::ops::AddAssign;

use bevy::prelude::*;

use crate::{
    narrow_phase::StageCounters,
    schedule::{CollisionSystems, add_to_tick},
};

/// Counters of the last tick, and their sums since the start.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource, Debug, Default)]
#[type_path = "bevy_octree"]
pub struct CollisionCounters {
    /// The last tick, or the current one as far as it has come.
    pub tick: TickCounters,
    /// The sums over all finished ticks.
    pub total: TickCounters,
}

/// Counters of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct TickCounters {
    /// Entities in the index.
    pub objects: u64,
    /// Entities that moved, came or went.
    pub moved: u64,
    /// Pairs of boxes that the broad phase compared.
    pub pairs_tested: u64,
    /// Pairs given to the exact tests.
    pub candidates: u64,
    /// Pairs of overlapping boxes that were spared the exact tests, since neither entity moved.
    pub resting_pairs: u64,
    /// How many candidates reached and left each stage of the exact tests.
    pub stages: StageCounters,
    /// Pairs in contact.
    pub contacts: u64,
    /// Velocities that were changed by a contact.
    pub bounces: u64,
    /// Contacts that began.
    pub started: u64,
    /// Contacts that ended.
    pub ended: u64,
}

impl AddAssign for TickCounters {
    fn add_assign(&mut self, other: Self) {
        self.objects += other.objects;
        self.moved += other.moved;
        self.pairs_tested += other.pairs_tested;
        self.candidates += other.candidates;
        self.resting_pairs += other.resting_pairs;
        self.stages += other.stages;
        self.contacts += other.contacts;
        self.bounces += other.bounces;
        self.started += other.started;
        self.ended += other.ended;
    }
}

impl CollisionCounters {
    fn begin_tick(mut counters: ResMut<Self>) {
        counters.tick = TickCounters::default();
    }

    pub(crate) fn end_tick(mut counters: ResMut<Self>) {
        let tick = counters.tick;
        counters.total += tick;
    }
}

/// Counts from one tick to the next.
pub(crate) fn register(app: &mut App) {
    app.init_resource::<CollisionCounters>()
        .register_type::<CollisionCounters>();
    add_to_tick(app, |app, schedule| {
        let begin = CollisionCounters::begin_tick.before(CollisionSystems::First);
        app.add_systems(
            schedule,
            (
                begin,
                CollisionCounters::end_tick.after(CollisionSystems::Last),
            ),
        );
    });
}
