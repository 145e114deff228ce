//! What is known of a frame, and whether it is the same whenever that frame is simulated.

use std::{
    collections::BTreeMap,
    hash::{Hash, Hasher},
};

use bevy::{ecs::entity::EntityHashMap, prelude::*, transform::TransformSystems};
use bevy_ggrs::{
    ChecksumPart, GgrsSchedule, RollbackDespawned, RollbackFrameCount, SaveWorld, SaveWorldSystems,
    checksum_hasher,
};
use bevy_octree::{motion::CollisionClock, prelude::*};

use crate::arena::Armour;

/// What is said of somebody, in a form in which it can be compared.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Line {
    pub what: &'static str,
    /// Who they are, by their numbers.
    pub who: [u64; 2],
    pub bits: Vec<u32>,
}

/// Which lines count.
#[derive(Resource, Clone, Debug)]
pub struct Counted(pub &'static [&'static str]);

/// All frames, as they were when they were last simulated.
#[derive(Resource, Clone, Debug, Default)]
pub struct Stories {
    pub of_frame: BTreeMap<i32, Vec<Line>>,
    /// How many frames were told, those that were simulated again counted again.
    pub told: u64,
    /// How often a frame was not as it had been.
    pub differences: u64,
    /// The first of these, in words.
    pub first: Option<String>,
    /// How many lines there were, by what they are about.
    pub lines: BTreeMap<&'static str, u64>,
}

/// Marks the checksum of the story.
#[derive(Component)]
struct OfStory;

/// What was told by messages in this tick.
#[derive(Resource, Debug, Default)]
struct Told(Vec<Line>);

pub struct StoryPlugin;

impl Plugin for StoryPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Stories>()
            .init_resource::<Told>()
            .init_resource::<Numbers>()
            .add_observer(note_number)
            .add_systems(
                GgrsSchedule,
                listen
                    .after(CollisionSystems::Last)
                    .before(TransformSystems::Propagate),
            )
            .add_systems(SaveWorld, tell.in_set(SaveWorldSystems::Checksum));
        app.world_mut().spawn((OfStory, ChecksumPart::default()));
    }
}

/// The numbers of all that have ever been there: who is gone is still talked about.
#[derive(Resource, Debug, Default)]
struct Numbers(EntityHashMap<u64>);

fn note_number(
    insert: On<Insert, CollisionOrder>,
    orders: Query<&CollisionOrder, Allow<RollbackDespawned>>,
    mut numbers: ResMut<Numbers>,
) {
    if let Ok(order) = orders.get(insert.entity) {
        numbers.0.insert(insert.entity, order.0);
    }
}

fn numbers_of(numbers: &Numbers, both: [Entity; 2]) -> [u64; 2] {
    both.map(|entity| numbers.0.get(&entity).copied().unwrap_or(u64::MAX))
}

/// Listens to all that is told in a tick.
fn listen(
    mut started: MessageReader<CollisionStarted>,
    mut ended: MessageReader<CollisionEnded>,
    mut bodies_started: MessageReader<BodyCollisionStarted>,
    mut bodies_ended: MessageReader<BodyCollisionEnded>,
    numbers: Res<Numbers>,
    mut told: ResMut<Told>,
) {
    let line = |what, both| Line {
        what,
        who: numbers_of(&numbers, both),
        bits: Vec::new(),
    };
    told.0.clear();
    let started = started
        .read()
        .map(|start| line("started", [start.a, start.b]));
    told.0.extend(started);
    let ended = ended.read().map(|end| line("ended", [end.a, end.b]));
    told.0.extend(ended);
    let bodies = bodies_started.read();
    told.0
        .extend(bodies.map(|start| line("bodies started", [start.a, start.b])));
    let bodies = bodies_ended.read();
    told.0
        .extend(bodies.map(|end| line("bodies ended", [end.a, end.b])));
}

