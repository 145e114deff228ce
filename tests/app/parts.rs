//! Things made of parts: what belongs to what, what is told of bodies, and how they bounce.

use crate::common::*;

use bevy::{ecs::entity_disabling::Disabled, prelude::*};
use bevy_octree::{components::BroadPhaseProxy, prelude::*};

/// Messages about bodies so far: started, ended.
#[derive(Resource, Default)]
struct Bodies {
    started: Vec<EntityPair>,
    ended: Vec<EntityPair>,
    open: Vec<EntityPair>,
}

fn record(
    mut bodies: ResMut<Bodies>,
    mut started: MessageReader<BodyCollisionStarted>,
    mut ended: MessageReader<BodyCollisionEnded>,
    contacts: Res<Contacts>,
) {
    for message in ended.read() {
        let pair = pair(message.a, message.b);
        let place = bodies.open.iter().position(|open| *open == pair);
        bodies
            .open
            .swap_remove(place.expect("what ends has started"));
        bodies.ended.push(pair);
    }
    for message in started.read() {
        let pair = pair(message.a, message.b);
        assert!(!bodies.open.contains(&pair), "{pair:?} started twice");
        bodies.open.push(pair);
        bodies.started.push(pair);
    }
    let mut open = bodies.open.clone();
    open.sort();
    let mut now: Vec<_> = contacts.body_pairs().map(|c| pair(c.a, c.b)).collect();
    now.sort();
    assert_eq!(open, now);
}

fn parts_app() -> App {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Bodies>()
        .add_systems(FixedPostUpdate, record.in_set(CollisionSystems::Last));
    app
}

fn at(x: f32, y: f32) -> Transform {
    Transform::from_xyz(x, y, 0.0)
}

/// A body without a shape of its own.
fn body(app: &mut App, x: f32, parts: impl Bundle) -> Entity {
    app.world_mut()
        .spawn((CollisionBody::default(), at(x, 0.0), parts))
        .id()
}

/// A unit cube that hangs on something.
fn part(app: &mut App, of: Entity, x: f32, y: f32) -> Entity {
    app.world_mut()
        .spawn((CollisionShape::default(), at(x, y), ChildOf(of)))
        .id()
}

/// A body with cubes side by side, which overlap.
fn train(app: &mut App, x: f32, count: usize) -> (Entity, Vec<Entity>) {
    let body = body(app, x, ());
    let parts = (0..count).map(|n| part(app, body, 0.9 * n as f32, 0.0));
    let parts = parts.collect();
    (body, parts)
}

/// How often a pair of bodies has been told to start and to end.
fn told(app: &App, a: Entity, b: Entity) -> (usize, usize) {
    let bodies = app.world().resource::<Bodies>();
    let count = |list: &[EntityPair]| list.iter().filter(|other| **other == pair(a, b)).count();
    (count(&bodies.started), count(&bodies.ended))
}

fn part_of(app: &App, entity: Entity) -> Option<Entity> {
    app.world().get::<PartOf>(entity).map(PartOf::body)
}

fn parts_of(app: &App, body: Entity) -> Vec<Entity> {
    let parts = app.world().get::<BodyParts>(body);
    let mut parts: Vec<_> = parts
        .into_iter()
        .flat_map(BodyParts::entities)
        .copied()
        .collect();
    parts.sort_by_key(|part| part.index_u32());
    parts
}

fn hang(app: &mut App, entity: Entity, on: Entity) {
    app.world_mut().entity_mut(entity).insert(ChildOf(on));
}

// 1. Who belongs to what.

#[test]
fn parts_of_one_body_do_not_meet_unless_asked_for() {
    let mut app = parts_app();
    let (body, parts) = train(&mut app, 0.0, 3);
    let inner = [[parts[0], parts[1]], [parts[1], parts[2]]];
    tick(&mut app, 2);
    assert!(contacts(&app).is_empty());
    assert_eq!(parts_of(&app, body), parts);
    for _ in 0..2 {
        let inner_contacts = CollisionBody {
            inner_contacts: true,
        };
        app.world_mut().entity_mut(body).insert(inner_contacts);
        tick(&mut app, 1);
        assert_eq!(contacts(&app), inner);
        // It is in contact with nothing but itself.
        assert!(app.world().resource::<Contacts>().body_pairs().len() == 0);
        app.world_mut()
            .entity_mut(body)
            .insert(CollisionBody::default());
        tick(&mut app, 1);
        assert!(contacts(&app).is_empty());
    }
    app.world_mut().entity_mut(body).remove::<CollisionBody>();
    tick(&mut app, 1);
    assert_eq!(contacts(&app), inner);
    assert_eq!(part_of(&app, parts[0]), None);
    assert!(app.world().get::<BodyParts>(body).is_none());
}

#[test]
fn no_broad_phase_lists_pairs_within_a_body() {
    for method in [
        BroadPhaseMethod::default(),
        BroadPhaseMethod::Exhaustive,
        "linear".parse().unwrap(),
        "object".parse().unwrap(),
    ] {
        let mut app = app(method);
        let mut rng = fastrand::Rng::with_seed(1);
        let mut bodies = Vec::new();
        for _ in 0..60 {
            let body = body(&mut app, 0.0, ());
            for _ in 0..4 {
                let [x, y, z] = [0; 3].map(|_| rng.f32() * 6.0);
                let shape = CollisionShape::default();
                app.world_mut()
                    .spawn((shape, Transform::from_xyz(x, y, z), ChildOf(body)));
            }
            bodies.push(body);
        }
        let own = |app: &App, [a, b]: EntityPair| part_of(app, a) == part_of(app, b);
        for _ in 0..3 {
            tick(&mut app, 1);
            let mut expected = brute_force_contacts(&mut app);
            assert!(expected.iter().any(|pair| own(&app, *pair)));
            expected.retain(|pair| !own(&app, *pair));
            assert_eq!(contacts(&app), expected);
            for body in &bodies {
                get_mut::<Transform>(&mut app, *body).translation.x += 0.1 * rng.f32();
            }
        }
    }
}

