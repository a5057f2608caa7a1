//! ANSYS archives (`.cdb`): blocks of nodes and elements, components, and elastic materials.
//!
//! Element type, material and component have one number: 1 AGGREGATE, 2 ITZ, 3 MORTAR, 4 FIBRE, from 101 on the packing's own
//! phases, which have no values. Cells are SOLID285 (4 nodes),
//! SOLID187 (10) or SOLID185 (8), cohesive elements INTER205. Nodes of the sides are the components XMIN to ZMAX. Numbers
//! are the mesh's indices plus 1. Columns of integers are as wide as the largest number needs, and coordinates have 14 digits.

use super::columns::{part, places, present};
use super::lines::Lines;
use meso_mesh::cells::{CellKind, Mesh, Phase, SIDES, Sides};
use meso_mesh::materials::{Elastic, Materials};
use std::io::{self, Write};

/// Columns of a number in a component.
const WIDTH: usize = 10;
/// The least columns of a number in a block.
const LEAST_WIDTH: usize = 7;

/// Writes `mesh` to `out`.
///
/// # Errors
/// Fails with the errors of `out`; more nodes or elements than nine columns can number.
pub(crate) fn write(mesh: &Mesh, out: impl Write) -> io::Result<()> {
    let elements = mesh.cell_count() + mesh.cohesive().len();
    if mesh.points.len().max(elements) > 99_999_999 {
        return Err(io::Error::other("a .cdb numbers at most 99,999,999 nodes and elements; take larger elements"));
    }
    let mut lines = Lines::new(out);
    lines.line(format!("/COM,mesocrete {}; units mm, N, MPa, tonne, s", env!("CARGO_PKG_VERSION")))?;
    lines.line("/PREP7")?;
    lines.line("SHPP,OFF")?;
    types(&mut lines, mesh)?;
    nodes(&mut lines, mesh)?;
    cells(&mut lines, mesh, width(mesh.points.len().max(elements)))?;
    materials(&mut lines, mesh)?;
    let sides = Sides::of(mesh);
    for (bit, (_, _, name)) in SIDES.iter().enumerate() {
        component(&mut lines, name, "NODE", sides.members(bit).map(|node| u64::from(node) + 1))?;
    }
    for phase in present(mesh) {
        component(&mut lines, &mesh.phases.set_name(phase), "ELEM", of_phase(mesh, phase))?;
    }
    lines.line("FINISH")?;
    lines.finish()
}

/// Numbers of a phase's elements; cohesive ones are of the ITZ.
fn of_phase(mesh: &Mesh, phase: Phase) -> impl Iterator<Item = u64> {
    let cells = (1..).zip(&mesh.phase).filter(move |(_, own)| **own == phase).map(|(number, _)| number);
    let first = mesh.cell_count() as u64 + 1;
    let joints = if phase == Phase::Itz { mesh.cohesive().len() as u64 } else { 0 };
    cells.chain(first..first + joints)
}

fn types(lines: &mut Lines<impl Write>, mesh: &Mesh) -> io::Result<()> {
    let solid = match mesh.kind {
        CellKind::Tetrahedron => 285,
        CellKind::QuadraticTetrahedron => 187,
        CellKind::Hexahedron => 185,
    };
    present(mesh).try_for_each(|phase| {
        let is_joint = phase == Phase::Itz && !mesh.cohesive.is_empty();
        lines.line(format!("ET,{},{}", part(phase), if is_joint { 205 } else { solid }))
    })
}

/// Columns of numbers up to `most`, with one space before them.
fn width(most: usize) -> usize {
    (most.to_string().len() + 1).max(LEAST_WIDTH)
}

fn nodes(lines: &mut Lines<impl Write>, mesh: &Mesh) -> io::Result<()> {
    let count = mesh.points.len();
    let width = width(count);
    lines.line(format!("NBLOCK,6,SOLID,{count:>10},{count:>10}"))?;
    lines.line(format!("(3i{width},6e21.13e3)"))?;
    for (number, point) in (1..).zip(&mesh.points) {
        [number, 0, 0].into_iter().for_each(|x| lines.integer(width, x));
        point.iter().for_each(|x| lines.text(21, &exponent(*x)));
        lines.end()?;
    }
    lines.line("N,R5.3,LOC,       -1,")
}

