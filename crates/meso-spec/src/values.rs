//! A spec's tree of values: changes laid over it, and its text.

use super::Spec;
use serde_json::Value;

impl Spec {
    /// Lays `changes` over `base`, a spec's values or a part of them, section by section.
    pub fn overlay(base: &mut Value, changes: Value) {
        overlay(base, changes);
    }

    /// The spec as compact JSON, the keys of each table in order: the text of its tree of values, in a fifth of the time.
    pub fn sorted_json(&self) -> String {
        let text = serde_json::to_string(self).expect("a spec is a tree of values");
        debug_assert!(!text.contains('\\'), "an escaped key has another place than its text");
        let mut sorted = String::with_capacity(text.len());
        sort(&text, 0, &mut sorted);
        sorted
    }
}

fn overlay(base: &mut Value, changes: Value) {
    match (base, changes) {
        (Value::Object(base), Value::Object(changes)) => {
            // A section that names another variant (specimen.kind, a law) replaces the old one, whose keys do not fit.
            let renamed = |tag: &str| changes.get(tag).is_some_and(|new| base.get(tag) != Some(new));
            if renamed("kind") || renamed("law") {
                base.clear();
            }
            for (key, change) in changes {
                overlay(base.entry(key).or_insert(Value::Null), change);
            }
        }
        (base @ Value::Null, Value::Object(changes)) => {
            *base = Value::Object(serde_json::Map::new());
            overlay(base, Value::Object(changes));
        }
        (base, change) => *base = change,
    }
}

/// Appends the value that begins at `from`, the keys of each table in order; returns where it ends. Text has no escapes.
fn sort(text: &str, from: usize, sorted: &mut String) -> usize {
    let until =
        |at: usize, is_end: fn(&u8) -> bool| at + text.as_bytes()[at..].iter().take_while(|byte| !is_end(byte)).count();
    let (mut at, place, mut items) = (from + 1, sorted.len() + 1, Vec::new());
    match text.as_bytes()[from] {
        open @ (b'{' | b'[') => {
            sorted.push(open.into());
            while !matches!(text.as_bytes()[at], b'}' | b']') {
                at += usize::from(text.as_bytes()[at] == b',');
                let (begin, key) = (sorted.len() - place, at);
                if open == b'{' {
                    at = until(at + 1, |byte| *byte == b'"') + 2;
                    sorted.push_str(&text[key..at]);
                }
                // The key has its quote in front, and neither the one behind nor the colon.
                let key = text[key..at].trim_end_matches("\":");
                at = sort(text, at, sorted);
                items.push((key, begin..sorted.len() - place));
            }
            let copied = sorted.split_off(place);
            if open == b'{' {
                items.sort_unstable_by_key(|(key, _)| *key);
            }
            for (number, (_, item)) in items.into_iter().enumerate() {
                sorted.push_str(if number > 0 { "," } else { "" });
                sorted.push_str(&copied[item]);
            }
            at += 1;
            sorted.push_str(&text[at - 1..at]);
        }
        b'"' => {
            at = until(at, |byte| *byte == b'"') + 1;
            sorted.push_str(&text[from..at]);
        }
        _ => {
            at = until(at, |byte| matches!(byte, b',' | b'}' | b']'));
            sorted.push_str(&text[from..at]);
        }
    }
    at
}
