//! Periodic boxes: no grain meets another one's image or its own, by explicit images; faces match when cut.

use crate::pack::models::parry_shapes;
use meso_core::aggregate::Aggregate;
use meso_core::check::{Finding, check};
use meso_core::formats::{Format, SurfaceOptions};
use meso_core::geometry::Polyhedron;
use meso_core::images::Images;
use meso_core::math::Vec3;
use meso_core::mesh::{self, MeshOptions, Method, Tools};
use meso_core::packing::{StopReason, Strategy};
use meso_core::specimen::{Period, Periodic, Specimen};
use meso_core::watch::Silent;
use meso_core::{Model, Spec, gjk, pack, saved};

fn periodic(side_mm: f64, axes: [bool; 3]) -> Specimen {
    Specimen::Cube { side_mm, periodic: Periodic(axes) }
}

fn packed(specimen: Specimen, strategy: Strategy, fraction: f64) -> Model {
    let mut spec = Spec { fraction, specimen, ..Spec::default() };
    spec.placement.strategy = strategy;
    pack(&spec, &Silent).unwrap()
}

/// The displacements to all images next to the box, itself first.
fn around(specimen: &Specimen) -> Vec<Vec3> {
    let period: Period = specimen.period();
    let steps = |axis: usize| match period.along(axis) {
        Some(length) => vec![0.0, -length, length],
        None => vec![0.0],
    };
    let mut all = Vec::new();
    for z in steps(2) {
        for y in steps(1) {
            all.extend(steps(0).into_iter().map(|x| Vec3::new(x, y, z)));
        }
    }
    all
}

/// Every pair, each with the second one's images, by the exact verdict and by parry; the number of pairs across a face.
fn assert_apart_with_images(model: &Model) -> usize {
    let shapes = parry_shapes(model);
    let here = parry3d_f64::math::Pose::IDENTITY;
    let mut across = 0;
    for shift in around(&model.spec.specimen) {
        let there = parry3d_f64::math::Pose::translation(shift.x, shift.y, shift.z);
        let moved: Vec<Polyhedron> = model.aggregates.iter().map(|a| a.body.translated(&shift)).collect();
        for (i, a) in model.aggregates.iter().enumerate() {
            for (j, b) in moved.iter().enumerate().filter(|(j, _)| *j < i || (*j == i && shift != Vec3::zeros())) {
                if !a.body.aabb().intersects(&b.aabb()) {
                    continue;
                }
                across += usize::from(shift != Vec3::zeros());
                assert!(!gjk::intersects(a.body.vertices(), b.vertices()).unwrap(), "{i} and {j} moved by {shift}");
                let contact = parry3d_f64::query::contact(&here, &shapes[i], &there, &shapes[j], 0.0).unwrap();
                assert!(contact.is_none_or(|contact| contact.dist > -1e-6), "{i} and {j}: {contact:?}");
            }
        }
    }
    across
}

#[test]
fn no_grain_meets_an_image_in_one_two_or_three_directions() {
    for (axes, strategy, fraction) in [
        ([true; 3], Strategy::TakeAndPlace, 0.35),
        ([true; 3], Strategy::Rearrange, 0.6),
        ([false, true, false], Strategy::Rearrange, 0.55),
        ([true, false, true], Strategy::Rearrange, 0.55),
    ] {
        let model = packed(periodic(45.0, axes), strategy, fraction);
        assert_eq!(model.report.stop_reason, StopReason::TargetReached, "{}", model.report.stop_detail);
        assert!(assert_apart_with_images(&model) > 50, "grains cross the faces");
        assert_eq!(check(&model).findings, []);
        let (mut inside, mut crossing) = (true, [false; 3]);
        for v in model.aggregates.iter().flat_map(|a| a.body.vertices()) {
            (0..3).filter(|&i| !axes[i]).for_each(|i| inside &= (0.0..=45.0).contains(&v[i]));
            (0..3).for_each(|i| crossing[i] |= !(0.0..=45.0).contains(&v[i]));
        }
        assert!(inside && crossing == axes, "{axes:?}: {crossing:?}");
        // Counted once each, whole.
        let volume: f64 = model.aggregates.iter().map(|a| a.body.volume()).sum();
        assert!((volume / 91_125.0 - model.report.fraction).abs() < 1e-12);
    }
}

