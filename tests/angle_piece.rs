//! A specimen of triangles that is not convex, for the tests of the core and of the command.

use meso_core::specimen::{Built, Specimen};

/// An L as triangles: two arms of length `long`, `thick` across and `high`, each corner moved by `place`.
pub(crate) fn angle_piece([long, thick, high]: [f64; 3], place: impl Fn([f64; 3]) -> [f64; 3]) -> Specimen {
    let profile = [[0.0, 0.0], [long, 0.0], [long, thick], [thick, thick], [thick, long], [0.0, long]];
    let at = |z: f64| profile.map(|[x, y]| place([x, y, z]));
    let caps = [[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]];
    let mut triangles: Vec<[u32; 3]> = caps.iter().map(|&[a, b, c]| [a, c, b]).collect();
    triangles.extend(caps.iter().map(|t| t.map(|i| i + 6)));
    for i in 0..6u32 {
        let j = (i + 1) % 6;
        triangles.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
    }
    Specimen::Mesh { vertices_mm: [at(0.0), at(high)].concat(), triangles, built: Built::default() }
}
