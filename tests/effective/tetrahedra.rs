//! Fitted tetrahedra against closed forms, CalculiX and voxels.

use crate::bodies::{aggregate, cube, entry, phases, slabs, sphere};
use crate::laminates::off;
use crate::packings::packing;
use crate::spheres::{coated, cubic_array};
use crate::stiffness::{MORTAR, STONE, given, laminate};
use meso_core::aggregate::Aggregate;
use meso_core::geometry::convex_hull;
use meso_core::math::Vec3;
use meso_core::mesh::{Mesh, Phase};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::{Silent, Spec, pack};
use meso_effective::{
    Boundary, Effective, EffectiveError, EffectiveOptions, FieldCells, Moduli, PhaseModuli, Phases, Property,
    PropertyField, Stiffness, StiffnessOptions, effective_in_tetrahedra, stiffness_in_tetrahedra,
};
use std::f64::consts::PI;
use std::fmt::Write;
use std::process::Command;

const SIDE: f64 = 20.0;
const X: [bool; 3] = [true, false, false];

fn solve(bodies: &[Aggregate], specimen: &Specimen, phases: &Phases, h: f64) -> Effective {
    solve_along([true; 3], bodies, specimen, phases, h)
}

fn solve_along(axes: [bool; 3], bodies: &[Aggregate], specimen: &Specimen, phases: &Phases, h: f64) -> Effective {
    let options = EffectiveOptions { axes, ..EffectiveOptions::new(Property::Diffusivity, h) };
    effective_in_tetrahedra((bodies, specimen), phases, &options, h, &Silent).unwrap().0
}

fn stiffness(bodies: &[Aggregate], specimen: &Specimen, stone: Moduli, h: f64) -> (Stiffness, Vec<PropertyField>) {
    let phases =
        PhaseModuli { mortar: given(MORTAR), aggregate: given(stone), itz: given(MORTAR), ..Default::default() };
    let options = StiffnessOptions { fields: true, ..StiffnessOptions::new(h) };
    stiffness_in_tetrahedra((bodies, specimen), &phases, &options, h, &Silent).unwrap()
}

/// A layer across z, through the whole cube.
fn layer() -> Vec<Aggregate> {
    let corner = |number: usize| {
        let at = |axis: usize, low: f64, high: f64| if number >> axis & 1 == 0 { low } else { high };
        Vec3::new(at(0, 0.0, SIDE), at(1, 0.0, SIDE), at(2, 3.3, 10.7))
    };
    vec![aggregate(convex_hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap(), 0.0)]
}

#[test]
fn layers_along_an_axis_are_exact_in_tetrahedra() {
    for value in [0.0, 0.3, 3.0, 1e4] {
        let found = solve(&layer(), &cube(SIDE, false), &phases(1.0, value, 1.0), 2.5);
        let parallel = 0.63 + 0.37 * value;
        let series = if value > 0.0 { 1.0 / (0.63 + 0.37 / value) } else { 0.0 };
        for (axis, exact) in [parallel, parallel, series].into_iter().enumerate() {
            let error = (entry(&found, axis, axis) - exact).abs() / parallel;
            assert!(error < 1e-6, "{error} along {axis} for {value}");
        }
    }
}

#[test]
#[ignore = "slow tier: half a minute of processor time"]
fn layers_at_an_angle_are_within_one_percent_in_tetrahedra() {
    let normal = Vec3::new(1.0, 1.0, 0.0);
    let period = SIDE / normal.norm();
    let bodies = slabs(normal, period, 0.4 * period, SIDE);
    for value in [0.0, 10.0, 1e4] {
        let error = off(&solve(&bodies, &cube(SIDE, true), &phases(1.0, value, 1.0), 2.0), normal, 0.4, value);
        assert!(error < 0.01, "{error} for {value}");
    }
}

/// A sphere in the middle of nothing in a periodic cube of 10 mm: a polyhedron of its volume.
fn body(radius: f64, thickness: f64) -> Aggregate {
    aggregate(sphere(Vec3::new(5.1, 4.8, 5.3), radius, 4), thickness)
}

