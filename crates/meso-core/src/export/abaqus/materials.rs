//! Materials under the names of the phases, and the sections that give them to the element sets.

use super::geometry::present;
use super::lines::Lines;
use crate::materials::Materials;
use crate::mesh::{Mesh, Phase};
use std::io::{self, Write};

/// Density, elasticity and section of every phase the mesh has.
pub(super) fn write(lines: &mut Lines<impl Write>, mesh: &Mesh, materials: &Materials) -> io::Result<()> {
    lines.line("** Material values are illustrative unless they were given: MPa, tonne/mm3")?;
    for phase in present(mesh) {
        let elastic = materials.elastic(phase);
        lines.line(format!("*MATERIAL, NAME={}", phase.name()))?;
        lines.line("*DENSITY")?;
        lines.line(format!("{:e},", elastic.density_t_per_mm3))?;
        lines.line("*ELASTIC")?;
        lines.line(format!("{}, {}", elastic.youngs_modulus_mpa, elastic.poisson_ratio))?;
    }
    present(mesh).try_for_each(|phase| section(lines, phase))
}

fn section(lines: &mut Lines<impl Write>, phase: Phase) -> io::Result<()> {
    lines.line(format!("*SOLID SECTION, ELSET={0}, MATERIAL={0}", phase.name()))
}
