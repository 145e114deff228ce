//! `peers app`.
#[derive(clap::Args)]
pub struct Arguments {}
pub fn run(_: &Arguments) -> crate::outcome::Outcome {
    Ok(())
}
