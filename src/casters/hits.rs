//! What casters met.

use std::{mem, ops::Deref};

use bevy::prelude::*;

use crate::spatial_query::{RayHit, ShapeHit};

/// A component that lists what a caster met.
pub(super) trait Hits {
    /// What is known of each.
    type Hit;

    /// Takes up what is met now. Returns `true` if that is something else than before.
    fn renew(&mut self, find: impl FnOnce(&mut Vec<Self::Hit>)) -> bool;
}

macro_rules! hits {
    ($(#[$attribute:meta])* $name:ident of $hit:ident) => {
        $(#[$attribute])*
        ///
        /// It counts as [changed](bevy::ecs::query::Changed) only in ticks in which the hits changed,
        /// be it by a distance. Entities that are gone since the last tick are in it until the next.
        /// Without the caster, the last hits stay.
        #[derive(Component, Clone, Debug, Default, Reflect)]
        #[reflect(Component, Clone, Debug, Default, PartialEq)]
        #[type_path = "bevy_octree"]
        pub struct $name {
            #[entities]
            hits: Vec<$hit>,
            /// Those of the tick before: memory to work with.
            #[reflect(ignore)]
            last: Vec<$hit>,
        }

        impl $name {
            /// Returns the nearest hit.
            #[must_use]
            #[doc(alias = "first")]
            pub fn nearest(&self) -> Option<&$hit> {
                self.hits.first()
            }

            /// Returns the hit of an entity, if it was met.
            #[must_use]
            pub fn of(&self, entity: Entity) -> Option<&$hit> {
                self.hits.iter().find(|hit| hit.entity == entity)
            }
        }

        /// The hits, nearest first.
        impl Deref for $name {
            type Target = [$hit];

            fn deref(&self) -> &[$hit] {
                &self.hits
            }
        }

        impl<'a> IntoIterator for &'a $name {
            type Item = &'a $hit;
            type IntoIter = std::slice::Iter<'a, $hit>;

            fn into_iter(self) -> Self::IntoIter {
                self.hits.iter()
            }
        }

        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                self.hits == other.hits
            }
        }

        impl Hits for $name {
            type Hit = $hit;

            fn renew(&mut self, find: impl FnOnce(&mut Vec<$hit>)) -> bool {
                mem::swap(&mut self.hits, &mut self.last);
                self.hits.clear();
                find(&mut self.hits);
                self.hits != self.last
            }
        }
    };
}

hits! {
    /// What the [`RayCaster`](super::RayCaster) of the entity met in the last tick, nearest first;
    /// what is as near, by ascending [`Entity`]. One alone is that which
    /// [`cast_ray`](crate::spatial_query::SpatialQuery::cast_ray) finds.
    RayHits of RayHit
}

hits! {
    /// What the [`ShapeCaster`](super::ShapeCaster) of the entity met in the last tick, nearest
    /// first; what is as near, by ascending [`Entity`]. One alone is that which
    /// [`cast_shape`](crate::spatial_query::SpatialQuery::cast_shape) finds.
    ShapeHits of ShapeHit
}

pub(super) fn register(app: &mut App) {
    app.register_type::<RayHits>().register_type::<ShapeHits>();
}
