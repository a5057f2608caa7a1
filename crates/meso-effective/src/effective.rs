//! The tensor of a packing: three grids, the solution along each axis, error and bounds.

use crate::boundary::Boundary;
use crate::bounds::{self, PropertyBounds};
use crate::error::{self, EffectiveError};
use crate::estimate::{Estimate, Sizes};
use crate::field::PropertyField;
use crate::flow::Flow;
use crate::grid::{self, Grid, Space};
use crate::links::{Layer, Links};
use crate::phases::{PhaseValues, Phases, Property};
use crate::resolution::Resolution;
use crate::shares;
use crate::solutions::{Column, Estimates, Solutions, reporting};
use crate::solver::{self, Energy};
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::Watch;
use meso_concrete::{Parts, images};
use meso_concrete::{Phase, PhaseNames};
use serde::Serialize;
use std::f64::consts::PI;

/// A tensor in the specimen's axes, row by row; a column is the mean flux for a unit gradient along its axis. Entries that were not
/// asked for are `None`.
pub type FluxTensor = [[Option<f64>; 3]; 3];

/// How properties are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveOptions {
    /// Property.
    pub what: Property,
    /// Edge of a voxel, mm; an even number of voxels that is nearest to it is taken along each axis.
    pub voxel_size_mm: f64,
    /// Axes of the gradient.
    pub axes: [bool; 3],
    /// Error of the equations, over the result.
    pub tolerance: f64,
    /// Whether to return the fields.
    pub fields: bool,
    /// Conditions at walls.
    pub boundary: Boundary,
}

impl EffectiveOptions {
    /// Memory that a specimen takes at most, bytes: links, levels and vectors, then the field.
    ///
    /// # Errors
    /// A voxel size or a tolerance out of its range.
    pub fn bytes(&self, specimen: &Specimen) -> Result<f64, EffectiveError> {
        error::accept_tolerance(self.tolerance)?;
        self.boundary.accept_for(false)?;
        Ok(self.bytes_of(grid::counts(specimen, self.voxel_size_mm)?))
    }

    /// Memory that `counts` voxels take at most, bytes.
    pub fn bytes_of(&self, counts: [usize; 3]) -> f64 {
        let voxels = counts.iter().map(|count| *count as f64).product::<f64>();
        let axes = self.axes.iter().filter(|axis| **axis).count() as f64;
        voxels * if self.fields { BYTES + 16.0 * axes } else { BYTES }
    }

    /// All axes, to nine digits, without fields.
    pub fn new(what: Property, voxel_size_mm: f64) -> Self {
        Self { what, voxel_size_mm, axes: [true; 3], tolerance: 1e-9, fields: false, boundary: Boundary::Fixed }
    }

    /// Size of voxels for a grading from `d_min_mm` up: an eighth.
    pub fn default_voxel_size(d_min_mm: f64) -> f64 {
        d_min_mm / 8.0
    }

    /// Size of tetrahedra for a grading from `d_min_mm` up: a quarter, since a cube of them has twelve and two nodes.
    pub fn default_element_size(d_min_mm: f64) -> f64 {
        d_min_mm / 4.0
    }
}

/// Bytes a voxel without fields: 57 were measured with 300^3 voxels, 69 with 99^3.
const BYTES: f64 = 72.0;

/// A phase in the result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseShare {
    /// Name of the phase, or its label.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its exact volume over the specimen's.
    pub volume_fraction: f64,
}

/// A moment of a test, if a result belongs to one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct At {
    /// Number of the frame, from 1; 0 is the end of a test in memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u32>,
    /// Mean axial strain, positive in the test's sense.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strain: Option<f64>,
    /// Stress, positive in the test's sense, MPa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_mpa: Option<f64>,
}

/// An effective property.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effective {
    /// Property.
    pub what: Property,
    /// The moment of a test that it belongs to.
    #[serde(flatten)]
    pub at: At,
    /// The tensor: extrapolated from three sizes of voxels or tetrahedra where they show an order, and within Reuss and Voigt; of a
    /// label volume, the middle of its bounds.
    pub tensor: FluxTensor,
    /// Error of each entry, which contains the exact value: by the changes from size to size, or by bounds of a label volume.
    pub error: FluxTensor,
    /// The tensor on the voxels or tetrahedra.
    pub fine: FluxTensor,
    /// The tensor on those of twice the size; nothing of a label volume.
    pub coarse: FluxTensor,
    /// Bounds on an isotropic mixture of the phases.
    pub bounds: PropertyBounds,
    /// Phases with their volumes.
    pub phases: Vec<PhaseShare>,
    /// The division, and the solutions on it.
    #[serde(flatten)]
    pub resolution: Resolution,
    /// What a reader should know.
    pub warnings: Vec<String>,
}

