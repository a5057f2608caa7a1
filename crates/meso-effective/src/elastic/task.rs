//! The stiffness of a packing: three grids, six mean strains, error, bounds and expansion.

use super::equations::Elastic;
use super::rows::LayerSums;
use super::voxels::Voxels;
use crate::bounds::{self, PropertyBounds};
use crate::error::{self, EffectiveError};
use crate::estimate::{Estimate, Sizes};
use crate::field::{FieldCells, PropertyField};
use crate::grid::{self, Grid, Space};
use crate::moduli::{Moduli, PhaseModuli, Table, accept_strains};
use crate::resolution::Resolution;
use crate::shares::volume_fractions;
use crate::solutions::{Column, Solutions, reporting};
use crate::solver::{Energy, Equations, solve_equations};
use crate::surfaces::Surface;
use meso_collision::simd::widest;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::{Silent, Watch};
use meso_concrete::{Parts, images, parallel};
use meso_concrete::{Phase, PhaseNames};
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
    /// The tensor: extrapolated from three sizes of voxels or tetrahedra where they show an order, its diagonal within Reuss and Voigt.
    pub tensor: StiffnessTensor,
    /// Error of each entry, by the changes from size to size.
    pub error: StiffnessTensor,
    /// The tensor on the voxels or tetrahedra.
    pub fine: StiffnessTensor,
    /// The tensor on those of twice the size; of a label volume with displacements that are trilinear over blocks of 2 x 2 x 2 voxels.
    pub coarse: Option<StiffnessTensor>,
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
) -> Result<(Stiffness, Vec<PropertyField>), EffectiveError> {
    let Parts { bodies, specimen, phases: names } = parts.into();
    let table = moduli.table(&names)?;
    let bodies = error::accepted_with_shells(bodies)?;
    accept_strains(&table, &bodies, &names)?;
    let counts = grid::counts(specimen, options.voxel_size_mm)?;
    of_medium(&Packing { bodies: &bodies, specimen, names, table }, counts, options, watch)
}

/// The stiffness of `medium` on a grid of `counts` voxels, and on coarser ones unless every voxel has one phase.
pub(crate) fn of_medium(
    medium: &dyn ElasticMedium,
    counts: [usize; 3],
    options: &StiffnessOptions,
    watch: &dyn Watch,
) -> Result<(Stiffness, Vec<PropertyField>), EffectiveError> {
    error::accept_tolerance(options.tolerance)?;
    let space = medium.space();
    let grid = |counts: [usize; 3]| Grid::new(&space, counts, 2, false);
    let on = |counts: [usize; 3], voxels: &Voxels, (fields, watch): (bool, &dyn Watch)| {
        columns(&mut Elastic::new(&grid(counts), voxels), options.tolerance, fields, watch)
    };
    let coarse = |(counts, voxels): ([usize; 3], Voxels)| on(counts, &voxels, (false, &Silent));
    let fine = medium.voxels(&grid(counts));
    let coarser: Result<Vec<_>, _> = if medium.is_of_voxels() {
        fine.coarser(counts, space.spacing(counts)).into_iter().map(coarse).collect()
    } else {
        let of = |counts: [usize; 3]| coarse((counts, medium.voxels(&grid(counts))));
        grid::coarser(counts).into_iter().map(of).collect()
    };
    let (coarser, fine) = (coarser?, on(counts, &fine, (options.fields, watch))?);
    let resolution = Resolution::of_voxels(space.boundary("uniform-strain"), counts, space.spacing(counts));
    let solutions = Solutions { fine, coarser, sizes: Sizes::new(grid::ratios(counts)) };
    Ok(Stiffness::new(solutions, medium.phases(), resolution))
}

/// Geometry and constants of elastic phases.
pub(crate) trait ElasticMedium {
    /// The box that is divided into voxels.
    fn space(&self) -> Space;
    /// The materials of a grid.
    fn voxels(&self, grid: &Grid) -> Voxels;
    /// The phases with their volumes.
    fn phases(&self) -> Vec<(Moduli, ElasticShare)>;
    /// Whether every voxel has one phase, so that coarser voxels would have another geometry.
    fn is_of_voxels(&self) -> bool {
        false
    }
}

