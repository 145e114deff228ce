//! The components that an entity carries to take part in collision detection.

use bevy::{
    ecs::{
        change_detection::{MAX_CHANGE_AGE, Tick},
        lifecycle::HookContext,
        world::DeferredWorld,
    },
    math::{Vec3A, bounding::Aabb3d},
    prelude::*,
};

use crate::{
    broad_phase::{EVERYWHERE, PairFilter, ProxyId},
    collision_index::{CollisionIndex, upkeep::Upkeep},
    narrow_phase::{Fit, Placed, Shape, ShapeError},
    regroup,
    way::SweptWay,
};

/// The shape of an entity.
///
/// An entity that has one takes part in collision detection; one that loses it, or is despawned, no
/// longer does, from that moment on. A shape that is overwritten is
/// changed; one that is removed and inserted again, even within a frame, starts anew: its contacts
/// end and start.
///
/// It is written and read, by serde and by reflection, as [plain
/// data](crate::shape_data::ShapeDescription): who makes shapes in files and editors has that.
///
/// It is placed by the [`Transform`]s of the entity and its ancestors. What becomes of shapes that
/// a scaled parent shears is said of the
/// [`BoundsPlugin`](crate::plugins::BoundsPlugin#sheared-shapes).
///
/// An entity with a shape and no [`Velocity`](crate::motion::Velocity) is *at rest*: while its
/// [`Transform`] stays unchanged, it is looked at by nothing.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{components::WorldAabb, prelude::*};
///
/// let mut world = World::new();
/// let wall = world.spawn((CollisionShape::cuboid(0.2, 4.0, 4.0), Transform::from_xyz(3.0, 0.0, 0.0))).id();
/// world.spawn(CollisionShape::from(Cuboid::new(1.0, 2.0, 3.0)));
/// assert!(world.get::<WorldAabb>(wall).is_some());
/// ```
#[doc(alias("collider", "hitbox", "hurtbox", "collision object"))]
#[derive(Component, Clone, Debug, Deref, Reflect)]
#[reflect(opaque)]
#[reflect(Component, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[require(Transform, WorldAabb, BroadPhaseProxy)]
#[component(on_add = join_body, on_remove = lose_shape)]
pub struct CollisionShape(pub Shape);

/// # Constructors
///
/// As those of [`Shape`], for which see what becomes of [bad numbers](Shape#constructors).
impl CollisionShape {
    /// Makes a box around the entity's origin, by the lengths of its whole sides, as Bevy's
    /// `Cuboid::new` does.
    ///
    /// See [`Shape::cuboid`].
    #[must_use]
    pub fn cuboid(x_length: f32, y_length: f32, z_length: f32) -> Self {
        Self(Shape::cuboid(x_length, y_length, z_length))
    }

    /// Makes a box as [`cuboid`](Self::cuboid) does, and refuses bad numbers.
    ///
    /// # Errors
    /// As [`Shape::try_cuboid`].
    pub fn try_cuboid(x_length: f32, y_length: f32, z_length: f32) -> Result<Self, ShapeError> {
        Shape::try_cuboid(x_length, y_length, z_length).map(Self)
    }

    /// Makes a box around the entity's origin, by half the lengths of its sides.
    ///
    /// See [`Shape::from_half_size`].
    #[must_use]
    pub fn from_half_size(half_size: Vec3) -> Self {
        Self(Shape::from_half_size(half_size))
    }

    /// Makes a box as [`from_half_size`](Self::from_half_size) does, and refuses bad numbers.
    ///
    /// # Errors
    /// As [`Shape::try_from_half_size`].
    pub fn try_from_half_size(half_size: Vec3) -> Result<Self, ShapeError> {
        Shape::try_from_half_size(half_size).map(Self)
    }

    /// Makes a ball around the entity's origin.
    ///
    /// See [`Shape::sphere`].
    #[must_use]
    pub fn sphere(radius: f32) -> Self {
        Self(Shape::sphere(radius))
    }

    /// Makes a ball as [`sphere`](Self::sphere) does, and refuses a bad radius.
    ///
    /// # Errors
    /// As [`Shape::try_sphere`].
    pub fn try_sphere(radius: f32) -> Result<Self, ShapeError> {
        Shape::try_sphere(radius).map(Self)
    }

    /// Makes a capsule around the entity's origin, along its y axis: by its radius, and the length
    /// between the centres of its round ends, as Bevy's `Capsule3d::new` does.
    ///
    /// See [`Shape::capsule`].
    #[must_use]
    pub fn capsule(radius: f32, length: f32) -> Self {
        Self(Shape::capsule(radius, length))
    }

    /// Makes a cylinder around the entity's origin, along its y axis, as Bevy's `Cylinder::new`
    /// does.
    ///
    /// See [`Shape::cylinder`].
    #[must_use]
    pub fn cylinder(radius: f32, height: f32) -> Self {
        Self(Shape::cylinder(radius, height))
    }

