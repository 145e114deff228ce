//! Pictures, one after the other: an animated GIF, made small.
//!
//! All pictures have one palette, and each but the first is no more than the rectangle that changed
//! in it, in which what did not change is transparent.

use std::{
    borrow::Cow,
    collections::HashMap,
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
};

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use image::{Rgb, RgbImage};
use thiserror::Error;

/// What can go wrong with an animation.
#[derive(Debug, Error)]
#[error("{}: {error}", path.display())]
pub struct AnimationError {
    path: PathBuf,
    error: EncodingError,
}

/// How many colours there are beside the transparent one.
const COLORS: usize = 255;
const TRANSPARENT: u8 = 255;
/// How many pixels the palette is learnt from, at most.
const SAMPLES: usize = 400_000;

/// Writes an animation that repeats for ever, of pictures that are so many seconds apart.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write(path: &Path, pictures: &[RgbImage], seconds: f32) -> Result<(), AnimationError> {
    try_write(path, pictures, seconds).map_err(|error| AnimationError {
        path: path.to_owned(),
        error,
    })
}

fn try_write(path: &Path, pictures: &[RgbImage], seconds: f32) -> Result<(), EncodingError> {
    let Some(first) = pictures.first() else {
        return Ok(());
    };
    let mut palette = Palette::of(pictures);
    let [width, height] = [first.width(), first.height()].map(|side| side as u16);
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = Encoder::new(file, width, height, &palette.colors())?;
    encoder.set_repeat(Repeat::Infinite)?;
    let mut before: Option<Vec<u8>> = None;
    // In hundredths of a second, so that the whole takes as long as it should.
    let hundredths =
        |pictures: usize| (pictures as f64 * f64::from(seconds) * 100.0).round() as u64;
    for (number, picture) in pictures.iter().enumerate() {
        let indices: Vec<u8> = picture
            .pixels()
            .map(|pixel| palette.index_of(pixel.0))
            .collect();
        let mut frame = match &before {
            None => Frame {
                width,
                height,
                buffer: Cow::Owned(indices.clone()),
                ..Frame::default()
            },
            Some(before) => changes(before, &indices, width.into()),
        };
        // What is shorter than two hundredths, browsers show for ten.
        let delay = hundredths(number + 1) - hundredths(number);
        frame.delay = delay.clamp(2, u16::MAX.into()) as u16;
        frame.transparent = Some(TRANSPARENT);
        frame.dispose = DisposalMethod::Keep;
        encoder.write_frame(&frame)?;
        before = Some(indices);
    }
    Ok(())
}

/// The rectangle of what changed from one picture to the next. Where nothing did, one pixel.
fn changes(before: &[u8], now: &[u8], width: usize) -> Frame<'static> {
    let changed = |at: usize| before[at] != now[at];
    let places = (0..now.len()).filter(|at| changed(*at));
    let (mut left, mut top, mut right, mut bottom) = (usize::MAX, usize::MAX, 0, 0);
    for at in places {
        let (x, y) = (at % width, at / width);
        (left, right) = (left.min(x), right.max(x));
        (top, bottom) = (top.min(y), bottom.max(y));
    }
    if left == usize::MAX {
        (left, top) = (0, 0);
    }
    let buffer = (top..=bottom).flat_map(|y| (left..=right).map(move |x| y * width + x));
    let buffer = buffer.map(|at| if changed(at) { now[at] } else { TRANSPARENT });
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left + 1) as u16,
        height: (bottom - top + 1) as u16,
        buffer: Cow::Owned(buffer.collect()),
        ..Frame::default()
    }
}

/// The colours of all pictures.
struct Palette {
    /// Red, green and blue in turn.
    colors: Vec<u8>,
    /// What finds the nearest, if there are not all.
    quantizer: Option<NeuQuant>,
    /// What was looked up.
    known: HashMap<[u8; 3], u8>,
}

impl Palette {
    fn of(pictures: &[RgbImage]) -> Self {
        let pixels = || pictures.iter().flat_map(RgbImage::pixels);
        let mut known = HashMap::new();
        let mut colors = Vec::new();
        for pixel in pixels() {
            let count = known.len();
            known.entry(pixel.0).or_insert_with(|| {
                colors.extend(pixel.0);
                count as u8
            });
            if known.len() > COLORS {
                return Self::learnt(pixels());
            }
        }
        Self {
            colors,
            quantizer: None,
            known,
        }
    }

    fn learnt<'a>(pixels: impl Iterator<Item = &'a Rgb<u8>> + Clone) -> Self {
        // Not a multiple of the width, as far as that can be helped: it would be columns.
        let stride = (pixels.clone().count() / SAMPLES).max(1) | 1;
        let samples: Vec<u8> = pixels
            .step_by(stride)
            .flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255])
            .collect();
        let quantizer = NeuQuant::new(3, COLORS, &samples);
        Self {
            colors: quantizer.color_map_rgb(),
            quantizer: Some(quantizer),
            known: HashMap::new(),
        }
    }

    /// All colours, and last one that stands for the transparent.
    fn colors(&self) -> Vec<u8> {
        let mut colors = self.colors.clone();
        colors.resize(3 * (COLORS + 1), 0);
        colors
    }

    fn index_of(&mut self, color: [u8; 3]) -> u8 {
        *self.known.entry(color).or_insert_with(|| {
            let [red, green, blue] = color;
            let nearest = |quantizer: &NeuQuant| quantizer.index_of(&[red, green, blue, 255]);
            self.quantizer.as_ref().map_or(0, nearest) as u8
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_back_is_what_was_written() {
        let mut first = RgbImage::from_pixel(8, 6, Rgb([20, 30, 40]));
        first.put_pixel(1, 1, Rgb([250, 0, 0]));
        let mut second = first.clone();
        second.put_pixel(5, 4, Rgb([0, 250, 0]));
        let still = second.clone();
        let path = std::env::temp_dir().join("bevy_octree_gallery_animation.gif");
        write(&path, &[first, second, still], 0.125)
            .expect("there is a folder for what is temporary");

        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let file = File::open(&path).expect("it was written");
        let mut decoder = options.read_info(file).expect("it is a GIF");
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().expect("it is whole") {
            let rectangle = [frame.left, frame.top, frame.width, frame.height];
            frames.push((rectangle, frame.delay, frame.buffer.to_vec()));
        }
        std::fs::remove_file(&path).ok();
        let rectangles: Vec<_> = frames.iter().map(|frame| frame.0).collect();
        assert_eq!(rectangles, [[0, 0, 8, 6], [5, 4, 1, 1], [0, 0, 1, 1]]);
        // An eighth of a second each, in hundredths that add up.
        assert_eq!(frames.iter().map(|frame| frame.1).sum::<u16>(), 38);
        let near = |color: &[u8], wanted: [u8; 3]| {
            color.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) < 24)
        };
        assert!(near(&frames[0].2[4 * 9..][..3], [250, 0, 0]));
        assert!(near(&frames[1].2[..3], [0, 250, 0]));
        assert_eq!(frames[2].2[3], 0, "nothing changed");
    }
}