#[test]
fn grains_larger_than_half_the_box_do_not_meet_in_any_image() {
    let model = packed(periodic(26.0, [true; 3]), Strategy::Rearrange, 0.4);
    let longest = model.aggregates.iter().map(|a| a.body.aabb().size().max()).fold(0.0, f64::max);
    assert!(longest > 26.0 / 2.0, "{longest}");
    assert_apart_with_images(&model);
    assert_eq!(check(&model).findings, []);
    assert!(model.report.fraction > 0.35, "{}", model.report.stop_detail);
}

#[test]
fn the_check_finds_an_image_that_overlaps_and_an_aggregate_that_meets_itself() {
    let mut model = packed(periodic(60.0, [true; 3]), Strategy::TakeAndPlace, 0.2);
    let middle = Vec3::repeat(30.0);
    let (first, second) = (model.aggregates[0].body.clone(), model.aggregates[1].body.clone());
    let to = |body: &Polyhedron, place: Vec3| body.translated(&(place - body.centroid()));
    model.aggregates.truncate(2);
    model.aggregates[0].body = to(&first, Vec3::new(0.5, 30.0, 30.0));
    model.aggregates[1].body = to(&second, Vec3::new(59.0, 30.0, 30.0));
    assert!(check(&model).findings.contains(&Finding::Overlap { a: 0, b: 1 }));
    model.aggregates[1].body = to(&second, middle);
    assert!(!check(&model).findings.iter().any(|f| matches!(f, Finding::Overlap { .. })));
    let stretched = first.mapped(|v| (v - first.centroid()) * 4.0 + middle);
    model.aggregates.truncate(1);
    model.aggregates[0].body = stretched;
    assert!(check(&model).findings.contains(&Finding::Overlap { a: 0, b: 0 }));
}

#[test]
fn packing_a_periodic_box_is_identical_at_one_and_four_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| packed(periodic(50.0, [true; 3]), Strategy::Rearrange, 0.55))
    };
    assert_eq!(run(1), run(4));
}

/// Corners on a face, bit for bit.
fn corners_at(aggregates: &[Aggregate], axis: usize, place: f64) -> Vec<(u32, [u64; 2])> {
    let mut corners = Vec::new();
    for aggregate in aggregates {
        let on = aggregate.body.vertices().iter().filter(|v| v[axis] == place);
        corners.extend(on.map(|v| (aggregate.id, [v[(axis + 1) % 3].to_bits(), v[(axis + 2) % 3].to_bits()])));
    }
    corners.sort_unstable();
    corners
}

#[test]
fn images_cut_at_the_faces_match_on_opposite_faces_and_fill_the_fraction() {
    let model = packed(periodic(60.0, [true, true, false]), Strategy::Rearrange, 0.5);
    let cut = Images::Cut.of(&model.aggregates, &model.spec.specimen);
    let volume: f64 = cut.iter().map(|a| a.body.volume()).sum();
    assert!((volume / 216_000.0 - model.report.fraction).abs() < 1e-12);
    for axis in 0..2 {
        let (low, high) = (corners_at(&cut, axis, 0.0), corners_at(&cut, axis, 60.0));
        assert!(low.len() > 100, "{}", low.len());
        assert_eq!(low, high);
    }
    assert!(cut.iter().flat_map(|a| a.body.vertices()).all(|v| v.iter().all(|x| (0.0..=60.0).contains(x))));
    let whole = Images::Whole.of(&model.aggregates, &model.spec.specimen);
    assert_eq!(whole.len(), cut.len());
    assert!(whole.len() > model.aggregates.len());
    assert_eq!(Images::None.of(&model.aggregates, &model.spec.specimen), model.aggregates);
}

