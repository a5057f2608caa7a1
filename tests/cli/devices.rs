//! Devices: none without a driver, checked by a small test, and taken by studies.

use crate::command::{Folder, Run};

/// The command without any driver of OpenCL; none on a machine with CUDA, whose driver cannot be hidden.
fn without_a_driver(folder: &Folder, args: &[&str]) -> Option<Run> {
    let of = |args: &[&str]| {
        let output = folder.command(args).env("OCL_ICD_VENDORS", folder.path("none")).output().expect("it runs");
        let stderr = String::from_utf8(output.stderr).expect("text");
        Run { code: output.status.code().expect("no signal"), stdout: output.stdout, stderr }
    };
    let has_none = of(&["devices"]).stdout.is_empty();
    if !has_none {
        eprintln!("skipped: a driver of this machine cannot be hidden");
    }
    has_none.then(|| of(args))
}

/// The lines of `devices`.
fn lines(folder: &Folder, args: &[&str]) -> Vec<String> {
    let run = folder.run(args);
    assert_eq!(run.code, 0, "{}", run.stderr);
    run.stdout().lines().map(str::to_owned).collect()
}

#[test]
fn a_device_without_a_driver_is_refused_in_one_line_before_anything_is_packed() {
    let folder = Folder::with_spec();
    let Some(run) = without_a_driver(&folder, &["solve", "small.toml", "--device", "gpu"]) else { return };
    assert_eq!((run.code, run.stderr.lines().count()), (2, 1), "{}", run.stderr);
    assert!(run.stderr.contains("there is no device gpu; install its driver"), "{}", run.stderr);
    assert_eq!(folder.names(), ["small.toml"]);
    let listed = without_a_driver(&folder, &["devices"]).unwrap();
    assert!(listed.code == 0 && listed.stderr.starts_with("no device; "), "{}", listed.stderr);
}

#[test]
fn a_check_compares_every_device_with_the_processor() {
    let folder = Folder::new();
    let listed = lines(&folder, &["devices"]);
    let checked = lines(&folder, &["devices", "--check"]);
    assert_eq!(checked.len(), listed.len());
    for (line, plain) in checked.iter().zip(&listed) {
        let is_faithful = !plain.contains("; ");
        // Drivers of processors give the memory that is free, which other programs change.
        let (name, _) = plain.rsplit_once(", ").expect("a name, then the memory");
        assert!(line.starts_with(name), "{line}");
        assert!(line.ends_with("; same bytes as the processor") || !is_faithful, "{line}");
    }
}

#[test]
fn a_study_on_a_device_has_the_curves_of_the_processor() {
    let folder = Folder::with_spec();
    if lines(&folder, &["devices"]).is_empty() {
        eprintln!("skipped: no device here (Debian: pocl-opencl-icd)");
        return;
    }
    let curve = |device: &str| {
        folder.write(
            "STUDY.toml",
            format!(
                "spec = 'small.toml'\n[solve]\nelement-size-mm = 5\naccept-phase-error = true\nframes = 0\n\
                 strain = 0.0003\ndevice = '{device}'\n[over]\nseed = [1]\n"
            ),
        );
        let run = folder.run(&["study", "STUDY.toml", "-o", device]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let case = folder.names_in(device).into_iter().find(|name| name.starts_with("seed-")).expect("a case");
        folder.read(&format!("{device}/{case}/curve.csv"))
    };
    assert_eq!(curve("gpu"), curve("cpu"));
}

#[test]
fn a_study_whose_device_is_missing_is_refused_before_anything_is_packed() {
    // Every case was packed, and then failed.
    let folder = Folder::with_spec();
    folder.write("STUDY.toml", "spec = 'small.toml'\n[solve]\ndevice = 'opencl:99'\n[over]\nseed = [1, 2]\n");
    let run = folder.run(&["study", "STUDY.toml", "-o", "out"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("STUDY.toml: there is no device opencl:99; "), "{}", run.stderr);
    assert!(!folder.path("out").exists() || folder.names_in("out").iter().all(|name| !name.starts_with("seed-")));
}

#[test]
fn names_that_are_no_device_are_refused() {
    let folder = Folder::with_spec();
    for (name, part) in [
        ("abacus", "\"abacus\" is no device; take cpu, gpu, cuda:N or opencl:N"),
        ("cuda:99", "there is no device cuda:99; "),
        ("opencl:0:48", "\"opencl:0:48\" is no device; "),
    ] {
        let run = folder.run(&["solve", "small.toml", "--device", name]);
        assert!(run.code == 2 && run.stderr.contains(part), "{}", run.stderr);
        assert_eq!(folder.names(), ["small.toml"]);
    }
}

/// Results of a test in a folder, but for the seconds that it took.
fn results(folder: &Folder, name: &str) -> Vec<(String, Vec<u8>)> {
    let without_seconds = |text: Vec<u8>| {
        let mut tree: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        tree.as_object_mut().expect("an object").remove("seconds");
        tree.to_string().into_bytes()
    };
    let read = |file: String| {
        let bytes = folder.read(&format!("{name}/{file}"));
        let bytes = if file == "result.json" { without_seconds(bytes) } else { bytes };
        (file, bytes)
    };
    folder.names_in(name).into_iter().map(read).collect()
}

#[test]
fn a_test_on_a_device_has_every_file_that_the_processor_writes() {
    let folder = Folder::with_spec();
    if lines(&folder, &["devices"]).is_empty() {
        eprintln!("skipped: no device here (Debian: pocl-opencl-icd)");
        return;
    }
    let solve = |name: &str, more: &[&str]| {
        let flags =
            "--element-size-mm 6 --accept-phase-error --strain 0.0004 --frames 2 --duration 4e-4 --min-gap-mm 0";
        let args: Vec<&str> = flags.split(' ').chain(more.iter().copied()).collect();
        let run = folder.run(&[&["solve", "small.toml", "-o", name], &*args].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
    };
    solve("here", &[]);
    solve("there", &["--device", "gpu"]);
    assert_eq!(results(&folder, "here").len(), 6);
    assert!(results(&folder, "here") == results(&folder, "there"));
    let result = String::from_utf8(folder.read("there/result.json")).expect("text");
    assert!(!result.contains("opencl") && !result.contains("device"), "{result}");
}
