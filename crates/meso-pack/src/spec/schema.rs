//! JSON Schemas of the options, from the types that serde reads them into and their docstrings: for editors of a SPEC.toml,
//! and for the Python package's types.

use super::{MixDesign, Spec};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value, json};

impl Spec {
    /// The schema of a SPEC.toml, JSON Schema 2020-12: of [`Spec`], and of the keys that stand for parts of it (`[mix]`
    /// for `fraction`, a `file` for a sieve table or a specimen, a `library` of grains).
    pub fn schema() -> Value {
        let mut schema = Self::schema_of::<Self>();
        schema["title"] = "mesocrete SPEC.toml".into();
        let mut mix = Self::schema_of::<MixDesign>();
        drop(take(&mut mix, "$schema"));
        schema["properties"]["mix"] = mix;
        // The content of a file need not stand in the spec.
        let library = json!({
            "description": "A file (STL, PLY, OBJ, OFF, JSON) or folder of grains; lies beside the spec. Each body in a file is a grain.",
            "type": "string",
        });
        schema["$defs"]["Shape"]["properties"]["library"] = library;
        let hull = "Grains of a `library` that are not convex count as their convex hulls.";
        schema["$defs"]["Shape"]["properties"]["hull"] = json!({ "description": hull, "type": "boolean" });
        let specimen = &mut schema["$defs"]["Specimen"];
        from_file(specimen, "mesh", "A surface file (STL, PLY, OBJ, OFF) that lies beside the spec.");
        let scale = "Millimetres in a unit of the file: 1000 for metres, 25.4 for inches; 1 by default.";
        if let Some(form) = specimen["oneOf"].as_array_mut().and_then(|forms| forms.last_mut()) {
            form["properties"]["scale"] = json!({ "description": scale, "type": "number" });
        }
        from_file(&mut schema["$defs"]["Curve"], "sieves", "A CSV file that lies beside the spec: sieve_mm,passing.");
        schema
    }

    /// The schema of any options.
    pub fn schema_of<T: JsonSchema>() -> Value {
        // Options are read, so that keys with a default may be left out.
        let settings = SchemaSettings::draft2020_12().for_deserialize();
        let schema: Schema = settings.into_generator().into_root_schema_for::<T>();
        schema.to_value()
    }
}

fn take(value: &mut Value, key: &str) -> Option<Value> {
    value.as_object_mut().and_then(|map| map.remove(key))
}

/// Adds to a tagged section the form of the variant `kind` that a `file` stands in.
fn from_file(section: &mut Value, kind: &str, description: &str) {
    let properties = Map::from_iter([
        ("kind".to_owned(), json!({ "type": "string", "const": kind })),
        ("file".to_owned(), json!({ "type": "string", "description": description })),
    ]);
    let form = json!({
        "type": "object", "properties": properties, "required": ["kind", "file"], "additionalProperties": false,
        "description": description,
    });
    if let Some(forms) = section["oneOf"].as_array_mut() {
        forms.push(form);
    }
}
