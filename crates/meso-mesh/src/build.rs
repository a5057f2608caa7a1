//! The mesh of a packing, by any method.
//!
//! Mortar outside a specimen that does not fill its bounding box is clipped, cell by cell (`clip`); the surface that is left is
//! one of whole cells: as far as half an element from the specimen's own. (A fitted lattice is cut at the specimen's
//! surface instead.) Voids are left out of every mesh.

use super::acceptance::all_positive;
use super::body_images::BodyImages;
use super::conforming::{self, VolumeMesher};
use super::error::MeshError;
use super::options::{Fit, ItzForm, Joined, MeshOptions, Method, MethodName, NarrowGaps, Order, Volumes};
use super::{clip, lattice, layer, voxel};
use crate::analysis::{add_cohesive, part_joined, restore_volumes, smear_itz, spare_stiff, split_narrow};
use crate::cells::{CellKind, FlatSides, Mesh, NO_BODY, Notes, Phase, cell_volume, drop_lone_nodes};
use crate::figures::{PhaseVolumes, note_closed_gaps};
use crate::location::Facets;
use crate::tet::TetMesh;
use meso_collision::geometry::BodyForm;
use meso_collision::math::Vec3;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::specimen::Container;
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_concrete::{Parts, parallel};

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
    let parts = parts.into();
    let Parts { specimen, .. } = parts;
    let options = &options.for_bodies(&parts.bodies);
    let Tools { gmsh, watch } = *tools;
    options.validate(specimen)?;
    accepts(&parts.bodies, options)?;
    report(watch, 0.02)?;
    // Where the specimen repeats itself, a body that crosses a face comes in again on the other side.
    let bodies = &BodyImages::of(&parts);
    report(watch, 0.05)?;
    let mut mesh = cells_of(&parts, bodies, options, gmsh)?;
    report(watch, 0.6)?;
    if !options.method.follows_surfaces() {
        clip(&mut mesh, &*specimen.container());
    }
    leave_out_voids(&mut mesh, &parts.bodies);
    note_closed_gaps(&mut mesh, bodies, &FlatSides::of(specimen));
    report(watch, 0.75)?;
    make_fit(&mut mesh, bodies, options);
    report(watch, 0.85)?;
    if options.itz == ItzForm::Cohesive {
        add_cohesive(&mut mesh);
    }
    report(watch, 0.95)?;
    all_positive(mesh.by_owner())?;
    mark_own(&mut mesh, &parts, bodies, options);
    if options.method.order() == Order::Quadratic {
        mesh.raise_order();
    }
    Ok(mesh)
}

