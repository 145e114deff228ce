//! Shapes as plain data: what becomes of the data on an entity, and how it is read and written.

#[cfg(feature = "reports")]
mod json;

use std::any::TypeId;

use bevy::{
    ecs::{entity_disabling::Disabled, reflect::ReflectComponent, template::FromTemplate},
    prelude::*,
    reflect::{
        FromReflect, GetPath, ReflectRef, TypeInfo, TypeRegistry,
        enums::{DynamicEnum, DynamicVariant},
        structs::DynamicStruct,
    },
};
use bevy_octree::{
    narrow_phase::{Shape, ShapeError},
    prelude::*,
    shape_data::{CoreDescription, PartDescription, ShapeDescription},
};

use crate::common::{
    self,
    warnings::{on_this_thread, told},
};
use common::get;

const BALL: ShapeDescription = ShapeDescription::Sphere { radius: 0.5 };
const BAD: ShapeDescription = ShapeDescription::Sphere { radius: -1.0 };

/// Who listens to the log hears this thread alone.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    on_this_thread(&mut app, Update);
    app
}

fn radius(app: &App, entity: Entity) -> Option<f32> {
    match app.world().get::<CollisionShape>(entity)?.0 {
        Shape::Sphere { radius } => Some(radius),
        _ => None,
    }
}

fn error(app: &App, entity: Entity) -> Option<&ShapeError> {
    Some(&app.world().get::<ShapeDescriptionError>(entity)?.0)
}

#[test]
fn data_makes_a_shape_that_takes_part_in_the_same_tick() {
    let mut app = app();
    let balls = [0.0, 0.75].map(|x| {
        let place = Transform::from_xyz(x, 0.0, 0.0);
        app.world_mut().spawn((BALL, place)).id()
    });
    app.update();
    let contacts = app.world().resource::<Contacts>();
    assert!(contacts.iter().any(|c| [c.a, c.b] == balls));
    // It needs nothing else.
    let alone = app.world_mut().spawn(BALL).id();
    app.update();
    assert_eq!(radius(&app, alone), Some(0.5));
    assert!(app.world().get::<Transform>(alone).is_some());
}

#[test]
fn a_change_is_a_new_shape_in_the_next_tick_however_it_was_made() {
    let mut app = app();
    let ball = app.world_mut().spawn(BALL).id();
    app.update();
    // In place, field by field.
    let mut data = app.world_mut().get_mut::<ShapeDescription>(ball).unwrap();
    let ShapeDescription::Sphere { radius: of } = &mut *data else {
        panic!("it is a ball");
    };
    *of = 2.0;
    app.update();
    assert_eq!(radius(&app, ball), Some(2.0));
    // By a new one.
    let new = ShapeDescription::Sphere { radius: 3.0 };
    app.world_mut().entity_mut(ball).insert(new);
    app.update();
    assert_eq!(radius(&app, ball), Some(3.0));
    // Of another kind, by a system of the frame, in a tick that is later.
    app.add_systems(PreUpdate, |mut all: Query<&mut ShapeDescription>| {
        for mut data in &mut all {
            data.set_if_neq(ShapeDescription::default());
        }
    });
    app.update();
    assert!(matches!(
        get::<CollisionShape>(&app, ball).0,
        Shape::Cuboid { .. }
    ));

    // Nothing is built where nothing changed.
    app.world_mut()
        .entity_mut(ball)
        .insert(CollisionShape::sphere(9.0));
    app.update();
    app.update();
    assert_eq!(
        radius(&app, ball),
        Some(9.0),
        "what is inserted later stays"
    );
}

#[test]
fn a_shape_beside_the_data_is_a_placeholder_and_stays_when_the_data_goes() {
    let mut app = app();
    let ball = app
        .world_mut()
        .spawn((BALL, CollisionShape::cuboid(1.0, 1.0, 1.0)))
        .id();
    app.update();
    assert_eq!(radius(&app, ball), Some(0.5));
    app.world_mut()
        .entity_mut(ball)
        .remove::<ShapeDescription>();
    app.update();
    assert_eq!(radius(&app, ball), Some(0.5));
}

