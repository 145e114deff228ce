//! Where entities are in the world, by their own transforms and those of their ancestors.
//!
//! `GlobalTransform` is up to date only after transform propagation, and entities have to be where they are in the tick in
//! which something moved. Places are computed in 64 bits, so that a deep hierarchy does not bend what hangs on it.

use bevy::{
    ecs::{
        entity::{EntityHashMap, EntityHashSet},
        entity_disabling::{DefaultQueryFilters, Disabled},
        query::{QueryData, QueryFilter},
        system::System,
        world::DeferredWorld,
    },
    math::{DAffine3, DQuat},
    prelude::*,
};

use crate::components::{BroadPhaseProxy, CollisionShape, WorldAabb};

/// An ancestor of entities with a shape. It stays one when the last of them is gone: that costs a look at it when it moves.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Carrier {
    /// Has it lost its transform?
    lost: bool,
}

/// Where an entity is in the space of its parent.
fn local(transform: &Transform) -> DAffine3 {
    let Transform { translation, rotation, scale } = *transform;
    let rotation = DQuat::from_xyzw(rotation.x.into(), rotation.y.into(), rotation.z.into(), rotation.w.into());
    let length = rotation.length();
    DAffine3::from_scale_rotation_translation(scale.as_dvec3(), rotation / length, translation.as_dvec3())
}

/// What an ancestor, or the entity itself, has to do with where an entity is.
pub(crate) type Ancestor<'a> = (&'a Transform, Option<&'a ChildOf>);

/// Where an entity is in the world; `None` if it is its own ancestor. A parent without a [`Transform`] ends the walk.
///
/// Walks up all ancestors. For the systems that [`see_disabled`] entities: a disabled parent is still where it is.
pub(crate) fn place_in_world(entity: Entity, ancestors: &Query<Ancestor, Allow<Disabled>>) -> Option<DAffine3> {
    let mut path = Vec::new();
    let (mut next, mut mark) = (Some(entity), entity);
    while let Some(Ok((transform, parent))) = next.map(|ancestor| ancestors.get(ancestor)) {
        path.push(local(transform));
        next = parent.map(ChildOf::parent);
        // Who walks in a circle comes back to where it was when the steps were last a power of two.
        if next == Some(mark) {
            return None;
        }
        if path.len().is_power_of_two() {
            mark = next.unwrap_or(mark);
        }
    }
    Some(path.into_iter().rev().fold(DAffine3::IDENTITY, |world, local| world * local))
}

/// Makes the queries of a system see entities that are disabled too, by whatever component.
pub(crate) fn see_disabled<S: IntoSystem<(), (), M>, M>(world: &mut World, system: S) -> S::System {
    let mut system = IntoSystem::into_system(system);
    without_filters(world, |world| {
        system.initialize(world);
    });
    system
}

/// Queries that are made while there are no filters never have any.
fn without_filters<T>(world: &mut World, mut make: impl FnMut(&mut World) -> T) -> T {
    let made = world.try_resource_scope(|world, _: Mut<DefaultQueryFilters>| make(world));
    made.unwrap_or_else(|| make(world))
}

/// A query that sees disabled entities too.
struct Unfiltered<D: QueryData + 'static, F: QueryFilter + 'static>(QueryState<D, F>);

impl<D: QueryData + 'static, F: QueryFilter + 'static> FromWorld for Unfiltered<D, F> {
    fn from_world(world: &mut World) -> Self {
        Self(without_filters(world, QueryState::new))
    }
}

type Moved = Or<(Changed<Transform>, Changed<ChildOf>)>;
type Altered = Or<(Moved, Changed<CollisionShape>, Changed<BroadPhaseProxy>)>;
type Node<'a> = (Option<&'a Transform>, Option<&'a ChildOf>, Option<&'a Children>, Has<Carrier>, Has<CollisionShape>);

