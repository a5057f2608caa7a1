//! The file formats between us and gmsh: surfaces to it (MSH 4.1, text), tetrahedra back (MSH 4.1, binary).
//!
//! Each grain is one discrete surface and the volume in it, tags counted from 1; the specimen's surface and the mortar
//! come last. The volumes stand in a script: volumes of a file of their own count as meshed already, and stay empty.

use super::facets::Triangles;
use crate::math::{Aabb, Vec3};
use std::io::{self, BufWriter, Write};

/// gmsh's script: the volumes within and between the surfaces of `file`, one for each of `centres` and the specimen's, with
/// a node at each centre. Where there is no centre is a void, which stays empty.
///
/// Where grains are small for the elements all nodes lie on surfaces, in more than seven tetrahedra each, and there gmsh
/// (4.8 and 4.15) begins to look through all tetrahedra at every step, so that it does not end: 850 grains at 4 mm took
/// more than 108 CPU seconds, and with nodes at their centres 7.
pub(super) fn script(file: &str, centres: &[Option<Vec3>], size: f64) -> String {
    let mut script = format!("Merge \"{file}\";\n");
    let specimen = centres.len() + 1;
    for tag in 1..=specimen {
        script += &format!("Surface Loop({tag}) = {{{tag}}};\n");
    }
    let meshed = || (1..).zip(centres).filter_map(|(tag, centre)| Some((tag, centre.as_ref()?)));
    for (tag, _) in meshed() {
        script += &format!("Volume({tag}) = {{{tag}}};\n");
    }
    // The specimen's surface first, then those that bound holes.
    let holes: String = (1..specimen).map(|tag| format!(",\n{tag}")).collect();
    script += &format!("Volume({specimen}) = {{{specimen}{holes}}};\n");
    for (tag, centre) in meshed() {
        let (x, y, z) = (centre.x, centre.y, centre.z);
        script += &format!("Point({tag}) = {{{x}, {y}, {z}, {size}}};\nPoint{{{tag}}} In Volume{{{tag}}};\n");
    }
    script
}

/// Writes the grains' surfaces, then the specimen's.
pub(super) fn write(surfaces: &[Triangles], out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 {} 0", surfaces.len())?;
    for (tag, surface) in (1..).zip(surfaces) {
        let aabb = Aabb::around(&surface.points);
        let ([a, b, c], [d, e, f]): ([f64; 3], [f64; 3]) = (aabb.min.into(), aabb.max.into());
        writeln!(out, "{tag} {a} {b} {c} {d} {e} {f} 0 0")?;
    }
    writeln!(out, "$EndEntities")?;
    nodes(&mut out, surfaces)?;
    triangles(&mut out, surfaces)?;
    out.flush()
}

fn nodes(out: &mut impl Write, surfaces: &[Triangles]) -> io::Result<()> {
    let total: usize = surfaces.iter().map(|surface| surface.points.len()).sum();
    writeln!(out, "$Nodes\n{} {total} 1 {total}", surfaces.len())?;
    let mut first = 1;
    for (tag, surface) in (1..).zip(surfaces) {
        writeln!(out, "2 {tag} 0 {}", surface.points.len())?;
        (first..first + surface.points.len()).try_for_each(|node| writeln!(out, "{node}"))?;
        // The shortest decimals that read back to the same numbers.
        surface.points.iter().try_for_each(|p| writeln!(out, "{} {} {}", p.x, p.y, p.z))?;
        first += surface.points.len();
    }
    writeln!(out, "$EndNodes")
}

fn triangles(out: &mut impl Write, surfaces: &[Triangles]) -> io::Result<()> {
    let total: usize = surfaces.iter().map(|surface| surface.triangles.len()).sum();
    writeln!(out, "$Elements\n{} {total} 1 {total}", surfaces.len())?;
    let (mut element, mut first) = (1, 1);
    for (tag, surface) in (1..).zip(surfaces) {
        writeln!(out, "2 {tag} 2 {}", surface.triangles.len())?;
        for [a, b, c] in surface.triangles.iter().map(|t| t.map(|node| node as usize + first)) {
            writeln!(out, "{element} {a} {b} {c}")?;
            element += 1;
        }
        first += surface.points.len();
    }
    writeln!(out, "$EndElements")
}

/// Tetrahedra with the tag of the volume each lies in.
#[derive(Default)]
pub(super) struct Volumes {
    pub(super) points: Vec<Vec3>,
    pub(super) cells: Vec<[u32; 4]>,
    pub(super) volume: Vec<u32>,
}

/// Reads the nodes and tetrahedra of a binary file.
///
/// # Errors
/// Says what is missing or out of order.
pub(super) fn read(file: &[u8]) -> Result<Volumes, String> {
    let mut volumes = Volumes::default();
    let mut numbers = Vec::new();
    let (version, _) = section(file, "MeshFormat")?.split_at_checked(6).ok_or("the header is cut off")?;
    if version != b"4.1 1 " {
        return Err("gmsh wrote another format than binary MSH 4.1".into());
    }
    read_nodes(&mut Bytes(section(file, "Nodes")?), &mut volumes, &mut numbers).ok_or("the nodes are cut off")?;
    read_cells(&mut Bytes(section(file, "Elements")?), &mut volumes, &numbers).ok_or("the elements are cut off")?;
    Ok(volumes)
}

/// What stands between `$name` and the end; the sections that are read know their own length.
fn section<'a>(file: &'a [u8], name: &str) -> Result<&'a [u8], String> {
    let head = format!("${name}\n");
    let start = file.windows(head.len()).position(|window| window == head.as_bytes());
    start.map(|start| &file[start + head.len()..]).ok_or_else(|| format!("gmsh's file has no ${name}"))
}

/// Blocks of an entity each: dimension, tag, parametric, count, then the tags, then the coordinates.
fn read_nodes(bytes: &mut Bytes, volumes: &mut Volumes, numbers: &mut Vec<u32>) -> Option<()> {
    let [blocks, count, _, highest] = bytes.u64s()?;
    numbers.resize(usize::try_from(highest).ok()? + 1, u32::MAX);
    volumes.points.reserve(usize::try_from(count).ok()?);
    for _ in 0..blocks {
        let [_, _, _] = bytes.i32s()?;
        let [nodes] = bytes.u64s()?;
        for number in 0..nodes {
            let [tag] = bytes.u64s()?;
            *numbers.get_mut(usize::try_from(tag).ok()?)? = volumes.points.len() as u32 + number as u32;
        }
        for _ in 0..nodes {
            volumes.points.push(Vec3::from(bytes.u64s::<3>()?.map(f64::from_bits)));
        }
    }
    Some(())
}

/// Blocks of an entity each: dimension, tag, element type, count, then each element's tag and nodes.
fn read_cells(bytes: &mut Bytes, volumes: &mut Volumes, numbers: &[u32]) -> Option<()> {
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
                volumes.cells.push(cell);
                volumes.volume.push(tag as u32);
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