#[test]
fn bad_data_is_told_once_and_leaves_a_component_that_says_so() {
    #[derive(Resource, Default)]
    struct Heard(Vec<Entity>);
    let mut app = app();
    app.init_resource::<Heard>().add_observer(
        |on: On<Insert, ShapeDescriptionError>, mut heard: ResMut<Heard>| heard.0.push(on.entity),
    );
    let [bare, rock] = [None, Some(Name::new("rock"))].map(|name| {
        let mut entity = app.world_mut().spawn(BAD);
        if let Some(name) = name {
            entity.insert((name, CollisionShape::sphere(4.0)));
        }
        entity.id()
    });
    let mut lines = told(|| {
        for _ in 0..3 {
            app.update();
        }
    });
    lines.sort_unstable(); // by entity
    let why = "the radius of a sphere must be finite and not negative, got -1";
    assert_eq!(
        lines,
        [
            format!("entity {bare} has no shape of its data: {why}"),
            format!("entity {rock} \"rock\" keeps its former shape, as its data makes none: {why}"),
        ]
    );
    let mut heard = app.world().resource::<Heard>().0.clone();
    heard.sort_unstable_by_key(|entity| entity.index_u32());
    assert_eq!(heard, [bare, rock]);
    assert_eq!(error(&app, bare), Some(&ShapeError::Radius(-1.0)));
    assert_eq!((radius(&app, bare), radius(&app, rock)), (None, Some(4.0)));

    // Wrong in another way: told again.
    let mut data = app.world_mut().get_mut::<ShapeDescription>(rock).unwrap();
    *data = ShapeDescription::default_mesh();
    assert_eq!(told(|| app.update()).len(), 1);
    assert_eq!(error(&app, rock), Some(&ShapeError::Empty));

    // Mended, and gone.
    app.world_mut().entity_mut(rock).insert(BALL);
    assert_eq!(told(|| app.update()), [""; 0]);
    assert_eq!((error(&app, rock), radius(&app, rock)), (None, Some(0.5)));
    app.world_mut()
        .entity_mut(bare)
        .remove::<ShapeDescription>();
    assert_eq!(error(&app, bare), None);

    // While it is wrong, it may be despawned.
    let soon_gone = app.world_mut().spawn(BAD).id();
    app.update();
    app.world_mut().despawn(soon_gone);
    app.update();
}

#[test]
fn what_is_disabled_or_cloned_has_the_shape_of_its_data() {
    let mut app = app();
    let ball = app.world_mut().spawn((BALL, Disabled)).id();
    app.update();
    app.world_mut()
        .entity_mut(ball)
        .insert(ShapeDescription::Sphere { radius: 2.0 });
    app.update();
    app.world_mut().entity_mut(ball).remove::<Disabled>();
    app.update();
    assert_eq!(radius(&app, ball), Some(2.0));

    let clone = app.world_mut().entity_mut(ball).clone_and_spawn();
    let mut data = app.world_mut().get_mut::<ShapeDescription>(clone).unwrap();
    *data = BALL;
    app.update();
    assert_eq!(
        (radius(&app, ball), radius(&app, clone)),
        (Some(2.0), Some(0.5))
    );
}

/// As an inspector or `world.mutate_components` does it: by type path, by the path of a field, or by
/// another variant, with nothing of ours at compile time.
#[test]
fn data_is_changed_through_the_registry_alone() {
    let mut app = app();
    let ball = app.world_mut().spawn(BALL).id();
    app.update();
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let registration = registry
        .get_with_type_path("bevy_octree::ShapeDescription")
        .expect("it is registered");
    let component = registration.data::<ReflectComponent>().unwrap();

    let mut reflected = component
        .reflect_mut(app.world_mut().entity_mut(ball))
        .unwrap();
    let field = reflected.reflect_path_mut(".radius").unwrap();
    field.apply(&2f32);
    app.update();
    assert_eq!(radius(&app, ball), Some(2.0));

    let mut fields = DynamicStruct::default();
    fields.insert("half_size", Vec3::ONE);
    let other = DynamicEnum::new("Cuboid", DynamicVariant::Struct(fields));
    component.apply(app.world_mut().entity_mut(ball), &other);
    app.update();
    assert!(matches!(
        get::<CollisionShape>(&app, ball).0,
        Shape::Cuboid {
            half_size: Vec3::ONE
        }
    ));
}

