//! What is allocated, to the byte: as much after a million rounds as after a few, linear in the
//! objects, and all of it in the figures.

use crate::{allocator, app};

use allocator::{alone, assert_flat, live, peak_of};
use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_octree::{
    broad_phase::{PairFilter, ProxyId, SpatialIndex},
    prelude::*,
    scene::Cube,
};
use fastrand::Rng;

const METHODS: [&str; 4] = ["auto", "linear", "object", "exhaustive"];

fn index(method: &str) -> SpatialIndex {
    SpatialIndex::new(&method.parse().unwrap())
}

fn cube(at: Vec3) -> Aabb3d {
    Aabb3d::new(at, Vec3::splat(0.5))
}

fn place(rng: &mut Rng, reach: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| (rng.f32() * 2.0 - 1.0) * reach))
}

#[test]
fn an_index_that_is_emptied_and_filled_stays_as_large() {
    let _alone = alone();
    for method in METHODS {
        let mut index = index(method);
        assert_flat(method, 1000, 1_000_000, || {
            let id = index.insert(cube(Vec3::ZERO)).unwrap();
            index.update();
            index.remove(id);
            index.update();
        });
        assert_flat(method, 100, 5000, || {
            let ids: Vec<_> = (0..200)
                .map(|x| index.insert(cube(Vec3::X * (x as f32 * 0.3))).unwrap())
                .collect();
            index.find_pairs();
            ids.iter().for_each(|id| assert!(index.remove(*id)));
            index.update();
        });
    }
}

#[test]
fn what_changes_between_two_updates_is_noted_once() {
    let _alone = alone();
    for method in METHODS {
        let mut index = index(method);
        let id = index.insert(cube(Vec3::ZERO)).unwrap();
        let ground = index.insert_unbounded(None).unwrap();
        let mut world = 0;
        assert_flat(method, 10, 100_000, || {
            world += 1;
            for id in [id, ground] {
                index
                    .set_filter(id, PairFilter { world, ..default() })
                    .unwrap();
                index.touch(id);
            }
            index.set(id, &cube(Vec3::X * world as f32)).unwrap();
            index.touch_all();
        });
    }
}

/// A crowd that mills about, with some that come and go, change their filters, and fly far away and
/// back.
struct Crowd {
    index: SpatialIndex,
    objects: Vec<(ProxyId, Vec3, Vec3)>,
    rng: Rng,
    ticks: u64,
}

impl Crowd {
    fn new(method: &str, count: usize) -> Self {
        let mut crowd = Self {
            index: index(method),
            objects: vec![],
            rng: Rng::with_seed(1),
            ticks: 0,
        };
        crowd.objects.reserve_exact(count);
        for _ in 0..count {
            let at = place(&mut crowd.rng, 8.0);
            let velocity = place(&mut crowd.rng, 0.1);
            crowd
                .objects
                .push((crowd.index.insert(cube(at)).unwrap(), at, velocity));
        }
        crowd
    }

    fn tick(&mut self) {
        let Self {
            index,
            objects,
            rng,
            ticks,
        } = self;
        *ticks += 1;
        for (id, at, velocity) in objects.iter_mut() {
            for axis in 0..3 {
                velocity[axis] = if at[axis].abs() > 8.0 {
                    -at[axis].signum() * 0.1
                } else {
                    velocity[axis]
                };
            }
            *at += *velocity;
            index.set(*id, &cube(*at)).unwrap();
        }
        let (id, at, _) = rng.choice(objects.iter_mut()).unwrap();
        match rng.u8(0..3) {
            0 => {
                index.remove(*id);
                *id = index.insert(cube(*at)).unwrap();
            }
            1 => index
                .set_filter(
                    *id,
                    PairFilter {
                        memberships: rng.u32(1..4),
                        ..default()
                    },
                )
                .unwrap(),
            _ => {
                let far = if ticks.is_multiple_of(100) { 1e4 } else { 1.0 };
                index.set(*id, &cube(*at * far)).unwrap();
            }
        }
        index.find_pairs();
    }
}

#[test]
fn a_crowd_takes_as_much_as_ever_and_all_of_it_is_counted() {
    let _alone = alone();
    for method in METHODS {
        let before = live();
        let mut crowd = Crowd::new(method, 300);
        // Some lists are seldom as long as they can be.
        assert_flat(method, 16_000, 16_000, || crowd.tick());
        let taken = live() - before - crowd.objects.capacity() * size_of::<(ProxyId, Vec3, Vec3)>();
        let told = crowd.index.memory_bytes();
        // The harness may begin another test meanwhile.
        assert!(
            told <= taken && taken - told < 16_384,
            "{method}: {taken} bytes, of which {told} are told"
        );
    }
}