/// A number with 14 digits and three digits of exponent, as Fortran writes it: to 5e-12 mm below 1000 mm.
fn exponent(x: f64) -> String {
    let text = format!("{x:.13E}");
    let (mantissa, power) = text.split_once('E').unwrap_or((&text, "0"));
    let (sign, digits) = power.strip_prefix('-').map_or(('+', power), |digits| ('-', digits));
    format!("{mantissa}E{sign}{digits:0>3}")
}

/// Material, type, constants, section, system, death, solid, shape, count of nodes, a zero, number, nodes.
fn cells(lines: &mut Lines<impl Write>, mesh: &Mesh, width: usize) -> io::Result<()> {
    let count = mesh.cell_count() + mesh.cohesive().len();
    lines.line(format!("EBLOCK,19,SOLID,{count:>10},{count:>10}"))?;
    lines.line(format!("(19i{width})"))?;
    for ((element, cell), phase) in (1..).zip(mesh.cells()).zip(&mesh.phase) {
        one(lines, width, element, part(*phase), cell)?;
    }
    let first = mesh.cell_count() as u64 + 1;
    let mut joint = |(element, nodes): (u64, &[u32])| one(lines, width, element, part(Phase::Itz), nodes);
    (first..).zip(mesh.cohesive()).try_for_each(&mut joint)?;
    lines.line(format!("{:>width$}", -1))
}

/// Nodes beyond the eighth stand on a second line; a wedge of 6 nodes repeats the third node of either face.
fn one(lines: &mut Lines<impl Write>, width: usize, element: u64, group: u64, nodes: &[u32]) -> io::Result<()> {
    let order = places(nodes.len());
    for field in [group, group, 1, 1, 0, 0, 0, 0, order.len() as u64, 0, element] {
        lines.integer(width, field);
    }
    for (at, &i) in order.iter().enumerate() {
        if at == 8 {
            lines.end()?;
        }
        lines.integer(width, u64::from(nodes[i]) + 1);
    }
    lines.end()
}

/// Elastic values; illustrative, as in decks.
fn materials(lines: &mut Lines<impl Write>, mesh: &Mesh) -> io::Result<()> {
    let values = Materials::default().in_mesh(mesh);
    for phase in present(mesh) {
        let number = part(phase);
        if let Phase::Own(_) = phase {
            lines
                .line(format!("/COM,no values for material {number} of {}: give them", mesh.phases.set_name(phase)))?;
            continue;
        }
        let Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 } = values.elastic(phase, &mesh.phases);
        lines.line(format!("MP,EX,{number},{youngs_modulus_mpa:?}"))?;
        lines.line(format!("MP,PRXY,{number},{poisson_ratio:?}"))?;
        lines.line(format!("MP,DENS,{number},{density_t_per_mm3:?}"))?;
    }
    Ok(())
}

/// A component; a range is its last number, negative, behind its first.
fn component(
    lines: &mut Lines<impl Write>,
    name: &str,
    what: &str,
    numbers: impl Iterator<Item = u64>,
) -> io::Result<()> {
    let numbers = ranges(numbers);
    if numbers.is_empty() {
        return Ok(());
    }
    lines.line(format!("CMBLOCK,{name:<8},{what},{:>8}", numbers.len()))?;
    lines.line("(8i10)")?;
    for line in numbers.chunks(8) {
        line.iter().for_each(|number| lines.text(WIDTH, &number.to_string()));
        lines.end()?;
    }
    Ok(())
}

fn ranges(numbers: impl Iterator<Item = u64>) -> Vec<i64> {
    let mut all: Vec<i64> = Vec::new();
    for number in numbers.map(|number| number as i64) {
        match all.last().copied() {
            Some(last) if last < 0 && -last + 1 == number => *all.last_mut().expect("a number") = -number,
            Some(last) if last > 0 && last + 1 == number => all.push(-number),
            _ => all.push(number),
        }
    }
    all
}
