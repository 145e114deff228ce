//! Where the ways of swept entities begin: kept with them, below all who ask.

use bevy::prelude::*;

use crate::broad_phase::ProxyId;

/// Where the way of an entity with [`Swept`](crate::swept::Swept) begins. Comes with it; a cloned
/// entity gets one of its own.
///
/// It holds for the entity that it was written for, for as long as that stays in the
/// [`CollisionIndex`](crate::collision_index::CollisionIndex): a copy on another entity, or one
/// from before the entity was out of the index, says nothing, and its way begins anew.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[component(clone_behavior = Ignore)]
pub struct SweptWay {
    /// Whose way it is.
    #[reflect(ignore, default = "nobody")]
    entity: Entity,
    /// The handle that it has while it is in the index; `None` in its first tick, in which it gets
    /// one.
    #[reflect(ignore)]
    id: Option<ProxyId>,
    /// Where its way in this tick begins.
    #[reflect(ignore)]
    start: Option<Transform>,
    /// Where that in the last tick began.
    #[reflect(ignore)]
    last: Option<Transform>,
    /// Does its box cover more than the place where it is?
    #[reflect(ignore)]
    stretched: bool,
}

const fn nobody() -> Entity {
    Entity::PLACEHOLDER
}

impl Default for SweptWay {
    fn default() -> Self {
        Self {
            entity: nobody(),
            id: None,
            start: None,
            last: None,
            stretched: false,
        }
    }
}

impl SweptWay {
    /// Returns where in the world the way began in the last tick that is done; `None` before the
    /// first.
    ///
    /// It is written after the set [`Response`](crate::CollisionSystems::Response), before
    /// [`Report`](crate::CollisionSystems::Report): who reads it from `Report` on, in an observer
    /// of collision events, in [`Last`](crate::CollisionSystems::Last) or after the tick, gets
    /// where the way of *this* tick began; up to `Response`, it is that of the tick before.
    #[must_use]
    pub const fn last_start(&self) -> Option<&Transform> {
        self.last.as_ref()
    }

    /// Has the way begin where the entity is at the next tick.
    pub(crate) fn forget(&mut self) {
        (self.start, self.last) = (None, None);
    }

    /// Is it that of this entity, under this handle?
    pub(crate) fn belongs_to(&self, entity: Entity, id: Option<ProxyId>) -> bool {
        self.entity == entity && (self.id.is_none() || self.id == id)
    }

    /// Where it begins, if it leads anywhere.
    #[inline]
    pub(crate) fn to(&self, pose: &Transform) -> Option<&Transform> {
        let elsewhere = |start: &&Transform| {
            start.translation != pose.translation || start.rotation != pose.rotation
        };
        self.start.as_ref().filter(elsewhere)
    }

    /// Where it begins, if it has begun.
    pub(crate) const fn start(&self) -> Option<&Transform> {
        self.start.as_ref()
    }

    pub(crate) const fn has_begun(&self) -> bool {
        self.start.is_some()
    }

    /// Has it begin here, in the tick in which the entity is new. What is not finite is nowhere.
    pub(crate) fn begin(&mut self, entity: Entity, pose: Option<Transform>) {
        *self = Self {
            entity,
            id: None,
            start: pose.filter(Transform::is_finite),
            last: None,
            ..*self
        };
    }

    /// Has the next one begin here, where this one ended.
    pub(crate) fn end(&mut self, id: Option<ProxyId>, pose: &Transform) {
        let is_somewhere = pose.is_finite();
        self.id = id;
        self.last = self.start.replace(*pose).filter(|_| is_somewhere);
        self.start = self.start.filter(|_| is_somewhere);
    }

    /// Has it be as it was at another time, whatever the handle of the entity is by now.
    pub(crate) fn restore(
        &mut self,
        entity: Entity,
        start: Option<Transform>,
        last: Option<Transform>,
    ) {
        *self = Self {
            entity,
            id: None,
            start,
            last,
            // The box is that of some other time.
            stretched: true,
        };
    }

    /// Does the box cover more than the place where the entity is?
    pub(crate) const fn is_stretched(&self) -> bool {
        self.stretched
    }

    pub(crate) const fn note_stretched(&mut self, stretched: bool) {
        self.stretched = stretched;
    }
}