    /// Makes the smallest convex solid around points.
    ///
    /// # Errors
    /// As [`Shape::convex_hull`].
    pub fn convex_hull(points: impl IntoIterator<Item = Vec3>) -> Result<Self, ShapeError> {
        Shape::convex_hull(points).map(Self)
    }

    /// Makes a convex solid of polygons, each a list of vertex indices.
    ///
    /// # Errors
    /// As [`Shape::convex`].
    pub fn convex<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        Shape::convex(vertices, polygons).map(Self)
    }

    /// Makes a mesh of planar polygons, each a list of vertex indices.
    ///
    /// # Errors
    /// As [`Shape::mesh`].
    pub fn mesh<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        Shape::mesh(vertices, polygons).map(Self)
    }
}

/// From whatever a [`Shape`] can be made of: Bevy's primitives, meshes, and, with the feature
/// `rapier`, colliders.
impl<T: Into<Shape>> From<T> for CollisionShape {
    fn from(shape: T) -> Self {
        Self(shape.into())
    }
}

/// The cube of side 1 around the entity's origin: what the report's scenes are made of.
impl Default for CollisionShape {
    fn default() -> Self {
        Self(Shape::Cuboid {
            half_size: Vec3::splat(0.5),
        })
    }
}

/// The box along the world's axes around an entity's shape, as the broad phase sees it: grown by
/// half the [tolerance](crate::narrow_phase::NarrowPhase::tolerance) of the exact tests. That of an
/// entity which is [swept](crate::swept::Swept) is around all of its way in the tick.
///
/// Kept up to date in the set [`Bounds`](crate::CollisionSystems::Bounds). A system after that set
/// and before [`Maintenance`](crate::CollisionSystems::Maintenance) may enlarge it. What is
/// inserted in its place is computed anew at the next tick.
#[doc(alias("aabb", "bounding box", "fat aabb"))]
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect, Deref)]
#[reflect(Component, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[component(on_insert = compute_anew, on_remove = leave_index)]
pub struct WorldAabb(pub Aabb3d);

impl WorldAabb {
    /// The box of an entity that has none: not computed yet, or impossible to compute. It is
    /// inverted, and so refused by the broad phase.
    pub const NONE: Self = Self(Aabb3d {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    });

    /// The box of an entity whose shape is unbounded, as a half-space: all of space. The index
    /// keeps such entities apart from the broad phase.
    pub const UNBOUNDED: Self = Self(EVERYWHERE);
}

impl Default for WorldAabb {
    fn default() -> Self {
        Self::NONE
    }
}

/// An entity's entry in the [`CollisionIndex`]. Comes and goes with the [`CollisionShape`]; a
/// cloned entity gets one of its own, as does one that is given a copy of another's.
///
/// For systems of one's own it is a handle to look at. That it counts as
/// [changed](bevy::ecs::query::Changed) has a meaning of its own: the box of the entity is out of
/// date.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Debug, Default)]
#[type_path = "bevy_octree"]
#[component(on_discard = leave_index, clone_behavior = Ignore)]
pub struct BroadPhaseProxy {
    #[reflect(ignore)]
    id: Option<ProxyId>,
    /// Where the shape was when its box was computed.
    pose: Transform,
    /// What that box says of the shape, and when it was computed: a box that was changed since says
    /// nothing.
    #[reflect(ignore)]
    fit: Fit,
    #[reflect(ignore)]
    boxed: Tick,
}

impl BroadPhaseProxy {
    /// Returns the entity's handle in the index; `None` before its first tick, and while it has no
    /// valid box.
    #[must_use]
    pub const fn id(&self) -> Option<ProxyId> {
        self.id
    }

    /// Where in the world the shape was when its box was computed.
    pub(crate) const fn pose(&self) -> &Transform {
        &self.pose
    }

    /// Is the box of the entity, which was last changed then, the one that was computed around its
    /// pose?
    #[inline]
    pub(crate) fn has_box_of(&self, box_changed: Tick) -> bool {
        box_changed == self.boxed
    }

    /// Is the box of the entity, which was last changed then, the one that was computed around its
    /// shape in this place?
    #[inline]
    pub(crate) fn is_box_at(&self, box_changed: Tick, pose: &Transform) -> bool {
        self.has_box_of(box_changed) && self.pose == *pose
    }

    /// What the box of the entity says of its shape, by when the two were last changed. Nothing, if
    /// that was after the box was computed.
    #[inline]
    pub(crate) fn fit(&self, box_changed: Tick, shape_changed: Tick) -> Fit {
        // Ticks wrap around; those of components are never further apart than that.
        let age = self.boxed.get().wrapping_sub(shape_changed.get());
        if box_changed == self.boxed && age <= MAX_CHANGE_AGE {
            self.fit
        } else {
            Fit::Loose
        }
    }
}

