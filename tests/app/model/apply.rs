//! How each of the things that may happen is done.

use bevy::{ecs::entity_disabling::Disabled, prelude::*};
use bevy_octree::{
    broad_phase::{
        BroadPhase, BroadPhaseStats, LinearOctree, ObjectOctree, ObjectOctreeSettings, Pair,
        PairKinds, PairSearch, Proxies, Visitor,
    },
    collision_index::CollisionIndex,
    components::{BroadPhaseProxy, WorldAabb},
    narrow_phase::NarrowPhase,
    prelude::*,
};

use super::{
    machine::{Mine, Parked, Seen, Slots},
    ops::{Act, Op, Part, Place, Who},
    oracle::{self, check_answers},
};

const MOST: usize = 24;

/// The two worlds beside the default one.
#[derive(Resource)]
pub struct Worlds(pub [Entity; 2]);

/// Observers did something in this tick, after all was looked at.
#[derive(Resource, Default)]
pub struct Acted(pub bool);

/// A broad phase that is checked after each step.
struct Checked<B>(B, fn(&B, &Proxies));

impl<B: BroadPhase> BroadPhase for Checked<B> {
    fn name(&self) -> &'static str {
        "checked"
    }

    fn maintain(&mut self, proxies: &Proxies) {
        self.0.maintain(proxies);
        (self.1)(&self.0, proxies);
    }

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let tested = self.0.find_pairs(proxies, pairs);
        (self.1)(&self.0, proxies);
        tested
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        self.0.traverse(proxies, visitor);
    }

    fn stats(&self) -> BroadPhaseStats {
        self.0.stats()
    }
}

fn vector(place: Place) -> Vec3 {
    Vec3::from_array(place.map(|quarters| f32::from(quarters) * 0.25))
}

fn shape(kind: u8) -> CollisionShape {
    match kind {
        0..3 => CollisionShape::default(),
        3 => CollisionShape::sphere(0.5),
        4 => CollisionShape::sphere(0.25),
        5 => CollisionShape::cuboid(2.0, 0.5, 1.0),
        6 => CollisionShape::capsule(0.25, 1.0),
        7 => CollisionShape(Shape::cone(0.5, 1.0)),
        8 => CollisionShape(Shape::cylinder(0.5, 1.0)),
        9 => CollisionShape::sphere(0.0),
        10 => {
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
            CollisionShape::mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
        }
        _ => CollisionShape::cuboid(16.0, 0.25, 16.0),
    }
}

/// Chooses one that is there.
fn who(world: &World, number: Who) -> Option<Entity> {
    let slots = &world.resource::<Slots>().0;
    let place = usize::from(number).checked_rem(slots.len())?;
    Some(slots[place])
}

fn spawn(world: &mut World, bundle: impl Bundle) {
    if world.resource::<Slots>().0.len() < MOST {
        world.spawn((Mine, bundle));
    }
}

fn act(world: &mut World, act: Act, own: Entity, other: Entity) {
    world.resource_mut::<Acted>().0 = true;
    let is_there = |world: &World, entity| world.get_entity(entity).is_ok();
    match act {
        Act::DespawnOther => _ = world.try_despawn(other).is_ok(),
        Act::DespawnSelf => _ = world.try_despawn(own).is_ok(),
        _ if !is_there(world, own) || !is_there(world, other) => {}
        Act::OptOut => _ = world.entity_mut(own).remove::<CollisionEventsEnabled>(),
        Act::DisableOther => _ = world.entity_mut(other).insert(Disabled),
        Act::PushOther => {
            if let Some(mut at) = world.get_mut::<Transform>(other) {
                at.translation += Vec3::new(0.5, 0.25, 0.0);
            }
        }
        Act::Reshape => _ = world.entity_mut(own).insert(shape(5)),
        Act::Spawn => {
            let at = world.get::<Transform>(other).copied().unwrap_or_default();
            spawn(world, (CollisionShape::sphere(0.5), at));
        }
        Act::Adopt => {
            if !oracle::lineage(world, own).any(|entity| entity == other) {
                world.entity_mut(other).insert(ChildOf(own));
            }
        }
    }
}

