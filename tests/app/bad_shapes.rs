//! Numbers and lists that no shape can have, by every way in: each has its rule, is told of with the
//! entity, and harms nobody.

use bevy::{
    ecs::system::SystemState,
    math::{Dir3, Isometry3d},
    prelude::*,
};
use bevy_octree::{
    components::WorldAabb,
    narrow_phase::{BoundsError, Moving, NarrowPhase, Placed, Shape, Workspace},
    prelude::*,
    shape_data::{CoreDescription, PartDescription, ShapeDescription},
};
use fastrand::Rng;

use crate::common::{
    self,
    warnings::{on_this_thread, told},
};
use common::get;

/// Numbers of exporters and sliders.
const NUMBERS: [f32; 20] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    -1e-45,
    1e20,
    -1e20,
    1e-20,
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    -3.0,
    1e9,
    1e38,
];

/// Now and then the numbers are good.
struct Source {
    rng: Rng,
    is_good: bool,
}

impl Source {
    fn number(&mut self) -> f32 {
        if self.is_good || self.rng.u8(0..3) > 0 {
            self.rng.f32() * 2.0
        } else {
            NUMBERS[self.rng.usize(0..NUMBERS.len())]
        }
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    fn vectors(&mut self) -> Vec<Vec3> {
        let count = self.rng.usize(0..9);
        (0..count).map(|_| self.vector()).collect()
    }

    fn count(&mut self) -> u32 {
        [0, 1, 2, 3, 4, 7, u32::MAX, u32::MAX - 1, 1 << 31][self.rng.usize(0..9)]
    }

    fn polygons(&mut self) -> Vec<Vec<u32>> {
        let count = self.rng.usize(0..7);
        let mut polygon = || {
            let corners = self.rng.usize(0..6);
            (0..corners).map(|_| self.count() % 9).collect()
        };
        (0..count).map(|_| polygon()).collect()
    }

    fn core(&mut self) -> CoreDescription {
        let [a, b, c] = std::array::from_fn(|_| self.vector());
        let [radius, radius_top, height] = std::array::from_fn(|_| self.number());
        match self.rng.u8(0..8) {
            0 => CoreDescription::Segment { a, b },
            1 => CoreDescription::Triangle { a, b, c },
            2 => CoreDescription::Cuboid { half_size: a },
            3 => CoreDescription::Cylinder { radius, height },
            4 => CoreDescription::Cone { radius, height },
            5 => CoreDescription::ConicalFrustum {
                radius_top,
                radius_bottom: radius,
                height,
            },
            6 => CoreDescription::Convex {
                vertices: self.vectors(),
                polygons: self.polygons(),
            },
            _ => CoreDescription::ConvexHull {
                points: self.vectors(),
            },
        }
    }

    fn description(&mut self, depth: u32) -> ShapeDescription {
        self.is_good = self.rng.u8(0..4) == 0;
        let [a, b, c] = std::array::from_fn(|_| self.vector());
        let [radius, length, height] = std::array::from_fn(|_| self.number());
        match self.rng.u8(0..17) {
            0 => ShapeDescription::Cuboid { half_size: a },
            1 => ShapeDescription::Sphere { radius },
            2 => ShapeDescription::Capsule { radius, length },
            3 => ShapeDescription::CapsuleBetween { a, b, radius },
            4 => ShapeDescription::Cylinder { radius, height },
            5 => ShapeDescription::Cone { radius, height },
            6 => ShapeDescription::ConicalFrustum {
                radius_top: length,
                radius_bottom: radius,
                height,
            },
            7 => ShapeDescription::Tetrahedron {
                vertices: [a, b, c, self.vector()],
            },
            8 => ShapeDescription::Triangle { a, b, c },
            9 => ShapeDescription::Segment { a, b },
            10 => ShapeDescription::HalfSpace { normal: a },
            11 => ShapeDescription::Convex {
                vertices: self.vectors(),
                polygons: self.polygons(),
            },
            12 => ShapeDescription::ConvexHull {
                points: self.vectors(),
            },
            13 => ShapeDescription::Mesh {
                vertices: self.vectors(),
                polygons: self.polygons(),
                surface_only: self.rng.bool(),
            },
            14 => ShapeDescription::Rounded {
                core: self.core(),
                radius,
            },
            15 => {
                let count = if depth > 3 { 0 } else { self.rng.usize(0..4) };
                let mut part = || PartDescription {
                    position: self.vector(),
                    rotation: Quat::from_vec4(self.vector().extend(radius)),
                    shape: self.description(depth + 1),
                };
                ShapeDescription::Compound {
                    parts: (0..count).map(|_| part()).collect(),
                }
            }
            _ if self.rng.bool() => {
                let cells = [i32::MIN, -1, 0, 1, 2, i32::MAX];
                let mut cell = || cells[self.rng.usize(0..6)];
                ShapeDescription::Voxels {
                    cells: (0..4).map(|_| IVec3::new(cell(), cell(), cell())).collect(),
                    cell_size: radius,
                }
            }
            _ => {
                let (rows, columns) = (self.count(), self.count());
                let fits = self.rng.bool() && rows < 9 && columns < 9;
                let heights = if fits { rows * columns } else { 4 };
                ShapeDescription::HeightField {
                    rows,
                    columns,
                    heights: (0..heights).map(|_| self.number()).collect(),
                    cell_size: a.truncate(),
                    holes: (0..self.rng.usize(0..3))
                        .map(|_| [self.count(), self.count()])
                        .collect(),
                }
            }
        }
    }
}

/// Who listens to the log hears this thread alone.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    on_this_thread(&mut app, Update);
    app
}

