//! All pairs of convex shapes by all exact tests, each answer with a certificate in 64-bit numbers.
//!
//! No other algorithm is asked: that a point is in a shape, and how far a shape reaches along a
//! direction, is known of each shape by a formula. Two points in two shapes say that these are no
//! further apart; a plane between them, that they are no nearer to each other.

use std::f32::consts::TAU;

use bevy::{
    math::{DMat3, DVec3, Dir3},
    prelude::*,
};
use bevy_octree::narrow_phase::{Moving, NarrowPhase, Placed, Shape, Workspace};
use fastrand::Rng;

/// Poses for each pair.
pub(crate) const ROUNDS: usize = 24;
/// How far off a distance may be, as a share of the sizes.
const EXACT: f64 = 1e-5;
/// The same of depths of round shapes, which are the end of an iteration.
const DEEP: f64 = 2e-3;

/// A shape as the test knows it, in its own coordinates: a core at a scale, and a radius around it.
#[derive(Clone, Debug)]
pub(crate) enum Core {
    Points(Vec<DVec3>),
    Frustum { bottom: f64, top: f64, half: f64 },
}

#[derive(Clone, Debug)]
pub(crate) struct Known {
    pub(crate) name: &'static str,
    pub(crate) shape: Shape,
    core: Core,
    radius: f64,
    /// What the scale makes of the radius.
    radius_scale: fn(DVec3) -> f64,
}

/// One of them in its place.
struct At<'a> {
    known: &'a Known,
    transform: Transform,
    turn: DMat3,
}

fn largest(scale: DVec3) -> f64 {
    scale.abs().max_element()
}

pub(crate) fn kinds(rng: &mut Rng) -> Vec<Known> {
    let mut size = || 0.2 + 1.8 * rng.f32();
    let wide = |point: Vec3| point.as_dvec3();
    let corners = |half: Vec3| {
        let signs = [-1.0, 1.0];
        let mut points = vec![];
        for x in signs {
            for y in signs {
                for z in signs {
                    points.push(wide(half * Vec3::new(x, y, z)));
                }
            }
        }
        Core::Points(points)
    };
    let known = |name, shape, core, radius: f32| Known {
        name,
        shape,
        core,
        radius: f64::from(radius),
        radius_scale: largest,
    };
    let mut all = vec![];
    let radius = size();
    all.push(known(
        "sphere",
        Shape::sphere(radius),
        Core::Points(vec![DVec3::ZERO]),
        radius,
    ));
    let half = Vec3::new(size(), size(), size());
    all.push(known(
        "cuboid",
        Shape::from_half_size(half),
        corners(half),
        0.0,
    ));
    let half = Vec3::new(0.5, 30.0, 100.0);
    all.push(known(
        "wall",
        Shape::from_half_size(half),
        corners(half),
        0.0,
    ));
    let (radius, length) = (size(), size());
    let ends = [-0.5, 0.5].map(|side| wide(Vec3::Y * length * side));
    all.push(Known {
        radius_scale: |scale| scale.x.abs().max(scale.z.abs()),
        ..known(
            "capsule",
            Shape::capsule(radius, length),
            Core::Points(ends.to_vec()),
            radius,
        )
    });
    let mut frustum = |name, top: f32, bottom: f32, radius: f32| {
        let height = 0.3 + rng.f32() * 2.0;
        let solid = Shape::conical_frustum(top, bottom, height);
        let core = Core::Frustum {
            bottom: bottom.into(),
            top: top.into(),
            half: f64::from(height) * 0.5,
        };
        let shape = if radius > 0.0 {
            Shape::rounded(&solid, radius).unwrap()
        } else {
            solid
        };
        known(name, shape, core, radius)
    };
    all.push(frustum("cylinder", 0.7, 0.7, 0.0));
    all.push(frustum("cone", 0.0, 0.9, 0.0));
    all.push(frustum("frustum", 1.1, 0.4, 0.0));
    all.push(frustum("rounded cylinder", 0.5, 0.5, 0.2));
    let mut point = || Vec3::new(rng.f32(), rng.f32(), rng.f32()) * 3.0 - 1.5;
    let [a, b, c, d] = [point(), point(), point(), point()];
    let few = |points: &[Vec3]| Core::Points(points.iter().copied().map(wide).collect());
    all.push(known(
        "segment",
        Shape::segment(a, b).unwrap(),
        few(&[a, b]),
        0.0,
    ));
    all.push(known(
        "triangle",
        Shape::triangle(a, b, c).unwrap(),
        few(&[a, b, c]),
        0.0,
    ));
    all.push(known(
        "leaning capsule",
        Shape::capsule_between(a, c, 0.4).unwrap(),
        few(&[a, c]),
        0.4,
    ));
    all.push(known(
        "tetrahedron",
        Shape::tetrahedron([a, b, c, d]).unwrap(),
        few(&[a, b, c, d]),
        0.0,
    ));
    let half = Vec3::new(0.4, 0.9, 0.6);
    let round = Shape::rounded(&Shape::from_half_size(half), 0.3).unwrap();
    all.push(known("rounded cuboid", round, corners(half), 0.3));
    all
}

