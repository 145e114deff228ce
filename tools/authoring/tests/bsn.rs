//! Shapes in scenes that are written with `bsn!`.

use bevy::{asset::AssetPlugin, prelude::*, scene::ScenePlugin};
use bevy_octree::{
    narrow_phase::Shape,
    prelude::*,
    shape_data::{CoreDescription, PartDescription, ShapeDescription},
};

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

/// A wheel, in a scene of its own, as others may put it together.
fn wheel() -> impl Scene {
    bsn! {
        ShapeDescription::Cylinder { radius: 0.4, height: 0.2 }
    }
}

/// What is not said is as the kind of shape has it by default.
fn cart() -> impl Scene {
    bsn! {
        #Cart
        ShapeDescription::Cuboid { half_size: {Vec3::new(1.0, 0.25, 0.5)} }
        Children [
            (#Wheel wheel() Transform { translation: {Vec3::new(0.8, -0.25, 0.5)} }),
            (#Mast ShapeDescription::Capsule { radius: 0.1 }),
            (
                #Load
                ShapeDescription::Compound {
                    parts: {vec![PartDescription::at(Vec3::Y, ShapeDescription::Sphere { radius: 0.3 })]}
                }
            ),
            (
                #Bumper
                ShapeDescription::Rounded {
                    core: {CoreDescription::Cuboid { half_size: Vec3::new(0.1, 0.1, 0.5) }},
                    radius: 0.05,
                }
            ),
            (#Small wheel() ShapeDescription::Cylinder { radius: 0.1 }),
        ]
    }
}

fn shape(app: &mut App, name: &str) -> Shape {
    let mut all = app.world_mut().query::<(&Name, &CollisionShape)>();
    let found = all
        .iter(app.world())
        .find(|(found, _)| found.as_str() == name);
    found
        .unwrap_or_else(|| panic!("{name} has a shape"))
        .1
        .0
        .clone()
}

#[test]
fn a_scene_in_bsn_has_the_shapes_that_it_describes() {
    let mut app = app();
    app.world_mut().spawn_scene(cart()).unwrap();
    app.update();
    let cart = shape(&mut app, "Cart");
    let half = Vec3::new(1.0, 0.25, 0.5);
    assert!(
        matches!(cart, Shape::Cuboid { half_size } if half_size == half),
        "{cart:?}"
    );
    let wheel = shape(&mut app, "Wheel");
    assert!(
        matches!(
            wheel,
            Shape::ConicalFrustum {
                radius_top: 0.4,
                radius_bottom: 0.4,
                half_height: 0.1
            }
        ),
        "{wheel:?}"
    );
    let mast = shape(&mut app, "Mast");
    assert!(
        matches!(
            mast,
            Shape::Capsule {
                radius: 0.1,
                half_length: 0.5
            }
        ),
        "{mast:?}"
    );
    let load = shape(&mut app, "Load");
    assert!(
        matches!(&load, Shape::Compound(parts) if parts.len() == 1),
        "{load:?}"
    );
    let bumper = shape(&mut app, "Bumper");
    assert!(matches!(bumper, Shape::Rounded(_)), "{bumper:?}");
    // What another scene says is patched.
    let small = shape(&mut app, "Small");
    assert!(
        matches!(
            small,
            Shape::ConicalFrustum {
                radius_top: 0.1,
                half_height: 0.1,
                ..
            }
        ),
        "{small:?}"
    );
    // They take part where the scene puts them.
    let contacts = app.world().resource::<Contacts>();
    assert!(!contacts.is_empty());
}
