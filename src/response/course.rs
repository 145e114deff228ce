//! The course of a body within a tick in which something is met on the way.

use bevy::prelude::*;

use super::{
    answering::lead_of,
    bounce::{Bounce, Party, respond},
};
use crate::{
    broad_phase::ProxyId,
    collision_index::CollisionIndex,
    components::BroadPhaseProxy,
    filters::Sensor,
    frame::{Ancestor, Frame},
    motion::{Velocity, is_moved_by_velocity},
    narrow_phase::{Contact, Moving, approach},
    swept::{AtSolid, Swept, SweptWithBody},
    way::SweptWay,
};

/// Who says where a body goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Steering {
    /// Its velocity: a bounce changes its course, so many times yet in this tick.
    Own { bounces_left: u32 },
    /// Something else, or nobody looks at it on the way: whatever becomes of its velocity, it keeps
    /// its course.
    Foreign,
}

/// What an impact does to the course of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Turn {
    /// It goes on as it would have.
    Keeps,
    /// It goes so much farther, per tick, than it would have.
    Diverts(Vec3),
    /// It has stopped, though its mover has moved it on, and meets nothing any more.
    Ends,
}

/// The body that answers in place of one of its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lead {
    pub(super) body: Entity,
    /// How much faster the part is than the body.
    faster: Vec3,
}

/// How fast something is: in the space that it is in, and in the world.
struct Speed {
    frame: Option<Frame>,
    in_world: Vec3,
}

impl Speed {
    fn of(entity: EntityRef, world: &World) -> Self {
        let parent = entity.get::<ChildOf>().map(ChildOf::parent);
        let frame =
            parent.map(|parent| Frame::of(parent, |ancestor| Ancestor::of(ancestor, world)));
        let own = entity
            .get::<Velocity>()
            .map_or(Vec3::ZERO, |velocity| velocity.0);
        let in_world = frame.map_or(own, |frame| frame.velocity_in_world(own));
        Self { frame, in_world }
    }
}

/// A body that met something in this tick, and where it is going since.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) entity: Entity,
    /// What it hangs on, if anything.
    pub(super) frame: Option<Frame>,
    /// The body that answers in its place, if there is one, and how much faster it is than that.
    pub(super) lead: Option<Lead>,
    /// Of a body, while a part of it meets something: how much faster that is.
    faster: Vec3,
    /// Its velocity in the world, and how it answers.
    party: Party,
    is_sensor: bool,
    is_swept: bool,
    steering: Steering,
    /// Does it stop at the first solid?
    stops: bool,
    /// Has it come to stay where it is for what is left of the tick?
    stays: bool,
    /// Has it stopped, though its mover has moved it on? Then it meets nothing any more.
    pub(super) has_ended: bool,
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

impl Course {
    /// That of a body which has met nothing yet.
    pub(super) fn of(id: ProxyId, world: &World) -> Option<Self> {
        let index = world.resource::<CollisionIndex>();
        let (entity, moving) = (index.body(id)?.entity, index.moving(id)?);
        let of_world = world.get_entity(entity).ok()?;
        let speed = Speed::of(of_world, world);
        let in_world = speed.in_world;
        let way = [0.0, 1.0].map(|time| moving.at(time).translation);
        let course = Self::along(way, of_world, speed);
        let lead = lead_of(entity, world).and_then(|body| {
            let faster = in_world - Speed::of(world.get_entity(body).ok()?, world).in_world;
            Some(Lead { body, faster })
        });
        Some(Self { lead, ..course })
    }

    /// That of a body which answers for its parts, with or without a shape of its own. `None` if it
    /// is gone, or nowhere.
    pub(super) fn of_body(body: Entity, world: &World) -> Option<Self> {
        let of_world = world.get_entity(body).ok()?;
        let own = of_world.get::<Transform>()?.translation;
        let speed = Speed::of(of_world, world);
        let id = of_world.get().and_then(BroadPhaseProxy::id);
        let moving = id.and_then(|id| world.resource::<CollisionIndex>().moving(id));
        let way = if let Some(moving) = moving {
            [0.0, 1.0].map(|time| moving.at(time).translation)
        } else {
            let end = speed
                .frame
                .map_or(own, |frame| frame.position_in_world(own));
            let way = of_world
                .get::<SweptWay>()
                .filter(|way| of_world.contains::<Swept>() && way.belongs_to(body, None));
            let start = way.and_then(SweptWay::start);
            [start.map_or(end, |start| start.translation), end]
        };
        Some(Self::along(way, of_world, speed))
    }

