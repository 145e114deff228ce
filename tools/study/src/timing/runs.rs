//! The study several times over: what differs between runs, no repeat within one shows.

use std::fmt::Write as _;

use super::{
    answers::{largest_ratio, place_of_crossover},
    measure::Row,
    output::significant,
    stats::{Estimate, mean},
    table::Table,
};

/// What each run gave, the octree at one N against exhaustive search.
pub struct Runs {
    best: Row,
    /// The largest set, and how many objects it has.
    set: String,
    objects: usize,
    ratios: Vec<f64>,
    crossovers: Vec<f64>,
}

impl Runs {
    /// No runs yet, of an octree that was the best in the first of them.
    pub fn new(best: Row) -> Self {
        Self {
            best,
            set: String::new(),
            objects: 0,
            ratios: Vec::new(),
            crossovers: Vec::new(),
        }
    }

    /// Takes what a run gave.
    pub fn push(&mut self, table: &Table) {
        if let Some(set) = table.sets.last() {
            self.set = set.name();
            self.objects = set.object_count();
        }
        self.ratios.push(largest_ratio(table, self.best));
        self.crossovers.push(place_of_crossover(table, self.best));
    }

    /// In Markdown.
    pub fn text(&self) -> String {
        let Self {
            best,
            set,
            objects,
            ratios,
            crossovers,
        } = self;
        let logarithms: Vec<f64> = ratios.iter().map(|ratio| ratio.ln()).collect();
        let ratio = mean(&logarithms).map(|mean| mean.map(f64::exp));
        let crossover = crossovers
            .iter()
            .all(|objects| objects.is_finite() && *objects > 0.0)
            .then(|| mean(crossovers))
            .flatten();
        let mut text = format!(
            "\n## How much differs from run to run?\n\n\
             The table measured {} times, each in another order and with a warm-up of its own; the octree at {best} \
             against exhaustive search. Means over the runs (of ratios, geometric), with the intervals of 95 % \
             confidence that Student's distribution gives.\n\n\
             | | mean | 95 % | of the runs |\n| --- | --: | --- | --- |\n",
            ratios.len()
        );
        let mut row = |name: &str, estimate: Option<Estimate>, runs: &[f64]| {
            let [mean, interval] = match estimate {
                Some(Estimate { low, mid, high }) => [
                    significant(mid),
                    format!("{} to {}", significant(low), significant(high)),
                ],
                None => ["–".to_owned(), "–".to_owned()],
            };
            let runs: Vec<String> = runs.iter().map(|value| significant(*value)).collect();
            _ = writeln!(
                text,
                "| {name} | {mean} | {interval} | {} |",
                runs.join(", ")
            );
        };
        row(
            &format!("ratio of times on {set}, {objects} objects"),
            ratio,
            ratios,
        );
        row("crossover [objects]", crossover, crossovers);
        text
    }
}
