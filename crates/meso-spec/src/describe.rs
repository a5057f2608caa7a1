//! A spec that explains itself: its TOML, with the meaning of every key above it.

use super::Spec;
use serde_json::Value;

/// Columns of a comment.
const WIDTH: usize = 100;

impl Spec {
    /// The text of a SPEC.toml with the meaning of each key above it, and the words that the key accepts. The text
    /// reads back as this spec.
    ///
    /// # Errors
    /// A seed beyond 2^63 - 1, which TOML cannot write.
    pub fn describe(&self) -> Result<String, toml::ser::Error> {
        let (schema, tree) = (Self::schema(), serde_json::to_value(self).unwrap_or_default());
        let (mut section, mut text) = (Vec::new(), String::new());
        for line in toml::to_string(self)?.lines() {
            let path = path_of(line, &mut section);
            let meaning = path.and_then(|path| meaning(&schema, &tree, &path)).unwrap_or_default();
            comment(&meaning, &mut text);
            text.push_str(line);
            text.push('\n');
        }
        Ok(text)
    }
}

/// The key or table that a line of TOML begins, from the top; `section` is the table at that line.
fn path_of(line: &str, section: &mut Vec<String>) -> Option<Vec<String>> {
    if let Some(name) = line.strip_prefix('[') {
        *section = name.trim_matches(['[', ']']).split('.').map(str::to_owned).collect();
        return Some(section.clone());
    }
    let (key, _) = line.split_once(" = ")?;
    Some([section.as_slice(), &[key.to_owned()]].concat())
}

/// The schema's description of the key at `path`.
fn meaning(schema: &Value, tree: &Value, path: &[String]) -> Option<String> {
    let (mut node, mut value, mut variant) = (schema, tree, schema);
    for key in path {
        if let Some(items) = node.get("items") {
            (node, value) = (items, &value[0]);
        }
        variant = form(schema, node, value);
        node = variant["properties"].get(key)?;
        value = &value[key];
    }
    // A tag says which variant it is.
    let described = if node.get("const").is_some() { variant } else { node };
    let text = described["description"].as_str()?.replace('\n', " ");
    Some(match choices(schema, node) {
        Some(words) => format!("{text} One of {words}."),
        None => text,
    })
}

/// The part of the schema that `value` has the form of.
fn form<'a>(schema: &'a Value, node: &'a Value, value: &Value) -> &'a Value {
    let node = definition(schema, node);
    let forms = node["oneOf"].as_array().or(node["anyOf"].as_array());
    let mut forms = forms.into_iter().flatten().map(|node| definition(schema, node));
    forms.find(|node| fits(node, value)).unwrap_or(node)
}

/// Whether `value` has the tags of a form.
fn fits(form: &Value, value: &Value) -> bool {
    let mut properties = form["properties"].as_object().into_iter().flatten();
    form["type"] == "object" && properties.all(|(key, node)| node.get("const").is_none_or(|tag| *tag == value[key]))
}

fn definition<'a>(schema: &'a Value, node: &'a Value) -> &'a Value {
    let name = node["$ref"].as_str().and_then(|address| address.strip_prefix("#/$defs/"));
    name.map_or(node, |name| &schema["$defs"][name])
}

/// The words that a key may be, where there are few.
fn choices(schema: &Value, node: &Value) -> Option<String> {
    let forms = definition(schema, node)["oneOf"].as_array()?;
    let words: Option<Vec<String>> = forms.iter().map(|form| Some(form.get("const")?.to_string())).collect();
    Some(words?.join(", "))
}

/// Adds `meaning` as comments that are no wider than [`WIDTH`].
fn comment(meaning: &str, text: &mut String) {
    let mut line = String::from("#");
    for word in meaning.split_whitespace() {
        if line.len() + 1 + word.len() > WIDTH {
            text.push_str(&line);
            text.push('\n');
            line.truncate(1);
        }
        line.push(' ');
        line.push_str(word);
    }
    if line.len() > 1 {
        text.push_str(&line);
        text.push('\n');
    }
}
