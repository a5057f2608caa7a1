//! Ranges of a deck's values besides those of its materials.

use super::{Analysis, DeckOptions, LAW};
use meso_concrete::{OutOfRange, PhaseNames, Ranges};
use meso_mesh::cells::Phase;
use meso_mesh::materials::{LawName, MATERIALS, Materials};
use meso_trial::Test;

/// Checks values by their names in the options of a deck.
pub(crate) const DECK: Ranges = Ranges("deck");

/// Every value against its range; NaN lies in none.
pub(super) fn check(options: &DeckOptions) -> Result<(), OutOfRange> {
    let strain = options.elastic_strain();
    let accepted = "it must lie between 0 and 1; the analysis sets its sign";
    DECK.require("strain", strain, strain > 0.0 && strain < 1.0, accepted)?;
    let [friction, duration, speed] = options.impact();
    DECK.require("friction", friction, (0.0..=10.0).contains(&friction), "it must be 0 to 10")?;
    DECK.require("frames", options.field_frames(), options.field_frames() > 0, "it must be 1 or more")?;
    DECK.positive("duration_s", duration)?;
    DECK.positive("time_increment_s", options.time_increment_s.unwrap_or(1.0))?;
    DECK.positive("impact_speed_mm_per_s", speed)?;
    let met = !options.with_damage || options.analysis.is_explicit() || options.analysis == Analysis::None;
    let accepted = "elastic has no damage; take another analysis, a test with a law that breaks, or none";
    DECK.require("with_damage", "true", met, accepted)?;
    let fits = |line: &&String| line.is_ascii() && !line.starts_with('*') && !line.contains(['\n', '\r']);
    if let Some(line) = options.heading.iter().find(|line| !fits(line)) {
        return Err(DECK.error("heading", format!("{line:?}"), "a line must be ASCII and must not begin with *"));
    }
    let law = if options.damages() { LAW } else { LawName::Elastic };
    options.materials.validate_scatter(law).map_err(in_deck)?;
    materials(&options.materials).map_err(in_deck)
}

/// Refuses options without effect, in a deck of hexahedra or of tetrahedra.
pub(super) fn effects(options: &DeckOptions, has_hexahedra: bool) -> Result<(), OutOfRange> {
    let DeckOptions { geometry_only, analysis, strain, friction, duration_s, time_increment_s, frames, .. } = options;
    let (is_explicit, speed) = (analysis.is_explicit() && !geometry_only, options.impact_speed_mm_per_s);
    let test = options.test().filter(|_| !geometry_only);
    let has_strain = *analysis == Analysis::Elastic || test.as_ref().is_some_and(Test::has_path);
    // A test refuses a friction that has no effect on it.
    let rubs = *analysis == Analysis::Striker || test.is_some();
    let value = |given: Option<f64>| given.map(|value| value.to_string());
    let explicit = "only a test that breaks, and a striker, take it";
    for (key, value, has_effect, accepted) in [
        ("analysis", (*analysis != Analysis::None).then(|| analysis.word()), !geometry_only, GEOMETRY),
        ("with_damage", options.with_damage.then(|| "true".to_owned()), !geometry_only, GEOMETRY),
        (
            "reduced_integration",
            options.reduced_integration.then(|| "true".to_owned()),
            has_hexahedra,
            "only voxels take it",
        ),
        ("strain", value(*strain), has_strain && !geometry_only, "only elastic and tests with a path take it"),
        ("friction", value(*friction), rubs && !geometry_only, "only tests whose plates rub, and a striker, take it"),
        (
            "impact_speed_mm_per_s",
            value(speed),
            *analysis == Analysis::Striker && !geometry_only,
            "only the analysis striker takes it",
        ),
        ("frames", frames.map(|frames| frames.to_string()), is_explicit, explicit),
        ("duration_s", value(*duration_s), is_explicit, explicit),
        ("time_increment_s", value(*time_increment_s), is_explicit, explicit),
    ] {
        DECK.require(key, value.clone().unwrap_or_default(), has_effect || value.is_none(), accepted)?;
    }
    Ok(())
}

/// The reason why geometry alone has no step and no material.
const GEOMETRY: &str = "geometry_only leaves it out";

fn materials(values: &Materials) -> Result<(), OutOfRange> {
    values.validate_elastic()?;
    values.validate_strength(LAW)?;
    values.validate_cohesive()?;
    values.validate_plasticity()
}

/// Names a value of `[materials]` as a deck's option.
fn in_deck(error: OutOfRange) -> OutOfRange {
    error.within(DECK.0)
}

/// Finds out whether Abaqus takes the curves of `phase`: it refuses plastic strains that fall. The curves of compression
/// ensure that themselves. `opening` is the deck's share of a crack's opening; a crack's plastic opening grows by that share
/// of G / (4 f) where it loses f / (5 E).
pub(super) fn curves(
    materials: &Materials,
    (phase, phases): (Phase, &PhaseNames),
    opening: f64,
) -> Result<(), OutOfRange> {
    let Some(strength) = materials.strength(phase, phases, LAW) else { return Ok(()) };
    materials.validate_peak_strain(phase, phases, LAW).map_err(in_deck)?;
    let (e, ft) = (materials.elastic(phase, phases).youngs_modulus_mpa, strength.tensile_mpa);
    let given = materials.mortar_strength.of(LAW).fracture_energy_n_per_mm;
    let share = opening * strength.fracture_energy_n_per_mm / given;
    let least = 0.8 * ft * ft / e / share;
    let accepted = format!("{} needs {least:.3e} or more for its elastic strain", phases.set_name(phase));
    MATERIALS.require("mortar_strength.fracture_energy_n_per_mm", given, given >= least, accepted).map_err(in_deck)
}

/// Finds out whether Abaqus takes the softening of a cohesive ITZ.
pub(super) fn separation(materials: &Materials) -> Result<(), OutOfRange> {
    materials.validate_cohesive_softening(LAW).map_err(in_deck)
}
