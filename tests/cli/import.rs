//! `mesocrete import`: from a label volume to a test of its specimen.

use crate::command::Folder;

/// Two balls that touch, and one that a face of the volume cuts.
const THREE: [([f64; 3], f64); 3] = [([8.0, 8.0, 9.0], 6.0), ([16.0, 15.0, 14.0], 6.2), ([24.0, 5.0, 17.0], 5.0)];

/// Labels of `count` voxels along each axis as numpy saves them; that of the k-th ball is k + 1.
fn balls(folder: &Folder, name: &str, count: usize, balls: &[([f64; 3], f64)]) {
    let labels: Vec<u8> = (1..).take(balls.len()).collect();
    labelled(folder, name, count, balls, &labels);
}

/// Balls with a label for each; the first ball that holds a voxel counts.
fn labelled(folder: &Folder, name: &str, count: usize, balls: &[([f64; 3], f64)], labels: &[u8]) {
    let header = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({count}, {count}, {count}), }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{header:117}\n").as_bytes());
    for voxel in 0..count * count * count {
        let at = [voxel % count, voxel / count % count, voxel / (count * count)].map(|x| x as f64 + 0.5);
        let away = |middle: [f64; 3]| (0..3).map(|axis| (at[axis] - middle[axis]).powi(2)).sum::<f64>().sqrt();
        bytes.push(balls.iter().position(|(middle, radius)| away(*middle) < *radius).map_or(0, |k| labels[k]));
    }
    folder.write(name, bytes);
}

