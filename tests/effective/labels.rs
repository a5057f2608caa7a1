//! Label volumes: layers, resistors, own images, periods, threads.

use meso_collision::simd::{Isa, choose};
use meso_core::Silent;
use meso_core::import::volume::Volume;
use meso_effective::{
    Effective, EffectiveOptions, GivenModuli, LabelPhases, LabelSpecimen, Property, Stiffness, StiffnessOptions,
    effective_of_labels, stiffness_of_labels,
};

fn specimen(counts: [usize; 3], of: impl Fn([usize; 3]) -> i64) -> LabelSpecimen {
    let [nx, ny, nz] = counts;
    let labels = (0..nx * ny * nz).map(|number| of([number % nx, number / nx % ny, number / (nx * ny)]));
    LabelSpecimen { volume: Volume::new(counts, None, labels).unwrap(), spacing_mm: [1.0; 3], periodic: [false; 3] }
}

fn phases(values: &[(&str, f64)]) -> LabelPhases {
    let diffusivity = values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    LabelPhases { diffusivity, ..LabelPhases::default() }
}

fn solve(specimen: &LabelSpecimen, phases: &LabelPhases) -> Effective {
    effective_of_labels(specimen, phases, &EffectiveOptions::new(Property::Diffusivity, 1.0), &Silent).unwrap().0
}

#[test]
fn layers_of_labels_are_exact_in_series_and_parallel() {
    // Layers of four voxels, so that the coarse volume has them, too; the spacing differs along each axis.
    let mut layered = specimen([8, 6, 12], |[_, _, k]| if k / 4 % 2 == 0 { 7 } else { -3 });
    layered.spacing_mm = [0.5, 1.0, 2.0];
    let found = solve(&layered, &phases(&[("7", 1.0), ("-3", 100.0)]));
    let (f, g) = (2.0 / 3.0, 1.0 / 3.0);
    let expected = [f + 100.0 * g, f + 100.0 * g, 1.0 / (f + g / 100.0)];
    for (axis, expected) in expected.into_iter().enumerate() {
        let (value, error) = (found.tensor[axis][axis].unwrap(), found.error[axis][axis].unwrap());
        assert!((value / expected - 1.0).abs() < 1e-6 && error < 1e-5 * expected, "{value} for {expected}");
    }
    assert_eq!(found.phases.iter().map(|phase| phase.name.as_str()).collect::<Vec<_>>(), ["-3", "7"]);
    assert!((found.phases[1].volume_fraction - f).abs() < 1e-12);
}

#[test]
fn walls_have_their_values_at_the_faces_of_the_voxels() {
    // One voxel across: half of each end's resistance counts.
    let row = specimen([4, 1, 1], |[i, ..]| i as i64);
    let values = [("0", 1.0), ("1", 2.0), ("2", 4.0), ("3", 5.0)];
    let found = solve(&row, &phases(&values));
    let resistance: f64 = values.iter().map(|(_, value)| 0.25 / value).sum();
    assert!((found.fine[0][0].unwrap() * resistance - 1.0).abs() < 1e-6);
    assert_eq!(found.resolution.boundary, ["fixed"; 3]);
}

/// bugs_eff_layers.py: every second voxel lost the layer or doubled it, 0.72 below 0 or 0.20 for 0.139.
#[test]
fn a_layer_of_one_voxel_has_its_resistance_wherever_it_lies() {
    for at in [3, 8, 9, 12] {
        let found = solve(&specimen([16, 16, 16], |[.., k]| i64::from(k == at)), &phases(&[("0", 1.0), ("1", 0.01)]));
        let exact = [15.01 / 16.0, 15.01 / 16.0, 16.0 / (15.0 + 100.0)];
        for (axis, exact) in exact.into_iter().enumerate() {
            let (value, error) = (found.tensor[axis][axis].unwrap(), found.error[axis][axis].unwrap());
            assert!((value / exact - 1.0).abs() < 1e-7 && error < 1e-5 * exact, "{value} {error} for {exact}");
        }
    }
    let striped = LabelSpecimen { periodic: [true; 3], ..specimen([8, 8, 8], |[.., k]| k as i64 % 2) };
    let found = solve(&striped, &phases(&[("0", 1.0), ("1", 0.1)]));
    let [along, across] = [0, 2].map(|axis| found.tensor[axis][axis].unwrap());
    assert!((along - 0.55).abs() < 1e-7 && (across - 2.0 / 11.0).abs() < 1e-7, "{along} {across}");
    let pore = solve(&specimen([20, 20, 10], |at| i64::from(at[..2] != [10, 10])), &phases(&[("0", 1.0), ("1", 0.0)]));
    let along = pore.tensor[2][2].unwrap();
    assert!((along - 0.0025).abs() < 1e-9, "{along}");
    assert_eq!([pore.tensor[0][0], pore.error[0][0]], [Some(0.0); 2]);
}

