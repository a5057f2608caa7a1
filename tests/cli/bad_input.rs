//! Whatever is wrong is named on one line, with the way out; never a panic, never half a file.

use crate::bad_specs::REJECTED;
use crate::command::{Folder, Run};

/// An error is one `error:` line that says `part`, and nothing is written.
fn assert_refused(folder: &Folder, before: &[String], run: &Run, code: i32, part: &str, what: &str) {
    assert_eq!(run.code, code, "{what}: {}", run.stderr);
    assert!(run.stderr.starts_with("error: "), "{what}: {}", run.stderr);
    assert!(run.stderr.contains(part), "{what} lacks {part:?}: {}", run.stderr);
    assert!(!run.stderr.contains("panicked"), "{what}: {}", run.stderr);
    assert!(run.stdout.is_empty(), "{what} wrote to stdout");
    assert_eq!(folder.names(), before, "{what} left files behind");
}

#[test]
fn every_impossible_spec_exits_with_2_and_names_key_and_value() {
    assert!(REJECTED.len() >= 120, "the table has {} rows", REJECTED.len());
    let folder = Folder::new();
    for &(text, key, part) in REJECTED {
        let run = folder.run_with_input(&["pack", "-", "-o", "model.json"], text.as_bytes());
        assert_refused(&folder, &[], &run, 2, part, text);
        assert!(run.stderr.contains(key), "{text}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{text}: {}", run.stderr);
    }
}

