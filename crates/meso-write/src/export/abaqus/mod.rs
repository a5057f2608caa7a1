//! Abaqus input decks (`.inp`): flat, streamed, read by Abaqus, CalculiX and meshio.
//!
//! gmsh writes such decks but has no reader for them (none in 4.15); `.msh` is for gmsh.
//!
//! Element sets, node sets, surfaces and materials have the names AGGREGATE, ITZ, MORTAR (and FIBRE, where there are
//! fibres), XMIN to ZMAX and S_XMIN to S_ZMAX. Node and element numbers are the mesh's indices plus 1. The rules kept throughout: keyword lines under 80
//! characters, data lines of at most 16 entries and 256 characters, numbers of at most 20.

mod at_rest;
mod damage;
mod elastic;
mod geometry;
mod limits;
pub(super) mod lines;
mod materials;
mod output;
mod periodic;
pub(super) mod supports;

use crate::export::lines::Lines;
pub(crate) use limits::DECK;
use meso_concrete::specimen::Specimen;
use meso_concrete::{OutOfRange, PhaseNames, exceeds, thousands};
use meso_mesh::cells::Sides;
use meso_mesh::cells::{Mesh, Phase};
use meso_mesh::figures::{MassScaling, PhaseVolumes};
use meso_mesh::materials::{LawName, Materials, Strength};
use meso_trial::{Loads, Sample, Test, TestKind, TrialError, word};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
pub(crate) use supports::{inward, names as support_names};

/// The law of the solver whose values a deck has.
const LAW: LawName = LawName::Cdp;

/// Content of a deck besides the mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct DeckOptions {
    /// Only nodes, elements, sets and surfaces, for *INCLUDE
    pub geometry_only: bool,
    /// Hexahedra with reduced integration (C3D8R)
    pub reduced_integration: bool,
    /// Tie opposite faces of a periodic box by *EQUATION; REF_X, REF_Y and REF_Z take the mean strain
    pub periodic_equations: bool,
    /// The analysis the deck runs, or the test; `geometry_only` leaves it out.
    pub analysis: Analysis,
    /// Strain at the end of the analysis, a positive number [default: the test's own, 0.001 elastic]
    pub strain: Option<f64>,
    /// Friction between plates and specimen [default: the test's own, 0.1 under a striker]
    pub friction: Option<f64>,
    /// Time of the path, s [default: the test's own, as in `solve`; 0.02 under a striker]
    pub duration_s: Option<f64>,
    /// Time increment that mass scaling keeps, s [default: the test's own, as in `solve`]
    pub time_increment_s: Option<f64>,
    /// Frames of field output [default: 50]
    pub frames: Option<u32>,
    /// Speed of the striker, mm/s [default: 5000]
    pub impact_speed_mm_per_s: Option<f64>,
    /// Supports and loads of the test on the mesh that is written: see [`load`](DeckOptions::load).
    #[serde(skip)]
    pub loads: Option<Loads>,
    /// Let aggregates that share nodes be crushed or torn: they make an elastic skeleton that never breaks.
    pub allow_joined: bool,
    /// Strength and damage of mortar and ITZ in a deck without an analysis, for steps of your own
    pub with_damage: bool,
    /// Material values.
    pub materials: Materials,
    /// Law of mortar and ITZ in a .k
    pub lsdyna_law: LsdynaLaw,
    /// Lines for `*HEADING`, e.g. the command and the seed: ASCII, none beginning with `*`; 76 characters of each are kept.
    pub heading: Vec<String>,
}

/// A specimen softens in its test where its mortar is at half its strength within so many times the test's strain: 0.048 at
/// 0.005. A cube of 24 mm in elements of 2 mm, where that is 0.03, is at 0.76 of its peak 0.07 mm beyond it, and tests at more.
const SOFTENS_WITHIN: f64 = 9.6;
/// How often the crushing energy is halved to find one that softens.
const HALVINGS: u32 = 10;

