//! The picture of ratios: a group of bars per scene, a bar per number of objects.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use plotters::{prelude::*, style::text_anchor::*};

use super::report::{Cell, Report};
use crate::{
    engines::Role,
    plot::{self, Canvas, Drawn, bold, text},
};

const SIZE: (u32, u32) = (1600, 760);
/// The height of the title and the legend.
const HEAD: i32 = 92;
/// How many of the shades, from the first on, are so light that black is read on them.
const LIGHT: usize = 2;
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
    let mut scenes: Vec<&str> = report.cells.iter().map(|cell| &*cell.scene).collect();
    scenes.dedup();
    let mut sizes: Vec<usize> = report.cells.iter().map(|cell| cell.objects).collect();
    sizes.sort_unstable();
    sizes.dedup();
    plot::draw(stem, SIZE, |canvas| {
        let (head, body) = canvas.split_vertically(HEAD);
        legend(&head, &sizes)?;
        bars(&body, &report.cells, &scenes, &sizes)
    })
}

fn legend(canvas: &Canvas, sizes: &[usize]) -> Drawn {
    canvas.draw(&Text::new(
        "How many times as fast as the fastest other broad phase, whose name is in the bar",
        (20, 14),
        bold(28),
    ))?;
    for (i, size) in sizes.iter().enumerate() {
        let x = 20 + 230 * i as i32;
        canvas.draw(&Rectangle::new(
            [(x, 58), (x + 20, 78)],
            SHADES[i % SHADES.len()].filled(),
        ))?;
        canvas.draw(&Text::new(
            format!("{} objects", plot::thousands(*size as f64)),
            (x + 28, 57),
            text(22),
        ))?;
    }
    Ok(())
}

/// Heights are logarithms to base 2, so that twice as fast and twice as slow are as far from the
/// line between.
fn bars(canvas: &Canvas, cells: &[Cell], scenes: &[&str], sizes: &[usize]) -> Drawn {
    let heights = || cells.iter().filter_map(Cell::ratio).map(f64::log2);
    let (low, high) = (
        heights().fold(-0.4, f64::min) - 0.3,
        heights().fold(1.0, f64::max) + 0.3,
    );
    let whole = |height| [(0.0, height), (scenes.len() as f64, height)];
    let mut chart = ChartBuilder::on(canvas)
        .margin_right(20)
        .margin_left(110)
        .margin_bottom(44)
        .build_cartesian_2d(0.0..scenes.len() as f64, low..high)?;
    for step in low.ceil() as i32..=high.floor() as i32 {
        let height = f64::from(step);
        let label = text(20).pos(Pos::new(HPos::Right, VPos::Center));
        let label = Text::new(format!("{} ×", height.exp2()), (-12, 0), label);
        chart.draw_series([PathElement::new(whole(height), BLACK.mix(0.15))])?;
        chart.draw_series([EmptyElement::at((0.0, height)) + label])?;
    }
    let upright = text(20)
        .transform(FontTransform::Rotate270)
        .pos(Pos::new(HPos::Center, VPos::Center));
    canvas.draw(&Text::new(
        "time of the peer / time of this crate",
        (24, (SIZE.1 as i32 - HEAD) / 2),
        upright,
    ))?;
    let width = 0.84 / sizes.len().max(1) as f64;
    for (scene, name) in scenes.iter().enumerate() {
        for cell in cells.iter().filter(|cell| cell.scene == *name) {
            let (Some(ratio), Some(peer)) = (cell.ratio(), cell.fastest(Role::Peer)) else {
                continue;
            };
            let size = sizes
                .iter()
                .position(|size| *size == cell.objects)
                .unwrap_or(0);
            let (left, height) = (scene as f64 + 0.08 + width * size as f64, ratio.log2());
            let (middle, right) = (left + width * 0.46, left + width * 0.92);
            let shade = SHADES[size % SHADES.len()].filled();
            chart.draw_series([Rectangle::new([(left, 0.0), (right, height)], shade)])?;
            let above = text(16).pos(Pos::new(HPos::Center, VPos::Bottom));
            let figure = Text::new(format!("{ratio:.1}"), (0, -2), above);
            chart.draw_series([EmptyElement::at((middle, height.max(0.0))) + figure])?;
            // The name of the peer, where there is room for it.
            if height > 0.18 * (high - low) {
                let ink = if size < LIGHT { &BLACK } else { &WHITE };
                let upright = text(17).transform(FontTransform::Rotate270).color(ink);
                let name = Text::new(peer.engine.to_owned(), (-9, -8), upright);
                chart.draw_series([EmptyElement::at((middle, 0.0)) + name])?;
            }
        }
        let (x, _) = chart
            .plotting_area()
            .map_coordinate(&(scene as f64 + 0.5, 0.0));
        let below = text(21).pos(Pos::new(HPos::Center, VPos::Center));
        // Coordinates of the plot are those of the whole picture.
        canvas.draw(&Text::new(
            (*name).to_owned(),
            (x, SIZE.1 as i32 - HEAD - 24),
            below,
        ))?;
    }
    chart.draw_series([PathElement::new(whole(0.0), BLACK.stroke_width(2))])?;
    Ok(())
}
