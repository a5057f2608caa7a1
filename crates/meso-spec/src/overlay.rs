//! Changes laid over a spec's tree of values.

use super::Spec;
use serde_json::Value;

impl Spec {
    /// Lays `changes` over `base`, a spec's values or a part of them, section by section.
    pub fn overlay(base: &mut Value, changes: Value) {
        overlay(base, changes);
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
