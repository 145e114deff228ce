//! Pictures, as SVG.

use std::{fmt::Write as _, fs, path::Path};

use crate::outcome::Outcome;

/// A picture. Coordinates are pixels, from the upper left corner; what is drawn later lies on top.
///
/// Attributes of SVG tell how: `stroke` and `stroke-width` for lines, `fill` for text and for what
/// lines enclose.
pub struct Svg(String);

impl Svg {
    /// A picture of so many pixels, all of one colour.
    pub fn new([width, height]: [u32; 2], background: &str) -> Self {
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" fill=\"none\" font-family=\"Roboto, Helvetica, Arial, sans-serif\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"{background}\"/>\n"
        ))
    }

    /// Draws a line through points.
    pub fn line(&mut self, points: impl IntoIterator<Item = [f32; 2]>, attributes: &str) {
        let points: Vec<_> = points
            .into_iter()
            .map(|[x, y]| format!("{},{}", tenths(x), tenths(y)))
            .collect();
        _ = writeln!(
            self.0,
            r#"<polyline points="{}" {attributes}/>"#,
            points.join(" ")
        );
    }

    /// Writes text, which begins, ends or is centred at a point of its base line, as `text-anchor`
    /// tells.
    pub fn text(&mut self, [x, y]: [f32; 2], text: &str, attributes: &str) {
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        _ = writeln!(
            self.0,
            r#"<text x="{}" y="{}" {attributes}>{text}</text>"#,
            tenths(x),
            tenths(y)
        );
    }

    /// Writes the picture to a file.
    pub fn save(self, path: &Path) -> Outcome {
        fs::write(path, self.0 + "</svg>\n")
            .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
    }
}

/// Rounded to tenths: less than a tenth of a pixel cannot be seen, and takes room.
fn tenths(value: f32) -> f32 {
    (value * 10.0).round() / 10.0
}
