//! What has to hold for any bytes that a user or a program hands over. The tests feed these with mutated files, `fuzz/` with
//! whatever libFuzzer finds.
//!
//! Nothing may panic, and nothing accepted may break its promise. Requests for much work are left alone.

use meso_core::check::check;
use meso_core::geometry::convex_hull;
use meso_core::gjk::{self, Algorithm};
use meso_core::import::volume;
use meso_core::materials::Materials;
use meso_core::math::Vec3;
use meso_core::mesh::{self, ItzForm, MeshOptions, Tools};
use meso_core::packing::Strategy;
use meso_core::spec::{Files, Spec, options_from_toml};
use meso_core::{Model, Silent, pack, saved};
use std::io;

/// A target by its name.
pub(crate) type Target = (&'static str, fn(&[u8]));

/// All of them.
pub(crate) const TARGETS: [Target; 10] = [
    ("spec", spec),
    ("saved-model", saved_model),
    ("stl", stl),
    ("sieve-table", sieve_table),
    ("volume", label_volume),
    ("materials", materials),
    ("hull", hull),
    ("offset", offset),
    ("collision", collision),
    ("tiny-mesh", tiny_mesh),
];

/// More aggregates than this are too much work for one case.
const MOST: f64 = 300.0;

/// One file beside a spec, whatever its name.
struct One<'a>(&'a [u8]);

impl Files for One<'_> {
    fn read(&mut self, _: &str) -> io::Result<Vec<u8>> {
        Ok(self.0.to_vec())
    }

    fn list(&mut self, _: &str) -> io::Result<Vec<String>> {
        Ok(vec!["a.stl".to_owned()])
    }
}

/// A spec that is read is valid, and is read again from what it says of itself.
pub(crate) fn spec(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(spec) = Spec::from_toml(text) else { return };
    spec.validate().expect("what was read is valid");
    let saved = serde_json::to_value(&spec).expect("a spec can be saved");
    assert_eq!(serde_json::from_value::<Spec>(saved).expect("it can be read again"), spec);
    spec.doubts();
}

/// A model that is read can be checked, written, and read again as the same.
pub(crate) fn saved_model(bytes: &[u8]) {
    let Ok(model) = saved::read(bytes) else { return };
    if model.spec.estimated_aggregates() < MOST && model.aggregates.len() < 1000 {
        let _ = check(&model).findings.len();
    }
    let mut written = Vec::new();
    saved::write(&model, &mut written).expect("memory takes all");
    assert_eq!(saved::read(&written).expect("what was written can be read"), model);
}

/// A surface in each format encloses something as a specimen, and is grains of a library, or it is refused.
pub(crate) fn stl(bytes: &[u8]) {
    for ending in ["stl", "ply", "obj", "off"] {
        let text = format!("fraction = 0.1\nspecimen = {{ kind = 'mesh', file = 'a.{ending}' }}\n");
        if let Ok(spec) = Spec::from_toml_with(&text, &mut One(bytes)) {
            assert!(spec.specimen.volume() > 0.0);
        }
        for hull in [false, true] {
            let text = format!("[shape]\nlibrary = 'a.{ending}'\nhull = {hull}\n");
            if let Ok(spec) = Spec::from_toml_with(&text, &mut One(bytes)) {
                assert!(!spec.shape.grains.is_empty());
            }
        }
    }
}

/// A sieve table that is read ascends from at least 0 to 1.
pub(crate) fn sieve_table(bytes: &[u8]) {
    let text = "[grading]\ncurve = { kind = 'sieves', file = 'a.csv' }\nd_min_mm = 4\nd_max_mm = 16\n";
    let Ok(spec) = Spec::from_toml_with(text, &mut One(bytes)) else { return };
    let shares: f64 = spec.grading.classes().iter().map(|class| class.share).sum();
    assert!((shares - 1.0).abs() < 1e-9, "the classes take all: {shares}");
}

/// A label volume in each format has a label for every voxel, or it is refused.
pub(crate) fn label_volume(bytes: &[u8]) {
    for ending in volume::ENDINGS {
        let Ok(volume) = volume::read::<u8>(&format!("a.{ending}"), bytes) else { continue };
        assert_eq!(volume.of.len(), volume.counts.iter().product::<usize>());
        assert!(volume.of.iter().all(|number| usize::from(*number) < volume.labels.len()));
    }
}

/// Materials that are read have finite figures.
pub(crate) fn materials(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(materials) = options_from_toml::<Materials>(text) else { return };
    let _ = materials.mortar.wave_speed_mm_per_s();
}

