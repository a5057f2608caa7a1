//! A serde deserializer over [`Node`] whose errors know the dotted path, the line and the nearest known name.

use super::messages::{found, list_of, nearest, plain_words, quoted};
use super::tree::{Node, Value};
use super::{Spec, SpecError};
use serde::de::value::SeqDeserializer;
use serde::de::{self, Deserialize, DeserializeSeed, Error, Expected, IntoDeserializer, Unexpected, Visitor};
use std::fmt::{self, Display};

/// Reads any option type from a tree.
pub(super) fn read<'de, T: Deserialize<'de>>(tree: &'de Node) -> Result<T, SpecError> {
    T::deserialize(tree).map_err(|fault| fault.into_error(tree))
}

/// A fault that serde found, while the path to it is still being collected from the inside out.
#[derive(Debug)]
pub(super) struct Fault {
    path: Vec<String>,
    what: What,
}

#[derive(Debug)]
pub(super) enum What {
    UnknownKey {
        name: String,
        known: &'static [&'static str],
    },
    UnknownWord {
        word: String,
        known: &'static [&'static str],
    },
    Missing(&'static str),
    /// A value of the wrong type, or of the right one and out of its range, and the expected one.
    Unfit {
        found: String,
        wanted: String,
        is_wrong_type: bool,
    },
    Other(String),
}

impl Fault {
    fn new(what: What) -> Self {
        Self { path: Vec::new(), what }
    }

    fn inside(mut self, key: &str) -> Self {
        self.path.push(key.to_owned());
        self
    }

    fn into_error(mut self, tree: &Node) -> SpecError {
        self.path.reverse();
        self.path.extend(self.lost_path(tree));
        let (name, message, is_wrong_type) = self.what.describe(&self.path);
        self.path.extend(name);
        SpecError { is_wrong_type, ..SpecError::value(self.path.join("."), message) }.at(tree)
    }

    /// serde buffers tables that carry a tag and forgets which key it was at: find the value it stumbled over.
    fn lost_path(&self, tree: &Node) -> Option<String> {
        let wrong = match &self.what {
            What::Unfit { found, .. } => found.clone(),
            What::UnknownWord { word, .. } => found(&Unexpected::Str(word)),
            _ => return None,
        };
        let table = self.path.iter().try_fold(tree, |node, name| node.child(name))?;
        let Value::Table(entries) = &table.value else { return None };
        entries.iter().find(|(_, child)| child.holds(&wrong)).map(|(key, _)| key.clone())
    }
}

impl Node {
    /// True when this value, or one inside it, is the one that a fault calls `found`.
    fn holds(&self, wrong: &str) -> bool {
        if let Value::Array(items) = &self.value
            && (list_of(items.len()) == wrong || items.iter().any(|item| item.holds(wrong)))
        {
            return true;
        }
        found(&self.unexpected()) == wrong
    }

    pub(super) fn unexpected(&self) -> Unexpected<'_> {
        match &self.value {
            Value::Null => Unexpected::Option,
            Value::Bool(flag) => Unexpected::Bool(*flag),
            Value::Integer(n) => match (i64::try_from(*n), u64::try_from(*n)) {
                (_, Ok(n)) => Unexpected::Unsigned(n),
                (Ok(n), _) => Unexpected::Signed(n),
                _ => Unexpected::Other("an integer beyond 64 bits"),
            },
            Value::Float(x) => Unexpected::Float(*x),
            Value::Text(text) => Unexpected::Str(text),
            Value::Array(_) => Unexpected::Seq,
            Value::Table(_) => Unexpected::Map,
        }
    }
}

impl What {
    /// The key's last part where serde knows it, the rest of the sentence, and whether the type is wrong.
    fn describe(&self, path: &[String]) -> (Option<String>, String, bool) {
        match self {
            Self::UnknownKey { name, known } => (
                Some(if name.is_empty() { "\"\"".to_owned() } else { name.clone() }),
                unknown_key(name, &with_library(known, path, &["shape"], &LIBRARY), path),
                false,
            ),
            Self::UnknownWord { word, known } => {
                let known = &with_library(known, path, &["shape", "kind"], &["harmonics"]);
                let hint = nearest(word, known).map(|near| format!("; did you mean \"{near}\"?")).unwrap_or_default();
                (None, format!("is {word:?}; it must be one of {}{hint}", quoted(known)), false)
            }
            Self::Missing(name) => (Some((*name).to_owned()), "is missing; add it".to_owned(), false),
            Self::Unfit { found, wanted, is_wrong_type } => {
                (None, format!("is {found}; it must be {wanted}"), *is_wrong_type)
            }
            Self::Other(message) => (None, format!("cannot be read: {message}"), false),
        }
    }
}

/// Keys of `shape` that become its grains before serde sees them.
const LIBRARY: [&str; 6] = ["library", "path", "hull", "tolerance", "degree", "triangles"];

