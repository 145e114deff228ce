//! Contacts of every kind of pair.

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;

use crate::narrow_phase::mesh::cube::SIDES;
use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

fn contact(a: (&Shape, Transform), b: (&Shape, Transform)) -> Contact {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let mut workspace = Workspace::default();
    let tests = NarrowPhase::default();
    let found = tests.contact(one, two, &mut workspace).unwrap();
    let back = tests.contact(two, one, &mut workspace).unwrap();
    let normal = -back.normal;
    assert_eq!(found, Contact { normal, ..back });
    found
}

fn assert_close(found: Contact, normal: Vec3, depth: f32) {
    let off = (found.normal - normal)
        .length()
        .max((found.depth - depth).abs());
    assert!(off < 1e-4, "{found:?}, expected {normal} {depth}");
}

#[test]
fn every_kind_of_pair_pushes_the_second_away() {
    let (cube, ball) = (box_of(1.0, 1.0, 1.0), Shape::sphere(1.0));
    let (mesh, here) = (mesh_of(Vec3::ONE), at(0.0, 0.0, 0.0));
    let convex = Shape::convex(mesh_vertices(&mesh).to_vec(), SIDES);
    let convex = convex.unwrap();
    for a in [&cube, &ball, &mesh, &convex] {
        for b in [&cube, &ball, &mesh, &convex] {
            let found = contact((a, here), (b, at(0.0, 1.75, 0.0)));
            assert_close(found, Vec3::Y, 0.25);
            assert!((found.point.y - 0.875).abs() < 0.126, "{found:?}");
            let touching = contact((a, at(1.0, 0.0, 0.0)), (b, at(-1.0, 0.0, 0.0)));
            assert_close(touching, Vec3::NEG_X, 0.0);
            let off = touching.point.abs();
            assert!(off.x < 1e-4 && off.y.max(off.z) < 0.2, "{touching:?}");
        }
    }
}

#[test]
fn a_mirror_does_not_turn_a_mesh_inside_out() {
    let mesh = mesh_of(Vec3::ONE);
    let mirrored = at(0.0, 0.0, 0.0).with_scale(Vec3::new(-1.0, 1.0, 1.0));
    let found = contact((&mesh, mirrored), (&mesh, at(0.0, 1.75, 0.0)));
    assert_close(found, Vec3::Y, 0.25);
    let flattened = mirrored.with_scale(Vec3::new(-1.0, 0.0, 1.0));
    let found = contact((&mesh, flattened), (&mesh, at(0.0, 1.0, 0.0)));
    assert!(
        found.normal.is_normalized() && found.depth < 1e-4,
        "{found:?}"
    );
}

fn mesh_vertices(shape: &Shape) -> &[Vec3] {
    match shape {
        Shape::Mesh(mesh) => mesh.vertices(),
        _ => unreachable!(),
    }
}

#[test]
fn a_ball_inside_leaves_by_the_nearest_face() {
    let small = Shape::sphere(0.1);
    let here = at(0.0, 0.0, 0.0);
    for solid in [box_of(1.0, 1.0, 1.0), mesh_of(Vec3::ONE)] {
        let found = contact((&solid, here), (&small, at(0.2, 0.0, -0.7)));
        assert_close(found, Vec3::NEG_Z, 0.4);
        // With its centre on the surface.
        let found = contact((&solid, here), (&small, at(0.2, 0.0, -1.0)));
        assert_close(found, Vec3::NEG_Z, 0.1);
    }
}

#[test]
fn cuboids_at_an_edge_and_on_a_floor() {
    let cube = box_of(1.0, 1.0, 1.0);
    let turned = Quat::from_rotation_z(std::f32::consts::FRAC_PI_4);
    let found = contact(
        (&cube, at(0.0, 0.0, 0.0)),
        (&cube, at(2.3, 0.0, 0.0).with_rotation(turned)),
    );
    assert_close(found, Vec3::X, 1.0 + 2f32.sqrt() - 2.3);
    let floor = box_of(100.0, 1.0, 100.0);
    let found = contact((&floor, at(0.0, 0.0, 0.0)), (&cube, at(40.0, 1.9, 7.0)));
    assert_close(found, Vec3::Y, 0.1);
    assert!(
        found.point.distance(Vec3::new(40.0, 0.95, 7.0)) < 0.1,
        "{found:?}"
    );
}

#[test]
fn one_mesh_inside_another_leaves_from_centre_to_centre() {
    let (large, small) = (mesh_of(Vec3::splat(2.0)), mesh_of(Vec3::splat(0.1)));
    let found = contact((&large, at(0.0, 0.0, 0.0)), (&small, at(0.0, 0.5, 0.0)));
    assert_close(found, Vec3::Y, 1.6);
    let here = at(1.0, 1.0, 1.0);
    let (one, two) = (Placed::new(&large, &here), Placed::new(&small, &here));
    let found = NarrowPhase::default().contact(one, two, &mut Workspace::default());
    assert_eq!(found.unwrap().normal.length(), 1.0);
}

/// The outer one's centre is in the inner one.
#[test]
fn a_mesh_that_is_inside_leaves_through_the_outer_one() {
    let (large, small) = (mesh_of(Vec3::splat(50.0)), mesh_of(Vec3::splat(0.5)));
    let place = at(0.1, 0.3, 0.2);
    let found = contact((&large, at(0.0, 0.0, 0.0)), (&small, place));
    assert_close(found, Vec3::Y, 50.2);
    let found = contact((&small, place), (&large, at(0.0, 0.0, 0.0)));
    assert_close(found, Vec3::NEG_Y, 50.2);
    let here = at(0.0, 0.0, 0.0);
    let (one, two) = (Placed::new(&large, &here), Placed::new(&small, &place));
    let found = NarrowPhase::default().manifold(one, two, &mut Workspace::default());
    assert_eq!(found.unwrap().points().len(), 1);
}
