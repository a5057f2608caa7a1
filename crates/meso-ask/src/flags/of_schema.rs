//! Flags of a request, made from its schema: the doc comment of an option is the help of its flag.

use super::values;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, Command};
use meso_core::Spec;
use schemars::JsonSchema;
use serde_json::{Number, Value};

/// An option that has a flag, and how help shows it.
#[derive(Clone, Copy, Debug)]
pub struct Flag {
    /// Key of the option.
    pub key: &'static str,
    /// Name of its value; empty for the usual one.
    value: &'static str,
    /// Whether only `--help` lists it.
    is_rare: bool,
    /// Default of the command, where it is another than the option's own.
    usual: Option<u32>,
    /// Further names, such as other programs have.
    aliases: &'static [&'static str],
}

impl Flag {
    /// A flag that every user needs.
    pub const fn common(key: &'static str, value: &'static str) -> Self {
        Self { key, value, is_rare: false, usual: None, aliases: &[] }
    }

    /// A flag that few users need.
    pub const fn rare(key: &'static str, value: &'static str) -> Self {
        Self { is_rare: true, ..Self::common(key, value) }
    }

    /// The flag with another default in the command.
    pub const fn usually(self, usual: u32) -> Self {
        Self { usual: Some(usual), ..self }
    }

    /// Whether a user may call its option so: by its key, with or without a unit, or by a name of the flag.
    pub(crate) fn is_called(&self, name: &str) -> bool {
        means(self.key, name) || self.aliases.iter().any(|alias| alias.replace('-', "_") == name)
    }

    /// The flag with further names.
    pub const fn known_as(self, aliases: &'static [&'static str]) -> Self {
        Self { aliases, ..self }
    }
}

/// The flag of a key: `--element-size-mm`. Flags drop seconds and speeds: `--duration`.
pub(crate) fn name(key: &str) -> String {
    let bare = ["_mm_per_s", "_s"].into_iter().find_map(|unit| key.strip_suffix(unit));
    format!("--{}", bare.unwrap_or(key).replace('_', "-"))
}

/// Whether a user may call the option with this key so, in a table or by a keyword: units may be left out.
pub fn means(key: &str, name: &str) -> bool {
    key == name || ["_mm", "_mm_per_s", "_s"].into_iter().any(|unit| key.strip_suffix(unit) == Some(name))
}

/// Adds the `flags` of the options of `T` to a command.
pub(crate) fn add<T: JsonSchema>(flags: &[Flag], command: Command) -> Command {
    let schema = Spec::schema_of::<T>();
    command.args(flags.iter().map(|flag| flag.of(&schema)))
}

impl Flag {
    fn of(&self, schema: &Value) -> Arg {
        let option = &schema["properties"][self.key];
        let mut forms = Forms::default();
        forms.take(option, schema);
        let help = option["description"].as_str().unwrap_or_default().replace('\n', " ");
        let arg = Arg::new(self.key).long(name(self.key).split_off(2)).help(help.trim_end_matches('.').to_owned());
        let arg = arg.hide_short_help(self.is_rare).aliases(self.aliases.iter().copied());
        if forms.is_switch {
            return arg.action(ArgAction::SetTrue);
        }
        let own = self.usual.map(|usual| usual.to_string());
        let own = own.or_else(|| option["default"].as_str().map(str::to_owned));
        let usual = own.map(|usual| format!(" [default: {usual}]"));
        let help = arg.get_help().map(ToString::to_string).unwrap_or_default() + &usual.unwrap_or_default();
        let name = if self.value.is_empty() { self.key.to_uppercase() } else { self.value.to_owned() };
        forms.read_by(arg.help(help).value_name(name))
    }
}

/// Forms that a value may have.
#[derive(Default)]
struct Forms {
    names: Vec<String>,
    is_number: bool,
    is_whole: bool,
    is_seed: bool,
    least: u64,
    is_switch: bool,
}

impl Forms {
    fn take(&mut self, schema: &Value, root: &Value) {
        if let Some(path) = schema["$ref"].as_str() {
            let definition = path.rsplit('/').next().unwrap_or_default();
            self.take(&root["$defs"][definition], root);
        }
        for key in ["anyOf", "oneOf", "allOf"] {
            schema[key].as_array().into_iter().flatten().for_each(|form| self.take(form, root));
        }
        let names = schema["enum"].as_array().into_iter().flatten().chain([&schema["const"]]);
        self.names.extend(names.filter_map(Value::as_str).map(str::to_owned));
        let has = |kind: &str| match &schema["type"] {
            Value::Array(kinds) => kinds.iter().any(|one| one == kind),
            one => one == kind,
        };
        self.is_number |= has("number");
        self.is_whole |= has("integer");
        self.is_seed |= schema["format"] == "uint64";
        self.least = self.least.max(schema["minimum"].as_u64().unwrap_or_default());
        self.is_switch |= has("boolean");
    }

    fn read_by(self, arg: Arg) -> Arg {
        let arg = if self.is_number || self.is_whole { arg.allow_negative_numbers(true) } else { arg };
        match (self.is_whole, self.is_number) {
            (true, _) if self.is_seed => arg.value_parser(|text: &str| values::seed(text).map(Value::from)),
            (true, _) if self.least > 0 => arg.value_parser(|text: &str| values::count(text).map(Value::from)),
            (true, _) => arg.value_parser(|text: &str| values::whole_number(text).map(Value::from)),
            (false, true) => arg.value_parser(move |text: &str| number_or(&self.names, text)),
            (false, false) => arg.value_parser(PossibleValuesParser::new(self.names).map(Value::from)),
        }
    }
}

/// A number, or one of some names.
fn number_or(names: &[String], text: &str) -> Result<Value, String> {
    if names.iter().any(|name| name == text) {
        return Ok(text.into());
    }
    let wanted = || [&["it must be a number, with a point for the decimals".to_owned()], names].concat().join(", or ");
    text.parse().ok().and_then(Number::from_f64).map(Value::Number).ok_or_else(wanted)
}