impl<'a> At<'a> {
    fn new(known: &'a Known, transform: Transform) -> Self {
        let turn = DMat3::from_quat(transform.rotation.as_dquat().normalize());
        Self {
            known,
            transform,
            turn,
        }
    }

    fn placed(&self) -> Placed<'_> {
        Placed::new(&self.known.shape, &self.transform)
    }

    fn scale(&self) -> DVec3 {
        self.transform.scale.as_dvec3()
    }

    fn radius(&self) -> f64 {
        self.known.radius * (self.known.radius_scale)(self.transform.scale.as_dvec3())
    }

    /// How far it reaches along a unit vector.
    fn reach(&self, direction: DVec3) -> f64 {
        let local = self.turn.transpose() * direction;
        let scaled = local * self.scale();
        let core = match &self.known.core {
            Core::Points(points) => points
                .iter()
                .map(|point| point.dot(scaled))
                .fold(f64::NEG_INFINITY, f64::max),
            Core::Frustum { bottom, top, half } => {
                let across = scaled.with_y(0.0).length();
                (top * across + half * scaled.y).max(bottom * across - half * scaled.y)
            }
        };
        core + self.radius() + direction.dot(self.transform.translation.as_dvec3())
    }

    /// No point is in it that is further than the reach along one of these.
    fn excess(&self, point: DVec3, directions: &[DVec3]) -> f64 {
        directions
            .iter()
            .map(|direction| direction.dot(point) - self.reach(*direction))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    fn size(&self) -> f64 {
        DVec3::AXES
            .iter()
            .map(|axis| self.reach(*axis) + self.reach(-*axis))
            .sum::<f64>()
    }
}

/// How far the second is beyond the first along a direction.
fn gap(a: &At, b: &At, direction: DVec3) -> f64 {
    -b.reach(-direction) - a.reach(direction)
}

/// Directions all around, evenly.
fn directions(count: usize) -> Vec<DVec3> {
    (0..count)
        .map(|number| {
            let y = 1.0 - 2.0 * (number as f64 + 0.5) / count as f64;
            let angle = number as f64 * 2.399_963_229_728_653;
            let across = (1.0 - y * y).sqrt();
            DVec3::new(across * angle.cos(), y, across * angle.sin())
        })
        .collect()
}

pub(crate) fn pose(rng: &mut Rng, reach: f32, scaled: bool) -> Transform {
    let mut number = |reach: f32| (rng.f32() * 2.0 - 1.0) * reach;
    let translation = Vec3::new(number(reach), number(reach), number(reach));
    let axis = Vec3::new(number(1.0), number(1.0), number(1.0));
    let rotation = Quat::from_scaled_axis(axis * TAU / 2.0);
    let scale = if scaled {
        Vec3::new(1.0 + number(0.6), 1.0 + number(0.6), -1.0 + number(0.6))
    } else {
        Vec3::ONE
    };
    Transform {
        translation,
        rotation,
        scale,
    }
}

