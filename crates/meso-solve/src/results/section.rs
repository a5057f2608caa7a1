//! Damage in a plane: every cell that it meets is cut exactly, and a pixel takes the cell that its centre lies in.

use super::png::Picture;
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::{CellKind, Mesh, Phase};
use meso_view::section::{ACROSS, sort_around};

/// Pixels along the longer side.
const PIXELS: f64 = 680.0;
/// Steps of damage from 0 to 1.
const STEPS: usize = 64;
/// Damage beyond which a cell of an aggregate shows it.
const BROKEN: f32 = 0.5;
/// Places in the palette, before the steps of damage.
const AGGREGATE: u8 = 1;
const FIBRE: u8 = 2;
const DAMAGE: u8 = 3;
const AGGREGATE_COLOUR: [u8; 3] = [150, 144, 134];
const FIBRE_COLOUR: [u8; 3] = [58, 78, 110];
/// Colours of damage 0, 1/4, ... 1: from mortar to a crack, ever darker, so that they differ without colour, too.
pub(super) const RAMP: [[u8; 3]; 5] = [[236, 232, 223], [250, 204, 115], [232, 118, 50], [170, 35, 30], [60, 5, 20]];

/// The section of `mesh` at the coordinate `place`, mm, along `axis`.
pub(super) fn picture(mesh: &Mesh, damage: &[f32], axis: usize, place: f64) -> Picture {
    let mut canvas = Canvas::new(&Aabb::around(&mesh.points), axis);
    for (number, cell) in mesh.cells().enumerate() {
        let corners = cut(mesh, cell, axis, place);
        if corners.len() > 2 {
            canvas.fill(&corners, colour(mesh.phase[number], damage[number]));
        }
    }
    canvas.picture
}

fn colour(phase: Phase, damage: f32) -> u8 {
    match phase {
        Phase::Aggregate | Phase::Void | Phase::Own(_) if damage <= BROKEN => AGGREGATE,
        Phase::Fibre => FIBRE,
        _ => DAMAGE + (damage.clamp(0.0, 1.0) * (STEPS - 1) as f32).round() as u8,
    }
}

fn palette() -> Vec<[u8; 3]> {
    let step = |i: usize| {
        let place = (RAMP.len() - 1) as f32 * i as f32 / (STEPS - 1) as f32;
        let low = (place as usize).min(RAMP.len() - 2);
        let share = place - low as f32;
        let mix = |k: usize| (1.0 - share) * f32::from(RAMP[low][k]) + share * f32::from(RAMP[low + 1][k]);
        [0, 1, 2].map(|k| mix(k).round() as u8)
    };
    [[0; 3], AGGREGATE_COLOUR, FIBRE_COLOUR].into_iter().chain((0..STEPS).map(step)).collect()
}

