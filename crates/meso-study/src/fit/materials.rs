//! The materials of a point of a fit, and their file.

use meso_core::materials::{LawName, Materials, Strength};
use std::collections::BTreeMap;

/// The parameters of a fit, as keys of `[materials.mortar_strength]`.
pub const PARAMETERS: [&str; 4] =
    ["compressive_mpa", "peak_strain", "fracture_energy_n_per_mm", "crushing_energy_n_per_mm"];
/// Least peak strain over the elastic strain of the strength that a point may have.
const LEAST_BEND: f64 = 1.1;

/// Values of the parameters.
pub(super) fn values(of: &Strength) -> Vec<f64> {
    vec![of.compressive_mpa, of.peak_strain, of.fracture_energy_n_per_mm, of.crushing_energy_n_per_mm]
}

/// The point itself, or one beside it whose curve rises to its peak.
pub(super) fn feasible(base: &Materials, point: &[f64]) -> Vec<f64> {
    let of_itz = base.itz_strength_ratio / base.itz.youngs_modulus_mpa;
    let most = point[0] * of_itz.max(1.0 / base.mortar.youngs_modulus_mpa);
    let mut point = point.to_vec();
    point[1] = point[1].max(LEAST_BEND * most);
    point
}

/// `base` with the parameters of `point`; the tensile strength keeps its share of the compressive one.
pub(super) fn at(base: &Materials, law: LawName, point: &[f64]) -> Materials {
    let usual = base.mortar_strength.of(law);
    let mortar_strength = Strength {
        compressive_mpa: point[0],
        peak_strain: point[1],
        tensile_mpa: usual.tensile_mpa / usual.compressive_mpa * point[0],
        fracture_energy_n_per_mm: point[2],
        crushing_energy_n_per_mm: point[3],
    };
    Materials { mortar_strength: mortar_strength.into(), ..base.clone() }
}

/// A file with all values, after some lines of comment.
pub(super) fn file(materials: &Materials, comment: &str) -> String {
    let comment: String = comment.lines().map(|line| format!("# {line}\n")).collect();
    let table = BTreeMap::from([("materials", materials)]);
    comment + "\n" + &toml::to_string(&table).expect("materials are numbers, names and tables of them")
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_core::materials::{Stone, StoneKind};
    use meso_core::spec::options_from_toml;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct File {
        materials: Materials,
    }

    #[test]
    fn a_file_of_materials_reads_back_to_the_same_values() {
        let kinds = vec![StoneKind { share: 1.0, strength_ratio: 0.5 }];
        let stone = Stone { kinds, weibull_modulus: Some(6.0), ..Stone::default() };
        let base = Materials { aggregate_strength: Some(stone), ..Materials::default() };
        let point = feasible(&base, &[1.0 / 3.0 * 100.0, 1e-5, 0.07, 3.3]);
        let made = at(&base, LawName::Meso, &point);
        assert!(point[1] > 1e-3 && values(&made.mortar_strength.of(LawName::Meso)) == point, "{point:?}");
        let read: File = options_from_toml(&file(&made, "a remark\nof two lines")).unwrap();
        assert_eq!(read.materials, made);
    }
}
