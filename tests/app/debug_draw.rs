//! What is drawn of leaves, boxes, contacts and queries.

use crate::common;
#[path = "../../examples/common/gizmo_lines.rs"]
mod gizmo_lines;

use bevy::{
    color::palettes::css,
    ecs::entity_disabling::{DefaultQueryFilters, Disabled},
    gizmos::GizmoPlugin,
    math::bounding::{Aabb3d, BoundingVolume},
    mesh::MeshPlugin,
    prelude::*,
};
use bevy_octree::{
    broad_phase::{Leaf, ObjectOctree, ObjectOctreeSettings, RootPolicy},
    collision_index::CollisionIndex,
    components::WorldAabb,
    debug_draw::LeafColors,
    narrow_phase::Contact,
    prelude::*,
    spatial_query::SpatialQuery,
};
use common::*;
use gizmo_lines::paths;

const MOVING: Color = Color::Srgba(css::RED);
const RESTING: Color = Color::Srgba(css::GREEN);
const CONTACTS: Color = Color::Srgba(css::BLUE);
const RAYS: Color = Color::Srgba(css::YELLOW);
const SWEEPS: Color = Color::Srgba(css::MAGENTA);
const OWN: Color = Color::Srgba(css::ORANGE);
const LEAST: Color = Color::BLACK;
const MOST: Color = Color::WHITE;

/// Draws nothing.
const NOTHING: CollisionGizmos = CollisionGizmos {
    moving: None,
    resting: None,
    shapes: None,
    contacts: None,
    normal_length: 2.0,
    leaves: None,
    leaf_colors: [LEAST, MOST],
    rays: None,
    ray_length: 50.0,
    sweeps: None,
};

/// An app that draws, nothing so far.
fn drawing(method: BroadPhaseMethod) -> App {
    let mut app = app(method);
    app.add_plugins((
        AssetPlugin::default(),
        MeshPlugin,
        GizmoPlugin,
        CollisionDebugPlugin,
    ))
    .insert_gizmo_config(NOTHING, GizmoConfig::default());
    app
}

/// Changes what is drawn, from the next frame on.
fn set(app: &mut App, gizmos: CollisionGizmos) {
    *app.world_mut()
        .resource_mut::<GizmoConfigStore>()
        .config_mut::<CollisionGizmos>()
        .1 = gizmos;
}

/// A frame with this drawn; no tick if time stands still.
fn draw(app: &mut App, gizmos: CollisionGizmos) {
    set(app, gizmos);
    app.update();
}

/// The lines in a colour, each from point to point.
fn lines(app: &App, color: Color) -> Vec<[Vec3; 2]> {
    let paths = paths(app)
        .into_iter()
        .filter(|path| path.color == LinearRgba::from(color));
    paths
        .flat_map(|path| {
            path.points
                .windows(2)
                .map(|line| [line[0], line[1]])
                .collect::<Vec<_>>()
        })
        .collect()
}

/// The boxes, and their colours. Each has one strip of lines, and nothing else has.
fn boxes(app: &App) -> Vec<(Aabb3d, LinearRgba)> {
    let strips = paths(app).into_iter().filter(|path| path.points.len() > 2);
    strips
        .map(|path| {
            (
                Aabb3d::from_point_cloud(Isometry3d::IDENTITY, path.points.into_iter()),
                path.color,
            )
        })
        .collect()
}

/// The boxes of these colours, in the order of their centres along x.
fn boxes_in(app: &App, colors: &[Color]) -> Vec<Aabb3d> {
    let wanted = |color: &LinearRgba| {
        colors
            .iter()
            .any(|wanted| LinearRgba::from(*wanted) == *color)
    };
    let mut boxes: Vec<_> = boxes(app)
        .into_iter()
        .filter(|(_, color)| wanted(color))
        .map(|(aabb, _)| aabb)
        .collect();
    boxes.sort_by(|a, b| a.center().x.total_cmp(&b.center().x));
    boxes
}

fn spawn(app: &mut App, x: f32) -> Entity {
    app.world_mut()
        .spawn((CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0)))
        .id()
}

fn aabb(app: &App, entity: Entity) -> Aabb3d {
    get::<WorldAabb>(app, entity).0
}