/// The effective property of `parts`, and the fields if asked for.
///
/// # Errors
/// Values out of range, a body with dents, a specimen that is no box, and equations that do not converge.
pub fn effective<'a>(
    parts: impl Into<Parts<'a>>,
    phases: &Phases,
    options: &EffectiveOptions,
    watch: &dyn Watch,
) -> Result<(Effective, Vec<PropertyField>), EffectiveError> {
    let Parts { bodies, specimen, phases: names } = parts.into();
    let values = phases.values(options.what);
    values.validate(options.what, &names)?;
    let bodies = error::accepted_with_shells(bodies)?;
    values.validate_shells(options.what, &bodies, &names)?;
    let counts = grid::counts(specimen, options.voxel_size_mm)?;
    of_medium(&Packing { bodies: &bodies, specimen, names: &names, values: &values }, counts, options, watch)
}

/// The effective property of `medium` on a grid of `counts` voxels, and on coarser ones unless solutions have bounds.
pub(crate) fn of_medium(
    medium: &dyn Medium,
    counts: [usize; 3],
    options: &EffectiveOptions,
    watch: &dyn Watch,
) -> Result<(Effective, Vec<PropertyField>), EffectiveError> {
    error::accept_tolerance(options.tolerance)?;
    options.boundary.accept_for(false)?;
    let stages = options.axes.iter().filter(|axis| **axis).count().max(1);
    let task = Task { medium, space: medium.space(), options, watch, stages };
    let coarse = EffectiveOptions { fields: false, ..*options };
    let grids = if medium.has_bounds() { Vec::new() } else { grid::coarser(counts) };
    let on = |counts: &[usize; 3]| Task { options: &coarse, stages: 0, ..task }.columns(*counts);
    let coarser = grids.iter().map(on).collect::<Result<_, _>>()?;
    let fine = task.columns(counts)?;
    let resolution = Resolution::of_voxels(task.space.boundary("fixed"), counts, task.space.spacing(counts));
    let largest = task.space.spacing(counts).into_iter().fold(0.0, f64::max);
    let sizes = Sizes { show: medium.shows_errors(largest), ..Sizes::new(grid::ratios(counts)) };
    Ok(Effective::new(options.what, Solutions { fine, coarser, sizes }, medium.phases(), resolution))
}

/// Geometry and values of phases that conduct.
pub(crate) trait Medium: Sync {
    /// The box that is divided into voxels.
    fn space(&self) -> Space;
    /// The links of a grid whose third axis is the specimen's `last`.
    fn links(&self, grid: &Grid, last: usize) -> Links;
    /// The phases with their volumes.
    fn phases(&self) -> Vec<PhaseShare>;
    /// Whether solutions have bounds of the exact value.
    fn has_bounds(&self) -> bool {
        false
    }
    /// Whether the changes from one size of voxels to another show the errors of voxels of a size.
    fn shows_errors(&self, _voxel_size_mm: f64) -> bool {
        true
    }
    /// Bounds of the exact value along the gradient of `flow`, from a solution whose value is `found`.
    fn bounds(&self, _flow: &Flow, _last: usize, _found: f64) -> Option<[f64; 2]> {
        None
    }
}

/// A packing with its values.
struct Packing<'a> {
    bodies: &'a [Aggregate],
    specimen: &'a Specimen,
    names: &'a PhaseNames,
    values: &'a PhaseValues,
}

