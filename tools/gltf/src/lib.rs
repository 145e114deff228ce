//! Levels from glTF files, as Bevy loads them, headless: see `tests`.
