//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build`] is the one way in; the methods are siblings, one file each. A mesh knows nothing of file formats.

mod clip;
mod cohesive;
pub mod conforming;
mod distance;
mod error;
mod flat_sides;
mod grains;
mod interface;
mod joined;
mod lattice;
mod layer;
pub(crate) mod opposite;
mod options;
pub mod quality;
mod second_order;
mod separate;
pub mod sides;
mod swaps;
mod sweep;
mod volumes;
mod voxel;
mod web;

pub use conforming::VolumeMesher;
pub use distance::InterfaceDistance;
pub use error::MeshError;
pub use options::{Fit, ItzForm, MeshOptions, MeshTable, Method, MethodName, Order};
pub use volumes::PhaseVolumes;

use crate::aggregate::{Aggregate, Kind};
use crate::math::Vec3;
use crate::model::Model;
use crate::packing::{Specimen, images_near};
use flat_sides::FlatSides;
use lattice::Tetrahedra;
use serde::Serialize;
use std::cmp::Ordering;

/// The material a cell is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Phase {
    /// The matrix.
    Mortar = 0,
    /// The shell between an aggregate's outer and inner surface.
    Itz = 1,
    /// The inside of an aggregate.
    Aggregate = 2,
    /// A fibre. 3 is what surfaces of voids have in a file: meshes have no cells there.
    Fibre = 4,
}

impl Phase {
    /// All phases, in the order decks list them.
    pub const ALL: [Self; 4] = [Self::Aggregate, Self::Itz, Self::Mortar, Self::Fibre];

    /// What a body has inside its ITZ; cells of voids are left out before anyone sees them.
    fn inside(kind: Kind) -> Self {
        match kind {
            Kind::Aggregate | Kind::Void => Self::Aggregate,
            Kind::Fibre => Self::Fibre,
        }
    }

    /// The name of its element set and of its material.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mortar => "MORTAR",
            Self::Itz => "ITZ",
            Self::Aggregate => "AGGREGATE",
            Self::Fibre => "FIBRE",
        }
    }
}

/// The shape of a mesh's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Four nodes, positive volume in Abaqus' (and VTK's) order.
    Tetrahedron,
    /// Its four corners, then the middles of its edges 1-2, 2-3, 3-1, 1-4, 2-4, 3-4.
    QuadraticTetrahedron,
    /// Eight nodes, bottom face counter-clockwise from above, then the top face.
    Hexahedron,
}

impl CellKind {
    /// Nodes per cell.
    pub fn nodes(self) -> usize {
        match self {
            Self::Tetrahedron => 4,
            Self::QuadraticTetrahedron => 10,
            Self::Hexahedron => 8,
        }
    }

    /// Nodes of a cell that are corners; they come first.
    pub fn corners(self) -> usize {
        match self {
            Self::Tetrahedron | Self::QuadraticTetrahedron => 4,
            Self::Hexahedron => 8,
        }
    }

    /// The faces' corners in Abaqus' order, S1 first, as positions in the cell; counter-clockwise seen from outside.
    pub fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron | Self::QuadraticTetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            Self::Hexahedron => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
        }
    }

    /// The same faces with the middle nodes of their edges after the corners, the first edge's first.
    pub fn face_nodes(self) -> &'static [&'static [usize]] {
        match self {
            Self::QuadraticTetrahedron => {
                &[&[0, 2, 1, 6, 5, 4], &[0, 1, 3, 4, 8, 7], &[1, 2, 3, 5, 9, 8], &[2, 0, 3, 6, 7, 9]]
            }
            _ => self.faces(),
        }
    }
}

/// A mesh of one kind of cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Node positions, mm.
    pub points: Vec<Vec3>,
    /// Kind of all cells.
    pub kind: CellKind,
    /// Node indices, [`CellKind`]'s number of them per cell.
    pub cells: Vec<u32>,
    /// Phase of every cell.
    pub phase: Vec<Phase>,
    /// Id of the aggregate or fibre every cell belongs to; `u32::MAX` in the mortar.
    pub aggregate: Vec<u32>,
    /// Zero-thickness cohesive elements: the aggregate side's face, then the nodes over it (6 or 8 in all).
    pub cohesive: Vec<u32>,
    /// Id of the aggregate below every cohesive element.
    pub cohesive_aggregate: Vec<u32>,
    /// The directions in which the specimen repeats itself.
    pub periodic: [bool; 3],
    /// What the builder had to decide.
    pub notes: Notes,
}