/// Analysis of a deck.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(from = "Word", into = "Word")]
pub enum Analysis {
    /// Nothing: mesh, materials and sections, ready for one's own steps.
    #[default]
    None,
    /// Linear elastic uniaxial compression by `*STATIC`; of the mean stress, where the box is periodic and its faces are
    /// tied.
    Elastic,
    /// A striker falls on the specimen, which stands on a plate; only in LS-DYNA decks.
    Striker,
    /// A test, named or of a file.
    Test(Box<Test>),
}

/// Names of the analyses that are no test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Plain {
    /// Mesh, materials and sections.
    None,
    /// Linear elastic uniaxial compression.
    Elastic,
    /// The fall of a striker.
    Striker,
}

/// The word for an analysis.
#[derive(Clone, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "it must be none, elastic, striker or the name of a test, such as compression")]
enum Word {
    Plain(Plain),
    Test(TestKind),
}

impl From<Plain> for Analysis {
    fn from(plain: Plain) -> Self {
        match plain {
            Plain::None => Self::None,
            Plain::Elastic => Self::Elastic,
            Plain::Striker => Self::Striker,
        }
    }
}

impl From<TestKind> for Analysis {
    fn from(kind: TestKind) -> Self {
        Test { kind, ..Test::default() }.into()
    }
}

impl From<Test> for Analysis {
    fn from(test: Test) -> Self {
        Self::Test(Box::new(test))
    }
}

impl From<Word> for Analysis {
    fn from(word: Word) -> Self {
        match word {
            Word::Plain(plain) => plain.into(),
            Word::Test(kind) => kind.into(),
        }
    }
}

impl From<Analysis> for Word {
    fn from(analysis: Analysis) -> Self {
        match analysis {
            Analysis::None => Self::Plain(Plain::None),
            Analysis::Elastic => Self::Plain(Plain::Elastic),
            Analysis::Striker => Self::Plain(Plain::Striker),
            Analysis::Test(test) => Self::Test(test.kind),
        }
    }
}

/// Law of mortar and ITZ in an LS-DYNA deck.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LsdynaLaw {
    /// `*MAT_CDPM` (273): damage plasticity of Grassl et al., with the values of the law `cdpm2`.
    #[default]
    Cdpm,
    /// `*MAT_CONCRETE_DAMAGE_REL3` (072R3): Karagozian and Case, its parameters generated from the strength.
    Rel3,
    /// `*MAT_CSCM_CONCRETE` (159): continuous surface cap, its parameters generated from the strength.
    Cscm,
}

impl Analysis {
    /// Whether the analysis is explicit dynamics, with damage.
    pub fn is_explicit(&self) -> bool {
        match self {
            Self::None | Self::Elastic => false,
            Self::Striker => true,
            Self::Test(test) => test.law != LawName::Elastic,
        }
    }

    /// The word that a user has for it.
    pub fn word(&self) -> String {
        word(&Word::from(self.clone()))
    }
}

/// Strain at the end of the analysis `elastic`.
const ELASTIC_STRAIN: f64 = 0.001;
/// Friction, duration and speed of a striker.
const IMPACT_FRICTION: f64 = 0.1;
const IMPACT_S: f64 = 0.02;
const IMPACT_MM_PER_S: f64 = 5000.0;
/// Frames of field output.
const FRAMES: u32 = 50;
/// Time increment whose mass scaling a report gives where no test has one, s.
const REPORTED_S: f64 = 5e-7;

impl DeckOptions {
    /// The test of the deck, with the values that are laid over its own; none of an analysis.
    pub fn test(&self) -> Option<Test> {
        let Analysis::Test(test) = &self.analysis else { return None };
        Some(Test {
            friction: self.friction.or(test.friction),
            strain: self.strain.or(test.strain),
            duration_s: self.duration_s.or(test.duration_s),
            time_step_s: self.time_increment_s.or(test.time_step_s),
            ..(**test).clone()
        })
    }

    /// Puts the supports and loads of the test on the mesh of `sample` into the deck.
    ///
    /// # Errors
    /// See [`Test::loads`].
    pub fn load(&mut self, sample: &Sample) -> Result<(), TrialError> {
        let test = self.test().filter(|_| !self.geometry_only);
        self.loads = test.map(|test| test.loads(sample)).transpose()?;
        Ok(())
    }

