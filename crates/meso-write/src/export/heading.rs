//! Heading of a deck: the packing, and the command that writes the deck again.
//!
//! It follows from what is written, not from the way it was asked for: a test by its name and by its file, by the command and
//! by Python has one heading.

use crate::export::abaqus::{Analysis, DeckOptions, LsdynaLaw};
use meso_mesh::MeshOptions;
use meso_mesh::materials::Materials;
use meso_pack::Spec;
use meso_trial::{Test, word};

/// Characters of a heading's line.
const LINE: usize = 76;
/// Begins the further lines of a text.
const INDENT: &str = "   ";

impl DeckOptions {
    /// Sets the heading: the packing of `spec`, and the command that meshes it so. `is_off` says that a phase is so far off
    /// its volume that the command asks for consent.
    pub fn head(&mut self, spec: &Spec, mesh: &MeshOptions, is_off: bool) {
        let packing = format!("packing: seed {}, fraction {} of a {}", spec.seed, spec.fraction, spec.specimen.kind());
        let (flags, keys) = self.test().map(|test| test_words(&test)).unwrap_or_default();
        self.heading = vec![packing];
        self.heading.extend(wrapped(&self.command(mesh, is_off, &flags, keys.is_some())));
        self.heading.extend(keys.iter().flat_map(|keys| wrapped(&format!("TEST.toml: {keys}"))));
    }

    /// The command that gives the same deck. Files and threads change nothing, so it has none.
    fn command(&self, mesh: &MeshOptions, is_off: bool, of_test: &[(&str, f64)], has_file: bool) -> String {
        let mut words = vec!["command: mesocrete mesh MODEL".to_owned()];
        words.extend(mesh.named().into_iter().map(|(key, value)| match value.as_str() {
            "true" => flag(key),
            value => format!("{} {value}", flag(key)),
        }));
        let switches = [
            ("reduced_integration", self.reduced_integration),
            ("geometry_only", self.geometry_only),
            ("periodic_equations", self.periodic_equations),
            ("with_damage", self.with_damage),
            ("accept_phase_error", is_off),
        ];
        words.extend(switches.into_iter().filter(|(_, given)| *given).map(|(key, _)| flag(key)));
        if self.analysis != Analysis::None {
            let name = if has_file { "TEST.toml".to_owned() } else { self.analysis.word() };
            words.push(format!("{} {name}", flag("analysis")));
        }
        let own = [("strain", self.strain), ("friction", self.friction), ("duration_s", self.duration_s)];
        let own = own.into_iter().filter_map(|(key, value)| Some((key, value?)));
        let own: Vec<(&str, f64)> =
            if matches!(self.analysis, Analysis::Test(_)) { of_test.to_vec() } else { own.collect() };
        words.extend(own.into_iter().map(|(key, value)| format!("{} {value:?}", flag(key))));
        words.extend(self.frames.map(|frames| format!("{} {frames}", flag("frames"))));
        words.extend(self.impact_speed_mm_per_s.map(|speed| format!("{} {speed}", flag("impact_speed"))));
        if self.lsdyna_law != LsdynaLaw::default() {
            words.push(format!("{} {}", flag("lsdyna_law"), word(&self.lsdyna_law)));
        }
        words.extend((self.materials != Materials::default()).then(|| format!("{} FILE", flag("materials"))));
        words.join(" ")
    }
}

/// The values of a test that have a flag of a deck, and its other values as keys of a TEST.toml, where it has any.
fn test_words(test: &Test) -> (Vec<(&'static str, f64)>, Option<String>) {
    let flags = [
        ("strain", test.strain),
        ("friction", test.friction),
        ("duration_s", test.duration_s),
        ("time_increment_s", test.time_step_s),
    ];
    let rest = Test { strain: None, friction: None, duration_s: None, time_step_s: None, ..test.clone() };
    let flags = flags.into_iter().filter_map(|(key, value)| Some((key, value?))).collect();
    if rest == (Test { kind: test.kind, ..Test::default() }) {
        return (flags, None);
    }
    let (usual, own) = (serde_json::to_value(Test::default()), serde_json::to_value(&rest));
    let (Ok(usual), Ok(serde_json::Value::Object(own))) = (usual, own) else { return (flags, None) };
    let keys = own.iter().filter(|(key, value)| *key == "kind" || usual[key.as_str()] != **value);
    let keys: Vec<String> = keys.map(|(key, value)| format!("{key} = {value}")).collect();
    (flags, Some(keys.join(", ")))
}

/// The flag of an option: flags drop the unit suffix `_s`.
fn flag(key: &str) -> String {
    format!("--{}", key.strip_suffix("_s").unwrap_or(key).replace('_', "-"))
}

/// The words of a text in lines.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    let pieces = text.split(' ').flat_map(|word| word.as_bytes().chunks(LINE - INDENT.len()));
    for word in pieces.map(String::from_utf8_lossy) {
        let line = lines.last_mut().expect("one at least");
        if line.is_empty() {
            line.push_str(&word);
        } else if line.len() + 1 + word.len() > LINE {
            lines.push(format!("{INDENT}{word}"));
        } else {
            line.push(' ');
            line.push_str(&word);
        }
    }
    lines
}
