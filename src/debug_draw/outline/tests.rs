use bevy::{
    gizmos::config::DefaultGizmoConfigGroup,
    math::{Vec3A, bounding::Aabb3d},
};

use super::*;

type TestPen<'a> = Pen<'a, DefaultGizmoConfigGroup, ()>;

/// The lines that are drawn.
fn lines(draw: impl FnOnce(&mut TestPen)) -> Vec<[Vec3; 2]> {
    let mut gizmos = GizmoBuffer::<DefaultGizmoConfigGroup, ()>::new();
    draw(&mut Pen {
        gizmos: &mut gizmos,
        color: Color::WHITE,
    });
    let strips = gizmos.strip_positions.windows(2).map(|w| [w[0], w[1]]);
    let pairs = gizmos.list_positions.chunks_exact(2).map(|l| [l[0], l[1]]);
    // What is not a number ends a strip.
    let lines = strips.chain(pairs);
    lines.filter(|[a, b]| !(a.is_nan() || b.is_nan())).collect()
}

/// The box around what is drawn.
fn bounds(draw: impl FnOnce(&mut TestPen)) -> Aabb3d {
    let lines = lines(draw);
    assert!(!lines.is_empty());
    Aabb3d::from_point_cloud(Isometry3d::IDENTITY, lines.into_iter().flatten())
}

#[track_caller]
fn assert_near(aabb: Aabb3d, min: Vec3, max: Vec3) {
    let off = (aabb.min - Vec3A::from(min)).abs() + (aabb.max - Vec3A::from(max)).abs();
    assert!(
        off.max_element() < 1e-3,
        "{aabb:?}, not from {min} to {max}"
    );
}

const SCALED: Transform = Transform {
    translation: Vec3::new(10.0, 0.0, 0.0),
    rotation: Quat::IDENTITY,
    scale: Vec3::new(1.0, -3.0, 2.0),
};
const HERE: Transform = Transform::IDENTITY;

#[test]
fn each_kind_is_drawn_as_large_as_it_is() {
    let x = Vec3::X * 10.0;
    let half = Vec3::new(1.0, 2.0, 3.0);
    assert_near(bounds(|pen| pen.cuboid(&HERE, half)), -half, half);
    let scaled = Vec3::new(1.0, 6.0, 6.0);
    assert_near(
        bounds(|pen| pen.cuboid(&SCALED, half)),
        x - scaled,
        x + scaled,
    );
    let three = Vec3::splat(3.0);
    assert_near(bounds(|pen| pen.sphere(&SCALED, 1.0)), x - three, x + three);
    // The larger one across, and the one along.
    let reach = Vec3::new(1.0, 6.0 + 1.0, 1.0);
    assert_near(
        bounds(|pen| pen.capsule(&SCALED, 0.5, 2.0)),
        x - reach,
        x + reach,
    );
    // Elliptic, and upside down.
    let reach = Vec3::new(2.0, 3.0, 4.0);
    let cone = lines(|pen| pen.frustum(&SCALED, 0.0, 2.0, 1.0));
    assert_near(
        bounds(|pen| pen.frustum(&SCALED, 0.0, 2.0, 1.0)),
        x - reach,
        x + reach,
    );
    for point in cone.into_iter().flatten() {
        let below = (3.0 - point.y) / 6.0; // from the base at 3 to the tip at -3
        let across = ((point.x - 10.0) / 2.0).hypot(point.z / 4.0);
        assert!((across + below - 1.0).abs() < 1e-4, "{point}");
    }
    let tall = [1.0, 1.0, 1.0];
    let reach = Vec3::splat(1.5);
    assert_near(
        bounds(|pen| pen.rounded_frustum(&HERE, tall, 0.5)),
        -reach,
        reach,
    );
    let mirrored = HERE.with_scale(Vec3::new(2.0, -2.0, 2.0));
    let reach = Vec3::splat(3.0);
    assert_near(
        bounds(|pen| pen.rounded_frustum(&mirrored, tall, 0.5)),
        -reach,
        reach,
    );
    assert_near(
        bounds(|pen| pen.rounded_cuboid(&HERE, half, 0.5)),
        -half - 0.5,
        half + 0.5,
    );
    let ends = [Vec3::NEG_X, Vec3::X];
    assert_near(
        bounds(|pen| pen.segment(&SCALED, ends)),
        x - Vec3::X,
        x + Vec3::X,
    );
    assert_near(
        bounds(|pen| pen.rounded_segment(&HERE, ends, 0.5)),
        Vec3::new(-1.5, -0.5, -0.5),
        Vec3::new(1.5, 0.5, 0.5),
    );
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    assert_eq!(lines(|pen| pen.triangle(&HERE, corners)).len(), 3);
    let (rows, columns) = (3, 5);
    assert_near(
        bounds(|pen| {
            pen.height_field(
                &HERE,
                [rows, columns],
                Vec2::new(1.0, 2.0),
                |row, column| (row * column) as f32,
            );
        }),
        Vec3::new(-2.0, 0.0, -2.0),
        Vec3::new(2.0, 8.0, 2.0),
    );
    let cells = [IVec3::new(1, 0, 0), IVec3::NEG_ONE];
    assert_near(
        bounds(|pen| pen.voxels(&HERE, 0.5, 2, cells.into_iter())),
        Vec3::splat(-0.5),
        Vec3::new(1.0, 0.5, 0.5),
    );
}

