//! Phases of the aggregates' own that cannot be.

use super::{Checked, number};
use crate::{Spec, SpecError};
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::{Grading, OwnPhase, SHARE_ROUNDING};
use meso_concrete::own_tables::alike;
use meso_concrete::{exceeds, short};

/// Longest name of a phase, which makes keyword lines of decks of fewer than 80 characters.
const LONGEST: usize = 24;

/// Names that the phases of every concrete, their values, or sets and surfaces of decks have.
const TAKEN: [&str; 26] = [
    "mortar",
    "itz",
    "aggregate",
    "void",
    "fibre",
    "aggregate_strength",
    "scatter",
    "mortar_strength",
    "itz_strength_ratio",
    "cohesive_thickness_mm",
    "cohesive_shear_energy_ratio",
    "cohesive_mode_power",
    "plasticity",
    "meso",
    "cdpm2",
    "outside",
    "all",
    "cohesive",
    "joints",
    "xmin",
    "xmax",
    "ymin",
    "ymax",
    "zmin",
    "zmax",
    "own",
];

/// Checks `[[phases]]`: each entry alone, then their shares in every size class.
pub(super) fn check(spec: &Spec) -> Checked {
    let Spec { phases, grading, .. } = spec;
    if phases.len() > PhaseNames::MOST {
        let message =
            format!("has {} entries; a specimen has at most {} phases of its own", phases.len(), PhaseNames::MOST);
        return Err(SpecError::value("phases", message));
    }
    for (number, phase) in phases.iter().enumerate() {
        name(phase, &phases[..number])?;
        share(phase)?;
        sizes(phase, grading)?;
    }
    for class in grading.classes() {
        let sum: f64 = phases.iter().map(|phase| phase.share_of(&class)).sum();
        if exceeds(sum, 1.0 + SHARE_ROUNDING) {
            let [low, high] = [class.d_min_mm, class.d_max_mm].map(number);
            let message = format!(
                "of all phases add up to {} in the class from {low} to {high} mm; it must be at most 1: the phase \
                 aggregate has the rest",
                number(short(sum))
            );
            return Err(SpecError::value("phases.share", message));
        }
    }
    Ok(())
}

fn name(phase: &OwnPhase, before: &[OwnPhase]) -> Checked {
    let name = phase.name.as_str();
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let wrong = if name.is_empty()
        || name.len() > LONGEST
        || !name.chars().all(is_word)
        || !name.starts_with(|c: char| c.is_ascii_lowercase())
    {
        format!("it takes lower-case letters, digits and _, a letter first, at most {LONGEST} of them: \"limestone\"")
    } else if TAKEN.contains(&name) {
        "this name has a meaning of its own; take another, such as \"limestone\"".to_owned()
    } else if let Some(known) = alike(name, &TAKEN) {
        format!("it begins like {known}, for which its values would be taken; take another, such as \"old_{known}\"")
    } else if before.iter().any(|other| other.name == name) {
        "another entry has this name; every phase has one entry".to_owned()
    } else {
        return Ok(());
    };
    Err(SpecError::value("phases.name", format!("is {name:?}; {wrong}")))
}

fn share(phase: &OwnPhase) -> Checked {
    let share = phase.share;
    if share > 0.0 && share <= 1.0 {
        return Ok(());
    }
    let percent = if (2.0..=100.0).contains(&share) {
        format!(": for {} % write {}", number(share), number(short(share / 100.0)))
    } else {
        String::new()
    };
    let message = format!(
        "of {} is {}; the accepted range is above 0 and at most 1 (volume over that of all aggregates in its classes){percent}",
        phase.name,
        number(share)
    );
    Err(SpecError::value("phases.share", message))
}

fn sizes(phase: &OwnPhase, grading: &Grading) -> Checked {
    let Some(sizes) = phase.sizes_mm else { return Ok(()) };
    let limits = &grading.classes_mm;
    let [low, high] = sizes.map(number);
    let wrong = if let Some(&other) = sizes.iter().find(|size| !limits.contains(size)) {
        let known: Vec<String> = limits.iter().map(|&limit| number(limit)).collect();
        format!(
            "{} is no limit of a class; grading.classes_mm has {}: take two of them, or add it there",
            number(other),
            known.join(", ")
        )
    } else if sizes[0] >= sizes[1] {
        "the smaller size comes first".to_owned()
    } else {
        return Ok(());
    };
    Err(SpecError::value("phases.sizes_mm", format!("of {} is [{low}, {high}]; {wrong}", phase.name)))
}
