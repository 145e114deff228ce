//! When two shapes on their way first meet, and where.
//!
//! The space-time and swept-volume techniques of Cameron (*A Study of the Clash Detection Problem
//! in Robotics*, 1985), which the report names as the cure for objects that pass through each
//! other: without rotation, the first meeting is solved for; with it, it is approached by
//! conservative advancement (Mirtich, *Impulse-based Dynamic Simulation of Rigid Body Systems*,
//! 1996): the two go on for as long as they cannot possibly meet, given their distance and how fast
//! they move and turn, and then look again.

use bevy::math::Vec3;

use super::advance;
use super::lift;
use super::moments::Moments;
use super::moving::Moving;
use super::parting_planes::{self, Answer};
use crate::narrow_phase::{
    answer::{Contact, TimedContact},
    frame::{
        case::Case,
        placed::{Placed, PlacedPair},
        workspace::Workspace,
    },
    length::direction_and_length,
    settings::NarrowPhase,
};

/// So many steps at most lead to a time at which two have parted: doubled, the smallest number
/// there is becomes one after 149, of which the last four take up to 16 where they are cut short.
const MOST_PARTING_STEPS: u32 = 192;

/// No step that leads there is longer, as a share of the way, where two that have parted may come
/// back.
const LONGEST_STEP: f32 = 1.0 / 16.0;

/// Up to so many times their size, a way and a distance are computed as exactly as the size is.
const LONGEST_WAY: f32 = 16.0;

/// So many times at most may two graze each other before they meet.
const MOST_GRAZES: u32 = 8;

impl NarrowPhase {
    /// Returns when two shapes on their way first come into contact, and how they then touch;
    /// `None` if they do not, or anything is not finite.
    ///
    /// Two that are [in contact](Self::intersects) at the start meet at once if they come nearer to
    /// each other. Those that do not, as a body that slides over a floor or leaves it, meet when
    /// they first come to what keeps them from going on: another wall of the same room, say. If there
    /// is nothing, they meet at once if they are in contact at the end too, and else not at all.
    /// Whatever is in contact at the end has met. Two that come apart for less than 1/16 of the way
    /// may count as in contact all along.
    ///
    /// Where two touch so that more than one plane parts them, as edge on edge, the normal is the
    /// one along which they come nearer to each other the least. If that is not at all, as for a
    /// box that slides over the seam of a floor, it is a graze, and a meeting only if none comes
    /// later that stops them.
    ///
    /// Without turns the answer is exact, as that of [`sweep`](Self::sweep); with them it is as
    /// exact as the tolerance, but for two that pass each other within a hair's breadth: of these,
    /// a contact shorter than 1/64 of the way may be missed. Half-spaces and their like have to
    /// stand still, or not turn.
    ///
    /// ```
    /// use bevy::transform::components::Transform;
    /// use bevy_octree::narrow_phase::{Moving, NarrowPhase, Shape, Workspace};
    ///
    /// // Two bullets, head-on, at a thousand times their size.
    /// let bullet = Shape::sphere(0.5);
    /// let (left, right) = (Transform::from_xyz(-500.0, 0.0, 0.0), Transform::from_xyz(500.0, 0.0, 0.0));
    /// let (a, b) = (Moving::new(&bullet, &left, &right), Moving::new(&bullet, &right, &left));
    /// let met = NarrowPhase::default().time_of_impact(&a, &b, &mut Workspace::default()).unwrap();
    /// assert!((met.time - 0.4995).abs() < 1e-6 && met.contact.point.length() < 1e-3);
    /// ```
    #[doc(alias = "ccd")]
    #[doc(alias = "toi")]
    #[doc(alias = "tunneling")]
    #[must_use]
    pub fn time_of_impact(
        &self,
        a: &Moving,
        b: &Moving,
        workspace: &mut Workspace,
    ) -> Option<TimedContact> {
        let moments = Moments { tests: self, a, b };
        if moments.pass_by() {
            return None;
        }
        moments.meeting(MOST_GRAZES, workspace)
    }
}

