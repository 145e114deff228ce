//! Avian's `MoveAndSlide`, with what its example of a kinematic character makes of it: it looks for the ground by a shape
//! cast, does not climb what is steep, and does not slip on what is not. Neither has steps, nor is anyone held on the ground.

use std::time::Duration;

use avian3d::prelude::*;
use bevy::{ecs::system::SystemState, prelude::*, time::TimeUpdateStrategy};

use super::{Body, Engine};
use crate::characters::{GRAVITY, HALF_LENGTH, RADIUS, SKIN, SLOPE, TICK, scenes::Solid};

/// How far below it the ground is looked for, and how much thinner what is cast is: as in the example.
const GROUND: [f32; 2] = [0.2, 0.001];
/// Less than this is no motion up or down a slope.
const LEVEL: f32 = 1e-3;
/// Updates before anyone walks: in these the tree takes its shape.
const UPDATES: usize = 4;

/// Its app, and how its characters walk.
pub struct Avian {
    app: App,
    state: SystemState<MoveAndSlide<'static, 'static>>,
    walk: Walk,
}

struct Walk {
    shape: Collider,
    thinner: Collider,
    settings: MoveAndSlideConfig,
    filter: SpatialQueryFilter,
}

impl Avian {
    pub fn new(solids: &[Solid]) -> Self {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            TransformPlugin,
            PhysicsPlugins::new(PostUpdate),
        ))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(
            TICK,
        )));
        app.finish();
        app.cleanup();
        for solid in solids {
            app.world_mut().spawn((RigidBody::Static, collider(solid)));
        }
        (0..UPDATES).for_each(|_| app.update());
        let state = SystemState::new(app.world_mut());
        // Avian takes the whole length between the two ends of the axis.
        let length = 2.0 * HALF_LENGTH;
        Self {
            app,
            state,
            walk: Walk {
                shape: Collider::capsule(RADIUS, length),
                thinner: Collider::capsule(RADIUS - GROUND[1], length),
                settings: MoveAndSlideConfig {
                    skin_width: SKIN,
                    ..default()
                },
                filter: SpatialQueryFilter::DEFAULT,
            },
        }
    }
}

impl Walk {
    /// The example asks this to know who may jump.
    fn is_grounded(&self, mover: &MoveAndSlide, position: Vec3) -> bool {
        let hit = mover.spatial_query.cast_shape(
            &self.thinner,
            position,
            Quat::IDENTITY,
            Dir3::NEG_Y,
            &ShapeCastConfig::from_max_distance(GROUND[0]),
            &self.filter,
        );
        hit.is_some_and(|hit| is_ground(hit.normal1))
    }

    fn tick(&self, mover: &MoveAndSlide, body: &mut Body, wish: Vec3) {
        body.is_grounded = self.is_grounded(mover, body.position);
        body.velocity = wish.with_y(body.velocity.y - GRAVITY * TICK);
        let wanted = body.velocity;
        let mut is_held = false;
        let moved = mover.move_and_slide(
            &self.shape,
            body.position,
            Quat::IDENTITY,
            wanted,
            Duration::from_secs_f32(TICK),
            &self.settings,
            &self.filter,
            |hit| {
                let normal = Vec3::from(*hit.normal);
                is_held |= is_ground(normal.with_y(normal.y.abs()));
                *hit.velocity = without_slope(*hit.velocity, normal, wanted);
                MoveAndSlideHitResponse::Accept
            },
        );
        body.position = moved.position;
        if is_held {
            body.velocity.y = moved.projected_velocity.y;
        }
    }
}

fn is_ground(normal: Vec3) -> bool {
    normal.angle_between(Vec3::Y) <= SLOPE.to_radians()
}

/// What is left of a velocity on a surface that nobody climbs, for it is steep, or slips down on, for it is not.
fn without_slope(velocity: Vec3, normal: Vec3, wanted: Vec3) -> Vec3 {
    // How a velocity goes up or down along the surface.
    let level = normal.cross(Vec3::Y).normalize_or_zero();
    let slope = |of: Vec3| of - normal * normal.dot(of) - level * level.dot(of);
    let [now, meant] = [velocity, wanted.with_y(0.0)].map(slope);
    let is_climbing = now.y > 0.0 && wanted.y <= 0.0;
    let is_slipping = now.y < -LEVEL && meant.y >= -LEVEL;
    let is_ground = is_ground(normal);
    if is_ground && is_slipping || !is_ground && is_climbing {
        velocity - now
    } else {
        velocity
    }
}

fn collider(solid: &Solid) -> (Collider, Transform) {
    match solid {
        // Avian takes full sides.
        Solid::Box(half, at) => {
            let sides = *half * 2.0;
            (Collider::cuboid(sides.x, sides.y, sides.z), *at)
        }
        Solid::Mesh(mesh) | Solid::Ground(mesh) => {
            let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
            (Collider::trimesh(vertices, triangles), Transform::IDENTITY)
        }
    }
}

impl Engine for Avian {
    fn tick(&mut self, bodies: &mut [Body], wishes: &[Vec3]) {
        let mover = self.state.get(self.app.world());
        let mover = mover.expect("all that it asks of the world is there");
        for (body, wish) in bodies.iter_mut().zip(wishes) {
            self.walk.tick(&mover, body, *wish);
        }
    }
}
