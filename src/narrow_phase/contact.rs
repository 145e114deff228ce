//! Where, which way and how deep two shapes meet.

use bevy::math::Vec3;

use super::{NarrowPhase, Placed, Workspace};

/// The geometry of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// A unit vector, pointing from the first shape to the second: the way to push the second.
    pub normal: Vec3,
    /// A point where the two meet, in the world.
    pub point: Vec3,
    /// How far the shapes overlap along the normal, in world units. Zero if they touch, or are apart by
    /// no more than the tolerance.
    pub depth: f32,
}

impl NarrowPhase {
    /// The contact of two shapes: some if and only if they [intersect](Self::intersects).
    #[must_use]
    pub fn contact(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> Option<Contact> {
        self.intersects(a, b, workspace).then(|| Contact {
            normal: (b.transform.translation - a.transform.translation)
                .try_normalize()
                .unwrap_or(Vec3::Y),
            point: a.transform.translation.midpoint(b.transform.translation),
            depth: 0.0,
        })
    }
}