/// Every voxel in 8 and in 64: the links' value rises to the exact one, which the error contains.
#[test]
fn the_error_of_a_label_volume_contains_the_value_of_finer_voxels() {
    let noise = |[i, j, k]: [usize; 3]| (i * 7919 + j * 104_729 + k * 1_299_709) / 1000;
    let ball = |[i, j, k]: [usize; 3]| {
        let square = |at: usize| (2.0 * at as f64 - 11.0).powi(2);
        (square(i) + square(j) + square(k)).sqrt()
    };
    type Of<'a> = &'a dyn Fn([usize; 3]) -> i64;
    let volumes: [(Of, [f64; 2]); 6] = [
        (&|at| i64::from(noise(at) % 10 < 4), [1.0, 0.0]),
        (&|at| i64::from(noise(at) % 10 < 4), [1.0, 100.0]),
        (&|at| i64::from(noise(at) % 3 == 0), [3.0, 0.02]),
        (&|at| i64::from(ball(at) < 7.0), [1.0, 0.0]),
        (&|at| i64::from((6.0..8.0).contains(&ball(at))), [1.0, 50.0]),
        (&|[i, j, _]| i64::from((i + j) / 3 % 2 == 0), [1.0, 6.0]),
    ];
    for (number, (of, values)) in volumes.into_iter().enumerate() {
        let given = phases(&[("0", values[0]), ("1", values[1])]);
        let on = |parts: usize| {
            let volume = specimen([12 * parts; 3], |at| of(at.map(|at| at / parts)));
            solve(&LabelSpecimen { periodic: [number % 2 == 0; 3], ..volume }, &given)
        };
        let [found, finer] = [1, 4].map(on);
        for axis in 0..3 {
            let at = |of: &[[Option<f64>; 3]; 3]| of[axis][axis].unwrap();
            let (value, error, fine) = (at(&found.tensor), at(&found.error), at(&finer.fine));
            let context = format!("{value} +- {error} for {fine} of {number} along {axis}, {:?}", found.bounds);
            assert!((value - at(&finer.tensor)).abs() <= error && fine >= at(&found.fine) - 1e-6, "{context}");
            assert!(fine >= value - error && fine <= value + error, "{context}");
            assert!(value >= found.bounds.reuss && value <= found.bounds.voigt, "{context}");
        }
    }
}

/// bugs_eff_pocket.py: the iterations ended with NaN.
#[test]
fn pockets_that_touch_no_face_carry_nothing() {
    let [values, more] = [&[("0", 0.0), ("1", 1.0)][..], &[("0", 0.0), ("1", 1.0), ("2", 5.0)]].map(phases);
    for (count, from, to) in [(12, 4, 8), (13, 4, 8), (14, 4, 8), (16, 4, 8), (18, 4, 8), (12, 5, 7), (12, 3, 8)] {
        for periodic in [false, true] {
            let is_inside = |at: [usize; 3]| at.iter().all(|at| (from..to).contains(at));
            let mut volume = specimen([count; 3], |at| i64::from(is_inside(at)));
            volume.periodic = [periodic; 3];
            let found = solve(&volume, &values);
            assert_eq!([found.tensor, found.error], [[[Some(0.0); 3]; 3]; 2], "{count} {from} {to}");
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
            // A pore along x beside the pocket: only x conducts.
            let mut beside = specimen([count; 3], |at| if at[1..] == [0, 0] { 2 } else { i64::from(is_inside(at)) });
            beside.periodic = [periodic; 3];
            let found = solve(&beside, &more);
            let pore = 5.0 / (count * count) as f64;
            assert!((found.tensor[0][0].unwrap() - pore).abs() < 1e-8, "{:?}", found.tensor);
            assert_eq!([found.tensor[1][1], found.error[1][1], found.tensor[2][2]], [Some(0.0); 3]);
        }
    }
    // A pore that leads around a period along x and y carries both, and a spiral counts too.
    let diagonal = |[i, j, k]: [usize; 3]| i64::from(k == 2 && (i == j || (i + 1) % 8 == j));
    let found = solve(&LabelSpecimen { periodic: [true; 3], ..specimen([8, 8, 8], diagonal) }, &values);
    assert!(found.tensor[0][0].unwrap() > 0.001 && found.tensor[0][1].unwrap() > 0.001, "{:?}", found.tensor);
    assert_eq!([found.tensor[2][2], found.error[2][2]], [Some(0.0); 2]);
}