/// Pairs of corners that an edge connects.
fn edges(kind: CellKind) -> &'static [(usize, usize)] {
    match kind {
        CellKind::Tetrahedron | CellKind::QuadraticTetrahedron => &[(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
        CellKind::Hexahedron => {
            &[(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
        }
    }
}

/// Corners of the section of a convex cell, in order around it; none where the plane misses it.
///
/// A corner in the plane counts as above it: where the plane runs along faces, the cells below show.
fn cut(mesh: &Mesh, cell: &[u32], axis: usize, place: f64) -> Vec<[f64; 2]> {
    let point = |corner: usize| mesh.points[cell[corner] as usize];
    let is_above = |corner: usize| point(corner)[axis] >= place;
    let first = is_above(0);
    if (1..mesh.kind.corners()).all(|corner| is_above(corner) == first) {
        return Vec::new();
    }
    let (u, v) = ACROSS[axis];
    let crossing = |&(a, b): &(usize, usize)| {
        // In one direction from all cells at the edge, so that their sections meet bit for bit.
        let (a, b) = if cell[a] < cell[b] { (a, b) } else { (b, a) };
        let (from, to): (Vec3, Vec3) = (point(a), point(b));
        let t = (place - from[axis]) / (to[axis] - from[axis]);
        [from[u] + t * (to[u] - from[u]), from[v] + t * (to[v] - from[v])]
    };
    let crossed = edges(mesh.kind).iter().filter(|&&(a, b)| is_above(a) != is_above(b));
    let mut corners: Vec<[f64; 2]> = crossed.map(crossing).collect();
    sort_around(&mut corners);
    corners
}

/// Pixels over a section, and their size.
struct Canvas {
    picture: Picture,
    /// Lower left corner, mm.
    from: [f64; 2],
    /// Edge of a pixel, mm.
    pixel: f64,
}

impl Canvas {
    fn new(aabb: &Aabb, axis: usize) -> Self {
        let (u, v) = ACROSS[axis];
        let size = [aabb.size()[u], aabb.size()[v]];
        let pixel = size[0].max(size[1]) / PIXELS;
        let [width, height] = size.map(|side| ((side / pixel).round() as usize).max(1));
        let picture = Picture { width, height, pixels: vec![0; width * height], palette: palette() };
        Self { picture, from: [aabb.min[u], aabb.min[v]], pixel }
    }

    /// Colours the pixels whose centres lie in a convex polygon.
    fn fill(&mut self, corners: &[[f64; 2]], colour: u8) {
        let place = |c: &[f64; 2]| [0, 1].map(|k| (c[k] - self.from[k]) / self.pixel - 0.5);
        let corners: Vec<[f64; 2]> = corners.iter().map(place).collect();
        let rows = span(corners.iter().map(|c| c[1]), self.picture.height);
        for row in rows {
            let y = row as f64;
            let crossings = (0..corners.len()).filter_map(|i| {
                let (one, other) = (corners[i], corners[(i + 1) % corners.len()]);
                // Upwards from both sides of the edge, for the same reason.
                let ([ax, ay], [bx, by]) = if one[1] < other[1] { (one, other) } else { (other, one) };
                ((ay <= y) != (by <= y)).then(|| ax + (y - ay) / (by - ay) * (bx - ax))
            });
            // SVG's and PNG's rows go down.
            let first = (self.picture.height - 1 - row) * self.picture.width;
            let columns = span(crossings, self.picture.width);
            self.picture.pixels[first + columns.start..first + columns.end].fill(colour);
        }
    }
}

/// The whole numbers below `end` that lie above the least of `values` and not above the largest.
fn span(values: impl Iterator<Item = f64>, end: usize) -> std::ops::Range<usize> {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [f64::min(low, x), f64::max(high, x)]);
    if low > high {
        return 0..0;
    }
    let after = |x: f64| ((x.floor() + 1.0).max(0.0) as usize).min(end);
    after(low)..after(high).max(after(low))
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_concrete::specimen::Specimen;
    use meso_mesh::{ItzForm, MeshOptions, Method, Tools};

    #[test]
    fn polygons_that_tile_a_square_leave_no_pixel_out() {
        let aabb = Aabb { min: Vec3::zeros(), max: Vec3::repeat(7.0) };
        let mut canvas = Canvas::new(&aabb, 2);
        let inner = [2.3, 4.1];
        let corners = [[0.0, 0.0], [7.0, 0.0], [7.0, 7.0], [0.0, 7.0]];
        for i in 0..4 {
            canvas.fill(&[corners[i], corners[(i + 1) % 4], inner], 1 + i as u8);
        }
        let pixels = &canvas.picture.pixels;
        assert_eq!((pixels.len(), pixels.iter().filter(|&&p| p == 0).count()), (680 * 680, 0));
        // The triangles' shares of the square, by their heights over its sides.
        for (i, height) in [4.1, 7.0 - 2.3, 7.0 - 4.1, 2.3].into_iter().enumerate() {
            let share = pixels.iter().filter(|&&p| p == 1 + i as u8).count() as f64 / pixels.len() as f64;
            assert!((share - height / 14.0).abs() < 2e-3, "{i}: {share}");
        }
    }

    #[test]
    fn a_plane_along_faces_shows_the_cells_below_it() {
        let options =
            MeshOptions { method: Method::FITTED, element_size_mm: 2.0, itz: ItzForm::None, ..MeshOptions::default() };
        let mesh = meso_mesh::build((&[], &Specimen::cube(8.0)), &options, &Tools::default()).unwrap();
        // The plane z = 4 passes through nodes.
        let area = |cell: &[u32]| {
            let corners = cut(&mesh, cell, 2, 4.0);
            let next = corners.iter().cycle().skip(1);
            corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
        };
        let total: f64 = mesh.cells().map(area).sum();
        assert!((total - 64.0).abs() < 1e-9, "{total}");
    }

    #[test]
    fn the_palette_goes_from_mortar_to_black_by_steps() {
        let palette = palette();
        assert_eq!(palette.len(), usize::from(DAMAGE) + STEPS);
        assert_eq!((palette[usize::from(DAMAGE)], palette[palette.len() - 1]), (RAMP[0], RAMP[4]));
    }
}
