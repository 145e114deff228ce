//! Rays and shapes that are cast in each tick, as components.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::{
    ecs::{entity::EntityHashMap, entity_disabling::Disabled},
    prelude::*,
    reflect::{GetPath, structs::DynamicStruct},
};
use bevy_octree::{casters::CasterSystems, prelude::*};
use fastrand::Rng;

use crate::{
    common::*,
    spatial_query::{ALL, ask, direction, random_app, vector},
};

fn new_app() -> App {
    app(BroadPhaseMethod::default())
}

fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn(bundle).id()
}

/// A row of cubes of side 1 along an axis, each two units behind the other, the first at 2.
fn row(app: &mut App, axis: Vec3, count: usize) -> Vec<Entity> {
    (1..=count)
        .map(|i| {
            let at = Transform::from_translation(axis * 2.0 * i as f32);
            spawn(app, (CollisionShape::default(), at))
        })
        .collect()
}

/// What a ray caster met, and how far away.
fn met(app: &App, caster: Entity) -> Vec<(Entity, f32)> {
    let hits = get::<RayHits>(app, caster);
    assert_eq!(hits.nearest(), hits.iter().next());
    hits.into_iter()
        .map(|hit| (hit.entity, hit.distance))
        .collect()
}

/// What a shape caster met, and how far away.
fn touched(app: &App, caster: Entity) -> Vec<(Entity, f32)> {
    get::<ShapeHits>(app, caster)
        .iter()
        .map(|hit| (hit.entity, hit.distance))
        .collect()
}

fn assert_near(found: &[(Entity, f32)], expected: &[(Entity, f32)]) {
    let is_near =
        |((a, x), (b, y)): (&(Entity, f32), &(Entity, f32))| a == b && (x - y).abs() < 1e-3;
    let are_near = found.len() == expected.len() && found.iter().zip(expected).all(is_near);
    assert!(are_near, "{found:?} {expected:?}");
}

#[test]
fn the_nearest_few_are_met() {
    let mut app = new_app();
    app.world_mut().register_disabling_component::<Parked>();
    let cubes = row(&mut app, Vec3::NEG_Z, 4);
    let all = [0, 1, 2, 3].map(|i| (cubes[i], 1.5 + 2.0 * i as f32));
    let caster = spawn(&mut app, RayCaster::default());
    assert_eq!(met(&app, caster), []);
    tick(&mut app, 1);
    assert_eq!(met(&app, caster), all[..1]);
    for (max_hits, length, count) in [
        (3, f32::MAX, 3),
        (u32::MAX, f32::INFINITY, 4),
        (u32::MAX, 5.5, 3),
        (1, 1.5, 1),
        (1, 1.4, 0),
        (0, 100.0, 0),
        (2, 0.0, 0),
        (2, -1.0, 0),
        (2, f32::NAN, 0),
    ] {
        let with = RayCaster::default()
            .with_length(length)
            .with_max_hits(max_hits);
        *get_mut(&mut app, caster) = with;
        tick(&mut app, 1);
        assert_eq!(met(&app, caster), all[..count], "{max_hits} {length}");
    }
    *get_mut(&mut app, caster) = RayCaster::default();
    tick(&mut app, 1);
    assert_eq!(
        get::<RayHits>(&app, caster).of(cubes[0]).unwrap().point,
        Vec3::NEG_Z * 1.5
    );
    assert_eq!(get::<RayHits>(&app, caster).of(cubes[1]), None);
    get_mut::<RayCaster>(&mut app, caster).enabled = false;
    tick(&mut app, 1);
    assert_eq!(met(&app, caster), []);
    // What is gone is no longer met.
    get_mut::<RayCaster>(&mut app, caster).enabled = true;
    app.world_mut().despawn(cubes[0]);
    tick(&mut app, 1);
    assert_eq!(met(&app, caster), all[1..2]);
    app.world_mut().entity_mut(caster).insert(Disabled);
    tick(&mut app, 1);
    assert_eq!(met(&app, caster), []);
    // By another component than Bevy's.
    app.world_mut().entity_mut(caster).remove::<Disabled>();
    tick(&mut app, 1);
    assert_eq!(met(&app, caster), all[1..2]);
    app.world_mut().entity_mut(caster).insert(Parked);
    tick(&mut app, 1);
    assert_eq!(met(&app, caster), []);
}

