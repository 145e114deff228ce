//! Which entities may meet: layers, static entities, lists of entities to ignore, sensors, and a hook of one's own.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! #[derive(Clone, Copy)]
//! enum Team {
//!     Red,
//!     Blue,
//! }
//!
//! impl CollisionLayer for Team {
//!     fn index(self) -> u32 {
//!         self as u32
//!     }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::default()));
//! for team in [Team::Red, Team::Red, Team::Blue] {
//!     let other = if let Team::Red = team { Team::Blue } else { Team::Red };
//!     app.world_mut().spawn((CollisionShape::default(), CollisionLayers::new([team], [other])));
//! }
//! app.update();
//! app.world_mut().run_schedule(FixedPostUpdate);
//! assert_eq!(app.world().resource::<Contacts>().len(), 2); // each red one with the blue one
//! ```
//!
//! Layers, static entities and [worlds] are looked at in the broad phase, as are the kinds of pairs in its
//! [settings](crate::settings::BroadPhaseSettings::pair_kinds): a pair that they rule out is gone before anything
//! else sees it. Lists and hooks are asked about candidate pairs, before the exact tests.

use bevy::{
    ecs::{
        entity::EntityHashSet,
        lifecycle::HookContext,
        system::{ReadOnlySystemParam, RegisteredSystemError, StaticSystemParam, SystemId, SystemParamItem},
        world::DeferredWorld,
    },
    prelude::*,
};

use crate::{
    broad_phase::{Pair, PairFilter},
    collision_index::{CandidatePairs, CollisionIndex, in_index},
    components::BroadPhaseProxy,
    schedule::{CollisionSystems, PairFilterSystems, add_to_tick, expect_ticks},
    worlds::{self, CollisionWorld, InCollisionWorld},
};

/// One of 32 layers by name: for an enum of one's own.
pub trait CollisionLayer {
    /// The layer's number, 0 to 31. Larger ones are no layer at all.
    fn index(self) -> u32;
}

/// The bits of some layers.
pub(crate) fn mask(layers: impl IntoIterator<Item = impl CollisionLayer>) -> u32 {
    layers.into_iter().fold(0, |mask, layer| mask | 1_u32.checked_shl(layer.index()).unwrap_or(0))
}

/// The layers that an entity is on, and those that it may meet. Two entities meet if each is on a layer that the other
/// may meet. Without this component, an entity is on the first layer and may meet all.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
#[component(on_remove = has_no_layers)]
pub struct CollisionLayers {
    /// The layers that the entity is on: a bit for each.
    pub memberships: u32,
    /// The layers that it may meet.
    pub filters: u32,
}

impl Default for CollisionLayers {
    fn default() -> Self {
        PairFilter::default().into()
    }
}

impl From<PairFilter> for CollisionLayers {
    fn from(PairFilter { memberships, filters, .. }: PairFilter) -> Self {
        Self { memberships, filters }
    }
}

impl CollisionLayers {
    /// On no layer: meets nothing.
    pub const NONE: Self = Self { memberships: 0, filters: 0 };
    /// On all layers, and may meet all.
    pub const ALL: Self = Self { memberships: u32::MAX, filters: u32::MAX };

    /// On these layers, and may meet those.
    #[must_use]
    pub fn new(
        memberships: impl IntoIterator<Item = impl CollisionLayer>,
        filters: impl IntoIterator<Item = impl CollisionLayer>,
    ) -> Self {
        Self { memberships: mask(memberships), filters: mask(filters) }
    }
}

/// An entity that does not meet others of its kind: walls, floors, scenery. Two static entities make no pair, however
/// they overlap, and however they are moved; unless the
/// [`PairKinds`](crate::settings::BroadPhaseSettings::pair_kinds) say otherwise.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
#[component(on_insert = is_static, on_remove = is_not_static)]
pub struct StaticCollider;

/// An entity whose contacts are reported, and that nothing bounces off.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct Sensor;

/// Entities that this one does not meet: its owner, its parts. Entities in the list that are gone, or have no shape, do
/// no harm. It is immutable: insert a new list to change it.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Deref, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
#[component(immutable, on_insert = look_again, on_discard = look_again)]
pub struct IgnoreCollisions(#[entities] pub EntityHashSet);

impl<const N: usize> From<[Entity; N]> for IgnoreCollisions {
    fn from(entities: [Entity; N]) -> Self {
        Self(entities.into_iter().collect())
    }
}

/// Has the pairs of an entity sought anew, those in which nothing moved too.
fn look_again(mut world: DeferredWorld, context: HookContext) {
    in_index(&mut world, context.entity, CollisionIndex::look_again);
}

// What hooks say is taken up at once, whenever the next tick may be. Before its first tick, an entity is not in the index,
// which then looks at its components.

fn has_no_layers(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| set_layers(filter, CollisionLayers::default()));
}

fn is_static(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_static = true);
}

fn is_not_static(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_static = false);
}

pub(crate) fn change_filter(mut world: DeferredWorld, context: HookContext, change: impl FnOnce(&mut PairFilter)) {
    in_index(&mut world, context.entity, |index, id| index.change_filter(id, change));
}

fn set_layers(filter: &mut PairFilter, layers: CollisionLayers) {
    let CollisionLayers { memberships, filters } = layers;
    *filter = PairFilter { memberships, filters, ..*filter };
}

/// A veto of one's own on pairs, with access to the world: see [`PairHookPlugin`].
pub trait PairHook: ReadOnlySystemParam + 'static {
    /// May these two meet? Asked about each pair of overlapping boxes of which one moved, in a fixed order; the verdict
    /// on a pair in which nothing moved stays as it was.
    fn admits(hook: &SystemParamItem<'_, '_, Self>, a: Entity, b: Entity) -> bool;
}

