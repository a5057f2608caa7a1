//! Response of a specimen to a test.

use crate::assemble::tet::{Shape, corners};
use crate::march::beyond_peak::BeyondPeak;
use crate::march::curve::{Extra, Figures, Row, lead, peak, to_half_peak};
use crate::march::frame::Frame;
use crate::march::lateral::Lateral;
use crate::march::run::Run;
use meso_concrete::exceeds;
use meso_element::LawName;
use meso_mesh::materials::Scatter;
use meso_mesh::{CellKind, Phase, PhaseVolumes};
use meso_trial::{Control, Gauge, OF_PLATES, Rule, Setup, Smoothing, Test, TestKind, TurnOf};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How a test came to its end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// At the strain that was asked for.
    Completed,
    /// The observer stopped it; the curve so far is valid.
    Stopped,
    /// It diverged; the curve until then is valid. Holds the element that ran away.
    Diverged(String),
    /// The device that took its steps failed; the curve until then is valid. Holds the reason.
    Failed(String),
}

/// The curve and its figures.
#[derive(Clone, Debug, Serialize)]
pub struct Response {
    /// The curve, row by row.
    #[serde(skip)]
    pub curve: Vec<Row>,
    /// Gauges and forces of supports, where the test has such columns.
    #[serde(skip)]
    pub extra: Extra,
    /// Content of `result.json`.
    #[serde(flatten)]
    pub result: Summary,
}

/// Content of `result.json`, without seconds.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Summary {
    /// The named test.
    pub test: TestKind,
    /// Loads, measures, turns, supports and gauges.
    #[serde(flatten)]
    pub setup: Setup,
    /// Coulomb's coefficient between plates and specimen.
    pub friction: f64,
    /// How the plates kept their speed.
    pub control: Control,
    /// The law of mortar and ITZ.
    pub law: LawName,
    /// Strain smoothing.
    pub smoothing: Smoothing,
    /// Cells of the mesh.
    pub elements: usize,
    /// Cohesive elements of the mesh.
    pub cohesive_elements: usize,
    /// Steps taken.
    pub steps: u64,
    /// Steps of the whole test at the plates' full speed.
    pub steps_planned: u64,
    /// s.
    pub time_step_s: f64,
    /// Longest step that would have needed no mass, s.
    pub stable_time_step_s: f64,
    /// Mass added over the specimen's own.
    pub added_mass_percent: f64,
    /// Figures of the curve.
    #[serde(flatten)]
    pub figures: Figures,
    /// Rate of strain at the peak between two plates in real time, 1/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_at_peak_per_s: Option<f64>,
    /// Figures of the curve beyond its peak.
    #[serde(flatten)]
    pub beyond_peak: BeyondPeak,
    /// Figures of a gauge of lateral strain on a specimen that is pressed.
    #[serde(flatten)]
    pub lateral: Lateral,
    /// Largest kinetic over internal energy after the ramp; from half the peak on, where the peak lies within the ramp.
    pub kinetic_over_internal_max: f64,
    /// Largest kinetic over internal energy until the stress has fallen to half its peak; to the peak under a lateral tension.
    pub kinetic_over_internal_to_half_peak: f64,
    /// Largest difference of work and energies over the work: what loose nodes lose when they meet a plate again, and rounding.
    pub energy_balance_error: f64,
    /// Largest hourglass over internal energy after the ramp.
    pub hourglass_over_internal: f64,
    /// Energies at the end, mJ.
    pub energies: Energies,
    /// Pairs of aggregates that share nodes in the mesh, or did before mortar separated them there.
    pub joined_pairs: usize,
    /// Cells of these aggregates that became mortar, in the mesh and in the test.
    pub joined_cells: usize,
    /// Phases of the test.
    pub phases: Vec<PhaseResult>,
    /// Columns of the curve after those of every test: gauges, and forces of supports in N.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<String>,
    /// Means of the gauges after the growth in a test that moves no support: the strains of an expansion.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub strains_at_end: BTreeMap<String, f64>,
    /// Share of the aggregates' volume that lost more than half of its stiffness; `None` where stone does not break.
    pub broken_stone: Option<f64>,
    /// Scatter of the strengths of mortar and ITZ; absent where they have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scatter: Option<Scatter>,
    /// Volume of the phase that is farthest off its exact one, as a share of this, signed; `None` where it is not known.
    pub phase_error: Option<f64>,
    /// Name of the phase that is farthest off, in lower case.
    pub phase_error_of: Option<String>,
    /// Faults that a strength must not be cited without, in a few words each: of the mesh, and the speed of the test.
    pub flags: Vec<String>,
    /// How the test ended.
    pub ended: Ended,
    /// Warnings, in sentences; those of the mesh come first.
    pub warnings: Vec<String>,
    /// Number of the warnings that were known before the first step.
    #[serde(skip)]
    pub mesh_warnings: usize,
    /// Why the curve is not to be trusted, in sentences.
    pub errors: Vec<String>,
}

