//! The volumes of a mesh: those of its phases beside the exact ones, and the correction of every aggregate's.
//!
//! Elements as large as the grains lose phases, shells and fibres first: [`PhaseOff`] names the one that is farthest off.
//!
//! In a fitted mesh chords cut corners off the aggregates, and parted gaps cells: [`restore`] gives them their volume back. The
//! nodes between an aggregate and the mortar move along the surface's normals, all of one aggregate by one distance: its
//! missing volume over the area that moves, some hundredths of a millimetre. Nodes of cells that would get too flat move half
//! as far, and the next round distributes the rest. Nodes on the specimen's sides, and between more than two materials, stay.

use super::cells::{Mesh, NO_AGGREGATE, Phase, cell_volume};
use super::error::MeshError;
use super::interface::{self, Owners};
use super::options::{ItzForm, MeshOptions, MethodName};
use super::sides::Sides;
use super::tet::{ascending, dihedral_cosines, stable_length};
use crate::aggregate::{Aggregate, Kind};
use crate::geometry::OffsetError;
use crate::math::Vec3;
use crate::packing::Specimen;
use crate::parallel;
use serde::Serialize;
use std::collections::BTreeMap;

/// Volume of every phase, mm3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseVolumes {
    /// Aggregate cores.
    pub aggregate: f64,
    /// Shells.
    pub itz: f64,
    /// Everything else, but for voids.
    pub mortar: f64,
    /// Fibres.
    #[serde(skip_serializing_if = "is_zero")]
    pub fibre: f64,
}

fn is_zero(volume: &f64) -> bool {
    *volume == 0.0
}

impl PhaseVolumes {
    /// The phases' volumes in `mesh`.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let nodes = mesh.kind.nodes();
        let of_run = |_: usize, cells: &[u32], phases: &[Phase]| {
            let mut sums = [0.0; 5];
            for (cell, phase) in cells.chunks_exact(nodes).zip(phases) {
                sums[*phase as usize] += cell_volume(mesh.kind, cell, &mesh.points);
            }
            sums
        };
        let runs = mesh.in_runs(of_run);
        let [mortar, itz, aggregate, _, fibre] = std::array::from_fn(|i| runs.iter().map(|sums| sums[i]).sum());
        Self { aggregate, itz, mortar, fibre }
    }

    /// That of one phase.
    pub fn of(&self, phase: Phase) -> f64 {
        match phase {
            Phase::Mortar => self.mortar,
            Phase::Itz => self.itz,
            Phase::Aggregate => self.aggregate,
            Phase::Fibre => self.fibre,
        }
    }

    /// The exact volumes, from the polyhedra; `shell(aggregate)` is the thickness of its shell, mm.
    ///
    /// # Errors
    /// Where an aggregate's core has no trustworthy volume.
    pub fn exact(
        aggregates: &[Aggregate],
        specimen: &Specimen,
        shell: impl Fn(&Aggregate) -> f64 + Sync,
    ) -> Result<Self, OffsetError> {
        let core = |index: usize| {
            let aggregate = &aggregates[index];
            core_volume(aggregate, if aggregate.kind == Kind::Aggregate { shell(aggregate) } else { 0.0 })
        };
        // Summed in the aggregates' order: the same on any number of threads.
        let cores = parallel::try_map(aggregates.len(), core)?;
        let (mut all, mut outer, mut inside, mut fibre) = (0.0, 0.0, 0.0, 0.0);
        for (aggregate, core) in aggregates.iter().zip(cores) {
            let volume = aggregate.body.volume();
            all += volume;
            match aggregate.kind {
                Kind::Aggregate => (outer, inside) = (outer + volume, inside + core),
                Kind::Void => {}
                Kind::Fibre => fibre += volume,
            }
        }
        Ok(Self { aggregate: inside, itz: outer - inside, mortar: specimen.volume() - all, fibre })
    }

    /// The exact volumes of the phases that `mesh` has: with the shells where its ITZ is solid; `None` where a core has no
    /// trustworthy volume.
    pub fn exact_for(mesh: &Mesh, bodies: &[Aggregate], specimen: &Specimen) -> Option<Self> {
        let solid = mesh.phase.contains(&Phase::Itz) && !mesh.has_smeared_itz();
        let shell = |aggregate: &Aggregate| if solid { aggregate.itz_thickness_mm } else { 0.0 };
        Self::exact(bodies, specimen, shell).ok()
    }

    /// Sum of the phases, mm3.
    pub fn total(&self) -> f64 {
        self.aggregate + self.itz + self.mortar + self.fibre
    }
}

/// The volume of an aggregate below a shell of `thickness` mm, mm3.
///
/// # Errors
/// Where it is not to be trusted.
pub(super) fn core_volume(aggregate: &Aggregate, thickness: f64) -> Result<f64, OffsetError> {
    Ok(aggregate.body.inward_offset(thickness)?.map_or(0.0, |core| core.volume()))
}

