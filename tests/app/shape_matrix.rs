//! All pairs of shapes by all exact tests, each answer with a certificate in 64-bit numbers.
//!
//! No other algorithm is asked: that a point is in a convex shape, and how far that reaches along a
//! direction, is known of each by a formula; all others consist of such. Two points in two shapes
//! say that these are no further apart; planes between all of what they consist of, that they are
//! no nearer to each other. What is asked about ways and rays has to agree with the distances.

pub(crate) mod known;
mod limits;
mod whole;

use bevy::{
    math::{DVec3, Dir3},
    prelude::*,
};
use bevy_octree::narrow_phase::{
    BoundsError, Contact, Moving, NarrowPhase, Passage, Placed, Proximity, Shape, Workspace,
};
use fastrand::Rng;

use known::{PartAt, directions, gap};
pub(crate) use known::{kinds, pose};
use whole::{At, Depth, Whole, wholes};

/// Poses for each pair.
pub(crate) const ROUNDS: usize = 24;
/// The same where one does not consist of a single convex shape.
const WHOLE_ROUNDS: usize = 10;
/// How far off a distance may be, as a share of the sizes.
const EXACT: f64 = 1e-5;
/// The same of depths.
const DEEP: f64 = 2e-5;
/// The same of depths of two that have faces, whose normals are preferred to others that are hardly
/// better.
const DEEP_OF_FACES: f64 = 1e-3;

const PARTS: &str = "of the deepest parts";

#[derive(Debug, Default)]
struct Tally {
    apart: u32,
    together: u32,
    swept: u32,
    met: u32,
    hit: u32,
    left: u32,
    outside: u32,
}

/// Two in their places, and what they are asked with.
struct Pair<'a> {
    a: &'a At<'a>,
    b: &'a At<'a>,
    tests: NarrowPhase,
    /// How far off a distance may be.
    exact: f64,
    /// How far off a depth may be.
    deep: f64,
    size: f64,
}

impl<'a> Pair<'a> {
    fn new(a: &'a At, b: &'a At) -> Self {
        let tests = NarrowPhase::default();
        let size = a.size() + b.size();
        let exact = EXACT * size + f64::from(tests.tolerance());
        let have_faces = [a, b]
            .iter()
            .all(|at| at.parts.iter().any(PartAt::has_faces));
        let deep = if have_faces { DEEP_OF_FACES } else { DEEP };
        Self {
            a,
            b,
            tests,
            exact,
            deep: deep * size.min(20.0) + exact,
            size,
        }
    }

    fn what(&self) -> String {
        let Self { a, b, .. } = self;
        format!(
            "{} {:?}\n{} {:?}",
            a.whole.name, a.transform, b.whole.name, b.transform
        )
    }

    fn are_convex(&self) -> bool {
        self.a.is_convex() && self.b.is_convex()
    }

    fn near(&self, workspace: &mut Workspace) -> Option<Proximity> {
        let (a, b) = (self.a.placed(), self.b.placed());
        let near = self.tests.closest_points(a, b, workspace);
        let back = self.tests.closest_points(b, a, workspace);
        assert_eq!(near.is_some(), back.is_some(), "{}", self.what());
        let (near, back) = (near?, back?);
        assert_eq!(
            (near.distance, near.points[0], near.points[1], near.offset),
            (back.distance, back.points[1], back.points[0], -back.offset),
            "{}",
            self.what()
        );
        Some(near)
    }

    /// Where they are in contact, which they are if and only if they intersect.
    fn contact(&self, workspace: &mut Workspace) -> Option<Contact> {
        let Self { a, b, tests, .. } = self;
        let (a, b) = (a.placed(), b.placed());
        let contact = tests.contact(a, b, workspace);
        for meets in [
            tests.intersects(a, b, workspace),
            tests.intersects(b, a, workspace),
            tests.manifold(a, b, workspace).is_some(),
        ] {
            assert_eq!(meets, contact.is_some(), "{}", self.what());
        }
        let back = tests.contact(b, a, workspace).map(Contact::reversed);
        assert_eq!(contact, back, "{}", self.what());
        contact
    }

    /// Two half-spaces: nothing is known of them, and nothing is said.
    fn check_endless(&self, workspace: &mut Workspace) {
        let Self { a, b, tests, .. } = self;
        assert_eq!(self.contact(workspace), None, "{}", self.what());
        assert_eq!(self.near(workspace), None, "{}", self.what());
        let hit = tests.sweep(a.placed(), Dir3::X, 10.0, b.placed(), workspace);
        assert_eq!(hit, None, "{}", self.what());
    }