type Teller<'a> = (
    &'a CollisionOrder,
    &'a Transform,
    Option<&'a Velocity>,
    Option<&'a Armour>,
    Option<&'a KinematicCharacter>,
    Option<&'a CharacterHits>,
);

fn bits<const N: usize>(numbers: [f32; N]) -> impl Iterator<Item = u32> {
    numbers.into_iter().map(f32::to_bits)
}

fn tell(
    entities: Query<Teller>,
    (contacts, clock): (Res<Contacts>, Res<CollisionClock>),
    (numbers, told, counted): (Res<Numbers>, Res<Told>, Res<Counted>),
    frame: Res<RollbackFrameCount>,
    mut stories: ResMut<Stories>,
    mut checksum: Single<&mut ChecksumPart, With<OfStory>>,
) {
    let mut story = Vec::new();
    for (number, place, velocity, armour, character, hits) in &entities {
        let mut line = |what, other, bits: Vec<u32>| {
            let who = [number.0, other];
            story.push(Line { what, who, bits });
        };
        let mut at: Vec<_> = bits(place.translation.to_array()).collect();
        at.extend(bits(place.rotation.to_array()));
        line("place", 0, at);
        if let Some(velocity) = velocity {
            line("velocity", 0, bits(velocity.to_array()).collect());
        }
        if let Some(armour) = armour {
            line("armour", 0, vec![armour.0]);
        }
        if let Some(character) = character {
            let ground = character.ground;
            let ground = ground.map_or(0, |ground| numbers_of(&numbers, [ground.entity; 2])[0]);
            line(
                "character",
                ground,
                bits(character.velocity.to_array()).collect(),
            );
        }
        for hit in hits.into_iter().flat_map(|hits| hits.iter()) {
            let [other, _] = numbers_of(&numbers, [hit.entity; 2]);
            line("hit", other, bits(hit.point.to_array()).collect());
        }
    }
    // Queries have no order that would be the same everywhere; what is met by one, and all that
    // follows, has.
    story.sort_by_key(|line| (line.who[0], line.what));
    for collision in contacts.iter() {
        let who = numbers_of(&numbers, [collision.a, collision.b]);
        let contact = collision.contact.map(|contact| contact.normal.to_array());
        let bits = bits([collision.time]).chain(bits(contact.unwrap_or_default()));
        story.push(Line {
            what: "contact",
            who,
            bits: bits.collect(),
        });
    }
    story.extend(told.0.iter().cloned());
    story.push(Line {
        what: "clock",
        who: [clock.tick(), 0],
        bits: Vec::new(),
    });
    story.retain(|line| counted.0.contains(&line.what));

    let mut hasher = checksum_hasher();
    story.hash(&mut hasher);
    checksum.0 = u128::from(hasher.finish());

    let stories = &mut *stories;
    stories.told += 1;
    for line in &story {
        *stories.lines.entry(line.what).or_default() += 1;
    }
    if let Some(before) = stories.of_frame.insert(frame.0, story) {
        let now = &stories.of_frame[&frame.0];
        if before != *now {
            stories.differences += 1;
            if stories.first.is_none() {
                stories.first = Some(difference(frame.0, &before, now));
            }
        }
    }
}

/// What tells two stories of a frame apart, in words.
pub fn difference(frame: i32, before: &[Line], now: &[Line]) -> String {
    let [mut a, mut b] = [before, now].map(<[Line]>::to_vec);
    a.sort();
    b.sort();
    if a == b {
        let (a, b) = before
            .iter()
            .zip(now)
            .find(|(a, b)| a != b)
            .expect("they differ");
        return format!("frame {frame}: the same in another order: {a:?}, then {b:?}");
    }
    let missing = a.iter().filter(|line| b.binary_search(line).is_err());
    let added = b.iter().filter(|line| a.binary_search(line).is_err());
    let missing: Vec<_> = missing.take(8).collect();
    let added: Vec<_> = added.take(8).collect();
    format!("frame {frame}: only before {missing:#?}, only now {added:#?}")
}
