//! Calibration by the command: the mortar of a measured curve, resumed, with the source of each value.

use crate::command::Folder;
use serde_json::Value;
use std::process::Stdio;

const SPEC: &str = "seed = 3\nfraction = 0.3\n[specimen]\nkind = 'cube'\nside_mm = 24\n\
[grading]\nd_min_mm = 4\nd_max_mm = 10\n[placement]\nmin_gap_mm = 0.5\n";
const FLAGS: [&str; 4] = ["--element-size-mm", "4", "--accept-phase-error", "-q"];

/// A folder with a spec and the curve of a mortar of 50 MPa.
fn measured() -> Folder {
    let folder = Folder::new();
    folder.write("SPEC.toml", SPEC);
    folder.write(
        "known.toml",
        "[materials.mortar_strength]\ncompressive_mpa = 50\npeak_strain = 0.0035\ntensile_mpa = 4.25\n",
    );
    let flags =
        ["solve", "SPEC.toml", "-o", "known", "--materials", "known.toml", "--strain", "0.006", "--frames", "0"];
    let run = folder.run(&[&flags[..], &FLAGS].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    folder
}

fn report(folder: &Folder) -> Value {
    serde_json::from_slice(&folder.read("fit/fit.json")).unwrap()
}

#[test]
fn a_fit_finds_the_mortar_of_a_curve_of_our_own_and_resumes() {
    let folder = measured();
    let fit = |steps: &str| {
        let flags = ["fit", "known/curve.csv", "SPEC.toml", "--seeds", "1", "--strain", "0.006", "--steps", steps];
        let run = folder.run(&[&flags[..], &FLAGS, &["--force"]].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        report(&folder)
    };
    let first = fit("0");
    assert_eq!(first["points"].as_array().unwrap().len(), 5);
    let cases = folder.names_in("fit/cases");
    let last = fit("3");
    // The first five points are those of the run before.
    assert!(cases.iter().all(|case| folder.names_in("fit/cases").contains(case)), "{cases:?}");
    assert_eq!(last["points"].as_array().unwrap()[..5], first["points"].as_array().unwrap()[..]);
    let of = |key: &str| last["parameters"][key]["value"].as_f64().unwrap();
    let [strength, strain] = [of("compressive_mpa"), of("peak_strain")];
    assert!((strength / 50.0 - 1.0).abs() < 0.03 && (strain / 0.0035 - 1.0).abs() < 0.05, "{last:#}");
    assert!(last["misfit"].as_f64() < first["misfit"].as_f64(), "{last:#}");
    let text = String::from_utf8(folder.read("fit/materials.toml")).unwrap();
    assert!(text.contains("# compressive_mpa ") && text.contains("[materials.mortar_strength]"), "{text}");
    folder.write("fitted.toml", &text);
    // A finished fit is kept; its tests are those of their records, to the bit.
    let again =
        [&["fit", "known/curve.csv", "SPEC.toml", "--seeds", "1", "--strain", "0.006", "--steps", "0"][..], &FLAGS];
    let kept = folder.run(&again.concat());
    assert!(
        kept.code == 1 && kept.stderr.contains("fit/materials.toml exists; --force replaces it"),
        "{}",
        kept.stderr
    );
    for case in &cases {
        let curve = format!("fit/cases/{case}/curve.csv");
        if folder.path(&curve).exists() {
            let mut bytes = folder.read(&curve);
            let place = bytes.len() / 2;
            bytes[place] ^= 1;
            folder.write(&curve, bytes);
        }
    }
    let damaged = folder.run(&[&again.concat()[..], &["--force"]].concat());
    assert!(
        damaged.code == 1 && damaged.stderr.contains("curve.csv is not the curve of its test; remove"),
        "{}",
        damaged.stderr
    );
    let run = folder.run(&["init", "-q", "--materials", "C30/37", "--rock", "basalt", "-o", "c30.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

#[test]
fn a_curve_or_a_class_that_cannot_be_is_wrong_usage() {
    let folder = Folder::new();
    folder.write("SPEC.toml", SPEC);
    folder.write("flat.csv", "strain,stress_mpa\n0,0\n0.001,0\n");
    folder.write("psi.csv", "strain,stress_mpa\n0,0\n0.001,4351\n0.003,2000\n");
    folder.write("percent.csv", "strain,stress_mpa\n0,0\n0.2,30\n0.3,20\n");
    folder.write("short.csv", "strain,stress_mpa\n0,0\n0.001\n");
    for (args, message) in [
        (&["fit", "flat.csv", "SPEC.toml"][..], "flat.csv: it must rise from its first row to a peak"),
        (
            &["fit", "psi.csv", "SPEC.toml"][..],
            "psi.csv: the peak stress is 4351; it must be 1 to 300 MPa: 4351 kPa are",
        ),
        (
            &["fit", "percent.csv", "SPEC.toml"][..],
            "percent.csv: the strain at its peak is 0.2; it must be 0.0001 to 0.03",
        ),
        (&["fit", "short.csv", "SPEC.toml"][..], "short.csv: line 3 has 1 cells and line 1 has 2"),
        (&["init", "--materials", "B30"][..], "--materials \"B30\" is no class of concrete, as C30 or C30/37"),
        (&["init", "--materials", "C5"][..], "--materials C5: fcm is 13; it must be 20 to 128 MPa"),
        (&["init", "--rock", "granite"][..], "--materials"),
    ] {
        let run = folder.run(args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.stderr);
        assert!(run.stderr.contains(message), "{args:?}: {}", run.stderr);
    }
}

/// The audit of new features: a count of 4,294,967,295 packings was an abort for want of 34 GB, the largest seed a panic,
/// and refused fits left folders behind.
#[test]
fn a_refused_fit_makes_no_folder() {
    let folder = Folder::new();
    folder.write("SPEC.toml", SPEC);
    folder.write("LAST.toml", SPEC.replace("seed = 3", "seed = 18446744073709551615"));
    folder.write("bad.toml", "[materials.mortar]\nyoungs_modulus_mpa = -1\n");
    folder.write("curve.csv", "\u{feff}strain;stress_mpa\r\n0;0\r\n0,001;20\r\n0,002;30\r\n0,004;10\r\n");
    let before = folder.names();
    for (args, message) in [
        (&["SPEC.toml", "--seeds", "4294967295"][..], "must be a whole number from 1 to 10000"),
        (&["LAST.toml", "--seeds", "2"], "seed is 18446744073709551615, and the packings take successive ones"),
        (&["SPEC.toml", "--element-size-mm", "-1"], "--element-size-mm is -1"),
        (&["SPEC.toml", "--strain", "nan"], "'--strain <E>': it must be a number"),
        (&["SPEC.toml", "--friction", "inf"], "'--friction <MU>': it must be a number"),
        (&["SPEC.toml", "--friction", "-1"], "--friction is -1"),
        (&["SPEC.toml", "--materials", "bad.toml"], "youngs_modulus_mpa is -1"),
        (&["SPEC.toml", "-o", "-"], "--output - is standard output, but a fit writes several files; name a folder"),
        (&["SPEC.toml", "-o", "no/such"], "no/such"),
    ] {
        let run = folder.run(&[&["fit", "curve.csv"][..], args].concat());
        assert!(run.code == 2 || args.contains(&"no/such"), "{args:?}: {} {}", run.code, run.stderr);
        assert!(run.stderr.contains(message), "{args:?}: {}", run.stderr);
        assert_eq!(folder.names(), before, "{args:?}");
    }
}

/// The audit of new features: a fit replaced the materials that it had read.
#[test]
fn a_fit_replaces_none_of_its_inputs_and_no_second_one_works_in_its_folder() {
    let folder = Folder::new();
    folder.write("SPEC.toml", SPEC);
    folder.write("materials.toml", "[materials.mortar]\nyoungs_modulus_mpa = 25000\n");
    folder.write("curve.csv", "strain,stress_mpa\n0,0\n0.001,20\n0.002,30\n0.004,10\n");
    let fit = ["fit", "curve.csv", "SPEC.toml", "--materials", "materials.toml", "-o", "."];
    let kept = folder.run(&fit);
    assert!(kept.code == 1 && kept.stderr.contains("materials.toml exists; --force replaces it"), "{}", kept.stderr);
    let input = folder.run(&[&fit[..], &["--force"]].concat());
    assert!(input.code == 2 && input.stderr.contains("materials.toml is the input"), "{}", input.stderr);
    let _held = meso_files::lock::join(&folder.path(""), "another").unwrap();
    let second = folder.run(&["fit", "curve.csv", "SPEC.toml", "-o", "."]);
    assert!(second.code == 1 && second.stderr.contains("is in use by process"), "{}", second.stderr);
}

/// Processes in one folder were refused: a fit now shares its tests as a study does, and one of them may be killed.
#[test]
fn processes_with_the_same_fit_share_its_tests_and_write_the_bytes_of_one() {
    let folder = measured();
    let flags = ["fit", "known/curve.csv", "SPEC.toml", "--seeds", "2", "--strain", "0.006", "--steps", "1"];
    let of = |out: &str| [&flags[..], &FLAGS, &["-o", out]].concat().into_iter().map(str::to_owned).collect::<Vec<_>>();
    let start = |out: &str| {
        let args = of(out);
        folder.command(&args.iter().map(String::as_str).collect::<Vec<_>>()).stderr(Stdio::null()).spawn().unwrap()
    };
    assert!(start("alone").wait().unwrap().success());
    let mut killed = start("shared");
    let mut others = [start("shared"), start("shared")];
    while !folder.path("shared/cases").is_dir() {
        std::thread::yield_now();
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(others.iter_mut().all(|other| other.wait().unwrap().success()));
    assert_eq!(folder.names_in("shared"), folder.names_in("alone"));
    for name in ["materials.toml", "fit.json"] {
        assert!(folder.read(&format!("shared/{name}")) == folder.read(&format!("alone/{name}")), "{name}");
    }
    let cases = folder.names_in("alone/cases");
    assert_eq!(folder.names_in("shared/cases"), cases);
    for case in cases {
        let curve = |fit: &str| folder.read(&format!("{fit}/cases/{case}/curve.csv"));
        assert!(curve("shared") == curve("alone"), "{case}");
    }
}

/// A test that failed is no reason to fail for ever: the same command does it again, and leaves the others.
#[test]
fn a_fit_that_begins_alone_runs_its_failed_tests_again() {
    let folder = measured();
    let flags = ["fit", "known/curve.csv", "SPEC.toml", "--seeds", "1", "--strain", "0.006", "--steps", "0", "--force"];
    let fit = || folder.run(&[&flags[..], &FLAGS].concat());
    assert_eq!(fit().code, 0);
    let case = format!("fit/cases/{}", folder.names_in("fit/cases")[0]);
    let (record, results) = (folder.read(&format!("{case}/case.json")), folder.read("fit/fit.json"));
    let mut failed: meso_study::Record = serde_json::from_slice(&record).unwrap();
    (failed.status, failed.error) = (meso_study::Status::Failed, Some("no memory".to_owned()));
    failed.sha256 = String::new();
    let seal = meso_study::digest(serde_json::to_string(&failed).unwrap().as_bytes());
    folder.write(
        &format!("{case}/case.json"),
        serde_json::to_vec(&meso_study::Record { sha256: seal, ..failed }).unwrap(),
    );
    assert_eq!(fit().code, 0);
    let again: meso_study::Record = serde_json::from_slice(&folder.read(&format!("{case}/case.json"))).unwrap();
    let first: meso_study::Record = serde_json::from_slice(&record).unwrap();
    assert_eq!((again.results, again.curve_sha256), (first.results, first.curve_sha256));
    assert!(again.error.is_none() && folder.read("fit/fit.json") == results);
}