#[test]
fn boxes_are_those_of_the_entities_and_tell_which_moved() {
    let mut app = drawing(BroadPhaseMethod::default());
    let [wall, ball] = [0.0, 8.0].map(|x| spawn(&mut app, x));
    app.world_mut().entity_mut(ball).insert(Velocity(Vec3::Y));
    set(
        &mut app,
        CollisionGizmos {
            moving: Some(MOVING),
            resting: Some(RESTING),
            ..NOTHING
        },
    );
    tick(&mut app, 1);
    // What has just come has moved.
    assert_eq!(
        boxes_in(&app, &[MOVING]),
        [aabb(&app, wall), aabb(&app, ball)]
    );
    tick(&mut app, 1);
    assert_eq!(boxes_in(&app, &[MOVING]), [aabb(&app, ball)]);
    assert_eq!(boxes_in(&app, &[RESTING]), [aabb(&app, wall)]);
    assert_eq!(lines(&app, RESTING).len(), 12, "the edges of a box");

    draw(
        &mut app,
        CollisionGizmos {
            resting: Some(RESTING),
            ..NOTHING
        },
    );
    assert_eq!(boxes(&app).len(), 1);
    assert_eq!(boxes_in(&app, &[RESTING]).len(), 1);
    draw(&mut app, NOTHING);
    assert!(paths(&app).is_empty());
    draw(
        &mut app,
        CollisionGizmos {
            moving: Some(MOVING),
            ..NOTHING
        },
    );
    assert_eq!((boxes(&app).len(), boxes_in(&app, &[MOVING]).len()), (1, 1));
    app.world_mut().despawn(ball);
    app.update();
    assert!(paths(&app).is_empty());
}

#[test]
fn an_entity_may_have_a_colour_of_its_own_or_be_hidden() {
    let mut app = drawing(BroadPhaseMethod::default());
    let [plain, own, hidden] = [0.0, 8.0, 16.0].map(|x| spawn(&mut app, x));
    app.world_mut()
        .entity_mut(own)
        .insert(DebugDraw::Color(OWN));
    app.world_mut().entity_mut(hidden).insert(DebugDraw::Hidden);
    tick(&mut app, 2);
    for (resting, expected) in [(Some(RESTING), vec![plain]), (None, vec![])] {
        draw(&mut app, CollisionGizmos { resting, ..NOTHING });
        assert_eq!(
            boxes_in(&app, &[OWN]),
            [aabb(&app, own)],
            "whether or not others are drawn"
        );
        assert_eq!(
            boxes_in(&app, &[RESTING]),
            expected.iter().map(|e| aabb(&app, *e)).collect::<Vec<_>>()
        );
        assert_eq!(boxes(&app).len(), 1 + expected.len());
    }
    app.world_mut().entity_mut(hidden).remove::<DebugDraw>();
    draw(
        &mut app,
        CollisionGizmos {
            resting: Some(RESTING),
            ..NOTHING
        },
    );
    assert_eq!(
        boxes_in(&app, &[RESTING]),
        [aabb(&app, plain), aabb(&app, hidden)]
    );
}

/// The leaves as the broad phase tells them.
fn leaves(app: &App) -> Vec<Leaf> {
    let mut leaves = Vec::new();
    index(app).for_each_leaf(|leaf| leaves.push(leaf));
    leaves
}

/// Nine objects in a root of 16 around the origin, five of them in a cluster in one octant, so that
/// it splits again.
fn clustered(method: BroadPhaseMethod) -> App {
    let mut app = drawing(method);
    for at in [
        [-4.0, 4.0, 4.0],
        [4.0, -4.0, 4.0],
        [4.0, 4.0, -4.0],
        [-4.0, -4.0, -4.0],
    ] {
        app.world_mut().spawn((
            CollisionShape::default(),
            Transform::from_translation(at.into()),
        ));
    }
    for i in 0..5_u16 {
        let at = Vec3::splat(1.0 + f32::from(i) * 1.5);
        app.world_mut()
            .spawn((CollisionShape::default(), Transform::from_translation(at)));
    }
    tick(&mut app, 1);
    app
}

