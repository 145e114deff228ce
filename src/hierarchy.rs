//! Where entities are in the world, by their own transforms and those of their ancestors.
//!
//! `GlobalTransform` is up to date only after transform propagation, and entities have to be where
//! they are in the tick in which something moved. Poses are computed in 64 bits, so that a deep
//! hierarchy does not bend what hangs on it.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy::{
    ecs::world::DeferredWorld,
    math::{DAffine3, DQuat},
    prelude::*,
};

use crate::{
    ancestors,
    components::{self, BroadPhaseProxy, CollisionShape, WorldAabb},
    disabled::Unfiltered,
};

/// An ancestor of entities with a shape. It stays one when the last of them is gone: that costs a
/// look at it when it moves.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Carrier {
    /// Has it lost its transform?
    lost: bool,
    /// The runs of [`Hierarchy`] in which its pose was found, and what hangs on it visited.
    known: u64,
    visited: u64,
    /// Where it is, in that run; `None` if it is its own ancestor.
    pose: Option<DAffine3>,
}

/// Where an entity is in the space of its parent.
pub(crate) fn local(transform: &Transform) -> DAffine3 {
    let Transform {
        translation,
        rotation,
        scale,
    } = *transform;
    let rotation = DQuat::from_xyzw(
        rotation.x.into(),
        rotation.y.into(),
        rotation.z.into(),
        rotation.w.into(),
    );
    let length = rotation.length();
    DAffine3::from_scale_rotation_translation(
        scale.as_dvec3(),
        rotation / length,
        translation.as_dvec3(),
    )
}

/// What an ancestor, or the entity itself, has to do with where an entity is.
pub(crate) type Link<'a> = (&'a Transform, Option<&'a ChildOf>);

/// Where an entity is in the world; `None` if it is its own ancestor. A parent without a
/// [`Transform`] ends the walk.
///
/// Walks up all ancestors. For the systems that [see](crate::disabled::see_disabled) disabled entities: a disabled parent is
/// still where it is.
pub(crate) fn pose_in_world(entity: Entity, links: &Query<Link>) -> Option<DAffine3> {
    let look = |entity| {
        let (transform, parent) = links.get(entity).ok()?;
        Some((local(transform), parent.map(ChildOf::parent)))
    };
    let path = ancestors::up(entity, look)
        .collect::<Result<Vec<_>, _>>()
        .ok()?;
    Some(
        path.into_iter()
            .rev()
            .fold(DAffine3::IDENTITY, |world, local| world * local),
    )
}

type Moved = Or<(Changed<Transform>, Changed<ChildOf>)>;
type Altered = Or<(Moved, Changed<CollisionShape>, Changed<BroadPhaseProxy>)>;
type Child = (Entity, Option<&'static Transform>, &'static ChildOf);
type Node = (
    Option<&'static Transform>,
    Option<&'static ChildOf>,
    Option<&'static Children>,
    Option<&'static mut Carrier>,
    Has<CollisionShape>,
);