/// Disables, as `Disabled` does.
#[derive(Component)]
struct Parked;

/// What is disabled, by whatever component, is still where it is, and so is what hangs on it.
#[test]
fn what_hangs_on_something_disabled_casts_from_where_it_is() {
    let mut app = new_app();
    app.world_mut().register_disabling_component::<Parked>();
    let ahead = row(&mut app, Vec3::X, 1)[0];
    let ship = spawn(&mut app, Transform::from_xyz(-3.0, 0.0, 0.0));
    let gun = spawn(
        &mut app,
        (ChildOf(ship), RayCaster::new(Vec3::ZERO, Dir3::X)),
    );
    tick(&mut app, 1);
    let before = met(&app, gun);
    assert_eq!(before.len(), 1);
    assert_eq!(before[0].0, ahead);
    app.world_mut().entity_mut(ship).insert(Disabled);
    tick(&mut app, 1);
    assert_eq!(met(&app, gun), before);
    app.world_mut()
        .entity_mut(ship)
        .remove::<Disabled>()
        .insert(Parked);
    tick(&mut app, 1);
    assert_eq!(met(&app, gun), before);
}

/// As everything that hangs on something, in the very tick in which that moves.
#[test]
fn casters_go_with_what_they_hang_on() {
    let mut app = new_app();
    let [ahead, above] = [Vec3::X, Vec3::Y].map(|axis| row(&mut app, axis, 1)[0]);
    let ship = spawn(
        &mut app,
        Transform::from_xyz(-3.0, 0.0, 0.0).with_scale(Vec3::new(2.0, 1.0, 1.0)),
    );
    let turret = spawn(
        &mut app,
        (ChildOf(ship), Transform::from_xyz(0.5, 0.0, 0.0)),
    );
    let gun = (
        ChildOf(turret),
        RayCaster::new(Vec3::X * 0.25, Dir3::X),
        ShapeCaster::new(Sphere::new(0.1), Vec3::X * 0.25, Dir3::X),
    );
    let gun = spawn(&mut app, gun);
    tick(&mut app, 1);
    // From -3 + 2 * 0.75 to the side of the cube; the ball is as large as the scale.
    assert_eq!(met(&app, gun), [(ahead, 3.0)]);
    assert_near(&touched(&app, gun), &[(ahead, 2.8)]);
    // Without propagation, and without a tick in between.
    let mut at = get_mut::<Transform>(&mut app, ship);
    at.translation = Vec3::Y * -3.0;
    at.rotation = Quat::from_rotation_z(FRAC_PI_2);
    tick(&mut app, 1);
    assert_near(&met(&app, gun), &[(above, 3.0)]);
    assert_near(&touched(&app, gun), &[(above, 2.8)]);
    // By its own velocity, within the tick.
    app.world_mut()
        .entity_mut(ship)
        .insert(Velocity(Vec3::Y * TICKS_PER_SECOND));
    tick(&mut app, 1);
    assert_near(&met(&app, gun), &[(above, 2.0)]);
    app.world_mut().entity_mut(turret).remove::<ChildOf>();
    tick(&mut app, 1);
    assert_near(&met(&app, gun), &[(ahead, 0.75)]);
}

/// An arrow that is painted on the entity shows where it goes.
#[test]
fn a_direction_is_bent_as_the_entity_is() {
    let mut app = new_app();
    let target = (
        CollisionShape::sphere(0.1),
        Transform::from_xyz(6.0, 2.0, 0.0),
    );
    let target = spawn(&mut app, target);
    let diagonal = Dir3::new(Vec3::new(1.0, 1.0, 0.0)).unwrap();
    let wide = Transform::from_scale(Vec3::new(3.0, 1.0, 1.0));
    let caster = spawn(&mut app, (RayCaster::new(Vec3::ZERO, diagonal), wide));
    tick(&mut app, 1);
    assert_near(&met(&app, caster), &[(target, 40f32.sqrt() - 0.1)]);
    let ray = get::<RayCaster>(&app, caster).global_ray(&wide.into());
    let ray = ray.unwrap();
    assert!(
        ray.direction
            .abs_diff_eq(Vec3::new(3.0, 1.0, 0.0).normalize(), 1e-6)
    );
    // A mirror turns it around.
    *get_mut(&mut app, caster) =
        Transform::from_xyz(12.0, 0.0, 0.0).with_scale(Vec3::new(-3.0, 1.0, 1.0));
    tick(&mut app, 1);
    assert_near(&met(&app, caster), &[(target, 40f32.sqrt() - 0.1)]);
}

