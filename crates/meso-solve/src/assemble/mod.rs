//! Blocks of elements of a mesh.

mod builder;
pub(crate) mod mass;
mod order;
pub(crate) mod parts;
pub(crate) mod patches;
pub(crate) mod tet;
mod weight;

use crate::assemble::builder::{Builder, OwnPatches};
use crate::assemble::order::{along_curve, key};
use crate::assemble::parts::BlockParts;
use crate::assemble::patches::{Numbered, Patches};
use crate::assemble::weight::Weight;
use crate::error::SolveError;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::PhaseNames;
use meso_element::block::{BLOCK, Batch, Block};
use meso_element::hex::BoxShape;
use meso_element::uniform::Uniform;
use meso_mesh::{CellKind, Mesh, Phase};
use meso_trial::Smoothing;
use rayon::prelude::*;

/// A mesh in the engine's order.
pub(crate) struct Assembly {
    pub(crate) blocks: Vec<Block>,
    /// Where strains are smoothed.
    pub(crate) patches: Option<Patches>,
    /// The mesh's number of every node of the engine.
    pub(crate) nodes: Vec<u32>,
    /// Lumped mass, tonne, by the engine's numbers.
    pub(crate) mass: Vec<f64>,
    /// Total mass without and with mass scaling, tonne.
    pub(crate) masses: [f64; 2],
    /// Longest step that needs no mass, s.
    pub(crate) stable_s: f64,
    /// Widest crack band by phase, mm.
    pub(crate) widest_mm: [f64; PhaseNames::ROOM],
}

/// Assembles a mesh.
///
/// # Errors
/// Cells of no positive volume, and hexahedra that are not boxes of one size.
pub(crate) fn assemble(parts: &BlockParts) -> Result<Assembly, SolveError> {
    let mesh = parts.sample.mesh;
    let aabb = Aabb::around(&mesh.points);
    let (nodes, number) = numbered(mesh);
    let patches = patches(parts, &nodes, &number);
    let weight = Weight::of(parts, patches.as_ref())?;
    let mass = nodes.iter().map(|&old| weight.mass[old as usize]).collect();
    let blocks = blocks(parts, &aabb, &number, patches.as_ref());
    let widest_mm = widest(&blocks, parts);
    Ok(Assembly { blocks, patches, nodes, mass, masses: weight.total, stable_s: weight.stable_s, widest_mm })
}

/// The mesh's number of every node of the engine, and the other way round.
fn numbered(mesh: &Mesh) -> (Vec<u32>, Vec<u32>) {
    let nodes = along_curve(mesh.points.len(), &Aabb::around(&mesh.points), |node| mesh.points[node]);
    let mut number = vec![0; nodes.len()];
    (0..).zip(&nodes).for_each(|(new, &old)| number[old as usize] = new);
    (nodes, number)
}

/// Longest step for which no solid element needs more than its own mass, s.
///
/// # Errors
/// Cells of no positive volume.
pub(crate) fn stable_s(parts: &BlockParts) -> Result<f64, SolveError> {
    let (nodes, number) = numbered(parts.sample.mesh);
    Ok(Weight::of(parts, patches(parts, &nodes, &number).as_ref())?.stable_s)
}

/// Patches of a mesh of tetrahedra; none unless strains are smoothed.
fn patches(parts: &BlockParts, nodes: &[u32], number: &[u32]) -> Option<Patches> {
    let (mesh, matter) = (parts.sample.mesh, &parts.common.matter);
    let is_smoothed = parts.smoothing == Smoothing::Edges;
    let mixed = matter[Phase::Mortar.index()].elastic == matter[Phase::Itz.index()].elastic;
    is_smoothed.then(|| Patches::of(Numbered { mesh, phases: &mesh.phase, number }, nodes, mixed))
}