#[test]
fn leaves_of_the_octree_are_cells_within_the_root() {
    let root = RootPolicy::Cube {
        center: Vec3::ZERO,
        half_size: 8.0,
    };
    let settings = ObjectOctreeSettings {
        root,
        ..ObjectOctreeSettings::with_max_objects(2)
    };
    let mut app = clustered(BroadPhaseMethod::ObjectOctree(settings));
    let leaves = leaves(&app);
    let (depth, fullest) = leaves.iter().fold((0, 0), |(depth, full), leaf| {
        (depth.max(leaf.generation), full.max(leaf.objects))
    });
    assert!(depth >= 2 && fullest == 2, "{leaves:?}");
    let volume = |aabb: &Aabb3d| (aabb.max - aabb.min).to_array().iter().product::<f32>();
    assert_eq!(
        leaves.iter().map(|leaf| volume(&leaf.bounds)).sum::<f32>(),
        16.0 * 16.0 * 16.0
    );

    assert!(paths(&app).is_empty());
    for (colors, of, most) in [
        (
            LeafColors::Generation,
            (|leaf| leaf.generation) as fn(&Leaf) -> u32,
            depth,
        ),
        (LeafColors::Fill, |leaf| leaf.objects, fullest),
    ] {
        draw(
            &mut app,
            CollisionGizmos {
                leaves: Some(colors),
                ..NOTHING
            },
        );
        let drawn = boxes(&app);
        assert_eq!(
            drawn.iter().map(|(aabb, _)| *aabb).collect::<Vec<_>>(),
            cells(&leaves)
        );
        for (leaf, (_, color)) in leaves.iter().zip(drawn) {
            let shade = Oklaba::from(LEAST).mix(&Oklaba::from(MOST), of(leaf) as f32 / most as f32);
            assert_eq!(color, LinearRgba::from(Color::from(shade)), "{leaf:?}");
        }
    }
    let root = index(&app)
        .engine_as::<ObjectOctree>()
        .and_then(ObjectOctree::root_cell)
        .unwrap();
    assert!(boxes(&app).iter().all(|(aabb, _)| root.contains(aabb)));
}

fn cells(leaves: &[Leaf]) -> Vec<Aabb3d> {
    leaves.iter().map(|leaf| leaf.bounds).collect()
}

#[test]
fn leaves_of_the_linear_octree_hold_its_objects() {
    let mut app = clustered(BroadPhaseMethod::LinearOctree);
    draw(
        &mut app,
        CollisionGizmos {
            leaves: Some(LeafColors::Fill),
            ..NOTHING
        },
    );
    let drawn: Vec<_> = boxes(&app).into_iter().map(|(aabb, _)| aabb).collect();
    assert_eq!(drawn, cells(&leaves(&app)));
    for (_, aabb) in index(&app).proxies().iter() {
        assert!(drawn.iter().any(|leaf| leaf.contains(aabb)));
    }
}

#[test]
fn without_a_tree_there_are_no_leaves() {
    for method in [BroadPhaseMethod::default(), BroadPhaseMethod::Exhaustive] {
        let mut app = clustered(method);
        draw(
            &mut app,
            CollisionGizmos {
                leaves: Some(LeafColors::Generation),
                ..NOTHING
            },
        );
        assert!(paths(&app).is_empty());
    }
}

#[test]
fn contacts_have_their_normal_where_it_is_known_and_a_line_else() {
    for geometry in [EventScope::All, EventScope::Enabled] {
        let mut app = drawing(BroadPhaseMethod::default());
        app.world_mut()
            .resource_mut::<CollisionEventSettings>()
            .geometry = geometry;
        let [a, b] = [0.0, 0.75].map(|x| spawn(&mut app, x));
        spawn(&mut app, 9.0);
        tick(&mut app, 1);
        assert!(paths(&app).is_empty());
        draw(
            &mut app,
            CollisionGizmos {
                contacts: Some(CONTACTS),
                ..NOTHING
            },
        );
        let drawn = lines(&app, CONTACTS);
        assert_eq!(paths(&app).len(), drawn.len());
        let contact = app.world().resource::<Contacts>().iter().next().unwrap();
        let centers: [Vec3; 2] =
            [contact.a, contact.b].map(|entity| aabb(&app, entity).center().into());
        if geometry == EventScope::Enabled {
            assert_eq!(drawn, [centers]);
            continue;
        }
        let Contact { normal, point, .. } = contact.contact.unwrap();
        assert!(drawn.contains(&[point, point + 2.0 * normal]), "{drawn:?}");
        assert_eq!(drawn.len(), 3 + 5, "a cross and an arrow");
        let mut flat = NOTHING;
        (flat.contacts, flat.normal_length) = (Some(CONTACTS), 0.0);
        draw(&mut app, flat);
        let drawn = lines(&app, CONTACTS);
        assert!(
            drawn.len() == 3 && drawn.iter().flatten().all(|point| point.is_finite()),
            "{drawn:?}"
        );
        // An entity that is gone may have a contact until the next tick.
        app.world_mut().despawn(a);
        app.update();
        app.world_mut().despawn(b);
        app.update();
        assert!(paths(&app).is_empty());
    }
}

