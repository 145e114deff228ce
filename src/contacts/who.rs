//! Who is who of the two in a contact.

use bevy::{
    ecs::query::{QueryData, QueryFilter},
    prelude::*,
};

use super::{
    events::{CollisionEnded, CollisionStarted},
    pair::Collision,
};

/// Writes the same for all that has an `a` and a `b`.
macro_rules! who_is_who {
    ($($(#[$attribute:meta])* $name:ident)+) => {
        $(
            $(#[$attribute])*
            impl $name {
                /// Returns `true` if an entity is one of the two.
                #[must_use]
                pub fn involves(&self, entity: Entity) -> bool {
                    self.a == entity || self.b == entity
                }

                /// Returns the one of the two that a query has, and then the other: `a` and `b`, if it
                /// has both. `None` if it has neither: an entity that is gone is in no query.
                #[must_use]
                #[doc(alias("which", "order"))]
                pub fn of<D: QueryData, F: QueryFilter>(
                    &self,
                    query: &Query<D, F>,
                ) -> Option<(Entity, Entity)> {
                    pick([self.a, self.b], |[one, _]| query.contains(one))
                }

                /// Returns the one of the two that the first query has, and the other, if the second
                /// query has that: `a` and `b`, if it is so both ways round. `None` if it is
                /// neither way round.
                #[must_use]
                #[doc(alias("match", "pair", "order"))]
                pub fn between<D: QueryData, F: QueryFilter, E: QueryData, G: QueryFilter>(
                    &self,
                    query: &Query<D, F>,
                    others: &Query<E, G>,
                ) -> Option<(Entity, Entity)> {
                    pick([self.a, self.b], |[one, other]| {
                        query.contains(one) && others.contains(other)
                    })
                }

                /// Returns the same as seen from one of the two, which is `a` of it, and whose normal
                /// leads away from it; `None` if the entity is neither.
                #[must_use]
                pub fn seen_by(self, entity: Entity) -> Option<Self> {
                    if self.a == entity {
                        Some(self)
                    } else {
                        (self.b == entity).then(|| self.reversed())
                    }
                }
            }
        )+
    };
}

who_is_who! {
    /// # Who is who
    ///
    /// As of [`CollisionStarted`](CollisionStarted#who-is-who).
    Collision

    /// # Who is who
    ///
    /// Whether the two [hear](Self::hears) of each other is not asked. The two are the entities
    /// that have the shapes: of a thing made of [parts](crate::parts), a query has to have the
    /// part. Where the body is meant, look for it in `bodies`, or read
    /// [`BodyCollisionStarted`](crate::contacts::BodyCollisionStarted).
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// #[derive(Component)]
    /// struct Player {
    ///     coins: u32,
    /// }
    ///
    /// #[derive(Component)]
    /// struct Coin;
    ///
    /// fn collect(
    ///     mut started: MessageReader<CollisionStarted>,
    ///     mut players: Query<&mut Player>,
    ///     coins: Query<(), With<Coin>>,
    ///     mut commands: Commands,
    /// ) {
    ///     for message in started.read() {
    ///         if let Some((player, coin)) = message.between(&players, &coins) {
    ///             players.get_mut(player).unwrap().coins += 1;
    ///             commands.entity(coin).try_despawn();
    ///         }
    ///     }
    /// }
    /// # bevy::ecs::system::assert_is_system(collect);
    /// ```
    CollisionStarted

    /// # Who is who
    ///
    /// As of [`CollisionStarted`](CollisionStarted#who-is-who).
    CollisionEnded
}

/// Two in the first order that will do.
fn pick([a, b]: [Entity; 2], will_do: impl Fn([Entity; 2]) -> bool) -> Option<(Entity, Entity)> {
    if will_do([a, b]) {
        Some((a, b))
    } else {
        will_do([b, a]).then_some((b, a))
    }
}