/// Energies at the end of a test, mJ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Work of the elements' forces: stored, dissipated and hourglass energy.
    pub internal: f64,
    /// Work of the plates.
    pub external: f64,
    /// Dissipated by friction on the plates.
    pub friction_work: f64,
    /// Energy of hourglass modes.
    pub hourglass: f64,
    /// Dissipated in cracks, crushing and plastic flow.
    pub dissipated: f64,
}

/// A phase of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseResult {
    /// Name in lower case.
    pub name: String,
    /// Volume of its cells in the test over the specimen's gross volume.
    pub volume_fraction: f64,
    /// Volume of the exact bodies over the specimen's, where known.
    pub exact_fraction: Option<f64>,
    /// Dissipated in its cells, mJ; in cohesive faces, too, for the ITZ.
    pub dissipated_mj: f64,
    /// Young's modulus before the test, MPa.
    #[serde(default)]
    pub youngs_modulus_mpa: f64,
    /// Poisson's ratio before the test.
    #[serde(default)]
    pub poisson_ratio: f64,
}

/// Kinetic over internal energy that is still quasi-static, and that is no longer.
const SLOW: f64 = 0.01;
const FAST: f64 = 0.05;
/// Flag of a specimen that was gone before its test began.
const TORN: &str = "torn by its lateral tension";
/// Distance of a curve from the stress of a turn, over that, at which it is met: rows are means over some steps.
const UNMET: f64 = 0.02;
/// Hourglass over internal energy that is still small.
const HOURGLASS: f64 = 0.02;
/// Difference of a mesh's volume from its specimen's, % of the notches, that is still small.
const NOTCH: f64 = 10.0;
/// Fall of the dissipated energy, over the most that there was, that is more than rounding.
const GIVEN_BACK: f64 = 0.05;
/// Difference of work and energies, over the work, that is still rounding and impacts.
const BALANCE: f64 = 1e-3;

impl Response {
    pub(crate) fn of(run: &Run, ended: Ended) -> Self {
        let rows = &run.state.rows;
        let last = rows.last().copied().unwrap_or_default();
        let ramp_s = run.path.lead_s + run.path.ramp_s;
        let checked = first_checked(rows, ramp_s, ended == Ended::Stopped);
        let largest = |rows: &[Row], of: fn(&Row) -> f64| {
            let after = rows.iter().skip(checked).filter(|row| row.internal > 0.0);
            after.map(of).fold(0.0, f64::max)
        };
        let kinetic = |row: &Row| row.kinetic / row.internal;
        // A pull is a dead load: it drives what breaks beyond the peak, however slow the plates are.
        let counted =
            if is_pulled(&run.setup) { &rows[..(peak(rows) + 1).min(rows.len())] } else { to_half_peak(rows) };
        let off = run.sample.phase_off();
        let mut result = Summary {
            test: run.test.kind,
            setup: run.setup.clone(),
            friction: run.test.friction(),
            control: run.test.control(),
            law: run.test.law,
            smoothing: run.test.smoothing(run.sample.mesh.kind),
            elements: run.sample.mesh.cell_count(),
            cohesive_elements: run.sample.mesh.cohesive().len(),
            steps: run.state.step,
            steps_planned: run.outline.steps,
            time_step_s: run.outline.dt,
            stable_time_step_s: run.outline.stable_s,
            added_mass_percent: run.added_mass_percent(),
            figures: Figures::of(rows, run.path.lead_s),
            rate_at_peak_per_s: rate_at_peak(run),
            beyond_peak: BeyondPeak::of(rows, run.supports.length_mm, run.supports.breaking_share),
            lateral: lateral(run),
            kinetic_over_internal_max: largest(rows, kinetic),
            kinetic_over_internal_to_half_peak: largest(counted, kinetic),
            energy_balance_error: balance_error(rows),
            hourglass_over_internal: largest(rows, |row| row.hourglass / row.internal),
            energies: energies(&last),
            joined_pairs: run.sample.mesh.joined_aggregates().1 + run.sample.mesh.notes.separated_pairs,
            joined_cells: run.sample.mesh.notes.parted_cells,
            phases: phases(run),
            columns: run.extra().names,
            strains_at_end: strains_at_end(run),
            broken_stone: broken_stone(run),
            scatter: run.scatter().cloned(),
            phase_error: off.map(|off| off.error()),
            phase_error_of: off.map(|off| run.sample.mesh.phases.name(off.phase).to_owned()),
            flags: run.flags(),
            ended,
            warnings: run.doubts(),
            mesh_warnings: 0,
            errors: Vec::new(),
        };
        let torn = is_pulled(&run.setup)
            && lead(rows, run.path.lead_s).last().is_some_and(|row| row.kinetic > FAST * row.internal);
        result.warn(run, torn);
        let stopped = (result.ended == Ended::Stopped).then(|| "stopped".to_owned());
        result.flags.extend(result.dynamic_flag().into_iter().chain(stopped));
        Self { curve: rows.clone(), extra: run.extra(), result }
    }
}

