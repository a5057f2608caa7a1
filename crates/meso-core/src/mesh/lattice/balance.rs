//! How much of its volume every grain still lacks.

use super::Tetrahedra;
use super::places::Places;
use super::surface::Surface;
use crate::mesh::NO_AGGREGATE;

/// A grain that lacks this share of its volume, or more, counts in full.
const FULL: f64 = 0.02;

/// What every grain's tetrahedra lack of its volume, 1 for [`FULL`] of it or more, -1 for as much too much.
pub(super) fn lacks(mesh: &Tetrahedra, places: &Places, surfaces: &[Surface]) -> Vec<f64> {
    let mut volumes = vec![0.0; surfaces.len()];
    for (cell, &grain) in mesh.cells.iter().zip(&mesh.grain).filter(|(_, grain)| **grain != NO_AGGREGATE) {
        let [a, b, c, d] = cell.map(|node| places.get(node));
        volumes[grain as usize] += (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
    }
    let lack = |(surface, volume): (&Surface, f64)| (1.0 - volume / surface.volume) / FULL;
    surfaces.iter().zip(volumes).map(|pair| lack(pair).clamp(-1.0, 1.0)).collect()
}
