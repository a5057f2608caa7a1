//! Width of the crack band in an element: cracking and crushing spend their energies over it, in decks and in our engine.
//!
//! A weak layer in a mesh is made as wide as it must be to spend its fracture energy (docs/engine.md): 1.19 edges of a box,
//! 1.4 edges of the regular tetrahedron of the cell's volume. The edge itself would make three soft boxes 1.7 times, and
//! a band of tetrahedra in which the crack chooses its way 1.37 to 1.42 times, as tough as asked for.

use super::cells::CellKind;

/// More than 1, since what holds a soft layer's sides makes it stronger and tougher: 1.187 times as tough with the edge
/// itself, at 1.5, 2 and 3 mm.
const BOX: f64 = 1.19;
/// With the edge itself a band three elements wide spends 1.37 to 1.42 of its energy, and a single layer 0.98 to 1.01.
const TETRAHEDRON: f64 = 1.4;

/// Width of a crack band over [`regular_edge`] of a cell of this kind; second-order tetrahedra count as two in a row,
/// as Abaqus counts them.
pub fn band_factor(kind: CellKind) -> f64 {
    match kind {
        CellKind::Hexahedron => BOX,
        CellKind::Tetrahedron => TETRAHEDRON,
        CellKind::QuadraticTetrahedron => TETRAHEDRON / 2.0,
    }
}

/// Edge of the cube, or of the regular tetrahedron, that has this volume, mm.
pub fn regular_edge(kind: CellKind, volume_mm3: f64) -> f64 {
    match kind {
        CellKind::Hexahedron => libm::cbrt(volume_mm3),
        _ => libm::cbrt(6.0 * std::f64::consts::SQRT_2 * volume_mm3),
    }
}

/// Width of the crack band in a cell of this volume, mm.
pub(crate) fn width_mm(kind: CellKind, volume_mm3: f64) -> f64 {
    band_factor(kind) * regular_edge(kind, volume_mm3)
}

/// The length over which Abaqus spreads a crack in a cell of this volume, mm: the cube root, of second-order elements half.
pub(crate) fn characteristic_mm(kind: CellKind, volume_mm3: f64) -> f64 {
    let across = libm::cbrt(volume_mm3);
    if kind == CellKind::QuadraticTetrahedron { across / 2.0 } else { across }
}
