//! How a program ends.

use std::{error::Error, process::ExitCode};

/// What may fail, with an error for the user.
pub type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// Tells the user what went wrong, if anything did.
pub fn exit(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