/// # Out of date or not
///
/// The set [`Bounds`](crate::CollisionSystems::Bounds) computes the boxes of those whose transform,
/// shape or proxy changed. So the change tick of a proxy is a flag, "the box is out of date", and
/// these are all who may write to one:
///
/// | method | who calls it | is the box out of date then? |
/// |---|---|---|
/// | [`outdate`](Self::outdate) | whoever makes a box wrong that no transform and no shape tells of | yes |
/// | [`note_box`](Self::note_box) | who computes the box | no |
/// | [`note_pose`](Self::note_pose) | who puts the entity elsewhere together with its box | no |
/// | [`touch_box`](Self::touch_box) | maintenance, of an index that missed something | no |
/// | [`note_id`](Self::note_id) | maintenance, which gives out handles | no |
/// | [`leave`] | hooks, as the entity leaves the index | yes: its box brings it back, if it has all it needs |
impl BroadPhaseProxy {
    /// Has the box computed anew in the next tick.
    pub(crate) fn outdate(proxy: &mut Mut<Self>) {
        proxy.set_changed();
    }

    /// Takes note of where the shape is that a box was computed around, and when that was. For who
    /// bypasses change detection.
    #[inline]
    pub(crate) fn note_box(&mut self, placed: Placed, boxed: Tick) {
        self.pose = *placed.transform;
        self.fit = Fit::of(placed);
        self.boxed = boxed;
    }

    /// Takes note of where the shape has been put. Its box was computed around where it was before.
    #[inline]
    pub(crate) fn note_pose(proxy: &mut Mut<Self>, pose: Transform) {
        let proxy = proxy.bypass_change_detection();
        (proxy.pose, proxy.boxed) = (pose, Tick::default());
    }

    /// Has the index look at the box again, which stays as it is.
    pub(crate) fn touch_box(proxy: &mut Mut<Self>, aabb: &mut Mut<WorldAabb>) {
        let is_own = proxy.has_box_of(aabb.last_changed());
        aabb.set_changed();
        if is_own {
            proxy.bypass_change_detection().boxed = aabb.last_changed();
        }
    }

    /// Takes note of the handle.
    pub(crate) fn note_id(proxy: &mut Mut<Self>, id: Option<ProxyId>) {
        proxy.bypass_change_detection().id = id;
    }
}

/// Has the box of an entity computed anew in the next tick, if it takes part.
pub(crate) fn outdate(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut proxy) = world.get_mut::<BroadPhaseProxy>(entity) {
        BroadPhaseProxy::outdate(&mut proxy);
    }
}

fn compute_anew(mut world: DeferredWorld, context: HookContext) {
    outdate(&mut world, context.entity);
}

/// A shape that is new may be a part of a body.
fn join_body(mut world: DeferredWorld, context: HookContext) {
    regroup::note(&mut world, context.entity);
}

fn lose_shape(mut world: DeferredWorld, context: HookContext) {
    regroup::note(&mut world, context.entity);
    leave(&mut world, context.entity);
}

/// Takes an entity out of the index at the moment in which it loses its shape, its box, its entry
/// or its life.
fn leave_index(mut world: DeferredWorld, context: HookContext) {
    leave(&mut world, context.entity);
}

/// Takes an entity out of the index.
pub(crate) fn leave(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut way) = world.get_mut::<SweptWay>(entity) {
        way.forget();
    }
    in_index(world, entity, CollisionIndex::remove);
    if let Some(mut proxy) = world.get_mut::<BroadPhaseProxy>(entity) {
        proxy.id = None;
    }
}

/// Does something to an entity's entry, at once. What the index misses, it mends at the next tick.
pub(crate) fn in_index(
    world: &mut DeferredWorld,
    entity: Entity,
    act: impl FnOnce(&mut CollisionIndex, ProxyId),
) {
    let Some(id) = world
        .get::<BroadPhaseProxy>(entity)
        .and_then(BroadPhaseProxy::id)
    else {
        return;
    };
    if let Some(mut index) = world.get_resource_mut::<CollisionIndex>()
        && index.is_entry_of(id, entity)
    {
        act(&mut index, id);
    } else if let Some(mut upkeep) = world.get_resource_mut::<Upkeep>() {
        upkeep.miss();
    }
}

/// Changes which pairs an entity makes, at once: for hooks of components that say so. Before its
/// first tick, an entity is not in the index, which then looks at its components.
pub(crate) fn change_filter(
    mut world: DeferredWorld,
    context: HookContext,
    change: impl FnOnce(&mut PairFilter),
) {
    in_index(&mut world, context.entity, |index, id| {
        index.change_filter(id, change);
    });
}

pub(crate) fn register(app: &mut App) {
    app.register_type::<CollisionShape>()
        .register_type::<WorldAabb>()
        .register_type::<BroadPhaseProxy>();
}
