//! Calibration by the command: the mortar of a measured curve, resumed, with the source of each value.

use crate::command::Folder;
use serde_json::Value;

const SPEC: &str = "seed = 3\nfraction = 0.3\n[specimen]\nkind = 'cube'\nside_mm = 24\n\
[grading]\nd_min_mm = 4\nd_max_mm = 10\n[placement]\nmin_gap_mm = 0.5\n";
const FLAGS: [&str; 4] = ["--element-size-mm", "3", "--accept-phase-error", "-q"];

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
        let run = folder.run(&[&flags[..], &FLAGS].concat());
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
    let run = folder.run(&["init", "-q", "--materials", "C30/37", "--rock", "basalt", "-o", "c30.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

#[test]
fn a_curve_or_a_class_that_cannot_be_is_wrong_usage() {
    let folder = Folder::new();
    folder.write("SPEC.toml", SPEC);
    folder.write("flat.csv", "strain,stress_mpa\n0,0\n0.001,0\n");
    folder.write("short.csv", "strain,stress_mpa\n0,0\n0.001\n");
    for (args, message) in [
        (&["fit", "flat.csv", "SPEC.toml"][..], "flat.csv: it must rise from its first row to a peak"),
        (&["fit", "short.csv", "SPEC.toml"][..], "short.csv: line 3 has no number there"),
        (&["init", "--materials", "B30"][..], "--materials \"B30\" is no class of concrete, as C30 or C30/37"),
        (&["init", "--materials", "C5"][..], "--materials C5: materials.fcm is 13; it must be 20 to 128 MPa"),
        (&["init", "--rock", "granite"][..], "--materials"),
    ] {
        let run = folder.run(args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.stderr);
        assert!(run.stderr.contains(message), "{args:?}: {}", run.stderr);
    }
}
