//! Who is in the room, who comes, and what happens to them.

use bevy::prelude::*;
use bevy_ggrs::prelude::*;
use bevy_octree::{motion::Outside, prelude::*};

use crate::arena::{Armour, Bullet, Falling, Kind, Luck, NextNumber, Player};

collision_layers! {
    enum Layer { Solid, Ghost }
}

/// Half of the room, along each axis.
const ROOM: Vec3 = Vec3::new(8.0, 3.0, 8.0);
const REFLECT: Bounce = Bounce::Reflect { restitution: 1.0 };
/// How many there are of each kind, as long as nothing happens.
const POPULATION: [(Kind, usize); 7] = [
    (Kind::Ball, 24),
    (Kind::Crate, 8),
    (Kind::Fast, 8),
    (Kind::Ghost, 8),
    (Kind::Ship, 3),
    (Kind::Stone, 6),
    (Kind::Spark, 6),
];

/// What is there for good: in no snapshot.
pub fn build(mut commands: Commands, mut next: ResMut<NextNumber>) {
    let walls = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| {
        [1.0, -1.0].map(|side| {
            let center = axis * side * (ROOM + 0.5);
            (center, (ROOM * 2.0 + 2.0) * (Vec3::ONE - axis) + axis)
        })
    });
    // What is as thin as paper.
    let plates = [-4.0, 4.0].map(|x| (Vec3::new(x, -1.0, x), Vec3::new(0.01, 4.0, 4.0)));
    for (center, size) in walls.chain(plates) {
        let shape = CollisionShape::cuboid(size.x, size.y, size.z);
        let place = Transform::from_translation(center);
        commands.spawn((next.take(), shape, StaticShape, place));
    }
    // A ramp that is a mesh.
    let corners = [
        (2.0, -3.0, 2.0),
        (2.0, -3.0, 6.0),
        (6.0, -1.5, 6.0),
        (6.0, -1.5, 2.0),
    ];
    let ramp = PolygonMesh::new(corners.map(Vec3::from), [[0, 1, 2], [0, 2, 3]]).unwrap();
    commands.spawn((next.take(), CollisionShape::from(ramp), StaticShape));
    // What bullets and all others pass, and are told of.
    let zone = Transform::from_xyz(0.0, -1.0, 0.0);
    commands.spawn((next.take(), CollisionShape::sphere(2.5), Sensor, zone));
}

/// What is there at first.
pub fn populate(mut commands: Commands, mut next: ResMut<NextNumber>, mut luck: ResMut<Luck>) {
    for (handle, x) in [-2.0, 2.0].into_iter().enumerate() {
        let player = Player {
            handle,
            reload: 0,
            ahead: Vec3::NEG_Z,
        };
        let body = (
            CollisionShape::capsule(0.3, 0.8),
            KinematicCharacter::default(),
        );
        let place = Transform::from_xyz(x, -2.2, 5.0);
        commands.spawn((
            next.take(),
            Rollback,
            player,
            body,
            CharacterHits::default(),
            place,
        ));
    }
    for (z, ticks) in [(-6.0, 120), (-3.0, 75)] {
        let [left, right] = [-5.0, 5.0].map(|x| Vec3::new(x, -2.8, z));
        let track = [(0, left), (ticks, right), (2 * ticks, left)];
        let track = PositionTrack::new(track)
            .unwrap()
            .with_outside(Outside::Loop);
        let platform = (CollisionShape::cuboid(2.0, 0.2, 2.0), track.starting_now());
        commands.spawn((next.take(), Rollback, platform));
    }
    for (kind, count) in POPULATION {
        for _ in 0..count {
            spawn(&mut commands, kind, &mut next, &mut luck);
        }
    }
}

/// From time to time, who is missing comes anew.
pub fn respawn(
    mut commands: Commands,
    present: Query<&Kind>,
    mut next: ResMut<NextNumber>,
    mut luck: ResMut<Luck>,
) {
    if luck.0.u32(..20) > 0 {
        return;
    }
    for (kind, count) in POPULATION {
        let missing = count.saturating_sub(present.iter().filter(|other| **other == kind).count());
        for _ in 0..missing {
            spawn(&mut commands, kind, &mut next, &mut luck);
        }
    }
}

pub fn bullet(at: Vec3, ahead: Vec3, frame: i32) -> impl Bundle {
    (
        Bullet { until: frame + 40 },
        CollisionShape::sphere(0.05),
        Velocity(ahead * 90.0),
        Swept::stopping(),
        Transform::from_translation(at),
    )
}

fn within(luck: &mut Luck, half: Vec3) -> Vec3 {
    let mut share = || luck.0.f32().mul_add(2.0, -1.0);
    Vec3::new(share(), share(), share()) * half
}

