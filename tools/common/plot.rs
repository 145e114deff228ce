//! Pictures: one drawing, written as SVG and as PNG.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
    sync::{Arc, Once},
};

use plotters::{
    coord::Shift,
    prelude::*,
    style::{FontStyle, IntoTextStyle, TextStyle, register_font},
};
use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{Options, Tree, fontdb},
};

/// The font of all pictures. Viewers of the SVG file that do not have the first one take the next.
const FONT: &str = "Roboto, Helvetica, Arial, sans-serif";
const REGULAR: &[u8] = include_bytes!("fonts/Roboto-Regular.ttf");
const BOLD: &[u8] = include_bytes!("fonts/Roboto-Bold.ttf");

/// What is drawn upon, in pixels.
pub type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The result of drawing.
pub type Drawn = Result<(), Box<dyn Error>>;

/// Draws a picture of `size` pixels and writes it to `stem.svg` and `stem.png`; gives the two
/// paths.
///
/// # Errors
/// Those of the drawing, and those of the file system, which name the file.
pub fn draw(
    stem: &Path,
    size: (u32, u32),
    drawing: impl FnOnce(&Canvas) -> Drawn,
) -> Result<[PathBuf; 2], Box<dyn Error>> {
    register_fonts();
    let mut svg = String::new();
    {
        let canvas = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        canvas.fill(&WHITE)?;
        drawing(&canvas)?;
        canvas.present()?;
    }
    let paths = ["svg", "png"].map(|extension| stem.with_extension(extension));
    for (path, bytes) in paths.iter().zip([svg.as_bytes(), &rasterize(&svg, size)?]) {
        fs::write(path, bytes)
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    Ok(paths)
}

/// Text of so many pixels' height, in the font that every picture has.
pub fn text(height: u32) -> TextStyle<'static> {
    (FONT, height).into_text_style(&(1, 1)).color(&BLACK)
}

/// The same, bold.
pub fn bold(height: u32) -> TextStyle<'static> {
    (FONT, height, FontStyle::Bold)
        .into_text_style(&(1, 1))
        .color(&BLACK)
}

/// A number with its digits in groups of three.
pub fn thousands(value: f64) -> String {
    let digits = format!("{value:.0}");
    let groups: Vec<_> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(String::from_utf8_lossy)
        .collect();
    groups.join("\u{202f}")
}

/// The picture has no font of the system's in it: it looks the same everywhere.
fn rasterize(svg: &str, (width, height): (u32, u32)) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut fonts = fontdb::Database::new();
    for font in [REGULAR, BOLD] {
        fonts.load_font_data(font.to_vec());
    }
    let tree = Tree::from_str(
        svg,
        &Options {
            fontdb: Arc::new(fonts),
            ..Options::default()
        },
    )?;
    let mut pixels = Pixmap::new(width, height)
        .ok_or_else(|| format!("a picture of {width} × {height} pixels"))?;
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    Ok(pixels.encode_png()?)
}

/// Tells `plotters` how wide text is.
fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for (style, bytes) in [(FontStyle::Normal, REGULAR), (FontStyle::Bold, BOLD)] {
            assert!(
                register_font(FONT, style, bytes).is_ok(),
                "a font is damaged"
            );
        }
    });
}
