//! How long the stages of a tick take.

use std::time::{Duration, Instant};

use bevy::{ecs::schedule::ScheduleLabel, prelude::*};
use bevy_octree::CollisionSystems;

/// The stages that are timed, in the order in which they run.
pub const STAGES: [(CollisionSystems, &str); 7] = [
    (CollisionSystems::Motion, "motion"),
    (CollisionSystems::Bounds, "bounds"),
    (CollisionSystems::Maintenance, "maintenance"),
    (CollisionSystems::BroadPhase, "broad_phase"),
    (CollisionSystems::NarrowPhase, "narrow_phase"),
    (CollisionSystems::Response, "response"),
    (CollisionSystems::Report, "report"),
];

/// The time that each of the [`STAGES`] took, over all ticks since the last [`reset`](Self::reset).
#[derive(Resource)]
pub struct StageTimes {
    pub sums: [Duration; STAGES.len()],
    /// The end of the stage before.
    last: Instant,
}

impl StageTimes {
    /// Has the stages of a schedule timed, by systems between them.
    pub fn install(app: &mut App, schedule: impl ScheduleLabel + Clone) {
        app.insert_resource(Self {
            sums: Default::default(),
            last: Instant::now(),
        });
        app.add_systems(schedule.clone(), begin.in_set(CollisionSystems::First));
        let ends = STAGES
            .iter()
            .skip(1)
            .map(|(set, _)| *set)
            .chain([CollisionSystems::Last]);
        for (stage, ((set, _), next)) in STAGES.into_iter().zip(ends).enumerate() {
            let end = move |mut times: ResMut<Self>| times.end(stage);
            app.add_systems(schedule.clone(), end.after(set).before(next));
        }
    }

    /// Forgets the times so far.
    pub fn reset(&mut self) {
        self.sums = Default::default();
    }

    fn end(&mut self, stage: usize) {
        let now = Instant::now();
        self.sums[stage] += now - self.last;
        self.last = now;
    }
}

fn begin(mut times: ResMut<StageTimes>) {
    times.last = Instant::now();
}
