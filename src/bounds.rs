//! World boxes from transforms and shapes.

use bevy::{
    ecs::{
        change_detection::{ContiguousMut, ContiguousRef},
        system::RegisteredSystemError,
    },
    prelude::*,
};

use crate::{
    change_ticks::{GROUP, ROWS, SinceLastRun},
    components::{BroadPhaseProxy, CollisionShape, WorldAabb},
    hierarchy::{self, Hierarchy},
    narrow_phase::{BoundsError, NarrowPhase, Placed, Shape},
    parallel,
    schedule::{CollisionSystems, add_to_tick},
    shear::{self, Sheared},
};

/// The plugin that computes the [`WorldAabb`] of every entity whose shape or place in the world
/// changed.
///
/// The place is taken from the [`Transform`]s of the entity and its ancestors, not from
/// `GlobalTransform`, which is up to date only after transform propagation: boxes are right in the
/// tick in which something moved. A parent without a `Transform` is at the origin of the world.
/// What rests is not looked at, however deep the hierarchy; what was written, and is where it was,
/// as after interpolation between ticks, rests too.
///
/// An entity whose box cannot be computed is left out of collision detection until that changes,
/// with a warning in the log: one with a transform that is not finite, its own or an ancestor's,
/// and one that is its own ancestor. So is one that has lost its `Transform`, without a warning.
/// One whose shape is unbounded has an [unbounded](WorldAabb::UNBOUNDED) box.
///
/// # Sheared shapes
///
/// A parent with a scale that differs by axis shears the children that are turned against it.
/// Cuboids, convex solids, meshes, half-spaces, triangles, segments, and what is rounded of these but
/// cuboids, are then what they are under it, exactly, but for the radius around them. All others are
/// not sheared, with a warning in the log, once for each entity: a ball stays a ball, by the largest
/// stretch in any direction; capsules, frusta, rounded cuboids, compounds, height fields and voxels
/// are turned as is nearest, and as long along each of their own axes as they would be; a Rapier
/// collider is as by Rapier itself. Ancestors that move, turn and stretch cost what they
/// cost elsewhere; a shape that turns against them is built anew, in time linear in its vertices.
///
/// # Scales that differ by axis
///
/// What [does not follow](crate::narrow_phase::Shape) such a scale, as a ball that stays a ball, is
/// told of in a warning in the log: once for each entity, when it gets the shape or the scale.
#[derive(Clone, Copy, Debug, Default)]
pub struct BoundsPlugin;

impl Plugin for BoundsPlugin {
    fn build(&self, app: &mut App) {
        let some_children =
            any_match_filter::<Or<((With<ChildOf>, With<CollisionShape>), With<Sheared>)>>;
        app.add_observer(hierarchy::on_unparented);
        add_to_tick(app, move |app, schedule| {
            let update = (
                outdate_all,
                update_roots,
                update_children.run_if(some_children),
            )
                .chain();
            app.add_systems(schedule, update.in_set(CollisionSystems::Bounds));
        });
    }
}

/// Boxes are grown by the tolerance: when that changes, so do all of them.
pub(crate) fn outdate_all(mut proxies: Query<&mut BroadPhaseProxy>, tests: Res<NarrowPhase>) {
    if tests.is_changed() {
        proxies
            .iter_mut()
            .for_each(|mut proxy| BroadPhaseProxy::outdate(&mut proxy));
    }
}

/// Brings all boxes up to date, at any moment.
pub(crate) fn refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    world.run_system_cached(outdate_all)?;
    world.run_system_cached(update_roots)?;
    world.run_system_cached(update_children)
}

type Root<'a> = (
    Entity,
    Ref<'a, CollisionShape>,
    Ref<'a, Transform>,
    &'a mut WorldAabb,
    &'a mut BroadPhaseProxy,
);

