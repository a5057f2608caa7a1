//! Stiffness on tetrahedra.

use super::domain::{Domain, GIVEN, Tetrahedron, Unknowns};
use super::meshed::{Bodies, Itz, cubes};
use crate::elastic::{Stiffness, StiffnessOptions, Strained, Sums, columns, shares};
use crate::error::{self, EffectiveError};
use crate::field::PropertyField;
use crate::moduli::{Moduli, PhaseModuli, Table, accept_strains};
use crate::solver::{Equations, Graph, Multigrid, Rows, dot, layers_mut};
use meso_collision::math::{Mat3, Vec3};
use meso_concrete::Phase;
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::{Silent, Watch};
use meso_concrete::{Parts, parallel};

/// The stiffness of `parts` on tetrahedra with edges of `element_size_mm`, and the stresses if asked for. The size of voxels
/// in `options` does not matter.
///
/// # Errors
/// Values out of range, a body with dents, a specimen that is no box, a mesh that cannot be made, and equations that do not
/// converge.
pub fn stiffness_in_tetrahedra<'a>(
    parts: impl Into<Parts<'a>>,
    moduli: &PhaseModuli,
    options: &StiffnessOptions,
    element_size_mm: f64,
    watch: &dyn Watch,
) -> Result<(Stiffness, Vec<PropertyField>), EffectiveError> {
    let Parts { bodies, specimen, phases: names } = parts.into();
    let table = moduli.table(&names)?;
    options.bytes_in_tetrahedra(specimen, element_size_mm)?;
    let bodies = error::accepted(bodies)?;
    accept_strains(&table, &bodies, &names)?;
    let of = |phase: Phase| table[phase.index()];
    let aggregates: Vec<Moduli> = names.all().filter(|phase| phase.is_aggregate()).map(of).collect();
    let itz = Itz::of(&of(Phase::Mortar), &aggregates, &of(Phase::Itz), false);
    let meshed = Bodies::new(&bodies, (specimen, &names), itz, of(Phase::Void).youngs_modulus_mpa > 0.0);
    let solve = |domain: &Domain, is_fine: bool| {
        let (fields, watch): (_, &dyn Watch) = if is_fine { (options.fields, watch) } else { (false, &Silent) };
        columns(&mut Solid::new(domain, &meshed, &table), options.tolerance, fields, watch)
    };
    let (solutions, resolution) = meshed.on_sizes((element_size_mm, "uniform-strain"), watch, solve)?;
    Ok(Stiffness::new(solutions, shares(&table, &bodies, specimen, &names), resolution))
}

/// Bytes a cube of the element size, without fields, by count.
const BYTES: f64 = 9000.0;

impl StiffnessOptions {
    /// Memory that tetrahedra take in a specimen at most, bytes.
    ///
    /// # Errors
    /// An element size or a tolerance out of its range, and a specimen that is no box.
    pub fn bytes_in_tetrahedra(&self, specimen: &Specimen, element_size_mm: f64) -> Result<f64, EffectiveError> {
        if !specimen.container().is_box() {
            return Err(EffectiveError::Specimen(specimen.kind()));
        }
        error::accept_tolerance(self.tolerance)?;
        Ok(BYTES * cubes(specimen, element_size_mm)?)
    }
}

/// Forces between two nodes by their relative displacement, row by row. In single precision forces would not balance.
pub(super) type Block = [f64; 9];
/// Unknown displacements that are added up in one sum.
const LAYER: usize = 3 << 12;

/// Equations of a mesh; displacements are in threes, one for each unknown node.
pub(super) struct Solid<'a> {
    pub(super) domain: &'a Domain,
    pub(super) unknowns: Unknowns,
    /// Share of the stiffness that is left in every cell; empty where nothing is lost.
    left: Vec<f32>,
    /// Constants of every cell.
    of: Vec<u8>,
    phases: Vec<Elasticity>,
    rows: Rows<Block>,
    /// Links to nodes without displacement.
    ground: Vec<Block>,
    /// Each component alone, for the preconditioner.
    networks: [(Graph, Multigrid<Graph>); 3],
    correction: Vec<f32>,
}

/// Lame's constants and the eigenstress, MPa.
#[derive(Clone, Copy)]
pub(super) struct Elasticity {
    lame: f64,
    shear: f64,
    eigenstress: f64,
}