#[test]
fn parts_hang_at_any_depth_and_come_at_any_time() {
    let mut app = parts_app();
    let root = body(&mut app, 0.0, CollisionShape::default());
    let [node, knot] = [(); 2].map(|()| app.world_mut().spawn(at(0.1, 0.0)).id());
    // A scene that comes before it hangs anywhere, leaves first.
    let leaf = part(&mut app, knot, 0.1, 0.0);
    hang(&mut app, knot, node);
    tick(&mut app, 1);
    assert_eq!(
        (part_of(&app, leaf), part_of(&app, root)),
        (None, Some(root))
    );
    assert_eq!(contacts(&app), [pair(root, leaf)]);
    hang(&mut app, node, root);
    tick(&mut app, 1);
    assert_eq!(parts_of(&app, root), [root, leaf]);
    assert!(contacts(&app).is_empty());
    assert_eq!(part_of(&app, knot), None, "it has no shape");
    // Shapes that come and go.
    app.world_mut()
        .entity_mut(knot)
        .insert(CollisionShape::default());
    app.world_mut().entity_mut(leaf).remove::<CollisionShape>();
    tick(&mut app, 1);
    assert_eq!(parts_of(&app, root), [root, knot]);
    assert_eq!(part_of(&app, leaf), None);
    // What is taken off.
    app.world_mut().entity_mut(node).remove::<ChildOf>();
    tick(&mut app, 1);
    assert_eq!(parts_of(&app, root), [root]);
    assert_eq!(contacts(&app), [pair(root, knot)]);
    // A body that loses its own shape.
    hang(&mut app, node, root);
    app.world_mut().entity_mut(root).remove::<CollisionShape>();
    tick(&mut app, 1);
    assert_eq!(parts_of(&app, root), [knot]);
}

#[test]
fn a_body_that_hangs_on_another_is_a_thing_of_its_own() {
    let mut app = parts_app();
    let (carrier, hull) = train(&mut app, 0.0, 1);
    let turret = body(&mut app, 0.5, ());
    let gun = part(&mut app, turret, 0.2, 0.0);
    let barrel = part(&mut app, turret, 0.4, 0.0);
    hang(&mut app, turret, hull[0]);
    tick(&mut app, 1);
    assert_eq!([gun, barrel].map(|e| part_of(&app, e)), [Some(turret); 2]);
    assert_eq!(contacts(&app), [pair(hull[0], gun), pair(hull[0], barrel)]);
    assert_eq!(told(&app, carrier, turret), (1, 0));
    // It becomes one with the other.
    app.world_mut().entity_mut(turret).remove::<CollisionBody>();
    tick(&mut app, 1);
    assert_eq!([gun, barrel].map(|e| part_of(&app, e)), [Some(carrier); 2]);
    assert!(contacts(&app).is_empty());
    assert_eq!(told(&app, carrier, turret), (1, 1));
}

#[test]
fn what_comes_in_the_middle_of_a_tick_does_not_meet_its_own() {
    for gap in SETS {
        let mut app = parts_app();
        let spawn = |mut commands: Commands, mut done: Local<bool>| {
            if !std::mem::replace(&mut *done, true) {
                let body = commands.spawn(CollisionBody::default()).id();
                for x in [0.0, 0.1, 0.2] {
                    commands.spawn((CollisionShape::default(), at(x, 0.0), ChildOf(body)));
                }
            }
        };
        app.add_systems(
            FixedPostUpdate,
            (spawn, update_spatial_index).chain().after(gap),
        );
        tick(&mut app, 3);
        assert_eq!(app.world().resource::<Log>().started, [], "{gap:?}");
    }
}

#[test]
fn bodies_may_come_before_the_plugins() {
    let mut app = App::new();
    let ship = app.world_mut().spawn(CollisionBody::default()).id();
    let parts = [0.0, 0.1].map(|x| part(&mut app, ship, x, 0.0));
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    app.update();
    assert!(contacts(&app).is_empty());
    assert_eq!(parts_of(&app, ship), parts);
    let late = part(&mut app, ship, 0.2, 0.0);
    app.update();
    assert_eq!(part_of(&app, late), Some(ship));
}

#[test]
fn a_circle_of_parents_does_no_harm() {
    let mut app = parts_app();
    let (ship, parts) = train(&mut app, 0.0, 2);
    tick(&mut app, 1);
    hang(&mut app, ship, parts[1]);
    tick(&mut app, 2);
    assert_eq!(part_of(&app, parts[0]), Some(ship));
}

