//! From a packing to its stiffness: two grids, six mean strains, error, bounds and expansion.

use super::equations::{Elastic, WEIGHTS};
use super::field::StressField;
use super::voxels::Voxels;
use crate::bounds::PropertyBounds;
use crate::effective::REST;
use crate::error::{self, EffectiveError};
use crate::grid::{self, Grid, Space};
use crate::moduli::{Moduli, PhaseModuli, Table};
use crate::resolution::Resolution;
use crate::shares::volume_fractions;
use crate::solver::{Energy, Equations, solve_equations};
use crate::surfaces::{Phase, Surface};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::{Stage, Watch};
use meso_concrete::{Parts, images, parallel};
use serde::Serialize;

/// Stiffness, MPa: stresses xx, yy, zz, yz, zx, xy by row for unit strains by column. Shear strains are engineering strains.
pub type StiffnessTensor = [[f64; 6]; 6];

/// How stiffness is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessOptions {
    /// Edge of a voxel, mm; an even number of voxels that is nearest to it is taken along each axis.
    pub voxel_size_mm: f64,
    /// Error of the equations, over the result.
    pub tolerance: f64,
    /// Whether to return the stresses.
    pub fields: bool,
}

/// Bytes a voxel of the stresses of all six strains.
const FIELDS: f64 = 144.0;
/// Bytes a voxel: 235 were measured with 100^3 voxels around a sphere, and every cut voxel has a material of 108.
const BYTES: f64 = 350.0;

impl StiffnessOptions {
    /// Stiffness to twelve digits of the energy, six of a strain.
    pub fn new(voxel_size_mm: f64) -> Self {
        Self { voxel_size_mm, tolerance: 1e-12, fields: false }
    }

    /// Memory that a specimen takes at most, bytes.
    ///
    /// # Errors
    /// A voxel size or a tolerance out of its range.
    pub fn bytes(&self, specimen: &Specimen) -> Result<f64, EffectiveError> {
        error::accept_tolerance(self.tolerance)?;
        Ok(self.bytes_of(grid::counts(specimen, self.voxel_size_mm)?))
    }

    /// Memory that `counts` voxels take at most, bytes.
    pub fn bytes_of(&self, counts: [usize; 3]) -> f64 {
        let bytes = if self.fields { BYTES + FIELDS } else { BYTES };
        bytes * counts.iter().map(|count| *count as f64).product::<f64>()
    }
}

/// A phase in the result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ElasticShare {
    /// Name of the phase, or its label.
    pub name: String,
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Strain without stress.
    pub eigenstrain: f64,
    /// Exact volume over the specimen's.
    pub volume_fraction: f64,
}

/// Bounds of an isotropic mixture, MPa.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ElasticBounds {
    /// Bounds of the bulk modulus.
    pub bulk_modulus_mpa: PropertyBounds,
    /// Bounds of the shear modulus.
    pub shear_modulus_mpa: PropertyBounds,
}

/// Constants of the isotropic material that is nearest to a stiffness: mean over all directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Isotropic {
    /// Bulk modulus, MPa.
    pub bulk_modulus_mpa: f64,
    /// Shear modulus, MPa.
    pub shear_modulus_mpa: f64,
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
}

/// Stiffness and expansion of a packing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stiffness {
    /// Property: `stiffness`.
    pub what: &'static str,
    /// The tensor, extrapolated from two sizes of voxels or tetrahedra.
    pub tensor: StiffnessTensor,
    /// Estimated error of each entry: the step of the extrapolation, and the error of the equations.
    pub error: StiffnessTensor,
    /// The tensor on the voxels or tetrahedra.
    pub fine: StiffnessTensor,
    /// The tensor on those of twice the size.
    pub coarse: StiffnessTensor,
    /// Constants of the nearest isotropic material.
    pub isotropic: Isotropic,
    /// Their estimated errors.
    pub isotropic_error: Isotropic,
    /// Strains xx, yy, zz, yz, zx, xy of the free specimen by the eigenstrains of its phases.
    pub expansion: [f64; 6],
    /// Estimated error of each strain.
    pub expansion_error: [f64; 6],
    /// Bounds on an isotropic mixture of the phases.
    pub bounds: ElasticBounds,
    /// Phases with their volumes.
    pub phases: Vec<ElasticShare>,
    /// The division, and the solutions on it.
    #[serde(flatten)]
    pub resolution: Resolution,
    /// What a reader should know.
    pub warnings: Vec<String>,
}

