//! What a user reads: help, lists, tables; kept as snapshots.

use crate::command::Folder;
use insta::assert_snapshot;
use std::path::Path;

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

/// Messages spell the flag of a key by `flag`, which knows no list of them.
#[test]
fn flags_in_messages_are_those_of_a_command() {
    let known = Folder::new().run(&["completions", "bash"]).stdout().to_owned();
    let known: Vec<&str> = known.split(|c: char| c.is_whitespace() || "\"')".contains(c)).collect();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut named = 0;
    while let Some(path) = folders.pop() {
        if path.is_dir() {
            folders.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        let calls = text.match_indices("flag(\"").map(|(at, call)| &text[at + call.len()..]);
        let lists = text.match_indices("].map(flag)").map(|(end, _)| &text[text[..end].rfind('[').unwrap() + 2..end]);
        let keys = calls.map(|rest| rest.split('"').next().unwrap()).chain(lists.flat_map(|list| list.split("\", \"")));
        for key in keys.map(|key| key.trim_matches('"')) {
            let flag = format!("--{}", key.trim_end_matches("_s").replace('_', "-"));
            assert!(known.contains(&flag.as_str()), "{flag} is no flag");
            named += 1;
        }
    }
    assert!(named > 25, "{named}");
}

const COMMANDS: [&str; 16] = [
    "pack",
    "mesh",
    "solve",
    "devices",
    "study",
    "fit",
    "check",
    "report",
    "convert",
    "image",
    "import",
    "init",
    "recipes",
    "schema",
    "completions",
    "man",
];

#[test]
fn every_command_has_an_example_in_its_help() {
    let folder = Folder::new();
    for command in COMMANDS {
        let text = folder.run(&[command, "-h"]).stdout().to_owned();
        assert!(text.contains("Example") && text.contains(&format!("  mesocrete {command}")), "{text}");
    }
}

#[test]
fn short_help_leaves_out_what_few_need() {
    let folder = Folder::new();
    let [short, long] = ["-h", "--help"].map(|flag| folder.run(&["pack", flag]).stdout().to_owned());
    let flags = |text: &str| text.matches("\n      --").count() + text.matches("\n  -").count();
    assert!(flags(&short) <= 20 && flags(&long) >= 38, "{} of {}", flags(&short), flags(&long));
    assert!(!short.contains("--subsamples") && long.contains("--subsamples"));
    assert!(short.contains("[possible values: auto, take-and-place,"), "{short}");
}

/// Section 4 of the users' review: 29 lines of figures after the first command.
#[test]
fn the_default_output_of_pack_fits_twelve_lines_and_verbose_has_the_rest() {
    let folder = Folder::with_spec();
    let said = folder.run(&["pack", "small.toml"]).stderr;
    // On a busy machine a line every 10 s tells the progress.
    let own = said.lines().filter(|line| !line.contains(" % of all after "));
    assert!(own.count() <= 12, "{said}");
    for part in [
        "packed ",
        "grading: ",
        "; worst class ",
        "meshed ",
        "surface error ",
        "wrote model.json, ",
        "next: open model.html",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let all = folder.run(&["pack", "small.toml", "--force", "--verbose"]).stderr;
    for part in ["    class, mm", "        phase  of specimen", "shortest altitude", "explicit steps of"] {
        assert!(all.contains(part) && !said.contains(part), "{part}: {all}");
    }
    assert_eq!(folder.run(&["pack", "small.toml", "-v", "-q"]).code, 2);
}

#[test]
fn a_methods_paragraph_has_the_figures_of_the_model_and_its_sources() {
    let folder = Folder::with_model();
    let run = folder.run(&["report", "small.json", "--cite"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    let text = run.stdout().replace('\n', " ");
    let model: serde_json::Value = serde_json::from_slice(&folder.read("small.json")).unwrap();
    let count = model["aggregates"].as_array().unwrap().len();
    for part in [
        concat!("mesocrete ", env!("CARGO_PKG_VERSION")),
        &format!("{count} aggregates were placed"),
        "Every pair of aggregates is proved to share no point.",
        "10.3390/buildings15213883",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert_eq!(folder.run(&["report", "small.json", "--cite", "-o", "a.html"]).code, 2);
    assert_eq!(folder.run(&["report", "small.json"]).code, 2);
}

#[test]
fn manual_pages_go_to_the_folder_that_is_named() {
    let folder = Folder::new();
    let run = folder.run(&["man", "pages/man1"]);
    assert_eq!(
        (run.code, run.stderr.as_str()),
        (0, "wrote 19 pages to pages/man1; read one: man pages/man1/mesocrete.1\n")
    );
    assert!(folder.read("pages/man1/mesocrete-pack.1").starts_with(b".ie"));
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
