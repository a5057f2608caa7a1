//! From a mesh to blocks of elements and nodes with mass.

use crate::block::{BLOCK, Block, Cells, Common, EMPTY, Group, eights};
use crate::element::face::Faces;
use crate::element::hex::{BoxShape, Hexes};
use crate::element::tet::{Shape, Tets};
use crate::error::SolveError;
use crate::lanes::{Eight, LANES};
use crate::mass::{Need, box_metric, tet_metric};
use crate::order::{along_curve, key};
use crate::sample::Sample;
use meso_core::materials::regular_edge;
use meso_core::math::{Aabb, Vec3};
use meso_core::mesh::{CellKind, Mesh, Phase};
use rayon::prelude::*;

/// Order of the phases within a block.
const PHASES: [Phase; 4] = [Phase::Mortar, Phase::Itz, Phase::Aggregate, Phase::Fibre];

/// A mesh in the engine's order.
pub(crate) struct Assembly {
    pub(crate) blocks: Vec<Block>,
    /// The mesh's number of every node of the engine.
    pub(crate) nodes: Vec<u32>,
    /// Lumped mass, tonne, by the engine's numbers.
    pub(crate) mass: Vec<f64>,
    /// Without and with what was added, tonne.
    pub(crate) masses: [f64; 2],
    /// Longest step that needs no mass, s.
    pub(crate) stable_s: f64,
    /// Widest crack band by phase, mm.
    pub(crate) widest_mm: [f64; 5],
}

/// Parts of an assembly.
pub(crate) struct Parts<'a> {
    pub(crate) sample: &'a Sample<'a>,
    pub(crate) phases: &'a [Phase],
    pub(crate) common: &'a Common,
    /// Time step, s.
    pub(crate) dt: f64,
}

