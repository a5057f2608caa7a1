//! How far interfaces lie from the exact surfaces, by figures known beforehand.

use crate::mesh::voxel::{aggregate, block, turned_blocks};
use meso_core::math::Vec3;
use meso_core::mesh::{self, Fit, InterfaceDistance, ItzForm, MeshOptions, Method, Order, Tools};
use meso_core::specimen::{Periodic, Specimen};

fn distance(block_mm: f64, specimen: &Specimen, itz: ItzForm) -> InterfaceDistance {
    let grains = [aggregate(0, block([2.0; 3], [block_mm; 3]), 0.5)];
    let options = MeshOptions {
        element_size_mm: 1.0,
        itz,
        method: Method::Voxel { thin_itz: true, subsamples: 1 },
        ..Default::default()
    };
    InterfaceDistance::of(&mesh::build((&grains, specimen), &options, &Tools::default()).unwrap(), &grains, specimen)
}

#[test]
fn an_aligned_block_of_voxels_has_no_distance_and_one_that_falls_short_has_the_rest() {
    let specimen = Specimen::cube(10.0);
    for itz in [ItzForm::Solid, ItzForm::Cohesive, ItzForm::None] {
        let exact = distance(6.0, &specimen, itz);
        assert_eq!((exact.nodes, exact.max_mm, exact.rms_mm), (5_usize.pow(3) - 3_usize.pow(3), 0.0, 0.0), "{itz:?}");
    }
    // Upper faces at 6.2, of which voxels know nothing: 64 - 27 of 98 nodes lie 0.2 below one and on no lower one.
    let short = distance(6.2, &specimen, ItzForm::None);
    assert!((short.max_mm - 0.2).abs() < 1e-12 && (short.rms_mm - 0.2 * (37.0_f64 / 98.0).sqrt()).abs() < 1e-12);
    // At 5.8 seven voxels' corners lie outside: at most sqrt(3) 0.2 from the block's corner.
    assert!((distance(5.8, &specimen, ItzForm::None).max_mm - 0.2 * 3.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn an_aggregate_that_comes_in_again_is_measured_by_its_nearest_image() {
    let specimen = Specimen::Cube { side_mm: 10.0, periodic: Periodic([true; 3]) };
    let moved = block([2.0; 3], [6.0; 3]).translated(&Vec3::new(-4.0, 0.0, 0.0));
    let grains = [aggregate(7, moved, 0.5)];
    let options = MeshOptions { element_size_mm: 1.0, itz: ItzForm::None, ..Default::default() };
    let mesh = mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap();
    assert!(mesh.points.iter().zip(0u32..).any(|(p, _)| p.x > 7.0), "the image is there");
    let found = InterfaceDistance::of(&mesh, &grains, &specimen);
    assert!(found.nodes > 90 && found.max_mm < 1e-12, "{found:?}");
}

#[test]
fn a_fitted_lattice_lies_nearer_than_a_plain_one_and_both_halve_with_the_elements() {
    let (grains, specimen) = turned_blocks();
    let of = |method, element_size_mm| {
        let options = MeshOptions { method, itz: ItzForm::None, element_size_mm, ..Default::default() };
        InterfaceDistance::of(
            &mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap(),
            &grains,
            &specimen,
        )
        .rms_mm
    };
    let (plain, finer, fitted) = (of(Method::PLAIN, 2.0), of(Method::PLAIN, 1.0), of(Method::FITTED, 2.0));
    assert!(plain > 0.2 && finer < 0.6 * plain && fitted < 0.1 * plain, "{plain} {finer} {fitted}");
}

#[test]
fn second_order_is_measured_at_its_corners() {
    let (grains, specimen) = turned_blocks();
    let of = |order| {
        let method = Method::Lattice { fit: Fit::Fitted, order };
        let options = MeshOptions { method, itz: ItzForm::None, element_size_mm: 2.5, ..Default::default() };
        InterfaceDistance::of(
            &mesh::build((&grains, &specimen), &options, &Tools::default()).unwrap(),
            &grains,
            &specimen,
        )
    };
    assert_eq!(of(Order::Quadratic), of(Order::Linear));
}
