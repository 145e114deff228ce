//! Beyond the report: how the time of a step grows up to a hundred thousand objects.

use std::{
    fmt::Write as _,
    time::{Duration, Instant},
};

use bevy_octree::scene::TestSet;

use super::{
    measure::{Laboratory, Row},
    output::{Output, significant},
    stats::{Estimate, Line, fit_line, median},
};
use crate::{outcome::Outcome, progress::Progress};

/// The octree's exponent is to be below this.
const NEARLY_LINEAR: f64 = 1.15;

/// The line is fitted from so many rings on: below, what a step costs whatever the number of
/// objects still shows.
const FITTED_FROM: u32 = 20;

/// How the growth is measured.
pub struct Plan {
    /// The sets, from small to large.
    pub sets: Vec<TestSet>,
    /// The octrees, by their N.
    pub octrees: Vec<Row>,
    pub steps: u32,
    pub repeats: u32,
    /// The time that exhaustive search may take in all.
    pub budget: Duration,
    pub seed: u64,
}

/// How the time of a step grows.
pub struct Growth {
    /// The octrees, then exhaustive search.
    pub curves: Vec<Curve>,
    /// The sets that exhaustive search had no time for.
    left_out: Vec<TestSet>,
}

/// The growth of one way to search.
pub struct Curve {
    pub row: Row,
    pub points: Vec<Point>,
}

/// The time of a step on one set.
pub struct Point {
    pub set: TestSet,
    pub steps: u32,
    /// Microseconds per step, by repeat.
    pub times: Vec<f64>,
    pairs: u64,
}

impl Point {
    const fn new(set: TestSet, steps: u32) -> Self {
        Self {
            set,
            steps,
            times: Vec::new(),
            pairs: 0,
        }
    }

    pub fn objects(&self) -> f64 {
        self.set.object_count() as f64
    }

    fn measure(&mut self, row: Row, laboratory: &mut Laboratory) -> Outcome {
        let run = laboratory.run(&self.set, row, self.steps)?;
        self.times
            .push(run.time.as_secs_f64() * 1e6 / f64::from(self.steps));
        self.pairs = run.counters.pairs_tested;
        Ok(())
    }
}

impl Curve {
    /// The line through the logarithms of objects and time: its slope is the exponent of growth.
    pub fn fit(&self) -> Option<Line> {
        let points = self.fitted().iter();
        fit_line(
            &points
                .map(|point| (point.objects().ln(), median(&point.times).mid.ln()))
                .collect::<Vec<_>>(),
        )
    }

    /// The points that the line is fitted to.
    pub fn fitted(&self) -> &[Point] {
        &self.points[self
            .points
            .partition_point(|point| point.set.rings < FITTED_FROM)..]
    }

    /// The rings of the smallest and the largest set that the line is fitted to.
    fn fitted_rings(&self) -> [u32; 2] {
        [
            FITTED_FROM,
            self.points.last().map_or(0, |point| point.set.rings),
        ]
    }
}

impl Growth {
    pub fn measure(plan: &Plan, laboratory: &mut Laboratory) -> Outcome<Self> {
        let mut curves = octrees(plan, laboratory)?;
        let (exhaustive, left_out) = exhaustive(plan, laboratory)?;
        curves.push(exhaustive);
        Ok(Self { curves, left_out })
    }

    /// The octree that is fastest on the sets that the line is fitted to, together.
    fn best(&self) -> &Curve {
        let octrees = self.curves.iter().filter(|curve| curve.row.is_divided());
        let time = |curve: &Curve| {
            curve
                .fitted()
                .iter()
                .map(|point| median(&point.times).mid.ln())
                .sum::<f64>()
        };
        octrees
            .min_by(|a, b| time(a).total_cmp(&time(b)))
            .expect("octrees are measured")
    }

    /// Writes `growth.csv`.
    pub fn write(&self, output: &Output) -> Outcome {
        output.csv("growth.csv", |csv| {
            csv.write_record([
                "row",
                "rings",
                "objects",
                "steps",
                "repeats",
                "us_per_step",
                "low",
                "high",
                "pairs_tested_per_step",
            ])?;
            for Curve { row, points } in &self.curves {
                for point in points {
                    let Estimate { low, mid, high } = median(&point.times);
                    csv.write_record([
                        row.to_string(),
                        point.set.rings.to_string(),
                        point.set.object_count().to_string(),
                        point.steps.to_string(),
                        point.times.len().to_string(),
                        format!("{mid:.3}"),
                        format!("{low:.3}"),
                        format!("{high:.3}"),
                        format!("{:.1}", point.pairs as f64 / f64::from(point.steps)),
                    ])?;
                }
            }
            Ok(())
        })
    }

