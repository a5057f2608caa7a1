//! The file formats between us and gmsh: surfaces to it (MSH 4.1, text), tetrahedra back (MSH 4.1, binary).
//!
//! Discrete surfaces and the volumes within and between them, tags counted from 1. The volumes stand in a script: volumes
//! of a file of their own count as meshed already, and stay empty.

use super::plc::Shells;
use meso_collision::math::{Aabb, Vec3};
use std::io::{self, BufWriter, Write};

/// gmsh's script: the volumes within and between the surfaces of `file`, with a node at each centre.
///
/// Where bodies are small for the elements all nodes lie on surfaces, in more than seven tetrahedra each, and there gmsh
/// (4.8 and 4.15) begins to look through all tetrahedra at every step, so that it does not end: 850 bodies at 4 mm took
/// more than 108 CPU seconds, and with nodes at their centres 7.
pub(super) fn script(file: &str, shells: &Shells, size: f64) -> String {
    let list = |indices: &[u32]| indices.iter().map(|index| (index + 1).to_string()).collect::<Vec<_>>().join(",\n");
    let mut script = format!("Merge \"{file}\";\n");
    for (tag, shell) in (1..).zip(&shells.loops) {
        script += &format!("Surface Loop({tag}) = {{{}}};\n", list(shell));
    }
    for (tag, volume) in (1..).zip(&shells.volumes) {
        script += &format!("Volume({tag}) = {{{}}};\n", list(&volume.loops));
    }
    let centres = (1..).zip(&shells.volumes).filter_map(|(tag, volume)| Some((tag, volume.centre?)));
    for (tag, centre) in centres {
        let (x, y, z) = (centre.x, centre.y, centre.z);
        script += &format!("Point({tag}) = {{{x}, {y}, {z}, {size}}};\nPoint{{{tag}}} In Volume{{{tag}}};\n");
    }
    script
}

/// Writes the surfaces.
pub(super) fn write(shells: &Shells, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 {} 0", shells.surfaces.len())?;
    for (tag, triangles) in (1..).zip(&shells.surfaces) {
        let aabb = Aabb::around(triangles.as_flattened().iter().map(|&node| &shells.points[node as usize]));
        let ([a, b, c], [d, e, f]): ([f64; 3], [f64; 3]) = (aabb.min.into(), aabb.max.into());
        writeln!(out, "{tag} {a} {b} {c} {d} {e} {f} 0 0")?;
    }
    writeln!(out, "$EndEntities")?;
    nodes(&mut out, shells)?;
    triangles(&mut out, shells)?;
    out.flush()
}

/// Every node once, with the first surface that has it.
fn nodes(out: &mut impl Write, shells: &Shells) -> io::Result<()> {
    let own = shells.own_nodes();
    let total: usize = own.iter().map(Vec::len).sum();
    writeln!(out, "$Nodes\n{} {total} 1 {total}", own.len())?;
    for (tag, nodes) in (1..).zip(own) {
        writeln!(out, "2 {tag} 0 {}", nodes.len())?;
        nodes.iter().try_for_each(|node| writeln!(out, "{}", node + 1))?;
        // The shortest decimals that read back to the same numbers.
        let mut positions = nodes.iter().map(|&node| shells.points[node as usize]);
        positions.try_for_each(|p| writeln!(out, "{} {} {}", p.x, p.y, p.z))?;
    }
    writeln!(out, "$EndNodes")
}

fn triangles(out: &mut impl Write, shells: &Shells) -> io::Result<()> {
    let total: usize = shells.surfaces.iter().map(Vec::len).sum();
    writeln!(out, "$Elements\n{} {total} 1 {total}", shells.surfaces.len())?;
    let mut element = 1;
    for (tag, triangles) in (1..).zip(&shells.surfaces) {
        writeln!(out, "2 {tag} 2 {}", triangles.len())?;
        for [a, b, c] in triangles.iter().map(|triangle| triangle.map(|node| node + 1)) {
            writeln!(out, "{element} {a} {b} {c}")?;
            element += 1;
        }
    }
    writeln!(out, "$EndElements")
}

