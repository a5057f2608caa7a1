//! The flags of meshes and decks, in `pack` and in `mesh`, and what is told of a mesh.

use crate::command::Folder;
use serde_json::Value;

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&folder.read(name)).unwrap()
}

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8(folder.read(name)).unwrap()
}

#[test]
fn one_command_gives_a_compression_deck_of_a_lattice_that_packing_and_meshing_in_turn_give_too() {
    let folder = Folder::with_model();
    let flags = [
        ["--method", "lattice"],
        ["--element-size-mm", "4"],
        ["--analysis", "compression"],
        ["--friction", "0.6"],
        ["--frames", "7"],
    ]
    .concat();
    let flags = [&flags[..], &["--accept-phase-error"]].concat();
    let run = folder.run(&[&["pack", "small.toml", "-o", "once.inp", "-o", "once.json"][..], &flags[..]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("meshed ") && run.stderr.contains("wrote once.inp"), "{}", run.stderr);
    assert_eq!(folder.run(&[&["mesh", "once.json", "-o", "twice.inp"][..], &flags[..]].concat()).code, 0);
    let deck = text(&folder, "once.inp");
    assert_eq!(deck, text(&folder, "twice.inp"));
    assert!(deck.contains("TYPE=C3D4") && deck.contains("TYPE=R3D3") && deck.contains("NUMBER INTERVAL=7\n"));
    assert!(deck.contains("*FRICTION\n0.6,\n"));
}

#[test]
fn the_element_size_is_found_under_its_usual_names() {
    let folder = Folder::with_model();
    for (i, flag) in ["--element-size-mm", "--element-size", "--mesh-size", "--size", "--h"].into_iter().enumerate() {
        let name = format!("{i}.inp");
        let run = folder.run(&["mesh", "small.json", "-o", &name, flag, "4", "--itz", "none"]);
        assert_eq!(run.code, 0, "{flag}: {}", run.stderr);
        assert!(folder.read(&name) == folder.read("0.inp"), "{flag}");
    }
    for (i, flag) in ["--voxel-size-mm", "--voxel-size", "--size", "--h"].into_iter().enumerate() {
        let name = format!("{i}.npy");
        let run = folder.run(&["image", "small.json", "-o", &name, flag, "4"]);
        assert_eq!(run.code, 0, "{flag}: {}", run.stderr);
        assert!(folder.read(&name) == folder.read("0.npy"), "{flag}");
    }
}

#[test]
fn an_analysis_alone_gives_the_deck_that_a_mechanician_would_run() {
    let folder = Folder::with_spec();
    let flags = ["--analysis", "compression", "--element-size-mm", "2", "--summary-json", "s.json"];
    assert_eq!(
        folder
            .run(&["pack", "small.toml", "-qo", "m.json", "--analysis", "compression", "--element-size-mm", "2"])
            .code,
        0
    );
    assert!(json(&folder, "m.json")["spec"]["placement"]["min_gap_mm"].as_f64().unwrap() >= 0.25);
    let run = folder.run(&[&["mesh", "m.json", "-o", "m.inp"][..], &flags].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let told = json(&folder, "s.json");
    let option = |name: &str| told["options"][name].as_str().unwrap().to_owned();
    assert_eq!(["itz", "joined", "volumes"].map(option), ["smeared", "mortar", "exact"]);
    let volume = |of: &str, phase: &str| told["quality"][of][phase].as_f64().unwrap();
    let aggregate = volume("volumes_mm3", "aggregate") / volume("exact_volumes_mm3", "aggregate");
    assert!((aggregate - 1.0).abs() < 0.005, "{aggregate}");
    assert_eq!(told["warnings"], Value::Array(Vec::new()));
    assert!(told["half_strength_strain"].as_f64().unwrap() < 0.06);
    for said in ["times the mass", "double=both", "m_curve.py"] {
        assert!(run.stderr.contains(said), "{said}: {}", run.stderr);
    }
    // Figures that are as they should be were read as alarms: a softening mortar, nodes off a surface that exact volumes move.
    for alarm in ["half its strength", "lie off"] {
        assert!(!run.stderr.contains(alarm), "{alarm}: {}", run.stderr);
    }
    let deck = text(&folder, "m.inp");
    for line in ["*ELEMENT, TYPE=C3D4, ELSET=ITZ", "packing: seed ", "S_N_BOTTOM, S_PLATE_BOTTOM"] {
        assert!(deck.contains(line), "{line}");
    }
    let script = text(&folder, "m_curve.py");
    assert!(script.contains("SENSE = -1.0") && !script.contains('@'), "{script}");
}

#[test]
fn a_script_that_would_be_in_the_way_is_kept_and_named() {
    let folder = Folder::with_model();
    folder.write("m_curve.py", "mine");
    let flags = ["mesh", "small.json", "-o", "m.inp", "--analysis", "tension", "--element-size-mm", "4", "--force"];
    let run = folder.run(&flags);
    assert!(run.code == 1 && run.stderr.contains("m_curve.py is no script of mesocrete"), "{}", run.stderr);
    assert_eq!(text(&folder, "m_curve.py"), "mine");
    assert!(!folder.names().contains(&"m.inp".to_owned()));
}

/// A deck without a test had the script of the deck before it beside it, which reads another job's results.
#[test]
fn a_script_goes_with_the_deck_it_belongs_to() {
    let folder = Folder::with_model();
    let mesh = |output: &str, flags: &[&str]| {
        let common = [
            "mesh",
            "small.json",
            "-o",
            output,
            "--element-size-mm",
            "4",
            "--itz",
            "none",
            "--accept-phase-error",
            "-q",
        ];
        folder.run(&[&common[..], flags].concat())
    };
    for (deck, script) in [("m.inp", "m_curve.py"), ("m.k", "m_binout.py")] {
        assert_eq!(mesh(deck, &["--analysis", "tension"]).code, 0);
        assert!(folder.names().contains(&script.to_owned()));
        std::fs::remove_file(folder.path(deck)).unwrap();
        let run = mesh(deck, &[]);
        let said = format!("{script} is of an earlier {deck}; --force removes it");
        assert!(run.code == 1 && run.stderr.contains(&said), "{}", run.stderr);
        let run = mesh(deck, &["--force"]);
        assert_eq!((run.code, folder.names().contains(&script.to_owned())), (0, false), "{}", run.stderr);
        assert!(run.stderr.contains(&format!("{script} is of the earlier {deck}, and goes with it")), "{}", run.stderr);
        // One that a user wrote stays, and so does that of another deck.
        folder.write(script, "mine");
        assert_eq!(mesh(deck, &["--force"]).code, 0);
        assert_eq!(text(&folder, script), "mine");
        std::fs::remove_file(folder.path(script)).unwrap();
        assert_eq!(mesh(&format!("n{deck}"), &["--analysis", "tension"]).code, 0);
        assert_eq!(mesh(deck, &["--force"]).code, 0);
        assert!(folder.names().contains(&format!("n{script}")));
    }
}

#[test]
fn durations_and_time_increments_can_be_asked_for() {
    let folder = Folder::with_model();
    let flags = [
        "--analysis",
        "tension",
        "--element-size-mm",
        "4",
        "--accept-phase-error",
        "--duration",
        "0.01",
        "--time-increment",
        "2e-7",
    ];
    let run = folder.run(&[&["mesh", "small.json", "-o", "m.inp"][..], &flags].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let deck = text(&folder, "m.inp");
    assert!(deck.contains("\n, 0.01\n") && deck.contains("*FIXED MASS SCALING, DT=2e-7"));
    assert!(run.stderr.contains("explicit steps of 2e-7 s need"), "{}", run.stderr);
    for flag in ["--duration", "--time-increment"] {
        let run = folder.run(&["mesh", "small.json", "-o", "no.inp", flag, "-1"]);
        assert!(run.code == 2 && run.stderr.contains("it must be a positive number"), "{}", run.stderr);
    }
}

#[test]
fn gaps_can_be_asked_for_on_the_command_line() {
    let folder = Folder::with_spec();
    let run = folder.run(&["pack", "small.toml", "-o", "gaps.json", "--min-gap-mm", "0.3", "--wall-gap-mm", "0.2"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let placement = &json(&folder, "gaps.json")["spec"]["placement"];
    assert_eq!((&placement["min_gap_mm"], &placement["wall_gap_mm"]), (&0.3.into(), &0.2.into()));
    let check = folder.run(&["check", "gaps.json"]);
    assert_eq!(check.code, 0, "{}", check.stdout());
    for flag in ["--min-gap-mm", "--wall-gap-mm"] {
        let run = folder.run(&["pack", "small.toml", "-o", "no.json", flag, "-1"]);
        assert!(run.code == 2 && run.stderr.contains(&format!("{flag} is -1")), "{}", run.stderr);
    }
}

#[test]
fn a_mesh_that_cannot_be_is_refused_before_anything_is_packed() {
    let folder = Folder::with_spec();
    for (spec, flags, code, said) in [
        ("small.toml", &["--element-size-mm", "99"][..], 2, "--element-size-mm is 99; it must lie within"),
        (
            "small.toml",
            &["--method", "conforming", "--gmsh", "./no-gmsh"],
            1,
            "./no-gmsh cannot be run (there is no such program)",
        ),
        ("small.toml", &["--periodic-equations"], 2, "--periodic-equations is true; only a box without walls"),
        ("small.toml", &["--materials", "nowhere.toml"], 1, "nowhere.toml: No such file or directory; check the name"),
    ] {
        let run = folder.run(&[&["pack", spec, "-o", "m.inp", "-o", "m.json"], flags].concat());
        assert!(run.code == code && run.stderr.contains(said), "{flags:?}: {} {}", run.code, run.stderr);
        assert!(!run.stderr.contains("packed"), "{}", run.stderr);
    }
    assert_eq!(folder.names(), ["small.toml"]);
}

/// A conforming mesh of grains with dents asked for gmsh first, and refused them when it was there.
#[test]
fn grains_that_are_not_polyhedra_are_refused_by_conforming_meshes_before_gmsh_is_looked_for() {
    let folder = Folder::new();
    let dented = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nv 2 2 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 5\nf 3 4 5\nf 4 2 5\n";
    folder.write("dented.obj", dented);
    for (name, shape, said) in [
        ("ball", "kind = 'sphere'", "spheres and ellipsoids take lattice or voxel"),
        ("dent", "kind = 'library', path = 'dented.obj'", "aggregates with dents take lattice or voxel"),
    ] {
        let spec = format!("fraction = 0.1\nspecimen = {{ kind = 'cube', side_mm = 30 }}\nshape = {{ {shape} }}");
        folder.write(&format!("{name}.toml"), spec);
        let [spec, model] = ["toml", "json"].map(|extension| format!("{name}.{extension}"));
        assert_eq!(folder.run(&["pack", &spec, "-o", &model]).code, 0, "{name}");
        for command in [["pack", &spec, "-o", "m.inp"], ["mesh", &model, "-o", "m.inp"]] {
            let run = folder.run(&[&command[..], &["--method", "conforming", "--gmsh", "./no-gmsh"]].concat());
            assert!(run.code == 2 && run.stderr.contains(said), "{command:?}: {} {}", run.code, run.stderr);
        }
    }
}

#[test]
fn values_that_no_deck_can_hold_are_named() {
    let folder = Folder::with_model();
    for (flag, value, said) in [
        ("--friction", "-0.1", "--friction is -0.1; it must be 0 to 10"),
        ("--strain", "nan", "'--strain <E>': it must be a number, with a point"),
        ("--strain", "0", "--strain is 0; it must lie between 0 and 1"),
        ("--frames", "0", "--frames is 0; it must be 1 or more"),
    ] {
        let run = folder.run(&["mesh", "small.json", "-o", "m.inp", &format!("{flag}={value}")]);
        assert!(run.code == 2 && run.stderr.contains(said), "{}", run.stderr);
    }
    for (line, said) in [
        ("itz_strength_ratio = 1.2", "materials.itz_strength_ratio is 1.2; it must lie above 0 and at most at 1"),
        (
            "mortar_strength = { tensile_mpa = -3 }",
            "materials.mortar_strength.tensile_mpa is -3; it must be a positive",
        ),
        (
            "mortar = { youngs_modulus_mpa = 2e4, poisson_ratio = 0.5, density_t_per_mm3 = 2e-9 }",
            "materials.mortar.poisson_ratio is 0.5; it must lie between -1 and 0.5",
        ),
        ("cohesive_thickness_mm = 200", "materials.cohesive_thickness_mm is 200; it must be below 1.345e2"),
        ("plasticity = { biaxial_ratio = 0.5 }", "materials.plasticity.biaxial_ratio is 0.5; it must be 1 or more"),
        (
            "mortar = { density_t_per_mm3 = 2.4 }",
            "materials.mortar.density_t_per_mm3 is 2.4; it must be 1e-11 to 1e-7 tonne/mm3: 2.4 g/cm3 are 2.4e-9",
        ),
        ("itz_strength_rato = 0.7", "m.toml: line 2: materials.itz_strength_rato is not a known key; did you mean"),
        ("itz_strength_ratio = '0.7'", "m.toml: line 2: materials.itz_strength_ratio is \"0.7\""),
    ] {
        folder.write("m.toml", format!("[materials]\n{line}\n"));
        let run = folder.run(&["mesh", "small.json", "-o", "m.inp", "--materials", "m.toml", "--itz", "cohesive"]);
        assert!(run.code == 2 && run.stderr.contains(said), "{}", run.stderr);
    }
    assert!(!folder.names().contains(&"m.inp".to_owned()));
}

#[test]
fn flags_of_decks_are_refused_if_no_deck_is_written() {
    let folder = Folder::with_model();
    let mesh = ["--element-size-mm", "8", "--accept-phase-error", "--geometry-only"];
    let run = folder.run(&[&["mesh", "small.json", "-qo", "m.vtu"][..], &mesh].concat());
    let said = "error: --geometry-only has no effect: no .inp or .k is written; leave it out\n";
    assert_eq!((run.code, run.stderr.as_str()), (2, said));
    let run = folder.run(&[&["mesh", "small.json", "-qo", "m.inp", "--analysis", "elastic"][..], &mesh].concat());
    assert_eq!((run.code, run.stderr.as_str()), (2, "error: --analysis is elastic; geometry_only leaves it out\n"));
    // An analysis decides the mesh, too: its method, and the treatment of joined aggregates.
    let run = folder.run(&["mesh", "small.json", "-qo", "m.vtu", "--analysis", "elastic", "--accept-phase-error"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
}

#[test]
fn the_time_step_of_cohesive_elements_is_told_beside_that_of_the_others() {
    // 0.1 mm times the root of 2.2e-9 tonne/mm3 over 16,000 MPa.
    let folder = Folder::with_model();
    for (itz, told) in [("cohesive", true), ("none", false)] {
        let run = folder.run(&[
            "mesh",
            "small.json",
            "-fo",
            "m.inp",
            "--element-size-mm",
            "8",
            "--itz",
            itz,
            "--accept-phase-error",
        ]);
        assert_eq!(
            run.stderr.contains("the cohesive elements allow 3.7e-8 s, by their stiffness"),
            told,
            "{}",
            run.stderr
        );
    }
}

#[test]
fn flags_of_other_methods_and_analyses_are_refused() {
    let folder = Folder::with_model();
    let mesh = ["mesh", "small.json", "-fqo", "m.inp", "--element-size-mm", "8", "--accept-phase-error"];
    for (flags, said) in [
        (&["--fit", "plain"][..], "--fit is plain; only the method lattice takes it"),
        (&["--slabs", "2"], "--slabs is 2; only the method conforming takes it"),
        (&["--thin-itz", "--method", "lattice"], "--thin-itz is true; only the method voxel takes it"),
        (&["--thin-itz", "--itz", "none"], "--thin-itz is true; only the itz solid takes it"),
        (&["--subsamples", "2", "--method", "lattice"], "--subsamples is 2; only the method voxel takes it"),
        (&["--narrow-gaps", "split"], "--narrow-gaps is split; only the methods lattice and conforming take it"),
        (&["--volumes", "exact"], "--volumes is exact; only the method conforming and a fitted lattice take it"),
        (&["--reduced-integration", "--method", "lattice"], "--reduced-integration is true; only voxels take it"),
        (&["--strain", "0.002"], "--strain is 0.002; only elastic and tests with a path take it"),
        (&["--friction", "0.6", "--analysis", "tension"], "--friction is 0.6; only tests whose plates rub take it"),
        (&["--frames", "9", "--analysis", "elastic"], "--frames is 9; only a test that breaks, and a striker, take it"),
    ] {
        let run = folder.run(&[&mesh[..], flags].concat());
        assert_eq!((run.code, run.stderr), (2, format!("error: {said}\n")), "{flags:?}");
    }
    let all = ["--subsamples", "2", "--reduced-integration", "--strain", "0.002", "--friction", "0.6", "--frames", "9"];
    let mesh =
        ["mesh", "small.json", "-fqo", "m.inp", "--element-size-mm", "3", "--method", "voxel", "--accept-phase-error"];
    let run = folder.run(&[&mesh[..], &all, &["--analysis", "compression"]].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
}

#[test]
fn the_strength_of_the_itz_is_its_ratio_of_the_mortars() {
    let folder = Folder::with_model();
    let strengths = |ratio: &str| {
        folder.write("m.toml", format!("[materials]\nitz_strength_ratio = {ratio}\n"));
        let run = folder.run(&[
            "mesh",
            "small.json",
            "-fo",
            "m.inp",
            "--element-size-mm",
            "4",
            "--accept-phase-error",
            "--analysis",
            "tension",
            "--materials",
            "m.toml",
        ]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let deck = text(&folder, "m.inp");
        let first = |block: &str| -> f64 { block.lines().nth(1).unwrap().split(',').next().unwrap().parse().unwrap() };
        let of = |name: &str| {
            let material = deck.split("*MATERIAL, NAME=").find(|part| part.starts_with(name)).unwrap();
            first(material.split("*CONCRETE TENSION STIFFENING").nth(1).unwrap())
        };
        [of("ITZ"), of("MORTAR")]
    };
    assert_eq!(strengths("0.5"), [1.7, 3.4]);
    assert_eq!(strengths("0.9"), [3.06, 3.4]);
}

#[test]
fn a_mesh_is_told_with_its_phases_against_the_exact_ones_and_its_bad_elements_by_number() {
    let folder = Folder::with_model();
    let run = folder.run(&[
        "mesh",
        "small.json",
        "-o",
        "m.inp",
        "--method",
        "lattice",
        "--element-size-mm",
        "3",
        "--summary-json",
        "m.json",
    ]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let told = json(&folder, "m.json");
    let quality = &told["quality"];
    let volume = |of: &str, phase: &str| quality[of][phase].as_f64().unwrap();
    for phase in ["aggregate", "itz", "mortar"] {
        let (meshed, exact) = (volume("volumes_mm3", phase), volume("exact_volumes_mm3", phase));
        assert!((meshed / exact - 1.0).abs() < 0.2, "{phase}: {meshed} {exact}");
        let row = run.stderr.lines().find(|line| line.trim_start().starts_with(phase)).expect(phase);
        assert!(row.contains(&format!("{:.5}", meshed / 64_000.0)), "{row}");
        assert!(row.contains(&format!("{:.5}", exact / 64_000.0)), "{row}");
    }
    let bad: Vec<u64> = told["bad_elements"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect();
    let sharp: u64 = quality["dihedral_histogram"].as_array().unwrap()[..4].iter().map(|n| n.as_u64().unwrap()).sum();
    assert!(bad.len() as u64 == sharp && sharp > 0, "thin layers have sharp angles: {sharp}");
    let worst = quality["min_dihedral_deg"][1].as_u64().unwrap() + 1;
    assert!(bad.contains(&worst) && run.stderr.contains(&format!("(element {worst})")), "{}", run.stderr);
    assert!(run.stderr.contains(&format!("(elements {}, {}", bad[0], bad[1])), "{}", run.stderr);
    let deck = text(&folder, "m.inp");
    assert!(deck.lines().any(|line| line.starts_with(&format!("{worst}, ")) && line.split(", ").count() == 5));
}

#[test]
fn elements_too_coarse_for_fibres_and_voids_are_told() {
    let folder = Folder::new();
    let spec = "fraction = 0.1\nspecimen = { kind = \"cube\", side_mm = 30 }\n\
                fibres = { fraction = 0.01, length_mm = 10, diameter_mm = 2 }\n\
                voids = { fraction = 0.01, diameter_mm = [3, 4] }\n";
    folder.write("spec.toml", spec);
    assert_eq!(folder.run(&["pack", "spec.toml", "-o", "model.json"]).code, 0);
    for (size, told) in [("3", true), ("1", false)] {
        let flags =
            ["--method", "lattice", "--itz", "none", "--element-size-mm", size, "--force", "--accept-phase-error"];
        let run = folder.run(&[&["mesh", "model.json", "-o", "mesh.vtu"][..], &flags].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        for name in ["fibres", "voids"] {
            let text = format!("too coarse for the {name}");
            assert_eq!(run.stderr.contains(&text), told, "{size} mm: {}", run.stderr);
        }
        assert!(run.stderr.contains("\n         void  "), "{}", run.stderr);
    }
}

#[test]
fn a_mesh_beyond_the_memory_is_refused_before_it_is_taken() {
    // 150 mm at 0.1 mm ended in an abort: "memory allocation of 13500000000 bytes failed". This takes 3 TB.
    let folder = Folder::new();
    folder.write("big.toml", "fraction = 0.05\n[specimen]\nkind = \"cube\"\nside_mm = 1500.0\n[grading]\nd_min_mm = 100.0\nd_max_mm = 200.0\n");
    let size = ["--element-size-mm", "1.0"];
    for command in
        [&["pack", "big.toml", "-qo", "big.inp", "--method", "lattice"][..], &["solve", "big.toml", "-qo", "out"]]
    {
        let run = folder.run(&[command, &size].concat());
        assert_eq!(run.code, 1, "{}", run.stderr);
        assert!(run.stderr.contains(" GB are free; take --element-size-mm "), "{}", run.stderr);
    }
    assert_eq!(folder.names(), ["big.toml"]);
}

#[test]
fn control_characters_of_keys_are_escaped_on_stderr() {
    // The case trust/escape.toml.
    let folder = Folder::new();
    folder.write("escape.toml", "\"\\u001b[2J\\u001b]0;title\\u0007\" = 1\n");
    for name in ["escape.toml", "\u{1b}[31m.toml"] {
        let run = folder.run(&["pack", name]);
        assert_ne!(run.code, 0);
        let is_plain = |line: &str| !line.contains(char::is_control);
        assert!(run.stderr.lines().all(is_plain) && run.stderr.contains("\\u{1b}["), "{:?}", run.stderr);
    }
    let run = folder.run(&["pack", "--no-\u{1b}[31m"]);
    assert!(run.code == 2 && run.stderr.lines().all(|line| !line.contains(char::is_control)), "{:?}", run.stderr);
}