/// twice_label_0.toml: the last of the two counted.
#[test]
fn a_label_that_is_given_twice_is_refused() {
    let scan = specimen([4, 4, 4], |[i, ..]| i as i64 / 2);
    let options = EffectiveOptions::new(Property::Diffusivity, 1.0);
    for names in [["0", "00"], ["-0", "0"], ["000", "0"], ["+0", "0"]] {
        let given = phases(&[(names[0], 1.0), (names[1], 50.0), ("1", 2.0)]);
        let refused = effective_of_labels(&scan, &given, &options, &Silent).err().unwrap().to_string();
        assert!(refused.starts_with("[diffusivity] has the label 0 twice, as "), "{refused}");
    }
    let moduli = serde_json::json!({ "youngs_modulus_mpa": 20000 });
    let given = serde_json::json!({ "stiffness": { "0": moduli, "1": moduli, "01": moduli } });
    let given: LabelPhases = serde_json::from_value(given).unwrap();
    let refused = stiffness_of_labels(&scan, &given, &StiffnessOptions::new(1.0), &Silent).err().unwrap().to_string();
    assert_eq!(refused, "[stiffness] has the label 1 twice, as 01 and as 1; keep one of them");
}

#[test]
fn a_homogeneous_volume_has_its_value_within_its_bounds() {
    let found = solve(&specimen([6, 6, 6], |_| 0), &phases(&[("0", 0.1)]));
    for axis in 0..3 {
        assert_eq!([found.tensor[axis][axis], found.error[axis][axis]], [Some(0.1), Some(0.0)]);
    }
    assert_eq!([found.bounds.reuss, found.bounds.voigt], [0.1; 2]);
}

/// Voxels in 8 and in 64: the stiffness falls to the exact one.
#[test]
fn the_error_of_a_stiffness_of_labels_contains_that_of_finer_voxels() {
    let noise = |[i, j, k]: [usize; 3]| (i * 7919 + j * 104_729 + k * 1_299_709) / 1000;
    type Of<'a> = &'a dyn Fn([usize; 3]) -> i64;
    let volumes: [(Of, f64); 3] = [
        (&|at| i64::from(noise(at) % 10 < 4), 0.0),
        (&|at| i64::from(noise(at) % 3 == 0), 10.0),
        (&|[i, ..]| i as i64 % 2, 50.0),
    ];
    for (of, stiffer) in volumes {
        let given = serde_json::json!({ "stiffness": {
            "0": { "youngs_modulus_mpa": 20000, "poisson_ratio": 0.2, "eigenstrain": -1e-4 },
            "1": { "youngs_modulus_mpa": 20000.0 * stiffer, "poisson_ratio": 0.3 } } });
        let given: LabelPhases = serde_json::from_value(given).unwrap();
        let on = |parts: usize| {
            let volume = specimen([6 * parts; 3], |at| of(at.map(|at| at / parts)));
            let volume = LabelSpecimen { periodic: [true; 3], ..volume };
            stiffness_of_labels(
                &volume,
                &given,
                &StiffnessOptions { tolerance: 1e-8, ..StiffnessOptions::new(1.0) },
                &Silent,
            )
            .unwrap()
            .0
        };
        let [found, finer] = [1, 4].map(on);
        for i in 0..6 {
            let (value, error) = (found.tensor[i][i], found.error[i][i]);
            assert!(
                (value - finer.tensor[i][i]).abs() <= error,
                "{value} +- {error} for {} of {stiffer}",
                finer.tensor[i][i]
            );
            assert!(
                (value - finer.fine[i][i]).abs() <= error,
                "{value} +- {error} for {} of {stiffer}",
                finer.fine[i][i]
            );
            assert!((found.expansion[i] - finer.expansion[i]).abs() <= found.expansion_error[i] + 1e-9);
        }
        let of = |stiffness: &Stiffness| [stiffness.isotropic.bulk_modulus_mpa, stiffness.isotropic.shear_modulus_mpa];
        let errors = [found.isotropic_error.bulk_modulus_mpa, found.isotropic_error.shear_modulus_mpa];
        for ((value, fine), error) in of(&found).into_iter().zip(of(&finer)).zip(errors) {
            assert!((value - fine).abs() <= error, "{value} +- {error} for {fine}");
        }
    }
}

