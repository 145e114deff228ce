//! Contacts.

use bevy::{math::bounding::BoundingVolume, prelude::*};

use super::gizmos::{CollisionGizmos, surface_point};
use crate::{
    components::WorldAabb,
    contacts::{Collision, Collisions},
    narrow_phase::Contact,
};

/// Draws all contacts; those without geometry only if both entities are still there, and have an
/// end.
pub(super) fn draw_contacts(
    mut gizmos: Gizmos<CollisionGizmos>,
    collisions: Collisions,
    boxes: Query<&WorldAabb>,
) {
    let CollisionGizmos {
        contacts: Some(color),
        ..
    } = *gizmos.config_ext
    else {
        return;
    };
    for Collision { a, b, contact, .. } in collisions.iter() {
        if let Some(Contact { normal, point, .. }) = contact {
            surface_point(&mut gizmos, point, normal, color);
        } else if let Ok(boxes) = boxes.get_many([a, b])
            && !boxes.contains(&&WorldAabb::UNBOUNDED)
        {
            let [a, b] = boxes.map(|aabb| aabb.center().into());
            gizmos.line(a, b, color);
        }
    }
}
