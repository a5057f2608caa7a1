//! From a packing to its mesh, whatever the method.

use super::cells::{CellKind, Draft, Mesh, NO_BODY, Notes, Phase};
use super::conforming::{self, VolumeMesher};
use super::error::MeshError;
use super::options::{Fit, ItzForm, MeshOptions, Method, MethodName, Order};
use super::sides::FlatSides;
use super::tet::TetMesh;
use super::{clip, closed_gaps, interface, lattice, layer, periodic, volumes, voxel};
use crate::aggregate::Aggregate;
use crate::model::Model;
use crate::packing::{Specimen, images_near};
use std::cmp::Ordering;

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
    let container = specimen.container();
    // Where the specimen repeats itself, what crosses a face comes in again on the other side.
    let mut bodies = images_near(aggregates, specimen, 0.0);
    bodies.sort_by(before);
    let bodies = bodies.as_slice();
    let mut mesh = cells_of(aggregates, bodies, specimen, options, gmsh)?;
    if matches!(options.method, Method::Voxel { .. } | Method::Lattice { fit: Fit::Plain, .. }) {
        clip::clip(&mut mesh, &*container);
    }
    clip::leave_out_voids(&mut mesh, bodies);
    closed_gaps::note(&mut mesh, bodies, &FlatSides::of(specimen));
    if options.itz == ItzForm::Cohesive {
        interface::add_cohesive(&mut mesh);
        if mesh.periodic != [false; 3] {
            periodic::complete(&mut mesh);
        }
    }
    volumes::all_positive(&mesh)?;
    if options.method.order() == Order::Quadratic {
        mesh.raise_order();
    }
    Ok(mesh)
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
            with_layer(mesh, Notes::default(), bodies, periodic, options)
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
