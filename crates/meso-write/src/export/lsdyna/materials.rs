//! Parts, sections and materials of a `.k`.

use super::loading::Block;
use super::{Field, LsdynaLaw, block_parts, card, formulation, part, present};
use crate::export::abaqus::{DECK, DeckOptions};
use crate::export::lines::Lines;
use meso_concrete::OutOfRange;
use meso_mesh::cells::{CellKind, Mesh, Phase};
use meso_mesh::figures::PhaseVolumes;
use meso_mesh::materials::{Elastic, LawName, Materials, Strength, characteristic_mm, width_mm};
use std::io::{self, Write};

/// CDPM2's parameters that `[materials]` has no word for (Grassl et al. 2013, Sec. 4): q_h0, H_p, A_h to D_h, A_s, D_f.
const CDPM: [f64; 8] = [0.3, 0.01, 0.08, 0.003, 2.0, 1e-6, 15.0, 0.85];
/// Area of the bilinear crack law over w_f f_t, with its kink at 0.15 w_f and 0.3 f_t.
const CRACK_AREA: f64 = 0.225;
/// Inches in a millimetre, and psi in an MPa, for `*MAT_072R3`.
const REL3_UNITS: [f64; 2] = [0.039_37, 145.037_7];
/// Largest grain of mortar, mm; `LOCWIDTH` of `*MAT_072R3` is three times that.
const SAND_MM: f64 = 4.0;
/// The law of the solver whose values a deck has.
const LAW: LawName = LawName::Cdpm2;
/// Least largest aggregate that `*MAT_159` was calibrated for, mm.
const CSCM_AGGREGATE_MM: f64 = 8.0;
/// Strengths that `*MAT_159` was calibrated for, MPa (FHWA-HRT-05-062, chapter 3).
const CSCM_MPA: [f64; 2] = [20.0, 58.0];
/// Steel of the plates.
const STEEL: Elastic = Elastic { youngs_modulus_mpa: 210_000.0, poisson_ratio: 0.3, density_t_per_mm3: 7.85e-9 };

/// Refuses strengths outside the calibration of a law that generates its parameters.
pub(super) fn check(options: &DeckOptions) -> Result<(), OutOfRange> {
    if options.lsdyna_law != LsdynaLaw::Cscm {
        return Ok(());
    }
    let [low, high] = CSCM_MPA;
    let names = options.materials.own_phases();
    for phase in [Phase::Mortar, Phase::Itz].into_iter().chain(names.own()) {
        let strength = options.materials.strength(phase, &names, LAW).map_or(low, |strength| strength.compressive_mpa);
        if strength < low || strength > high {
            let accepted = format!(
                "*MAT_159 generates parameters for {low} to {high} MPa, and {} has {strength} MPa; take cdpm or rel3",
                names.set_name(phase)
            );
            return Err(DECK.error("lsdyna_law", "cscm", accepted));
        }
    }
    Ok(())
}

/// Part, section and material of every phase, and of the plates.
pub(super) fn write(
    cards: &mut Lines<impl Write>,
    mesh: &Mesh,
    options: &DeckOptions,
    blocks: &[Block],
) -> io::Result<()> {
    let materials = options.materials.in_mesh(mesh);
    let is_solid = |phase: Phase| phase != Phase::Itz || mesh.cohesive.is_empty();
    for phase in present(mesh) {
        one_part(cards, &mesh.phases.set_name(phase), part(phase))?;
        let own = if is_solid(phase) { formulation(mesh.kind, options.reduced_integration) } else { joint(mesh.kind) };
        section(cards, part(phase), own)?;
        match materials.strength(phase, &mesh.phases, LAW).filter(|_| options.has_curves()) {
            _ if !is_solid(phase) => cohesive(cards, &materials, options.has_curves())?,
            Some(strength) => strong(cards, phase, &materials, &strength, mesh, options)?,
            None => elastic(cards, part(phase), &materials.elastic(phase, &mesh.phases))?,
        }
    }
    if options.reduced_integration && mesh.kind == CellKind::Hexahedron {
        // IHQ QH: bricks of one point resist their modes by a stiffness, as those of the engine do.
        cards.line("*CONTROL_HOURGLASS")?;
        card(cards, &[Field::Integer(4), HOURGLASS.into()])?;
    }
    plates(cards, blocks)
}

/// Stiffness of hourglass modes over that of the element.
const HOURGLASS: f64 = 0.03;

