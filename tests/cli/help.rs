//! What a user reads: help, lists, tables; kept as snapshots.

use crate::command::Folder;
use insta::assert_snapshot;

#[test]
fn help() {
    let folder = Folder::new();
    for command in ["pack", "mesh", "solve", "study", "check", "report", "convert", "init", "recipes", "devices"] {
        let run = folder.run(&[command, "--help"]);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""));
        assert_snapshot!(format!("help_{command}"), run.stdout());
    }
    assert_snapshot!("help", folder.run(&["--help"]).stdout());
}

#[test]
fn without_a_command_the_help_is_shown_as_wrong_usage() {
    let run = Folder::new().run(&[]);
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("Usage: mesocrete <COMMAND>"), "{}", run.stderr);
}

#[test]
fn the_version_is_one_line() {
    let run = Folder::new().run(&["--version"]);
    assert_eq!(run.stdout(), format!("mesocrete {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn recipes() {
    assert_snapshot!(Folder::new().run(&["recipes"]).stdout());
}

#[test]
fn init_writes_a_commented_spec() {
    assert_snapshot!(Folder::new().run(&["init", "-o", "-"]).stdout());
}

/// The text with ` #` for every number after spaces, these included.
fn without_figures(text: &str) -> String {
    let mut rest = text;
    let mut found = String::new();
    while let Some(start) = rest.find(' ') {
        let word = rest[start..].trim_start_matches(' ');
        let digits = word.strip_prefix(['+', '-']).unwrap_or(word);
        found.push_str(&rest[..start]);
        if digits.starts_with(|c: char| c.is_ascii_digit()) {
            found.push_str(" #");
            rest = digits.trim_start_matches(|c: char| c.is_ascii_digit() || ",.".contains(c));
        } else {
            found.push_str(&rest[start..rest.len() - word.len()]);
            rest = word;
        }
    }
    found + rest
}

#[test]
fn messages_of_pack_and_tables_of_check() {
    let folder = Folder::with_spec();
    let packed = folder.run(&["pack", "small.toml"]).stderr;
    let table = folder.run(&["check", "model.json"]).stdout().to_owned();
    let json = folder.run(&["check", "model.json", "--json"]).stdout().to_owned();
    // The figures are the algorithms' business; here it is the words.
    assert_snapshot!("pack_messages", without_figures(&packed));
    assert_snapshot!("check_table", without_figures(&table));
    assert_snapshot!("check_json", without_figures(&json));
    assert_eq!(folder.run(&["pack", "small.toml", "--force", "--quiet"]).stderr, "");
}

#[test]
fn commands_that_show_the_guarantees_are_those_of_the_command() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guarantees.md")).unwrap();
    let shown: Vec<&str> = page.split('`').filter(|code| code.starts_with("mesocrete ")).collect();
    assert!(shown.len() > 5, "{shown:?}");
    for line in shown {
        assert_eq!(meso_cli::validate(line.split(' ').map(Into::into)), Ok(()), "{line}");
    }
}
