//! A drilled core in a label volume: the upright cylinder that fits all that does not lie outside.
//!
//! Labels of the outside occur within the core, too, where it has pores. So the outside is what is connected with the sides of its
//! layer; all else is the core.

use meso_concrete::exceeds;
use meso_concrete::import::grains::CoreCylinder;
use meso_concrete::import::volume::Volume;
use std::f64::consts::PI;

/// Layers about the core that stay in the volume, voxels.
const FRAME: usize = 2;
/// Largest share of a core's voxels that may lie beyond its cylinder, or be missing within: 1.5 voxels of 100 across.
pub(crate) const MOST_OFF: f64 = 0.05;

/// The part of a volume about a core, and the core's cylinder in it.
pub(crate) struct Drilled {
    /// Voxels beyond the cylinder have a label of the outside.
    pub(crate) volume: Volume<u16>,
    /// The cylinder in the part of the volume.
    pub(crate) round: CoreCylinder,
    /// Voxels of the cylinder.
    pub(crate) voxels: usize,
    /// Share of the core's voxels that lie beyond the cylinder, or are missing within.
    pub(crate) off: f64,
    /// Share of the cylinder's voxels that have a label of the outside.
    pub(crate) pores: f64,
}

/// Why there is no core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NoCore {
    /// All lies outside, or nothing does.
    Nothing,
    /// It is no upright cylinder: so much of it is off.
    Off(f64),
}

/// Finds the core in a volume whose voxels have these edges, mm.
///
/// # Errors
/// See [`NoCore`].
pub(crate) fn find(volume: &Volume<u16>, outside: &[i64], edges_mm: [f64; 3]) -> Result<Drilled, NoCore> {
    let [nx, ny, _] = volume.counts;
    let [hx, hy, _] = edges_mm;
    let is_named: Vec<bool> = volume.labels.iter().map(|label| outside.contains(label)).collect();
    let layers: Vec<Vec<bool>> = volume
        .of
        .chunks(nx * ny)
        .map(|layer| core_of([nx, ny], &|voxel| is_named[usize::from(layer[voxel])]))
        .collect();
    let has_core = |layer: &Vec<bool>| layer.iter().any(|is_core| *is_core);
    let from = layers.iter().position(has_core).ok_or(NoCore::Nothing)?;
    let to = layers.iter().rposition(has_core).map_or(0, |last| last + 1);
    let at = |voxel: usize| [((voxel % nx) as f64 + 0.5) * hx, ((voxel / nx) as f64 + 0.5) * hy];
    let own = || layers[from..to].iter().flat_map(|layer| (0..layer.len()).filter(|&voxel| layer[voxel]).map(at));
    let count = own().count() as f64;
    if count == (nx * ny * (to - from)) as f64 {
        return Err(NoCore::Nothing);
    }
    let sum = own().fold([0.0; 2], |sum, place| [sum[0] + place[0], sum[1] + place[1]]);
    let centre = sum.map(|sum| sum / count);
    let radius = (count / (to - from) as f64 * hx * hy / PI).sqrt();
    let is_within = |[x, y]: [f64; 2]| libm::hypot(x - centre[0], y - centre[1]) < radius;
    let differ = |layer: &Vec<bool>| (0..layer.len()).filter(|&voxel| layer[voxel] != is_within(at(voxel))).count();
    let off = layers[from..to].iter().map(differ).sum::<usize>() as f64 / count;
    if exceeds(off, MOST_OFF) {
        return Err(NoCore::Off(off));
    }
    let range = |axis: usize, edge: f64, most: usize| {
        let [low, high] = [centre[axis] - radius, centre[axis] + radius].map(|mm| mm / edge);
        [(low.floor().max(0.0) as usize).saturating_sub(FRAME), (high.ceil() as usize + FRAME).min(most)]
    };
    let ([x0, x1], [y0, y1]) = (range(0, hx, nx), range(1, hy, ny));
    let air = is_named.iter().position(|is_named| *is_named).unwrap_or(0) as u16;
    let (mut of, mut voxels, mut pores) = (Vec::with_capacity((x1 - x0) * (y1 - y0) * (to - from)), 0, 0);
    for (z, y) in (from..to).flat_map(|z| (y0..y1).map(move |y| (z, y))) {
        for x in x0..x1 {
            let own = volume.of[(z * ny + y) * nx + x];
            let is_in = is_within(at(y * nx + x));
            voxels += usize::from(is_in);
            pores += usize::from(is_in && is_named[usize::from(own)]);
            of.push(if is_in { own } else { air });
        }
    }
    let volume = Volume {
        counts: [x1 - x0, y1 - y0, to - from],
        of,
        labels: volume.labels.clone(),
        spacing_mm: volume.spacing_mm,
        size_note: None,
        array_note: None,
    };
    let centre_mm = [centre[0] - x0 as f64 * hx, centre[1] - y0 as f64 * hy];
    let round = CoreCylinder { centre_mm, radius_mm: radius };
    Ok(Drilled { volume, round, voxels, off, pores: pores as f64 / voxels as f64 })
}