fn one_part(cards: &mut Lines<impl Write>, name: &str, number: u64) -> io::Result<()> {
    cards.line("*PART")?;
    cards.line(name)?;
    card(cards, &[number.into(), number.into(), number.into()])
}

fn section(cards: &mut Lines<impl Write>, number: u64, elform: i64) -> io::Result<()> {
    cards.line("*SECTION_SOLID")?;
    card(cards, &[number.into(), Field::Integer(elform)])
}

/// Formulation of cohesive elements: hexahedra of 8, or wedges of 6 nodes.
fn joint(kind: CellKind) -> i64 {
    if kind == CellKind::Hexahedron { 19 } else { 21 }
}

fn elastic(cards: &mut Lines<impl Write>, number: u64, values: &Elastic) -> io::Result<()> {
    let Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 } = *values;
    cards.line("*MAT_ELASTIC")?;
    card(cards, &[number.into(), density_t_per_mm3.into(), youngs_modulus_mpa.into(), poisson_ratio.into()])
}

fn strong(
    cards: &mut Lines<impl Write>,
    phase: Phase,
    materials: &Materials,
    strength: &Strength,
    mesh: &Mesh,
    options: &DeckOptions,
) -> io::Result<()> {
    let values = &materials.elastic(phase, &mesh.phases);
    match options.lsdyna_law {
        LsdynaLaw::Cdpm => {
            let band = CrackWidths::of(mesh);
            cdpm(cards, part(phase), values, &Cdpm::of(strength, materials.plasticity.biaxial_ratio, band))
        }
        LsdynaLaw::Rel3 => rel3(cards, part(phase), values, strength),
        LsdynaLaw::Cscm => cscm(cards, part(phase), values, strength),
    }
}

/// Widths over which a crack is spread: our band's, and the cube root of an element's volume.
#[derive(Clone, Copy)]
struct CrackWidths {
    width_mm: f64,
    characteristic_mm: f64,
}

impl CrackWidths {
    /// The band of the mortar's mean element, which the ITZ shares.
    fn of(mesh: &Mesh) -> Self {
        let volumes = PhaseVolumes::of_mesh(mesh);
        let smeared = mesh.has_smeared_itz();
        let is_mortar = |phase: &&Phase| **phase == Phase::Mortar || smeared && **phase == Phase::Itz;
        let cells = mesh.phase.iter().filter(is_mortar).count();
        let mean = match cells {
            0 => volumes.total() / mesh.cell_count() as f64,
            _ => (volumes.mortar + if smeared { volumes.itz } else { 0.0 }) / cells as f64,
        };
        Self { width_mm: width_mm(mesh, mean), characteristic_mm: characteristic_mm(mesh.kind, mean) }
    }
}

/// Values of `*MAT_273` that follow from strengths and energies, by the mapping of the law `cdpm2`.
struct Cdpm {
    eccentricity: f64,
    tensile: f64,
    compressive: f64,
    /// w_f, mm, for the cube root of an element's volume.
    opening: f64,
    /// e_fc of compressive softening.
    crushing: f64,
}

impl Cdpm {
    fn of(strength: &Strength, biaxial_ratio: f64, band: CrackWidths) -> Self {
        let (fc, ft) = (strength.compressive_mpa, strength.tensile_mpa);
        let fb = biaxial_ratio * fc;
        // Grassl et al. 2013, eq. 20.
        let share = ft * (fb * fb - fc * fc) / (fb * (fc * fc - ft * ft));
        let opening = strength.fracture_energy_n_per_mm / (CRACK_AREA * ft);
        let ductility = CDPM[6];
        Self {
            eccentricity: (1.0 + share) / (2.0 - share),
            tensile: ft,
            compressive: fc,
            opening: opening * band.characteristic_mm / band.width_mm,
            crushing: strength.crushing_energy_n_per_mm * ft / (band.width_mm * fc * fc * ductility),
        }
    }
}

/// MID RO E PR ECC QH0 FT FC, HP AH BH CH DH AS DF FC0, TYPE BS WF WF1 FT1 STRFLG FAILFLG EFC.
fn cdpm(cards: &mut Lines<impl Write>, number: u64, values: &Elastic, law: &Cdpm) -> io::Result<()> {
    let [qh0, hp, ah, bh, ch, dh, ductility, df] = CDPM;
    let Elastic { youngs_modulus_mpa: e, poisson_ratio: nu, density_t_per_mm3: rho } = *values;
    cards.line("*MAT_CDPM")?;
    let Cdpm { eccentricity, tensile, compressive, opening, crushing } = *law;
    let first = [rho, e, nu, eccentricity, qh0, tensile, compressive].map(Field::Real);
    card(cards, &[&[number.into()][..], &first].concat())?;
    card(cards, &[hp, ah, bh, ch, dh, ductility, df].map(Field::Real))?;
    card(cards, &[1.0, 1.0, opening, 0.15 * opening, 0.3 * tensile, 0.0, 0.0, crushing].map(Field::Real))
}

