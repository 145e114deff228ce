//! The measurements of Table 1.

use std::fmt::Write as _;

use bevy_octree::scene::TestSet;

use super::{
    measure::{Laboratory, Row},
    output::{Output, significant},
    stats::{Estimate, median},
};
use crate::{outcome::Outcome, progress::Progress};

/// The seconds of Table 1 of Swan, *Fast Collision Detection with an N-Objects Octree*, 1994: t0 to
/// t10 on a workstation with a 75 MHz processor. Facts, for comparison.
const SECONDS_OF_1994: [(&str, [f64; 11]); 5] = [
    (
        "N = 5",
        [
            2.55, 12.1, 33.9, 72.9, 120., 192., 255., 344., 447., 571., 726.,
        ],
    ),
    (
        "N = 10",
        [
            2.85, 11.8, 34.3, 70.8, 118., 178., 246., 333., 448., 559., 688.,
        ],
    ),
    (
        "N = 30",
        [
            2.77, 13.6, 33.7, 70.3, 117., 181., 250., 337., 443., 550., 693.,
        ],
    ),
    (
        "N = 50",
        [
            2.86, 12.2, 33.9, 72.1, 116., 178., 250., 337., 443., 559., 674.,
        ],
    ),
    (
        "N = big",
        [
            2.49, 11.9, 33.6, 69.2, 116., 183., 266., 377., 474., 625., 791.,
        ],
    ),
];

/// How the table is measured.
pub struct Plan {
    pub sets: Vec<TestSet>,
    pub steps: u32,
    pub repeats: u32,
    pub seed: u64,
}

/// The table.
pub struct Table {
    pub sets: Vec<TestSet>,
    pub steps: u32,
    /// In the order of [`Row::ALL`], then of the sets.
    cells: Vec<Vec<Cell>>,
}

/// What was measured of one test set with one way to search.
#[derive(Clone, Default)]
pub struct Cell {
    /// Milliseconds for all steps, by repeat.
    pub times: Vec<f64>,
    /// Pairs compared in all steps: the same in each repeat.
    pub pairs: u64,
}

impl Table {
    /// Measures every cell once in each repeat, in an order that is shuffled anew each time, so
    /// that a machine that becomes slower or faster favours none. A first pass warms up and is
    /// thrown away.
    pub fn measure(plan: Plan, laboratory: &mut Laboratory) -> Outcome<Self> {
        let Plan {
            sets,
            steps,
            repeats,
            seed,
        } = plan;
        let mut random = fastrand::Rng::with_seed(seed);
        let mut cells = vec![vec![Cell::default(); sets.len()]; Row::ALL.len()];
        let mut order: Vec<_> = (0..Row::ALL.len())
            .flat_map(|row| (0..sets.len()).map(move |set| (row, set)))
            .collect();
        let mut progress = Progress::new(u64::from(repeats + 1) * order.len() as u64);
        for repeat in 0..=repeats {
            random.shuffle(&mut order);
            for &(row, set) in &order {
                progress.begin(format!("Table 1: {}, {}", sets[set].name(), Row::ALL[row]));
                let run = laboratory.run(&sets[set], Row::ALL[row], steps)?;
                let cell = &mut cells[row][set];
                cell.pairs = run.counters.pairs_tested;
                if repeat > 0 {
                    cell.times.push(run.time.as_secs_f64() * 1e3);
                }
            }
        }
        Ok(Self { sets, steps, cells })
    }

    /// The cells of a row, in the order of the sets.
    pub fn row(&self, row: Row) -> &[Cell] {
        let index = Row::ALL.iter().position(|other| *other == row);
        &self.cells[index.expect("every row is measured")]
    }

    /// The natural logarithms of the times of a cell, by repeat.
    pub fn logs(&self, row: Row, set: usize) -> Vec<f64> {
        self.row(row)[set]
            .times
            .iter()
            .map(|time| time.ln())
            .collect()
    }

