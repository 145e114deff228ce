//! Pairs of arbitrary shapes in arbitrary places: all that is asked of a pair agrees with the rest, and
//! of convex shapes with how far these reach, in 64-bit numbers.

use bevy::{
    math::{DMat3, DVec3, bounding::Aabb3d},
    prelude::*,
};
use bevy_octree::{
    narrow_phase::{Contact, Moving, NarrowPhase, Placed, Proximity, Shape, Workspace},
    shape_data::ShapeDescription,
};

use crate::{data, source::Source};

/// How far off a distance may be, as a share of the sizes.
const EXACT: f64 = 3e-5;
/// The same of depths, where normals of faces are preferred to others that are hardly better.
const DEEP: f64 = 3e-3;

/// Makes two shapes of the bytes, and puts them somewhere.
pub fn run(bytes: &[u8]) {
    let mut source = Source::new(bytes);
    let is_wild = source.may_go_wild();
    let data = [(); 2].map(|()| data::description(&mut source, 0));
    let poses = [(); 2].map(|()| source.pose());
    let built = data.each_ref().map(ShapeDescription::build);
    for (data, built) in data.iter().zip(&built) {
        check_data(data, built.as_ref().ok());
    }
    let [Ok(a), Ok(b)] = built else {
        return;
    };
    let pair = Pair {
        placed: [Placed::new(&a, &poses[0]), Placed::new(&b, &poses[1])],
        known: [0, 1].map(|side| Reach::of(&data[side], &poses[side])),
        data: &data[0],
        tests: NarrowPhase::default(),
        is_wild,
    };
    pair.check(&mut source);
}

/// What is built comes back as data, and is built of that.
fn check_data(data: &ShapeDescription, built: Option<&Shape>) {
    if let Some(shape) = built {
        let again = ShapeDescription::of(shape).expect("it is none of Rapier's");
        assert!(again.build().is_ok(), "{data:?}\n{again:?}");
    }
}

/// How far a convex shape reaches along a direction, by a formula.
struct Reach {
    core: Core,
    radius: f64,
    turn: DMat3,
    scale: DVec3,
    position: DVec3,
}

enum Core {
    Points(Vec<DVec3>),
    Frustum { top: f64, bottom: f64, half: f64 },
}

impl Reach {
    /// `None` of what is not convex, or has no end.
    fn of(data: &ShapeDescription, at: &Transform) -> Option<Self> {
        let even = at.scale.abs().max_element();
        let (core, radius) = match data {
            ShapeDescription::Sphere { radius } => (Core::Points(vec![DVec3::ZERO]), radius * even),
            ShapeDescription::Capsule { radius, length } => {
                let across = at.scale.x.abs().max(at.scale.z.abs());
                let end = DVec3::Y * f64::from(length * 0.5);
                (Core::Points(vec![end, -end]), radius * across)
            }
            ShapeDescription::CapsuleBetween { a, b, radius } => (
                Core::Points(vec![a.as_dvec3(), b.as_dvec3()]),
                radius * even,
            ),
            ShapeDescription::Rounded { core, radius } => {
                (Core::of(&core.clone().into())?, radius * even)
            }
            other => (Core::of(other)?, 0.0),
        };
        Some(Self {
            core,
            radius: radius.into(),
            turn: DMat3::from_quat(at.rotation.as_dquat().normalize()),
            scale: at.scale.as_dvec3(),
            position: at.translation.as_dvec3(),
        })
    }

    /// How far it reaches along a unit vector.
    fn along(&self, way: DVec3) -> f64 {
        let scaled = (self.turn.transpose() * way) * self.scale;
        let core = match &self.core {
            Core::Points(points) => {
                let reaches = points.iter().map(|point| point.dot(scaled));
                reaches.fold(f64::NEG_INFINITY, f64::max)
            }
            Core::Frustum { top, bottom, half } => {
                let across = scaled.with_y(0.0).length();
                (top * across + half * scaled.y).max(bottom * across - half * scaled.y)
            }
        };
        core + self.radius + way.dot(self.position)
    }

    fn size(&self) -> f64 {
        let ways = DVec3::AXES.iter().flat_map(|axis| [*axis, -*axis]);
        ways.map(|way| self.along(way).abs()).fold(0.0, f64::max)
    }

