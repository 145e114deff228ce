//! What came out, as tables and ratios.

use std::fmt;

use serde::Serialize;

use super::queries::Operation;
use crate::measure::geometric_mean;

/// The head of the table that cells print rows of.
pub const HEADER: &str =
    "scene     triangles operation         queries    ours_ns   parry_ns    ratio  hits";

/// One operation on one mesh.
#[derive(Serialize)]
pub struct Cell {
    pub scene: &'static str,
    pub triangles: usize,
    pub operation: Operation,
    pub queries: usize,
    /// Nanoseconds per query; of building, per triangle.
    pub ours_ns: f64,
    pub parry_ns: f64,
    /// How many questions hit, by this crate.
    pub hits: usize,
    pub differences: Differences,
}

/// Where the two differ.
#[derive(Clone, Copy, Default, Serialize)]
pub struct Differences {
    /// In hits, or distances.
    pub answers: usize,
    /// Of these, where this crate is right, where parry is, and where both are, for the one that
    /// was asked is within its tolerance; the others are not known.
    pub ours_right: usize,
    pub parry_right: usize,
    pub both_right: usize,
    /// In depths alone, which each defines in its own way.
    pub depths: usize,
}

impl Cell {
    pub fn ratio(&self) -> f64 {
        self.parry_ns / self.ours_ns
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            scene,
            triangles,
            operation,
            queries,
            ours_ns,
            parry_ns,
            hits,
            differences,
        } = self;
        write!(
            f,
            "{scene:<9} {triangles:>9} {operation:<17} {queries:>7} {ours_ns:>10.1} {parry_ns:>10.1} {:>8.2} {hits:>5}",
            self.ratio()
        )?;
        let Differences {
            answers,
            ours_right,
            parry_right,
            both_right,
            depths,
        } = differences;
        if *answers > 0 {
            write!(f, "  differs {answers}")?;
            if ours_right + parry_right + both_right > 0 {
                write!(
                    f,
                    " (right: ours {ours_right}, parry {parry_right}, both {both_right})"
                )?;
            }
        }
        if *depths > 0 {
            write!(f, "  other depth {depths}")?;
        }
        writeln!(f)
    }
}

/// Bytes that a mesh takes.
#[derive(Serialize)]
pub struct Memory {
    pub scene: &'static str,
    pub triangles: usize,
    pub ours: f64,
    pub parry: f64,
    /// With what it takes to tell inside from outside.
    pub parry_oriented: Option<f64>,
}

/// All that was measured.
#[derive(Default, Serialize)]
pub struct Report {
    pub cells: Vec<Cell>,
    /// Per triangle.
    pub bytes: Vec<Memory>,
}

impl Report {
    /// By operation: worst ratio and mean.
    fn by_operation(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\noperation            worst  geomean  (parry / ours)")?;
        for operation in Operation::ALL {
            let cells = self.cells.iter();
            let ratios: Vec<_> = cells
                .filter(|cell| cell.operation == operation)
                .map(Cell::ratio)
                .collect();
            if ratios.is_empty() {
                continue;
            }
            let worst = ratios.iter().copied().fold(f64::NAN, f64::min);
            let mean = geometric_mean(&ratios);
            writeln!(f, "{operation:<17} {worst:>8.2} {mean:>8.2}")?;
        }
        Ok(())
    }

    /// By scene and operation: nanoseconds over the number of triangles.
    fn growth(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sizes: Vec<_> = self.bytes.iter().map(|row| row.triangles).collect();
        sizes.sort_unstable();
        if sizes.first().map(|first| first * 2) >= sizes.last().copied() {
            return Ok(());
        }
        writeln!(
            f,
            "\ngrowth: time ~ triangles^e, from the first size to the last; logarithmic is near 0"
        )?;
        writeln!(
            f,
            "scene     operation          ours_e  parry_e  ours_ns at each size"
        )?;
        let mut scenes: Vec<_> = self.cells.iter().map(|cell| cell.scene).collect();
        scenes.dedup();
        for scene in scenes {
            for operation in Operation::ALL {
                let cells = self.cells.iter();
                let mut cells: Vec<_> = cells
                    .filter(|cell| cell.scene == scene && cell.operation == operation)
                    .collect();
                cells.sort_by_key(|cell| cell.triangles);
                if cells.len() < 2 {
                    continue;
                }
                let points =
                    |of: fn(&Cell) -> f64| cells.iter().map(move |c| (c.triangles as f64, of(c)));
                let [ours, parry] = [
                    exponent(points(|cell| cell.ours_ns)),
                    exponent(points(|cell| cell.parry_ns)),
                ];
                write!(f, "{scene:<9} {operation:<17} {ours:>7.2} {parry:>8.2} ")?;
                for cell in cells {
                    write!(f, " {:>11.1}", cell.ours_ns)?;
                }
                writeln!(f)?;
            }
        }
        Ok(())
    }

    fn memory(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nscene     triangles  bytes/triangle: ours    parry  oriented    ratio"
        )?;
        for row in &self.bytes {
            let Memory {
                scene,
                triangles,
                ours,
                parry,
                parry_oriented,
            } = row;
            let oriented = parry_oriented.map_or_else(String::new, |bytes| format!("{bytes:.1}"));
            writeln!(
                f,
                "{scene:<9} {triangles:>9} {ours:>21.1} {parry:>8.1} {oriented:>9} {:>8.2}",
                parry / ours
            )?;
        }
        Ok(())
    }
}

/// The slope of the line through the logarithms, by least squares.
fn exponent(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let points: Vec<_> = points.map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = points.len() as f64;
    let mean_x = points.iter().map(|point| point.0).sum::<f64>() / count;
    let mean_y = points.iter().map(|point| point.1).sum::<f64>() / count;
    let product: f64 = points
        .iter()
        .map(|(x, y)| (x - mean_x) * (y - mean_y))
        .sum();
    let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    product / square
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.memory(f)?;
        self.growth(f)?;
        self.by_operation(f)?;
        let ratios: Vec<_> = self.cells.iter().map(Cell::ratio).collect();
        let worst = ratios.iter().copied().fold(f64::NAN, f64::min);
        let mean = geometric_mean(&ratios);
        writeln!(
            f,
            "\nworst_ratio={worst:.2} geomean_ratio={mean:.2} (parry / ours)"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponent_is_that_of_a_power() {
        let squares = [1.0, 10.0, 100.0].map(|x: f64| (x, 3.0 * x * x));
        assert!((exponent(squares.into_iter()) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_last_line_has_the_ratios() {
        let cell = |ours_ns, parry_ns| Cell {
            scene: "terrain",
            triangles: 1000,
            operation: Operation::Ray,
            queries: 10,
            ours_ns,
            parry_ns,
            hits: 5,
            differences: Differences::default(),
        };
        let report = Report {
            cells: vec![cell(1.0, 4.0), cell(2.0, 2.0)],
            bytes: vec![],
        };
        let text = report.to_string();
        assert!(text.ends_with("\nworst_ratio=1.00 geomean_ratio=2.00 (parry / ours)\n"));
    }
}
