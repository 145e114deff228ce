//! What is made of meshes.

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
