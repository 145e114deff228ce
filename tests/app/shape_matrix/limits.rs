//! What is met does not depend on how far is looked, as long as that is a little further: a search for the first looks no
//! further than the best so far, and which of several that are as near is asked about first makes no difference then.

use std::collections::BTreeMap;

use bevy::{math::Dir3, prelude::*};
use bevy_octree::narrow_phase::{
    Impact, NarrowPhase, Placed, RayCastOptions, ShapeCastOptions, Workspace,
};
use fastrand::Rng;

use super::{known::pose, whole::wholes};

const FAR: f32 = 1000.0;
const ROUNDS: usize = 6;

/// All of an impact, as bits.
fn bits(impact: Impact) -> (u32, [[u32; 3]; 3], Option<u32>, u32) {
    let vectors = [impact.point, impact.normal, impact.face_normal];
    let vectors = vectors.map(|vector| vector.to_array().map(f32::to_bits));
    let (distance, depth) = (impact.distance.to_bits(), impact.depth.to_bits());
    (distance, vectors, impact.polygon, depth)
}

/// Often along an axis, or across one.
fn direction(rng: &mut Rng) -> Dir3 {
    loop {
        let coordinate = |rng: &mut Rng| match rng.u32(0..3) {
            0 => 0.0,
            _ => rng.f32() * 2.0 - 1.0,
        };
        let along = Vec3::from_array([0; 3].map(|_| coordinate(rng)));
        if let Ok(direction) = Dir3::new(along) {
            return direction;
        }
    }
}

/// How many are met, and how many of these differently, or not at all, if no further is looked than a limit, by the
/// question.
#[derive(Default)]
struct Tally(BTreeMap<&'static str, [u32; 2]>);

impl Tally {
    fn check(
        &mut self,
        question: &'static str,
        what: &str,
        mut ask: impl FnMut(f32) -> Option<Impact>,
    ) {
        let Some(met) = ask(FAR) else { return };
        let [all, others] = self.0.entry(question).or_default();
        *all += 1;
        let a_little = met.distance * (1.0 + 1e-4) + 1e-4;
        for limit in [a_little, 2.0 * met.distance + 1.0] {
            let near = ask(limit);
            if near.map(bits) != Some(bits(met)) {
                *others += 1;
                println!("{question}, up to {limit}, {what}: {met:?}, {near:?}");
            }
        }
    }
}

#[test]
fn what_is_met_is_the_same_however_far_is_looked() {
    let (mut rng, mut tally) = (Rng::with_seed(77), Tally::default());
    let (all, tests, mut workspace) = (
        wholes(&mut rng),
        NarrowPhase::default(),
        Workspace::default(),
    );
    let onwards = ShapeCastOptions::DEFAULT.ignore_start().find_polygon();
    let ray_onwards = RayCastOptions::DEFAULT.ignore_start();
    for (a, b) in all.iter().flat_map(|a| all.iter().map(move |b| (a, b))) {
        for round in 0..ROUNDS {
            let at = pose(&mut rng, 3.0, round % 2 == 0);
            let mut there = pose(&mut rng, 3.0, round % 3 == 0);
            let along = direction(&mut rng);
            there.translation += along * [3.0, 30.0][round % 2];
            let (moving, target) = (Placed::new(&a.shape, &at), Placed::new(&b.shape, &there));
            let what = format!("{} at {at:?}, {} at {there:?}", a.name, b.name);
            let (what, from, workspace) = (&*what, at.translation, &mut workspace);
            tally.check("a shape", what, |limit| {
                tests.sweep(moving, along, limit, target, workspace)
            });
            tally.check("a shape, off its start", what, |limit| {
                tests.sweep_with(moving, along, limit, target, &onwards, workspace)
            });
            tally.check("a ray", what, |limit| {
                tests.cast_ray(target, from, along, limit)
            });
            tally.check("a ray, off its start", what, |limit| {
                tests.cast_ray_with(target, from, along, limit, &ray_onwards)
            });
        }
    }
    for (question, [met, others]) in tally.0 {
        println!("{question}: {met} met, {others} differ");
        assert!(met > 10 && others == 0, "{question}: {met}, {others}");
    }
}