/// The phase of a mesh that is farthest from its exact volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseOff {
    /// Which one.
    pub phase: Phase,
    /// Its volume in the mesh over the specimen's.
    pub meshed: f64,
    /// That of its bodies.
    pub exact: f64,
}

impl PhaseOff {
    /// Most that a phase's volume in a mesh may differ from its exact one, as a share of this.
    pub const ACCEPTED: f64 = 0.1;

    /// That of a mesh of `bodies` made with `options`; `None` where a core has no trustworthy volume.
    pub(super) fn of(mesh: &Mesh, bodies: &[Aggregate], specimen: &Specimen, options: &MeshOptions) -> Option<Self> {
        let exact = PhaseVolumes::exact(bodies, specimen, |aggregate| options.shell_mm(aggregate)).ok()?;
        let meshed = comparable(mesh, options.itz);
        let whole = specimen.volume();
        let off = |phase| Self { phase, meshed: meshed.of(phase) / whole, exact: exact.of(phase) / whole };
        let wanted = Phase::ALL.into_iter().map(off).filter(|off| off.exact > 0.0);
        wanted.max_by(|a, b| a.error().abs().total_cmp(&b.error().abs()))
    }

    /// Its excess, or, below 0, its lack, as a share of its exact volume.
    pub fn error(&self) -> f64 {
        self.meshed / self.exact - 1.0
    }

    /// The error that says so, and the ways out.
    pub(super) fn refused(&self, options: &MeshOptions) -> MeshError {
        let Self { phase, meshed, exact } = *self;
        MeshError::PhaseError { phase: phase.in_words(), meshed, exact, ways: ways_out(phase, options) }
    }
}

/// The volumes in `mesh`, a smeared ITZ as the mortar that it is.
fn comparable(mesh: &Mesh, itz: ItzForm) -> PhaseVolumes {
    let volumes = PhaseVolumes::of_mesh(mesh);
    match itz {
        ItzForm::Smeared => PhaseVolumes { mortar: volumes.mortar + volumes.itz, itz: 0.0, ..volumes },
        ItzForm::Solid | ItzForm::Cohesive | ItzForm::None => volumes,
    }
}

/// The ways to keep the phase, by the options' names.
fn ways_out(phase: Phase, options: &MeshOptions) -> String {
    let size = match phase {
        Phase::Fibre => "an element_size_mm of at most half the fibres' diameter",
        Phase::Aggregate | Phase::Itz | Phase::Mortar => "a smaller element_size_mm",
    };
    let method = match options.method.name() {
        MethodName::Voxel => "the method lattice or conforming",
        MethodName::Lattice => "the method conforming",
        MethodName::Conforming => "another method",
    };
    match options.itz {
        ItzForm::Solid => format!("{size}, {method}, or itz none"),
        ItzForm::Cohesive | ItzForm::Smeared | ItzForm::None => format!("{size}, or {method}"),
    }
}

/// Times that the missing volumes are shared out.
const ROUNDS: usize = 6;
/// Volumes are right when this share of them all is missing.
const CLOSE: f64 = 1e-4;
/// The most that a node moves in a round, over the element size.
const STEP: f64 = 0.05;
/// No cell gets a sharper angle than this, degrees, unless it has one already.
const SHARPEST_DEG: f64 = 9.0;
/// A round leaves cells whose stable length is below a tenth of the element size this share of it.
const KEPT: f64 = 0.97;
/// Halvings of a node's displacement before it stays.
const HALVINGS: usize = 3;

/// Moves the interface nodes of `mesh`, of tetrahedra, until every aggregate has the volume that its body has.
pub(super) fn restore(mesh: &mut Mesh, bodies: &[Aggregate], element_size_mm: f64) {
    let exact: BTreeMap<u32, f64> = bodies.iter().map(|body| (body.id, body.body.volume())).collect();
    let surface = Surface::of(mesh);
    for _ in 0..ROUNDS {
        let missing = missing(mesh, &exact);
        if missing.values().map(|volume| volume.abs()).sum::<f64>() < CLOSE * exact.values().sum::<f64>() {
            return;
        }
        let mut displacements = surface.displacements(mesh, &missing, STEP * element_size_mm);
        surface.shorten(mesh, &mut displacements, element_size_mm / 10.0);
        parallel::each_short_mut(&mut mesh.points, |node, point| *point += displacements[node]);
    }
}

