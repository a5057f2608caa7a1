//! Ctrl-C keeps the best packing; a second one ends everything at once.
#![cfg(unix)]

use crate::command::Folder;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A specimen that takes far longer to pack than these tests wait.
const LARGE: &str = "fraction = 0.6\nspecimen = { kind = 'cube', side_mm = 200 }\n";

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

fn start(folder: &Folder, args: &[&str]) -> Child {
    folder.write("large.toml", LARGE);
    folder.command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn the_first_interrupt_keeps_the_best_packing() {
    let folder = Folder::new();
    let outputs = ["-o", "a.json", "-o", "a.csv", "--strategy", "take-and-place", "--attempts", "4000000"];
    let child = start(&folder, &[&["pack", "large.toml"], &outputs[..]].concat());
    std::thread::sleep(Duration::from_secs(6));
    let asked = Instant::now();
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{message}");
    // The promise is half a second; writing a large model and a busy machine take more.
    assert!(asked.elapsed() < Duration::from_secs(20), "{:?}", asked.elapsed());
    assert_eq!(folder.names(), ["a.csv", "a.json", "large.toml"]);
    assert!(message.contains("warning: short of the target (interrupted): "), "{message}");
    assert_eq!(folder.run(&["check", "a.json"]).code, 0);
}

#[test]
fn the_second_interrupt_ends_it_and_leaves_nothing() {
    let folder = Folder::new();
    let mut child = start(&folder, &["pack", "large.toml", "-o", "a.json"]);
    std::thread::sleep(Duration::from_millis(500));
    signal(&child, "-INT");
    std::thread::sleep(Duration::from_millis(250));
    signal(&child, "-INT");
    let code = child.wait().unwrap().code();
    assert_eq!(code, Some(130));
    assert!(!folder.names().iter().any(|name| name.ends_with(".tmp")), "{:?}", folder.names());
}

#[test]
fn a_command_that_has_nothing_to_keep_ends_at_once() {
    let folder = Folder::with_model();
    let mut child = folder.command(&["check", "-"]).stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    // Standard input stays open, so that it waits.
    let _input = child.stdin.take();
    std::thread::sleep(Duration::from_millis(200));
    signal(&child, "-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

/// A gmsh that writes its process number beside itself, and then is never done.
const ENDLESS: &str =
    "#!/bin/sh\ncase \"$*\" in *--version*) exit 0;; esac\necho $$ > \"$(dirname \"$0\")/running\"\nexec sleep 100\n";
/// One that is not even done with its version.
const ENDLESS_AT_ONCE: &str = "#!/bin/sh\necho $$ > \"$(dirname \"$0\")/running\"\nexec sleep 100\n";

/// A folder with `model.json` and `gaps.toml`, whose gaps gmsh can mesh, and the program `./endless`.
fn with_endless_gmsh(program: &str) -> Folder {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let gaps = "placement = { min_gap_mm = 0.1, wall_gap_mm = 0.1 }\n";
    folder.write("gaps.toml", format!("fraction = 0.2\nspecimen = {{ kind = 'cube', side_mm = 30 }}\n{gaps}"));
    assert_eq!(folder.run(&["pack", "gaps.toml", "-o", "model.json"]).code, 0);
    folder.write("endless", program);
    std::fs::set_permissions(folder.path("endless"), PermissionsExt::from_mode(0o755)).unwrap();
    std::fs::create_dir(folder.path("temporary")).unwrap();
    folder
}

/// Starts `command` with that gmsh, and waits until it runs.
fn until_gmsh_runs(folder: &Folder, command: &[&str]) -> Child {
    let args = [command, &["-o", "m.inp", "--method", "conforming", "--gmsh", "./endless"]].concat();
    let mut child = folder.command(&args).env("TMPDIR", folder.path("temporary")).spawn().unwrap();
    let begun = Instant::now();
    while !std::fs::read(folder.path("running")).is_ok_and(|number| number.ends_with(b"\n")) {
        assert!(child.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(60), "no gmsh");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

/// Whether the gmsh that noted its number still runs.
fn gmsh_runs(folder: &Folder) -> bool {
    let number = String::from_utf8(folder.read("running")).unwrap();
    Command::new("kill").args(["-0", number.trim()]).stderr(Stdio::null()).status().unwrap().success()
}

#[cfg(target_os = "linux")]
#[test]
fn a_kill_that_nobody_can_catch_ends_gmsh_too() {
    for program in [ENDLESS, ENDLESS_AT_ONCE] {
        let folder = with_endless_gmsh(program);
        let mut child = until_gmsh_runs(&folder, &["mesh", "model.json"]);
        signal(&child, "-KILL");
        assert_eq!(child.wait().unwrap().code(), None);
        let killed = Instant::now();
        // Whoever takes over its children has to look after the dead one first.
        while gmsh_runs(&folder) {
            assert!(killed.elapsed() < Duration::from_secs(20), "gmsh goes on without us");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn an_interrupt_during_gmsh_ends_gmsh_and_leaves_nothing() {
    // After the packing, too, the first one counts.
    let (mesh, pack) = (["mesh", "model.json"], ["pack", "gaps.toml"]);
    for (program, command) in [(ENDLESS, mesh), (ENDLESS, pack), (ENDLESS_AT_ONCE, mesh)] {
        let folder = with_endless_gmsh(program);
        let mut child = until_gmsh_runs(&folder, &command);
        signal(&child, "-INT");
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert!(!gmsh_runs(&folder), "gmsh goes on without us");
        assert_eq!(std::fs::read_dir(folder.path("temporary")).unwrap().count(), 0, "its folder is left");
        assert!(!folder.names().iter().any(|name| name == "m.inp" || name.ends_with(".tmp")), "{:?}", folder.names());
    }
}
