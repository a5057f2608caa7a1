//! Meshes as gmsh's `.msh` 4.1, binary: gmsh itself, FEniCSx, MOOSE, meshio.
//!
//! Physical volumes AGGREGATE, ITZ, MORTAR and FIBRE, and those of the packing's own phases, numbered like the phases of a `.vtu` plus 1; the physical
//! surfaces XMIN to ZMAX, numbered from 101, hold the faces on the bounding planes. No surface has the number of a
//! volume, since scikit-fem and akantu look groups up without their dimension. gmsh knows no cohesive elements: they are prisms or
//! hexahedra without volume, in the ITZ. The view `aggregate` gives every element its grain, -1 in the mortar; a face
//! on a bounding plane has that of its cell (meshio reads a view only where it names all elements in their order).
//!
//! In a periodic mesh XMAX, YMAX and ZMAX name the opposite surface as their master (`$Periodic`), with the node opposite
//! to each of theirs. Where cohesive elements separate the materials, both nodes are of one material; a node opposite to a
//! void has no partner and is left out.

use meso_collision::math::{Aabb, Vec3};
use meso_concrete::PhaseNames;
use meso_mesh::cells::{CellKind, Mesh, Phase};
use meso_mesh::cells::{SIDES, Sides, Spots, owners};
use std::borrow::Cow;
use std::io::{self, BufWriter, Write};

/// Elements of one entity: dimension, tag, gmsh's element type, nodes each, and all their nodes.
struct Block {
    dimension: i32,
    tag: i32,
    kind: i32,
    nodes: usize,
    /// Indices of the elements' nodes, one after the other.
    connectivity: Vec<u32>,
    /// Grain of every element.
    aggregates: Vec<u32>,
}

impl Block {
    fn len(&self) -> usize {
        self.connectivity.len() / self.nodes
    }
}

/// Writes `mesh` to `out`.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(mesh: &Mesh, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let sides = Sides::of(mesh);
    let blocks = blocks(mesh, &sides);
    out.write_all(b"$MeshFormat\n4.1 1 8\n")?;
    int(&mut out, 1)?;
    out.write_all(b"\n$EndMeshFormat\n")?;
    names(&blocks, &mesh.phases, &mut out)?;
    entities(mesh, &blocks, &mut out)?;
    nodes(mesh, &blocks, &mut out)?;
    elements(&blocks, &mut out)?;
    periodic(mesh, &sides, &blocks, &mut out)?;
    grains(&blocks, &mut out)?;
    out.flush()
}

fn blocks(mesh: &Mesh, sides: &Sides) -> Vec<Block> {
    let sides = (FIRST_SIDE..).zip(sides.faces()).map(|(tag, faces)| side(mesh, tag, faces));
    let phases = [Phase::Mortar, Phase::Itz, Phase::Aggregate].map(|phase| volume(mesh, phase));
    let last = [cohesive(mesh), volume(mesh, Phase::Fibre)];
    let own = mesh.phases.own().map(|phase| volume(mesh, phase));
    sides.chain(phases).chain(last).chain(own).filter(|block| !block.connectivity.is_empty()).collect()
}

fn side(mesh: &Mesh, tag: i32, faces: &[(u32, usize)]) -> Block {
    let (kind, nodes) = match mesh.kind {
        CellKind::Tetrahedron => (2, 3),
        CellKind::QuadraticTetrahedron => (9, 6),
        CellKind::Hexahedron => (3, 4),
    };
    let nodes_of = |&(cell, face): &(u32, usize)| {
        let start = cell as usize * mesh.kind.nodes();
        mesh.kind.face_nodes()[face].iter().map(move |&i| mesh.cells[start + i])
    };
    let connectivity = faces.iter().flat_map(nodes_of).collect();
    let aggregates = faces.iter().map(|&(cell, _)| mesh.id(mesh.owner[cell as usize])).collect();
    Block { dimension: 2, tag, kind, nodes, connectivity, aggregates }
}

