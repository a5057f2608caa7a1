//! Label volumes: layers, resistors, own images, periods, threads.

use meso_collision::simd::{Isa, choose};
use meso_core::Silent;
use meso_core::import::volume::Volume;
use meso_effective::{
    Effective, EffectiveOptions, LabelPhases, LabelSpecimen, Property, Stiffness, StiffnessOptions,
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
