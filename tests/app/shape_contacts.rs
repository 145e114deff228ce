//! Contacts of a shape that is no entity.

use std::ops::ControlFlow;

use bevy::prelude::*;
use bevy_octree::{
    narrow_phase::{NarrowPhase, Placed, Workspace},
    prelude::*,
};
use fastrand::Rng;

use crate::{
    common::*,
    spatial_query::{ALL, ask, everything, methods, random_app, random_shape, rotation, vector},
};

#[test]
fn contacts_are_those_of_brute_force() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut rng = Rng::with_seed(40 + seed as u64);
        let mut app = random_app(&mut rng, method, 400);
        let (objects, tests) = (everything(&mut app), *app.world().resource::<NarrowPhase>());
        ask(&mut app, move |spatial| {
            let (mut workspace, mut rng) = (Workspace::default(), Rng::with_seed(8));
            let (mut found, mut entities, mut count) = (vec![], vec![], 0);
            for _ in 0..150 {
                let shape = random_shape(&mut rng);
                let at = Transform::from_translation(vector(&mut rng, 10.0))
                    .with_rotation(rotation(&mut rng));
                let placed = Placed::new(&shape, &at);
                spatial.shape_contacts(&shape, &at, &ALL, &mut found);
                let deepest_first = |pair: &[ShapeContact]| pair[0].depth >= pair[1].depth;
                assert!(found.windows(2).all(deepest_first));
                for contact in &found {
                    let (_, other, there) = objects
                        .iter()
                        .find(|(entity, ..)| *entity == contact.entity)
                        .unwrap();
                    // From the entity to the shape.
                    let expected = tests
                        .contact(Placed::new(other, there), placed, &mut workspace)
                        .unwrap();
                    assert_eq!(
                        (contact.normal, contact.point, contact.depth),
                        (expected.normal, expected.point, expected.depth)
                    );
                }
                spatial.shape_intersections(&shape, &at, &ALL, &mut entities);
                let mut touched: Vec<_> = found.iter().map(|contact| contact.entity).collect();
                touched.sort();
                assert_eq!(touched, entities);
                count += found.len();
            }
            assert!(count > 30, "{count}");
        });
    }
}

/// Moved along the normal by the depth, a shape touches, and no more.
#[test]
fn a_normal_leads_out() {
    let mut app = app(BroadPhaseMethod::default());
    let [floor, wall] = [Vec3::NEG_Y, Vec3::NEG_X].map(|side| {
        let half_size = Vec3::ONE + (Vec3::ONE - side.abs()) * 9.0;
        let at = Transform::from_translation(side);
        let shape = CollisionShape::from_half_size(half_size);
        app.world_mut().spawn((shape, at)).id()
    });
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let (ball, mut at) = (Shape::sphere(1.0), Transform::from_xyz(0.9, 0.7, 0.0));
        let mut contacts = vec![];
        spatial.shape_contacts(&ball, &at, &ALL, &mut contacts);
        let told: Vec<_> = contacts
            .iter()
            .map(|contact| (contact.entity, contact.normal))
            .collect();
        assert_eq!(told, [(floor, Vec3::Y), (wall, Vec3::X)]);
        for contact in &contacts {
            at.translation += contact.normal * contact.depth;
        }
        assert!(at.translation.abs_diff_eq(Vec3::new(1.0, 1.0, 0.0), 1e-5));
        spatial.shape_contacts(&ball, &at, &ALL, &mut contacts);
        assert!(contacts.iter().all(|contact| contact.depth < 1e-5));
        at.translation += Vec3::splat(0.1);
        spatial.shape_contacts(&ball, &at, &ALL, &mut contacts);
        assert_eq!(contacts, []);
    });
}

#[test]
fn filters_and_callbacks_are_asked() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes = [0.0, 0.1, 0.2].map(|x| block(&mut app, x));
    app.world_mut().entity_mut(cubes[1]).insert(Sensor);
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let (shape, at) = (
            Shape::cuboid(1.0, 1.0, 1.0),
            Transform::from_xyz(0.9, 0.0, 0.0),
        );
        let solid = ALL.without_sensors().except(cubes[0]);
        let mut contacts = vec![];
        spatial.shape_contacts(&shape, &at, &solid, &mut contacts);
        assert!(contacts.len() == 1 && contacts[0].entity == cubes[2]);
        let mut calls = 0;
        spatial.for_each_shape_contact(&shape, &at, &ALL, |_| {
            calls += 1;
            ControlFlow::Break(())
        });
        assert_eq!(calls, 1);
        // Bad input finds nothing, and leaves nothing.
        let nowhere = Transform::from_translation(Vec3::NAN);
        spatial.shape_contacts(&shape, &nowhere, &ALL, &mut contacts);
        assert_eq!(contacts, []);
        // A query within a query.
        spatial.for_each_shape_contact(&shape, &at, &ALL, |contact| {
            let mut inner = vec![];
            spatial.shape_contacts(&shape, &at, &ALL, &mut inner);
            assert!(inner.contains(&contact) && inner.len() == 3);
        });
    });
}

/// A shape without an end meets all that is in it.
#[cfg(feature = "rapier")]
#[test]
fn a_half_space_has_contacts_too() {
    use bevy_rapier3d::geometry::Collider;

    let mut app = app(BroadPhaseMethod::default());
    let cubes = [0.0, 5.0].map(|x| block(&mut app, x));
    tick(&mut app, 1);
    ask(&mut app, move |spatial| {
        let ground = Shape::from(&Collider::halfspace(Vec3::X).unwrap());
        let at = Transform::from_xyz(0.25, 0.0, 0.0);
        let mut contacts = vec![];
        spatial.shape_contacts(&ground, &at, &ALL, &mut contacts);
        let [contact] = contacts[..] else {
            panic!("{contacts:?}")
        };
        assert_eq!((contact.entity, contact.normal), (cubes[0], Vec3::NEG_X));
        assert!((contact.depth - 0.75).abs() < 1e-5, "{contact:?}");
    });
}
