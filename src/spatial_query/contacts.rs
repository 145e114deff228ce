//! Contacts of a shape that is no entity.

use bevy::prelude::*;

use super::{filter::SpatialQueryFilter, query::SpatialQuery, scratch};
use crate::{
    broad_phase::Flow,
    narrow_phase::{Contact, Placed, Shape},
};

/// Where a shape at a place touches an entity.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct ShapeContact {
    /// The entity.
    pub entity: Entity,
    /// A point where the two meet.
    pub point: Vec3,
    /// A unit vector from the entity to the shape: to part the two, move the shape along it.
    pub normal: Vec3,
    /// How deep the two are in each other along the normal, in world units: how far the shape has to
    /// move. 0 if they touch, or are apart by no more than the tolerance.
    pub depth: f32,
}

/// # Contacts of a shape
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// /// Moves a character out of whatever it has got into, by its capsule or, as here, its ball.
/// fn push_out(mut characters: Query<(Entity, &mut Transform), With<Velocity>>, spatial: SpatialQuery, mut contacts: Local<Vec<ShapeContact>>) {
///     let body = Shape::sphere(0.5);
///     for (character, mut at) in &mut characters {
///         let walls = SpatialQueryFilter::DEFAULT.except(character).without_sensors();
///         // The deepest first: what it settles, others need no more.
///         for _ in 0..4 {
///             spatial.shape_contacts(&body, &at, &walls, &mut contacts);
///             let Some(deepest) = contacts.first().filter(|contact| contact.depth > 1e-4) else { break };
///             at.translation += deepest.normal * deepest.depth;
///         }
///     }
/// }
/// # bevy::ecs::system::assert_is_system(push_out);
/// ```
impl SpatialQuery<'_, '_> {
    /// Calls `found` with every entity that a shape at a place is in contact with, and where, in no
    /// particular order; it may return a [`ControlFlow`](std::ops::ControlFlow) to stop.
    ///
    /// Exact: those that
    /// [`for_each_shape_intersection`](Self::for_each_shape_intersection) finds, each with its
    /// [`NarrowPhase::contact`](crate::narrow_phase::NarrowPhase::contact).
    #[doc(alias("penetration", "overlap", "contact query", "depenetration"))]
    pub fn for_each_shape_contact<F: Flow>(
        &self,
        shape: &Shape,
        at: &Transform,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(ShapeContact) -> F,
    ) {
        let placed = Placed::new(shape, at);
        self.for_each_near_shape(placed, filter, |_, body| {
            let contact = scratch::with(|scratch| {
                self.tests()
                    .contact(body.placed(), placed, &mut scratch.workspace)
            });
            contact.is_none_or(|contact| {
                let Contact {
                    normal,
                    point,
                    depth,
                } = contact;
                let contact = ShapeContact {
                    entity: body.entity,
                    point,
                    normal,
                    depth,
                };
                found(contact).goes_on()
            })
        });
    }

    /// Finds all contacts of a shape at a place, as
    /// [`for_each_shape_contact`](Self::for_each_shape_contact): the deepest first, those as deep by
    /// ascending [`Entity`]. They replace what is in `contacts`, which is yours to use again.
    #[doc(alias("penetration", "depenetration", "collide shape"))]
    pub fn shape_contacts(
        &self,
        shape: &Shape,
        at: &Transform,
        filter: &SpatialQueryFilter,
        contacts: &mut Vec<ShapeContact>,
    ) {
        contacts.clear();
        self.for_each_shape_contact(shape, at, filter, |contact| contacts.push(contact));
        contacts.sort_unstable_by(|a, b| b.depth.total_cmp(&a.depth).then_with(|| self.order_of(a.entity).cmp(&self.order_of(b.entity))));
    }
}