fn spawn(commands: &mut Commands, kind: Kind, next: &mut NextNumber, luck: &mut Luck) {
    let place = Transform::from_translation(within(luck, ROOM - 1.0));
    let turn = Quat::from_scaled_axis(within(luck, Vec3::splat(3.0)));
    let way = within(luck, Vec3::ONE);
    let one = (next.take(), Rollback, kind, Armour(1 + luck.0.u32(..3)));
    match kind {
        Kind::Ball => {
            let ball = (CollisionShape::sphere(0.4), Velocity(way * 8.0), REFLECT);
            commands.spawn((one, ball, place));
        }
        Kind::Crate => {
            let body = (CollisionShape::cuboid(0.8, 0.6, 1.0), Velocity(way * 4.0));
            commands.spawn((one, body, Bounce::Reverse, place.with_rotation(turn)));
        }
        Kind::Fast => {
            let ball = (CollisionShape::sphere(0.2), Velocity(way * 60.0), REFLECT);
            commands.spawn((one, ball, Swept::default(), place));
        }
        Kind::Ghost => {
            let layers = CollisionLayers::new(Layer::Ghost, [Layer::Ghost]);
            let ball = (CollisionShape::sphere(0.6), Velocity(way * 6.0), REFLECT);
            commands.spawn((one, ball, layers, place));
        }
        Kind::Ship => {
            let body = (CollisionBody::default(), Velocity(way * 20.0), REFLECT);
            let ship = commands.spawn((one, body, Swept::default(), place)).id();
            for (z, length) in [(0.0, 1.2), (-0.5, 0.6), (0.5, 0.6)] {
                let part = CollisionShape::cuboid(length, 0.3, 0.4);
                let place = Transform::from_xyz(0.0, 0.0, z);
                commands.spawn((next.take(), Rollback, part, place, ChildOf(ship)));
            }
        }
        Kind::Stone => {
            let bounce = Bounce::Reflect { restitution: 0.3 };
            let ball = (CollisionShape::sphere(0.3), Velocity(way * 3.0), bounce);
            commands.spawn((one, ball, Swept::default(), Falling, place));
        }
        Kind::Spark => {
            let ball = (CollisionShape::sphere(0.3), Velocity(way * 30.0), REFLECT);
            commands.spawn((one, ball, Swept::default(), place));
        }
    }
}

/// One of those of which there are some, the same on all machines.
fn one_of<T: Ord + Copy>(
    all: impl Iterator<Item = (CollisionOrder, T)>,
    luck: &mut Luck,
) -> Option<T> {
    let mut all: Vec<_> = all.collect();
    all.sort();
    luck.0.choice(all).map(|(_, one)| one)
}

/// From time to time, something happens to somebody.
pub fn meddle(
    mut commands: Commands,
    kinds: Query<(Entity, &CollisionOrder, &Kind)>,
    parts: Query<(Entity, &CollisionOrder), With<ChildOf>>,
    mut luck: ResMut<Luck>,
) {
    let of_kind = |kind| {
        let all = kinds.iter().filter(move |(_, _, other)| **other == kind);
        all.map(|(entity, number, _)| (*number, entity))
    };
    match luck.0.u32(..64) {
        // A ghost becomes solid.
        0 => {
            if let Some(ghost) = one_of(of_kind(Kind::Ghost), &mut luck) {
                let layers = CollisionLayers::new(Layer::Solid, LayerMask::ALL);
                commands.entity(ghost).insert(layers);
            }
        }
        // Somebody grows.
        1 => {
            if let Some(ball) = one_of(of_kind(Kind::Ball), &mut luck) {
                let radius = luck.0.f32().mul_add(0.4, 0.2);
                commands.entity(ball).insert(CollisionShape::sphere(radius));
            }
        }
        // Somebody is elsewhere, without having passed what is between.
        2 => {
            if let Some(fast) = one_of(of_kind(Kind::Fast), &mut luck) {
                let place = Transform::from_translation(within(&mut luck, ROOM - 1.0));
                commands.entity(fast).insert((place, Swept::default()));
            }
        }
        // Somebody is looked at all along its way, or no longer.
        3 => {
            if let Some(ball) = one_of(of_kind(Kind::Ball), &mut luck) {
                commands.entity(ball).insert(Swept::default());
            }
        }
        4 => {
            if let Some(ball) = one_of(of_kind(Kind::Ball), &mut luck) {
                commands.entity(ball).remove::<Swept>();
            }
        }
        // A ship loses a part.
        5 => {
            let parts = parts.iter().map(|(entity, number)| (*number, entity));
            if let Some(part) = one_of(parts, &mut luck) {
                commands.entity(part).despawn_rollback();
            }
        }
        // A ship is gone, with all of its parts.
        6 => {
            if let Some(ship) = one_of(of_kind(Kind::Ship), &mut luck) {
                commands.entity(ship).despawn_rollback();
            }
        }
        _ => {}
    }
}
