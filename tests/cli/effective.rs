//! `mesocrete effective`: files of a result, and what cannot be asked.

use crate::command::Folder;

/// Elements that are large for the grains keep a test quick.
const ACCEPT: &str = "--accept-phase-error";

#[test]
fn a_property_is_written_as_figures_page_and_fields() {
    let folder = Folder::with_model();
    let run = folder.run(&["effective", "small.json", "--voxel-size-mm", "4", "--axes", "xz", "-o", "out"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.starts_with("diffusivity: x 0."), "{}", run.stderr);
    let figures: serde_json::Value = serde_json::from_slice(&folder.read("out/effective.json")).unwrap();
    assert_eq!(figures["voxels"], serde_json::json!([10, 10, 10]));
    assert!(figures["tensor"][1][1].is_null() && figures["tensor"][2][2].as_f64().unwrap() > 0.0);
    // Phases that a packing does not have had a volume of -0.
    let shares = figures["phases"].as_array().unwrap().iter().map(|phase| phase["volume_fraction"].as_f64().unwrap());
    assert!(shares.into_iter().all(f64::is_sign_positive), "{figures}");
    let page = String::from_utf8(folder.read("out/effective.html")).unwrap();
    assert_eq!(page.matches("<img").count(), 2);
    assert!(folder.read("out/diffusivity_z.vti").starts_with(b"<?xml"));
    assert!(!folder.path("out/diffusivity_y.vti").exists());
    let again = folder.run(&["effective", "small.json", "-o", "out"]);
    assert_eq!(again.code, 1, "{}", again.stderr);
    assert!(again.stderr.contains("effective.json exists; --force replaces it"), "{}", again.stderr);
}

/// The fields of an earlier run were found only after all solutions (review of the first version).
#[test]
fn an_existing_field_is_refused_before_the_model_is_read() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("out")).unwrap();
    for property in ["diffusivity", "conductivity"] {
        let field = format!("out/{property}_z.vti");
        folder.write(&field, "mine");
        let run = folder.run(&["effective", "missing.json", "--what", property, "-o", "out"]);
        assert_eq!((run.code, folder.read(&field)), (1, b"mine".to_vec()));
        assert!(run.stderr.contains(&format!("{property}_z.vti exists; --force replaces it")), "{}", run.stderr);
    }
    let run = folder.run(&["effective", "missing.json", "--axes", "xy", "-o", "out"]);
    assert!(run.stderr.contains("missing.json"), "fields that are not asked for do not matter: {}", run.stderr);
}

/// A refused run left an empty folder behind (review of the first version).
#[test]
fn a_refused_run_leaves_no_folder() {
    let folder = Folder::with_model();
    for flags in [&["missing.json"][..], &["small.json", "--voxel-size-mm", "30"]] {
        let run = folder.run(&[&["effective"], flags, &["-o", "new"]].concat());
        assert!(run.code > 0 && !folder.path("new").exists(), "{}", run.stderr);
    }
    let run = folder.run(&["effective", "small.json", "-o", "no/new"]);
    assert!(run.code == 1 && run.stderr.contains("no/new"), "{}", run.stderr);
}

#[test]
fn phases_come_from_a_file_and_all_properties_into_one_list() {
    let folder = Folder::with_model();
    folder.write("phases.toml", "[diffusivity]\nmortar = 2\naggregate = 2\n");
    let flags =
        ["--what", "all", "--phases", "phases.toml", "--voxel-size-mm", "5", "--axes", "x", "--no-fields", "-q"];
    let run = folder.run(&[&["effective", "small.json"][..], &flags].concat());
    // Eight voxels along a side leave the conductivity of contrast 2 to 3 uncertain.
    let remark =
        "the upper Hashin-Shtrikman bound, 0.44 % from the conductivity along x, is within its error of 4.95 %";
    let size = "halve the voxel size";
    let said = format!("warning: the error along x is above 2 %; {size}\nwarning: {remark}; {size}\n");
    assert_eq!((run.code, run.stderr), (0, said));
    assert!(String::from_utf8(folder.read("out/effective.html")).unwrap().contains(remark));
    let found: serde_json::Value = serde_json::from_slice(&folder.read("out/effective.json")).unwrap();
    assert!((found[0]["tensor"][0][0].as_f64().unwrap() - 2.0).abs() < 1e-6);
    assert_eq!((&found[1]["what"], &found[2]["what"]), (&"conductivity".into(), &"stiffness".into()));
}