/// Is it told of with its number?
fn names(lines: &[String], entity: Entity) -> bool {
    let id = entity.to_string();
    lines
        .iter()
        .any(|line| line.split_whitespace().any(|word| word == id))
}

fn check_told(app: &App, entities: &[Entity], lines: &[String], what: impl Fn(usize) -> String) {
    for (number, entity) in entities.iter().enumerate() {
        let world = app.world();
        let takes_part = world.get::<WorldAabb>(*entity).is_some_and(|aabb| {
            *aabb == WorldAabb::UNBOUNDED
                || aabb.min.is_finite() && aabb.max.is_finite() && aabb.min.cmple(aabb.max).all()
        });
        let has_error = world.get::<ShapeDescriptionError>(*entity).is_some();
        let is_told = names(lines, *entity);
        assert!(
            takes_part && !has_error || is_told,
            "{}: neither there nor told of",
            what(number)
        );
        assert!(!has_error || is_told, "{}", what(number));
    }
}

#[test]
fn whatever_data_says_makes_a_shape_or_is_told_of_with_its_entity() {
    let (mut made, mut refused) = (0, 0);
    for seed in 0..12 {
        let rng = Rng::with_seed(seed);
        let mut source = Source {
            rng,
            is_good: false,
        };
        let mut app = app();
        let ball = app
            .world_mut()
            .spawn((CollisionShape::sphere(0.5), Velocity::default()))
            .id();
        let all: Vec<ShapeDescription> = (0..120).map(|_| source.description(0)).collect();
        let entities: Vec<Entity> = all
            .iter()
            .map(|data| {
                app.world_mut()
                    .spawn((data.clone(), Velocity::default()))
                    .id()
            })
            .collect();
        let lines = told(|| {
            app.update();
            app.update();
        });
        check_told(&app, &entities, &lines, |number| {
            format!("{:?}", all[number])
        });
        for entity in &entities {
            let has_error = app.world().get::<ShapeDescriptionError>(*entity).is_some();
            refused += usize::from(has_error);
            made += usize::from(!has_error);
        }
        // They harm nobody.
        let before = get::<Transform>(&app, ball).translation;
        for (entity, data) in entities.iter().zip(&all) {
            let mut at = app.world_mut().get_mut::<Transform>(*entity).unwrap();
            at.translation = source.vector() * 0.5;
            at.scale = source.vector();
            if source.rng.u8(0..4) == 0 {
                at.rotation = Quat::from_vec4(source.vector().extend(1.0));
            }
            // Again, as an inspector would.
            *app.world_mut()
                .get_mut::<ShapeDescription>(*entity)
                .unwrap() = data.clone();
        }
        let lines = told(|| {
            app.update();
            app.update();
        });
        check_told(&app, &entities, &lines, |number| {
            let at = get::<Transform>(&app, entities[number]);
            format!("{:?} {at:?}", all[number])
        });
        assert_eq!(get::<Transform>(&app, ball).translation, before);
    }
    assert!(made > 200 && refused > 200, "{made} {refused}");
}

