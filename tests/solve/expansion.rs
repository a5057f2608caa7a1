//! Strains without stress: closed forms of Levin and Lame, layers, courses, and cracks that strains open.

use crate::loads::column;
use crate::samples::{Meshed, brittle, options, voxels};
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::geometry::convex_hull;
use meso_core::materials::{Elastic, Materials};
use meso_core::math::Vec3;
use meso_core::mesh::{ItzForm, Method, Phase, PhaseVolumes};
use meso_core::specimen::Specimen;
use meso_core::watch::Silent;
use meso_solve::{
    Below, Course, Expansion, Frame, LawName, Observer, Response, Rule, Side, SupportSpec, Test, TestKind,
};
use std::cell::RefCell;

/// Largest stress in any cell, MPa.
#[derive(Default)]
struct Most(RefCell<f64>);

impl Observer for Most {
    fn frame(&self, frame: &Frame) {
        let stress = frame.cells(|point| point.stress);
        *self.0.borrow_mut() = stress.iter().flatten().fold(0.0, |most, s| f64::from(s.abs()).max(most));
    }
}

fn expansion(expansion: Expansion) -> Test {
    let expansion = Some(expansion);
    Test { kind: TestKind::Expansion, law: LawName::Elastic, expansion, frames: 1, ..Test::default() }
}

#[test]
fn a_free_body_expands_without_stress() {
    for method in [Method::FITTED, Method::VOXEL] {
        let meshed = Meshed::mortar([12.0, 15.0, 18.0], method, 3.0);
        let most = Most::default();
        let test = expansion(Expansion { mortar: 1e-3.into(), ..Expansion::default() });
        let response = meshed.watched(&brittle(), &test, &Silent, &most);
        let stress = *most.0.borrow() / (brittle().mortar.youngs_modulus_mpa * 1e-3);
        assert!(stress < 1e-6, "{method:?} {stress:e}");
        for name in ["strain_x", "strain_y", "strain_z"] {
            let strain = *column(&response, name).last().unwrap();
            assert!((strain / 1e-3 - 1.0).abs() < 1e-6, "{name} {strain}");
        }
    }
}

#[test]
fn two_phases_expand_as_levin_says() {
    let (meshed, materials) = layers();
    let test = expansion(Expansion { aggregate: 1e-3.into(), ..Expansion::default() });
    let response = meshed.solve(&materials, &test);
    // Across the layers no stress acts on the whole, so that the mean strain is that of the phases by volume.
    let across = *column(&response, "strain_y").last().unwrap();
    assert!((across / (1e-3 / 3.0) - 1.0).abs() < 5e-3, "{across}");
}

/// Mean pressure in the aggregate at the last frame, MPa.
struct Squeezed<'a>(&'a Meshed, RefCell<f64>);

impl Observer for Squeezed<'_> {
    fn frame(&self, frame: &Frame) {
        let mesh = &self.0.mesh;
        let stress = frame.cells(|point| point.stress);
        let mut sums = [0.0; 2];
        for (cell, stress) in stress.iter().enumerate().filter(|(cell, _)| mesh.phase[*cell] == Phase::Aggregate) {
            let volume = volume(&mesh.cell(cell).iter().map(|&node| mesh.points[node as usize]).collect::<Vec<_>>());
            let pressure = -f64::from(stress[0] + stress[1] + stress[2]) / 3.0;
            sums = [sums[0] + volume * pressure, sums[1] + volume];
        }
        *self.1.borrow_mut() = sums[0] / sums[1];
    }
}

/// Volume of a tetrahedron, mm3.
fn volume(corners: &[Vec3]) -> f64 {
    (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).dot(&(corners[3] - corners[0])).abs() / 6.0
}

