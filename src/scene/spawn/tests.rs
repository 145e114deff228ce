use bevy::ecs::world::CommandQueue;

use super::*;
use crate::{
    motion::PositionTrack,
    narrow_phase::Shape,
    scene::{ShapeDescription, TestSet},
};

fn spawn(scene: &SceneDescription) -> (World, Result<Vec<Entity>, SceneError>) {
    let mut world = World::new();
    let mut queue = CommandQueue::default();
    let entities = scene.spawn(&mut Commands::new(&mut queue, &world));
    queue.apply(&mut world);
    (world, entities)
}

#[test]
fn each_motion_gets_its_component() {
    let shape = ShapeDescription::Sphere { radius: 2.0 };
    let ball = ObjectDescription::new(shape);
    let track = PositionTrack::new([(0, Vec3::ONE), (9, Vec3::ZERO)]).unwrap();
    let motions = [
        Motion::Static,
        Motion::Velocity(Vec3::X),
        Motion::Track(track.clone()),
    ];
    let objects = motions.map(|motion| ObjectDescription {
        motion,
        ..ball.clone()
    });
    let (world, entities) = spawn(&SceneDescription::new("motions", objects));
    let [still, mover, tracked] = entities.unwrap()[..] else {
        panic!("three objects make three entities");
    };
    for entity in [still, mover, tracked] {
        let shape = &world.get::<CollisionShape>(entity).unwrap().0;
        assert!(matches!(shape, Shape::Sphere { radius: 2.0 }), "{shape:?}");
    }
    assert_eq!(world.get::<Name>(mover).unwrap().as_str(), "object_1");
    assert!(!world.entity(still).contains::<Velocity>());
    assert!(!world.entity(still).contains::<PositionTrack>());
    assert_eq!(world.get::<Velocity>(mover), Some(&Velocity(Vec3::X)));
    assert_eq!(world.get::<PositionTrack>(tracked), Some(&track));
    let start = world.get::<Transform>(tracked).unwrap().translation;
    assert_eq!(start, Vec3::ONE);
}

#[test]
fn test_sets_spawn_in_order() {
    let set = TestSet::new(3);
    let (world, entities) = spawn(&set.into());
    let entities = entities.unwrap();
    assert_eq!(entities.len(), 98);
    for (entity, cube) in entities.into_iter().zip(set.cubes()) {
        let transform = world.get::<Transform>(entity).unwrap();
        assert_eq!(*transform, Transform::from_translation(cube.position));
        let velocity = world.get::<Velocity>(entity).unwrap();
        assert_eq!(velocity.0, cube.velocity * 64.0);
        let Shape::Cuboid { half_size } = world.get::<CollisionShape>(entity).unwrap().0 else {
            panic!("test sets are made of cubes");
        };
        assert_eq!(half_size, Vec3::splat(0.5));
    }
}

#[test]
fn invalid_scenes_spawn_nothing() {
    let good = ObjectDescription::new(ShapeDescription::Sphere { radius: 1.0 });
    let bad = ObjectDescription::new(ShapeDescription::Sphere { radius: -1.0 });
    let (world, result) = spawn(&SceneDescription::new("bad", [good, bad]));
    assert_eq!(
        result.unwrap_err().to_string(),
        "scene \"bad\": object 1 (\"object_1\"): shape: the radius of a sphere must be finite and not negative, got -1"
    );
    assert_eq!(
        world.iter_entities().count(),
        World::new().iter_entities().count()
    );
}

#[test]
fn a_hundred_thousand_cubes_spawn_at_once() {
    let (mut world, entities) = spawn(&TestSet::new(110).into());
    assert_eq!(entities.unwrap().len(), 97_682);
    let mut movers = world.query::<(&CollisionShape, &Velocity)>();
    assert_eq!(movers.iter(&world).count(), 97_682);
}
