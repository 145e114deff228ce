//! The components that an entity carries to take part in collision detection.

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    math::{Vec3A, bounding::Aabb3d},
    prelude::*,
};

use crate::{
    broad_phase::{EVERYWHERE, ProxyId},
    collision_index,
    motion::Velocity,
    narrow_phase::{Shape, ShapeError},
    response::Bounce,
    swept::SweptWay,
};

/// The shape of an entity. An entity that has one takes part in collision detection; one that loses it, or is
/// despawned, no longer does, from that moment on. A shape that is overwritten is changed; one that is removed and
/// inserted again, even within a frame, starts anew: its contacts end and start.
///
/// It is placed by the [`Transform`]s of the entity and its ancestors. What becomes of shapes that a scaled parent shears is
/// said of the [`BoundsPlugin`](crate::BoundsPlugin#sheared-shapes).
///
/// An entity with a shape and no [`Velocity`] is *static*: while its [`Transform`] stays
/// unchanged, it is looked at by nothing.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// let mut world = World::new();
/// let wall = world.spawn((CollisionShape::cuboid(Vec3::new(0.1, 2.0, 2.0))?, Transform::from_xyz(3.0, 0.0, 0.0))).id();
/// assert!(world.get::<WorldAabb>(wall).is_some());
/// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
/// ```
#[derive(Component, Clone, Debug, Deref, Reflect)]
#[reflect(opaque)]
#[reflect(Component, Clone, Debug)]
#[require(Transform, WorldAabb, BroadPhaseProxy)]
#[component(on_remove = leave_index)]
pub struct CollisionShape(pub Shape);

impl CollisionShape {
    /// A box, by half its sides.
    ///
    /// # Errors
    /// As [`Shape::cuboid`].
    pub fn cuboid(half_size: Vec3) -> Result<Self, ShapeError> {
        Shape::cuboid(half_size).map(Self)
    }

    /// A ball around the entity's origin.
    ///
    /// # Errors
    /// As [`Shape::sphere`].
    pub fn sphere(radius: f32) -> Result<Self, ShapeError> {
        Shape::sphere(radius).map(Self)
    }
}

impl From<Shape> for CollisionShape {
    fn from(shape: Shape) -> Self {
        Self(shape)
    }
}

/// The cube of side 1 around the entity's origin: what the report's scenes are made of.
impl Default for CollisionShape {
    fn default() -> Self {
        Self(Shape::Cuboid { half_size: Vec3::splat(0.5) })
    }
}

/// A moving cube of side 1 that bounces: everything that a cube of the report's test sets needs, in one component.
/// Scale it by its [`Transform`].
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
#[require(CollisionShape, Velocity, Bounce)]
pub struct Cube;

/// The box along the world's axes around an entity's shape, as the broad phase sees it: grown by half the
/// [tolerance](crate::narrow_phase::NarrowPhase::tolerance) of the exact tests. That of an entity which is
/// [swept](crate::swept::Swept) is around all of its way in the tick.
///
/// Kept up to date in the set [`Bounds`](crate::CollisionSystems::Bounds). A system after that set and before
/// [`Maintenance`](crate::CollisionSystems::Maintenance) may enlarge it. What is inserted in its place is computed anew
/// at the next tick.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect, Deref)]
#[reflect(Component, Debug, Default, PartialEq)]
#[component(on_insert = compute_anew, on_remove = leave_index)]
pub struct WorldAabb(pub Aabb3d);

impl WorldAabb {
    /// The box of an entity that has none: not computed yet, or impossible to compute. It is inverted, and so refused
    /// by the broad phase.
    pub const NONE: Self = Self(Aabb3d { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY });

    /// The box of an entity whose shape has no end, as a half-space: all of space. The index keeps such entities apart
    /// from the broad phase.
    pub const UNBOUNDED: Self = Self(EVERYWHERE);
}

impl Default for WorldAabb {
    fn default() -> Self {
        Self::NONE
    }
}

/// An entity's entry in the [`CollisionIndex`](crate::collision_index::CollisionIndex). Comes and goes with the [`CollisionShape`]; a
/// cloned entity gets one of its own, as does one that is given a copy of another's.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_discard = leave_index, clone_behavior = Ignore)]
pub struct BroadPhaseProxy {
    #[reflect(ignore)]
    pub(crate) id: Option<ProxyId>,
    /// Where the shape was when its box was computed.
    pub(crate) pose: Transform,
}

impl BroadPhaseProxy {
    /// The entity's handle in the index; `None` before its first tick, and while it has no valid box.
    #[must_use]
    pub const fn id(&self) -> Option<ProxyId> {
        self.id
    }
}

/// Takes an entity out of the index at the moment in which it loses its shape, its box, its entry or its life.
fn leave_index(mut world: DeferredWorld, context: HookContext) {
    leave(&mut world, context.entity);
}

/// Takes an entity out of the index.
pub(crate) fn leave(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut way) = world.get_mut::<SweptWay>(entity) {
        way.forget();
    }
    collision_index::in_index(world, entity, collision_index::CollisionIndex::remove);
    if let Some(mut proxy) = world.get_mut::<BroadPhaseProxy>(entity) {
        proxy.id = None;
    }
}

fn compute_anew(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut proxy) = world.get_mut::<BroadPhaseProxy>(context.entity) {
        proxy.set_changed();
    }
}