/// Blocks of voxels in odd counts, periodic and between walls: the same geometry, and fewer displacements.
#[test]
fn blocks_of_a_label_volume_have_its_geometry() {
    let of = |volume: LabelSpecimen, stiffer: f64| {
        let given = serde_json::json!({ "stiffness": {
            "0": { "youngs_modulus_mpa": 20000, "poisson_ratio": 0.2 },
            "1": { "youngs_modulus_mpa": 20000.0 * stiffer, "poisson_ratio": 0.2 } } });
        let given: LabelPhases = serde_json::from_value(given).unwrap();
        let found = stiffness_of_labels(&volume, &given, &StiffnessOptions::new(1.0), &Silent).unwrap().0;
        let error = found.error[0][0] / found.tensor[0][0];
        (found.fine, found.coarse.unwrap(), error)
    };
    let alike = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-5;
    for periodic in [false, true] {
        let volume = |counts: [usize; 3], label: &dyn Fn([usize; 3]) -> i64| LabelSpecimen {
            periodic: [periodic; 3],
            spacing_mm: [1.0, 2.0, 0.5],
            ..specimen(counts, label)
        };
        let (fine, coarse, error) = of(volume([7, 5, 3], &|_| 1), 3.0);
        assert!(error < 1e-5 && (0..6).all(|i| alike(fine[i][i], coarse[i][i])), "{fine:?} {coarse:?}");
        // Layers of two voxels are exact in blocks of two, along and across.
        let (fine, coarse, _) = of(volume([4, 8, 6], &|[_, j, _]| j as i64 / 2 % 2), 20.0);
        assert!((0..6).all(|i| !periodic || alike(fine[i][i], coarse[i][i])), "{fine:?} {coarse:?}");
        let (fine, coarse, _) = of(volume([7, 6, 5], &|[i, j, k]| (i * j + k) as i64 % 3 / 2), 10.0);
        assert!((0..6).all(|i| coarse[i][i] > fine[i][i]), "{fine:?} {coarse:?}");
    }
}

#[test]
fn a_closed_volume_conducts_nothing_and_an_island_does_not_matter() {
    let island = |[i, j, k]: [usize; 3]| i64::from(k == 5) * 2 + i64::from([i, j, k] == [2, 2, 2]);
    let found = solve(&specimen([8, 8, 12], |at| island(at).min(2)), &phases(&[("0", 1.0), ("1", 50.0), ("2", 0.0)]));
    assert_eq!(found.fine[2][2].map(|value| value.abs() < 1e-9), Some(true));
    assert!(found.fine[0][0].unwrap() > 0.9);
}

#[test]
fn a_period_joins_the_ends_of_a_volume() {
    let striped = |periodic: bool| {
        let mut volume = specimen([16, 16, 4], |[i, j, _]| i64::from((i + j) / 8 % 2 == 0));
        volume.periodic = [periodic; 3];
        solve(&volume, &phases(&[("0", 1.0), ("1", 10.0)]))
    };
    let [periodic, walls] = [true, false].map(striped);
    // Oblique layers carry flux across the gradient; insulated sides forbid it.
    let off = |found: &Effective| found.fine[0][1].unwrap();
    assert!((off(&periodic) - periodic.fine[1][0].unwrap()).abs() < 1e-5 && off(&periodic).abs() > 1.0);
    assert!(walls.fine[0][0].unwrap() < periodic.fine[0][0].unwrap());
    assert_eq!(periodic.resolution.boundary, ["periodic"; 3]);
}

/// Voxels without order, of values 1, 0 and 30.
fn scan() -> LabelSpecimen {
    specimen([24, 24, 24], |[i, j, k]| ((i * 7919 + j * 104_729 + k * 1_299_709) / 1000 % 3) as i64)
}

