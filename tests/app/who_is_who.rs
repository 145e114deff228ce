//! Who of the two in a contact is who.

use bevy::{ecs::system::RunSystemOnce, prelude::*};
use bevy_octree::{contacts::Collision, narrow_phase::Contact, prelude::*};

use crate::common::*;

#[derive(Component)]
struct Player;

#[derive(Component)]
struct Coin;

/// A player, a coin, and a wall.
fn three(world: &mut World) -> [Entity; 3] {
    let player = world.spawn(Player).id();
    let coin = world.spawn(Coin).id();
    [player, coin, world.spawn_empty().id()]
}

fn collision(a: Entity, b: Entity) -> Collision {
    Collision {
        a,
        b,
        bodies: [a, b],
        contact: Some(Contact {
            normal: Vec3::X,
            point: Vec3::ZERO,
            depth: 1.0,
        }),
        layers: [CollisionLayers::NONE, CollisionLayers::ALL],
        time: 0.5,
    }
}

#[test]
fn the_two_are_told_apart_in_whatever_order_they_come() {
    let mut world = World::new();
    let [player, coin, wall] = three(&mut world);
    let gone = world.spawn((Player, Coin)).id();
    world.despawn(gone);
    let both = world.spawn((Player, Coin)).id();
    let look = move |players: Query<(), With<Player>>, coins: Query<&Coin>| {
        for (a, b, of_players, match_of_both) in [
            (player, coin, Some((player, coin)), Some((player, coin))),
            (coin, player, Some((player, coin)), Some((player, coin))),
            (player, wall, Some((player, wall)), None),
            (wall, player, Some((player, wall)), None),
            (wall, coin, None, None),
            (gone, coin, None, None),
            (gone, player, Some((player, gone)), None),
            (player, both, Some((player, both)), Some((player, both))),
            (both, player, Some((both, player)), Some((player, both))),
            (coin, both, Some((both, coin)), Some((both, coin))),
        ] {
            let collision = collision(a, b);
            let [started, ended] = [
                CollisionStarted::from(collision),
                CollisionStarted::from(collision).reversed(),
            ];
            assert_eq!(collision.of(&players), of_players);
            assert_eq!(started.of(&players), of_players);
            assert_eq!(CollisionEnded::from(collision).of(&players), of_players);
            assert_eq!(collision.between(&players, &coins), match_of_both);
            assert_eq!(started.between(&players, &coins), match_of_both);
            let turned = match_of_both.map(|(player, coin)| (coin, player));
            let back = started.between(&coins, &players);
            if a != both && b != both {
                assert_eq!(back, turned);
                assert_eq!(ended.of(&players), of_players);
            }
            for entity in [player, coin, wall] {
                let is_one = entity == a || entity == b;
                assert_eq!(collision.involves(entity), is_one);
                assert_eq!(started.involves(entity), is_one);
                assert_eq!(started.other(entity).is_some(), is_one);
                let seen = started.seen_by(entity);
                assert_eq!(seen.map(|seen| seen.a), is_one.then_some(entity));
                assert_eq!(seen.map(|seen| seen.b), started.other(entity));
                if let Some(seen) = seen {
                    let outwards = if entity == a { 1.0 } else { -1.0 };
                    assert_eq!(seen.contact.unwrap().normal.x, outwards);
                    assert_eq!(seen.layers == started.layers, entity == a);
                    assert_eq!(seen.time, 0.5);
                }
            }
        }
    };
    world.run_system_once(look).unwrap();
}

/// A coin is collected once, by whoever is first; what ends is told as what starts.
#[test]
fn a_player_collects_coins() {
    #[derive(Resource, Default)]
    struct Purse(Vec<Entity>, Vec<Entity>);
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Purse>().add_systems(
        FixedPostUpdate,
        (|mut started: MessageReader<CollisionStarted>,
          mut ended: MessageReader<CollisionEnded>,
          players: Query<(), With<Player>>,
          coins: Query<(), With<Coin>>,
          mut purse: ResMut<Purse>,
          mut commands: Commands| {
            for message in ended.read() {
                // The coin may be gone by now.
                let left = message.of(&players).map(|(_, other)| other);
                purse.1.extend(left);
            }
            for message in started.read() {
                if let Some((_, coin)) = message.between(&players, &coins) {
                    purse.0.push(coin);
                    commands.entity(coin).try_despawn();
                }
            }
        })
        .after(CollisionSystems::Report),
    );
    let mut spawn = |x: f32| {
        let coin = (Coin, Sensor, CollisionShape::sphere(0.25));
        let at = Transform::from_xyz(x, 0.0, 0.0);
        app.world_mut().spawn((coin, at)).id()
    };
    let coins = [2.0, 4.0, 6.0].map(&mut spawn);
    let wall = (
        CollisionShape::default(),
        Transform::from_xyz(3.0, 0.0, 0.0),
    );
    let wall = app.world_mut().spawn(wall).id();
    let player = (
        Player,
        CollisionShape::sphere(0.5),
        Velocity(Vec3::X * 0.5 * TICKS_PER_SECOND),
    );
    app.world_mut().spawn((player, Transform::default()));
    tick(&mut app, 24);
    let Purse(collected, left) = app.world().resource();
    assert_eq!(collected[..], coins);
    let mut expected = vec![coins[0], wall, coins[1], coins[2]];
    let mut left = left.clone();
    left.sort();
    expected.sort();
    assert_eq!(left, expected);
}
