//! The materials of a point of a fit, and their file.

use meso_core::materials::{Materials, Strength};
use serde_json::Value;

/// The parameters of a fit, as keys of `[materials.mortar_strength]`.
pub(super) const PARAMETERS: [&str; 4] =
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
pub(super) fn at(base: &Materials, point: &[f64]) -> Materials {
    let usual = base.mortar_strength;
    let mortar_strength = Strength {
        compressive_mpa: point[0],
        peak_strain: point[1],
        tensile_mpa: usual.tensile_mpa / usual.compressive_mpa * point[0],
        fracture_energy_n_per_mm: point[2],
        crushing_energy_n_per_mm: point[3],
    };
    Materials { mortar_strength, ..base.clone() }
}

/// A file with all values, after some lines of comment.
pub(super) fn toml(materials: &Materials, comment: &str) -> String {
    let mut text: String = comment.lines().map(|line| format!("# {line}\n")).collect();
    let tree = serde_json::to_value(materials).unwrap_or_default();
    add_table(&mut text, "materials", &tree);
    text
}

/// Adds a table: its values, then the tables within it.
fn add_table(text: &mut String, name: &str, table: &Value) {
    let entries = || table.as_object().into_iter().flatten().filter(|(_, value)| !value.is_null());
    text.push_str(&format!("\n[{name}]\n"));
    for (key, value) in entries().filter(|(_, value)| !value.is_object()) {
        text.push_str(&format!("{key} = {}\n", inline(value)));
    }
    entries()
        .filter(|(_, value)| value.is_object())
        .for_each(|(key, value)| add_table(text, &format!("{name}.{key}"), value));
}

fn inline(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::Object(entries) => {
            let entries: Vec<String> =
                entries.iter().map(|(key, value)| format!("{key} = {}", inline(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        scalar => scalar.to_string(),
    }
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
        let made = at(&base, &point);
        assert!(point[1] > 1e-3 && values(&made.mortar_strength) == point, "{point:?}");
        let read: File = options_from_toml(&toml(&made, "a remark\nof two lines")).unwrap();
        assert_eq!(read.materials, made);
    }
}