/// Tables are gone through as slices, in which what rests costs a look at its change ticks, and on
/// all threads.
fn update_roots(
    mut roots: Query<Root, Without<ChildOf>>,
    mut nowhere: Query<&mut WorldAabb, (With<CollisionShape>, Without<Transform>)>,
    tests: Res<NarrowPhase>,
) {
    match roots.contiguous_iter_mut() {
        Ok(tables) => tables.for_each(|table| update_table(&tests, table)),
        // What disables entities may not be in tables.
        Err(_) => {
            for (entity, shape, transform, mut aabb, mut proxy) in &mut roots {
                let is_outdated = shape.is_changed() || proxy.is_changed();
                let has_moved =
                    || transform.is_changed() && !proxy.is_box_at(aabb.last_changed(), &transform);
                if is_outdated || has_moved() {
                    *aabb = world_aabb(&tests, entity, &shape, &transform);
                    let placed = Placed::new(&shape, &transform);
                    tell_scale(entity, placed, proxy.pose(), shape.is_changed());
                    let proxy = proxy.bypass_change_detection();
                    proxy.note_box(placed, aabb.last_changed());
                }
            }
        }
    }
    for mut aabb in &mut nowhere {
        aabb.set_if_neq(WorldAabb::NONE);
    }
}

type Table<'a> = (
    &'a [Entity],
    ContiguousRef<'a, CollisionShape>,
    ContiguousRef<'a, Transform>,
    ContiguousMut<'a, WorldAabb>,
    ContiguousMut<'a, BroadPhaseProxy>,
);

fn update_table(tests: &NarrowPhase, (entities, shapes, transforms, boxes, proxies): Table) {
    let since = SinceLastRun::of_mut(&boxes);
    let (boxes, mut boxed) = ContiguousMut::bypass_change_detection_split(boxes);
    let (proxies, outdated) = ContiguousMut::bypass_change_detection_split(proxies);
    let read = entities.chunks(ROWS).zip(shapes.chunks(ROWS));
    let read = read.zip(transforms.chunks(ROWS));
    let ticks = shapes
        .changed_ticks_slice()
        .chunks(ROWS)
        .zip(transforms.changed_ticks_slice().chunks(ROWS))
        .zip(outdated.changed().chunks(ROWS));
    let written = boxes
        .chunks_mut(ROWS)
        .zip(boxed.changed_mut().chunks_mut(ROWS))
        .zip(proxies.chunks_mut(ROWS));
    parallel::for_each(read.zip(ticks).zip(written), |((read, ticks), written)| {
        let ((entities, shapes), transforms) = read;
        let ((reshaped, moved), outdated) = ticks;
        let ((boxes, boxed), proxies) = written;
        for start in (0..entities.len()).step_by(GROUP) {
            let group = start..entities.len().min(start + GROUP);
            let ticks = [reshaped, moved, outdated].map(|ticks| &ticks[group.clone()]);
            if !ticks.iter().any(|ticks| since.any_changed(ticks)) {
                continue;
            }
            for row in group {
                let (shape, transform) = (&shapes[row], &transforms[row]);
                let is_reshaped = since.changed(reshaped[row]);
                let is_outdated = is_reshaped || since.changed(outdated[row]);
                let has_moved =
                    || since.changed(moved[row]) && !proxies[row].is_box_at(boxed[row], transform);
                if is_outdated || has_moved() {
                    boxes[row] = world_aabb(tests, entities[row], shape, transform);
                    boxed[row] = since.this_run();
                    let placed = Placed::new(shape, transform);
                    tell_scale(entities[row], placed, proxies[row].pose(), is_reshaped);
                    proxies[row].note_box(placed, since.this_run());
                }
            }
        }
    });
}

type Child = (
    Ref<'static, CollisionShape>,
    &'static mut WorldAabb,
    &'static mut BroadPhaseProxy,
    Option<&'static mut Sheared>,
);

