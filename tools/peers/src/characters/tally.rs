//! What is told of a run, in numbers.

use bevy::math::{Vec2, Vec3};
use serde::Serialize;

use super::{
    HALF_HEIGHT, RADIUS, Run, SPEED, TICK,
    judge::Judge,
    scenes::{Aim, Place},
};
use crate::measure::median;

/// Deeper than that in something is in it, in length units.
const IN: f64 = 1e-3;
/// Who is so far below the lowest ground has fallen.
const BELOW: f32 = 2.0;
/// Further than that from all things, a character is in the air.
const AIRBORNE: f64 = 0.05;
/// A step is climbed once the feet are this close to its level.
const CLIMBED: f32 = 0.05;
/// So many ticks it takes to come to rest.
const SETTLING: usize = 60;
/// A motion that is no longer than this is none.
const STILL: f32 = 1e-4;

/// A number with a name.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// What it is, as the head of a column.
    pub name: String,
    pub value: f64,
    /// How many digits are shown behind the point.
    #[serde(skip)]
    pub digits: usize,
}

impl Figure {
    fn new(name: impl Into<String>, value: f64, digits: usize) -> Self {
        let name = name.into();
        Self {
            name,
            value,
            digits,
        }
    }
}

/// The name of the first figure of all: how long a character takes.
pub const TIME: &str = "µs";

/// All figures of a run.
pub fn tally(place: &Place, run: &Run, judge: &Judge) -> Vec<Figure> {
    let characters = place.walkers.len();
    let gaps: Vec<Vec<f64>> = run
        .bodies
        .iter()
        .map(|bodies| bodies.iter().map(|body| judge.gap(body.position)).collect())
        .collect();
    let all = gaps.iter().flatten();
    let deepest = all.clone().copied().fold(0.0, f64::min).abs() / f64::from(RADIUS);
    let percent = |count: usize| 100.0 * count as f64 / (characters * run.bodies.len()) as f64;
    let is_low = |height: f32| height < place.lowest - BELOW;
    let last = run.bodies.last().into_iter().flatten();
    let fallen = last.filter(|body| is_low(body.position.y)).count();
    let times = run.times.iter().map(|time| time * 1e6 / characters as f64);
    let mut figures = vec![
        Figure::new(TIME, median(times), 2),
        Figure::new("deepest", deepest, 4),
        Figure::new("in, %", percent(all.filter(|gap| **gap < -IN).count()), 2),
        Figure::new("fallen", fallen as f64, 0),
    ];
    let mut groups: Vec<&str> = vec![];
    for (group, _) in &place.walkers {
        if groups.last() != Some(group) {
            groups.push(group);
        }
    }
    for group in groups {
        let of_group = place.walkers.iter().enumerate();
        let of_group = of_group.filter(|(_, (name, _))| *name == group);
        let numbers: Vec<usize> = of_group.map(|(number, _)| number).collect();
        figures.extend(of(group, &numbers, place, run, &gaps));
    }
    figures
}

/// What is told of a group, by what its first character is there for.
fn of(group: &str, numbers: &[usize], place: &Place, run: &Run, gaps: &[Vec<f64>]) -> Vec<Figure> {
    let first = numbers[0];
    let each = numbers.iter().map(|number| Track {
        number: *number,
        place,
        run,
    });
    let ticks = run.bodies.len();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    match place.walkers[first].1.aim {
        Aim::Way => {
            let wanted = f64::from(SPEED * TICK) * ticks as f64;
            let ways: Vec<_> = each.map(|track| track.flat_way() / wanted).collect();
            let grounded = run.bodies.iter().flatten();
            let grounded = grounded.filter(|body| body.is_grounded).count();
            let grounded = 100.0 * grounded as f64 / (numbers.len() * ticks) as f64;
            vec![
                Figure::new("way", mean(&ways), 3),
                Figure::new("grounded, %", grounded, 1),
            ]
        }
        Aim::Along(..) => {
            let kept: Vec<_> = each.map(|track| track.kept()).collect();
            let least = kept.iter().copied().fold(f64::INFINITY, f64::min);
            vec![
                Figure::new(format!("{group}: kept"), mean(&kept), 3),
                Figure::new("least", least, 3),
            ]
        }
        Aim::Climb(steps, height) => {
            let climbed: Vec<_> = each
                .map(|track| f64::from(track.climbed(height).min(steps)))
                .collect();
            vec![Figure::new(format!("{group}: climbed"), mean(&climbed), 0)]
        }
        Aim::Descend => {
            let airborne = gaps.iter().filter(|gaps| gaps[first] > AIRBORNE);
            let airborne = airborne.count() as f64;
            vec![Figure::new(format!("{group}: airborne"), airborne, 0)]
        }
        Aim::Stay => {
            let [turns, drift] = each.fold([0.0; 2], |[turns, drift], track| {
                let [more, further] = track.unrest();
                [turns + more, drift + further]
            });
            vec![
                Figure::new(format!("{group}: turns"), turns, 0),
                Figure::new("drift", drift, 4),
            ]
        }
    }
}