    /// Finds out whether a deck can follow the test, whatever its specimen.
    ///
    /// # Errors
    /// See [`Test::validate`] and [`Test::suits_deck`].
    pub fn follows(&self) -> Result<(), TrialError> {
        let Some(test) = self.test().filter(|_| !self.geometry_only) else { return Ok(()) };
        test.validate()?;
        test.followed()
    }

    /// Finds out whether a specimen can have the test, and a deck its path, before there is a mesh.
    ///
    /// # Errors
    /// See [`Test::validate`] and [`Test::suits_deck`].
    pub fn suits(&self, specimen: &Specimen) -> Result<(), TrialError> {
        self.test().map_or(Ok(()), |test| {
            test.validate()?;
            test.suits_deck(specimen)
        })
    }

    /// Time increment that mass scaling keeps, s.
    pub fn mass_scaling_step_s(&self) -> f64 {
        let own = self.loads.as_ref().map(|loads| loads.time_increment_s);
        own.or(self.time_increment_s).unwrap_or(REPORTED_S)
    }

    /// Strain at the end of the analysis `elastic`, a positive number.
    pub(crate) fn elastic_strain(&self) -> f64 {
        self.strain.unwrap_or(ELASTIC_STRAIN)
    }

    /// Frames of field output.
    pub(crate) fn field_frames(&self) -> u32 {
        self.frames.unwrap_or(FRAMES)
    }

    /// Friction, duration in s and speed in mm/s of a striker.
    pub(crate) fn impact(&self) -> [f64; 3] {
        [
            self.friction.unwrap_or(IMPACT_FRICTION),
            self.duration_s.unwrap_or(IMPACT_S),
            self.impact_speed_mm_per_s.unwrap_or(IMPACT_MM_PER_S),
        ]
    }

    /// Whether a job of the deck gives a curve, which the script beside it writes down.
    pub fn has_curve(&self) -> bool {
        let has_path = if let Analysis::Test(test) = &self.analysis { test.has_path() } else { true };
        self.is_explicit() && !self.geometry_only && has_path
    }

    /// Whether the analysis is explicit dynamics, with damage.
    pub(crate) fn is_explicit(&self) -> bool {
        self.analysis.is_explicit()
    }

