//! The command without the feature `gpu`: no device but this processor, and the remedy.

use crate::command::Folder;

#[test]
fn a_command_without_devices_refuses_one_in_one_line_before_anything_is_packed() {
    let folder = Folder::with_spec();
    for name in ["gpu", "opencl:0", "abacus"] {
        let run = folder.run(&["solve", "small.toml", "--device", name]);
        assert_eq!((run.code, run.stderr.lines().count()), (2, 1), "{}", run.stderr);
        assert!(run.stderr.contains(&format!("--device {name}: ")), "{}", run.stderr);
        assert!(run.stderr.contains("--features gpu") && run.stderr.contains("the device cpu"), "{}", run.stderr);
        assert_eq!(folder.names(), ["small.toml"]);
    }
    let run = folder.run(&["devices", "--check"]);
    assert!(run.code == 0 && run.stdout().is_empty(), "{}", run.stderr);
    assert!(run.stderr.starts_with("no device: ") && run.stderr.contains("--features gpu"), "{}", run.stderr);
}