/// The stiffness of `parts`, from `moduli`, and the stresses if asked for.
///
/// # Errors
/// Values out of range, a body with dents, a specimen that is no box, and equations that do not converge.
pub fn stiffness<'a>(
    parts: impl Into<Parts<'a>>,
    moduli: &PhaseModuli,
    options: &StiffnessOptions,
    watch: &dyn Watch,
) -> Result<(Stiffness, Vec<StressField>), EffectiveError> {
    let Parts { bodies, specimen } = parts.into();
    let table = moduli.table()?;
    let bodies = error::accepted(bodies)?;
    let counts = grid::counts(specimen, options.voxel_size_mm)?;
    of_medium(&Packing { bodies: &bodies, specimen, table }, counts, options, watch)
}

/// The stiffness of `medium`, on grids of `counts` voxels and of half as many along each axis.
pub(crate) fn of_medium(
    medium: &dyn ElasticMedium,
    counts: [usize; 3],
    options: &StiffnessOptions,
    watch: &dyn Watch,
) -> Result<(Stiffness, Vec<StressField>), EffectiveError> {
    error::accept_tolerance(options.tolerance)?;
    let space = medium.space();
    let on = |counts: [usize; 3], fields: bool, report: &dyn Fn(f64)| {
        let grid = Grid::new(&space, counts, 2, false);
        let voxels = medium.voxels(&grid);
        Solved::of(&mut Elastic::new(&grid, &voxels), options.tolerance, fields, report)
    };
    let coarse = on(counts.map(|count| count.div_ceil(2)), false, &|_| ())?;
    let mut fine = on(counts, options.fields, &|share| watch.stage(Stage::Solve, share))?;
    let fields = std::mem::take(&mut fine.fields);
    let resolution = Resolution::of_voxels(space.boundary("uniform-strain"), counts, space.spacing(counts));
    Ok((Stiffness::new([&fine, &coarse], medium.phases(), medium.rest(), resolution), fields))
}

/// Geometry and constants of elastic phases.
pub(crate) trait ElasticMedium {
    /// The box that is divided into voxels.
    fn space(&self) -> Space;
    /// The materials of a grid.
    fn voxels(&self, grid: &Grid) -> Voxels;
    /// The phases with their volumes.
    fn phases(&self) -> Vec<(Moduli, ElasticShare)>;
    /// Share of the change from voxels of twice the size by which the fine result is still off (Richardson).
    fn rest(&self) -> f64;
}

/// A packing with its constants.
struct Packing<'a> {
    bodies: &'a [Aggregate],
    specimen: &'a Specimen,
    table: Table,
}

impl ElasticMedium for Packing<'_> {
    fn space(&self) -> Space {
        Space::of(self.specimen)
    }

    fn voxels(&self, grid: &Grid) -> Voxels {
        let near = images::near(self.bodies, self.specimen, grid.spacing.max());
        let has_itz = self.table[Phase::Itz as usize] != self.table[Phase::Aggregate as usize];
        let surfaces = Surface::all(&near, has_itz, &|v| *v);
        Voxels::new(grid, &surfaces, &self.table)
    }

    fn phases(&self) -> Vec<(Moduli, ElasticShare)> {
        shares(&self.table, self.bodies, self.specimen)
    }

    fn rest(&self) -> f64 {
        REST
    }
}

