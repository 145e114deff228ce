//! When two shapes on their way first meet, and where.
//!
//! The space-time and swept-volume techniques of Cameron (*A Study of the Clash Detection Problem in Robotics*, 1985),
//! which the report names as the cure for objects that pass through each other: without rotation, the first meeting is
//! solved for; with it, it is approached by conservative advancement (Mirtich, *Impulse-based Dynamic Simulation of Rigid
//! Body Systems*, 1996): the two go on for as long as they cannot possibly meet, given their distance and how fast they
//! move and turn, and then look again.

use bevy::math::Vec3;
use bevy::math::bounding::{Aabb3d, BoundingVolume};
use bevy::transform::components::Transform;

use crate::narrow_phase::{
    answer::Contact,
    error::BoundsError,
    frame::{
        approach::approach,
        oriented_box::OrientedBox,
        placed::{Pair, Placed},
        workspace::Workspace,
    },
    length::direction_and_length,
    settings::NarrowPhase,
    shape::Shape,
};

/// So often may two that turn look how far they are from each other; after that, they go on by steps of no less than
/// [`LEAST_STEP`] of the way that is left.
const LOOKS: u32 = 64;

/// So often do they look at most. What is left of the way is gone long before, for no step is less than the next number.
const MOST_LOOKS: u32 = 4 * LOOKS;

/// So many steps at most lead to a time at which two have parted: doubled, the smallest number there is becomes one after
/// 149.
const MOST_PARTING_STEPS: u32 = 192;

/// See [`LOOKS`]: it is two that pass each other within a hair's breadth that get there.
const LEAST_STEP: f32 = 1.0 / 64.0;

/// So many times at most may two graze each other before they meet.
const MOST_GRAZES: u32 = 8;

/// The longest step, as a share of the way, in search of a moment at which two have parted that may soon meet again.
const LONGEST_STEP: f32 = 1.0 / 16.0;

/// How often an interval is halved in search of a moment.
const HALVINGS: u32 = 10;

/// A shape on its way: from one place to another in a straight line, at constant speed, turning at a constant rate by
/// the shorter way.
///
/// Its size is that which it has at the end, all the way.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    shape: &'a Shape,
    start: Transform,
    end: Transform,
}

/// Two shapes on their way meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedContact {
    /// The share of the way after which they do, 0 to 1.
    pub time: f32,
    /// Where they then touch.
    pub contact: Contact,
}

impl TimedContact {
    /// The contact on what was left of a way after a share of it, by the time of the whole way.
    pub(crate) fn after(self, time: f32) -> Self {
        Self { time: time + self.time * (1.0 - time), ..self }
    }
}

impl<'a> Moving<'a> {
    /// From `start` to `end`.
    #[must_use]
    pub fn new(shape: &'a Shape, start: &Transform, end: &Transform) -> Self {
        Self { shape, start: start.with_scale(end.scale), end: *end }
    }

    /// At rest.
    #[must_use]
    pub fn resting(placed: Placed<'a>) -> Self {
        Self::new(placed.shape, placed.transform, placed.transform)
    }

