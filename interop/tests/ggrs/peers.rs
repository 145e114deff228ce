//! Two peers over a network that is late, and loses packets.

use std::{collections::BTreeMap, thread, time::Duration};

use bevy::prelude::*;
use bevy_ggrs::{ConfirmedFrameCount, ggrs::DesyncDetection, prelude::*};
use interop::network::{Conditions, LossyNetwork};

use crate::{
    ALL, app,
    arena::Game,
    frame,
    story::{Line, Stories, difference},
};

/// How many frames both of them have to have confirmed.
const FRAMES: i32 = 1500;
const AN_HOUR: Duration = Duration::from_secs(3600);

fn peer(network: &LossyNetwork, own: usize) -> App {
    let other = 1 - own;
    let session = SessionBuilder::<Game>::new()
        .with_num_players(2)
        .unwrap()
        .with_max_prediction_window(10)
        .with_input_delay(1)
        .with_desync_detection_mode(DesyncDetection::On { interval: 1 })
        // By the clock of the machine, which may have other things to do.
        .with_disconnect_timeout(AN_HOUR)
        .with_disconnect_notify_delay(AN_HOUR)
        .add_player(PlayerType::Local, own)
        .unwrap()
        .add_player(PlayerType::Remote(other), other)
        .unwrap()
        .start_p2p_session(network.socket(own))
        .unwrap();
    app(Session::P2P(session), ALL)
}

/// What happens to the session, if it is something bad.
fn complaints(app: &mut App) -> Vec<String> {
    let Session::P2P(session) = &mut *app.world_mut().resource_mut::<Session<Game>>() else {
        return Vec::new();
    };
    let events = session.events();
    let bad = events.filter(|event| {
        matches!(
            event,
            GgrsEvent::DesyncDetected { .. } | GgrsEvent::Disconnected { .. }
        )
    });
    bad.map(|event| format!("{event:?}")).collect()
}

/// Up to which frame nothing changes any more.
fn confirmed(app: &App) -> i32 {
    app.world().resource::<ConfirmedFrameCount>().0
}

/// Takes the frames that nothing changes any more, in their last version.
fn take_confirmed(app: &mut App, into: &mut BTreeMap<i32, Vec<Line>>) {
    // The frame that comes before the first one that may yet be restored.
    let confirmed = confirmed(app) - 1;
    let mut stories = app.world_mut().resource_mut::<Stories>();
    let later = stories.of_frame.split_off(&(confirmed + 1));
    into.append(&mut stories.of_frame);
    stories.of_frame = later;
}

#[test]
fn two_peers_over_a_bad_network_stay_equal() {
    let conditions = Conditions {
        loss: 0.15,
        doubled: 0.05,
        delay: 1..=4,
    };
    let network = LossyNetwork::new(conditions, 7);
    let mut peers = [0, 1].map(|own| peer(&network, own));
    let mut told = [BTreeMap::new(), BTreeMap::new()];
    let (mut updates, mut compared) = (0_u64, 0);
    while compared < FRAMES {
        network.step();
        for (peer, told) in peers.iter_mut().zip(&mut told) {
            peer.update();
            assert_eq!(
                complaints(peer),
                Vec::<String>::new(),
                "frame {}",
                frame(peer)
            );
            take_confirmed(peer, told);
        }
        let [ours, theirs] = &mut told;
        while let (Some(a), Some(b)) = (ours.first_entry(), theirs.first_entry()) {
            assert_eq!(a.key(), b.key());
            let (frame, a) = a.remove_entry();
            let b = b.remove();
            assert!(a == b, "{}", difference(frame, &a, &b));
            compared += 1;
        }
        updates += 1;
        assert!(
            updates < 20 * FRAMES as u64,
            "the peers come on: {compared} frames"
        );
        // Until they know each other they wait for real time, by which packets are sent again.
        if peers.iter().any(|peer| frame(peer) == 0) {
            thread::sleep(Duration::from_millis(2));
        }
    }
    for peer in &peers {
        let stories = peer.world().resource::<Stories>();
        // Of these, some had been foreseen wrongly.
        println!(
            "{} frames, {} of them again, {} otherwise than before; {:?}",
            frame(peer),
            stories.told - frame(peer) as u64,
            stories.differences,
            network.counts(),
        );
        assert!(stories.differences > FRAMES as u64 / 20);
    }
}
