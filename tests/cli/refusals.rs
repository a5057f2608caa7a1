//! Wrong combinations of options are refused before the first stage, alike by command and file: tests/python/test_refusals.py
//! gives the same ones by keyword. A row `by` flag or keyword has no counterpart, or clap's words in the other front.

use crate::command::Folder;
use serde_json::{Map, Value};

/// Wrong options, the one that is refused, and the refusal without its name.
#[derive(serde::Deserialize)]
struct Row {
    verb: String,
    options: Map<String, Value>,
    wrong: String,
    said: String,
    /// The file that is asked for, unless it is the usual one.
    output: Option<String>,
    by: Option<String>,
}

/// Verbs that are steps of a study.
const STEPS: [&str; 4] = ["mesh", "deck", "solve", "effective"];

impl Row {
    fn is_by(&self, front: &str) -> bool {
        self.by.as_deref().is_none_or(|by| by == front)
    }
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
    folder.write("curve.csv", "strain,stress_mpa\n0,0\n0.0005,10\n0.001,20\n0.002,30\n0.003,25\n0.004,15\n");
    folder.write("STUDY.toml", "spec = 'small.toml'\n[over]\nseed = [1]\n");
    let before = folder.names();
    for Row { verb, options, wrong, said, output, .. } in refusals().into_iter().filter(|row| row.is_by("flag")) {
        let inputs: &[&str] = match &*verb {
            "deck" => &["mesh", "small.json"],
            "pack" => &["pack", "small.toml"],
            "import" => &["import", "no.npy"],
            "fit" => &["fit", "curve.csv", "small.toml"],
            "init" => &["init"],
            "study" => &["study", "STUDY.toml"],
            _ => &[&*verb, "small.json"],
        };
        let usual = match &*verb {
            "deck" => "m.inp",
            "mesh" => "m.vtu",
            "pack" | "import" => "x.json",
            "image" => "x.npy",
            _ => "out",
        };
        let output = output.as_deref().unwrap_or(usual);
        let mut words: Vec<String> = [inputs, &["-o", output]].concat().into_iter().map(str::to_owned).collect();
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
    let of_study = |row: &Row| row.by.is_none() && STEPS.contains(&&*row.verb);
    for Row { verb, options, wrong, said, .. } in refusals().into_iter().filter(of_study) {
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
