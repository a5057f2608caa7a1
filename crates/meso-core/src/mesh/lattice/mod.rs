//! Body-centred cubic tetrahedra, plain or fitted to the grains.
//!
//! Plain: every tetrahedron has the phase of its centroid. Fitted: isosurface stuffing after Labelle and Shewchuk
//! (SIGGRAPH 2007), for many materials and exact planes: lattice nodes near a surface move onto it ([`snap`]), the edges
//! that still cross one are cut there ([`cut`]). So it goes with the specimen's own surface where that is no box
//! ([`outline`]), and what is outside is left out ([`trim`]).

mod back;
mod balance;
mod bcc;
mod cut;
mod finish;
mod fit;
mod mend;
mod merge;
mod outline;
mod places;
mod recut;
mod relabel;
mod roles;
mod skin;
mod slide;
mod smooth;
mod snap;
mod star;
mod surface;
mod trim;
mod twins;

use super::grains::{Grain, Locator};
use super::{CellKind, Mesh, MeshOptions, NO_AGGREGATE, Notes, Phase};
use crate::aggregate::Aggregate;
use crate::math::Vec3;
use crate::packing::{Container, Specimen};
use crate::stop;
use bcc::Bcc;
pub(in crate::mesh) use mend::ways;
use outline::Outline;
use rayon::prelude::*;
use skin::Skin;
pub(in crate::mesh) use star::{Star, Stars, sharpness, sharpness_of};
use surface::Surface;

/// Tetrahedra before they are a mesh: nodes, and the grain each lies in.
#[derive(Clone)]
pub(super) struct Tetrahedra {
    pub(super) points: Vec<Vec3>,
    pub(super) cells: Vec<[u32; 4]>,
    /// Index of the grain, [`NO_AGGREGATE`] in the mortar.
    pub(super) grain: Vec<u32>,
}

/// The plain lattice: phase by centroid.
pub(super) fn plain(aggregates: &[Aggregate], specimen: &Specimen, options: &MeshOptions) -> Mesh {
    let grains = Grain::all(aggregates, |a| super::shell_thickness(a, options));
    let bcc = Bcc::new(specimen.aabb(), options.element_size_mm);
    let locator = Locator::new(&grains, &specimen.aabb());
    let points: Vec<Vec3> = (0..bcc.nodes() as u32).into_par_iter().map(|node| bcc.position(node)).collect();
    let layers: Vec<Vec<[u32; 4]>> = (0..bcc.counts[2])
        .into_par_iter()
        .map(|k| {
            let mut cells = Vec::new();
            bcc.tetrahedra(k, |cell| cells.push(oriented(cell, &points)));
            cells
        })
        .collect();
    let cells = layers.concat();
    let located: Vec<(Phase, u32)> =
        cells.par_iter().map(|cell| locate(&grains, &locator, &centroid(cell, &points))).collect();
    let (phase, aggregate) = located.into_iter().unzip();
    Mesh::of(CellKind::Tetrahedron, points, cells.into_flattened(), phase, aggregate)
}

fn locate(grains: &[Grain], locator: &Locator, x: &Vec3) -> (Phase, u32) {
    stop::point();
    match locator.find(x) {
        None => (Phase::Mortar, NO_AGGREGATE),
        Some((g, height)) if height > -grains[g].shell => (Phase::Itz, grains[g].id),
        Some((g, _)) => (grains[g].phase, grains[g].id),
    }
}

/// The fitted lattice: grains and mortar within `room`, its own surface included.
pub(super) fn fitted(
    aggregates: &[Aggregate],
    room: &dyn Container,
    repeats: [bool; 3],
    element_size: f64,
) -> (Tetrahedra, Notes) {
    let grains = Grain::all(aggregates, |_| 0.0);
    let outline = Outline::new(room);
    let bcc =
        Bcc::new(room.aabb(), element_size).reaching_beyond(outline.as_ref().map_or_else(Default::default, |o| o.open));
    let locator = Locator::new(&grains, bcc.domain());
    let mut field = snap::Field::new(&bcc, &grains, outline.as_ref());
    field.snap();
    let mut mesh = cut::Cutter::new(&field, &locator).cells();
    let outline = outline.as_ref().map(|outline| (outline, trim::trim(&mut mesh)));
    let skin = Skin { outline, repeats };
    let surfaces: Vec<Surface> = aggregates.par_iter().map(|a| Surface::new(&a.body)).collect();
    let off = fit::fit(&mut mesh, &surfaces, &locator, bcc.domain(), element_size, &skin);
    let off_surface_nodes = off + twins::count_off(&mesh, &surfaces, bcc.domain(), &skin);
    (mesh, Notes { off_surface_nodes, ..Notes::default() })
}

pub(super) fn centroid(cell: &[u32; 4], points: &[Vec3]) -> Vec3 {
    cell.iter().map(|&node| points[node as usize]).sum::<Vec3>() / 4.0
}

/// The same nodes in the order of positive volume.
pub(crate) fn oriented(cell: [u32; 4], points: &[Vec3]) -> [u32; 4] {
    let [a, b, c, d] = cell;
    let p = |node: u32| points[node as usize] - points[a as usize];
    if p(b).cross(&p(c)).dot(&p(d)) < 0.0 { [a, c, b, d] } else { cell }
}