/// Voxels of a layer that are not connected with its sides through voxels of the outside.
fn core_of([nx, ny]: [usize; 2], is_outside: &dyn Fn(usize) -> bool) -> Vec<bool> {
    let mut is_core = vec![true; nx * ny];
    let sides = (0..nx).flat_map(|x| [x, (ny - 1) * nx + x]).chain((0..ny).flat_map(|y| [y * nx, y * nx + nx - 1]));
    let mut open: Vec<usize> = sides.collect();
    while let Some(voxel) = open.pop() {
        if !is_core[voxel] || !is_outside(voxel) {
            continue;
        }
        is_core[voxel] = false;
        let (x, y) = (voxel % nx, voxel / nx);
        open.extend((x > 0).then(|| voxel - 1));
        open.extend((x + 1 < nx).then_some(voxel + 1));
        open.extend((y > 0).then(|| voxel - nx));
        open.extend((y + 1 < ny).then_some(voxel + nx));
    }
    is_core
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A volume of 40 x 50 x 12 voxels, of labels by place.
    fn volume(label: impl Fn(f64, f64, usize) -> i64) -> Volume<u16> {
        let at = |i: usize| label((i % 40) as f64 + 0.5, (i / 40 % 50) as f64 + 0.5, i / 2000);
        Volume::new([40, 50, 12], None, (0..24_000).map(at).collect::<Vec<i64>>()).unwrap()
    }

    #[test]
    fn a_core_is_found_with_its_diameter_whatever_pores_and_empty_layers_it_has() {
        let core = |x: f64, y: f64, z: usize| {
            let is_core = libm::hypot(x - 21.0, y - 24.0) < 15.0 && z > 0 && z < 11;
            let is_pore = libm::hypot(x - 20.0, y - 20.0) < 4.0;
            i64::from(is_core && !is_pore)
        };
        let found = find(&volume(core), &[0], [0.5, 0.5, 1.0]).unwrap();
        let CoreCylinder { centre_mm, radius_mm } = found.round;
        assert!((radius_mm - 7.5).abs() < 0.05 && found.off < 0.02, "{radius_mm} {}", found.off);
        let pores = (found.pores * found.voxels as f64).round() as usize;
        // Ten layers of a circle of 706.9 and of a pore of 50.3 voxels.
        assert!((490..=530).contains(&pores) && found.voxels.abs_diff(7_069) < 100, "{pores} {}", found.voxels);
        // The part has a frame of two voxels about the core, whose centre is its middle.
        let [nx, ny, nz] = found.volume.counts;
        assert!((34..=36).contains(&nx) && (34..=36).contains(&ny) && nz == 10, "{nx} {ny} {nz}");
        let middle = [nx, ny].map(|count| 0.25 * count as f64);
        assert!(centre_mm.iter().zip(middle).all(|(found, middle)| (found - middle).abs() < 0.3));
    }

    #[test]
    fn shapes_other_than_an_upright_cylinder_are_refused() {
        let of = |label: &dyn Fn(f64, f64, usize) -> i64| find(&volume(label), &[0], [1.0; 3]).map(drop).unwrap_err();
        assert_eq!(of(&|_, _, _| 1), NoCore::Nothing);
        assert_eq!(of(&|_, _, _| 0), NoCore::Nothing);
        assert!(matches!(of(&|x, y, _| i64::from(x > 5.0 && x < 35.0 && y > 9.0 && y < 39.0)), NoCore::Off(_)));
        let leaning = |x: f64, y: f64, z: usize| i64::from(libm::hypot(x - 15.0 - z as f64, y - 25.0) < 10.0);
        assert!(matches!(of(&leaning), NoCore::Off(off) if off > 0.3));
    }
}