/// What was built of whatever numbers, against what is as it should be, and each other.
#[test]
fn whatever_could_be_built_passes_all_tests() {
    let mut source = Source {
        rng: Rng::with_seed(5),
        is_good: false,
    };
    let mut shapes: Vec<Shape> = vec![
        Shape::sphere(0.5),
        Shape::cuboid(1.0, 2.0, 3.0),
        Shape::capsule(0.5, 1.0),
        Shape::mesh([Vec3::ZERO, Vec3::X, Vec3::Z], [[0, 1, 2]]).unwrap(),
    ];
    let usual = shapes.len();
    while shapes.len() < 90 {
        let Ok(shape) = source.description(0).build() else {
            continue;
        };
        let is_usual = |size: f32| (1e-3..1e3).contains(&size);
        let aabb = shape.world_aabb(&Transform::IDENTITY);
        if !aabb.is_ok_and(|aabb| is_usual((aabb.max - aabb.min).length())) {
            shapes.push(shape);
        }
    }
    // Variants made by hand are not checked at all.
    for _ in 0..30 {
        let [radius, half] = [source.number(), source.number()];
        shapes.push(match source.rng.u8(0..5) {
            0 => Shape::Sphere { radius },
            1 => Shape::Cuboid {
                half_size: source.vector(),
            },
            2 => Shape::Capsule {
                radius,
                half_length: half,
            },
            3 => Shape::ConicalFrustum {
                radius_top: radius,
                radius_bottom: source.number(),
                half_height: half,
            },
            _ => Shape::HalfSpace {
                normal: source.vector(),
            },
        });
    }
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let places = [
        Transform::IDENTITY,
        Transform::from_xyz(0.3, 0.2, -0.1).with_rotation(Quat::from_rotation_x(0.7)),
        Transform::from_xyz(1e9, -1e20, 1.0),
        Transform::from_scale(Vec3::new(0.0, 1e20, -1.0)),
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ];
    let mut count = 0;
    for (number, shape) in shapes.iter().enumerate() {
        for other in shapes.iter().take(usual).chain(&shapes[number..=number]) {
            for at in &places {
                let there = places[source.rng.usize(0..2)];
                let (a, b) = (Placed::new(shape, at), Placed::new(other, &there));
                let what = || format!("{shape:?} {at:?}\n{other:?} {there:?}");
                let meets = tests.intersects(a, b, &mut workspace);
                let contact = tests.contact(a, b, &mut workspace);
                assert_eq!(contact.is_some(), meets, "{}", what());
                if let Some(contact) = contact {
                    count += 1;
                    assert!(contact.normal.is_normalized(), "{contact:?} {}", what());
                    assert!(contact.depth >= 0.0, "{contact:?} {}", what());
                }
                if let Some(near) = tests.closest_points(a, b, &mut workspace) {
                    assert!(near.distance.is_finite() && near.distance >= 0.0);
                    assert!(near.points.iter().all(|point| point.is_finite()));
                }
                for hit in [
                    tests.sweep(a, Dir3::X, 10.0, b, &mut workspace),
                    tests.sweep(b, Dir3::X, 10.0, a, &mut workspace),
                    tests.cast_ray(a, Vec3::new(-5.0, 0.1, 0.2), Dir3::X, 20.0),
                ]
                .into_iter()
                .flatten()
                {
                    assert!((0.0..=20.0).contains(&hit.distance), "{hit:?} {}", what());
                    assert!(hit.normal.is_normalized(), "{hit:?} {}", what());
                    assert!(hit.point.is_finite(), "{hit:?} {}", what());
                }
                if let Some(point) = tests.closest_point(a, Vec3::ONE, &mut workspace) {
                    assert!(point.is_finite(), "{}", what());
                }
                let _ = tests.cast_ray_through(a, Vec3::ONE, Dir3::NEG_Y, 20.0);
                let end = Transform::from_xyz(2.0, 0.0, 0.0);
                let moving = Moving::new(other, &there, &end);
                let met = tests.time_of_impact(&moving, &Moving::resting(a), &mut workspace);
                if let Some(met) = met {
                    assert!((0.0..=1.0).contains(&met.time), "{met:?} {}", what());
                }
                let _ = tests.swept_aabb(&Moving::new(shape, at, &there));
            }
        }
    }
    assert!(count > 100, "{count}");
}

