//! What ends at the first thing that it hits, and which polygon of it that was.

use crate::{bullets::*, common};

use bevy::{ecs::system::RunSystemOnce, platform::collections::HashSet, prelude::*};
use bevy_octree::prelude::*;
use common::*;

#[derive(Component)]
struct Bullet;

#[derive(Resource, Default)]
struct Hits(Vec<(Entity, Entity)>);

/// Walls, and bullets that pass all of them in a tick, if they do not end there; some entities are
/// spawned before the others.
fn range(walls_first: bool) -> (App, Vec<Entity>, Vec<Entity>) {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Hits>();
    let (mut walls, mut bullets) = (vec![], vec![]);
    for what in [walls_first, !walls_first] {
        if what {
            walls.extend((0..3).map(|i| paper(&mut app, 2.0 - i as f32)));
        } else {
            bullets.extend(
                (0..4).map(|i| bullet(&mut app, Vec3::new(-1.0, i as f32, 0.0), Vec3::X * 6.0)),
            );
        }
    }
    for bullet in &bullets {
        app.world_mut().entity_mut(*bullet).insert(Bullet);
    }
    (app, walls, bullets)
}

/// As the documentation of `swept` has it.
fn hit(
    mut started: MessageReader<CollisionStarted>,
    bullets: Query<(), With<Bullet>>,
    mut hits: ResMut<Hits>,
    mut commands: Commands,
) {
    let mut spent = HashSet::new();
    for message in started.read() {
        let message = if bullets.contains(message.a) {
            *message
        } else {
            message.reversed()
        };
        if bullets.contains(message.a) && spent.insert(message.a) {
            hits.0.push((message.a, message.b));
            commands.entity(message.a).despawn();
        }
    }
}

#[test]
fn the_first_message_is_the_first_hit() {
    for walls_first in [true, false] {
        let (mut app, walls, bullets) = range(walls_first);
        app.add_systems(FixedPostUpdate, hit.in_set(CollisionSystems::Last));
        tick(&mut app, 3);
        let mut hits = app.world().resource::<Hits>().0.clone();
        hits.sort_unstable();
        let mut expected: Vec<_> = bullets.iter().map(|bullet| (*bullet, walls[2])).collect();
        expected.sort_unstable();
        assert_eq!(hits, expected);
        assert!(
            bullets
                .iter()
                .all(|it| app.world().get_entity(*it).is_err())
        );
    }
}

#[test]
fn a_bullet_that_goes_is_told_once_and_walls_each() {
    for walls_first in [true, false] {
        let (mut app, walls, bullets) = range(walls_first);
        for wall in &walls {
            app.world_mut()
                .entity_mut(*wall)
                .insert(CollisionEventsEnabled)
                .observe(|on: On<CollisionStarted>, mut hits: ResMut<Hits>| {
                    hits.0.push((on.a, on.b));
                });
        }
        for bullet in &bullets {
            app.world_mut()
                .entity_mut(*bullet)
                .insert(CollisionEventsEnabled)
                .observe(
                    |on: On<CollisionStarted>, mut hits: ResMut<Hits>, mut commands: Commands| {
                        hits.0.push((on.a, on.b));
                        commands.entity(on.a).despawn();
                    },
                );
        }
        tick(&mut app, 2);
        let hits = &app.world().resource::<Hits>().0;
        for bullet in &bullets {
            let told_it = |hit: &&(Entity, Entity)| hit.0 == *bullet;
            let own: Vec<_> = hits.iter().filter(told_it).collect();
            assert_eq!(own, [&(*bullet, walls[2])]);
            let of_walls = hits.iter().filter(|hit| hit.1 == *bullet);
            let of_walls: Vec<_> = of_walls.map(|hit| hit.0).collect();
            assert_eq!(of_walls, [walls[2], walls[1], walls[0]]);
        }
    }
}

#[test]
fn either_of_two_may_be_asked_for_the_other() {
    let (mut app, walls, bullets) = range(false);
    app.insert_resource(CollisionEventSettings {
        geometry: EventScope::All,
        ..default()
    });
    let red = CollisionLayers::new(LayerMask::layer(1), LayerMask::ALL);
    app.world_mut().entity_mut(bullets[0]).insert(red);
    let stranger = app.world_mut().spawn_empty().id();
    for wall in &walls {
        let all = CollisionLayers::new(LayerMask::ALL, LayerMask::ALL);
        app.world_mut().entity_mut(*wall).insert(all);
    }
    tick(&mut app, 1);
    let contacts = app.world().resource::<Contacts>();
    assert_eq!(contacts.len(), 12);
    for it in contacts.iter() {
        assert_eq!([it.a, it.b].map(|e| it.other(e)), [Some(it.b), Some(it.a)]);
        assert_eq!(it.other(stranger), None);
    }
    let mut started = app.world_mut().resource_mut::<Messages<CollisionStarted>>();
    let started: Vec<_> = started.drain().collect();
    tick(&mut app, 1);
    let mut ended = app.world_mut().resource_mut::<Messages<CollisionEnded>>();
    let ended: Vec<_> = ended.drain().collect();
    assert_eq!((started.len(), ended.len()), (12, 12));
    for it in started {
        let back = it.reversed();
        assert_eq!([back.a, back.b], [it.b, it.a]);
        assert_eq!(back.layers, [it.layers[1], it.layers[0]]);
        assert_eq!(back.contact.unwrap().normal, -it.contact.unwrap().normal);
        assert_eq!((back.time, back.reversed()), (it.time, it));
        assert_eq!([it.a, it.b].map(|e| it.other(e)), [Some(it.b), Some(it.a)]);
        assert_eq!(it.other(stranger), None);
    }
    for it in ended {
        let back = it.reversed();
        assert_eq!([back.a, back.b], [it.b, it.a]);
        assert_eq!(back.layers, [it.layers[1], it.layers[0]]);
        assert_eq!(back.contact.unwrap().normal, -it.contact.unwrap().normal);
        assert_eq!(back.reversed(), it);
        assert_eq!([it.a, it.b].map(|e| it.other(e)), [Some(it.b), Some(it.a)]);
        assert_eq!(it.other(stranger), None);
    }
}

