//! The rule: what a contact does to the velocities of two.

use bevy::{math::DVec3, prelude::*};
use serde::{Deserialize, Serialize};

/// Says how an entity's [`Velocity`](crate::motion::Velocity) answers to contacts.
///
/// This happens in the world: velocities of entities with a parent are taken there and back,
/// through the whole hierarchy. One whose ancestors are scaled to nothing has no answer. Entities
/// without this component pass through each other, and are only reported. Who does not hear of a
/// contact with a [detector](crate::filters::Detector) does not answer. Those that are
/// [swept](crate::swept::Swept), and what they meet, answer at the time of impact. A
/// [body](crate::parts) answers to what its parts meet.
///
/// # Resting under a force of your own
///
/// A bounce changes velocities, and moves nothing. What a force of your own, such as gravity, pulls
/// down anew in each tick has moved a little into the ground before the bounce takes that speed
/// away, and is never moved out: it sinks, the faster the less it bounces, and at last falls
/// through. There are two cures.
///
/// [`Swept`](crate::swept::Swept) stops it at the surface:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// const TICK: f32 = 1.0 / 60.0;
///
/// fn fall(mut falling: Query<&mut Velocity>) {
///     for mut velocity in &mut falling {
///         velocity.y -= 9.8 * TICK;
///     }
/// }
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
///     .insert_resource(MotionSettings { step: Step::Seconds(TICK) })
///     .add_systems(Update, fall.before(CollisionSystems::Motion));
/// let floor = (CollisionShape::cuboid(9.0, 1.0, 9.0), StaticShape, Transform::from_xyz(0.0, -0.5, 0.0));
/// app.world_mut().spawn(floor);
/// let bounce = Bounce::Reflect { restitution: 0.3 };
/// let body = (CollisionShape::sphere(0.5), Velocity::default(), bounce, Transform::from_xyz(0.0, 0.6, 0.0));
/// let body = app.world_mut().spawn((body, Swept::default())).id();
/// (0..600).for_each(|_| app.update());
/// assert!(app.world().get::<Transform>(body).unwrap().translation.y > 0.49);
/// ```
///
/// Or a system lifts it by the depth of its contacts, which somebody has to [ask
/// for](crate::contacts::CollisionEventSettings::geometry). That costs less where many rest, as
/// there is no search for impacts, and does for what is too slow to pass through the ground in a
/// tick:
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_octree::prelude::*;
/// # const TICK: f32 = 1.0 / 60.0;
/// # fn fall(mut falling: Query<&mut Velocity>) {
/// #     for mut velocity in &mut falling {
/// #         velocity.y -= 9.8 * TICK;
/// #     }
/// # }
/// fn lift(contacts: Res<Contacts>, fixed: Query<(), With<StaticShape>>, mut bodies: Query<&mut Transform, With<Bounce>>) {
///     for collision in contacts.iter() {
///         // As seen from what is to be lifted.
///         let collision = if fixed.contains(collision.a) { collision.reversed() } else { collision };
///         if fixed.contains(collision.b)
///             && let (Some(contact), Ok(mut body)) = (collision.contact, bodies.get_mut(collision.a))
///         {
///             body.translation -= contact.normal * contact.depth;
///         }
///     }
/// }
///
/// # let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
///     .insert_resource(MotionSettings { step: Step::Seconds(TICK) })
///     .insert_resource(CollisionEventSettings { geometry: EventScope::All, ..default() })
///     .add_systems(Update, fall.before(CollisionSystems::Motion))
///     .add_systems(Update, lift.after(CollisionSystems::Response));
/// # let floor = (CollisionShape::cuboid(9.0, 1.0, 9.0), StaticShape, Transform::from_xyz(0.0, -0.5, 0.0));
/// # app.world_mut().spawn(floor);
/// # let bounce = Bounce::Reflect { restitution: 0.3 };
/// # let body = (CollisionShape::sphere(0.5), Velocity::default(), bounce, Transform::from_xyz(0.0, 0.6, 0.0));
/// # let body = app.world_mut().spawn(body).id();
/// # (0..600).for_each(|_| app.update());
/// # assert!(app.world().get::<Transform>(body).unwrap().translation.y > 0.49);
/// ```
#[doc(alias(
    "restitution",
    "response",
    "bounciness",
    "elasticity",
    "coefficient of restitution"
))]
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[reflect(Component, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Bounce {
    /// The velocity is reversed, once per tick at most, however many contacts there are (Swan 1994,
    /// section 1.2).
    ///
    /// It is reversed in every tick in which there is a contact, so that objects which do not get
    /// out of each other within one tick tremble in place: steps must be small against sizes, and
    /// starting positions free of overlap.
    #[default]
    Reverse,
    /// The velocity is reflected about the contact's normal, if the two approach each other: as
    /// between bodies of equal mass if both reflect, and as from a wall otherwise. Contacts act one
    /// after the other, in the order of the [`Contacts`](crate::contacts::Contacts).
    ///
    /// What has no `Bounce` is a wall that moves as its velocity says. One that is
    /// [reversed](Self::Reverse) is at rest to what it comes towards. So bounces make no energy but
    /// by the walls that move. Under a force of your own, it [does not
    /// rest](Self#resting-under-a-force-of-your-own) by itself.
    ///
    /// Where two no more than touch, edge on edge, the normal is the one along which they approach
    /// the least: a box that slides over a floor of flush boxes goes on over the seams.
    Reflect {
        /// The share of the approaching speed that is given back: 0 slides along, 1 loses nothing.
        /// A number outside 0 to 1 is taken as the nearest inside, and NaN as 0.
        restitution: f32,
    },
}

/// A restitution in its range; 0 for NaN.
fn share(restitution: f32) -> f32 {
    if restitution > 0.0 {
        restitution.min(1.0)
    } else {
        0.0
    }
}

/// # For `bsn!`
impl Bounce {
    /// Returns the `Reverse` that `bsn!` begins with.
    #[must_use]
    pub const fn default_reverse() -> Self {
        Self::Reverse
    }

    /// Returns the `Reflect` that `bsn!` begins with: with a restitution of 0.
    #[must_use]
    pub const fn default_reflect() -> Self {
        Self::Reflect { restitution: 0.0 }
    }
}

impl Bounce {
    /// The restitution of those that reflect.
    pub(super) fn restitution(self) -> Option<f32> {
        match self {
            Self::Reverse => None,
            Self::Reflect { restitution } => Some(share(restitution)),
        }
    }
}

/// One of the two in a contact, as the response sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Party {
    /// In the world.
    pub(super) velocity: Vec3,
    /// How much of it is that of what the entity hangs on: this part is not its own to change.
    pub(super) drift: Vec3,
    pub(super) bounce: Option<Bounce>,
    /// Has it been reversed in this tick? It is so once at most.
    pub(super) reversed: bool,
}

impl Party {
    fn restitution(&self) -> Option<f32> {
        self.bounce.and_then(Bounce::restitution)
    }

    /// The same, of which a part meets something that is so much faster, and by no doing of its own.
    pub(super) fn faster(self, faster: Vec3) -> Self {
        Self {
            velocity: self.velocity + faster,
            drift: self.drift + faster,
            ..self
        }
    }

    /// The party after its velocity was reversed, if it is.
    fn turned_around(self) -> Option<Self> {
        let turns =
            self.bounce == Some(Bounce::Reverse) && !self.reversed && self.velocity != self.drift;
        turns.then(|| Self {
            velocity: 2.0 * self.drift - self.velocity,
            reversed: true,
            ..self
        })
    }

    /// How fast it is to the other, which is in that direction. Who turns around has given nothing
    /// up, and so has nothing to give: to what it comes towards, it is at rest.
    fn as_a_wall(&self, towards_other: Vec3) -> Vec3 {
        let comes = (self.velocity - self.drift).dot(towards_other) > 0.0;
        if self.bounce == Some(Bounce::Reverse) && comes {
            self.drift
        } else {
            self.velocity
        }
    }
}

/// The velocities in the world that a contact leaves two with; `None` for those that keep theirs.
/// Who is reversed, is so before the other is reflected. Energy does not grow but by what those do
/// that have no [`Bounce`], or hang on something.
pub(super) fn respond(parties: [Party; 2], normal: Vec3) -> [Option<Vec3>; 2] {
    let turned = parties.map(Party::turned_around);
    let now = [0, 1].map(|which| turned[which].unwrap_or(parties[which]));
    let mut after = turned.map(|turned| turned.map(|party| party.velocity));
    let walls = [now[0].as_a_wall(normal), now[1].as_a_wall(-normal)];
    if let Some(change) = reflection(now.map(|party| party.restitution()), walls, normal) {
        for (which, change) in [-change, change].into_iter().enumerate() {
            if now[which].restitution().is_some() {
                // A velocity beyond all numbers is none.
                let velocity = (now[which].velocity.as_dvec3() + change).as_vec3();
                after[which] = Some(velocity).filter(|velocity| velocity.is_finite());
            }
        }
    }
    after
}

/// How reflection changes the velocities of those with a restitution: that of the first the other
/// way. `None` if nothing is reflected.
fn reflection(
    restitutions: [Option<f32>; 2],
    velocities: [Vec3; 2],
    normal: Vec3,
) -> Option<DVec3> {
    let restitution = restitutions.into_iter().flatten().reduce(f32::min)?;
    // In 64 bits, and with the normal's length as rounding left it: bounces by the thousand must
    // not add up to anything.
    let [a, b, normal] = [velocities[0], velocities[1], normal].map(Vec3::as_dvec3);
    let speed = (a - b).dot(normal);
    let sharers = restitutions.iter().flatten().count() as f64;
    let change = speed * (1.0 + f64::from(restitution)) / (sharers * normal.length_squared());
    (speed > 0.0).then(|| normal * change)
}

pub(super) fn register(app: &mut App) {
    app.register_type::<Bounce>();
}

#[cfg(test)]
mod tests;