/// What a builder had to decide, and how often: nothing is bridged or thinned in silence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Notes {
    /// Nodes that two or more aggregates share: there a gap between them, thinner than the elements can show, is closed.
    pub closed_gaps: usize,
    /// Pairs of aggregates that share nodes.
    pub closed_gap_pairs: usize,
    /// The widest gap between two of these, mm.
    pub widest_closed_gap_mm: f64,
    /// Nodes of aggregates on flat sides of the specimen (across which it does not repeat itself): there a gap between the
    /// two, thinner than the elements can show, is closed.
    pub closed_side_gaps: usize,
    /// Aggregates that have such nodes.
    pub closed_side_gap_aggregates: usize,
    /// The widest gap between one of them and its side, mm.
    pub widest_closed_side_gap_mm: f64,
    /// Nodes of a fitted lattice that belong on a surface and lie off it, since there no angle would be large enough.
    pub off_surface_nodes: usize,
    /// Aggregates too small for their solid ITZ: it takes 0.8 of their centroid's depth instead.
    pub thinned_itz_aggregates: usize,
    /// Nodes of the solid ITZ that stopped short, so that no tetrahedron turns over.
    pub thinned_itz_nodes: usize,
    /// The nodes where the layer has no thickness at all.
    pub pinched_itz_nodes: usize,
    /// Inner nodes of a lattice's solid ITZ that left the exact offset, so that no angle is too sharp.
    pub shifted_itz_nodes: usize,
}

/// [`Mesh::aggregate`] of a cell that belongs to none.
pub const NO_AGGREGATE: u32 = u32::MAX;

impl Mesh {
    /// Cells alone, without cohesive elements, of a specimen that does not repeat itself.
    pub(crate) fn of(
        kind: CellKind,
        points: Vec<Vec3>,
        cells: Vec<u32>,
        phase: Vec<Phase>,
        aggregate: Vec<u32>,
    ) -> Self {
        let (cohesive, cohesive_aggregate) = (Vec::new(), Vec::new());
        let (periodic, notes) = ([false; 3], Notes::default());
        Self { points, kind, cells, phase, aggregate, cohesive, cohesive_aggregate, periodic, notes }
    }

    /// The cells' node indices, one slice per cell.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.cells.chunks_exact(self.kind.nodes())
    }

    /// The cohesive elements' nodes, one slice per element.
    pub fn cohesive(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.cohesive.chunks_exact(2 * self.kind.faces()[0].len())
    }

    /// Number of cells, cohesive elements apart.
    pub fn cell_count(&self) -> usize {
        self.phase.len()
    }
}

/// Meshes a packed specimen by a method of our own.
///
/// # Errors
/// Options that cannot be met are named before any work starts; see [`MeshError`].
pub fn build(model: &Model, options: &MeshOptions) -> Result<Mesh, MeshError> {
    build_parts(&model.bodies(), &model.spec.specimen, options)
}

/// Meshes a packed specimen; `gmsh` is asked where the method is conforming.
///
/// # Errors
/// As [`build`], and those of `gmsh`.
pub fn build_with(model: &Model, options: &MeshOptions, gmsh: &dyn VolumeMesher) -> Result<Mesh, MeshError> {
    assemble(&model.bodies(), &model.spec.specimen, options, gmsh)
}

/// Meshes `aggregates`, which must be disjoint and inside `specimen`; voids among them are left out of the mesh.
///
/// # Errors
/// As [`build`].
pub fn build_parts(aggregates: &[Aggregate], specimen: &Specimen, options: &MeshOptions) -> Result<Mesh, MeshError> {
    assemble(aggregates, specimen, options, &|_: &conforming::Surfaces| Err(MeshError::NeedsGmsh))
}