/// The phases with their exact volumes.
pub(crate) fn shares(table: &Table, bodies: &[Aggregate], specimen: &Specimen) -> Vec<(Moduli, ElasticShare)> {
    let fractions = volume_fractions(bodies, specimen);
    let share = |phase: Phase| {
        let moduli = table[phase as usize];
        (moduli, ElasticShare::new(phase.name().to_owned(), &moduli, fractions[phase as usize]))
    };
    Phase::ALL.map(share).to_vec()
}

impl ElasticShare {
    pub(crate) fn new(name: String, moduli: &Moduli, volume_fraction: f64) -> Self {
        let Moduli { youngs_modulus_mpa, poisson_ratio, eigenstrain } = *moduli;
        Self { name, youngs_modulus_mpa, poisson_ratio, eigenstrain, volume_fraction }
    }
}

/// Solutions on one division of a specimen.
pub(crate) struct Solved<F> {
    tensor: StiffnessTensor,
    /// Mean stress of the specimen without strain.
    eigenstress: [f64; 6],
    iterations: Vec<usize>,
    error: f64,
    pub(crate) fields: Vec<F>,
}

/// Elastic equations of a specimen with a mean strain.
pub(crate) trait Strained: Equations<Number = f64> {
    /// A component of the field for viewers.
    type Field;
    /// Volume of the specimen, mm3.
    fn volume(&self) -> f64;
    /// Number of unknowns.
    fn len(&self) -> usize;
    /// Forces of the stress that displacements and a mean strain cause.
    fn forces(&self, u: &[f64], mean: &[f64; 6], out: &mut [f64]);
    /// Sums over the specimen.
    fn sums(&self, u: &[f64], mean: &[f64; 6]) -> Sums;
    /// The stresses, for the strain `component`.
    fn field(&self, u: &[f64], mean: &[f64; 6], component: usize) -> Self::Field;
}

/// Iterations of a usual solution.
const USUAL: f64 = 40.0;

impl<F> Solved<F> {
    /// The solutions for six unit strains; `report` receives the share of them that is done.
    pub(crate) fn of(
        strained: &mut impl Strained<Field = F>,
        tolerance: f64,
        fields: bool,
        report: &dyn Fn(f64),
    ) -> Result<Self, EffectiveError> {
        let mut solved = Self {
            tensor: [[0.0; 6]; 6],
            eigenstress: [0.0; 6],
            iterations: Vec::new(),
            error: 0.0,
            fields: Vec::new(),
        };
        for column in 0..6 {
            let share = |iteration: usize| (column as f64 + 1.0 - 1.0 / (1.0 + iteration as f64 / USUAL)) / 6.0;
            solved.add(strained, column, (tolerance, fields), &|iteration, _| report(share(iteration)))?;
        }
        let mean = |i: usize, j: usize| (solved.tensor[i][j] + solved.tensor[j][i]) / 2.0;
        solved.tensor = [0, 1, 2, 3, 4, 5].map(|i| [0, 1, 2, 3, 4, 5].map(|j| mean(i, j)));
        Ok(solved)
    }

    /// Solves for a unit strain, and adds its column.
    fn add(
        &mut self,
        strained: &mut impl Strained<Field = F>,
        column: usize,
        (tolerance, fields): (f64, bool),
        report: &dyn Fn(usize, f64),
    ) -> Result<(), EffectiveError> {
        let mut mean = [0.0; 6];
        mean[column] = 1.0;
        let nothing = vec![0.0; strained.len()];
        let energy = strained.sums(&nothing, &mean).energy;
        let mut rhs = nothing.clone();
        strained.forces(&nothing, &mean, &mut rhs);
        rhs.iter_mut().for_each(|force| *force = -*force);
        drop(nothing);
        let found = solve_equations(strained, rhs, Energy::falling(energy), tolerance, report)?;
        let sums = strained.sums(&found.potential, &mean);
        let volume = strained.volume();
        (0..6).for_each(|row| self.tensor[row][column] = sums.stress[row] / volume);
        self.tensor[column][column] = sums.energy / volume;
        self.eigenstress[column] = sums.eigen / volume;
        if fields {
            self.fields.push(strained.field(&found.potential, &mean, column));
        }
        self.iterations.push(found.iterations);
        self.error = self.error.max(found.error);
        Ok(())
    }
}