/// Refuses methods that cannot mesh some of the `bodies`.
///
/// # Errors
/// A conforming mesh takes convex polyhedra.
pub fn accepts(bodies: &[Aggregate], options: &MeshOptions) -> Result<(), MeshError> {
    let forms = || bodies.iter().map(|body| body.body.form());
    let has_round = forms().any(|form| matches!(form, BodyForm::Round(_)));
    options.accepts(has_round, forms().any(|form| form == BodyForm::Surface))
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
fn make_fit(mesh: &mut Mesh, bodies: &BodyImages, options: &MeshOptions) {
    // Where cells stand across the surfaces, whole faces of aggregates meet: cohesive elements there would bear pressure.
    if options.joined != Joined::Keep && (options.itz != ItzForm::Cohesive || !options.method.follows_surfaces()) {
        part_joined(mesh, bodies, options.joined == Joined::Cut);
    }
    if options.itz != ItzForm::Solid && restores_volumes(options) {
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

/// Whether the aggregates get their exact volumes: without a layer once they are parted, else before it opens.
fn restores_volumes(options: &MeshOptions) -> bool {
    options.method.follows_surfaces() && options.volumes == Some(Volumes::Exact)
}

/// The cells of the method asked for, with the solid ITZ as a layer of its own.
fn cells_of(
    parts: &Parts,
    bodies: &BodyImages,
    options: &MeshOptions,
    gmsh: &dyn VolumeMesher,
) -> Result<Mesh, MeshError> {
    let Parts { bodies: placed, specimen, .. } = parts;
    let all = bodies.all.as_slice();
    let (size, periodic) = (options.element_size_mm, specimen.periodic().0);
    let mut mesh = match options.method {
        Method::Voxel { thin_itz, subsamples } => voxel::build(all, specimen, options, thin_itz, subsamples),
        Method::Lattice { fit: Fit::Plain, .. } => lattice::plain(all, specimen, options),
        Method::Lattice { fit: Fit::Fitted, .. } => {
            let (mesh, notes) = lattice::fitted(all, &*specimen.container(), periodic, size);
            with_layer(mesh, notes, bodies, parts, options)
        }
        Method::Conforming { slabs, .. } => {
            let mesh = conforming::mesh(placed, all, specimen, size, slabs, gmsh)?;
            with_layer(mesh, Notes { conforming: true, ..Notes::default() }, bodies, parts, options)
        }
    };
    bodies.name_bodies(&mut mesh.owner);
    Ok(Mesh { periodic, id_of: bodies.id_of.clone(), ..mesh })
}

/// The most that a body whose volume is not restored may lose for its layer's sake, as a share of it. Without a limit, a mesh
/// of 4 mm misses 13 % of aggregates from 5 mm, and with it 10 %.
const FLAPS: f64 = 0.02;

/// Tetrahedra of bodies and mortar with the solid ITZ and the shells below it, where it is asked for.
fn with_layer(mut mesh: TetMesh, mut notes: Notes, images: &BodyImages, parts: &Parts, options: &MeshOptions) -> Mesh {
    let bodies = images.all.as_slice();
    let inside = |&owner: &u32| match owner {
        NO_BODY => Phase::Mortar,
        owner => Phase::of(bodies[owner as usize].kind),
    };
    let mut phase: Vec<Phase> = mesh.owner.iter().map(inside).collect();
    if options.itz == ItzForm::Solid {
        let periodic = parts.specimen.periodic().0;
        let is_lattice = options.method.name() == MethodName::Lattice;
        if is_lattice {
            let most = if restores_volumes(options) { f64::INFINITY } else { FLAPS };
            layer::unfold(&mut mesh, &mut phase, periodic, bodies, most);
        }
        if restores_volumes(options) {
            mesh.points = with_exact_volumes(&mesh, &phase, images, options.element_size_mm);
        }
        let exact = PhaseVolumes::exact(&parts.bodies, parts.specimen, |aggregate| options.shell_mm(aggregate)).ok();
        notes.cores_mm3 = exact.map(|exact| exact.aggregate);
        let (size, mut finished) = (options.element_size_mm, layer::FinishedLayer::default());
        let shells = parts.bodies.iter().map(|body| body.shells.len()).max().unwrap_or(0);
        for number in 0..=shells {
            // Inner sides of layers have nodes along most edges alone.
            let onto = if is_lattice || number > 0 { layer::Onto::Triangles(size) } else { layer::Onto::Faces };
            let exact_mm3 = match number {
                0 => exact.map(|exact| exact.itz),
                shell => layer::exact_mm3(&parts.bodies, shell),
            };
            let (first, between) = (mesh.cells.len(), |body: &Aggregate| body.layer_between(number));
            let layer = layer::add(&mut mesh, &mut phase, periodic, bodies, between, onto, exact_mm3);
            notes.thinned_itz_aggregates += layer.thinned_aggregates;
            notes.thinned_itz_nodes += layer.short_nodes();
            notes.pinched_itz_nodes += layer.pinched_nodes;
            if is_lattice {
                let improved = layer::improve(&mut mesh, &mut phase, periodic, &layer, exact_mm3, size);
                notes.shifted_itz_nodes += improved.shifted;
                notes.pinched_itz_nodes += improved.collapsed;
                notes.thinned_itz_nodes += improved.thinned;
            }
            finished.set_aside(&mut mesh, &mut phase, first);
        }
        finished.give_back(&mut mesh, &mut phase, bodies);
        if is_lattice && shells > 0 {
            layer::smooth(&mut mesh, &mut phase, periodic, bodies, size);
        }
    }
    let TetMesh { points, cells, owner } = mesh;
    Mesh { notes, ..Mesh::of(CellKind::Tetrahedron, points, cells.into_flattened(), phase, owner) }
}

/// The nodes where the aggregates have their exact volumes.
fn with_exact_volumes(mesh: &TetMesh, phase: &[Phase], images: &BodyImages, size: f64) -> Vec<Vec3> {
    let mut owner = mesh.owner.clone();
    images.name_bodies(&mut owner);
    let cells = mesh.cells.as_flattened().to_vec();
    let mut whole = Mesh::of(CellKind::Tetrahedron, mesh.points.clone(), cells, phase.to_vec(), owner);
    restore_volumes(&mut whole, images, size);
    whole.points
}

/// Keeps the aggregates' cells and the mortar's inside `container`, and the nodes they have.
fn clip(mesh: &mut Mesh, container: &dyn Container) {
    if !container.is_box() {
        let inside = clip::kept(mesh, container);
        retain(mesh, &inside);
    }
}

/// Gives the cells of aggregates with phases of their own these phases; all of meshing is the same for them. In an aggregate
/// with shells a cell has the phase at its centre, unless the shells are layers.
fn mark_own(mesh: &mut Mesh, parts: &Parts, images: &BodyImages, options: &MeshOptions) {
    mesh.phases = parts.phases.clone();
    if parts.bodies.iter().all(|body| body.own.is_none() && body.shells.is_empty()) {
        return;
    }
    let has_layers = options.itz == ItzForm::Solid && options.method.follows_surfaces();
    // A cell lies in one of the images of its body.
    let facets = |body: usize| match has_layers || parts.bodies[body].shells.is_empty() {
        true => Vec::new(),
        false => Facets::all(images.images(body as u32), |_| 0.0),
    };
    let facets = parallel::map(parts.bodies.len(), facets);
    let (nodes, mut phase) = (mesh.kind.nodes(), std::mem::take(&mut mesh.phase));
    parallel::each_short_mut(&mut phase, |cell, phase| {
        if *phase != Phase::Aggregate {
            return;
        }
        let owner = mesh.owner[cell] as usize;
        let corners = &mesh.cells[nodes * cell..][..mesh.kind.corners()];
        let centre = corners.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / corners.len() as f64;
        let depth = facets[owner].iter().map(|facets| -facets.height(&centre)).fold(f64::NEG_INFINITY, f64::max);
        *phase = parts.bodies[owner].phase_at(if facets[owner].is_empty() { f64::INFINITY } else { depth });
    });
    mesh.phase = phase;
}

/// Keeps all cells but those of voids, whose volume is noted.
fn leave_out_voids(mesh: &mut Mesh, bodies: &[Aggregate]) {
    if bodies.iter().all(|body| body.kind != Kind::Void) {
        return;
    }
    let is_void = |&owner: &u32| bodies.get(owner as usize).is_some_and(|body| body.kind == Kind::Void);
    let solid = parallel::map_short(mesh.owner.len(), |cell| !is_void(&mesh.owner[cell]));
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
    mesh.owner.retain(|_| *kept.next().unwrap_or(&true));
    drop_lone_nodes(&mut mesh.points, &mut mesh.cells);
}