    /// What is on its way.
    #[must_use]
    pub const fn shape(&self) -> &'a Shape {
        self.shape
    }

    /// Where the shape is after a share of its way, 0 to 1.
    #[must_use]
    pub fn at(&self, time: f32) -> Transform {
        let rotation =
            if self.turns() { self.start.rotation.slerp(self.end.rotation, time) } else { self.end.rotation };
        Transform { translation: self.start.translation + self.way() * time, rotation, scale: self.end.scale }
    }

    /// From the start to the end, but for turns.
    fn way(&self) -> Vec3 {
        self.end.translation - self.start.translation
    }

    fn turns(&self) -> bool {
        self.start.rotation != self.end.rotation
    }

    /// What is left of the way after a share of it.
    pub(crate) fn after(&self, time: f32) -> Self {
        Self { start: self.at(time), ..*self }
    }

    /// Turning as it does, on another way.
    pub(crate) fn along(self, from: Vec3, to: Vec3) -> Self {
        let (start, end) = (Transform { translation: from, ..self.start }, Transform { translation: to, ..self.end });
        Self { start, end, ..self }
    }

    /// The axis about which it turns, in its origin, times the angle in radians.
    fn turn(&self) -> Vec3 {
        if !self.turns() {
            return Vec3::ZERO;
        }
        let turn = self.end.rotation.normalize() * self.start.rotation.normalize().inverse();
        let shorter = if turn.w < 0.0 { -turn } else { turn };
        shorter.to_scaled_axis()
    }

    /// How fast, per whole way, the part of it moves that turning moves fastest; infinite if it has no end.
    fn turning_speed(&self) -> f32 {
        if self.turns() { self.turn().length() * self.reach().unwrap_or(f32::INFINITY) } else { 0.0 }
    }

    /// How fast, per whole way, a point moves that is part of the shape after a share of it.
    pub(crate) fn velocity_at(&self, time: f32, point: Vec3) -> Vec3 {
        self.way() + self.turn().cross(point - self.at(time).translation)
    }

    /// How far the shape reaches from the point about which it turns.
    fn reach(&self) -> Result<f32, BoundsError> {
        let around_origin = OrientedBox::of(self.shape, &self.end, self.end.translation)?;
        Ok(around_origin.center.length() + around_origin.radius)
    }
}

/// # On the way
impl NarrowPhase {
    /// The box to feed to a broad phase for all of a shape's way: see [`world_aabb`](Self::world_aabb). The smallest one if
    /// the shape does not turn.
    ///
    /// # Errors
    /// As for [`Shape::world_aabb`].
    pub fn swept_aabb(&self, moving: &Moving) -> Result<Aabb3d, BoundsError> {
        // Whatever a shape turns through is in a ball around the point that it turns about.
        let ball = if moving.turns() { Some(Shape::Sphere { radius: moving.reach()? }) } else { None };
        let aabb = |at: &Transform| match &ball {
            Some(ball) => self.world_aabb(Placed::new(ball, &Transform::from_translation(at.translation))),
            None => self.world_aabb(Placed::new(moving.shape, at)),
        };
        Ok(aabb(&moving.start)?.merge(&aabb(&moving.end)?))
    }

    /// When two shapes on their way first come into contact, and how they then touch; `None` if they do not, or anything is
    /// not finite.
    ///
    /// Two that are [in contact](Self::intersects) at the start meet at once if they come nearer to each other, and if they
    /// stay in contact to the end; those that part count from then on, if they are apart for more than 1/16 of the way or
    /// do so at once. Whatever is in contact at the end has met.
    ///
    /// Where two touch so that more than one plane parts them, as edge on edge, the normal is the one along which they come
    /// nearer to each other the least. If that is not at all, as for a box that slides over the seam of a floor, it is a
    /// graze, and a meeting only if none comes later that stops them.
    ///
    /// Without turns the answer is exact, as that of [`sweep`](Self::sweep); with them it is as exact as the tolerance, but
    /// for two that pass each other within a hair's breadth: of these, a contact shorter than 1/64 of the way may be missed.
    /// Half-spaces and their like have to stand still, or not turn.
    ///
    /// ```
    /// use bevy::transform::components::Transform;
    /// use bevy_octree::narrow_phase::{Moving, NarrowPhase, Shape, Workspace};
    ///
    /// // Two bullets, head-on, at a thousand times their size.
    /// let bullet = Shape::sphere(0.5)?;
    /// let (left, right) = (Transform::from_xyz(-500.0, 0.0, 0.0), Transform::from_xyz(500.0, 0.0, 0.0));
    /// let (a, b) = (Moving::new(&bullet, &left, &right), Moving::new(&bullet, &right, &left));
    /// let met = NarrowPhase::default().time_of_impact(&a, &b, &mut Workspace::default()).unwrap();
    /// assert!((met.time - 0.4995).abs() < 1e-6 && met.contact.point.length() < 1e-3);
    /// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
    /// ```
    #[must_use]
    pub fn time_of_impact(&self, a: &Moving, b: &Moving, workspace: &mut Workspace) -> Option<TimedContact> {
        self.meeting(a, b, MOST_GRAZES, workspace)
    }

