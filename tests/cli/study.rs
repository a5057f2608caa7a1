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
    // A packing by hand has equal bytes.
    folder.run(&["pack", "small.toml", "--seed", "2", "-o", "two.json"]);
    let case = cases.iter().find(|case| case.starts_with("seed-2_side_mm-40")).expect("the case");
    assert_eq!(folder.read(&format!("study/{case}/model.json")), folder.read("two.json"));
}

#[test]
fn fields_of_strengths_are_repetitions_beside_packings_and_the_ensemble_splits_their_scatter() {
    let study = "spec = 'small.toml'\nmodel = 'none'\n[over]\nseed = [1, 2]\nsolve.materials.scatter.seed = [1, 5]\n\
                 [solve]\nelement-size-mm = 5\nstrain = 0.002\nframes = 0\naccept-phase-error = true\n\
                 [solve.materials.scatter]\ncoefficient_of_variation = 0.2\ncorrelation_length_mm = 20\n";
    let folder = folder(study);
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let table = String::from_utf8(folder.read("study/ensemble.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let names = ["figure", "n", "mean", "std", "cv", "low", "high", "needed"];
    let parts = ["std_packing", "std_packing_error", "std_material", "std_material_error"];
    assert_eq!(rows[0], [&names[..], &parts[..]].concat());
    let of = |figure: &str| rows.iter().find(|row| row[0] == figure).unwrap_or_else(|| panic!("{figure} of {table}"));
    // Fields leave the packing as it is.
    let by_material = |figure: &str| of(figure)[10].parse::<f64>().unwrap();
    assert!(of("fraction")[1] == "4" && by_material("fraction") < 1e-9, "{:?}", of("fraction"));
    assert!(by_material("solve.peak_mpa") > 0.5, "{:?}", of("solve.peak_mpa"));
}

#[test]
fn effective_properties_are_columns() {
    let study = "spec = 'small.toml'\n[effective]\nwhat = 'all'\nvoxel-size-mm = 5\nno-fields = true\nphases = 'p.toml'\n\
                 [over]\nseed = [1, 2]\neffective.axes = ['x', 'xz']\n";
    let folder = folder(study);
    folder.write("p.toml", "[diffusivity]\nitz = 5\n");
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let table = String::from_utf8(folder.read("study/table.csv")).unwrap();
    let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| {
        let place = names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{name} of {names:?}"));
        rows(&folder).into_iter().map(|row| row[place].clone()).collect::<Vec<_>>()
    };
    let along_x = column("effective.diffusivity.tensor.xx");
    assert!(
        along_x.iter().all(|value| value.parse::<f64>().unwrap() > 0.3)
            && along_x[0] == along_x[2]
            && along_x[0] != along_x[1]
    );
    assert_eq!(column("effective.diffusivity.tensor.zz")[0], "");
    assert!(column("effective.stiffness.isotropic.youngs_modulus_mpa")[0].parse::<f64>().unwrap() > 20_000.0);
    assert!(names.contains(&"effective.stiffness.tensor.xx_yy") && names.contains(&"effective.conductivity.error.xx"));
    // Other values are another case.
    folder.write("p.toml", "[diffusivity]\nitz = 6\n");
    let again = folder.run(&["study", "STUDY.toml", "--dry-run"]);
    assert_eq!(String::from_utf8_lossy(&again.stdout).matches("open").count(), 4, "{}", again.stderr);
    for (table, said) in [
        ("axes = 'xx'", "some of x, y, z"),
        ("output = 'a'", "is set by the study"),
        ("periodic = 'x'", "label volumes"),
    ] {
        folder.write("STUDY.toml", format!("spec = 'small.toml'\n[effective]\n{table}\n"));
        let run = folder.run(&["study", "STUDY.toml"]);
        assert!(run.code == 2 && run.stderr.contains(said), "{}", run.stderr);
    }
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
    assert_eq!(run.code, 1, "{}", run.stderr);
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
fn a_kill_loses_the_case_in_hand_at_most() {
    let study = "spec = 'small.toml'\n[over]\nseed = { from = 1, to = 30 }\n";
    let (killed, straight) = (folder(study), folder(study));
    assert_eq!(straight.run(&["study", "STUDY.toml", "-q"]).code, 0);
    for (kills, wait) in [100, 400, 250, 900, 300, 600].into_iter().enumerate() {
        let mut child = killed.command(&["study", "STUDY.toml", "-q"]).spawn().expect("it starts");
        std::thread::sleep(std::time::Duration::from_millis(wait));
        child.kill().expect("a kill");
        child.wait().expect("an end");
        let open =
            cases(&killed).iter().filter(|case| !killed.path(&format!("study/{case}/case.json")).exists()).count();
        // A case that a killed process had in hand comes last.
        assert!(open <= kills + 1, "{open} cases without a record");
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
        ("[over]\nseed = 3\n", "STUDY.toml: line 2: over.seed is 3; give a list, e.g. [3], or { from = 1, to = 20 }"),
        ("[over]\nseed = []\n", "STUDY.toml: line 2: over.seed has no values"),
        ("[over]\nfraction = [0.3, 1.5]\n", "STUDY.toml: line 2: case fraction = 1.5: fraction is 1.5"),
        ("recipe = 'rve-61'\n", "STUDY.toml: there is no recipe \"rve-61\""),
        ("[over]\nmesh.itz = ['none']\n", ": mesh.itz changes [mesh], which is not there"),
        ("[mesh]\nitz = 'none'\n", "STUDY.toml: [mesh] output is missing; name the files of the mesh, e.g. mesh.inp"),
        ("[mesh]\noutput = 'a.inp'\nelements = 3\n", "[mesh] elements is not known; "),
        ("[mesh]\noutput = '../a.inp'\n", "[mesh] output has \"../a.inp\"; it must be the name of a file"),
        (
            "outputs = ['a\\u0000.csv']\n".replace('\'', "\"").leak(),
            "outputs has \"a\\0.csv\"; it must be the name of a file",
        ),
        ("[solve]\nresume = true\n", "[solve] resume is set by the study; remove it"),
        (
            "[solve]\nmin-gap-mm = 1.0\n",
            "[solve] min_gap_mm is of the packing, which the study makes; give --min-gap-mm",
        ),
        ("outputs = ['a.png7']\n", "outputs has \"a.png7\"; it must end in one of .json"),
        ("oops = 1\n", "oops"),
        ("[solve]\ntest = 'a.toml'\n", "a.toml: No such file or directory; check the name and the folder"),
        (
            "[solve]\ntest = { test = 'tension', kind = 'shear' }\n",
            "STUDY.toml: line 2: [solve] test names its test twice: test and kind are two words for one thing",
        ),
        (
            "[over]\nseed = [1]\n[zip]\nseed = [2]\n",
            "STUDY.toml: line 2: seed is given twice in over, zip and draw; keep one",
        ),
        ("[test]\nkind = 'cyclic'\n", "test is the test of [solve], which must be there"),
        ("[test]\npressure = 1\n[solve]\n", "[test] pressure is not a known key"),
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
        + "[solve]\nelement-size-mm = 6\naccept-phase-error = true\nframes = 1\nstrain = 0.001\n\
           [over]\nspecimen.side_mm = [40]\nseed = [1, 2]\nsolve.friction = [0.0, 0.3]\n";
    let folder = folder(&study);
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let text = String::from_utf8(folder.read("study/table.csv")).unwrap();
    assert!(text.lines().next().unwrap().contains(",solve.peak_mpa,"), "{text}");
    assert_eq!(text.lines().count(), 5);
}

#[test]
fn keys_of_a_test_file_are_axes_of_a_study() {
    let study = "test = 'press.toml'\n".to_owned()
        + &tiny_then(
            "[solve]\nelement-size-mm = 5\naccept-phase-error = true\nframes = 0\nlaw = 'elastic'\n[over]\ntest.pressure_mpa = [1.0, 2.0]\n",
        );
    let folder = folder(&study);
    folder.write("press.toml", "kind = 'triaxial'\nhistory = 'path.csv'\nduration_s = 2e-4\n");
    folder.write("path.csv", "strain\n5e-5\n0\n");
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let peak = |case: &String| {
        let record: serde_json::Value =
            serde_json::from_slice(&folder.read(&format!("study/{case}/case.json"))).unwrap();
        record["results"]["solve"]["peak_mpa"].as_f64().unwrap()
    };
    let names = folder.names_in("study").into_iter().filter(|name| name.starts_with("pressure_mpa-"));
    let peaks: Vec<f64> = names.map(|name| peak(&name)).collect();
    assert!(peaks.len() == 2 && (peaks[0] - peaks[1]).abs() > 0.5, "{peaks:?}");
}

/// The case: decks of a study had packings without gaps, other than those of `pack --analysis`.
#[test]
fn packings_of_a_study_keep_the_gaps_that_its_deck_or_its_test_needs() {
    let gap = |section: &str, flags: &[&str]| {
        let folder = folder(&tiny_then(&format!("{section}[over]\nseed = [1]\n")));
        let run = folder.run(&[&["study", "STUDY.toml"], flags].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let model = folder.read(&format!("study/{}/model.json", cases(&folder)[0]));
        let model: serde_json::Value = serde_json::from_slice(&model).unwrap();
        model["spec"]["placement"]["min_gap_mm"].as_f64().unwrap_or(0.0)
    };
    let deck = "[mesh]\noutput = 'm.inp'\nelement-size-mm = 2\nanalysis = 'elastic'\naccept-phase-error = true\n";
    assert_eq!(gap(deck, &[]), 1.0);
    assert_eq!(gap(deck, &["--min-gap-mm", "0.5"]), 0.5);
    assert_eq!(gap("[mesh]\noutput = 'm.msh'\nitz = 'none'\naccept-phase-error = true\n", &[]), 0.0);
}

/// A cube that packs at once, with `rest` behind it.
fn tiny(rest: &str) -> String {
    format!(
        "{rest}\n[spec]\nfraction = 0.2\n[spec.specimen]\nkind = 'cube'\nside_mm = 20\n[spec.grading]\nd_min_mm = 5\nd_max_mm = 8\n"
    )
}

/// Sections behind the spec of [`tiny`].
fn tiny_then(sections: &str) -> String {
    tiny("") + sections
}

/// The shared case study_errors_unseen.toml: kinetic energy of 92 %, yet done, exit 0 and no column of errors.
#[test]
fn a_test_with_errors_fails_its_case() {
    let solve = "[solve]\nelement-size-mm = 4\naccept-phase-error = true\nframes = 1\nduration = 1e-5\n";
    let folder = folder(&tiny_then(&format!("{solve}[over]\nseed = [1, 2]\n")));
    let run = folder.run(&["study", "STUDY.toml"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("0 of 2 cases done (0 before), 2 failed"), "{}", run.stderr);
    let text = String::from_utf8(folder.read("study/table.csv")).unwrap();
    assert!(text.lines().next().unwrap().ends_with(",status,warnings,error"), "{text}");
    assert!(rows(&folder).iter().all(|row| row[2] == "failed" && row.concat().contains("kinetic energy")), "{text}");
    // Every line of a case names it.
    for (case, lines) in
        cases(&folder).iter().map(|case| (case, run.stderr.lines().filter(|line| line.contains(case.as_str()))))
    {
        assert!(
            lines.clone().any(|line| line.starts_with(&format!("error: {case}: the kinetic energy"))),
            "{}",
            run.stderr
        );
    }
    let is_said = |line: &str| !line.starts_with("error: ") || line.starts_with("error: seed-");
    assert!(run.stderr.lines().all(is_said), "{}", run.stderr);
    // The figures that the errors are about stay in the case's folder.
    assert!(folder.names_in(&format!("study/{}", cases(&folder)[0])).contains(&"result.json".to_owned()));
}

#[test]
fn one_case_with_errors_among_others_fails_the_study() {
    let solve = "[solve]\nelement-size-mm = 4\naccept-phase-error = true\nframes = 1\nstrain = 0.0005\n[over]\nsolve.duration = [1e-5, 0.01]\n";
    let folder = folder(&tiny_then(solve));
    let run = folder.run(&["study", "STUDY.toml", "--jobs", "2"]);
    let statuses: Vec<_> = rows(&folder).iter().map(|row| row[2].clone()).collect();
    assert_eq!((run.code, statuses), (1, vec!["failed".to_owned(), "done".to_owned()]), "{}", run.stderr);
}

#[test]
fn a_strict_mesh_that_is_coarse_fails_its_case() {
    let mesh = "[mesh]\noutput = 'm.inp'\nelement-size-mm = 4\naccept-phase-error = true\nitz = 'none'\n";
    for (strict, code, status) in [("strict = true\n", 1, "failed"), ("", 0, "done")] {
        let folder = folder(&tiny_then(&format!("{mesh}{strict}")));
        let run = folder.run(&["study", "STUDY.toml"]);
        let row = rows(&folder).remove(0);
        assert_eq!((run.code, row[1].as_str()), (code, status), "{}", run.stderr);
        assert!(strict.is_empty() || row.concat().contains("where [mesh] strict allows 1 %"), "{row:?}");
        assert!(strict.is_empty() || row.concat().contains("of its exact volume"), "the warning is a column: {row:?}");
        let is_named = |line: &&str| line.starts_with("warning: ");
        assert!(run.stderr.lines().filter(is_named).all(|line| line.contains(&row[0])), "{}", run.stderr);
    }
}

#[test]
fn warnings_of_a_spec_are_a_column() {
    let folder = folder(&tiny_then("[spec.placement]\nstrategy = 'rearrange'\nattempts = 7\n"));
    assert_eq!(folder.run(&["study", "STUDY.toml"]).code, 0);
    assert!(String::from_utf8(folder.read("study/table.csv")).unwrap().contains("attempts count for the strategy"));
}

/// The shared case study_outputs_lost.toml: files overwrote and deleted each other, and the case was done.
#[test]
fn files_of_a_case_that_would_overwrite_each_other_are_refused_before_the_first_case() {
    let solve = "[solve]\nelement-size-mm = 4\n";
    for (outputs, sections, expected) in [
        ("'curve.csv'", solve, "outputs has \"curve.csv\", which [solve] writes, too"),
        ("'a.csv', 'a.csv'", "", "outputs has \"a.csv\", which outputs writes, too"),
        ("'a.csv', 'A.CSV'", "", "outputs has \"A.CSV\", which outputs writes, too"),
        ("'frame_0009.vtu'", solve, "outputs has \"frame_0009.vtu\", which [solve] writes, too"),
        ("'frame_+9.vtu'", solve, "which [solve] writes, too"),
        ("'result.json'", solve, "which [solve] writes, too"),
        ("'Model.json'", "", "outputs has \"Model.json\", which the study writes, too"),
        ("'mesh.json'", "[mesh]\noutput = 'm.inp'\n", "which the study writes, too"),
        ("'m.vtu'", "[mesh]\noutput = 'm.vtu'\n", "[mesh] output has \"m.vtu\", which outputs writes, too"),
        ("'m_3.vtu'", "[mesh]\noutput = 'm.pvtu'\n", "which outputs writes, too"),
        ("", "[mesh]\noutput = ['m.vtu', 'M.vtu']\n", "[mesh] output has \"M.vtu\""),
        ("", &format!("[mesh]\noutput = 'frame_0001.vtu'\n{solve}"), "[mesh] output has \"frame_0001.vtu\""),
        ("", &format!("[mesh]\noutput = 'frame.pvtu'\n{solve}"), "which [solve] writes, too"),
        (
            "",
            "[mesh]\noutput = 'a.vtu'\n[over]\nmesh.output = [['b.vtu'], ['b.vtu', 'b.vtu']]\n",
            "[mesh] output has \"b.vtu\"",
        ),
    ] {
        let folder = folder(&tiny_then(sections).replacen('\n', &format!("outputs = [{outputs}]\n"), 1));
        for words in [&["study", "STUDY.toml"][..], &["study", "STUDY.toml", "--dry-run"]] {
            let run = folder.run(words);
            assert_eq!(run.code, 2, "{outputs} {sections}: {}", run.stderr);
            assert!(run.stderr.contains(expected), "{outputs} {sections}: {}", run.stderr);
            assert!(!folder.path("study").exists(), "{outputs} {sections}");
        }
    }
}

/// The shared case study_runs_a_program.toml, and other ways to write it.
#[cfg(unix)]
#[test]
fn a_study_file_runs_no_program() {
    use std::os::unix::fs::PermissionsExt;
    let conforming = "output = 'm.inp'\nmethod = 'conforming'\n";
    for sections in [
        format!("[mesh]\n{conforming}gmsh = './x.sh'\n"),
        "[solve]\nmethod = 'conforming'\ngmsh = './x.sh'\n".to_owned(),
        format!("[mesh]\n{conforming}\"gmsh=./x.sh\" = true\n"),
        format!("[mesh]\n{conforming}\"gmsh=./x.sh --a\" = true\n"),
        format!("[mesh]\n{conforming}[over]\nmesh.gmsh = ['./x.sh']\n"),
        format!("[mesh]\n{conforming}gmsh = ['./x.sh']\n"),
        format!("[mesh]\n{conforming}GMSH = './x.sh'\n"),
        "[solve]\nmethod = 'conforming'\n\"gmsh=./x.sh\" = true\n".to_owned(),
    ] {
        let folder = folder(&tiny_then(&sections));
        folder.write("x.sh", "#!/bin/sh\ntouch \"$(dirname \"$0\")/it-ran\"\n");
        std::fs::set_permissions(folder.path("x.sh"), std::fs::Permissions::from_mode(0o755)).unwrap();
        for words in [&["study", "STUDY.toml"][..], &["study", "STUDY.toml", "--dry-run"]] {
            let run = folder.run(words);
            assert_eq!(run.code, 2, "{sections}: {}", run.stderr);
            assert!(!folder.path("it-ran").exists(), "{sections}");
        }
    }
    // The command line may name one.
    let folder = folder(&tiny_then(&format!("[mesh]\n{conforming}")));
    folder.write("x.sh", "#!/bin/sh\ntouch \"$(dirname \"$0\")/it-ran\"\n");
    std::fs::set_permissions(folder.path("x.sh"), std::fs::Permissions::from_mode(0o755)).unwrap();
    folder.run(&["study", "STUDY.toml", "--dry-run", "--gmsh", "./x.sh"]);
    assert!(folder.path("it-ran").exists());
}

/// The shared case study_two_processes.py: 6 of 8 pairs had false failures. Processes of one study share its cases.
#[test]
fn two_processes_in_one_folder_share_the_cases_and_other_work_is_refused() {
    let study = "spec = 'small.toml'\noutputs = ['g.csv']\n[over]\nseed = { from = 1, to = 25 }\n";
    let (twice, straight) = (folder(study), folder(study));
    assert_eq!(straight.run(&["study", "STUDY.toml", "-q"]).code, 0);
    let mut first = twice.command(&["study", "STUDY.toml", "-q"]).spawn().expect("it starts");
    while cases(&twice).is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let second = twice.run(&["study", "STUDY.toml", "-q", "--force"]);
    assert_eq!(second.code, 1, "{}", second.stderr);
    assert!(second.stderr.starts_with("error: study is in use by "), "{}", second.stderr);
    // The tables of a running study can be had at any time.
    assert!(twice.run(&["study", "STUDY.toml", "-q", "--collect"]).code <= 1);
    for more in [&[][..], &["--retry-failed"], &["--jobs", "2"], &["--dry-run"]] {
        assert_eq!(twice.run(&[&["study", "STUDY.toml", "-q"][..], more].concat()).code, 0);
    }
    assert!(first.wait().expect("an end").success());
    assert_equal(&twice, &straight, &["case.json", "model.json", "g.csv"]);
}

/// Compares files of every case, and the tables.
fn assert_equal(found: &Folder, right: &Folder, files: &[&str]) {
    for name in cases(right) {
        for file in files {
            let file = format!("study/{name}/{file}");
            assert_eq!(found.read(&file), right.read(&file), "{file}");
        }
    }
    for table in ["study/table.csv", "study/ensemble.csv"] {
        assert_eq!(found.read(table), right.read(table), "{table}");
    }
}

/// An array of 8 tasks over 12 cases: the tasks as a scheduler starts them, some killed, all submitted again, collected.
#[test]
fn an_array_with_killed_tasks_leaves_the_bytes_of_the_serial_study() {
    let study = "spec = 'small.toml'\n[over]\nseed = { from = 1, to = 12 }\n";
    let (array, straight) = (folder(study), folder(study));
    straight.run(&["study", "STUDY.toml", "-q"]);
    let task = |number: usize| array.command(&["study", "STUDY.toml", "-q", "--shard", &format!("{number}/8")]);
    // One is lost before it begins, so that cases are left however fast the others are.
    for number in (1..=8).filter(|number| *number != 5) {
        let mut child = task(number).spawn().expect("it starts");
        if number % 3 == 0 {
            std::thread::sleep(std::time::Duration::from_millis(30));
            let _ = child.kill();
        }
        child.wait().expect("an end");
    }
    let left = array.run(&["study", "STUDY.toml", "--collect"]);
    assert!(
        left.code == 1 && left.stderr.contains("cases are left; the command without --collect does them"),
        "{}",
        left.stderr
    );
    let times = |folder: &Folder| -> Vec<_> {
        let time =
            |name: &String| std::fs::metadata(folder.path(&format!("study/{name}/case.json"))).ok()?.modified().ok();
        cases(&straight).iter().map(time).collect()
    };
    let before = times(&array);
    let mut again: Vec<_> = (1..=8).map(|number| task(number).spawn().expect("it starts")).collect();
    assert!(again.iter_mut().all(|child| child.wait().expect("an end").success()));
    let after = times(&array);
    assert!(
        before.iter().zip(&after).all(|(before, after)| before.is_none() || before == after),
        "nothing is done twice"
    );
    assert!(!array.path("study/.mesocrete-lock").exists());
    assert_eq!(array.run(&["study", "STUDY.toml", "-q", "--collect"]).code, 0);
    assert_equal(&array, &straight, &["case.json", "model.json"]);
}

/// Processes at the same time, some killed, started again: one file of records and the tables, whoever did which case.
#[test]
fn records_in_one_file_have_the_bytes_of_one_process_and_the_tables_of_folders() {
    let study = "spec = 'small.toml'\noutputs = ['g.csv']\n[over]\nseed = { from = 1, to = 12 }\n";
    let (array, straight, folders) = (folder(study), folder(study), folder(study));
    folders.run(&["study", "STUDY.toml", "-q"]);
    let flags = ["study", "STUDY.toml", "-q", "--layout", "table"];
    assert_eq!(straight.run(&flags).code, 0);
    for kills in [true, false] {
        let mut tasks: Vec<_> = (0..4).map(|_| array.command(&flags).spawn().expect("it starts")).collect();
        if kills {
            std::thread::sleep(std::time::Duration::from_millis(30));
            tasks.iter_mut().take(3).for_each(|task| drop(task.kill()));
        }
        let ends: Vec<bool> = tasks.iter_mut().map(|task| task.wait().expect("an end").success()).collect();
        assert!(ends[3] && (kills || ends[0]), "{ends:?}");
    }
    let files = ["ensemble.csv", "records.jsonl", "table.csv"];
    assert_eq!(
        (array.names_in("study"), straight.names_in("study")),
        (files.map(str::to_owned).into(), files.map(str::to_owned).into())
    );
    for file in files.map(|name| format!("study/{name}")) {
        assert!(array.read(&file) == straight.read(&file), "{file}");
        assert!(file.contains("records") || array.read(&file) == folders.read(&file), "{file}");
    }
    // The same command without the flag goes on there; the flag changes no study that has begun.
    let again = array.run(&["study", "STUDY.toml"]);
    assert!(again.code == 0 && again.stderr.contains("12 of 12 cases done (12 before)"), "{}", again.stderr);
    assert!(String::from_utf8(array.run(&["study", "STUDY.toml", "--dry-run"]).stdout).unwrap().starts_with("done"));
    for (folder, layout) in [(&array, "folders"), (&folders, "table")] {
        let refused = folder.run(&["study", "STUDY.toml", "--layout", layout]);
        assert!(refused.code == 1 && refused.stderr.contains("leave the layout out"), "{}", refused.stderr);
    }
}

#[test]
fn a_case_runs_alone_by_its_number_and_leaves_the_tables_to_others() {
    let folder = folder("spec = 'small.toml'\n[over]\nseed = [1, 2, 3]\n");
    let output = folder.run(&["study", "STUDY.toml", "--case", "2"]);
    assert!(output.code == 0 && output.stderr.contains("1 of 1 cases done"), "{}", output.stderr);
    let listed = String::from_utf8(folder.run(&["study", "STUDY.toml", "--dry-run"]).stdout).expect("text");
    let states: Vec<&str> = listed.lines().map(|line| line.split(' ').next().unwrap_or_default()).collect();
    assert_eq!(states, ["open", "done", "open"]);
    assert!(!folder.path("study/table.csv").exists());
    for (flag, value, said) in [
        ("--case", "4", "--case is 4; it must lie within 1 and 3"),
        ("--shard", "0/3", "0/3 must be K/N, whole numbers with K from 1 to N, as 3/40"),
        ("--shard", "4/3", "4/3 must be K/N"),
        ("--shard", "3", "3 must be K/N"),
    ] {
        let output = folder.run(&["study", "STUDY.toml", flag, value]);
        assert!(output.code == 2 && output.stderr.contains(said), "{}", output.stderr);
    }
}

#[test]
fn a_slurm_script_runs_the_tasks_of_its_array() {
    let folder =
        folder(&tiny("[mesh]\noutput = 'm.msh'\nitz = 'none'\naccept-phase-error = true\n[over]\nseed = [1, 2, 3]\n"));
    let flags = ["-o", "a study", "--slurm=2", "--threads", "3", "--min-gap-mm", "0.1"];
    let script = folder.run(&[&["study", "STUDY.toml"][..], &flags].concat()).stdout;
    let script = String::from_utf8(script).expect("text");
    assert!(script.starts_with("#!/bin/bash\n# 3 cases by 2 tasks."), "{script}");
    for line in ["#SBATCH --array=1-2\n", "#SBATCH --cpus-per-task=3\n", "#SBATCH --requeue\n", "#SBATCH --mem="] {
        assert!(script.contains(line), "{script}");
    }
    // The case: effective properties had no part in the memory, so that each task was killed again.
    let fine = "[effective]\nvoxel_size_mm = 0.2\n[over]\nseed = [1]\n";
    let megabytes = |sections: &str| -> f64 {
        let script = self::folder(&tiny(sections)).run(&["study", "STUDY.toml", "--slurm"]).stdout;
        let script = String::from_utf8(script).expect("text");
        script.split("--mem=").nth(1).and_then(|text| text.split('M').next()).expect("a size").parse().expect("MB")
    };
    assert!(megabytes(fine) > 100.0 + megabytes("[over]\nseed = [1]\n"));
    let refused = folder.run(&["study", "-", "--slurm"]);
    assert!(refused.code == 2, "{}", refused.stderr);
    // A stand-in of Slurm: bash, and the number of the task.
    let mesocrete = std::path::Path::new(env!("CARGO_BIN_EXE_mesocrete")).parent().expect("a folder");
    let path = format!("{}:{}", mesocrete.display(), std::env::var("PATH").unwrap_or_default());
    folder.write("study.sbatch", &script);
    if cfg!(unix) {
        for task in ["1", "2"] {
            let mut bash = std::process::Command::new("bash");
            bash.arg("study.sbatch").current_dir(folder.path("")).env("PATH", &path).env("SLURM_ARRAY_TASK_ID", task);
            let output = bash.output().expect("bash");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        let collected = folder.run(&["study", "STUDY.toml", "-o", "a study", "--min-gap-mm", "0.1", "--collect"]);
        assert!(collected.code == 0 && collected.stderr.contains("3 of 3 cases done"), "{}", collected.stderr);
    }
}

#[test]
fn a_changed_file_of_materials_changes_the_cases_that_use_it() {
    let study = "[solve]\nelement-size-mm = 5\nmaterials = 'a.toml'\n[over]\nsolve.materials = ['a.toml', 'b.toml']\n";
    let folder = folder(&tiny_then(study));
    folder.write("a.toml", "[materials.mortar]\nyoungs_modulus_mpa = 25000\n");
    folder.write("b.toml", "[materials.mortar]\nyoungs_modulus_mpa = 26000\n");
    let names = || -> Vec<String> {
        let listed = folder.run(&["study", "STUDY.toml", "--dry-run"]);
        assert_eq!(listed.code, 0, "{}", listed.stderr);
        String::from_utf8(listed.stdout).unwrap().lines().map(str::to_owned).collect()
    };
    let before = names();
    folder.write("b.toml", "[materials.mortar]\nyoungs_modulus_mpa = 27000\n");
    let after = names();
    assert_eq!(before[0], after[0]);
    assert_ne!(before[1], after[1]);
}

/// The audit of new features: a study kept the results of an old TEST.toml, and of materials in a list of one.
#[test]
fn a_changed_test_file_beside_a_study_changes_the_cases_that_use_it() {
    let study = "[solve]\nelement-size-mm = 5\ntest = 'T.TOML'\nmaterials = ['a.toml']\n[over]\nsolve.test = ['T.TOML', 'tension']\n";
    let folder = folder("");
    std::fs::create_dir(folder.path("sub")).unwrap();
    folder.write("sub/STUDY.toml", tiny_then(study));
    folder.write("sub/T.TOML", "kind = 'compression'\n");
    folder.write("sub/a.toml", "[materials.mortar]\nyoungs_modulus_mpa = 25000\n");
    let names = || -> Vec<String> {
        let listed = folder.run(&["study", "sub/STUDY.toml", "--dry-run"]);
        assert_eq!(listed.code, 0, "{}", listed.stderr);
        String::from_utf8(listed.stdout).unwrap().lines().map(str::to_owned).collect()
    };
    let before = names();
    folder.write("sub/T.TOML", "kind = 'compression'\nramp = 0.2\n");
    let after = names();
    assert!(before[0] != after[0] && before[1] == after[1], "{before:?} {after:?}");
    folder.write("sub/a.toml", "[materials.mortar]\nyoungs_modulus_mpa = 26000\n");
    let last = names();
    assert!(after[0] != last[0] && after[1] != last[1], "{after:?} {last:?}");
}

/// The case: the table that a TEST.toml of `[solve] test` names was no part of the case, so that old results were kept.
#[test]
fn a_changed_table_of_a_test_file_changes_the_cases_that_use_it() {
    let study =
        "[solve]\nelement-size-mm = 5\ntest = 'tests/T.toml'\n[over]\nsolve.test = ['tests/T.toml', 'tension']\n";
    let folder = folder(&tiny_then(study));
    std::fs::create_dir(folder.path("tests")).unwrap();
    folder.write("tests/T.toml", "kind = 'cyclic'\nhistory = 'turns.csv'\nexpansion = { mortar = 'dry.csv' }\n");
    folder.write("tests/dry.csv", "time,strain\n28,-1e-4\n");
    folder.write("tests/turns.csv", "strain\n0.002\n0.001\n0.003\n");
    let names = || -> Vec<String> {
        let listed = folder.run(&["study", "STUDY.toml", "--dry-run"]);
        assert_eq!(listed.code, 0, "{}", listed.stderr);
        String::from_utf8(listed.stdout).unwrap().lines().map(str::to_owned).collect()
    };
    let before = names();
    folder.write("tests/turns.csv", "strain\n0.002\n0.001\n0.004\n");
    let after = names();
    assert!(before[0] != after[0] && before[1] == after[1], "{before:?} {after:?}");
    folder.write("tests/dry.csv", "time,strain\n28,-2e-4\n");
    let drier = names();
    assert!(drier[0] != after[0] && drier[1] == after[1], "{drier:?} {after:?}");
}

#[test]
fn a_study_on_standard_output_is_refused_and_makes_no_folder() {
    let folder = Folder::new();
    folder.write("study.toml", "spec = { fraction = 0.1 }\n");
    let run = folder.run(&["study", "study.toml", "-o", "-"]);
    let said = "error: --output - is standard output, but a study writes many files; name a folder\n";
    assert_eq!((run.code, run.stderr.as_str()), (2, said));
    assert_eq!(folder.names(), ["study.toml"]);
}

/// A study in a pipe said nothing for five minutes.
#[test]
fn a_study_in_a_pipe_says_how_many_cases_it_has() {
    let folder = Folder::new();
    folder.write(
        "S.toml",
        "[spec]\nspecimen = { kind = \"cube\", side_mm = 40 }\nfraction = 0.2\n[over]\nseed = [1, 2]\n",
    );
    let run = folder.run(&["study", "S.toml"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.starts_with("study of 2 cases, 0 done before\n"), "{}", run.stderr);
    let again = folder.run(&["study", "S.toml"]).stderr;
    assert!(!again.contains("study of"), "nothing is left to do: {again}");
}

#[test]
fn drawn_and_zipped_options_of_listed_specs_are_cases() {
    let study = "spec = ['small.toml', 'other.toml']\nmodel = 'json.gz'\n[zip]\nspecimen.side_mm = [30, 40]\n\
        itz.thickness_mm = [[0.1, 0.2], [0.3, 0.4]]\n\
        [draw]\ncases = 2\ndesign = 'latin-hypercube'\n[draw.over]\nfraction = { low = 0.1, high = 0.2 }\n";
    let folder = folder(study);
    folder.write("other.toml", "fraction = 0.1\n[specimen]\nkind = 'cube'\nside_mm = 35\n[grading]\nd_max_mm = 8\n");
    let run = folder.run(&["study", "STUDY.toml"]);
    assert!(run.stderr.contains("8 of 8 cases done"), "{}", run.stderr);
    let table = String::from_utf8(folder.read("study/table.csv")).unwrap();
    assert!(table.starts_with("case,spec,itz.thickness_mm,specimen.side_mm,fraction,seed,"), "{table}");
    let cases = folder.names_in("study").into_iter().filter(|name| name.starts_with("spec-"));
    for case in cases {
        assert_eq!(folder.names_in(&format!("study/{case}")), ["case.json", "model.json.gz"]);
    }
    let again = folder.run(&["study", "STUDY.toml"]);
    assert!(again.stderr.contains("8 of 8 cases done (8 before)"), "{}", again.stderr);
}

#[test]
fn a_study_without_models_keeps_none() {
    let folder = folder(&format!(
        "model = 'none'\n{STUDY}[mesh]\noutput = 'mesh.vtu'\nelement-size-mm = 5\naccept-phase-error = true\n"
    ));
    let run = folder.run(&["study", "STUDY.toml"]);
    assert!(run.stderr.contains("6 of 6 cases done"), "{}", run.stderr);
    for case in cases(&folder) {
        assert_eq!(folder.names_in(&format!("study/{case}")), ["case.json", "grains.csv", "mesh.json", "mesh.vtu"]);
    }
    assert!(folder.run(&["study", "STUDY.toml"]).stderr.contains("(6 before)"));
}

#[test]
fn wrong_draws_and_lists_of_a_study_are_named() {
    for (text, message) in [
        ("spec = ['a/s.toml', 'small.toml']\n", "a/s.toml"),
        ("[zip]\nseed = [1, 2]\nfraction = [0.1]\n", "zip.fraction has 1 values and zip.seed has 2"),
        ("[draw]\ncases = 0\n", "draw.cases is 0; it must lie within 1 and 1000000"),
        ("[draw]\ncases = 2\n[draw.over]\nfraction = 0.2\n", "draw.over.fraction is 0.2; give a range"),
        ("spec = []\n", "spec lists no file"),
        ("model = 'xml'\n", "json.gz"),
    ] {
        let run = folder(text).run(&["study", "STUDY.toml"]);
        // A file that is not there is no wrong usage.
        let code = if text.contains("a/s.toml") { 1 } else { 2 };
        assert_eq!((run.code, run.stderr.contains(message)), (code, true), "{text}: {}", run.stderr);
    }
}

#[test]
fn a_data_set_names_the_package_that_makes_it() {
    let folder = Folder::with_spec();
    let run = folder.run(&["dataset", "small.toml", "-n", "2"]);
    assert!(run.code == 2 && run.stderr.contains("pip install mesocrete, and run its mesocrete"), "{}", run.stderr);
}

#[test]
fn a_study_on_dask_names_the_package_that_does_it_and_the_line_of_python() {
    let folder = folder(STUDY);
    let run = folder.run(&["study", "STUDY.toml", "-o", "s", "--dask", "tcp://10.0.0.1:8786"]);
    let line = r#"mc.study("STUDY.toml", out="s", executor=Client("tcp://10.0.0.1:8786"))"#;
    assert!(run.code == 2 && run.stderr.contains(line), "{}", run.stderr);
    assert!(!folder.path("s").exists());
}