/// Small objects on one layer under large ones on another, which do not meet.
#[test]
fn pairs_that_are_ruled_out_take_no_memory() {
    const SMALL: usize = 4000;
    const LARGE: usize = 400;
    let _alone = alone();
    for method in METHODS {
        for (step, movers) in [(0.01, 1), (0.01, 8), (1.0, 1), (1.0, 8)] {
            let mut rng = Rng::with_seed(2);
            let mut objects: Vec<(Option<ProxyId>, Vec3, Vec3)> = Vec::with_capacity(SMALL + LARGE);
            objects.extend((0..SMALL).map(|_| (None, place(&mut rng, 40.0), Vec3::splat(0.2))));
            objects.extend((0..LARGE).map(|_| (None, place(&mut rng, 1.0), Vec3::splat(50.0))));
            let mut found = 0;
            let peak = peak_of(|| {
                let mut index = index(method);
                for (place, (id, at, half)) in objects.iter_mut().enumerate() {
                    let layer = if place < SMALL { 1 } else { 2 };
                    let new = index.insert(Aabb3d::new(*at, *half)).unwrap();
                    let filters = if place < SMALL { 1 } else { 0 };
                    index
                        .set_filter(
                            new,
                            PairFilter {
                                memberships: layer,
                                filters,
                                ..default()
                            },
                        )
                        .unwrap();
                    *id = Some(new);
                }
                for tick in 0..12 {
                    for (place, (id, at, half)) in objects.iter_mut().enumerate() {
                        // Different ones, by and by.
                        if (place + tick) % movers == 0 {
                            *at += Vec3::splat(step);
                            index.set(id.unwrap(), &Aabb3d::new(*at, *half)).unwrap();
                        }
                    }
                    found = index.find_pairs().len();
                }
            });
            let each = peak / (SMALL + LARGE);
            assert!(
                each < 1000 && found < SMALL,
                "{method}, {movers}, {step}: {each} bytes each, {found} pairs"
            );
        }
    }
}

#[test]
fn an_app_takes_as_much_after_many_ticks_as_after_a_few() {
    let _alone = alone();
    let mut app = app(1.0 / 64.0);
    for x in [-1.0, 1.0] {
        let wall = CollisionShape::from_half_size(Vec3::new(0.1, 5.0, 5.0));
        app.world_mut()
            .spawn((wall, Transform::from_xyz(x, 0.0, 0.0)));
    }
    let ball = CollisionShape::sphere(0.1);
    let bounce = Bounce::Reflect { restitution: 1.0 };
    app.world_mut().spawn((
        ball,
        Velocity(Vec3::X * 5.0),
        bounce,
        CollisionEventsEnabled,
        CollidingEntities::default(),
        RayCaster::new(Vec3::ZERO, Dir3::X).with_max_hits(4),
        ShapeCaster::new(Sphere::new(0.05), Vec3::ZERO, Dir3::X).with_max_hits(4),
    ));
    assert_flat("a ball between two walls", 1000, 30_000, || app.update());
    assert_flat("cubes that come and go", 100, 3000, || {
        let cubes = [(); 4].map(|()| app.world_mut().spawn(Cube).id());
        app.update();
        cubes
            .into_iter()
            .for_each(|cube| _ = app.world_mut().despawn(cube));
        app.update();
    });
}

#[test]
fn bodies_take_as_much_after_many_ticks_as_after_a_few() {
    let _alone = alone();
    let mut app = app(1.0 / 64.0);
    for x in [-4.0, 4.0] {
        let wall = CollisionShape::from_half_size(Vec3::new(0.1, 5.0, 5.0));
        app.world_mut()
            .spawn((wall, Transform::from_xyz(x, 0.0, 0.0)));
    }
    let ship = |app: &mut App| {
        let bounce = Bounce::Reflect { restitution: 1.0 };
        let ship = (CollisionBody::default(), Velocity(Vec3::X * 900.0), bounce);
        let ship = app.world_mut().spawn((ship, Swept::default())).id();
        for x in [-0.5, 0.0, 0.5] {
            let part = (
                CollisionShape::sphere(0.4),
                Transform::from_xyz(x, 0.0, 0.0),
            );
            app.world_mut().spawn((part, ChildOf(ship)));
        }
        app.world_mut()
            .entity_mut(ship)
            .insert((CollisionEventsEnabled, CollidingEntities::default()));
        ship
    };
    let first = ship(&mut app);
    assert_flat("a ship between two walls", 1000, 5000, || app.update());
    let part = app.world().get::<Children>(first).unwrap()[0];
    assert_flat("ships that come and go, and lose a part", 200, 2000, || {
        let other = ship(&mut app);
        app.world_mut().entity_mut(part).insert(ChildOf(other));
        app.update();
        app.world_mut().entity_mut(part).insert(ChildOf(first));
        app.update();
        app.world_mut().despawn(other);
        app.update();
    });
}
