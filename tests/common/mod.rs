//! A headless app with a clock of its own, and what the tests look at.

pub mod fnv;
pub mod interrupted;
pub mod warnings;

use std::{collections::HashMap, time::Duration};

use bevy::{app::Plugins, ecs::schedule::ScheduleLabel, prelude::*, time::TimeUpdateStrategy};
use bevy_octree::{
    broad_phase::{
        BroadPhase, BroadPhaseStats, ObjectOctree, ObjectOctreeSettings, Pair, Proxies, ProxyId,
        SpatialIndex, Visitor,
    },
    collision_index::CollisionIndex,
    components::WorldAabb,
    motion::CollisionClock,
    narrow_phase::{NarrowPhase, Placed, Workspace},
    prelude::*,
};

/// Ticks per second: that of the fixed timestep. A velocity of `TICKS_PER_SECOND * v` moves `v` per
/// tick, exactly.
pub const TICKS_PER_SECOND: f32 = 64.0;

/// All sets, in their order.
pub const SETS: [CollisionSystems; 9] = [
    CollisionSystems::First,
    CollisionSystems::Motion,
    CollisionSystems::Bounds,
    CollisionSystems::Maintenance,
    CollisionSystems::BroadPhase,
    CollisionSystems::NarrowPhase,
    CollisionSystems::Response,
    CollisionSystems::Report,
    CollisionSystems::Last,
];

/// Two entities, the one that was spawned first in front.
pub type EntityPair = [Entity; 2];

/// The sides of a box whose corners are numbered by their bits: x, y, z from the lowest.
pub const SIDES: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

/// The pair of two entities in any order.
pub fn pair(a: Entity, b: Entity) -> EntityPair {
    if a.index_u32() < b.index_u32() {
        [a, b]
    } else {
        [b, a]
    }
}

/// An app with all plugins in `FixedPostUpdate`, which [`tick`] runs once.
pub fn app(method: BroadPhaseMethod) -> App {
    let mut app = app_with(OctreePlugins::default(), FixedPostUpdate);
    app.world_mut().resource_mut::<BroadPhaseSettings>().method = method;
    app
}

/// An app whose collision plugins are `plugins`, with their systems in `schedule`.
pub fn app_with<M>(plugins: impl Plugins<M>, schedule: impl ScheduleLabel) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, plugins))
        .insert_resource(TimeUpdateStrategy::ManualDuration(
            Duration::from_secs(1) / TICKS_PER_SECOND as u32,
        ))
        .init_resource::<Log>()
        .add_systems(
            schedule,
            Log::record
                .in_set(CollisionSystems::Last)
                .run_if(messages_exist),
        );
    // The first update of a clock only starts it.
    app.world_mut()
        .resource_mut::<Time<Real>>()
        .update_with_duration(Duration::ZERO);
    app
}

fn messages_exist(started: Option<Res<Messages<CollisionStarted>>>) -> bool {
    started.is_some()
}

/// Runs `ticks` ticks.
pub fn tick(app: &mut App, ticks: usize) {
    for _ in 0..ticks {
        app.update();
    }
}

/// A static unit cube.
pub fn block(app: &mut App, x: f32) -> Entity {
    app.world_mut()
        .spawn((CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0)))
        .id()
}

/// An app with two static cubes in contact, one tick old.
pub fn in_contact() -> (App, EntityPair) {
    let mut app = app(BroadPhaseMethod::default());
    let cubes = [block(&mut app, 0.0), block(&mut app, 0.9)];
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [cubes]);
    (app, cubes)
}

/// Every message so far, with the number of its tick, counted from 1.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Log {
    pub started: Vec<(u64, EntityPair)>,
    pub ended: Vec<(u64, EntityPair)>,
    open: Vec<EntityPair>,
}

impl Log {
    /// Takes up the messages of a tick, and checks that they tell of each change of the contacts,
    /// exactly once.
    fn record(
        mut log: ResMut<Self>,
        mut started: MessageReader<CollisionStarted>,
        mut ended: MessageReader<CollisionEnded>,
        clock: Res<CollisionClock>,
        contacts: Res<Contacts>,
    ) {
        let tick = clock.tick().wrapping_add(1);
        for pair in ended.read().map(|message| pair(message.a, message.b)) {
            let place = log.open.iter().position(|open| *open == pair);
            log.open.swap_remove(place.expect("what ends has started"));
            log.ended.push((tick, pair));
        }
        for pair in started.read().map(|message| pair(message.a, message.b)) {
            assert!(!log.open.contains(&pair), "{pair:?} started twice");
            log.open.push(pair);
            log.started.push((tick, pair));
        }
        assert_eq!(
            sorted(log.open.clone()),
            pairs(&contacts),
            "what started and has not ended is in contact"
        );
    }
}

fn sorted(mut pairs: Vec<EntityPair>) -> Vec<EntityPair> {
    pairs.sort_unstable_by_key(|pair| pair.map(Entity::index_u32));
    pairs
}

fn pairs(contacts: &Contacts) -> Vec<EntityPair> {
    sorted(
        contacts
            .iter()
            .map(|contact| pair(contact.a, contact.b))
            .collect(),
    )
}