/// The cards of `*MAT_072R3`, of which the negative A0 asks for generated parameters; the others stay blank.
fn rel3(cards: &mut Lines<impl Write>, number: u64, values: &Elastic, strength: &Strength) -> io::Result<()> {
    let [rsize, ucf] = REL3_UNITS;
    cards.line("*MAT_CONCRETE_DAMAGE_REL3")?;
    card(cards, &[number.into(), values.density_t_per_mm3.into(), values.poisson_ratio.into()])?;
    card(cards, &[strength.tensile_mpa.into(), (-strength.compressive_mpa).into()])?;
    let blank = Field::Blank;
    card(cards, &[blank, blank, blank, rsize.into(), ucf.into(), blank, (3.0 * SAND_MM).into(), blank])?;
    (0..4).try_for_each(|_| card(cards, &[blank; 8]))
}

/// The cards of `*MAT_159` with generated parameters: units of MPa, mm, s, tonne, N have the number 2; no erosion.
fn cscm(cards: &mut Lines<impl Write>, number: u64, values: &Elastic, strength: &Strength) -> io::Result<()> {
    cards.line("*MAT_CSCM_CONCRETE")?;
    let [plot, rates] = [1, 0].map(Field::Integer);
    let [step, erode, recover] = [0.0, 0.0, 0.0].map(Field::Real);
    card(
        cards,
        &[number.into(), values.density_t_per_mm3.into(), plot, step, rates, erode, recover, Field::Integer(0)],
    )?;
    card(cards, &[0.0.into()])?;
    card(cards, &[strength.compressive_mpa.into(), CSCM_AGGREGATE_MM.into(), Field::Integer(2)])
}

/// `*MAT_COHESIVE_MIXED_MODE` (138): MID RO ROFLG INTFAIL EN ET GIC GIIC, XMU T S UND UTD GAMMA.
///
/// The density is per area (ROFLG 1), as elements have no volume; no element is deleted (INTFAIL 0), so that debonded faces
/// carry compression. A negative XMU takes the law of Benzeggagh and Kenane. Without strength the interface stays elastic.
fn cohesive(cards: &mut Lines<impl Write>, materials: &Materials, is_strong: bool) -> io::Result<()> {
    let stiffness = materials.separation_stiffness();
    let density = materials.itz.density_t_per_mm3 * materials.cohesive_thickness_mm;
    let head = [part(Phase::Itz).into(), Field::Real(density), Field::Integer(1), Field::Integer(0)];
    if !is_strong {
        // *MAT_COHESIVE_ELASTIC (184): MID RO ROFLG INTFAIL ET EN FN_FAIL.
        cards.line("*MAT_COHESIVE_ELASTIC")?;
        return card(cards, &[&head[..], &[stiffness, stiffness].map(Field::Real)].concat());
    }
    let strength = materials.itz_strength(LAW);
    let opening = strength.fracture_energy_n_per_mm;
    let sliding = materials.cohesive_shear_energy_ratio * opening;
    cards.line("*MAT_COHESIVE_MIXED_MODE")?;
    card(cards, &[&head[..], &[stiffness, stiffness, opening, sliding].map(Field::Real)].concat())?;
    let (power, tensile, shear) = (-materials.cohesive_mode_power, strength.tensile_mpa, strength.cohesion_mpa());
    card(cards, &[power, tensile, shear].map(Field::Real))
}

/// Plates of steel: each is held, or moves along one axis, and turns about none.
fn plates(cards: &mut Lines<impl Write>, blocks: &[Block]) -> io::Result<()> {
    for (Block { name, held, density, .. }, number) in blocks.iter().zip(block_parts(blocks)) {
        one_part(cards, name, number)?;
        section(cards, number, 1)?;
        let Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 } = STEEL;
        cards.line("*MAT_RIGID")?;
        let density = density.unwrap_or(density_t_per_mm3);
        card(cards, &[number.into(), density.into(), youngs_modulus_mpa.into(), poisson_ratio.into()])?;
        card(cards, &[Field::Real(1.0), Field::Integer(*held), Field::Integer(7)])?;
        card(cards, &[Field::Blank])?;
    }
    Ok(())
}
