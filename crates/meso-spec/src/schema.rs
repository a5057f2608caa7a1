//! JSON Schemas of the options, from the types that serde reads them into and their docstrings: for editors of a SPEC.toml,
//! and for the Python package's types.

use super::{MixDesign, Spec};
use meso_concrete::import::sieve_table::{Meaning, SieveUnit, ValueUnit};
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
        let path =
            "A file (DAT, ANM, TXT) or folder of coefficients n m Re Im, for harmonics; another name of `library`.";
        schema["$defs"]["Shape"]["properties"]["path"] = json!({ "description": path, "type": "string" });
        for (key, meaning) in [
            ("degree", "Highest degree of the harmonics that counts; 12 by default."),
            ("triangles", "Triangles of the surface that is made of harmonics; 160 by default."),
        ] {
            schema["$defs"]["Shape"]["properties"][key] = json!({ "description": meaning, "type": "integer" });
        }
        let harmonics = "Stones from files of spherical harmonics, one coefficient a line; they become a library.";
        if let Some(kinds) = schema["$defs"]["ShapeKind"]["oneOf"].as_array_mut() {
            kinds.push(json!({ "description": harmonics, "type": "string", "const": "harmonics" }));
        }
        let hull = "Grains of a `library` that are not convex count as their convex hulls.";
        schema["$defs"]["Shape"]["properties"]["hull"] = json!({ "description": hull, "type": "boolean" });
        let tolerance = "Distance within which the surfaces of a `library` are reduced to fewer triangles, as a share of their length, 0 to \
                         0.1; scans of more than 20,000 triangles by 0.005 where it is absent.";
        schema["$defs"]["Shape"]["properties"]["tolerance"] = json!({ "description": tolerance, "type": "number" });
        let specimen = &mut schema["$defs"]["Specimen"];
        let scale = "Millimetres in a unit of the file: 1000 for metres, 25.4 for inches; 1 by default.";
        let scale = json!({ "scale": { "description": scale, "type": "number" } });
        from_file(specimen, "mesh", "A surface file (STL, PLY, OBJ, OFF) that lies beside the spec.", scale);
        let table = "A sieve table (CSV, text; .xlsx in Python) that lies beside the spec, with any heading.";
        from_file(&mut schema["$defs"]["Curve"], "sieves", table, choices_of_a_table());
        let percent = "Per cent that passes each sieve, 0 to 100, instead of passing.";
        let sieves = schema["$defs"]["Curve"]["oneOf"].as_array_mut().into_iter().flatten();
        for form in sieves.filter(|form| form["properties"].get("sieves_mm").is_some()) {
            let mut numbers = form["properties"]["passing"].clone();
            numbers["description"] = percent.into();
            form["properties"]["passing_percent"] = numbers;
            form["required"] = json!(["kind", "sieves_mm"]);
        }
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

/// Keys beside the `file` of a sieve table, for a table that could mean two things.
fn choices_of_a_table() -> Value {
    let names = |names: Vec<&str>, text: &str| json!({ "type": "string", "enum": names, "description": text });
    json!({
        "column": { "type": ["string", "integer"], "description": "Column of the grading: its heading, or its position from 1." },
        "blend": {
            "type": "object", "additionalProperties": { "type": "number" },
            "description": "Aggregates in columns, by headings, and the share of each; shares sum to 1 or 100.",
        },
        "means": names(Meaning::NAMES.map(|name| name.0).into(), "Meaning of the column, where neither heading nor numbers say it."),
        "unit": names(ValueUnit::NAMES.map(|name| name.0).into(), "Unit of the column's numbers."),
        "sieve_unit": names(SieveUnit::NAMES.map(|name| name.0).into(), "Unit of bare numbers in the column of sieves."),
        "sheet": { "type": "string", "description": "Sheet of a workbook; Python only." },
    })
}

/// Adds to a tagged section the form of the variant `kind` that a `file` stands in, with its further keys.
fn from_file(section: &mut Value, kind: &str, description: &str, further: Value) {
    let mut properties = Map::from_iter([
        ("kind".to_owned(), json!({ "type": "string", "const": kind })),
        ("file".to_owned(), json!({ "type": "string", "description": description })),
    ]);
    if let Value::Object(further) = further {
        properties.extend(further);
    }
    let form = json!({
        "type": "object", "properties": properties, "required": ["kind", "file"], "additionalProperties": false,
        "description": description,
    });
    if let Some(forms) = section["oneOf"].as_array_mut() {
        forms.push(form);
    }
}