#[test]
fn a_clone_is_a_body_of_its_own() {
    let mut app = parts_app();
    let (ship, parts) = train(&mut app, 0.0, 2);
    tick(&mut app, 1);
    let copy = app
        .world_mut()
        .entity_mut(ship)
        .clone_and_spawn_with_opt_out(|builder| _ = builder.linked_cloning(true));
    get_mut::<Transform>(&mut app, copy).translation.y = 0.5;
    tick(&mut app, 1);
    let copies: Vec<_> = get::<Children>(&app, copy).iter().collect();
    assert_eq!(parts_of(&app, copy), copies);
    assert_eq!(parts_of(&app, ship), parts);
    assert_eq!(contacts(&app).len(), 4);
    assert_eq!(told(&app, ship, copy), (1, 0));
}

// 2. What is told.

#[test]
fn contacts_and_messages_name_part_and_body_though_they_be_gone() {
    let mut app = parts_app();
    let mut started = app
        .world()
        .resource::<Messages<CollisionStarted>>()
        .get_cursor();
    let mut ended = app
        .world()
        .resource::<Messages<CollisionEnded>>()
        .get_cursor();
    let (ship, parts) = train(&mut app, 0.0, 3);
    let wall = block(&mut app, 2.6);
    tick(&mut app, 1);
    let contact = app.world().resource::<Contacts>().iter().next().unwrap();
    assert_eq!((contact.a, contact.b), (parts[2], wall));
    assert_eq!(contact.bodies, [ship, wall]);
    assert_eq!(contact.reversed().bodies, [wall, ship]);
    let message = *started.read(app.world().resource()).next().unwrap();
    assert_eq!((message.a, message.bodies), (parts[2], [ship, wall]));
    assert_eq!(message.reversed().bodies, [wall, ship]);
    app.world_mut().despawn(ship);
    tick(&mut app, 1);
    let message = *ended.read(app.world().resource()).next().unwrap();
    assert_eq!((message.a, message.bodies), (parts[2], [ship, wall]));
    assert_eq!(told(&app, ship, wall), (1, 1));
}

#[test]
fn two_bodies_are_in_contact_once() {
    let mut app = parts_app();
    let (ship, parts) = train(&mut app, 0.0, 3);
    let (other, others) = train(&mut app, 0.0, 3);
    tick(&mut app, 2);
    assert_eq!(contacts(&app).len(), 7);
    assert_eq!(told(&app, ship, other), (1, 0));
    let all = app.world().resource::<Contacts>();
    let pairs: Vec<_> = all.body_pairs().collect();
    assert_eq!((pairs.len(), pairs[0].contacts), (1, 7));
    assert_eq!(pairs[0].parts, [parts[0], others[0]]);
    let between: Vec<_> = all.between_bodies(other, ship).collect();
    assert_eq!(between.len(), 7);
    assert!(
        between
            .iter()
            .all(|c| c.bodies == [other, ship] && others.contains(&c.a))
    );
    assert_eq!(all.of_body(ship).count(), 7);
    assert!(all.of_body(ship).all(|c| parts.contains(&c.a)));
    // They part, part by part.
    for _ in 0..8 {
        get_mut::<Transform>(&mut app, other).translation.x += 0.5;
        tick(&mut app, 1);
    }
    assert!(contacts(&app).is_empty());
    assert_eq!(told(&app, ship, other), (1, 1));
    assert_eq!(app.world().resource::<Contacts>().of_body(ship).count(), 0);
}

/// What is done to a part, and how often the contact of its body has started and ended after that.
#[test]
fn whatever_happens_to_a_part_the_contact_of_its_body_ends_once() {
    type Deed = fn(&mut App, Entity);
    let deeds: [(&str, Deed, Deed); 5] = [
        (
            "despawned",
            |app, part| _ = app.world_mut().despawn(part),
            |_, _| {},
        ),
        (
            "disabled",
            |app, part| _ = app.world_mut().entity_mut(part).insert(Disabled),
            |app, part| _ = app.world_mut().entity_mut(part).remove::<Disabled>(),
        ),
        (
            "shapeless",
            |app, part| _ = app.world_mut().entity_mut(part).remove::<CollisionShape>(),
            |app, part| {
                let shape = CollisionShape::default();
                app.world_mut().entity_mut(part).insert(shape);
            },
        ),
        (
            "on another layer",
            |app, part| {
                let layers = CollisionLayers::NONE;
                app.world_mut().entity_mut(part).insert(layers);
            },
            |app, part| _ = app.world_mut().entity_mut(part).remove::<CollisionLayers>(),
        ),
        (
            "elsewhere",
            |app, part| get_mut::<Transform>(app, part).translation.y = 50.0,
            |app, part| get_mut::<Transform>(app, part).translation.y = 0.0,
        ),
    ];
    for (name, deed, undo) in deeds {
        let mut app = parts_app();
        let (ship, parts) = train(&mut app, 0.0, 2);
        let wall = app
            .world_mut()
            .spawn(CollisionShape::cuboid(9.0, 1.0, 9.0))
            .id();
        tick(&mut app, 1);
        assert_eq!(told(&app, ship, wall), (1, 0));
        deed(&mut app, parts[0]);
        tick(&mut app, 2);
        assert_eq!(told(&app, ship, wall), (1, 0), "{name}: another is left");
        deed(&mut app, parts[1]);
        tick(&mut app, 2);
        assert_eq!(told(&app, ship, wall), (1, 1), "{name}");
        undo(&mut app, parts[1]);
        tick(&mut app, 2);
        let again = usize::from(name != "despawned");
        assert_eq!(told(&app, ship, wall), (1 + again, 1), "{name}");
    }
}