    fn check(&self, around: &[DVec3], rng: &mut Rng, tally: &mut Tally) {
        let mut workspace = Workspace::default();
        if !self.a.has_end() && !self.b.has_end() {
            return self.check_endless(&mut workspace);
        }
        let contact = self.contact(&mut workspace);
        let near = self.near(&mut workspace).expect("all is known");
        for (at, point) in [self.a, self.b].iter().zip(near.points) {
            let excess = at.excess(point.as_dvec3(), around);
            let exact = self.exact;
            assert!(
                excess <= exact,
                "{point} is {excess} outside\n{}",
                self.what()
            );
        }
        if near.distance > 0.0 {
            tally.apart += 1;
            self.check_apart(&near, &mut workspace);
            let is_sure = f64::from(near.distance) > self.exact;
            assert!(
                contact.is_none() || !is_sure,
                "{} apart\n{}",
                near.distance,
                self.what()
            );
        } else {
            tally.together += 1;
            assert!(contact.is_some(), "{}", self.what());
        }
        if let Some(contact) = contact {
            self.check_contact(&contact, around, &mut workspace);
        }
        self.check_sweep(rng, tally, &mut workspace);
        self.check_turn(rng, tally, &mut workspace);
    }

    /// There is a plane between each two of what they consist of.
    fn check_apart(&self, near: &Proximity, workspace: &mut Workspace) {
        let distance = f64::from(near.distance);
        let [from, to] = near.points.map(Vec3::as_dvec3);
        assert!((to - from).length() <= distance + self.exact);
        // The shorter a vector of 32-bit numbers is, the less is known of its direction.
        let doubt = |distance: f64| 5e-7 * self.size * self.size / distance;
        let normal = near.offset.as_dvec3().normalize();
        for part_a in &self.a.parts {
            for part_b in &self.b.parts {
                let least = distance - self.exact - doubt(distance);
                if gap(part_a, part_b, normal) >= least {
                    continue;
                }
                let (a, b) = (part_a.placed(), part_b.placed());
                let found = self.tests.closest_points(a, b, workspace).unwrap();
                let normal = found.offset.as_dvec3().normalize_or_zero();
                let apart = gap(part_a, part_b, normal);
                assert!(
                    apart >= least,
                    "{distance} apart, {apart} for certain\n{}",
                    self.what()
                );
            }
        }
    }

    fn check_contact(&self, contact: &Contact, around: &[DVec3], workspace: &mut Workspace) {
        let Self { a, b, deep, .. } = *self;
        let normal = contact.normal.as_dvec3();
        let depth = f64::from(contact.depth);
        assert!((normal.length() - 1.0).abs() < 1e-5, "{}", self.what());
        assert!(depth >= 0.0 && depth.is_finite(), "{}", self.what());
        let depths = [a.whole.depth, b.whole.depth];
        let is_of_parts = !depths.contains(&Depth::Other);
        let in_parts = || {
            let pairs = a.parts.iter().flat_map(|part_a| {
                let with = move |part_b| (part_a, part_b);
                b.parts.iter().map(with)
            });
            pairs.map(|(part_a, part_b)| -gap(part_a, part_b, normal))
        };
        let (expected, how) = if !a.has_end() || !b.has_end() {
            (in_parts().fold(0.0, f64::max), "beyond the plane")
        } else if self.are_convex() {
            (-gap(&a.parts[0], &b.parts[0], normal), "along its normal")
        } else if is_of_parts {
            let mut deepest = 0f64;
            for part_a in &a.parts {
                for part_b in &b.parts {
                    let (a, b) = (part_a.placed(), part_b.placed());
                    let found = self.tests.contact(a, b, workspace);
                    let Some(found) = found.filter(|found| f64::from(found.depth) > deepest) else {
                        continue;
                    };
                    let ways = [found.normal.as_dvec3(), normal];
                    let ways = ways.iter().chain(around);
                    let least = ways.map(|way| -gap(part_a, part_b, *way));
                    deepest = deepest.max(least.fold(f64::INFINITY, f64::min));
                }
            }
            (deepest, PARTS)
        } else {
            // Moved by that, they are apart for certain.
            // Of a mesh of any form, how far that is, is no more than an estimate.
            let most = in_parts().fold(0.0, f64::max);
            assert!(
                depth <= 2.0 * most + deep,
                "{contact:?} deep, {most} is enough\n{}",
                self.what()
            );
            (depth, "")
        };
        // Of parts, it is known by a finite number of directions.
        let slack = if how == PARTS { 0.04 * expected } else { 0.0 };
        assert!(
            (expected - depth).abs() <= deep + slack,
            "{depth} deep, {expected} {how}\n{}",
            self.what()
        );
        if self.are_convex() {
            let least = around
                .iter()
                .map(|way| -gap(&a.parts[0], &b.parts[0], *way))
                .fold(f64::INFINITY, f64::min);
            assert!(
                depth <= least.max(0.0) + deep,
                "{depth} deep, {least} at most\n{}",
                self.what()
            );
        }
        // Of two meshes, it is an estimate.
        if depths == [Depth::Other; 2] {
            return;
        }
        let beyond = if is_of_parts {
            deep
        } else {
            deep + 2.0 * depth
        };
        for at in [a, b] {
            let excess = at.excess(contact.point.as_dvec3(), around);
            assert!(
                excess <= beyond,
                "{contact:?} is {excess} outside\n{}",
                self.what()
            );
        }
    }