#[test]
fn every_wrong_flag_exits_with_2_and_names_the_flag() {
    let cases: &[(&[&str], &str)] = &[
        (&["pack", "--fraction", "45"], "--fraction is 45; the accepted range is above 0 and below 1"),
        (&["pack", "--fraction", "45"], "for 45 % write 0.45"),
        (&["pack", "--fraction", "0"], "--fraction is 0;"),
        (&["pack", "--fraction", "-0.4"], "--fraction is -0.4;"),
        (&["pack", "--fraction", "nan"], "'--fraction <F>': it must be a number"),
        (&["pack", "--fraction", "inf"], "'--fraction <F>': it must be a number"),
        (&["pack", "--fraction", "1e308"], "--fraction is 1e308;"),
        (&["pack", "--fraction", "1,5"], "'--fraction <F>': it must be a number, with a point"),
        (&["pack", "--fraction", "40%"], "'--fraction <F>': it must be a number"),
        (&["pack", "--fraction", ""], "--fraction"),
        (&["pack", "--fraction", " 0.4 "], "--fraction"),
        (&["pack", "--fraction", "0x1"], "--fraction"),
        (&["pack", "--fraction"], "--fraction"),
        (&["pack", "--fraction", "0.4", "--fraction", "0.5"], "--fraction"),
        (&["pack", "--seed", "-1"], "'--seed <N>': it must be a whole number from 0 to 18446744073709551615"),
        (&["pack", "--seed", "18446744073709551616"], "--seed"),
        (&["pack", "--seed", "1.5"], "--seed"),
        (&["pack", "--seed", "one"], "--seed"),
        (&["pack", "--attempts", "0"], "'--attempts <N>': it must be a whole number from 1 to 4294967295"),
        (&["pack", "--attempts", "-3"], "--attempts"),
        (&["pack", "--attempts", "1e3"], "--attempts"),
        (&["pack", "--attempts", "18446744073709551615"], "--attempts"),
        (&["pack", "--time-limit", "0"], "--time-limit is 0;"),
        (&["pack", "--time-limit", "-1"], "--time-limit is -1;"),
        (&["pack", "--time-limit", "nan"], "'--time-limit <S>': it must be a number"),
        (&["pack", "--time-limit", "soon"], "--time-limit"),
        (&["pack", "--threads", "0"], "'--threads <N>': it must be a whole number from 1 to 1024"),
        (&["pack", "--threads", "1000000"], "--threads"),
        (&["pack", "--threads", "-1"], "--threads"),
        (&["pack", "--strategy", "fast"], "[possible values: auto, take-and-place, rearrange]"),
        (&["pack", "--sede", "3"], "--seed"),
        (
            &["pack", "-o", "model.xyz"],
            "'model.xyz' for '--output <FILE>': unknown format; the extension must be one of .json",
        ),
        (&["pack", "-o", "model"], "'model' for '--output <FILE>': unknown format"),
        (&["pack", "-o", "-", "-o", "-"], "standard output is asked for twice"),
        (&["pack", "-o", "-", "--summary-json", "-"], "standard output is asked for twice"),
        (&["pack", "-o", "a.json", "-o", "./a.json"], "asked for twice"),
        (&["pack", "a.toml", "b.toml"], "b.toml"),
        (&["pack", "rve-60"], "rve-60 is a recipe and no file; write it first: mesocrete init rve-60"),
        (&["pack", "small.json"], "small.json: line 1: this is JSON, not TOML; a saved model needs no packing"),
        (&["pack", "."], ". is a directory; name a file, or - for standard input"),
        (&["mesh"], "--output"),
        (&["mesh", "small.json", "-o", "small.stl"], "'small.stl' for '--output <FILE>': unknown mesh format"),
        (&["mesh", "small.json", "-o", "m.inp", "--element-size-mm", "0"], "--element-size-mm is 0;"),
        (&["mesh", "small.json", "-o", "m.inp", "--element-size-mm", "-2"], "--element-size-mm is -2;"),
        (&["mesh", "small.json", "-o", "m.inp", "--element-size-mm", "nan"], "it must be a number, with a point"),
        (&["mesh", "small.json", "-o", "m.inp", "--element-size-mm", "1e-9"], "--element-size-mm is"),
        (&["mesh", "small.json", "-o", "m.inp", "--element-size-mm", "41"], "--element-size-mm is 41;"),
        (&["mesh", "small.json", "-o", "m.inp", "--method", "magic"], "[possible values: voxel, "),
        (&["mesh", "small.json", "-o", "m.inp", "--itz", "thick"], "[possible values: solid, "),
        (&["mesh", "small.json", "-o", "m.inp", "--subsamples", "0"], "--subsamples is 0; it must be 1 to 8"),
        (&["mesh", "small.json", "-o", "m.inp", "--subsamples", "-1"], "'--subsamples <N>': it must be a whole number"),
        (&["mesh", "small.json", "-o", "m.inp", "--order", "two"], "'--order <N>': it must be a whole number"),
        (&["mesh", "small.json", "-o", "m.inp", "--slabs", "0"], "--slabs is 0; it must be 1 to 100"),
        (&["mesh", "small.json", "-o", "m.inp", "--slabs", "-2"], "'--slabs <N>': it must be a whole number"),
        (&["mesh", "small.json", "-o", "m.inp", "--strain", "-0.1"], "--strain is -0.1; it must lie between 0 and 1"),
        (&["mesh", "small.json", "-o", "m.inp", "--friction", "-1"], "--friction is -1; it must be 0 to 10"),
        (&["mesh", "small.json", "-o", "m.inp", "--frames", "-3"], "'--frames <N>': it must be a whole number"),
        (&["mesh", "small.json", "-o", "m.inp", "--frames", "0"], "--frames is 0; "),
        (
            &["mesh", "small.json", "-o", "m.inp", "--threads", "-1"],
            "'--threads <N>': it must be a whole number from 1",
        ),
        (&["mesh", "small.json", "-o", "m.inp", "--slabs", "101"], "--slabs is 101; it must be 1 to 100"),
        (&["convert", "small.json"], "--output"),
        (&["convert", "small.json", "-o", "a.inp"], "'a.inp' for '--output <FILE>': unknown format"),
        (&["convert", "small.json", "-o", "a.inp"], "mesocrete mesh"),
        (
            &["convert", "small.json", "-o", "-", "--format", "png"],
            "[possible values: json, json.gz, vtu, vtp, stl, step, glb, ply, obj, csv]",
        ),
        (&["convert", "small.json", "-o", "small.json", "--force"], "small.json is the input; write to another file"),
        (&["check"], "MODEL"),
        (&["init", "moon"], "there is no recipe \"moon\"; the recipes are paper"),
        (&["frobnicate"], "frobnicate"),
    ];
    let folder = Folder::with_model();
    let before = folder.names();
    for (args, part) in cases {
        assert_refused(&folder, &before, &folder.run(args), 2, part, &args.join(" "));
    }
}