/// Where one character was.
struct Track<'a> {
    number: usize,
    place: &'a Place,
    run: &'a Run,
}

impl Track<'_> {
    /// From the start to the end.
    fn positions(&self) -> impl Iterator<Item = Vec3> + Clone {
        let start = self.place.walkers[self.number].1.start;
        let bodies = self.run.bodies.iter();
        std::iter::once(start).chain(bodies.map(|bodies| bodies[self.number].position))
    }

    /// From tick to tick.
    fn motions(&self) -> impl Iterator<Item = Vec3> + Clone {
        let to = self.positions().skip(1);
        self.positions().zip(to).map(|(from, to)| to - from)
    }

    fn flat_way(&self) -> f64 {
        self.motions()
            .map(|motion| f64::from(Vec2::new(motion.x, motion.z).length()))
            .sum()
    }

    fn kept(&self) -> f64 {
        let Aim::Along(along, each) = self.place.walkers[self.number].1.aim else {
            return f64::NAN;
        };
        let ticks = self.run.bodies.len() as f64;
        let whole: Vec3 = self.motions().sum();
        f64::from(along.dot(Vec2::new(whole.x, whole.z))) / (f64::from(each) * ticks)
    }

    /// Levels, one as high above another.
    fn climbed(&self, height: f32) -> u32 {
        let feet = self.positions().map(|position| position.y - HALF_HEIGHT);
        let highest = feet.fold(0.0, f32::max);
        ((highest + CLIMBED) / height) as u32
    }

    /// Turns and drift.
    fn unrest(&self) -> [f64; 2] {
        let motions = || self.motions().skip(SETTLING);
        let turns = motions().zip(motions().skip(1)).filter(|(one, next)| {
            one.length() > STILL && next.length() > STILL && one.dot(*next) < 0.0
        });
        let drift = motions().map(|motion| f64::from(motion.length())).sum();
        [turns.count() as f64, drift]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characters::{
        engines::Body,
        scenes::{Course, Walker},
    };

    fn figures(aim: Aim, positions: impl IntoIterator<Item = Vec3>) -> Vec<Figure> {
        let course = Course::Straight(Vec2::X);
        let start = Vec3::Y * HALF_HEIGHT;
        let walker = Walker { start, course, aim };
        let place = Place {
            solids: vec![],
            walkers: vec![("it", walker)],
            lowest: 0.0,
            ticks: 0,
        };
        let bodies = positions.into_iter().map(|at| vec![Body::new(start + at)]);
        let bodies: Vec<_> = bodies.collect();
        let times = vec![1e-6; bodies.len()];
        let run = Run { times, bodies };
        tally(&place, &run, &Judge::new(&place.solids))
    }

    fn value(figures: &[Figure], name: &str) -> f64 {
        let figure = figures.iter().find(|figure| figure.name == name);
        figure.map_or(f64::NAN, |figure| figure.value)
    }

    #[test]
    fn ways_are_shares_of_what_was_wanted() {
        let each = SPEED * TICK;
        let steps = (1..=60).map(|tick| Vec3::new(0.5 * each * tick as f32, 0.0, 0.0));
        let found = figures(Aim::Way, steps.clone());
        assert!((value(&found, "way") - 0.5).abs() < 1e-4);
        assert!((value(&found, TIME) - 1.0).abs() < 1e-9);
        let found = figures(Aim::Along(Vec2::X, each), steps);
        assert!((value(&found, "least") - 0.5).abs() < 1e-4);
    }

    #[test]
    fn steps_count_once_the_feet_are_there() {
        let found = figures(Aim::Climb(10, 0.2), [0.1, 0.62].map(|y| Vec3::Y * y));
        assert_eq!(value(&found, "it: climbed"), 3.0);
    }

    #[test]
    fn who_goes_to_and_fro_is_not_at_rest() {
        let steps = (0..SETTLING + 100).map(|tick| Vec3::X * (0.01 * (tick % 2) as f32));
        let found = figures(Aim::Stay, steps);
        assert_eq!(value(&found, "it: turns"), 99.0);
        assert!((value(&found, "drift") - 1.0).abs() < 1e-3);
        let found = figures(Aim::Stay, [Vec3::ZERO; SETTLING + 100]);
        assert_eq!(value(&found, "drift"), 0.0);
    }

    #[test]
    fn who_is_below_all_has_fallen() {
        let found = figures(Aim::Way, [Vec3::Y * -9.0]);
        assert_eq!(value(&found, "fallen"), 1.0);
    }
}
