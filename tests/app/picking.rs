//! What pointers pick.

use crate::common;

use bevy::{
    camera::Camera,
    picking::{
        InteractionPlugin, Pickable, PickingPlugin, PickingSettings,
        backend::{
            HitData, PointerHits,
            ray::{RayId, RayMap},
        },
        hover::HoverMap,
        pointer::PointerId,
    },
    prelude::*,
};
use bevy_octree::{picking::CollisionPickingSettings, prelude::*};
use common::*;

/// An app that picks, and a camera whose pointer looks along x from the origin.
fn picking() -> (App, Entity) {
    let mut app = app(BroadPhaseMethod::default());
    app.add_plugins(CollisionPickingPlugin);
    let camera = point(
        &mut app,
        Camera {
            order: 3,
            ..default()
        },
        Dir3::X,
    );
    (app, camera)
}

/// A camera of its own for the mouse, which looks that way.
fn point(app: &mut App, camera: Camera, direction: Dir3) -> Entity {
    let camera = app.world_mut().spawn(camera).id();
    let ray = Ray3d::new(Vec3::ZERO, direction);
    app.world_mut()
        .resource_mut::<RayMap>()
        .map
        .insert(RayId::new(camera, PointerId::Mouse), ray);
    camera
}

/// A cube of side 1 along the ray.
fn spawn(app: &mut App, x: f32, bundle: impl Bundle) -> Entity {
    app.world_mut()
        .spawn((
            CollisionShape::default(),
            Transform::from_xyz(x, 0.0, 0.0),
            bundle,
        ))
        .id()
}

/// What is written by the next frame, given that the index knows of all that was spawned.
fn hits(app: &mut App) -> Vec<PointerHits> {
    app.world_mut()
        .run_system_cached(update_spatial_index)
        .unwrap();
    app.world_mut()
        .resource_mut::<Messages<PointerHits>>()
        .clear();
    app.update();
    app.world_mut()
        .resource_mut::<Messages<PointerHits>>()
        .drain()
        .collect()
}

/// The entities that are picked, nearest first, by the only pointer.
fn picked(app: &mut App) -> Vec<Entity> {
    let hits = hits(app);
    assert!(hits.len() <= 1, "{hits:?}");
    hits.iter()
        .flat_map(|hits| &hits.picks)
        .map(|(entity, _)| *entity)
        .collect()
}

#[test]
fn the_nearest_is_picked_with_its_place_and_normal() {
    let (mut app, camera) = picking();
    assert!(hits(&mut app).is_empty());
    spawn(&mut app, 8.0, ());
    let near = spawn(&mut app, 4.0, ());
    let ball = CollisionShape::sphere(1.0);
    // The ray meets the box of this one, and not the ball.
    app.world_mut()
        .spawn((ball, Transform::from_xyz(2.0, 0.9, 0.9)));
    let hits = hits(&mut app);
    let [
        PointerHits {
            pointer: PointerId::Mouse,
            picks,
            order: 3.0,
        },
    ] = &hits[..]
    else {
        panic!("{hits:?}")
    };
    assert_eq!(
        picks[..],
        [(
            near,
            HitData::new(camera, 3.5, Some(Vec3::X * 3.5), Some(Vec3::NEG_X))
        )]
    );
}

/// What is known beyond that comes along: for each that is picked, which polygon was met.
#[test]
fn a_hit_brings_all_that_is_known_of_it() {
    let (mut app, _) = picking();
    let glass = spawn(
        &mut app,
        2.0,
        Pickable {
            should_block_lower: false,
            ..default()
        },
    );
    let corners = [[-9.0, -9.0], [-9.0, 9.0], [9.0, 9.0], [9.0, -9.0]];
    let corners = corners.map(|[y, z]| Vec3::new(0.0, y + 1.0, z));
    let wall = Shape::mesh(corners, [[0, 1, 2], [0, 2, 3]]).unwrap();
    let wall = (
        CollisionShape::from(wall),
        Transform::from_xyz(5.0, 0.0, 0.0),
    );
    let wall = app.world_mut().spawn(wall).id();
    let hits = hits(&mut app);
    let known: Vec<RayHit> = hits[0]
        .picks
        .iter()
        .map(|(_, data)| *data.extra_as().expect("it is known"))
        .collect();
    let met: Vec<_> = known.iter().map(|hit| (hit.entity, hit.distance)).collect();
    assert_eq!(met, [(glass, 1.5), (wall, 5.0)]);
    assert_eq!([known[0].polygon, known[1].polygon], [None, Some(0)]);
    assert_eq!(known[1].face_normal.x.abs(), 1.0);
    for (hit, (entity, data)) in known.iter().zip(&hits[0].picks) {
        assert_eq!(hit.entity, *entity);
        assert_eq!((data.depth, data.position), (hit.distance, Some(hit.point)));
        assert_eq!(data.normal, Some(hit.normal));
    }
}

