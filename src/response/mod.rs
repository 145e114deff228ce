//! What contacts do to velocities.

mod answering;
mod bounce;
mod course;
mod discrete;
mod impacts;
mod outcomes;

use bevy::prelude::*;

use crate::{
    contacts::Verdicts,
    disabled::see_disabled,
    schedule::{CollisionSystems, ImpactSystems, add_to_tick},
    swept::{AtSolid, Swept},
};

use answering::Answering;
pub use bounce::Bounce;
use discrete::{reflect, reverse};
use impacts::resolve_impacts;
use outcomes::{Outcomes, apply_outcomes, clear_outcomes};

/// The plugin for the response: from contacts to velocities.
#[derive(Clone, Copy, Debug, Default)]
pub struct BouncePlugin;

/// Has something met another that is to stop there?
fn something_stops(
    verdicts: Res<Verdicts>,
    (swept, answering): (Query<&Swept>, Answering),
) -> bool {
    let stops = |entity| {
        swept
            .get(answering.who(entity))
            .is_ok_and(|swept| swept.at_solid == AtSolid::Stop)
    };
    let impacts = verdicts.impacts().iter();
    impacts
        .flat_map(|impact| [impact.key.a, impact.key.b])
        .any(stops)
}

impl Plugin for BouncePlugin {
    fn build(&self, app: &mut App) {
        outcomes::register(app);
        add_to_tick(app, |app, schedule| {
            // Where nothing bounces, contacts are not looked at.
            let something_bounces = any_with_component::<Bounce>;
            let some_impacts = |verdicts: Res<Verdicts>| !verdicts.impacts().is_empty();
            let some_outcomes = |outcomes: Res<Outcomes>| !outcomes.is_empty();
            // What was not applied in its tick comes too late.
            let clear = clear_outcomes
                .after(CollisionSystems::BroadPhase)
                .before(CollisionSystems::NarrowPhase);
            let resolve = resolve_impacts
                .in_set(ImpactSystems)
                .run_if(some_impacts)
                .run_if(something_bounces.or_else(something_stops));
            let reflect = see_disabled(app.world_mut(), reflect);
            let at_rest = (reverse, reflect).chain().run_if(something_bounces);
            let answer = (
                apply_outcomes.run_if(some_outcomes),
                at_rest,
                clear_outcomes.run_if(some_outcomes),
            );
            let answer = answer.chain().in_set(CollisionSystems::Response);
            app.add_systems(schedule, (clear.run_if(some_outcomes), resolve, answer));
        });
    }
}

pub(crate) fn register(app: &mut App) {
    bounce::register(app);
}