    /// That of an entity on its way in this tick, from its start to its end.
    fn along([start, end]: [Vec3; 2], of_world: EntityRef, speed: Speed) -> Self {
        let Speed { frame, in_world } = speed;
        // What cannot be told in its own space cannot change.
        let leads_back = frame.is_none_or(|frame| frame.leads_back());
        let party = Party {
            velocity: in_world,
            drift: frame.map_or(Vec3::ZERO, |frame| frame.drift()),
            bounce: of_world
                .get::<Bounce>()
                .copied()
                .filter(|_| leads_back && of_world.contains::<Velocity>()),
            reversed: false,
        };
        let swept = of_world.get::<Swept>();
        let steering = match swept {
            Some(swept) if is_moved_by_velocity(of_world) && leads_back => Steering::Own {
                bounces_left: swept.sub_steps,
            },
            _ => Steering::Foreign,
        };
        Self {
            entity: of_world.id(),
            frame,
            lead: None,
            faster: Vec3::ZERO,
            party,
            is_sensor: of_world.contains::<Sensor>(),
            is_swept: swept.is_some() || of_world.contains::<SweptWithBody>(),
            steering,
            stops: swept.is_some_and(|swept| swept.at_solid == AtSolid::Stop),
            stays: false,
            has_ended: false,
            since: 0.0,
            from: start,
            way: end - start,
            version: 0,
            has_turned: false,
            diverted: None,
            bounces: 0,
        }
    }

    /// As that of a body which answers for this one, while this one meets something.
    pub(super) fn led(&self, lead: &Lead, body: &Self) -> Self {
        Self {
            is_sensor: self.is_sensor,
            faster: lead.faster,
            ..*body
        }
    }

    /// The body again, once its part has met it.
    pub(super) const fn alone(self) -> Self {
        Self {
            faster: Vec3::ZERO,
            ..self
        }
    }

    /// Is it that of the shape of a body that answers for its parts, of which there is one, too?
    pub(super) fn is_own_lead(&self) -> bool {
        self.lead.is_some_and(|lead| lead.body == self.entity)
    }

    /// Its velocity as that of a part of a body which has this course.
    pub(super) fn velocity_of_part(&self, lead: &Lead) -> Vec3 {
        self.velocity() + lead.faster
    }

    /// Meets nothing any more in this tick: it has stopped, with its body, though its mover has
    /// moved it on.
    pub(super) const fn end(&mut self) {
        self.has_ended = true;
        self.version += 1;
    }

    /// Its velocity in its own space, as the impacts have made it.
    pub(super) fn own_velocity(&self) -> Option<Vec3> {
        self.frame.map_or(Some(self.party.velocity), |frame| {
            frame.own_velocity(self.party.velocity)
        })
    }

    /// Its velocity in the world, for as long as it moves.
    pub(super) fn velocity(&self) -> Vec3 {
        let of_body = if self.stays {
            Vec3::ZERO
        } else {
            self.party.velocity
        };
        of_body + self.faster
    }

    /// Where it is after a share of the tick.
    pub(super) fn position(&self, time: f32) -> Vec3 {
        self.from + self.way * (time - self.since)
    }