    /// How far a point is outside of it, at least.
    fn excess(&self, point: DVec3) -> f64 {
        let ways = ways().map(|way| way.dot(point) - self.along(way));
        ways.fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Core {
    fn of(data: &ShapeDescription) -> Option<Self> {
        let points =
            |points: &[Vec3]| Self::Points(points.iter().map(|point| point.as_dvec3()).collect());
        let frustum = |top: f32, bottom: f32, height: f32| Self::Frustum {
            top: top.into(),
            bottom: bottom.into(),
            half: f64::from(height) * 0.5,
        };
        Some(match data {
            ShapeDescription::Cuboid { half_size } => {
                let corner = |bits: u8| {
                    let signs =
                        [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 });
                    *half_size * Vec3::from(signs)
                };
                points(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner))
            }
            ShapeDescription::Cylinder { radius, height } => frustum(*radius, *radius, *height),
            ShapeDescription::Cone { radius, height } => frustum(0.0, *radius, *height),
            ShapeDescription::ConicalFrustum {
                radius_top,
                radius_bottom,
                height,
            } => frustum(*radius_top, *radius_bottom, *height),
            ShapeDescription::Tetrahedron { vertices } => points(vertices),
            ShapeDescription::Triangle { a, b, c } => points(&[*a, *b, *c]),
            ShapeDescription::Segment { a, b } => points(&[*a, *b]),
            ShapeDescription::ConvexHull { points: all } => points(all),
            _ => return None,
        })
    }
}

/// Directions all around.
fn ways() -> impl Iterator<Item = DVec3> {
    const COUNT: usize = 120;
    (0..COUNT).map(|number| {
        let y = 1.0 - 2.0 * (number as f64 + 0.5) / COUNT as f64;
        let angle = number as f64 * 2.399_963_229_728_653;
        let across = (1.0 - y * y).sqrt();
        DVec3::new(across * angle.cos(), y, across * angle.sin())
    })
}

/// Are there voxels of no cells in it, or a height field of nothing but holes?
fn is_nothing(shape: &Shape) -> bool {
    match shape {
        Shape::Voxels(voxels) => voxels.iter().next().is_none(),
        Shape::HeightField(field) => {
            let most = field.heights().len() as u32 * 2;
            (0..most).all(|number| field.triangle(number).is_none())
        }
        Shape::Compound(_) => {
            let data = format!("{:?}", ShapeDescription::of(shape));
            data.contains("cells: []") || data.contains("HeightField")
        }
        _ => false,
    }
}

/// Nowhere, and so far aside of a way, all around: what grazes may be met or not.
fn around(way: Vec3, far: f32) -> impl Iterator<Item = Vec3> {
    let (aside, across) = way.any_orthonormal_pair();
    [Vec3::ZERO, aside, across, -aside, -across]
        .into_iter()
        .map(move |by| by * far)
}

/// Two in their places.
struct Pair<'a> {
    placed: [Placed<'a>; 2],
    known: [Option<Reach>; 2],
    /// What the first is.
    data: &'a ShapeDescription,
    tests: NarrowPhase,
    is_wild: bool,
}

