//! Options that a user gave, with their giver.

use crate::flags::of_schema::{self, Flag};
use crate::{AskError, Giver};
use clap::error::ErrorKind;
use clap::{ArgMatches, Args, Command, Error, FromArgMatches};
use meso_concrete::OutOfRange;
use meso_core::spec;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Options of a request, of which some have flags.
pub trait Options: JsonSchema + Serialize + DeserializeOwned + Default {
    /// The options that have flags, in the order of the help.
    const FLAGS: &'static [Flag];

    /// The key of the option that a user gives by a name: its key, with or without its unit, or a name of its flag. `more`
    /// lists keys without a flag.
    fn key_of<'a>(name: &str, more: &[&'a str]) -> Option<&'a str> {
        let with_flag = Self::FLAGS.iter().find(|flag| flag.is_called(name)).map(|flag| flag.key);
        with_flag.or_else(|| more.iter().copied().find(|key| of_schema::means(key, name)))
    }
}

/// Options that were given, and who gave them.
#[derive(Clone, Debug, Default)]
pub struct Given<T> {
    /// The options; those that nobody gave have their defaults.
    pub options: T,
    given: Map<String, Value>,
    giver: Giver<'static>,
}

impl<T: Options> Given<T> {
    /// The options of a table, each by its key.
    ///
    /// # Errors
    /// A value that its option cannot have.
    pub fn of(given: Map<String, Value>, giver: Giver<'static>) -> Result<Self, AskError> {
        let options = spec::options_from_value(&Value::Object(given.clone()));
        let options =
            options.map_err(|error| AskError::Usage(format!("{} {}", giver.option(&error.key), error.message)))?;
        Ok(Self { options, given, giver })
    }

    /// The front that fills the request.
    pub fn giver(&self) -> Giver<'static> {
        self.giver
    }

    /// Whether an option has a flag.
    pub fn has_flag(key: &str) -> bool {
        T::FLAGS.iter().any(|flag| flag.key == key)
    }

    /// The options of `base`, under those that were given.
    pub fn over(&self, base: &T) -> T {
        let mut tree = serde_json::to_value(base).unwrap_or_default();
        if let Value::Object(options) = &mut tree {
            options.extend(self.given.clone());
        }
        // Both were read from such trees; an option that is not taken would be another request.
        spec::options_from_value(&tree)
            .unwrap_or_else(|error| panic!("options that were read are read again: {error:?}"))
    }

    /// Whether an option was given.
    pub fn has(&self, key: &str) -> bool {
        self.given.contains_key(key)
    }

    /// Keys of the options that were given another value than their default.
    pub fn asked(&self) -> impl Iterator<Item = &'static str> {
        let usual = serde_json::to_value(T::default()).unwrap_or_default();
        T::FLAGS
            .iter()
            .map(|flag| flag.key)
            .filter(move |key| self.given.get(*key).is_some_and(|own| *own != usual[*key]))
    }

    /// A refusal in the giver's spelling.
    pub fn refusal(&self, wrong: &OutOfRange) -> String {
        self.giver.refusal(wrong)
    }
}

impl<T: Options> Args for Given<T> {
    fn augment_args(command: Command) -> Command {
        of_schema::add::<T>(T::FLAGS, command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T: Options> FromArgMatches for Given<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let value = |flag: &Flag| match matches.try_get_one::<bool>(flag.key) {
            Ok(switch) => switch.filter(|given| **given).map(|_| true.into()),
            Err(_) => matches.get_one::<Value>(flag.key).cloned(),
        };
        let given: Map<String, Value> =
            T::FLAGS.iter().filter_map(|flag| Some((flag.key.to_owned(), value(flag)?))).collect();
        let options = serde_json::from_value(Value::Object(given.clone()));
        let options = options.map_err(|error| Error::raw(ErrorKind::InvalidValue, format!("{error}\n")))?;
        Ok(Self { options, given, giver: Giver::Flags })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