/// A packing with its constants.
struct Packing<'a> {
    bodies: &'a [Aggregate],
    specimen: &'a Specimen,
    names: PhaseNames,
    table: Table,
}

impl ElasticMedium for Packing<'_> {
    fn space(&self) -> Space {
        Space::of(self.specimen)
    }

    fn voxels(&self, grid: &Grid) -> Voxels {
        let near = images::near(self.bodies, self.specimen, grid.spacing.max());
        let stones = || self.names.all().filter(|phase| phase.is_aggregate());
        let has_itz = stones().any(|phase| self.table[Phase::Itz.index()] != self.table[phase.index()]);
        let surfaces = Surface::all(&near, has_itz, &|v| *v);
        Voxels::new(grid, &surfaces, &self.table)
    }

    fn phases(&self) -> Vec<(Moduli, ElasticShare)> {
        shares(&self.table, self.bodies, self.specimen, &self.names)
    }
}

/// The phases with their exact volumes.
pub(crate) fn shares(
    table: &Table,
    bodies: &[Aggregate],
    specimen: &Specimen,
    names: &PhaseNames,
) -> Vec<(Moduli, ElasticShare)> {
    let fractions = volume_fractions(bodies, specimen, names);
    let share = |phase: Phase| {
        let moduli = table[phase.index()];
        (moduli, ElasticShare::new(names.name(phase).to_owned(), &moduli, fractions[phase.index()]))
    };
    names.all().map(share).collect()
}

impl ElasticShare {
    pub(crate) fn new(name: String, moduli: &Moduli, volume_fraction: f64) -> Self {
        let Moduli { youngs_modulus_mpa, poisson_ratio, eigenstrain } = *moduli;
        Self { name, youngs_modulus_mpa, poisson_ratio, eigenstrain, volume_fraction }
    }
}

/// Elastic equations of a specimen with a mean strain.
pub(crate) trait Strained: Equations<Number = f64> {
    /// Volume of the specimen, mm3.
    fn volume(&self) -> f64;
    /// Number of unknowns.
    fn len(&self) -> usize;
    /// Forces of the stress that displacements and a mean strain cause.
    fn forces(&self, u: &[f64], mean: &[f64; 6], out: &mut [f64]);
    /// Sums over the specimen.
    fn sums(&self, u: &[f64], mean: &[f64; 6]) -> Sums;
    /// The stresses, for the strain `component`.
    fn field(&self, u: &[f64], mean: &[f64; 6], component: usize) -> PropertyField;
}

/// The solutions for six unit strains.
pub(crate) fn columns(
    strained: &mut impl Strained,
    tolerance: f64,
    fields: bool,
    watch: &dyn Watch,
) -> Result<Vec<Column<6>>, EffectiveError> {
    let mut columns = (0..6)
        .map(|component| column(strained, component, (tolerance, fields), &reporting(watch, component, 6)))
        .collect::<Result<Vec<_>, _>>()?;
    for (i, j) in (0..6).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let mean = (columns[i].mean[j] + columns[j].mean[i]) / 2.0;
        (columns[i].mean[j], columns[j].mean[i]) = (mean, mean);
    }
    Ok(columns)
}

/// The solution for a unit strain.
fn column(
    strained: &mut impl Strained,
    component: usize,
    (tolerance, fields): (f64, bool),
    report: &dyn Fn(usize, f64),
) -> Result<Column<6>, EffectiveError> {
    let mut mean = [0.0; 6];
    mean[component] = 1.0;
    let nothing = vec![0.0; strained.len()];
    let energy = strained.sums(&nothing, &mean).energy;
    let mut rhs = nothing.clone();
    strained.forces(&nothing, &mean, &mut rhs);
    rhs.iter_mut().for_each(|force| *force = -*force);
    drop(nothing);
    let found = solve_equations(strained, rhs, Energy::falling(energy), tolerance, report)?;
    let sums = strained.sums(&found.potential, &mean);
    let volume = strained.volume();
    let mut stress = sums.stress.map(|sum| sum / volume);
    stress[component] = sums.energy / volume;
    let field = fields.then(|| strained.field(&found.potential, &mean, component));
    let column = Column::new(component, stress, (found.iterations, found.error));
    Ok(Column { eigenstress: sums.eigen / volume, field, ..column })
}