/// Asks a [`PairHook`] about every candidate pair. Add it beside [`OctreePlugins`](crate::OctreePlugins), in any order.
///
/// ```
/// use bevy::{ecs::system::SystemParam, prelude::*};
/// use bevy_octree::prelude::*;
///
/// #[derive(Component)]
/// struct Ghost;
///
/// #[derive(SystemParam)]
/// struct NoGhosts<'w, 's>(Query<'w, 's, (), With<Ghost>>);
///
/// impl PairHook for NoGhosts<'static, 'static> {
///     fn admits(hook: &NoGhosts, a: Entity, b: Entity) -> bool {
///         !hook.0.contains(a) && !hook.0.contains(b)
///     }
/// }
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::default(), PairHookPlugin::<NoGhosts>::default()));
/// app.world_mut().spawn((CollisionShape::default(), Ghost));
/// app.world_mut().spawn(CollisionShape::default());
/// app.world_mut().run_schedule(FixedPostUpdate);
/// assert!(app.world().resource::<Contacts>().is_empty());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PairHookPlugin<H>(std::marker::PhantomData<fn() -> H>);

impl<H> Default for PairHookPlugin<H> {
    fn default() -> Self {
        Self(std::marker::PhantomData)
    }
}

impl<H: PairHook> Plugin for PairHookPlugin<H> {
    fn build(&self, app: &mut App) {
        let hook = app.register_system(ask_about::<H>);
        app.world_mut().get_resource_or_init::<PairHooks>().0.push(hook);
        add_to_tick(app, |app, schedule| {
            // Filters take pairs out, and none looks at what others took: in any order, the same are left.
            app.add_systems(schedule, ask::<H>.in_set(PairFilterSystems).ambiguous_with(PairFilterSystems));
        });
    }

    fn finish(&self, app: &mut App) {
        expect_ticks(app, "PairHookPlugin");
    }
}

fn ask<H: PairHook>(hook: StaticSystemParam<H>, index: Res<CollisionIndex>, mut candidates: ResMut<CandidatePairs>) {
    candidates.retain(|pair| {
        let [a, b] = index.entities(*pair);
        H::admits(&hook, a, b)
    });
}

/// The hooks, to be asked about one pair.
#[derive(Resource, Debug, Default)]
struct PairHooks(Vec<SystemId<In<[Entity; 2]>, bool>>);

fn ask_about<H: PairHook>(In([a, b]): In<[Entity; 2]>, hook: StaticSystemParam<H>) -> bool {
    H::admits(&hook, a, b)
}

/// May these two meet, by lists and hooks? For pairs that come up after the broad phase.
pub(crate) fn may_meet(world: &mut World, pair: Pair) -> bool {
    let [a, b] = world.resource::<CollisionIndex>().entities(pair);
    let ignores = |one, other| world.get::<IgnoreCollisions>(one).is_some_and(|list| list.contains(&other));
    if ignores(a, b) || ignores(b, a) {
        return false;
    }
    for place in 0.. {
        let hook = world.get_resource::<PairHooks>().and_then(|hooks| hooks.0.get(place).copied());
        let Some(hook) = hook else { break };
        match world.run_system_with(hook, [a, b]) {
            Ok(true) => {}
            Ok(false) => return false,
            Err(error) => tracing::warn!("a hook could not be asked about {a} and {b}: {error}"),
        }
    }
    true
}

/// Layers, static entities, lists of entities to ignore, and worlds.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilterPlugin;

impl Plugin for FilterPlugin {
    fn build(&self, app: &mut App) {
        let some_ignore = |lists: Query<(), With<IgnoreCollisions>>| !lists.is_empty();
        app.register_type::<CollisionLayers>()
            .register_type::<StaticCollider>()
            .register_type::<Sensor>()
            .register_type::<IgnoreCollisions>()
            .register_type::<InCollisionWorld>()
            .register_type::<CollisionWorld>();
        add_to_tick(app, move |app, schedule| {
            app.add_systems(
                schedule,
                (
                    follow_layers.after(CollisionSystems::Bounds).before(CollisionSystems::Maintenance),
                    ignore.in_set(PairFilterSystems).run_if(some_ignore),
                ),
            );
        });
    }
}

/// What an entity's components say about the pairs that it makes.
pub(crate) type FilterParts<'a> = (Option<&'a CollisionLayers>, Has<StaticCollider>, Option<&'a InCollisionWorld>);

pub(crate) fn filter(
    (layers, is_static, world): (Option<&CollisionLayers>, bool, Option<&InCollisionWorld>),
) -> PairFilter {
    let CollisionLayers { memberships, filters } = layers.copied().unwrap_or_default();
    let world = world.map_or(PairFilter::DEFAULT_WORLD, |world| worlds::number(world.0));
    PairFilter { memberships, filters, is_static, world }
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
            index.change_filter(id, |filter| set_layers(filter, *layers));
        }
    }
}

/// Takes out pairs of which one entity ignores the other.
fn ignore(lists: Query<&IgnoreCollisions>, index: Res<CollisionIndex>, mut candidates: ResMut<CandidatePairs>) {
    candidates.retain(|pair| {
        let [a, b] = index.entities(*pair);
        let ignores = |one, other| lists.get(one).is_ok_and(|list| list.contains(&other));
        !ignores(a, b) && !ignores(b, a)
    });
}
