//! Several outputs are one unit, wherever a run fails or is ended; what is read may be a pipe or a link.
#![cfg(unix)]

use crate::command::Folder;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::{Command, Stdio};

const OUTPUTS: [&str; 3] = ["a.vtu", "b.csv", "c.stl"];
/// Four steps to fill a file, one to make its name ready and one to give it.
const STEPS: usize = 6 * OUTPUTS.len();

/// Converts into three files, with `variable` set to a step; the exit code.
fn convert(folder: &Folder, variable: &str, step: usize) -> Option<i32> {
    let mut args = vec!["convert", "small.json", "-f"];
    OUTPUTS.iter().for_each(|output| args.extend(["-o", output]));
    let mut command = folder.command(&args);
    command.env(variable, step.to_string()).stderr(Stdio::null()).status().unwrap().code()
}

/// What the three files are: all as they were, or all new; panics where they are mixed or something is left.
fn all_new(folder: &Folder, old: &[Option<&[u8]>; 3], what: &str) -> bool {
    let left: Vec<String> = folder.names().into_iter().filter(|name| name.starts_with('.')).collect();
    assert!(left.is_empty(), "{what}: {left:?} is left");
    let now = OUTPUTS.map(|name| std::fs::read(folder.path(name)).ok());
    let same = (0..3).filter(|&i| now[i].as_deref() == old[i]).count();
    assert!(same == 0 || same == 3, "{what}: {same} of 3 files are old");
    same == 0
}

#[test]
fn a_signal_or_a_failure_at_any_step_leaves_all_old_files_or_all_new_ones() {
    let folder = Folder::with_model();
    for (variable, code) in [("MESOCRETE_SIGNAL_AT", 130), ("MESOCRETE_FAIL_AT", 1)] {
        for old in [[None; 3], [Some(&b"old"[..]); 3], [Some(&b"old"[..]), None, Some(&b"older"[..])]] {
            let mut seen = [0, 0];
            for step in 0..=STEPS {
                for (name, content) in OUTPUTS.iter().zip(old) {
                    let _ = std::fs::remove_file(folder.path(name));
                    content.into_iter().for_each(|content| folder.write(name, content));
                }
                let what = format!("{variable} {step}");
                let ended = convert(&folder, variable, step);
                let new = all_new(&folder, &old, &what);
                // A signal while names are made ready and given comes after them; the step after the last is none.
                assert_eq!(ended, Some(if step == STEPS { 0 } else { code }), "{what}");
                seen[usize::from(new)] += 1;
            }
            let names = if code == 130 { 2 * OUTPUTS.len() } else { 0 };
            assert_eq!(seen, [STEPS - names, names + 1], "{variable}");
        }
    }
}

#[test]
fn a_replaced_file_keeps_its_mode_and_its_links() {
    let folder = Folder::with_model();
    folder.write("secret.csv", "old");
    std::fs::set_permissions(folder.path("secret.csv"), PermissionsExt::from_mode(0o600)).unwrap();
    symlink("secret.csv", folder.path("link.csv")).unwrap();
    assert_eq!(folder.run(&["convert", "small.json", "-o", "link.csv", "-f"]).code, 0);
    assert!(folder.path("link.csv").is_symlink());
    assert!(folder.read("secret.csv").len() > 100);
    let mode = std::fs::metadata(folder.path("secret.csv")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
}

#[test]
fn a_link_to_nothing_is_named_before_the_work() {
    let folder = Folder::with_spec();
    symlink("nowhere.json", folder.path("link.json")).unwrap();
    for force in [&[][..], &["-f"]] {
        let run = folder.run(&[&["pack", "small.toml", "-o", "link.json"], force].concat());
        assert_eq!(run.code, 1);
        assert!(run.stderr.contains("link.json is a broken link; remove it"), "{}", run.stderr);
        assert!(!run.stderr.contains("packed"), "{}", run.stderr);
    }
}

#[test]
fn a_full_device_and_a_read_only_folder_are_named() {
    let folder = Folder::with_model();
    let run = folder.run(&["convert", "small.json", "-o", "/dev/full"]);
    assert_eq!(run.code, 2, "a device has no extension: {}", run.stderr);
    folder.write("there.csv", "old");
    let shell = |script: &str| {
        let mut command = Command::new("sh");
        let program = env!("CARGO_BIN_EXE_mesocrete");
        command.args(["-c", &script.replace("mesocrete", program)]).current_dir(folder.path(""));
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, message) = shell("mesocrete check small.json > /dev/full");
    assert!(code == Some(1) && message.contains("No space left"), "{code:?} {message}");
}

#[test]
fn a_file_beyond_the_systems_limit_fails_and_leaves_the_old_one() {
    let folder = Folder::with_model();
    folder.write("model.json", "old");
    let script = format!("ulimit -f 1; exec {} convert small.json -o model.json -f", env!("CARGO_BIN_EXE_mesocrete"));
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path("")).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("model.json: File too large"), "{message}");
    assert_eq!(folder.read("model.json"), b"old");
    assert!(folder.names().iter().all(|name| !name.starts_with('.')), "{:?}", folder.names());
}

