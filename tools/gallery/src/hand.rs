//! Dragging a body by hand.

use bevy::prelude::*;
use bevy_octree::prelude::*;

use crate::{play::Tick, scene::Began};

/// What is held by the mouse.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Hand {
    held: Option<Held>,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    /// What was picked, and what is moved: what it hangs on, if on anything.
    picked: Entity,
    moved: Entity,
    /// A point and the normal of the plane in which it is dragged.
    plane: (Vec3, Vec3),
    /// From where it is held to its middle.
    grip: Vec3,
    /// Where it is to be.
    place: Vec3,
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
        .add_observer(drop_at_end)
        // Whatever else moves it.
        .add_systems(
            Tick,
            hold.after(CollisionSystems::Motion)
                .before(CollisionSystems::Bounds),
        );
}

type Loose = (With<CollisionShape>, Without<StaticShape>);

fn take(
    drag: On<Pointer<DragStart>>,
    loose: Query<(), Loose>,
    parents: Query<&ChildOf>,
    mut bodies: Query<(&GlobalTransform, Option<&mut Velocity>)>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut hand: ResMut<Hand>,
) {
    if drag.button != PointerButton::Primary || !loose.contains(drag.entity) {
        return;
    }
    let moved = parents.root_ancestor(drag.entity);
    let Ok((place, velocity)) = bodies.get_mut(moved) else {
        return;
    };
    let place = place.translation();
    let at = drag.hit.position.unwrap_or(place);
    hand.held = Some(Held {
        picked: drag.entity,
        moved,
        plane: (at, *camera.forward()),
        grip: place - at,
        place,
        velocity: velocity.map(|mut velocity| std::mem::take(&mut velocity.0)),
    });
}

fn pull(
    drag: On<Pointer<Drag>>,
    mut hand: ResMut<Hand>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut bodies: Query<&mut Transform>,
) {
    let Some(held) = hand.held.as_mut().filter(|held| held.picked == drag.entity) else {
        return;
    };
    let (camera, eye) = *camera;
    let Ok(ray) = camera.viewport_to_world(eye, drag.pointer_location.position) else {
        return;
    };
    let (point, normal) = held.plane;
    if let Some(distance) = ray.intersect_plane(point, InfinitePlane3d::new(normal)) {
        held.place = ray.get_point(distance) + held.grip;
    }
    // Seen at once, though ticks may wait.
    if let Ok(mut place) = bodies.get_mut(held.moved) {
        place.translation = held.place;
    }
}

fn hold(hand: Res<Hand>, mut bodies: Query<(&mut Transform, Option<&mut Velocity>)>) {
    if let Some(held) = hand.held
        && let Ok((mut place, velocity)) = bodies.get_mut(held.moved)
    {
        place.translation = held.place;
        if let Some(mut velocity) = velocity {
            velocity.0 = Vec3::ZERO;
        }
    }
}

fn release(drag: On<Pointer<DragEnd>>, mut hand: ResMut<Hand>, mut bodies: Query<&mut Velocity>) {
    if drag.button != PointerButton::Primary {
        return;
    }
    if let Some(held) = hand.held.take()
        && let Ok(mut velocity) = bodies.get_mut(held.moved)
        && let Some(own) = held.velocity
    {
        velocity.0 = own;
    }
}

fn drop_at_end(_: On<Began>, mut hand: ResMut<Hand>) {
    hand.held = None;
}
