//! Scenes that `bsn!` writes.

use bevy::{
    prelude::*,
    scene::{Scene, ScenePlugin},
};
use bevy_asset::AssetPlugin;
use bevy_octree::{
    motion::Outside,
    narrow_phase::Shape,
    prelude::*,
    shape_data::{CoreDescription, PartDescription},
};

collision_layers! {
    enum Layer { Ground, Ship }
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        ScenePlugin,
        OctreePlugins::new(Update),
    ));
    app
}

/// Spawns a scene, and lets it take part in a tick.
fn spawned(app: &mut App, scene: impl Scene) -> Entity {
    let entity = app.world_mut().spawn_scene(scene).unwrap().id();
    app.update();
    entity
}

fn get<C: Component + Clone>(app: &App, entity: Entity) -> C {
    app.world().get::<C>(entity).expect("it has one").clone()
}

fn children(app: &App, entity: Entity) -> Vec<Entity> {
    let children = app.world().get::<Children>(entity).unwrap();
    children.iter().collect()
}

fn data(app: &App, entity: Entity) -> ShapeDescription {
    get(app, entity)
}

#[test]
fn what_a_scene_says_falls_on_what_another_says() {
    let mut app = app();
    let floor = bsn! {
        #floor
        ShapeDescription::Cuboid { half_size: Vec3::new(9.0, 0.5, 9.0) }
        StaticShape
    };
    let floor = spawned(&mut app, floor);
    let hero = bsn! {
        #hero
        ShapeDescription::Capsule { radius: 0.4 }
        Transform { translation: Vec3::new(0.0, 1.3, 0.0) }
        Velocity(Vec3::NEG_Y)
    };
    let hero = spawned(&mut app, hero);
    let (radius, length) = (0.4, 1.0);
    assert_eq!(
        data(&app, hero),
        ShapeDescription::Capsule { radius, length }
    );
    assert_eq!(get::<Transform>(&app, hero).scale, Vec3::ONE);
    let contacts = app.world().resource::<Contacts>();
    assert!(contacts.iter().any(|c| [c.a, c.b] == [floor, hero]));
}

/// Each kind can be written without a field, and is then as its default says.
#[test]
fn every_kind_can_be_written() {
    let mut app = app();
    macro_rules! kinds {
        ($($kind:ident: $default:ident, $makes_a_shape:expr;)*) => {
            $(
                let entity = spawned(&mut app, bsn! { ShapeDescription::$kind });
                let of = stringify!($kind);
                assert_eq!(data(&app, entity), ShapeDescription::$default(), "{of}");
                let shape = app.world().get::<CollisionShape>(entity);
                assert_eq!(shape.is_some(), $makes_a_shape, "{of}");
            )*
        };
    }
    kinds! {
        Cuboid: default_cuboid, true;
        Sphere: default_sphere, true;
        Capsule: default_capsule, true;
        CapsuleBetween: default_capsulebetween, true;
        Cylinder: default_cylinder, true;
        Cone: default_cone, true;
        ConicalFrustum: default_conicalfrustum, true;
        Tetrahedron: default_tetrahedron, true;
        Triangle: default_triangle, true;
        Segment: default_segment, true;
        HalfSpace: default_halfspace, true;
        Convex: default_convex, false;
        ConvexHull: default_convexhull, true;
        Mesh: default_mesh, false;
        Rounded: default_rounded, true;
        Compound: default_compound, false;
        HeightField: default_heightfield, true;
        Voxels: default_voxels, true;
    }
    let cube = spawned(&mut app, bsn! { ShapeDescription });
    assert_eq!(data(&app, cube), ShapeDescription::default());
}

#[test]
fn fields_of_every_sort_can_be_written() {
    let mut app = app();
    // A part of a field; the rest of it is the default's.
    let flat = bsn! { ShapeDescription::Cuboid { half_size: Vec3 { y: 0.1 } } };
    let flat = spawned(&mut app, flat);
    let half_size = Vec3::new(0.5, 0.1, 0.5);
    assert_eq!(data(&app, flat), ShapeDescription::Cuboid { half_size });

    // Lists and arrays, as expressions.
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let hull = bsn! { ShapeDescription::ConvexHull { points: {vec![a, b, c, d, Vec3::NEG_ONE]} } };
    let hull = spawned(&mut app, hull);
    assert!(
        matches!(data(&app, hull), ShapeDescription::ConvexHull { points } if points.len() == 5)
    );
    let solid = bsn! { ShapeDescription::Tetrahedron { vertices: {[a, b, c, d]} } };
    let solid = spawned(&mut app, solid);
    let vertices = [a, b, c, d];
    assert_eq!(
        data(&app, solid),
        ShapeDescription::Tetrahedron { vertices }
    );
    let field = bsn! {
        ShapeDescription::HeightField { heights: {vec![0.0, 1.0, 0.0, 1.0]}, holes: {vec![[0, 0]]} }
    };
    let field = spawned(&mut app, field);
    assert!(matches!(
        data(&app, field),
        ShapeDescription::HeightField { rows: 2, columns: 2, holes, .. } if holes == [[0, 0]]
    ));

    // What is rounded, and parts, with all of their fields.
    let dice = bsn! {
        ShapeDescription::Rounded {
            core: CoreDescription::Cuboid { half_size: {Vec3::splat(0.4)} },
        }
    };
    let dice = spawned(&mut app, dice);
    let core = CoreDescription::Cuboid {
        half_size: Vec3::splat(0.4),
    };
    assert_eq!(
        data(&app, dice),
        ShapeDescription::Rounded { core, radius: 0.1 }
    );
    let dumbbell = bsn! {
        ShapeDescription::Compound {
            parts: {[-1.0, 1.0]
                .map(|x| PartDescription::at(Vec3::X * x, ShapeDescription::default_sphere()))
                .to_vec()}
        }
    };
    let dumbbell = spawned(&mut app, dumbbell);
    assert!(matches!(
        get::<CollisionShape>(&app, dumbbell).0,
        Shape::Compound(_)
    ));
}

