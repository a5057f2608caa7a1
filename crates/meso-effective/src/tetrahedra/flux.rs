//! Diffusivity and conductivity on tetrahedra.

use super::domain::{Domain, GIVEN, Tetrahedron, Unknowns};
use super::meshed::{Bodies, Itz, cubes};
use crate::boundary::Boundary;
use crate::effective::{Effective, EffectiveOptions};
use crate::error::{self, EffectiveError};
use crate::field::PropertyField;
use crate::phases::{PhaseValues, Phases, Property};
use crate::solutions::{Column, reporting};
use crate::solver::{self, Energy, Graph, Rows, Solution};
use meso_collision::math::{Mat3, Vec3};
use meso_concrete::PhaseNames;
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::Watch;
use meso_concrete::{Parts, parallel};

/// The effective property of `parts` on tetrahedra with edges of `element_size_mm`, and the fields if asked for. The size of
/// voxels in `options` does not matter.
///
/// # Errors
/// Values out of range, a body with dents, an axis without flat ends, a mesh that cannot be made, and equations that do not
/// converge.
pub fn effective_in_tetrahedra<'a>(
    parts: impl Into<Parts<'a>>,
    phases: &Phases,
    options: &EffectiveOptions,
    element_size_mm: f64,
    watch: &dyn Watch,
) -> Result<(Effective, Vec<PropertyField>), EffectiveError> {
    let Parts { bodies, specimen, phases: names } = parts.into();
    let values = phases.values(options.what);
    values.validate(options.what, &names)?;
    options.bytes_in_tetrahedra(specimen, element_size_mm)?;
    let bodies = error::accepted(bodies)?;
    let aggregates = values.of_aggregates(&names);
    let itz = Itz::of(&values.mortar, &aggregates, &values.itz, aggregates.iter().all(|value| *value == 0.0));
    let meshed = Bodies::new(&bodies, (specimen, &names), itz, values.void > 0.0);
    let is_flux = options.boundary == Boundary::UniformFlux;
    let stages = options.axes.iter().filter(|axis| is_flux || **axis).count();
    let solve = |domain: &Domain, is_fine: bool| {
        let (fields, stages) = if is_fine { (options.fields, stages) } else { (false, 0) };
        let conduction = Conduction::new(domain, &meshed, &values, &names);
        Task { conduction, options, fields, shows_excess: false, watch, stages }.columns()
    };
    let (solutions, resolution) = meshed.on_sizes((element_size_mm, options.boundary.name()), watch, solve)?;
    Ok(Effective::new(options.what, solutions, values.shares(&bodies, specimen, &names), resolution))
}

/// Bytes a cube of the element size, without fields: 1,930 were measured, mesh included.
const BYTES: f64 = 2200.0;

impl EffectiveOptions {
    /// Memory that tetrahedra take in a specimen at most, bytes.
    ///
    /// # Errors
    /// An element size or a tolerance out of its range, and a specimen without flat ends.
    pub fn bytes_in_tetrahedra(&self, specimen: &Specimen, element_size_mm: f64) -> Result<f64, EffectiveError> {
        self.boundary.accept(specimen)?;
        has_ends(specimen, self.axes)?;
        error::accept_tolerance(self.tolerance)?;
        Ok(BYTES * cubes(specimen, element_size_mm)?)
    }
}

/// Refuses axes along which a specimen has no flat ends.
fn has_ends(specimen: &Specimen, axes: [bool; 3]) -> Result<(), EffectiveError> {
    match specimen {
        _ if specimen.container().is_box() => Ok(()),
        Specimen::Cylinder { .. } if axes == [false, false, true] => Ok(()),
        Specimen::Cylinder { .. } => Err(EffectiveError::Ends),
        _ => Err(EffectiveError::Specimen(specimen.kind())),
    }
}

/// Conductivities of a mesh's cells.
pub(super) struct Conduction<'a> {
    pub(super) domain: &'a Domain,
    /// Number of every cell's tensor.
    pub(super) of: Vec<u32>,
    pub(super) tensors: Vec<Mat3>,
}