fn array(radius: f64, value: f64, h: f64) -> Effective {
    solve(&[body(radius, 0.0)], &cube(10.0, true), &phases(1.0, value, 1.0), h)
}

#[test]
fn spheres_in_a_cubic_array_have_the_published_values_in_tetrahedra() {
    for value in [0.0, 0.3, 3.0, 10.0, 1e4] {
        let (found, exact) = (array(4.0, value, 0.625), cubic_array(4.0 / 3.0 * PI * 0.064, value));
        let diagonal = [0, 1, 2].map(|axis| entry(&found, axis, axis) / exact - 1.0);
        assert!(diagonal.iter().all(|error| error.abs() < 0.005), "{diagonal:?} for {value}");
        // The bounds of Hashin and Shtrikman are crossed within the stated error at most.
        let (bounds, d, error) = (found.bounds, entry(&found, 0, 0), found.error[0][0].unwrap());
        let (low, high) = (bounds.hashin_shtrikman_lower - error, bounds.hashin_shtrikman_upper + error);
        assert!(d > low && d < high, "{d} is outside {low} to {high} for {value}");
    }
}

#[test]
fn few_impermeable_spheres_take_one_and_a_half_of_their_volume_in_tetrahedra() {
    let fraction = 4.0 / 3.0 * PI * 0.001;
    let found = solve_along(X, &[body(1.0, 0.0)], &cube(10.0, true), &phases(1.0, 0.0, 1.0), 0.2);
    let slope = (entry(&found, 0, 0) - 1.0) / fraction;
    assert!((slope / -1.5 - 1.0).abs() < 0.01, "{slope}");
}

/// Films on impermeable cores, and layers of elements on others. The sphere has 1,280 triangles.
#[test]
fn a_thin_conductive_shell_is_exact_at_ten_elements_a_radius() {
    for (core, shell) in [(0.0, 10.0), (0.0, 1000.0), (2.0, 50.0), (2.0, 0.1)] {
        let (radius, thickness) = (3.0, 0.03);
        let phases = phases(1.0, core, shell);
        let bodies = [aggregate(sphere(Vec3::new(4.1, 3.8, 4.3), radius, 3), thickness)];
        let found = solve_along(X, &bodies, &cube(8.0, true), &phases, 8.0 / 26.0);
        let exact = cubic_array(4.0 / 3.0 * PI * 0.375_f64.powi(3), coated(core, shell, 1.0 - thickness / radius));
        let error = entry(&found, 0, 0) / exact - 1.0;
        assert!(error.abs() < 0.01, "{error} for {core}, {shell}");
    }
}

/// Voxels of an eighth of the smallest grain are within 0.2 % of voxels half as large.
#[test]
fn packings_have_the_values_of_voxels_in_tetrahedra() {
    let model = packing(0.4, 24.0, ", periodic = [\"x\", \"y\", \"z\"]");
    let options = EffectiveOptions { axes: X, ..EffectiveOptions::new(Property::Diffusivity, 0.625) };
    let phases = phases(1.0, 0.0, 1.0);
    let found = effective_in_tetrahedra(&model, &phases, &options, 0.75, &Silent).unwrap().0;
    let voxels = meso_effective::effective(&model, &phases, &options, &Silent).unwrap().0;
    let (one, other) = (entry(&found, 0, 0), entry(&voxels, 0, 0));
    assert!((one / other - 1.0).abs() < 0.01, "{one} {other}");
}

#[test]
fn tetrahedra_are_the_same_on_any_number_of_threads() {
    let model = packing(0.3, 25.0, "");
    let [one, many] = [1, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let options = EffectiveOptions { fields: true, ..EffectiveOptions::new(Property::Diffusivity, 1.5) };
            let (found, fields) =
                effective_in_tetrahedra(&model, &phases(1.0, 0.0, 7.0), &options, 1.5, &Silent).unwrap();
            let mut bytes = serde_json::to_vec(&found).unwrap();
            fields.iter().for_each(|field| field.write(&mut bytes).unwrap());
            let options = StiffnessOptions::new(2.5);
            let found = stiffness_in_tetrahedra(&model, &PhaseModuli::default(), &options, 2.5, &Silent).unwrap().0;
            bytes.extend(serde_json::to_vec(&found).unwrap());
            bytes
        })
    });
    assert!(one == many && one.len() > 100_000);
}