fn volume(mesh: &Mesh, phase: Phase) -> Block {
    // gmsh swaps the middles of the last two edges of second-order tetrahedra.
    let (kind, order): (_, &[usize]) = match mesh.kind {
        CellKind::Tetrahedron => (4, &[0, 1, 2, 3]),
        CellKind::QuadraticTetrahedron => (11, &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
        CellKind::Hexahedron => (5, &[0, 1, 2, 3, 4, 5, 6, 7]),
    };
    let cells = || mesh.cells().zip(mesh.ids()).zip(&mesh.phase).filter(|(_, of)| **of == phase);
    let connectivity = cells().flat_map(|((cell, _), _)| order.iter().map(|&i| cell[i])).collect();
    let aggregates = cells().map(|((_, id), _)| id).collect();
    Block { dimension: 3, tag: i32::from(phase.number()) + 1, kind, nodes: mesh.kind.nodes(), connectivity, aggregates }
}

/// A volume of its own (an entity may hold one type only by convention), in the same physical group as solid ITZ.
fn cohesive(mesh: &Mesh) -> Block {
    let (kind, nodes) = if mesh.kind == CellKind::Hexahedron { (5, 8) } else { (6, 6) };
    let (connectivity, aggregates) =
        (mesh.cohesive.clone(), mesh.cohesive_owner.iter().map(|&owner| mesh.id(owner)).collect());
    Block { dimension: 3, tag: COHESIVE, kind, nodes, connectivity, aggregates }
}

/// Entity of the cohesive elements.
const COHESIVE: i32 = 4;

/// Entity and physical group of the first of [`SIDES`]; the others follow.
const FIRST_SIDE: i32 = 101;

impl Block {
    /// The physical group: that of a volume is its phase's, also for cohesive elements.
    fn physical(&self) -> i32 {
        if self.dimension == 3 && self.tag == COHESIVE { i32::from(Phase::Itz.number()) + 1 } else { self.tag }
    }

    fn name(&self, phases: &PhaseNames) -> Cow<'static, str> {
        match (self.dimension, self.physical()) {
            (2, tag) => SIDES[(tag - FIRST_SIDE) as usize].2.into(),
            (_, tag) => phases.set_name(Phase::numbered((tag - 1) as u8)),
        }
    }
}

fn names(blocks: &[Block], phases: &PhaseNames, out: &mut impl Write) -> io::Result<()> {
    let group = |block: &Block| (block.dimension, block.physical(), block.name(phases));
    let mut groups: Vec<_> = blocks.iter().map(group).collect();
    groups.dedup();
    writeln!(out, "$PhysicalNames\n{}", groups.len())?;
    groups.iter().try_for_each(|(dimension, tag, name)| writeln!(out, "{dimension} {tag} \"{name}\""))?;
    writeln!(out, "$EndPhysicalNames")
}

/// No points, no curves; surfaces and volumes with their box and their physical group.
fn entities(mesh: &Mesh, blocks: &[Block], out: &mut impl Write) -> io::Result<()> {
    out.write_all(b"$Entities\n")?;
    let count = |dimension| blocks.iter().filter(|block| block.dimension == dimension).count();
    [0, 0, count(2), count(3)].into_iter().try_for_each(|n| size(out, n))?;
    for block in blocks {
        let aabb = Aabb::around(block.connectivity.iter().map(|&node| &mesh.points[node as usize]));
        int(out, block.tag)?;
        aabb.min.iter().chain(aabb.max.iter()).try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
        size(out, 1)?;
        int(out, block.physical())?;
        size(out, 0)?;
    }
    out.write_all(b"\n$EndEntities\n")
}

/// All nodes in one block, numbered from 1; they belong to the first volume, as every node must to something.
fn nodes(mesh: &Mesh, blocks: &[Block], out: &mut impl Write) -> io::Result<()> {
    let count = mesh.points.len();
    out.write_all(b"$Nodes\n")?;
    [1, count, 1, count].into_iter().try_for_each(|n| size(out, n))?;
    let tag = blocks.iter().find(|block| block.dimension == 3).map_or(1, |block| block.tag);
    [3, tag, 0].into_iter().try_for_each(|n| int(out, n))?;
    size(out, count)?;
    (1..=count).try_for_each(|n| size(out, n))?;
    mesh.points.iter().flatten().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
    out.write_all(b"\n$EndNodes\n")
}