    /// The growth in words.
    pub fn text(&self) -> String {
        let mut text = String::from(
            "\n## How does the time of a step grow?\n\n\
             Median time of a step in microseconds, and in nanoseconds per object.\n\n\
             | method | rings | objects | steps | runs | µs per step | ns per object | pairs compared per object |\n\
             | --- | --: | --: | --: | --: | --: | --: | --: |\n",
        );
        for Curve { row, points } in &self.curves {
            for point in points {
                let time = median(&point.times).mid;
                let pairs = point.pairs as f64 / f64::from(point.steps) / point.objects();
                let [per_object, time, pairs] =
                    [1e3 * time / point.objects(), time, pairs].map(significant);
                let Point {
                    set, steps, times, ..
                } = point;
                let (rings, objects, repeats) = (set.rings, set.object_count(), times.len());
                let figures = format!(
                    "{rings} | {objects} | {steps} | {repeats} | {time} | {per_object} | {pairs}"
                );
                _ = writeln!(text, "| {row} | {figures} |");
            }
        }
        if !self.left_out.is_empty() {
            let names: Vec<String> = self.left_out.iter().map(TestSet::name).collect();
            _ = writeln!(
                text,
                "\nExhaustive search had no time left for {}: see `--budget`.",
                names.join(", ")
            );
        }
        text.push('\n');
        for curve in &self.curves {
            let [first, last] = curve.fitted_rings();
            _ = match curve.fit() {
                Some(Line {
                    slope: Estimate { low, mid, high },
                    ..
                }) => writeln!(
                    text,
                    "- {}: time ∝ objects^**{mid:.3}** (95 % confidence: {low:.3} to {high:.3}) from r = {first} to \
                     r = {last}.",
                    curve.row
                ),
                None => writeln!(
                    text,
                    "- {}: no exponent, for want of three sizes from r = {first} on.",
                    curve.row
                ),
            };
        }
        text
    }

    /// Whether the octree's time grows nearly in proportion to the objects, in one line.
    pub fn acceptance(&self) -> String {
        let best = self.best();
        let [first, last] = best.fitted_rings();
        let claim = format!(
            "The octree's exponent from r = {first} to r = {last}, at the N that is fastest there ({}), is below \
             {NEARLY_LINEAR}",
            best.row
        );
        let Some(Line {
            slope: Estimate { low, mid, high },
            ..
        }) = best.fit()
        else {
            return format!(
                "{claim}: **not decided** (fewer than three sizes; see `--max-rings`)."
            );
        };
        let verdict = if high < NEARLY_LINEAR {
            "holds"
        } else if mid < NEARLY_LINEAR {
            "holds, though not for all of the interval"
        } else {
            "does not hold"
        };
        format!("{claim}: **{verdict}** ({mid:.3}, 95 % confidence {low:.3} to {high:.3}).")
    }
}

/// In an order that is shuffled anew in each repeat.
fn octrees(plan: &Plan, laboratory: &mut Laboratory) -> Outcome<Vec<Curve>> {
    let mut random = fastrand::Rng::with_seed(plan.seed);
    let points = || {
        plan.sets
            .iter()
            .map(|set| Point::new(*set, plan.steps))
            .collect()
    };
    let mut curves: Vec<Curve> = plan
        .octrees
        .iter()
        .map(|row| Curve {
            row: *row,
            points: points(),
        })
        .collect();
    let mut order: Vec<_> = (0..curves.len())
        .flat_map(|row| (0..plan.sets.len()).map(move |set| (row, set)))
        .collect();
    let mut progress = Progress::new(u64::from(plan.repeats) * order.len() as u64);
    for _ in 0..plan.repeats {
        random.shuffle(&mut order);
        for &(row, set) in &order {
            let Curve { row, points } = &mut curves[row];
            progress.begin(format!("growth: {}, {row}", plan.sets[set].name()));
            points[set].measure(*row, laboratory)?;
        }
    }
    Ok(curves)
}

/// From small to large, with fewer steps and then fewer repeats as time runs short.
fn exhaustive(plan: &Plan, laboratory: &mut Laboratory) -> Outcome<(Curve, Vec<TestSet>)> {
    let row = Row::Exhaustive;
    let started = Instant::now();
    let mut points: Vec<Point> = Vec::new();
    let mut progress = Progress::new(plan.sets.len() as u64);
    for (index, set) in plan.sets.iter().enumerate() {
        progress.begin(format!("growth: {}, {row}", set.name()));
        let left = plan.budget.saturating_sub(started.elapsed()).as_secs_f64();
        // The time of a step grows with the square of the objects.
        let step = points.last().map_or(0.0, |point| {
            median(&point.times).mid * 1e-6 * (set.object_count() as f64 / point.objects()).powi(2)
        });
        let Some((repeats, steps)) = share(plan, left, plan.sets.len() - index, step) else {
            return Ok((Curve { row, points }, plan.sets[index..].to_vec()));
        };
        let mut point = Point::new(*set, steps);
        for _ in 0..repeats {
            point.measure(row, laboratory)?;
        }
        points.push(point);
    }
    Ok((Curve { row, points }, Vec::new()))
}

/// How many repeats of how many steps of `step` seconds fit in this set's share of the seconds that
/// are left; `None` if not one does in all of them.
fn share(plan: &Plan, left: f64, sets: usize, step: f64) -> Option<(u32, u32)> {
    // The update that takes up the objects costs as much as a step.
    let shortest = 2.0 * step;
    if left <= 0.0 || shortest > left {
        return None;
    }
    let share = left / sets as f64;
    let repeats = (share / shortest)
        .clamp(1.0, f64::from(plan.repeats))
        .floor();
    let steps = (share / repeats / step - 1.0)
        .clamp(1.0, f64::from(plan.steps))
        .floor();
    Some((repeats as u32, steps as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_given_up_before_repeats() {
        let plan = Plan {
            sets: Vec::new(),
            octrees: Vec::new(),
            steps: 200,
            repeats: 5,
            budget: Duration::from_secs(10),
            seed: 0,
        };
        assert_eq!(share(&plan, 10.0, 1, 0.0), Some((5, 200)));
        assert_eq!(share(&plan, 10.0, 1, 0.1), Some((5, 19)));
        assert_eq!(share(&plan, 10.0, 2, 1.0), Some((2, 1)));
        assert_eq!(share(&plan, 10.0, 2, 5.0), Some((1, 1)));
        assert_eq!(share(&plan, 10.0, 1, 6.0), None);
        assert_eq!(share(&plan, 0.0, 1, 0.0), None);
    }
}