    /// Its way from then on, given that of the whole tick, from which it has its turns.
    pub(super) fn after<'a>(&self, time: f32, whole: &Moving<'a>) -> Moving<'a> {
        whole
            .after(time)
            .along(self.position(time), self.position(1.0))
    }

    /// Is it on another way than at the start of the tick?
    pub(super) const fn is_diverted(&self) -> bool {
        self.is_swept && self.is_moved()
    }

    /// Is it elsewhere at the end of the tick than it would have been?
    pub(super) const fn is_moved(&self) -> bool {
        self.version > 0 && !self.has_ended
    }

    /// Is it on no way, and elsewhere than it would have been?
    pub(super) const fn is_displaced(&self) -> bool {
        !self.is_swept && self.is_moved()
    }

    /// Goes along with what it hangs on, the way of which changes by so much per tick, of so many
    /// seconds. What is not swept counts for the whole tick as where it is at the end of it.
    pub(super) fn carry(&mut self, change: Vec3, time: f32, seconds: f32) {
        let faster = change / seconds;
        if faster.is_finite() {
            self.party.velocity += faster;
            self.party.drift += faster;
            self.frame = self.frame.map(|frame| frame.drifting(faster));
        }
        if self.is_swept {
            (self.from, self.since, self.way) = (self.position(time), time, self.way + change);
        } else {
            self.from += change * (1.0 - time);
        }
        self.version += 1;
    }

    /// Has it bounced as often as it may?
    fn is_spent(&self) -> bool {
        self.party.bounce.is_some() && self.steering == Steering::Own { bounces_left: 0 }
    }

    /// How it takes part in an impact. Who is spent keeps its velocity for the next tick; in this
    /// one, it is a wall at rest. Who does not hear of it goes on as it does.
    fn party(&self, hears: bool) -> Party {
        if !hears {
            Party {
                velocity: self.velocity(),
                ..Party::default()
            }
        } else if self.stays || self.is_spent() {
            Party::default().faster(self.faster)
        } else if self.stops {
            // A wall that comes.
            let party = Party {
                bounce: None,
                ..self.party
            };
            party.faster(self.faster)
        } else {
            self.party.faster(self.faster)
        }
    }

    /// Answers to an impact, given the velocity that it leaves the body with, if that changes.
    fn answer(&mut self, hears: bool, velocity: Option<Vec3>, time: f32, seconds: f32) -> Turn {
        match velocity {
            _ if !hears => Turn::Keeps,
            _ if self.stops => Turn::Keeps,
            _ if self.is_spent() => self.stop(time),
            Some(velocity) => self.bounce(velocity - self.faster, time, seconds),
            None => Turn::Keeps,
        }
    }

    /// Stays where it is for what is left of the tick.
    fn stop(&mut self, time: f32) -> Turn {
        let stayed = std::mem::replace(&mut self.stays, true);
        if stayed || self.way == Vec3::ZERO {
            Turn::Keeps
        } else if self.steering == Steering::Foreign {
            self.end();
            Turn::Ends
        } else {
            self.divert(time, Vec3::ZERO)
        }
    }

    /// Goes by another velocity from now on, or would.
    fn bounce(&mut self, velocity: Vec3, time: f32, seconds: f32) -> Turn {
        self.party.velocity = velocity;
        self.bounces += 1;
        match &mut self.steering {
            Steering::Own { bounces_left } => {
                debug_assert!(*bounces_left > 0, "who is spent stops");
                *bounces_left -= 1;
                self.divert(time, velocity * seconds)
            }
            Steering::Foreign => {
                // It stays on its way, and is reversed once per tick at most.
                self.party.reversed = true;
                Turn::Keeps
            }
        }
    }

    fn divert(&mut self, time: f32, way: Vec3) -> Turn {
        debug_assert!(self.since <= time, "impacts come in the order of time");
        let change = way - self.way;
        (self.from, self.since, self.way) = (self.position(time), time, way);
        self.version += 1;
        self.has_turned = true;
        Turn::Diverts(change)
    }
}

/// Two meet, with the normal from the first to the second: their velocities answer at once, of those
/// that hear of it. Those that are to, stop, if the two come nearer to each other by their ways: of
/// what its mover moves, the velocity says nothing.
pub(super) fn meet(
    [a, b]: [&mut Course; 2],
    hears: [bool; 2],
    contact: &Contact,
    come_nearer: bool,
    (time, seconds): (f32, f32),
) -> [Turn; 2] {
    if a.is_sensor || b.is_sensor {
        return [Turn::Keeps; 2];
    }
    let mut turns = [Turn::Keeps; 2];
    if approach([a.velocity(), b.velocity()], contact.normal) {
        let answers = respond([a.party(hears[0]), b.party(hears[1])], contact.normal);
        turns = [
            a.answer(hears[0], answers[0], time, seconds),
            b.answer(hears[1], answers[1], time, seconds),
        ];
    }
    if come_nearer {
        for ((course, turn), hears) in [a, b].into_iter().zip(&mut turns).zip(hears) {
            if course.stops && hears {
                *turn = course.stop(time);
            }
        }
    }
    turns
}