#[test]
fn results_of_labels_are_the_same_with_any_vector_instructions() {
    let found = Isa::ALL.map(|isa| {
        choose(isa);
        serde_json::to_vec(&solve(&scan(), &phases(&[("0", 1.0), ("1", 0.0), ("2", 30.0)]))).unwrap()
    });
    choose(Isa::best());
    assert!(found[0] == found[1] && found[0] == found[2]);
}

/// Rows that the width of no register divides, with voxels of one phase, cut ones, and blocks of voxels.
#[test]
fn stiffness_is_the_same_with_any_vector_instructions() {
    let of_labels = |labels: &LabelSpecimen| {
        let stiff = |e: f64| GivenModuli { youngs_modulus_mpa: Some(e), poisson_ratio: Some(0.2), eigenstrain: None };
        let stiffness = [("0", 20_000.0), ("1", 1_000.0), ("2", 60_000.0)].map(|(label, e)| (label.into(), stiff(e)));
        let phases = LabelPhases { stiffness: stiffness.into(), ..Default::default() };
        stiffness_of_labels(labels, &phases, &StiffnessOptions::new(1.0), &Silent).unwrap().0
    };
    let labels = specimen([11, 7, 5], |[i, j, k]| ((i * 7919 + j * 104_729 + k * 1_299_709) / 1000 % 3) as i64);
    let found = Isa::ALL.map(|isa| {
        choose(isa);
        serde_json::to_vec(&(of_labels(&labels), crate::stiffness::array(3.0, crate::stiffness::STONE, 1.0))).unwrap()
    });
    choose(Isa::best());
    assert!(found[0] == found[1] && found[0] == found[2]);
}

#[test]
fn a_looser_tolerance_takes_fewer_iterations_and_keeps_its_error() {
    let phases = phases(&[("0", 1.0), ("1", 0.0), ("2", 30.0)]);
    let [loose, tight] = [1e-4, 1e-12].map(|tolerance| {
        let options = EffectiveOptions { tolerance, ..EffectiveOptions::new(Property::Diffusivity, 1.0) };
        effective_of_labels(&scan(), &phases, &options, &Silent).unwrap().0
    });
    for axis in 0..3 {
        let error = loose.fine[axis][axis].unwrap() / tight.fine[axis][axis].unwrap() - 1.0;
        assert!(error > 0.0 && error < loose.resolution.solver_error, "{error} along {axis}");
        assert!(2 * loose.resolution.iterations[axis] < tight.resolution.iterations[axis]);
    }
    let options = EffectiveOptions { tolerance: 0.1, ..EffectiveOptions::new(Property::Diffusivity, 1.0) };
    let refused = effective_of_labels(&scan(), &phases, &options, &Silent).err().unwrap().to_string();
    assert_eq!(refused, "effective.tolerance is 0.1; it must be 1e-13 to 0.01");
}

#[test]
fn results_of_labels_are_the_same_on_any_number_of_threads() {
    let scan = scan();
    let [one, other, many] = [1, 2, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| solve(&scan, &phases(&[("0", 1.0), ("1", 0.0), ("2", 30.0)])));
        serde_json::to_vec(&found).unwrap()
    });
    assert!(one == other && one == many);
}

#[test]
fn layers_of_labels_have_the_exact_modulus_across() {
    let layered = LabelSpecimen { periodic: [true; 3], ..specimen([4, 4, 8], |[_, _, k]| i64::from(k >= 4)) };
    let given = serde_json::json!({ "stiffness": {
        "0": { "youngs_modulus_mpa": 20000, "poisson_ratio": 0.0 },
        "1": { "youngs_modulus_mpa": 60000, "poisson_ratio": 0.0, "eigenstrain": 1e-4 } } });
    let phases: LabelPhases = serde_json::from_value(given).unwrap();
    let found: Stiffness = stiffness_of_labels(&layered, &phases, &StiffnessOptions::new(1.0), &Silent).unwrap().0;
    assert!((found.tensor[2][2] / 30000.0 - 1.0).abs() < 1e-6 && (found.tensor[0][0] / 40000.0 - 1.0).abs() < 1e-6);
    assert!((found.expansion[2] / 0.5e-4 - 1.0).abs() < 1e-5 && (found.expansion[0] / 0.75e-4 - 1.0).abs() < 1e-5);
}

