//! Some of the axes x, y, z, as a word: `xz`.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Unexpected};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};

const WANTED: &str = "some of x, y, z, each once, as in xz";

/// At least one of the axes x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes([bool; 3]);

impl Axes {
    /// All three.
    pub const ALL: Self = Self([true; 3]);

    /// Which of x, y, z they are.
    pub fn flags(self) -> [bool; 3] {
        self.0
    }

    /// Reads a word such as `xz`.
    ///
    /// # Errors
    /// Other letters, an axis twice, and none.
    pub fn read(text: &str) -> Result<Self, String> {
        let axes = ['x', 'y', 'z'].map(|axis| text.contains(axis));
        let named = axes.iter().filter(|axis| **axis).count();
        if named == 0 || text.chars().count() != named {
            return Err(format!("it must be {WANTED}"));
        }
        Ok(Self(axes))
    }
}

impl Default for Axes {
    fn default() -> Self {
        Self::ALL
    }
}

impl Display for Axes {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        ["x", "y", "z"].into_iter().zip(self.0).filter(|(_, has)| *has).try_for_each(|(name, _)| out.write_str(name))
    }
}

impl Serialize for Axes {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Axes {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        Self::read(&text).map_err(|_| de::Error::invalid_value(Unexpected::Str(&text), &WANTED))
    }
}

impl JsonSchema for Axes {
    fn schema_name() -> Cow<'static, str> {
        "Axes".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "pattern": "^[xyz]{1,3}$" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_words_of_x_y_z_each_once() {
        assert_eq!(
            Axes::read("zx").map(|axes| (axes.flags(), axes.to_string())),
            Ok(([true, false, true], "xz".into()))
        );
        for wrong in ["", "xx", "w", "xyzx", "x y"] {
            assert!(Axes::read(wrong).is_err(), "{wrong}");
        }
        assert_eq!(serde_json::from_str::<Axes>("\"y\"").unwrap().flags(), [false, true, false]);
        assert!(serde_json::from_str::<Axes>("\"q\"").unwrap_err().to_string().contains("some of x, y, z"));
    }
}
