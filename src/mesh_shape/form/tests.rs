//! What is made of meshes.

use bevy::mesh::Indices;

use super::*;

#[test]
fn what_looks_closed_and_is_not_is_doubted() {
    let holed = |mesh: Mesh| {
        let indices: Vec<u32> = mesh
            .indices()
            .unwrap()
            .iter()
            .skip(3)
            .map(|i| i as u32)
            .collect();
        mesh.with_inserted_indices(Indices::U32(indices))
    };
    let doubt = |mesh: &Mesh, form| build(mesh, form).unwrap().doubt;
    let ball = holed(Sphere::new(1.0).into());
    assert!(doubt(&ball, MeshForm::AsItIs).is_some_and(|doubt| doubt.contains("edge")));
    assert!(doubt(&ball, MeshForm::SurfaceOnly).is_none());
    let plane = Mesh::from(Plane3d::default());
    assert!(doubt(&plane, MeshForm::AsItIs).is_none());
    assert!(doubt(&plane, MeshForm::Solid).is_some());
    assert!(doubt(&Sphere::new(1.0).into(), MeshForm::Solid).is_none());
    assert!(matches!(
        build(&ball, MeshForm::Convex),
        Err(ShapeError::NotClosed { .. })
    ));
}

#[test]
fn forms_are_equal_by_their_sizes() {
    let voxels = |size| MeshForm::Voxels { size };
    assert_eq!(voxels(f32::NAN), voxels(f32::NAN));
    assert_ne!(voxels(1.0), voxels(2.0));
    assert_ne!(voxels(0.0), MeshForm::Cuboid);
}

#[test]
fn each_form_is_what_it_says() {
    let shape = |form| build(&Cuboid::new(2.0, 4.0, 6.0).into(), form).map(|built| built.shape);
    let Ok(Shape::Cuboid { half_size }) = shape(MeshForm::Cuboid) else {
        panic!("a cuboid")
    };
    assert_eq!(half_size, Vec3::new(1.0, 2.0, 3.0));
    assert!(matches!(shape(MeshForm::Sphere), Ok(Shape::Sphere { .. })));
    assert!(matches!(shape(MeshForm::Convex), Ok(Shape::Convex(_))));
    assert!(
        matches!(shape(MeshForm::ConvexHull), Ok(Shape::Convex(hull)) if hull.polygon_count() == 6)
    );
    assert!(matches!(shape(MeshForm::Capsule), Ok(Shape::Rounded(_))));
    let Ok(Shape::Voxels(voxels)) = shape(MeshForm::Voxels { size: 1.0 }) else {
        panic!("voxels")
    };
    assert_eq!(voxels.len(), 2 * 4 * 6);
}

/// Whatever the form, what is wrong with a mesh is told, and nothing panics.
#[test]
fn bad_meshes_are_refused_by_every_form() {
    let forms = [
        MeshForm::AsItIs,
        MeshForm::Solid,
        MeshForm::SurfaceOnly,
        MeshForm::Convex,
        MeshForm::ConvexHull,
        MeshForm::Cuboid,
        MeshForm::Sphere,
        MeshForm::Capsule,
        MeshForm::Voxels { size: 0.5 },
    ];
    let cube = || Mesh::from(Cuboid::default());
    let cube_at =
        |at: [f32; 3]| cube().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![at; 24]);
    for form in forms {
        let error = |mesh: &Mesh| build(mesh, form).err();
        let out_of_range = cube().with_inserted_indices(Indices::U16(vec![0, 1, 99]));
        assert!(matches!(
            error(&out_of_range),
            Some(ShapeError::IndexOutOfRange { .. })
        ));
        let odd = cube().with_inserted_indices(Indices::U16(vec![0, 1]));
        assert!(matches!(
            error(&odd),
            Some(ShapeError::TooFewCorners { .. })
        ));
        let bare = cube().with_removed_attribute(Mesh::ATTRIBUTE_POSITION);
        assert_eq!(error(&bare), Some(ShapeError::NoPositions));
        let none = cube().with_inserted_indices(Indices::U16(vec![]));
        assert_eq!(error(&none), Some(ShapeError::Empty));
        let nan = cube_at([f32::NAN; 3]);
        assert!(matches!(
            error(&nan),
            Some(ShapeError::NonFiniteVertex { .. })
        ));
        // As far as numbers go.
        let _ = build(&cube_at([f32::MAX; 3]), form);
    }
    let far = cube().scaled_by(Vec3::splat(f32::MAX));
    for form in forms {
        let _ = build(&far, form);
    }
}
