//! One test, one deck: by its name and by its file, by `pack`, `mesh` and `study`; refusals before any work.

use crate::command::Folder;
use std::time::Instant;

/// Every named test that a deck can have, and the specimen that it needs. Named cycles turn at a stress: see below.
const TESTS: [(&str, &str); 14] = [
    ("compression", CUBE),
    ("tension", CUBE),
    ("splitting", CUBE),
    ("triaxial", CUBE),
    ("biaxial", CUBE),
    ("expansion", CUBE),
    ("bending", PRISM),
    ("four-point", PRISM),
    ("shear", PRISM),
    ("hopkinson", CUBE),
    ("hopkinson-splitting", CUBE),
    ("spall", CUBE),
    ("drop", PRISM),
    ("impact", CUBE),
];
const CUBE: &str = "kind = 'cube'\nside_mm = 16\n";
const PRISM: &str = "kind = 'notched-prism'\nlength_mm = 40\nwidth_mm = 12\ndepth_mm = 16\nnotch_depth_mm = 4\n\
                     notch_width_mm = 4\nupper_notch_depth_mm = 4\n";
const MESH: [&str; 3] = ["--element-size-mm", "4", "--accept-phase-error"];

fn spec(specimen: &str) -> String {
    format!("fraction = 0.05\n[grading]\nd_min_mm = 5\nd_max_mm = 6\n[specimen]\n{specimen}")
}

#[test]
fn a_test_by_its_name_and_by_its_file_gives_one_deck_in_pack_and_in_mesh() {
    let folder = Folder::new();
    for (name, specimen) in TESTS {
        folder.write("s.toml", spec(specimen));
        folder.write("T.toml", format!("kind = '{name}'\n"));
        let run = |words: &[&str], analysis: &str| {
            let run = folder.run(&[words, &MESH, &["-fq", "--analysis", analysis]].concat());
            assert_eq!(run.code, 0, "{name}: {}", run.stderr);
        };
        run(&["pack", "s.toml", "-o", "m.json", "-o", "packed.inp"], name);
        run(&["mesh", "m.json", "-o", "named.inp"], name);
        run(&["mesh", "m.json", "-o", "filed.inp"], "T.toml");
        let named = folder.read("named.inp");
        assert!(named == folder.read("packed.inp") && named == folder.read("filed.inp"), "{name}");
        if ["biaxial", "expansion"].contains(&name) {
            continue;
        }
        run(&["mesh", "m.json", "-o", "named.k"], name);
        run(&["mesh", "m.json", "-o", "filed.k"], "T.toml");
        assert!(folder.read("named.k") == folder.read("filed.k"), "{name}");
    }
}

