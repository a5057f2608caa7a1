//! Young's moduli of a cracked specimen: what it unloads with at a moment of a test.
//!
//! A cell has the share of its stiffness with which its law unloads. The specimen is strained along an axis between smooth ends, and
//! its sides are free. Linear tetrahedra are too stiff: the energy that a quadratic bubble on each edge, alone, would take away is taken
//! from the modulus, and is its error.

use super::cracked::Cracked;
use super::domain::{Domain, Tetrahedron};
use super::solid::Solid;
use crate::effective::At;
use crate::elastic::{ElasticShare, Strained};
use crate::error::{self, EffectiveError};
use crate::moduli::{PhaseModuli, Table};
use crate::resolution::Resolution;
use crate::solutions::reporting;
use crate::solver::{Energy, solve_equations};
use meso_collision::math::{Mat3, Vec3};
use meso_concrete::watch::Watch;
use meso_concrete::{Phase, Ranges, parallel};
use serde::Serialize;

/// Young's moduli of a specimen at a moment of its test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unloading {
    /// Property: `stiffness`.
    pub what: &'static str,
    /// When.
    #[serde(flatten)]
    pub at: At,
    /// Along x, y, z between smooth ends, MPa; `None` where not asked for.
    pub youngs_modulus_mpa: [Option<f64>; 3],
    /// Their errors, MPa.
    pub error: [Option<f64>; 3],
    /// On the tetrahedra, MPa.
    pub fine: [Option<f64>; 3],
    /// Phases with their volumes and the constants before the test.
    pub phases: Vec<ElasticShare>,
    /// The division, and the solutions on it.
    #[serde(flatten)]
    pub resolution: Resolution,
    /// What a reader should know.
    pub warnings: Vec<String>,
}

/// Stiffness that holds the ends, over that of their nodes.
const HELD: f64 = 1e6;
/// Bytes a tetrahedron.
const BYTES: f64 = 900.0;
/// An error above this share of a modulus is worth a warning.
const LARGE: f64 = 0.05;

impl Cracked<'_> {
    /// Refuses constants out of their ranges; the memory that the moduli take at most, bytes.
    ///
    /// # Errors
    /// The first constant, strains without stress, and a tolerance out of its range.
    pub fn accept_moduli(&self, moduli: &PhaseModuli, tolerance: f64) -> Result<f64, EffectiveError> {
        let table = moduli.table(&self.mesh.phases)?;
        error::accept_tolerance(tolerance)?;
        for (phase, of) in self.mesh.phases.all().zip(&table) {
            let key = format!("{}.eigenstrain", self.mesh.phases.name(phase));
            let accepted = "a cracked specimen has no free strain; leave it out";
            Ranges("stiffness").require(key, of.eigenstrain, of.eigenstrain == 0.0, accepted)?;
        }
        Ok(BYTES * (self.mesh.cell_count() * self.mesh.kind.tetrahedra().len()) as f64)
    }
}

/// Young's moduli along some axes of a mesh with cracks.
///
/// # Errors
/// Those of [`Cracked::accept_moduli`], axes without flat ends, and equations that do not converge.
pub fn moduli_in_cracks(
    of: &Cracked<'_>,
    moduli: &PhaseModuli,
    axes: [bool; 3],
    tolerance: f64,
    watch: &dyn Watch,
) -> Result<Unloading, EffectiveError> {
    of.accept_moduli(moduli, tolerance)?;
    let (names, table) = (&of.mesh.phases, moduli.table(&of.mesh.phases)?);
    let domain = of.domain(axes)?;
    let stages = axes.iter().filter(|axis| **axis).count();
    let (mut fine, mut error, mut iterations, mut solver_error) = ([None; 3], [None; 3], Vec::new(), 0.0_f64);
    for axis in (0..3).filter(|axis| axes[*axis]) {
        let report = reporting(watch, iterations.len(), stages);
        let found = Pulled::of(of, &domain, &table, axis).solve(tolerance, &report)?;
        (fine[axis], error[axis]) = (Some(found.modulus), Some(found.excess));
        iterations.push(found.iterations);
        solver_error = solver_error.max(found.error);
    }
    let youngs_modulus_mpa = [0, 1, 2].map(|axis| Some(fine[axis]? - error[axis]?));
    let large = (0..3).any(|axis| youngs_modulus_mpa[axis].zip(error[axis]).is_some_and(|(e, off)| off > LARGE * e));
    let warning = format!("the error is above {} %; solve the test with smaller elements", 100.0 * LARGE);
    let share =
        |(phase, volume): (Phase, f64)| ElasticShare::new(names.name(phase).to_owned(), &table[phase.index()], volume);
    let resolution = Resolution::of_mesh(["smooth"; 3], domain.mesh.cell_count());
    Ok(Unloading {
        what: "stiffness",
        at: of.at,
        youngs_modulus_mpa,
        error,
        fine,
        phases: names.all().zip(of.volumes(&domain, |_| 1.0)).map(share).collect(),
        resolution: Resolution { iterations, solver_error, ..resolution },
        warnings: large.then_some(warning).into_iter().collect(),
    })
}