#[test]
fn a_part_changes_bodies_in_contact() {
    let mut app = parts_app();
    let (ship, parts) = train(&mut app, 0.0, 1);
    let (other, _) = train(&mut app, 20.0, 1);
    let wall = block(&mut app, 0.5);
    tick(&mut app, 1);
    hang(&mut app, parts[0], other);
    // It stays where it is.
    get_mut::<Transform>(&mut app, parts[0]).translation.x = -20.0;
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, pair(parts[0], wall)), (1, 0));
    assert_eq!(
        (told(&app, ship, wall), told(&app, other, wall)),
        ((1, 1), (1, 0))
    );
    let contact = app.world().resource::<Contacts>().between(parts[0], wall);
    assert_eq!(contact.unwrap().bodies, [other, wall]);
    // On what it touches.
    let (third, thirds) = train(&mut app, -0.5, 1);
    tick(&mut app, 1);
    assert_eq!(told(&app, other, third), (1, 0));
    hang(&mut app, parts[0], third);
    get_mut::<Transform>(&mut app, parts[0]).translation.x = 0.5;
    tick(&mut app, 1);
    assert_eq!(told(&app, other, third), (1, 1));
    assert_eq!(messages_about(&app, pair(parts[0], thirds[0])), (1, 1));
}

#[test]
fn two_bodies_swap_a_part() {
    let mut app = parts_app();
    let (left, lefts) = train(&mut app, 0.0, 1);
    let (right, rights) = train(&mut app, 5.0, 1);
    let walls = [block(&mut app, 0.5), block(&mut app, 5.5)];
    tick(&mut app, 1);
    for (entity, on, x) in [(lefts[0], right, -5.0), (rights[0], left, 5.0)] {
        hang(&mut app, entity, on);
        get_mut::<Transform>(&mut app, entity).translation.x = x;
    }
    tick(&mut app, 1);
    assert_eq!(told(&app, left, walls[0]), (1, 1));
    assert_eq!(told(&app, right, walls[0]), (1, 0));
    assert_eq!(told(&app, right, walls[1]), (1, 1));
    assert_eq!(told(&app, left, walls[1]), (1, 0));
    for (entity, wall) in [(lefts[0], walls[0]), (rights[0], walls[1])] {
        assert_eq!(messages_about(&app, pair(entity, wall)), (1, 0));
    }
}

#[test]
fn lists_and_observers_of_bodies() {
    #[derive(Resource, Default)]
    struct Heard(Vec<(Entity, Entity, [Entity; 2], bool)>);
    let mut app = parts_app();
    app.init_resource::<Heard>();
    let ship = body(
        &mut app,
        0.0,
        (CollisionEventsEnabled, CollidingEntities::default()),
    );
    let parts = [0.0, 0.9].map(|x| part(&mut app, ship, x, 0.0));
    app.world_mut()
        .entity_mut(ship)
        .observe(
            |event: On<BodyCollisionStarted>, mut heard: ResMut<Heard>| {
                heard.0.push((event.a, event.b, event.parts, true));
            },
        )
        .observe(|event: On<BodyCollisionEnded>, mut heard: ResMut<Heard>| {
            heard.0.push((event.a, event.b, event.parts, false));
        });
    app.world_mut()
        .entity_mut(parts[0])
        .insert(CollidingEntities::default());
    let (other, others) = train(&mut app, 0.5, 2);
    tick(&mut app, 3);
    let first = (ship, other, [parts[0], others[0]], true);
    assert_eq!(app.world().resource::<Heard>().0, [first]);
    let list = |app: &App, of| {
        get::<CollidingEntities>(app, of)
            .iter()
            .copied()
            .collect::<Vec<_>>()
    };
    assert_eq!(list(&app, ship), [other]);
    assert_eq!(list(&app, parts[0]), [others[0]]);
    // It opts out, and is told that it ended.
    app.world_mut()
        .entity_mut(ship)
        .remove::<CollisionEventsEnabled>();
    tick(&mut app, 1);
    assert_eq!(app.world().resource::<Heard>().0.len(), 2);
    assert_eq!(told(&app, ship, other), (1, 0));
    app.world_mut().despawn(other);
    tick(&mut app, 1);
    assert_eq!(app.world().resource::<Heard>().0.len(), 2);
    assert_eq!(list(&app, ship), []);
}

#[test]
fn messages_about_bodies_are_for_those_who_asked() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    let mut cursor = app
        .world()
        .resource::<Messages<BodyCollisionStarted>>()
        .get_cursor();
    app.insert_resource(CollisionEventSettings {
        messages: EventScope::Enabled,
        ..default()
    });
    let (ship, _) = train(&mut app, 0.0, 2);
    block(&mut app, 0.5);
    tick(&mut app, 1);
    assert_eq!(cursor.read(app.world().resource()).count(), 0);
    app.world_mut()
        .entity_mut(ship)
        .insert(CollisionEventsEnabled);
    tick(&mut app, 1);
    assert_eq!(cursor.read(app.world().resource()).count(), 1);
}

#[test]
fn a_part_that_is_not_heard_is_not_heard_of_its_body_either() {
    let mut app = parts_app();
    let (ship, parts) = train(&mut app, 0.0, 1);
    let layers = CollisionLayers::from_bits(0, 1);
    app.world_mut()
        .entity_mut(parts[0])
        .insert((Detector, layers));
    let wall = block(&mut app, 0.5);
    for entity in [ship, wall] {
        app.world_mut()
            .entity_mut(entity)
            .insert(CollidingEntities::default());
    }
    let mut cursor = app
        .world()
        .resource::<Messages<BodyCollisionStarted>>()
        .get_cursor();
    tick(&mut app, 1);
    let message = *cursor.read(app.world().resource()).next().unwrap();
    assert_eq!(
        (message.a, message.b, message.hears),
        (ship, wall, [true, false])
    );
    assert_eq!(get::<CollidingEntities>(&app, ship).len(), 1);
    assert_eq!(get::<CollidingEntities>(&app, wall).len(), 0);
}

