//! The picture of ratios: a group of bars per scene, a bar per number of objects.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use plotters::{prelude::*, style::text_anchor::*};

use super::report::{Cell, Report};
use crate::{
    engines::Role,
    plot::{self, Drawn, bold, text},
};

const SIZE: (u32, u32) = (1100, 520);
/// Of the bars, from few objects to many.
const SHADES: [RGBColor; 5] = [
    RGBColor(158, 202, 225),
    RGBColor(107, 174, 214),
    RGBColor(49, 130, 189),
    RGBColor(8, 81, 156),
    RGBColor(8, 48, 107),
];

/// Draws the report's ratios to `stem.svg` and `stem.png`.
pub fn draw(stem: &Path, report: &Report) -> Result<[PathBuf; 2], Box<dyn Error>> {
    plot::draw(stem, SIZE, |canvas| ratios(canvas, report))
}

fn ratios(canvas: &plot::Canvas, report: &Report) -> Drawn {
    let mut scenes: Vec<&str> = vec![];
    let mut sizes: Vec<usize> = vec![];
    for cell in &report.cells {
        if !scenes.contains(&&*cell.scene) {
            scenes.push(&cell.scene);
        }
        if !sizes.contains(&cell.objects) {
            sizes.push(cell.objects);
        }
    }
    sizes.sort_unstable();
    let most = report.cells.iter().filter_map(Cell::ratio).fold(2.0, f64::max);
    let least = report.cells.iter().filter_map(Cell::ratio).fold(0.8, f64::min);

    let title = "Time of the fastest peer, by that of this crate";
    let [head, body] = {
        let (head, body) = canvas.split_vertically(62);
        [head, body]
    };
    head.draw(&Text::new(title, (20, 12), bold(20)))?;
    for (i, size) in sizes.iter().enumerate() {
        let x = 20 + 170 * i as i32;
        let shade = SHADES[i % SHADES.len()];
        head.draw(&Rectangle::new([(x, 42), (x + 14, 56)], shade.filled()))?;
        head.draw(&Text::new(format!("{size} objects"), (x + 20, 42), text(15)))?;
    }

    let mut chart = ChartBuilder::on(&body)
        .margin_right(20)
        .margin_left(12)
        .x_label_area_size(34)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..scenes.len() as f64, (least * 0.9..most * 1.25).log_scale())?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .disable_x_axis()
        .y_desc("peer / ours (logarithmic)")
        .axis_desc_style(text(15))
        .y_label_style(text(14))
        .y_label_formatter(&|ratio| format!("{ratio:.1}"))
        .light_line_style(BLACK.mix(0.05))
        .bold_line_style(BLACK.mix(0.12))
        .draw()?;
    let base = 1.0;
    let width = 0.84 / sizes.len().max(1) as f64;
    for cell in &report.cells {
        let (Some(ratio), Some(peer)) = (cell.ratio(), cell.fastest(Role::Peer)) else { continue };
        let place = |found: Option<usize>| found.unwrap_or(0);
        let scene = place(scenes.iter().position(|scene| *scene == cell.scene));
        let size = place(sizes.iter().position(|size| *size == cell.objects));
        let left = scene as f64 + 0.08 + width * size as f64;
        let bar = Rectangle::new([(left, base), (left + width * 0.92, ratio)], SHADES[size % SHADES.len()].filled());
        chart.draw_series([bar])?;
        let middle = (left + width * 0.46, ratio.max(base));
        let style = text(11).pos(Pos::new(HPos::Center, VPos::Bottom));
        chart.draw_series([EmptyElement::at(middle) + Text::new(format!("{ratio:.1}"), (0, -2), style.clone())])?;
        let upright = text(11).transform(FontTransform::Rotate270).color(&WHITE);
        let name = Text::new(peer.engine.to_owned(), (-6, -6), upright);
        if ratio > base * 1.6 {
            chart.draw_series([EmptyElement::at((left + width * 0.46, base)) + name])?;
        }
    }
    let whole = [(0.0, base), (scenes.len() as f64, base)];
    chart.draw_series([PathElement::new(whole, BLACK.stroke_width(2))])?;
    let plane = chart.plotting_area();
    for (i, scene) in scenes.iter().enumerate() {
        let (x, _) = plane.map_coordinate(&(i as f64 + 0.5, base));
        let y = SIZE.1 as i32 - 22;
        canvas.draw(&Text::new((*scene).to_owned(), (x, y), text(15).pos(Pos::new(HPos::Center, VPos::Center))))?;
    }
    Ok(())
}