#[test]
fn a_ray_is_drawn_to_what_it_hits() {
    let mut app = drawing(BroadPhaseMethod::default());
    spawn(&mut app, 4.0);
    let cast = |spatial: SpatialQuery, mut gizmos: Gizmos<CollisionGizmos>| {
        for direction in [Dir3::X, Dir3::NEG_X] {
            let ray = Ray3d::new(Vec3::ZERO, direction);
            gizmos.ray_hit(
                ray,
                spatial.cast_ray(ray, f32::MAX, &SpatialQueryFilter::DEFAULT),
            );
        }
    };
    app.add_systems(
        Update,
        cast.run_if(|contacts: Res<CollisionIndex>| !contacts.index().proxies().is_empty()),
    );
    tick(&mut app, 2);
    assert!(paths(&app).is_empty());
    draw(
        &mut app,
        CollisionGizmos {
            rays: Some(RAYS),
            ..NOTHING
        },
    );
    let drawn = lines(&app, RAYS);
    let met = drawn[0][1];
    assert!(met.distance(Vec3::X * 3.5) < 1e-3, "{met}");
    assert!(drawn.contains(&[met, met + 2.0 * Vec3::NEG_X]), "{drawn:?}");
    assert!(
        drawn.contains(&[Vec3::ZERO, 50.0 * Vec3::NEG_X]),
        "{drawn:?}"
    );
    assert_eq!(drawn.len(), 1 + 3 + 5 + 1);
}

/// As far as they reach, with what they met; those of an entity that hangs on another where that is.
/// What hangs on something that is disabled, by whatever component, is drawn where it is; what is disabled, is not.
#[test]
fn casters_are_drawn_where_they_are() {
    #[derive(Component, Default)]
    struct Asleep;

    let stops: [fn(EntityWorldMut); 2] = [
        |mut entity| _ = entity.insert(Disabled),
        |mut entity| _ = entity.insert(Asleep),
    ];
    for stop in stops {
        let mut app = drawing(BroadPhaseMethod::default());
        let id = app.world_mut().register_component::<Asleep>();
        app.world_mut()
            .resource_mut::<DefaultQueryFilters>()
            .register_disabling_component(id);
        let casters = (
            RayCaster::new(Vec3::ZERO, Dir3::Y).with_length(2.0),
            ShapeCaster::new(Sphere::new(0.25), Vec3::ZERO, Dir3::Y).with_length(2.0),
        );
        let mast = app
            .world_mut()
            .spawn(Transform::from_xyz(5.0, 0.0, 0.0))
            .id();
        let eye = app.world_mut().spawn((casters, ChildOf(mast))).id();
        let gizmos = CollisionGizmos {
            rays: Some(RAYS),
            sweeps: Some(SWEEPS),
            ..NOTHING
        };
        // In whatever order they are drawn: does one of them begin there, if there are any?
        let starts = |app: &mut App| {
            tick(app, 1);
            draw(app, gizmos);
            [RAYS, SWEEPS].map(|color| {
                let lines = lines(app, color);
                let begins = |line: &[Vec3; 2]| line[0] == Vec3::X * 5.0;
                (!lines.is_empty()).then(|| lines.iter().any(begins))
            })
        };
        let expected = [Some(true); 2];
        assert_eq!(starts(&mut app), expected);
        stop(app.world_mut().entity_mut(mast));
        assert_eq!(starts(&mut app), expected);
        stop(app.world_mut().entity_mut(eye));
        assert_eq!(starts(&mut app), [None; 2]);
    }
}

