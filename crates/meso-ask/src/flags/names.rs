//! Options with a name out of a few: the core's own enums, so that a new method needs no change here.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use serde::de::value::{Error, StrDeserializer};
use serde::de::{self, Deserialize, Deserializer, IntoDeserializer, Visitor};

/// Parser of the names that serde knows as those of `T`; help, completions and tips list them.
pub fn parser<T>() -> impl TypedValueParser<Value = T>
where
    T: for<'de> Deserialize<'de> + Clone + Send + Sync + 'static,
{
    parser_of(all::<T>().to_vec(), read)
}

/// Parser of some names, which `read` turns into values.
pub fn parser_of<T>(
    names: Vec<&'static str>,
    read: impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static,
) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(move |name| read(&name))
}

/// Reads a name that serde knows as one of `T`'s.
pub fn read<T: for<'de> Deserialize<'de>>(text: &str) -> Result<T, String> {
    let name: StrDeserializer<'_, Error> = text.into_deserializer();
    T::deserialize(name).map_err(|error| error.to_string())
}

/// All names of `T`, with commas.
pub fn list<T: for<'de> Deserialize<'de>>() -> String {
    all::<T>().join(", ")
}

/// All names of `T`.
pub fn all<T: for<'de> Deserialize<'de>>() -> &'static [&'static str] {
    let mut names: &[&str] = &[];
    // It always fails, after it has received the names.
    let _ = T::deserialize(Ask(&mut names));
    names
}

/// The name of `value`; empty where serde has none for it.
pub fn of(value: &impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Asks a type for the names of its variants.
struct Ask<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Ask<'_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(de::Error::custom("no enum"))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Error> {
        *self.0 = variants;
        Err(de::Error::custom("only asked"))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Arg, Command};
    use meso_core::packing::Strategy;

    #[test]
    fn names_are_those_of_the_spec() {
        assert_eq!(all::<Strategy>(), ["auto", "take-and-place", "rearrange"]);
        let command = Command::new("x").arg(Arg::new("strategy").value_parser(parser::<Strategy>()));
        let found = command.clone().try_get_matches_from(["x", "rearrange"]).unwrap();
        assert_eq!(found.get_one("strategy"), Some(&Strategy::Rearrange));
        let error = command.try_get_matches_from(["x", "rearange"]).unwrap_err().to_string();
        assert!(error.contains("[possible values: auto, take-and-place, rearrange]"), "{error}");
        assert!(error.contains("a similar value exists: 'rearrange'"), "{error}");
    }
}
