//! A room in which all that this crate does goes on at once, played by two.

use bevy::{platform::collections::HashMap, prelude::*};
use bevy_ggrs::prelude::*;
use bevy_ggrs::{LocalInputs, LocalPlayers, RollbackFrameCount};
use bevy_octree::{
    prelude::*,
    rollback::{CollisionSnapshot, RestoreSystems, RollbackPlugin},
};
use fastrand::Rng;
use serde::{Deserialize, Serialize};

use crate::{spawning, story};

pub type Game = GgrsConfig<Keys, usize>;

/// What a player holds down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Keys(u8);

impl Keys {
    const LEFT: u8 = 1;
    const RIGHT: u8 = 2;
    const AHEAD: u8 = 4;
    const BACK: u8 = 8;
    const JUMP: u8 = 16;
    const FIRE: u8 = 32;

    /// What a player holds down in a frame: for some frames the same, then something else.
    fn of(player: usize, frame: i32) -> Self {
        let held = (frame + 4 * player as i32) / 9;
        let seed = (player as u64 + 1) << 32 | u64::from(held.unsigned_abs());
        Self(Rng::with_seed(seed).u8(..))
    }

    const fn has(self, key: u8) -> bool {
        self.0 & key != 0
    }

    /// Which of two keys is down: 1, -1, or 0 for none and both.
    fn axis(self, more: u8, less: u8) -> f32 {
        f32::from(self.has(more)) - f32::from(self.has(less))
    }
}

/// The number of what is spawned next.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct NextNumber(pub u64);

impl NextNumber {
    pub const fn take(&mut self) -> CollisionOrder {
        self.0 += 1;
        CollisionOrder(self.0)
    }
}

/// All chance of the game.
#[derive(Resource, Clone, Debug)]
pub struct Luck(pub Rng);

/// What a player steers.
#[derive(Component, Clone, Copy, Debug)]
pub struct Player {
    pub handle: usize,
    /// How many frames it takes until it can fire again.
    pub reload: u32,
    /// Where it looks.
    pub ahead: Vec3,
}

/// What ends by itself in that frame, unless it hits something earlier.
#[derive(Component, Clone, Copy, Debug)]
pub struct Bullet {
    pub until: i32,
}

/// What is gone after some hits, and how many are left.
#[derive(Component, Clone, Copy, Debug)]
pub struct Armour(pub u32);

/// What falls.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Falling;

/// What there is to be of the inhabitants of the room.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Ball,
    Crate,
    Fast,
    Ghost,
    Ship,
    Stone,
    Spark,
}

/// The room with all that is in it, in the schedule of `bevy_ggrs`.
pub struct ArenaPlugin;

impl Plugin for ArenaPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(NextNumber::default())
            .insert_resource(Luck(Rng::with_seed(19)))
            .insert_resource(CollisionEventSettings {
                geometry: EventScope::All,
                ..default()
            })
            .add_plugins((
                OctreePlugins::new(GgrsSchedule),
                RollbackPlugin,
                story::StoryPlugin,
            ))
            .add_systems(Startup, (spawning::build, spawning::populate).chain())
            .add_systems(ReadInputs, read_keys)
            .add_systems(
                GgrsSchedule,
                (steer, fall, spawning::respawn, spawning::meddle)
                    .chain()
                    .after(RestoreSystems)
                    .before(CollisionSystems::First),
            )
            .add_systems(
                GgrsSchedule,
                (hit, end_bullets).chain().in_set(CollisionSystems::Last),
            );
        roll_back(app);
    }
}

/// All that is part of the state of the game.
fn roll_back(app: &mut App) {
    // What this crate has of an entity.
    app.rollback_component_with_clone::<Transform>()
        .rollback_component_with_clone::<CollisionShape>()
        .rollback_component_with_clone::<Velocity>()
        .rollback_component_with_clone::<Bounce>()
        .rollback_component_with_clone::<Swept>()
        .rollback_component_with_clone::<CollisionLayers>()
        .rollback_immutable_component_with_clone::<CollisionBody>()
        .rollback_component_with_clone::<KinematicCharacter>()
        .update_component_with_map_entities::<KinematicCharacter>()
        .rollback_component_with_clone::<CharacterHits>()
        .update_component_with_map_entities::<CharacterHits>()
        .rollback_component_with_clone::<PositionTrack>()
        .rollback_resource_with_clone::<CollisionSnapshot>()
        .update_resource_with_map_entities::<CollisionSnapshot>();
    // What the game has.
    app.rollback_immutable_component_with_copy::<CollisionOrder>()
        .rollback_component_with_copy::<Player>()
        .rollback_component_with_copy::<Bullet>()
        .rollback_component_with_copy::<Armour>()
        .rollback_component_with_copy::<Falling>()
        .rollback_component_with_copy::<Kind>()
        .rollback_resource_with_copy::<NextNumber>()
        .rollback_resource_with_clone::<Luck>();
}