    /// The first meeting that keeps the two from going on, or else the first one: at most so many grazes are passed over.
    fn meeting(&self, a: &Moving, b: &Moving, grazes: u32, workspace: &mut Workspace) -> Option<TimedContact> {
        let mut free_from = 0.0;
        if let Some(met) = self.touch(a, b, 0.0, workspace) {
            if comes_nearer(a, b, &met) {
                return Some(met);
            }
            match self.parted(a, b, workspace) {
                Some(time) => free_from = time,
                None => return Some(met),
            }
        }
        let turn = a.turns() || b.turns();
        let mut on_the_way = None;
        if !turn {
            on_the_way =
                self.straight(&a.after(free_from), &b.after(free_from), workspace).map(|met| met.after(free_from));
        }
        // Parry does not find every impact.
        if turn || (on_the_way.is_none() && !(is_own(a.shape) && is_own(b.shape))) {
            on_the_way = self.advance(a, b, free_from, workspace);
        }
        // Within the tolerance, or as rounding has it.
        let met = on_the_way.or_else(|| self.touch(a, b, 1.0, workspace))?;
        // Two convex shapes that pass each other on two sides of a plane do not meet again, but for turns.
        let goes_on = turn || !(is_convex(a.shape) && is_convex(b.shape));
        if goes_on && grazes > 0 && met.time < 1.0 && !comes_nearer(a, b, &met) {
            let (a, b) = (a.after(met.time), b.after(met.time));
            let later = self.meeting(&a, &b, grazes - 1, workspace).filter(|later| comes_nearer(&a, &b, later));
            return later.map(|later| later.after(met.time)).or(Some(met));
        }
        Some(met)
    }

    /// The contact after a share of the way.
    fn touch(&self, a: &Moving, b: &Moving, time: f32, workspace: &mut Workspace) -> Option<TimedContact> {
        let velocity = |point| a.velocity_at(time, point) - b.velocity_at(time, point);
        let contact = at_once(a, b, time, |a, b| self.contact_in_passing(a, b, velocity, workspace))?;
        Some(TimedContact { time, contact })
    }

    fn touches(&self, a: &Moving, b: &Moving, time: f32, workspace: &mut Workspace) -> bool {
        at_once(a, b, time, |a, b| self.intersects(a, b, workspace))
    }

    /// Between a time at which the two are in contact and one at which they are not: two such times, close to each other.
    fn narrow(&self, a: &Moving, b: &Moving, times: [f32; 2], workspace: &mut Workspace) -> [f32; 2] {
        (0..HALVINGS).fold(times, |[touching, free], _| {
            let middle = touching.midpoint(free);
            if self.touches(a, b, middle, workspace) { [middle, free] } else { [touching, middle] }
        })
    }

    /// A time at which two that are in contact at the start have parted, soon after they did. `None` if they do not.
    fn parted(&self, a: &Moving, b: &Moving, workspace: &mut Workspace) -> Option<f32> {
        let speed = (a.way() - b.way()).length() + a.turning_speed() + b.turning_speed();
        // Two convex shapes that part do not come back, but for turns.
        let longest = if is_convex(a.shape) && is_convex(b.shape) { 1.0 } else { LONGEST_STEP };
        let (mut last, mut time) = (0.0, 4.0 * self.tolerance() / speed);
        for _ in 0..MOST_PARTING_STEPS {
            // Not if nothing moves, nor if something is not finite.
            if !(time > 0.0 && time.is_finite() && last < 1.0) {
                break;
            }
            let now = time.min(1.0);
            if !self.touches(a, b, now, workspace) {
                // Those that begin to part at once, as after a bounce, have not gone far.
                return Some(if last == 0.0 { now } else { self.narrow(a, b, [last, now], workspace)[1] });
            }
            last = now;
            time += time.min(longest);
        }
        None
    }