/// A scene that has another in it changes single fields of what is there, or the whole kind.
#[test]
fn one_scene_overrides_another() {
    fn hero() -> impl Scene {
        bsn! { ShapeDescription::Capsule { radius: 0.4, length: 1.5 } }
    }
    let mut app = app();
    let thin = spawned(
        &mut app,
        bsn! { hero() ShapeDescription::Capsule { radius: 0.2 } },
    );
    let (radius, length) = (0.2, 1.5);
    assert_eq!(
        data(&app, thin),
        ShapeDescription::Capsule { radius, length }
    );
    let round = spawned(
        &mut app,
        bsn! { hero() ShapeDescription::Sphere { radius: 2.0 } },
    );
    assert_eq!(data(&app, round), ShapeDescription::Sphere { radius: 2.0 });
    assert!(matches!(
        get::<CollisionShape>(&app, round).0,
        Shape::Sphere { radius: 2.0 }
    ));
}

/// What is spawned below a body is part of it in the same tick.
#[test]
fn shapes_of_children_are_parts_of_their_body() {
    let mut app = app();
    let ship = bsn! {
        CollisionBody
        Children [
            (ShapeDescription::Sphere),
            (
                ShapeDescription::Cylinder { height: 3.0 }
                Transform { translation: Vec3::new(0.0, 0.25, 0.0) }
            ),
        ]
    };
    let ship = spawned(&mut app, ship);
    let children = children(&app, ship);
    let parts = get::<BodyParts>(&app, ship);
    assert_eq!(parts.entities().len(), 2);
    assert!(
        children
            .iter()
            .all(|child| parts.entities().contains(child))
    );
    assert!(app.world().resource::<Contacts>().is_empty());
}

#[test]
fn data_that_is_wrong_says_so() {
    let mut app = app();
    let bad = spawned(
        &mut app,
        bsn! { #bad ShapeDescription::Sphere { radius: -1.0 } },
    );
    assert!(app.world().get::<ShapeDescriptionError>(bad).is_some());
    assert!(app.world().get::<CollisionShape>(bad).is_none());
}

/// All else that an entity may be given, as fields, as constructors, or as values.
#[test]
fn every_component_of_a_game_can_be_written() {
    let mut app = app();
    let track = PositionTrack::new([(0, Vec3::ZERO), (60, Vec3::X)])
        .unwrap()
        .with_outside(Outside::Loop);
    let way = track.clone();
    let all = bsn! {
        CollisionShape::sphere(0.25)
        CollisionLayers::new(Layer::Ship, [Layer::Ground])
        Bounce::Reflect { restitution: 0.5 }
        Swept { at_solid: AtSolid::Stop }
        Velocity({Vec3::X})
        Sensor
        Detector
        MovedElsewhere
        CollidingEntities
        CollisionEventsEnabled
        ManifoldsEnabled
        RayCaster { direction: {Dir3::X}, length: 4.0, filter: CasterFilter { sensors: false } }
        ShapeCaster { shape: {CollisionShape::sphere(0.5)}, max_hits: 3 }
        template_value(way)
    };
    let all = spawned(&mut app, all);
    assert_eq!(
        get::<CollisionShape>(&app, all),
        CollisionShape::sphere(0.25)
    );
    let layers = CollisionLayers::new(Layer::Ship, Layer::Ground);
    assert_eq!(get::<CollisionLayers>(&app, all), layers);
    let restitution = 0.5;
    assert_eq!(get::<Bounce>(&app, all), Bounce::Reflect { restitution });
    assert_eq!(get::<Swept>(&app, all), Swept::stopping());
    let ray = get::<RayCaster>(&app, all);
    let expected = RayCaster::new(Vec3::ZERO, Dir3::X).with_length(4.0);
    let filter = CasterFilter::default().without_sensors();
    assert_eq!(ray, RayCaster { filter, ..expected });
    assert_eq!(get::<ShapeCaster>(&app, all).max_hits, 3);
    assert_eq!(get::<PositionTrack>(&app, all), track);

    let plain = spawned(&mut app, bsn! { ShapeDescription::Sphere Bounce::Reverse });
    assert_eq!(get::<Bounce>(&app, plain), Bounce::Reverse);
    let slides = spawned(&mut app, bsn! { ShapeDescription::Sphere Bounce::Reflect });
    let restitution = 0.0;
    assert_eq!(get::<Bounce>(&app, slides), Bounce::Reflect { restitution });
    let own = spawned(
        &mut app,
        bsn! { CollisionShape({Shape::cuboid(1.0, 2.0, 3.0)}) },
    );
    assert_eq!(
        get::<CollisionShape>(&app, own),
        CollisionShape::cuboid(1.0, 2.0, 3.0)
    );
}

/// What names others: worlds, and whom not to meet.
#[test]
fn others_of_a_scene_are_named() {
    let mut app = app();
    let arena = bsn! {
        #arena
        Children [
            (ShapeDescription::Sphere InCollisionWorld(#arena)),
            (ShapeDescription::Sphere),
        ]
    };
    let arena = spawned(&mut app, arena);
    let children = children(&app, arena);
    assert_eq!(
        get::<InCollisionWorld>(&app, children[0]),
        InCollisionWorld(arena)
    );
    let ignores = bsn! { ShapeDescription::Sphere template_value(IgnoreCollisions::from(arena)) };
    let ignores = spawned(&mut app, ignores);
    assert_eq!(
        get::<IgnoreCollisions>(&app, ignores),
        IgnoreCollisions::from(arena)
    );
}
