//! An app to which all of it happens, and what is checked after each tick.

use std::{collections::HashSet, ops::Add};

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};
use bevy_octree::{
    collision_index::CollisionIndex,
    diagnostics::STAGES,
    motion::{MotionSettings, Step as TickLength},
    prelude::*,
};

use super::{
    apply::{Acted, Worlds, apply},
    ops::{Op, Step},
    oracle::{self, Expected},
};
use crate::common::{SETS, contacts, counters, index, interrupted, pair};

/// Disables, as `Disabled` does.
#[derive(Component, Clone, Default)]
pub struct Parked;

/// All entities that were spawned, and are there.
#[derive(Resource, Default)]
pub struct Slots(pub Vec<Entity>);

/// Marks what was spawned.
#[derive(Component, Clone, Default)]
#[component(on_add = enlist, on_remove = strike_off)]
pub struct Mine;

fn enlist(mut world: DeferredWorld, context: HookContext) {
    world.resource_mut::<Slots>().0.push(context.entity);
}

fn strike_off(mut world: DeferredWorld, context: HookContext) {
    world
        .resource_mut::<Slots>()
        .0
        .retain(|entity| *entity != context.entity);
}

/// What happens in the middle of the next tick, before the set of this number.
#[derive(Resource, Default)]
struct Sabotage(Option<(usize, Op)>);

/// Who was told of whom, and not yet of the end: by observers.
#[derive(Resource, Default)]
struct Observed(HashSet<[Entity; 2]>);

/// How much was looked at, so that nobody takes silence for an answer.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Seen {
    pub ticks: usize,
    pub contacts: usize,
    pub events: usize,
    pub answers: usize,
}

impl Add for Seen {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            ticks: self.ticks + other.ticks,
            contacts: self.contacts + other.contacts,
            events: self.events + other.events,
            answers: self.answers + other.answers,
        }
    }
}

pub struct Machine {
    app: App,
    /// Was it changed who messages are for, since the last whole tick? That is told by the next.
    is_rescoped: bool,
}

