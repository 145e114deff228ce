//! The arguments of an example.

use std::{env, fmt::Display, process, str::FromStr};

use crate::outcome::Outcome;

/// The arguments that nobody has taken yet.
pub struct Arguments(Vec<String>);

impl Arguments {
    /// All that were given. If `--help` is among them, prints `help` and ends the program.
    pub fn given(help: &str) -> Self {
        let given: Vec<_> = env::args_os()
            .skip(1)
            .map(|argument| argument.to_string_lossy().into_owned())
            .collect();
        if given
            .iter()
            .any(|argument| ["-h", "--help"].contains(&&**argument))
        {
            println!("{}", help.trim());
            process::exit(0);
        }
        Self(given)
    }

    /// Takes `name value` or `name=value`, wherever it is.
    pub fn option<T: FromStr<Err: Display>>(&mut self, name: &str) -> Outcome<Option<T>> {
        let is_named = |argument: &String| argument.split('=').next() == Some(name);
        let Some(index) = self.0.iter().position(is_named) else {
            return Ok(None);
        };
        let argument = self.0.remove(index);
        let value = match argument.split_once('=') {
            Some((_, value)) => value.to_owned(),
            None if self
                .0
                .get(index)
                .is_some_and(|next| !next.starts_with("--")) =>
            {
                self.0.remove(index)
            }
            None => return Err(format!("{name} needs a value; see --help").into()),
        };
        let value = value
            .parse()
            .map_err(|error| format!("invalid value `{value}` for {name}: {error}"))?;
        Ok(Some(value))
    }

    /// Takes what is left when all options are taken: a value for each of `names`, and no more.
    pub fn rest<const COUNT: usize>(self, names: [&str; COUNT]) -> Outcome<[String; COUNT]> {
        let is_unexpected =
            |&(index, argument): &(usize, &String)| argument.starts_with('-') || index >= COUNT;
        if let Some((_, argument)) = self.0.iter().enumerate().find(is_unexpected) {
            return Err(format!("unexpected argument `{argument}`; see --help").into());
        }
        self.0.try_into().map_err(|given: Vec<_>| {
            format!("{} is missing; see --help", names[given.len()]).into()
        })
    }
}