/// Whether a side is pulled by a pressure below 0.
fn is_pulled(setup: &Setup) -> bool {
    setup.supports.iter().any(|support| support.pressure_mpa < 0.0)
}

fn rate_at_peak(run: &Run) -> Option<f64> {
    let (extra, rows) = (run.extra(), &run.state.rows);
    let column = extra.names.iter().position(|name| name == OF_PLATES[0])?;
    (!rows.is_empty()).then(|| extra.row(peak(rows))[column])
}

/// Means of the gauges over the rows after the growth, or their last values before, if no support moves. Cracks leave the
/// specimen vibrating, and these rows have ten periods of it.
fn strains_at_end(run: &Run) -> BTreeMap<String, f64> {
    let (extra, rows, gauges) = (run.extra(), &run.state.rows, run.test.gauges());
    if run.test.has_path() || run.test.is_fast() || rows.is_empty() {
        return BTreeMap::new();
    }
    // A row is a mean since the row before it.
    let first = (1..rows.len()).find(|&row| rows[row - 1].time_s >= run.path.lead_s).unwrap_or(rows.len() - 1);
    let mean = |column: usize| {
        (first..rows.len()).map(|row| extra.row(row)[column]).sum::<f64>() / (rows.len() - first) as f64
    };
    let named = extra.names.iter().enumerate();
    let of_gauges = named.filter(|(_, name)| gauges.iter().any(|gauge| gauge.name() == *name));
    of_gauges.map(|(column, name)| (name.clone(), mean(column))).collect()
}

/// Number of the first row whose speed counts: after the ramp, or from half the peak on where the ramp holds the peak. So no
/// ramp hides the strength that is reported. A test that was stopped while its stress still rose in the ramp has no strength.
fn first_checked(rows: &[Row], ramp_s: f64, was_stopped: bool) -> usize {
    let peak = rows.iter().max_by(|a, b| a.stress_mpa.total_cmp(&b.stress_mpa)).copied().unwrap_or_default();
    let last = rows.last().copied().unwrap_or_default();
    let rises = was_stopped && last.time_s <= ramp_s && last.stress_mpa >= 0.8 * peak.stress_mpa;
    let is_hidden = peak.time_s <= ramp_s && !rises;
    let counts = |row: &Row| row.time_s > ramp_s || (is_hidden && row.stress_mpa >= peak.stress_mpa / 2.0);
    rows.iter().position(counts).unwrap_or(rows.len())
}

fn energies(row: &Row) -> Energies {
    let Row { kinetic, internal, external, friction_work, hourglass, dissipated, .. } = *row;
    Energies { kinetic, internal, external, friction_work, hourglass, dissipated }
}

