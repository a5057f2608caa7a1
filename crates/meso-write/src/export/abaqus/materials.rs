//! Materials under the names of the phases, and the sections that give them to the element sets.

use super::damage::{self, Band, Row};
use super::geometry::present;
use super::limits;
use super::lines::real;
use super::{DeckOptions, LAW};
use crate::export::lines::Lines;
use meso_concrete::OutOfRange;
use meso_mesh::cells::{Mesh, Phase};
use meso_mesh::figures::PhaseVolumes;
use meso_mesh::materials::{Elastic, Materials, Plasticity, Strength, characteristic_mm, width_mm};
use std::io::{self, Write};

/// Material and section of every phase the mesh has, and of the cohesive elements.
pub(super) fn write(lines: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions) -> io::Result<()> {
    let materials = &options.materials.in_mesh(mesh);
    lines.line("** Material values are illustrative unless they were given: MPa, tonne/mm3")?;
    for phase in present(mesh) {
        elastic(lines, &mesh.phases.set_name(phase), &materials.elastic(phase, &mesh.phases))?;
        if let Some(strains) = options.loads.as_ref().and_then(|loads| loads.strains) {
            lines.line("*EXPANSION, ZERO=0.0")?;
            lines.line(format!(
                "{},",
                real(strains[if phase.is_aggregate() { Phase::Aggregate } else { phase }.index()])
            ))?;
        }
        if let (true, Some(strength)) = (options.damages(), materials.strength(phase, &mesh.phases, LAW)) {
            plasticity(
                lines,
                &materials.elastic(phase, &mesh.phases),
                &strength,
                (&materials.plasticity, crack_band(mesh)),
            )?;
        }
    }
    if !mesh.cohesive.is_empty() {
        cohesive(lines, materials, options.damages())?;
    }
    for phase in present(mesh) {
        lines.line(format!("*SOLID SECTION, ELSET={0}, MATERIAL={0}", mesh.phases.set_name(phase)))?;
    }
    if mesh.cohesive.is_empty() {
        return Ok(());
    }
    let section = "*COHESIVE SECTION, ELSET=ITZ, MATERIAL=ITZ, RESPONSE=TRACTION SEPARATION";
    if options.damages() {
        // Faces that have parted bear compression still: Abaqus would delete their elements, and nothing would hold them apart.
        lines.line("*SECTION CONTROLS, NAME=ITZ, ELEMENT DELETION=NO, MAX DEGRADATION=1.0")?;
        lines.line(section.to_owned() + ",")?;
        lines.line("CONTROLS=ITZ")?;
    } else {
        lines.line(section)?;
    }
    // A constitutive thickness of 1: separations are strains, and the density is per area.
    lines.line("1.0,")
}

/// Finds out whether Abaqus takes the curves of every phase in the elements it has.
pub(super) fn check(mesh: &Mesh, materials: &Materials) -> Result<(), OutOfRange> {
    let mut strong = present(mesh).filter(|&phase| materials.strength(phase, &mesh.phases, LAW).is_some());
    let materials = materials.in_mesh(mesh);
    let opening = crack_band(mesh).opening;
    strong.try_for_each(|phase| limits::curves(&materials, (phase, &mesh.phases), opening))
}

/// Warns of crack bands so wide that they dissipate more crushing energy than was asked for.
pub(super) fn band_doubt(mesh: &Mesh, materials: &Materials) -> Option<String> {
    let width = crack_band(mesh).width_mm;
    let widest = damage::widest_mm(&materials.mortar, &materials.mortar_strength.of(LAW));
    (width > widest).then(|| {
        format!(
            "elements too large for this crushing energy: crack bands of {width:.2} mm, limit {widest:.2} mm. Dissipation will be \
             too high. Use smaller elements, or a larger materials.mortar_strength.crushing_energy_n_per_mm"
        )
    })
}

fn elastic(lines: &mut Lines<impl Write>, name: &str, elastic: &Elastic) -> io::Result<()> {
    lines.line(format!("*MATERIAL, NAME={name}"))?;
    lines.line("*DENSITY")?;
    lines.line(format!("{},", real(elastic.density_t_per_mm3)))?;
    lines.line("*ELASTIC")?;
    lines.line(format!("{}, {}", real(elastic.youngs_modulus_mpa), real(elastic.poisson_ratio)))
}

