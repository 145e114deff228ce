//! What becomes of a body within a tick in which something is met on the way.

use bevy::prelude::*;

use super::Swept;
use crate::{
    broad_phase::ProxyId,
    collision_index::CollisionIndex,
    filters::Sensor,
    motion::{Velocity, is_moved_by_velocity},
    narrow_phase::{Moving, approach},
    response::{Bounce, respond},
};

/// A body that met something in this tick, and where it is going since.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    pub(super) entity: Entity,
    pub(super) velocity: Vec3,
    bounce: Option<Bounce>,
    is_sensor: bool,
    is_swept: bool,
    /// How often it may still bounce within this tick, if its way is ours to change.
    steers: Option<u32>,
    /// The share of the tick after which it last changed course.
    since: f32,
    /// Where it was then.
    from: Vec3,
    /// How far it would go from there in a whole tick.
    way: Vec3,
    /// How often it has changed course.
    pub(super) version: u32,
    /// Did it do so by itself, rather than with what it hangs on?
    pub(super) has_turned: bool,
    /// Its handle among those that have.
    pub(super) diverted: Option<ProxyId>,
    pub(super) bounces: u64,
}

impl Track {
    /// That of a body which has met nothing yet.
    pub(super) fn of(id: ProxyId, world: &World) -> Option<Self> {
        let index = world.resource::<CollisionIndex>();
        let (entity, moving) = (index.body(id)?.entity, index.moving(id)?);
        let swept = world.get::<Swept>(entity);
        let steers = is_moved_by_velocity(world.entity(entity)) && !world.entity(entity).contains::<ChildOf>();
        Some(Self {
            entity,
            velocity: world.get::<Velocity>(entity).map_or(Vec3::ZERO, |velocity| velocity.0),
            bounce: world.get::<Bounce>(entity).copied(),
            is_sensor: world.entity(entity).contains::<Sensor>(),
            is_swept: swept.is_some(),
            steers: swept.map(|swept| swept.sub_steps).filter(|_| steers),
            since: 0.0,
            from: moving.at(0.0).translation,
            way: moving.at(1.0).translation - moving.at(0.0).translation,
            version: 0,
            has_turned: false,
            diverted: None,
            bounces: 0,
        })
    }

    /// Where it is after a share of the tick.
    pub(super) fn place(&self, time: f32) -> Vec3 {
        self.from + self.way * (time - self.since)
    }

    /// Its way from then on, given that of the whole tick, from which it has its turns.
    pub(super) fn after<'a>(&self, time: f32, whole: &Moving<'a>) -> Moving<'a> {
        whole.after(time).along(self.place(time), self.place(1.0))
    }

    /// How far it goes in a whole tick.
    pub(super) const fn way(&self) -> Vec3 {
        self.way
    }

    /// Is it on another way than at the start of the tick?
    pub(super) const fn is_diverted(&self) -> bool {
        self.is_swept && self.version > 0
    }

    /// Is it on no way, and elsewhere than it would have been?
    pub(super) const fn is_displaced(&self) -> bool {
        !self.is_swept && self.version > 0
    }

    /// Takes up that the way of what it hangs on changes by so much per tick. What is not swept counts for the whole tick as
    /// where it is at the end of it.
    pub(super) fn carry(&mut self, change: Vec3, time: f32) {
        if self.is_swept {
            (self.from, self.since, self.way) = (self.place(time), time, self.way + change);
        } else {
            self.from += change * (1.0 - time);
        }
        self.version += 1;
    }

    /// May it still answer to an impact?
    fn answers(&self) -> Option<Bounce> {
        self.bounce.filter(|_| self.steers != Some(0))
    }

    /// Takes up the velocity that an impact leaves it with, if that is another one. Does it change course?
    fn answer(&mut self, velocity: Option<Vec3>, time: f32, seconds: f32) -> bool {
        if let Some(velocity) = velocity {
            self.velocity = velocity;
            self.bounces += 1;
            match &mut self.steers {
                Some(left) => *left -= 1,
                // It stays on its way, and is reversed once per tick at most.
                None => {
                    self.bounce = self.bounce.filter(|bounce| *bounce != Bounce::Reverse);
                    return false;
                }
            }
            self.divert(time, velocity * seconds);
        } else {
            self.divert(time, Vec3::ZERO);
        }
        true
    }

    fn divert(&mut self, time: f32, way: Vec3) {
        (self.from, self.since, self.way) = (self.place(time), time, way);
        self.version += 1;
        self.has_turned = true;
    }
}

/// Two meet, with the normal from the first to the second: their velocities answer at once. Returns which of them change
/// course.
pub(super) fn meet(tracks: [&mut Track; 2], normal: Vec3, time: f32, seconds: f32) -> [bool; 2] {
    let [a, b] = tracks;
    let velocities = [a.velocity, b.velocity];
    if a.is_sensor || b.is_sensor || !approach(velocities, normal) {
        return [false; 2];
    }
    // Who has bounced often enough is a wall to the other, and stays.
    let answers = respond([a.answers(), b.answers()], velocities, normal);
    let turn = |track: &mut Track, velocity: Option<Vec3>| {
        let stays = track.bounce.is_some() && track.steers == Some(0) && track.way != Vec3::ZERO;
        (velocity.is_some() || stays) && track.answer(velocity, time, seconds)
    };
    [turn(a, answers[0]), turn(b, answers[1])]
}