/// A specimen that is strained along an axis.
struct Pulled<'a> {
    solid: Solid<'a>,
    axis: usize,
}

struct Found {
    modulus: f64,
    excess: f64,
    iterations: usize,
    error: f64,
}

impl<'a> Pulled<'a> {
    fn of(cracked: &Cracked<'_>, domain: &'a Domain, table: &Table, axis: usize) -> Self {
        let parts = cracked.mesh.kind.tetrahedra().len();
        let count = domain.mesh.cell_count();
        let of = parallel::map_short(count, |cell| cracked.mesh.phase[cell / parts].number());
        let left = parallel::map_short(count, |cell| cracked.stiffness_left[cell / parts]);
        // The ends hold their nodes along the axis.
        let edge = libm::cbrt(domain.volume);
        let stiffness = HELD * table[Phase::Mortar.index()].youngs_modulus_mpa * edge;
        let hold = |node: usize, block: &mut [f64; 9]| {
            if is_end(domain, node, axis) {
                block[4 * axis] += stiffness;
            }
        };
        Self { solid: Solid::with(domain, (of, left), table, 0, hold), axis }
    }

    fn solve(mut self, tolerance: f64, report: &dyn Fn(usize, f64)) -> Result<Found, EffectiveError> {
        let mut mean = [0.0; 6];
        mean[self.axis] = 1.0;
        let volume = self.solid.domain.volume;
        let solid = &mut self.solid;
        let nothing = vec![0.0; solid.len()];
        let mut forces = vec![0.0; solid.len()];
        solid.forces(&nothing, &mean, &mut forces);
        for (unknown, node) in solid.unknowns.nodes.iter().enumerate() {
            if is_end(solid.domain, *node as usize, self.axis) {
                forces[3 * unknown + self.axis] = 0.0;
            }
        }
        forces.iter_mut().for_each(|force| *force = -*force);
        let energy = Energy::falling(solid.sums(&nothing, &mean).energy);
        let found = solve_equations(solid, forces, energy, tolerance, report)?;
        let u = &found.potential;
        let modulus = solid.sums(u, &mean).energy / volume;
        let excess = excess(solid, u, &mean, self.axis) / volume;
        Ok(Found { modulus, excess, iterations: found.iterations, error: found.error })
    }
}

fn is_end(domain: &Domain, node: usize, axis: usize) -> bool {
    domain.sides.on(node as u32) >> (2 * axis) & 3 != 0
}

/// Energy that a quadratic bubble on each edge, alone, would take away.
fn excess(solid: &Solid<'_>, u: &[f64], mean: &[f64; 6], axis: usize) -> f64 {
    let domain = solid.domain;
    let energies = parallel::map_short(domain.mesh.points.len(), |node| {
        let mut edges: Vec<(usize, Vec3, Mat3)> = Vec::with_capacity(16);
        for (cell, at) in domain.corners(node as u32) {
            let [xx, yy, zz, yz, zx, xy] = solid.stress(cell, u, mean);
            let (stress, elasticity) = (Mat3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz), solid.elasticity(cell));
            let Tetrahedron { volume, gradients: g } = domain.cell(cell);
            for (other, end) in domain.nodes(cell).into_iter().enumerate().filter(|(_, end)| *end > node) {
                let (a, b) = (&g[at], &g[other]);
                let residual = stress * (a + b) * volume;
                let block =
                    |factor: f64, a: &Vec3, b: &Vec3| Mat3::from_row_slice(&elasticity.block(factor * volume, a, b));
                let energy = block(1.6, a, a) + block(1.6, b, b) + block(0.8, a, b) + block(0.8, b, a);
                match edges.iter_mut().find(|edge| edge.0 == end) {
                    Some(edge) => (edge.1, edge.2) = (edge.1 + residual, edge.2 + energy),
                    None => edges.push((end, residual, energy)),
                }
            }
        }
        let taken = |(end, mut residual, mut energy): (usize, Vec3, Mat3)| {
            if is_end(domain, node, axis) && is_end(domain, end, axis) {
                residual[axis] = 0.0;
                energy[(axis, axis)] *= HELD;
            }
            energy.try_inverse().map_or(0.0, |inverse| residual.dot(&(inverse * residual)))
        };
        edges.into_iter().map(taken).sum::<f64>()
    });
    energies.iter().sum()
}
