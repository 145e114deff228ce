use super::*;

fn shear(parent: Transform) -> DAffine3 {
    turned(parent, 0.9)
}

/// That of a child which is turned against its parent.
fn turned(parent: Transform, angle: f32) -> DAffine3 {
    let child = Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, 0.5, 0.7, angle));
    let affine = |transform: Transform| {
        let Transform {
            translation,
            rotation,
            scale,
        } = transform;
        let rotation = rotation.as_dquat().normalize();
        DAffine3::from_scale_rotation_translation(
            scale.as_dvec3(),
            rotation,
            translation.as_dvec3(),
        )
    };
    affine(parent) * affine(child)
}

#[test]
fn a_turn_and_a_transform_are_the_whole_of_it() {
    for scale in [
        Vec3::new(4.0, 1.0, 1.0),
        Vec3::new(-4.0, 0.1, 3.0),
        Vec3::new(1.0, 0.0, 2.0),
        Vec3::new(1e-9, 1e9, 1.0),
    ] {
        let world = shear(Transform::from_xyz(1.0, 2.0, 3.0).with_scale(scale));
        let shape = Shape::from_half_size(Vec3::ONE);
        let Placement {
            transform,
            turn,
            is_sheared,
        } = put(&shape, &world, None);
        assert!(is_sheared);
        let again = transform.compute_affine().matrix3.as_dmat3() * turn.transpose();
        let size = world
            .matrix3
            .to_cols_array()
            .into_iter()
            .fold(0.0, |size: f64, value| size.max(value.abs()));
        assert!(
            again.abs_diff_eq(world.matrix3, 1e-6 * size),
            "{again} {}",
            world.matrix3
        );
        assert!((turn.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn what_a_transform_can_say_is_left_to_it() {
    let upright = [Vec3::ONE, Vec3::splat(-3.0), Vec3::ZERO, Vec3::splat(1e-20)];
    for scale in upright {
        let parent = Transform::from_rotation(Quat::from_rotation_y(1.0)).with_scale(scale);
        let world = shear(parent);
        let Placement {
            transform,
            turn,
            is_sheared,
        } = put(&Shape::sphere(1.0), &world, None);
        assert!(!is_sheared && turn == DMat3::IDENTITY);
        assert!((transform.rotation.length() - 1.0).abs() < 1e-6);
        let again = transform.compute_affine().matrix3.as_dmat3();
        assert!(again.abs_diff_eq(world.matrix3, 1e-6 * f64::from(scale.abs().max_element())));
    }
}

#[test]
fn a_shape_is_built_anew_only_when_it_turns_against_its_parent() {
    let shape = Shape::from_half_size(Vec3::ONE);
    let parent = Transform::from_scale(Vec3::new(4.0, 1.0, 2.0));
    let mut sheared = Sheared::new(&shape, put(&shape, &shear(parent), None).turn);
    let mut follow = |parent, angle| {
        let before = sheared.clone();
        let placement = put(&shape, &turned(parent, angle), Some(&sheared));
        sheared.follow(&shape, placement.turn);
        sheared.shape().is_same(before.shape())
    };
    for step in 0..200 {
        let step = step as f32;
        let turned = Quat::from_euler(EulerRot::XYZ, step, 0.3 * step, 0.1 * step);
        let parent = parent
            .with_rotation(turned)
            .with_translation(Vec3::splat(step));
        // Nor does it matter how far the parent is stretched.
        assert!(follow(
            parent.with_scale(Vec3::new(4.0, 1.0 + step, 2.0)),
            0.9
        ));
    }
    assert!(!follow(parent, 1.0));
    assert!(!follow(Transform::IDENTITY, 1.0));
    assert!(follow(Transform::IDENTITY, 1.1));
}