#[test]
fn a_cylinder_has_a_value_between_its_flat_ends() {
    let text = "fraction = 0.2\nspecimen = { kind = \"cylinder\", diameter_mm = 40, height_mm = 40 }";
    let model = pack(&Spec::from_toml(text).unwrap(), &Silent).unwrap();
    let along = |axes: [bool; 3], aggregate: f64| {
        let options = EffectiveOptions { axes, ..EffectiveOptions::new(Property::Diffusivity, 2.5) };
        effective_in_tetrahedra(&model, &phases(1.0, aggregate, 1.0), &options, 2.5, &Silent)
    };
    let z = [false, false, true];
    // The chords of the mantle lean a little, and it is insulated.
    let plain = entry(&along(z, 1.0).unwrap().0, 2, 2);
    assert!((plain - 1.0).abs() < 2e-3, "{plain}");
    let (found, bounds) = along(z, 0.0).map(|(found, _)| (entry(&found, 2, 2), found.bounds)).unwrap();
    assert!(found < bounds.hashin_shtrikman_upper && found > 0.6, "{found} {bounds:?}");
    assert!(matches!(along([true; 3], 0.0), Err(EffectiveError::Ends)));
    let options = StiffnessOptions::new(2.5);
    let refused = stiffness_in_tetrahedra(&model, &PhaseModuli::default(), &options, 2.5, &Silent);
    assert!(matches!(refused, Err(EffectiveError::Specimen("cylinder"))));
}

/// Walls across the layers keep them from nothing. The mesh rounds the seams where a layer meets its periodic images.
#[test]
fn periodic_layers_have_their_stiffness_in_tetrahedra() {
    let specimen = Specimen::Cube { side_mm: SIDE, periodic: Periodic([true, true, false]) };
    let (found, _) = stiffness(&layer(), &specimen, STONE, 2.5);
    let [across, shear_across, shear_along] = laminate();
    for (row, exact) in [(2, across), (3, shear_across), (4, shear_across), (5, shear_along)] {
        let value = found.fine[row][row];
        assert!((value / exact - 1.0).abs() < 1e-3, "{value} {exact} in row {row}");
    }
}

/// Levin (Mech. Solids 2, 1967, 58), as for voxels.
#[test]
fn expansion_follows_levin_in_tetrahedra() {
    let (found, _) = stiffness(&[body(3.5, 0.0)], &cube(10.0, true), STONE, 0.625);
    let inverse = |of: &Moduli| 1.0 / of.bulk();
    let fraction = 4.0 / 3.0 * PI * 0.042_875;
    let mix = |mortar: f64, stone: f64| (1.0 - fraction) * mortar + fraction * stone;
    let slope = (STONE.eigenstrain - MORTAR.eigenstrain) / (inverse(&STONE) - inverse(&MORTAR));
    let away = 1.0 / found.isotropic.bulk_modulus_mpa - mix(inverse(&MORTAR), inverse(&STONE));
    let exact = mix(MORTAR.eigenstrain, STONE.eigenstrain) + slope * away;
    for axis in 0..3 {
        assert!((found.expansion[axis] - exact).abs() < 0.005 * exact.abs(), "{:?} {exact}", found.expansion);
    }
    // The bounds are kept within the stated error.
    let (bulk, k) = (found.bounds.bulk_modulus_mpa, found.isotropic.bulk_modulus_mpa);
    let error = found.isotropic_error.bulk_modulus_mpa;
    let (low, high) = (bulk.hashin_shtrikman_lower - error, bulk.hashin_shtrikman_upper + error);
    assert!(k > low && k < high && error < 0.01 * k, "{k} {bulk:?} {error}");
}

