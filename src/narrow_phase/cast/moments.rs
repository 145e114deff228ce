//! Two shapes on their way, at single moments.

use bevy::math::Vec3;

use super::moving::Moving;
use crate::narrow_phase::{
    answer::{Contact, Proximity, TimedContact},
    frame::{
        approach::approach,
        case::Case,
        placed::{Placed, PlacedPair},
        separation::Separation,
        two_solids,
        workspace::Workspace,
    },
    settings::NarrowPhase,
};

/// How often an interval is halved in search of a moment.
const HALVINGS: u32 = 10;

/// Two shapes on their way, which can be asked about any moment: a share of the way, 0 to 1.
#[derive(Clone, Copy)]
pub struct Moments<'a> {
    pub tests: &'a NarrowPhase,
    pub a: &'a Moving<'a>,
    pub b: &'a Moving<'a>,
}

impl Moments<'_> {
    /// Asks about the two where they are at a moment.
    fn at<T>(&self, time: f32, ask: impl FnOnce(Placed, Placed) -> T) -> T {
        let Self { a, b, .. } = self;
        ask(
            Placed::new(a.shape(), &a.at(time)),
            Placed::new(b.shape(), &b.at(time)),
        )
    }

    /// How fast, per whole way, the first comes to the second.
    pub fn velocity(&self) -> Vec3 {
        self.a.way() - self.b.way()
    }

    /// How fast, per whole way, the parts of the two that turning moves fastest may come together.
    pub fn turning_speed(&self) -> f32 {
        self.a.turning_speed() + self.b.turning_speed()
    }

    pub fn turn(&self) -> bool {
        self.a.turns() || self.b.turns()
    }

    /// Returns `true` if there is a plane between the two wherever they are apart.
    pub fn are_convex(&self) -> bool {
        [self.a, self.b]
            .iter()
            .all(|moving| moving.shape().kind().is_convex())
    }

    /// The contact at a moment.
    pub fn touch(&self, time: f32, workspace: &mut Workspace) -> Option<TimedContact> {
        let velocity = |point| self.velocity_at(time, point);
        let contact = self.at(time, |a, b| {
            self.tests.contact_in_passing(a, b, velocity, workspace)
        })?;
        Some(TimedContact { time, contact })
    }

    /// The contact of two that no more than touch at a moment, at a point and with a normal that
    /// parts them, or a better one of these.
    pub fn touch_along(
        &self,
        time: f32,
        normal: Vec3,
        point: Vec3,
        workspace: &mut Workspace,
    ) -> TimedContact {
        let velocity = self.velocity_at(time, point);
        let normal = self.at(time, |a, b| {
            self.tests
                .normal_in_passing(a, b, normal, velocity, workspace)
        });
        let contact = Contact {
            normal,
            point,
            depth: 0.0,
        };
        TimedContact { time, contact }
    }

    /// How fast, per whole way, the two come to each other at a point.
    fn velocity_at(&self, time: f32, point: Vec3) -> Vec3 {
        self.a.velocity_at(time, point) - self.b.velocity_at(time, point)
    }

    pub fn touches(&self, time: f32, workspace: &mut Workspace) -> bool {
        self.at(time, |a, b| self.tests.intersects(a, b, workspace))
    }

    /// The normal of a plane that parts two convex solids, from the first to the second, and how far
    /// they are apart along it, if that is quicker to tell than their closest points.
    pub fn parting_plane(&self, time: f32, workspace: &mut Workspace) -> Option<(Vec3, f32)> {
        let case = Case::of(self.a.shape(), self.b.shape());
        let (normal, gap) = self.at(time, |a, b| {
            if !matches!(case, Case::Cuboids | Case::Convex) {
                return None;
            }
            let pair = PlacedPair::new(a, b, self.tests.tolerance()).ok()?;
            if pair.is_large() {
                return None;
            }
            if case == Case::Cuboids {
                let found = Separation::of(&pair.box_a, &pair.box_b, f32::INFINITY)?;
                return Some((found.axis, found.along));
            }
            let [a, b] = two_solids::place_both(&pair, workspace)?;
            Some(two_solids::widest_gap(a, b))
        })?;
        Some((normal.into(), gap))
    }

    pub fn closest_points(&self, time: f32, workspace: &mut Workspace) -> Option<Proximity> {
        self.at(time, |a, b| self.tests.closest_points(a, b, workspace))
    }

    /// Of all normals that part the two, which touch at a moment, the one along which they come
    /// nearer to each other the least.
    pub fn normal_in_passing(&self, time: f32, normal: Vec3, workspace: &mut Workspace) -> Vec3 {
        self.at(time, |a, b| {
            self.tests
                .normal_in_passing(a, b, normal, self.velocity(), workspace)
        })
    }

    /// Between a moment at which the two are in contact and one at which they are not: two such,
    /// close to each other.
    pub fn narrow(&self, times: [f32; 2], workspace: &mut Workspace) -> [f32; 2] {
        (0..HALVINGS).fold(times, |[touching, free], _| {
            let middle = touching.midpoint(free);
            if self.touches(middle, workspace) {
                [middle, free]
            } else {
                [touching, middle]
            }
        })
    }

    /// Returns `true` if the two come nearer to each other where they meet.
    pub fn come_nearer(&self, met: &TimedContact) -> bool {
        let velocities =
            [self.a, self.b].map(|moving| moving.velocity_at(met.time, met.contact.point));
        approach(velocities, met.contact.normal)
    }
}
