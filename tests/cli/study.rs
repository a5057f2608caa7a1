//! Studies by the command: every combination, resumed, with one table.

use crate::command::Folder;

const STUDY: &str = "spec = 'small.toml'\noutputs = ['grains.csv']\n\
[over]\nseed = { from = 1, to = 3 }\nspecimen.side_mm = [30, 40]\n";

/// A folder with a study of six cases.
fn folder(study: &str) -> Folder {
    let folder = Folder::with_spec();
    folder.write("STUDY.toml", study);
    folder
}

/// The rows of the table, without their names.
fn rows(folder: &Folder) -> Vec<Vec<String>> {
    let text = String::from_utf8(folder.read("study/table.csv")).expect("text");
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn cases(folder: &Folder) -> Vec<String> {
    if !folder.path("study").exists() {
        return Vec::new();
    }
    folder.names_in("study").into_iter().filter(|name| name.starts_with("seed-")).collect()
}

#[test]
fn every_combination_has_a_folder_and_a_row() {
    let folder = folder(STUDY);
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("6 of 6 cases done (0 before), 0 failed"), "{}", run.stderr);
    let cases = cases(&folder);
    assert_eq!(cases.len(), 6);
    for case in &cases {
        assert_eq!(folder.names_in(&format!("study/{case}")), ["case.json", "grains.csv", "model.json"]);
    }
    let seeds: Vec<_> = rows(&folder).iter().map(|row| (row[1].clone(), row[2].clone())).collect();
    let expected = [("1", "30"), ("1", "40"), ("2", "30"), ("2", "40"), ("3", "30"), ("3", "40")];
    assert_eq!(seeds, expected.map(|(seed, side)| (seed.to_owned(), side.to_owned())));
    assert!(String::from_utf8(folder.read("study/ensemble.csv")).unwrap().contains(",aggregates,3,"));
    // The same packing as by hand.
    folder.run(&["pack", "small.toml", "--seed", "2", "-o", "two.json"]);
    let case = cases.iter().find(|case| case.starts_with("seed-2_side_mm-40")).expect("the case");
    assert_eq!(folder.read(&format!("study/{case}/model.json")), folder.read("two.json"));
}

#[test]
fn cases_at_the_same_time_leave_the_same_files() {
    let (one, three) = (folder(STUDY), folder(STUDY));
    assert_eq!(one.run(&["study", "STUDY.toml", "-q"]).code, 0);
    assert_eq!(three.run(&["study", "STUDY.toml", "-q", "--jobs", "3"]).code, 0);
    assert_eq!(cases(&one), cases(&three));
    for name in cases(&one) {
        for file in ["case.json", "model.json", "grains.csv"] {
            let file = format!("study/{name}/{file}");
            assert_eq!(one.read(&file), three.read(&file), "{file}");
        }
    }
    for table in ["table.csv", "ensemble.csv"] {
        assert_eq!(one.read(&format!("study/{table}")), three.read(&format!("study/{table}")));
    }
}

#[test]
fn a_torn_case_is_done_again_and_the_others_are_not() {
    let folder = folder(STUDY);
    assert_eq!(folder.run(&["study", "STUDY.toml"]).code, 0);
    let case = &cases(&folder)[3];
    let model = folder.read(&format!("study/{case}/model.json"));
    folder.write(&format!("study/{case}/model.json"), "{");
    let listed = folder.run(&["study", "STUDY.toml", "--dry-run"]);
    let listed = String::from_utf8(listed.stdout).unwrap();
    assert_eq!(listed.lines().filter(|line| line.starts_with("open")).count(), 1, "{listed}");
    let run = folder.run(&["study", "STUDY.toml"]);
    assert!(run.stderr.contains("6 of 6 cases done (5 before)"), "{}", run.stderr);
    assert_eq!(folder.read(&format!("study/{case}/model.json")), model);
}

