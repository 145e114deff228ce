//! What is printed.

use std::fmt;

use bevy_octree::scene::stress::StressScene;

use super::{
    bandwidth::Bandwidth,
    model::{Range, Stage, predict, threads_for},
};

/// The time of a tick at 60 Hz, in milliseconds.
const BUDGET_MS: f64 = 1000.0 / 60.0;

/// The stage that moves the objects of a stress scene: a game's own, and none of the library's.
const OF_THE_SCENE: &str = "motion";

/// What is said of one scene, in Markdown.
pub struct Tables<'a> {
    pub scene: StressScene,
    pub objects: usize,
    pub stages: &'a [Stage],
    pub bandwidth: &'a Bandwidth,
    pub threads: &'a [u32],
}

impl fmt::Display for Tables<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            scene,
            objects,
            stages,
            threads,
            ..
        } = self;
        writeln!(
            f,
            "### `{scene}`, {objects} objects: measured, and predicted\n"
        )?;
        write!(
            f,
            "| stage [ms] | 1 thread | 2 threads | serial | parallel share | memory traffic [B/object] |"
        )?;
        for threads in *threads {
            write!(f, " {threads} threads |")?;
        }
        write!(f, "\n|---|--:|--:|--:|--:|--:|")?;
        writeln!(f, "{}", "--:|".repeat(threads.len()))?;
        for stage in *stages {
            self.row(f, &stage.name, std::slice::from_ref(stage))?;
        }
        self.row(f, "**all**", stages)?;
        let own: Vec<Stage> = stages
            .iter()
            .filter(|stage| stage.name != OF_THE_SCENE)
            .cloned()
            .collect();
        if own.len() < stages.len() {
            self.row(f, &format!("**all but {OF_THE_SCENE}**"), &own)?;
        }
        writeln!(f)?;
        self.at_60_hz(f, &own)
    }
}

impl Tables<'_> {
    /// A row about some stages together.
    fn row(&self, f: &mut fmt::Formatter<'_>, name: &str, stages: &[Stage]) -> fmt::Result {
        let sum = |of: fn(&Stage) -> f64| stages.iter().map(of).sum::<f64>();
        let (one, serial) = (sum(|stage| stage.one), sum(|stage| stage.serial));
        let share = 1.0 - serial / one.max(f64::MIN_POSITIVE);
        write!(
            f,
            "| {name} | {one:.2} | {:.2} | {serial:.2} | {:.0} % | {:.0} |",
            sum(|stage| stage.two),
            100.0 * share,
            self.bytes_per_object(stages)
        )?;
        for threads in self.threads {
            let range = predict(stages, *threads, self.bandwidth.threads());
            write!(f, " {} |", Shown(range))?;
        }
        writeln!(f)
    }

    fn bytes_per_object(&self, stages: &[Stage]) -> f64 {
        let waiting = stages.iter().map(|stage| stage.traffic).sum();
        self.bandwidth.bytes_in(waiting) / self.objects.max(1) as f64
    }

    /// What the library's stages would need at 60 Hz.
    fn at_60_hz(&self, f: &mut fmt::Formatter<'_>, stages: &[Stage]) -> fmt::Result {
        let serial: f64 = stages.iter().map(|stage| stage.serial).sum();
        let one: f64 = stages.iter().map(|stage| stage.one).sum();
        let bytes = self.bytes_per_object(stages) * self.objects as f64;
        write!(
            f,
            "At 60 Hz, {} objects have {BUDGET_MS:.1} ms a tick (without {OF_THE_SCENE}): ",
            self.objects
        )?;
        match threads_for(stages, BUDGET_MS) {
            Some(1) => write!(f, "one thread is enough")?,
            Some(threads) => write!(f, "{threads} threads are enough, if memory serves them all")?,
            None => {
                let most_serial = stages
                    .iter()
                    .max_by(|a, b| a.serial.total_cmp(&b.serial))
                    .map_or("", |stage| &stage.name);
                write!(
                    f,
                    "no number of threads is enough, for {serial:.1} ms are serial, most of them in {most_serial}"
                )?;
            }
        }
        let [fewest, share] = [16.0, 1.0 - serial / one.max(f64::MIN_POSITIVE)];
        // Of Amdahl's t(n) = s + p / n, the share p that 16 threads would need.
        let needed = (1.0 - BUDGET_MS / one.max(BUDGET_MS)) / (1.0 - 1.0 / fewest);
        if needed <= 0.0 {
            write!(f, ".")?;
        } else if needed <= 1.0 {
            write!(
                f,
                ". On {fewest:.0} threads, {:.1} % have to be parallel, and {:.1} % are.",
                100.0 * needed,
                100.0 * share
            )?;
        } else {
            write!(
                f,
                ". On {fewest:.0} threads, a thread would have to do in {:.1} ms what it does in {one:.1}, all of it in parallel.",
                fewest * BUDGET_MS
            )?;
        }
        writeln!(
            f,
            " Memory would have to move {:.1} GB/s.",
            bytes * 60.0 * 1e-9
        )
    }
}

/// A range, or one number where both ends are written alike.
struct Shown(Range);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = [self.0.low, self.0.high].map(|ms| format!("{ms:.2}"));
        if low == high {
            write!(f, "{low}")
        } else {
            write!(f, "{low} – {high}")
        }
    }
}