fn balance_error(rows: &[Row]) -> f64 {
    let work = rows.iter().map(|row| row.external.abs()).fold(0.0, f64::max);
    let off = |row: &Row| (row.external - row.internal - row.kinetic - row.friction_work).abs();
    if work > 0.0 { rows.iter().map(off).fold(0.0, f64::max) / work } else { 0.0 }
}

/// Figures of the first gauge of lateral strain, if the specimen is pressed along one axis.
fn lateral(run: &Run) -> Lateral {
    let is_lateral = |gauge: &Gauge| matches!(gauge, Gauge::LateralStrain { .. });
    let is_free = run.supports.sign < 0.0 && run.test.kind != TestKind::Biaxial;
    let gauge = run.test.gauges().into_iter().find(is_lateral).filter(|_| is_free);
    let (rows, extra) = (&run.state.rows, run.extra());
    let column = gauge.and_then(|gauge| extra.names.iter().position(|name| name == gauge.name()));
    let all = |column: usize| (0..rows.len()).map(|row| extra.row(row)[column]).collect::<Vec<f64>>();
    column.map_or_else(Lateral::default, |column| Lateral::of(rows, &all(column), run.path.lead_s))
}

/// Damage beyond which a cell of stone is broken.
const BROKEN: f32 = 0.5;

fn broken_stone(run: &Run) -> Option<f64> {
    if run.common.stones.is_empty() {
        return None;
    }
    let mesh = run.sample.mesh;
    let damage = Frame::new(run, 0).cells(|point| point.damage);
    let is_stone = |cell: &usize| mesh.phase[*cell] == Phase::Aggregate;
    let volume = |cell: usize| match mesh.kind {
        CellKind::Hexahedron => run.common.shape.volume(),
        _ => Shape::of(&corners(mesh, cell as u32)).volume,
    };
    let all: f64 = (0..mesh.cell_count()).filter(is_stone).map(volume).sum();
    let broken: f64 = (0..mesh.cell_count()).filter(is_stone).filter(|&cell| damage[cell] > BROKEN).map(volume).sum();
    // A sum of nothing is -0.
    (all > 0.0).then(|| broken / all + 0.0)
}

fn phases(run: &Run) -> Vec<PhaseResult> {
    let volumes = PhaseVolumes::of_mesh(run.sample.mesh);
    let result = |phase: Phase| {
        let groups = run.blocks.iter().flat_map(|block| &block.groups).filter(|group| group.phase == phase);
        let exact = |exact: PhaseVolumes| exact.of(phase) / run.sample.volume_mm3;
        PhaseResult {
            name: run.sample.mesh.phases.name(phase).to_owned(),
            volume_fraction: volumes.of(phase) / run.sample.volume_mm3,
            exact_fraction: run.sample.exact.map(exact),
            dissipated_mj: groups.map(|group| group.dissipated).sum(),
            youngs_modulus_mpa: run.common.matter[phase.index()].elastic.youngs_modulus_mpa,
            poisson_ratio: run.common.matter[phase.index()].elastic.poisson_ratio,
        }
    };
    let has_faces = !run.sample.mesh.cohesive.is_empty();
    // Bodies that the elements have lost are told with a volume of 0.
    let is_asked = |phase| run.sample.exact.is_some_and(|exact| exact.of(phase) > 0.0);
    let is_there = |&phase: &Phase| {
        run.sample.mesh.phase.contains(&phase) || is_asked(phase) || (phase == Phase::Itz && has_faces)
    };
    run.sample.mesh.phases.solid().filter(is_there).map(result).collect()
}

/// Whether the dissipated energy fell by more than the balance allows: a law gave energy back.
fn gave_back(rows: &[Row]) -> bool {
    let (mut most, mut fall) = (0.0_f64, 0.0_f64);
    for row in rows {
        most = most.max(row.dissipated);
        fall = fall.max(most - row.dissipated);
    }
    fall > GIVEN_BACK * most
}

