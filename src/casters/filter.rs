//! Which entities a caster sees, as data.

use bevy::{
    ecs::entity::{EntityHashSet, MapEntities},
    prelude::*,
};

use crate::{
    ancestors, filters::LayerMask, spatial_query::SpatialQueryFilter, worlds::InCollisionWorld,
};

/// Says which entities a [`RayCaster`](super::RayCaster) or
/// [`ShapeCaster`](super::ShapeCaster) sees: by default all but the thing that it is part of.
///
/// Those in the world of the caster, always: the default one, or that of the caster's
/// [`InCollisionWorld`].
///
/// What is not to be said by data is said to a [`SpatialQueryFilter`], in a system of your own.
#[derive(Clone, Debug, PartialEq, MapEntities, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CasterFilter {
    /// Only what is on one of these layers; with [`LayerMask::ALL`], which is the default, what is
    /// on no layer at all, too.
    pub layers: LayerMask,
    /// Whether [`Sensor`](crate::filters::Sensor)s are seen: as of all queries, by default they are.
    pub sensors: bool,
    /// Which of its own kin the caster does not see.
    pub ignores: CasterIgnores,
    /// Further entities that it does not see.
    #[entities]
    pub excluded: EntityHashSet,
}

/// Which of its own kin a caster does not see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq, Hash)]
#[type_path = "bevy_octree"]
#[doc(alias("ignore_self", "ignore self"))]
pub enum CasterIgnores {
    /// None of it: a caster in the middle of its own shape meets that.
    Nothing,
    /// The entity that the caster is on.
    Itself,
    /// That entity, and all parts of the nearest [body](crate::parts) that it is or hangs on: a ship
    /// does not see its wings, wherever on it the caster is. Of what is on no body, the entity alone.
    #[default]
    Body,
    /// All that hangs on the same topmost ancestor, that one and the entity itself included: for
    /// what is a hierarchy of its own, such as a tank with its turret. Not for what hangs on a level
    /// that is all one hierarchy.
    Family,
}

impl Default for CasterFilter {
    fn default() -> Self {
        Self {
            layers: LayerMask::ALL,
            sensors: true,
            ignores: CasterIgnores::default(),
            excluded: EntityHashSet::default(),
        }
    }
}

impl CasterFilter {
    /// Lets only those pass that are on one of these layers. Replaces earlier layers.
    #[must_use]
    #[doc(alias("layer mask", "from_mask"))]
    pub fn on(self, layers: impl Into<LayerMask>) -> Self {
        Self {
            layers: layers.into(),
            ..self
        }
    }

    /// Leaves out [`Sensor`](crate::filters::Sensor)s: for what is solid.
    #[must_use]
    pub fn without_sensors(self) -> Self {
        Self {
            sensors: false,
            ..self
        }
    }

    /// Leaves out this much of the caster's own kin.
    #[must_use]
    pub fn ignoring(self, ignores: CasterIgnores) -> Self {
        Self { ignores, ..self }
    }

    /// Leaves out further entities, beside those that were left out before.
    #[must_use]
    pub fn excluding(mut self, entities: impl IntoIterator<Item = Entity>) -> Self {
        self.excluded.extend(entities);
        self
    }

    /// Hands the filter on, as that of a query of this entity.
    pub(super) fn apply(
        &self,
        entity: Entity,
        world: Option<&InCollisionWorld>,
        parent: impl Fn(Entity) -> Option<Entity> + Sync,
        body: impl FnOnce(Entity) -> Option<Entity>,
        ask: impl FnOnce(&SpatialQueryFilter),
    ) {
        let all = SpatialQueryFilter::DEFAULT;
        let mut filter = world.map_or(all, |world| all.in_world(world.0));
        if self.layers != LayerMask::ALL {
            filter = filter.on(self.layers);
        }
        if !self.sensors {
            filter = filter.without_sensors();
        }
        if !self.excluded.is_empty() {
            filter = filter.excluding(&self.excluded);
        }
        match self.ignores {
            CasterIgnores::Nothing => ask(&filter),
            CasterIgnores::Itself => ask(&filter.except(entity)),
            CasterIgnores::Body => {
                let filter = filter.except(entity);
                match body(entity) {
                    Some(body) => ask(&filter.without_body(body)),
                    None => ask(&filter),
                }
            }
            CasterIgnores::Family => {
                let own = topmost(entity, &parent);
                ask(&filter.only(&|other| topmost(other, &parent) != own));
            }
        }
    }
}

/// The last on the way up; in a circle, one of it.
fn topmost(entity: Entity, parent: impl Fn(Entity) -> Option<Entity>) -> Option<Entity> {
    ancestors::up(entity, |entity| Some((entity, parent(entity))))
        .map_while(Result::ok)
        .last()
}

pub(super) fn register(app: &mut App) {
    app.register_type::<CasterFilter>()
        .register_type::<CasterIgnores>();
}