/// The case: polygons of millions of corners, files of 40 MB, were aborted for want of memory.
#[cfg(target_os = "linux")]
#[test]
fn surfaces_beyond_the_free_memory_are_refused_with_both_figures() {
    let corners = 1_300_000;
    let ring = "1 2 3 ".repeat(corners);
    let flat = "0 0 0\n1 0 0\n0 1 0\n";
    let stl = [&[b'x'; 80][..], &1_000_000_u32.to_le_bytes(), &vec![0; 50_000_000]].concat();
    for (name, bytes) in [
        ("s.obj", format!("v {}f {ring}\n", flat.trim_end().replace('\n', "\nv ") + "\n").into_bytes()),
        ("s.off", format!("OFF\n3 1 0\n{flat}{} {ring}\n", 3 * corners).into_bytes()),
        ("s.stl", stl),
    ] {
        let folder = Folder::new();
        folder.write(name, bytes);
        for spec in ["specimen = { kind = 'mesh', file = 'NAME' }\n", "shape = { library = 'NAME' }\n"] {
            folder.write("s.toml", spec.replace("NAME", name));
            let script = format!("ulimit -v 500000; exec {} pack s.toml -o m.json", env!("CARGO_BIN_EXE_mesocrete"));
            let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path("")).output().unwrap();
            let message = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{message}");
            assert!(message.contains(" MB of memory, and ") && message.contains("fewer corners"), "{message}");
        }
    }
}

#[test]
fn a_closed_standard_output_is_no_place_for_data() {
    let folder = Folder::with_spec();
    let script = format!("{} init -o - >&-", env!("CARGO_BIN_EXE_mesocrete"));
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path("")).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("standard output is closed; name a file"), "{message}");
    let kept = folder.command(&["init", "-o", "-"]).stdout(Stdio::null()).status().unwrap();
    assert!(kept.success(), "the null device is where the user wants it");
}

#[test]
fn pipes_and_links_are_read() {
    let folder = Folder::with_model();
    symlink("small.json", folder.path("link.json")).unwrap();
    assert_eq!(folder.run(&["check", "link.json"]).code, 0);
    let model = folder.read("small.json");
    assert_eq!(folder.run_with_input(&["check", "/dev/stdin"], &model).code, 0);
    let script = format!("mkfifo pipe; cat small.json > pipe & {} check pipe", env!("CARGO_BIN_EXE_mesocrete"));
    let status = Command::new("sh").args(["-c", &script]).current_dir(folder.path("")).stdout(Stdio::null()).status();
    assert!(status.unwrap().success());
}

#[test]
fn an_input_without_end_is_refused_at_once() {
    let folder = Folder::new();
    let run = folder.command(&["check", "/dev/zero"]).output().unwrap();
    assert_eq!(run.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&run.stderr).contains("not a saved model"));
}

/// The audit of new features: a packing of 0.01 mm without a mesh was refused for the default size of elements.
#[test]
fn a_packing_without_a_mesh_is_not_asked_for_a_size_of_elements() {
    let folder = Folder::new();
    folder.write(
        "S.toml",
        "fraction = 0.1\nspecimen = { kind = 'cube', side_mm = 0.01 }\nitz = { thickness_mm = [1e-5, 2e-5] }\n\
         [grading]\nd_min_mm = 0.0025\nd_max_mm = 0.004\n",
    );
    let run = folder.run(&["pack", "S.toml", "-o", "m.json", "-q"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    for args in [&["-o", "m.inp"][..], &["-o", "n.json", "--element-size-mm", "2"]] {
        let run = folder.run(&[&["pack", "S.toml", "-q"][..], args].concat());
        assert!(run.code == 2 && run.stderr.contains("--element-size-mm is 2"), "{args:?}: {}", run.stderr);
    }
}
