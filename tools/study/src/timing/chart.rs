//! A chart of times against numbers of objects.

use std::{array, ops::Range};

use plotters::{
    coord::ranged1d::{AsRangedCoord, ValueFormatter},
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use super::{measure::Row, stats::Estimate};
use crate::plot::{Canvas, Drawn, bold, text};

const INK: RGBColor = RGBColor(0x60, 0x60, 0x60);
const GRID: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);
const MARKER_RADIUS: f64 = 10.0;
const RIM: f64 = 2.5;

/// A line of a chart.
pub struct Series {
    pub label: String,
    pub row: Row,
    /// Objects, and time.
    pub points: Vec<(f64, Estimate)>,
    /// The ends of a fitted line, drawn dashed; without one, the points are joined.
    pub fit: Option<[(f64, f64); 2]>,
}

/// What stands around a chart.
pub struct Frame<'a> {
    pub title: &'a str,
    pub note: &'a str,
    /// What the axes are, units included.
    pub axes: [&'a str; 2],
    /// How the numbers on the axes are written.
    pub formats: [fn(f64) -> String; 2],
}

/// Draws a chart with a title and a note above it, error bars, and a legend.
pub fn chart<X, Y>(canvas: &Canvas, frame: &Frame, (x, y): (X, Y), series: &[Series]) -> Drawn
where
    X: AsRangedCoord<Value = f64, CoordDescType: ValueFormatter<f64>>,
    Y: AsRangedCoord<Value = f64, CoordDescType: ValueFormatter<f64>>,
{
    canvas.draw(&Text::new(frame.title, (60, 36), bold(48)))?;
    canvas.draw(&Text::new(frame.note, (60, 100), text(32).color(&INK)))?;
    let (_, area) = canvas.split_vertically(150);
    let mut chart = ChartBuilder::on(&area)
        .margin_right(60)
        .margin_bottom(30)
        .margin_left(40)
        .x_label_area_size(100)
        .y_label_area_size(140)
        .build_cartesian_2d(x, y)?;
    let [x_format, y_format] = frame.formats;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .axis_style(INK)
        .x_desc(frame.axes[0])
        .y_desc(frame.axes[1])
        .x_label_formatter(&|x| x_format(*x))
        .y_label_formatter(&|y| y_format(*y))
        .label_style(text(32))
        .axis_desc_style(text(36))
        .draw()?;
    for Series {
        row, points, fit, ..
    } in series
    {
        let style = color(*row).stroke_width(3);
        match fit {
            Some(ends) => {
                chart.draw_series(DashedLineSeries::new(*ends, 14, 10, style))?;
            }
            None => {
                chart.draw_series(LineSeries::new(
                    points.iter().map(|(x, time)| (*x, time.mid)),
                    style,
                ))?;
            }
        }
        let bar = |&(x, Estimate { low, mid, high }): &(f64, _)| {
            ErrorBar::new_vertical(x, low, mid, high, style, 16)
        };
        chart.draw_series(points.iter().map(bar))?;
    }
    let area = chart.plotting_area();
    for Series { row, points, .. } in series {
        for (x, time) in points {
            marker(canvas, *row, area.map_coordinate(&(*x, time.mid)))?;
        }
    }
    let (left, top) = area.get_pixel_range();
    legend(canvas, (left.start + 40, top.start + 30), series)
}

/// The ranges that all points lie in, error bars included; `None` if there are no points.
pub fn extents(series: &[Series]) -> Option<[Range<f64>; 2]> {
    let points = series.iter().flat_map(|series| &series.points);
    let corners = points.flat_map(|(x, time)| [[*x, time.low], [*x, time.high]]);
    let span = |axis: usize| {
        let values = corners.clone().map(move |corner| corner[axis]);
        Some(values.clone().reduce(f64::min)?..values.reduce(f64::max)?)
    };
    let [x, y] = array::from_fn(span);
    Some([x?, y?])
}

/// Lists the series from `corner` down.
fn legend(canvas: &Canvas, (left, top): (i32, i32), series: &[Series]) -> Drawn {
    let font = text(32);
    let widths = series
        .iter()
        .map(|series| canvas.estimate_text_size(&series.label, &font));
    let width = widths
        .map(|size| size.map_or(0, |(width, _)| width))
        .max()
        .unwrap_or(0) as i32;
    let bottom = top + 46 * series.len() as i32 + 20;
    let corners = [(left, top), (left + width + 150, bottom)];
    canvas.draw(&Rectangle::new(corners, WHITE.filled()))?;
    canvas.draw(&Rectangle::new(corners, GRID.stroke_width(2)))?;
    for (place, Series { label, row, .. }) in (0..).zip(series) {
        let y = top + 46 * place + 33;
        canvas.draw(&PathElement::new(
            [(left + 24, y), (left + 100, y)],
            color(*row).stroke_width(3),
        ))?;
        marker(canvas, *row, (left + 62, y))?;
        let style = font.pos(Pos::new(HPos::Left, VPos::Center));
        canvas.draw(&Text::new(&label[..], (left + 120, y), style))?;
    }
    Ok(())
}

/// A shape that tells the row, on a white rim that sets it off against the lines beneath.
fn marker(canvas: &Canvas, row: Row, (x, y): (i32, i32)) -> Drawn {
    let corners = shape(row);
    for (radius, color) in [(MARKER_RADIUS + RIM, WHITE), (MARKER_RADIUS, color(row))] {
        let place = |at: i32, offset: f64| at + (offset * radius).round() as i32;
        let corners: Vec<_> = corners
            .iter()
            .map(|corner| (place(x, corner.0), place(y, corner.1)))
            .collect();
        canvas.draw(&Polygon::new(corners, color))?;
    }
    Ok(())
}

/// The colours of Okabe and Ito, which colour-blind readers can tell apart.
const fn color(row: Row) -> RGBColor {
    match row {
        Row::Octree(..10) => RGBColor(0xe6, 0x9f, 0x00),
        Row::Octree(..30) => RGBColor(0x56, 0xb4, 0xe9),
        Row::Octree(..50) => RGBColor(0x00, 0x9e, 0x73),
        Row::Octree(_) => RGBColor(0x00, 0x72, 0xb2),
        Row::Big => RGBColor(0xcc, 0x79, 0xa7),
        Row::Exhaustive => RGBColor(0xd5, 0x5e, 0x00),
    }
}

/// The corners of the marker of a row, in units of its radius.
const fn shape(row: Row) -> &'static [(f64, f64)] {
    match row {
        Row::Octree(..10) => &[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)],
        Row::Octree(..30) => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
        Row::Octree(..50) => &[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)],
        Row::Octree(_) => &[
            (0.42, -1.0),
            (1.0, -0.42),
            (1.0, 0.42),
            (0.42, 1.0),
            (-0.42, 1.0),
            (-1.0, 0.42),
            (-1.0, -0.42),
            (-0.42, -1.0),
        ],
        Row::Big => &[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)],
        Row::Exhaustive => &[
            (0.0, -0.45),
            (0.7, -1.15),
            (1.15, -0.7),
            (0.45, 0.0),
            (1.15, 0.7),
            (0.7, 1.15),
            (0.0, 0.45),
            (-0.7, 1.15),
            (-1.15, 0.7),
            (-0.45, 0.0),
            (-1.15, -0.7),
            (-0.7, -1.15),
        ],
    }
}
