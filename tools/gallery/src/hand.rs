//! Dragging a body by hand.

use bevy::prelude::*;
use bevy_octree::{filters::StaticShape, prelude::*};

use crate::scene::Began;

/// What is held by the mouse.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Hand {
    held: Option<Held>,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    entity: Entity,
    /// A point and the normal of the plane in which it is dragged.
    plane: (Vec3, Vec3),
    /// From where it is held to its middle.
    grip: Vec3,
    /// Its own velocity, which it gets back.
    velocity: Option<Vec3>,
}

impl Hand {
    /// Whether there is something in it.
    pub const fn is_busy(&self) -> bool {
        self.held.is_some()
    }
}

/// Adds the hand: what is picked and is not static can be dragged.
pub fn plugin(app: &mut App) {
    app.init_resource::<Hand>()
        .add_observer(take)
        .add_observer(pull)
        .add_observer(release)
        .add_observer(drop_at_end);
}

fn take(
    drag: On<Pointer<DragStart>>,
    mut bodies: Query<
        (&GlobalTransform, Option<&mut Velocity>),
        (With<CollisionShape>, Without<StaticShape>, Without<ChildOf>),
    >,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut hand: ResMut<Hand>,
) {
    if drag.button != PointerButton::Primary {
        return;
    }
    let Ok((place, velocity)) = bodies.get_mut(drag.entity) else {
        return;
    };
    let at = drag.hit.position.unwrap_or(place.translation());
    hand.held = Some(Held {
        entity: drag.entity,
        plane: (at, *camera.forward()),
        grip: place.translation() - at,
        velocity: velocity.map(|mut velocity| std::mem::take(&mut velocity.0)),
    });
}

fn pull(
    drag: On<Pointer<Drag>>,
    hand: Res<Hand>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut bodies: Query<&mut Transform>,
) {
    let Some(held) = hand.held.filter(|held| held.entity == drag.entity) else {
        return;
    };
    let (camera, eye) = *camera;
    let Ok(ray) = camera.viewport_to_world(eye, drag.pointer_location.position) else {
        return;
    };
    let (point, normal) = held.plane;
    let plane = InfinitePlane3d::new(normal);
    if let Some(distance) = ray.intersect_plane(point, plane)
        && let Ok(mut place) = bodies.get_mut(held.entity)
    {
        place.translation = ray.get_point(distance) + held.grip;
    }
}

fn release(_: On<Pointer<DragEnd>>, mut hand: ResMut<Hand>, mut bodies: Query<&mut Velocity>) {
    if let Some(held) = hand.held.take()
        && let Ok(mut velocity) = bodies.get_mut(held.entity)
        && let Some(own) = held.velocity
    {
        velocity.0 = own;
    }
}

fn drop_at_end(_: On<Began>, mut hand: ResMut<Hand>) {
    hand.held = None;
}