fn assemble(
    aggregates: &[Aggregate],
    specimen: &Specimen,
    options: &MeshOptions,
    gmsh: &dyn VolumeMesher,
) -> Result<Mesh, MeshError> {
    options.validate(specimen)?;
    let room = specimen.container();
    // Where the specimen repeats itself, what crosses a face comes in again on the other side.
    let mut images = images_near(aggregates, specimen, 0.0);
    images.sort_by(before);
    let (placed, aggregates) = (aggregates, images.as_slice());
    let size = options.element_size_mm;
    let mut mesh = match options.method {
        Method::Voxel { thin_itz, subsamples } => voxel::build(aggregates, specimen, options, thin_itz, subsamples),
        Method::Lattice { fit: Fit::Plain, .. } => lattice::plain(aggregates, specimen, options),
        Method::Lattice { fit: Fit::Fitted, .. } => {
            let (tetrahedra, notes) = lattice::fitted(aggregates, &*room, specimen.periodic().0, size);
            with_layer(of_tetrahedra(tetrahedra, aggregates, notes), aggregates, specimen, options)
        }
        Method::Conforming { slabs, .. } => {
            let mesh = conforming::mesh(placed, aggregates, specimen, size, slabs, gmsh)?;
            with_layer(mesh, aggregates, specimen, options)
        }
    };
    mesh.periodic = specimen.periodic().0;
    let whole_cells = matches!(options.method, Method::Voxel { .. } | Method::Lattice { fit: Fit::Plain, .. });
    if whole_cells {
        clip::clip(&mut mesh, &*room);
    }
    clip::leave_out_voids(&mut mesh, aggregates);
    joined::note(&mut mesh, aggregates, &FlatSides::of(specimen));
    if options.itz == ItzForm::Cohesive {
        cohesive::add(&mut mesh);
        if mesh.periodic != [false; 3] {
            opposite::complete(&mut mesh);
        }
    }
    volumes::all_positive(&mesh)?;
    if options.method.order() == Order::Quadratic {
        mesh.raise_order();
    }
    Ok(mesh)
}

/// The order of bodies, that builders decide by: images at opposite faces are in the same one.
fn before(a: &Aggregate, b: &Aggregate) -> Ordering {
    let corner = |body: &Aggregate| body.body.aabb().min;
    let along = |axis: usize| corner(a)[axis].total_cmp(&corner(b)[axis]);
    a.id.cmp(&b.id).then_with(|| along(0).then(along(1)).then(along(2)))
}

/// Tetrahedra of aggregates and mortar with the solid ITZ, where it is asked for.
fn with_layer(mut mesh: Mesh, aggregates: &[Aggregate], specimen: &Specimen, options: &MeshOptions) -> Mesh {
    mesh.periodic = specimen.periodic().0;
    if options.itz == ItzForm::Solid {
        let thinned = layer::add(&mut mesh, aggregates, |a| a.itz_thickness_mm);
        mesh.notes.thinned_itz_aggregates = thinned.aggregates;
        mesh.notes.thinned_itz_nodes = thinned.nodes;
        mesh.notes.pinched_itz_nodes = thinned.pinched;
        if options.method.name() == MethodName::Lattice {
            let blunted = layer::blunt(&mut mesh, &thinned, options.element_size_mm);
            mesh.notes.shifted_itz_nodes = blunted.shifted;
            mesh.notes.pinched_itz_nodes += blunted.collapsed;
        }
    }
    mesh
}

/// Tetrahedra as a mesh of aggregates and mortar.
fn of_tetrahedra(tetrahedra: Tetrahedra, aggregates: &[Aggregate], notes: Notes) -> Mesh {
    let phase = |&g: &u32| if g == NO_AGGREGATE { Phase::Mortar } else { Phase::inside(aggregates[g as usize].kind) };
    let id = |&g: &u32| if g == NO_AGGREGATE { g } else { aggregates[g as usize].id };
    let (phases, ids) = (tetrahedra.grain.iter().map(phase).collect(), tetrahedra.grain.iter().map(id).collect());
    let cells = tetrahedra.cells.into_flattened();
    Mesh { notes, ..Mesh::of(CellKind::Tetrahedron, tetrahedra.points, cells, phases, ids) }
}

/// The thickness of an aggregate's shell as a layer of solid elements, mm; 0 for none.
fn shell_thickness(aggregate: &Aggregate, options: &MeshOptions) -> f64 {
    match options.itz {
        ItzForm::Solid => aggregate.itz_thickness_mm,
        ItzForm::Cohesive | ItzForm::None => 0.0,
    }
}