impl Medium for Packing<'_> {
    fn space(&self) -> Space {
        Space::of(self.specimen)
    }

    fn links(&self, grid: &Grid, last: usize) -> Links {
        let near = images::near(self.bodies, self.specimen, grid.spacing.max());
        let layers = Layer::all(&near, self.values, self.names, last);
        Links::new(grid, &layers, self.values.mortar)
    }

    fn phases(&self) -> Vec<PhaseShare> {
        self.values.shares(self.bodies, self.specimen, self.names)
    }

    /// Shells that are thinner than a voxel join the grains that share it. A shell of thickness t and value D makes an insulating grain
    /// of radius a one of value 2 t D / a. A grain that conducts is joined to its neighbours by itself, which the changes show, as
    /// long as its shell adds little to it.
    fn shows_errors(&self, voxel_size_mm: f64) -> bool {
        let PhaseValues { mortar, itz, .. } = *self.values;
        let joins = |body: &Aggregate| {
            let aggregate = self.values.of(body.phase(), self.names);
            let (radius, thickness) = (libm::cbrt(0.75 / PI * body.body.volume()), body.itz_thickness_mm);
            body.kind == Kind::Aggregate
                && thickness < voxel_size_mm
                && 2.0 * thickness * itz > CONDUCTOR * radius * mortar
                && 2.0 * thickness * (itz - aggregate) > SHELL * radius * aggregate
        };
        let least = self.values.of_aggregates(self.names).into_iter().fold(f64::INFINITY, f64::min);
        itz <= mortar || itz <= least || !self.bodies.iter().any(joins)
    }
}

/// Name of the cracks among the phases of a result.
pub(crate) const CRACK: &str = "crack";
/// Grains of more than this many times the mortar's value are good conductors.
const CONDUCTOR: f64 = 10.0;
/// A shell that adds more than this many times its grain's own value is not shown: docs/measured/properties.md.
const SHELL: f64 = 5.0;
/// Remedy where voxels show no error.
const JOINED: &str = "the ITZ is thinner than a voxel and joins grains; take the method lattice";

impl PhaseValues {
    /// The phases with their exact volumes.
    pub(crate) fn shares(&self, bodies: &[Aggregate], specimen: &Specimen, names: &PhaseNames) -> Vec<PhaseShare> {
        let fractions = shares::volume_fractions(bodies, specimen, names);
        let share = |phase: Phase| {
            let (value, volume_fraction) = (self.of(phase, names), fractions[phase.index()]);
            PhaseShare { name: names.name(phase).to_owned(), value, volume_fraction }
        };
        names.all().map(share).collect()
    }
}

#[derive(Clone, Copy)]
struct Task<'a> {
    medium: &'a dyn Medium,
    space: Space,
    options: &'a EffectiveOptions,
    watch: &'a dyn Watch,
    /// Solutions that are reported as progress.
    stages: usize,
}

impl Task<'_> {
    /// The solutions along the axes asked for. Periodic axes share one grid; a walled one is turned to the third place.
    fn columns(&self, counts: [usize; 3]) -> Result<Vec<Column<3>>, EffectiveError> {
        let asked = |periodic: bool| {
            let is = move |axis: usize| self.space.periodic[axis] == periodic;
            (0..3).filter(move |axis| self.options.axes[*axis] && is(*axis))
        };
        let mut columns = Vec::new();
        if asked(true).next().is_some() {
            let (grid, links) = self.links(counts, 2, false);
            for axis in asked(true) {
                columns.push(self.column(&grid, &links, axis, 2, columns.len())?);
            }
        }
        for axis in asked(false) {
            let (grid, links) = self.links(counts, axis, true);
            columns.push(self.column(&grid, &links, 2, axis, columns.len())?);
        }
        columns.sort_by_key(|column| column.component);
        Ok(columns)
    }

    fn links(&self, counts: [usize; 3], last: usize, fixed: bool) -> (Grid, Links) {
        let grid = Grid::new(&self.space, counts, last, fixed);
        let links = self.medium.links(&grid, last);
        (grid, links)
    }

    /// The solution for a unit gradient along the grid's `axis`.
    fn column(
        &self,
        grid: &Grid,
        links: &Links,
        axis: usize,
        last: usize,
        done: usize,
    ) -> Result<Column<3>, EffectiveError> {
        let place = |axis: usize| (last + 1 + axis) % 3;
        // No part carries a flux along the axis.
        let blocked = || Column { bounds: Some([0.0; 2]), ..Column::new(place(axis), [0.0; 3], (0, 0.0)) };
        let is_blocked = !links.carries[axis];
        if is_blocked && !self.options.fields {
            return Ok(blocked());
        }
        let nothing = vec![0.0; if links.coupled() > 0 { links.counts.iter().product() } else { 0 }];
        let given = Flow { grid, links, axis, potential: &nothing };
        let (energy, rhs) = (given.given_energy(), given.sources());
        drop(nothing);
        let report = reporting(self.watch, done, self.stages);
        let found = solver::solve(links, rhs, Energy::falling(energy), self.options.tolerance, &report)?;
        let flow = Flow { grid, links, axis, potential: &found.potential };
        let field = self.options.fields.then(|| flow.field(self.options.what, last));
        if is_blocked {
            return Ok(Column { field, ..blocked() });
        }
        let mean = flow.mean();
        let mut flux = [0.0; 3];
        (0..3).for_each(|axis| flux[place(axis)] = mean[axis]);
        let bounds = self.medium.bounds(&flow, last, mean[axis]);
        Ok(Column { bounds, field, ..Column::new(place(axis), flux, (found.iterations, found.error)) })
    }
}