impl<'a> Conduction<'a> {
    fn new(domain: &'a Domain, bodies: &Bodies<'_>, values: &PhaseValues, names: &PhaseNames) -> Self {
        let mesh = &domain.mesh;
        let of = parallel::map_short(mesh.cell_count(), |cell| u32::from(bodies.phase(mesh, cell).number()));
        let tensors = names.all().map(|phase| Mat3::identity() * values.of(phase, names)).collect();
        let mut all = Self { domain, of, tensors };
        let phases = all.tensors.len() as u32;
        for (cell, volume, normal) in bodies.films(mesh) {
            let tensor = all.tensors[all.of[cell] as usize];
            if all.of[cell] < phases {
                all.of[cell] = all.tensors.len() as u32;
                all.tensors.push(tensor);
            }
            let more = values.itz * volume / domain.cell(cell).volume;
            all.tensors[all.of[cell] as usize] += (Mat3::identity() - normal * normal.transpose()) * more;
        }
        all
    }

    pub(super) fn tensor(&self, cell: usize) -> &Mat3 {
        &self.tensors[self.of[cell] as usize]
    }

    pub(super) fn conducts(&self, cell: usize) -> bool {
        *self.tensor(cell) != Mat3::zeros()
    }

    /// The links between unknowns, and those to nodes without one.
    pub(super) fn graph(&self, unknowns: &Unknowns) -> Graph {
        let link = |cell: usize, at: usize, other: usize| {
            let Tetrahedron { volume, gradients } = self.domain.cell(cell);
            let link = -volume * gradients[at].dot(&(self.tensor(cell) * gradients[other]));
            self.conducts(cell).then_some(link)
        };
        let links = |unknown: usize| self.domain.links(unknowns, unknown, link);
        let row = |unknown: usize, row: &mut Vec<(u32, f64)>| {
            row.extend(links(unknown).into_iter().filter(|(to, _)| *to != GIVEN));
        };
        let rows = Rows::new(unknowns.nodes.len(), row, |to, from| *to += from).map(|link| *link as f32);
        let given = |unknown: usize| {
            let given = links(unknown).into_iter().filter(|(to, _)| *to == GIVEN);
            given.map(|(_, link)| link).sum::<f64>() as f32
        };
        Graph::new(rows, parallel::map_short(unknowns.nodes.len(), given))
    }

    /// Gradient in a cell, for a `given` one and the potential's.
    pub(super) fn gradient(&self, cell: usize, given: &Vec3, of: &[u32], potential: &[f64]) -> Vec3 {
        let (nodes, Tetrahedron { gradients, .. }) = (self.domain.nodes(cell), self.domain.cell(cell));
        let mut sum = *given;
        for (node, gradient) in nodes.into_iter().zip(gradients).filter(|(node, _)| of[*node] != GIVEN) {
            sum += gradient * potential[of[node] as usize];
        }
        sum
    }

    /// Flux into each unknown's node that the mean gradient leaves over.
    fn sources(&self, unknowns: &Unknowns, axis: usize) -> Vec<f64> {
        let source = |unknown: usize| {
            let corners = self.domain.corners(unknowns.nodes[unknown]);
            let into = corners.map(|(cell, at)| {
                let Tetrahedron { volume, gradients } = self.domain.cell(cell);
                -volume * self.tensor(cell).column(axis).dot(&gradients[at])
            });
            into.sum::<f64>()
        };
        parallel::map_short(unknowns.nodes.len(), source)
    }

    /// Mean flux, along the gradient by the energy, whose error is the square of the potential's.
    pub(super) fn mean(&self, of: &[u32], axis: usize, potential: &[f64]) -> [f64; 3] {
        let sums = self.sums(of, &unit(axis), potential);
        [0, 1, 2].map(|a| sums[if a == axis { 3 } else { a }] / self.domain.volume)
    }

    /// Flux along x, y, z and energy, over the specimen.
    pub(super) fn sums(&self, of: &[u32], given: &Vec3, potential: &[f64]) -> [f64; 4] {
        self.domain.sums(|cell| {
            let gradient = self.gradient(cell, given, of, potential);
            let flux = self.tensor(cell) * gradient * self.domain.cell(cell).volume;
            [flux.x, flux.y, flux.z, flux.dot(&gradient)]
        })
    }

