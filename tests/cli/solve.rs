//! The test itself by the command: whole results, the same bytes on any number of threads, after a kill, and after Ctrl-C.

use crate::command::{Folder, Run, assert_whole};
use serde_json::Value;
use std::collections::BTreeMap;

/// Flags of a test of a moment: elements of 5 mm in a cube of 40 mm.
const QUICK: [&str; 5] = ["--element-size-mm", "5", "--strain", "0.003", "--accept-phase-error"];

fn solve(folder: &Folder, args: &[&str]) -> Run {
    folder.run(&[&["solve"], args, &QUICK].concat())
}

pub(crate) fn result(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&folder.read(name)).unwrap()
}

/// The columns of a curve, by name.
fn curve(folder: &Folder, name: &str) -> BTreeMap<String, Vec<f64>> {
    let text = String::from_utf8(folder.read(name)).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap();
    let rows: Vec<Vec<f64>> = lines.map(|row| row.iter().map(|value| value.parse().unwrap()).collect()).collect();
    let column = |i: usize| rows.iter().map(|row| row[i]).collect();
    names.iter().enumerate().map(|(i, name)| ((*name).to_owned(), column(i))).collect()
}

#[test]
fn a_test_leaves_a_curve_its_figures_frames_and_a_page() {
    let folder = Folder::with_model();
    let run = solve(&folder, &["small.json", "-o", "out", "--frames", "2"]);
    assert_eq!((run.code, run.stdout()), (0, ""), "{}", run.stderr);
    let files = ["curve.csv", "frame_0001.vtu", "frame_0002.vtu", "frames.pvd", "result.html", "result.json"];
    assert_eq!(folder.names_in("out"), files);
    assert!(run.stderr.contains("wrote out/result.html") && run.stderr.contains(" 50 %: strain 0.0"), "{}", run.stderr);
    let curve = curve(&folder, "out/curve.csv");
    let columns = ["strain", "stress_mpa", "kinetic", "internal", "external", "friction_work", "hourglass"];
    assert!(columns.iter().all(|name| curve[*name].iter().all(|value| value.is_finite())));
    let (strain, stress) = (&curve["strain"], &curve["stress_mpa"]);
    assert!(strain.is_sorted() && strain.len() > 100 && (strain[strain.len() - 1] / 0.003 - 1.0).abs() < 0.01);
    let peak = stress.iter().copied().fold(0.0, f64::max);
    let result = result(&folder, "out/result.json");
    assert_eq!(result["peak_mpa"].as_f64(), Some(peak));
    for (key, value) in [("test", "compression"), ("law", "meso"), ("ended", "completed"), ("version", "0.1.0")] {
        assert_eq!(result[key], value, "{key}");
    }
    for key in [
        "friction",
        "elements",
        "steps",
        "time_step_s",
        "added_mass_percent",
        "modulus_mpa",
        "first_peak_mpa",
        "peak_strain",
        "stress_at_end_mpa",
        "kinetic_over_internal_max",
        "kinetic_over_internal_to_half_peak",
        "energy_balance_error",
        "hourglass_over_internal",
        "joined_pairs",
    ] {
        assert!(result[key].is_number(), "{key} is {}", result[key]);
    }
    assert!(result["softened"].is_boolean() && result["warnings"].is_array());
    assert!(result["seconds"]["mesh"].as_f64() > Some(0.0) && result["seconds"]["solve"].as_f64() > Some(0.0));
    for phase in result["phases"].as_array().unwrap() {
        let keys = ["volume_fraction", "exact_fraction", "dissipated_mj"];
        assert!(phase["name"].is_string() && keys.iter().all(|key| phase[key].is_number()), "{phase}");
    }
    let frames = String::from_utf8(folder.read("out/frames.pvd")).unwrap();
    assert_eq!(frames.matches("file=\"frame_000").count(), 2);
}