impl Elasticity {
    fn of(moduli: &Moduli) -> Self {
        let (bulk, shear) = (moduli.bulk(), moduli.shear());
        Self { lame: bulk - 2.0 / 3.0 * shear, shear, eigenstress: 3.0 * bulk * moduli.eigenstrain }
    }

    /// With a share of its stiffness.
    fn times(self, share: f64) -> Self {
        Self { lame: share * self.lame, shear: share * self.shear, eigenstress: share * self.eigenstress }
    }

    /// Forces between two nodes of a cell, from the gradients of their shape functions, times `factor`.
    pub(super) fn block(&self, factor: f64, a: &Vec3, b: &Vec3) -> Block {
        let all =
            Mat3::identity() * (self.shear * a.dot(b)) + a * b.transpose() * self.lame + b * a.transpose() * self.shear;
        std::array::from_fn(|entry| factor * all[(entry / 3, entry % 3)])
    }

    /// Stresses xx, yy, zz, yz, zx, xy from engineering strains.
    fn stress(&self, strain: &[f64; 6]) -> [f64; 6] {
        let volume = self.lame * (strain[0] + strain[1] + strain[2]);
        let normal = |i: usize| volume + 2.0 * self.shear * strain[i];
        [normal(0), normal(1), normal(2), self.shear * strain[3], self.shear * strain[4], self.shear * strain[5]]
    }
}

impl<'a> Solid<'a> {
    fn new(domain: &'a Domain, bodies: &Bodies<'_>, table: &Table) -> Self {
        let mesh = &domain.mesh;
        let of = parallel::map_short(mesh.cell_count(), |cell| bodies.phase(mesh, cell).number());
        let walls = (0..3).filter(|axis| !mesh.periodic[*axis]).fold(0, |bits, axis| bits | 3 << (2 * axis));
        Self::with(domain, (of, Vec::new()), table, walls, |_, _| {})
    }

    /// Cells of phases, with the shares of their stiffness that are left. Nodes on `walls` move as the mean strain asks; `hold` adds
    /// to what holds a node.
    pub(super) fn with(
        domain: &'a Domain,
        (of, left): (Vec<u8>, Vec<f32>),
        table: &Table,
        walls: u8,
        hold: impl Fn(usize, &mut Block) + Sync,
    ) -> Self {
        let is_stiff = |cell: usize| table[usize::from(of[cell])].youngs_modulus_mpa > 0.0;
        let unknowns = domain.unknowns(walls, is_stiff);
        let phases: Vec<Elasticity> = table.iter().map(Elasticity::of).collect();
        let share = |cell: usize| left.get(cell).map_or(1.0, |left| f64::from(*left));
        let block = |cell: usize, at: usize, other: usize| {
            let Tetrahedron { volume, gradients } = domain.cell(cell);
            let of_cell = &phases[usize::from(of[cell])];
            is_stiff(cell).then(|| of_cell.block(-volume * share(cell), &gradients[at], &gradients[other]))
        };
        let links = |unknown: usize| domain.links(&unknowns, unknown, block);
        let row = |unknown: usize, row: &mut Vec<(u32, Block)>| {
            row.extend(links(unknown).into_iter().filter(|(to, _)| *to != GIVEN));
        };
        let count = unknowns.nodes.len();
        let rows = Rows::new(count, row, add);
        let ground = parallel::map_short(count, |unknown| {
            let mut sum = [0.0; 9];
            links(unknown).into_iter().filter(|(to, _)| *to == GIVEN).for_each(|(_, block)| add(&mut sum, block));
            hold(unknowns.nodes[unknown] as usize, &mut sum);
            sum
        });
        let networks = [0, 1, 2].map(|component| network(&rows, &ground, component));
        Self { domain, left, of, phases, rows, ground, networks, correction: vec![0.0; 3 * count], unknowns }
    }

    /// Constants of a cell.
    pub(super) fn elasticity(&self, cell: usize) -> Elasticity {
        let own = self.phases[usize::from(self.of[cell])];
        self.left.get(cell).map_or(own, |left| own.times(f64::from(*left)))
    }

    fn strain(&self, cell: usize, u: &[f64], mean: &[f64; 6]) -> [f64; 6] {
        let mut h = Mat3::zeros();
        for (node, gradient) in self.domain.nodes(cell).into_iter().zip(self.domain.cell(cell).gradients) {
            let unknown = self.unknowns.of[node];
            if unknown != GIVEN {
                h += Vec3::from_column_slice(&u[3 * unknown as usize..][..3]) * gradient.transpose();
            }
        }
        let shear = |a: usize, b: usize| h[(a, b)] + h[(b, a)];
        let strain = [h[(0, 0)], h[(1, 1)], h[(2, 2)], shear(1, 2), shear(2, 0), shear(0, 1)];
        std::array::from_fn(|i| mean[i] + strain[i])
    }