/// A ball of mortar, 24 mm wide, around an aggregate of 14 mm whose surface the mesh follows.
fn sphere_in_shell(element_size_mm: f64) -> Meshed {
    let specimen = Specimen::Sphere { diameter_mm: 24.0 };
    let centre = 0.5 * (specimen.aabb().min + specimen.aabb().max);
    // Fibonacci's points on a sphere.
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let point = |i: u32| {
        let z: f64 = 1.0 - (2.0 * f64::from(i) + 1.0) / 400.0;
        let (sine, cosine) = (turn * f64::from(i)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        centre + 7.0 * Vec3::new(r * cosine, r * sine, z)
    };
    let body = convex_hull(&(0..400).map(point).collect::<Vec<_>>()).unwrap();
    let body = Aggregate {
        id: 0,
        kind: Kind::Aggregate,
        own: None,
        class: 0,
        itz_thickness_mm: 0.0,
        shells: Vec::new(),
        body,
    };
    Meshed::of(&[body], specimen, options(Method::FITTED, element_size_mm, ItzForm::None))
}

/// The case: a sphere of whole cells, jagged and 1.0 of its volume, had 6.1 % too much in elements of this size. Cells that
/// follow its surface have 1.2 % too much, and smoothed ones less.
#[test]
fn a_sphere_that_swells_in_a_shell_has_the_pressure_of_lame() {
    let meshed = sphere_in_shell(1.5);
    let volumes = PhaseVolumes::of_mesh(&meshed.mesh);
    let share = volumes.aggregate / (volumes.aggregate + volumes.mortar);
    let stiffness = 26e3;
    let mut materials = brittle();
    materials.aggregate = materials.mortar;
    materials.aggregate.youngs_modulus_mpa = stiffness;
    let (nu, shell) = (materials.mortar.poisson_ratio, materials.mortar.youngs_modulus_mpa);
    // Timoshenko and Goodier, Sec. 136: strain of the sphere and of the shell's inside under the pressure 1.
    let sphere = (1.0 - 2.0 * nu) / stiffness;
    let shell = (share * (1.0 - 2.0 * nu) + 0.5 * (1.0 + nu)) / (shell * (1.0 - share));
    let expected = 1e-3 / (sphere + shell);
    let seen = Squeezed(&meshed, RefCell::default());
    meshed.watched(
        &materials,
        &expansion(Expansion { aggregate: 1e-3.into(), ..Expansion::default() }),
        &Silent,
        &seen,
    );
    let found = *seen.1.borrow();
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}

/// The case: plates stood off a specimen that had shrunk, so that its modulus was half of its own, and its test a fast one.
#[test]
fn a_specimen_that_shrank_or_swelled_freely_is_pressed_as_one_that_did_not() {
    let meshed = Meshed::mortar([12.0, 12.0, 18.0], Method::FITTED, 3.0);
    // A brittle specimen collapses at its peak, and no collapse is as fast as another; an elastic one shows the plates' own.
    for law in [LawName::Cdp, LawName::Elastic] {
        let strained = |mortar: f64| {
            let expansion = (mortar != 0.0).then(|| Expansion { mortar: mortar.into(), ..Expansion::default() });
            meshed.solve(&brittle(), &Test { expansion, law, ..Test::default() }).result
        };
        let plain = strained(0.0);
        for mortar in [-5e-4, 1e-4] {
            let result = strained(mortar);
            let (own, usual) = (result.figures, plain.figures);
            let [modulus, peak] = [(own.modulus_mpa, usual.modulus_mpa), (own.peak_mpa, usual.peak_mpa)]
                .map(|(found, expected)| found / expected - 1.0);
            assert!(modulus.abs() < 0.01 && peak.abs() < 0.01, "{law:?} {mortar}: {modulus} {peak}");
            assert!((own.peak_strain / usual.peak_strain - 1.0).abs() < 0.03, "{law:?} {mortar}: {result:?}");
            let moving = [&result, &plain].map(|result| result.kinetic_over_internal_to_half_peak);
            let is_slow = law != LawName::Elastic || moving[0] < 1.1 * moving[1];
            assert!(is_slow && result.errors.is_empty(), "{law:?} {mortar}: {moving:?} {result:?}");
        }
    }
}

/// Mean strains along x, y and z at the end of an expansion.
fn ends(response: &Response) -> [f64; 3] {
    ["strain_x", "strain_y", "strain_z"].map(|name| response.result.strains_at_end[name])
}

/// Cells of mortar whose middle third across y is aggregate, without a Poisson effect.
fn layers() -> (Meshed, Materials) {
    let mut meshed = Meshed::mortar([12.0, 12.0, 12.0], Method::VOXEL, 2.0);
    let nodes = meshed.mesh.kind.nodes();
    for (cell, phase) in meshed.mesh.cells.chunks_exact(nodes).zip(&mut meshed.mesh.phase) {
        let y = cell.iter().map(|&node| meshed.mesh.points[node as usize].y).sum::<f64>() / nodes as f64;
        // Symmetric layers: the body does not bend.
        if (y - 6.0).abs() < 2.0 {
            *phase = Phase::Aggregate;
        }
    }
    let mut materials = brittle();
    (materials.mortar.poisson_ratio, materials.aggregate.poisson_ratio) = (0.0, 0.0);
    (meshed, materials)
}

#[test]
fn two_phases_with_courses_of_their_own_expand_as_levin_says_at_every_moment() {
    let (meshed, materials) = layers();
    // Mortar shrinks until day 30, aggregates swell from day 60 to day 120.
    let mortar = Course::Through(vec![[30.0, -2e-4]]);
    let aggregate = Course::Through(vec![[60.0, 0.0], [120.0, 3e-4]]);
    let test = expansion(Expansion { mortar, aggregate, ..Expansion::default() });
    let response = meshed.solve(&materials, &test);
    let smooth = |share: f64| share.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * share.clamp(0.0, 1.0));
    // The growth lasts 48 us for each mm; a row is a mean over the time since the row before.
    let day = |row: usize| (response.curve[row - 1].time_s + response.curve[row].time_s) / 2.0 / (48e-6 * 12.0) * 120.0;
    let found = column(&response, "strain_y");
    let off = |row: usize| {
        let exact = (2.0 * -2e-4 * smooth(day(row) / 30.0) + 3e-4 * smooth((day(row) - 60.0) / 60.0)) / 3.0;
        (found[row] - exact).abs()
    };
    let most = (1..found.len()).map(off).fold(0.0, f64::max);
    assert!(found.len() > 300 && most < 5e-3 * (4e-4 / 3.0), "{most:e}");
}