#[test]
fn tetrahedra_are_written_as_figures_page_and_grids() {
    let folder = Folder::with_model();
    let flags = ["--what", "all", "--method", "lattice", "--element-size-mm", "3", "--axes", "x"];
    let run = folder.run(&[&["effective", "small.json", "-o", "out"][..], &flags].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let found: serde_json::Value = serde_json::from_slice(&folder.read("out/effective.json")).unwrap();
    assert!(found[0]["elements"].as_u64().unwrap() > 5000 && found[0]["voxels"].is_null());
    assert_eq!(found[2]["element_size_mm"], serde_json::json!(3.0));
    let page = String::from_utf8(folder.read("out/effective.html")).unwrap();
    assert_eq!(page.matches("<img").count(), 8);
    assert!(page.contains("tetrahedra of 3 mm; ends of x, y, z"), "{page}");
    for field in ["diffusivity_x", "conductivity_x", "stiffness_xy"] {
        assert!(folder.read(&format!("out/{field}.vtu")).starts_with(b"<?xml"));
    }
    let coarse = folder.run(&["effective", "small.json", "--method", "lattice", "--element-size-mm", "5", "-f"]);
    assert_eq!(coarse.code, 2);
    assert!(coarse.stderr.contains("in the packing; take smaller elements, or the method voxel"), "{}", coarse.stderr);
}

#[test]
fn stiffness_and_expansion_are_written_with_their_bounds() {
    let folder = Folder::with_model();
    folder.write("phases.toml", "[stiffness.aggregate]\nyoungs_modulus_mpa = 40000\n");
    let flags =
        ["--what", "stiffness", "--phases", "phases.toml", "--voxel-size-mm", "4", "--eigenstrain", "mortar=-4e-4"];
    let run = folder.run(&[&["effective", "small.json"][..], &flags].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.starts_with("stiffness: E ") && run.stderr.contains("free strain x -"), "{}", run.stderr);
    let found: serde_json::Value = serde_json::from_slice(&folder.read("out/effective.json")).unwrap();
    let (bulk, bounds) = (&found["isotropic"]["bulk_modulus_mpa"], &found["bounds"]["bulk_modulus_mpa"]);
    assert!(bulk.as_f64() > bounds["reuss"].as_f64() && bulk.as_f64() < bounds["voigt"].as_f64());
    let page = String::from_utf8(folder.read("out/effective.html")).unwrap();
    assert!(page.contains("Young's modulus: ") && page.contains("Strain of the free specimen"));
    assert_eq!(page.matches("<img").count(), 6);
    // The mean of the stresses for a strain along x is the first column.
    let field = folder.read("out/stiffness_xx.vti");
    let start = field.len() - 28 - 24_000;
    let stress = |voxel: usize| f32::from_le_bytes(field[start + 24 * voxel..][..4].try_into().unwrap());
    let mean = (0..1000).map(|voxel| f64::from(stress(voxel))).sum::<f64>() / 1000.0;
    assert!((mean / found["fine"][0][0].as_f64().unwrap() - 1.0).abs() < 1e-5, "{mean}");
}

/// A text as `.vti` of 4 x 4 x 8 voxels: two layers across z.
fn layers() -> String {
    let labels = "0 ".repeat(64) + &"9 ".repeat(64);
    format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 4 0 4 0 8\" Spacing=\"0.5 0.5 0.5\"><CellData>\
         <DataArray type=\"Int32\" Name=\"a\" format=\"ascii\">{labels}</DataArray></CellData></ImageData></VTKFile>"
    )
}