    /// How far they are apart while they are elsewhere.
    fn distance(&self, a: Transform, b: Transform, workspace: &mut Workspace) -> f32 {
        let (a, b) = (self.a.moved(a), self.b.moved(b));
        let near = self.tests.closest_points(a.placed(), b.placed(), workspace);
        near.unwrap().distance
    }

    fn check_sweep(&self, rng: &mut Rng, tally: &mut Tally, workspace: &mut Workspace) {
        let Self { a, b, tests, .. } = self;
        let exact = self.exact as f32;
        // Towards somewhere near the other.
        let aim =
            pose(rng, 1.0, false).translation + b.transform.translation - a.transform.translation;
        let Ok((direction, length)) = Dir3::new_and_length(aim) else {
            return;
        };
        let max_distance = 2.0 * length;
        let moved = |distance: f32| Transform {
            translation: a.transform.translation + direction * distance,
            ..a.transform
        };
        let hit = tests.sweep(a.placed(), direction, max_distance, b.placed(), workspace);
        let until = hit.map_or(max_distance, |hit| hit.distance);
        if let Some(hit) = hit {
            tally.swept += 1;
            let there = self.distance(moved(hit.distance), b.transform, workspace);
            assert!(
                there <= 2.0 * exact,
                "{there} apart after {}\n{}",
                hit.distance,
                self.what()
            );
            assert!(hit.normal.is_normalized(), "{hit:?}\n{}", self.what());
            assert!(hit.normal.dot(*direction) <= 1e-6, "{}", self.what());
            let on = tests.closest_point(b.placed(), hit.point, workspace);
            let off = on.unwrap().distance(hit.point);
            // What overlaps at the start meets where its contact is.
            assert!(
                hit.distance == 0.0 || off <= 4.0 * exact,
                "{off} off {hit:?}\n{}",
                self.what()
            );
        }
        let steps = (0..12).map(|step| step as f32 / 12.0).chain([0.99]);
        for distance in steps.map(|share| share * until) {
            if distance < until - 50.0 * exact {
                let there = self.distance(moved(distance), b.transform, workspace);
                assert!(
                    there > 0.0,
                    "met before {until}, at {distance} {direction:?}\n{}",
                    self.what()
                );
            }
        }
    }