    /// The field along `axis`, for a `given` gradient and the potential's.
    pub(super) fn field(
        &self,
        (what, of): (Property, &[u32]),
        axis: usize,
        given: &Vec3,
        potential: &[f64],
    ) -> PropertyField {
        let node = |node: usize| {
            let given = self.domain.mesh.points[node].dot(given);
            (given + if of[node] == GIVEN { 0.0 } else { potential[of[node] as usize] }) as f32
        };
        let flux = |cell: usize| {
            let flux = self.tensor(cell) * self.gradient(cell, given, of, potential);
            [flux.x as f32, flux.y as f32, flux.z as f32]
        };
        let mesh = &self.domain.mesh;
        let flux = parallel::map_short(mesh.cell_count(), flux).into_flattened();
        let potential = parallel::map_short(mesh.points.len(), node);
        PropertyField { what: what.name(), component: axis, cells: self.domain.field_cells(), potential, values: flux }
    }
}

/// Bits of all sides.
const ALL_SIDES: u8 = 0b11_1111;

/// Solutions on one mesh.
pub(super) struct Task<'a> {
    pub(super) conduction: Conduction<'a>,
    pub(super) options: &'a EffectiveOptions,
    pub(super) fields: bool,
    /// Whether the error follows from each solution alone.
    pub(super) shows_excess: bool,
    pub(super) watch: &'a dyn Watch,
    /// Solutions that are reported as progress.
    pub(super) stages: usize,
}

impl Task<'_> {
    /// The solutions along the axes asked for. Axes with the same conditions share their equations.
    pub(super) fn columns(&self) -> Result<Vec<Column<3>>, EffectiveError> {
        let domain = self.conduction.domain;
        let mut columns = Vec::new();
        let groups = match self.options.boundary {
            Boundary::Fixed => self.groups(),
            Boundary::UniformGradient => vec![(self.asked().collect(), ALL_SIDES)],
            Boundary::UniformFlux => return self.columns_of_uniform_flux(),
        };
        for (axes, given) in groups {
            let unknowns = domain.unknowns(given, |cell| self.conduction.conducts(cell));
            let graph = self.conduction.graph(&unknowns);
            for axis in axes {
                columns.push(self.column(&unknowns, &graph, axis, columns.len())?);
            }
        }
        columns.sort_by_key(|column| column.component);
        Ok(columns)
    }

    fn asked(&self) -> impl Iterator<Item = usize> {
        (0..3).filter(|axis| self.options.axes[*axis])
    }

    /// Periodic axes, and each of the others, with the bits of the sides that have given potentials.
    fn groups(&self) -> Vec<(Vec<usize>, u8)> {
        let periodic = &self.conduction.domain.mesh.periodic;
        let (repeated, walled): (Vec<usize>, Vec<usize>) = self.asked().partition(|axis| periodic[*axis]);
        let first = (!repeated.is_empty()).then_some((repeated, 0));
        first.into_iter().chain(walled.into_iter().map(|axis| (vec![axis], 3 << (2 * axis)))).collect()
    }

    fn column(
        &self,
        unknowns: &Unknowns,
        graph: &Graph,
        axis: usize,
        done: usize,
    ) -> Result<Column<3>, EffectiveError> {
        let conduction = &self.conduction;
        let nothing = vec![0.0; unknowns.nodes.len()];
        let energy = conduction.mean(&unknowns.of, axis, &nothing)[axis] * conduction.domain.volume;
        let sources = conduction.sources(unknowns, axis);
        let found = self.solve(graph, sources, Energy::falling(energy), done)?;
        let flux = conduction.mean(&unknowns.of, axis, &found.potential);
        let of = (self.options.what, &unknowns.of[..]);
        let field = self.fields.then(|| conduction.field(of, axis, &unit(axis), &found.potential));
        let excess = self.shows_excess.then(|| conduction.excess(&unknowns.of, axis, &found.potential));
        Ok(Column { excess, field, ..Column::new(axis, flux, (found.iterations, found.error)) })
    }

    /// Solution number `done`.
    pub(super) fn solve(
        &self,
        graph: &Graph,
        rhs: Vec<f64>,
        energy: Energy,
        done: usize,
    ) -> Result<Solution, EffectiveError> {
        let report = reporting(self.watch, done, self.stages);
        solver::solve(graph, rhs, energy, self.options.tolerance, &report)
    }
}

/// A unit gradient.
pub(super) fn unit(axis: usize) -> Vec3 {
    Vec3::from_fn(|row, _| f64::from(u8::from(row == axis)))
}
