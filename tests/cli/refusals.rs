//! Wrong combinations of options are refused before the first stage, alike by command and file: tests/python/test_refusals.py
//! gives the same ones by keyword.

use crate::command::Folder;
use serde_json::{Map, Value};

/// Wrong options, the one that is refused, and the refusal without its name.
#[derive(serde::Deserialize)]
struct Row {
    verb: String,
    options: Map<String, Value>,
    wrong: String,
    said: String,
}

fn refusals() -> Vec<Row> {
    serde_json::from_str(include_str!("../refusals.json")).unwrap()
}

/// The flag of an option, without dashes before it.
fn flag(key: &str) -> String {
    key.trim_end_matches("_mm_per_s").trim_end_matches("_s").replace('_', "-")
}

fn word(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

#[test]
fn a_wrong_combination_is_refused_by_its_flag_before_the_first_stage() {
    let folder = Folder::with_model();
    let before = folder.names();
    for Row { verb, options, wrong, said } in refusals() {
        let (command, output) =
            if verb == "deck" { ("mesh", "m.inp") } else { (&*verb, if verb == "mesh" { "m.vtu" } else { "out" }) };
        let mut words = vec![command.to_owned(), "small.json".to_owned(), "-o".to_owned(), output.to_owned()];
        for (key, value) in &options {
            let flag = flag(key);
            words.push(if *value == true { format!("--{flag}") } else { format!("--{flag}={}", word(value)) });
        }
        let run = folder.run(&words.iter().map(String::as_str).collect::<Vec<_>>());
        let wanted = format!("error: --{} {said}", flag(&wrong));
        assert!(run.code == 2 && run.stderr.starts_with(&wanted), "{words:?}: {wanted}: {}", run.stderr);
        assert_eq!(folder.names(), before, "{words:?}");
    }
}

#[test]
fn a_wrong_combination_is_refused_by_the_line_of_a_study_before_the_first_stage() {
    let folder = Folder::with_spec();
    for Row { verb, options, wrong, said } in refusals() {
        let section = if verb == "deck" { "mesh" } else { &*verb };
        let key = |key: &str| flag(key).replace('-', "_");
        let mut study = format!("spec = 'small.toml'\n[over]\nseed = [1]\n[{section}]\n");
        match &*verb {
            "deck" => study += "output = 'm.inp'\n",
            "mesh" => study += "output = 'm.vtu'\n",
            _ => {}
        }
        for (name, value) in &options {
            study += &format!("{} = {value}\n", key(name));
        }
        folder.write("STUDY.toml", &study);
        let run = folder.run(&["study", "STUDY.toml"]);
        let line = 1 + study.lines().position(|line| line.starts_with(&format!("{} = ", key(&wrong)))).unwrap();
        let wanted = format!("error: STUDY.toml: line {line}: [{section}] {} {said}", key(&wrong));
        assert!(run.code == 2 && run.stderr.starts_with(&wanted), "{study}: {wanted}: {}", run.stderr);
        assert_eq!(folder.names(), ["STUDY.toml", "small.toml"], "{study}");
    }
}