    fn check_turn(&self, rng: &mut Rng, tally: &mut Tally, workspace: &mut Workspace) {
        let Self { a, b, tests, .. } = self;
        let aim =
            pose(rng, 1.0, false).translation + b.transform.translation - a.transform.translation;
        let mut end = Transform {
            translation: a.transform.translation + aim * 1.5,
            ..a.transform
        };
        // What has no end may not turn.
        if a.has_end() {
            end.rotation = pose(rng, 0.0, false).rotation;
        }
        let moving = Moving::new(&a.whole.shape, &a.transform, &end);
        let back = Transform {
            translation: b.transform.translation - aim * 0.3,
            ..b.transform
        };
        let other = Moving::new(&b.whole.shape, &b.transform, &back);
        match tests.swept_aabb(&moving) {
            Ok(bounds) => {
                let slack = 1e-5 * self.size;
                for share in [0.0, 0.3, 0.7, 1.0] {
                    let at = a.moved(moving.at(share));
                    for axis in DVec3::AXES {
                        let high = Vec3::from(bounds.max).as_dvec3().dot(axis);
                        let low = Vec3::from(bounds.min).as_dvec3().dot(axis);
                        assert!(at.reach(axis) <= high + slack, "{}", self.what());
                        assert!(-at.reach(-axis) >= low - slack, "{}", self.what());
                    }
                }
            }
            Err(error) => {
                assert_eq!(error, BoundsError::Unbounded);
                assert!(!a.has_end(), "{}", self.what());
            }
        }
        let begins_apart = self.distance(a.transform, b.transform, workspace) > 0.0;
        let met = tests.time_of_impact(&moving, &other, workspace);
        let until = met.map_or(1.0, |met| met.time);
        if let Some(met) = met {
            tally.met += 1;
            let there = self.distance(moving.at(met.time), other.at(met.time), workspace);
            assert!(
                there <= 10.0 * self.exact as f32,
                "{there} apart at {}\n{}\n{end:?}",
                met.time,
                self.what()
            );
            assert!(met.contact.normal.is_normalized(), "{}", self.what());
        }
        for step in 0..12 {
            let time = until * (step as f32 / 12.0) - 1e-3;
            // Two that touch at the start may part, and meet again.
            if time > 0.0 && begins_apart {
                // What is over within a 64th of the way may be missed, if they turn.
                let touch = |time: f32, workspace: &mut Workspace| {
                    self.distance(moving.at(time), other.at(time), workspace) <= 0.0
                };
                let is_long = [-1.0, 0.0, 1.0].into_iter().all(|side| {
                    let time = (time + side / 128.0).clamp(0.0, 1.0);
                    touch(time, workspace)
                });
                assert!(
                    !is_long,
                    "met before {until}, at {time}\n{}\n{end:?}",
                    self.what()
                );
            }
        }
    }
}

/// One of them, and points and rays.
struct Alone<'a> {
    at: &'a At<'a>,
    tests: NarrowPhase,
    exact: f64,
}