/// Numbered from 1 through all blocks.
fn elements(blocks: &[Block], out: &mut impl Write) -> io::Result<()> {
    let count = blocks.iter().map(Block::len).sum();
    out.write_all(b"$Elements\n")?;
    [blocks.len(), count, 1, count].into_iter().try_for_each(|n| size(out, n))?;
    let mut number = 0;
    for block in blocks {
        [block.dimension, block.tag, block.kind].into_iter().try_for_each(|n| int(out, n))?;
        size(out, block.len())?;
        for nodes in block.connectivity.chunks_exact(block.nodes) {
            number += 1;
            size(out, number)?;
            nodes.iter().try_for_each(|&node| size(out, node as usize + 1))?;
        }
    }
    out.write_all(b"\n$EndElements\n")
}

/// Every upper surface of a direction in which the box repeats itself, the lower one as its master, the translation between
/// them, and pairs of opposite nodes.
fn periodic(mesh: &Mesh, sides: &Sides, blocks: &[Block], out: &mut impl Write) -> io::Result<()> {
    let has_surface = |tag: i32| blocks.iter().any(|block| (block.dimension, block.tag) == (2, tag));
    let tags = |axis: usize| [1, 0].map(|upper| FIRST_SIDE + 2 * axis as i32 + upper);
    let axes = || (0..3).filter(|axis| mesh.periodic[*axis] && tags(*axis).into_iter().all(has_surface));
    if axes().next().is_none() {
        return Ok(());
    }
    let lengths = Aabb::around(&mesh.points).size();
    let owners = owners(mesh, sides);
    let spots = Spots::new(&mesh.points, (0..mesh.points.len() as u32).filter(|&node| sides.on(node) != 0));
    out.write_all(b"$Periodic\n")?;
    size(out, axes().count())?;
    for axis in axes() {
        let [slave, master] = tags(axis);
        [2, slave, master].into_iter().try_for_each(|n| int(out, n))?;
        // An affine transformation, row by row: the identity and a translation.
        size(out, 16)?;
        let affine = |i: usize| {
            if i.is_multiple_of(5) {
                1.0
            } else if i == 4 * axis + 3 {
                lengths[axis]
            } else {
                0.0
            }
        };
        (0..16).try_for_each(|i| out.write_all(&f64::to_le_bytes(affine(i))))?;
        let opposite = |node: u32| {
            let at = mesh.points[node as usize] - Vec3::ith(axis, lengths[axis]);
            spots.at(at).filter(|image| owners[*image as usize] == owners[node as usize]).min()
        };
        let pairs: Vec<[u32; 2]> =
            sides.members(2 * axis + 1).filter_map(|node| Some([node, opposite(node)?])).collect();
        size(out, pairs.len())?;
        pairs.as_flattened().iter().try_for_each(|&node| size(out, node as usize + 1))?;
    }
    out.write_all(b"\n$EndPeriodic\n")
}

/// The view `aggregate`: time 0, step 0, one component, all elements.
fn grains(blocks: &[Block], out: &mut impl Write) -> io::Result<()> {
    let aggregates = || blocks.iter().flat_map(|block| &block.aggregates);
    write!(out, "$ElementData\n1\n\"aggregate\"\n1\n0\n3\n0\n1\n{}\n", aggregates().count())?;
    for (number, &id) in (1..).zip(aggregates()) {
        int(out, number)?;
        let value = if id == Mesh::NO_BODY { -1.0 } else { f64::from(id) };
        out.write_all(&value.to_le_bytes())?;
    }
    out.write_all(b"\n$EndElementData\n")
}

fn int(out: &mut impl Write, value: i32) -> io::Result<()> {
    out.write_all(&value.to_le_bytes())
}

/// gmsh's `size_t`.
fn size(out: &mut impl Write, value: usize) -> io::Result<()> {
    out.write_all(&(value as u64).to_le_bytes())
}