/// Assembles a mesh.
///
/// # Errors
/// Cells of no positive volume, and hexahedra that are not boxes of one size.
pub(crate) fn assemble(parts: &Parts) -> Result<Assembly, SolveError> {
    let mesh = parts.sample.mesh;
    let aabb = Aabb::around(&mesh.points);
    let nodes = along_curve(mesh.points.len(), &aabb, |node| mesh.points[node]);
    let mut number = vec![0; nodes.len()];
    (0..).zip(&nodes).for_each(|(new, &old)| number[old as usize] = new);
    let mut weight = Weight::of(parts)?;
    weight.add_faces(parts);
    let mass = nodes.iter().map(|&old| weight.mass[old as usize]).collect();
    let blocks = blocks(parts, &aabb, &number);
    let widest_mm = widest(&blocks, parts);
    Ok(Assembly { blocks, nodes, mass, masses: weight.total, stable_s: weight.stable_s, widest_mm })
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

/// Mass of the mesh's nodes.
struct Weight {
    mass: Vec<f64>,
    /// Of it, what solid elements do not need for the step.
    spare: Vec<f64>,
    total: [f64; 2],
    stable_s: f64,
}

impl Weight {
    fn of(parts: &Parts) -> Result<Self, SolveError> {
        let mesh = parts.sample.mesh;
        let (count, corners) = (mesh.points.len(), mesh.kind.corners());
        let zero = || vec![0.0; count];
        let mut weight = Self { mass: zero(), spare: zero(), total: [0.0; 2], stable_s: f64::INFINITY };
        for (cell, &phase) in mesh.cells().zip(parts.phases) {
            let need = need(parts, cell, phase)?;
            weight.total[0] += need.mass;
            weight.total[1] += need.mass + need.added();
            weight.stable_s = weight.stable_s.min(need.stable_s);
            let share = 1.0 / corners as f64;
            for &node in cell {
                weight.mass[node as usize] += share * (need.mass + need.added());
                weight.spare[node as usize] += share * (need.mass - need.needed).max(0.0);
            }
        }
        Ok(weight)
    }

    /// Adds what cohesive faces need beyond what the nodes can spare.
    fn add_faces(&mut self, parts: &Parts) {
        let (mesh, Some(cohesion)) = (parts.sample.mesh, &parts.common.cohesion) else { return };
        let mut needed = vec![0.0; mesh.points.len()];
        let safe = parts.dt / crate::mass::SAFETY;
        for face in mesh.cohesive() {
            let (_, area) = facing(mesh, face);
            let share = cohesion.stiffness * area * safe * safe / 2.0;
            face.iter().for_each(|&node| needed[node as usize] += share);
        }
        for (node, needed) in needed.iter().enumerate() {
            let added = (needed - self.spare[node]).max(0.0);
            self.mass[node] += added;
            self.total[1] += added;
        }
    }
}

fn need(parts: &Parts, cell: &[u32], phase: Phase) -> Result<Need, SolveError> {
    let mesh = parts.sample.mesh;
    let matter = &parts.common.matter[phase as usize];
    if mesh.kind == CellKind::Hexahedron {
        let shape = &parts.common.shape;
        return Ok(Need::of(matter, &box_metric(shape), 8, shape.volume(), parts.dt));
    }
    let (metric, volume) = tet_metric(&corners(mesh, cell));
    if !(volume > 0.0 && metric.iter().all(|x| x.is_finite())) {
        let at: [f64; 3] = mesh.points[cell[0] as usize].into();
        return Err(SolveError::mesh(format!("the tetrahedron at {at:?} has the volume {volume} mm3; mesh anew")));
    }
    Ok(Need::of(matter, &metric, 4, volume, parts.dt))
}

fn corners(mesh: &Mesh, cell: &[u32]) -> [Vec3; 4] {
    [0, 1, 2, 3].map(|corner| mesh.points[cell[corner] as usize])
}

/// Unit normal of a cohesive face, out of the aggregate, and the area of each pair of its nodes, mm2.
fn facing(mesh: &Mesh, face: &[u32]) -> (Vec3, f64) {
    let pairs = face.len() / 2;
    let p = |i: usize| mesh.points[face[i] as usize];
    // Twice the area along the normal: the cross product of two edges, or of the diagonals.
    let twice = if pairs == 4 { (p(2) - p(0)).cross(&(p(3) - p(1))) } else { (p(1) - p(0)).cross(&(p(2) - p(0))) };
    let size = twice.norm();
    let normal = if size > 0.0 { twice / size } else { Vec3::z() };
    (normal, 0.5 * size / pairs as f64)
}

fn blocks(parts: &Parts, aabb: &Aabb, number: &[u32]) -> Vec<Block> {
    let mesh = parts.sample.mesh;
    let per_cell = mesh.kind.nodes();
    let centre = |cell: usize| centroid(mesh, &mesh.cells[cell * per_cell..][..per_cell]);
    let order = along_curve(mesh.cell_count(), aabb, centre);
    let chunks: Vec<&[u32]> = order.chunks(BLOCK).collect();
    let faces = faces_by_block(mesh, aabb, &chunks);
    let build = |(cells, faces): (&&[u32], &Vec<u32>)| Builder { parts, number, nodes: Vec::new() }.build(cells, faces);
    chunks.par_iter().zip(&faces).map(build).collect()
}

fn centroid(mesh: &Mesh, nodes: &[u32]) -> Vec3 {
    nodes.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / nodes.len() as f64
}

/// Cohesive faces go to the block in which the curve passes them.
fn faces_by_block(mesh: &Mesh, aabb: &Aabb, chunks: &[&[u32]]) -> Vec<Vec<u32>> {
    let per_cell = mesh.kind.nodes();
    let first = |chunk: &&[u32]| key(aabb, &centroid(mesh, &mesh.cells[chunk[0] as usize * per_cell..][..per_cell]));
    let starts: Vec<u64> = chunks.iter().map(first).collect();
    let mut faces = vec![Vec::new(); chunks.len()];
    for (number, face) in (0..).zip(mesh.cohesive()) {
        let at = key(aabb, &centroid(mesh, face));
        faces[starts.partition_point(|&start| start <= at).saturating_sub(1)].push(number);
    }
    faces
}

/// Builds one block.
struct Builder<'a> {
    parts: &'a Parts<'a>,
    /// The engine's number of every node of the mesh.
    number: &'a [u32],
    nodes: Vec<u32>,
}