#[test]
fn the_values_of_a_test_are_the_same_bytes_as_flags_and_as_keys_of_its_file() {
    let folder = Folder::new();
    folder.write("s.toml", spec(CUBE));
    let keys = "kind = 'compression'\nstrain = 0.004\nfriction = 0.6\nduration_s = 0.002\ntime_step_s = 2e-7\n";
    folder.write("T.toml", keys);
    let flags = "--strain 0.004 --friction 0.6 --duration 0.002 --time-increment 2e-7";
    let flags: Vec<&str> = flags.split(' ').collect();
    assert_eq!(folder.run(&["pack", "s.toml", "-qo", "m.json", "--min-gap-mm", "1"]).code, 0);
    let of = |name: &str, words: &[&str]| {
        let run = folder.run(&[&["mesh", "m.json", "-qo", name][..], &MESH, words].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        String::from_utf8(folder.read(name)).unwrap()
    };
    let filed = of("filed.inp", &["--analysis", "T.toml"]);
    assert_eq!(filed, of("flags.inp", &[&["--analysis", "compression"][..], &flags].concat()));
    assert!(filed.contains("\n, 0.002\n") && filed.contains("DT=2e-7") && filed.contains("*FRICTION\n0.6,\n"));
    // The heading has the command that gives it again.
    assert!(filed.contains("--analysis compression --strain 0.004"), "{}", &filed[..900]);
}

#[test]
fn a_study_writes_the_deck_that_mesh_writes() {
    let folder = Folder::new();
    let section = "[mesh]\noutput = 'd.inp'\nelement-size-mm = 4\naccept-phase-error = true\nanalysis = ";
    folder.write("T.toml", "kind = 'compression'\n");
    for (name, analysis) in [("named", "compression"), ("filed", "T.toml")] {
        folder.write("s.toml", spec(CUBE));
        folder.write("STUDY.toml", format!("spec = 's.toml'\n{section}'{analysis}'\n[over]\nseed = [1]\n"));
        let run = folder.run(&["study", "STUDY.toml", "-o", name, "-q"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let case = std::fs::read_dir(folder.path(name)).unwrap().map(|entry| entry.unwrap().path());
        let case = case.into_iter().find(|path| path.join("d.inp").exists()).expect("a case with a deck");
        let deck = std::fs::read(case.join("d.inp")).unwrap();
        let model = case.join("model.json").to_string_lossy().into_owned();
        let run = folder.run(&[&["mesh", &model, "-fqo", "own.inp", "--analysis", "compression"][..], &MESH].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(deck == folder.read("own.inp"), "{name}");
    }
}

/// The case: `pack -o beam.k --analysis bending` packed and meshed for 85 CPU s before "--analysis is test".
#[test]
fn a_deck_that_cannot_be_is_refused_before_anything_is_read_or_packed() {
    let folder = Folder::new();
    folder.write("file.toml", "kind = 'expansion'\n");
    for (analysis, output, said) in [
        (
            "biaxial",
            "b.k",
            "--analysis is biaxial; biaxial has no .k yet: write an .inp, or test it with `mesocrete solve",
        ),
        ("expansion", "b.k", "--analysis is expansion; expansion has no .k yet"),
        ("file.toml", "b.k", "--analysis is expansion; expansion has no .k yet"),
        ("elastic", "b.k", "--analysis is elastic; a .k takes none, striker or a test"),
        ("striker", "b.inp", "--analysis is striker; only a .k takes it"),
        ("cyclic", "b.inp", "--analysis is cyclic; a deck's plates cannot turn at a stress"),
        ("cyclic", "b.k", "--analysis is cyclic; a deck's plates cannot turn at a stress"),
    ] {
        // Neither file is there: the refusal comes first.
        for words in [["pack", "no.toml", "-o", output], ["mesh", "no.json", "-o", output]] {
            let begun = Instant::now();
            let run = folder.run(&[&words[..], &["--analysis", analysis, "--element-size-mm", "auto"]].concat());
            assert!(run.code == 2 && run.stderr.contains(said), "{analysis}: {}", run.stderr);
            assert!(begun.elapsed().as_secs() < 5, "{analysis}");
        }
    }
    folder.write("s.toml", spec(CUBE));
    folder.write("STUDY.toml", "spec = 's.toml'\n[mesh]\noutput = 'b.k'\nanalysis = 'biaxial'\n[over]\nseed = [1]\n");
    let run = folder.run(&["study", "STUDY.toml"]);
    assert!(run.code == 2 && run.stderr.contains("biaxial has no .k yet"), "{}", run.stderr);
    assert!(!folder.names().contains(&"study".to_owned()), "{:?}", folder.names());
}

/// docs/paper/deck.toml is the step of the method paper: Buildings 2025, 15(21), 3883, Sec. 3.2.
#[test]
fn the_papers_deck_presses_by_6_per_mille_in_20_ms_on_a_plate_at_rest() {
    let folder = Folder::new();
    folder.write("s.toml", spec(CUBE));
    folder.write("paper.toml", include_str!("../../docs/paper/deck.toml"));
    let support = |name: &str, moves: f64| {
        format!("[[supports]]\nname = '{name}'\non = 'z-{name}'\nfriction = 0.1\nmoves = {moves}\n")
    };
    let supports = support("min", 0.0).replacen("min", "bottom", 1) + &support("max", -1.0).replacen("max", "top", 1);
    folder.write("own.toml", format!("kind = 'compression'\n{supports}"));
    let deck = |name: &str, words: &[&str]| {
        let run = folder.run(&[&["pack", "s.toml", "-qo", name][..], &MESH, &["--analysis"], words].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        String::from_utf8(folder.read(name)).unwrap()
    };
    let paper = deck("paper.inp", &["paper.toml"]);
    let figures = ["own.toml", "--strain", "0.006", "--duration", "0.02", "--time-increment", "5e-7"];
    assert!(paper == deck("own.inp", &figures));
    for line in ["*DYNAMIC, EXPLICIT\n, 0.02\n", "DT=5e-7,", "REF_TOP, 3, 3, -9.600000000e-2\n", "REF_BOTTOM, 3, 3\n"] {
        assert!(paper.contains(line), "{line}");
    }
}