    pub(super) fn stress(&self, cell: usize, u: &[f64], mean: &[f64; 6]) -> [f64; 6] {
        self.elasticity(cell).stress(&self.strain(cell, u, mean))
    }
}

fn add(to: &mut Block, from: Block) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
}

/// The network of a component alone.
fn network(rows: &Rows<Block>, ground: &[Block], component: usize) -> (Graph, Multigrid<Graph>) {
    let entry = |block: &Block| block[4 * component] as f32;
    let graph = Graph::new(rows.map(entry), ground.iter().map(entry).collect());
    let multigrid = Multigrid::new(&graph);
    (graph, multigrid)
}

/// A block times a displacement, added to a force.
#[inline]
fn add_product(force: &mut [f64; 3], block: &Block, u: [f64; 3]) {
    for (force, row) in force.iter_mut().zip(block.as_chunks::<3>().0) {
        *force += row.iter().zip(u).map(|(k, u)| k * u).sum::<f64>();
    }
}

impl Equations for Solid<'_> {
    type Number = f64;

    fn layer_len(&self) -> usize {
        LAYER
    }

    fn apply(&self, u: &[f64], out: &mut [f64]) -> f64 {
        let displacements = u.as_chunks::<3>().0;
        layers_mut(out, LAYER, |layer, out| {
            for (number, out) in out.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let unknown = layer * (LAYER / 3) + number;
                let own = displacements[unknown];
                *out = [0.0; 3];
                add_product(out, &self.ground[unknown], own);
                let (columns, blocks) = self.rows.row(unknown);
                for (column, block) in columns.iter().zip(blocks) {
                    let other = displacements[*column as usize];
                    add_product(out, block, [0, 1, 2].map(|i| own[i] - other[i]));
                }
            }
        });
        dot(u, out, LAYER)
    }

    fn correction(&mut self, r: &[f64]) -> &[f32] {
        for (component, (graph, multigrid)) in self.networks.iter_mut().enumerate() {
            let own: Vec<f32> = r.iter().skip(component).step_by(3).map(|r| *r as f32).collect();
            let to = self.correction.iter_mut().skip(component).step_by(3);
            to.zip(multigrid.cycle(graph, &own)).for_each(|(to, found)| *to = *found);
        }
        &self.correction
    }
}

impl Strained for Solid<'_> {
    fn volume(&self) -> f64 {
        self.domain.volume
    }

    fn len(&self) -> usize {
        3 * self.unknowns.nodes.len()
    }

    fn forces(&self, u: &[f64], mean: &[f64; 6], out: &mut [f64]) {
        let force = |unknown: usize| {
            let mut force = Vec3::zeros();
            for (cell, at) in self.domain.corners(self.unknowns.nodes[unknown]) {
                let [xx, yy, zz, yz, zx, xy] = self.stress(cell, u, mean);
                let Tetrahedron { volume, gradients } = self.domain.cell(cell);
                force += Mat3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz) * gradients[at] * volume;
            }
            [force.x, force.y, force.z]
        };
        out.copy_from_slice(parallel::map_short(self.unknowns.nodes.len(), force).as_flattened());
    }

    fn sums(&self, u: &[f64], mean: &[f64; 6]) -> Sums {
        let sums = self.domain.sums::<8>(|cell| {
            let (strain, stress) = (self.strain(cell, u, mean), self.stress(cell, u, mean));
            let energy: f64 = (0..6).map(|i| strain[i] * stress[i]).sum();
            let eigen = self.elasticity(cell).eigenstress * (strain[0] + strain[1] + strain[2]);
            let volume = self.domain.cell(cell).volume;
            [stress[0], stress[1], stress[2], stress[3], stress[4], stress[5], energy, eigen].map(|sum| sum * volume)
        });
        Sums { stress: [0, 1, 2, 3, 4, 5].map(|i| sums[i]), energy: sums[6], eigen: sums[7] }
    }

    fn field(&self, u: &[f64], mean: &[f64; 6], component: usize) -> PropertyField {
        let stress = |cell: usize| self.stress(cell, u, mean).map(|stress| stress as f32);
        PropertyField::of_stress(component, self.domain.field_cells(), parallel::map_short(self.of.len(), stress))
    }
}