/// Bevy's primitives, made by hand as they are in games.
#[test]
fn primitives_of_bad_numbers_are_told_of() {
    let mut source = Source {
        rng: Rng::with_seed(9),
        is_good: false,
    };
    for round in 0..60 {
        let mut app = app();
        let mut shapes = Vec::new();
        let made = told(|| {
            let [x, y, z] = source.vector().to_array();
            let half_size = source.vector();
            let corners: [Vec3; 4] = std::array::from_fn(|_| source.vector());
            let [a, b, c, _] = corners;
            let flat = [a, b, c].map(Vec3::truncate);
            shapes.push(CollisionShape::from(Cuboid { half_size }));
            shapes.push(Sphere { radius: x }.into());
            shapes.push(
                Capsule3d {
                    radius: x,
                    half_length: y,
                }
                .into(),
            );
            shapes.push(
                Cylinder {
                    radius: y,
                    half_height: z,
                }
                .into(),
            );
            shapes.push(
                Cone {
                    radius: x,
                    height: z,
                }
                .into(),
            );
            shapes.push(
                ConicalFrustum {
                    radius_top: x,
                    radius_bottom: y,
                    height: z,
                }
                .into(),
            );
            shapes.push(Segment3d { vertices: [a, b] }.into());
            shapes.push(
                Triangle3d {
                    vertices: [a, b, c],
                }
                .into(),
            );
            shapes.push(Tetrahedron { vertices: corners }.into());
            shapes.push(
                Plane3d {
                    normal: Dir3::Y,
                    half_size: flat[0],
                }
                .into(),
            );
            shapes.push(Extrusion::new(Triangle2d { vertices: flat }, x).into());
            shapes.push(Extrusion::new(Rectangle { half_size: flat[1] }, y).into());
            shapes.push(
                Extrusion::new(
                    Rhombus {
                        half_diagonals: flat[2],
                    },
                    y,
                )
                .into(),
            );
            let sides = [0, 1, 2, 3, 8, u32::MAX][source.rng.usize(0..6)];
            let polygon = RegularPolygon {
                circumcircle: Circle { radius: x },
                sides,
            };
            shapes.push(Extrusion::new(polygon, z).into());
        });
        let entities: Vec<Entity> = shapes
            .iter()
            .map(|shape| app.world_mut().spawn(shape.clone()).id())
            .collect();
        let lines = told(|| app.update());
        check_told(&app, &entities, &lines, |number| {
            format!("{round}: {:?} {made:?}", shapes[number])
        });
    }
}

/// A whole landscape of them, and one that is edited.
#[test]
fn a_million_voxels_are_a_shape() {
    let cells = (0..100 * 100 * 100).map(|n| IVec3::new(n % 100, n / 100 % 100, n / 10_000));
    let data = ShapeDescription::Voxels {
        cell_size: 1.0,
        cells: cells.collect(),
    };
    let mut app = app();
    let ground = app.world_mut().spawn(data).id();
    let ball = |at: Vec3| (CollisionShape::sphere(0.4), Transform::from_translation(at));
    let [on, above] =
        [99.9, 101.0].map(|y| app.world_mut().spawn(ball(Vec3::new(50.0, y, 50.0))).id());
    assert_eq!(told(|| app.update()), [""; 0]);
    let contacts = app.world().resource::<Contacts>();
    assert!(contacts.between(ground, on).is_some());
    assert!(contacts.between(ground, above).is_none());
}

