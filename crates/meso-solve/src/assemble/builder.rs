//! A block, built from the mesh's cells, cohesive faces and patches that it has.

use crate::assemble::centroid;
use crate::assemble::parts::BlockParts;
use crate::assemble::patches::{MOST_NODES, Patch, Patches, band};
use crate::assemble::tet::{Shape, corners};
use crate::assemble::weight::facing;
use meso_collision::math::Vec3;
use meso_element::block::{Batch, Block, EMPTY, Group, eights};
use meso_element::face::Faces;
use meso_element::hex::Hexes;
use meso_element::lanes::{LANES, Octet};
use meso_element::uniform::{Tets, Uniform};
use meso_mesh::materials::regular_edge;
use meso_mesh::{CellKind, Mesh, Phase};

/// Phase and material of an element, and the number of its strain without stress.
type Matter = (Phase, u16, u8);

/// Order of the materials within a block: phase by phase.
fn order((phase, matter, free): Matter) -> (u8, u16, u8) {
    (phase.number(), matter, free)
}

/// Builds one block.
pub(crate) struct Builder<'a> {
    parts: &'a BlockParts<'a>,
    /// The engine's number of every node of the mesh.
    number: &'a [u32],
    patches: Option<OwnPatches<'a>>,
    nodes: Vec<u32>,
}

/// The patches of a block.
pub(crate) struct OwnPatches<'a> {
    /// All patches of the mesh.
    all: &'a Patches,
    /// Numbers of the block's patches among all.
    numbers: &'a [u32],
    shapes: Vec<Patch>,
}

impl<'a> OwnPatches<'a> {
    /// Takes the patches with some `numbers` among `all`.
    pub(crate) fn new(mesh: &Mesh, all: &'a Patches, numbers: &'a [u32]) -> Self {
        let shapes = numbers.iter().map(|&number| all.patch(mesh, number)).collect();
        Self { all, numbers, shapes }
    }

    /// Places of those with some phase, material and strain, and from `least` to `most` nodes.
    fn of(&self, parts: &BlockParts, own: Matter, least: usize, most: usize) -> Vec<u32> {
        let fits = |place: &u32| {
            let shape = &self.shapes[*place as usize];
            let is_sized = (least..=most).contains(&shape.nodes().len());
            is_sized && self.matter(parts, *place) == own
        };
        (0..self.numbers.len() as u32).filter(fits).collect()
    }
}

impl OwnPatches<'_> {
    /// Phase, material and strain of the patch at some place: the stone is that of its first cell.
    fn matter(&self, parts: &BlockParts, place: u32) -> Matter {
        let number = self.numbers[place as usize];
        let (phase, cells) = (self.all.phase[number as usize], self.all.cells(number));
        let matter = parts.common.place(phase, parts.sample.mesh.owner[cells[0] as usize]);
        (phase, matter, parts.free(phase, cells))
    }
}

impl<'a> Builder<'a> {
    /// For a block with some patches, where strains are smoothed.
    pub(crate) fn new(parts: &'a BlockParts<'a>, number: &'a [u32], patches: Option<OwnPatches<'a>>) -> Self {
        Self { parts, number, patches, nodes: Vec::new() }
    }

    /// The block of some cells and cohesive faces.
    pub(crate) fn build(mut self, cells: &[u32], faces: &[u32]) -> Block {
        let mesh = self.parts.sample.mesh;
        let mut cells = if self.patches.is_some() { Vec::new() } else { cells.to_vec() };
        cells.sort_by_key(|&cell| order(self.matter(cell)));
        self.nodes = self.nodes_of(&cells, faces);
        let mut groups = Vec::new();
        for own in cells.chunk_by(|&a, &b| self.matter(a) == self.matter(b)) {
            let kind = if mesh.kind == CellKind::Hexahedron { self.hexes(own) } else { self.tets(own) };
            groups.push(self.group(self.matter(own[0]), kind, own));
        }
        if let Some(own) = &self.patches {
            self.add_patches(own, &mut groups);
        }
        if !faces.is_empty() {
            let is_quad = mesh.kind == CellKind::Hexahedron;
            let kind = if is_quad { Batch::Quads(self.faces(faces)) } else { Batch::Triangles(self.faces(faces)) };
            groups.push(self.group((Phase::Itz, Phase::Itz.number().into(), Phase::Itz.number()), kind, faces));
        }
        Block { nodes: self.nodes, groups }
    }