/// Three bytes a coordinate: lattices, repeated and nearly coplanar points come often.
fn points(bytes: &[u8]) -> Vec<Vec3> {
    let number = |b: &[u8]| f64::from(b[0] as i8) + f64::from(b[1] as i8) * 2f64.powi(-i32::from(b[2] % 60));
    bytes.chunks_exact(9).map(|p| Vec3::new(number(p), number(&p[3..]), number(&p[6..]))).take(60).collect()
}

/// A hull has all points inside, by the exact answer of a query of its own.
pub(crate) fn hull(bytes: &[u8]) {
    let points = points(bytes);
    let Ok(hull) = convex_hull(&points) else { return };
    assert!(hull.volume() > 0.0);
    for point in &points {
        let inside = Algorithm::Exact.intersects(hull.vertices(), &[*point]).expect("finite numbers");
        assert!(inside, "{point} of {points:?}");
    }
}

/// An inner body lies within its outer one and is smaller.
pub(crate) fn offset(bytes: &[u8]) {
    let Some((&depth, rest)) = bytes.split_first() else { return };
    let Ok(body) = convex_hull(&points(rest)) else { return };
    let thickness = f64::from(depth) / 64.0;
    let Ok(Some(inner)) = body.inward_offset(thickness) else { return };
    assert!(inner.volume() <= body.volume() * (1.0 + 1e-9));
    let (outer, within) = (body.aabb(), inner.aabb());
    let slack = 1e-9 * (1.0 + outer.size().max());
    for axis in 0..3 {
        assert!(within.min[axis] >= outer.min[axis] + thickness - slack);
        assert!(within.max[axis] <= outer.max[axis] - thickness + slack);
    }
}

/// All searches agree, whichever body comes first, and a distance is 0 on contact alone.
pub(crate) fn collision(bytes: &[u8]) {
    let points = points(bytes);
    if points.len() < 2 {
        return;
    }
    let (a, b) = points.split_at(points.len() / 2);
    let exact = Algorithm::Exact.intersects(a, b).expect("finite numbers");
    for method in Algorithm::ALL {
        assert_eq!(method.intersects(a, b).expect("finite numbers"), exact, "{method:?}: {a:?} {b:?}");
        assert_eq!(method.intersects(b, a).expect("finite numbers"), exact, "{method:?} swapped");
    }
    assert_eq!(gjk::distance(a, b).expect("finite numbers") == 0.0, exact, "{a:?} {b:?}");
}

/// A tiny packing of a spec is sound, and its meshes have cells that fill the specimen.
pub(crate) fn tiny_mesh(bytes: &[u8]) {
    let Some(model) = tiny(bytes) else { return };
    let found = check(&model).findings;
    assert!(found.is_empty(), "{found:?}");
    for method in [mesh::Method::VOXEL, mesh::Method::FITTED] {
        let element_size_mm = model.spec.specimen.aabb().size().min() / 6.0;
        let options = MeshOptions { method, element_size_mm, itz: ItzForm::Cohesive, ..MeshOptions::default() };
        let Ok(mesh) = mesh::build(&model, &options, &Tools::default()) else { continue };
        let filled = mesh::PhaseVolumes::of_mesh(&mesh).total() / model.spec.specimen.volume();
        assert!(filled > 0.5 && filled < 1.5, "{filled}");
    }
}

/// A packing of what the bytes ask for: kind, size, fraction, seed, shape.
fn tiny(bytes: &[u8]) -> Option<Model> {
    let &[kind, size, share, seed, shape, gap, ..] = bytes else { return None };
    let size = 20.0 + f64::from(size % 16);
    let specimen = match kind % 4 {
        0 => format!("{{ kind = 'cube', side_mm = {size} }}"),
        1 => format!("{{ kind = 'cylinder', diameter_mm = {size}, height_mm = {size} }}"),
        2 => format!("{{ kind = 'sphere', diameter_mm = {size} }}"),
        _ => format!("{{ kind = 'cube', side_mm = {size}, periodic = ['x', 'y', 'z'] }}"),
    };
    let shape = ["polyhedron", "rounded", "crushed"][usize::from(shape % 3)];
    let (share, gap) = (0.05 + f64::from(share % 30) / 100.0, f64::from(gap % 8) / 20.0);
    let text = format!(
        "fraction = {share}\nseed = {seed}\nspecimen = {specimen}\nshape = {{ kind = '{shape}' }}\ngrading = {{ d_max_mm = 10 }}\n\
         placement = {{ min_gap_mm = {gap}, attempts = 200 }}\n"
    );
    let mut spec = Spec::from_toml(&text).ok()?;
    spec.placement.strategy = Strategy::TakeAndPlace;
    pack(&spec, &Silent).ok()
}
