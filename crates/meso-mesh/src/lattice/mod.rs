//! Body-centred cubic tetrahedra, plain or fitted to the bodies.
//!
//! Plain: every tetrahedron has the phase of its centroid. Fitted: isosurface stuffing after Labelle and Shewchuk
//! (SIGGRAPH 2007), for many materials and exact planes:
//!
//! 1. [`warp`]: lattice nodes near a surface move onto it.
//! 2. [`stencils`]: the edges that still cross one are cut there. So it goes with the specimen's own surface where that is no
//!    box ([`boundary`]), and the cells outside are left out.
//! 3. [`sweeps`]: the nodes slide onto the bodies' edges and corners and are smoothed.
//! 4. [`repair`]: small angles are enlarged, and nodes that left their body for it come back.

mod bcc;
mod boundary;
mod caps;
mod nodes;
mod repair;
mod reprojection;
mod smoothing;
mod stencils;
mod surface;
mod sweeps;
mod warp;

use super::options::MeshOptions;
use crate::cells::{CellKind, Mesh, NO_BODY, Notes, Phase};
use crate::location::{Facets, Locator};
use crate::tet::{TetMesh, centroid, oriented};
use bcc::Bcc;
use boundary::{Boundary, BoundarySurface};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::specimen::{Container, Specimen};
use meso_concrete::stop;
use surface::Surface;

/// The plain lattice: phase by centroid.
pub(super) fn plain(bodies: &[Aggregate], specimen: &Specimen, options: &MeshOptions) -> Mesh {
    let facets = Facets::all(bodies, |body| options.shell_mm(body));
    let bcc = Bcc::new(specimen.aabb(), options.element_size_mm);
    let locator = Locator::new(&facets, &specimen.aabb());
    let points: Vec<Vec3> = parallel::map_short(bcc.nodes(), |node| bcc.position(node as u32));
    let layers: Vec<Vec<[u32; 4]>> = parallel::map(bcc.counts[2], |k| {
        let mut cells = Vec::new();
        bcc.tetrahedra(k, |cell| cells.push(oriented(cell, &points)));
        cells
    });
    let cells = layers.concat();
    let located = parallel::map_each(&cells, |cell| locate(&facets, &locator, &centroid(*cell, &points)));
    let (phase, owner) = located.into_iter().unzip();
    Mesh::of(CellKind::Tetrahedron, points, cells.into_flattened(), phase, owner)
}

fn locate(facets: &[Facets], locator: &Locator, x: &Vec3) -> (Phase, u32) {
    stop::point();
    match locator.find(x) {
        None => (Phase::Mortar, NO_BODY),
        Some((body, height)) if facets[body].has_in_shell(x, height) => (Phase::Itz, body as u32),
        Some((body, _)) => (facets[body].phase, body as u32),
    }
}

/// The fitted lattice: bodies and mortar within `container`, its own surface included.
pub(super) fn fitted(
    bodies: &[Aggregate],
    container: &dyn Container,
    repeats: [bool; 3],
    element_size: f64,
) -> (TetMesh, Notes) {
    let surface = BoundarySurface::new(container);
    let wholes = parallel::map_each(bodies, |body| (body.body.volume(), body.body.cut_space()));
    // Cells reach at most one element beyond a node that is pulled onto a surface.
    let continued = caps::continued(bodies, 2.0 * element_size);
    let bodies = continued.as_deref().unwrap_or(bodies);
    let facets = Facets::all(bodies, |_| 0.0);
    let open = surface.as_ref().map_or_else(Default::default, |surface| surface.open);
    let bcc = Bcc::new(container.aabb(), element_size).reaching_beyond(open);
    let locator = Locator::new(&facets, bcc.domain());
    let mut field = warp::Field::new(&bcc, &facets, surface.as_ref());
    field.warp();
    let mut mesh = stencils::Cutter::new(&field, &locator).cells();
    let surface = surface.as_ref().map(|surface| (surface, stencils::trim(&mut mesh)));
    let boundary = Boundary { surface, repeats };
    let surfaces: Vec<Surface> =
        parallel::map(bodies.len(), |i| Surface::new(&bodies[i].body, wholes[i].0, wholes[i].1));
    let off = sweeps::fit(&mut mesh, &surfaces, &locator, bcc.domain(), element_size, &boundary);
    let off_surface_nodes = off + nodes::count_off(&mesh, &surfaces, bcc.domain(), &boundary);
    (mesh, Notes { off_surface_nodes, ..Notes::default() })
}