#[test]
fn who_is_nowhere_meets_nothing() {
    let mut app = new_app();
    row(&mut app, Vec3::NEG_Z, 1);
    let both = || (RayCaster::default(), ShapeCaster::default());
    let caster = spawn(&mut app, both());
    for at in [
        Transform::from_scale(Vec3::ZERO),
        Transform::from_scale(Vec3::new(1.0, 1.0, 0.0)),
        Transform::from_scale(Vec3::NAN),
        Transform::from_xyz(0.0, f32::INFINITY, 0.0),
        Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ] {
        *get_mut(&mut app, caster) = Transform::IDENTITY;
        tick(&mut app, 1);
        assert_eq!(
            (met(&app, caster).len(), touched(&app, caster).len()),
            (1, 1)
        );
        *get_mut(&mut app, caster) = at;
        tick(&mut app, 1);
        assert_eq!(
            (met(&app, caster), touched(&app, caster)),
            (vec![], vec![]),
            "{at:?}"
        );
        // A turn that is none is lost in what Bevy makes of it.
        if at.rotation.length() != 0.0 {
            assert_eq!(RayCaster::default().global_ray(&at.into()), None);
        }
    }
    *get_mut(&mut app, caster) = Transform::IDENTITY;
    tick(&mut app, 1);
    assert_eq!(met(&app, caster).len(), 1);
    app.world_mut().entity_mut(caster).remove::<Transform>();
    tick(&mut app, 1);
    assert_eq!((met(&app, caster), touched(&app, caster)), (vec![], vec![]));
    // Bad casters are no better.
    let good = spawn(&mut app, both());
    get_mut::<RayCaster>(&mut app, good).origin = Vec3::NAN;
    let mut shape = get_mut::<ShapeCaster>(&mut app, good);
    shape.rotation = Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0);
    tick(&mut app, 1);
    assert_eq!((met(&app, good), touched(&app, good)), (vec![], vec![]));
}

collision_layers! {
    enum Layer { Scenery, Friend, Foe }
}

#[test]
fn filters_say_who_is_seen() {
    let mut app = new_app();
    let cubes = row(&mut app, Vec3::NEG_Z, 5);
    let world = app.world_mut();
    world.entity_mut(cubes[1]).insert(Sensor);
    world
        .entity_mut(cubes[2])
        .insert(CollisionLayers::new(Layer::Friend, LayerMask::ALL));
    world.entity_mut(cubes[3]).insert(CollisionLayers::NONE);
    let elsewhere = world.spawn_empty().id();
    world
        .entity_mut(cubes[4])
        .insert(InCollisionWorld(elsewhere));
    let own = (
        CollisionShape::sphere(0.4),
        RayCaster::default().with_max_hits(u32::MAX),
        ShapeCaster::new(Sphere::new(0.1), Vec3::ZERO, Dir3::NEG_Z).with_max_hits(u32::MAX),
    );
    let caster = spawn(&mut app, own);
    let seen = |app: &mut App, filter: CasterFilter| {
        get_mut::<RayCaster>(app, caster).filter = filter.clone();
        get_mut::<ShapeCaster>(app, caster).filter = filter;
        tick(app, 1);
        let by = |hits: Vec<(Entity, f32)>| hits.into_iter().map(|(entity, _)| entity);
        let seen: Vec<_> = by(met(app, caster)).collect();
        assert!(by(touched(app, caster)).eq(seen.iter().copied()));
        seen
    };
    let all = CasterFilter::default();
    // Sensors are seen like all others; and those on no layer, as long as no layers are named.
    assert_eq!(seen(&mut app, all.clone()), cubes[..4]);
    assert_eq!(
        seen(&mut app, all.clone().without_sensors()),
        [cubes[0], cubes[2], cubes[3]]
    );
    assert_eq!(seen(&mut app, all.clone().on(Layer::Friend)), [cubes[2]]);
    assert_eq!(
        seen(&mut app, all.clone().on([Layer::Scenery, Layer::Friend])),
        cubes[..3]
    );
    assert!(seen(&mut app, all.clone().on(Layer::Foe)).is_empty());
    assert!(seen(&mut app, all.clone().on([])).is_empty());
    assert_eq!(
        seen(&mut app, all.clone().excluding(cubes[..2].iter().copied())),
        cubes[2..4]
    );
    let with_itself = all.clone().ignoring(CasterIgnores::Nothing);
    assert_eq!(seen(&mut app, with_itself)[..2], [caster, cubes[0]]);
    app.world_mut()
        .entity_mut(caster)
        .insert(InCollisionWorld(elsewhere));
    assert_eq!(seen(&mut app, all), cubes[4..]);
}