#[test]
fn a_refusal_of_the_system_exits_with_1_and_names_the_path() {
    let long = format!("{}.json", "x".repeat(300));
    let cases: &[(&[&str], &str)] = &[
        (&["pack", "absent.toml"], "absent.toml: No such file or directory; check the name"),
        (&["pack", "small.toml", "-o", "absent/model.json"], "there is no folder absent; make it first"),
        (&["pack", "small.toml", "-o", &long], "too long"),
        (&["pack", "small.toml", "-o", "folder.json"], "folder.json is a directory; name a file in it"),
        (&["pack", "small.toml", "-o", "small.json"], "small.json exists; --force replaces it"),
        (&["pack", "small.toml", "-o", "a.json", "--summary-json", "small.json"], "small.json exists"),
        (&["pack", "small.toml", "-o", "a.json", "--summary-json", "/dev/full"], "/dev/full: No space left on device"),
        (&["init", "-o", "small.toml"], "small.toml exists; --force replaces it"),
        (&["check", "absent.json"], "absent.json: No such file or directory"),
        (
            &["check", "small.toml"],
            "small.toml: this is not a saved model of mesocrete: it is TOML, as a spec is; pack it first",
        ),
        (&["convert", "small.toml", "-o", "a.stl"], "small.toml: this is not a saved model of mesocrete"),
        (&["mesh", "empty.json", "-o", "a.inp"], "empty.json: this is not a saved model of mesocrete: it is empty"),
        (&["check", "a_deck"], "a_deck: this is not a saved model of mesocrete: it is a deck"),
        (&["check", "other.json"], "other.json: it was written by mesocrete 9.1.0"),
    ];
    let folder = Folder::with_model();
    std::fs::create_dir(folder.path("folder.json")).unwrap();
    folder.write("empty.json", "");
    folder.write("a_deck", "*HEADING\n*NODE\n");
    let model = String::from_utf8(folder.read("small.json")).unwrap();
    folder.write("other.json", model.replacen("\"0.1.0\"", "\"9.1.0\"", 1));
    let before = folder.names();
    for (args, part) in cases {
        assert_refused(&folder, &before, &folder.run(args), 1, part, &args.join(" "));
    }
}

#[test]
fn bytes_that_are_no_text_are_refused() {
    let folder = Folder::new();
    let run = folder.run_with_input(&["pack", "-"], b"seed = 1\n# \xff\n");
    assert_refused(&folder, &[], &run, 2, "standard input: byte 11 is not UTF-8", "invalid UTF-8");
}

#[test]
fn a_spec_without_end_is_not_read_to_its_end() {
    let folder = Folder::new();
    let run = folder.run_with_input(&["pack", "-"], &vec![b'#'; 33 << 20]);
    assert_refused(&folder, &[], &run, 2, "longer than 32 MB", "33 MB");
}

#[test]
#[cfg(unix)]
fn a_pipe_that_a_spec_names_is_not_waited_for() {
    let folder = Folder::new();
    let made = std::process::Command::new("mkfifo").arg(folder.path("pipe.stl")).status();
    assert!(made.expect("mkfifo runs").success());
    folder.write("pipe.toml", "specimen = { kind = 'mesh', file = 'pipe.stl' }");
    let run = folder.run(&["pack", "pipe.toml"]);
    let names = ["pipe.stl".into(), "pipe.toml".into()];
    assert_refused(&folder, &names, &run, 2, "pipe.stl is not a regular file", "a FIFO that a spec names");
}

#[test]
fn a_planted_overlap_is_found_by_check() {
    let folder = Folder::with_model();
    let text = String::from_utf8(folder.read("small.json")).unwrap();
    let mut model: serde_json::Value = serde_json::from_str(&text).unwrap();
    let body = model["aggregates"][0].clone();
    model["aggregates"][1]["vertices"] = body["vertices"].clone();
    model["aggregates"][1]["faces"] = body["faces"].clone();
    folder.write("overlap.json", model.to_string());
    let run = folder.run(&["check", "overlap.json"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stdout().contains("aggregates 0 and 1 share a point"), "{}", run.stdout());
    assert!(run.stdout().contains("NOT sound"));
    assert!(run.stderr.contains("overlap.json: 5 of its promises are not kept"), "{}", run.stderr);
}
