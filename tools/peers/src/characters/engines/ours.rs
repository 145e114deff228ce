//! This crate's `walk`, by the same settings.

use bevy::{ecs::system::SystemState, prelude::*};
use bevy_octree::{character::walk, prelude::*};

use super::{Body, Engine};
use crate::characters::{
    GRAVITY, HALF_LENGTH, RADIUS, SKIN, SLOPE, SNAP, STEP, TICK, scenes::Solid,
};

/// Its app, and how its characters walk.
pub struct Ours {
    app: App,
    state: SystemState<SpatialQuery<'static, 'static>>,
    shape: Shape,
    settings: WalkSettings,
    /// What each stands on.
    grounds: Vec<Option<Ground>>,
}

impl Ours {
    pub fn new(solids: &[Solid]) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
        for solid in solids {
            app.world_mut().spawn((StaticShape, shape(solid)));
        }
        app.update();
        let state = SystemState::new(app.world_mut());
        Self {
            app,
            state,
            shape: Shape::capsule(RADIUS, 2.0 * HALF_LENGTH),
            settings: WalkSettings {
                max_slope: SLOPE.to_radians(),
                step_height: STEP,
                snap: SNAP,
                moves: MoveSettings {
                    skin: SKIN,
                    ..default()
                },
                ..default()
            },
            grounds: vec![],
        }
    }
}

fn shape(solid: &Solid) -> (CollisionShape, Transform) {
    match solid {
        Solid::Box(half, at) => (CollisionShape::from_half_size(*half), *at),
        Solid::Mesh(mesh) | Solid::Ground(mesh) => {
            let shape = CollisionShape::mesh(mesh.vertices.clone(), &mesh.triangles);
            let shape = shape.expect("the meshes of the scenes are valid");
            (shape, Transform::IDENTITY)
        }
    }
}

impl Engine for Ours {
    fn tick(&mut self, bodies: &mut [Body], wishes: &[Vec3]) {
        let spatial = self.state.get(self.app.world());
        let spatial = spatial.expect("all that it asks of the world is there");
        self.grounds.resize(bodies.len(), None);
        for ((body, wish), ground) in bodies.iter_mut().zip(wishes).zip(&mut self.grounds) {
            let walked = walk(
                &spatial,
                &self.shape,
                &Transform::from_translation(body.position),
                wish.with_y(body.velocity.y - GRAVITY * TICK),
                TICK,
                ground.as_ref(),
                &self.settings,
                &SpatialQueryFilter::DEFAULT,
                |_| AtHit::Slide,
            );
            *ground = walked.ground;
            *body = Body {
                position: walked.pose.translation,
                velocity: walked.velocity,
                is_grounded: walked.ground.is_some(),
            };
        }
    }
}