/// A tank: hull, turret and gun; another hangs on the same level.
#[test]
fn a_family_is_not_seen_by_its_members() {
    let mut app = new_app();
    let target = row(&mut app, Vec3::NEG_Z, 1)[0];
    let tank = spawn(&mut app, Transform::default());
    let hull = spawn(&mut app, (CollisionShape::sphere(1.0), ChildOf(tank)));
    let turret = spawn(&mut app, (CollisionShape::sphere(0.5), ChildOf(tank)));
    let gun = spawn(
        &mut app,
        (
            CollisionShape::sphere(0.1),
            ChildOf(turret),
            RayCaster::default(),
        ),
    );
    let bolt = spawn(&mut app, (CollisionShape::sphere(0.05), ChildOf(gun)));
    let seen = |app: &mut App, ignores| {
        let mut caster = get_mut::<RayCaster>(app, gun);
        caster.filter.ignores = ignores;
        caster.max_hits = u32::MAX;
        tick(app, 1);
        let mut seen: Vec<_> = met(app, gun)
            .into_iter()
            .map(|(entity, _)| entity)
            .collect();
        seen.sort();
        seen
    };
    let sorted = |mut all: Vec<Entity>| {
        all.sort();
        all
    };
    let tanks = [hull, turret, bolt, target];
    assert_eq!(seen(&mut app, CasterIgnores::Itself), sorted(tanks.into()));
    assert_eq!(
        seen(&mut app, CasterIgnores::Nothing),
        sorted([&tanks[..], &[gun]].concat())
    );
    assert_eq!(seen(&mut app, CasterIgnores::Family), [target]);
    app.world_mut().entity_mut(gun).remove::<ChildOf>();
    assert_eq!(
        seen(&mut app, CasterIgnores::Family),
        sorted(vec![hull, turret, target])
    );
    // Whoever is its own ancestor is nowhere.
    app.world_mut().entity_mut(gun).insert(ChildOf(bolt));
    assert!(seen(&mut app, CasterIgnores::Family).is_empty());
}