/// A deck of C3D4 whose outer nodes have the displacements of a strain.
fn deck(mesh: &Mesh, stone: &Moduli, strain: [[f64; 3]; 3]) -> String {
    let mut deck = String::from("*NODE, NSET=ALL\n");
    for (number, point) in mesh.points.iter().enumerate() {
        writeln!(deck, "{}, {:.12}, {:.12}, {:.12}", number + 1, point.x, point.y, point.z).unwrap();
    }
    for (phase, name, moduli) in [(Phase::Mortar, "MORTAR", &MORTAR), (Phase::Aggregate, "STONE", stone)] {
        writeln!(deck, "*ELEMENT, TYPE=C3D4, ELSET={name}").unwrap();
        for (number, cell) in mesh.cells().enumerate().filter(|(number, _)| mesh.phase[*number] == phase) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| cell[corner] + 1);
            writeln!(deck, "{}, {a}, {b}, {c}, {d}", number + 1).unwrap();
        }
        let (e, nu) = (moduli.youngs_modulus_mpa, moduli.poisson_ratio);
        writeln!(deck, "*MATERIAL, NAME={name}\n*ELASTIC\n{e:.1}, {nu}").unwrap();
        writeln!(deck, "*SOLID SECTION, ELSET={name}, MATERIAL={name}").unwrap();
    }
    deck.push_str("*STEP\n*STATIC\n*BOUNDARY\n");
    let is_outer = |point: &Vec3| point.iter().any(|x| x.abs() < 1e-9 || (x - 10.0).abs() < 1e-9);
    for (number, point) in mesh.points.iter().enumerate().filter(|(_, point)| is_outer(point)) {
        for (axis, row) in strain.iter().enumerate() {
            let displacement: f64 = (0..3).map(|i| row[i] * point[i]).sum();
            writeln!(deck, "{}, {}, {}, {displacement:.12e}", number + 1, axis + 1, axis + 1).unwrap();
        }
    }
    deck.push_str("*EL PRINT, ELSET=MORTAR, TOTALS=ONLY\nELSE\n*EL PRINT, ELSET=STONE, TOTALS=ONLY\nELSE\n*END STEP\n");
    deck
}

/// The elastic energy that CalculiX finds; `None` without it.
fn energy(deck: &str) -> Option<f64> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.inp"), deck).unwrap();
    let Ok(run) = Command::new("ccx").args(["-i", "job"]).current_dir(folder.path()).output() else {
        eprintln!("skipped: no `ccx` here (Debian: calculix-ccx)");
        return None;
    };
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stdout));
    let text = std::fs::read_to_string(folder.path().join("job.dat")).unwrap();
    let totals = text.split("total internal energy").skip(1);
    Some(totals.map(|block| block.lines().nth(2).unwrap().trim().parse::<f64>().unwrap()).sum())
}

#[test]
fn moduli_are_those_of_calculix_on_the_same_tetrahedra() {
    let bodies = [aggregate(sphere(Vec3::new(5.1, 4.8, 5.3), 3.0, 2), 0.0)];
    let (found, fields) = stiffness(&bodies, &cube(10.0, false), STONE, 1.25);
    let FieldCells::Tetrahedra(mesh) = &fields[0].cells else { panic!("the cells are tetrahedra") };
    for (entry, strain) in [
        (found.fine[0][0], [[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]]),
        (found.fine[3][3], [[0.0; 3], [0.0, 0.0, 0.5], [0.0, 0.5, 0.0]]),
    ] {
        let Some(energy) = energy(&deck(mesh, &STONE, strain.map(|row| row.map(|x| 1e-3 * x)))) else { return };
        let theirs = 2.0 * energy / 1e-6 / 1000.0;
        assert!((entry / theirs - 1.0).abs() < 1e-4, "ours {entry}, theirs {theirs}");
    }
}