#[test]
fn a_label_volume_is_imported_checked_meshed_and_crushed() {
    let folder = Folder::new();
    balls(&folder, "scan.npy", 24, &THREE);
    let run = folder.run(&["import", "scan.npy", "--voxel-size-mm", "0.5", "-o", "model.json", "--threads", "1"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("3 grains of") && run.stderr.ends_with("wrote model.json\n"), "{}", run.stderr);
    assert!(run.stderr.contains("1 pairs of grains that touch in the labels are apart"), "{}", run.stderr);
    let again = folder.run(&["import", "scan.npy", "--voxel-size-mm", "0.5", "-qo", "again.json", "--threads", "3"]);
    assert_eq!((again.code, again.stderr.as_str()), (0, ""));
    assert!(folder.read("model.json") == folder.read("again.json"));
    assert_eq!(folder.run(&["check", "model.json"]).code, 0);
    let flags = ["--method", "lattice", "--element-size-mm", "1", "--itz", "none", "--volumes", "exact", "--strict"];
    let mesh = [&["mesh", "model.json", "-o", "mesh.vtu", "--summary-json", "mesh.json"][..], &flags].concat();
    let run = folder.run(&mesh);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let solve = ["solve", "model.json", "-o", "out", "--element-size-mm", "2", "--strain", "0.0005", "--quiet"];
    let run = folder.run(&solve);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(String::from_utf8(folder.read("out/result.json")).unwrap().contains("\"peak_mpa\""));
}

#[test]
fn balls_that_one_two_and_three_faces_of_a_label_volume_cut_keep_their_volume_in_a_fitted_lattice() {
    let folder = Folder::new();
    for middle in [[1.2, 24.0, 24.0], [1.2, 46.4, 24.0], [0.0, 0.0, 0.0], [2.6, 1.4, 47.2]] {
        balls(&folder, "scan.npy", 48, &[(middle, 13.0)]);
        // Surfaces at every other voxel have dents, which add to a grain in a fitted lattice of 2 mm.
        let run = folder.run(&["import", "scan.npy", "--voxel-size-mm", "0.5", "--step", "1", "-qfo", "model.json"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        for (size, volumes, most) in [("2", "fitted", 0.01), ("2", "exact", 1e-3), ("1", "fitted", 0.01)] {
            let mesh = ["mesh", "model.json", "-fo", "x.vtu", "--summary-json", "x.json", "--method", "lattice"];
            let flags = ["--itz", "none", "--strict", "--element-size-mm", size, "--volumes", volumes];
            let run = folder.run(&[&mesh[..], &flags].concat());
            assert_eq!(run.code, 0, "{middle:?} {size}: {}", run.stderr);
            let figures: serde_json::Value = serde_json::from_slice(&folder.read("x.json")).unwrap();
            let of = |which: &str| figures["quality"][which]["aggregate"].as_f64().unwrap();
            let lost = 1.0 - of("volumes_mm3") / of("exact_volumes_mm3");
            assert!(lost.abs() < most, "{middle:?} {size} {volumes}: {lost}");
            assert!(figures["quality"]["min_dihedral_deg"][0].as_f64().unwrap() > 8.0);
        }
    }
}

/// Volume of a ball in a box of 24 mm less that of one thinner by `t`, mm3, by chords; middle and radius are in voxels of 0.5 mm.
fn shell(middle: [f64; 3], radius: f64, t: f64) -> f64 {
    let count = 1000;
    let at = |i: i32| (f64::from(i) + 0.5) * 24.0 / f64::from(count);
    let chord = |y: f64, z: f64, radius: f64| {
        let [mx, my, mz] = middle.map(|x| x / 2.0);
        let half = (radius.powi(2) - (y - my).powi(2) - (z - mz).powi(2)).max(0.0).sqrt();
        (mx + half).clamp(0.0, 24.0) - (mx - half).clamp(0.0, 24.0)
    };
    let points = (0..count).flat_map(|j| (0..count).map(move |k| (at(j), at(k))));
    let all: f64 = points.map(|(y, z)| chord(y, z, radius / 2.0) - chord(y, z, radius / 2.0 - t)).sum();
    all * (24.0 / f64::from(count)).powi(2)
}

/// The surface of a label volume has a few percent more area than the ball.
#[test]
fn the_itz_of_balls_that_faces_of_a_label_volume_cut_ends_at_the_cut_in_meshes_and_images() {
    let folder = Folder::new();
    for middle in [[1.2, 24.0, 24.0], [1.2, 46.4, 24.0], [0.0, 0.0, 0.0], [2.6, 1.4, 47.2]] {
        balls(&folder, "scan.npy", 48, &[(middle, 13.0)]);
        for t in ["0.3", "1"] {
            let import = ["import", "scan.npy", "--voxel-size-mm", "0.5", "--step", "1", "-qfo", "model.json"];
            assert_eq!(folder.run(&[&import[..], &["--itz-thickness-mm", t]].concat()).code, 0);
            assert_eq!(folder.run(&["check", "model.json"]).code, 0);
            let expected = shell(middle, 13.0, t.parse().unwrap());
            let is_near = |found: f64, share: f64| (found / expected - 1.0).abs() < share;
            // Layers of both thicknesses in finer lattices: tests/mesh/caps.rs.
            for flags in [["voxel", "0.5", "--subsamples=4"], ["lattice", "2", "--quiet"]] {
                let [method, size, flag] = flags;
                let mesh = ["mesh", "model.json", "-fo", "x.vtu", "--summary-json", "x.json", "--itz", "solid"];
                let thin: &[&str] = if method == "voxel" { &["--thin-itz"] } else { &[] };
                let sized = ["--method", method, "--element-size-mm", size, flag];
                let run = folder.run(&[&mesh[..], &sized, thin].concat());
                assert_eq!(run.code, 0, "{middle:?} {t} {flags:?}: {}", run.stderr);
                let figures: serde_json::Value = serde_json::from_slice(&folder.read("x.json")).unwrap();
                let of = |which: &str| figures["quality"][which]["itz"].as_f64().unwrap();
                let [meshed, exact] = [of("volumes_mm3"), of("exact_volumes_mm3")];
                assert!(is_near(exact, 0.05), "{middle:?} {t}: {exact} of {expected}");
                // A layer of 0.3 mm on smaller voxels: tests/mesh/caps.rs.
                let most = if method == "voxel" { 0.05 } else { 0.01 };
                assert!((meshed / exact - 1.0).abs() < most, "{middle:?} {t} {flags:?}: {meshed} of {exact}");
                assert_eq!(figures["notes"]["closed_side_gaps"], 0);
            }
            let image =
                ["image", "model.json", "-qfo", "x.npy", "--what", "share", "--of", "itz", "--voxel-size-mm", "1"];
            assert_eq!(folder.run(&image).code, 0);
            let shares: f64 =
                folder.read("x.npy")[128..].as_chunks().0.iter().map(|s| f64::from(f32::from_le_bytes(*s))).sum();
            assert!(is_near(shares, 0.05), "{middle:?} {t}: {shares} of {expected}");
        }
    }
}

#[test]
fn volumes_without_grains_and_wrong_flags_are_refused() {
    let folder = Folder::new();
    balls(&folder, "scan.npy", 24, &THREE);
    let model = || folder.run(&["import", "scan.npy", "-o", "x.json", "--quiet"]);
    assert_eq!(
        model().stderr,
        "warning: the file has no size of a voxel, so it is 1 mm; --voxel-size-mm sets another\n"
    );
    for (flags, code, said) in [
        (&["--mortar", "0,1,2,3"][..], 1, "it has no grain of 64 voxels or more (0 are smaller)"),
        (&["--mortar", "9"], 1, "mortar names 9, which the volume does not have; its labels are 0, 1, 2, 3"),
        (
            &["--mortar", "1,2,3"],
            1,
            "% of the volume in one part, which reaches all faces of the volume: is it mortar?",
        ),
        (&["--voxel-size-mm", "0"], 2, "--voxel-size-mm is 0; it must be"),
        (&["--voxel-size-mm", "1,2"], 2, "--voxel-size-mm takes one length, or three"),
        (&["--step", "20"], 2, "--step is 20; it must be 1 to 8 voxels"),
        (&["--aggregate", "1", "--mortar", "0"], 2, "cannot be used with"),
        (&["-o", "x.inp"], 2, "'x.inp' for '--output <FILE>': unknown format"),
    ] {
        let run = folder.run(&[&["import", "scan.npy", "-fo", "y.json"][..], flags].concat());
        assert_eq!(run.code, code, "{flags:?}: {}", run.stderr);
        assert!(run.stderr.contains(said), "{flags:?}: {}", run.stderr);
    }
}

#[test]
fn hollows_and_separate_parts_of_a_label_are_reported() {
    let folder = Folder::new();
    // A ball of label 1 around a hollow, and label 2 in two places.
    let hollow = [([8.0, 8.0, 9.0], 3.0), ([8.0, 8.0, 9.0], 7.0), ([19.0, 18.0, 6.0], 4.0), ([19.0, 18.0, 18.0], 4.0)];
    labelled(&folder, "scan.npy", 24, &hollow, &[0, 1, 2, 2]);
    let run = folder.run(&["import", "scan.npy", "--voxel-size-mm", "0.5", "-o", "model.json", "--threads", "1"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // Voxels whose middle is within 3 voxels of a grid point: 136 of 24^3.
    assert!(run.stderr.contains("hollows in 1 grain(s), 0.984 % of the voxels, were filled"), "{}", run.stderr);
    assert!(run.stderr.contains("1 label(s) have separate parts; each of these 2 parts is a grain"), "{}", run.stderr);
    let model: serde_json::Value = serde_json::from_slice(&folder.read("model.json")).unwrap();
    let labels = &model["report"]["labels"];
    assert_eq!((labels["filled"].as_u64(), labels["labels"].as_array().map(Vec::len)), (Some(1), Some(3)));
    assert_eq!(folder.run(&["check", "model.json"]).code, 0);
}

/// Air 0, mortar 1, grains from 2: the mortar was one grain of a third of the volume, after half a minute of surfaces.
#[test]
fn a_label_that_surrounds_others_is_asked_about_and_a_flag_is_named_that_works() {
    let folder = Folder::new();
    let specimen = [([8.0, 12.0, 12.0], 3.5), ([16.0, 12.0, 12.0], 3.5), ([12.0, 12.0, 12.0], 11.0)];
    labelled(&folder, "scan.npy", 24, &specimen, &[2, 3, 1]);
    let import = |flags: &[&str]| {
        folder.run(&[&["import", "scan.npy", "--voxel-size-mm", "1", "-qfo", "m.json"][..], flags].concat())
    };
    let run = import(&[]);
    let said = "label 1 is 38 % of the volume in one part and surrounds 2 grains: is it mortar? --mortar=0,1 if so";
    assert!(run.code == 1 && run.stderr.contains(said), "{}", run.stderr);
    assert_eq!(import(&["--mortar=0,1", "--strict"]).code, 0);
    // A grain of a third of the volume is taken on request.
    labelled(&folder, "scan.npy", 24, &specimen[2..], &[1]);
    let run = import(&[]);
    assert!(run.code == 1 && run.stderr.contains("or --largest-grain 0.42 if it is a grain"), "{}", run.stderr);
    assert_eq!(import(&["--largest-grain", "0.42"]).code, 0);
    assert_eq!(folder.run(&["check", "m.json"]).code, 0);
}

/// No flag took a grain at two or three walls, whose box is the whole volume, and the message named none.
#[test]
fn each_question_names_the_flag_of_either_answer_and_both_work() {
    let folder = Folder::new();
    let import = |flags: &[&str]| {
        folder.run(&[&["import", "scan.npy", "--voxel-size-mm", "1", "-qfo", "m.json"][..], flags].concat())
    };
    let is_wall = |at: f64| at < 5.0;
    // An L, a tripod of three rods along the edges, and three plates in a corner; each beside a ball.
    let shapes: [&dyn Fn([f64; 3]) -> bool; 3] =
        [&|[x, y, _]| is_wall(x) || is_wall(y), &|p| p.iter().filter(|at| is_wall(**at)).count() > 1, &|p| {
            p.iter().any(|at| is_wall(*at))
        }];
    for is_odd in shapes {
        labelled(&folder, "scan.npy", 24, &[([15.0; 3], 5.0)], &[2]);
        let mut bytes = folder.read("scan.npy");
        for (voxel, label) in bytes[128..].iter_mut().enumerate() {
            if is_odd([voxel % 24, voxel / 24 % 24, voxel / 576].map(|at| at as f64)) {
                *label = 1;
            }
        }
        let share = bytes[128..].iter().filter(|label| **label > 0).count() as f64 / 24_f64.powi(3);
        folder.write("scan.npy", bytes);
        let run = import(&[]);
        assert!(run.code == 1 && run.stderr.contains("is it mortar? --mortar=0,1 if so, or "), "{}", run.stderr);
        assert!(run.stderr.contains("--largest-grain 1 if it is a grain; grains that touch"), "{}", run.stderr);
        assert_eq!(import(&["--mortar=0,1"]).code, 0);
        assert_eq!(import(&["--largest-grain", "1", "--strict"]).code, 0);
        let model: serde_json::Value = serde_json::from_slice(&folder.read("m.json")).unwrap();
        let found = model["report"]["fraction"].as_f64().unwrap();
        assert!((found / share - 1.0).abs() < 0.01, "{found} {share}");
    }
    // A core within its ITZ is one phase.
    labelled(&folder, "scan.npy", 24, &[([12.0; 3], 4.5), ([12.0; 3], 7.0)], &[2, 1]);
    let run = import(&[]);
    let phase = "--mortar=0,1 if so, or --aggregate=1,2 if these labels are one phase, as core and ITZ are";
    assert!(run.code == 1 && run.stderr.contains(phase), "{}", run.stderr);
    assert_eq!(import(&["--aggregate=1,2"]).code, 0, "{}", import(&["--aggregate=1,2"]).stderr);
}

/// Mortar of a tenth of the volume became a grain with a warning of the loss: all its grains were below 64 voxels, and the air
/// was what surrounded them too.
#[test]
fn mortar_in_air_is_asked_about_however_small_it_and_its_grains_are() {
    let folder = Folder::new();
    let at = |signs: [f64; 3]| (signs.map(|sign| 12.0 + 3.75 * sign), 2.0);
    let grains = [at([1.0, 1.0, 1.0]), at([-1.0, 1.0, 1.0]), at([1.0, -1.0, -1.0])];
    labelled(&folder, "scan.npy", 24, &[&grains[..], &[([12.0; 3], 7.0)]].concat(), &[2, 3, 4, 1]);
    let import = |flags: &[&str]| {
        folder.run(&[&["import", "scan.npy", "--voxel-size-mm", "1", "-qfo", "m.json"][..], flags].concat())
    };
    let run = import(&[]);
    let said = "label 1 is 10 % of the volume in one part, most of what is labelled, and nearly all other labels lie in its box: is it \
                mortar? --mortar=0,1 if so, or --largest-grain 1 if it is a grain";
    assert!(run.code == 1 && run.stderr.contains(said), "{}", run.stderr);
    assert_eq!(import(&["--mortar=0,1", "--least-voxels", "16"]).code, 0);
    assert_eq!(import(&["--largest-grain", "1"]).code, 0);
    // A grain with others about it is one.
    let around = [([19.0, 12.0, 12.0], 3.0), ([5.0, 12.0, 12.0], 3.0), ([12.0, 19.0, 12.0], 3.0)];
    labelled(&folder, "scan.npy", 24, &[&[([12.0; 3], 6.5)], &around[..]].concat(), &[1, 2, 3, 4]);
    assert_eq!(import(&[]).code, 0, "{}", import(&[]).stderr);
}

/// A plate of two voxels vanished from all figures with `--smoothing 4`; so did 70 % of rods.
#[test]
fn losses_of_an_import_are_counted_with_a_warning() {
    let folder = Folder::new();
    let row: Vec<_> =
        (0..36).map(|k| ([2.0 + 4.0 * f64::from(k % 6), 2.0 + 4.0 * f64::from(k / 6), 12.0], 2.0)).collect();
    let labels: Vec<u8> = (1..=36).collect();
    labelled(&folder, "scan.npy", 24, &row, &labels);
    let flags = ["import", "scan.npy", "--voxel-size-mm", "0.0001", "--least-voxels", "8", "-qfo", "m.json"];
    let run = folder.run(&[&flags[..], &["--smoothing", "2", "--strict"]].concat());
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(run.stderr.starts_with("warning: the aggregates have "), "{}", run.stderr);
    let model: serde_json::Value = serde_json::from_slice(&folder.read("m.json")).unwrap();
    let of = |key: &str| model["report"]["labels"][key].as_f64().unwrap();
    let voxels = folder.read("scan.npy")[128..].iter().filter(|label| **label > 0).count() as f64 / 24_f64.powi(3);
    assert!((of("fraction") + of("dropped_fraction") - voxels).abs() < 1e-12);
    let fraction = model["report"]["fraction"].as_f64().unwrap();
    assert!((of("lost_fraction") + fraction - voxels).abs() < 1e-12);
    // Grains of nanometres pass the check.
    assert_eq!(folder.run(&["check", "m.json"]).code, 0);
}

/// The mask of a drilled core was lost: its strength was that of a cube with corners of mortar.
#[test]
fn a_drilled_core_is_a_cylinder_of_its_diameter() {
    let folder = Folder::new();
    // Two grains, of which the side of the core cuts one, and a pore with the label of the air.
    let inside = [([20.0, 20.0, 10.0], 5.0), ([34.0, 20.0, 20.0], 6.0), ([14.0, 26.0, 27.0], 4.0)];
    labelled(&folder, "scan.npy", 40, &inside, &[2, 3, 9]);
    let mut bytes = folder.read("scan.npy");
    for (voxel, label) in bytes[128..].iter_mut().enumerate() {
        let [x, y] = [voxel % 40, voxel / 40 % 40].map(|at| at as f64 - 19.5);
        let is_core = (x * x + y * y).sqrt() < 18.0;
        *label = if is_core && *label != 9 { (*label).max(1) } else { 0 };
    }
    let voxels = bytes[128..].iter().filter(|label| **label > 1).count() as f64;
    folder.write("scan.npy", bytes);
    let import = ["import", "scan.npy", "--voxel-size-mm", "0.5", "-fo", "m.json", "--outside", "0", "--mortar", "1"];
    let run = folder.run(&import);
    assert!(run.code == 0 && run.stderr.contains("the core is a cylinder of 18."), "{}", run.stderr);
    let model: serde_json::Value = serde_json::from_slice(&folder.read("m.json")).unwrap();
    let of = |key: &str| model["specimen"][key].as_f64().unwrap();
    let (diameter, height) = (of("diameter_mm"), of("height_mm"));
    assert!((diameter - 18.0).abs() < 0.05 && height == 20.0, "{diameter} {height}");
    let fraction = voxels * 0.125 / (std::f64::consts::FRAC_PI_4 * diameter * diameter * height);
    let found = model["report"]["fraction"].as_f64().unwrap();
    assert!((found / fraction - 1.0).abs() < 0.01, "{found} {fraction}");
    let labels = &model["report"]["labels"];
    let [of_labels, pores] = [&labels["fraction"], &labels["core"]["pores_fraction"]].map(|x| x.as_f64().unwrap());
    assert!((found / of_labels - 1.0).abs() < 0.01, "{found} {of_labels}");
    // The ball of 4 voxels with the label 9.
    assert!((pores * labels["core"]["voxels"].as_f64().unwrap() - 268.0).abs() < 20.0, "{pores}");
    assert!(run.stderr.contains("outside by its label, as pores are"), "{}", run.stderr);
    let reach = |vertex: &serde_json::Value| {
        let [x, y] = [0, 1].map(|axis| vertex[axis].as_f64().unwrap() - 0.5 * diameter);
        x.hypot(y)
    };
    let vertices =
        model["aggregates"].as_array().unwrap().iter().flat_map(|grain| grain["vertices"].as_array().unwrap());
    let farthest = vertices.map(reach).fold(0.0, f64::max);
    assert!(farthest <= 0.5 * diameter && farthest > 0.49 * diameter, "{farthest} {diameter}");
    assert_eq!(folder.run(&["check", "m.json"]).code, 0);
    let run = folder.run(&["mesh", "m.json", "-o", "m.vtu", "--method", "lattice", "--element-size-mm", "1"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    balls(&folder, "scan.npy", 24, &THREE);
    let run = folder.run(&["import", "scan.npy", "--outside", "0", "-fo", "m.json"]);
    assert!(run.code == 1 && run.stderr.contains("is no cylinder along z"), "{}", run.stderr);
}

/// The case: grains that touch in a scan were bitten by the mortar that parted them in the mesh, and the advice was to pack.
#[test]
fn touching_grains_keep_a_gap_that_elements_resolve() {
    let folder = Folder::new();
    let touching = [([12.0, 12.0, 12.0], 8.0), ([26.0, 13.0, 13.0], 8.0), ([18.0, 27.0, 14.0], 8.0)];
    balls(&folder, "scan.npy", 40, &touching);
    let bitten = |gap: &[&str]| {
        let import = ["import", "scan.npy", "--voxel-size-mm", "0.5", "-fo", "m.json"];
        let run = folder.run(&[&import[..], gap].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert_eq!(folder.run(&["check", "m.json"]).code, 0);
        let mesh = ["mesh", "m.json", "-fo", "m.vtu", "--method", "lattice", "--itz", "none", "--joined", "mortar"];
        let flags = ["--element-size-mm", "2", "--accept-phase-error", "--summary-json", "s.json"];
        let run = folder.run(&[&mesh[..], &flags].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let figures: serde_json::Value = serde_json::from_slice(&folder.read("s.json")).unwrap();
        (figures["notes"]["parted_aggregates"].as_u64().unwrap(), run.stderr)
    };
    let (grains, said) = bitten(&[]);
    assert!(
        grains >= 2 && said.contains(" grains to keep them apart. Smaller elements or import with a larger --gap-mm"),
        "{said}"
    );
    let (grains, said) = bitten(&["--gap-mm", "2"]);
    assert!(grains == 0 && !said.contains("keep them apart"), "{said}");
    // Both grains of a pair gave way alike, by half of the gap: their planes of contact were at x = 9.5 mm or so.
    let model: serde_json::Value = serde_json::from_slice(&folder.read("m.json")).unwrap();
    let xs = |grain: usize| {
        let vertices = model["aggregates"][grain]["vertices"].as_array().unwrap();
        vertices.iter().map(|vertex| vertex[0].as_f64().unwrap()).collect::<Vec<f64>>()
    };
    let (right, left) = (xs(0).into_iter().fold(0.0, f64::max), xs(1).into_iter().fold(f64::INFINITY, f64::min));
    assert!((left - right - 2.0).abs() < 0.4 && (0.5 * (left + right) - 9.5).abs() < 0.4, "{right} {left}");
    let run = folder.run(&["import", "scan.npy", "--gap-mm", "-1", "-fo", "m.json"]);
    assert!(run.code == 2 && run.stderr.contains("--gap-mm is -1; it must be 0 to 1000 mm"), "{}", run.stderr);
}
