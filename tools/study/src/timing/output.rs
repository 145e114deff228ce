//! The folder that everything is written to.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::outcome::Outcome;

/// A folder that can be written to.
pub struct Output(PathBuf);

impl Output {
    /// Makes the folder if there is none, and tries it, so that nothing is measured in vain.
    ///
    /// # Errors
    /// Names the folder.
    pub fn new(folder: &Path) -> Outcome<Self> {
        let probe = folder.join("answers.md");
        fs::create_dir_all(folder)
            .and_then(|()| fs::write(probe, "The study has not finished.\n"))
            .map_err(|error| format!("cannot write to the folder {}: {error}", folder.display()))?;
        Ok(Self(folder.to_owned()))
    }

    /// A file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file of text.
    pub fn text(&self, name: &str, text: &str) -> Outcome {
        let path = self.path(name);
        fs::write(&path, text)
            .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
    }

    /// Writes a file of comma-separated values.
    pub fn csv(
        &self,
        name: &str,
        fill: impl FnOnce(&mut csv::Writer<Vec<u8>>) -> csv::Result<()>,
    ) -> Outcome {
        let mut writer = csv::Writer::from_writer(Vec::new());
        fill(&mut writer)?;
        self.text(name, &String::from_utf8(writer.into_inner()?)?)
    }
}

/// A number to three significant digits.
pub fn significant(value: f64) -> String {
    let digits = if value.is_finite() && value != 0.0 {
        value.abs().log10().floor() as i32
    } else {
        0
    };
    let unit = 10f64.powi(digits - 2);
    format!(
        "{:.*}",
        usize::try_from(2 - digits).unwrap_or(0),
        (value / unit).round() * unit
    )
}