impl Alone<'_> {
    fn what(&self) -> String {
        format!("{} {:?}", self.at.whole.name, self.at.transform)
    }

    fn check_box(&self) {
        let Self { at, exact, .. } = *self;
        let aabb = match at.whole.shape.world_aabb(&at.transform) {
            Ok(aabb) => aabb,
            Err(error) => {
                assert_eq!(error, BoundsError::Unbounded);
                let side = self.tests.side(at.placed()).unwrap();
                let (normal, offset) = at.parts[0].plane().unwrap();
                // Bevy's normals point inside.
                assert!((Vec3::from(side.normal()).as_dvec3() + normal).length() < 1e-5);
                assert!((f64::from(side.d()) - offset).abs() <= exact, "{side:?}");
                return;
            }
        };
        let [low, high] = [aabb.min, aabb.max].map(|corner| Vec3::from(corner).as_dvec3());
        for axis in DVec3::AXES {
            assert!(at.reach(axis) <= high.dot(axis) + exact, "{}", self.what());
            assert!(-at.reach(-axis) >= low.dot(axis) - exact, "{}", self.what());
        }
        // Upright, it is as small as can be.
        let upright = Transform {
            rotation: Quat::IDENTITY,
            ..at.transform
        };
        if at.is_convex() && at.whole.name != "leaning capsule" {
            let aabb = at.whole.shape.world_aabb(&upright).unwrap();
            let at = at.moved(upright);
            for axis in DVec3::AXES {
                let high = Vec3::from(aabb.max).as_dvec3().dot(axis);
                let beyond = high - at.reach(axis);
                assert!(beyond <= 2.0 * exact, "{beyond} {}", self.what());
            }
        }
    }

    fn check_point(&self, point: Vec3, around: &[DVec3], tally: &mut Tally) {
        let Self { at, tests, exact } = self;
        let mut workspace = Workspace::default();
        let closest = tests
            .closest_point(at.placed(), point, &mut workspace)
            .unwrap();
        let excess = at.excess(closest.as_dvec3(), around);
        assert!(
            excess <= *exact,
            "{closest} is {excess} outside\n{}",
            self.what()
        );
        let distance = (point - closest).as_dvec3().length();
        let is_in = self.meets(point, &mut workspace);
        let tolerance = f64::from(tests.tolerance());
        if distance <= 0.5 * tolerance {
            assert!(is_in, "{point} {}", self.what());
        }
        if distance <= 2.0 * exact {
            return;
        }
        tally.outside += 1;
        assert!(!is_in, "{point} {}", self.what());
        // The shorter a vector of 32-bit numbers is, the less is known of its direction.
        let size = at.size();
        let doubt = exact + 5e-7 * size * size / distance;
        // What parts the point from all of it.
        for part in &at.parts {
            let on_part = tests.closest_point(part.placed(), point, &mut workspace);
            let normal = (point - on_part.unwrap()).as_dvec3().normalize_or_zero();
            let beyond = part.excess(point.as_dvec3(), &[normal]);
            assert!(
                beyond >= distance - doubt,
                "{point}: {beyond} {distance}\n{}",
                self.what()
            );
        }
    }

    /// Is the point in it, or on it?
    fn meets(&self, point: Vec3, workspace: &mut Workspace) -> bool {
        let at = At::new(self.at.whole, self.at.transform);
        let mote = Shape::sphere(0.0);
        let here = Transform::from_translation(point);
        let mote = Placed::new(&mote, &here);
        self.tests.intersects(mote, at.placed(), workspace)
    }

    fn check_ray(&self, origin: Vec3, rng: &mut Rng, around: &[DVec3], tally: &mut Tally) {
        let Self { at, tests, exact } = *self;
        let mut workspace = Workspace::default();
        let aim = at.transform.translation - origin + pose(rng, 0.7, false).translation;
        let Ok((direction, length)) = Dir3::new_and_length(aim) else {
            return;
        };
        let most = 2.0 * length;
        let hit = tests.cast_ray(at.placed(), origin, direction, most);
        let along = |distance: f32| origin + direction * distance;
        let until = hit.map_or(most, |hit| hit.distance);
        if let Some(hit) = hit {
            tally.hit += 1;
            let met = along(hit.distance).as_dvec3();
            let excess = at.excess(met, around);
            assert!(excess <= 4.0 * exact, "{hit:?} {}", self.what());
            assert!(hit.normal.dot(*direction) <= 1e-6, "{}", self.what());
            if hit.distance > 0.0 {
                let normal = hit.normal.as_dvec3();
                let near = at
                    .parts
                    .iter()
                    .filter(|part| part.excess(met, around) <= 4.0 * exact);
                // How far the part reaches beyond the hit along the normal.
                let behind = near.map(|part| match part.plane() {
                    Some((plane, _)) => (plane - normal).length(),
                    None => (part.reach(normal) - normal.dot(hit.point.as_dvec3())).abs(),
                });
                let behind = behind.fold(f64::INFINITY, f64::min);
                assert!(
                    behind <= 0.02 * at.size().min(20.0),
                    "{behind} {hit:?} {}",
                    self.what()
                );
            }
        }
        for step in 0..16 {
            let distance = until * (step as f32 / 16.0);
            if distance < until - 8.0 * exact as f32 {
                let point = along(distance);
                let closest = tests.closest_point(at.placed(), point, &mut workspace);
                assert!(
                    closest.unwrap() != point,
                    "met before {until}, at {distance}: {}",
                    self.what()
                );
            }
        }
        // A ball without a size on the same way.
        let mote = Shape::sphere(0.0);
        let here = Transform::from_translation(origin);
        let mote = Placed::new(&mote, &here);
        let swept = tests.sweep(mote, direction, most, at.placed(), &mut workspace);
        if let Some(hit) = hit {
            let swept = swept.unwrap_or_else(|| panic!("swept past\n{}", self.what()));
            assert!(
                swept.distance <= hit.distance + 2.0 * exact as f32,
                "{swept:?} {hit:?}\n{}",
                self.what()
            );
        }
        let passage = tests.cast_ray_through(at.placed(), origin, direction, most);
        assert_eq!(passage.is_some(), hit.is_some(), "{}", self.what());
        if let Some(passage) = passage {
            self.check_passage(passage, until, along, tally);
        }
    }

    fn check_passage(
        &self,
        passage: Passage,
        until: f32,
        along: impl Fn(f32) -> Vec3,
        tally: &mut Tally,
    ) {
        let mut workspace = Workspace::default();
        let exact = self.exact as f32;
        if let Some(enter) = passage.enter {
            let off = (enter.distance - until).abs();
            assert!(off <= 2.0 * exact, "{off} {}", self.what());
        } else {
            assert!(until <= exact, "{until} {passage:?} {}", self.what());
        }
        let Some(leave) = passage.leave else {
            return;
        };
        tally.left += 1;
        assert!(leave.distance >= until - exact, "{}", self.what());
        for step in 0..=8 {
            let distance = until + (leave.distance - until) * (step as f32 / 8.0);
            let point = along(distance);
            let placed = self.at.placed();
            let closest = self.tests.closest_point(placed, point, &mut workspace);
            let off = closest.unwrap().distance(point);
            assert!(
                off <= 2.0 * exact,
                "{off} off within {until} to {}, at {distance}: {}",
                leave.distance,
                self.what()
            );
        }
        let after = leave.distance + 0.1;
        if self.at.is_convex() {
            let point = along(after);
            let is_in = self.meets(point, &mut workspace);
            // Along a side, it leaves slowly.
            assert!(
                !is_in || leave.normal.dot(along(1.0) - along(0.0)).abs() < 0.05,
                "{passage:?} {}",
                self.what()
            );
        }
    }
}

