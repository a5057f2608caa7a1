//! From a packing to its mesh, whatever the method.
//!
//! Mortar outside a specimen that does not fill its bounding box is clipped, cell by cell (`clip`); the surface that is left is
//! one of whole cells: as far as half an element from the specimen's own. (A fitted lattice is cut at the specimen's
//! surface instead.) Voids are left out of every mesh.

use super::acceptance::all_positive;
use super::conforming::{self, VolumeMesher};
use super::draft::Draft;
use super::error::MeshError;
use super::options::{Fit, ItzForm, Joined, MeshOptions, Method, MethodName, NarrowGaps, Order, Volumes};
use super::{clip, lattice, layer, voxel};
use crate::analysis::{add_cohesive, part_joined, restore_volumes, smear_itz, spare_stiff, split_narrow};
use crate::cells::{CellKind, FlatSides, Mesh, NO_BODY, Notes, Phase, cell_volume, drop_lone_nodes};
use crate::figures::note_closed_gaps;
use crate::tet::TetMesh;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::images::near as images_near;
use meso_concrete::specimen::{Container, Specimen};
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_concrete::{Parts, parallel};
use std::cmp::Ordering;

/// The help that a mesh may need from outside.
#[derive(Clone, Copy)]
pub struct Tools<'a> {
    /// Fills surfaces with tetrahedra; only the conforming method asks for it.
    pub gmsh: &'a dyn VolumeMesher,
    /// Watches [`Stage::Mesh`]; meshing ends between two steps when the watch stops.
    pub watch: &'a dyn Watch,
}

impl Default for Tools<'_> {
    /// No gmsh, and nobody who watches.
    fn default() -> Self {
        Self { gmsh: &|_: &conforming::Surfaces| Err(MeshError::NeedsGmsh), watch: &Silent }
    }
}

/// Meshes bodies inside a specimen; voids among them are left out of the mesh.
///
/// # Errors
/// Options that cannot be met are named before any work starts; see [`MeshError`].
pub fn build<'a>(parts: impl Into<Parts<'a>>, options: &MeshOptions, tools: &Tools) -> Result<Mesh, MeshError> {
    let Parts { bodies: aggregates, specimen } = &parts.into();
    let Tools { gmsh, watch } = *tools;
    options.validate(specimen)?;
    report(watch, 0.02)?;
    // Where the specimen repeats itself, what crosses a face comes in again on the other side.
    let mut bodies = images_near(aggregates, specimen, 0.0);
    bodies.sort_by(before);
    let bodies = bodies.as_slice();
    report(watch, 0.05)?;
    let mut mesh = cells_of(aggregates, bodies, specimen, options, gmsh)?;
    report(watch, 0.6)?;
    if matches!(options.method, Method::Voxel { .. } | Method::Lattice { fit: Fit::Plain, .. }) {
        clip(&mut mesh, &*specimen.container());
    }
    leave_out_voids(&mut mesh, bodies);
    note_closed_gaps(&mut mesh, bodies, &FlatSides::of(specimen));
    report(watch, 0.75)?;
    make_fit(&mut mesh, bodies, options);
    report(watch, 0.85)?;
    if options.itz == ItzForm::Cohesive {
        add_cohesive(&mut mesh);
    }
    report(watch, 0.95)?;
    all_positive(mesh.by_aggregate())?;
    if options.method.order() == Order::Quadratic {
        mesh.raise_order();
    }
    Ok(mesh)
}

/// Reports the share of meshing that is done.
///
/// # Errors
/// [`MeshError::Stopped`] where the watch stops.
fn report(watch: &dyn Watch, share: f64) -> Result<(), MeshError> {
    watch.stage(Stage::Mesh, share);
    if watch.stops() { Err(MeshError::Stopped) } else { Ok(()) }
}

/// Parts joined aggregates, restores volumes, splits narrow gaps, spares stiff cells and names the smeared ITZ, as far as each
/// is asked for.
fn make_fit(mesh: &mut Mesh, bodies: &[Aggregate], options: &MeshOptions) {
    let follows_surfaces = !matches!(options.method, Method::Voxel { .. } | Method::Lattice { fit: Fit::Plain, .. });
    // Where cells stand across the surfaces, whole faces of aggregates meet: cohesive elements there would bear pressure.
    if options.joined != Joined::Keep && (options.itz != ItzForm::Cohesive || !follows_surfaces) {
        part_joined(mesh, bodies, options.joined == Joined::Cut);
    }
    if options.volumes == Volumes::Exact && follows_surfaces && options.itz != ItzForm::Solid {
        restore_volumes(mesh, bodies, options.element_size_mm);
    }
    if options.narrow_gaps == NarrowGaps::Split {
        mesh.notes.split_gap_edges = split_narrow(mesh);
    }
    if options.joined != Joined::Keep && options.itz != ItzForm::Solid {
        spare_stiff(mesh);
    }
    if options.itz == ItzForm::Smeared {
        smear_itz(mesh);
    }
}

