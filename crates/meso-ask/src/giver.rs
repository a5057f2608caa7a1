//! The front that gave a request's values, which decides the spelling of its options.

use crate::flags::of_schema;
use meso_concrete::OutOfRange;
use std::fmt::Display;
use std::path::Path;

/// A front that fills a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Giver<'a> {
    /// Flags of the command: `--voxel-size-mm`.
    #[default]
    Flags,
    /// Keywords of Python, in which lengths have no unit: `voxel_size`.
    Keywords,
    /// Entries of a dict that is a keyword of Python: `solve["friction"]`.
    Keyword(&'a str),
    /// A section of a study, whose keys are flags: `[effective] voxel_size_mm`, `[solve] duration`.
    Section(&'a str),
    /// A table whose keys are those of the options: `[test] duration_s`.
    Table(&'a str),
}

impl Giver<'_> {
    /// The option with this key, as its user spells it. Values in a table, as of `materials.mortar`, have no flag.
    pub fn option(self, key: &str) -> String {
        match self {
            Self::Flags | Self::Keywords if key.contains('.') => key.to_owned(),
            Self::Flags => of_schema::name(key),
            Self::Keywords => keyword(key).to_owned(),
            Self::Keyword(name) => format!("{name}[\"{}\"]", keyword(key)),
            Self::Section(name) => {
                format!("[{name}] {}", of_schema::name(key).trim_start_matches('-').replace('-', "_"))
            }
            Self::Table(name) => format!("[{name}] {key}"),
        }
    }

    /// A value of the option with this key, as its user types it.
    pub fn choice(self, key: &str, value: &str) -> String {
        let option = self.option(key);
        match self {
            Self::Flags => format!("{option} {value}"),
            Self::Keywords | Self::Keyword(_) => format!("{option}=\"{value}\""),
            Self::Section(_) | Self::Table(_) => format!("{option} = \"{value}\""),
        }
    }

    /// A number for the option with this key, as its user types it.
    pub fn number(self, key: &str, value: impl Display) -> String {
        let option = self.option(key);
        match self {
            Self::Flags => format!("{option} {value}"),
            Self::Keywords | Self::Keyword(_) => format!("{option}={value}"),
            Self::Section(_) | Self::Table(_) => format!("{option} = {value}"),
        }
    }

    /// Labels for the option with this key, as its user types them; negative ones, too.
    pub fn labels(self, key: &str, labels: &[i64]) -> String {
        match self {
            Self::Flags => {
                let list = labels.iter().map(i64::to_string).collect::<Vec<_>>().join(",");
                format!("{}={list}", self.option(key))
            }
            _ => self.number(key, format_args!("{labels:?}")),
        }
    }

    /// The option that lets files be replaced, as its user gives it.
    fn overwriting(self) -> &'static str {
        if self == Self::Flags { "--force" } else { "overwrite=True" }
    }

    /// Why a file that exists is kept.
    pub fn exists(self, file: &Path) -> String {
        format!("{} exists; {} replaces it", file.display(), self.overwriting())
    }

    /// Why a file beside another one is kept, which an earlier one has left there.
    pub fn is_left(self, left: &Path, file: impl Display) -> String {
        format!("{} is of an earlier {file}; {} removes it", left.display(), self.overwriting())
    }

    /// A refusal in the user's spelling: the option, its value and the accepted range.
    pub fn refusal(self, wrong: &OutOfRange) -> String {
        format!("{} {}", self.option(&wrong.key), wrong.fault())
    }
}

/// Python's keyword of a key: lengths and the time limit have no unit.
fn keyword(key: &str) -> &str {
    if key == "time_limit_s" { "time_limit" } else { key.trim_end_matches("_mm") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_concrete::Ranges;

    #[test]
    fn a_refusal_is_spelled_as_its_option_was_given() {
        let wrong = Ranges("effective").positive("voxel_size_mm", 0.0).unwrap_err();
        let of = |giver: Giver<'_>| giver.refusal(&wrong);
        assert_eq!(of(Giver::Flags), "--voxel-size-mm is 0; it must be a positive number");
        assert_eq!(of(Giver::Keywords), "voxel_size is 0; it must be a positive number");
        assert_eq!(of(Giver::Keyword("effective")), "effective[\"voxel_size\"] is 0; it must be a positive number");
        assert_eq!(Giver::Keywords.option("time_limit_s"), "time_limit");
        assert_eq!(Giver::Section("solve").option("duration_s"), "[solve] duration");
        let choice = |giver: Giver<'_>| giver.choice("method", "lattice");
        assert_eq!(choice(Giver::Flags), "--method lattice");
        assert_eq!(choice(Giver::Keywords), "method=\"lattice\"");
        assert_eq!(choice(Giver::Section("mesh")), "[mesh] method = \"lattice\"");
        assert_eq!(Giver::Table("test").option("duration_s"), "[test] duration_s");
        assert_eq!(of(Giver::Section("effective")), "[effective] voxel_size_mm is 0; it must be a positive number");
    }
}
