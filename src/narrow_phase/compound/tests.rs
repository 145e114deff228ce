//! What compounds are made of.

use std::{f32::consts::FRAC_PI_2, sync::LazyLock};

use super::*;

fn ball(x: f32) -> (Isometry3d, Shape) {
    (Isometry3d::from_xyz(x, 0.0, 0.0), Shape::sphere(0.5))
}

#[test]
fn what_cannot_be_put_together_is_refused() {
    assert_eq!(Compound::new([]).unwrap_err(), ShapeError::NoParts);
    let bad = |(pose, shape): (Isometry3d, Shape)| {
        Compound::new([ball(0.0), ball(1.0), (pose, shape)]).unwrap_err()
    };
    let expected = ShapeError::Part {
        part: 2,
        error: BoundsError::NonFinite,
    };
    let nan = Shape::Sphere { radius: f32::NAN };
    let (here, _) = ball(0.0);
    assert_eq!(bad((here, nan)), expected);
    assert_eq!(bad(ball(f32::INFINITY)), expected);
    assert_eq!(bad(ball(f32::MAX)), expected);
    for rotation in [
        Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
        Quat::from_xyzw(0.0, f32::NAN, 0.0, 1.0),
    ] {
        let pose = Isometry3d { rotation, ..here };
        assert_eq!(bad((pose, Shape::cuboid(1.0, 1.0, 1.0))), expected);
    }
}

#[test]
fn bounds_are_around_all_parts() {
    let turned = Isometry3d::new(Vec3::Y * 2.0, Quat::from_rotation_z(FRAC_PI_2));
    let compound = Compound::new([ball(-3.0), (turned, Shape::cuboid(4.0, 1.0, 2.0))]).unwrap();
    let (center, half, radius) = compound.local_bounds();
    let (low, high) = (center - half, center + half);
    assert!(low.abs_diff_eq(Vec3A::new(-3.5, -0.5, -1.0), 1e-5), "{low}");
    assert!(high.abs_diff_eq(Vec3A::new(0.5, 4.0, 1.0), 1e-5), "{high}");
    assert!(radius <= half.length());
    let corners = [Vec3A::new(-3.0, -0.5, 0.0), Vec3A::new(0.5, 4.0, 1.0)];
    for corner in corners {
        assert!(corner.distance(center) <= radius);
    }
}

#[test]
fn compounds_of_compounds_have_all_parts() {
    static INNER: LazyLock<Compound> =
        LazyLock::new(|| Compound::new([ball(1.0), ball(2.0)]).unwrap());
    let turn = Isometry3d::new(Vec3::Y, Quat::from_rotation_z(FRAC_PI_2));
    let parts = [ball(5.0), (turn, Shape::cuboid(1.0, 1.0, 1.0)), ball(6.0)];
    // The cuboid stands for it.
    let nested = |shape: &Shape| matches!(shape, Shape::Cuboid { .. }).then_some(&*INNER);
    let compound = Compound::flattened(parts, |shape| nested(shape)).unwrap();
    assert_eq!(compound.len(), 4);
    let at = |number: u32| compound.part(number).unwrap().0.translation;
    assert!(at(1).abs_diff_eq(Vec3A::Y * 2.0, 1e-6) && at(2).abs_diff_eq(Vec3A::Y * 3.0, 1e-6));
    assert_eq!((at(0).x, at(3).x), (5.0, 6.0));
    assert!(compound.part(4).is_none());
}

#[test]
fn a_compound_is_what_its_parts_make() {
    let mut random = fastrand::Rng::with_seed(1);
    let mut any = || random.f32() * 20.0 - 10.0;
    let mut parts = Vec::new();
    for i in 0..100 {
        let rotation = Quat::from_xyzw(any(), any(), any(), any());
        let pose = Isometry3d::new(Vec3::new(any(), any(), any()), rotation);
        parts.push((pose, Shape::cuboid(1.0, 0.1 * i as f32, 2.0)));
    }
    let compound = Compound::new(parts.iter().cloned()).unwrap();
    for (number, (pose, shape)) in (0..).zip(&parts) {
        let (found, of) = compound.part(number).unwrap();
        assert!(of.is_same(shape) && found.translation == pose.translation);
    }
    let again = compound.parts().map(|(pose, shape)| (pose, shape.clone()));
    let again = Compound::new(again).unwrap();
    assert_eq!(again, compound);
    assert_eq!(again.local_bounds(), compound.local_bounds());
    let fewer = Compound::new(parts[1..].iter().cloned()).unwrap();
    assert_ne!(fewer, compound);
}
