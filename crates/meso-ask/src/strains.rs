//! Strains by the name of their phase: a table in files, `mortar=-4e-4` in flags.

use crate::flags::values;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::collections::BTreeMap;

/// A phase, or a label, and its strain without stress.
pub(crate) type Strain = (String, f64);

/// Reads a flag's `mortar=-4e-4`.
pub(crate) fn of_flag(text: &str) -> Result<Strain, String> {
    let (phase, strain) = text.split_once('=').ok_or("it must be a phase and a strain, as in mortar=-4e-4")?;
    Ok((phase.trim().to_owned(), values::number(strain.trim())?))
}

/// Strains as flags have them.
pub(crate) fn shown(strains: &[Strain]) -> String {
    strains.iter().map(|(phase, strain)| format!("{phase}={strain:e}")).collect::<Vec<_>>().join(",")
}

pub(crate) fn serialize<S: Serializer>(strains: &[Strain], to: S) -> Result<S::Ok, S::Error> {
    strains.iter().cloned().collect::<BTreeMap<_, _>>().serialize(to)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Strain>, D::Error> {
    match Form::deserialize(from)? {
        Form::Text(text) => text.split(',').map(of_flag).collect::<Result<_, _>>().map_err(de::Error::custom),
        Form::Table(strains) => Ok(strains.into_iter().collect()),
    }
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a table of strains by phase")]
enum Form {
    Text(String),
    Table(BTreeMap<String, f64>),
}
