//! Vetoes of one's own.

use std::marker::PhantomData;

use bevy::{
    ecs::system::{ReadOnlySystemParam, StaticSystemParam, SystemId, SystemParamItem},
    prelude::*,
};

use super::ignore::ignore;
use crate::{
    collision_index::{CandidatePairs, CollisionIndex},
    schedule::{PairFilterSystems, add_to_tick, expect_ticks},
};

/// A veto of one's own on pairs, with access to the world: see [`PairHookPlugin`].
#[doc(alias(
    "collision hook",
    "contact filter",
    "physics hook",
    "one-way platform",
    "one-way",
    "modify contacts"
))]
pub trait PairHook: ReadOnlySystemParam + 'static {
    /// Returns `true` if these two may meet. Asked about each pair of overlapping boxes of which
    /// one moved, in a fixed order; the verdict on a pair in which nothing moved stays as it was.
    fn admits(hook: &SystemParamItem<'_, '_, Self>, a: Entity, b: Entity) -> bool;
}

/// Asks a [`PairHook`] about every candidate pair. Add it beside
/// [`OctreePlugins`](crate::OctreePlugins), in any order.
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
pub struct PairHookPlugin<H>(PhantomData<fn() -> H>);

impl<H> Default for PairHookPlugin<H> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<H: PairHook> Plugin for PairHookPlugin<H> {
    fn build(&self, app: &mut App) {
        let hook = app.register_system(ask_about::<H>);
        app.world_mut()
            .get_resource_or_init::<PairHooks>()
            .0
            .push(hook);
        add_to_tick(app, |app, schedule| {
            // Whichever takes out a pair: the rest is the same. Lists are asked first, for they
            // cost less.
            let ask = ask::<H>
                .in_set(HookSystems)
                .ambiguous_with(HookSystems)
                .after(ignore);
            app.configure_sets(schedule, HookSystems.in_set(PairFilterSystems))
                .add_systems(schedule, ask);
        });
    }

    fn finish(&self, app: &mut App) {
        expect_ticks(app, "PairHookPlugin");
    }
}

/// All hooks.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct HookSystems;

fn ask<H: PairHook>(
    hook: StaticSystemParam<H>,
    index: Res<CollisionIndex>,
    mut candidates: ResMut<CandidatePairs>,
) {
    candidates.retain(|pair| {
        let [a, b] = index.entities(*pair);
        H::admits(&hook, a, b)
    });
}

/// The hooks, each as a system that is asked about one pair.
#[derive(Resource, Debug, Default)]
struct PairHooks(Vec<SystemId<In<[Entity; 2]>, bool>>);

fn ask_about<H: PairHook>(In([a, b]): In<[Entity; 2]>, hook: StaticSystemParam<H>) -> bool {
    H::admits(&hook, a, b)
}

/// Do all hooks admit a pair? One that cannot be asked has no say.
pub(super) fn admit(world: &mut World, pair: [Entity; 2]) -> bool {
    if !world.contains_resource::<PairHooks>() {
        return true;
    }
    world.resource_scope(|world, hooks: Mut<PairHooks>| {
        hooks
            .0
            .iter()
            .all(|hook| match world.run_system_with(*hook, pair) {
                Ok(admitted) => admitted,
                Err(error) => {
                    let [a, b] = pair;
                    tracing::warn!("a hook could not be asked about {a} and {b}: {error}");
                    true
                }
            })
    })
}