impl Stiffness {
    /// The result of the solutions on fine and coarse cells; the coarse ones' difference times `share` is the fine ones' error.
    pub(crate) fn new<F>(
        [fine, coarse]: [&Solved<F>; 2],
        phases: Vec<(Moduli, ElasticShare)>,
        share: f64,
        resolution: Resolution,
    ) -> Self {
        let rest = |fine: f64, coarse: f64| fine + share * (fine - coarse);
        let each = |of: &dyn Fn(usize, usize) -> f64| {
            let row = |i: usize| [0, 1, 2, 3, 4, 5].map(|j| of(i, j));
            [row(0), row(1), row(2), row(3), row(4), row(5)]
        };
        let tensor = each(&|i, j| rest(fine.tensor[i][j], coarse.tensor[i][j]));
        let solver_error = fine.error;
        let error = each(&|i, j| {
            share * (fine.tensor[i][j] - coarse.tensor[i][j]).abs() + solver_error * fine.tensor[j][j].abs()
        });
        let (isotropic, on_fine) = (Isotropic::of(&tensor), Isotropic::of(&fine.tensor));
        let [by_fine, by_coarse] = [fine, coarse].map(Solved::expansion);
        let strain = |i: usize| rest(by_fine[i], by_coarse[i]);
        let strain_error = |i: usize| share * (by_fine[i] - by_coarse[i]).abs();
        let isotropic_error = isotropic.distance(&on_fine);
        let bounds = ElasticBounds::of(&phases);
        Self {
            what: "stiffness",
            warnings: warnings(&isotropic, &isotropic_error, &bounds, resolution.remedy()),
            tensor,
            error,
            fine: fine.tensor,
            coarse: coarse.tensor,
            isotropic,
            isotropic_error,
            expansion: [0, 1, 2, 3, 4, 5].map(strain),
            expansion_error: [0, 1, 2, 3, 4, 5].map(strain_error),
            bounds,
            phases: phases.into_iter().map(|(_, share)| share).collect(),
            resolution: Resolution { iterations: fine.iterations.clone(), solver_error, ..resolution },
        }
    }
}

impl ElasticBounds {
    fn of(phases: &[(Moduli, ElasticShare)]) -> Self {
        let of = |(moduli, share): &(Moduli, ElasticShare)| [moduli.bulk(), moduli.shear(), share.volume_fraction];
        let [bulk_modulus_mpa, shear_modulus_mpa] =
            PropertyBounds::of_moduli(&phases.iter().map(of).collect::<Vec<_>>());
        Self { bulk_modulus_mpa, shear_modulus_mpa }
    }
}

/// An error above this share of a modulus is worth a warning.
const LARGE: f64 = 0.02;

fn warnings(found: &Isotropic, error: &Isotropic, bounds: &ElasticBounds, remedy: &str) -> Vec<String> {
    let large = error.bulk_modulus_mpa > LARGE * found.bulk_modulus_mpa
        || error.shear_modulus_mpa > LARGE * found.shear_modulus_mpa;
    let text = format!("the error of the moduli is above {} %; {remedy}", 100.0 * LARGE);
    let ElasticBounds { bulk_modulus_mpa: bulk, shear_modulus_mpa: shear } = bounds;
    let remarks = [
        bulk.remark("bulk modulus", found.bulk_modulus_mpa, error.bulk_modulus_mpa, remedy),
        shear.remark("shear modulus", found.shear_modulus_mpa, error.shear_modulus_mpa, remedy),
    ];
    large.then_some(text).into_iter().chain(remarks.into_iter().flatten()).collect()
}

