//! Rapier's `KinematicCharacterController`.

use bevy::math::Vec3;
use rapier3d::{
    control::{CharacterAutostep, CharacterLength, KinematicCharacterController},
    prelude::*,
};

use super::{Body, Engine};
use crate::characters::{
    GRAVITY, HALF_LENGTH, RADIUS, SKIN, SLOPE, SNAP, STEP, STEP_WIDTH, TICK, scenes::Solid,
};

/// Steps of the whole pipeline, before anyone walks: in these the tree takes its shape.
const STEPS: usize = 4;

/// Its world, and how its characters walk.
pub struct Rapier {
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    controller: KinematicCharacterController,
    shape: Capsule,
}

impl Rapier {
    pub fn new(solids: &[Solid]) -> Self {
        let mut rapier = Self {
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            controller: KinematicCharacterController {
                up: Vector::Y,
                offset: CharacterLength::Absolute(SKIN),
                slide: true,
                autostep: Some(CharacterAutostep {
                    max_height: CharacterLength::Absolute(STEP),
                    min_width: CharacterLength::Absolute(STEP_WIDTH),
                    include_dynamic_bodies: false,
                }),
                max_slope_climb_angle: SLOPE.to_radians(),
                min_slope_slide_angle: SLOPE.to_radians(),
                snap_to_ground: Some(CharacterLength::Absolute(SNAP)),
                ..KinematicCharacterController::default()
            },
            shape: Capsule::new_y(HALF_LENGTH, RADIUS),
        };
        for solid in solids {
            rapier.colliders.insert(collider(solid));
        }
        rapier.step();
        rapier
    }

    fn step(&mut self) {
        let mut pipeline = PhysicsPipeline::new();
        let mut islands = IslandManager::new();
        for _ in 0..STEPS {
            pipeline.step(
                Vector::ZERO,
                &IntegrationParameters::default(),
                &mut islands,
                &mut self.broad_phase,
                &mut self.narrow_phase,
                &mut self.bodies,
                &mut self.colliders,
                &mut ImpulseJointSet::new(),
                &mut MultibodyJointSet::new(),
                &mut SoftBodySet::new(),
                &mut CCDSolver::new(),
                &(),
                &(),
            );
        }
    }
}

fn vector(of: Vec3) -> Vector {
    of.to_array().into()
}

fn collider(solid: &Solid) -> ColliderBuilder {
    match solid {
        Solid::Box(half, at) => {
            let [x, y, z, w] = at.rotation.to_array();
            let turn = Rotation::from_xyzw(x, y, z, w);
            ColliderBuilder::cuboid(half.x, half.y, half.z)
                .position(Pose::from_parts(vector(at.translation), turn))
        }
        Solid::Mesh(mesh) | Solid::Ground(mesh) => {
            let vertices = mesh.vertices.iter().map(|vertex| vector(*vertex));
            ColliderBuilder::trimesh(vertices.collect(), mesh.triangles.clone())
                .expect("the meshes of the scenes are valid")
        }
    }
}

impl Engine for Rapier {
    fn tick(&mut self, bodies: &mut [Body], wishes: &[Vec3]) {
        let queries = self.broad_phase.as_query_pipeline(
            self.narrow_phase.query_dispatcher(),
            &self.bodies,
            &self.colliders,
            QueryFilter::default(),
        );
        for (body, wish) in bodies.iter_mut().zip(wishes) {
            let fall = body.velocity.y - GRAVITY * TICK;
            let way = (*wish + Vec3::Y * fall) * TICK;
            let at = Pose::from_translation(vector(body.position));
            let moved =
                self.controller
                    .move_shape(TICK, &queries, &self.shape, &at, vector(way), |_| {});
            body.position += Vec3::from_array(moved.translation.to_array());
            body.velocity = Vec3::Y * if moved.grounded { 0.0 } else { fall };
            body.is_grounded = moved.grounded;
        }
    }
}