#[test]
fn a_wall_gap_keeps_the_faces_of_a_periodic_box_from_grazing_aggregates() {
    let gap = 0.05;
    let mut spec = Spec { fraction: 0.5, specimen: periodic(40.0, [true, false, true]), ..Spec::default() };
    spec.placement.wall_gap_mm = gap;
    for seed in 1..=3 {
        let model = pack(&Spec { seed, ..spec.clone() }, &Silent).unwrap();
        assert_eq!(check(&model).findings, []);
        for body in model.aggregates.iter().map(|a| &a.body) {
            let off = |x: f64| (x - (x / 40.0).round() * 40.0).abs();
            for axis in [0, 2] {
                assert!([body.aabb().min, body.aabb().max].iter().all(|end| off(end[axis]) >= gap), "{seed}");
                assert!(body.vertices().iter().all(|v| off(v[axis]) >= 0.02 * gap), "{seed}");
                assert!((0.0..40.0).contains(&body.centroid()[axis]), "{seed}");
            }
        }
        assert!(assert_apart_with_images(&model) > 50);
    }
}

#[test]
fn surfaces_are_written_with_images_and_models_without() {
    let model = packed(periodic(40.0, [true; 3]), Strategy::TakeAndPlace, 0.3);
    let size = |format: Format, images| {
        let mut out = Vec::new();
        format.write(&model, SurfaceOptions { images, ..Default::default() }, &mut out).unwrap();
        out.len()
    };
    assert!(size(Format::Stl, Images::Whole) > size(Format::Stl, Images::None));
    assert!(size(Format::Vtu, Images::Cut) > size(Format::Vtu, Images::None));
    assert_eq!(size(Format::Json, Images::Whole), size(Format::Json, Images::None));
    let mut file = Vec::new();
    saved::write(&model, &mut file).unwrap();
    assert_eq!(saved::read(&file).unwrap().spec.specimen, model.spec.specimen);
    assert!(String::from_utf8(file).unwrap().contains("\"periodic\":[\"x\",\"y\",\"z\"]"));
}

#[test]
fn meshes_of_a_periodic_box_have_matching_faces() {
    let model = packed(periodic(40.0, [true; 3]), Strategy::Rearrange, 0.45);
    for method in [Method::VOXEL, Method::PLAIN] {
        let options = MeshOptions { method, element_size_mm: 1.6, ..Default::default() };
        let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
        let mut phases = [Vec::new(), Vec::new()];
        for (cell, phase) in mesh.cells().zip(&mesh.phase) {
            for (side, place) in [0.0, 40.0].into_iter().enumerate() {
                let mut on: Vec<[u64; 2]> = cell
                    .iter()
                    .map(|&node| mesh.points[node as usize])
                    .filter(|p| p.x == place)
                    .map(|p| [p.y.to_bits(), p.z.to_bits()])
                    .collect();
                on.sort_unstable();
                if on.len() >= 3 {
                    phases[side].push((on, *phase));
                }
            }
        }
        let [mut low, mut high] = phases;
        low.sort();
        high.sort();
        let nodes = |side: &[(Vec<[u64; 2]>, mesh::Phase)]| side.iter().map(|s| s.0.clone()).collect::<Vec<_>>();
        assert!(low.len() > 500);
        assert_eq!(nodes(&low), nodes(&high), "{method:?}: the faces have the same nodes and elements");
    }
    let exact = mesh::PhaseVolumes::exact(&model.aggregates, &model.spec.specimen, |a| a.itz_thickness_mm).unwrap();
    let options = MeshOptions {
        element_size_mm: 1.0,
        method: Method::Voxel { thin_itz: true, subsamples: 1 },
        ..Default::default()
    };
    let mesh = mesh::build(&model, &options, &Tools::default()).unwrap();
    let volumes = mesh::PhaseVolumes::of_mesh(&mesh);
    assert!(((volumes.aggregate + volumes.itz) / (exact.aggregate + exact.itz) - 1.0).abs() < 0.01);
}
