//! Scenes as files.

use std::{fs, io, path::Path};

use ron::{error::Span, extensions::Extensions, ser::PrettyConfig};

use super::{description::SceneDescription, error::SceneError};

/// Scene files, with the feature `scene_files`.
impl SceneDescription {
    /// Reads a scene from RON.
    ///
    /// # Errors
    ///
    /// [`SceneError::Parse`] if `text` is not a scene, [`SceneError::Invalid`] if it is an invalid
    /// one.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        Self::parse_from(text, "scene text")
    }

    /// Reads a scene from a file.
    ///
    /// # Errors
    ///
    /// As [`SceneDescription::parse`], naming the file; [`SceneError::Read`] if the file is missing
    /// or not UTF-8.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(|source| SceneError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse_from(&text, &path.display().to_string())
    }

    /// Reads a scene from RON that comes from `origin`, which errors name.
    pub(super) fn parse_from(text: &str, origin: &str) -> Result<Self, SceneError> {
        // Some editors begin a file with a byte-order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let scene: Self = ron_options().from_str(text).map_err(|error| {
            let (line, column) = place(text, error.span);
            let mut message = error.code.to_string();
            if let Some(variant) = spelled_twice(text, line, column) {
                message += &format!(
                    "; what is in `{variant}(…)` takes no name and no brackets of its own"
                );
            }
            SceneError::Parse {
                origin: origin.to_owned(),
                line,
                column,
                message,
            }
        })?;
        scene.validate().map_err(|problem| SceneError::Invalid {
            origin: origin.to_owned(),
            problem,
        })?;
        Ok(scene)
    }

    /// Writes the scene as RON that [`SceneDescription::parse`] reads back.
    ///
    /// # Errors
    ///
    /// Those of the RON writer, which can express every scene.
    pub fn to_ron(&self) -> ron::Result<String> {
        let pretty = PrettyConfig::new().struct_names(false).depth_limit(4);
        ron_options().to_string_pretty(self, pretty)
    }

    /// Writes the scene to a file.
    ///
    /// # Errors
    ///
    /// [`SceneError::Write`] if the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SceneError> {
        let path = path.as_ref();
        let text = self.to_ron().map_err(io::Error::other);
        text.and_then(|text| fs::write(path, text))
            .map_err(|source| SceneError::Write {
                path: path.to_owned(),
                source,
            })
    }
}

/// How scene files are read and written.
fn ron_options() -> ron::Options {
    ron::Options::default()
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES | Extensions::IMPLICIT_SOME)
}

/// The variant, if what is at a place is its content in the brackets, or under the name, that
/// standard RON has for a newtype: `Velocity((1, 0, 0))`, `TestSet(TestSet(rings: 3))`.
fn spelled_twice(text: &str, line: usize, column: usize) -> Option<&str> {
    let line = text.lines().nth(line.checked_sub(1)?)?;
    let place = line.char_indices().nth(column.checked_sub(1)?)?.0;
    let (before, at) = line.split_at(place);
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let before = before.trim_end().trim_end_matches(is_name);
    let variant = before.trim_end().strip_suffix('(')?.trim_end();
    let variant = &variant[variant.rfind(|c| !is_name(c)).map_or(0, |end| end + 1)..];
    let is_variant = ["TestSet", "Objects", "Velocity", "Track"].contains(&variant);
    (is_variant && at.trim_start_matches(is_name).trim_start().starts_with('(')).then_some(variant)
}

/// The line and column of the offending token: RON's span begins at the blanks and comments before
/// it.
fn place(text: &str, span: Span) -> (usize, usize) {
    let mut lines = text
        .lines()
        .enumerate()
        .skip(span.start.line.saturating_sub(1));
    let token = lines.find_map(|(index, line)| {
        let first = if index + 1 == span.start.line {
            span.start.col.saturating_sub(1)
        } else {
            0
        };
        let code = line.split("//").next()?;
        let blanks = code.chars().skip(first).position(|c| !c.is_whitespace())?;
        Some((index + 1, first + blanks + 1))
    });
    token.unwrap_or((span.end.line, span.end.col))
}