fn check_pair(a: &At, b: &At, around: &[DVec3], rng: &mut Rng, tally: &mut Tally) {
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let what = || {
        format!(
            "{} {:?}\n{} {:?}",
            a.known.name, a.transform, b.known.name, b.transform
        )
    };
    let size = a.size() + b.size();
    let exact = EXACT * size + f64::from(tests.tolerance());
    let near = tests
        .closest_points(a.placed(), b.placed(), &mut workspace)
        .expect("all is known");
    let meets = tests.intersects(a.placed(), b.placed(), &mut workspace);
    assert_eq!(
        meets,
        tests.intersects(b.placed(), a.placed(), &mut workspace),
        "{}",
        what()
    );
    let contact = tests.contact(a.placed(), b.placed(), &mut workspace);
    assert_eq!(contact.is_some(), meets, "{}", what());
    let points = near.points.map(Vec3::as_dvec3);
    for (at, point) in [a, b].iter().zip(points) {
        let excess = at.excess(point, around);
        assert!(excess <= exact, "{point} is {excess} outside\n{}", what());
    }
    if near.distance > 0.0 {
        tally.apart += 1;
        let normal = near.offset.as_dvec3().normalize();
        let apart = gap(a, b, normal);
        // The shorter a vector of 32-bit numbers is, the less is known of its direction.
        let doubt = 5e-7 * size * size / f64::from(near.distance);
        assert!(
            apart >= f64::from(near.distance) - exact - doubt,
            "{} apart, {apart} for certain\n{}",
            near.distance,
            what()
        );
        assert!((points[1] - points[0]).length() <= f64::from(near.distance) + exact);
        if f64::from(near.distance) > exact {
            assert!(!meets, "{} apart\n{}", near.distance, what());
        }
    } else {
        tally.together += 1;
        assert!(meets, "{}", what());
    }
    if let Some(contact) = contact {
        let normal = contact.normal.as_dvec3();
        assert!((normal.length() - 1.0).abs() < 1e-5);
        let along = -gap(a, b, normal);
        let depth = f64::from(contact.depth);
        let deep = DEEP * size.min(20.0) + exact;
        assert!(
            (along - depth).abs() <= deep,
            "{depth} deep, {along} along its normal\n{}",
            what()
        );
        let least = around
            .iter()
            .map(|way| -gap(a, b, *way))
            .fold(f64::INFINITY, f64::min);
        assert!(
            depth <= least.max(0.0) + deep,
            "{depth} deep, {least} at most\n{}",
            what()
        );
        for at in [a, b] {
            let excess = at.excess(contact.point.as_dvec3(), around);
            assert!(
                excess <= deep,
                "the contact is {excess} outside\n{}",
                what()
            );
        }
    }
    check_casts(a, b, rng, tally);
}

fn check_casts(a: &At, b: &At, rng: &mut Rng, tally: &mut Tally) {
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let what = || {
        format!(
            "{} {:?}\n{} {:?}",
            a.known.name, a.transform, b.known.name, b.transform
        )
    };
    let size = a.size() + b.size();
    let exact = (EXACT * size) as f32 + tests.tolerance();
    // Towards somewhere near the other.
    let aim = pose(rng, 1.0, false).translation + b.transform.translation - a.transform.translation;
    let Ok((direction, length)) = Dir3::new_and_length(aim) else {
        return;
    };
    let max_distance = 2.0 * length;
    let moved = |distance: f32| Transform {
        translation: a.transform.translation + direction * distance,
        ..a.transform
    };
    let distance_at = |distance: f32, workspace: &mut Workspace| {
        let there = moved(distance);
        let there = Placed::new(&a.known.shape, &there);
        tests
            .closest_points(there, b.placed(), workspace)
            .unwrap()
            .distance
    };
    let hit = tests.sweep(
        a.placed(),
        direction,
        max_distance,
        b.placed(),
        &mut workspace,
    );
    let until = hit.map_or(max_distance, |hit| hit.distance);
    if let Some(hit) = hit {
        tally.swept += 1;
        let there = distance_at(hit.distance, &mut workspace);
        assert!(
            there <= 2.0 * exact,
            "{there} apart after {}\n{}",
            hit.distance,
            what()
        );
    }
    for step in 0..12 {
        let distance = until * (step as f32 / 12.0);
        if distance < until - 50.0 * exact {
            let there = distance_at(distance, &mut workspace);
            assert!(
                there > 0.0,
                "met before {until}, at {distance} {direction:?}\n{}",
                what()
            );
        }
    }
    // On a turn.
    let end = Transform {
        translation: a.transform.translation + aim * 1.5,
        rotation: pose(rng, 0.0, false).rotation,
        ..a.transform
    };
    let moving = Moving::new(&a.known.shape, &a.transform, &end);
    let still = Moving::resting(b.placed());
    if let Ok(bounds) = tests.swept_aabb(&moving) {
        for share in [0.0, 0.3, 0.7, 1.0] {
            let at = At::new(a.known, moving.at(share));
            for axis in DVec3::AXES {
                let high = f64::from(Vec3::from(bounds.max).dot(axis.as_vec3()));
                let low = f64::from(Vec3::from(bounds.min).dot(axis.as_vec3()));
                assert!(at.reach(axis) <= high + 1e-5 * size, "{}", what());
                assert!(-at.reach(-axis) >= low - 1e-5 * size, "{}", what());
            }
        }
    }
    let begins_apart = distance_at(0.0, &mut workspace) > 0.0;
    let met = tests.time_of_impact(&moving, &still, &mut workspace);
    let until = met.map_or(1.0, |met| met.time);
    let touches = |time: f32, workspace: &mut Workspace| {
        let at = moving.at(time);
        let at = Placed::new(&a.known.shape, &at);
        tests
            .closest_points(at, b.placed(), workspace)
            .unwrap()
            .distance
    };
    if let Some(met) = met {
        tally.met += 1;
        let there = touches(met.time, &mut workspace);
        assert!(
            there <= 10.0 * exact,
            "{there} apart at {}\n{}",
            met.time,
            what()
        );
    }
    for step in 0..12 {
        let time = until * (step as f32 / 12.0) - 1e-3;
        // Two that touch at the start may part, and meet again.
        if time > 0.0 && begins_apart {
            let there = touches(time, &mut workspace);
            assert!(
                there > 0.0,
                "met before {until}, at {time}\n{}\n{end:?}",
                what()
            );
        }
    }
}