    /// Finds out whether `mesh` can be written as a deck with these options.
    ///
    /// # Errors
    /// Names the option, its value and the accepted range.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), OutOfRange> {
        self.validate_for(mesh.periodic)?;
        self.suits_phases(&mesh.phases)?;
        if self.has_curves() {
            materials::check(mesh, &self.materials)?;
        }
        if !mesh.cohesive.is_empty() {
            self.validate_cohesive()?;
        }
        let is_fast = self.loads.as_ref().is_some_and(Loads::is_fast);
        if (self.has_curve() || is_fast) && !self.allow_joined {
            refuse_joined(mesh, &self.analysis)?;
        }
        let has_test = matches!(self.analysis, Analysis::Test(_)) && !self.geometry_only;
        match &self.loads {
            Some(loads) => supports::check(loads)?,
            None if has_test => return Err(no_loads(&self.analysis)),
            None => {}
        }
        self.accept_mass(mesh)?;
        if self.periodic_equations { periodic::check(mesh) } else { Ok(()) }
    }

    /// Refuses a packing's own phases without values, and values without such a phase; geometry needs none.
    ///
    /// # Errors
    /// The first of them.
    pub fn suits_phases(&self, phases: &PhaseNames) -> Result<(), OutOfRange> {
        if self.geometry_only { Ok(()) } else { self.materials.suits(phases) }
    }

    /// Refuses options without effect on a deck of hexahedra, or of tetrahedra.
    ///
    /// # Errors
    /// Names the option, its value and whom it serves.
    pub fn validate_effects(&self, has_hexahedra: bool) -> Result<(), OutOfRange> {
        limits::effects(self, has_hexahedra)
    }

    /// Checks the values of cohesive elements before there is a mesh.
    ///
    /// # Errors
    /// Fails like [`validate`](Self::validate).
    pub fn validate_cohesive(&self) -> Result<(), OutOfRange> {
        if self.geometry_only { Ok(()) } else { limits::separation(&self.materials) }
    }

    /// The inelastic strain at which the deck's curve of mortar has come to half its strength; `None` where it has no curve.
    pub fn half_strength_strain(&self, mesh: &Mesh) -> Option<f64> {
        let strength = self.materials.mortar_strength.of(LAW);
        let width_mm = || materials::crack_band(mesh).width_mm;
        self.has_curves().then(|| damage::half_strength_strain(&self.materials.mortar, &strength, width_mm()))
    }

    /// Doubts about this deck of `mesh`, a sentence each. The deck can be written and run all the same.
    /// `exact` has the volumes of the packing's own phases, where known.
    pub fn doubts(&self, mesh: &Mesh, exact: Option<&PhaseVolumes>) -> Vec<String> {
        if self.analysis == Analysis::None || self.geometry_only {
            return Vec::new();
        }
        let softening = if self.has_curves() { materials::band_doubt(mesh, &self.materials) } else { None };
        let softening = softening.or_else(|| self.softening_doubt(mesh));
        let mass = self.mass_doubt(mesh);
        let strips = self.strips_doubt();
        let doubts = [joined_doubt(mesh), volume_doubt(mesh, exact), softening, self.bond_doubt(mesh), mass, strips];
        doubts.into_iter().flatten().collect()
    }

    /// The mass that an explicit step of this deck adds, if it has one.
    fn mass_scaling(&self, mesh: &Mesh) -> Option<MassScaling> {
        let loads = self.loads.as_ref().filter(|_| self.has_curve())?;
        Some(MassScaling::of(mesh, &self.materials, loads.time_increment_s))
    }

    /// Refuses a step whose mass scaling leaves nothing of the specimen's own inertia.
    fn accept_mass(&self, mesh: &Mesh) -> Result<(), OutOfRange> {
        let Some(scaling) = self.mass_scaling(mesh) else { return Ok(()) };
        let (step, times) = (scaling.time_step_s, scaling.factor);
        let accepted = || {
            let fits = scaling.step_for(mesh, &self.materials, MassScaling::LITTLE);
            format!(
                "such steps need {times:.0} times the mass: inertia would carry this test; take {fits:e} s, which adds at most \
                 20 %, or check the units of the materials"
            )
        };
        if times <= MassScaling::MOST {
            Ok(())
        } else {
            Err(DECK.error("time_increment_s", format!("{step:e}"), accepted()))
        }
    }

    fn mass_doubt(&self, mesh: &Mesh) -> Option<String> {
        let is_given = self.test().is_some_and(|test| test.time_step_s.is_some());
        let much = MassScaling::much(is_given);
        let scaling = self.mass_scaling(mesh).filter(|scaling| scaling.factor > much)?;
        let (step, times) = (scaling.time_step_s, scaling.factor);
        let fits = scaling.step_for(mesh, &self.materials, MassScaling::LITTLE);
        Some(format!(
            "steps of {step:e} s need {times:.1} times the mass, so look at the kinetic energy; a time increment of {fits:e} s adds \
             at most 20 %"
        ))
    }

    fn strips_doubt(&self) -> Option<String> {
        let Analysis::Test(test) = &self.analysis else { return None };
        let sticks = test.kind == TestKind::Splitting && test.law == LawName::Elastic && test.supports.is_empty();
        sticks.then(|| {
            "strips of an elastic deck hold the round side in all directions, whatever the friction: their force was 15 % \
             above that of mesocrete solve with a friction of 0.5, and 19 % above that without"
                .to_owned()
        })
    }

    fn softening_doubt(&self, mesh: &Mesh) -> Option<String> {
        let test =
            self.test().filter(|test| test.kind == TestKind::Compression && !test.is_fast() && self.has_curves())?;
        let (mortar, given) = (&self.materials.mortar, self.materials.mortar_strength.of(LAW));
        let (strain, width_mm) = (test.strain(), materials::crack_band(mesh).width_mm);
        let mut halved = (0..=HALVINGS).map(|n| {
            let energy = given.crushing_energy_n_per_mm / f64::from(1 << n);
            let strength = Strength { crushing_energy_n_per_mm: energy, ..given };
            (energy, damage::half_strength_strain(mortar, &strength, width_mm))
        });
        let half = halved.next()?.1;
        if half <= SOFTENS_WITHIN * strain {
            return None;
        }
        let remedy = halved.find(|(_, half)| *half <= SOFTENS_WITHIN * strain);
        let remedy = remedy.map_or_else(String::new, |(energy, half)| format!(" ({energy} gives {half:.4})"));
        Some(format!(
            "mortar is at half its strength at an inelastic strain of {half:.4} only, and the test ends at {strain}: the specimen \
             will hardly soften; take a smaller materials.mortar_strength.crushing_energy_n_per_mm{remedy}"
        ))
    }

    fn bond_doubt(&self, mesh: &Mesh) -> Option<String> {
        let is_bonded = self.has_curve() && mesh.cohesive.is_empty() && !mesh.phase.contains(&Phase::Itz);
        is_bonded.then(|| {
            "without an ITZ the elastic aggregates stay bonded to the mortar for ever; take itz smeared, \
             cohesive or solid"
                .to_owned()
        })
    }

    /// Whether mortar and ITZ have strength in the deck.
    pub(crate) fn has_curves(&self) -> bool {
        self.damages() && !self.geometry_only
    }

    /// Whether mortar and ITZ get strength and damage.
    fn damages(&self) -> bool {
        self.with_damage || self.is_explicit()
    }

    /// Checks all values before there is a mesh, for a specimen that is periodic along the `periodic` axes.
    ///
    /// # Errors
    /// Fails like [`validate`](Self::validate).
    pub fn validate_for(&self, periodic: [bool; 3]) -> Result<(), OutOfRange> {
        limits::check(self)?;
        if self.has_curves() {
            let names = self.materials.own_phases();
            let mut strong = std::iter::once(Phase::Mortar).chain(names.own());
            strong.try_for_each(|phase| limits::curves(&self.materials, (phase, &names), 1.0))?;
        }
        if !self.periodic_equations {
            return Ok(());
        }
        let no = |key, value, accepted| Err(DECK.error(key, value, accepted));
        let tie = "only a box without walls has faces to tie: pack with specimen.periodic = [\"x\", \"y\", \"z\"]";
        let step = "with periodic_equations it needs a box without any wall; take none and a step of your own";
        match &self.analysis {
            _ if periodic == [false; 3] => no("periodic_equations", "true", tie),
            Analysis::Elastic if !self.geometry_only && periodic != [true; 3] => no("analysis", "elastic", step),
            Analysis::None | Analysis::Elastic => Ok(()),
            Analysis::Striker | Analysis::Test(_) => {
                no("periodic_equations", "true", "plates need free faces; take analysis elastic or none")
            }
        }
    }
}