/// Finds the entities with a shape and a parent that are elsewhere since the last time, with a look
/// at what changed and what hangs on it.
pub(crate) struct Hierarchy {
    nodes: Unfiltered<Node, ()>,
    moved_carriers: Unfiltered<(Entity, Has<Transform>, &'static mut Carrier), Moved>,
    unplaced_carriers: Unfiltered<(Entity, &'static mut Carrier), Without<Transform>>,
    altered: QueryState<Child, (With<ChildOf>, With<WorldAabb>, Altered)>,
    /// Carriers that moved.
    moved: Vec<Entity>,
    /// Entities with a shape that changed, and their parents.
    altered_children: Vec<(Entity, Option<Transform>, Entity)>,
    /// What hangs on something that moved, and where that is.
    to_visit: Vec<(Entity, Option<DAffine3>)>,
    /// The way up.
    path: Vec<(Entity, DAffine3)>,
    /// The number of this run, which no other has.
    run: u64,
    /// Has anything been visited in this run?
    has_visited: bool,
}

impl FromWorld for Hierarchy {
    fn from_world(world: &mut World) -> Self {
        Self {
            nodes: Unfiltered::from_world(world),
            moved_carriers: Unfiltered::from_world(world),
            unplaced_carriers: Unfiltered::from_world(world),
            altered: QueryState::new(world),
            moved: Vec::new(),
            altered_children: Vec::new(),
            to_visit: Vec::new(),
            path: Vec::new(),
            run: 0,
            has_visited: false,
        }
    }
}

impl Hierarchy {
    /// Calls `found` with all entities with a shape and a parent that moved, were moved by an
    /// ancestor, or changed shape, each once, and where they are: `None` if they, or an ancestor,
    /// are their own ancestor. Some may be disabled.
    pub(crate) fn for_each_moved(
        &mut self,
        world: &mut World,
        mut found: impl FnMut(&mut World, Entity, Option<DAffine3>),
    ) {
        static RUNS: AtomicU64 = AtomicU64::new(1);
        self.run = RUNS.fetch_add(1, Ordering::Relaxed);
        self.find_moved_carriers(world);
        self.has_visited = !self.moved.is_empty();
        while let Some(entity) = self.moved.pop() {
            let Ok((_, parent, _, Some(carrier), _)) = self.nodes.0.get_mut(world, entity) else {
                continue;
            };
            if carrier.visited == self.run {
                continue;
            }
            let parent = parent.map(ChildOf::parent);
            let pose = self.pose_of_parent(world, parent);
            self.to_visit.push((entity, pose));
            // What hangs on one that moved has moved.
            while let Some((entity, parent)) = self.to_visit.pop() {
                self.visit(world, entity, parent, &mut found);
            }
        }
        self.find_altered(world, found);
    }

    /// Those that moved, and those that lost their transform since the last time.
    fn find_moved_carriers(&mut self, world: &mut World) {
        for (entity, is_placed, mut carrier) in self.moved_carriers.0.query_mut(world) {
            carrier.lost = !is_placed;
            self.moved.push(entity);
        }
        for (entity, mut carrier) in self.unplaced_carriers.0.query_mut(world) {
            if !std::mem::replace(&mut carrier.lost, true) {
                self.moved.push(entity);
            }
        }
    }

    /// Finds where an entity is, given where its parent is, and has what hangs on it visited.
    fn visit(
        &mut self,
        world: &mut World,
        entity: Entity,
        parent: Option<DAffine3>,
        found: &mut impl FnMut(&mut World, Entity, Option<DAffine3>),
    ) {
        let Ok((transform, child_of, children, carrier, has_shape)) =
            self.nodes.0.get_mut(world, entity)
        else {
            return;
        };
        let pose = transform.and_then(|transform| Some(parent? * local(transform)));
        let has_shape = has_shape && child_of.is_some();
        if let Some(mut carrier) = carrier {
            if carrier.visited == self.run {
                return;
            }
            (carrier.visited, carrier.known, carrier.pose) = (self.run, self.run, pose);
            let origin = if transform.is_some() {
                pose
            } else {
                Some(DAffine3::IDENTITY)
            };
            self.to_visit
                .extend(children.into_iter().flatten().map(|child| (*child, origin)));
        }
        if has_shape {
            found(world, entity, pose);
        }
    }

    /// Those that moved by themselves without taking others with them, and those that changed
    /// otherwise.
    fn find_altered(
        &mut self,
        world: &mut World,
        mut found: impl FnMut(&mut World, Entity, Option<DAffine3>),
    ) {
        let altered = self.altered.query(world);
        let mut changed = std::mem::take(&mut self.altered_children);
        changed.extend(
            altered
                .iter()
                .map(|(entity, own, parent)| (entity, own.copied(), parent.parent())),
        );
        let visited =
            |carrier: Option<&Carrier>| carrier.is_some_and(|carrier| carrier.visited == self.run);
        if self.has_visited {
            changed.retain(|(entity, _, parent)| {
                !visited(world.get(*entity)) && !visited(world.get(*parent))
            });
        }
        for (entity, own, parent) in changed.drain(..) {
            let pose = self.pose_of_parent(world, Some(parent));
            found(world, entity, own.and_then(|own| Some(pose? * local(&own))));
        }
        self.altered_children = changed;
    }

    /// Where a parent is, each computed once.
    fn pose_of_parent(&mut self, world: &mut World, mut next: Option<Entity>) -> Option<DAffine3> {
        let mut pose = loop {
            let Some((entity, node)) =
                next.and_then(|next| Some((next, self.nodes.0.get_mut(world, next).ok()?)))
            else {
                break Some(DAffine3::IDENTITY);
            };
            let (transform, parent, _, carrier, _) = node;
            let (transform, parent) = (transform.copied(), parent.map(ChildOf::parent));
            let Some(mut carrier) = carrier else {
                world.entity_mut(entity).insert(Carrier::default());
                continue;
            };
            let Some(transform) = transform else {
                // One that is nowhere ends the walk.
                carrier.lost = true;
                break Some(DAffine3::IDENTITY);
            };
            if carrier.known == self.run {
                let pose = carrier.pose;
                if pose.is_none() && self.path.iter().any(|(below, _)| *below == entity) {
                    tracing::warn!(
                        "{entity} is its own ancestor: it and what hangs on it are left out of collision detection"
                    );
                }
                break pose;
            }
            // Who comes here again before the way back is in a circle.
            (carrier.known, carrier.pose) = (self.run, None);
            self.path.push((entity, local(&transform)));
            next = parent;
        };
        for (entity, local) in self.path.drain(..).rev() {
            pose = pose.map(|pose| pose * local);
            if let Some(mut carrier) = world.get_mut::<Carrier>(entity) {
                carrier.pose = pose;
            }
        }
        pose
    }
}

/// An entity that loses its parent is elsewhere from then on, and so is what hangs on it.
pub(crate) fn on_unparented(event: On<Remove, ChildOf>, mut world: DeferredWorld) {
    let entity = event.entity;
    if world.get::<Carrier>(entity).is_some() {
        if let Some(mut transform) = world.get_mut::<Transform>(entity) {
            transform.set_changed();
        }
    } else {
        components::outdate(&mut world, entity);
    }
}