#[test]
fn each_part_says_for_itself_in_which_world_it_is() {
    let mut app = parts_app();
    let (ship, parts) = train(&mut app, 0.0, 2);
    let place = app.world_mut().spawn_empty().id();
    let elsewhere = app
        .world_mut()
        .spawn((
            CollisionShape::default(),
            at(0.9, 0.0),
            InCollisionWorld(place),
        ))
        .id();
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    app.world_mut()
        .entity_mut(parts[1])
        .insert(InCollisionWorld(place));
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(parts[1], elsewhere)]);
    assert_eq!(told(&app, ship, elsewhere), (1, 0));
    app.world_mut().despawn(place);
    tick(&mut app, 1);
    assert_eq!(told(&app, ship, elsewhere), (1, 1));
    assert_eq!(parts_of(&app, ship), [parts[0]]);
}

// 3. Queries.

#[test]
fn queries_answer_by_body() {
    let mut app = parts_app();
    let (ship, parts) = train(&mut app, 0.0, 3);
    let (other, _) = train(&mut app, 10.0, 1);
    let lone = block(&mut app, 20.0);
    tick(&mut app, 1);
    let look = move |spatial: SpatialQuery| {
        let ray = Ray3d::new(Vec3::X * -5.0, Dir3::X);
        let first =
            |filter: SpatialQueryFilter| spatial.cast_ray(ray, 100.0, &filter).unwrap().entity;
        let all = SpatialQueryFilter::DEFAULT;
        assert_eq!(first(all), parts[0]);
        assert_eq!(spatial.body_of(first(all)), ship);
        assert_eq!(spatial.body_of(lone), lone);
        assert_eq!(spatial.body_of(ship), ship);
        assert_eq!(first(all.except(parts[0])), parts[1]);
        for own in [ship, parts[0], parts[2]] {
            assert_eq!(spatial.body_of(first(all.without_body(own))), other);
        }
        assert_eq!(first(all.without_body(lone)), parts[0]);
        let mut found = Vec::new();
        let near = all.without_body(other);
        spatial.sphere_intersections(Vec3::ZERO, 100.0, &near, &mut found);
        assert_eq!(found.len(), 4);
    };
    app.world_mut()
        .run_system_cached_with(ask, Box::new(look))
        .unwrap();
}

type Question = Box<dyn Fn(SpatialQuery) + Send + Sync>;

fn ask(In(look): In<Question>, spatial: SpatialQuery) {
    look(spatial);
}

// 4. How bodies bounce.

/// A body of five parts: a nose, a hull, two wings that are turned, and a fin.
fn ship(app: &mut App, x: f32, parts: impl Bundle) -> (Entity, Vec<Entity>) {
    let ship = body(app, x, parts);
    let turned = |angle: f32| Quat::from_rotation_z(angle);
    let poses = [
        (
            Vec3::new(1.5, 0.0, 0.0),
            Vec3::new(1.0, 0.5, 0.5),
            Quat::IDENTITY,
        ),
        (Vec3::ZERO, Vec3::new(3.0, 1.0, 1.0), Quat::IDENTITY),
        (
            Vec3::new(-0.5, 1.0, 0.0),
            Vec3::new(0.8, 2.0, 0.2),
            turned(0.4),
        ),
        (
            Vec3::new(-0.5, -1.0, 0.0),
            Vec3::new(0.8, 2.0, 0.2),
            turned(-0.4),
        ),
        (
            Vec3::new(-1.2, 0.0, 0.6),
            Vec3::new(0.5, 0.2, 1.0),
            Quat::IDENTITY,
        ),
    ];
    let parts = poses.map(|(at, size, rotation)| {
        let shape = CollisionShape::cuboid(size.x, size.y, size.z);
        let place = Transform::from_translation(at).with_rotation(rotation);
        app.world_mut().spawn((shape, place, ChildOf(ship))).id()
    });
    (ship, parts.to_vec())
}

fn wall(app: &mut App, x: f32) -> Entity {
    let shape = CollisionShape::cuboid(0.01, 50.0, 50.0);
    app.world_mut().spawn((shape, StaticShape, at(x, 0.0))).id()
}

fn velocity(app: &App, entity: Entity) -> Vec3 {
    get::<Velocity>(app, entity).0
}

fn position(app: &App, entity: Entity) -> Vec3 {
    get::<Transform>(app, entity).translation
}

const FAST: f32 = 100.0 * TICKS_PER_SECOND;
const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };

#[test]
fn a_body_bounces_once_however_many_parts_touch() {
    for bounce in [ELASTIC, Bounce::Reverse] {
        let mut app = parts_app();
        let speed = 0.25 * TICKS_PER_SECOND;
        let ship = body(&mut app, 0.0, (Velocity(Vec3::X * speed), bounce));
        // A flat front of three, one of them a detached node deeper.
        for y in [-1.0, 0.0] {
            part(&mut app, ship, 0.0, y);
        }
        let node = app.world_mut().spawn((at(0.0, 1.0), ChildOf(ship))).id();
        part(&mut app, node, 0.0, 0.0);
        let wall = wall(&mut app, 0.8);
        let mut bounces = 0;
        for _ in 0..8 {
            tick(&mut app, 1);
            bounces += counters(&app).bounces;
        }
        assert_eq!(bounces, 1, "{bounce:?}");
        assert_eq!(velocity(&app, ship), Vec3::X * -speed);
        assert_eq!(told(&app, ship, wall), (1, 1));
    }
}