fn read_keys(mut commands: Commands, frame: Res<RollbackFrameCount>, players: Res<LocalPlayers>) {
    let keys = players
        .0
        .iter()
        .map(|player| (*player, Keys::of(*player, frame.0)));
    commands.insert_resource(LocalInputs::<Game>(keys.collect::<HashMap<_, _>>()));
}

fn steer(
    mut commands: Commands,
    mut players: Query<(
        &CollisionOrder,
        &mut Player,
        &mut KinematicCharacter,
        &Transform,
    )>,
    keys: Res<PlayerInputs<Game>>,
    frame: Res<RollbackFrameCount>,
    time: Res<Time>,
    mut next: ResMut<NextNumber>,
) {
    for (_, mut player, mut character, place) in players.iter_mut().sort::<&CollisionOrder>() {
        let (keys, _) = keys[player.handle];
        let way = Vec3::new(
            keys.axis(Keys::RIGHT, Keys::LEFT),
            0.0,
            keys.axis(Keys::BACK, Keys::AHEAD),
        );
        let rise = match character.velocity.y {
            _ if character.is_on_ground() && keys.has(Keys::JUMP) => 6.0,
            rise => rise - 9.8 * time.delta_secs(),
        };
        character.velocity = way * 5.0 + Vec3::Y * rise;
        player.ahead = way.try_normalize().unwrap_or(player.ahead);
        player.reload = player.reload.saturating_sub(1);
        if keys.has(Keys::FIRE) && player.reload == 0 {
            player.reload = 5;
            let muzzle = place.translation + player.ahead * 0.6;
            let bullet = spawning::bullet(muzzle, player.ahead, frame.0);
            commands.spawn((next.take(), Rollback, bullet));
        }
    }
}

fn fall(mut falling: Query<&mut Velocity, With<Falling>>, time: Res<Time>) {
    for mut velocity in &mut falling {
        velocity.y -= 9.8 * time.delta_secs();
    }
}

/// Bullets are gone by their first hit, and what they hit has less armour by it.
fn hit(
    mut commands: Commands,
    contacts: Res<Contacts>,
    bullets: Query<(), With<Bullet>>,
    sensors: Query<(), With<Sensor>>,
    mut targets: Query<(Entity, &mut Armour, &Kind)>,
) {
    let mut spent = Vec::new();
    for collision in contacts.iter() {
        let solid = !sensors.contains(collision.a) && !sensors.contains(collision.b);
        for (bullet, body) in [
            (collision.a, collision.bodies[1]),
            (collision.b, collision.bodies[0]),
        ] {
            if !solid || !bullets.contains(bullet) {
                continue;
            }
            if !spent.contains(&bullet) {
                spent.push(bullet);
                commands.entity(bullet).despawn_rollback();
            }
            if let Ok((target, mut armour, kind)) = targets.get_mut(body)
                && armour.0 > 0
            {
                armour.0 -= 1;
                match (armour.0, kind) {
                    // Sparks are what the game forgot to despawn in the way of `bevy_ggrs`: they
                    // are spawned anew when a frame is restored in which they were there.
                    (0, Kind::Spark) => commands.entity(target).despawn(),
                    (0, _) => commands.entity(target).despawn_rollback(),
                    _ => {}
                }
            }
        }
    }
}

fn end_bullets(
    mut commands: Commands,
    bullets: Query<(Entity, &Bullet)>,
    frame: Res<RollbackFrameCount>,
) {
    for (entity, bullet) in &bullets {
        if bullet.until <= frame.0 {
            commands.entity(entity).despawn_rollback();
        }
    }
}