    /// Numbers of the nodes of cells, faces and the block's patches, ascending.
    fn nodes_of(&self, cells: &[u32], faces: &[u32]) -> Vec<u32> {
        let of_patches = self.patches.iter().flat_map(|own| own.shapes.iter().flat_map(Patch::nodes));
        let of_cells = cells.iter().flat_map(|&cell| self.cell(cell));
        let of_faces = faces.iter().flat_map(|&face| self.face(face));
        let mut nodes: Vec<u32> =
            of_patches.chain(of_cells).chain(of_faces).map(|&node| self.number[node as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    fn cell(&self, cell: u32) -> &[u32] {
        self.parts.sample.mesh.cell(cell as usize)
    }

    fn face(&self, face: u32) -> &[u32] {
        let mesh = self.parts.sample.mesh;
        let nodes = 2 * mesh.kind.faces()[0].len();
        &mesh.cohesive[face as usize * nodes..][..nodes]
    }

    /// Phase, material and strain of a cell.
    fn matter(&self, cell: u32) -> Matter {
        let mesh = self.parts.sample.mesh;
        let phase = mesh.phase[cell as usize];
        (phase, self.parts.common.place(phase, mesh.owner[cell as usize]), self.parts.free(phase, &[cell]))
    }

    fn group(&self, (phase, matter, free): Matter, cells: Batch, numbers: &[u32]) -> Group {
        let count = eights(numbers.len());
        let remembered = cells.remembered(&self.parts.common.matter[usize::from(matter)]);
        let mut memory = vec![Octet::default(); count * remembered];
        self.scatter(&cells, matter, numbers, &mut memory);
        let mut numbers = numbers.to_vec();
        numbers.resize(count * LANES, EMPTY);
        Group { phase, matter, free, cells, memory, numbers, dissipated: 0.0, hourglass: [0.0; 2] }
    }

    /// Writes the factors of the strengths of some cells or patches into their memory.
    fn scatter(&self, kind: &Batch, matter: u16, numbers: &[u32], memory: &mut [Octet]) {
        let matter = &self.parts.common.matter[usize::from(matter)];
        let (Some(place), Some(field)) = (matter.factor(), self.parts.strengths) else { return };
        let remembered = matter.remembered();
        for (i, number) in numbers.iter().enumerate() {
            let own = self.patches.as_ref().filter(|_| kind.are_patches());
            let at = own.map_or_else(|| self.centre(&[*number]), |own| self.centre(own.all.cells(*number)));
            memory[i / LANES * remembered + place].0[i % LANES] = (field.factor(&at) - 1.0) as f32;
        }
    }

    /// Centre of the volume of some cells; those of a patch are tetrahedra.
    fn centre(&self, cells: &[u32]) -> Vec3 {
        let mesh = self.parts.sample.mesh;
        let volume = |cell: u32| if cells.len() == 1 { 1.0 } else { Shape::of(&corners(mesh, cell)).volume };
        let (mut sum, mut all) = (Vec3::zeros(), 0.0);
        for &cell in cells {
            sum += volume(cell) * centroid(mesh, self.cell(cell));
            all += volume(cell);
        }
        sum / all
    }

    /// The block's own number of a node.
    fn local(&self, node: u32) -> u16 {
        let place = self.nodes.partition_point(|&other| other < self.number[node as usize]);
        u16::try_from(place).expect("a block has at most 32,768 nodes")
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

    fn tets(&self, cells: &[u32]) -> Batch {
        let sample = self.parts.sample;
        Batch::Tets(self.eights(cells, |eight: &mut Tets, lane, cell, used| {
            let nodes = self.cell(cell);
            let shape = Shape::of(&corners(sample.mesh, cell));
            let width = sample.band_factor * regular_edge(sample.mesh.kind, shape.volume);
            let volume = if used { shape.volume } else { 0.0 };
            eight.set(lane, &[0, 1, 2, 3].map(|corner| self.local(nodes[corner])), &shape.gradients, volume, width);
        }))
    }

    /// Adds the groups of the block's patches, by phase and number of nodes.
    fn add_patches(&self, own: &OwnPatches, groups: &mut Vec<Group>) {
        let places = 0..own.numbers.len() as u32;
        let mut matters: Vec<Matter> = places.map(|place| own.matter(self.parts, place)).collect();
        matters.sort_by_key(|&matter| order(matter));
        matters.dedup();
        for matter in matters {
            let mut add = |places: &[u32], cells: Batch| {
                let numbers: Vec<u32> = places.iter().map(|&place| own.numbers[place as usize]).collect();
                groups.extend((!numbers.is_empty()).then(|| self.group(matter, cells, &numbers)));
            };
            let [small, middle, large] =
                [(4, 8), (9, 9), (10, MOST_NODES)].map(|(a, b)| own.of(self.parts, matter, a, b));
            add(&small, Batch::Patches8(self.uniform(own, &small)));
            add(&middle, Batch::Patches9(self.uniform(own, &middle)));
            add(&large, Batch::Patches12(self.uniform(own, &large)));
        }
    }

    /// Eights of the block's patches at some places.
    fn uniform<const N: usize>(&self, own: &OwnPatches, places: &[u32]) -> Vec<Uniform<N>> {
        let sample = self.parts.sample;
        self.eights(places, |eight: &mut Uniform<N>, lane, place, used| {
            let shape = &own.shapes[place as usize];
            let width = band(sample.mesh) * sample.band_factor * regular_edge(sample.mesh.kind, shape.cell_mm3);
            let nodes: Vec<u16> = shape.nodes().iter().map(|&node| self.local(node)).collect();
            eight.set(lane, &nodes, &shape.gradients()[1..], if used { shape.volume } else { 0.0 }, width);
        })
    }

    fn hexes(&self, cells: &[u32]) -> Batch {
        Batch::Hexes(self.eights(cells, |eight: &mut Hexes, lane, cell, used| {
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