/// The volumes of aggregates in a mesh for an analysis are within this share of their own.
const VOLUMES_OFF: f64 = 0.05;

/// Warns of aggregates that are far from their own volume.
fn volume_doubt(mesh: &Mesh, exact: Option<&PhaseVolumes>) -> Option<String> {
    let (exact, meshed) = (exact?.aggregate, PhaseVolumes::of_mesh(mesh).aggregate);
    exceeds((meshed - exact).abs(), VOLUMES_OFF * exact).then(|| {
        let percent = 100.0 * (meshed / exact - 1.0);
        format!(
            "the aggregates of this mesh have {percent:+.1} % of their exact volume, so this is another concrete; take \
             smaller elements, a larger min_gap_mm, or the method lattice with itz smeared and volumes exact"
        )
    })
}

/// Warns of aggregates that share nodes, where that was asked for or is only too stiff.
fn joined_doubt(mesh: &Mesh) -> Option<String> {
    let ((nodes, pairs), touching) = (mesh.joined_aggregates(), mesh.touching_share());
    if nodes > 0 {
        let (nodes, pairs) = (thousands(nodes), thousands(pairs));
        return Some(format!(
            "{pairs} pairs of aggregates share {nodes} nodes, an elastic skeleton: too stiff, and it never breaks; mesh with \
             joined mortar or itz cohesive, or pack with a larger min_gap_mm"
        ));
    }
    (touching > Mesh::FEW_TOUCH).then(|| {
        let share = 100.0 * touching;
        format!(
            "{share:.1} % of the cohesive elements lie between two aggregates: without mortar there these form a skeleton that \
             hardly breaks; mesh with joined mortar, or pack with a larger min_gap_mm"
        )
    })
}