#[test]
fn a_short_ray_along_the_normal_tells_the_polygon() {
    let mut app = app(BroadPhaseMethod::default());
    app.insert_resource(CollisionEventSettings {
        geometry: EventScope::All,
        ..default()
    });
    // A target of squares across the x axis, two triangles each; one in eight is in a tree.
    const SIDE: u32 = 8;
    let corner = |i: u32| Vec3::new(0.0, (i / (SIDE + 1)) as f32, (i % (SIDE + 1)) as f32);
    let corners: Vec<_> = (0..(SIDE + 1) * (SIDE + 1)).map(corner).collect();
    let triangles = (0..SIDE * SIDE).flat_map(|square| {
        let a = square / SIDE * (SIDE + 1) + square % SIDE;
        let [b, c, d] = [a + SIDE + 1, a + SIDE + 2, a + 1];
        [[a, b, c], [a, c, d]]
    });
    let target = PolygonMesh::new(corners, triangles).unwrap();
    app.world_mut()
        .spawn((CollisionShape::from(target), StaticShape));
    let mut expected = vec![];
    for square in 0..SIDE * SIDE {
        let (y, z) = ((square / SIDE) as f32, (square % SIDE) as f32);
        let from = if square % 3 == 0 { 1.0 } else { -1.0 };
        let start = Vec3::new(3.0 * from, y + 0.7, z + 0.3);
        let bullet = bullet(&mut app, start, Vec3::X * -7.0 * from);
        expected.push((bullet, 2 * square));
    }
    tick(&mut app, 1);
    let told = app
        .world_mut()
        .run_system_once(
            |mut started: MessageReader<CollisionStarted>,
             bullets: Query<(&SweptWay, &Transform, &CollisionShape)>,
             spatial: SpatialQuery| {
                let polygon = |it: &CollisionStarted| {
                    let it = if bullets.contains(it.a) {
                        *it
                    } else {
                        it.reversed()
                    };
                    let contact = it.contact.unwrap();
                    let normal = Dir3::new(contact.normal).unwrap();
                    let ray = Ray3d::new(contact.point - 0.01 * contact.normal, normal);
                    let is_hit = |entity| entity == it.b;
                    let filter = SpatialQueryFilter::DEFAULT.only(&is_hit);
                    let by_ray = spatial.cast_ray(ray, 0.02, &filter)?.polygon;
                    // The other way: once more along the way of this tick.
                    let (way, end, shape) = bullets.get(it.a).unwrap();
                    let start = way.last_start().unwrap();
                    let way = end.translation - start.translation;
                    let again = spatial.cast_shape_with(
                        Placed::new(&shape.0, start),
                        Dir3::new(way).unwrap(),
                        way.length(),
                        &filter,
                        &ShapeCastOptions::DEFAULT.find_polygon(),
                    );
                    assert_eq!(again.unwrap().polygon, by_ray);
                    Some((it.a, by_ray?))
                };
                started.read().filter_map(polygon).collect::<Vec<_>>()
            },
        )
        .unwrap();
    let mut told = told;
    told.sort_unstable();
    expected.sort_unstable();
    assert_eq!(told, expected);
}

#[test]
fn last_start_is_that_of_this_tick_from_the_report_on() {
    #[derive(Resource, Default)]
    struct Seen(Vec<(bool, f32)>);
    fn note(after: bool) -> impl Fn(Query<&SweptWay>, ResMut<Seen>) {
        move |ways, mut seen| {
            for way in &ways {
                let start = way.last_start().map_or(f32::NAN, |at| at.translation.x);
                seen.0.push((after, start));
            }
        }
    }
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Seen>().add_systems(
        FixedPostUpdate,
        (
            note(false).in_set(CollisionSystems::Response),
            note(true).in_set(CollisionSystems::Report),
        ),
    );
    bullet(&mut app, Vec3::ZERO, Vec3::X * 2.0);
    tick(&mut app, 3);
    let seen = &app.world().resource::<Seen>().0;
    assert!(seen[0].1.is_nan());
    let expected = [
        (true, 0.0),
        (false, 0.0),
        (true, 2.0),
        (false, 2.0),
        (true, 4.0),
    ];
    assert_eq!(seen[1..], expected);
}