/// A ship of a hull and two wings, with eyes in its hull, in a wing, and on a mast that has no shape.
#[test]
fn a_body_is_not_seen_from_any_of_its_parts() {
    let mut app = new_app();
    let target = row(&mut app, Vec3::NEG_Z * 4.0, 1)[0];
    let ball = || CollisionShape::sphere(0.5);
    let fleet = spawn(&mut app, Transform::default());
    let ship = spawn(&mut app, (CollisionBody::default(), ChildOf(fleet)));
    let part = |app: &mut App, z: f32, parent| {
        let at = Transform::from_xyz(0.0, 0.0, z);
        spawn(app, (ball(), at, ChildOf(parent)))
    };
    let hull = part(&mut app, 0.0, ship);
    let wing = part(&mut app, -0.5, hull);
    // Those are things of their own.
    let boat = part(&mut app, -1.0, ship);
    app.world_mut()
        .entity_mut(boat)
        .insert(CollisionBody::default());
    let other = part(&mut app, -2.0, fleet);
    let mast = spawn(&mut app, ChildOf(hull));
    let seen = |app: &mut App, on: Entity, caster: RayCaster| {
        app.world_mut()
            .entity_mut(on)
            .insert(caster.with_max_hits(u32::MAX));
        tick(app, 1);
        let mut seen: Vec<_> = met(app, on).into_iter().map(|(entity, _)| entity).collect();
        app.world_mut().entity_mut(on).remove::<RayCaster>();
        seen.sort();
        seen
    };
    let sorted = |mut all: Vec<Entity>| {
        all.sort();
        all
    };
    assert_eq!(CasterIgnores::default(), CasterIgnores::Body);
    for on in [ship, hull, mast] {
        let found = seen(&mut app, on, RayCaster::default());
        assert_eq!(found, sorted(vec![boat, other, target]), "{on}");
    }
    // From a wing, which is in front.
    let found = seen(&mut app, wing, RayCaster::new(Vec3::Z, Dir3::NEG_Z));
    assert_eq!(found, sorted(vec![boat, other, target]));
    // The boat sees the ship on which it hangs.
    let back = RayCaster::new(Vec3::NEG_Z * 0.25, Dir3::Z);
    assert_eq!(seen(&mut app, boat, back), sorted(vec![hull, wing]));
    // On nothing that is a body, the entity alone is not seen.
    let from_other = seen(&mut app, other, RayCaster::new(Vec3::Z * 4.0, Dir3::NEG_Z));
    assert_eq!(from_other, sorted(vec![hull, wing, boat, target]));
    let own =
        RayCaster::default().with_filter(CasterFilter::default().ignoring(CasterIgnores::Itself));
    assert_eq!(
        seen(&mut app, hull, own),
        sorted(vec![wing, boat, other, target])
    );
    // Shapes that are cast, too.
    let ahead = ShapeCaster::new(Sphere::new(0.1), Vec3::ZERO, Dir3::NEG_Z);
    app.world_mut()
        .entity_mut(mast)
        .insert(ahead.with_max_hits(u32::MAX));
    tick(&mut app, 1);
    let mut found: Vec<_> = get::<ShapeHits>(&app, mast)
        .iter()
        .map(|hit| hit.entity)
        .collect();
    found.sort();
    assert_eq!(found, sorted(vec![boat, other, target]));
    // No longer a body.
    app.world_mut().entity_mut(mast).remove::<ShapeCaster>();
    app.world_mut().entity_mut(ship).remove::<CollisionBody>();
    let found = seen(&mut app, hull, RayCaster::default());
    assert_eq!(found, sorted(vec![wing, boat, other, target]));
}

/// What bounces on its way is where it has come to; and who hears of a contact reads hits of the
/// same tick.
#[test]
fn hits_are_those_of_the_end_of_the_tick() {
    #[derive(Resource, Default)]
    struct Seen(Vec<f32>);
    let mut app = new_app();
    app.init_resource::<Seen>();
    let wall = spawn(
        &mut app,
        (
            CollisionShape::cuboid(1.0, 9.0, 9.0),
            Transform::from_xyz(5.5, 0.0, 0.0),
            CollisionEventsEnabled,
        ),
    );
    let bullet = (
        CollisionShape::sphere(0.5),
        Swept::stopping(),
        Velocity(Vec3::X * 10.0 * TICKS_PER_SECOND),
        RayCaster::new(Vec3::ZERO, Dir3::X),
    );
    let bullet = spawn(&mut app, bullet);
    let look = spawn(
        &mut app,
        (
            RayCaster::new(Vec3::Y * 9.0, Dir3::NEG_Y),
            Transform::from_xyz(4.5, 0.0, 0.0),
        ),
    );
    app.world_mut().entity_mut(wall).observe(
        |event: On<CollisionStarted>, hits: Query<&RayHits>, mut seen: ResMut<Seen>| {
            let hits = hits.get(event.b).unwrap();
            seen.0.extend(hits.iter().map(|hit| hit.distance));
        },
    );
    tick(&mut app, 1);
    assert_near(&met(&app, bullet), &[(wall, 0.5)]);
    assert_near(&met(&app, look), &[(bullet, 8.5)]);
    let seen = &app.world().resource::<Seen>().0;
    assert!(seen.len() == 1 && (seen[0] - 0.5).abs() < 1e-3, "{seen:?}");
}