/// Refuses a mesh whose aggregates share nodes: however the mortar softens, they carry the load.
fn refuse_joined(mesh: &Mesh, analysis: &Analysis) -> Result<(), OutOfRange> {
    let (nodes, pairs) = mesh.joined_aggregates();
    if nodes == 0 {
        return Ok(());
    }
    let (nodes, pairs) = (thousands(nodes), thousands(pairs));
    let accepted = format!(
        "{pairs} pairs of aggregates share {nodes} nodes, an elastic skeleton that never breaks; mesh with joined mortar or itz \
         cohesive, pack with a larger min_gap_mm, or set allow_joined"
    );
    Err(DECK.error("analysis", analysis.word(), accepted))
}

/// Finds out whether an `.inp` can have these options.
///
/// # Errors
/// Names the option, its value and the accepted range.
pub(crate) fn check(options: &DeckOptions) -> Result<(), OutOfRange> {
    let has_striker = options.analysis == Analysis::Striker && !options.geometry_only;
    let accepted = "only a .k takes it; take a test, elastic or none for an .inp";
    DECK.require("analysis", "striker", !has_striker, accepted)?;
    let usual = LsdynaLaw::default();
    DECK.require(
        "lsdyna_law",
        format!("{:?}", options.lsdyna_law).to_lowercase(),
        options.lsdyna_law == usual,
        "only a .k takes it",
    )
}

/// All nodes of the deck besides those of `mesh`, by ascending numbers.
fn extras(mesh: &Mesh, options: &DeckOptions) -> Vec<geometry::ExtraNodes> {
    let tied = options.periodic_equations.then(|| periodic::references(mesh));
    let loads = options.loads.as_ref().filter(|_| !options.geometry_only);
    let own = loads.map(|loads| match loads.is_elastic {
        true => at_rest::references(mesh, loads),
        false => supports::references(mesh, loads),
    });
    tied.into_iter().chain(own).flatten().collect()
}

/// The error of a test without loads.
fn no_loads(analysis: &Analysis) -> OutOfRange {
    DECK.error(
        "analysis",
        analysis.word(),
        "it needs the loads of the test on this mesh, which DeckOptions::load gives",
    )
}

/// Writes `mesh` as a deck to `out`, streamed, without a second copy of the mesh.
///
/// # Errors
/// Fails with the errors of `out`, and those of [`DeckOptions::validate`] as invalid input.
pub fn write(mesh: &Mesh, options: &DeckOptions, out: impl Write) -> io::Result<()> {
    let invalid = |error: OutOfRange| io::Error::new(io::ErrorKind::InvalidInput, error);
    options.validate(mesh).and_then(|()| check(options)).map_err(invalid)?;
    let mut lines = Lines::new(out);
    geometry::heading(&mut lines, mesh, options)?;
    let sides = Sides::of(mesh);
    geometry::write(&mut lines, mesh, &sides, options, &extras(mesh, options))?;
    if options.periodic_equations {
        periodic::write(&mut lines, mesh, &sides)?;
    }
    if !options.geometry_only {
        materials::write(&mut lines, mesh, options)?;
        match (&options.analysis, &options.loads) {
            (Analysis::Elastic, _) => {
                let step = if options.periodic_equations { elastic::write_periodic } else { elastic::write };
                step(&mut lines, mesh, &sides, options.elastic_strain())?;
            }
            (Analysis::Test(_), Some(loads)) => {
                let write = if loads.is_elastic { at_rest::write } else { supports::write };
                write(&mut lines, mesh, options, loads)?;
            }
            // An impact is refused above.
            (Analysis::None | Analysis::Striker | Analysis::Test(_), _) => {}
        }
    }
    lines.finish()
}
