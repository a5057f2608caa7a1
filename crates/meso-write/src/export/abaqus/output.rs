//! Output of an explicit deck: fields at some frames, histories of plates and energies, states to restart from.

use super::geometry::present;
use super::lines::real;
use super::{DeckOptions, LAW};
use crate::export::lines::Lines;
use meso_mesh::cells::{Mesh, Phase};
use std::io::{self, Write};

/// Rows of history output in a step.
pub(super) const HISTORY: f64 = 500.0;
/// Frames of stresses and strains.
const STRESS_FRAMES: u32 = 5;

/// States from which a job of days goes on after it was killed.
pub(super) fn restart(lines: &mut Lines<impl Write>) -> io::Result<()> {
    lines.line("*RESTART, WRITE, NUMBER INTERVAL=4")
}

/// Damage and displacements at every frame; stresses and strains, most of the size, at few.
pub(super) fn fields(lines: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions) -> io::Result<()> {
    let frames = options.field_frames();
    lines.line(format!("*OUTPUT, FIELD, NUMBER INTERVAL={frames}"))?;
    lines.line("*NODE OUTPUT")?;
    lines.line("U")?;
    for phase in present(mesh).filter(|phase| options.materials.strength(*phase, &mesh.phases, LAW).is_some()) {
        element_output(lines, mesh, phase, "PEEQ, PEEQT, DAMAGEC, DAMAGET, SDEG")?;
    }
    if !mesh.cohesive.is_empty() {
        element_output(lines, mesh, Phase::Itz, "S, LE, SDEG, QUADSCRT, STATUS")?;
    }
    lines.line(format!("*OUTPUT, FIELD, NUMBER INTERVAL={}", frames.min(STRESS_FRAMES)))?;
    for phase in present(mesh) {
        let plastic = if options.materials.strength(phase, &mesh.phases, LAW).is_some() { ", PE" } else { "" };
        element_output(lines, mesh, phase, &format!("S, LE{plastic}"))?;
    }
    Ok(())
}

fn element_output(lines: &mut Lines<impl Write>, mesh: &Mesh, phase: Phase, variables: &str) -> io::Result<()> {
    lines.line(format!("*ELEMENT OUTPUT, ELSET={}", mesh.phases.set_name(phase)))?;
    lines.line(variables)
}

/// Forces and displacements of the plates, filtered since contact forces alias; energies; the increments and the mass that
/// scaling adds. `plates` are sets of reference nodes, each with the degree of freedom along its axis.
pub(super) fn history(
    lines: &mut Lines<impl Write>,
    plates: impl Iterator<Item = (String, usize)>,
    interval: f64,
) -> io::Result<()> {
    let interval = real(interval);
    lines.line(format!("*OUTPUT, HISTORY, TIME INTERVAL={interval}, FILTER=ANTIALIASING"))?;
    for (set, dof) in plates {
        lines.line(format!("*NODE OUTPUT, NSET={set}"))?;
        lines.line(format!("U{dof}, RF{dof}"))?;
    }
    lines.line(format!("*OUTPUT, HISTORY, TIME INTERVAL={interval}"))?;
    lines.line("*ENERGY OUTPUT")?;
    lines.line("ALLIE, ALLKE, ALLWK, ALLSE, ALLPD, ALLDMD, ALLFD, ALLAE, ALLVD, ALLMW, ETOTAL")?;
    lines.line("*INCREMENTATION OUTPUT")?;
    lines.line("DT, DMASS")
}
