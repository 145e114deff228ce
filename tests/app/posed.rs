//! Questions as if some entities were elsewhere have the answers that there would be.

use bevy::{ecs::system::SystemState, prelude::*};
use bevy_octree::prelude::*;

/// Shapes at random, and where some of them are to be.
fn scene(seed: u64) -> (App, Vec<(Entity, Transform)>) {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    let mut random = fastrand::Rng::with_seed(seed);
    let mut place = || {
        let mut share = || random.f32() * 2.0 - 1.0;
        let turn = Quat::from_scaled_axis(Vec3::new(share(), share(), share()));
        Transform::from_xyz(share() * 5.0, share() * 5.0, share() * 5.0).with_rotation(turn)
    };
    let shapes = [
        CollisionShape::cuboid(1.0, 0.6, 0.8),
        CollisionShape::sphere(0.5),
        CollisionShape::capsule(0.3, 0.8),
    ];
    let mut elsewhere = Vec::new();
    for number in 0..60 {
        let shape = shapes[number % shapes.len()].clone();
        let entity = app.world_mut().spawn((shape, place())).id();
        if number % 5 == 0 {
            elsewhere.push((entity, place()));
        }
    }
    app.update();
    (app, elsewhere)
}

#[test]
fn answers_are_those_that_there_would_be() {
    let (mut hits, mut changed) = (0, 0);
    for seed in 0..20 {
        let (mut app, elsewhere) = scene(seed);
        let mut random = fastrand::Rng::with_seed(1000 + seed);
        let mut vector = || Vec3::from_array([0; 3].map(|_| random.f32() * 2.0 - 1.0));
        let rays: Vec<_> = (0..40)
            .map(|_| Ray3d::new(vector() * 7.0, Dir3::new(vector()).unwrap_or(Dir3::X)))
            .collect();
        let ball = Shape::sphere(0.4);
        let filter = SpatialQueryFilter::DEFAULT.except(elsewhere[0].0);
        let ask = |app: &mut App, elsewhere: &[(Entity, Transform)]| {
            let mut state = SystemState::<SpatialQuery>::new(app.world_mut());
            let spatial = state.get(app.world()).unwrap();
            let then = spatial.at(elsewhere.iter().copied());
            let answers = rays.iter().map(|ray| {
                let at = Transform::from_translation(ray.origin);
                let mut overlaps = Vec::new();
                then.shape_intersections(&ball, &at, &filter, &mut overlaps);
                let moving = Placed::new(&ball, &at);
                (
                    then.cast_ray(*ray, 20.0, &filter),
                    then.cast_shape(
                        moving,
                        ray.direction,
                        20.0,
                        &filter,
                        &ShapeCastOptions::DEFAULT,
                    ),
                    overlaps,
                )
            });
            answers.collect::<Vec<_>>()
        };
        let now = ask(&mut app, &[]);
        let then = ask(&mut app, &elsewhere);
        for (entity, at) in &elsewhere {
            app.world_mut().entity_mut(*entity).insert(*at);
        }
        app.update();
        let expected = ask(&mut app, &[]);
        assert_eq!(then, expected);
        hits += then.iter().filter(|(ray, ..)| ray.is_some()).count();
        changed += usize::from(then != now);
    }
    assert!(hits > 50 && changed == 20, "{hits} hits, {changed} changed");
}

#[test]
fn who_is_nowhere_is_not_found() {
    let (mut app, elsewhere) = scene(1);
    let (entity, _) = elsewhere[0];
    let at = *app.world().get::<Transform>(entity).unwrap();
    let gone = app.world_mut().spawn_empty().id();
    let mut state = SystemState::<SpatialQuery>::new(app.world_mut());
    let spatial = state.get(app.world()).unwrap();
    let ball = Shape::sphere(0.1);
    let mut found = Vec::new();
    spatial.shape_intersections(&ball, &at, &SpatialQueryFilter::DEFAULT, &mut found);
    assert!(found.contains(&entity));
    let nowhere = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    let then = spatial.at([(gone, at), (entity, nowhere)]);
    then.shape_intersections(&ball, &at, &SpatialQueryFilter::DEFAULT, &mut found);
    assert!(!found.contains(&entity) && !found.contains(&gone));
    // The last of two counts.
    let then = spatial.at([(entity, nowhere), (entity, at)]);
    then.shape_intersections(&ball, &at, &SpatialQueryFilter::DEFAULT, &mut found);
    assert!(found.contains(&entity));
}

/// As it would be if it were there: what has no box is not in the index.
#[test]
fn who_is_in_no_box_there_is_not_found() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    let capsule = app
        .world_mut()
        .spawn(CollisionShape::capsule(0.3, 0.8))
        .id();
    app.update();
    let mut state = SystemState::<SpatialQuery>::new(app.world_mut());
    let spatial = state.get(app.world()).unwrap();
    let then = spatial.at([(capsule, Transform::from_scale(Vec3::splat(3e38)))]);
    let ray = Ray3d::new(Vec3::NEG_X, Dir3::X);
    assert_eq!(then.cast_ray(ray, 9.0, &SpatialQueryFilter::DEFAULT), None);
}