fn check_alone(at: &At, around: &[DVec3], rng: &mut Rng, tally: &mut Tally) {
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let what = || format!("{} {:?}", at.known.name, at.transform);
    let exact = EXACT * at.size() + f64::from(tests.tolerance());
    let aabb = at.known.shape.world_aabb(&at.transform).unwrap();
    for axis in DVec3::AXES {
        let (low, high) = (
            Vec3::from(aabb.min).as_dvec3(),
            Vec3::from(aabb.max).as_dvec3(),
        );
        assert!(at.reach(axis) <= high.dot(axis) + exact, "{}", what());
        assert!(-at.reach(-axis) >= low.dot(axis) - exact, "{}", what());
    }
    for _ in 0..8 {
        let reach = (at.size() as f32) * 0.25;
        let point = at.transform.translation + pose(rng, reach, false).translation;
        let closest = tests
            .closest_point(at.placed(), point, &mut workspace)
            .unwrap();
        let excess = at.excess(closest.as_dvec3(), around);
        assert!(excess <= exact, "{closest} is {excess} outside\n{}", what());
        let offset = (point - closest).as_dvec3();
        let mote = Shape::sphere(0.0);
        let here = Transform::from_translation(point);
        let is_in = tests.intersects(Placed::new(&mote, &here), at.placed(), &mut workspace);
        if offset.length() > 2.0 * exact {
            tally.outside += 1;
            assert!(!is_in, "{point} {}", what());
            // What parts the point from the shape.
            let normal = offset.normalize();
            let beyond = normal.dot(point.as_dvec3()) - at.reach(normal);
            assert!(
                beyond >= offset.length() - exact,
                "{point}: {beyond} {}\n{}",
                offset.length(),
                what()
            );
        } else {
            assert!(is_in, "{point} {}", what());
        }
        let Ok(direction) =
            Dir3::new(at.transform.translation - point + pose(rng, 0.5, false).translation)
        else {
            continue;
        };
        let hit = tests.cast_ray(at.placed(), point, direction, 4.0 * reach);
        let along = |distance: f32| point + direction * distance;
        let until = hit.map_or(4.0 * reach, |hit| hit.distance);
        if let Some(hit) = hit {
            tally.hit += 1;
            let excess = at.excess(along(hit.distance).as_dvec3(), around);
            assert!(excess <= 4.0 * exact, "{hit:?} {}", what());
            if hit.distance > 0.0 {
                let normal = hit.normal.as_dvec3();
                let behind = at.reach(normal) - normal.dot(hit.point.as_dvec3());
                assert!(
                    behind.abs() <= 0.02 * at.size().min(20.0),
                    "{behind} {hit:?} {}",
                    what()
                );
            }
        }
        for step in 0..16 {
            let distance = until * (step as f32 / 16.0);
            if distance < until - 8.0 * exact as f32 {
                let here = Transform::from_translation(along(distance));
                let mote = Placed::new(&mote, &here);
                let is_in = tests.intersects(mote, at.placed(), &mut workspace);
                assert!(!is_in, "met before {until}, at {distance}: {}", what());
            }
        }
    }
}

#[derive(Debug, Default)]
struct Tally {
    apart: u32,
    together: u32,
    swept: u32,
    met: u32,
    hit: u32,
    outside: u32,
}

#[test]
fn all_pairs_of_convex_shapes_pass_all_tests() {
    let around = directions(1500);
    let mut rng = Rng::with_seed(13);
    let mut tally = Tally::default();
    for round in 0..ROUNDS {
        let kinds = kinds(&mut rng);
        for a in &kinds {
            let scaled = round % 3 == 2;
            let a = At::new(a, pose(&mut rng, 2.0, scaled));
            check_alone(&a, &around, &mut rng, &mut tally);
            for b in &kinds {
                let reach = if round % 2 == 0 { 1.5 } else { 4.0 };
                let b = At::new(b, pose(&mut rng, reach, scaled));
                check_pair(&a, &b, &around, &mut rng, &mut tally);
            }
        }
    }
    let Tally {
        apart,
        together,
        swept,
        met,
        hit,
        outside,
    } = tally;
    assert!(
        [apart, together, swept, met, hit, outside]
            .iter()
            .all(|count| *count > 300),
        "{tally:?}"
    );
}
