//! Hulls of points that are known to be difficult.

use std::f32::consts::PI;

use bevy::math::{EulerRot, Quat};
use proptest::prelude::*;

use super::*;

/// How far points are outside of a hull, at most, as a share of its radius.
fn farthest_outside(hull: &ConvexMesh, points: &[Vec3]) -> f64 {
    let (_, _, radius) = hull.local_bounds();
    let mut farthest = f64::NEG_INFINITY;
    for (polygon, normal) in hull.polygons().zip(hull.normals()) {
        let corners = polygon
            .iter()
            .map(|v| hull.vertices()[*v as usize].as_dvec3());
        let middle = corners.sum::<DVec3>() / polygon.len() as f64;
        for point in points {
            let height = normal.as_dvec3().dot(point.as_dvec3() - middle);
            farthest = farthest.max(height);
        }
    }
    farthest / f64::from(radius)
}

/// The volume of a hull.
fn volume(hull: &ConvexMesh) -> f64 {
    let origin = hull.vertices()[0].as_dvec3();
    let at = |v: u32| hull.vertices()[v as usize].as_dvec3() - origin;
    let of = |corners: &[u32]| {
        let fan = corners[1..].windows(2);
        fan.map(|pair| at(corners[0]).dot(at(pair[0]).cross(at(pair[1]))))
            .sum::<f64>()
    };
    hull.polygons().map(of).sum::<f64>() / 6.0
}

/// The hull, which is to be near all points and made of them.
fn checked(points: &[Vec3], outside: f64) -> ConvexMesh {
    let hull = ConvexMesh::hull_of(points.iter().copied()).unwrap();
    let farthest = farthest_outside(&hull, points);
    assert!(farthest <= outside, "{farthest} outside");
    let mut given = points.iter();
    let is_given = |vertex: &Vec3| given.any(|point| point == vertex);
    assert!(hull.vertices().iter().all(is_given), "in the order given");
    let (vertices, edges) = (hull.vertices().len(), hull.edges().len());
    assert_eq!(vertices + hull.polygon_count(), edges + 2, "Euler");
    hull
}

fn sphere(count: u32, random: &mut fastrand::Rng) -> Vec<Vec3> {
    let mut on = || {
        let (y, angle) = (random.f32() * 2.0 - 1.0, random.f32() * 2.0 * PI);
        let ring = (1.0 - y * y).sqrt();
        Vec3::new(ring * angle.cos(), y, ring * angle.sin())
    };
    (0..count).map(|_| on()).collect()
}

fn turn(random: &mut fastrand::Rng) -> Quat {
    let [a, b, c] = [(); 3].map(|()| random.f32() * 2.0 * PI);
    Quat::from_euler(EulerRot::XYZ, a, b, c)
}

fn grid(side: u32) -> impl Iterator<Item = Vec3> {
    let at = move |i: u32| {
        Vec3::new(
            (i % side) as f32,
            (i / side % side) as f32,
            (i / side / side) as f32,
        )
    };
    (0..side * side * side).map(move |i| at(i) / (side - 1) as f32 - 0.5)
}

#[test]
fn what_has_no_hull_is_refused() {
    let hull = |points: &[Vec3]| ConvexMesh::hull_of(points.iter().copied()).unwrap_err();
    assert_eq!(hull(&[]), ShapeError::FewPoints(0));
    assert_eq!(hull(&[Vec3::ONE; 3]), ShapeError::FewPoints(3));
    assert_eq!(hull(&[Vec3::ONE; 9]), ShapeError::Flat);
    let line: Vec<_> = (0..9).map(|i| Vec3::splat(i as f32)).collect();
    assert_eq!(hull(&line), ShapeError::Flat);
    let plane: Vec<_> = (0..25)
        .map(|i| Vec3::new((i % 5) as f32, 7.0, (i / 5) as f32))
        .collect();
    assert_eq!(hull(&plane), ShapeError::Flat);
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..50 {
        let turn = turn(&mut random);
        let turned: Vec<_> = plane.iter().map(|point| turn * *point).collect();
        assert_eq!(hull(&turned), ShapeError::Flat);
    }
    let mut far = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    far[2].x = f32::NAN;
    assert!(matches!(
        hull(&far),
        ShapeError::NonFiniteVertex { vertex: 2, .. }
    ));
}

#[test]
fn grids_are_cubes_of_six_faces_however_they_are_turned() {
    let mut random = fastrand::Rng::with_seed(2);
    for round in 0..200 {
        let (turn, side) = (turn(&mut random), [2, 3, 5, 10][round % 4]);
        let size = [1e-30, 1e-3, 1.0, 1e5, 1e30][round % 5];
        let points: Vec<_> = grid(side).map(|point| turn * point * size).collect();
        let hull = checked(&points, 1e-6);
        assert_eq!(
            (hull.vertices().len(), hull.polygon_count()),
            (8, 6),
            "{round}"
        );
        let share = volume(&hull) / f64::from(size).powi(3);
        assert!((share - 1.0).abs() < 1e-5, "{share}");
    }
}