#[test]
fn hits_count_as_changed_only_where_they_are() {
    #[derive(Resource, Default)]
    struct Changes(u32);
    let mut app = new_app();
    app.init_resource::<Changes>().add_systems(
        FixedPostUpdate,
        (|hits: Query<(), Changed<RayHits>>, mut changes: ResMut<Changes>| {
            changes.0 += hits.iter().count() as u32;
        })
        .after(CasterSystems),
    );
    let cubes = row(&mut app, Vec3::NEG_Z, 2);
    let caster = spawn(&mut app, RayCaster::default());
    let changes = |app: &mut App| {
        tick(app, 1);
        std::mem::take(&mut app.world_mut().resource_mut::<Changes>().0)
    };
    assert_eq!([0; 3].map(|_| changes(&mut app)), [1, 0, 0]);
    get_mut::<Transform>(&mut app, caster).translation.z = 0.5;
    assert_eq!([0; 2].map(|_| changes(&mut app)), [1, 0]);
    // What happens behind the first is not its matter.
    get_mut::<Transform>(&mut app, cubes[1]).translation.z -= 0.5;
    assert_eq!([0; 2].map(|_| changes(&mut app)), [0, 0]);
    app.world_mut().despawn(cubes[0]);
    assert_eq!([0; 2].map(|_| changes(&mut app)), [1, 0]);
    // Turned in its place, in steps.
    for _ in 0..4 {
        get_mut::<Transform>(&mut app, caster).rotate_y(PI);
        assert_eq!([0; 2].map(|_| changes(&mut app)), [1, 0]);
    }
}

#[test]
fn shapes_are_cast_as_they_are_told() {
    let mut app = new_app();
    let cubes = row(&mut app, Vec3::NEG_Z, 3);
    let plank = || CollisionShape::cuboid(0.2, 0.2, 1.0);
    let caster = spawn(&mut app, ShapeCaster::new(plank(), Vec3::ZERO, Dir3::NEG_Z));
    let distances = |app: &mut App, with: ShapeCaster| {
        *get_mut(app, caster) = with;
        tick(app, 1);
        touched(app, caster)
    };
    let along = || ShapeCaster::new(plank(), Vec3::ZERO, Dir3::NEG_Z);
    assert_near(&distances(&mut app, along()), &[(cubes[0], 1.0)]);
    let across = along().with_rotation(Quat::from_rotation_y(FRAC_PI_2));
    assert_near(&distances(&mut app, across), &[(cubes[0], 1.4)]);
    let all = along().with_max_hits(u32::MAX).with_length(4.0);
    assert_near(
        &distances(&mut app, all),
        &[(cubes[0], 1.0), (cubes[1], 3.0)],
    );
    let aside = ShapeCaster::new(plank(), Vec3::X * 0.7, Dir3::NEG_Z);
    assert_near(&distances(&mut app, aside), &[]);
    // What it starts in touch with is in the way, unless it is told not to be.
    let inside = || ShapeCaster::new(plank(), Vec3::NEG_Z * 1.2, Dir3::Z);
    assert_near(&distances(&mut app, inside()), &[(cubes[0], 0.0)]);
    let onward = inside().with_options(ShapeCastOptions::DEFAULT.ignore_start());
    assert_near(&distances(&mut app, onward), &[]);
    // It grows with the entity.
    let at = Transform::from_scale(Vec3::splat(5.0));
    let start = along().global_start(&at.into()).unwrap();
    assert_eq!(start, (at, Dir3::NEG_Z));
    *get_mut(&mut app, caster) = at.with_scale(Vec3::new(5.0, 1.0, 1.0));
    let aside = ShapeCaster::new(plank(), Vec3::X * 0.15, Dir3::NEG_Z);
    assert_near(&distances(&mut app, aside), &[(cubes[0], 1.0)]);
}