/// The result under some conditions at walls.
fn bounded(
    boundary: Boundary,
    bodies: &[Aggregate],
    specimen: &Specimen,
    value: f64,
) -> Result<Effective, EffectiveError> {
    let options = EffectiveOptions { boundary, ..EffectiveOptions::new(Property::Diffusivity, 2.5) };
    effective_in_tetrahedra((bodies, specimen), &phases(1.0, value, 1.0), &options, 2.5, &Silent)
        .map(|(found, _)| found)
}

/// A uniform flux across layers makes every plane an equipotential, and so does a uniform gradient along them.
#[test]
fn layers_are_exact_under_uniform_flux_and_uniform_gradient() {
    let specimen = cube(SIDE, false);
    for value in [0.3, 50.0] {
        let [gradient, flux] = [Boundary::UniformGradient, Boundary::UniformFlux]
            .map(|boundary| bounded(boundary, &layer(), &specimen, value).unwrap());
        let (parallel, series) = (0.63 + 0.37 * value, 1.0 / (0.63 + 0.37 / value));
        for axis in 0..2 {
            assert!((entry(&gradient, axis, axis) / parallel - 1.0).abs() < 1e-6, "{gradient:?}");
            assert!(entry(&flux, axis, axis) < parallel && entry(&flux, axis, axis) > series, "{flux:?}");
        }
        assert!((entry(&flux, 2, 2) / series - 1.0).abs() < 1e-6, "{flux:?}");
        assert!(entry(&gradient, 2, 2) > series, "{gradient:?}");
        assert_eq!(flux.resolution.boundary, ["uniform-flux"; 3]);
    }
}

#[test]
fn uniform_flux_and_uniform_gradient_enclose_fixed_ends() {
    let model = packing(0.3, 25.0, "");
    let [fixed, gradient, flux] = [Boundary::Fixed, Boundary::UniformGradient, Boundary::UniformFlux].map(|boundary| {
        let options = EffectiveOptions { boundary, ..EffectiveOptions::new(Property::Diffusivity, 2.0) };
        effective_in_tetrahedra(&model, &phases(1.0, 0.0, 1.0), &options, 2.0, &Silent).unwrap().0
    });
    for axis in 0..3 {
        let [low, middle, high] = [&flux, &fixed, &gradient].map(|found| found.fine[axis][axis].unwrap());
        assert!(low < middle && middle < high && high < 1.1 * low, "{low} {middle} {high} along {axis}");
    }
    let off = (entry(&flux, 0, 1) - entry(&flux, 1, 0)).abs();
    assert!(off < 1e-4, "{off}");
}

#[test]
fn uniform_conditions_are_refused_where_they_have_no_meaning() {
    let (walls, periodic) = (cube(SIDE, false), cube(SIDE, true));
    let said = |boundary, specimen, value| bounded(boundary, &layer(), specimen, value).unwrap_err().to_string();
    for boundary in [Boundary::UniformGradient, Boundary::UniformFlux] {
        let text = said(boundary, &periodic, 2.0);
        assert!(text.ends_with("the specimen must be a cube, a box or a prism that has walls on all sides"), "{text}");
    }
    let text = said(Boundary::UniformFlux, &walls, 0.0);
    assert_eq!(
        text,
        "effective.boundary is uniform-flux; a phase without conduction meets a wall, and no flux enters there"
    );
    let options =
        EffectiveOptions { boundary: Boundary::UniformFlux, ..EffectiveOptions::new(Property::Diffusivity, 2.5) };
    let text = meso_effective::effective((&[][..], &walls), &Phases::default(), &options, &Silent).err().unwrap();
    assert!(text.to_string().ends_with("take the method lattice"), "{text}");
}

#[test]
fn element_sizes_out_of_range_are_refused_by_name() {
    let options = EffectiveOptions::new(Property::Diffusivity, 1.0);
    for size in [0.0, 1e-3, 6.0] {
        let refused =
            effective_in_tetrahedra((&[][..], &cube(SIDE, true)), &Phases::default(), &options, size, &Silent);
        let said = refused.err().unwrap().to_string();
        assert!(said.starts_with(&format!("effective.element_size_mm is {size};")), "{said}");
    }
}
