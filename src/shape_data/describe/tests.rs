use super::*;

#[test]
fn the_sizes_of_what_was_made_by_hand_are_absolute() {
    let half_size = Vec3::new(-1.0, 2.0, -3.0);
    assert_eq!(
        ShapeDescription::of(&Shape::Cuboid { half_size }),
        Ok(ShapeDescription::Cuboid {
            half_size: half_size.abs()
        })
    );
    assert_eq!(
        ShapeDescription::try_from(&CollisionShape(Shape::Sphere { radius: -1.0 })),
        Ok(ShapeDescription::Sphere { radius: 1.0 })
    );
}

#[test]
fn frusta_and_capsules_have_simpler_names_where_they_are_simpler() {
    use ShapeDescription as Data;
    let of = |shape: Shape| Data::of(&shape).unwrap();
    let (radius, height, length) = (1.0, 4.0, 2.0);
    for data in [
        Data::Cylinder { radius, height },
        Data::Cone { radius, height },
        Data::ConicalFrustum {
            radius_top: 1.0,
            radius_bottom: 0.0,
            height,
        },
        Data::Capsule { radius, length },
        Data::CapsuleBetween {
            a: Vec3::X,
            b: Vec3::Y,
            radius,
        },
        Data::default_triangle(),
        Data::default_segment(),
        Data::default_halfspace(),
        Data::default_rounded(),
    ] {
        assert_eq!(of(data.build().unwrap()), data);
    }
    assert_eq!(
        of(Shape::conical_frustum(1.0, 1.0, 4.0)),
        Data::Cylinder { radius, height }
    );
    assert_eq!(
        of(Shape::rounded(&Shape::cylinder(1.0, 4.0), 0.5).unwrap()),
        Data::Rounded {
            core: CoreDescription::Cylinder { radius, height },
            radius: 0.5
        }
    );
}

#[cfg(feature = "rapier")]
mod rapier {
    use std::f32::consts::FRAC_PI_2;

    use bevy_rapier3d::parry::{
        bounding_volume::Aabb,
        math::{Pose, Vector},
        shape::{self as parry, SharedShape},
    };

    use super::*;
    use crate::shape_data::{CoreDescription, PartDescription};

    fn data(shape: SharedShape) -> ShapeDescription {
        ShapeDescription::of(&Shape::from(shape)).unwrap()
    }

    #[test]
    fn what_is_known_of_rapier_is_written_as_ours() {
        use ShapeDescription as Data;
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        let [radius, height, length] = [0.5, 4.0, 4.0];
        let core = |core, radius| Data::Rounded { core, radius };
        let half_size = Vec3::new(1.0, 2.0, 3.0);
        let cases = [
            (SharedShape::ball(0.5), Data::Sphere { radius }),
            (
                SharedShape::cuboid(1.0, 2.0, 3.0),
                Data::Cuboid { half_size },
            ),
            (
                SharedShape::capsule_y(2.0, 0.5),
                Data::Capsule { radius, length },
            ),
            (
                SharedShape::capsule_x(2.0, 0.5),
                Data::CapsuleBetween {
                    a: -2.0 * x,
                    b: 2.0 * x,
                    radius,
                },
            ),
            (
                SharedShape::cylinder(2.0, 0.5),
                Data::Cylinder { radius, height },
            ),
            (SharedShape::cone(2.0, 0.5), Data::Cone { radius, height }),
            (SharedShape::segment(x, y), Data::Segment { a: x, b: y }),
            (
                SharedShape::triangle(x, y, z),
                Data::Triangle { a: x, b: y, c: z },
            ),
            (SharedShape::halfspace(y), Data::HalfSpace { normal: y }),
            (
                SharedShape::round_cuboid(1.0, 2.0, 3.0, 0.25),
                core(CoreDescription::Cuboid { half_size }, 0.25),
            ),
            (
                SharedShape::round_cylinder(2.0, 0.5, 0.25),
                core(CoreDescription::Cylinder { radius, height }, 0.25),
            ),
            (
                SharedShape::round_cone(2.0, 0.5, 0.25),
                core(CoreDescription::Cone { radius, height }, 0.25),
            ),
            (
                SharedShape::round_triangle(x, y, z, 0.25),
                core(CoreDescription::Triangle { a: x, b: y, c: z }, 0.25),
            ),
            (
                SharedShape::trimesh(vec![x, y, z], vec![[0, 1, 2]]).unwrap(),
                Data::Mesh {
                    vertices: vec![x, y, z],
                    polygons: vec![vec![0, 1, 2]],
                    surface_only: true,
                },
            ),
            (
                SharedShape::voxels(Vector::splat(0.5), &[IVec3::new(1, 2, 3)]),
                Data::Voxels {
                    cell_size: 0.5,
                    cells: vec![IVec3::new(1, 2, 3)],
                },
            ),
            (
                SharedShape::polyline(vec![x, y], None),
                Data::Compound {
                    parts: vec![PartDescription::at(
                        Vec3::ZERO,
                        Data::Segment { a: x, b: y },
                    )],
                },
            ),
        ];
        for (shape, expected) in cases {
            assert_eq!(data(shape), expected);
        }

        let hull = SharedShape::convex_hull(&[Vec3::ZERO, x, y, z]).unwrap();
        let Data::Convex { vertices, .. } = data(hull.clone()) else {
            panic!("a hull");
        };
        assert_eq!(vertices.len(), 4);
        let turn = Quat::from_rotation_z(FRAC_PI_2);
        let parts = SharedShape::compound(vec![
            (Pose::from_parts(x, turn), SharedShape::ball(0.5)),
            (Pose::from_parts(y, Quat::IDENTITY), hull),
        ]);
        let Data::Compound { parts } = data(parts) else {
            panic!("a compound");
        };
        let expected = PartDescription {
            position: x,
            rotation: turn,
            shape: Data::Sphere { radius },
        };
        assert_eq!(parts[0], expected);
        assert_eq!(parts[1].position, y);
    }

    /// A height field of Rapier's has its own rules for diagonals; its triangles say them.
    #[test]
    fn height_fields_of_rapier_are_their_triangles() {
        let heights = bevy_rapier3d::parry::utils::Array2::new(2, 2, vec![0.0, 1.0, 2.0, 3.0]);
        let field = SharedShape::heightfield(heights, Vec3::new(4.0, 1.0, 6.0));
        let built = data(field.clone()).build().unwrap();
        let (Shape::Mesh(mesh), Aabb { mins, maxs }) = (built, field.compute_local_aabb()) else {
            panic!("a mesh");
        };
        assert!(!mesh.has_inside());
        assert_eq!(mesh.polygon_count(), 2);
        let corners = mesh.vertices();
        let low = corners.iter().fold(Vec3::INFINITY, |low, v| low.min(*v));
        let high = corners
            .iter()
            .fold(Vec3::NEG_INFINITY, |high, v| high.max(*v));
        assert_eq!((low, high), (mins, maxs));
    }

    #[test]
    fn what_is_unknown_says_so() {
        let bricks = SharedShape::voxels(Vector::new(1.0, 2.0, 1.0), &[IVec3::ZERO]);
        let within = SharedShape::compound(vec![(Pose::IDENTITY, bricks.clone())]);
        for shape in [bricks, within] {
            assert!(matches!(
                shape.as_typed_shape(),
                parry::TypedShape::Voxels(_) | parry::TypedShape::Compound(_)
            ));
            let error = ShapeDescription::of(&Shape::from(shape)).unwrap_err();
            assert_eq!(
                error.to_string(),
                "there is no data for a shape of Rapier's of the kind Voxels"
            );
        }
    }
}
