//! Tables of values by phase: the keys that every concrete has, and beside them those of the specimen's own phases.

use serde::de::{self, Deserialize, Deserializer, Error, IntoDeserializer, MapAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;

/// Reads a struct by `read`, which refuses unknown keys, and the values of all other names beside it.
///
/// # Errors
/// Those of both; a name that begins like a key of the struct is refused as an unknown key.
pub fn read<'de, D: Deserializer<'de>, S, T: Deserialize<'de>>(
    deserializer: D,
    read: impl FnOnce(CommonTable<'_, D, T>) -> Result<S, D::Error>,
) -> Result<(S, BTreeMap<String, T>), D::Error> {
    let mut own = BTreeMap::new();
    let common = read(CommonTable { deserializer, own: &mut own })?;
    Ok((common, own))
}

/// A deserializer of a struct that keeps the tables of other names for `own`.
pub struct CommonTable<'a, D, T> {
    deserializer: D,
    own: &'a mut BTreeMap<String, T>,
}

impl<'de, D: Deserializer<'de>, T: Deserialize<'de>> Deserializer<'de> for CommonTable<'_, D, T> {
    type Error = D::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.deserializer.deserialize_any(visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        let entries = CommonEntries { entries: visitor, known, own: self.own };
        self.deserializer.deserialize_struct(name, known, entries)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        newtype_struct seq tuple tuple_struct map identifier ignored_any option enum
    }
}

/// A known key that begins like a name, which makes the name a slip of it.
pub fn alike<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let begins = |known: &str| name.bytes().zip(known.bytes()).take_while(|(a, b)| a == b).count();
    known.iter().copied().find(|known| begins(known) >= ALIKE)
}

/// A struct's visitor or its entries, without those of other names.
struct CommonEntries<'a, E, T> {
    entries: E,
    known: &'static [&'static str],
    own: &'a mut BTreeMap<String, T>,
}

impl<'de, V: Visitor<'de>, T: Deserialize<'de>> Visitor<'de> for CommonEntries<'_, V, T> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.entries.expecting(f)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<V::Value, A::Error> {
        self.entries.visit_map(CommonEntries { entries: map, known: self.known, own: self.own })
    }
}

/// Letters at the beginning of a name that make it a slip of a known one.
const ALIKE: usize = 4;

impl<'de, A: MapAccess<'de>, T: Deserialize<'de>> MapAccess<'de> for CommonEntries<'_, A, T> {
    type Error = A::Error;

    fn next_key_seed<K: de::DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        while let Some(key) = self.entries.next_key::<String>()? {
            if self.known.contains(&key.as_str()) {
                return seed.deserialize(key.into_deserializer()).map(Some);
            }
            if alike(&key, self.known).is_some() {
                return Err(A::Error::unknown_field(&key, self.known));
            }
            let values = self.entries.next_value()?;
            self.own.insert(key, values);
        }
        Ok(None)
    }

    fn next_value_seed<V: de::DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.entries.next_value_seed(seed)
    }
}
