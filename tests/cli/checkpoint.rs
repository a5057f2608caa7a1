//! Tests that are killed and resumed, and two tests in one folder.
//!
//! Cases `checkpoint.py` and `frames_of_another_test.sh`: frames of another test were taken for the test's own.

use crate::command::{Folder, Run};
use crate::solve::result;
use crate::solve::signals::{LONG, signal, wait_for};
use serde_json::Value;
use std::process::Child;

/// Starts the long test with checkpoints in the folder `out`, and kills it when a checkpoint after frame 2 is there.
fn kill(folder: &Folder, out: &str, args: &[&str]) {
    let mut child = started(folder, out, &[&["--checkpoint", "0"], args].concat());
    wait_for(&mut child, || folder.path(&format!("{out}/frame_0002.vtu")).exists());
    let checkpoint = format!("{out}/checkpoint.bin");
    let there = folder.read(&checkpoint);
    wait_for(&mut child, || folder.read(&checkpoint) != there);
    signal(&child, "-KILL");
    child.wait().unwrap();
}

fn started(folder: &Folder, out: &str, args: &[&str]) -> Child {
    folder.command(&[&LONG[..], &["-o", out, "-q"], args].concat()).spawn().unwrap()
}

fn resumed(folder: &Folder, out: &str, args: &[&str]) -> Run {
    folder.run(&[&LONG[..], &["-o", out, "-q", "--resume"], args].concat())
}

#[test]
fn a_killed_test_is_resumed_to_the_same_bytes() {
    let folder = Folder::with_model();
    assert_eq!(folder.run(&[&LONG[..], &["-o", "whole", "-q"]].concat()).code, 0);
    kill(&folder, "cut", &[]);
    assert!(!folder.path("cut/curve.csv").exists() && folder.path("cut/checkpoint.bin").exists());
    let refused = folder.run(&[&LONG[..], &["-o", "cut"]].concat());
    assert!(refused.code == 1 && refused.stderr.contains("--resume continues from it"), "{}", refused.stderr);
    let other = folder.run(&[&LONG[..], &["-o", "cut", "--resume", "--friction", "0.2"]].concat());
    assert!(other.code == 1 && other.stderr.contains("it belongs to another mesh"), "{}", other.stderr);
    // The cases: the 4 MB that a dead run had reserved stayed, and a checkpoint that was killed on its way.
    folder.write("cut/.mesocrete-a1B2c3.tmp", "a checkpoint's beginning");
    let resumed = folder.run(&[&LONG[..], &["-o", "cut", "--resume", "-q"]].concat());
    assert_eq!(resumed.code, 0, "{}", resumed.stderr);
    let names = folder.names_in("cut");
    assert_eq!(names, folder.names_in("whole"));
    for file in names.iter().filter(|name| *name != "result.json") {
        assert!(folder.read(&format!("whole/{file}")) == folder.read(&format!("cut/{file}")), "{file} differs");
    }
    let [mut whole, mut cut] = ["whole", "cut"].map(|name| result(&folder, &format!("{name}/result.json")));
    for result in [&mut whole, &mut cut] {
        result["seconds"] = Value::Null;
    }
    assert_eq!(whole, cut);
}

#[test]
fn a_damaged_checkpoint_or_frame_is_refused_before_any_work() {
    let folder = Folder::with_model();
    kill(&folder, "cut", &[]);
    for (name, message) in [
        ("checkpoint.bin", "the file is cut off or damaged"),
        ("frame_0001.vtu", "frame_0001.vtu is not the frame that this checkpoint was written after"),
        ("frame_0002.vtu", "frame_0002.vtu is not the frame that this checkpoint was written after"),
    ] {
        let file = format!("cut/{name}");
        let whole = folder.read(&file);
        let flipped = |place: usize| {
            let mut bytes = whole.clone();
            bytes[place] ^= 4;
            bytes
        };
        let length = whole.len();
        let damaged = [flipped(length / 3), flipped(length - 50), whole[..100].to_vec(), [&whole[..], b"\n"].concat()];
        for (i, bytes) in damaged.into_iter().enumerate() {
            folder.write(&file, bytes);
            let run = resumed(&folder, "cut", &[]);
            assert!(run.code == 1 && run.stderr.contains(message), "{name} {i}: {} {}", run.code, run.stderr);
            assert!(run.stderr.ends_with("; --force starts the test anew\n"), "{}", run.stderr);
        }
        std::fs::remove_file(folder.path(&file)).unwrap();
        let run = resumed(&folder, "cut", &[]);
        assert!(run.code == 1 && run.stderr.contains(name), "{name}: {}", run.stderr);
        folder.write(&file, whole);
    }
    assert_eq!(resumed(&folder, "cut", &[]).code, 0);
}

/// The bar of 500 flipped bits in every file that is read back; tests/solve/checkpoint.rs flips those of the engine's state.
#[test]
#[ignore = "slow: a thousand runs of the command"]
fn slow_no_flipped_bit_of_a_checkpoint_or_a_frame_is_resumed_from() {
    let folder = Folder::with_model();
    kill(&folder, "cut", &[]);
    for name in ["checkpoint.bin", "frame_0001.vtu"] {
        let file = format!("cut/{name}");
        let whole = folder.read(&file);
        for i in 0..500_u64 {
            let bit = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 8) as usize % (8 * whole.len());
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            folder.write(&file, flipped);
            let run = resumed(&folder, "cut", &[]);
            assert!(run.code == 1 && run.stderr.contains(name), "{name}, bit {bit}: {} {}", run.code, run.stderr);
        }
        folder.write(&file, whole);
    }
    assert_eq!(resumed(&folder, "cut", &[]).code, 0);
}

#[test]
fn a_new_test_takes_the_checkpoint_and_the_frames_of_the_old_one_away() {
    let folder = Folder::with_model();
    kill(&folder, "out", &[]);
    let old = folder.read("out/frame_0002.vtu");
    let mut child = started(&folder, "out", &["--friction", "0.9", "--checkpoint", "1000", "--force"]);
    wait_for(&mut child, || !folder.path("out/checkpoint.bin").exists());
    // The new test may soon write its own.
    wait_for(&mut child, || std::fs::read(folder.path("out/frame_0002.vtu")).ok().as_ref() != Some(&old));
    wait_for(&mut child, || folder.path("out/frame_0001.vtu").exists());
    signal(&child, "-KILL");
    child.wait().unwrap();
    let run = resumed(&folder, "out", &[]);
    assert!(run.code == 1 && run.stderr.contains("there is no out/checkpoint.bin to resume from"), "{}", run.stderr);
}

#[test]
fn a_second_test_in_a_folder_is_refused_at_once_and_the_first_goes_on() {
    let folder = Folder::with_model();
    let mut first = started(&folder, "out", &[]);
    wait_for(&mut first, || folder.path("out/.mesocrete-lock").exists());
    for args in [&["--force"][..], &["--checkpoint", "0", "--force"], &["--resume"], &[]] {
        let run = folder.run(&[&LONG[..], &["-o", "out"], args].concat());
        let message = format!("error: out is in use by process {}; wait until it ends, or name another", first.id());
        assert!(run.code == 1 && run.stderr.starts_with(&message), "{args:?}: {}", run.stderr);
    }
    assert!(first.wait().unwrap().success());
    let names = folder.names_in("out");
    assert!(names.len() >= 8 && names.contains(&"curve.csv".to_owned()), "{names:?}");
}
