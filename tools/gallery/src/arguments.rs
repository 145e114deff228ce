//! The arguments of the command.

use std::{path::PathBuf, str::FromStr};

use bevy::math::UVec2;
use clap::Parser;

use crate::{
    controls::KEYS,
    play::Play,
    settings::{Leaves, Search},
};

/// Shows what `bevy_octree` does: in a window, or, with `--frames`, in pictures.
#[derive(Parser, Clone, Debug)]
#[command(version, after_help = format!("In the window:\n{KEYS}"))]
pub struct Arguments {
    /// The scene to begin with; `--list` names all.
    #[arg(long)]
    pub scene: Option<String>,
    /// Draws pictures of all scenes, without a window.
    #[arg(long, conflicts_with_all = ["scene", "gif", "objects", "max_objects", "leaves"])]
    pub all: bool,
    /// Lists the scenes, and ends.
    #[arg(long)]
    pub list: bool,
    /// Draws pictures without a window, after so many ticks: `200`, or `0..200` for all before the
    /// 200th. Without it, there is one picture, at the tick that the scene thinks best, if `--out`
    /// or `--gif` are given.
    #[arg(long, value_name = "FROM..TO")]
    pub frames: Option<FrameRange>,
    /// Draws every so many ticks.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..), value_name = "TICKS")]
    pub every: u64,
    /// The width and height of the pictures, or of the window.
    #[arg(long, default_value = "1280x720", value_name = "WIDTHxHEIGHT")]
    pub size: Size,
    /// The folder for pictures, which are named after scene and tick. [default: target/gallery, unless
    /// --gif is given]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Makes an animation of the pictures.
    #[arg(long, value_name = "FILE")]
    pub gif: Option<PathBuf>,
    /// How many objects there are, in scenes where that can be chosen.
    #[arg(long, value_name = "COUNT")]
    pub objects: Option<usize>,
    /// How many objects a leaf of the octree lists before it splits.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_objects: Option<u32>,
    /// How pairs are searched for.
    #[arg(long)]
    pub search: Option<Search>,
    /// How fast ticks follow each other, in the window and in an animation; 1 for 64 in a second.
    #[arg(long, default_value_t = 1.0, value_parser = speed)]
    pub speed: f32,
    /// Which leaves of the octree are drawn.
    #[arg(long)]
    pub leaves: Option<Leaves>,
    /// Draws the panel in pictures too.
    #[arg(long)]
    pub panel: bool,
}

fn speed(text: &str) -> Result<f32, String> {
    let [slowest, fastest] = Play::SPEEDS;
    let speed = text.parse::<f32>().map_err(|error| error.to_string())?;
    if (slowest..=fastest).contains(&speed) {
        Ok(speed)
    } else {
        Err(format!("expected a number from {slowest} to {fastest}"))
    }
}

impl Arguments {
    /// Whether pictures are asked for.
    pub const fn wants_pictures(&self) -> bool {
        self.all || self.frames.is_some() || self.out.is_some() || self.gif.is_some()
    }
}

/// The ticks after which pictures are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// From the first to before the last.
    pub range: FrameRange,
    /// How many ticks apart.
    pub every: u64,
}

impl Frames {
    /// Returns `true` if a picture is drawn after so many ticks.
    pub const fn contains(&self, tick: u64) -> bool {
        let FrameRange { from, to } = self.range;
        from <= tick && tick < to && (tick - from).is_multiple_of(self.every)
    }

    /// Returns the tick of the last picture.
    pub const fn last(&self) -> u64 {
        let FrameRange { from, to } = self.range;
        from + (to - 1 - from) / self.every * self.every
    }

    /// Returns the number of pictures.
    pub const fn count(&self) -> u64 {
        let FrameRange { from, to } = self.range;
        (to - from).div_ceil(self.every)
    }
}

/// Ticks, from one to before another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    from: u64,
    to: u64,
}

impl From<u64> for FrameRange {
    fn from(tick: u64) -> Self {
        Self {
            from: tick,
            to: tick + 1,
        }
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |text: &str| {
            let number = text.trim().parse::<u64>();
            number.map_err(|error| format!("`{text}` is no number of ticks: {error}"))
        };
        let range = match text.split_once("..") {
            None => number(text)?.into(),
            Some((from, to)) => Self {
                from: number(from)?,
                to: number(to)?,
            },
        };
        if range.from < range.to && range.to < u64::MAX {
            Ok(range)
        } else {
            Err(format!("there is no tick in {text}"))
        }
    }
}

/// The size of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub UVec2);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let expected = || format!("`{text}` is no size: expected one like 1280x720");
        let (width, height) = text.split_once('x').ok_or_else(expected)?;
        let side = |text: &str| text.parse::<u32>().map_err(|_| expected());
        let [width, height] = [side(width)?, side(height)?];
        if (16..=8192).contains(&width) && (16..=8192).contains(&height) {
            Ok(Self(UVec2::new(width, height)))
        } else {
            Err(format!("{text} is out of range: sides are from 16 to 8192"))
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_command_is_well_formed() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn frames_are_from_the_first_to_before_the_last() {
        let frames = |range: &str, every| Frames {
            range: range.parse().expect("it is a range"),
            every,
        };
        let ticks = |frames: Frames| -> Vec<u64> {
            (0..=frames.last())
                .filter(|tick| frames.contains(*tick))
                .collect()
        };
        assert_eq!(ticks(frames("0..10", 4)), [0, 4, 8]);
        assert_eq!(frames("0..10", 4).count(), 3);
        assert_eq!(ticks(frames("3..9", 3)), [3, 6]);
        assert_eq!(frames("3..9", 3).count(), 2);
        assert_eq!(ticks(frames("7", 5)), [7]);
        for wrong in ["5..5", "6..2", "a..3", "", "-1..2"] {
            assert!(wrong.parse::<FrameRange>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_are_read() {
        assert_eq!("640x360".parse(), Ok(Size(UVec2::new(640, 360))));
        for wrong in ["640", "640x", "0x10", "x", "1e3x2", "9000x20"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }
}