impl Stiffness {
    /// The result of the solutions, and their fields.
    pub(crate) fn new(
        mut solutions: Solutions<6>,
        phases: Vec<(Moduli, ElasticShare)>,
        resolution: Resolution,
    ) -> (Self, Vec<PropertyField>) {
        let bounds = ElasticBounds::of(&phases);
        let are_bounds = bounds::are_within(phases.iter().map(|(_, share)| share.volume_fraction));
        // Entries that an isotropic tensor has equal are alike.
        let found = solutions.estimates(|i, j| match (i == j, i < 3, j < 3) {
            (true, is_normal, _) => usize::from(is_normal),
            (false, true, true) => 2,
            _ => 3,
        });
        let all = |tensor: [[Option<f64>; 6]; 6]| tensor.map(|row| row.map(Option::unwrap_or_default));
        let settled = solutions.settled(&found, |i, j| (are_bounds && i == j).then(|| bounds.of_entry(i)));
        let [tensor, error] = settled.map(all);
        let solver_error = solutions.error();
        let modulus = |of: fn(&Isotropic) -> f64, bounds: &PropertyBounds| {
            let found = solutions.like(|columns| vec![of(&Isotropic::of(&stiffness_of(columns)))])[0];
            let value = of(&Isotropic::of(&tensor));
            let error = found.error + (value - found.value).abs();
            let estimate = Estimate { value, error }.solved(solver_error, value);
            if are_bounds { estimate.within(bounds.reuss, bounds.voigt) } else { estimate }
        };
        let bulk = modulus(|is| is.bulk_modulus_mpa, &bounds.bulk_modulus_mpa);
        let shear = modulus(|is| is.shear_modulus_mpa, &bounds.shear_modulus_mpa);
        let isotropic = Isotropic::of_moduli(bulk.value, shear.value);
        let isotropic_error = isotropic.error(bulk.error, shear.error);
        let strains = |first: usize| solutions.like(|columns| expansion(columns)[first..first + 3].to_vec());
        let expansion = [strains(0), strains(3)].concat();
        let (fine, coarse) = solutions.tensors();
        let found = Self {
            what: "stiffness",
            warnings: soft(&phases)
                .into_iter()
                .chain(warnings(&isotropic, &isotropic_error, &bounds, resolution.remedy()))
                .collect(),
            tensor,
            error,
            fine: all(fine),
            coarse: coarse.map(all),
            isotropic,
            isotropic_error,
            expansion: std::array::from_fn(|i| expansion[i].value),
            expansion_error: std::array::from_fn(|i| expansion[i].error),
            bounds,
            phases: phases.into_iter().map(|(_, share)| share).collect(),
            resolution: resolution.solved(&solutions),
        };
        (found, solutions.fields())
    }
}

/// The tensor of six solutions.
fn stiffness_of(columns: &[Column<6>]) -> StiffnessTensor {
    std::array::from_fn(|row| std::array::from_fn(|column| columns[column].mean[row]))
}

impl ElasticBounds {
    fn of(phases: &[(Moduli, ElasticShare)]) -> Self {
        let of = |(moduli, share): &(Moduli, ElasticShare)| [moduli.bulk(), moduli.shear(), share.volume_fraction];
        let [bulk_modulus_mpa, shear_modulus_mpa] =
            PropertyBounds::of_moduli(&phases.iter().map(of).collect::<Vec<_>>());
        Self { bulk_modulus_mpa, shear_modulus_mpa }
    }

    /// Bounds of Reuss and Voigt on the entry of a tensor's diagonal, which hold for every specimen.
    fn of_entry(&self, row: usize) -> [f64; 2] {
        let (bulk, shear) = (&self.bulk_modulus_mpa, &self.shear_modulus_mpa);
        let of = |bulk: f64, shear: f64| if row < 3 { bulk + 4.0 / 3.0 * shear } else { shear };
        [of(bulk.reuss, shear.reuss), of(bulk.voigt, shear.voigt)]
    }
}

/// An error above this share of a modulus is worth a warning.
const LARGE: f64 = 0.02;

/// No mortar or stone has a modulus below this, MPa; many have so many GPa.
const SOFT: f64 = 300.0;