pub(crate) fn update_children(
    world: &mut World,
    mut hierarchy: Local<Hierarchy>,
    children: &mut QueryState<Child>,
    unparented: &mut QueryState<Entity, (With<Sheared>, Without<ChildOf>)>,
) {
    let Some(&tests) = world.get_resource::<NarrowPhase>() else {
        return;
    };
    for entity in unparented.iter(world).collect::<Vec<_>>() {
        world.entity_mut(entity).remove::<Sheared>();
        // What takes part is another shape from now on.
        if let Some(mut shape) = world.get_mut::<CollisionShape>(entity) {
            shape.set_changed();
        }
    }
    hierarchy.for_each_moved(world, |world, entity, pose| {
        // It may be disabled.
        let Ok((own, mut aabb, mut proxy, sheared)) = children.get_mut(world, entity) else {
            return;
        };
        let Some(pose) = pose else {
            aabb.set_if_neq(WorldAabb::NONE);
            return;
        };
        let is_reshaped = own.is_changed();
        let is_outdated = is_reshaped || proxy.is_changed();
        let own = &own.0;
        let placement = shear::put(own, &pose, sheared.as_deref());
        let stays = || proxy.is_box_at(aabb.last_changed(), &placement.transform);
        if !is_outdated && sheared.is_none() && !placement.is_sheared && stays() {
            return;
        }
        if !placement.is_sheared {
            let placed = Placed::new(own, &placement.transform);
            tell_scale(entity, placed, proxy.pose(), is_reshaped);
        }
        let mut put = |shape: &Shape| {
            let placed = Placed::new(shape, &placement.transform);
            *aabb = world_aabb(&tests, entity, shape, placed.transform);
            let proxy = proxy.bypass_change_detection();
            proxy.note_box(placed, aabb.last_changed());
        };
        if let Some(mut sheared) = sheared {
            sheared.follow(own, placement.turn);
            put(sheared.shape());
        } else if !placement.is_sheared {
            put(own);
        } else {
            let sheared = Sheared::new(own, placement.turn);
            put(sheared.shape());
            if sheared.shape().is_same(own) {
                tracing::warn!(
                    "{entity} is sheared by an ancestor, as its shape cannot be: see `BoundsPlugin`"
                );
            }
            world.entity_mut(entity).insert(sheared);
        }
    });
}

/// The box around a shape where it is.
#[inline]
pub(crate) fn world_aabb(
    tests: &NarrowPhase,
    entity: Entity,
    shape: &Shape,
    transform: &Transform,
) -> WorldAabb {
    match tests.world_aabb(Placed::new(shape, transform)) {
        Ok(aabb) => WorldAabb(aabb),
        Err(error) => without_box(entity, error),
    }
}

/// Tells of a shape that does not follow its scale, when it gets the one or the other.
#[inline]
fn tell_scale(entity: Entity, placed: Placed, before: &Transform, is_reshaped: bool) {
    let scale = placed.transform.scale;
    let follows = matches!(placed.shape, Shape::Cuboid { .. } | Shape::Mesh(_)) || is_even(scale);
    if !follows && (is_reshaped || is_even(before.scale)) {
        tell_left_by_scale(entity, placed);
    }
}

#[inline]
fn is_even(scale: Vec3) -> bool {
    let Vec3 { x, y, z } = scale.abs();
    x == y && y == z
}

#[cold]
fn tell_left_by_scale(entity: Entity, placed: Placed) {
    let scale = placed.transform.scale;
    if let Some(what) = placed.shape.left_by_scale(scale)
        && scale.is_finite()
    {
        tracing::warn!("{entity} has a scale that differs by axis, {scale}, and {what}");
    }
}

#[cold]
fn without_box(entity: Entity, error: BoundsError) -> WorldAabb {
    if error == BoundsError::Unbounded {
        return WorldAabb::UNBOUNDED;
    }
    tracing::warn!("{entity} is left out of collision detection: {error}");
    WorldAabb::NONE
}
