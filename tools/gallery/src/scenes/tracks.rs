//! A clip: objects on position tracks, and the report of what touches what.

use std::fmt::Write as _;

use bevy::prelude::*;
use bevy_octree::{motion::CollisionClock, prelude::*, scene::CollisionReport};

use super::figures;
use crate::{
    play::Tick,
    scene::{AddScene as _, OfScene, Scene, showing},
};

const NAME: &str = "clip";
const FILE: &str = include_str!("../../../../assets/scenes/clip.scene.ron");
/// How many ticks the clip has.
const TICKS: u64 = 240;

/// Adds the clip.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "an animation, and its collision report",
        "An arm lifts a satellite out of a bay, along keyframes. Below: which objects touched so far, \
         and when.",
        |world, _| {
            figures::spawn(world, FILE);
            world.spawn((OfScene, Report::default()));
        },
    );
    app.add_scene(
        scene
            .view(Vec3::new(7.0, 6.0, 13.0), Vec3::new(0.0, 2.8, 0.0))
            .best_tick(100)
            .ends_at(TICKS + 60)
            .caption(say),
    )
    .add_systems(
        Tick,
        note.in_set(CollisionSystems::Last).run_if(showing(NAME)),
    );
}

#[derive(Component, Default)]
struct Report(CollisionReport);

fn note(
    clock: Res<CollisionClock>,
    contacts: Res<Contacts>,
    names: Query<&Name>,
    mut reports: Query<&mut Report>,
) -> Result<(), BevyError> {
    let tick = clock.tick();
    if tick >= TICKS {
        return Ok(());
    }
    let name = |entity| names.get(entity).map_or("", Name::as_str).to_owned();
    let Ok(mut report) = reports.single_mut() else {
        return Ok(());
    };
    let pairs = contacts.iter();
    let named = pairs.map(|contact| (name(contact.a), name(contact.b)));
    report.0.record(tick, named)?;
    Ok(())
}

fn say(world: &mut World) -> String {
    let mut words = "first  last  ticks\n".to_owned();
    let mut reports = world.query::<&Report>();
    for report in reports.iter(world) {
        for pair in report.0.pairs() {
            _ = writeln!(
                words,
                "{:5} {:5} {:6}  {}, {}",
                pair.first_contact, pair.last_contact, pair.ticks, pair.a, pair.b
            );
        }
    }
    words
}