#[test]
fn meshes_and_their_figures_are_of_each_case() {
    let study = "[spec]\nfraction = 0.2\nspecimen = { kind = 'cube', side_mm = 24 }\n[spec.grading]\nd_max_mm = 10\n\
        [mesh]\nmethod = 'voxel'\nitz = 'none'\noutput = 'mesh.inp'\n[over]\nmesh.element-size-mm = [2, 3]\nseed = [4]\n";
    let folder = folder(study);
    let run = folder.run(&["study", "STUDY.toml", "-q"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    let names = folder.names_in("study").into_iter().filter(|name| name.starts_with("element-size-mm-"));
    let names: Vec<_> = names.collect();
    assert_eq!(names.len(), 2);
    assert_eq!(folder.names_in(&format!("study/{}", names[0])), ["case.json", "mesh.inp", "mesh.json", "model.json"]);
    let text = String::from_utf8(folder.read("study/table.csv")).unwrap();
    assert!(text.lines().next().unwrap().contains(",mesh."), "{text}");
}

#[test]
fn a_case_that_fails_is_kept_with_its_message() {
    // Gaps as wide as grains: found out when the specimen is packed.
    let study = "spec = 'small.toml'\n[over]\nplacement.min_gap_mm = [0, 9]\n";
    let folder = folder(study);
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("1 of 2 cases done (0 before), 1 failed; --retry-failed"), "{}", run.stderr);
    assert!(run.stderr.contains("warning: min_gap_mm-9_"), "{}", run.stderr);
    let again = folder.run(&["study", "STUDY.toml"]);
    assert!(again.stderr.contains("1 of 2 cases done (2 before), 1 failed"), "{}", again.stderr);
    let retried = folder.run(&["study", "STUDY.toml", "--retry-failed"]);
    assert!(retried.stderr.contains("1 of 2 cases done (1 before), 1 failed"), "{}", retried.stderr);
}

#[test]
fn force_runs_every_case_again_and_nothing_else_does() {
    let folder = folder("spec = 'small.toml'\n[over]\nseed = [1, 2]\n");
    assert_eq!(folder.run(&["study", "STUDY.toml", "-q"]).code, 0);
    let record = format!("study/{}/case.json", cases(&folder)[0]);
    let right = folder.read(&record);
    let marked = [right.as_slice(), b"\n"].concat();
    folder.write(&record, &marked);
    let again = folder.run(&["study", "STUDY.toml"]);
    assert!(again.stderr.contains("(2 before)") && folder.read(&record) == marked, "{}", again.stderr);
    let forced = folder.run(&["study", "STUDY.toml", "--force"]);
    assert!(forced.stderr.contains("2 of 2 cases done (0 before)"), "{}", forced.stderr);
    assert_eq!(folder.read(&record), right);
}

#[cfg(unix)]
#[test]
fn a_killed_study_loses_the_case_in_hand_at_most() {
    let study = "spec = 'small.toml'\n[over]\nseed = { from = 1, to = 30 }\n";
    let (killed, straight) = (folder(study), folder(study));
    assert_eq!(straight.run(&["study", "STUDY.toml", "-q"]).code, 0);
    for wait in [100, 400, 250, 900, 300, 600] {
        let mut child = killed.command(&["study", "STUDY.toml", "-q"]).spawn().expect("it starts");
        std::thread::sleep(std::time::Duration::from_millis(wait));
        child.kill().expect("a kill");
        child.wait().expect("an end");
        let open =
            cases(&killed).iter().filter(|case| !killed.path(&format!("study/{case}/case.json")).exists()).count();
        assert!(open <= 1, "{open} cases without a record");
    }
    assert_eq!(killed.run(&["study", "STUDY.toml", "-q"]).code, 0);
    assert_eq!(cases(&killed).len(), 30);
    for name in cases(&killed) {
        for file in ["case.json", "model.json"] {
            let file = format!("study/{name}/{file}");
            assert_eq!(killed.read(&file), straight.read(&file), "{file}");
        }
        assert_eq!(killed.names_in(&format!("study/{name}")), ["case.json", "model.json"]);
    }
}

#[test]
fn wrong_studies_are_refused_before_the_work() {
    for (study, expected) in [
        ("[over]\nseed = 3\n", "STUDY.toml: over.seed is 3; give a list, e.g. [3], or { from = 1, to = 20 }"),
        ("[over]\nseed = []\n", "STUDY.toml: over.seed has no values"),
        ("[over]\nfraction = [0.3, 1.5]\n", "STUDY.toml: case fraction = 1.5: fraction is 1.5"),
        ("recipe = 'rve-61'\n", "STUDY.toml: there is no recipe \"rve-61\""),
        ("[over]\nmesh.itz = ['none']\n", "over.mesh.itz changes [mesh], which is not there"),
        ("[mesh]\nitz = 'none'\n", "STUDY.toml: [mesh] the following required arguments were not provided"),
        ("[mesh]\noutput = 'a.inp'\nelements = 3\n", "STUDY.toml: [mesh] unexpected argument '--elements' found"),
        ("[mesh]\noutput = '../a.inp'\n", "[mesh] output has \"../a.inp\"; it must be the name of a file"),
        ("[solve]\nresume = true\n", "[solve] resume is set by the study; remove it"),
        ("outputs = ['a.png7']\n", "outputs has \"a.png7\"; it must end in one of .json"),
        ("oops = 1\n", "oops"),
    ] {
        let folder = folder(study);
        let run = folder.run(&["study", "STUDY.toml"]);
        assert_eq!(run.code, 2, "{study}{}", run.stderr);
        assert!(run.stderr.contains(expected), "{study}{}", run.stderr);
        assert!(!folder.path("study").exists(), "{study}");
    }
}

#[test]
fn tests_of_a_study_are_in_the_table() {
    let study = "recipe = 'paper-compression'\n".to_owned()
        + "[solve]\nelement-size-mm = 6\nframes = 1\nstrain = 0.001\n\
           [over]\nspecimen.side_mm = [40]\nseed = [1, 2]\nsolve.friction = [0.0, 0.3]\n";
    let folder = folder(&study);
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let text = String::from_utf8(folder.read("study/table.csv")).unwrap();
    assert!(text.lines().next().unwrap().contains(",solve.peak_mpa,"), "{text}");
    assert_eq!(text.lines().count(), 5);
}