impl Builder<'_> {
    fn build(mut self, cells: &[u32], faces: &[u32]) -> Block {
        let mesh = self.parts.sample.mesh;
        let mut cells = cells.to_vec();
        cells.sort_by_key(|&cell| self.parts.phases[cell as usize] as u8);
        let of_cells = cells.iter().flat_map(|&cell| self.cell(cell));
        let of_faces = faces.iter().flat_map(|&face| self.face(face));
        let mut nodes: Vec<u32> = of_cells.chain(of_faces).map(|&node| self.number[node as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        self.nodes = nodes;
        let mut groups = Vec::new();
        for phase in PHASES {
            let start = cells.partition_point(|&cell| (self.parts.phases[cell as usize] as u8) < phase as u8);
            let end = cells.partition_point(|&cell| self.parts.phases[cell as usize] as u8 <= phase as u8);
            if start < end {
                let own = &cells[start..end];
                let kind = if mesh.kind == CellKind::Hexahedron { self.hexes(own) } else { self.tets(own) };
                groups.push(self.group(phase, kind, own));
            }
        }
        if !faces.is_empty() {
            let is_quad = mesh.kind == CellKind::Hexahedron;
            let kind = if is_quad { Cells::Quads(self.faces(faces)) } else { Cells::Triangles(self.faces(faces)) };
            groups.push(self.group(Phase::Itz, kind, faces));
        }
        Block { nodes: self.nodes, groups }
    }

    fn cell(&self, cell: u32) -> &[u32] {
        let mesh = self.parts.sample.mesh;
        &mesh.cells[cell as usize * mesh.kind.nodes()..][..mesh.kind.nodes()]
    }

    fn face(&self, face: u32) -> &[u32] {
        let mesh = self.parts.sample.mesh;
        let nodes = 2 * mesh.kind.faces()[0].len();
        &mesh.cohesive[face as usize * nodes..][..nodes]
    }

    fn group(&self, phase: Phase, cells: Cells, numbers: &[u32]) -> Group {
        let count = eights(numbers.len());
        let remembered = cells.remembered(&self.parts.common.matter[phase as usize]);
        let mut numbers = numbers.to_vec();
        numbers.resize(count * LANES, EMPTY);
        let memory = vec![Eight::default(); count * remembered];
        Group { phase, cells, memory, numbers, dissipated: 0.0, hourglass: [0.0; 2] }
    }

    /// The block's own number of a node.
    fn local(&self, node: u32) -> u16 {
        let place = self.nodes.partition_point(|&other| other < self.number[node as usize]);
        u16::try_from(place).expect("a block has fewer than 65,536 nodes")
    }

    /// Eights of elements; empty lanes hold the last element without its weight.
    fn eights<T: Default>(&self, numbers: &[u32], set: impl Fn(&mut T, usize, u32, bool)) -> Vec<T> {
        let fill = |chunk: &[u32]| {
            let mut eight = T::default();
            for lane in 0..LANES {
                set(&mut eight, lane, chunk[lane.min(chunk.len() - 1)], lane < chunk.len());
            }
            eight
        };
        numbers.chunks(LANES).map(fill).collect()
    }

    fn tets(&self, cells: &[u32]) -> Cells {
        let sample = self.parts.sample;
        Cells::Tets(self.eights(cells, |eight: &mut Tets, lane, cell, used| {
            let nodes = self.cell(cell);
            let mut shape = Shape::of(&corners(sample.mesh, nodes));
            let width = sample.band_factor * regular_edge(sample.mesh.kind, shape.volume);
            shape.volume *= f64::from(u8::from(used));
            eight.set(lane, [0, 1, 2, 3].map(|corner| self.local(nodes[corner])), &shape, width);
        }))
    }

    fn hexes(&self, cells: &[u32]) -> Cells {
        Cells::Hexes(self.eights(cells, |eight: &mut Hexes, lane, cell, used| {
            let nodes = self.cell(cell);
            eight.set(lane, std::array::from_fn(|corner| self.local(nodes[corner])), used);
        }))
    }

    fn faces<const N: usize>(&self, faces: &[u32]) -> Vec<Faces<N>> {
        self.eights(faces, |eight: &mut Faces<N>, lane, face, used| {
            let nodes = self.face(face);
            let (normal, area) = facing(self.parts.sample.mesh, nodes);
            let at = [0, 1].map(|side| std::array::from_fn(|pair| self.local(nodes[side * N + pair])));
            eight.set(lane, at, normal.into(), if used { area } else { 0.0 });
        })
    }
}

/// The widest crack band of every phase.
fn widest(blocks: &[Block], parts: &Parts) -> [f64; 5] {
    let mut widest = [0.0_f64; 5];
    for group in blocks.iter().flat_map(|block| &block.groups) {
        let widest = &mut widest[group.phase as usize];
        match &group.cells {
            Cells::Tets(cells) => {
                let widths = cells.iter().flat_map(|cells| cells.width.0);
                *widest = widths.fold(*widest, |most, width| most.max(f64::from(width)));
            }
            Cells::Hexes(_) => *widest = parts.common.band_mm,
            Cells::Triangles(_) | Cells::Quads(_) => {}
        }
    }
    widest
}
