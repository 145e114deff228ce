//! Whose way it is that a swept entity is looked at along: no copy's, and that of all that hangs on
//! it.

use crate::{bullets::*, common};

use bevy::prelude::*;
use bevy_octree::{
    components::WorldAabb,
    counters::TickCounters,
    prelude::*,
    swept::{SweptPlugin, SweptWay},
};
use common::*;

fn assert_near(found: Vec3, expected: Vec3, within: f32) {
    assert!(
        found.distance(expected) <= within,
        "{found}, expected {expected}"
    );
}

fn counters_of_all_ticks(app: &App) -> TickCounters {
    app.world().resource::<CollisionCounters>().total
}

/// Where a way begins is the business of one entity: no copy has been where the original was.
#[test]
fn what_is_copied_begins_where_it_is() {
    type Copying = fn(&mut World, Entity) -> Entity;
    let copies: [Copying; 4] = [
        |world, bullet| world.entity_mut(bullet).clone_and_spawn(),
        |world, bullet| {
            let copy = *world.get::<Swept>(bullet).unwrap();
            world.spawn((CollisionShape::sphere(0.05), copy)).id()
        },
        |world, bullet| {
            let way = world.get::<SweptWay>(bullet).unwrap().clone();
            world
                .spawn((CollisionShape::sphere(0.05), Swept::default(), way))
                .id()
        },
        // Put elsewhere by inserting the component with the value that it has.
        |world, bullet| {
            let copy = *world.get::<Swept>(bullet).unwrap();
            world.entity_mut(bullet).insert(copy);
            bullet
        },
    ];
    for (number, copying) in copies.into_iter().enumerate() {
        for known in [false, true] {
            let mut app = app(BroadPhaseMethod::default());
            paper(&mut app, 0.0);
            let bullet = bullet(&mut app, Vec3::X * -10.0, Vec3::ZERO);
            tick(&mut app, 2);
            let copy = copying(app.world_mut(), bullet);
            get_mut::<Transform>(&mut app, copy).translation = Vec3::new(10.0, 1.0, 0.0);
            if known {
                update_spatial_index(app.world_mut());
            }
            tick(&mut app, 2);
            assert_eq!(counters_of_all_ticks(&app).started, 0, "{number}");
            let aabb = get::<WorldAabb>(&app, copy).0;
            assert!((aabb.max - aabb.min).max_element() < 0.101, "{number}");
            // From there on it is swept.
            get_mut::<Transform>(&mut app, copy).translation.x = -5.0;
            tick(&mut app, 1);
            assert_eq!(contacts(&app).len(), 1, "{number}");
        }
    }
}

/// Values are compared by what is said, not by where an entity is.
#[test]
fn equal_settings_are_equal_wherever_they_have_been() {
    let mut app = app(BroadPhaseMethod::default());
    let bullet = bullet(&mut app, Vec3::ZERO, Vec3::X);
    tick(&mut app, 2);
    assert_eq!(*get::<Swept>(&app, bullet), Swept::default());
    assert_eq!(
        get::<SweptWay>(&app, bullet)
            .last_start()
            .map(|start| start.translation),
        Some(Vec3::X)
    );
}

