//! Ways of swept entities that are put back go on where they began, also of who was spawned or marked again.

use bevy::{
    ecs::entity::{EntityHashMap, MapEntities},
    prelude::*,
};
use bevy_octree::{
    prelude::*,
    rollback::{CollisionSnapshot, RollbackPlugin},
};

use crate::{common::tick, order::plain_app};

/// What a ship does whose wing meets walls, to the last bit.
type State = (Transform, Velocity);

fn state(app: &App, ship: Entity) -> State {
    let world = app.world();
    let of = |entity| world.entity(entity);
    (
        *of(ship).get::<Transform>().unwrap(),
        *of(ship).get::<Velocity>().unwrap(),
    )
}

fn walls_and_ship(number: u64) -> (App, Entity) {
    let mut app = plain_app(Default::default());
    app.add_plugins(RollbackPlugin);
    for (order, x) in [(1, -10.0), (2, 10.0)] {
        let wall = CollisionShape::cuboid(1.0, 4.0, 4.0);
        let at = Transform::from_xyz(x, 0.0, 0.0);
        app.world_mut()
            .spawn((wall, StaticShape, CollisionOrder(order), at));
    }
    let moves = (
        Transform::from_xyz(-3.0, 0.0, 0.0),
        Velocity(Vec3::new(61.0, 0.0, 0.07)),
    );
    let ship = ship(app.world_mut(), number, moves);
    (app, ship)
}

fn ship(world: &mut World, number: u64, moves: State) -> Entity {
    let bounce = Bounce::Reflect { restitution: 1.0 };
    let marks = (CollisionBody::default(), Swept::default(), bounce);
    let ship = world.spawn((marks, CollisionOrder(number), moves)).id();
    let at = Transform::from_xyz(0.9, 0.0, 0.2).with_rotation(Quat::from_rotation_y(0.9));
    let wing = CollisionShape::cuboid(1.0, 0.5, 0.4);
    world.spawn((wing, CollisionOrder(number + 1), ChildOf(ship), at));
    ship
}

fn by_number(app: &mut App) -> Vec<(u64, Entity)> {
    let mut all = app.world_mut().query::<(&CollisionOrder, Entity)>();
    let mut all: Vec<_> = all
        .iter(app.world())
        .map(|(order, entity)| (order.0, entity))
        .collect();
    all.sort_unstable();
    all
}

/// Goes back by a tick, again and again, and simulates it again.
fn go_back(mut put_back: impl FnMut(&mut World, Entity, State) -> Entity) {
    let (mut app, mut entity) = walls_and_ship(3);
    let snapshot = |app: &App| app.world().resource::<CollisionSnapshot>().clone();
    let mut hits = 0;
    for number in 0..400 {
        let (before, mut saved) = (state(&app, entity), snapshot(&app));
        tick(&mut app, 1);
        let (there, mut straight) = (state(&app, entity), snapshot(&app));
        let names = by_number(&mut app);
        entity = put_back(app.world_mut(), entity, before);
        let again = by_number(&mut app);
        let mut renamed: EntityHashMap<Entity> = names
            .iter()
            .zip(&again)
            .map(|((_, before), (_, after))| (*before, *after))
            .collect();
        saved.map_entities(&mut renamed);
        straight.map_entities(&mut renamed);
        app.insert_resource(saved);
        tick(&mut app, 1);
        assert_eq!(state(&app, entity), there, "tick {number}");
        assert_eq!(snapshot(&app), straight, "tick {number}");
        hits += usize::from(before.1 != there.1);
    }
    assert!(hits > 10, "{hits}");
}

#[test]
fn in_place() {
    go_back(|world, ship, moves| {
        world.entity_mut(ship).insert(moves);
        ship
    });
}

#[test]
fn swept_anew() {
    go_back(|world, ship, moves| {
        world.entity_mut(ship).insert((moves, Swept::default()));
        ship
    });
}

#[test]
fn spawned_again() {
    go_back(|world, ship, moves| {
        world.despawn(ship);
        self::ship(world, 3, moves)
    });
}