/// The words that serde knows, and `more` where the path is `place`: libraries are read before serde sees the shape.
fn with_library<'a>(known: &[&'a str], path: &[String], place: &[&str], more: &[&'a str]) -> Vec<&'a str> {
    known.iter().chain(more.iter().filter(|_| path == place)).copied().collect()
}

fn unknown_key(name: &str, known: &[&str], path: &[String]) -> String {
    if let Some(near) = nearest(name, known) {
        return format!("is not a known key; did you mean {near}?");
    }
    // `size` for `element_size_mm`.
    let wider: Vec<&str> = known.iter().copied().filter(|key| key.split('_').any(|word| word == name)).collect();
    if !wider.is_empty() {
        return format!("is not a known key; did you mean {}?", wider.join(" or "));
    }
    let homes = homes_of(name);
    if homes.is_empty() || homes.iter().any(|home| home == path) {
        return format!("is not a known key; the keys here are {}", known.join(", "));
    }
    if homes[0].is_empty() {
        return "is not a known key here; it belongs at the top, before any [table]".to_owned();
    }
    let tables: Vec<String> = homes.iter().map(|home| format!("[{}]", home.join("."))).collect();
    format!("is not a known key here; it belongs under {}", tables.join(" or "))
}

/// The tables in which the default spec has a key of this name, the outermost first.
fn homes_of(name: &str) -> Vec<Vec<String>> {
    let mut homes = Vec::new();
    homes_in(&serde_json::to_value(Spec::default()).unwrap_or_default(), name, &[], &mut homes);
    homes.sort_by_key(Vec::len);
    homes
}

fn homes_in(table: &serde_json::Value, name: &str, path: &[String], homes: &mut Vec<Vec<String>>) {
    let Some(entries) = table.as_object() else { return };
    if entries.contains_key(name) {
        homes.push(path.to_vec());
    }
    entries.iter().for_each(|(key, child)| homes_in(child, name, &[path, std::slice::from_ref(key)].concat(), homes));
}

impl Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what.describe(&self.path).1)
    }
}

impl std::error::Error for Fault {}

impl de::Error for Fault {
    fn custom<T: Display>(message: T) -> Self {
        Self::new(What::Other(message.to_string()))
    }

    fn invalid_type(unfit: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        let (found, wanted) = (found(&unfit), plain_words(&wanted.to_string()));
        Self::new(What::Unfit { found, wanted, is_wrong_type: true })
    }

    fn invalid_value(unfit: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        let (found, wanted) = (found(&unfit), plain_words(&wanted.to_string()));
        Self::new(What::Unfit { found, wanted, is_wrong_type: false })
    }

    fn invalid_length(length: usize, wanted: &dyn Expected) -> Self {
        let (found, wanted) = (list_of(length), plain_words(&wanted.to_string()));
        Self::new(What::Unfit { found, wanted, is_wrong_type: false })
    }

    fn unknown_variant(word: &str, known: &'static [&'static str]) -> Self {
        Self::new(What::UnknownWord { word: word.to_owned(), known })
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(What::UnknownKey { name: name.to_owned(), known })
    }

    fn missing_field(name: &'static str) -> Self {
        Self::new(What::Missing(name))
    }
}

/// The entries of a table; adds the key to the path of an error in its value.
struct Entries<'de> {
    rest: std::slice::Iter<'de, (String, Node)>,
    current: Option<&'de (String, Node)>,
}

impl<'de> de::MapAccess<'de> for Entries<'de> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        self.current = self.rest.next();
        self.current.map(|(key, _)| seed.deserialize(key.as_str().into_deserializer())).transpose()
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let (key, node) = self.current.ok_or_else(|| Fault::custom("a value was read before its key"))?;
        // Here and not in the value's deserializer: serde reads a tagged table only after that is gone.
        seed.deserialize(node).map_err(|fault| fault.inside(key))
    }
}

impl<'de> IntoDeserializer<'de, Fault> for &'de Node {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> de::Deserializer<'de> for &'de Node {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Null => visitor.visit_unit(),
            Value::Bool(flag) => visitor.visit_bool(*flag),
            Value::Integer(n) => match (u64::try_from(*n), i64::try_from(*n)) {
                (Ok(n), _) => visitor.visit_u64(n),
                (_, Ok(n)) => visitor.visit_i64(n),
                _ => Err(de::Error::invalid_value(self.unexpected(), &visitor)),
            },
            Value::Float(x) => visitor.visit_f64(*x),
            Value::Text(text) => visitor.visit_str(text),
            Value::Array(items) => {
                let mut items = SeqDeserializer::new(items.iter());
                let value = visitor.visit_seq(&mut items)?;
                items.end()?;
                Ok(value)
            }
            Value::Table(entries) => visitor.visit_map(Entries { rest: entries.iter(), current: None }),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Value::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match &self.value {
            Value::Text(text) => visitor.visit_enum(text.as_str().into_deserializer()),
            _ => Err(de::Error::invalid_type(self.unexpected(), &"a name in quotes")),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value {
            // A list would be read as the fields in their order of declaration, which is nobody's business.
            Value::Array(_) => Err(Error::invalid_type(Unexpected::Seq, &"a table")),
            _ => self.deserialize_any(visitor),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        newtype_struct seq tuple tuple_struct map identifier ignored_any
    }
}