#[test]
fn what_parts_have_of_a_bounce_does_not_count_if_the_body_answers() {
    let mut app = parts_app();
    let speed = 0.25 * TICKS_PER_SECOND;
    let ship = body(&mut app, 0.0, (Velocity(Vec3::X * speed), ELASTIC));
    let nose = part(&mut app, ship, 0.0, 0.0);
    app.world_mut().entity_mut(nose).insert((
        Velocity::default(),
        Bounce::Reverse,
        Swept::stopping(),
    ));
    wall(&mut app, 0.8);
    tick(&mut app, 4);
    assert_eq!(velocity(&app, ship), Vec3::X * -speed);
    assert_eq!(velocity(&app, nose), Vec3::ZERO);
}

#[test]
fn parts_of_a_body_that_does_not_answer_answer_for_themselves() {
    let mut app = parts_app();
    let speed = 0.25 * TICKS_PER_SECOND;
    let rail = body(&mut app, 0.0, ());
    let cart = part(&mut app, rail, 0.0, 0.0);
    app.world_mut()
        .entity_mut(cart)
        .insert((Velocity(Vec3::X * speed), ELASTIC));
    wall(&mut app, 0.8);
    tick(&mut app, 4);
    assert_eq!(velocity(&app, cart), Vec3::X * -speed);
    // So do those of a body that is disabled.
    app.world_mut()
        .entity_mut(rail)
        .insert((Velocity::default(), ELASTIC, Disabled));
    wall(&mut app, -0.8);
    tick(&mut app, 4);
    assert_eq!(velocity(&app, cart), Vec3::X * speed);
}

#[test]
fn a_part_that_moves_by_itself_pushes_its_body_back() {
    for swept in [false, true] {
        let mut app = parts_app();
        let ship = body(&mut app, 0.0, (Velocity::default(), ELASTIC));
        if swept {
            app.world_mut().entity_mut(ship).insert(Swept::default());
        }
        let ram = part(&mut app, ship, 0.0, 0.0);
        app.world_mut()
            .entity_mut(ram)
            .insert(Velocity(Vec3::X * 0.1 * TICKS_PER_SECOND));
        wall(&mut app, 0.65);
        tick(&mut app, 4);
        let expected = Vec3::X * -0.2 * TICKS_PER_SECOND;
        let found = velocity(&app, ship);
        assert!((found - expected).length() < 1e-3, "{swept}: {found}");
    }
}

#[test]
fn two_bodies_exchange_their_speeds() {
    for swept in [false, true] {
        let mut app = parts_app();
        let speed = 0.25 * TICKS_PER_SECOND;
        let ships = [(-4.0, speed), (4.0, -speed)].map(|(x, speed)| {
            let (ship, _) = ship(&mut app, x, (Velocity(Vec3::X * speed), ELASTIC));
            if swept {
                app.world_mut().entity_mut(ship).insert(Swept::default());
            }
            ship
        });
        tick(&mut app, 20);
        let speeds = ships.map(|ship| velocity(&app, ship));
        assert_eq!(speeds, [Vec3::X * -speed, Vec3::X * speed], "{swept}");
        assert_eq!(told(&app, ships[0], ships[1]), (1, 1));
    }
}

#[test]
fn inner_contacts_change_nothing_about_how_a_body_moves() {
    for swept in [false, true] {
        for bounce in [ELASTIC, Bounce::Reverse] {
            let mut app = parts_app();
            let asks = CollisionBody {
                inner_contacts: true,
            };
            let ship = body(&mut app, 0.0, (Velocity(Vec3::X), bounce));
            app.world_mut().entity_mut(ship).insert(asks);
            if swept {
                app.world_mut().entity_mut(ship).insert(Swept::default());
            }
            for x in [0.0, 0.5] {
                part(&mut app, ship, x, 0.0);
            }
            tick(&mut app, 3);
            assert_eq!(contacts(&app).len(), 1);
            assert_eq!(velocity(&app, ship), Vec3::X);
        }
    }
}

