//! What follows from the components of all entities, without any index, and from one tick alone.

use std::collections::{HashMap, HashSet};

use bevy::{ecs::entity_disabling::Disabled, prelude::*};
use bevy_octree::{
    components::{BroadPhaseProxy, WorldAabb},
    narrow_phase::{NarrowPhase, Placed, Workspace},
    prelude::*,
};

use super::machine::{Parked, Slots};
use crate::common::{EntityPair, pair};

/// What a tick is to come to. Verdicts that rounding may decide are left open.
#[derive(Resource, Clone, Debug, Default)]
pub struct Expected {
    /// In contact for certain, and perhaps.
    pub must: HashSet<EntityPair>,
    pub may: HashSet<EntityPair>,
    /// Who has opted in to events.
    pub enabled: HashSet<Entity>,
    /// Who is in the index.
    pub part: HashSet<Entity>,
}

/// Where an entity is in the world: a parent without a place is at its origin.
pub fn pose(world: &World, entity: Entity) -> Transform {
    let Some(local) = world.get::<Transform>(entity) else {
        return Transform::IDENTITY;
    };
    world
        .get::<ChildOf>(entity)
        .map_or(*local, |parent| pose(world, parent.parent()) * *local)
}

pub fn lineage(world: &World, entity: Entity) -> impl Iterator<Item = Entity> {
    std::iter::successors(Some(entity), |entity| {
        world.get::<ChildOf>(*entity).map(ChildOf::parent)
    })
}

pub fn is_disabled(world: &World, entity: Entity) -> bool {
    world.get::<Disabled>(entity).is_some() || world.get::<Parked>(entity).is_some()
}

pub fn body_of(world: &World, entity: Entity) -> Option<Entity> {
    lineage(world, entity).find(|entity| world.get::<CollisionBody>(*entity).is_some())
}

/// Is the entity in the index, by all that its components say?
pub fn takes_part(world: &World, entity: Entity) -> bool {
    let is_finite = lineage(world, entity).all(|entity| {
        let own = world.get::<Transform>(entity);
        own.is_none_or(Transform::is_finite)
    });
    is_finite
        && pose(world, entity).is_finite()
        && world.get::<CollisionShape>(entity).is_some()
        && world.get::<Transform>(entity).is_some()
        && world.get::<WorldAabb>(entity).is_some()
        && world.get::<BroadPhaseProxy>(entity).is_some()
        && !is_disabled(world, entity)
}

fn is_swept(world: &World, entity: Entity) -> bool {
    lineage(world, entity).any(|entity| world.get::<Swept>(entity).is_some())
}

/// Which of two hear of the contact, if filters let them meet.
pub fn hears(world: &World, a: Entity, b: Entity) -> Option<[bool; 2]> {
    let in_world = |entity| world.get::<InCollisionWorld>(entity).map(|own| own.0);
    let layers = |entity| {
        let layers = world.get::<CollisionLayers>(entity);
        layers.copied().unwrap_or_default()
    };
    let ignores = |a, b| {
        let list = world.get::<IgnoreCollisions>(a);
        list.is_some_and(|list| list.0.contains(&b))
    };
    let meets = |a, b| layers(a).filters.0 & layers(b).memberships.0 != 0;
    let detects = |entity| world.get::<Detector>(entity).is_some();
    let is_static = |entity| world.get::<StaticShape>(entity).is_some();
    let kinds = world.resource::<BroadPhaseSettings>().pair_kinds;
    let is_sought = match (is_static(a), is_static(b)) {
        (false, false) => kinds.moving_moving,
        (true, true) => kinds.static_static,
        _ => kinds.moving_static,
    };
    let is_inner = match (body_of(world, a), body_of(world, b)) {
        (Some(of_a), Some(of_b)) if of_a == of_b => {
            !world.get::<CollisionBody>(of_a).unwrap().inner_contacts
        }
        _ => false,
    };
    let hears = [meets(a, b), meets(b, a)];
    let either = (hears[0] && detects(a)) || (hears[1] && detects(b));
    (in_world(a) == in_world(b)
        && is_sought
        && !is_inner
        && !ignores(a, b)
        && !ignores(b, a)
        && (hears == [true; 2] || either))
        .then_some(hears)
}

/// Looks at all pairs, in the middle of a tick, once all has moved.
pub fn look(world: &mut World) {
    let tests = *world.resource::<NarrowPhase>();
    let [strict, loose] =
        [0.5, 2.0].map(|share| NarrowPhase::new(tests.tolerance() * share).unwrap());
    let all: Vec<Entity> = world.resource::<Slots>().0.clone();
    let view = &*world;
    let mut workspace = Workspace::default();
    let mut expected = Expected::default();
    let placed: Vec<_> = all
        .iter()
        .filter(|entity| takes_part(view, **entity))
        .map(|entity| {
            (
                *entity,
                &view.get::<CollisionShape>(*entity).unwrap().0,
                pose(view, *entity),
            )
        })
        .collect();
    for (place, (a, shape_a, pose_a)) in placed.iter().enumerate() {
        expected.part.insert(*a);
        if view.get::<CollisionEventsEnabled>(*a).is_some() {
            expected.enabled.insert(*a);
        }
        for (b, shape_b, pose_b) in &placed[place + 1..] {
            let Some(_) = hears(view, *a, *b) else {
                continue;
            };
            let key = pair(*a, *b);
            let mut meet = |tests: &NarrowPhase| {
                let [a, b] = [Placed::new(shape_a, pose_a), Placed::new(shape_b, pose_b)];
                tests.intersects(a, b, &mut workspace)
            };
            if is_swept(view, *a) || is_swept(view, *b) {
                // What they met on the way, other tests tell.
                expected.may.insert(key);
            } else if meet(&loose) {
                expected.may.insert(key);
                if meet(&strict) {
                    expected.must.insert(key);
                }
            }
        }
    }
    world.insert_resource(expected);
}