/// gmsh's tetrahedra, with the tag of the volume each lies in.
#[derive(Default)]
pub(super) struct Tagged {
    pub(super) points: Vec<Vec3>,
    pub(super) cells: Vec<[u32; 4]>,
    pub(super) tags: Vec<u32>,
}

/// Reads the nodes and tetrahedra of a binary file.
///
/// # Errors
/// Names the entry that is missing or out of order.
pub(super) fn read(file: &[u8]) -> Result<Tagged, String> {
    let mut read = Tagged::default();
    let mut numbers = Vec::new();
    let (version, _) = section(file, "MeshFormat")?.split_at_checked(6).ok_or("the header is cut off")?;
    if version != b"4.1 1 " {
        return Err("gmsh wrote another format than binary MSH 4.1".into());
    }
    read_nodes(&mut Bytes(section(file, "Nodes")?), &mut read, &mut numbers).ok_or("the nodes are cut off")?;
    read_cells(&mut Bytes(section(file, "Elements")?), &mut read, &numbers).ok_or("the elements are cut off")?;
    Ok(read)
}

/// The text from `$name` to the end; the sections that are read know their own length.
fn section<'a>(file: &'a [u8], name: &str) -> Result<&'a [u8], String> {
    let head = format!("${name}\n");
    let start = file.windows(head.len()).position(|window| window == head.as_bytes());
    start.map(|start| &file[start + head.len()..]).ok_or_else(|| format!("gmsh's file has no ${name}"))
}

/// Blocks of an entity each: dimension, tag, parametric, count, then the tags, then the coordinates.
fn read_nodes(bytes: &mut Bytes, read: &mut Tagged, numbers: &mut Vec<u32>) -> Option<()> {
    let [blocks, count, _, highest] = bytes.u64s()?;
    numbers.resize(usize::try_from(highest).ok()? + 1, u32::MAX);
    read.points.reserve(usize::try_from(count).ok()?);
    for _ in 0..blocks {
        let [_, _, _] = bytes.i32s()?;
        let [nodes] = bytes.u64s()?;
        for number in 0..nodes {
            let [tag] = bytes.u64s()?;
            *numbers.get_mut(usize::try_from(tag).ok()?)? = read.points.len() as u32 + number as u32;
        }
        for _ in 0..nodes {
            read.points.push(Vec3::from(bytes.u64s::<3>()?.map(f64::from_bits)));
        }
    }
    Some(())
}

/// Blocks of an entity each: dimension, tag, element type, count, then each element's tag and nodes.
fn read_cells(bytes: &mut Bytes, read: &mut Tagged, numbers: &[u32]) -> Option<()> {
    let [blocks, ..] = bytes.u64s::<4>()?;
    for _ in 0..blocks {
        let [dimension, tag, kind] = bytes.i32s()?;
        let [elements] = bytes.u64s()?;
        // Points, lines, triangles, tetrahedra.
        let nodes = match kind {
            15 => 1,
            1 => 2,
            2 => 3,
            4 => 4,
            _ => return None,
        };
        for _ in 0..elements {
            bytes.u64s::<1>()?;
            let mut cell = [0; 4];
            for node in &mut cell[..nodes] {
                let [tag] = bytes.u64s()?;
                *node = *numbers.get(usize::try_from(tag).ok()?)?;
            }
            if dimension == 3 {
                read.cells.push(cell);
                read.tags.push(tag as u32);
            }
        }
    }
    Some(())
}

/// Little-endian numbers from the front.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn u64s<const N: usize>(&mut self) -> Option<[u64; N]> {
        let (head, tail) = self.0.split_at_checked(8 * N)?;
        self.0 = tail;
        Some(std::array::from_fn(|i| u64::from_le_bytes(head[8 * i..][..8].try_into().expect("eight bytes"))))
    }

    fn i32s<const N: usize>(&mut self) -> Option<[i32; N]> {
        let (head, tail) = self.0.split_at_checked(4 * N)?;
        self.0 = tail;
        Some(std::array::from_fn(|i| i32::from_le_bytes(head[4 * i..][..4].try_into().expect("four bytes"))))
    }
}