/// No kind is opaque, down to the numbers: an editor shows a field for each.
#[test]
fn all_of_the_data_is_open_to_editors() {
    fn open(registry: &TypeRegistry, id: TypeId, seen: &mut Vec<TypeId>) {
        if seen.contains(&id) {
            return;
        }
        seen.push(id);
        let info = registry.get_type_info(id).expect("it is registered");
        let path = info.type_path();
        match info {
            TypeInfo::Enum(info) => {
                for variant in info.iter() {
                    for field in variant.as_struct_variant().unwrap().iter() {
                        open(registry, field.type_id(), seen);
                    }
                }
            }
            TypeInfo::Struct(info) => info.iter().for_each(|f| open(registry, f.type_id(), seen)),
            TypeInfo::List(info) => open(registry, info.item_ty().id(), seen),
            TypeInfo::Array(info) => open(registry, info.item_ty().id(), seen),
            TypeInfo::Opaque(_) => {
                let numbers = ["f32", "u32", "i32", "bool"];
                assert!(numbers.contains(&path), "{path} is opaque");
            }
            _ => panic!("{path} is something else"),
        }
    }
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let mut seen = Vec::new();
    open(&registry, TypeId::of::<ShapeDescription>(), &mut seen);
    assert!(seen.contains(&TypeId::of::<PartDescription>()));
    assert!(seen.contains(&TypeId::of::<CoreDescription>()));
    for name in ["ShapeDescription", "CoreDescription", "PartDescription"] {
        let registration = registry
            .get_with_type_path(&format!("bevy_octree::{name}"))
            .unwrap();
        assert!(registration.data::<ReflectDefault>().is_some(), "{name}");
        assert!(registration.data::<ReflectSerialize>().is_some(), "{name}");
        assert!(
            registration.data::<ReflectDeserialize>().is_some(),
            "{name}"
        );
    }
    assert!(matches!(BALL.reflect_ref(), ReflectRef::Enum(_)));
    assert_eq!(ShapeDescription::from_reflect(&BALL), Some(BALL));
}

/// What `bsn!` does: it starts from the default of a variant, and sets the fields that are named.
#[test]
fn data_is_built_from_a_template() {
    type Template = <ShapeDescription as FromTemplate>::Template;
    let mut app = app();
    let mut template = Template::default_capsule();
    if let Template::Capsule { radius, .. } = &mut template {
        *radius = 0.25;
    }
    let mut entity = app.world_mut().spawn_empty();
    let built: ShapeDescription = entity.build_template(&template).unwrap();
    let (radius, length) = (0.25, 1.0);
    assert_eq!(built, ShapeDescription::Capsule { radius, length });
}

/// Bevy's own scene files have a component by its type path, in RON.
#[cfg(feature = "scene_files")]
#[test]
fn data_is_written_to_bevys_scene_files_and_read_back() {
    use bevy::reflect::serde::{ReflectDeserializer, ReflectSerializer};
    use serde::de::DeserializeSeed;

    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let data = ShapeDescription::Compound {
        parts: vec![
            PartDescription::at(Vec3::X, BALL),
            PartDescription {
                position: Vec3::ZERO,
                rotation: Quat::from_rotation_x(1.0),
                shape: ShapeDescription::Rounded {
                    core: CoreDescription::default_triangle(),
                    radius: 0.5,
                },
            },
        ],
    };
    let text = ron::to_string(&ReflectSerializer::new(&data, &registry)).unwrap();
    assert!(
        text.starts_with("{\"bevy_octree::ShapeDescription\":Compound(parts:[("),
        "{text}"
    );
    let mut reader = ron::Deserializer::from_str(&text).unwrap();
    let read = ReflectDeserializer::new(&registry)
        .deserialize(&mut reader)
        .unwrap();
    assert_eq!(read.try_downcast_ref::<ShapeDescription>(), Some(&data));

    // A scene file that was written before there were more kinds.
    let old = "Mesh(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], polygons: [[0, 1, 2]])";
    assert!(matches!(
        ron::from_str(old),
        Ok(ShapeDescription::Mesh {
            surface_only: false,
            ..
        })
    ));
}