/// The mesh's one box.
///
/// # Errors
/// Where its hexahedra are not boxes of one size along the axes.
pub(crate) fn box_shape(mesh: &Mesh) -> Result<BoxShape, SolveError> {
    if mesh.kind != CellKind::Hexahedron {
        return Ok(BoxShape { edges: [1.0; 3] });
    }
    let first = &mesh.cells[..8];
    let p = |cell: &[u32], corner: usize| mesh.points[cell[corner] as usize];
    let edges = Vec3::from_fn(|axis, _| p(first, [1, 3, 4][axis])[axis] - p(first, 0)[axis]);
    let slack = 1e-6 * edges.amax();
    let signs = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let is_box = |cell: &[u32]| {
        let expected = |corner: usize| p(cell, 0) + edges.component_mul(&Vec3::from(signs[corner].map(f64::from)));
        (1..8).all(|corner| (p(cell, corner) - expected(corner)).amax() <= slack)
    };
    match mesh.cells().find(|cell| edges.min() <= 0.0 || !is_box(cell)) {
        None => Ok(BoxShape { edges: edges.into() }),
        Some(cell) => {
            let at: [f64; 3] = p(cell, 0).into();
            let why = format!("the hexahedron at {at:?} is no box like the first one; take voxels or tetrahedra");
            Err(SolveError::mesh(why))
        }
    }
}

fn blocks(parts: &BlockParts, aabb: &Aabb, number: &[u32], patches: Option<&Patches>) -> Vec<Block> {
    let mesh = parts.sample.mesh;
    let centre = |cell: usize| centroid(mesh, mesh.cell(cell));
    let order = along_curve(mesh.cell_count(), aabb, centre);
    let chunks: Vec<&[u32]> = order.chunks(BLOCK).collect();
    let faces = faces_by_block(mesh, aabb, &chunks);
    let of_patches = patches.map_or_else(Vec::new, |patches| patches_by_block(mesh, patches, &chunks));
    let build = |block: usize| {
        let own = patches.map(|patches| OwnPatches::new(mesh, patches, &of_patches[block]));
        Builder::new(parts, number, own).build(chunks[block], &faces[block])
    };
    // The last cells may have no patch of their own.
    (0..chunks.len()).into_par_iter().map(build).filter(|block| !block.nodes.is_empty()).collect()
}

fn centroid(mesh: &Mesh, nodes: &[u32]) -> Vec3 {
    nodes.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / nodes.len() as f64
}

/// Cohesive faces go to the block in which the curve passes them.
fn faces_by_block(mesh: &Mesh, aabb: &Aabb, chunks: &[&[u32]]) -> Vec<Vec<u32>> {
    let first = |chunk: &&[u32]| key(aabb, &centroid(mesh, mesh.cell(chunk[0] as usize)));
    let starts: Vec<u64> = chunks.iter().map(first).collect();
    let mut faces = vec![Vec::new(); chunks.len()];
    for (number, face) in (0..).zip(mesh.cohesive()) {
        let at = key(aabb, &centroid(mesh, face));
        faces[starts.partition_point(|&start| start <= at).saturating_sub(1)].push(number);
    }
    faces
}

/// Patches go to the block of their first cell.
fn patches_by_block(mesh: &Mesh, patches: &Patches, chunks: &[&[u32]]) -> Vec<Vec<u32>> {
    let mut block_of = vec![0_u32; mesh.cell_count()];
    for (block, cells) in (0..).zip(chunks) {
        cells.iter().for_each(|&cell| block_of[cell as usize] = block);
    }
    let mut of_blocks = vec![Vec::new(); chunks.len()];
    for patch in 0..patches.len() as u32 {
        of_blocks[block_of[patches.cells(patch)[0] as usize] as usize].push(patch);
    }
    of_blocks
}

/// The widest crack band of every phase.
fn widest(blocks: &[Block], parts: &BlockParts) -> [f64; PhaseNames::ROOM] {
    fn most<const N: usize>(cells: &[Uniform<N>]) -> f64 {
        cells.iter().flat_map(|cells| cells.width.0).fold(0.0, |most, width| most.max(f64::from(width)))
    }
    let mut widest = [0.0_f64; PhaseNames::ROOM];
    for group in blocks.iter().flat_map(|block| &block.groups) {
        let widest = &mut widest[group.phase.index()];
        match &group.cells {
            Batch::Tets(cells) => *widest = widest.max(most(cells)),
            Batch::Patches8(cells) => *widest = widest.max(most(cells)),
            Batch::Patches9(cells) => *widest = widest.max(most(cells)),
            Batch::Patches12(cells) => *widest = widest.max(most(cells)),
            Batch::Hexes(_) => *widest = parts.common.band_mm,
            Batch::Triangles(_) | Batch::Quads(_) => {}
        }
    }
    widest
}
