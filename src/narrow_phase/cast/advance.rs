//! Conservative advancement: two of which one turns go on for as long as they cannot possibly meet.

use bevy::math::Vec3;

use super::moments::Moments;
use crate::narrow_phase::{
    answer::{Contact, Proximity, TimedContact},
    frame::{
        placed::{Placed, PlacedPair},
        workspace::Workspace,
    },
    shape::Kind,
    support,
};

/// So often may two that turn look how far they are from each other; after that, they go on by
/// steps of no less than [`LEAST_STEP`] of the way that is left.
const LOOKS: u32 = 64;

/// So often do they look at most. What is left of the way is gone long before, for no step is less
/// than the next number.
const MOST_LOOKS: u32 = 4 * LOOKS;

/// See [`LOOKS`]: it is two that pass each other within a hair's breadth that get there.
const LEAST_STEP: f32 = 1.0 / 64.0;

/// Two that are further apart than so many tolerances along the normal of a plane, are not in
/// contact, whatever rounding makes of it.
const WIDE: f32 = 4.0;

/// The first meeting of two of which one turns, which are apart at `from`.
pub fn first_meeting(
    moments: Moments,
    from: f32,
    workspace: &mut Workspace,
) -> Option<TimedContact> {
    let mut advance = Advance::new(moments, from);
    while advance.looks < MOST_LOOKS && advance.time <= 1.0 {
        match advance.step(workspace) {
            Look::Apart => {}
            Look::Parting => return None,
            Look::Touching(near) => return Some(advance.meeting(near, workspace)),
        }
    }
    None
}

/// Two on their way, from one moment to the next.
struct Advance<'a> {
    moments: Moments<'a>,
    /// How fast the first comes to the second, per whole way, but for turns.
    velocity: Vec3,
    /// How much faster turns may bring the two together.
    turning: f32,
    /// Between two convex shapes that are apart there is a plane, and what counts is how fast they
    /// come to it.
    have_plane: bool,
    /// At least what rounding leaves uncertain at the size of the two.
    tolerance: f32,
    /// When it begins.
    from: f32,
    /// The moment that is looked at next; the two have not met before, or not for long.
    time: f32,
    /// The moment before that one, at which the two were apart.
    last: f32,
    /// How often they have looked.
    looks: u32,
    /// The last step was longer than was safe: the two may have met on it.
    overshot: bool,
}

/// What a look at a moment says.
enum Look {
    /// They are apart; there is a next moment.
    Apart,
    /// They are apart, and will be.
    Parting,
    /// They are in contact. How near they are, where that is known.
    Touching(Option<Proximity>),
}

impl<'a> Advance<'a> {
    fn new(moments: Moments<'a>, from: f32) -> Self {
        let [a, b] = [moments.a, moments.b].map(|moving| Placed::new(moving.shape(), &moving.end));
        let tolerance = moments.tests.tolerance();
        Self {
            moments,
            velocity: moments.velocity(),
            turning: moments.turning_speed(),
            have_plane: moments.are_convex(),
            tolerance: PlacedPair::new(a, b, tolerance).map_or(tolerance, |pair| pair.tolerance),
            from,
            time: from,
            last: from,
            looks: 0,
            overshot: false,
        }
    }

    /// Looks how far the two are from each other, and goes on to the moment up to which they cannot
    /// meet.
    fn step(&mut self, workspace: &mut Workspace) -> Look {
        if let Some((normal, gap)) = self.moments.parting_plane(self.time, workspace)
            && gap > WIDE * self.tolerance
        {
            return match self.free_time(normal, gap) {
                Some(free) => {
                    self.go_on(free, false);
                    Look::Apart
                }
                None => Look::Parting,
            };
        }
        let near = self.moments.closest_points(self.time, workspace);
        let touching = match &near {
            Some(near) => near.distance <= self.tolerance,
            // Parry does not always find an answer.
            None => self.moments.touches(self.time, workspace),
        };
        if touching {
            return Look::Touching(near);
        }
        let free = match &near {
            Some(near) => match self.free_time(near.offset / near.distance, near.distance) {
                Some(free) => free,
                None => return Look::Parting,
            },
            None => 0.0,
        };
        self.go_on(free, near.is_none());
        Look::Apart
    }

    /// Goes on for as long as the two are known to be apart, or for longer in a hurry.
    fn go_on(&mut self, free: f32, hurries: bool) {
        let least = if hurries || self.looks >= LOOKS {
            LEAST_STEP * (1.0 - self.from)
        } else {
            0.0
        };
        // A step that rounding swallows is none: the next number is the least.
        let step = free.max(least).max(self.time.next_up() - self.time);
        self.overshot = free < step;
        (self.last, self.time) = (self.time, self.time + step);
        self.looks += 1;
    }

    /// For how long two cannot meet that are so far apart along a normal, which of two that are not
    /// convex is that of their closest points; `None` if they never do.
    fn free_time(&self, normal: Vec3, gap: f32) -> Option<f32> {
        let closing = self.turning
            + if self.have_plane {
                self.velocity.dot(normal)
            } else {
                self.velocity.length()
            };
        let free = (gap - 0.5 * self.tolerance) / closing;
        (closing > 0.0 && free.is_finite()).then_some(free)
    }

    /// Is one of them of Rapier's, and not as one of ours?
    fn is_foreign(&self) -> bool {
        [self.moments.a, self.moments.b].iter().any(|moving| {
            let placed = Placed::new(moving.shape(), &moving.end);
            placed.shape.kind() == Kind::Foreign && support::as_own(placed).is_none()
        })
    }

    /// How the two meet that are in contact at the moment, or were since the last one.
    fn meeting(&self, near: Option<Proximity>, workspace: &mut Workspace) -> TimedContact {
        debug_assert!(self.last <= self.time, "{} {}", self.last, self.time);
        let (time, near) = if self.overshot {
            let [touching, free] = self.moments.narrow([self.time, self.last], workspace);
            (touching, self.moments.closest_points(free, workspace))
        } else {
            (self.time, near)
        };
        let touch = self.moments.touch(time, workspace);
        // Two that have just met do not overlap. The normal of a contact of meshes may be one along
        // which they do, and says nothing about whether they come nearer to each other. Parry's
        // closest points are too far off to tell a better one.
        if let Some(touch) = touch
            && (touch.contact.depth <= self.tolerance || self.is_foreign())
        {
            return touch;
        }
        let parting = near.and_then(|near| Some((near.offset.try_normalize()?, near.points[1])));
        if let Some((normal, point)) = parting {
            return self.moments.touch_along(time, normal, point, workspace);
        }
        touch.unwrap_or_else(|| {
            // Within the tolerance, but for rounding.
            let contact = Contact {
                normal: Vec3::Y,
                point: self.moments.b.at(time).translation,
                depth: 0.0,
            };
            TimedContact { time, contact }
        })
    }
}
