//! Rollback by `bevy_ggrs`: whatever is simulated again comes out the same.

mod arena;
mod peers;
mod spawning;
mod story;

use std::time::Duration;

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_ggrs::{RollbackFrameCount, prelude::*};

use crate::{
    arena::{ArenaPlugin, Game},
    story::{Counted, Stories},
};

const ALL: &[&str] = &[
    "place",
    "velocity",
    "armour",
    "character",
    "hit",
    "contact",
    "clock",
    "started",
    "ended",
    "bodies started",
    "bodies ended",
];

/// How many frames are looked at when each is simulated again.
const FRAMES: i32 = 3000;

/// One frame of the game for each update.
fn app(session: Session<Game>, counted: &'static [&'static str]) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, GgrsPlugin::<Game>::default(), ArenaPlugin))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_nanos(
            1_000_000_000 / 60,
        )))
        .insert_resource(Counted(counted))
        .insert_resource(session);
    app.finish();
    app.cleanup();
    app
}

fn frame(app: &App) -> i32 {
    app.world().resource::<RollbackFrameCount>().0
}

/// Each frame is simulated, and seven times more.
fn sync_test(frames: i32, counted: &'static [&'static str]) -> Stories {
    let session = SessionBuilder::<Game>::new()
        .with_num_players(2)
        .and_then(|builder| {
            builder
                .with_max_prediction_window(8)
                .with_check_distance(7)
                .add_player(PlayerType::Local, 0)
        })
        .and_then(|builder| builder.add_player(PlayerType::Local, 1))
        .and_then(SessionBuilder::start_synctest_session)
        .unwrap();
    let mut app = app(Session::SyncTest(session), counted);
    app.world_mut()
        .add_observer(|mismatch: On<SyncTestMismatch>, stories: Res<Stories>| {
            panic!(
                "{:?}: {}",
                mismatch.event(),
                stories.first.as_deref().unwrap_or("no story")
            );
        });
    let mut updates = 0;
    while frame(&app) < frames {
        app.update();
        updates += 1;
        assert!(updates < 2 * frames, "the game goes on");
        let mut stories = app.world_mut().resource_mut::<Stories>();
        let newest = stories.of_frame.keys().next_back().copied().unwrap_or(0);
        stories.of_frame.retain(|frame, _| *frame > newest - 20);
    }
    app.world_mut().remove_resource::<Stories>().unwrap()
}

#[test]
fn nothing_changes_by_being_rolled_back() {
    let stories = sync_test(FRAMES, ALL);
    assert_eq!(
        stories.differences,
        0,
        "{}",
        stories.first.unwrap_or_default()
    );
    // Each frame but the first few was told again and again, and there was much to tell.
    println!("{} frames told: {:?}", stories.told, stories.lines);
    assert!(stories.told > 6 * FRAMES as u64);
    for what in ALL {
        let lines = stories.lines.get(what).copied().unwrap_or(0);
        assert!(lines > FRAMES as u64 / 10, "{what}: {lines}");
    }
}
