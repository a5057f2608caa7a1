//! The same spec and seed give the same files, whatever the threads, the place, the language.

use crate::command::Folder;

const OUTPUTS: [&str; 5] = ["model.json", "model.vtu", "model.stl", "model.csv", "model.inp"];

fn pack(change: impl Fn(&mut std::process::Command), extra: &[&str]) -> Vec<Vec<u8>> {
    let folder = Folder::with_spec();
    let outputs = OUTPUTS.iter().flat_map(|name| ["-o", name]);
    let args: Vec<&str> = ["pack", "small.toml"].into_iter().chain(outputs).chain(extra.iter().copied()).collect();
    let mut command = folder.command(&args);
    change(&mut command);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    OUTPUTS.map(|name| folder.read(name)).into()
}

#[test]
fn files_are_the_same_on_1_2_and_4_threads() {
    let one = pack(|_| (), &["--threads", "1"]);
    for threads in ["2", "4"] {
        let other = pack(|_| (), &["--threads", threads]);
        for ((name, one), other) in OUTPUTS.iter().zip(&one).zip(&other) {
            assert!(one == other, "{name} differs between 1 and {threads} threads");
        }
    }
}

#[test]
fn files_are_the_same_in_any_language() {
    let german = pack(
        |command| {
            command.env("LC_ALL", "de_DE.UTF-8").env("LANG", "de_DE.UTF-8");
        },
        &[],
    );
    assert!(german == pack(|_| (), &[]));
}

#[test]
fn another_seed_gives_another_packing() {
    assert!(pack(|_| (), &["--seed", "2"])[0] != pack(|_| (), &[])[0]);
}