/// Whatever is asked by hand, at the end of the tick.
#[test]
fn casters_answer_as_queries_do() {
    let mut rng = Rng::with_seed(3);
    let mut app = random_app(&mut rng, BroadPhaseMethod::default(), 300);
    let ball = Shape::sphere(0.3);
    let mut casters = vec![];
    for number in 0..200 {
        let (from, to) = (vector(&mut rng, 12.0), vector(&mut rng, 6.0));
        let way = Dir3::new(to - from).unwrap_or(Dir3::X);
        let max_hits = 1 + number % 3;
        let ray = RayCaster::new(Vec3::ZERO, Dir3::NEG_Z).with_max_hits(max_hits);
        let shape = ShapeCaster::new(ball.clone(), Vec3::ZERO, Dir3::NEG_Z)
            .with_max_hits(max_hits)
            .with_length(15.0);
        let at = Transform::from_translation(from).looking_to(way, direction(&mut rng));
        let caster = (ray.with_length(15.0), shape, at);
        casters.push((spawn(&mut app, caster), at, max_hits as usize));
    }
    tick(&mut app, 1);
    let all = casters.clone();
    let expected = ask(&mut app, move |spatial| {
        let (mut rays, mut shapes, mut expected) = (vec![], vec![], vec![]);
        for (_, at, max_hits) in &all {
            let (way, moving) = (at.forward(), Placed::new(&ball, at));
            spatial.ray_hits(Ray3d::new(at.translation, way), 15.0, &ALL, &mut rays);
            let options = ShapeCastOptions::DEFAULT;
            spatial.shape_hits(moving, way, 15.0, &ALL, &options, &mut shapes);
            let first = spatial.cast_shape(&ball, at, way, 15.0, &ALL);
            assert_eq!(
                first.map(|hit| hit.distance),
                shapes.first().map(|hit| hit.distance)
            );
            rays.truncate(*max_hits);
            shapes.truncate(*max_hits);
            expected.push((
                rays.iter()
                    .map(|hit| (hit.entity, hit.distance))
                    .collect::<Vec<_>>(),
                shapes
                    .iter()
                    .map(|hit| (hit.entity, hit.distance))
                    .collect::<Vec<_>>(),
            ));
        }
        expected
    });
    let mut count = 0;
    for ((caster, ..), (rays, shapes)) in casters.iter().zip(&expected) {
        assert_near(&met(&app, *caster), rays);
        assert_near(&touched(&app, *caster), shapes);
        count += rays.len() + shapes.len();
    }
    assert!(count > 200, "{count}");
}

/// As an editor writes them: what is not said is as by default.
#[test]
fn casters_are_data() {
    let mut app = new_app();
    row(&mut app, Vec3::X, 1);
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    for path in [
        "RayCaster",
        "RayHits",
        "ShapeCaster",
        "ShapeHits",
        "CasterFilter",
        "CasterIgnores",
    ] {
        let path = format!("bevy_octree::{path}");
        let registration = registry.get_with_type_path(&path);
        let registration = registration.unwrap_or_else(|| panic!("{path} is not registered"));
        assert!(registration.data::<ReflectDefault>().is_some(), "{path}");
    }
    let caster = app.world_mut().spawn_empty().id();
    let mut written = DynamicStruct::default();
    written.insert("direction", Dir3::X);
    let reflect = registry.get(std::any::TypeId::of::<RayCaster>()).unwrap();
    let reflect = reflect.data::<ReflectComponent>().unwrap();
    reflect.insert(&mut app.world_mut().entity_mut(caster), &written, &registry);
    assert_eq!(
        *get::<RayCaster>(&app, caster),
        RayCaster::new(Vec3::ZERO, Dir3::X)
    );
    tick(&mut app, 1);
    let hits = get::<RayHits>(&app, caster);
    let distance = hits.path::<f32>("hits[0].distance");
    assert_eq!(distance.ok(), Some(&1.5));
}

#[test]
fn entities_in_casters_and_hits_are_mapped() {
    let mut app = new_app();
    let cube = row(&mut app, Vec3::NEG_Z, 1)[0];
    let [other, copy] = [(); 2].map(|()| app.world_mut().spawn_empty().id());
    let filter = CasterFilter::default().excluding([other]);
    let caster = spawn(&mut app, RayCaster::default().with_filter(filter));
    tick(&mut app, 1);
    let mut hits = get::<RayHits>(&app, caster).clone();
    RayHits::map_entities(&mut hits, &mut EntityHashMap::from_iter([(cube, copy)]));
    assert_eq!(hits.nearest().unwrap().entity, copy);
    let mut mapped = get::<RayCaster>(&app, caster).clone();
    RayCaster::map_entities(&mut mapped, &mut EntityHashMap::from_iter([(other, copy)]));
    assert_eq!(mapped.filter, CasterFilter::default().excluding([copy]));
}

/// What is scaled to nothing along an axis has a place and a turn all the same.
#[test]
fn flat_shapes_are_cast_and_turns_need_no_unit_length() {
    let mut app = new_app();
    let cubes = row(&mut app, Vec3::NEG_Z, 1);
    let flat = Transform::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let flat = spawn(&mut app, (ShapeCaster::default(), flat));
    let long = ShapeCaster::default().with_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 3.0));
    let long = spawn(&mut app, long);
    let none = ShapeCaster::default().with_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    let none = spawn(&mut app, none);
    tick(&mut app, 1);
    for caster in [flat, long] {
        assert_near(&touched(&app, caster), &[(cubes[0], 1.0)]);
    }
    assert_eq!(touched(&app, none), []);
}
