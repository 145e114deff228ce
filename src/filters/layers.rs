//! The layers that an entity is on, and those that it may meet.

use bevy::{
    ecs::{lifecycle::HookContext, system::RegisteredSystemError, world::DeferredWorld},
    prelude::*,
};
use serde::{Deserialize, Serialize};

use super::mask::LayerMask;
use crate::{
    broad_phase::PairFilter,
    collision_index::CollisionIndex,
    components::{BroadPhaseProxy, change_filter},
    schedule::{CollisionSystems, add_to_tick},
};

/// The layers that an entity is on, and those that it may meet. Two entities meet if each is on a
/// layer that the other may meet; to have one of them hear of the other, and not the other way
/// round, see [`Detector`](super::Detector). Without this component, an entity is on the first
/// layer and may meet all.
#[doc(alias(
    "collision groups",
    "layer mask",
    "collision filter",
    "collision mask",
    "collision matrix",
    "physics layers"
))]
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect, Serialize, Deserialize)]
#[reflect(Component, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[component(on_remove = has_no_layers)]
pub struct CollisionLayers {
    /// The layers that the entity is on.
    pub memberships: LayerMask,
    /// The layers that it may meet.
    pub filters: LayerMask,
}

impl Default for CollisionLayers {
    fn default() -> Self {
        PairFilter::default().into()
    }
}

impl From<PairFilter> for CollisionLayers {
    fn from(
        PairFilter {
            memberships,
            filters,
            ..
        }: PairFilter,
    ) -> Self {
        Self::from_bits(memberships, filters)
    }
}

impl CollisionLayers {
    /// The layers of an entity that is on none, and meets nothing.
    pub const NONE: Self = Self {
        memberships: LayerMask::NONE,
        filters: LayerMask::NONE,
    };
    /// The layers of an entity that is on all, and may meet all.
    pub const ALL: Self = Self {
        memberships: LayerMask::ALL,
        filters: LayerMask::ALL,
    };

    /// Returns the layers of an entity that is on the first, and may meet the second.
    ///
    /// ```
    /// # use bevy_octree::prelude::*;
    /// # collision_layers! { enum Layer { Ground, Ship, Bullet } }
    /// let ship = CollisionLayers::new(Layer::Ship, [Layer::Ground, Layer::Bullet]);
    /// assert_eq!(ship, CollisionLayers::from_bits(0b010, 0b101));
    /// let ghost = CollisionLayers::new(Layer::Ship, []);
    /// assert_eq!(ghost, CollisionLayers::new([Layer::Ship], LayerMask::NONE));
    /// ```
    ///
    /// For constants, see [`from_masks`](Self::from_masks).
    #[must_use]
    pub fn new(memberships: impl Into<LayerMask>, filters: impl Into<LayerMask>) -> Self {
        Self::from_masks(memberships.into(), filters.into())
    }

    /// Returns the layers of an entity that is on the first, and may meet the second, as
    /// [`new`](Self::new) does: for constants.
    ///
    /// ```
    /// # use bevy_octree::prelude::*;
    /// collision_layers! {
    ///     enum Layer { Ground, Ship, Bullet }
    /// }
    ///
    /// const SOLID: LayerMask = Layer::Ground.mask().union(Layer::Ship.mask());
    /// const BULLET: CollisionLayers = CollisionLayers::from_masks(Layer::Bullet.mask(), SOLID);
    /// assert_eq!(BULLET, CollisionLayers::new(Layer::Bullet, [Layer::Ground, Layer::Ship]));
    /// ```
    #[must_use]
    pub const fn from_masks(memberships: LayerMask, filters: LayerMask) -> Self {
        Self {
            memberships,
            filters,
        }
    }

    /// Returns layers by their bits, the lowest for the first layer: for constants.
    #[must_use]
    pub const fn from_bits(memberships: u32, filters: u32) -> Self {
        Self::from_masks(LayerMask(memberships), LayerMask(filters))
    }

    /// May an entity on these layers meet one on others?
    const fn hears(self, other: Self) -> bool {
        self.filters.0 & other.memberships.0 != 0
    }

    pub(super) const fn put_into(self, filter: &mut PairFilter) {
        filter.memberships = self.memberships.0;
        filter.filters = self.filters.0;
    }
}

/// Which of two in contact hear of it, by their layers: one of them, if that is a detector which the
/// other may not meet. Both, where neither would: somebody else made that pair.
pub(crate) fn hear([a, b]: [CollisionLayers; 2]) -> [bool; 2] {
    let hears = [a.hears(b), b.hears(a)];
    if hears == [false; 2] {
        [true; 2]
    } else {
        hears
    }
}

// What hooks say is taken up at once, whenever the next tick may be. Before its first tick, an
// entity is not in the index, which then looks at its components.
fn has_no_layers(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| {
        CollisionLayers::default().put_into(filter);
    });
}

pub(super) fn register(app: &mut App) {
    app.register_type::<CollisionLayers>();
    add_to_tick(app, |app, schedule| {
        let follow = follow_layers
            .after(CollisionSystems::Bounds)
            .before(CollisionSystems::Maintenance);
        app.add_systems(schedule, follow);
    });
}

/// Takes up the layers of all entities whose layers changed, at any moment.
pub(crate) fn refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    world.run_system_cached(follow_layers)
}

/// Takes up layers that changed of entities that are in the index already.
fn follow_layers(
    mut index: ResMut<CollisionIndex>,
    changed: Query<(Entity, &BroadPhaseProxy, &CollisionLayers), Changed<CollisionLayers>>,
) {
    for (entity, proxy, layers) in &changed {
        if let Some(id) = proxy.id().filter(|id| index.is_entry_of(*id, entity)) {
            index.change_filter(id, |filter| layers.put_into(filter));
        }
    }
}