/// Phases that may be in GPa.
fn soft(phases: &[(Moduli, ElasticShare)]) -> Option<String> {
    let is_soft = |share: &ElasticShare| share.volume_fraction > 0.0 && (0.0..SOFT).contains(&share.youngs_modulus_mpa);
    let soft = phases.iter().map(|(_, share)| share).filter(|share| is_soft(share) && share.youngs_modulus_mpa > 0.0);
    let (names, moduli): (Vec<&str>, Vec<f64>) =
        soft.map(|share| (share.name.as_str(), share.youngs_modulus_mpa)).unzip();
    let first = moduli.first()?;
    let names = names.join(", ");
    Some(format!("moduli below {SOFT} MPa ({names}) are no mortar's: {first} GPa would be {} MPa", 1e3 * first))
}

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
        Self::of_moduli(k, g)
    }

    /// Constants by bulk and shear modulus.
    fn of_moduli(k: f64, g: f64) -> Self {
        let over = |value: f64, by: f64| if by > 0.0 { value / by } else { 0.0 };
        Self {
            bulk_modulus_mpa: k,
            shear_modulus_mpa: g,
            youngs_modulus_mpa: over(9.0 * k * g, 3.0 * k + g),
            poisson_ratio: over(3.0 * k - 2.0 * g, 6.0 * k + 2.0 * g),
        }
    }

    /// Errors of the constants by those of bulk and shear modulus.
    fn error(&self, bulk: f64, shear: f64) -> Self {
        let (k, g) = (self.bulk_modulus_mpa, self.shear_modulus_mpa);
        let corners = [(bulk, shear), (bulk, -shear), (-bulk, shear), (-bulk, -shear)];
        let corners = corners.map(|(dk, dg)| Self::of_moduli((k + dk).max(0.0), (g + dg).max(0.0)));
        let most =
            |of: fn(&Self) -> f64| corners.iter().map(|corner| (of(corner) - of(self)).abs()).fold(0.0, f64::max);
        Self {
            bulk_modulus_mpa: bulk,
            shear_modulus_mpa: shear,
            youngs_modulus_mpa: most(|is| is.youngs_modulus_mpa),
            poisson_ratio: most(|is| is.poisson_ratio),
        }
    }
}

/// Strain of the free specimen, `C^-1` times the mean eigenstress.
fn expansion(columns: &[Column<6>]) -> [f64; 6] {
    let (mut c, mut strain) = (stiffness_of(columns), std::array::from_fn(|column| columns[column].eigenstress));
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

/// Sums over a specimen, times its volume.
pub(crate) struct Sums {
    pub(crate) stress: [f64; 6],
    pub(crate) energy: f64,
    /// Eigenstress times strain: by reciprocity the mean eigenstress of the specimen (Levin, 1967).
    pub(crate) eigen: f64,
}

impl Strained for Elastic<'_> {
    fn volume(&self) -> f64 {
        self.grid.volume()
    }

    fn len(&self) -> usize {
        3 * self.voxels.of.len()
    }

    fn forces(&self, u: &[f64], mean: &[f64; 6], out: &mut [f64]) {
        self.nodal_forces(u, mean, out);
    }

    fn field(&self, u: &[f64], mean: &[f64; 6], component: usize) -> PropertyField {
        let Grid { counts, origin, spacing, .. } = self.grid;
        let ([nx, ny, nz], state) = (*counts, self.state(u, mean));
        let at = |number: usize| [number % nx, number / nx % ny, number / (nx * ny)];
        let stress =
            parallel::map_short(nx * ny * nz, |number| state.mean_stress(at(number)).map(|stress| stress as f32));
        let (origin_mm, spacing_mm) = ((*origin).into(), (*spacing).into());
        PropertyField::of_stress(component, FieldCells::Voxels { counts: *counts, origin_mm, spacing_mm }, stress)
    }

    fn sums(&self, u: &[f64], mean: &[f64; 6]) -> Sums {
        let [nx, ny, nz] = self.grid.counts;
        let volume = self.grid.volume() / (nx * ny * nz) as f64;
        let state = self.state(u, mean);
        let layers = parallel::map(nz, |layer| widest(LayerSums { state, layer }));
        let sum = |which: usize| layers.iter().map(|layer| layer[which]).sum::<f64>() * volume;
        Sums { stress: [0, 1, 2, 3, 4, 5].map(sum), energy: sum(6), eigen: sum(7) }
    }
}