fn check_alone(at: &At, around: &[DVec3], rng: &mut Rng, tally: &mut Tally) {
    let tests = NarrowPhase::default();
    let exact = EXACT * at.size() + f64::from(tests.tolerance());
    let alone = Alone { at, tests, exact };
    alone.check_box();
    for _ in 0..8 {
        let reach = (at.size() as f32) * 0.25;
        let point = at.transform.translation + pose(rng, reach, false).translation;
        alone.check_point(point, around, tally);
        alone.check_ray(point, rng, around, tally);
    }
}

/// How a shape is scaled in a round.
fn scale(round: usize) -> Option<Vec3> {
    let scales = [
        None,
        Some(Vec3::splat(1.5)),
        Some(Vec3::splat(-0.7)),
        Some(Vec3::new(-1.2, 1.2, 1.2)),
        Some(Vec3::new(1.3, 0.6, -0.8)),
    ];
    scales[round % scales.len()]
}

fn put<'a>(whole: &'a Whole, rng: &mut Rng, reach: f32, round: usize) -> At<'a> {
    let mut transform = pose(rng, reach, false);
    transform.scale = scale(round).unwrap_or(Vec3::ONE);
    At::new(whole, transform)
}

fn check_all(tally: &Tally, least: u32) {
    let Tally {
        apart,
        together,
        swept,
        met,
        hit,
        left,
        outside,
    } = *tally;
    assert!(
        [apart, together, swept, met, hit, left, outside]
            .iter()
            .all(|count| *count > least),
        "{tally:?}"
    );
}

#[test]
fn all_pairs_of_convex_shapes_pass_all_tests() {
    let around = directions(1500);
    let mut rng = Rng::with_seed(13);
    let mut tally = Tally::default();
    for round in 0..ROUNDS {
        let all: Vec<Whole> = kinds(&mut rng).into_iter().map(Whole::from).collect();
        for a in &all {
            let scaled = round % 3 == 2;
            let a = At::new(a, pose(&mut rng, 2.0, scaled));
            check_alone(&a, &around, &mut rng, &mut tally);
            for b in &all {
                let reach = if round % 2 == 0 { 1.5 } else { 4.0 };
                let b = At::new(b, pose(&mut rng, reach, scaled));
                Pair::new(&a, &b).check(&around, &mut rng, &mut tally);
            }
        }
    }
    check_all(&tally, 300);
}

/// Whatever it consists of, with each other and with those that are convex.
#[test]
fn all_pairs_of_all_shapes_pass_all_tests() {
    let around = directions(300);
    let mut rng = Rng::with_seed(31);
    let mut tally = Tally::default();
    for round in 0..WHOLE_ROUNDS {
        let all = wholes(&mut rng);
        let convex: Vec<Whole> = kinds(&mut rng).into_iter().map(Whole::from).collect();
        for (number, a) in all.iter().enumerate() {
            let a = put(a, &mut rng, 1.0, round + number);
            check_alone(&a, &around, &mut rng, &mut tally);
            for (other, b) in all.iter().chain(&convex).enumerate() {
                let reach = if round % 2 == 0 { 1.5 } else { 4.0 };
                let b = put(b, &mut rng, reach, round / 2 + other);
                Pair::new(&a, &b).check(&around, &mut rng, &mut tally);
            }
        }
    }
    // Fewer without Rapier's.
    check_all(&tally, 200);
}
