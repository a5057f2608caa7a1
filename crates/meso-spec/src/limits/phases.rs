//! Phases of the aggregates' own that cannot be.

use super::grading::ascending;
use super::{Checked, in_order, length, number, within};
use crate::{Spec, SpecError};
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::{Grading, OwnPhase, SHARE_ROUNDING, ShellLaw, Thickness};
use meso_concrete::own_tables::alike;
use meso_concrete::{exceeds, short};
use std::cmp::Ordering;

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
    let count = spec.phases().own().len();
    if phases.len() > PhaseNames::MOST || count > PhaseNames::MOST {
        let message = format!(
            "makes {count} phases with those of shells; a specimen has at most {} of its own",
            PhaseNames::MOST
        );
        return Err(SpecError::value("phases", message));
    }
    for (number, phase) in phases.iter().enumerate() {
        name("phases.name", &phase.name)?;
        if phases[..number].iter().any(|other| other.name == phase.name) {
            let message = format!("is {:?}; another entry has this name, and every phase has one entry", phase.name);
            return Err(SpecError::value("phases.name", message));
        }
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

/// A word that names no other phase, set or key.
fn name(key: &str, name: &str) -> Checked {
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let begins = name.starts_with(|c: char| c.is_ascii_lowercase());
    let wrong = if !begins || name.len() > LONGEST || !name.chars().all(is_word) {
        format!("it takes lower-case letters, digits and _, a letter first, at most {LONGEST} of them: \"limestone\"")
    } else if TAKEN.contains(&name) {
        "this name has a meaning of its own; take another, such as \"limestone\"".to_owned()
    } else if let Some(known) = alike(name, &TAKEN) {
        format!("it begins like {known}, for which its values would be taken; take another, such as \"old_{known}\"")
    } else {
        return Ok(());
    };
    Err(SpecError::value(key, format!("is {name:?}; {wrong}")))
}

/// Checks `[[shape.shells]]`: each entry alone, then those of all grains of a phase together.
pub(super) fn check_shells(spec: &Spec) -> Checked {
    let Spec { shape, phases, .. } = spec;
    if shape.shells.is_empty() {
        return Ok(());
    }
    for shell in &shape.shells {
        name("shape.shells.name", &shell.name)?;
        law(shell)?;
        if shell.outward && (!shape.has_exact_cores() || shell.volume_share.is_some()) {
            let message = format!(
                "of {} needs thickness_mm, size_share or thickness_over_size_mm, and convex polyhedra or spheres; without \
                 it, sizes are those of grains with the shell",
                shell.name
            );
            return Err(SpecError::value("shape.shells.outward", message));
        }
        if let Some(of) = shell.of.as_ref().filter(|of| phases.iter().all(|phase| phase.name != **of)) {
            let message =
                format!("of {} is {of:?}; it must be the name of an entry of [[phases]], or be left out", shell.name);
            return Err(SpecError::value("shape.shells.of", message));
        }
    }
    for own in std::iter::once(None).chain((0..phases.len() as u8).map(Some)) {
        together(spec, own)?;
    }
    Ok(())
}

/// Thickness of a shell over the size of its grain: half of it leaves nothing inside.
const SIZE_SHARES: [f64; 2] = [1e-4, 0.5];

fn law(shell: &ShellLaw) -> Checked {
    const KEY: &str = "shape.shells.thickness_mm";
    const SHARE: &str = "shape.shells.size_share";
    const ROWS: &str = "shape.shells.thickness_over_size_mm";
    match shell.thickness() {
        Some(Thickness::Drawn(limits)) => {
            limits.iter().try_for_each(|&mm| length(KEY, mm))?;
            in_order(KEY, limits)
        }
        Some(Thickness::SizeShare(limits)) => {
            let [least, most] = SIZE_SHARES;
            limits.iter().try_for_each(|&share| within(SHARE, share, least, most))?;
            in_order(SHARE, limits)
        }
        Some(Thickness::OverSize(rows)) => {
            if rows.is_empty() {
                let message = "has no rows; give sizes and thicknesses, as [[5, 0.2], [20, 0.5]]";
                return Err(SpecError::value(ROWS, message));
            }
            rows.iter().flatten().try_for_each(|&mm| length(ROWS, mm))?;
            ascending(ROWS, "sizes", &rows.iter().map(|[size, _]| *size).collect::<Vec<_>>())
        }
        Some(Thickness::VolumeShare(share)) if share > 0.0 && share < 1.0 => Ok(()),
        Some(Thickness::VolumeShare(share)) => {
            let accepted = "the accepted range is above 0 and below 1 (volume over the grain's within its ITZ)";
            let message = format!("of {} is {}; {accepted}", shell.name, number(share));
            Err(SpecError::value("shape.shells.volume_share", message))
        }
        None => {
            let message = format!(
                "give {} none or several thicknesses; give one of thickness_mm, size_share, thickness_over_size_mm and \
                 volume_share",
                shell.name
            );
            Err(SpecError::value("shape.shells", message))
        }
    }
}

/// ITZ and shells of grains of a phase leave a core in grains of every size.
///
/// From row to row of a law they take a + b ln(d) + c d of a grain of the size d, which comes nearest to d / 2 at the ends or
/// at d = b / (1/2 - c).
fn together(spec: &Spec, own: Option<u8>) -> Checked {
    let laws = spec.shells_of(own);
    if let Some(pair) = laws.windows(2).find(|pair| !pair[0].1.outward && pair[1].1.outward) {
        let message = format!("of {} follows a shell within the stone; outward ones come first", pair[1].1.name);
        return Err(SpecError::value("shape.shells.outward", message));
    }
    let (coating, laws): (Vec<_>, Vec<_>) = laws.into_iter().partition(|(_, law)| law.outward);
    let itz_mm = if coating.is_empty() { spec.itz.thickness_mm[1] } else { 0.0 };
    let shares: f64 = laws.iter().filter_map(|(_, law)| law.volume_share).sum();
    if exceeds(shares, 1.0 - SHARE_ROUNDING) {
        let message = format!("of all shells of a grain add up to {}; below 1 a core is left", number(short(shares)));
        return Err(SpecError::value("shape.shells.volume_share", message));
    }
    let sizes = own.and_then(|own| spec.phases.get(usize::from(own))).and_then(|phase| phase.sizes_mm);
    let [smallest, largest] = sizes.unwrap_or([spec.grading.d_min_mm, spec.grading.d_max_mm]);
    let rows = laws.iter().filter_map(|(_, law)| law.thickness_over_size_mm.as_ref()).flatten().map(|[size, _]| *size);
    let c: f64 = laws.iter().filter_map(|(_, law)| law.size_share).map(|[_, high]| high).sum();
    let all = |size: f64| {
        let shells: f64 = laws.iter().filter_map(|(_, law)| law.limits_mm(size)).map(|[_, high]| high).sum();
        if shells > 0.0 { itz_mm + shells } else { 0.0 }
    };
    let mut sizes = vec![smallest, largest];
    sizes.extend(rows.filter(|size| smallest < *size && *size < largest));
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    let between = |ends: &[f64]| {
        let (low, high) = (ends[0], ends[1]);
        let b = (all(high) - all(low) - c * (high - low)) / libm::log(high / low);
        [low, (b / (0.5 - c)).clamp(low, high), high]
    };
    let sizes = sizes.windows(2).flat_map(between);
    let Some(size) = sizes.into_iter().find(|size| (2.0 * all(*size)).partial_cmp(size) != Some(Ordering::Less)) else {
        return Ok(());
    };
    let message = format!(
        "reaches {} with the ITZ, but {} of these grains is {} thick at most; stay below {} in all, give \
         volume_share, or give the shells to a phase of larger sizes_mm",
        number(short(all(size))),
        if size == smallest { "the smallest" } else { "one" },
        number(short(size)),
        number(short(size / 2.0))
    );
    Err(SpecError::value("shape.shells", message))
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
