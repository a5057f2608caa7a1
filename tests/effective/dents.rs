//! Bodies with dents: sections of any number of loops, links that cross a surface several times, and shells.

use crate::bodies::{aggregate, cube, entry, phases, solve, sphere};
use crate::stiffness::{MORTAR, STONE, given};
use meso_core::Silent;
use meso_core::aggregate::Aggregate;
use meso_core::geometry::{Polyhedron, TriangleMesh, convex_hull};
use meso_core::math::{Rotation, Vec3};
use meso_effective::{EffectiveOptions, PhaseModuli, Property, StiffnessOptions, effective_in_tetrahedra, stiffness};

const SIDE: f64 = 20.0;

fn turn() -> Rotation {
    Rotation::from_euler_angles(0.3, 0.5, 0.2)
}

fn placed(corner: [f64; 3]) -> Vec3 {
    turn() * Vec3::from(corner) + Vec3::new(5.0, 5.0, 7.0)
}

/// A prism whose section is an L, 6 mm high.
pub(crate) fn angle() -> Polyhedron {
    let outline = [[0.0, 0.0], [8.0, 0.0], [8.0, 3.0], [3.0, 3.0], [3.0, 8.0], [0.0, 8.0]];
    let vertices = [0.0, 6.0].iter().flat_map(|z| outline.map(|[x, y]| placed([x, y, *z]))).collect();
    let top = (1..5).map(|k| [6, 6 + k, 7 + k]);
    let bottom = (1..5).map(|k| [0, k + 1, k]);
    let sides = (0..6).flat_map(|k| {
        let next = (k + 1) % 6;
        [[k, next, next + 6], [k, next + 6, k + 6]]
    });
    Polyhedron::of_surface(&TriangleMesh { vertices, triangles: top.chain(bottom).chain(sides).collect() })
}

/// The two blocks of the L.
fn blocks() -> Vec<Aggregate> {
    let block = |[x, y]: [[f64; 2]; 2]| {
        let corner = |k: usize| placed([x[k & 1], y[k >> 1 & 1], [0.0, 6.0][k >> 2]]);
        aggregate(convex_hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap(), 0.0)
    };
    vec![block([[0.0, 8.0], [0.0, 3.0]]), block([[0.0, 3.0], [3.0, 8.0]])]
}

#[test]
fn an_angle_obstructs_as_its_two_blocks_do() {
    let specimen = cube(SIDE, true);
    let [whole, parts] =
        [vec![aggregate(angle(), 0.0)], blocks()].map(|bodies| solve(&bodies, &specimen, &phases(1.0, 0.0, 0.0), 1.0));
    for (row, column) in [(0, 0), (1, 1), (2, 2), (0, 1)] {
        let (one, other) = (entry(&whole, row, column), entry(&parts, row, column));
        assert!((one - other).abs() < 1e-6, "{one} {other}");
    }
    assert!(entry(&whole, 0, 0) < 0.97);
}

#[test]
fn a_convex_body_conducts_alike_where_it_counts_as_one_with_dents() {
    let specimen = cube(SIDE, true);
    let round = sphere(Vec3::new(9.7, 10.2, 10.4), 7.0, 2);
    for (values, itz, most) in [([0.0, 0.0], 0.0, 1e-6), ([20.0, 0.0], 0.0, 1e-4), ([0.0, 5.0], 0.5, 1e-3)] {
        let [convex, dented] = [round.clone(), round.clone().with_dents()]
            .map(|body| solve(&[aggregate(body, itz)], &specimen, &phases(1.0, values[0], values[1]), 1.0));
        let (one, other) = (entry(&dented, 2, 2), entry(&convex, 2, 2));
        assert!((one / other - 1.0).abs() < most, "{values:?}: {one} {other}");
    }
}

#[test]
fn a_convex_body_is_as_stiff_where_it_counts_as_one_with_dents() {
    let specimen = cube(SIDE, true);
    let round = sphere(Vec3::new(9.7, 10.2, 10.4), 7.0, 2);
    let phases =
        PhaseModuli { mortar: given(MORTAR), aggregate: given(STONE), itz: given(MORTAR), ..Default::default() };
    let [convex, dented] = [round.clone(), round.with_dents()].map(|body| {
        let bodies = [aggregate(body, 0.0)];
        stiffness((&bodies[..], &specimen), &phases, &StiffnessOptions::new(1.25), &Silent).unwrap().0
    });
    assert!((dented.tensor[0][0] / convex.tensor[0][0] - 1.0).abs() < 1e-5);
}

#[test]
fn a_shell_on_an_angle_conducts_alike_in_voxels_and_tetrahedra() {
    let specimen = cube(SIDE, true);
    let bodies = [aggregate(angle(), 0.4)];
    for values in [phases(1.0, 0.0, 8.0), phases(1.0, 3.0, 8.0)] {
        let in_voxels = solve(&bodies, &specimen, &values, 0.5);
        let options = EffectiveOptions::new(Property::Diffusivity, 1.0);
        let (found, _) = effective_in_tetrahedra((&bodies[..], &specimen), &values, &options, 1.0, &Silent).unwrap();
        for axis in 0..3 {
            let (one, other) = (entry(&found, axis, axis), entry(&in_voxels, axis, axis));
            assert!((one / other - 1.0).abs() < 0.02, "{axis}: {one} {other}");
        }
    }
}
