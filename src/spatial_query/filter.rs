//! Which entities a query is to see.

use std::fmt;

use bevy::{ecs::entity::EntityHashSet, prelude::*};

use crate::{
    broad_phase::PairFilter,
    filters::{self, CollisionLayer},
    worlds,
};

/// Which entities a query is to see: all of the default world, unless told otherwise. Borrows what it is told, so that it costs nothing to make
/// and to copy.
///
/// ```
/// use bevy::{ecs::entity::EntityHashSet, prelude::*};
/// use bevy_octree::prelude::*;
///
/// fn sees_a_foe(origin: Vec3, party: &EntityHashSet, foes: Query<(), With<Velocity>>, spatial: SpatialQuery) -> bool {
///     let is_foe = |entity| foes.contains(entity);
///     let filter = SpatialQueryFilter::default().excluding(party).only(&is_foe);
///     spatial.cast_ray(Ray3d::new(origin, Dir3::X), 100.0, &filter).is_some()
/// }
/// ```
#[derive(Clone, Copy)]
pub struct SpatialQueryFilter<'a> {
    /// All worlds, if none is given.
    world: Option<u32>,
    layers: Option<u32>,
    except: Option<Entity>,
    excluded: Option<&'a EntityHashSet>,
    predicate: Option<Predicate<'a>>,
}

impl Default for SpatialQueryFilter<'_> {
    fn default() -> Self {
        Self::ALL
    }
}

type Predicate<'a> = &'a (dyn Fn(Entity) -> bool + Sync);

impl<'a> SpatialQueryFilter<'a> {
    /// All entities that are in no [`CollisionWorld`](crate::worlds::CollisionWorld), and so in the default world.
    pub const ALL: Self =
        Self { world: Some(PairFilter::DEFAULT_WORLD), layers: None, except: None, excluded: None, predicate: None };

    /// Those that are [in this world](crate::worlds::InCollisionWorld), instead of the default one.
    #[must_use]
    pub const fn in_world(self, world: Entity) -> Self {
        Self { world: Some(worlds::number(world)), ..self }
    }

    /// Those of all worlds, the default one included.
    #[must_use]
    pub const fn in_any_world(self) -> Self {
        Self { world: None, ..self }
    }

    /// All entities but one: the one that asks, most of the time.
    #[must_use]
    pub const fn except(entity: Entity) -> Self {
        Self { except: Some(entity), ..Self::ALL }
    }

    /// Only those that are on one of these layers: by default, an entity is on the first. Replaces earlier layers.
    #[must_use]
    pub fn on(self, layers: impl IntoIterator<Item = impl CollisionLayer>) -> Self {
        self.on_mask(filters::mask(layers))
    }

    /// As [`on`](Self::on), with a bit for each layer.
    #[must_use]
    pub const fn on_mask(self, layers: u32) -> Self {
        Self { layers: Some(layers), ..self }
    }

    /// None of these either. Replaces an earlier set.
    #[must_use]
    pub const fn excluding(self, entities: &'a EntityHashSet) -> Self {
        Self { excluded: Some(entities), ..self }
    }

    /// Only those for which `predicate` holds. Replaces an earlier predicate.
    ///
    /// It is asked before the exact tests, about no more entities than these would look at.
    #[must_use]
    pub const fn only(self, predicate: &'a (dyn Fn(Entity) -> bool + Sync)) -> Self {
        Self { predicate: Some(predicate), ..self }
    }

    /// Does an entity pass that the broad phase knows as `object`? The cheapest questions come first.
    #[must_use]
    pub fn accepts(&self, entity: Entity, object: &PairFilter) -> bool {
        self.world.is_none_or(|world| world == object.world)
            && self.layers.is_none_or(|layers| layers & object.memberships != 0)
            && self.except != Some(entity)
            && self.excluded.is_none_or(|excluded| !excluded.contains(&entity))
            && self.predicate.is_none_or(|predicate| predicate(entity))
    }
}

impl fmt::Debug for SpatialQueryFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SpatialQueryFilter")
            .field("world", &self.world)
            .field("layers", &self.layers)
            .field("except", &self.except)
            .field("excluded", &self.excluded)
            .field("has_predicate", &self.predicate.is_some())
            .finish()
    }
}