impl Summary {
    fn warn(&mut self, run: &Run, torn: bool) {
        self.mesh_warnings = self.warnings.len();
        self.warn_of_the_laws(run);
        self.warn_of_strips(run);
        self.warn_of_notches(run);
        self.warn_of_turns(run);
        self.warn_of_idle_plates(run);
        self.warn_of_strains(run);
        if let Ended::Diverged(element) = &self.ended {
            self.errors.push(format!("the run diverged at {element}; the curve is valid until then"));
        }
        if let Ended::Failed(why) = &self.ended {
            let fix = "resume from the last checkpoint, on this device or another";
            self.errors.push(format!("the device failed: {why}; the curve is valid until then; {fix}"));
        }
        if torn {
            self.flags.push(TORN.to_owned());
            let fix = "take a pressure_mpa nearer to 0 than the tensile strength";
            self.errors.push(format!("its lateral tension tore the specimen apart before the plates moved; {fix}"));
        } else {
            self.warn_of_speed();
        }
        if exceeds(self.hourglass_over_internal, HOURGLASS) {
            let share = 100.0 * self.hourglass_over_internal;
            let way_out = "take smaller elements or less hourglass stiffness";
            self.warnings.push(format!("hourglass modes have {share:.1} % of the internal energy; {way_out}"));
        }
        if exceeds(self.energy_balance_error, BALANCE) {
            let share = 100.0 * self.energy_balance_error;
            let way_out = if gave_back(&run.state.rows) {
                "cracks that closed gave energy back, as they may with the laws cdp and cdpm2; take the law meso, or a smaller \
                 strain at which the specimen has not come apart"
            } else {
                "take a smaller time step"
            };
            self.errors.push(format!("the energy balance is off by {share:.2} % of the work; {way_out}"));
        }
    }

    /// Whether stress over strain is a modulus: in splitting, bending and shear both are nominal, and waves run in real time.
    pub fn has_modulus(&self) -> bool {
        let is_nominal = matches!(self.test, TestKind::Splitting | TestKind::Shear | TestKind::Expansion);
        !self.is_fast() && !self.test.is_beam() && !is_nominal
    }

    /// Whether its supports moved in real time.
    pub fn is_fast(&self) -> bool {
        self.setup.supports.iter().any(|support| support.drive.is_some())
    }

    /// Whether waves and inertia are in its largest stress, which is no strength then.
    fn is_struck(&self) -> bool {
        matches!(self.test, TestKind::Spall | TestKind::Drop)
    }

    /// Whether no support moves: an expansion has strains and no strength.
    pub fn is_free(&self) -> bool {
        self.test == TestKind::Expansion && self.setup.supports.iter().all(|support| support.moves == 0.0)
    }

    /// The main result in words: the peak, or the mean strains of an expansion.
    pub fn headline(&self) -> String {
        if self.is_free() {
            let strains = self.strains_at_end.iter().map(|(name, strain)| format!("{name} {strain:.3e}"));
            return format!("mean {}", strains.collect::<Vec<_>>().join(", "));
        }
        let Figures { first_peak_mpa, peak_mpa, peak_strain, .. } = self.figures;
        if !self.has_peak() {
            return format!("no peak yet, {peak_mpa:.2} MPa at a strain of {:.5}", peak_strain.max(0.0));
        }
        if self.is_struck() {
            return format!("largest stress {peak_mpa:.2} MPa");
        }
        let splits = matches!(self.test, TestKind::Splitting | TestKind::HopkinsonSplitting);
        let splits_early = splits && first_peak_mpa < peak_mpa;
        let first = if splits_early { format!("first peak {first_peak_mpa:.2} MPa, ") } else { String::new() };
        format!("{first}peak {peak_mpa:.2} MPa at a strain of {peak_strain:.5}")
    }

    /// The result with the flags of its mesh and its speed, if there are any.
    pub fn flagged(&self) -> Option<String> {
        let (peak, flags) = (self.figures.peak_mpa, self.flags.join("; "));
        let is_plain = self.has_peak() && !self.is_free() && !self.is_struck();
        let found = || if is_plain { format!("peak {peak:.2} MPa") } else { self.headline() };
        (!flags.is_empty()).then(|| format!("{}, {flags}", found()))
    }

    /// Whether the largest stress is a strength: the test came to its end, or its stress had fallen before.
    pub fn has_peak(&self) -> bool {
        self.ended == Ended::Completed || self.figures.softened
    }

    /// Kinetic energy before the peak, % of the internal one, of a test that was not quasi-static.
    fn dynamic_percent(&self) -> Option<f64> {
        let share = self.kinetic_over_internal_to_half_peak;
        let is_torn = self.flags.iter().any(|flag| flag == TORN);
        (exceeds(share, SLOW) && !self.is_free() && !self.is_fast() && !is_torn).then_some(100.0 * share)
    }

