//! Meshes of ours by their trees, and polygon by polygon.

use bevy::math::{Dir3, Vec3};
use bevy::transform::components::Transform;
use bevy_rapier3d::parry::math::Pose;
use bevy_rapier3d::parry::shape::SharedShape;

use crate::narrow_phase::support::query::tests::Random;
use crate::narrow_phase::*;

/// Hills with a tree, of four-sided polygons and of triangles, and the same without.
fn hills_with_and_without_tree(random: &mut Random) -> [Shape; 2] {
    let side = 9u32;
    let corners = (0..side * side).map(|i| {
        let [x, z] = [i % side, i / side].map(|i| i as f32 - 4.0);
        Vec3::new(x + 3.0, random.between(-0.8, 0.8), z - 1.0)
    });
    let corners: Vec<_> = corners.collect();
    let mut polygons = vec![];
    for z in 0..side - 1 {
        for x in 0..side - 1 {
            let a = z * side + x;
            let [b, c, d] = [a + side, a + side + 1, a + 1];
            polygons.extend([vec![a, b, c], vec![a, c, d]]);
        }
    }
    // A kite of four corners in one plane, so that something is cut.
    let mut corners = corners;
    let first = corners.len() as u32;
    corners.extend([
        Vec3::new(0.0, 2.0, 0.0),
        Vec3::new(1.0, 2.0, 0.5),
        Vec3::new(0.2, 2.0, 0.2),
        Vec3::new(0.5, 2.0, 1.0),
    ]);
    polygons.push(vec![first, first + 1, first + 2, first + 3]);
    let mesh = PolygonMesh::new(corners, polygons).expect("it is fine");
    assert!(mesh.tree().is_some());
    [mesh.clone(), mesh.without_tree()].map(Shape::from)
}

#[test]
fn a_mesh_by_its_tree_is_the_mesh_polygon_by_polygon() {
    let mut random = Random::new(12);
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let parts = vec![
        (
            Pose::translation(0.0, 1.0, 0.0),
            SharedShape::capsule_x(0.4, 0.2),
        ),
        (Pose::translation(0.0, -1.0, 0.5), SharedShape::ball(0.4)),
    ];
    let shapes: [Shape; 6] = [
        SharedShape::capsule_y(0.5, 0.25).into(),
        SharedShape::capsule_y(6.0, 0.05).into(),
        SharedShape::cylinder(0.5, 0.5).into(),
        SharedShape::compound(parts).into(),
        SharedShape::halfspace(Vec3::Y).into(),
        SharedShape::triangle(Vec3::ZERO, Vec3::X, Vec3::Y).into(),
    ];
    let (mut touching, mut swept) = (0, 0);
    for i in 0..900 {
        let meshes = hills_with_and_without_tree(&mut random);
        let mut scale = random.point() * 2.0;
        match i % 9 {
            0 => scale.y = 0.0,
            1 => scale = scale.with_x(0.0).with_z(1e-12),
            2 => scale *= 1e-3,
            3 => scale *= 1e4,
            4 => scale = Vec3::ONE,
            _ => {}
        }
        let reach = scale.abs().max_element();
        let at_mesh = Transform::from_translation(random.point() * 100.0)
            .with_rotation(random.turn())
            .with_scale(scale);
        let shape = &shapes[i % shapes.len()];
        let place = at_mesh.translation
            + at_mesh.rotation * (Vec3::X * 3.0 * scale.x)
            + random.point() * (4.0 * reach + 1.0);
        let at_shape = Transform::from_translation(place).with_rotation(random.turn());
        let direction = Dir3::new(at_mesh.translation - place + random.point()).unwrap_or(Dir3::X);
        let answers = meshes.map(|mesh| {
            let (mesh, shape) = (Placed::new(&mesh, &at_mesh), Placed::new(shape, &at_shape));
            let nearest = tests.closest_points(mesh, shape, &mut workspace);
            let contact = tests.contact(mesh, shape, &mut workspace);
            let sweep = [
                tests.sweep(shape, direction, 1e6, mesh, &mut workspace),
                tests.sweep(mesh, direction, 1e6, shape, &mut workspace),
            ];
            (
                nearest.map(|nearest| nearest.distance),
                contact.map(|contact| (contact.depth, contact.normal)),
                sweep.map(|met| met.map(|met| met.distance)),
            )
        });
        let [by_tree, one_by_one] = answers;
        assert_eq!(by_tree, one_by_one, "{i}: {shape:?} at {scale}");
        touching += usize::from(by_tree.1.is_some());
        swept += by_tree.2.iter().flatten().count();
    }
    assert!(touching > 100 && swept > 300, "{touching} {swept}");
}