impl Isotropic {
    /// Mean over all directions of a stiffness.
    fn of(c: &StiffnessTensor) -> Self {
        let along = c[0][0] + c[1][1] + c[2][2];
        let across = c[0][1] + c[1][2] + c[0][2];
        let k = (along + 2.0 * across) / 9.0;
        let g = (along - across + 3.0 * (c[3][3] + c[4][4] + c[5][5])) / 15.0;
        Self {
            bulk_modulus_mpa: k,
            shear_modulus_mpa: g,
            youngs_modulus_mpa: 9.0 * k * g / (3.0 * k + g),
            poisson_ratio: (3.0 * k - 2.0 * g) / (6.0 * k + 2.0 * g),
        }
    }

    fn distance(&self, other: &Self) -> Self {
        Self {
            bulk_modulus_mpa: (self.bulk_modulus_mpa - other.bulk_modulus_mpa).abs(),
            shear_modulus_mpa: (self.shear_modulus_mpa - other.shear_modulus_mpa).abs(),
            youngs_modulus_mpa: (self.youngs_modulus_mpa - other.youngs_modulus_mpa).abs(),
            poisson_ratio: (self.poisson_ratio - other.poisson_ratio).abs(),
        }
    }
}

impl<F> Solved<F> {
    /// Strain of the free specimen, `C^-1` times the mean eigenstress.
    fn expansion(&self) -> [f64; 6] {
        let (mut c, mut strain) = (self.tensor, self.eigenstress);
        // Gauss's elimination; the tensor is positive definite.
        for pivot in 0..6 {
            for row in pivot + 1..6 {
                let factor = c[row][pivot] / c[pivot][pivot];
                let from = c[pivot];
                c[row].iter_mut().zip(from).for_each(|(to, from)| *to -= factor * from);
                strain[row] -= factor * strain[pivot];
            }
        }
        for row in (0..6).rev() {
            let known: f64 = (row + 1..6).map(|column| c[row][column] * strain[column]).sum();
            strain[row] = (strain[row] - known) / c[row][row];
        }
        strain
    }
}

/// Sums over a specimen, times its volume.
pub(crate) struct Sums {
    pub(crate) stress: [f64; 6],
    pub(crate) energy: f64,
    /// Eigenstress times strain: by reciprocity the mean eigenstress of the specimen (Levin, 1967).
    pub(crate) eigen: f64,
}

impl Strained for Elastic<'_> {
    type Field = StressField;

    fn volume(&self) -> f64 {
        self.grid.volume()
    }

    fn len(&self) -> usize {
        3 * self.voxels.of.len()
    }

    fn forces(&self, u: &[f64], mean: &[f64; 6], out: &mut [f64]) {
        self.nodal_forces(u, mean, out);
    }

    fn field(&self, u: &[f64], mean: &[f64; 6], component: usize) -> StressField {
        StressField::new(self, u, mean, component)
    }

    fn sums(&self, u: &[f64], mean: &[f64; 6]) -> Sums {
        let [nx, ny, nz] = self.grid.counts;
        let volume = self.grid.volume() / (nx * ny * nz) as f64;
        let layers = parallel::map(nz, |k| {
            let mut sums = [0.0; 8];
            for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
                let at = [i, j, k];
                let (strain, stress) = (self.strain(at, u, mean), self.stress(at, u, mean));
                for row in 0..6 {
                    sums[row] += stress[row][0];
                    sums[6] += (0..8).map(|mode| WEIGHTS[mode] * stress[row][mode] * strain[row][mode]).sum::<f64>();
                    sums[7] += f64::from(self.material(at).eigenstress[row]) * strain[row][0];
                }
            }
            sums
        });
        let sum = |which: usize| layers.iter().map(|layer| layer[which]).sum::<f64>() * volume;
        Sums { stress: [0, 1, 2, 3, 4, 5].map(sum), energy: sum(6), eigen: sum(7) }
    }
}
