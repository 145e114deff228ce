//! Ticks of which some sets are skipped, and what is told of contacts meanwhile.

use bevy::prelude::*;
use bevy_octree::prelude::*;

use super::{EntityPair, SETS, pair, sorted};

/// The sets that do not run in the tick to come.
#[derive(Resource, Default)]
struct Skipped(Vec<CollisionSystems>);

/// Has any set of `Update` skipped that [`skip`] is told of, and what is told of contacts
/// [followed](Told).
pub fn let_sets_be_skipped(app: &mut App) {
    app.init_resource::<Skipped>().init_resource::<Told>();
    for set in SETS {
        app.configure_sets(
            Update,
            set.run_if(move |skipped: Res<Skipped>| !skipped.0.contains(&set)),
        );
    }
    app.add_systems(Update, Told::follow.in_set(CollisionSystems::Last));
}

/// These do not run from the next tick on.
pub fn skip(app: &mut App, sets: &[CollisionSystems]) {
    app.world_mut().resource_mut::<Skipped>().0 = sets.to_vec();
}

/// What messages told.
#[derive(Resource, Default)]
pub struct Told {
    /// The contacts that started and have not ended.
    open: Vec<EntityPair>,
    /// The messages of the last tick, those of ends first.
    pub last: Vec<String>,
}

impl Told {
    fn follow(
        mut told: ResMut<Self>,
        mut started: MessageReader<CollisionStarted>,
        mut ended: MessageReader<CollisionEnded>,
    ) {
        told.last.clear();
        for message in ended.read() {
            let pair = pair(message.a, message.b);
            let place = told.open.iter().position(|other| *other == pair);
            told.open.swap_remove(place.expect("what ends has started"));
            told.last.push(format!("- {} {}", message.a, message.b));
        }
        for message in started.read() {
            let pair = pair(message.a, message.b);
            assert!(!told.open.contains(&pair), "{pair:?} started twice");
            told.open.push(pair);
            let (a, b, time) = (message.a, message.b, message.time);
            told.last.push(format!("+ {a} {b} {time}"));
        }
    }
}

/// The contacts that started and have not ended, sorted.
pub fn told(app: &App) -> Vec<EntityPair> {
    sorted(app.world().resource::<Told>().open.clone())
}