#[test]
fn a_label_volume_takes_values_by_label() {
    let folder = Folder::new();
    folder.write("scan.vti", layers());
    folder.write("p.toml", "[diffusivity]\n0 = 1.0\n9 = 3.0\n[stiffness.0]\nyoungs_modulus_mpa = 20000\n[stiffness.9]\nyoungs_modulus_mpa = 20000\n");
    let flags = ["--phases", "p.toml", "--eigenstrain", "0=1e-4,9=1e-4", "--periodic", "xy"];
    let run = folder.run(&[&["effective", "scan.vti", "--what", "stiffness"][..], &flags].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.starts_with("stiffness: E 20000 +- 0 MPa, nu 0.2000") && run.stderr.contains("x 1.000e-4"));
    let run = folder.run(&["effective", "scan.vti", "--phases", "p.toml", "-o", "flux"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let found: serde_json::Value = serde_json::from_slice(&folder.read("flux/effective.json")).unwrap();
    assert!((found["tensor"][0][0].as_f64().unwrap() - 2.0).abs() < 1e-6);
    assert!((found["tensor"][2][2].as_f64().unwrap() - 1.5).abs() < 1e-6);
    assert_eq!((&found["phases"][1]["name"], &found["voxel_size_mm"][0]), (&"9".into(), &0.5.into()));
}

#[test]
fn an_image_of_a_model_has_the_values_of_its_phases() {
    let folder = Folder::with_model();
    let image = folder.run(&["image", "small.json", "-o", "labels.tif", "--voxel-size-mm", "2"]);
    assert_eq!(image.code, 0, "{}", image.stderr);
    let run = folder.run(&["effective", "labels.tif", "--axes", "x", "--no-fields", "-q"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let found: serde_json::Value = serde_json::from_slice(&folder.read("out/effective.json")).unwrap();
    let value = found["fine"][0][0].as_f64().unwrap();
    assert!(value > 0.3 && value < found["bounds"]["hashin_shtrikman_upper"].as_f64().unwrap(), "{found}");
    assert_eq!(found["voxels"], serde_json::json!([20, 20, 20]));
}

#[test]
fn a_label_volume_that_cannot_be_solved_is_refused() {
    let folder = Folder::with_model();
    folder.write("scan.vti", layers());
    folder.write("bad.npy", "no array");
    folder.write("p.toml", "[diffusivity]\n0 = 1.0\n");
    for (code, flags, said) in [
        (2, &["scan.vti"][..], "label 9 has no value; give it in [diffusivity] of a phases file, as in 9 = 1.0"),
        (2, &["scan.vti", "--phases", "p.toml"], "label 9 has no value"),
        (
            2,
            &["small.json", "--periodic", "x"],
            "--periodic is x; a model's specimen has its own periods; only label volumes take it",
        ),
        (1, &["scan.vti", "--array", "b"], "scan.vti: it has no array `b` of one value a voxel; take one of `a`"),
        (2, &["small.json", "--array", "a"], "--array is a; a model has no arrays: leave it out, or take a .vti"),
        (1, &["bad.npy"], "bad.npy: this is not a file of numpy.save"),
        (1, &["missing.tif"], "missing.tif"),
    ] {
        let run = folder.run(&[&["effective"], flags].concat());
        assert_eq!(run.code, code, "{flags:?}: {}", run.stderr);
        assert!(run.stderr.contains(said) && !folder.path("out").exists(), "{flags:?}: {}", run.stderr);
    }
}

#[test]
fn refusals_name_the_flag_and_the_range() {
    let folder = Folder::with_model();
    folder.write("bad.toml", "[diffusivity]\nmortar = 0\n");
    folder.write("unknown.toml", "[diffusivity]\nstone = 0\n");
    for (flags, said) in [
        (&["--voxel-size-mm", "0"][..], "--voxel-size-mm is 0; it must be a positive number"),
        (&["--voxel-size-mm", "1e300"], "--voxel-size-mm is 1e300; it must be at most 10 mm"),
        (&["--voxel-size-mm", "30"], "--voxel-size-mm is 30; it must be at most 10 mm"),
        (&["--method", "conforming"], "--method is conforming; it must be voxel or lattice"),
        (&["--method", "lattice", "--voxel-size-mm", "2"], "--voxel-size-mm is 2; only the method voxel takes it"),
        (&["--element-size-mm", "2"], "--element-size-mm is 2; only the method lattice takes it"),
        (&["--method", "lattice", "--element-size-mm", "30"], "--element-size-mm is 30; it must be 0.04 to 10 mm"),
        (&["--boundary", "uniform"], "[possible values: fixed, uniform-gradient, uniform-flux]"),
        (&["--boundary", "uniform-flux"], "--boundary is uniform-flux; voxels have fixed; take the method lattice"),
        (
            &["--what", "stiffness", "--boundary", "uniform-flux", "--method", "lattice"],
            "--boundary is uniform-flux; stiffness takes fixed",
        ),
        (&["--tolerance", "0.1"], "--tolerance is 0.1; it must be 1e-13 to 0.01"),
        (&["--what", "stiffness", "--tolerance", "0"], "--tolerance is 0; it must be 1e-13 to 0.01"),
        (&["--what", "strength"], "[possible values: diffusivity, conductivity, stiffness, permeability, all]"),
        (&["--what", "stiffness", "--axes", "x"], "--axes is x; stiffness takes all, xyz"),
        (&["--eigenstrain", "mortar=-4e-4"], "--eigenstrain is mortar=-4e-4; only stiffness has strains"),
        (
            &["--what", "stiffness", "--eigenstrain", "stone=1e-4"],
            "--eigenstrain is stone=1e-4; its phases must be mortar",
        ),
        (&["--what", "stiffness", "--eigenstrain", "mortar"], "it must be a phase and a strain"),
        (&["--what", "stiffness", "--eigenstrain", "mortar=0.2"], "stiffness.mortar.eigenstrain is 0.2"),
        (&["--frame", "peak"], "--frame is peak; only the folder of a test has frames; name the one that"),
        (&["--crack-roughness", "0.5"], "--crack-roughness is 0.5; only the folder of a test has frames"),
        (&["--frame", "middle"], "it must be peak, last, all, the number of a frame from 1, or a strain below 1"),
        (&["--axes", "xx"], "it must be some of x, y, z, each once"),
        (&["--phases", "bad.toml"], "diffusivity.mortar is 0; it must be 1e-30 to 1e30"),
        (&["--phases", "unknown.toml"], "stone"),
    ] {
        let run = folder.run(&[&["effective", "small.json"][..], flags].concat());
        assert_eq!(run.code, 2, "{flags:?}: {}", run.stderr);
        assert!(run.stderr.contains(said), "{flags:?}: {}", run.stderr);
    }
}

/// Issue 69, after the crack: the properties of a specimen in a frame of its test.
#[test]
fn a_frame_of_a_test_has_the_properties_of_its_cracks() {
    let folder = Folder::with_model();
    let test = ["--test", "tension", "--element-size-mm", "4", "--strain", "0.002", "--frames", "4", "-q", ACCEPT];
    let run = folder.run(&[&["solve", "small.json", "-o", "run"][..], &test].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let ask = |flags: &[&str]| {
        let run = folder.run(&[&["effective", "run", "-o", "out", "--force"][..], flags].concat());
        assert_eq!(run.code, 0, "{flags:?}: {}", run.stderr);
        let figures: serde_json::Value = serde_json::from_slice(&folder.read("out/effective.json")).unwrap();
        (figures, run.stderr)
    };
    let value = |figures: &serde_json::Value, axis: usize| figures["tensor"][axis][axis].as_f64().unwrap();
    let (last, said) = ask(&["--frame", "last", "--what", "permeability"]);
    assert!(said.starts_with("frame 4, strain 0.00200: permeability x "), "{said}");
    assert_eq!((&last["frame"], &last["what"]), (&serde_json::json!(4), &serde_json::json!("permeability")));
    // The specimen is torn apart: the opening is its elongation, and z is the axis across the crack. Means over both axes of a rough
    // crack in coarse elements; a bar of 2 mm had 0.97.
    let cubic = 0.08_f64.powi(3) / (12.0 * 40.0);
    let along = f64::midpoint(value(&last, 0), value(&last, 1));
    assert!((0.6..1.4).contains(&(along / cubic)) && value(&last, 2) < 1e-2 * along, "{along:e} {cubic:e} {last}");
    assert!(folder.read("out/permeability_x.vtu").starts_with(b"<?xml"));
    assert_eq!(String::from_utf8(folder.read("out/effective.html")).unwrap().matches("<img").count(), 3);
    let flags = ["--what", "diffusivity", "--axes", "x", "--no-fields"];
    let (third, _) = ask(&[&["--frame", "3"][..], &flags].concat());
    let (by_strain, _) = ask(&[&["--frame", "0.00148"][..], &flags].concat());
    assert_eq!((value(&third, 0), &by_strain["frame"]), (value(&by_strain, 0), &serde_json::json!(3)));
    let (dry, _) = ask(&[&["--frame", "3", "--crack-diffusivity", "0"][..], &flags].concat());
    assert!(value(&dry, 0) < value(&third, 0), "water in the cracks conducts");
    // The strain's peak lies before the first frame.
    let (_, said) = ask(&flags);
    assert!(
        said.contains("warning: frame 1, the nearest to the peak, has ") && said.contains("more --frames"),
        "{said}"
    );
    let (all, _) = ask(&[&["--frame", "all"][..], &flags].concat());
    let frames: Vec<u64> = all.as_array().unwrap().iter().map(|of| of["frame"].as_u64().unwrap()).collect();
    assert_eq!(frames, [1, 2, 3, 4]);
    let table = String::from_utf8(folder.read("out/effective.csv")).unwrap();
    assert!(table.starts_with("frame,strain,stress_mpa,diffusivity_x,diffusivity_x_error\n1,0.000"), "{table}");
    assert_eq!(table.lines().count(), 5);
    assert_eq!(String::from_utf8(folder.read("out/effective.html")).unwrap().matches("<svg").count(), 2);
    // The constants are those of the test. z lies across the crack.
    let modulus = |frame: &str| {
        let (found, said) = ask(&["--what", "stiffness", "--frame", frame, "--axes", "xz"]);
        assert!(said.starts_with(&format!("frame {frame}, strain 0.00")) && said.contains("modulus x "), "{said}");
        [0, 2].map(|axis| found["youngs_modulus_mpa"][axis].as_f64().unwrap())
    };
    let [[x, z], [torn_x, torn_z]] = ["1", "4"].map(modulus);
    assert!((20_000.0..35_000.0).contains(&x) && z > 1.5 * torn_z && torn_x > 0.7 * x, "{x} {z} {torn_x} {torn_z}");
    for (flags, said) in [
        (&["--frame", "9"][..], "--frame is 9; the test has frames 1 to 4"),
        (&["--frame", "0.5"], "--frame is 0.5; the frames reach a strain of 0.00200"),
        (&["--method", "lattice"], "--method is lattice; a frame has the mesh of its test; leave it out"),
        (&["--voxel-size-mm", "1"], "--voxel-size-mm is 1; a frame has the mesh of its test"),
        (&["--crack-roughness", "2", "--what", "permeability"], "--crack-roughness is 2; it must be 0 to 1"),
        (&["--crack-diffusivity", "-1"], "--crack-diffusivity is -1; it must be 0 to 1000000"),
        (&["--boundary", "uniform-flux"], "--boundary is uniform-flux"),
    ] {
        let run = folder.run(&[&["effective", "run", "-o", "new"][..], flags].concat());
        assert!(
            run.code == 2 && run.stderr.contains(said) && !folder.path("new").exists(),
            "{flags:?}: {}",
            run.stderr
        );
    }
}

#[test]
fn a_folder_without_frames_or_with_foreign_ones_is_refused_by_name() {
    let folder = Folder::with_model();
    let refused = |said: &str| {
        let run = folder.run(&["effective", "run", "-o", "new"]);
        assert!(run.code > 0 && run.stderr.contains(said) && !folder.path("new").exists(), "{said}: {}", run.stderr);
    };
    std::fs::create_dir(folder.path("run")).unwrap();
    refused("result.json: there is no such file; name a folder that `mesocrete solve -o run` wrote");
    folder.write("run/result.json", "{}");
    refused("result.json: it is no result of `mesocrete solve`: missing field");
    let test =
        ["solve", "small.json", "-o", "run", "--element-size-mm", "5", "--strain", "0.0005", "-q", "--force", ACCEPT];
    let solve = |more: &[&str]| assert_eq!(folder.run(&[&test[..], more].concat()).code, 0);
    solve(&["--frames", "0"]);
    refused("--frame is peak; the test has no frames; solve it again with --frames 20");
    solve(&["--frames", "1", "--itz", "cohesive"]);
    refused("cohesive faces, and its frames have no openings of them; solve it with --itz solid, smeared or none");
    solve(&["--frames", "1"]);
    let frame = folder.read("run/frame_0001.vtu");
    std::fs::remove_file(folder.path("run/frame_0001.vtu")).unwrap();
    refused("frame_0001.vtu");
    folder.write("run/frame_0001.vtu", &frame[..frame.len() - 200]);
    refused("is damaged; solve the test again");
    folder.write("run/frame_0001.vtu", {
        let at = frame.windows(12).position(|window| window == b"crack_strain").unwrap();
        [&frame[..at], b"crack_strait", &frame[at + 12..]].concat()
    });
    refused("it has no array crack_strain; solve the test again with this version");
    folder.write("run/frame_0001.vtu", "<VTKFile>");
    refused("it is no grid of mesocrete's own");
    // The same mesh at the same strain, pressed between rougher plates.
    let other = |friction: &str| {
        let rest = ["-o", "other", "--frames", "1", "--friction", friction];
        assert_eq!(folder.run(&[&test[..2], &rest[..], &test[4..]].concat()).code, 0);
        folder.read("other/frame_0001.vtu")
    };
    folder.write("run/frame_0001.vtu", other("0.4"));
    refused("frame_0001.vtu: it is a frame of another test, or it was changed; solve the test again");
    folder.write("run/frame_0001.vtu", other("0.1"));
    assert_eq!(folder.run(&["effective", "run", "-qo", "twin"]).code, 0);
    let result = String::from_utf8(folder.read("run/result.json")).unwrap();
    folder.write("run/frame_0001.vtu", &frame);
    let seal = result[..result.find("\"seal\"").unwrap()].rfind(',').unwrap();
    let end = seal + 1 + result[seal + 1..].find([',', '}']).unwrap();
    folder.write("run/result.json", format!("{}{}", &result[..seal], &result[end..]));
    refused("frame_0001.vtu: the results of this test have no seal of it; solve the test again with this version");
    let elements = result.find("\"elements\": ").unwrap() + 12;
    folder.write("run/result.json", format!("{}1{}", &result[..elements], &result[elements..]));
    refused("cells, and those of this test have 1");
}

/// Fields of other properties lay beside the figures of a result that had none of them.
#[test]
fn fields_of_a_result_go_when_another_replaces_it() {
    let folder = Folder::with_model();
    let run = |flags: &[&str]| {
        let run = folder.run(&[&["effective", "small.json", "--voxel-size-mm", "8", "-qo", "out"][..], flags].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let mut names: Vec<String> = std::fs::read_dir(folder.path("out"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    assert_eq!(run(&["--what", "all"]).len(), 2 + 6 + 6);
    folder.write("out/notes.vti", "mine");
    let left = run(&["--axes", "z", "-f"]);
    assert_eq!(left, ["diffusivity_z.vti", "effective.html", "effective.json", "notes.vti"]);
    assert_eq!(run(&["--no-fields", "-f"]), ["effective.html", "effective.json", "notes.vti"]);
}