    /// Writes `table1.csv`, `samples.csv` and `table1.md`; gives the text of the last.
    pub fn write(&self, output: &Output) -> Outcome<String> {
        output.csv("table1.csv", |csv| {
            let line =
                |csv: &mut csv::Writer<_>, row: &str, quantity: &str, values: Vec<String>| {
                    csv.write_record([row, quantity].into_iter().map(str::to_owned).chain(values))
                };
            let sets = self.sets.iter();
            line(
                csv,
                "row",
                "quantity",
                sets.clone().map(TestSet::name).collect(),
            )?;
            line(
                csv,
                "",
                "objects",
                sets.map(|set| set.object_count().to_string()).collect(),
            )?;
            for row in Row::ALL {
                let cells = self.row(row);
                let each = |f: &dyn Fn(Estimate) -> f64| -> Vec<String> {
                    cells
                        .iter()
                        .map(|cell| format!("{:.6}", f(median(&cell.times))))
                        .collect()
                };
                let row = row.to_string();
                line(csv, &row, "median_ms", each(&|time| time.mid))?;
                line(csv, &row, "low_ms", each(&|time| time.low))?;
                line(csv, &row, "high_ms", each(&|time| time.high))?;
                line(
                    csv,
                    &row,
                    "median_ms_per_step",
                    each(&|time| time.mid / f64::from(self.steps)),
                )?;
                line(
                    csv,
                    &row,
                    "pairs_tested",
                    cells.iter().map(|cell| cell.pairs.to_string()).collect(),
                )?;
            }
            Ok(())
        })?;
        output.csv("samples.csv", |csv| {
            csv.write_record(["set", "objects", "row", "repeat", "ms"])?;
            for row in Row::ALL {
                for (set, cell) in self.sets.iter().zip(self.row(row)) {
                    for (repeat, time) in cell.times.iter().enumerate() {
                        let (objects, repeat) =
                            (set.object_count().to_string(), (repeat + 1).to_string());
                        csv.write_record([
                            set.name(),
                            objects,
                            row.to_string(),
                            repeat,
                            format!("{time:.6}"),
                        ])?;
                    }
                }
            }
            Ok(())
        })?;
        let text = self.markdown();
        output.text("table1.md", &text)?;
        Ok(text)
    }

    fn markdown(&self) -> String {
        let steps = f64::from(self.steps);
        let repeats = self.row(Row::Exhaustive)[0].times.len();
        let interval = if repeats < 6 {
            "range"
        } else {
            "95 % confidence interval of the median"
        };
        let mut text = format!(
            "# Table 1, measured anew\n\n\
             Milliseconds for {} steps: median of {repeats} runs, and {interval} in brackets.\n\n\
             In it: all that an update of the app does (motion, bounds, octree maintenance, search, exact tests, \
             bounce, messages, and Bevy's `MinimalPlugins`). Not in it: making the app, and the update that takes up \
             the objects.\n\n",
            self.steps
        );
        self.grid(&mut text, |cell| {
            let Estimate { low, mid, high } = median(&cell.times);
            format!(
                "{} ({}–{})",
                significant(mid),
                significant(low),
                significant(high)
            )
        });
        text += "\n## Milliseconds per step\n\n";
        self.grid(&mut text, |cell| {
            significant(median(&cell.times).mid / steps)
        });
        text +=
            "\n## Pairs of boxes compared, per step\n\nFree of noise: the same in every run.\n\n";
        self.grid(&mut text, |cell| significant(cell.pairs as f64 / steps));
        text += "\n## The report's table of 1994\n\n\
                 *Seconds* for 200 steps, on one processor of 75 MHz. There, \"big\" stands for exhaustive search.\n\n";
        let all: Vec<TestSet> = (0..=10).map(TestSet::new).collect();
        header(&mut text, &all);
        for (row, seconds) in SECONDS_OF_1994 {
            line(&mut text, row, seconds.map(significant));
        }
        text
    }

    fn grid(&self, text: &mut String, entry: impl Fn(&Cell) -> String) {
        header(text, &self.sets);
        for row in Row::ALL {
            line(text, &row.to_string(), self.row(row).iter().map(&entry));
        }
    }
}

fn header(text: &mut String, sets: &[TestSet]) {
    line(text, "test set", sets.iter().map(TestSet::name));
    line(text, "---", sets.iter().map(|_| "--:".to_owned()));
    line(
        text,
        "objects",
        sets.iter().map(|set| set.object_count().to_string()),
    );
}

fn line(text: &mut String, title: &str, entries: impl IntoIterator<Item = String>) {
    _ = write!(text, "| {title} |");
    for entry in entries {
        _ = write!(text, " {entry} |");
    }
    text.push('\n');
}