#[test]
fn casters_are_drawn_with_what_they_met() {
    let mut app = drawing(BroadPhaseMethod::default());
    for x in [4.0, 8.0] {
        spawn(&mut app, x);
    }
    let mast = app
        .world_mut()
        .spawn(Transform::from_xyz(1.0, 0.0, 0.0))
        .id();
    let eye = app
        .world_mut()
        .spawn((RayCaster::default(), ChildOf(mast)))
        .id();
    let gizmos = CollisionGizmos {
        rays: Some(RAYS),
        sweeps: Some(SWEEPS),
        ..NOTHING
    };
    let look = |app: &mut App, caster: RayCaster| {
        app.world_mut().entity_mut(eye).insert(caster);
        tick(app, 1);
        draw(app, gizmos);
        lines(app, RAYS)
    };
    let x = |x: f32| Vec3::X * x;
    let ahead = RayCaster::new(Vec3::ZERO, Dir3::X);
    let near = |line: &[Vec3; 2], expected: [Vec3; 2]| {
        line.iter()
            .zip(expected)
            .all(|(point, other)| point.distance(other) < 1e-3)
    };
    let has = |drawn: &[[Vec3; 2]], line: [Vec3; 2]| drawn.iter().any(|one| near(one, line));
    // The line, a cross of three lines, an arrow of five.
    let drawn = look(&mut app, ahead.clone());
    assert!(
        has(&drawn, [x(1.0), x(3.5)]) && has(&drawn, [x(3.5), x(1.5)]),
        "{drawn:?}"
    );
    assert_eq!(drawn.len(), 1 + 3 + 5);
    // Two, and one more would be met: it goes on.
    let drawn = look(&mut app, ahead.clone().with_max_hits(3));
    assert!(has(&drawn, [x(1.0), x(51.0)]), "{drawn:?}");
    assert_eq!(drawn.len(), 1 + 2 * (3 + 5));
    // Nothing is met, and nothing is drawn beyond its end.
    let drawn = look(&mut app, ahead.clone().with_length(2.0));
    assert!(
        drawn.len() == 1 && near(&drawn[0], [x(1.0), x(3.0)]),
        "{drawn:?}"
    );
    let off = RayCaster {
        enabled: false,
        ..ahead
    };
    assert!(look(&mut app, off).is_empty());
    assert!(lines(&app, SWEEPS).is_empty());

    // A ball that is cast: the way, the ball where it touches, and where that is.
    let ball = ShapeCaster::new(Sphere::new(0.25), Vec3::ZERO, Dir3::X);
    app.world_mut()
        .entity_mut(eye)
        .remove::<RayCaster>()
        .insert(ball.clone());
    tick(&mut app, 1);
    draw(&mut app, gizmos);
    let drawn = lines(&app, SWEEPS);
    assert!(
        has(&drawn, [x(1.0), x(3.25)]) && has(&drawn, [x(3.5), x(1.5)]),
        "{drawn:?}"
    );
    let beside = drawn
        .iter()
        .flatten()
        .map(|point| point.y.abs())
        .fold(0.0, f32::max);
    // The ball, or the arrow beside it.
    assert!((0.24..0.5).contains(&beside), "{beside}");
    let round = drawn.len();
    // One that touches nothing is where its way ends.
    app.world_mut()
        .entity_mut(eye)
        .insert(ball.with_length(1.0));
    tick(&mut app, 1);
    draw(&mut app, gizmos);
    let drawn = lines(&app, SWEEPS);
    assert!(has(&drawn, [x(1.0), x(2.0)]), "{drawn:?}");
    assert_eq!(drawn.len(), round - 3 - 5);
    app.world_mut().entity_mut(eye).insert(DebugDraw::Hidden);
    draw(&mut app, gizmos);
    assert!(paths(&app).is_empty());
}