fn give(world: &mut World, entity: Entity, part: Part) {
    let to = |own: bool, world: &World| world.resource::<Worlds>().0[usize::from(own)];
    let own_world = match part {
        Part::World(own) => to(own, world),
        _ => entity,
    };
    let mut entity = world.entity_mut(entity);
    match part {
        Part::Shape => entity.insert(shape(0)),
        Part::Sensor => entity.insert(Sensor),
        Part::Detector => entity.insert(Detector),
        Part::Static => entity.insert(StaticShape),
        Part::Swept => entity.insert(Swept::default()),
        Part::SweptStopping => entity.insert(Swept::stopping()),
        Part::Reverse => entity.insert(Bounce::Reverse),
        Part::Reflect => entity.insert(Bounce::Reflect { restitution: 0.5 }),
        Part::World(_) => entity.insert(InCollisionWorld(own_world)),
        Part::Ignored => entity.insert(IgnoreCollisions::default()),
        Part::Layers => entity.insert(CollisionLayers::default()),
        Part::Events => entity.insert(CollisionEventsEnabled),
        Part::Manifolds => entity.insert(ManifoldsEnabled),
        Part::Colliding => entity.insert(CollidingEntities::default()),
        Part::Body => entity.insert(CollisionBody::default()),
        Part::InnerBody => entity.insert(CollisionBody {
            inner_contacts: true,
        }),
        Part::Velocity => entity.insert(Velocity(Vec3::X * 4.0)),
        Part::Proxy => entity.insert(BroadPhaseProxy::default()),
        Part::Box => entity.insert(WorldAabb::default()),
        Part::Transform => entity.insert(Transform::default()),
    };
}

fn take(world: &mut World, entity: Entity, part: Part) {
    let mut entity = world.entity_mut(entity);
    match part {
        Part::Shape => entity.remove::<CollisionShape>(),
        Part::Sensor => entity.remove::<Sensor>(),
        Part::Detector => entity.remove::<Detector>(),
        Part::Static => entity.remove::<StaticShape>(),
        Part::Swept | Part::SweptStopping => entity.remove::<Swept>(),
        Part::Reverse | Part::Reflect => entity.remove::<Bounce>(),
        Part::World(_) => entity.remove::<InCollisionWorld>(),
        Part::Ignored => entity.remove::<IgnoreCollisions>(),
        Part::Layers => entity.remove::<CollisionLayers>(),
        Part::Events => entity.remove::<CollisionEventsEnabled>(),
        Part::Manifolds => entity.remove::<ManifoldsEnabled>(),
        Part::Colliding => entity.remove::<CollidingEntities>(),
        Part::Body | Part::InnerBody => entity.remove::<CollisionBody>(),
        Part::Velocity => entity.remove::<Velocity>(),
        Part::Proxy => entity.remove::<BroadPhaseProxy>(),
        Part::Box => entity.remove::<WorldAabb>(),
        Part::Transform => entity.remove::<Transform>(),
    };
}

fn watch(world: &mut World, own: Entity, at_end: bool, does: Act) {
    let mut entity = world.entity_mut(own);
    entity.insert(CollisionEventsEnabled);
    if at_end {
        entity.observe(move |event: On<CollisionEnded>, mut commands: Commands| {
            let [own, other] = [event.a, event.b];
            commands.queue(move |world: &mut World| act(world, does, own, other));
        });
    } else {
        entity.observe(move |event: On<CollisionStarted>, mut commands: Commands| {
            let [own, other] = [event.a, event.b];
            commands.queue(move |world: &mut World| act(world, does, own, other));
        });
    }
}

fn set_method(world: &mut World, number: u8) {
    let octree = |max_objects| ObjectOctreeSettings {
        search: if max_objects == 2 {
            PairSearch::Leaves
        } else {
            PairSearch::Blocks
        },
        ..ObjectOctreeSettings::with_max_objects(max_objects)
    };
    let method = match number {
        0 => BroadPhaseMethod::Auto,
        1 => BroadPhaseMethod::LinearOctree,
        2 => BroadPhaseMethod::Exhaustive,
        3 => BroadPhaseMethod::ObjectOctree(octree(1)),
        4 => BroadPhaseMethod::ObjectOctree(octree(2)),
        _ => {
            let engine: Box<dyn BroadPhase> = if number == 5 {
                Box::new(Checked(
                    ObjectOctree::new(octree(2)),
                    ObjectOctree::assert_well_formed,
                ))
            } else {
                Box::new(Checked(
                    LinearOctree::default(),
                    LinearOctree::assert_well_formed,
                ))
            };
            world.resource_mut::<CollisionIndex>().set_engine(engine);
            return;
        }
    };
    world.resource_mut::<BroadPhaseSettings>().method = method;
}