#[test]
fn each_ray_picks_for_itself() {
    let (mut app, first) = picking();
    let [ahead, behind] = [4.0, -4.0].map(|x| spawn(&mut app, x, ()));
    let second = point(&mut app, Camera::default(), Dir3::NEG_X);
    point(&mut app, Camera::default(), Dir3::Y);
    point(
        &mut app,
        Camera {
            is_active: false,
            ..default()
        },
        Dir3::X,
    );
    let gone = point(&mut app, Camera::default(), Dir3::X);
    app.world_mut().despawn(gone);
    let mut found: Vec<_> = hits(&mut app)
        .iter()
        .flat_map(|hits| &hits.picks)
        .map(|(entity, hit)| (hit.camera, *entity))
        .collect();
    found.sort_unstable();
    let mut expected = [(first, ahead), (second, behind)];
    expected.sort_unstable();
    assert_eq!(found, expected);
}

#[test]
fn what_does_not_block_lets_others_be_picked_behind_it() {
    const GLASS: Pickable = Pickable {
        should_block_lower: false,
        is_hoverable: true,
    };
    const FOG: Pickable = Pickable {
        should_block_lower: true,
        is_hoverable: false,
    };
    let (mut app, _) = picking();
    spawn(&mut app, 2.0, Pickable::IGNORE);
    let glass = [4.0, 6.0].map(|x| spawn(&mut app, x, GLASS));
    assert_eq!(picked(&mut app), glass);
    let wall = spawn(&mut app, 8.0, ());
    spawn(&mut app, 10.0, ());
    assert_eq!(picked(&mut app), [glass[0], glass[1], wall]);
    // It cannot be hovered, but hides the wall: Bevy has to be told.
    let fog = spawn(&mut app, 7.0, FOG);
    assert_eq!(picked(&mut app), [glass[0], glass[1], fog]);
    app.world_mut()
        .entity_mut(glass[0])
        .insert(Pickable::default());
    assert_eq!(picked(&mut app), [glass[0]]);
}

#[test]
fn markers_are_asked_for_if_required() {
    let (mut app, camera) = picking();
    let plain = spawn(&mut app, 2.0, ());
    let marked = spawn(&mut app, 4.0, CollisionPickable);
    assert_eq!(picked(&mut app), [plain]);
    app.world_mut()
        .resource_mut::<CollisionPickingSettings>()
        .require_markers = true;
    assert!(picked(&mut app).is_empty());
    app.world_mut().entity_mut(camera).insert(CollisionPickable);
    assert_eq!(picked(&mut app), [marked]);
}

#[test]
fn a_camera_with_layers_picks_what_it_may_meet() {
    let (mut app, camera) = picking();
    let on_first = spawn(&mut app, 2.0, ());
    let on_third = spawn(&mut app, 4.0, CollisionLayers::from_bits(0b100, 0));
    for (layers, expected) in [
        (CollisionLayers::ALL, vec![on_first]),
        (CollisionLayers::from_bits(0, 0b110), vec![on_third]),
        (CollisionLayers::from_bits(u32::MAX, 0b010), vec![]),
    ] {
        app.world_mut().entity_mut(camera).insert(layers);
        assert_eq!(picked(&mut app), expected, "{layers:?}");
    }
}

#[test]
fn a_camera_picks_in_all_worlds_or_in_its_own() {
    let (mut app, camera) = picking();
    let [first, second] = [(); 2].map(|()| app.world_mut().spawn_empty().id());
    let near = spawn(&mut app, 2.0, InCollisionWorld(first));
    assert_eq!(picked(&mut app), [near]);
    let far = spawn(&mut app, 4.0, InCollisionWorld(second));
    let farther = spawn(&mut app, 6.0, ());
    assert_eq!(picked(&mut app), [near]);
    app.world_mut()
        .entity_mut(camera)
        .insert(InCollisionWorld(second));
    assert_eq!(picked(&mut app), [far]);
    app.world_mut().despawn(first);
    app.world_mut()
        .entity_mut(camera)
        .remove::<InCollisionWorld>();
    app.world_mut().despawn(far);
    assert_eq!(picked(&mut app), [farther]);
}

#[test]
fn what_is_gone_or_elsewhere_is_not_picked() {
    let (mut app, _) = picking();
    let cubes = [2.0, 4.0, 6.0].map(|x| spawn(&mut app, x, ()));
    assert_eq!(picked(&mut app), [cubes[0]]);
    app.world_mut().despawn(cubes[0]);
    assert_eq!(picked(&mut app), [cubes[1]]);
    get_mut::<Transform>(&mut app, cubes[1]).translation.y = 3.0;
    assert_eq!(picked(&mut app), [cubes[2]]);
    app.world_mut()
        .entity_mut(cubes[2])
        .remove::<CollisionShape>();
    assert!(picked(&mut app).is_empty());
}

/// With Bevy's own plugins, added later, what is picked is hovered.
#[test]
fn what_is_picked_is_hovered() {
    let (mut app, _) = picking();
    // There is no window to make rays from.
    app.insert_resource(PickingSettings {
        is_input_enabled: false,
        is_window_picking_enabled: false,
        ..default()
    })
    .add_plugins((PickingPlugin, InteractionPlugin));
    app.world_mut().spawn(PointerId::Mouse);
    let cube = spawn(&mut app, 4.0, ());
    hits(&mut app);
    let hovered = app.world().resource::<HoverMap>().get(&PointerId::Mouse);
    assert_eq!(
        hovered.map(|hits| hits.keys().copied().collect::<Vec<_>>()),
        Some(vec![cube])
    );
}
