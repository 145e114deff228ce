//! Figures 9 and 10, and the figure of growth.

use std::{iter, ops::Range};

use plotters::{
    coord::combinators::WithKeyPoints,
    prelude::{BindKeyPoints, IntoLogRange, LogCoord},
};

use super::{
    answers::RIGHT_HAND_SIDE,
    chart::{Frame, Series, chart, extents},
    growth::{Curve, Growth},
    measure::Row,
    output::Output,
    stats::{Estimate, median},
    table::Table,
};
use crate::{
    outcome::Outcome,
    plot::{draw, thousands},
};

const SIZE: (u32, u32) = (1800, 1125);

/// Figures 9 and 10 of the report, measured anew.
pub fn figures_9_and_10(table: &Table, output: &Output) -> Outcome {
    let series = |from: usize| {
        Row::ALL.map(|row| Series {
            label: label(row),
            row,
            points: iter::zip(&table.sets, table.row(row))
                .map(|(set, cell)| (set.object_count(), median(&cell.times)))
                .filter(|(objects, _)| *objects >= from)
                .map(|(objects, time)| (objects as f64, time))
                .collect(),
            fit: None,
        })
    };
    let repeats = table.row(Row::Exhaustive)[0].times.len();
    let bars = if repeats < 6 {
        "range"
    } else {
        "95 % confidence"
    };
    let figure9 = Frame {
        title: "Figure 9: test set size and time to detect collisions",
        note: &format!("median of {repeats} runs, bars: {bars}"),
        axes: ["objects", &format!("time for {} steps [ms]", table.steps)],
        formats: [|objects| format!("{objects:.0}"), |time| format!("{time}")],
    };
    let all = series(0);
    if let Some([x, y]) = extents(&all) {
        let ranges = (-0.02 * x.end..1.05 * x.end, 0.0..1.05 * y.end);
        draw(&output.path("figure9"), SIZE, |canvas| {
            chart(canvas, &figure9, ranges, &all)
        })?;
    }
    let title =
        format!("Figure 10: the right-hand side of Figure 9, from {RIGHT_HAND_SIDE} objects on");
    let figure10 = Frame {
        title: &title,
        ..figure9
    };
    let right = series(RIGHT_HAND_SIDE);
    if let Some([x, y]) = extents(&right) {
        let ranges = (x.start - 30.0..x.end + 30.0, 0.0..1.05 * y.end);
        draw(&output.path("figure10"), SIZE, |canvas| {
            chart(canvas, &figure10, ranges, &right)
        })?;
    }
    Ok(())
}

/// The time of a step against the number of objects, both on logarithmic scales.
pub fn growth_figure(growth: &Growth, output: &Output) -> Outcome {
    let series: Vec<Series> = growth.curves.iter().map(growth_series).collect();
    let frame = Frame {
        title: "Time per step, beyond the report's sets",
        note: "medians of all runs; dashed: fitted from r = 20 on, exponents with 95 % confidence",
        axes: ["objects", "time per step"],
        formats: [thousands, duration],
    };
    if let Some([x, y]) = extents(&series) {
        let ranges = (
            logarithmic(x.start / 1.3..x.end * 1.3, &[1, 2, 5]),
            logarithmic(y.start / 2.0..y.end * 2.0, &[1]),
        );
        draw(&output.path("growth"), SIZE, |canvas| {
            chart(canvas, &frame, ranges, &series)
        })?;
    }
    Ok(())
}

/// A logarithmic scale with labels at these digits in each decade.
fn logarithmic(range: Range<f64>, digits: &[i32]) -> WithKeyPoints<LogCoord<f64>> {
    let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let points = decades.flat_map(|decade| {
        digits
            .iter()
            .map(move |digit| f64::from(*digit) * 10f64.powi(decade))
    });
    let points = points
        .filter(|point| range.contains(point))
        .collect::<Vec<_>>();
    range.log_scale().with_key_points(points)
}

fn growth_series(curve: &Curve) -> Series {
    let points: Vec<_> = curve
        .points
        .iter()
        .map(|point| (point.objects(), median(&point.times)))
        .collect();
    let mut label = label(curve.row);
    let fit = curve.fit().map(|line| {
        let Estimate { low, mid, high } = line.slope;
        label += &format!(": exponent {mid:.2} ({low:.2} to {high:.2})");
        let fitted = curve.fitted();
        [0, fitted.len() - 1]
            .map(|end| fitted[end].objects())
            .map(|objects| {
                (
                    objects,
                    (line.intercept + line.slope.mid * objects.ln()).exp(),
                )
            })
    });
    Series {
        label,
        row: curve.row,
        points,
        fit,
    }
}

fn label(row: Row) -> String {
    if row == Row::Exhaustive {
        "exhaustive search".to_owned()
    } else {
        format!("octree, {row}")
    }
}

/// A time in its handiest unit.
fn duration(microseconds: f64) -> String {
    match microseconds {
        ..1e3 => format!("{microseconds} µs"),
        ..1e6 => format!("{} ms", microseconds / 1e3),
        _ => format!("{} s", microseconds / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_readers() {
        assert_eq!([500.0, 20_000.0].map(thousands), ["500", "20\u{202f}000"]);
        assert_eq!([10.0, 5000.0, 2e6].map(duration), ["10 µs", "5 ms", "2 s"]);
    }
}