/// What is about no entity.
fn apply_to_all(world: &mut World, op: &Op) {
    match *op {
        Op::Spawn(kind, at) => {
            spawn(
                world,
                (shape(kind), Transform::from_translation(vector(at))),
            );
        }
        Op::SpawnMoving(kind, at, way) => {
            let moves = (shape(kind), Velocity(vector(way) * 4.0));
            spawn(world, (moves, Transform::from_translation(vector(at))));
        }
        Op::Method(number) => set_method(world, number),
        Op::Kinds(bits) => {
            world.resource_mut::<BroadPhaseSettings>().pair_kinds = PairKinds {
                moving_moving: bits & 1 == 0,
                moving_static: bits & 2 == 0,
                static_static: bits & 4 != 0,
            };
        }
        Op::Tolerance(large) => {
            let tolerance = if large { 1e-2 } else { 1e-4 };
            world.insert_resource(NarrowPhase::new(tolerance).unwrap());
        }
        Op::Messages(all) => {
            let scope = if all {
                EventScope::All
            } else {
                EventScope::Enabled
            };
            world.resource_mut::<CollisionEventSettings>().messages = scope;
        }
        Op::EndWorld(own) => {
            let number = usize::from(own);
            let ended = world.resource::<Worlds>().0[number];
            world.despawn(ended);
            world.resource_mut::<Worlds>().0[number] = Entity::PLACEHOLDER;
            let other = world.spawn_empty().id();
            world.resource_mut::<Worlds>().0[number] = other;
        }
        Op::Clear => {
            for entity in std::mem::take(&mut world.resource_mut::<Slots>().0) {
                // A child goes with its parent.
                _ = world.try_despawn(entity);
            }
        }
        Op::Flush => update_spatial_index(world),
        Op::Query(origin, to) => {
            update_spatial_index(world);
            let [origin, to] = [origin, to].map(vector);
            let answers = world
                .run_system_cached_with(oracle::query, (origin, to))
                .unwrap();
            check_answers(world, origin, to, &answers);
            world.resource_mut::<Seen>().answers += answers.count();
        }
        _ => {}
    }
}

fn change_transform(world: &mut World, entity: Entity, change: impl FnOnce(&mut Transform)) {
    if let Some(mut transform) = world.get_mut::<Transform>(entity) {
        change(&mut transform);
    }
}

pub fn apply(world: &mut World, op: &Op) {
    let (Op::Clone(number)
    | Op::Despawn(number)
    | Op::Move(number, _)
    | Op::Teleport(number, _)
    | Op::Turn(number, _)
    | Op::Scale(number, _)
    | Op::Resize(number, _)
    | Op::Swap(number, _)
    | Op::Renew(number)
    | Op::Reparent(number, _)
    | Op::Orphan(number)
    | Op::Disable(number, _)
    | Op::Enable(number)
    | Op::Give(number, _)
    | Op::Take(number, _)
    | Op::Ignore(number, _)
    | Op::Layers(number, ..)
    | Op::Velocity(number, _)
    | Op::Watch(number, ..)) = *op
    else {
        return apply_to_all(world, op);
    };
    let Some(entity) = who(world, number) else {
        return;
    };
    match *op {
        Op::Clone(_) if world.resource::<Slots>().0.len() < MOST => {
            world.entity_mut(entity).clone_and_spawn();
        }
        Op::Clone(_) => {}
        Op::Despawn(_) => _ = world.despawn(entity),
        Op::Move(_, to) => change_transform(world, entity, |at| at.translation = vector(to)),
        Op::Teleport(_, far) => {
            let to = [1e3, -1e3, 1e6, -1e6, 1e12, f32::NAN, f32::INFINITY, 1e-30][usize::from(far)];
            change_transform(world, entity, |at| at.translation.y = to);
        }
        Op::Turn(_, turn) => {
            let turn = Quat::from_scaled_axis(vector(turn));
            change_transform(world, entity, |at| at.rotation = turn);
        }
        Op::Scale(_, scale) => {
            let scale = Vec3::splat([1.0, 0.5, 2.0, -1.0, 0.0, 1.5][usize::from(scale)]);
            change_transform(world, entity, |at| at.scale = scale);
        }
        Op::Resize(_, kind) => {
            if let Some(mut own) = world.get_mut::<CollisionShape>(entity) {
                *own = shape(kind);
            }
        }
        Op::Swap(_, kind) => _ = world.entity_mut(entity).insert(shape(kind)),
        Op::Renew(_) => {
            if let Some(own) = world.entity_mut(entity).take::<CollisionShape>() {
                world.entity_mut(entity).insert(own);
            }
        }
        Op::Reparent(_, on) => {
            let on = who(world, on).unwrap_or(entity);
            if !oracle::lineage(world, on).any(|other| other == entity) {
                world.entity_mut(entity).insert(ChildOf(on));
            }
        }
        Op::Orphan(_) => _ = world.entity_mut(entity).remove::<ChildOf>(),
        Op::Disable(_, own) => {
            let mut entity = world.entity_mut(entity);
            if own {
                entity.insert(Parked);
            } else {
                entity.insert(Disabled);
            }
        }
        Op::Enable(_) => _ = world.entity_mut(entity).remove::<(Disabled, Parked)>(),
        Op::Give(_, part) => give(world, entity, part),
        Op::Take(_, part) => take(world, entity, part),
        Op::Ignore(_, other) => {
            let list = IgnoreCollisions::from_iter(who(world, other));
            world.entity_mut(entity).insert(list);
        }
        Op::Layers(_, on, meets) => {
            let layers = CollisionLayers::from_bits(on.into(), meets.into());
            world.entity_mut(entity).insert(layers);
        }
        Op::Velocity(_, way) => {
            let velocity = Velocity(vector(way) * 8.0);
            world.entity_mut(entity).insert(velocity);
        }
        Op::Watch(_, at_end, does) => watch(world, entity, at_end, does),
        _ => {}
    }
}