impl Effective {
    /// The result of the solutions, and their fields.
    pub(crate) fn new(
        what: Property,
        mut solutions: Solutions<3>,
        phases: Vec<PhaseShare>,
        resolution: Resolution,
    ) -> (Self, Vec<PropertyField>) {
        let shares: Vec<(f64, f64)> = phases.iter().map(|phase| (phase.value, phase.volume_fraction)).collect();
        let bounds = PropertyBounds::of(&shares);
        let are_bounds = bounds::are_within(shares.iter().map(|share| share.1));
        let mut found = solutions.estimates(|row, column| usize::from(row == column));
        for column in &solutions.fine {
            by_bounds(&mut found, &solutions.fine, column, &bounds);
        }
        // Voigt and Reuss bound the diagonal of every specimen, and Voigt the other entries (Cauchy and Schwarz).
        let [tensor, error] = solutions.settled(&found, |row, column| {
            are_bounds.then_some([if row == column { bounds.reuss } else { -bounds.voigt }, bounds.voigt])
        });
        let (fine, coarse) = solutions.tensors();
        let remedy = if solutions.sizes.show { resolution.remedy() } else { JOINED };
        // Cracks have directions, and the bounds of Hashin and Shtrikman are those of an isotropic mixture.
        let is_isotropic = phases.iter().all(|phase| phase.name != CRACK);
        let warnings = warnings(what, (&bounds, is_isotropic), [&tensor, &error], remedy);
        let (at, coarse, resolution) = (At::default(), coarse.unwrap_or_default(), resolution.solved(&solutions));
        (Self { what, at, tensor, error, fine, coarse, bounds, phases, resolution, warnings }, solutions.fields())
    }
}

/// Replaces the estimates of a column that has bounds, or the most by which it exceeds the exact value. The deviation of a fine tensor
/// from the exact one is a positive form, which limits entries off the diagonal by those on it (Cauchy and Schwarz).
fn by_bounds(found: &mut Estimates<3>, columns: &[Column<3>], column: &Column<3>, of_all: &PropertyBounds) {
    let own = column.component;
    let on_diagonal = match (column.bounds, column.excess) {
        (Some([low, high]), _) => Estimate::between(low, high),
        (None, Some(error)) => Estimate { value: column.mean[own], error },
        (None, None) => return,
    };
    let over = |of: &Column<3>| of.bounds.map(|[_, high]| high - of.mean[of.component]).or(of.excess);
    let off = |axis: usize| {
        let other = columns.iter().find(|column| column.component == axis);
        other.and_then(over).unwrap_or(of_all.voigt).max(0.0)
    };
    for (row, found) in found.iter_mut().enumerate() {
        let beside = || Estimate { value: column.mean[row], error: (off(row) * off(own)).sqrt() };
        found[own] = Some(if row == own { on_diagonal } else { beside() });
    }
}

/// An error above this share of an entry on the diagonal is worth a warning.
const LARGE: f64 = 0.02;

fn warnings(
    what: Property,
    (bounds, is_isotropic): (&PropertyBounds, bool),
    [tensor, error]: [&FluxTensor; 2],
    remedy: &str,
) -> Vec<String> {
    let found = |axis: usize| Some((["x", "y", "z"][axis], tensor[axis][axis]?, error[axis][axis]?));
    let found: Vec<(&str, f64, f64)> = (0..3).filter_map(found).collect();
    let large = found.iter().filter(|(_, value, error)| *error > LARGE * value);
    let axes: Vec<&str> = large.map(|(axis, ..)| *axis).collect();
    let along = axes.join(", ");
    let large = format!("the error along {along} is above {} %; {remedy}", 100.0 * LARGE);
    let remark = |(axis, value, error): &(&str, f64, f64)| {
        if !is_isotropic {
            return None;
        }
        bounds.remark(&format!("{} along {axis}", what.name()), *value, *error, remedy)
    };
    (!axes.is_empty()).then_some(large).into_iter().chain(found.iter().filter_map(remark)).collect()
}