#[test]
fn a_fast_body_is_carried_from_the_first_impact_of_any_part() {
    // Hanging on something, or not; with a shape of its own, or not.
    for (hangs, has_shape) in [(false, false), (true, false), (false, true), (true, true)] {
        for angle in [0.0, 0.3, 1.6, 2.9] {
            let mut app = parts_app();
            let (ship, parts) = ship(
                &mut app,
                0.0,
                (Velocity(Vec3::X * FAST), ELASTIC, Swept::default()),
            );
            get_mut::<Transform>(&mut app, ship).rotation = Quat::from_rotation_z(angle);
            if has_shape {
                app.world_mut()
                    .entity_mut(ship)
                    .insert(CollisionShape::sphere(0.1));
            }
            if hangs {
                let node = Transform::from_xyz(1.0, 2.0, 0.0).with_scale(Vec3::splat(2.0));
                let node = app.world_mut().spawn(node).id();
                hang(&mut app, ship, node);
                get_mut::<Transform>(&mut app, ship).translation = Vec3::new(-0.5, -1.0, 0.0);
                get_mut::<Transform>(&mut app, ship).scale = Vec3::splat(0.5);
                get_mut::<Velocity>(&mut app, ship).0 *= 0.5;
            }
            let wall = wall(&mut app, 50.0);
            // How far the foremost corner of all reaches.
            let reach = parts
                .iter()
                .map(|part| {
                    let place = get::<Transform>(&app, *part);
                    let Shape::Cuboid { half_size } = get::<CollisionShape>(&app, *part).0 else {
                        unreachable!()
                    };
                    let turn = Quat::from_rotation_z(angle);
                    let center = (turn * place.translation).x;
                    let extent: f32 = [Vec3::X, Vec3::Y, Vec3::Z]
                        .iter()
                        .map(|axis| (turn * place.rotation * *axis).x.abs() * half_size.dot(*axis))
                        .sum();
                    center + extent
                })
                .fold(0.0, f32::max);
            tick(&mut app, 1);
            let way = 50.0 - 0.005 - reach;
            let expected = way - (100.0 - way);
            let world = |app: &App, entity| {
                let mut pose = *get::<Transform>(app, entity);
                let mut at = entity;
                while let Some(parent) = app.world().get::<ChildOf>(at) {
                    at = parent.parent();
                    pose = *get::<Transform>(app, at) * pose;
                }
                pose.translation
            };
            let found = world(&app, ship);
            assert!(
                (found.x - expected).abs() < 0.01,
                "{hangs} {has_shape} {angle}: {found} is not at {expected}"
            );
            assert_eq!(counters(&app).bounces, 1);
            assert_eq!(told(&app, ship, wall).0, 1);
            let back = velocity(&app, ship).x * if hangs { 2.0 } else { 1.0 };
            assert!((back + FAST).abs() < 0.1);
            // Queries find all of it where it is, at once.
            for part in &parts {
                let index = app
                    .world()
                    .resource::<bevy_octree::collision_index::CollisionIndex>()
                    .index();
                let id = get::<BroadPhaseProxy>(&app, *part).id().unwrap();
                let aabb = index.proxies().get(id).unwrap();
                let center = Vec3::from((aabb.min + aabb.max) * 0.5);
                assert!(center.distance(world(&app, *part)) < 0.01);
            }
            // And it goes on from there.
            tick(&mut app, 1);
            assert!((world(&app, ship).x - expected + 100.0).abs() < 0.02);
            assert_eq!(told(&app, ship, wall), (1, 1));
        }
    }
}

#[test]
fn a_body_between_two_walls_bounces_as_often_as_it_may() {
    let mut app = parts_app();
    let (ship, _) = ship(
        &mut app,
        0.0,
        (Velocity(Vec3::X * FAST), ELASTIC, Swept::new(3)),
    );
    let walls = [-4.0, 4.0].map(|x| wall(&mut app, x));
    tick(&mut app, 1);
    assert_eq!(counters(&app).bounces, 3);
    // At the next impact it stays for the rest of the tick.
    assert!(position(&app, ship).x.abs() < 4.0);
    for _ in 0..50 {
        tick(&mut app, 1);
        assert!(position(&app, ship).x.abs() < 4.0);
    }
    assert!((velocity(&app, ship).length() - FAST).abs() < 1.0);
    for wall in walls {
        let (started, ended) = told(&app, ship, wall);
        assert!(started > 0 && started - ended < 2);
    }
}

#[test]
fn a_body_that_stops_does_so_with_all_of_its_parts() {
    for moved_elsewhere in [false, true] {
        let mut app = parts_app();
        let (ship, parts) = ship(&mut app, 0.0, (Velocity(Vec3::X * FAST), Swept::stopping()));
        if moved_elsewhere {
            app.world_mut().entity_mut(ship).insert(MovedElsewhere);
        }
        let walls = [10.0, 20.0, 30.0].map(|x| wall(&mut app, x));
        tick(&mut app, 1);
        if moved_elsewhere {
            // The first tick only tells where it is.
            get_mut::<Transform>(&mut app, ship).translation.x = 100.0;
            tick(&mut app, 1);
        }
        let met = walls.map(|wall| told(&app, ship, wall).0);
        assert_eq!(met, [1, 0, 0], "{moved_elsewhere}");
        let x = position(&app, ship).x;
        if moved_elsewhere {
            assert_eq!(x, 100.0);
        } else {
            assert!((x - 10.0 + 0.005 + 2.0).abs() < 0.01, "{x}");
            // Its nose is what it has met.
            assert_eq!(contacts(&app), [pair(parts[0], walls[0])]);
        }
    }
}

#[test]
fn a_body_that_does_not_bounce_passes_through_and_is_told_of_all() {
    let mut app = parts_app();
    let (ship, _) = ship(&mut app, 0.0, (Velocity(Vec3::X * FAST), Swept::default()));
    let walls = [10.0, 20.0, 30.0].map(|x| wall(&mut app, x));
    tick(&mut app, 2);
    assert_eq!(walls.map(|wall| told(&app, ship, wall)), [(1, 1); 3]);
    assert_eq!(velocity(&app, ship), Vec3::X * FAST);
    // Without, it misses them.
    app.world_mut().entity_mut(ship).remove::<Swept>();
    get_mut::<Transform>(&mut app, ship).translation.x = -45.0;
    tick(&mut app, 2);
    assert_eq!(walls.map(|wall| told(&app, ship, wall)), [(1, 1); 3]);
    // Put elsewhere by a new component, it has not passed through what is between.
    app.world_mut().entity_mut(ship).insert(Swept::default());
    get_mut::<Velocity>(&mut app, ship).0 = Vec3::ZERO;
    tick(&mut app, 2);
    get_mut::<Transform>(&mut app, ship).translation.x = -100.0;
    app.world_mut().entity_mut(ship).insert(Swept::default());
    tick(&mut app, 2);
    assert_eq!(walls.map(|wall| told(&app, ship, wall)), [(1, 1); 3]);
    get_mut::<Transform>(&mut app, ship).translation.x = 100.0;
    tick(&mut app, 2);
    assert_eq!(walls.map(|wall| told(&app, ship, wall)), [(2, 2); 3]);
}

