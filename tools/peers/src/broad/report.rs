//! What came out, as tables and ratios.

use std::fmt;

use serde::{Serialize, Serializer, ser::SerializeStruct};

use crate::{engines::Role, measure::geometric_mean};

/// The head of the table that cells print rows of.
pub const HEADER: &str = "scene             objects      pairs engine         update_ms   pairs_ms   total_ms  ns/object   / ours";

/// The name of the crate's default way to search, which ratios relate to where it takes part.
const DEFAULT: &str = "auto";

/// Medians of one engine, per frame.
#[derive(Serialize)]
pub struct Row {
    /// Its name.
    pub engine: &'static str,
    /// What it is to the comparison.
    #[serde(skip)]
    pub role: Role,
    /// Milliseconds for handing over all boxes and for maintenance.
    pub update_ms: f64,
    /// Milliseconds for all pairs.
    pub pairs_ms: f64,
    /// Milliseconds for both: the median of sums.
    pub total_ms: f64,
    /// It took longer than the limit for a frame, and has no figures.
    pub too_slow: bool,
    /// Its pairs were not those of the others, in one frame at least.
    pub mismatch: bool,
}

/// A scene at one number of objects.
pub struct Cell {
    /// Its name.
    pub scene: String,
    /// How many objects.
    pub objects: usize,
    /// Pairs in the last frame.
    pub pairs: usize,
    /// The engines.
    pub rows: Vec<Row>,
}

impl Cell {
    /// This crate: as it is by default, if that takes part, otherwise its best.
    pub fn ours(&self) -> Option<&Row> {
        self.rows
            .iter()
            .find(|row| row.engine == DEFAULT)
            .or_else(|| self.fastest(Role::Ours))
    }

    /// The fastest of the engines that found the right pairs.
    pub fn fastest(&self, role: Role) -> Option<&Row> {
        self.rows
            .iter()
            .filter(|row| row.role == role && !row.too_slow && !row.mismatch)
            .min_by(|a, b| a.total_ms.total_cmp(&b.total_ms))
    }

    /// The time of the fastest peer by this crate's.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.fastest(Role::Peer)?.total_ms / self.ours()?.total_ms)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ours = self.ours().map_or(f64::NAN, |row| row.total_ms);
        for row in &self.rows {
            let Row {
                engine,
                update_ms,
                pairs_ms,
                total_ms,
                ..
            } = row;
            write!(
                f,
                "{:<15} {:>9} {:>10} {engine:<14}",
                self.scene, self.objects, self.pairs
            )?;
            if row.too_slow {
                writeln!(f, " over the limit")?;
                continue;
            }
            let ns = total_ms * 1e6 / self.objects as f64;
            let ratio = total_ms / ours;
            write!(
                f,
                "{update_ms:>10.4} {pairs_ms:>10.4} {total_ms:>10.4} {ns:>10.1} {ratio:>8.2}"
            )?;
            writeln!(f, "{}", if row.mismatch { " MISMATCH" } else { "" })?;
        }
        Ok(())
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut cell = serializer.serialize_struct("Cell", 7)?;
        cell.serialize_field("scene", &self.scene)?;
        cell.serialize_field("objects", &self.objects)?;
        cell.serialize_field("pairs", &self.pairs)?;
        cell.serialize_field("ours", &self.ours().map(|row| row.engine))?;
        cell.serialize_field(
            "fastest_peer",
            &self.fastest(Role::Peer).map(|row| row.engine),
        )?;
        cell.serialize_field("ratio", &self.ratio())?;
        cell.serialize_field("rows", &self.rows)?;
        cell.end()
    }
}

/// All cells.
#[derive(Default, Serialize)]
pub struct Report {
    /// By scene, and by number of objects within each.
    pub cells: Vec<Cell>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nscene             objects ours             total_ms fastest peer     total_ms    ratio"
        )?;
        let mut ratios = vec![];
        for cell in &self.cells {
            let (Some(ours), Some(peer), Some(ratio)) =
                (cell.ours(), cell.fastest(Role::Peer), cell.ratio())
            else {
                continue;
            };
            ratios.push(ratio);
            write!(
                f,
                "{:<15} {:>9} {:<14}{:>11.4}",
                cell.scene, cell.objects, ours.engine, ours.total_ms
            )?;
            writeln!(
                f,
                " {:<14}{:>11.4} {ratio:>8.2}",
                peer.engine, peer.total_ms
            )?;
        }
        let worst = ratios.iter().copied().fold(f64::NAN, f64::min);
        let mean = geometric_mean(&ratios);
        writeln!(
            f,
            "\nworst_ratio={worst:.2} geomean_ratio={mean:.2} (fastest peer / ours)"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(engine: &'static str, role: Role, total_ms: f64) -> Row {
        Row {
            engine,
            role,
            update_ms: 0.0,
            pairs_ms: total_ms,
            total_ms,
            too_slow: false,
            mismatch: false,
        }
    }

    #[test]
    fn a_ratio_relates_the_fastest_right_peer_to_the_default() {
        let mut rows = vec![
            row("object", Role::Ours, 1.0),
            row("grid", Role::Peer, 6.0),
            row("wrong", Role::Peer, 0.5),
            row("floor", Role::Floor, 0.1),
        ];
        rows[2].mismatch = true;
        let mut cell = Cell {
            scene: "brownian".into(),
            objects: 10,
            pairs: 3,
            rows,
        };
        assert_eq!(cell.ratio(), Some(6.0));
        cell.rows.push(row("auto", Role::Ours, 2.0));
        assert_eq!(cell.ratio(), Some(3.0));
        assert!(cell.to_string().contains("MISMATCH"));
        let report = Report { cells: vec![cell] };
        assert!(
            report
                .to_string()
                .ends_with("worst_ratio=3.00 geomean_ratio=3.00 (fastest peer / ours)\n")
        );
        assert!(
            serde_json::to_string(&report)
                .unwrap()
                .contains(r#""fastest_peer":"grid","ratio":3.0"#)
        );
    }
}