/// The pairs in contact, sorted.
pub fn contacts(app: &App) -> Vec<EntityPair> {
    pairs(app.world().resource::<Contacts>())
}

/// The number of messages of either kind about a pair: started, ended.
pub fn messages_about(app: &App, pair: EntityPair) -> (usize, usize) {
    let log = app.world().resource::<Log>();
    let count = |messages: &[(u64, EntityPair)]| {
        messages.iter().filter(|(_, other)| *other == pair).count()
    };
    (count(&log.started), count(&log.ended))
}

/// The counters of the last tick.
pub fn counters(app: &App) -> bevy_octree::counters::TickCounters {
    app.world().resource::<CollisionCounters>().tick
}

/// The index of boxes.
pub fn index(app: &App) -> &SpatialIndex {
    app.world().resource::<CollisionIndex>().index()
}

/// A component of an entity.
pub fn get<C: Component>(app: &App, entity: Entity) -> &C {
    app.world()
        .get(entity)
        .expect("the entity has the component")
}

/// A component of an entity, to be changed.
pub fn get_mut<C: Component<Mutability = bevy::ecs::component::Mutable>>(
    app: &mut App,
    entity: Entity,
) -> Mut<'_, C> {
    app.world_mut()
        .get_mut(entity)
        .expect("the entity has the component")
}

/// The pairs in contact by the exact tests alone, over all pairs of entities with a shape; sorted.
pub fn brute_force_contacts(app: &mut App) -> Vec<EntityPair> {
    let world = app.world_mut();
    let shapes = world.query::<(Entity, &CollisionShape)>();
    let world = &*world;
    let placed: Vec<_> = shapes
        .iter_manual(world)
        .map(|(id, shape)| (id, shape, world_pose(world, id)))
        .collect();
    let tests = *world.resource::<NarrowPhase>();
    let mut workspace = Workspace::default();
    let mut pairs = Vec::new();
    for (place, (a, shape_a, pose_a)) in placed.iter().enumerate() {
        for (b, shape_b, pose_b) in &placed[place + 1..] {
            if tests.intersects(
                Placed::new(shape_a, pose_a),
                Placed::new(shape_b, pose_b),
                &mut workspace,
            ) {
                pairs.push(pair(*a, *b));
            }
        }
    }
    sorted(pairs)
}

fn world_pose(world: &World, entity: Entity) -> Transform {
    let local = world.get::<Transform>(entity).copied().unwrap_or_default();
    world
        .get::<ChildOf>(entity)
        .map_or(local, |parent| world_pose(world, parent.parent()) * local)
}

/// An octree beside that of the app, over the same boxes, with everything checked that is said to
/// hold.
pub struct Mirror {
    index: SpatialIndex,
    ids: HashMap<Entity, ProxyId>,
}

impl Mirror {
    pub fn new(settings: ObjectOctreeSettings) -> Self {
        let engine = Checked(ObjectOctree::new(settings));
        Self {
            index: SpatialIndex::with_engine(Box::new(engine)),
            ids: HashMap::new(),
        }
    }

    /// Takes up the boxes that the app's entities have now, checks the octree, and checks that it
    /// finds the same candidate pairs as the app.
    pub fn follow(&mut self, app: &mut App) {
        let world = app.world_mut();
        let mut boxes = world.query_filtered::<(Entity, &WorldAabb), With<CollisionShape>>();
        let mut gone = std::mem::take(&mut self.ids);
        for (entity, aabb) in boxes.iter(world) {
            let known = gone
                .get(&entity)
                .filter(|id| self.index.set(**id, aabb).is_ok())
                .copied();
            if let Some(id) = known.or_else(|| self.index.insert(aabb.0).ok()) {
                self.ids.insert(entity, id);
            }
            if known.is_some() {
                gone.remove(&entity);
            }
        }
        for id in gone.into_values() {
            self.index.remove(id);
        }
        self.index.update();
        let entities: HashMap<_, _> = self.ids.iter().map(|(entity, id)| (*id, *entity)).collect();
        let found = self
            .index
            .find_pairs()
            .iter()
            .map(|p| pair(entities[&p.a], entities[&p.b]))
            .collect();
        let collisions = world.resource::<CollisionIndex>();
        let expected = collisions
            .index()
            .pairs()
            .iter()
            .map(|p| collisions.entities(p))
            .map(|[a, b]| pair(a, b));
        assert_eq!(sorted(found), sorted(expected.collect()));
    }

    pub fn stats(&self) -> BroadPhaseStats {
        self.index.stats()
    }
}

/// The report's octree, checked after each maintenance step.
struct Checked(ObjectOctree);

impl BroadPhase for Checked {
    fn name(&self) -> &'static str {
        "checked octree"
    }

    fn maintain(&mut self, proxies: &Proxies) {
        self.0.maintain(proxies);
        self.0.assert_well_formed(proxies);
    }

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        self.0.find_pairs(proxies, pairs)
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        self.0.traverse(proxies, visitor);
    }

    fn stats(&self) -> BroadPhaseStats {
        self.0.stats()
    }
}