/// The answers of the library, and those of all tests one after the other.
pub fn query(In((origin, to)): In<(Vec3, Vec3)>, spatial: SpatialQuery) -> Answers {
    let filter = SpatialQueryFilter::DEFAULT;
    let mut answers = Answers::default();
    if let Ok(direction) = Dir3::new(to - origin) {
        let mut hits = Vec::new();
        spatial.ray_hits(Ray3d::new(origin, direction), 5.0, &filter, &mut hits);
        answers.first = spatial
            .cast_ray(Ray3d::new(origin, direction), 5.0, &filter)
            .map(|hit| hit.distance);
        answers.ray = hits.iter().map(|hit| (hit.entity, hit.distance)).collect();
        assert_eq!(answers.ray.len(), hits.len(), "each is met once: {hits:?}");
        assert_eq!(answers.first, hits.first().map(|hit| hit.distance));
    }
    let mut near = Vec::new();
    spatial.within(origin, 2.0, &filter, &mut near);
    answers.near = near.iter().map(|hit| (hit.entity, hit.distance)).collect();
    assert_eq!(
        answers.near.len(),
        near.len(),
        "each is near once: {near:?}"
    );
    answers.nearest = spatial
        .nearest(origin, f32::INFINITY, &filter)
        .map(|hit| hit.distance);
    let mut few = Vec::new();
    spatial.k_nearest(origin, 3, 2.0, &filter, &mut few);
    let [few, first] = [&few[..], &near[..few.len().min(near.len())]]
        .map(|hits| -> Vec<_> { hits.iter().map(|hit| hit.distance).collect() });
    assert_eq!(
        (few.len(), &few),
        (near.len().min(3), &first),
        "the nearest are the nearest of all"
    );
    let mut region = Vec::new();
    spatial.sphere_intersections(origin, 1.0, &filter, &mut region);
    answers.region = region.iter().copied().collect();
    assert_eq!(
        answers.region.len(),
        region.len(),
        "each is there once: {region:?}"
    );
    answers
}

#[derive(Debug, Default)]
pub struct Answers {
    pub ray: HashMap<Entity, f32>,
    pub first: Option<f32>,
    pub near: HashMap<Entity, f32>,
    pub nearest: Option<f32>,
    pub region: HashSet<Entity>,
}

impl Answers {
    pub fn count(&self) -> usize {
        self.ray.len() + self.near.len() + self.region.len()
    }
}

/// Checks answers against all exact tests.
pub fn check_answers(world: &World, origin: Vec3, to: Vec3, answers: &Answers) {
    let tests = *world.resource::<NarrowPhase>();
    let mut workspace = Workspace::default();
    let mut nearest = f32::INFINITY;
    let ball = Shape::sphere(1.0);
    let at = Transform::from_translation(origin);
    for entity in &world.resource::<Slots>().0 {
        let is_seen =
            takes_part(world, *entity) && world.get::<InCollisionWorld>(*entity).is_none();
        if !is_seen {
            let found = [
                answers.ray.contains_key(entity),
                answers.near.contains_key(entity),
                answers.region.contains(entity),
            ];
            assert_eq!(found, [false; 3], "{entity} is not to be seen");
            continue;
        }
        let place = pose(world, *entity);
        let shape = &world.get::<CollisionShape>(*entity).unwrap().0;
        let placed = || Placed::new(shape, &place);
        if let Ok(direction) = Dir3::new(to - origin) {
            let cast = |origin| {
                let hit = tests.cast_ray(placed(), origin, direction, 5.0);
                hit.map(|hit| hit.distance)
            };
            let (found, expected) = (answers.ray.get(entity).copied(), cast(origin));
            let agree = |a: Option<f32>, b: Option<f32>| match (a, b) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-3,
                (a, b) => a.is_none() && b.is_none(),
            };
            // A ray that grazes may meet or not.
            let (aside, across) = direction.any_orthonormal_pair();
            let grazes = || {
                [aside, -aside, across, -across, *direction, -*direction]
                    .iter()
                    .any(|by| !agree(cast(origin + *by * 2e-4), expected))
            };
            assert!(
                agree(found, expected) || grazes(),
                "ray to {entity}: {found:?}, {expected:?}"
            );
        }
        let closest = tests.closest_point(placed(), origin, &mut workspace);
        let distance = closest.map_or(f32::INFINITY, |point| point.distance(origin));
        nearest = nearest.min(distance);
        match answers.near.get(entity) {
            Some(found) => assert!(
                (found - distance).abs() < 1e-3,
                "{entity}: {found} {distance}"
            ),
            None => assert!(distance > 2.0 - 1e-3, "{entity} is near, {distance}"),
        }
        let meets = |share: f32, workspace: &mut Workspace| {
            let tests = NarrowPhase::new(tests.tolerance() * share).unwrap();
            tests.intersects(placed(), Placed::new(&ball, &at), workspace)
        };
        if answers.region.contains(entity) {
            assert!(meets(2.0, &mut workspace), "{entity} is not in the ball");
        } else {
            assert!(!meets(0.5, &mut workspace), "{entity} is in the ball");
        }
    }
    match answers.nearest {
        None => assert_eq!(nearest, f32::INFINITY, "somebody is nearest"),
        Some(found) => assert!(
            (found - nearest).abs() <= 1e-3 * nearest.max(1.0),
            "{found} {nearest}"
        ),
    }
}
