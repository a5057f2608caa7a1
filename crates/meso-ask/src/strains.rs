//! Strains by the name of their phase: a table in files, `mortar=-4e-4` in flags.

use crate::flags::values;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt::{self, Formatter};

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
    from.deserialize_any(TextOrMap)
}

struct TextOrMap;

impl<'de> Visitor<'de> for TextOrMap {
    type Value = Vec<Strain>;

    fn expecting(&self, out: &mut Formatter<'_>) -> fmt::Result {
        out.write_str("a map of strains by phase")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Vec<Strain>, E> {
        text.split(',').map(of_flag).collect::<Result<_, _>>().map_err(E::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Vec<Strain>, A::Error> {
        let strains = BTreeMap::<String, f64>::deserialize(MapAccessDeserializer::new(map))?;
        Ok(strains.into_iter().collect())
    }
}
