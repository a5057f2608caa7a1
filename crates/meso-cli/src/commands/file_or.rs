//! Parser of a TOML file, or of a name.

use clap::builder::TypedValueParser;
use clap::{Arg, Command};
use meso_ask::files::is_toml;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Parser of a TOML file, which its ending gives away, or of a name.
#[derive(Clone)]
pub(super) struct FileOr<T, P> {
    pub(super) file: fn(PathBuf) -> T,
    pub(super) name: P,
}

impl<T: Clone + Send + Sync + 'static, P: TypedValueParser<Value = T>> TypedValueParser for FileOr<T, P> {
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, clap::Error> {
        let path = Path::new(value);
        if is_toml(path) { Ok((self.file)(path.to_owned())) } else { self.name.parse_ref(command, arg, value) }
    }
}
