//! When gmsh is asked again, for elements of another size, and when it is not.

use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::{self, MeshError, MeshOptions, Method, Tools};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use std::io;
use std::sync::Mutex;

/// The error of a mesh whose gmsh always fails with `error`, and the sizes that gmsh was asked for after the first, mm.
fn asked(error: impl Fn() -> MeshError + Sync) -> (MeshError, Vec<f64>) {
    let mut spec = Spec { fraction: 0.2, specimen: Specimen::cube(30.0), ..Default::default() };
    (spec.placement.min_gap_mm, spec.placement.wall_gap_mm) = (0.1, 0.1);
    let model = meso_core::pack(&spec, &Silent).unwrap();
    let sizes = Mutex::new(Vec::new());
    let gmsh = |surfaces: &Surfaces| {
        sizes.lock().unwrap().extend(surfaces.again_mm());
        Err(error())
    };
    let options = MeshOptions { method: Method::CONFORMING, element_size_mm: 5.0, ..Default::default() };
    let error = mesh::build(&model, &options, &Tools { gmsh: &gmsh, ..Tools::default() }).unwrap_err();
    (error, sizes.into_inner().unwrap())
}

#[test]
fn a_gmsh_that_breaks_off_is_asked_for_other_sizes_and_its_first_failure_is_reported() {
    let count = Mutex::new(0);
    let (error, sizes) = asked(|| {
        *count.lock().unwrap() += 1;
        MeshError::Gmsh(format!("gmsh failed (signal: 6), time {}", count.lock().unwrap()))
    });
    assert_eq!(error.to_string(), "gmsh failed (signal: 6), time 1");
    assert!(sizes.len() >= 2 && sizes.iter().all(|size| (size / 5.0 - 1.0).abs() < 0.1), "{sizes:?}");
}

#[test]
fn neither_a_stop_nor_a_full_disk_nor_a_missing_gmsh_is_retried() {
    let (stopped, sizes) = asked(|| MeshError::Stopped);
    assert!(matches!(stopped, MeshError::Stopped) && sizes.is_empty(), "{stopped}");
    let full = || MeshError::Files { folder: "/scratch".into(), error: io::Error::from_raw_os_error(28) };
    let (full, sizes) = asked(full);
    assert!(sizes.is_empty() && full.to_string().starts_with("the files for gmsh in /scratch: "), "{full}");
    let (missing, sizes) = asked(|| MeshError::MissingGmsh { program: "gmsh".into(), why: "cannot be run".into() });
    assert!(sizes.is_empty() && missing.to_string().contains("pip install gmsh"), "{missing}");
    assert!(!missing.to_string().contains("--"), "flags are the command's: {missing}");
}