#[test]
fn a_test_without_frames_leaves_all_other_results() {
    let folder = Folder::with_model();
    let run = solve(&folder, &["small.json", "--frames", "0", "-q"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(folder.names_in("out"), ["curve.csv", "frames.pvd", "result.html", "result.json"]);
}

#[test]
fn the_page_of_a_test_is_whole_in_itself() {
    let folder = Folder::with_model();
    // Far enough that a fifth of the peak is lost, the second moment.
    let flags = ["--strain", "0.008", "--friction", "0.005", "--element-size-mm", "5", "--accept-phase-error", "-q"];
    assert_eq!(folder.run(&[&["solve", "small.json"][..], &flags].concat()).code, 0);
    let page = String::from_utf8(folder.read("out/result.html")).unwrap();
    assert_whole(&page);
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 3 * 3, "three sections at three moments");
    assert_eq!((page.matches("<svg").count(), page.matches("</svg>").count()), (3, 3));
    for part in ["<canvas id=\"cracks\"", "id=\"corners-2\"", "id=\"body-moved-0\"", "Stress over strain", "x = 20 mm"]
    {
        assert!(page.contains(part), "the page lacks {part:?}");
    }
}

#[test]
fn results_are_the_same_bytes_on_1_and_2_threads() {
    let folder = Folder::with_model();
    for threads in ["1", "2"] {
        let run = solve(&folder, &["small.json", "-o", threads, "--threads", threads, "--frames", "2", "-q"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    for file in ["curve.csv", "frame_0001.vtu", "frame_0002.vtu", "frames.pvd", "result.html"] {
        assert!(folder.read(&format!("1/{file}")) == folder.read(&format!("2/{file}")), "{file} differs");
    }
}

#[test]
fn a_spec_is_packed_and_tested_in_one_go() {
    let folder = Folder::with_spec();
    let flags =
        ["--test", "tension", "--element-size-mm", "5", "--seed", "3", "--method", "voxel", "--accept-phase-error"];
    let run = folder.run(&[&["solve", "small.toml"], &flags[..]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stderr.contains("packing a cube of 64000 mm3: 30 %, 6 to 12 mm, gaps of 1.25 mm, seed 3"),
        "{}",
        run.stderr
    );
    let result = result(&folder, "out/result.json");
    assert_eq!(
        (&result["test"], result["seed"].as_u64(), result["elements"].as_u64()),
        (&"tension".into(), Some(3), Some(512))
    );
    let peak = result["peak_mpa"].as_f64().unwrap();
    assert!((1.5..4.0).contains(&peak), "{peak}");
}

#[test]
fn results_that_are_there_are_kept_unless_forced() {
    let folder = Folder::with_model();
    assert_eq!(solve(&folder, &["small.json", "--frames", "3", "-q"]).code, 0);
    let before = folder.read("out/curve.csv");
    let run = solve(&folder, &["small.json", "--friction", "0.5"]);
    assert_eq!((run.code, run.stderr.as_str()), (1, "error: out/curve.csv exists; --force replaces it\n"));
    assert!(folder.read("out/curve.csv") == before);
    let steady = ["small.json", "--friction", "0.5", "--control", "steady", "--frames", "1", "--force", "-q"];
    assert_eq!(solve(&folder, &steady).code, 0);
    assert!(folder.read("out/curve.csv") != before);
    // Frames of the run before would be taken for its own.
    assert_eq!(folder.names_in("out"), ["curve.csv", "frame_0001.vtu", "frames.pvd", "result.html", "result.json"]);
}

#[test]
fn strengths_that_scatter_are_named_before_the_test_and_stand_in_its_frames() {
    let folder = Folder::with_model();
    let scatter = |rest: &str| {
        folder.write("S.toml", format!("[materials.scatter]\ncoefficient_of_variation = 0.2\n{rest}"));
    };
    let with = |args: &[&str]| folder.run(&[args, &["--materials", "S.toml"], &QUICK[..2]].concat());
    scatter("correlation_length_mm = 10\nseed = 4\n");
    let flags = ["solve", "small.json", "-o", "out", "--frames", "1", "--strain", "1e-3", "--accept-phase-error"];
    let run = with(&flags);
    let words = "strengths of mortar and ITZ scatter by 20.0 % (Weibull, modulus 5.8) over 10 mm, seed 4\n";
    assert!(run.code == 0 && run.stderr.contains(words), "{}", run.stderr);
    assert!(String::from_utf8_lossy(&folder.read("out/frame_0001.vtu")).contains(r#"Name="strength_factor""#));
    for (rest, args, said) in [
        (
            "correlation_length_mm = 1\n",
            &["solve", "small.json"][..],
            "is 1; with elements of 5 mm it must be 2.5 or more",
        ),
        (
            "correlation_length_mm = 0\n",
            &["solve", "small.json"],
            "scatter.correlation_length_mm is 0; it must be a positive",
        ),
        (
            "correlation_length_mm = nan\n",
            &["solve", "small.json"],
            "line 3: materials.scatter.correlation_length_mm is nan",
        ),
        ("", &["solve", "small.json"], "line 1: materials.scatter.correlation_length_mm is missing"),
        (
            "correlation_length_mm = 9\ndistribution = 'gauss'\n",
            &["solve", "small.json"],
            "line 4: materials.scatter.distribution is \"gauss\"; it must be one of \"weibull\", \"lognormal\"",
        ),
        (
            "correlation_length_mm = 9\nphases = ['aggregate']\n",
            &["solve", "small.json"],
            "line 4: materials.scatter.phases is \"aggregate\"; it must be one of \"mortar\", \"itz\"",
        ),
        ("correlation_length_mm = 9\n", &["solve", "small.json", "--law", "cdp"], "in tests with the law meso only"),
        (
            "correlation_length_mm = 9\n",
            &["solve", "small.json", "--itz", "cohesive"],
            r#"take phases = ["mortar"], or a solid or smeared ITZ"#,
        ),
        (
            "correlation_length_mm = 9\n",
            &["mesh", "small.json", "--analysis", "compression", "-o", "deck.inp"],
            "for decks and other laws set 0, or remove the table",
        ),
    ] {
        scatter(rest);
        let run = with(&[args, if args[0] == "solve" { &["-o", "other"] } else { &[] }].concat());
        assert!(run.code == 2 && run.stderr.contains(said), "{rest} {args:?}: {}", run.stderr);
        assert!(!run.stderr.contains("meshing"), "{rest} {args:?}: {}", run.stderr);
    }
}

#[test]
fn an_impossible_test_is_named_before_any_step_and_leaves_nothing() {
    let folder = Folder::with_model();
    folder.write("soft.toml", "[materials.mortar]\nyoungs_modulus_mpa = -5\n");
    folder.write("broken.json", "{");
    let before = folder.names();
    for (args, code, part) in [
        (&["none.json"][..], 1, "none.json: No such file or directory; check the name and the folder"),
        (&["none.toml"], 1, "none.toml: No such file or directory"),
        (&["broken.json"], 1, "broken.json: "),
        (&["small.json", "--friction", "-1"], 2, "--friction is -1; it must be 0 to 10"),
        (&["small.json", "--friction", "nan"], 2, "'--friction <MU>': it must be a number"),
        (&["small.json", "--strain", "0"], 2, "--strain is 0; it must be 1e-12 to 0.1"),
        (&["small.json", "--strain", "1"], 2, "--strain is 1;"),
        (&["small.json", "--duration", "-1"], 2, "--duration is -1; it must be a positive number"),
        (&["small.json", "--time-step", "0"], 2, "--time-step is 0; it must be a positive number"),
        (&["small.json", "--time-step", "1"], 2, "--time-step is 1;"),
        (
            &["small.json", "--duration", "1e-9"],
            2,
            "--duration is 0.000000001; 1.000e-9 s in steps of 2.000e-7 s are 1 steps",
        ),
        (&["small.json", "--frames", "-1"], 2, "'--frames <N>': it must be a whole number, not below 0"),
        (&["small.json", "--frames", "10001"], 2, "--frames is 10001; it must be at most 10000"),
        (
            &["small.json", "-o", "-"],
            2,
            "--output - is standard output, but a test writes several files; name a folder",
        ),
        (&["small.json", "--law", "steel"], 2, "[possible values: meso, cdp"),
        (&["small.json", "--smoothing", "edges", "--method", "voxel"], 2, "--smoothing edges needs tetrahedra"),
        (&["small.json", "--test", "bending"], 2, "a beam must be longer than 10/9 of its depth"),
        (&["small.json", "--itz", "thick"], 2, "[possible values: solid, cohesive, smeared, none]"),
        (&["small.json", "--order", "2"], 2, "--order is 2; a test takes 1"),
        (&["small.json", "--fit", "plain", "--method", "voxel"], 2, "--fit is plain; only the method lattice takes it"),
        (&["small.json", "--element-size-mm", "90"], 2, "--element-size-mm is 90; it must lie within"),
        (&["small.json", "--materials", "soft.toml"], 2, "materials.mortar.youngs_modulus_mpa is -5"),
        (&["small.json", "--checkpoint", "-1"], 2, "for '--checkpoint <S>': it must be a number of seconds"),
        (&["small.json", "--checkpoint", "1e300"], 2, "for '--checkpoint <S>': it must be a number of seconds"),
        (&["small.json", "--resume"], 1, "there is no out/checkpoint.bin to resume from"),
        (
            &["small.json", "--device", "gpu", "--method", "voxel"],
            2,
            "voxels run on the processor only; take tetrahedra, or the device cpu",
        ),
        (&["small.json", "--seed", "3"], 2, "--seed has no effect on a saved model; leave it out"),
        (&["small.json", "-o", "none/out"], 1, "none/out: No such file or directory"),
        (&["small.json", "-o", "small.json"], 1, "small.json is not a folder"),
    ] {
        let run = folder.run(&[&["solve"], args].concat());
        assert_eq!(run.code, code, "{args:?}: {}", run.stderr);
        assert!(run.stderr.contains("error: ") && run.stderr.contains(part), "{args:?}: {}", run.stderr);
        assert!(!run.stderr.contains("meshing"), "{args:?}: {}", run.stderr);
        assert_eq!(folder.names(), before, "{args:?}");
    }
}

/// Steps of writing fail in debug builds alone.
#[cfg(debug_assertions)]
mod failures {
    use super::*;

    /// Fails the step of writing with this number; see `tests/cli/outputs.rs`.
    fn solve_failing_at(step: u32, folder: &Folder, args: &[&str]) -> (Option<i32>, String) {
        let flags = ["solve", "small.json", "--control", "steady"];
        let run = folder
            .command(&[&flags[..], args, &QUICK].concat())
            .env("MESOCRETE_FAIL_AT", step.to_string())
            .output()
            .unwrap();
        (run.status.code(), String::from_utf8(run.stderr).unwrap())
    }

    #[test]
    fn a_frame_that_cannot_be_written_ends_no_test() {
        let folder = Folder::with_model();
        // A file takes four steps, the first one keeps room for the results: the second of three frames fails.
        let (code, told) = solve_failing_at(9, &folder, &["--frames", "3"]);
        assert_eq!(code, Some(1), "{told}");
        assert!(
            told.contains("warning: out/frame_0002.vtu: ") && told.contains("goes on without this frame"),
            "{told}"
        );
        assert!(told.ends_with("error: 1 of 3 frames could not be written; all other results are whole\n"), "{told}");
        let files = ["curve.csv", "frame_0001.vtu", "frame_0003.vtu", "frames.pvd", "result.html", "result.json"];
        assert_eq!(folder.names_in("out"), files);
        let result = result(&folder, "out/result.json");
        assert!(result["ended"] == "completed" && result["frames"].as_array().unwrap().len() == 2, "{result}");
        assert_eq!(String::from_utf8(folder.read("out/frames.pvd")).unwrap().matches("<DataSet").count(), 2);
    }

    #[test]
    fn a_checkpoint_that_cannot_be_written_ends_no_test_and_is_told() {
        let folder = Folder::with_model();
        let (code, told) = solve_failing_at(6, &folder, &["--checkpoint", "0", "--frames", "1"]);
        assert_eq!(code, Some(0), "{told}");
        assert_eq!(told.matches("warning: out/checkpoint.bin: ").count(), 1, "{told}");
        assert_eq!(folder.names_in("out"), ["curve.csv", "frame_0001.vtu", "frames.pvd", "result.html", "result.json"]);
    }
}

#[cfg(unix)]
pub(crate) mod signals {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    /// The quick test in so many steps that it can be caught on its way.
    pub(crate) const LONG: [&str; 11] = [
        "solve",
        "small.json",
        "--element-size-mm",
        "5",
        "--strain",
        "0.003",
        "--frames",
        "4",
        "--time-step",
        "8e-8",
        "--accept-phase-error",
    ];

    pub(crate) fn signal(child: &Child, name: &str) {
        assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
    }

    /// Waits for `event`, as long as the child runs.
    pub(crate) fn wait_for(child: &mut Child, mut event: impl FnMut() -> bool) {
        let begun = Instant::now();
        while !event() {
            assert!(child.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(120), "too late");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// The result of a test that Ctrl-C stops when a line of its progress begins so.
    fn interrupted(folder: &Folder, args: &[&str], line: &str) -> serde_json::Value {
        let mut child = folder.command(args).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        assert!(lines.any(|told| told.unwrap().starts_with(line)), "{args:?}");
        let asked = Instant::now();
        signal(&child, "-INT");
        let rest: Vec<String> = lines.map(Result::unwrap).collect();
        assert_eq!(child.wait().unwrap().code(), Some(130), "{args:?} {rest:?}");
        assert!(asked.elapsed() < Duration::from_secs(10), "{args:?} {:?}", asked.elapsed());
        let result = result(folder, "out/result.json");
        let (steps, planned) = (result["steps"].as_u64().unwrap(), result["steps_planned"].as_u64().unwrap());
        assert!(result["ended"] == "stopped" && steps < planned, "{args:?} {steps} of {planned}");
        let page = String::from_utf8(folder.read("out/result.html")).unwrap();
        assert!(page.ends_with("</html>\n"));
        // A page was titled "3.24 MPa" where the stress still rose.
        let title = page.split("<title>").nth(1).unwrap().split("</title>").next().unwrap();
        let is_free = args.contains(&"expansion");
        assert_eq!(title.contains("no peak yet, "), result["softened"] == false && !is_free, "{title}");
        assert!(!folder.names_in("out").iter().any(|name| name.ends_with(".tmp")));
        result
    }

    #[test]
    fn an_interrupt_keeps_the_curve_so_far() {
        let folder = Folder::with_model();
        let result = interrupted(&folder, &LONG, " 30 %");
        assert!(result["steps"].as_u64() > result["steps_planned"].as_u64().map(|planned| planned / 4), "{result}");
        let rows = curve(&folder, "out/curve.csv")["strain"].len();
        assert!(rows > 50 && rows < 390, "{rows}");
    }

    /// The case: `timeout` lost the curve of a test, since it sends SIGTERM to the program and again to its group.
    #[test]
    fn two_signals_at_once_are_one_request() {
        let folder = Folder::with_model();
        let mut child = folder.command(&LONG).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        assert!(lines.any(|told| told.unwrap().starts_with(" 10 %")));
        signal(&child, "-TERM");
        signal(&child, "-TERM");
        lines.for_each(|line| drop(line.unwrap()));
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(result(&folder, "out/result.json")["ended"], "stopped");
    }

    /// The case: no test but compression was interrupted. From Python, each is in every run of the tests.
    #[test]
    #[ignore = "slow tier: nine tests in many small steps, 12 s of processor time"]
    fn an_interrupt_keeps_the_curve_of_a_test_of_every_kind() {
        let folder = Folder::with_model();
        let prism = |sizes: &str| {
            format!(
                "fraction = 0.1\nspecimen = {{ kind = 'notched-prism', {sizes}, width_mm = 10, notch_width_mm = 5 }}\n\
                 grading = {{ d_min_mm = 6, d_max_mm = 8 }}\n"
            )
        };
        folder.write("beam.toml", prism("length_mm = 65, depth_mm = 20, notch_depth_mm = 5"));
        let notches = "length_mm = 40, depth_mm = 40, notch_depth_mm = 10, upper_notch_depth_mm = 10";
        folder.write("sheared.toml", prism(notches));
        for kind in
            ["tension", "triaxial", "biaxial", "cyclic", "splitting", "bending", "four-point", "shear", "expansion"]
        {
            let body = match kind {
                "bending" | "four-point" => "beam.toml",
                "shear" => "sheared.toml",
                _ => "small.json",
            };
            // A beam is slow.
            let step = if body == "beam.toml" { "4e-7" } else { "2e-8" };
            let args = ["solve", body, "--test", kind, "--element-size-mm", "5", "--time-step", step, "--frames", "1"];
            let result = interrupted(&folder, &[&args[..], &["--accept-phase-error", "--force"]].concat(), " 10 %");
            let columns = result["columns"].as_array().map_or(0, Vec::len);
            assert!(result["test"] == kind && (columns > 0) == (kind != "tension"), "{result}");
            assert!(curve(&folder, "out/curve.csv")["strain"].len() > 2, "{kind}");
        }
    }
}

#[test]
fn a_test_of_a_file_has_its_gauges_and_supports_as_columns() {
    let folder = Folder::with_model();
    assert_eq!(folder.run(&["init", "--test", "triaxial"]).code, 0);
    let run =
        solve(&folder, &["small.json", "-o", "out", "--test", "TEST.toml", "--pressure-mpa", "2", "--frames", "0"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let (curve, result) = (curve(&folder, "out/curve.csv"), result(&folder, "out/result.json"));
    assert_eq!((&result["test"], &result["pressure_mpa"]), (&"triaxial".into(), &2.0.into()));
    let columns = result["columns"].as_array().unwrap();
    assert_eq!(columns.len(), 4, "{columns:?}");
    assert!(columns.iter().all(|name| curve.contains_key(name.as_str().unwrap())), "{columns:?}");
}

/// The case: a wrong name of `--analysis` got the list of names, and no tip.
#[test]
fn a_wrong_name_of_a_test_gets_the_name_that_it_resembles() {
    let folder = Folder::with_model();
    folder.write("T.toml", "kind = 'bendin'\n");
    for (args, tip) in [
        (&["mesh", "small.json", "-o", "m.inp", "--analysis", "splittin"][..], "a similar value exists: 'splitting'"),
        (&["pack", "small.toml", "-o", "m.inp", "--analysis", "elastik"], "a similar value exists: 'elastic'"),
        (&["solve", "small.json", "--test", "compresion"], "a similar value exists: 'compression'"),
        (&["solve", "small.json", "--test", "T.toml"], "did you mean \"bending\"?"),
        (&["mesh", "small.json", "-o", "m.inp", "--analysis", "T.toml"], "did you mean \"bending\"?"),
    ] {
        let run = folder.run(args);
        assert!(run.code == 2 && run.stderr.contains(tip), "{args:?} {}", run.stderr);
    }
}

/// The case: a course of strains could not come from a table.
#[test]
fn a_course_of_strains_comes_from_a_table_whose_faults_have_its_file_line_and_column() {
    let folder = Folder::with_model();
    std::fs::create_dir(folder.path("tests")).unwrap();
    let test = "kind = 'expansion'\n[expansion]\nmortar = 'dry.csv'\nlayer_mm = 6\nbelow = { aggregate = 1e-4 }\n";
    folder.write("tests/TEST.toml", test);
    let args = ["small.json", "-o", "out", "--test", "tests/TEST.toml", "--frames", "0", "--force"];
    for (table, fault) in [
        ("time,strain\n28,-2e-4\n7,-4e-4\n", "its line 3 has 7 in the column time; times must be finite"),
        ("time,strain\n28,dry\n", "its line 2 has no number in the column strain"),
    ] {
        folder.write("tests/dry.csv", table);
        let run = solve(&folder, &args);
        let named = format!("tests/TEST.toml: test.expansion.mortar is dry.csv; {fault}");
        assert!(run.code == 2 && run.stderr.contains(&named), "{}", run.stderr);
    }
    // With the mark that Excel writes before UTF-8.
    folder.write("tests/dry.csv", "\u{feff}time,strain\r\n28,-2e-4\r\n90,-4e-4\r\n");
    let run = solve(&folder, &args);
    let words = "mortar -4e-4 at 90 in 2 rows in a layer of 6 mm, aggregate 1e-4 below the layer";
    assert!(run.code == 0 && run.stderr.contains(words), "{}", run.stderr);
    let result = result(&folder, "out/result.json");
    assert_eq!(result["expansion"]["mortar"], serde_json::json!([[28.0, -2e-4], [90.0, -4e-4]]));
    assert_eq!(result["expansion"]["below"]["aggregate"], 1e-4);
    // Zeros without a word: fibres of a specimen without fibres, and a table without a strain.
    for (lines, fault) in [
        ("fibre = 1e-4", "expansion.fibre is 1e-4; no mesh of this specimen has that phase; leave it out"),
        ("", "expansion is 0; no phase has a strain; give one, as mortar = -3e-4, or leave the table out"),
        ("mortar = -0.02", "expansion.mortar is -0.02; it must be -0.005 to 0.02: -0.02 % are -0.0002"),
    ] {
        folder.write("tests/TEST.toml", format!("kind = 'expansion'\n[expansion]\n{lines}\n"));
        let run = solve(&folder, &args);
        assert!(run.code == 2 && run.stderr.contains(fault), "{} {}", run.code, run.stderr);
        // Refused before the mesh is made.
        assert!(!run.stderr.contains("meshing"), "{}", run.stderr);
    }
}

/// Found by an audit: `--test expansion` alone was refused, and an expansion printed no figure.
#[test]
fn an_expansion_alone_names_its_strain_and_prints_the_mean_strains() {
    let folder = Folder::with_model();
    let run = solve(&folder, &["small.json", "-o", "out", "--test", "expansion", "--frames", "0"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("expansion of aggregate 1e-4, law meso: "), "{}", run.stderr);
    assert!(run.stderr.contains("\nmean strain_x ") && !run.stderr.contains("MPa at"), "{}", run.stderr);
    let result = result(&folder, "out/result.json");
    assert_eq!(result["expansion"]["aggregate"], 1e-4);
    let strain = result["strains_at_end"]["strain_z"].as_f64().unwrap();
    assert!(strain > 1e-6 && strain < 1e-4, "{strain}");
}

/// Found by an audit: a modulus of 4204 MPa, of nominal stress over nominal strain.
#[test]
fn a_splitting_test_prints_no_modulus() {
    let folder = Folder::with_model();
    let run = solve(&folder, &["small.json", "-o", "out", "--test", "splitting", "--frames", "0"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("\npeak ") && !run.stderr.contains("modulus"), "{}", run.stderr);
}

#[test]
fn a_test_that_the_specimen_cannot_have_is_refused_before_the_packing() {
    let folder = Folder::with_spec();
    let run = folder.run(&["solve", "small.toml", "--test", "bending"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("10/9 of its depth") && !run.stderr.contains("packing"), "{}", run.stderr);
    let run = folder.run(&["solve", "small.toml", "--test", "twisting"]);
    assert!(run.stderr.contains("NAME|TEST.toml"), "{}", run.stderr);
    let run = folder.run(&["solve", "small.toml", "--test", "compresion"]);
    assert!(run.code == 2 && run.stderr.contains("a similar value exists: 'compression'"), "{}", run.stderr);
}

/// The case: a nan in a support made the whole file the default test.
#[test]
fn numbers_that_are_not_finite_are_refused_by_line_and_key_in_every_file() {
    let folder = Folder::with_model();
    let support = "[[supports]]\nname = 'a'\non = 'z-max'\n";
    for (text, said) in [
        ("strain = nan\n", "line 1: strain is nan; it must be finite"),
        ("kind = 'drop'\nmass_kg = inf\n", "line 2: mass_kg is inf"),
        (&format!("{support}friction = nan\n"), "line 4: supports.friction is nan"),
        (
            &format!("{support}drive = {{ kind = 'speed', speed_m_per_s = [[0, 0], [1e-5, nan]] }}\n"),
            "supports.drive.speed_m_per_s is nan",
        ),
        ("[expansion]\naggregate = -inf\n", "line 2: expansion.aggregate is -inf"),
    ] {
        folder.write("T.toml", text);
        let run = solve(&folder, &["small.json", "-o", "out", "--test", "T.toml"]);
        assert!(run.code == 2 && run.stderr.contains(said), "{text}: {}", run.stderr);
    }
    folder.write("M.toml", "[materials.mortar_strength]\ncompressive_mpa = nan\n");
    let run = solve(&folder, &["small.json", "-o", "out", "--materials", "M.toml"]);
    assert!(run.code == 2 && run.stderr.contains("is nan; it must be finite"), "{}", run.stderr);
    folder.write("STUDY.toml", "spec = 's.toml'\n[solve]\nfriction = nan\n[over]\nseed = [1]\n");
    let run = folder.run(&["study", "STUDY.toml", "-o", "study"]);
    assert!(run.code == 2 && run.stderr.contains("is nan; it must be finite"), "{}", run.stderr);
}