#[test]
fn grids_far_from_the_origin_are_cubes() {
    let mut random = fastrand::Rng::with_seed(3);
    for far in [10.0, 100.0, 1000.0] {
        for _ in 0..20 {
            let (turn, at) = (turn(&mut random), turn(&mut random) * Vec3::X * far);
            let points: Vec<_> = grid(5).map(|point| turn * point + at).collect();
            let hull = checked(&points, 1e-6 * f64::from(far));
            assert!((volume(&hull) - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn every_point_of_a_sphere_is_a_corner() {
    let mut random = fastrand::Rng::with_seed(4);
    for count in [4, 10, 100, 1000, 10_000] {
        let points = sphere(count, &mut random);
        let hull = checked(&points, 2e-6);
        // Of points at random, some are nearer to each other than they can be told apart.
        let corners = hull.vertices().len() as f64;
        assert!(corners >= 0.99 * f64::from(count), "{corners} of {count}");
    }
}

#[test]
fn rings_and_poles_are_merged_to_what_they_lie_on() {
    let mut random = fastrand::Rng::with_seed(5);
    for count in [3, 8, 64, 500] {
        let turn = turn(&mut random);
        let ring = |y: f32| {
            (0..count).map(move |i| {
                let angle = 2.0 * PI * i as f32 / count as f32;
                Vec3::new(angle.cos(), y, angle.sin())
            })
        };
        // A cylinder of three rings: those in the middle are on its sides.
        let points = ring(-1.0).chain(ring(0.0)).chain(ring(1.0));
        let points: Vec<_> = points.map(|point| turn * point).collect();
        let hull = checked(&points, 1e-6);
        assert_eq!(hull.vertices().len(), 2 * count);
        assert_eq!(hull.polygon_count(), count + 2);
    }
}

#[test]
fn thin_things_have_hulls() {
    let mut random = fastrand::Rng::with_seed(6);
    for thickness in [1e-2, 1e-3, 1e-4] {
        for _ in 0..20 {
            let turn = turn(&mut random);
            let flat = Vec3::new(1.0, thickness, 1.0);
            let plate: Vec<_> = grid(4).map(|point| turn * (point * flat)).collect();
            checked(&plate, 2e-6);
            let thin = Vec3::new(thickness, 1.0, thickness);
            let needle: Vec<_> = grid(4).map(|point| turn * (point * thin)).collect();
            match ConvexMesh::hull_of(needle.iter().copied()) {
                Ok(hull) => assert!(farthest_outside(&hull, &needle) < 1e-5),
                Err(error) => assert_eq!(error, ShapeError::Flat),
            }
        }
    }
}

#[test]
fn noise_on_faces_does_no_harm() {
    let mut random = fastrand::Rng::with_seed(7);
    for noise in [1e-8, 1e-7, 3e-7, 1e-6, 3e-6, 1e-5, 1e-4] {
        for _ in 0..20 {
            let turn = turn(&mut random);
            let mut jitter = || (random.f32() - 0.5) * noise;
            let points: Vec<_> = grid(8)
                .map(|point| turn * point + Vec3::new(jitter(), jitter(), jitter()))
                .collect();
            checked(&points, 3e-5);
        }
    }
}

proptest! {
    #[test]
    fn few_points_of_a_small_grid(seed: u64, count in 4_usize..40, side in 2_u32..6) {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut coordinate = || random.u32(0..side) as f32;
        let points: Vec<_> = (0..count)
            .map(|_| Vec3::new(coordinate(), coordinate(), coordinate()))
            .collect();
        let turn = turn(&mut random);
        let turned: Vec<_> = points.iter().map(|point| turn * *point).collect();
        for points in [points, turned] {
            match ConvexMesh::hull_of(points.iter().copied()) {
                Ok(_) => { checked(&points, 2e-6); }
                Err(error) => prop_assert_eq!(error, ShapeError::Flat),
            }
        }
    }
}

#[cfg(feature = "rapier")]
#[test]
fn volumes_are_those_of_the_other_hull() {
    use bevy_rapier3d::parry::transformation::convex_hull;

    let mut random = fastrand::Rng::with_seed(8);
    for round in 0..100 {
        let size = [1e-2, 1.0, 100.0][round % 3];
        let count = random.u32(4..300);
        let points: Vec<Vec3> = match round % 2 {
            0 => sphere(count, &mut random),
            _ => (0..count)
                .map(|_| Vec3::from([(); 3].map(|()| random.f32())))
                .collect(),
        };
        let points: Vec<Vec3> = points.iter().map(|point| *point * size).collect();
        let ours = volume(&checked(&points, 2e-6));
        let (vertices, triangles) = convex_hull(&points);
        let at = |v: u32| vertices[v as usize].as_dvec3();
        let other = triangles
            .iter()
            .map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c))) / 6.0);
        let other: f64 = other.sum();
        assert!((ours / other - 1.0).abs() < 1e-4, "{ours}, not {other}");
    }
}