impl Moments<'_> {
    /// The first meeting that keeps the two from going on, or else the first one: at most so many
    /// grazes are passed over.
    fn meeting(self, grazes: u32, workspace: &mut Workspace) -> Option<TimedContact> {
        match self.by_planes(workspace) {
            // Within the tolerance, or as rounding has it.
            Some(None) => return self.touch(1.0, workspace),
            Some(met) => return met,
            None => {}
        }
        let mut free_from = 0.0;
        if let Some(met) = self.touch(0.0, workspace) {
            if self.come_nearer(&met) {
                return Some(met);
            }
            if !self.are_convex() {
                return self.meeting_off(met, grazes, workspace);
            }
            match self.parted(workspace) {
                Some(time) => free_from = time,
                None => return Some(met),
            }
        }
        let turn = self.turn();
        let mut on_the_way = None;
        if !turn {
            let (a, b) = (self.a.after(free_from), self.b.after(free_from));
            let rest = Moments {
                a: &a,
                b: &b,
                ..self
            };
            on_the_way = rest.straight(workspace).map(|met| met.after(free_from));
        }
        // Parry does not find every impact.
        if turn
            || (on_the_way.is_none() && Case::of(self.a.shape(), self.b.shape()) == Case::Foreign)
        {
            on_the_way = advance::first_meeting(self, free_from, workspace);
        }
        // Within the tolerance, or as rounding has it.
        let met = on_the_way.or_else(|| self.touch(1.0, workspace))?;
        // Two convex shapes that pass each other on two sides of a plane do not meet again, but for
        // turns.
        let goes_on = turn || !self.are_convex();
        if goes_on && grazes > 0 && met.time < 1.0 && !self.come_nearer(&met) {
            let (a, b) = (self.a.after(met.time), self.b.after(met.time));
            let rest = Moments {
                a: &a,
                b: &b,
                ..self
            };
            let later = rest
                .meeting(grazes - 1, workspace)
                .filter(|later| rest.come_nearer(later));
            return later.map(|later| later.after(met.time)).or(Some(met));
        }
        Some(met)
    }

    /// The first meeting that keeps two from going on that touch at the start and may go on, as a
    /// body that slides over the floor of a room: it is lifted off what it touches, and met is then
    /// what comes, whether it goes on touching the first or not. Once the two have parted, what
    /// counts is the way that they go, of which that of one lifted out of a deep overlap says
    /// nothing.
    fn meeting_off(
        self,
        met: TimedContact,
        grazes: u32,
        workspace: &mut Workspace,
    ) -> Option<TimedContact> {
        let margin = lift::margin(self.tests, self.a.start.translation);
        let (mut lifted, mut touch) = (*self.a, met);
        let (mut overlap, mut ahead) = (0.0, None);
        for _ in 0..lift::MOST_LIFTS {
            let Contact { normal, depth, .. } = touch.contact;
            overlap += depth;
            lifted = lifted.beside(-normal * (depth + margin));
            let rest = Moments { a: &lifted, ..self };
            match rest.touch(0.0, workspace) {
                // Of several that it touches, one that it goes into.
                Some(next) if rest.come_nearer(&next) => return Some(next),
                Some(next) => touch = next,
                None => {
                    ahead = rest
                        .meeting(grazes, workspace)
                        .filter(|later| rest.come_nearer(later));
                    break;
                }
            }
        }
        if overlap > margin
            && let Some(grazes) = grazes.checked_sub(1)
            && let Some(parted) = self.parted_before(ahead, workspace)
        {
            let (a, b) = (self.a.after(parted), self.b.after(parted));
            let rest = Moments {
                a: &a,
                b: &b,
                ..self
            };
            let later = rest.meeting(grazes, workspace);
            return later.map(|later| later.after(parted));
        }
        // All the way along what it touches, or off it.
        ahead.or_else(|| self.touches(1.0, workspace).then_some(met))
    }

    /// A moment at which two that overlap at the start have parted, if that is before they meet, on
    /// a way beside theirs, what is ahead.
    fn parted_before(&self, ahead: Option<TimedContact>, workspace: &mut Workspace) -> Option<f32> {
        let parted = self.parted(workspace);
        match ahead {
            Some(ahead) if parted.is_none_or(|parted| ahead.time <= parted) => {
                (!self.touches(ahead.time, workspace)).then_some(ahead.time)
            }
            _ => parted,
        }
    }

    /// A moment at which two that are in contact at the start have parted, soon after they did.
    /// `None` if they do not.
    fn parted(&self, workspace: &mut Workspace) -> Option<f32> {
        let speed = self.velocity().length() + self.a.turning_speed() + self.b.turning_speed();
        let (mut last, mut time) = (0.0, 4.0 * self.tests.tolerance() / speed);
        let longest = if self.turn() || !self.are_convex() {
            LONGEST_STEP
        } else {
            1.0
        };
        for _ in 0..MOST_PARTING_STEPS {
            // Not if nothing moves, nor if something is not finite.
            if !(time > 0.0 && time.is_finite() && last < 1.0) {
                break;
            }
            let now = time.min(1.0);
            if !self.touches(now, workspace) {
                // Those that begin to part at once, as after a bounce, have not gone far.
                return Some(if last == 0.0 {
                    now
                } else {
                    self.narrow([last, now], workspace)[1]
                });
            }
            last = now;
            // Two convex shapes that part do not come back, but for turns.
            time += time.min(longest);
        }
        None
    }

    /// The first meeting of two convex solids that do not turn, if there is one, by the planes that
    /// may part them. `None` if these do not tell, or not all the way: of others, of those that are
    /// in touch at the start, and over a way on which rounding counts.
    fn by_planes(&self, workspace: &mut Workspace) -> Option<Option<TimedContact>> {
        let Self { tests, a, b } = self;
        if self.turn() || !matches!(Case::of(a.shape(), b.shape()), Case::Cuboids | Case::Convex) {
            return None;
        }
        let (moving, target) = (
            Placed::new(a.shape(), &a.start),
            Placed::new(b.shape(), &b.start),
        );
        let pair = PlacedPair::new(moving, target, tests.tolerance()).ok()?;
        let (direction, distance) = direction_and_length(self.velocity())?;
        let longest = LONGEST_WAY * pair.size;
        let offset = pair.box_b.center - pair.box_a.center;
        if pair.is_large() || distance > longest || offset.length() > longest {
            return None;
        }
        match parting_planes::first_impact(&pair, Vec3::from(direction).into(), distance, workspace)
        {
            Answer::Apart => Some(None),
            Answer::Met(met) => {
                let time = (met.distance / distance).min(1.0);
                let point = a.start.translation + Vec3::from(met.point) + b.way() * time;
                let normal = self.normal_in_passing(time, (-met.normal).into(), workspace);
                let contact = Contact {
                    normal,
                    point,
                    depth: 0.0,
                };
                Some(Some(TimedContact { time, contact }))
            }
            Answer::Unknown => None,
        }
    }

    /// The first meeting of two that do not turn, and are apart at the start: as one of them sees it, the other comes along a
    /// line.
    fn straight(&self, workspace: &mut Workspace) -> Option<TimedContact> {
        let Self { tests, a, b } = self;
        let (direction, distance) = direction_and_length(self.velocity())?;
        let (moving, target) = (
            Placed::new(a.shape(), &a.start),
            Placed::new(b.shape(), &b.start),
        );
        let impact = tests.sweep_from(true, moving, direction, distance, target, workspace)?;
        let time = (impact.distance / distance).min(1.0);
        let point = impact.point + b.way() * time;
        let normal = self.normal_in_passing(time, -impact.normal, workspace);
        Some(TimedContact {
            time,
            contact: Contact {
                normal,
                point,
                depth: 0.0,
            },
        })
    }
}

#[cfg(test)]
mod tests;
