//! Followers: what is in the index already, and has moved.

use std::ops::Range;

use bevy::{ecs::change_detection::Tick, math::bounding::Aabb3d, prelude::*};

use super::{Body, CollisionIndex};
use crate::{
    broad_phase::{ProxyId, ProxyPart, cut},
    narrow_phase::Fit,
};

/// All that the index is to know of an entity that is in it by its handle, in a box, and keeps its
/// shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Following<'a> {
    pub(crate) entity: Entity,
    pub(crate) id: ProxyId,
    pub(crate) aabb: &'a Aabb3d,
    pub(crate) pose: &'a Transform,
    /// What the box says of the shape.
    pub(crate) fit: Fit,
    /// When the entity's own shape became what it is.
    pub(crate) reshaped: Tick,
    /// Where its way in this tick begins, if it is on one.
    pub(crate) start: Option<&'a Transform>,
}

/// What is behind handles that follow each other, for one job to bring up to date.
#[derive(Debug)]
pub(crate) struct Followers<'a> {
    proxies: ProxyPart<'a>,
    entities: &'a mut [Entity],
    bodies: &'a mut [Body],
    fits: &'a mut [Fit],
    /// Of no more than there are starts.
    starts: &'a mut [Option<Transform>],
}

impl Followers<'_> {
    /// Gives an entity its box and its pose of this tick, and lists its handle, if that was not
    /// listed yet. `false`, and nothing changes, if it is not in the index by this handle, has
    /// another shape by now, or one of the boxes is none: then
    /// [`upsert`](CollisionIndex::upsert) has to decide.
    #[inline]
    pub(crate) fn follow(&mut self, now: &Following<'_>, moved: &mut Vec<ProxyId>) -> bool {
        let Some(place) = self.proxies.place(now.id) else {
            return false;
        };
        let (Some(entity), Some(body)) = (self.entities.get(place), self.bodies.get_mut(place))
        else {
            return false;
        };
        // It may have turned inside its box.
        let stays = *entity == now.entity
            && body.reshaped == now.reshaped
            && self.proxies.renew(now.id, now.aabb, moved);
        if stays {
            body.pose = *now.pose;
            self.fits[place] = now.fit;
            if let Some(start) = self.starts.get_mut(place) {
                *start = now.start.copied();
            } else {
                debug_assert!(now.start.is_none(), "room is made for starts");
            }
        }
        stays
    }
}

impl CollisionIndex {
    /// What is behind some ranges of handles, which ascend and do not overlap.
    pub(crate) fn followers<'a>(
        &'a mut self,
        ranges: impl Iterator<Item = Range<usize>> + Clone + 'a,
    ) -> impl Iterator<Item = Followers<'a>> {
        let Self {
            index,
            entities,
            bodies,
            fits,
            starts,
            ..
        } = self;
        let (mut entities, mut bodies) = (&mut entities[..], &mut bodies[..]);
        let (mut fits, mut starts) = (&mut fits[..], &mut starts[..]);
        let mut start = 0;
        index
            .parts(ranges.clone())
            .zip(ranges)
            .map(move |(proxies, range)| {
                let followers = Followers {
                    proxies,
                    entities: cut(&mut entities, start, &range),
                    bodies: cut(&mut bodies, start, &range),
                    fits: cut(&mut fits, start, &range),
                    starts: cut(&mut starts, start, &range),
                };
                start = range.end;
                followers
            })
    }

    /// Brings one entity up to date, [as among others](Followers::follow), with memory
    /// that is lent.
    pub(crate) fn follow(&mut self, now: &Following<'_>, moved: &mut Vec<ProxyId>) -> bool {
        if now.start.is_some() {
            self.make_room_for_starts();
        }
        let index = now.id.index();
        moved.clear();
        let mut alone = self.followers(std::iter::once(index..index + 1));
        let follows = alone
            .next()
            .is_some_and(|mut alone| alone.follow(now, moved));
        drop(alone);
        self.note_moved(moved);
        follows
    }

    /// Takes note of those that followed, in the order in which they are to count as moved.
    pub(crate) fn note_moved(&mut self, moved: &[ProxyId]) {
        self.index.note_moved(moved);
    }

    /// Takes note that nobody is on a way.
    pub(crate) fn forget_starts(&mut self) {
        self.starts.clear();
    }

    /// Makes room for the starts of ways of all that are in the index.
    pub(crate) fn make_room_for_starts(&mut self) {
        self.starts
            .resize(self.bodies.len().max(self.starts.len()), None);
    }
}