    fn dynamic_flag(&self) -> Option<String> {
        self.dynamic_percent().map(|share| format!("not quasi-static ({share:.1} % kinetic energy before the peak)"))
    }

    /// Says that a test was not quasi-static until half its peak, so that its strength is that of a fast test.
    pub fn dynamic_before_the_peak(&self) -> Option<String> {
        self.dynamic_percent().map(|share| {
            format!(
                "the test was not quasi-static before its peak: its kinetic energy was {share:.1} % of the internal energy, so \
                 its strength is that of a fast test; take a longer duration"
            )
        })
    }

    /// Warnings that the end of the test brings; those of the mesh came before the first step.
    pub fn late_warnings(&self) -> impl Iterator<Item = String> {
        let late = self.warnings.iter().skip(self.mesh_warnings).cloned();
        self.dynamic_before_the_peak().into_iter().chain(late)
    }

    /// Kinetic energy that is no longer small.
    fn warn_of_speed(&mut self) {
        let (kinetic, before) = (self.kinetic_over_internal_max, self.kinetic_over_internal_to_half_peak);
        if kinetic <= SLOW || self.test == TestKind::Expansion || self.is_fast() {
            return;
        }
        let share = 100.0 * kinetic;
        let reached = format!("the kinetic energy reached {share:.1} % of the internal energy");
        if is_pulled(&self.setup) && before <= SLOW {
            self.warnings.push(format!(
                "{reached} beyond the peak: a lateral tension is a dead load, which drives what breaks, so that the curve there \
                 is no test; no duration calms it"
            ));
            return;
        }
        // No row to half the peak: it broke within the ramp.
        let text = if before > SLOW || before == 0.0 {
            format!("{reached}; take a longer duration")
        } else {
            let before = 100.0 * before;
            format!(
                "{reached}, {before:.1} % until the stress had fallen to half its peak; to calm the collapse beyond, \
                 take a longer duration"
            )
        };
        if exceeds(kinetic, FAST) { self.errors.push(text) } else { self.warnings.push(text) }
    }

    /// Warns of splitting strips that are narrower than two elements: one row of nodes cuts into the specimen like a wedge.
    fn warn_of_strips(&mut self, run: &Run) {
        let size = run.sample.element_size_mm;
        let Some(width) = run.test.splitting_strip_mm(&run.sample.geometry()).filter(|width| *width < 2.0 * size)
        else {
            return;
        };
        let rounded = |mm: f64| (1e3 * mm).round() / 1e3;
        self.warnings.push(format!(
            "the strips are {} mm wide and the elements {size} mm, so that fewer than three rows of nodes lie under a strip \
             and cut into the specimen; take elements of {} mm",
            rounded(width),
            rounded(0.5 * width)
        ));
    }

    /// Warns of notches that the mesh fills or widens: those narrower than two elements.
    fn warn_of_notches(&mut self, run: &Run) {
        let error = 100.0 * run.sample.notch_error();
        if exceeds(error.abs(), NOTCH) {
            let does = if error > 0.0 { "fills" } else { "widens" };
            let error = error.abs();
            self.warnings.push(format!(
                "the mesh {does} the notches by {error:.0} % of their volume; take elements of at most half a notch's width"
            ));
        }
    }

    /// Warns of turns at a stress that the specimen never had: the path turned at its limit instead.
    fn warn_of_turns(&mut self, run: &Run) {
        let stresses = || run.state.rows.iter().map(|row| row.stress_mpa);
        let (low, high) = (stresses().fold(0.0, f64::min), stresses().fold(0.0, f64::max));
        let is_met = |at: f64| (low - UNMET * at.abs()..=high + UNMET * at.abs()).contains(&at);
        let turns = run.test.turns();
        let mut unmet = turns.iter().filter(|turn| turn.of == TurnOf::Stress && !is_met(turn.at));
        if let (Some(turn), Ended::Completed) = (unmet.next(), &self.ended) {
            let (at, strain) = (turn.at, run.test.strain());
            self.warnings.push(format!(
                "the path never met its turn at {at} MPa and turned at its strain of {strain} instead; the stress was \
                 {low:.2} to {high:.2} MPa, so take a turn within it"
            ));
        }
    }