    /// The first meeting of two that do not turn: as one of them sees it, the other comes along a line.
    fn straight(&self, a: &Moving, b: &Moving, workspace: &mut Workspace) -> Option<TimedContact> {
        let (direction, distance) = direction_and_length(a.way() - b.way())?;
        let (moving, target) = (Placed::new(a.shape, &a.start), Placed::new(b.shape, &b.start));
        let impact = self.sweep(moving, direction, distance, target, workspace)?;
        let time = (impact.distance / distance).min(1.0);
        let point = impact.point + b.way() * time;
        let velocity = a.way() - b.way();
        let normal = at_once(a, b, time, |a, b| self.normal_in_passing(a, b, -impact.normal, velocity, workspace));
        Some(TimedContact { time, contact: Contact { normal, point, depth: 0.0 } })
    }

    /// The first meeting of two of which one turns, which are apart at `from`: by conservative advancement.
    fn advance(&self, a: &Moving, b: &Moving, from: f32, workspace: &mut Workspace) -> Option<TimedContact> {
        let velocity = a.way() - b.way();
        let turning = a.turning_speed() + b.turning_speed();
        // Between two convex shapes that are apart there is a plane, and what counts is how fast they come to it.
        let have_plane = is_convex(a.shape) && is_convex(b.shape);
        let placed = [Placed::new(a.shape, &a.end), Placed::new(b.shape, &b.end)];
        let tolerance =
            Pair::new(placed[0], placed[1], self.tolerance()).map_or(self.tolerance(), |pair| pair.tolerance);
        let (mut last, mut time) = (from, from);
        // Was the last step longer than was safe?
        let mut hurried = false;
        for looks in 0..MOST_LOOKS {
            if time > 1.0 {
                break;
            }
            let near = at_once(a, b, time, |a, b| self.closest_points(a, b, workspace));
            let touching = match near {
                Some(near) => near.distance <= tolerance,
                // Parry does not always find an answer.
                None => self.touches(a, b, time, workspace),
            };
            if touching {
                let time = if hurried { self.narrow(a, b, [time, last], workspace)[0] } else { time };
                let direction = near.and_then(|near| near.offset.try_normalize()).unwrap_or(Vec3::Y);
                let point = near.map_or(b.at(time).translation, |near| near.points[1]);
                let at_tolerance = TimedContact { time, contact: Contact { normal: direction, point, depth: 0.0 } };
                return Some(self.touch(a, b, time, workspace).unwrap_or(at_tolerance));
            }
            let mut free = 0.0;
            if let Some(near) = near {
                let towards = velocity.dot(near.offset / near.distance);
                let closing = turning + if have_plane { towards } else { velocity.length() };
                free = (near.distance - 0.5 * tolerance) / closing;
                if closing <= 0.0 || !free.is_finite() {
                    return None;
                }
            }
            let hurry = looks >= LOOKS || near.is_none();
            let least = if hurry { LEAST_STEP * (1.0 - from) } else { 0.0 };
            // A step that rounding swallows is none: the next number is the least.
            let step = free.max(least).max(time.next_up() - time);
            hurried = free < step;
            (last, time) = (time, time + step);
        }
        None
    }
}

/// Asks about the two where they are after a share of their ways.
fn at_once<T>(a: &Moving, b: &Moving, time: f32, ask: impl FnOnce(Placed, Placed) -> T) -> T {
    ask(Placed::new(a.shape, &a.at(time)), Placed::new(b.shape, &b.at(time)))
}

/// Is there a plane between this shape and any other such that is apart from it?
fn is_convex(shape: &Shape) -> bool {
    matches!(shape, Shape::Cuboid { .. } | Shape::Sphere { .. } | Shape::Convex(_))
}

/// Is it a shape of ours?
fn is_own(shape: &Shape) -> bool {
    is_convex(shape) || matches!(shape, Shape::Mesh(_))
}

/// Do the two come nearer to each other where they meet?
fn comes_nearer(a: &Moving, b: &Moving, met: &TimedContact) -> bool {
    approach([a, b].map(|moving| moving.velocity_at(met.time, met.contact.point)), met.contact.normal)
}

#[cfg(test)]
mod tests;
