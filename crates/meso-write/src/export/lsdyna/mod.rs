//! LS-DYNA keyword decks (`.k`), which OpenRadioss reads, too: fixed columns, streamed.
//!
//! Part numbers are 1 AGGREGATE, 2 ITZ, 3 MORTAR, 4 FIBRE, 11 on for the plates, and 101 on for the packing's own phases; node and segment sets 1 to 6 are
//! XMIN to ZMAX, those from 11 on the supports' and loads', part set 1 is the specimen. Node and element numbers are the mesh's indices plus 1; cohesive elements
//! follow the cells. Units are tonne, mm, s, N, MPa. Columns are those of
//! PyDyna's definitions of the cards; element formulations and the order of a wedge's nodes were not checked in a manual.

mod loading;
mod materials;

pub use super::abaqus::LsdynaLaw;
use super::abaqus::{Analysis, DeckOptions};
use super::columns::{part, places, present};
use super::lines::Lines;
use loading::Block;
pub(super) use loading::force_of;
use meso_concrete::OutOfRange;
use meso_mesh::cells::{CellKind, Mesh, Phase, SIDES, Sides};
use std::io::{self, Write};

/// Most nodes and elements that eight columns can number.
const MOST: usize = 99_999_999;
/// Columns of a card's field.
const FIELD: usize = 10;

/// Part of the first plate; those of phases are below.
const PLATE: u64 = 11;
/// Numbers of the node sets ZMIN and ZMAX.
const LOWER: u64 = 5;
const UPPER: u64 = 6;

/// Parts of rigid blocks.
fn block_parts(blocks: &[Block]) -> impl Iterator<Item = u64> {
    (PLATE..).take(blocks.len())
}

/// Finds out whether a `.k` can have these options.
///
/// # Errors
/// Names the option, its value and the accepted range.
pub(crate) fn check(options: &DeckOptions) -> Result<(), OutOfRange> {
    let no = |key, value, accepted| Err(super::abaqus::DECK.error(key, value, accepted));
    if options.periodic_equations {
        return no("periodic_equations", "true", "a .k has no equations between faces; take an .inp, or leave it out");
    }
    match &options.analysis {
        _ if options.geometry_only => {}
        Analysis::Elastic => {
            return no("analysis", "elastic", "a .k takes none, striker or a test; take an .inp for elastic");
        }
        Analysis::Test(test) => loading::check(test, &options.analysis.word())?,
        Analysis::None | Analysis::Striker => {}
    }
    if options.has_curves() { materials::check(options) } else { Ok(()) }
}

/// Writes `mesh` as a deck to `out`, streamed.
///
/// # Errors
/// Fails with the errors of `out`, and those of [`check`] as invalid input.
pub(crate) fn write(mesh: &Mesh, options: &DeckOptions, out: impl Write) -> io::Result<()> {
    let invalid = |error: OutOfRange| io::Error::new(io::ErrorKind::InvalidInput, error);
    options.validate(mesh).and_then(|()| check(options)).map_err(invalid)?;
    if options.analysis == Analysis::Striker && !options.geometry_only {
        loading::check_faces(mesh).map_err(invalid)?;
    }
    if mesh.points.len().max(mesh.cell_count() + mesh.cohesive().len()) > MOST - 100 {
        return Err(io::Error::other("a .k numbers at most 99,999,999 nodes and elements; take larger elements"));
    }
    let mut cards = Lines::new(out);
    heading(&mut cards, mesh, options)?;
    let sides = Sides::of(mesh);
    let blocks = loading::blocks(mesh, options);
    nodes(&mut cards, mesh, &blocks)?;
    elements(&mut cards, mesh, &blocks)?;
    sets(&mut cards, mesh, &sides)?;
    if !options.geometry_only {
        materials::write(&mut cards, mesh, options, &blocks)?;
        loading::write(&mut cards, mesh, options, &blocks)?;
    }
    cards.line("*END")?;
    cards.finish()
}

fn heading(cards: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions) -> io::Result<()> {
    cards.line("*KEYWORD")?;
    let (version, nodes, cells) = (env!("CARGO_PKG_VERSION"), mesh.points.len(), mesh.cell_count());
    cards.line("$ units: tonne, mm, s, N, MPa; material values are illustrative unless they were given")?;
    options.heading.iter().try_for_each(|line| cards.line(format!("$ {line:.76}")))?;
    cards.line("*TITLE")?;
    cards.line(format!("mesocrete {version}: {nodes} nodes, {cells} elements"))
}

/// One block of all nodes, the plates' too: readers such as lsdyna-mesh-reader keep the first one alone.
fn nodes(cards: &mut Lines<impl Write>, mesh: &Mesh, blocks: &[Block]) -> io::Result<()> {
    cards.line("*NODE")?;
    (1..).zip(&mesh.points).try_for_each(|(number, p)| node(cards, number, [p.x, p.y, p.z]))?;
    loading::corners(cards, mesh, blocks)
}