#[test]
fn what_is_empty_or_of_one_row_is_told_of() {
    let data = [
        ShapeDescription::Compound { parts: vec![] },
        ShapeDescription::HeightField {
            rows: 1,
            columns: 5,
            heights: vec![0.0; 5],
            cell_size: Vec2::ONE,
            holes: vec![],
        },
        ShapeDescription::HeightField {
            rows: 2,
            columns: 1 << 31,
            heights: vec![],
            cell_size: Vec2::ONE,
            holes: vec![],
        },
        ShapeDescription::ConvexHull { points: vec![] },
        ShapeDescription::Mesh {
            vertices: vec![],
            polygons: vec![],
            surface_only: false,
        },
    ];
    for data in data {
        let mut app = app();
        let entity = app.world_mut().spawn(data.clone()).id();
        let lines = told(|| app.update());
        assert!(
            lines.len() == 1 && names(&lines, entity),
            "{data:?}: {lines:?}"
        );
        assert!(app.world().get::<CollisionShape>(entity).is_none());
    }
    // No cells are in contact with nothing, until there are some.
    let empty = ShapeDescription::Voxels {
        cell_size: 1.0,
        cells: vec![],
    };
    let parts = vec![PartDescription::at(Vec3::X, empty.clone())];
    for data in [empty, ShapeDescription::Compound { parts }] {
        let mut app = app();
        let entity = app.world_mut().spawn(data).id();
        let ball = app.world_mut().spawn(CollisionShape::sphere(9.0)).id();
        app.update();
        let contacts = app.world().resource::<Contacts>();
        assert!(contacts.between(entity, ball).is_none());
    }
    // A hole where there is no cell.
    let nested = Shape::compound([(Isometry3d::IDENTITY, Shape::sphere(1.0))]).unwrap();
    let around = Shape::compound([(Isometry3d::IDENTITY, nested)]).unwrap();
    assert!(matches!(around, Shape::Compound(parts) if parts.len() == 1));
}