/// A part of what bounces goes where that goes, swept itself or not, and meets what is there.
#[test]
fn what_hangs_on_a_swept_entity_bounces_with_it() {
    for swept in [false, true] {
        for nested in [false, true] {
            let mut app = app(BroadPhaseMethod::default());
            wall(&mut app, Vec3::X * 5.0, Vec3::new(0.1, 0.5, 0.5));
            // On the way of the part, had there been no bounce: behind the wall, and at the end.
            for x in [7.0, 10.0] {
                wall(&mut app, Vec3::new(x, 2.0, 0.0), Vec3::splat(0.4));
            }
            let before = wall(&mut app, Vec3::new(-0.1, 2.0, 0.0), Vec3::splat(0.3));
            let ball = elastic_bullet(&mut app, Vec3::X * 1.0, Vec3::X * 9.0);
            let holder = if nested {
                app.world_mut()
                    .spawn((Transform::default(), ChildOf(ball)))
                    .id()
            } else {
                ball
            };
            let part = (
                CollisionShape::sphere(0.05),
                Transform::from_xyz(0.0, 2.0, 0.0),
                ChildOf(holder),
            );
            let part = app.world_mut().spawn((part, Sensor)).id();
            if swept {
                app.world_mut().entity_mut(part).insert(Swept::default());
            }
            app.world_mut()
                .entity_mut(part)
                .insert(CollisionEventsEnabled);
            app.add_systems(
                FixedPostUpdate,
                look.after(CollisionSystems::Response)
                    .before(CollisionSystems::Report),
            );
            app.insert_resource(At(Vec3::ZERO, part));
            tick(&mut app, 1);
            // From 1 to the wall, and what is left of 9.
            let x = 4.85 - (9.0 - 3.85);
            assert_near(place(&app, ball), Vec3::X * x, 1e-3);
            let touched: Vec<_> = contacts(&app)
                .into_iter()
                .filter(|pair| pair.contains(&part))
                .collect();
            assert_eq!(
                touched,
                [pair(before, part)],
                "swept {swept}, nested {nested}"
            );
            assert_near(app.world().resource::<At>().0, Vec3::new(x, 2.0, 0.0), 1e-3);
            let met = app
                .world()
                .resource::<Contacts>()
                .iter()
                .find(|contact| [contact.a, contact.b].contains(&part))
                .unwrap();
            assert_eq!(met.time < 1.0, swept);
            let contact = met.contact.unwrap();
            assert!(
                (contact.point.x - if swept { 0.2 } else { x }).abs() < 0.12,
                "{contact:?}"
            );
            // It goes on from there.
            tick(&mut app, 1);
            let touched = contacts(&app)
                .into_iter()
                .filter(|pair| pair.contains(&part))
                .count();
            assert_eq!(touched, 0, "swept {swept}, nested {nested}");
            assert_near(place(&app, ball), Vec3::X * (x - 9.0), 1e-3);
        }
    }

    /// Where queries see a part.
    #[derive(Resource)]
    struct At(Vec3, Entity);

    fn look(spatial: SpatialQuery, mut at: ResMut<At>) {
        let only = |entity| entity == at.1;
        let filter = SpatialQueryFilter::DEFAULT.only(&only);
        let far = Vec3::new(0.0, 100.0, 0.0);
        if let Some(hit) = spatial.nearest(far, 1e3, &filter) {
            at.0 = hit.point - (far - hit.point).normalize() * 0.05;
        }
    }
}

/// A part that is at rest in contact leaves what it touches as what it hangs on is hit.
#[test]
fn what_hangs_on_a_body_at_rest_leaves_with_it() {
    let mut app = app(BroadPhaseMethod::default());
    let ball = elastic_bullet(&mut app, Vec3::ZERO, Vec3::ZERO);
    let part = app.world_mut().spawn((
        CollisionShape::sphere(0.05),
        Transform::from_xyz(0.0, 2.0, 0.0),
    ));
    let part = part.id();
    app.world_mut().entity_mut(part).insert(ChildOf(ball));
    let there = wall(&mut app, Vec3::Y * 2.5, Vec3::splat(0.5));
    tick(&mut app, 2);
    assert_eq!(contacts(&app), [[part, there]]);
    elastic_bullet(&mut app, Vec3::X * -3.0, Vec3::X * 10.0);
    tick(&mut app, 1);
    assert!(!contacts(&app).contains(&[part, there]));
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, [part, there]), (1, 1));
}

/// Without the plugin nothing is swept, whatever an entity has been elsewhere.
#[test]
fn without_the_plugin_boxes_are_those_of_places() {
    let mut other = app(BroadPhaseMethod::default());
    let elsewhere = bullet(&mut other, Vec3::X * -10.0, Vec3::ZERO);
    tick(&mut other, 1);
    let group = OctreePlugins::default().build().disable::<SweptPlugin>();
    let mut app = app_with(group, FixedPostUpdate);
    paper(&mut app, 0.0);
    let bullet = bullet(&mut app, Vec3::X * -10.0, Vec3::X * 20.0);
    app.world_mut()
        .entity_mut(bullet)
        .insert(*get::<Swept>(&other, elsewhere));
    for _ in 0..3 {
        update_spatial_index(app.world_mut());
        let aabb = get::<WorldAabb>(&app, bullet).0;
        assert!((aabb.max - aabb.min).max_element() < 0.101);
        tick(&mut app, 1);
        let aabb = get::<WorldAabb>(&app, bullet).0;
        assert!((aabb.max - aabb.min).max_element() < 0.101);
    }
    assert_eq!(counters_of_all_ticks(&app).started, 0);
}
