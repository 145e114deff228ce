//! Bevy's own rays, which meshes answer.

use bevy::{
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, ViewVisibility},
    },
    ecs::system::SystemState,
    math::{Vec3, bounding::Aabb3d},
    mesh::{Mesh, Mesh3d},
    picking::mesh_picking::ray_cast::{MeshRayCast, MeshRayCastSettings, RayCastVisibility},
    prelude::*,
};

use super::{
    Ray,
    engines::{Answer, QueryEngine},
};

/// Bevy's `MeshRayCast`, against as many entities with the mesh of a cube. It has no index: each ray
/// looks at the box of each mesh, and then at the triangles of those that it meets.
///
/// A ray that begins within a mesh meets nothing of it, for faces seen from behind do not count.
pub struct Meshes {
    world: World,
    state: SystemState<MeshRayCast<'static, 'static>>,
}

impl Meshes {
    /// The boxes as meshes.
    pub fn new(boxes: &[Aabb3d]) -> Self {
        let mut world = World::new();
        let mut meshes = Assets::<Mesh>::default();
        let cube = meshes.add(Cuboid::from_length(1.0));
        world.insert_resource(meshes);
        let entity = |aabb: &Aabb3d| {
            let (center, sides) = ((aabb.min + aabb.max) * 0.5, aabb.max - aabb.min);
            let transform = Transform::from_translation(center.into()).with_scale(sides.into());
            (
                Mesh3d(cube.clone()),
                Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(0.5)),
                GlobalTransform::from(transform),
                InheritedVisibility::VISIBLE,
                ViewVisibility::default(),
            )
        };
        world.spawn_batch(boxes.iter().map(entity).collect::<Vec<_>>());
        let state = SystemState::new(&mut world);
        Self { world, state }
    }
}

impl QueryEngine for Meshes {
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer> {
        let mut caster = self.state.get_mut(&mut self.world).ok()?;
        // What one cannot see counts elsewhere, too.
        let settings = MeshRayCastSettings::default().with_visibility(RayCastVisibility::Any);
        let mut cast = |ray: &Ray| {
            let hits = caster.cast_ray(Ray3d::new(ray.origin, ray.direction), &settings);
            hits.first().map(|(_, hit)| hit.distance)
        };
        Answer::of(rays.iter().map(&mut cast))
    }

    fn regions(&mut self, _: &[Aabb3d]) -> Option<Answer> {
        None
    }

    fn nearest(&mut self, _: &[Vec3]) -> Option<Answer> {
        None
    }
}