#[test]
fn labels_without_values_are_refused_by_name() {
    let scan = specimen([4, 4, 4], |[i, ..]| i as i64);
    let refused = |values: &[(&str, f64)]| {
        let options = EffectiveOptions::new(Property::Diffusivity, 1.0);
        effective_of_labels(&scan, &phases(values), &options, &Silent).err().unwrap().to_string()
    };
    assert!(
        refused(&[("0", 1.0), ("1", 1.0), ("2", 1.0)]).starts_with("label 3 has no value; give it in [diffusivity]")
    );
    assert!(refused(&[("stone", 1.0)]).starts_with("[diffusivity] has `stone`;"));
    assert!(refused(&[("0", 1.0), ("mortar", 1.0)]).starts_with("[diffusivity] has `mortar`;"));
    assert!(refused(&[("0", -1.0), ("1", 1.0), ("2", 1.0), ("3", 1.0)]).starts_with("diffusivity.0 is -1;"));
    assert!(refused(&[("0", 0.0), ("1", 0.0), ("2", 0.0), ("3", 0.0)]).starts_with("all labels of the volume"));
    // Without numbers, labels are those of mesocrete's images: 3 is a void.
    assert!(solve(&scan, &phases(&[("aggregate", 2.0)])).phases[3].value == 0.0);
}

/// The case: `7 = 2.0` for a volume without a label 7 was left out without a word.
#[test]
fn values_of_labels_that_are_not_there_are_warned_of_and_change_nothing() {
    let layered = specimen([4, 4, 4], |[.., k]| k as i64 / 2);
    let right = phases(&[("0", 1.0), ("1", 2.0)]);
    for (more, said) in [(vec!["7"], "7"), (vec!["-1"], "-1"), (vec!["2", "30"], "2, 30"), (vec!["07"], "7")] {
        let mut given = right.clone();
        given.diffusivity.extend(more.iter().map(|name| ((*name).to_owned(), 5.0)));
        let (mut found, alone) = (solve(&layered, &given), solve(&layered, &right));
        let warning = found.warnings.pop().unwrap();
        assert_eq!(warning, format!("[diffusivity] has {said}, and the volume has no voxel of such a label"));
        assert_eq!(found, alone);
    }
    let moduli =
        |label: &str| (label.to_owned(), GivenModuli { youngs_modulus_mpa: Some(2e4), ..GivenModuli::default() });
    let given = LabelPhases { stiffness: ["0", "1", "9"].map(moduli).into(), ..LabelPhases::default() };
    let found = stiffness_of_labels(&layered, &given, &StiffnessOptions::new(1.0), &Silent).unwrap().0;
    assert!(found.warnings.iter().any(|warning| warning.starts_with("[stiffness] has 9, ")), "{:?}", found.warnings);
}

/// The case: `--voxel-size-mm=-1` gave a value beyond the bounds, 1e-300 ended in a bug, and NaN was an error of the equations.
#[test]
fn voxels_of_a_size_that_none_has_are_refused() {
    let layered = specimen([4, 4, 4], |[.., k]| k as i64 / 2);
    let phases = phases(&[("0", 1.0), ("1", 2.0)]);
    for edge in [f64::NAN, 0.0, -1.0, 1e-300, 1e300, f64::INFINITY, 9e-7, 1.1e6] {
        for axis in 0..3 {
            let mut odd = layered.clone();
            odd.spacing_mm[axis] = edge;
            let options = EffectiveOptions::new(Property::Diffusivity, 1.0);
            let error = effective_of_labels(&odd, &phases, &options, &Silent).err().unwrap().to_string();
            assert!(error.starts_with("effective.voxel_size_mm is "), "{error}");
            assert!(error.ends_with("; it must be 1e-6 to 1e6 mm") && error.len() < 70, "{error}");
            assert!(stiffness_of_labels(&odd, &LabelPhases::default(), &StiffnessOptions::new(1.0), &Silent).is_err());
        }
    }
    for edge in [1e-6, 1e6] {
        let same = LabelSpecimen { spacing_mm: [edge; 3], ..layered.clone() };
        let (found, right) = (solve(&same, &phases), solve(&layered, &phases));
        assert!((found.tensor[2][2].unwrap() / right.tensor[2][2].unwrap() - 1.0).abs() < 1e-6);
    }
}