/// The cells of the method asked for, with the solid ITZ as a layer of its own.
fn cells_of(
    placed: &[Aggregate],
    bodies: &[Aggregate],
    specimen: &Specimen,
    options: &MeshOptions,
    gmsh: &dyn VolumeMesher,
) -> Result<Mesh, MeshError> {
    let (size, periodic) = (options.element_size_mm, specimen.periodic().0);
    let (draft, notes) = match options.method {
        Method::Voxel { thin_itz, subsamples } => {
            (voxel::build(bodies, specimen, options, thin_itz, subsamples), Notes::default())
        }
        Method::Lattice { fit: Fit::Plain, .. } => (lattice::plain(bodies, specimen, options), Notes::default()),
        Method::Lattice { fit: Fit::Fitted, .. } => {
            let (mesh, notes) = lattice::fitted(bodies, &*specimen.container(), periodic, size);
            with_layer(mesh, notes, bodies, periodic, options)
        }
        Method::Conforming { slabs, .. } => {
            let mesh = conforming::mesh(placed, bodies, specimen, size, slabs, gmsh)?;
            with_layer(mesh, Notes { conforming: true, ..Notes::default() }, bodies, periodic, options)
        }
    };
    Ok(draft.into_mesh(bodies, periodic, notes))
}

/// The order of bodies, that builders decide by: images at opposite faces are in the same one.
fn before(a: &Aggregate, b: &Aggregate) -> Ordering {
    let corner = |body: &Aggregate| body.body.aabb().min;
    let along = |axis: usize| corner(a)[axis].total_cmp(&corner(b)[axis]);
    a.id.cmp(&b.id).then_with(|| along(0).then(along(1)).then(along(2)))
}

/// Tetrahedra of bodies and mortar with the solid ITZ, where it is asked for.
fn with_layer(
    mesh: TetMesh,
    mut notes: Notes,
    bodies: &[Aggregate],
    periodic: [bool; 3],
    options: &MeshOptions,
) -> (Draft, Notes) {
    let inside = |&owner: &u32| match owner {
        NO_BODY => Phase::Mortar,
        owner => Phase::inside(bodies[owner as usize].kind),
    };
    let phase = mesh.owner.iter().map(inside).collect();
    let mut mesh = layer::Layered { mesh, phase, periodic };
    if options.itz == ItzForm::Solid {
        let layer = layer::add(&mut mesh, bodies, |body| body.itz_thickness_mm);
        notes.thinned_itz_aggregates = layer.thinned_aggregates;
        notes.thinned_itz_nodes = layer.short_nodes;
        notes.pinched_itz_nodes = layer.pinched_nodes;
        if options.method.name() == MethodName::Lattice {
            let improved = layer::improve(&mut mesh, &layer, options.element_size_mm);
            notes.shifted_itz_nodes = improved.shifted;
            notes.pinched_itz_nodes += improved.collapsed;
        }
    }
    let layer::Layered { mesh, phase, .. } = mesh;
    let TetMesh { points, cells, owner } = mesh;
    (Draft { kind: CellKind::Tetrahedron, points, cells: cells.into_flattened(), phase, owner }, notes)
}

/// Keeps the aggregates' cells and the mortar's inside `container`, and the nodes they have.
fn clip(mesh: &mut Mesh, container: &dyn Container) {
    if !container.is_box() {
        let inside = clip::kept(mesh, container);
        retain(mesh, &inside);
    }
}

/// Keeps all cells but those of voids, whose volume is noted.
fn leave_out_voids(mesh: &mut Mesh, bodies: &[Aggregate]) {
    let mut voids: Vec<u32> = bodies.iter().filter(|body| body.kind == Kind::Void).map(|body| body.id).collect();
    if voids.is_empty() {
        return;
    }
    voids.sort_unstable();
    let solid = parallel::map_short(mesh.aggregate.len(), |cell| voids.binary_search(&mesh.aggregate[cell]).is_err());
    let taken = mesh.cells().zip(&solid).filter(|(_, is_solid)| !**is_solid);
    mesh.notes.voids_mm3 = taken.map(|(cell, _)| cell_volume(mesh.kind, cell, &mesh.points)).sum();
    retain(mesh, &solid);
}

/// Keeps some of the cells, and the nodes they have.
fn retain(mesh: &mut Mesh, cells: &[bool]) {
    let mut kept = cells.iter().flat_map(|kept| std::iter::repeat_n(*kept, mesh.kind.nodes()));
    mesh.cells.retain(|_| kept.next().unwrap_or(true));
    let mut kept = cells.iter();
    mesh.phase.retain(|_| *kept.next().unwrap_or(&true));
    let mut kept = cells.iter();
    mesh.aggregate.retain(|_| *kept.next().unwrap_or(&true));
    drop_lone_nodes(&mut mesh.points, &mut mesh.cells);
}
