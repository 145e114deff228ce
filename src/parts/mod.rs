//! Things made of parts: a ship of five shapes is one thing, and bounces as one.
//!
//! Mark an entity as a [`CollisionBody`], and all shapes that hang on it are its parts, however
//! deep: those of children, of their children, and its own, if it has one. Nothing else has to be
//! said, so that a scene that is spawned below it is made of its parts, too.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::{motion::{MotionSettings, Step}, prelude::*};
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
//!     .insert_resource(MotionSettings { step: Step::Seconds(0.25) });
//! // A hull and two wings, which overlap it.
//! let bounce = Bounce::Reflect { restitution: 1.0 };
//! let ship = app.world_mut().spawn((CollisionBody::default(), Velocity(Vec3::X), bounce, Transform::default())).id();
//! let parts = [(0.0, 2.0), (-1.0, 1.0), (1.0, 1.0)].map(|(z, length)| {
//!     let part = (CollisionShape::cuboid(length, 0.5, 1.5), Transform::from_xyz(0.0, 0.0, z));
//!     app.world_mut().spawn((part, ChildOf(ship))).id()
//! });
//! let wall = (CollisionShape::cuboid(1.0, 9.0, 9.0), StaticShape, Transform::from_xyz(2.0, 0.0, 0.0));
//! let wall = app.world_mut().spawn(wall).id();
//! (0..2).for_each(|_| app.update());
//!
//! let contacts = app.world().resource::<Contacts>();
//! let hit = contacts.between(parts[0], wall).unwrap(); // its nose; parts do not meet each other
//! assert_eq!((contacts.len(), hit.bodies), (1, [ship, wall]));
//! assert_eq!(app.world().get::<Velocity>(ship).unwrap().0, -Vec3::X);
//! ```
//!
//! # What belongs to what
//!
//! A shape is part of the nearest body above it, or of itself if it is a body. So a body that hangs
//! on another is a thing of its own: it is carried along, and it meets the other's parts, unless
//! [layers](crate::filters::CollisionLayers) or [lists](crate::filters::IgnoreCollisions) say
//! otherwise. That is all: there is nothing to write but the marker, and the hierarchy.
//!
//! The library keeps [`PartOf`] on each part and [`BodyParts`] on the body, to look up. They are up
//! to date at the beginning of each tick, and in the set
//! [`Maintenance`](crate::CollisionSystems::Maintenance). Parts may come, go, be shaped otherwise,
//! and be hung elsewhere at any time; what is told of contacts follows in the same tick:
//!
//! | what happens to a part in contact | its own contact | the contact of its body |
//! |---|---|---|
//! | it is despawned, disabled, or loses its shape | ends | ends, if it was the last one |
//! | it is hung on another body | goes on | as above; that of the other body starts, if it is the first one |
//! | it is hung on the body that it touches | ends, unless [asked for](CollisionBody::inner_contacts) | as above |
//! | its body loses the marker | goes on | ends |
//! | its body is despawned | ends | ends |
//!
//! Whatever else is said of an entity is about that entity alone: which
//! [world](crate::worlds::InCollisionWorld) and which layers a part is on, whether it is static, a
//! sensor or a detector, each part says for itself.
//!
//! # What is told
//!
//! Contacts are those of parts. Each [`Collision`](crate::contacts::Collision) and each
//! [message](crate::contacts::CollisionStarted) names the bodies, too, as they were when the two
//! were last found in contact: also those of a part that is gone. What is part of no body is its own.
//!
//! The messages [`BodyCollisionStarted`](crate::contacts::BodyCollisionStarted) and
//! [`BodyCollisionEnded`](crate::contacts::BodyCollisionEnded) are about whole bodies: one when the
//! first two parts touch, one when the last two have parted, exactly once each. They are written for
//! all that a body meets, whether that is a body or not. What
//! [sensors](crate::filters::Sensor) see is told apart from what solid parts do: a ship whose radar
//! reaches the wall is told so, and is told again when its hull does. Observers of a body are told if it has
//! [`CollisionEventsEnabled`](crate::contacts::CollisionEventsEnabled).
//!
//! | asked | of a part | of a body |
//! |---|---|---|
//! | [`CollidingEntities`](crate::contacts::CollidingEntities) | the entities that it touches | the bodies that it touches |
//! | [`Contacts`](crate::contacts::Contacts), [`Collisions`](crate::contacts::Collisions) | `of`, `between` | `of_body`, `between_bodies`, `body_pairs` |
//! | [`SpatialQuery`](crate::spatial_query::SpatialQuery) | hits are parts | `body_of` a hit; a filter `without_body` |
//!
//! # How it moves
//!
//! A body that has a [`Bounce`](crate::response::Bounce) or is [`Swept`](crate::swept::Swept)
//! answers to what its parts meet, in their place; what these have of either by themselves is not
//! asked. It needs a [`Velocity`](crate::motion::Velocity), as ever. It is reversed once per tick,
//! however many parts are in contact, and reflected while it comes nearer, by the velocity of the
//! part that meets something: a part that moves by a velocity of its own pushes its body back. If it
//! is swept, all of its parts are, along the way that they go with it and by themselves; the first
//! impact among all of them is the one that counts, and from there on the whole body goes another
//! way. Bodies do not turn by themselves.
//!
//! A body that has neither answers to nothing, and each of its parts speaks for itself, as those of
//! no body do. So does each part of a body that is disabled.
//!
//! # Cost
//!
//! Nothing where there are no bodies. Parts of one body are told apart in the broad phase, like
//! layers. Where there are bodies, each tick looks at all contacts once more, and at all parts.

mod group;
mod relation;

use bevy::prelude::*;

pub(crate) use group::{RegroupSystems, is_regroup_due, regroup};
pub(crate) use relation::KnownParts;
pub use relation::{BodyParts, CollisionBody, PartOf};

/// What others read though nothing is in contact.
pub(crate) fn register(app: &mut App) {
    relation::register(app);
    group::register(app);
}