/// A scale of which one number is none is no scale, whichever numbers a shape goes by: it is told of, and each question has
/// the same answer. So is a turn.
#[test]
fn what_is_partly_no_number_is_found_by_no_question() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let convex = Shape::convex_hull(corners).unwrap();
    let part = (Isometry3d::IDENTITY, Shape::sphere(0.5));
    let shapes = [
        Shape::cuboid(1.0, 1.0, 1.0),
        Shape::sphere(0.5),
        Shape::capsule(0.5, 1.0),
        Shape::cylinder(0.5, 1.0),
        Shape::half_space(Vec3::Y).unwrap(),
        Shape::compound([part]).unwrap(),
        Shape::rounded(&Shape::cuboid(1.0, 1.0, 1.0), 0.1).unwrap(),
        convex,
        #[cfg(feature = "rapier")]
        Shape::from(&bevy_rapier3d::prelude::Collider::ball(0.5)),
        #[cfg(feature = "rapier")]
        Shape::from(&bevy_rapier3d::prelude::Collider::cuboid(0.5, 0.5, 0.5)),
        #[cfg(feature = "rapier")]
        Shape::from(&bevy_rapier3d::prelude::Collider::triangle(
            Vec3::X,
            Vec3::Y,
            Vec3::Z,
        )),
    ];
    let mut bad = Vec::new();
    for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let scale = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(number), Vec3::ONE);
            bad.push(Transform::from_scale(scale));
        }
        for place in 0..4 {
            let mut turn = [0.0, 0.0, 0.0, 1.0];
            turn[place] = number;
            bad.push(Transform::from_rotation(Quat::from_array(turn)));
        }
    }
    let tests = NarrowPhase::default();
    let here = Transform::IDENTITY;
    let ball = Shape::sphere(2.0);
    for (shape, at) in shapes
        .iter()
        .flat_map(|shape| bad.iter().map(move |at| (shape, *at)))
    {
        let what = || format!("{shape:?} at {at:?}");
        let bad = Placed::new(shape, &at);
        let (good, far) = (
            Placed::new(&ball, &here),
            Transform::from_xyz(0.0, 9.0, 0.0),
        );
        let far = Placed::new(&ball, &far);
        let workspace = &mut Workspace::default();
        assert!(
            tests
                .world_aabb(bad)
                .is_err_and(|error| error == BoundsError::NonFinite),
            "{}",
            what()
        );
        for [a, b] in [[bad, good], [good, bad]] {
            assert!(!tests.intersects(a, b, workspace), "{}", what());
            assert_eq!(tests.contact(a, b, workspace), None, "{}", what());
            assert_eq!(tests.manifold(a, b, workspace), None, "{}", what());
            assert_eq!(tests.closest_points(a, b, workspace), None, "{}", what());
            let [a, b] = [a, b].map(Moving::resting);
            assert!(
                tests.time_of_impact(&a, &b, workspace).is_none(),
                "{}",
                what()
            );
        }
        assert_eq!(
            tests.cast_ray(bad, Vec3::Y * 9.0, Dir3::NEG_Y, 20.0),
            None,
            "{}",
            what()
        );
        assert_eq!(
            tests.cast_ray_through(bad, Vec3::Y * 9.0, Dir3::NEG_Y, 20.0),
            None,
            "{}",
            what()
        );
        assert_eq!(
            tests.closest_point(bad, Vec3::Y * 9.0, workspace),
            None,
            "{}",
            what()
        );
        assert_eq!(
            tests.sweep(far, Dir3::NEG_Y, 20.0, bad, workspace),
            None,
            "{}",
            what()
        );
        assert_eq!(
            tests.sweep(bad, Dir3::Y, 20.0, far, workspace),
            None,
            "{}",
            what()
        );
    }
    let all = &SpatialQueryFilter::DEFAULT;
    for at in bad {
        // On some it is their own, on others that of a parent.
        let mut app = app();
        for shape in &shapes {
            let shape = CollisionShape(shape.clone());
            app.world_mut().spawn((shape.clone(), at));
            app.world_mut().spawn((at, children![shape]));
        }
        let lines = told(|| app.update());
        assert_eq!(lines.len(), 2 * shapes.len(), "{at:?}: {lines:?}");
        let mut state = SystemState::<SpatialQuery>::new(app.world_mut());
        let spatial = state.get(app.world()).unwrap();
        let (mut found, mut contacts) = (Vec::new(), Vec::new());
        spatial.shape_intersections(&ball, &here, all, &mut found);
        let ray = Ray3d::new(Vec3::Y * 9.0, Dir3::NEG_Y);
        assert_eq!(found, [], "{at:?}");
        assert_eq!(spatial.cast_ray(ray, 20.0, all), None, "{at:?}");
        let hit = spatial.cast_sphere(ray.origin, 0.5, ray.direction, 20.0, all);
        assert_eq!(hit, None, "{at:?}");
        assert_eq!(spatial.nearest(Vec3::ZERO, 20.0, all), None, "{at:?}");
        assert_eq!(spatial.index().index().proxies().len(), 0, "{at:?}");
        // What asks is refused alike.
        let cube = app.world_mut().spawn(CollisionShape::default()).id();
        app.update();
        let spatial = state.get(app.world()).unwrap();
        for shape in &shapes {
            spatial.shape_intersections(shape, &at, all, &mut found);
            spatial.shape_contacts(shape, &at, all, &mut contacts);
            assert_eq!((found.len(), contacts.len()), (0, 0), "{shape:?} {at:?}");
            let hit = spatial.cast_shape(shape, &at, Dir3::X, 9.0, all);
            assert_eq!(hit, None, "{shape:?} {at:?}");
            let then = spatial.at([(cube, at)]);
            assert_eq!(then.cast_ray(ray, 20.0, all), None, "{at:?}");
        }
    }
}
