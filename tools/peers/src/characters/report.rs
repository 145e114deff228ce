//! What came out, as tables in Markdown and ratios.

use std::fmt;

use serde::{Serialize, Serializer};

use super::{
    engines::Contestant,
    scenes::Scene,
    tally::{Figure, TIME},
};
use crate::measure::geometric_mean;

/// An engine in a scene.
#[derive(Serialize)]
pub struct Row {
    #[serde(serialize_with = "by_name")]
    pub scene: Scene,
    #[serde(serialize_with = "by_name")]
    pub engine: Contestant,
    pub characters: usize,
    pub ticks: usize,
    pub figures: Vec<Figure>,
}

fn by_name<S: Serializer>(named: &impl fmt::Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(named)
}

/// All of it, scene by scene.
#[derive(Default, Serialize)]
#[serde(transparent)]
pub struct Report {
    pub rows: Vec<Row>,
}

impl Row {
    fn time(&self) -> Option<f64> {
        let time = self.figures.iter().find(|figure| figure.name == TIME);
        time.map(|figure| figure.value)
    }
}

impl Report {
    /// The time of each peer by that of this crate, in the scenes whose times are compared.
    fn ratios(&self) -> Vec<f64> {
        let is_timed = |row: &&Row| row.scene.is_timed();
        let mut ratios = vec![];
        for ours in self.rows.iter().filter(is_timed) {
            let peers = self.rows.iter().filter(|row| row.scene == ours.scene);
            let peers = peers.filter(|row| !row.engine.is_ours());
            if ours.engine.is_ours() {
                ratios.extend(peers.filter_map(|peer| Some(peer.time()? / ours.time()?)));
            }
        }
        ratios
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for rows in self.rows.chunk_by(|one, next| one.scene == next.scene) {
            let Row {
                scene,
                characters,
                ticks,
                ref figures,
                ..
            } = rows[0];
            writeln!(f, "{scene}: {characters} characters, {ticks} ticks\n")?;
            write!(f, "| engine |")?;
            for Figure { name, .. } in figures {
                write!(f, " {name} |")?;
            }
            writeln!(f, "\n|---|{}", "--:|".repeat(figures.len()))?;
            for Row {
                engine, figures, ..
            } in rows
            {
                write!(f, "| `{engine}` |")?;
                for Figure { value, digits, .. } in figures {
                    write!(f, " {value:.digits$} |")?;
                }
                writeln!(f)?;
            }
            writeln!(f)?;
        }
        let ratios = self.ratios();
        if ratios.is_empty() {
            return Ok(());
        }
        let worst = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let mean = geometric_mean(&ratios);
        writeln!(
            f,
            "worst_ratio={worst:.2} geomean_ratio={mean:.2} (peer / ours, terrain and boxes)"
        )
    }
}