#[test]
fn a_swept_box_is_two_boxes_and_what_is_between() {
    let mut app = drawing(BroadPhaseMethod::default());
    let [start, end] = [Vec3::ZERO, Vec3::X * 9.0].map(|at| Aabb3d::new(at, Vec3::ONE));
    app.add_systems(Update, move |mut gizmos: Gizmos<CollisionGizmos>| {
        gizmos.swept_box(&start, &end);
    });
    app.update();
    assert!(paths(&app).is_empty());
    draw(
        &mut app,
        CollisionGizmos {
            sweeps: Some(SWEEPS),
            ..NOTHING
        },
    );
    assert_eq!(boxes_in(&app, &[SWEEPS]), [start, end]);
    assert_eq!(lines(&app, SWEEPS).len(), 12 + 12 + 8);
}

/// Where it came from, where it is, and what is between; of one that rests, nothing.
#[test]
fn the_way_of_a_swept_entity_is_drawn() {
    let mut app = drawing(BroadPhaseMethod::default());
    let bullet = spawn(&mut app, 0.0);
    app.world_mut()
        .entity_mut(bullet)
        .insert((Swept::default(), Velocity(Vec3::X * 9.0 * TICKS_PER_SECOND)));
    let sweeps = CollisionGizmos {
        sweeps: Some(SWEEPS),
        ..NOTHING
    };
    draw(&mut app, sweeps);
    draw(&mut app, sweeps);
    let way = [9.0, 18.0].map(|x| Aabb3d::new(Vec3::X * x, Vec3::splat(0.5)));
    assert_eq!(boxes_in(&app, &[SWEEPS]), way);
    app.world_mut().entity_mut(bullet).insert(DebugDraw::Hidden);
    draw(&mut app, sweeps);
    assert!(paths(&app).is_empty());
    app.world_mut()
        .entity_mut(bullet)
        .remove::<DebugDraw>()
        .insert(Velocity::default());
    draw(&mut app, sweeps);
    assert!(paths(&app).is_empty());
}

/// By default everything but leaves; the switch that all gizmo groups have turns it all off.
#[test]
fn a_group_that_is_disabled_draws_nothing() {
    let mut app = drawing(BroadPhaseMethod::LinearOctree);
    let gizmos = CollisionGizmos::default();
    for x in [0.0, 0.75] {
        spawn(&mut app, x);
    }
    draw(&mut app, gizmos);
    assert_eq!(boxes(&app).len(), 2);
    assert_eq!(lines(&app, gizmos.contacts.unwrap()).len(), 1);
    app.world_mut()
        .resource_mut::<GizmoConfigStore>()
        .config_mut::<CollisionGizmos>()
        .0
        .enabled = false;
    app.update();
    assert!(paths(&app).is_empty());
}

/// What the last tick found stays to be seen in frames without a tick, whatever the schedule of the
/// ticks.
#[test]
fn every_frame_shows_the_last_tick() {
    let plugins = (AssetPlugin::default(), MeshPlugin, GizmoPlugin);
    let mut app = app_with(OctreePlugins::new(PostUpdate), PostUpdate);
    app.add_plugins((plugins, CollisionDebugPlugin));
    spawn(&mut app, 0.0);
    app.update();
    assert_eq!(boxes(&app).len(), 1, "in the frame of the tick");

    let mut app = drawing(BroadPhaseMethod::default());
    set(&mut app, CollisionGizmos::default());
    spawn(&mut app, 0.0);
    tick(&mut app, 1);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    tick(&mut app, 3);
    assert_eq!(boxes(&app).len(), 1);
}

#[test]
fn without_gizmos_the_plugin_does_nothing() {
    let mut app = app(BroadPhaseMethod::default());
    app.add_plugins(CollisionDebugPlugin).add_systems(
        Update,
        |gizmos: Option<Gizmos<CollisionGizmos>>| {
            assert!(gizmos.is_none());
        },
    );
    spawn(&mut app, 0.0);
    tick(&mut app, 2);
    assert_eq!(counters(&app).objects, 1);
}

const SHAPES: Color = Color::Srgba(css::TEAL);

/// The box around all that is drawn in a colour.
fn extent(app: &App, color: Color) -> Option<Aabb3d> {
    let lines = lines(app, color);
    (!lines.is_empty())
        .then(|| Aabb3d::from_point_cloud(Isometry3d::IDENTITY, lines.into_iter().flatten()))
}