    /// Warns of plates that never touched the specimen; if no support carries a force, the curve is none.
    fn warn_of_idle_plates(&mut self, run: &Run) {
        let (extra, first, rows) = (run.extra(), run.gauges.len(), run.state.rows.len());
        let has_columns = extra.names.len() >= first + run.supports.all.len();
        let moves = run.test.has_path() || run.test.is_fast();
        if !moves || self.ended != Ended::Completed || rows == 0 || !has_columns {
            return;
        }
        let is_idle = |place: usize| (0..rows).all(|row| extra.row(row)[first + place] == 0.0);
        let all_idle = (0..run.supports.all.len()).all(is_idle);
        for (place, plate) in run.supports.all.iter().enumerate() {
            if plate.face.rule != Rule::Plate || !is_idle(place) {
                continue;
            }
            let (name, leaves) = (&plate.name, plate.moves * plate.face.inward < 0.0);
            let why = if leaves {
                format!("its moves of {} lead it away; take {}, or rule = \"glued\"", plate.moves, -plate.moves)
            } else {
                "let a support press the specimen against it, or leave it out".to_owned()
            };
            let text = format!("the plate {name} never touched the specimen: {why}");
            if all_idle { self.errors.push(text) } else { self.warnings.push(text) }
        }
    }

    /// Says that a test in real time ended at the largest strain.
    fn warn_of_strains(&mut self, run: &Run) {
        if run.is_too_far() {
            let (time, most) = (run.state.time, 100.0 * Test::LARGEST_STRAIN);
            self.warnings.push(format!(
                "the test ended after {time:.3e} s, at a strain of {most} %: strains of the engine are small ones"
            ));
        }
    }

    /// Warns of bands that are too wide for the energy of cracking or crushing.
    fn warn_of_the_laws(&mut self, run: &Run) {
        if let Some(ratio) = run.common.matter.iter().find_map(|matter| matter.low_tension()) {
            self.warnings.push(format!(
                "the mortar's tensile strength is {ratio:.3} of its compressive strength; below 0.09 the law cdpm2 gains \
                 too much from friction and lateral pressure; set materials.mortar_strength.tensile_mpa to 0.1 of \
                 compressive_mpa"
            ));
        }
        let phases = &run.sample.mesh.phases;
        for phase in phases.solid() {
            let (width, limits) = (run.outline.widest_mm[phase.index()], run.common.widest_mm(phase, phases));
            let name = phases.name(phase);
            for (what, energy, limit) in [("cracks", "fracture", limits[0]), ("crushing", "crushing", limits[1])] {
                if width > limit {
                    self.warnings.push(format!(
                        "elements are too large for the {energy} energy of {name}: its bands are up to {width:.2} mm wide, \
                         and {what} in more than {limit:.2} mm dissipate too much; take smaller elements"
                    ));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_of_a_test_stopped_while_its_ramp_rose_does_not_count() {
        let row = |(time_s, stress_mpa)| Row { time_s, stress_mpa, ..Row::default() };
        let rows = [(1.0, 1.0), (2.0, 3.0), (3.0, 2.0)].map(row);
        assert_eq!([first_checked(&rows[..2], 9.0, true), first_checked(&rows[..2], 9.0, false)], [2, 1]);
        assert_eq!(first_checked(&rows, 9.0, true), 1, "it broke before it was stopped");
        assert_eq!(first_checked(&rows[..2], 1.5, true), 1, "the ramp was over");
    }

    #[test]
    fn a_law_gave_energy_back_where_the_dissipated_energy_fell_by_a_twentieth() {
        let rows = |energies: &[f64]| -> Vec<Row> {
            energies.iter().map(|&dissipated| Row { dissipated, ..Row::default() }).collect()
        };
        assert!(gave_back(&rows(&[0.0, 8.75, 8.27, -58.0])));
        assert!(gave_back(&rows(&[0.0, 4.0, 3.0, 9.0])));
        assert!(!gave_back(&rows(&[0.0, 4.0, 3.9, 9.0])));
        assert!(!gave_back(&rows(&[0.0, 0.0])) && !gave_back(&[]));
    }
}
