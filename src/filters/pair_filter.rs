//! What filters say of a pair, before the broad phase and after it.

use bevy::prelude::*;

use super::{
    hooks,
    ignore::{self, IgnoreCollisions},
    layers::CollisionLayers,
    markers::{Detector, StaticShape},
};
use crate::{
    broad_phase::{Pair, PairFilter},
    collision_index::CollisionIndex,
    parts::PartOf,
    worlds::{self, InCollisionWorld},
};

/// What an entity's components say about the pairs that it makes.
pub(crate) type FilterParts<'a> = (
    Option<&'a CollisionLayers>,
    Has<StaticShape>,
    Has<Detector>,
    Option<&'a InCollisionWorld>,
    Option<&'a PartOf>,
);

/// The same, for the broad phase.
pub(crate) fn filter(
    (layers, is_static, is_detector, world, part): (
        Option<&CollisionLayers>,
        bool,
        bool,
        Option<&InCollisionWorld>,
        Option<&PartOf>,
    ),
) -> PairFilter {
    let world = world.map_or(PairFilter::DEFAULT_WORLD, |world| worlds::number(world.0));
    let mut filter = PairFilter {
        is_static,
        is_detector,
        world,
        body: part.map_or(PairFilter::NO_BODY, PartOf::number),
        ..PairFilter::default()
    };
    layers.copied().unwrap_or_default().put_into(&mut filter);
    filter
}

/// May these two meet, by lists and hooks? For pairs that come up after the broad phase.
pub(crate) fn may_meet(world: &mut World, pair: Pair) -> bool {
    let entities = world.resource::<CollisionIndex>().entities(pair);
    !ignore::ignore_each_other(entities, |entity| world.get::<IgnoreCollisions>(entity))
        && hooks::admit(world, entities)
}
