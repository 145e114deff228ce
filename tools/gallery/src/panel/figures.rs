//! What the panel says: the scene, counts, times.

use bevy::{
    diagnostic::{Diagnostic, DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
};
use bevy_octree::{
    broad_phase::BroadPhaseStats, collision_index::CollisionIndex, diagnostics::StageTimes,
    prelude::*,
};

use crate::{
    play::{self, Play},
    scene::{Began, Gallery},
};

/// Which text it is.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    /// The name of the scene, and its title.
    Title,
    /// What there is to see.
    About,
    /// Numbers that are the same wherever it runs.
    Counts,
    /// How long things take.
    Times,
    /// What the scene has to say by itself.
    Caption,
}

/// Adds what is said.
pub fn plugin(app: &mut App) {
    app.add_observer(introduce).add_systems(
        Last,
        (
            count.run_if(play::ticked.or_eager(resource_changed::<Gallery>)),
            time.run_if(any_with_component::<Window>),
            caption,
        ),
    );
}

fn introduce(began: On<Began>, gallery: Res<Gallery>, mut texts: Query<(&Said, &mut Text)>) {
    if !began.is_other {
        return;
    }
    let scene = gallery.scene();
    for (said, mut text) in &mut texts {
        text.0 = match said {
            Said::Title => format!("{}: {}", scene.name, scene.title),
            Said::About => scene.about.to_owned(),
            _ => continue,
        };
    }
}

fn count(
    counters: Res<CollisionCounters>,
    index: Res<CollisionIndex>,
    play: Res<Play>,
    mut texts: Query<(&Said, &mut Text)>,
) {
    let tick = &counters.tick;
    let stats: BroadPhaseStats = index.index().stats();
    let bounces = tick.bounces;
    for (said, mut text) in &mut texts {
        if *said == Said::Counts {
            text.0 = format!(
                "tick {}: {} objects, {} moved\n\
                 {} pairs of boxes compared, {} overlap\n\
                 {} in contact, {bounces} bounces\n\
                 octree: {} leaves, depth {}, {} kB",
                play.tick,
                tick.objects,
                tick.moved,
                tick.pairs_tested,
                tick.candidates + tick.resting_pairs,
                tick.contacts,
                stats.leaves,
                stats.depth,
                index.index().memory_bytes() / 1024,
            );
        }
    }
}

/// How long things take: not in pictures, which are to be the same on every run.
fn time(
    times: Res<StageTimes>,
    store: Res<DiagnosticsStore>,
    mut texts: Query<(&Said, &mut Text)>,
    mut smooth: Local<f64>,
) {
    let frame = store
        .get(&FrameTimeDiagnosticsPlugin::FRAME_TIME)
        .and_then(Diagnostic::smoothed)
        .unwrap_or_default();
    let tick = times.sum().as_secs_f64() * 1e3;
    *smooth += (tick - *smooth) * 0.1;
    for (said, mut text) in &mut texts {
        if *said == Said::Times {
            let rate = 1e3 / frame.max(0.1);
            let words = format!(
                "collisions {:.2} ms per tick, frame {frame:.1} ms ({rate:.0} per second)",
                *smooth
            );
            text.set_if_neq(Text(words));
        }
    }
}

fn caption(world: &mut World, mut texts: Local<Option<QueryState<(&Said, &mut Text)>>>) {
    let Some(caption) = world.resource::<Gallery>().scene().caption else {
        say(world, &mut texts, String::new());
        return;
    };
    let words = caption(world);
    say(world, &mut texts, words);
}

fn say(
    world: &mut World,
    texts: &mut Option<QueryState<(&'static Said, &'static mut Text)>>,
    words: String,
) {
    let texts = texts.get_or_insert_with(|| world.query());
    for (said, mut text) in texts.iter_mut(world) {
        if *said == Said::Caption {
            text.set_if_neq(Text(words.clone()));
        }
    }
}