fn assert_around(drawn: Aabb3d, expected: Aabb3d) {
    let off = (drawn.min - expected.min).abs() + (drawn.max - expected.max).abs();
    assert!(off.max_element() < 0.01, "{drawn:?}, {expected:?}");
}

/// Turned so that what is round reaches as far as its box along the axes.
#[test]
fn shapes_are_drawn_as_large_as_their_boxes_and_where_they_are() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let shapes = [
        Shape::cuboid(1.0, 2.0, 3.0),
        Shape::sphere(0.5),
        Shape::capsule(0.5, 1.0),
        Shape::cone(0.5, 1.0),
        Shape::cylinder(0.5, 2.0),
        Shape::conical_frustum(0.25, 0.5, 1.0),
        Shape::capsule_between(Vec3::NEG_X, Vec3::X, 0.5).unwrap(),
        Shape::triangle(Vec3::ZERO, Vec3::X, Vec3::Y).unwrap(),
        Shape::segment(Vec3::NEG_X, Vec3::ONE).unwrap(),
        Shape::rounded(&Shape::cuboid(1.0, 2.0, 3.0), 0.25).unwrap(),
        Shape::rounded(&Shape::cylinder(0.5, 1.0), 0.25).unwrap(),
        Shape::convex(corners, faces).unwrap(),
        Shape::mesh(corners, faces).unwrap(),
    ];
    for shape in shapes {
        let mut app = drawing(BroadPhaseMethod::default());
        let place = Transform {
            translation: Vec3::new(5.0, 6.0, 7.0),
            rotation: Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
            scale: Vec3::new(2.0, -2.0, 2.0),
        };
        let text = format!("{shape:?}");
        let entity = app.world_mut().spawn((CollisionShape(shape), place)).id();
        let shapes = Some(SHAPES);
        set(&mut app, CollisionGizmos { shapes, ..NOTHING });
        tick(&mut app, 2);
        let drawn = extent(&app, SHAPES).unwrap_or_else(|| panic!("{text} is not drawn"));
        assert_around(drawn, aabb(&app, entity));
        draw(&mut app, NOTHING);
        assert_eq!(extent(&app, SHAPES), None);
    }
}

#[test]
fn a_shape_has_the_colour_of_its_entity_or_is_hidden_with_it() {
    let mut app = drawing(BroadPhaseMethod::default());
    let [plain, own, hidden] = [0.0, 8.0, 16.0].map(|x| spawn(&mut app, x));
    app.world_mut()
        .entity_mut(own)
        .insert(DebugDraw::Color(OWN));
    app.world_mut().entity_mut(hidden).insert(DebugDraw::Hidden);
    tick(&mut app, 1);
    let shapes = Some(SHAPES);
    draw(&mut app, CollisionGizmos { shapes, ..NOTHING });
    assert_around(extent(&app, SHAPES).unwrap(), aabb(&app, plain));
    assert_around(extent(&app, OWN).unwrap(), aabb(&app, own));
    // What is not drawn of others is not drawn of it, but for its box.
    draw(&mut app, NOTHING);
    assert_eq!(lines(&app, OWN).len(), 12);
}

#[test]
fn shapes_without_an_end_are_a_patch() {
    let mut app = drawing(BroadPhaseMethod::default());
    let ground = CollisionShape(Shape::half_space(Vec3::Y).unwrap());
    app.world_mut()
        .spawn((ground, Transform::from_xyz(0.0, 3.0, 0.0)));
    let shapes = Some(SHAPES);
    set(&mut app, CollisionGizmos { shapes, ..NOTHING });
    tick(&mut app, 2);
    let drawn = extent(&app, SHAPES).expect("it is drawn");
    assert!(drawn.min.y == 3.0 && drawn.max.x <= 10.0, "{drawn:?}");
}

/// What `bsn!` does with a colour of one entity: it starts from the default of the variant.
#[test]
fn a_colour_can_be_named_in_templates() {
    let mut template = <DebugDraw as FromTemplate>::Template::default_color();
    if let DebugDraw::Color(color) = &mut template {
        *color = OWN;
    }
    let mut world = World::new();
    let mut entity = world.spawn_empty();
    let built: DebugDraw = entity.build_template(&template).unwrap();
    assert_eq!(built, DebugDraw::Color(OWN));
}
