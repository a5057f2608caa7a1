//! `[materials]` of a concrete's class or a mortar's strength, each value with its source.
//!
//! The defaults stand for one concrete, whose strength is [`Mix::default_peak_mpa`]. Other concretes scale them by the rules of
//! codes, so that the default's own strength gives the default's strengths and energies again. The mortar's modulus is the
//! one with which the lower bound of Hashin and Shtrikman (1963) has the code's modulus of the concrete: cubes of 36 mm had
//! 30.1 GPa where the bound has 30.0.

use super::rock::Rock;
use super::{Elastic, LawName, MATERIALS, Materials, Strength};
use meso_concrete::{OutOfRange, PhysicalRange};
use std::fmt::Write;

/// A concrete, by its mean strength, its rock and its share of coarse aggregate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// Mean compressive strength of cylinders, MPa.
    pub fcm_mpa: f64,
    /// Kind of the aggregate's rock; `None` keeps the default stiffness.
    pub rock: Option<Rock>,
    /// Volume of the aggregates that the packing has, over the concrete's.
    pub fraction: f64,
    /// The law that the mortar follows; decks have the values of [`LawName::Cdp`].
    pub law: LawName,
}

/// A key, its value, and where the value is from.
type Entry = (&'static str, f64, String);

/// Material values, with the source of each that is not a default.
#[derive(Clone, Debug, PartialEq)]
pub struct Sourced {
    /// The values.
    pub materials: Materials,
    /// Tables of `[materials]`: their name, and key, value and source of each value.
    tables: Vec<(&'static str, Vec<Entry>)>,
}

/// Difference of mean and characteristic strength, MPa: EN 1992-1-1, Table 3.1; fib Model Code 2010, eq. 5.1-1.
const MARGIN_MPA: f64 = 8.0;
/// Range of mean strengths, MPa, that the codes' rules are meant for: C12 to C120.
const STRENGTHS: PhysicalRange =
    PhysicalRange { least: 20.0, most: 128.0, unit: "MPa", others: PhysicalRange::STRESSES };
/// Least peak strain over the elastic strain of the strength: the curve needs some way to bend.
const LEAST_BEND: f64 = 1.2;

impl Mix {
    /// Share of coarse aggregate where none is given.
    pub const USUAL_FRACTION: f64 = 0.4;

    /// Strength of the concrete that the default mortar and aggregates make between plates of friction 0.1, with 40 % of
    /// aggregates, MPa. Cubes of 36 and 50 mm had 35.5 and 35.6 with `meso`, of 100 and 150 mm 34.2 and 33.3 with `cdp`.
    pub fn default_peak_mpa(law: LawName) -> f64 {
        match law {
            LawName::Meso | LawName::Elastic => 35.5,
            LawName::Cdp | LawName::Cdpm2 => 34.0,
        }
    }

    /// The concrete with a mortar of this compressive strength, MPa.
    ///
    /// # Errors
    /// Names a strength outside its range.
    pub fn of_mortar(mpa: f64, rock: Option<Rock>, fraction: f64, law: LawName) -> Result<Self, OutOfRange> {
        let usual = Materials::default().mortar_strength.of(law);
        let ratio = Self::default_peak_mpa(law) / usual.compressive_mpa;
        let own = |mpa: f64| (1e3 * mpa / ratio).round() / 1e3;
        let range = PhysicalRange { least: own(STRENGTHS.least), most: own(STRENGTHS.most), ..STRENGTHS };
        let accepted = format!("{}; the codes' rules hold there", range.refusal(mpa));
        MATERIALS.require("mortar", mpa, range.has(mpa), accepted)?;
        let fcm_mpa = (mpa * ratio).clamp(STRENGTHS.least, STRENGTHS.most);
        Ok(Self { fcm_mpa, rock, fraction, law })
    }

    /// The concrete of a class, `C30` or `C30/37`, or of a mortar's strength, `M40`.
    ///
    /// # Errors
    /// A sentence with the accepted forms.
    pub fn parse(text: &str, rock: Option<Rock>, fraction: f64, law: LawName) -> Result<Self, String> {
        let number = |text: &str| text.parse::<f64>().ok().filter(|mpa| mpa.is_finite());
        let of_class = |rest: &str| {
            let (cylinder, cube) = rest.split_once('/').map_or((rest, None), |(cylinder, cube)| (cylinder, Some(cube)));
            cube.is_none_or(|cube| number(cube).is_some()).then(|| number(cylinder)).flatten()
        };
        if let Some(fck) = text.strip_prefix(['C', 'c']).and_then(of_class) {
            return Ok(Self { fcm_mpa: fck + MARGIN_MPA, rock, fraction, law });
        }
        if let Some(mpa) = text.strip_prefix(['M', 'm']).and_then(number) {
            let mix = Self::of_mortar(mpa, rock, fraction, law);
            return mix.map_err(|error| format!("{text:?} {}", error.fault()));
        }
        Err(format!("{text:?} is no class of concrete, as C30 or C30/37, and no mortar, as M40 of 40 MPa"))
    }

    /// Its material values, each with its source.
    ///
    /// # Errors
    /// Names a strength or a fraction outside its range.
    pub fn materials(&self) -> Result<Sourced, OutOfRange> {
        let Self { fcm_mpa: fcm, fraction, .. } = *self;
        let accepted = format!("{}; the codes' rules hold there", STRENGTHS.refusal(fcm));
        MATERIALS.require("fcm", fcm, STRENGTHS.has(fcm), accepted)?;
        MATERIALS.require("fraction", fraction, (0.0..=0.8).contains(&fraction), "it must be 0 to 0.8")?;
        let usual = Materials::default();
        let mut sourced = Sourced { materials: usual.clone(), tables: Vec::new() };
        self.add_stiffness(&usual, &mut sourced);
        self.add_strength(&usual, &mut sourced);
        Ok(sourced)
    }

    fn add_stiffness(&self, usual: &Materials, sourced: &mut Sourced) {
        let rock = self.rock.map(Rock::values);
        let stone = rock.map_or(usual.aggregate, |rock| rock.elastic);
        let (factor, code) = rock.map_or((1.0, "no rock named: as quartzite"), |rock| rock.concrete);
        let concrete = factor * secant_modulus(self.fcm_mpa);
        let mortar = mortar_modulus(concrete, &stone, usual.mortar.poisson_ratio, self.fraction);
        let ratio = usual.itz.youngs_modulus_mpa / usual.mortar.youngs_modulus_mpa;
        sourced.materials.aggregate = stone;
        sourced.materials.mortar.youngs_modulus_mpa = mortar;
        sourced.materials.itz.youngs_modulus_mpa = ratio * mortar;
        let source = rock.map_or("the default", |rock| rock.source).to_owned();
        let of_rock = "of the rock; remembered".to_owned();
        let of_concrete = format!(
            "by Hashin and Shtrikman for a concrete of {concrete:.0} MPa with {} of aggregates: EN 1992-1-1, Table 3.1, times \
             {factor} ({code})",
            self.fraction
        );
        let mut aggregate = vec![("youngs_modulus_mpa", stone.youngs_modulus_mpa, source)];
        if rock.is_some() {
            aggregate.push(("poisson_ratio", stone.poisson_ratio, of_rock.clone()));
            aggregate.push(("density_t_per_mm3", stone.density_t_per_mm3, of_rock));
        }
        let share = format!("{ratio:.2} of the mortar's, as in the defaults");
        sourced.tables.extend([
            ("aggregate", aggregate),
            ("mortar", vec![("youngs_modulus_mpa", mortar, of_concrete)]),
            ("itz", vec![("youngs_modulus_mpa", ratio * mortar, share)]),
        ]);
    }

    fn add_strength(&self, usual: &Materials, sourced: &mut Sourced) {
        let (default, fcm) = (usual.mortar_strength.of(self.law), self.fcm_mpa);
        let reference = Self::default_peak_mpa(self.law);
        let ratio = fcm / reference;
        let compressive_mpa = ratio * default.compressive_mpa;
        let scaled = libm::pow(ratio, 0.31) * default.peak_strain;
        let least = LEAST_BEND * compressive_mpa / sourced.materials.mortar.youngs_modulus_mpa;
        let tensile = mean_tensile(fcm) / mean_tensile(reference);
        let strength = Strength {
            compressive_mpa,
            peak_strain: scaled.max(least),
            tensile_mpa: tensile * default.tensile_mpa,
            fracture_energy_n_per_mm: libm::pow(ratio, 0.18) * default.fracture_energy_n_per_mm,
            crushing_energy_n_per_mm: default.crushing_energy_n_per_mm,
        };
        let per =
            |value: f64| format!("the default {value} makes a concrete of {reference} MPa, this one has {fcm:.1}");
        let bend = if scaled < least { ", raised to 1.2 times its elastic strain" } else { "" };
        let strain = format!("{}; grows with f_cm^0.31 (EN 1992-1-1, Table 3.1){bend}", per(default.peak_strain));
        let energy =
            "the default: energies beyond the peak hardly depend on strength (Jansen and Shah 1997; remembered)";
        sourced.materials.mortar_strength = strength.into();
        let rows = vec![
            ("compressive_mpa", strength.compressive_mpa, per(default.compressive_mpa)),
            ("peak_strain", strength.peak_strain, strain),
            (
                "tensile_mpa",
                strength.tensile_mpa,
                format!("{}; grows with f_ctm (fib Model Code 2010, eq. 5.1-3)", per(default.tensile_mpa)),
            ),
            (
                "fracture_energy_n_per_mm",
                strength.fracture_energy_n_per_mm,
                format!(
                    "{}; grows with f_cm^0.18 (fib Model Code 2010, eq. 5.1-9)",
                    per(default.fracture_energy_n_per_mm)
                ),
            ),
            ("crushing_energy_n_per_mm", strength.crushing_energy_n_per_mm, energy.to_owned()),
        ];
        sourced.tables.push(("mortar_strength", rows));
    }
}

impl Sourced {
    /// The values as a TOML file, with the source of each as a comment above it; values that are not there keep the defaults.
    pub fn toml(&self, title: &str) -> String {
        let mut text = format!("# {title}\n[materials]\n");
        for (table, rows) in &self.tables {
            let _ = write!(text, "\n[materials.{table}]\n");
            for (key, value, source) in rows {
                let _ = writeln!(text, "# {source}\n{key} = {}", rounded(*value));
            }
        }
        text
    }
}

/// Four digits, which is more than any of the sources has.
fn rounded(value: f64) -> String {
    let exponent = 3 - libm::log10(value.abs()).floor() as i32;
    let text = format!("{:.*}", usize::try_from(exponent).unwrap_or(0), value);
    if value < 1e-3 { format!("{value:.3e}") } else { text }
}

/// Secant modulus of a concrete of quartzite, MPa: EN 1992-1-1, Table 3.1.
fn secant_modulus(fcm: f64) -> f64 {
    22_000.0 * libm::pow(fcm / 10.0, 0.3)
}

/// Mean tensile strength, MPa: fib Model Code 2010, eq. 5.1-3.
fn mean_tensile(fcm: f64) -> f64 {
    let fck = fcm - MARGIN_MPA;
    if fck <= 50.0 { 0.3 * libm::pow(fck, 2.0 / 3.0) } else { 2.12 * libm::log1p(0.1 * fcm) }
}

/// Modulus of the mortar that makes, with a share `c` of `stone`, a concrete of the modulus `target`.
fn mortar_modulus(target: f64, stone: &Elastic, poisson_ratio: f64, c: f64) -> f64 {
    let (mut low, mut high) = (1e-3 * target, 1e3 * target);
    for _ in 0..100 {
        let middle = (low * high).sqrt();
        let made = composite_modulus(&Elastic { youngs_modulus_mpa: middle, poisson_ratio, ..*stone }, stone, c);
        if made < target { low = middle } else { high = middle }
    }
    (low * high).sqrt()
}

/// Modulus of a matrix with a share `c` of stiffer stone: the lower bound of Hashin and Shtrikman (1963).
fn composite_modulus(matrix: &Elastic, stone: &Elastic, c: f64) -> f64 {
    let moduli = |of: &Elastic| {
        let (e, nu) = (of.youngs_modulus_mpa, of.poisson_ratio);
        [e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))]
    };
    let ([km, gm], [ka, ga]) = (moduli(matrix), moduli(stone));
    // c / (1 / (ka - km) + ...), without a division by zero where both are alike.
    let added = |rise: f64, rest: f64| c * rise / (1.0 + (1.0 - c) * rise * rest);
    let k = km + added(ka - km, 3.0 / (3.0 * km + 4.0 * gm));
    let g = gm + added(ga - gm, 6.0 * (km + 2.0 * gm) / (5.0 * gm * (3.0 * km + 4.0 * gm)));
    9.0 * k * g / (3.0 * k + g)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mix(fcm_mpa: f64, rock: Option<Rock>) -> Sourced {
        Mix { fcm_mpa, rock, fraction: 0.4, law: LawName::Meso }.materials().unwrap()
    }

    /// The physics report: mortar 20, stone 60, ITZ 16 GPa, 40 %: 30.0 by the bound, 30.1 by the engine.
    #[test]
    fn the_bound_is_that_of_hashin_and_shtrikman() {
        let of = |gpa: f64| Elastic { youngs_modulus_mpa: 1000.0 * gpa, poisson_ratio: 0.2, density_t_per_mm3: 1e-9 };
        let made = composite_modulus(&of(20.0), &of(60.0), 0.4);
        // At nu 0.2 both moduli scale alike: E (1 + c x / (1 + (1 - c) x / 2)) with x = 60 / 20 - 1.
        assert!((made - 20_000.0 * (1.0 + 0.4 * 2.0 / 1.6)).abs() < 1e-6, "{made}");
        assert!((mortar_modulus(made, &of(60.0), 0.2, 0.4) - 20_000.0).abs() < 1e-6);
        assert!((composite_modulus(&of(20.0), &of(20.0), 0.4) - 20_000.0).abs() < 1e-9);
    }

    #[test]
    fn the_default_concrete_has_the_default_strengths() {
        for law in [LawName::Meso, LawName::Cdp] {
            let mix = Mix { fcm_mpa: Mix::default_peak_mpa(law), rock: None, fraction: 0.4, law };
            let made = mix.materials().unwrap().materials.mortar_strength.of(law);
            let usual = Materials::default().mortar_strength.of(law);
            let pairs = [
                (made.compressive_mpa, usual.compressive_mpa),
                (made.tensile_mpa, usual.tensile_mpa),
                (made.fracture_energy_n_per_mm, usual.fracture_energy_n_per_mm),
                (made.crushing_energy_n_per_mm, usual.crushing_energy_n_per_mm),
            ];
            assert!(pairs.iter().all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{made:?}");
        }
    }

    /// EN 1992-1-1, Table 3.1, and the factors of 3.1.3(2).
    #[test]
    fn rules_of_the_codes_have_the_values_of_their_tables() {
        for (fcm, tensile, modulus) in [(20.0, 1.6, 27.0), (38.0, 2.9, 33.0), (58.0, 4.1, 37.0), (98.0, 5.0, 44.0)] {
            assert!((mean_tensile(fcm) - tensile).abs() < 0.06, "{fcm}");
            assert!((secant_modulus(fcm) / 1000.0 - modulus).abs() < 0.6, "{fcm}");
        }
        let factors =
            [Rock::Basalt, Rock::Quartzite, Rock::Limestone, Rock::Sandstone].map(|rock| rock.values().concrete.0);
        assert_eq!(factors, [1.2, 1.0, 0.9, 0.7]);
    }

    #[test]
    fn a_concrete_of_every_class_and_rock_has_valid_values_and_its_modulus() {
        for rock in Rock::ALL.map(Some).into_iter().chain([None]) {
            for fcm_mpa in [20.0, 38.0, 58.0, 98.0, 128.0] {
                let materials = mix(fcm_mpa, rock).materials;
                materials.validate_elastic().unwrap();
                materials.validate_strength(LawName::Meso).unwrap();
                materials.validate_peak_strains(LawName::Meso).unwrap();
                let factor = rock.map_or(1.0, |rock| rock.values().concrete.0);
                let made = composite_modulus(&materials.mortar, &materials.aggregate, 0.4);
                assert!((made / (factor * secant_modulus(fcm_mpa)) - 1.0).abs() < 1e-9, "{rock:?} {fcm_mpa}");
            }
        }
    }

    #[test]
    fn classes_and_mortars_are_read_and_others_refused() {
        let fcm = |text: &str| Mix::parse(text, None, 0.4, LawName::Meso).map(|mix| mix.fcm_mpa);
        assert_eq!([fcm("C30"), fcm("c30/37")], [Ok(38.0), Ok(38.0)]);
        for law in [LawName::Meso, LawName::Cdp] {
            let mortar = Mix::parse("M40", None, 0.4, law).unwrap().materials().unwrap().materials.mortar_strength;
            assert!((mortar.of(law).compressive_mpa - 40.0).abs() < 1e-9);
        }
        for text in ["", "C", "30", "C30/", "M", "Cinf", "X40"] {
            assert!(fcm(text).is_err(), "{text}");
        }
        let wrong =
            Mix { fcm_mpa: 5.0, rock: None, fraction: 0.4, law: LawName::Meso }.materials().unwrap_err().to_string();
        assert!(wrong.contains("materials.fcm is 5; it must be 20 to 128 MPa"), "{wrong}");
    }

    #[test]
    fn every_value_has_its_source_above_it() {
        let text = mix(38.0, Some(Rock::Granite)).toml("C30");
        let lines: Vec<&str> = text.lines().collect();
        let values = lines.iter().enumerate().filter(|(_, line)| line.contains(" = "));
        assert_eq!(values.clone().count(), 10, "{text}");
        for (number, line) in values {
            assert!(lines[number - 1].starts_with("# ") && lines[number - 1].len() > 12, "{line}");
        }
    }
}