/// A node: its number in 8 columns, coordinates in 16 each.
fn node(cards: &mut Lines<impl Write>, number: u64, position: [f64; 3]) -> io::Result<()> {
    cards.integer(8, number);
    position.into_iter().for_each(|x| cards.coordinate(x));
    cards.end()
}

/// All elements by their numbers, each with the part of its phase.
fn elements(cards: &mut Lines<impl Write>, mesh: &Mesh, blocks: &[Block]) -> io::Result<()> {
    cards.line("*ELEMENT_SOLID")?;
    for ((number, cell), phase) in (1..).zip(mesh.cells()).zip(&mesh.phase) {
        element(cards, number, part(*phase), cell)?;
    }
    if !mesh.cohesive.is_empty() {
        cards.line("*ELEMENT_SOLID")?;
        let first = mesh.cell_count() as u64 + 1;
        let mut joints = (first..).zip(mesh.cohesive());
        joints.try_for_each(|(number, nodes)| element(cards, number, part(Phase::Itz), nodes))?;
    }
    if !blocks.is_empty() {
        cards.line("*ELEMENT_SOLID")?;
    }
    loading::hexahedra(cards, mesh, blocks)
}

/// A solid of 4, 6 or 8 nodes on one card of 8 columns a field; of 10 nodes on two.
///
/// A tetrahedron repeats its last node. A cohesive wedge repeats the third node of either face.
fn element(cards: &mut Lines<impl Write>, number: u64, part: u64, nodes: &[u32]) -> io::Result<()> {
    let order = if nodes.len() == 4 { &[0, 1, 2, 3, 3, 3, 3, 3] } else { places(nodes.len()) };
    cards.integer(8, number);
    cards.integer(8, part);
    if order.len() > 8 {
        cards.end()?;
    }
    order.iter().for_each(|&i| cards.integer(8, u64::from(nodes[i]) + 1));
    cards.end()
}

/// Node and segment sets of the sides, and the parts of the specimen.
fn sets(cards: &mut Lines<impl Write>, mesh: &Mesh, sides: &Sides) -> io::Result<()> {
    for (bit, (_, _, name)) in SIDES.iter().enumerate() {
        set(cards, "*SET_NODE_LIST_TITLE", name, bit as u64 + 1)?;
        list(cards, sides.members(bit).map(|node| u64::from(node) + 1))?;
        if sides.faces()[bit].is_empty() {
            continue;
        }
        set(cards, "*SET_SEGMENT_TITLE", name, bit as u64 + 1)?;
        sides.faces()[bit].iter().try_for_each(|&(cell, face)| segment(cards, mesh, cell, face))?;
    }
    set(cards, "*SET_PART_LIST_TITLE", "SPECIMEN", 1)?;
    list(cards, present(mesh).map(part))
}

/// The corners of a face; a triangle repeats its last one.
fn segment(cards: &mut Lines<impl Write>, mesh: &Mesh, cell: u32, face: usize) -> io::Result<()> {
    let corners: Vec<u32> = mesh.by_owner().face(cell, face).collect();
    let last = corners[corners.len() - 1];
    corners.iter().chain((corners.len() < 4).then_some(&last)).for_each(|&i| cards.integer(FIELD, u64::from(i) + 1));
    cards.end()
}

fn set(cards: &mut Lines<impl Write>, keyword: &str, name: &str, number: u64) -> io::Result<()> {
    cards.line(keyword)?;
    cards.line(name)?;
    cards.integer(FIELD, number);
    cards.end()
}

/// Numbers, eight to a line.
fn list(cards: &mut Lines<impl Write>, numbers: impl Iterator<Item = u64>) -> io::Result<()> {
    let mut on_line = 0;
    for number in numbers {
        if on_line == 8 {
            cards.end()?;
            on_line = 0;
        }
        cards.integer(FIELD, number);
        on_line += 1;
    }
    if on_line > 0 { cards.end() } else { Ok(()) }
}

/// A card of fields of ten columns; integers are written without a point.
fn card(cards: &mut Lines<impl Write>, fields: &[Field]) -> io::Result<()> {
    for field in fields {
        match *field {
            Field::Blank => cards.text(FIELD, ""),
            Field::Integer(value) => cards.text(FIELD, &value.to_string()),
            Field::Real(value) => cards.real(FIELD, value),
        }
    }
    cards.end()
}

/// A field of a card.
#[derive(Clone, Copy)]
enum Field {
    Blank,
    Integer(i64),
    Real(f64),
}

impl From<u64> for Field {
    fn from(value: u64) -> Self {
        Self::Integer(value as i64)
    }
}

impl From<f64> for Field {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

/// Formulation of the cells: constant stress in tetrahedra, selective reduced integration in hexahedra.
fn formulation(kind: CellKind, reduced: bool) -> i64 {
    match kind {
        CellKind::Tetrahedron => 10,
        CellKind::QuadraticTetrahedron => 16,
        CellKind::Hexahedron if reduced => 1,
        CellKind::Hexahedron => 2,
    }
}