/// Finds the entities with a shape and a parent that are elsewhere since the last time, with a look at what changed and what
/// hangs on it.
pub(crate) struct Hierarchy {
    nodes: Unfiltered<Node<'static>, ()>,
    carriers: Unfiltered<(Entity, Has<Transform>, &'static mut Carrier), Moved>,
    unplaced_carriers: Unfiltered<(Entity, &'static mut Carrier), Without<Transform>>,
    shapes: QueryState<Entity, (With<ChildOf>, With<WorldAabb>, Altered)>,
    places: Places,
    visited: EntityHashSet,
    to_visit: Vec<Entity>,
    moved: Vec<(Entity, Option<DAffine3>)>,
}

impl FromWorld for Hierarchy {
    fn from_world(world: &mut World) -> Self {
        Self {
            nodes: Unfiltered::from_world(world),
            carriers: Unfiltered::from_world(world),
            unplaced_carriers: Unfiltered::from_world(world),
            shapes: QueryState::new(world),
            places: Places::default(),
            visited: EntityHashSet::default(),
            to_visit: Vec::new(),
            moved: Vec::new(),
        }
    }
}

impl Hierarchy {
    /// All entities with a shape and a parent that moved, were moved by an ancestor, or changed shape; and where they are:
    /// `None` if they, or an ancestor, are their own ancestor. Each once; some may be disabled.
    pub(crate) fn moved(&mut self, world: &mut World) -> std::vec::Drain<'_, (Entity, Option<DAffine3>)> {
        self.places.known.clear();
        self.visited.clear();
        self.find_moved_carriers(world);
        let nodes = self.nodes.0.query(world);
        // What hangs on one that moved has moved.
        while let Some(entity) = self.to_visit.pop() {
            let Ok((_, _, children, carries, has_shape)) = nodes.get(entity) else { continue };
            if !(carries || has_shape) || !self.visited.insert(entity) {
                continue;
            }
            let place = self.places.of(entity, &nodes);
            if has_shape {
                self.moved.push((entity, place));
            }
            self.to_visit.extend(children.into_iter().flatten());
        }
        for entity in self.shapes.query(world) {
            if !self.visited.contains(&entity) {
                let place = self.places.of(entity, &nodes);
                self.moved.push((entity, place));
            }
        }
        for carrier in self.places.new_carriers.drain(..) {
            world.entity_mut(carrier).insert(Carrier::default());
        }
        self.moved.drain(..)
    }

    /// Those that moved, and those that lost their transform since the last time.
    fn find_moved_carriers(&mut self, world: &mut World) {
        self.to_visit.clear();
        for (entity, is_placed, mut carrier) in self.carriers.0.query_mut(world) {
            carrier.lost = !is_placed;
            self.to_visit.push(entity);
        }
        for (entity, mut carrier) in self.unplaced_carriers.0.query_mut(world) {
            if !std::mem::replace(&mut carrier.lost, true) {
                self.to_visit.push(entity);
            }
        }
    }
}

/// Places that are known, each computed once.
#[derive(Default)]
struct Places {
    known: EntityHashMap<Place>,
    path: Vec<(Entity, DAffine3)>,
    /// Ancestors that were not known to be ones.
    new_carriers: Vec<Entity>,
}

#[derive(Clone, Copy)]
enum Place {
    /// The walk that began here has not come to its end.
    Asked,
    Found(Option<DAffine3>),
}

impl Places {
    /// That of an entity; `None` if it has none.
    fn of(&mut self, entity: Entity, nodes: &Query<Node>) -> Option<DAffine3> {
        let (mut next, mut is_ancestor) = (Some(entity), false);
        let mut world = loop {
            let Some((asked, node)) = next.and_then(|next| Some((next, nodes.get(next).ok()?))) else {
                break Some(DAffine3::IDENTITY);
            };
            let (transform, parent, _, carries, _) = node;
            if is_ancestor && !carries {
                self.new_carriers.push(asked);
            }
            match self.known.get(&asked) {
                Some(Place::Found(place)) => break *place,
                Some(Place::Asked) => {
                    tracing::warn!(
                        "{asked} is its own ancestor: it and what hangs on it are left out of collision detection"
                    );
                    break None;
                }
                None => {}
            }
            let Some(transform) = transform else {
                // An ancestor that is nowhere ends the walk.
                break is_ancestor.then_some(DAffine3::IDENTITY);
            };
            self.known.insert(asked, Place::Asked);
            self.path.push((asked, local(transform)));
            next = parent.map(ChildOf::parent);
            is_ancestor = true;
        };
        for (entity, local) in self.path.drain(..).rev() {
            world = world.map(|world| world * local);
            self.known.insert(entity, Place::Found(world));
        }
        world
    }
}

/// An entity that loses its parent is elsewhere from then on, and so is what hangs on it.
pub(crate) fn on_unparented(event: On<Remove, ChildOf>, mut world: DeferredWorld) {
    let entity = event.entity;
    if world.get::<Carrier>(entity).is_some() {
        if let Some(mut transform) = world.get_mut::<Transform>(entity) {
            transform.set_changed();
        }
    } else if let Some(mut proxy) = world.get_mut::<BroadPhaseProxy>(entity) {
        proxy.set_changed();
    }
}