impl Pair<'_> {
    fn what(&self) -> String {
        let [a, b] = self.placed;
        let data = [a, b].map(|placed| ShapeDescription::of(placed.shape));
        format!(
            "{:?} {:?}\n{:?} {:?}",
            data[0], a.transform, data[1], b.transform
        )
    }

    fn check(&self, source: &mut Source) {
        let contact = self.contact();
        let near = self.near();
        self.check_anything(source, contact, near);
        if self.is_wild {
            return;
        }
        let both_end = self
            .placed
            .map(|placed| placed.shape.world_aabb(placed.transform));
        if let [Err(_), Err(_)] = both_end {
            return assert!(contact.is_none() && near.is_none(), "{}", self.what());
        }
        let Some(near) = near else {
            // What is nothing is nowhere.
            let are_some = self.placed.iter().all(|placed| !is_nothing(placed.shape));
            return assert!(
                contact.is_none() && !are_some,
                "all is known\n{}",
                self.what()
            );
        };
        let exact = self.exact();
        let distance = f64::from(near.distance);
        assert!(
            contact.is_some() || distance > 0.0,
            "{near:?}\n{}",
            self.what()
        );
        assert!(
            contact.is_none() || distance <= exact,
            "{near:?} {contact:?}\n{}",
            self.what()
        );
        let [from, to] = near.points.map(Vec3::as_dvec3);
        assert!(
            ((to - from).length() - distance).abs() <= exact,
            "{near:?}\n{}",
            self.what()
        );
        for (placed, point) in self.placed.iter().zip(near.points) {
            let closest = self
                .tests
                .closest_point(*placed, point, &mut Workspace::default());
            let off = closest.map_or(f64::INFINITY, |at| at.as_dvec3().distance(point.as_dvec3()));
            assert!(off <= exact, "{point} is {off} off\n{}", self.what());
        }
        if let [Some(a), Some(b)] = &self.known {
            self.check_known(a, b, &near, contact, exact);
        }
        self.check_sweep(source, exact as f32);
        self.check_ray(source, exact as f32);
    }

    /// The contact, which is there if and only if they intersect, either way round.
    fn contact(&self) -> Option<Contact> {
        let ([a, b], tests, mut workspace) = (self.placed, &self.tests, Workspace::default());
        let contact = tests.contact(a, b, &mut workspace);
        let is_met = contact.is_some();
        assert_eq!(
            is_met,
            tests.intersects(a, b, &mut workspace),
            "{}",
            self.what()
        );
        assert_eq!(
            is_met,
            tests.intersects(b, a, &mut workspace),
            "{}",
            self.what()
        );
        assert_eq!(
            is_met,
            tests.manifold(a, b, &mut workspace).is_some(),
            "{}",
            self.what()
        );
        let back = tests.contact(b, a, &mut workspace).map(Contact::reversed);
        if !self.are_equal() {
            assert_eq!(contact, back, "{}", self.what());
        }
        if let Some(contact) = contact {
            assert!(
                (contact.normal.length() - 1.0).abs() < 1e-4,
                "{contact:?}\n{}",
                self.what()
            );
            assert!(
                contact.depth >= 0.0 && contact.point.is_finite(),
                "{contact:?}\n{}",
                self.what()
            );
        }
        contact
    }

    /// In all things, position included: nothing is said of the order of such.
    fn are_equal(&self) -> bool {
        let [a, b] = self.placed;
        a.transform == b.transform && format!("{:?}", a.shape) == format!("{:?}", b.shape)
    }

    /// How far off answers may be, of what reaches so far.
    fn exact(&self) -> f64 {
        let boxes = self
            .placed
            .map(|placed| placed.shape.world_aabb(placed.transform));
        let reach = |aabb: &Aabb3d| aabb.min.abs().max(aabb.max.abs()).max_element();
        let reaches = boxes.iter().flatten().map(|aabb| f64::from(reach(aabb)));
        EXACT * reaches.fold(1.0, f64::max) + f64::from(self.tests.tolerance())
    }

    fn near(&self) -> Option<Proximity> {
        let ([a, b], mut workspace) = (self.placed, Workspace::default());
        let near = self.tests.closest_points(a, b, &mut workspace);
        let back = self.tests.closest_points(b, a, &mut workspace);
        assert_eq!(near.is_some(), back.is_some(), "{}", self.what());
        let (near, back) = (near?, back?);
        assert!(
            near.distance >= 0.0 && near.offset.is_finite(),
            "{near:?}\n{}",
            self.what()
        );
        if !self.are_equal() {
            let turned = (back.distance, back.points[1], back.points[0], -back.offset);
            let straight = (near.distance, near.points[0], near.points[1], near.offset);
            assert_eq!(straight, turned, "{}", self.what());
        }
        Some(near)
    }

    /// Whatever the numbers, nothing panics, and what touches at the start is met there.
    fn check_anything(
        &self,
        source: &mut Source,
        contact: Option<Contact>,
        near: Option<Proximity>,
    ) {
        let ([a, b], tests, mut workspace) = (self.placed, &self.tests, Workspace::default());
        let direction = source.direction();
        // What is a hundred million across has its end somewhere within ten.
        let is_near = near.is_some_and(|near| f64::from(near.distance) <= self.exact());
        let hit = tests.sweep(a, direction, source.size(), b, &mut workspace);
        let is_early =
            |hit: bevy_octree::narrow_phase::Impact| hit.distance >= 0.0 && hit.point.is_finite();
        assert!(hit.is_none_or(is_early), "{hit:?}\n{}", self.what());
        assert!(
            hit.is_none_or(|hit| hit.distance > 0.0 || contact.is_some() || is_near),
            "{hit:?}\n{}",
            self.what()
        );
        let end = source.pose();
        let (moving, resting) = (Moving::new(a.shape, a.transform, &end), Moving::resting(b));
        let met = tests.time_of_impact(&moving, &resting, &mut workspace);
        assert!(
            met.is_none_or(|met| (0.0..=1.0).contains(&met.time)),
            "{met:?}\n{}",
            self.what()
        );
        let last = Reach::of(self.data, &moving.at(1.0)).filter(|_| !self.is_wild);
        if let (Ok(swept), Some(last)) = (tests.swept_aabb(&moving), last) {
            let slack = 1e-4 * last.size() + 1e-4;
            for axis in DVec3::AXES {
                let [low, high] =
                    [swept.min, swept.max].map(|corner| Vec3::from(corner).as_dvec3().dot(axis));
                let is_within =
                    last.along(axis) <= high + slack && -last.along(-axis) >= low - slack;
                assert!(is_within, "{swept:?} {:?}\n{}", moving.at(1.0), self.what());
            }
        }
        let passage = tests.cast_ray_through(b, source.vector(), direction, source.size());
        assert!(
            passage.is_none_or(|passage| passage.length().is_none_or(|length| !length.is_nan()))
        );
    }

    /// Of two convex shapes, a plane says how far they are apart, and how deep in each other.
    fn check_known(
        &self,
        a: &Reach,
        b: &Reach,
        near: &Proximity,
        contact: Option<Contact>,
        exact: f64,
    ) {
        let gap = |way: DVec3| -b.along(-way) - a.along(way);
        let size = a.size() + b.size();
        for (reach, point) in [a, b].iter().zip(near.points) {
            let excess = reach.excess(point.as_dvec3());
            assert!(
                excess <= exact,
                "{point} is {excess} outside\n{}",
                self.what()
            );
        }
        let distance = f64::from(near.distance);
        let most = ways().map(gap).fold(f64::NEG_INFINITY, f64::max);
        assert!(
            most <= distance + exact,
            "{distance} apart, {most} at least\n{}",
            self.what()
        );
        if distance > exact {
            // The shorter a vector of 32-bit numbers is, the less is known of its direction.
            let doubt = exact + 1e-6 * size * size / distance;
            let apart = gap(near.offset.as_dvec3().normalize());
            assert!(
                apart >= distance - doubt,
                "{distance} apart, {apart} for certain\n{}",
                self.what()
            );
        }
        if let Some(contact) = contact {
            let depth = f64::from(contact.depth);
            let deep = DEEP * size + exact;
            let along = (-gap(contact.normal.as_dvec3().normalize())).max(0.0);
            assert!(
                (along - depth).abs() <= deep,
                "{contact:?}, {along} deep\n{}",
                self.what()
            );
            assert!(
                depth <= (-most).max(0.0) + deep,
                "{contact:?}, {most} at most\n{}",
                self.what()
            );
        }
    }

    /// How far the first would be from the second.
    fn distance_at(&self, by: Vec3) -> f32 {
        let [a, b] = self.placed;
        let there = Transform {
            translation: a.transform.translation + by,
            ..*a.transform
        };
        let there = Placed::new(a.shape, &there);
        let near = self
            .tests
            .closest_points(there, b, &mut Workspace::default());
        near.map_or(f32::INFINITY, |near| near.distance)
    }

    /// A point where the first, so much further on, and the second meet is one of both.
    fn check_point(&self, by: Vec3, point: Vec3, exact: f32) {
        let [a, b] = self.placed;
        let there = Transform {
            translation: a.transform.translation + by,
            ..*a.transform
        };
        for placed in [Placed::new(a.shape, &there), b] {
            let mut workspace = Workspace::default();
            let closest = self.tests.closest_point(placed, point, &mut workspace);
            let off = closest.map_or(f32::INFINITY, |closest| closest.distance(point));
            assert!(
                off <= 20.0 * exact,
                "{point} is {off} off {placed:?}\n{}",
                self.what()
            );
        }
    }

    /// What is swept ends in touch, and passes nothing.
    fn check_sweep(&self, source: &mut Source, exact: f32) {
        let [a, b] = self.placed;
        let aim = b.transform.translation - a.transform.translation + source.vector() * 0.25;
        let Ok((direction, length)) = Dir3::new_and_length(aim) else {
            return;
        };
        let most = 2.0 * length;
        let hit = self
            .tests
            .sweep(a, direction, most, b, &mut Workspace::default());
        let until = hit.map_or(most, |hit| hit.distance);
        if let Some(hit) = hit {
            let there = self.distance_at(direction * hit.distance);
            assert!(
                there <= 4.0 * exact,
                "{there} apart, {hit:?} {direction:?}\n{}",
                self.what()
            );
            let is_against = hit.normal.is_normalized() && hit.normal.dot(*direction) <= 1e-5;
            assert!(is_against, "{hit:?} {direction:?}\n{}", self.what());
            // What overlaps at the start has no one point where it touches.
            if hit.distance > 0.0 {
                if let [Some(a), Some(b)] = &self.known {
                    // The plane through where they touch parts them.
                    let away = hit.normal.as_dvec3();
                    let gone = direction.as_dvec3().dot(away) * f64::from(hit.distance);
                    let apart = gone - b.along(away) - a.along(-away);
                    let deep = DEEP * (a.size() + b.size()) + 4.0 * f64::from(exact);
                    assert!(
                        apart >= -deep,
                        "{apart} apart along {hit:?} {direction:?}\n{}",
                        self.what()
                    );
                }
                self.check_point(direction * hit.distance, hit.point, exact);
            }
        }
        let end = Transform {
            translation: a.transform.translation + direction * most,
            ..*a.transform
        };
        let (moving, resting) = (Moving::new(a.shape, a.transform, &end), Moving::resting(b));
        let mut workspace = Workspace::default();
        let timed = self
            .tests
            .time_of_impact(&moving, &resting, &mut workspace)
            .filter(|met| met.time > 0.0);
        let timed = timed.filter(|_| !self.tests.intersects(a, b, &mut workspace));
        if let Some(met) = timed {
            let by = moving.at(met.time).translation - a.transform.translation;
            self.check_point(by, met.contact.point, exact);
        }
        for step in 0..12 {
            let distance = until * (step as f32 / 12.0);
            if distance < until - 100.0 * exact {
                let is_met = around(*direction, 20.0 * exact)
                    .all(|by| self.distance_at(direction * distance + by) <= 0.0);
                assert!(
                    !is_met,
                    "met before {until}, at {distance} {direction:?}\n{}",
                    self.what()
                );
            }
        }
    }

    fn check_ray(&self, source: &mut Source, exact: f32) {
        let b = self.placed[1];
        let origin = source.vector();
        let aim = b.transform.translation - origin + source.vector() * 0.25;
        let Ok((direction, length)) = Dir3::new_and_length(aim) else {
            return;
        };
        let most = 2.0 * length;
        let mut workspace = Workspace::default();
        let hit = self.tests.cast_ray(b, origin, direction, most);
        let mut off = |distance: f32, by: Vec3| {
            let point = origin + direction * distance + by;
            let closest = self.tests.closest_point(b, point, &mut workspace);
            closest.map_or(f32::INFINITY, |closest| closest.distance(point))
        };
        let until = hit.map_or(most, |hit| hit.distance);
        if let Some(hit) = hit {
            let off = off(hit.distance, Vec3::ZERO);
            let apart = hit.point.distance(origin + direction * hit.distance);
            assert!(
                apart <= 4.0 * exact,
                "{apart} off, {hit:?} {direction:?}\n{}",
                self.what()
            );
            assert!(
                off <= 4.0 * exact,
                "{off} off, {hit:?} {direction:?}\n{}",
                self.what()
            );
        }
        for step in 0..12 {
            let distance = until * (step as f32 / 12.0);
            if distance < until - 20.0 * exact {
                let is_met = around(*direction, 20.0 * exact).all(|by| off(distance, by) <= 0.0);
                assert!(
                    !is_met,
                    "met before {until}, at {distance} of {direction:?} from {origin}\n{}",
                    self.what()
                );
            }
        }
    }
}