#[test]
fn a_part_that_joins_or_leaves_a_fast_body_is_swept_as_long_as_it_belongs_to_it() {
    let mut app = parts_app();
    let ship = body(&mut app, 0.0, (Velocity(Vec3::X * FAST), Swept::default()));
    tick(&mut app, 1);
    let late = part(&mut app, ship, 0.0, 0.0);
    let walls = [150.0, 250.0].map(|x| wall(&mut app, x));
    tick(&mut app, 1);
    assert_eq!(told(&app, ship, walls[0]).0, 1);
    app.world_mut().entity_mut(late).remove::<ChildOf>();
    get_mut::<Transform>(&mut app, late).translation.x = 200.0;
    tick(&mut app, 1);
    get_mut::<Transform>(&mut app, late).translation.x = 300.0;
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, pair(late, walls[1])), (0, 0));
}

#[test]
fn what_hangs_on_a_fast_body_and_is_a_body_itself_goes_with_it() {
    let mut app = parts_app();
    let (ship, _) = ship(
        &mut app,
        0.0,
        (Velocity(Vec3::X * FAST), ELASTIC, Swept::default()),
    );
    // Behind it, and so it meets nothing.
    let trailer = body(
        &mut app,
        -10.0,
        (Velocity::default(), ELASTIC, Swept::default()),
    );
    hang(&mut app, trailer, ship);
    let box_of_trailer = part(&mut app, trailer, 0.0, 0.0);
    wall(&mut app, 50.0);
    tick(&mut app, 1);
    let back = position(&app, ship).x;
    assert!(
        (back - (2.0 * (50.0 - 0.005 - 2.0) - 100.0)).abs() < 0.01,
        "{back}"
    );
    assert_eq!(position(&app, trailer), Vec3::X * -10.0);
    assert_eq!(velocity(&app, trailer), Vec3::ZERO);
    let index = app
        .world()
        .resource::<bevy_octree::collision_index::CollisionIndex>()
        .index();
    let id = get::<BroadPhaseProxy>(&app, box_of_trailer).id().unwrap();
    let aabb = index.proxies().get(id).unwrap();
    assert!(((aabb.min.x + aabb.max.x) / 2.0 - (back - 10.0)).abs() < 0.01);
}

#[test]
fn a_body_is_as_a_single_shape_where_it_consists_of_one() {
    for swept in [false, true] {
        for bounce in [
            ELASTIC,
            Bounce::Reflect { restitution: 0.4 },
            Bounce::Reverse,
        ] {
            let mut rng = fastrand::Rng::with_seed(5);
            let mut apps = [(); 2].map(|()| {
                let mut app = app(BroadPhaseMethod::default());
                // What observes bodies comes with the first of them.
                let first = app.world_mut().spawn(CollisionBody::default()).id();
                app.world_mut().despawn(first);
                app
            });
            let mut movers: Vec<[Entity; 2]> = Vec::new();
            for number in 0..40 {
                let mut vector =
                    |size: f32| Vec3::from_array([0; 3].map(|_| (rng.f32() - 0.5) * size));
                let place = Transform::from_translation(vector(12.0))
                    .with_rotation(Quat::from_scaled_axis(vector(3.0)));
                let velocity = Velocity(vector(1.0) * TICKS_PER_SECOND);
                let shape = CollisionShape::from_half_size(vector(1.0).abs() + 0.2);
                let moves = number % 3 != 0;
                let made = [0, 1].map(|which| {
                    let world = apps[which].world_mut();
                    // As many entities in the same order.
                    let [body, shaped] = [(); 2].map(|()| world.spawn_empty().id());
                    let (own, hung) = if which == 0 {
                        (shaped, None)
                    } else {
                        (body, Some(shaped))
                    };
                    world.entity_mut(own).insert(place);
                    if let Some(part) = hung {
                        world.entity_mut(body).insert(CollisionBody::default());
                        world
                            .entity_mut(part)
                            .insert((shape.clone(), ChildOf(body)));
                    } else {
                        world.entity_mut(shaped).insert(shape.clone());
                    }
                    if moves {
                        world.entity_mut(own).insert((velocity, bounce));
                        if swept {
                            world.entity_mut(own).insert(Swept::default());
                        }
                    }
                    own
                });
                movers.push(made);
            }
            for number in 0..60 {
                apps.iter_mut().for_each(|app| tick(app, 1));
                assert_eq!(contacts(&apps[0]), contacts(&apps[1]), "tick {number}");
                for [one, other] in &movers {
                    let apart = position(&apps[0], *one).distance(position(&apps[1], *other));
                    assert!(
                        apart < 1e-3,
                        "{swept} {bounce:?} tick {number}: {one} {apart}"
                    );
                }
            }
        }
    }
}