/// Levin (1967): the strain of a free body follows from its strain under a uniform pressure, on any mesh.
#[test]
fn concrete_whose_aggregates_swell_has_the_strain_that_its_bulk_modulus_gives() {
    let meshed = voxels(24.0, 3, 3.0);
    let mut materials = brittle();
    materials.itz = materials.mortar;
    let bulk = |elastic: &Elastic| elastic.youngs_modulus_mpa / (3.0 - 6.0 * elastic.poisson_ratio);
    let [stone, mortar] = [&materials.aggregate, &materials.mortar].map(bulk);
    let swollen = meshed.solve(&materials, &expansion(Expansion { aggregate: 1e-3.into(), ..Expansion::default() }));
    let pressed = |name: &str, on: Side| SupportSpec {
        name: name.to_owned(),
        on,
        strip: None,
        rule: Rule::Pressure,
        friction: 0.0,
        moves: 0.0,
        pressure_mpa: 10.0,
        stress_ratio: None,
        drive: None,
    };
    let supports = vec![pressed("mantle", Side::Mantle), pressed("bottom", Side::ZMin), pressed("top", Side::ZMax)];
    // A thousandth of what the pressure does.
    let hardly = Expansion { mortar: 1e-7.into(), ..Expansion::default() };
    let squeezed = meshed.solve(&materials, &Test { supports, ..expansion(hardly) });
    let [free, squeezed] = [&swollen, &squeezed].map(|response| ends(response).iter().sum::<f64>());
    let whole = -10.0 / squeezed;
    assert!(mortar < whole && whole < stone, "{whole} {mortar} {stone}");
    let exact = 3e-3 * (1.0 / whole - 1.0 / mortar) / (1.0 / stone - 1.0 / mortar);
    assert!((free / exact - 1.0).abs() < 5e-3, "{free} {exact}");
}

/// A homogeneous body whose layer has a strain has as a whole the strain of the layer times its share.
#[test]
fn a_layer_at_the_surface_strains_the_whole_by_its_share() {
    let shrinkage = |layer_on: Vec<Side>| {
        expansion(Expansion { mortar: (-1e-3).into(), layer_mm: Some(2.0), layer_on, ..Expansion::default() })
    };
    let whole = 1.0 - (8.0_f64 / 12.0).powi(3);
    let mantle = 1.0 - (8.0_f64 / 12.0).powi(2);
    for (layer_on, share) in [(vec![], whole), (vec![Side::ZMax], 1.0 / 6.0), (vec![Side::Mantle], mantle)] {
        for (method, error) in [(Method::VOXEL, 1e-3), (Method::FITTED, 0.15)] {
            let meshed = Meshed::mortar([12.0; 3], method, 2.0);
            let strains = ends(&meshed.solve(&brittle(), &shrinkage(layer_on.clone())));
            // A layer on one side bends the body, and its side strains as the mean does.
            let off = strains.map(|strain| (strain / (-1e-3 * share) - 1.0).abs());
            assert!(off.iter().all(|off| *off < error), "{method:?} {layer_on:?} {strains:?}");
        }
    }
}