/// Each point of the outline of a rounded frustum is as far from the frustum as the radius says.
#[test]
fn what_is_rounded_is_a_radius_away_from_what_is_within() {
    let [top, bottom, half_height] = [1.0f32, 2.0, 1.5];
    let (edge, radius) = (Vec2::new(bottom - top, -2.0 * half_height), 0.25);
    for point in lines(|pen| pen.rounded_frustum(&HERE, [top, bottom, half_height], radius))
        .into_iter()
        .flatten()
    {
        let at = Vec2::new(point.x.hypot(point.z), point.y);
        let from = Vec2::new(top, half_height);
        let share = ((at - from).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        let ends = [(half_height, top), (-half_height, bottom)];
        let to_ends = ends.map(|(y, r)| Vec2::new((at.x - r).max(0.0), at.y - y).length());
        let away = to_ends
            .into_iter()
            .fold(at.distance(from + edge * share), f32::min);
        assert!((away - radius).abs() < 1e-4, "{point} is {away} away");
    }
}

#[test]
fn a_half_space_is_a_patch_of_its_plane() {
    for at in [HERE, SCALED] {
        let normal = Vec3::new(1.0, 1.0, 0.0);
        let drawn = lines(|pen| pen.half_space(&at, normal));
        // As points of the plane are scaled.
        let out = (normal / at.scale).normalize();
        let on_plane = drawn.iter().flatten();
        let on_plane = on_plane.filter(|point| (**point - at.translation).dot(out).abs() < 1e-3);
        // All but the arrow.
        assert!(on_plane.count() > drawn.len(), "{at:?}");
    }
    assert!(lines(|pen| pen.half_space(&HERE, Vec3::ZERO)).is_empty());
}

#[test]
fn what_is_large_is_drawn_in_part() {
    let count = 10 * MOST_LINES as u32;
    let vertices: Vec<Vec3> = (0..=count).map(|x| Vec3::X * x as f32).collect();
    let edges: Vec<[u32; 2]> = (0..count).map(|start| [start, start + 1]).collect();
    let drawn = lines(|pen| pen.edges(&HERE, &vertices, &edges));
    assert!((MOST_LINES / 2..=MOST_LINES).contains(&drawn.len()));
    let drawn = lines(|pen| pen.edges(&HERE, &vertices, &edges[..MOST_LINES]));
    assert_eq!(drawn.len(), MOST_LINES);

    let few = lines(|pen| pen.height_field(&HERE, [1000, 2], Vec2::ONE, |_, _| 0.0));
    assert!(few.len() <= 3 * (MOST_ROWS + 1), "{}", few.len());
    let reach = Vec3::new(0.5, 0.0, 499.5);
    assert_near(
        bounds(|pen| pen.height_field(&HERE, [1000, 2], Vec2::ONE, |_, _| 0.0)),
        -reach,
        reach,
    );
    let cells = (0..5000).map(|x| IVec3::X * x);
    let boxes = lines(|pen| pen.voxels(&HERE, 1.0, 5000, cells));
    assert!(boxes.len() <= 12 * MOST_BOXES);
}

#[test]
fn a_part_is_where_its_pose_says_in_the_whole() {
    let whole = Transform::from_xyz(1.0, 0.0, 0.0).with_scale(Vec3::splat(2.0));
    let part = Isometry3d::new(Vec3::X, Quat::from_rotation_z(TAU / 4.0));
    let at = of_part(&whole, part);
    let tip = at.transform_point(Vec3::X);
    assert!(tip.distance(Vec3::new(3.0, 2.0, 0.0)) < 1e-5, "{tip}");
}
