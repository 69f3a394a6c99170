//! Groups of flags that know which of them were typed.

use std::ops::Deref;

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

/// Flags, and which of them were given: where they would do nothing they are refused.
#[derive(Debug)]
pub(crate) struct Given<T> {
    args: T,
    /// As they are typed.
    pub(crate) given: Vec<String>,
}

impl<T> Deref for Given<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.args
    }
}

impl<T: Args> Args for Given<T> {
    fn augment_args(command: Command) -> Command {
        T::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        T::augment_args_for_update(command)
    }
}

impl<T: Args> FromArgMatches for Given<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let flags = T::augment_args(Command::new(""));
        let typed = |flag: &&Arg| {
            let source = matches.value_source(flag.get_id().as_str());
            source == Some(ValueSource::CommandLine)
        };
        let given = flags.get_arguments().filter(typed);
        Ok(Self {
            given: given
                .filter_map(|flag| Some(format!("--{}", flag.get_long()?)))
                .collect(),
            args: T::from_arg_matches(matches)?,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
