//! Ranges of a deck's values besides those of its materials.

use super::{Analysis, DeckOptions, LAW, Loading};
use meso_concrete::{OutOfRange, Ranges};
use meso_mesh::cells::Phase;
use meso_mesh::materials::{MATERIALS, Materials};

/// Checks values by their names in the options of a deck.
pub(crate) const DECK: Ranges = Ranges("deck");

/// Every value against its range; NaN lies in none.
pub(super) fn check(options: &DeckOptions) -> Result<(), OutOfRange> {
    let loading = &options.loading;
    let strain = options.final_strain();
    let accepted = "it must lie between 0 and 1; the analysis sets its sign";
    DECK.require("strain", strain, strain > 0.0 && strain < 1.0, accepted)?;
    DECK.require("friction", loading.friction, (0.0..=10.0).contains(&loading.friction), "it must be 0 to 10")?;
    DECK.require("frames", loading.frames, loading.frames > 0, "it must be 1 or more")?;
    DECK.positive("duration_s", loading.duration_s)?;
    DECK.positive("time_increment_s", loading.time_increment_s)?;
    DECK.positive("impact_speed_mm_per_s", loading.impact_speed_mm_per_s)?;
    let met = !options.with_damage || options.analysis != Analysis::Elastic;
    let accepted = "analysis elastic has no damage; take compression, tension or none";
    DECK.require("with_damage", "true", met, accepted)?;
    if let Some(section) = options.section_mm2 {
        DECK.positive("section_mm2", section)?;
    }
    let fits = |line: &&String| line.is_ascii() && !line.starts_with('*') && !line.contains(['\n', '\r']);
    if let Some(line) = options.heading.iter().find(|line| !fits(line)) {
        return Err(DECK.error("heading", format!("{line:?}"), "a line must be ASCII and must not begin with *"));
    }
    materials(&options.materials).map_err(in_deck)
}

/// Refuses options without effect, in a deck of hexahedra or of tetrahedra. Their usual values are accepted.
pub(super) fn effects(options: &DeckOptions, has_hexahedra: bool) -> Result<(), OutOfRange> {
    let DeckOptions { geometry_only, loading, strain, .. } = options;
    let (usual, is_explicit) = (Loading::default(), options.has_curve());
    let analysis = if *geometry_only { Analysis::None } else { options.analysis };
    let name = format!("{:?}", options.analysis).to_lowercase();
    let geometry = "geometry_only leaves it out";
    let explicit = "only the analyses compression, tension and impact take it";
    let asked = |key, value: f64, usual: f64| (key, value != usual, value.to_string());
    let (friction, frames) = (loading.friction, f64::from(loading.frames));
    for ((key, is_asked, value), has_effect, accepted) in [
        (("analysis", options.analysis != Analysis::None, name), !geometry_only, geometry),
        (("with_damage", options.with_damage, "true".to_owned()), !geometry_only, geometry),
        (("reduced_integration", options.reduced_integration, "true".to_owned()), has_hexahedra, "only voxels take it"),
        (
            ("strain", strain.is_some(), strain.unwrap_or_default().to_string()),
            analysis != Analysis::None,
            "only an analysis takes it",
        ),
        (
            asked("friction", friction, usual.friction),
            matches!(analysis, Analysis::Compression | Analysis::Impact | Analysis::Test),
            "only the analyses compression and impact take it",
        ),
        (
            asked("impact_speed_mm_per_s", loading.impact_speed_mm_per_s, usual.impact_speed_mm_per_s),
            analysis == Analysis::Impact,
            "only the analysis impact takes it",
        ),
        (asked("frames", frames, f64::from(usual.frames)), is_explicit, explicit),
        (asked("duration_s", loading.duration_s, usual.duration_s), is_explicit, explicit),
        (asked("time_increment_s", loading.time_increment_s, usual.time_increment_s), is_explicit, explicit),
    ] {
        DECK.require(key, value, has_effect || !is_asked, accepted)?;
    }
    Ok(())
}

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
pub(super) fn curves(materials: &Materials, phase: Phase, opening: f64) -> Result<(), OutOfRange> {
    let Some(strength) = materials.strength(phase, LAW) else { return Ok(()) };
    materials.validate_peak_strain(phase, LAW).map_err(in_deck)?;
    let (e, ft) = (materials.elastic(phase).youngs_modulus_mpa, strength.tensile_mpa);
    let given = materials.mortar_strength.fracture_energy_n_per_mm;
    let share = opening * strength.fracture_energy_n_per_mm / given;
    let least = 0.8 * ft * ft / e / share;
    let accepted = format!("{} needs {least:.3e} or more for its elastic strain", phase.name());
    MATERIALS.require("mortar_strength.fracture_energy_n_per_mm", given, given >= least, accepted).map_err(in_deck)
}

/// Finds out whether Abaqus takes the softening of a cohesive ITZ.
pub(super) fn separation(materials: &Materials) -> Result<(), OutOfRange> {
    materials.validate_cohesive_softening(LAW).map_err(in_deck)
}