/// The volume that every aggregate lacks in `mesh`, mm3.
fn missing(mesh: &Mesh, exact: &BTreeMap<u32, f64>) -> BTreeMap<u32, f64> {
    let mut missing = exact.clone();
    let cells = mesh.cells().zip(&mesh.phase).zip(&mesh.aggregate);
    for ((cell, _), id) in cells.filter(|((_, phase), _)| **phase == Phase::Aggregate) {
        *missing.get_mut(id).expect("a cell's aggregate is a body") -= cell_volume(mesh.kind, cell, &mesh.points);
    }
    missing
}

/// The nodes that may move, with their faces and cells.
struct Surface {
    /// For every node the aggregate whose surface it slides off, [`NO_AGGREGATE`] where it stays.
    owner: Vec<u32>,
    /// The aggregates' faces that have such nodes, with their aggregates.
    faces: Vec<([u32; 3], u32)>,
    /// The cells that have such nodes.
    cells: Vec<u32>,
}

impl Surface {
    fn of(mesh: &Mesh) -> Self {
        let (owners, sides) = (Owners::of(mesh.by_aggregate()), Sides::of(mesh));
        let moving = |node: u32| owners.beside_mortar(node).filter(|_| sides.on(node) == 0).unwrap_or(NO_AGGREGATE);
        let owner: Vec<u32> = (0..mesh.points.len() as u32).map(moving).collect();
        let moves = |node: &u32| owner[*node as usize] != NO_AGGREGATE;
        let cores = interface::faces(mesh.by_aggregate())
            .into_iter()
            .filter(|face| mesh.phase[face.cell as usize] == Phase::Aggregate);
        let faces = cores.map(|face| ([0, 1, 2].map(|i| face.nodes[i]), mesh.aggregate[face.cell as usize]));
        let faces = faces.filter(|(nodes, _)| nodes.iter().any(moves)).collect();
        let cells =
            (0..).zip(mesh.cells()).filter(|(_, cell)| cell.iter().any(moves)).map(|(number, _)| number).collect();
        Self { owner, faces, cells }
    }

    /// The displacement of every node, `most` mm at most.
    fn displacements(&self, mesh: &Mesh, missing: &BTreeMap<u32, f64>, most: f64) -> Vec<Vec3> {
        // The gradient of the aggregate's volume by the node's position: a third of the area vectors around it.
        let mut normals = vec![Vec3::zeros(); mesh.points.len()];
        for (nodes, id) in &self.faces {
            let [a, b, c] = nodes.map(|node| mesh.points[node as usize]);
            let third = (b - a).cross(&(c - a)) / 6.0;
            nodes
                .iter()
                .filter(|node| self.owner[**node as usize] == *id)
                .for_each(|node| normals[*node as usize] += third);
        }
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for (normal, owner) in normals.iter().zip(&self.owner).filter(|(_, owner)| **owner != NO_AGGREGATE) {
            *areas.entry(*owner).or_default() += normal.norm();
        }
        let distance = |id: u32| (missing[&id] / areas[&id]).clamp(-most, most);
        parallel::map_short(normals.len(), |node| match normals[node].norm() {
            0.0 => Vec3::zeros(),
            length => normals[node] * (distance(self.owner[node]) / length),
        })
    }

    /// Halves the displacements of the nodes whose cells would get too flat, at last to zero.
    fn shorten(&self, mesh: &Mesh, displacements: &mut [Vec3], short: f64) {
        let mut watched = self.cells.clone();
        for halving in 0.. {
            let after = |node: &u32| mesh.points[*node as usize] + displacements[*node as usize];
            let is_flat = |number: &u32| {
                let cell = &mesh.cells[4 * *number as usize..][..4];
                let [before, after] =
                    [[0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize]), [0, 1, 2, 3].map(|i| after(&cell[i]))];
                before != after && flattens(before, after, short)
            };
            let flat = parallel::pick(&watched, is_flat);
            if flat.is_empty() {
                return;
            }
            let nodes = ascending(flat.iter().flat_map(|&cell| mesh.cells[4 * cell as usize..][..4].to_vec()));
            let share = if halving < HALVINGS { 0.5 } else { 0.0 };
            nodes.iter().for_each(|&node| displacements[node as usize] *= share);
            // Elsewhere nothing has changed.
            let has_shortened =
                |cell: &u32| mesh.cells[4 * *cell as usize..][..4].iter().any(|node| nodes.binary_search(node).is_ok());
            watched = parallel::pick(&self.cells, has_shortened);
        }
    }
}

/// Whether a tetrahedron gets worse than it may.
fn flattens(before: [Vec3; 4], after: [Vec3; 4], short: f64) -> bool {
    let sharpest = libm::cos(SHARPEST_DEG.to_radians());
    let ([_, was], [_, is]) = (dihedral_cosines(before), dihedral_cosines(after));
    let (length, now) = (stable_length(before), stable_length(after));
    is > sharpest.max(was) || now < short.min(KEPT * length)
}