/// The case: mortar could not shrink in a layer while the aggregates grew in the whole specimen.
#[test]
fn mortar_that_shrinks_in_a_layer_adds_its_strains_to_those_of_aggregates_that_grow_everywhere() {
    let meshed = voxels(24.0, 3, 3.0);
    let grown = |own: Expansion| {
        let test = Test { law: LawName::Elastic, ..expansion(own) };
        ends(&meshed.solve(&brittle(), &test))
    };
    let (dry, stone) = (Course::from(-2e-4), Course::from(1e-4));
    let shrinks = grown(Expansion { mortar: dry.clone(), layer_mm: Some(6.0), ..Expansion::default() });
    let swells = grown(Expansion { aggregate: stone.clone(), ..Expansion::default() });
    let below = Some(Below { aggregate: stone.clone(), ..Below::default() });
    let both = grown(Expansion { mortar: dry, aggregate: stone, layer_mm: Some(6.0), below, ..Expansion::default() });
    for axis in 0..3 {
        assert!(shrinks[axis] < -2e-5 && swells[axis] > 1e-5, "{shrinks:?} {swells:?}");
        assert!((both[axis] - shrinks[axis] - swells[axis]).abs() < 2e-7, "{both:?} {shrinks:?} {swells:?}");
    }
}

/// Stress along x in the middle of a plate, MPa: in its outer and in its inner layers of cells.
struct Plate<'a>(&'a Meshed, RefCell<[f64; 2]>);

impl Observer for Plate<'_> {
    fn frame(&self, frame: &Frame) {
        let mesh = &self.0.mesh;
        let stress = frame.cells(|point| point.stress[0]);
        let mut sums = [[0.0; 2]; 2];
        for (cell, stress) in mesh.cells().zip(stress) {
            let centre = cell.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / cell.len() as f64;
            if (centre.x - 20.0).abs() < 2.0 && (centre.y - 20.0).abs() < 2.0 {
                let sum = &mut sums[usize::from((centre.z - 4.0).abs() < 2.0)];
                *sum = [sum[0] + f64::from(stress), sum[1] + 1.0];
            }
        }
        *self.1.borrow_mut() = sums.map(|[sum, count]| sum / count);
    }
}

#[test]
fn a_plate_whose_sides_shrink_has_the_stresses_of_its_closed_form_far_from_its_edges() {
    let meshed = Meshed::mortar([40.0, 40.0, 8.0], Method::VOXEL, 2.0);
    let layer_on = vec![Side::ZMin, Side::ZMax];
    let test = expansion(Expansion { mortar: (-1e-4).into(), layer_mm: Some(2.0), layer_on, ..Expansion::default() });
    let seen = Plate(&meshed, RefCell::default());
    meshed.watched(&brittle(), &test, &Silent, &seen);
    let elastic = brittle().mortar;
    // Plane stress, and no force on the whole section: half of the plate shrinks.
    let exact = 0.5 * 1e-4 * elastic.youngs_modulus_mpa / (1.0 - elastic.poisson_ratio);
    let [outer, inner] = *seen.1.borrow();
    assert!((outer / exact - 1.0).abs() < 0.01 && (inner / exact + 1.0).abs() < 0.01, "{outer} {inner} {exact}");
}

/// The case: the servo held the growth back from the first crack on, fifty times as long, and its last strains vibrated.
#[test]
fn aggregates_that_swell_until_concrete_cracks_keep_to_their_time_and_leave_steady_strains() {
    let meshed = voxels(24.0, 3, 3.0);
    for law in [LawName::Cdp, LawName::Meso] {
        let own = Expansion { aggregate: 1e-3.into(), ..Expansion::default() };
        let test = Test { law, frames: 0, ..expansion(own) };
        let response = meshed.solve(&brittle(), &test);
        let result = &response.result;
        assert!(result.energies.dissipated > 1.0 && result.steps == result.steps_planned, "{law:?} {result:?}");
        let longer = meshed.solve(&brittle(), &Test { duration_s: Some(1e-3), ..test });
        let off = [0, 1, 2].map(|axis: usize| ends(&response)[axis] / ends(&longer)[axis] - 1.0);
        assert!(off.iter().all(|off| off.abs() < 0.01), "{law:?} {off:?} {result:?}");
    }
}

#[test]
fn a_layer_without_an_element_is_refused_with_a_size_that_has_one() {
    let meshed = Meshed::mortar([12.0; 3], Method::VOXEL, 3.0);
    let test = expansion(Expansion { mortar: 1e-4.into(), layer_mm: Some(1.0), ..Expansion::default() });
    let error = meso_solve::Run::new(meshed.sample(), &brittle(), &test).err().unwrap().to_string();
    assert!(error.contains("take elements of 2 mm"), "{error}");
}