impl Machine {
    pub fn new() -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
            .insert_resource(MotionSettings {
                step: TickLength::Seconds(1.0 / 64.0),
            })
            .init_resource::<Slots>()
            .init_resource::<Sabotage>()
            .init_resource::<Observed>()
            .init_resource::<Acted>()
            .init_resource::<Seen>()
            .init_resource::<Expected>();
        app.world_mut().register_disabling_component::<Parked>();
        interrupted::let_sets_be_skipped(&mut app);
        let worlds = [(); 2].map(|()| app.world_mut().spawn_empty().id());
        app.insert_resource(Worlds(worlds));
        for (gap, set) in SETS.into_iter().enumerate() {
            let strike = move |world: &mut World| {
                let sabotage = &mut world.resource_mut::<Sabotage>().0;
                if let Some((_, op)) = sabotage.take_if(|(place, _)| *place == gap) {
                    apply(world, &op);
                }
            };
            let strike = strike.before(set);
            match gap.checked_sub(1) {
                Some(last) => app.add_systems(Update, strike.after(SETS[last])),
                None => app.add_systems(Update, strike),
            };
        }
        let last = oracle::look
            .after(CollisionSystems::Response)
            .before(CollisionSystems::Report);
        app.add_systems(Update, last);
        app.add_observer(
            |event: On<CollisionStarted>, mut seen: ResMut<Observed>, mut all: ResMut<Seen>| {
                let pair = [event.a, event.b];
                all.events += 1;
                assert!(
                    seen.0.insert(pair),
                    "{pair:?} started twice, observers are told"
                );
                assert!(event.contact.is_some());
            },
        );
        app.add_observer(|event: On<CollisionEnded>, mut seen: ResMut<Observed>| {
            let pair = [event.a, event.b];
            assert!(
                seen.0.remove(&pair),
                "{pair:?} ended and had not started, observers are told"
            );
        });
        Self {
            app,
            is_rescoped: false,
        }
    }

    pub fn step(&mut self, step: &Step) {
        if let Step::Do(Op::Messages(_)) | Step::TickWith(_, Op::Messages(_)) = step {
            self.is_rescoped = true;
        }
        match step {
            Step::Do(op) => apply(self.app.world_mut(), op),
            Step::Tick => {
                self.tick(&[]);
                self.check();
                let count = contacts(&self.app).len();
                let mut seen = self.app.world_mut().resource_mut::<Seen>();
                seen.contacts += count;
                seen.ticks += 1;
            }
            Step::TickWithout(bits) => {
                let number = |(place, set): (usize, CollisionSystems)| {
                    (bits >> place & 1 == 1).then_some(set)
                };
                let skipped: Vec<_> = STAGES.into_iter().enumerate().filter_map(number).collect();
                self.tick(&skipped);
            }
            Step::TickWith(gap, op) => {
                let sabotage = Sabotage(Some((usize::from(*gap), op.clone())));
                self.app.insert_resource(sabotage);
                // Who messages are for may change after they were written.
                self.run(&[]);
            }
        }
    }

    fn run(&mut self, skipped: &[CollisionSystems]) {
        interrupted::skip(&mut self.app, skipped);
        self.app.insert_resource(Acted(false));
        self.app.update();
    }

    fn tick(&mut self, skipped: &[CollisionSystems]) {
        self.run(skipped);
        // Neither list may hold what is in no contact, however little was done in the tick.
        self.is_rescoped &= !skipped.is_empty();
        if !skipped.contains(&CollisionSystems::Report) && !self.is_rescoped {
            self.check_told();
        }
    }

    /// What was told is what is in contact, by messages.
    fn check_told(&self) {
        let world = self.app.world();
        let scope = world.resource::<CollisionEventSettings>().messages;
        if scope == EventScope::All {
            assert_eq!(interrupted::told(&self.app), contacts(&self.app));
        }
    }

    /// What a whole tick has come to, which nothing interfered with.
    fn check(&mut self) {
        let world = self.app.world();
        let expected = world.resource::<Expected>();
        let all = world.resource::<Contacts>();
        let found: HashSet<_> = all
            .iter()
            .map(|contact| pair(contact.a, contact.b))
            .collect();
        assert_eq!(found.len(), all.len(), "each pair once");
        if let Some(pair) = expected.must.difference(&found).next() {
            panic!("{pair:?} is not in contact");
        }
        if let Some(pair) = found.difference(&expected.may).next() {
            panic!("{pair:?} is in contact");
        }
        let mut open = HashSet::new();
        let mut told = HashSet::new();
        for contact in all.iter() {
            let hears = contact.hears();
            let ends = [contact.a, contact.b];
            for (side, own) in ends.into_iter().enumerate() {
                if hears[side] && expected.enabled.contains(&own) {
                    open.insert([own, ends[1 - side]]);
                    told.insert(pair(contact.a, contact.b));
                }
            }
        }
        assert_eq!(
            world.resource::<Observed>().0,
            open,
            "observers were told of what is"
        );
        if world.resource::<CollisionEventSettings>().messages == EventScope::Enabled {
            let found: HashSet<_> = interrupted::told(&self.app).into_iter().collect();
            assert_eq!(found, told, "messages told of what somebody asked for");
        }
        assert_eq!(counters(&self.app).contacts as usize, all.len());
        if world.resource::<Acted>().0 {
            return;
        }
        self.check_lists();
        let found: HashSet<_> = {
            let collisions = world.resource::<CollisionIndex>();
            let ids = index(&self.app).proxies().iter();
            ids.map(|(id, _)| collisions.entity(id).unwrap()).collect()
        };
        assert_eq!(found, expected.part, "who is in the index");
    }

    fn check_lists(&self) {
        let world = self.app.world();
        let all = world.resource::<Contacts>();
        for entity in &world.resource::<Slots>().0 {
            for other in &world.resource::<Slots>().0 {
                let is_there = all.between(*entity, *other).is_some();
                assert_eq!(is_there, all.contains(*other, *entity));
                if is_there {
                    let contact = all.between(*entity, *other).unwrap();
                    let hears = oracle::hears(world, *entity, *other);
                    assert_eq!(Some(contact.hears()), hears, "{entity} {other}");
                }
            }
            let Some(list) = world.get::<CollidingEntities>(*entity) else {
                continue;
            };
            let is_body = world.get::<CollisionBody>(*entity).is_some();
            let expected: HashSet<Entity> = if oracle::is_disabled(world, *entity) {
                HashSet::new()
            } else if is_body {
                let bodies = all.iter().flat_map(|contact| {
                    let ([a, b], hears) = (contact.bodies, contact.hears());
                    let one = (a == *entity && a != b && hears[0]).then_some(b);
                    let other = (b == *entity && a != b && hears[1]).then_some(a);
                    one.into_iter().chain(other)
                });
                bodies.collect()
            } else {
                all.of(*entity).map(|contact| contact.b).collect()
            };
            assert_eq!(
                list.iter().copied().collect::<HashSet<_>>(),
                expected,
                "list of {entity}"
            );
        }
    }

    /// Everything goes, and nothing is left of it.
    pub fn end(&mut self) -> Seen {
        self.app
            .world_mut()
            .resource_mut::<CollisionEventSettings>()
            .messages = EventScope::All;
        self.tick(&[]);
        self.check();
        apply(self.app.world_mut(), &Op::Clear);
        // What the last ends bring about may spawn: nothing is left of that either.
        for _ in 0..3 {
            self.tick(&[]);
            apply(self.app.world_mut(), &Op::Clear);
        }
        self.tick(&[]);
        self.check();
        assert!(contacts(&self.app).is_empty());
        assert!(interrupted::told(&self.app).is_empty());
        assert!(self.app.world().resource::<Observed>().0.is_empty());
        assert_eq!(index(&self.app).proxies().len(), 0);
        *self.app.world().resource::<Seen>()
    }
}
