//! Which entities a query is to see.

use std::fmt;

use bevy::{ecs::entity::EntityHashSet, prelude::*};

use crate::{broad_phase::PairFilter, filters::LayerMask, worlds};

/// Says which entities a query sees: all of the default world, unless told otherwise. Borrows what
/// it is told, so that it costs nothing to make and to copy.
///
/// "All" includes [sensors](crate::filters::Sensor), such as triggers and pickups: a bullet or a line
/// of sight ends at them, unless the filter is [without](Self::without_sensors) them.
///
/// Begin with [`DEFAULT`](Self::DEFAULT), or `default()`, and refine it:
///
/// | by | what is seen |
/// |---|---|
/// | [`in_world`](Self::in_world), [`in_any_world`](Self::in_any_world) | another world, or all of them |
/// | [`on`](Self::on) | only what is on one of some layers |
/// | [`except`](Self::except), [`excluding`](Self::excluding) | all but one entity, all but some |
/// | [`without_body`](Self::without_body) | all but the parts of one [body](crate::parts) |
/// | [`without_sensors`](Self::without_sensors) | all but what is a [`Sensor`](crate::filters::Sensor), which is seen like all others by default |
/// | [`only`](Self::only) | what a function of yours says |
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
#[doc(alias("query filter", "layer mask"))]
#[derive(Clone, Copy)]
pub struct SpatialQueryFilter<'a> {
    /// All worlds, if none is given.
    world: Option<u32>,
    layers: Option<LayerMask>,
    except: Option<Entity>,
    excluded: Option<&'a EntityHashSet>,
    skips_sensors: bool,
    excluded_body: Option<Entity>,
    /// Whoever asks, as the broad phase knows it.
    asker: Option<PairFilter>,
    predicate: Option<Predicate<'a>>,
}

impl Default for SpatialQueryFilter<'_> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

type Predicate<'a> = &'a (dyn Fn(Entity) -> bool + Sync);

impl<'a> SpatialQueryFilter<'a> {
    /// The filter that lets all entities pass that are in no
    /// [`CollisionWorld`](crate::worlds::CollisionWorld), and so in the default world.
    pub const DEFAULT: Self = Self {
        world: Some(PairFilter::DEFAULT_WORLD),
        layers: None,
        except: None,
        excluded: None,
        skips_sensors: false,
        excluded_body: None,
        asker: None,
        predicate: None,
    };

    /// Lets those pass that are [in this world](crate::worlds::InCollisionWorld), instead of the
    /// default one.
    #[must_use]
    pub const fn in_world(self, world: Entity) -> Self {
        Self {
            world: Some(worlds::number(world)),
            ..self
        }
    }

    /// Lets those of all worlds pass, the default one included.
    #[must_use]
    pub const fn in_any_world(self) -> Self {
        Self {
            world: None,
            ..self
        }
    }

    /// Lets only those pass that are on one of these layers: by default, an entity is on the first.
    /// Replaces earlier layers.
    ///
    /// ```
    /// # use bevy_octree::prelude::*;
    /// # collision_layers! { enum Layer { Ground, Friend, Foe } }
    /// let foes = SpatialQueryFilter::DEFAULT.on(Layer::Foe);
    /// let anyone = SpatialQueryFilter::DEFAULT.on(Layer::Friend | Layer::Foe);
    /// ```
    #[must_use]
    #[doc(alias("layer mask", "from_mask"))]
    pub fn on(self, layers: impl Into<LayerMask>) -> Self {
        Self {
            layers: Some(layers.into()),
            ..self
        }
    }

    /// Leaves out one entity: the one that asks, most of the time. Replaces an earlier one; for
    /// several, see [`excluding`](Self::excluding).
    #[must_use]
    #[doc(alias("exclude", "ignore"))]
    pub const fn except(self, entity: Entity) -> Self {
        Self {
            except: Some(entity),
            ..self
        }
    }

    /// Leaves out the entities of a set. Replaces an earlier set.
    #[must_use]
    pub const fn excluding(self, entities: &'a EntityHashSet) -> Self {
        Self {
            excluded: Some(entities),
            ..self
        }
    }

    /// Leaves out entities that are a [`Sensor`](crate::filters::Sensor) at the moment of the query:
    /// for what is solid.
    #[must_use]
    #[doc(alias("trigger", "solid"))]
    pub const fn without_sensors(self) -> Self {
        Self {
            skips_sensors: true,
            ..self
        }
    }

    /// Leaves out all parts of one [body](crate::parts): that which an entity is, or is a part of at
    /// the moment of the query. Of an entity that is part of none, that one alone. Replaces an earlier
    /// one; [`except`](Self::except) may leave out another.
    #[must_use]
    #[doc(alias("exclude rigid body", "self", "ship"))]
    pub const fn without_body(self, entity: Entity) -> Self {
        Self {
            excluded_body: Some(entity),
            ..self
        }
    }

    /// Lets only those pass for which `predicate` holds. Replaces an earlier predicate.
    ///
    /// It is asked before the exact tests, about no more entities than these would look at.
    #[must_use]
    pub const fn only(self, predicate: &'a (dyn Fn(Entity) -> bool + Sync)) -> Self {
        Self {
            predicate: Some(predicate),
            ..self
        }
    }

    /// Lets only those pass that an object and they may meet, both ways: by world, layers and bodies.
    pub(super) const fn met_by(self, asker: PairFilter) -> Self {
        Self {
            world: Some(asker.world),
            asker: Some(PairFilter {
                is_detector: false,
                ..asker
            }),
            ..self
        }
    }

    /// Are sensors left out?
    pub(super) const fn skips_sensors(&self) -> bool {
        self.skips_sensors
    }

    /// Of which body are the parts left out?
    pub(super) const fn excluded_body(&self) -> Option<Entity> {
        self.excluded_body
    }

    /// Returns `true` if an entity passes that the broad phase knows as `object`, as long as it is
    /// not about [sensors](Self::without_sensors) or [bodies](Self::without_body), which the entity
    /// alone can tell. The cheapest questions come first.
    #[must_use]
    pub fn accepts(&self, entity: Entity, object: &PairFilter) -> bool {
        self.world.is_none_or(|world| world == object.world)
            && self
                .layers
                .is_none_or(|layers| layers.0 & object.memberships != 0)
            && self.asker.is_none_or(|asker| {
                asker.admits(&PairFilter {
                    is_detector: false,
                    ..*object
                })
            })
            && self.except != Some(entity)
            && self
                .excluded
                .is_none_or(|excluded| !excluded.contains(&entity))
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
            .field("skips_sensors", &self.skips_sensors)
            .field("excluded_body", &self.excluded_body)
            .field("asker", &self.asker)
            .field("has_predicate", &self.predicate.is_some())
            .finish()
    }
}