/// Crack band of the mortar's mean element: one curve serves all elements.
///
/// The ITZ's curve takes it, too: over the width of its own thin cells it would be tougher than mortar.
pub(super) fn crack_band(mesh: &Mesh) -> Band {
    let volumes = PhaseVolumes::of_mesh(mesh);
    let smeared = mesh.has_smeared_itz();
    let is_mortar = |phase: &Phase| *phase == Phase::Mortar || *phase == Phase::Itz && smeared;
    let mortar = mesh.phase.iter().filter(|phase| is_mortar(phase)).count();
    // A mesh of ITZ and aggregates alone has its own cells' width.
    let (volume, cells) = match mortar {
        0 => (volumes.total(), mesh.cell_count()),
        cells if smeared => (volumes.mortar + volumes.itz, cells),
        cells => (volumes.mortar, cells),
    };
    let mean = volume / cells as f64;
    let width_mm = width_mm(mesh, mean);
    Band { width_mm, opening: characteristic_mm(mesh.kind, mean) / width_mm }
}

fn plasticity(
    lines: &mut Lines<impl Write>,
    elastic: &Elastic,
    strength: &Strength,
    (p, band): (&Plasticity, Band),
) -> io::Result<()> {
    let values = [p.dilation_angle_deg, p.eccentricity, p.biaxial_ratio, p.meridian_ratio, p.viscosity_s];
    lines.line("*CONCRETE DAMAGED PLASTICITY")?;
    lines.line(values.map(real).join(", "))?;
    let (compression, tension) =
        (damage::compression(elastic, strength, band.width_mm), damage::tension(strength, band.opening));
    lines.line("*CONCRETE COMPRESSION HARDENING")?;
    curve(lines, &compression, |row| row.stress)?;
    lines.line("*CONCRETE TENSION STIFFENING, TYPE=DISPLACEMENT")?;
    curve(lines, &tension, |row| row.stress)?;
    lines.line("*CONCRETE COMPRESSION DAMAGE")?;
    curve(lines, &compression, |row| row.damage)?;
    lines.line("*CONCRETE TENSION DAMAGE, TYPE=DISPLACEMENT")?;
    curve(lines, &tension, |row| row.damage)
}

fn curve(lines: &mut Lines<impl Write>, rows: &[Row], value: impl Fn(&Row) -> f64) -> io::Result<()> {
    rows.iter().try_for_each(|row| lines.line(format!("{:.6e}, {:.6e}", value(row), row.inelastic)))
}

/// Traction-separation: stiffness E / t; with damage a quadratic stress criterion and linear softening by the
/// fracture energy, between that of opening and that of sliding after Benzeggagh and Kenane.
fn cohesive(lines: &mut Lines<impl Write>, materials: &Materials, damages: bool) -> io::Result<()> {
    let (itz, t) = (&materials.itz, materials.cohesive_thickness_mm);
    let stiffness = materials.separation_stiffness();
    let strength = materials.itz_strength(LAW);
    let cohesion = strength.cohesion_mpa();
    lines.line("*MATERIAL, NAME=ITZ")?;
    lines.line("*DENSITY")?;
    lines.line(format!("{},", real(itz.density_t_per_mm3 * t)))?;
    lines.line("*ELASTIC, TYPE=TRACTION")?;
    lines.line(format!("{stiffness:.6e}, {stiffness:.6e}, {stiffness:.6e}"))?;
    if !damages {
        return Ok(());
    }
    lines.line("*DAMAGE INITIATION, CRITERION=QUADS")?;
    lines.line(format!("{:.6e}, {cohesion:.6e}, {cohesion:.6e}", strength.tensile_mpa))?;
    let power = real(materials.cohesive_mode_power);
    lines.line(format!("*DAMAGE EVOLUTION, TYPE=ENERGY, MIXED MODE BEHAVIOR=BK, POWER={power}"))?;
    let opening = strength.fracture_energy_n_per_mm;
    let sliding = materials.cohesive_shear_energy_ratio * opening;
    lines.line(format!("{opening:.6e}, {sliding:.6e}, {sliding:.6e}"))
}
