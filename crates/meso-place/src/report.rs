//! The report of a packing run: fractions, stop reason, counters.

use super::{GrainTally, PackingTarget, Placed};
use meso_collision::gjk::Counters;
use meso_concrete::aggregate::{Aggregate, Grading, Inclusions, Kind, OwnPhase, Reduction, Shape, Template, Voids};
use meso_concrete::specimen::Specimen;
use meso_concrete::{Phase, PhaseNames, parallel};
use meso_concrete::{exceeds, short, thousands};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// The figures of one run: the keys of `--summary-json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Version of mesocrete.
    pub version: String,
    /// Seed of the run.
    pub seed: u64,
    /// Asked volume fraction of the aggregates, 0 to 1.
    pub target_fraction: f64,
    /// Reached volume fraction.
    pub fraction: f64,
    /// Fraction of the aggregates with their outward shells and the ITZ around them, where the spec asks for some; all other
    /// fractions are then of stones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coated_fraction: Option<f64>,
    /// Aggregates placed.
    pub aggregates: usize,
    /// Aggregates taken but not placed.
    pub discarded: usize,
    /// The specimen.
    pub specimen: SpecimenReport,
    /// The curve behind the classes, e.g. `fuller, normalised, n = 0.5`.
    pub grading: String,
    /// The strategy that placed.
    pub strategy: String,
    /// Per size class, from the finest.
    pub classes: Vec<ClassReport>,
    /// Voids and fibres, where the spec asks for some.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<PhaseReport>,
    /// Aggregates of a phase of their own, where the spec asks for some; they count among all aggregates above, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub own_phases: Vec<OwnPhaseReport>,
    /// Shells of the aggregates below their ITZ, where the spec asks for some.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shells: Vec<ShellReport>,
    /// Aggregates whose drawn ITZ was thinner than asked by the documented limit, by id.
    pub itz_limited: Vec<u32>,
    /// Aggregates with dents that have parts thinner than two of their ITZ, by id: nothing of these parts is inside the ITZ.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub itz_thin: Vec<u32>,
    /// The scans among the grains of the library that were reduced.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reduced: Vec<ReducedGrain>,
    /// The label volume that the aggregates come from, where they do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<LabelReport>,
    /// Why the placement ended.
    pub stop_reason: StopReason,
    /// The reason for the stop in a sentence: which class or fraction fell short, and by how much.
    pub stop_detail: String,
    /// Wall-clock seconds by stage; zero in a loaded model.
    #[serde(default)]
    pub seconds: Seconds,
    /// Counters of each stage.
    #[serde(default)]
    pub work: Work,
}

/// A grain of the library that is a scan in fewer triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReducedGrain {
    /// Position in the library, from 0.
    pub grain: usize,
    /// What that changed.
    #[serde(flatten)]
    pub reduction: Reduction,
}

impl ReducedGrain {
    /// All reduced grains in the library of `shape`.
    fn all(shape: &Shape) -> Vec<Self> {
        let reduced = |(grain, template): (usize, &Template)| Some(Self { grain, reduction: template.reduced? });
        shape.grains.iter().enumerate().filter_map(reduced).collect()
    }
}

/// A drilled core in a label volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoreReport {
    /// Labels outside of it.
    pub outside: Vec<i64>,
    /// Diameter of the cylinder of its volume, mm.
    pub diameter_mm: f64,
    /// Voxels of this cylinder, of which the shares below are.
    pub voxels: usize,
    /// Voxels that are beyond the cylinder, or missing within, over those of the core.
    pub off_fraction: f64,
    /// Share of the cylinder that has a label of the outside, such as pores; it is mortar.
    pub pores_fraction: f64,
}

impl LabelReport {
    /// The voxels of which shares are: those of the core, or else all.
    pub fn whole(&self) -> f64 {
        let all = || self.voxels.iter().map(|count| *count as f64).product();
        self.core.as_ref().map_or_else(all, |core| core.voxels as f64)
    }
}

/// A label volume whose grains the aggregates are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelReport {
    /// Voxels along x, y, z.
    pub voxels: [usize; 3],
    /// Edges of a voxel along x, y, z, mm.
    pub voxel_size_mm: [f64; 3],
    /// Share of the voxels that the aggregates had, hollows included, to compare with their fraction.
    pub fraction: f64,
    /// Largest distance of a face between a grain's voxels and others to its surface, mm; some 500 faces a grain are measured.
    pub farthest_mm: f64,
    /// Pairs of grains that share a face in the labels, and are apart in the model.
    pub separated_pairs: usize,
    /// Grains dropped as too small, or too thin for a surface.
    pub dropped: usize,
    /// Share of the voxels that they had.
    pub dropped_fraction: f64,
    /// Share of the specimen that was grains in the labels and is mortar in the model: dropped, or lost by gaps and smoothing.
    #[serde(default)]
    pub lost_fraction: f64,
    /// The drilled core that the specimen is; absent where it is the whole volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub core: Option<CoreReport>,
    /// Grains with hollows, mortar that one grain encloses, which were filled.
    #[serde(default)]
    pub filled: usize,
    /// Share of the voxels that the hollows had.
    #[serde(default)]
    pub filled_fraction: f64,
    /// Label of every aggregate, by id.
    pub labels: Vec<i64>,
}

/// Kind and volume of the specimen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpecimenReport {
    /// As in the spec.
    pub kind: String,
    /// Volume of the specimen, mm3.
    pub volume_mm3: f64,
    /// Lowest corner of the vertices of the spec, mm, where it is not the origin. The packing has its origin there: its
    /// coordinates plus these are those of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin_mm: Option<[f64; 3]>,
}

impl Report {
    /// Relative error of the class that is furthest from its target; `None` without classes.
    pub fn worst_class(&self) -> Option<f64> {
        let asked = self.classes.iter().filter(|class| class.target_fraction > 0.0);
        asked.map(|class| class.fraction / class.target_fraction - 1.0).max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }
}

impl SpecimenReport {
    /// The entry of a specimen.
    pub fn new(specimen: &Specimen) -> Self {
        Self { kind: specimen.kind().to_owned(), volume_mm3: specimen.volume(), origin_mm: specimen.origin() }
    }
}

/// Asked and reached volume of one class, over the specimen's volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassReport {
    /// Lower limit, mm.
    pub d_min_mm: f64,
    /// Upper limit, mm.
    pub d_max_mm: f64,
    /// Fraction of the specimen asked for.
    pub target_fraction: f64,
    /// Fraction of the specimen reached.
    pub fraction: f64,
    /// Number of aggregates.
    pub aggregates: usize,
}

/// Asked and reached volume of a further phase, over the specimen's volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhaseReport {
    /// Voids or fibres.
    pub phase: Kind,
    /// Fraction of the specimen asked for.
    pub target_fraction: f64,
    /// Fraction of the specimen reached.
    pub fraction: f64,
    /// Volume of the bodies, mm3.
    pub volume_mm3: f64,
    /// Number of bodies.
    pub bodies: usize,
    /// Per class of diameters, from the finest, where voids have a grading of their own; `aggregates` counts the voids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<ClassReport>,
}

/// Asked and reached volume of a phase of the aggregates' own, ITZ shells included, over the specimen's volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnPhaseReport {
    /// Name in the spec.
    pub phase: String,
    /// Fraction of the specimen asked for.
    pub target_fraction: f64,
    /// Fraction of the specimen reached.
    pub fraction: f64,
    /// Volume of the bodies, mm3.
    pub volume_mm3: f64,
    /// Number of aggregates.
    pub aggregates: usize,
}

/// Volume of the shells of a phase, over the specimen's volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShellReport {
    /// Name of the phase in the spec.
    pub phase: String,
    /// Fraction of the specimen that the shells take.
    pub fraction: f64,
    /// Volume of the shells, mm3.
    pub volume_mm3: f64,
    /// Number of aggregates that have one.
    pub aggregates: usize,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// Fraction and grading as asked.
    TargetReached,
    /// Aggregates found no place within their attempts.
    AttemptsExhausted,
    /// The rearrangement stopped falling.
    Jammed,
    /// `--time-limit` came first.
    TimeLimit,
    /// The user stopped it.
    Interrupted,
}

/// Wall-clock seconds by stage. The core reads no clock: its callers fill these in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Seconds {
    /// Whole run.
    pub total: f64,
    /// Generating the grains.
    pub take: f64,
    /// Placing the grains.
    pub place: f64,
    /// Writing files.
    pub write: f64,
}

/// Numbers of candidates or pairs that each stage saw; a pair that a stage decides goes no further.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Work {
    /// Candidate positions tried.
    pub candidates: u64,
    /// Pairs the broad phase named.
    pub pairs_broad: u64,
    /// Pairs left after the bounding spheres.
    pub pairs_sphere: u64,
    /// Pairs left after the ellipsoid axis.
    pub pairs_axis: u64,
    /// Pairs put to GJK.
    pub gjk_calls: u64,
    /// Pairs put to exact arithmetic.
    pub exact_calls: u64,
    /// Sweeps of the rearrangement.
    pub sweeps: u64,
}

/// A class counts as reached within this share of its target, or within one of its own grains.
const REACHED: f64 = 0.002;
/// Distance of the fraction from its target, over that, from which it is said though every class is within one of its grains.
const COARSE: f64 = 0.02;

/// Compares the placed `aggregates` and `inclusions` with the `target`. Volumes are those of the placed polyhedra.
pub fn report(
    target: &PackingTarget,
    tally: &GrainTally,
    outcome: &Placed,
    (aggregates, inclusions): (&[Aggregate], &[Aggregate]),
    seconds: Seconds,
) -> Report {
    let bodies = Report::of_bodies(target, aggregates, inclusions);
    let Report { specimen, classes, phases, .. } = &bodies;
    let largest: Vec<f64> = tally.largest_mm3.iter().map(|grain| grain / specimen.volume_mm3).collect();
    let (of_classes, of_phases) = largest.split_at(classes.len());
    // When the take was complete, a class without grains asked for less than half of its smallest grain.
    let (some, none): (Vec<_>, Vec<_>) =
        classes.iter().zip(of_classes).partition(|(_, largest)| outcome.stop.is_some() || **largest > 0.0);
    let too_small: Vec<String> = none.iter().map(|(class, _)| class.too_small()).collect();
    let short_classes = some.into_iter().filter_map(|(class, largest)| class.lack(*largest));
    let largest_of = |phase: &PhaseReport| of_phases[usize::from(phase.phase == Kind::Fibre)];
    let short: Vec<String> =
        short_classes.chain(phases.iter().filter_map(|phase| phase.lack(largest_of(phase)))).collect();
    let too_large =
        (outcome.too_large > 0).then(|| format!("{} grains are too large for the specimen", outcome.too_large));
    let cut_short = (!tally.complete)
        .then(|| format!("stopped when {} aggregates were made, before all grains were", tally.aggregates));
    let notes: Vec<String> = short.iter().chain(&too_small).cloned().chain(too_large).chain(cut_short).collect();
    Report {
        discarded: tally.aggregates - aggregates.len(),
        grading: target.grading.describe(),
        strategy: outcome.strategy.into(),
        itz_limited: tally.itz_limited.clone(),
        itz_thin: tally.itz_thin.clone(),
        stop_reason: outcome.stop.unwrap_or(if short.is_empty() {
            StopReason::TargetReached
        } else {
            outcome.dead_end
        }),
        stop_detail: detail(target.fraction, classes, &notes),
        seconds,
        work: outcome.work,
        ..bodies
    }
}

/// Value in a report for a figure that its file does not hold.
pub(crate) const NOT_RECORDED: &str = "not recorded in the file";

/// Aggregates that a remark names.
const NAMED: usize = 5;

impl Report {
    /// A sentence on each kind of aggregate whose ITZ is not as drawn.
    pub fn remarks(&self) -> Vec<String> {
        let limited = "an ITZ thinner than drawn: half of the distance from the centre to the nearest face";
        let thin = "parts thinner than two of their ITZ, which have nothing inside it";
        let named = |ids: &[u32]| ids.iter().take(NAMED).map(u32::to_string).collect::<Vec<_>>().join(", ");
        let more = |ids: &[u32]| if ids.len() > NAMED { ", ..." } else { "" };
        let kinds =
            [(&self.itz_limited, limited), (&self.itz_thin, thin)].into_iter().filter(|(ids, _)| !ids.is_empty());
        kinds
            .map(|(ids, has)| {
                format!("{} aggregates have {has} (ids {}{})", thousands(ids.len()), named(ids), more(ids))
            })
            .collect()
    }

    /// What the reductions of scans changed, in a sentence; `None` where there were none.
    pub fn cost_of_reductions(&self) -> Option<String> {
        let changes = || self.reduced.iter().map(|grain| 100.0 * grain.reduction.volume_change);
        let (low, high) = (changes().reduce(f64::min)?, changes().reduce(f64::max)?);
        let distance = self.reduced.iter().map(|grain| 100.0 * grain.reduction.distance).fold(0.0, f64::max);
        let (grains, percent) = (thousands(self.reduced.len()), short(distance));
        let range = if low == high { format!("{low:+.2} %") } else { format!("{low:+.2} to {high:+.2} %") };
        Some(format!(
            "scans in fewer triangles, {grains} of the library's grains: within {percent} % of their length; volume changed by {range}"
        ))
    }

    /// Why the fraction is not the one asked for; `None` where it is.
    pub fn shortfall(&self) -> Option<String> {
        let why = match self.stop_reason {
            StopReason::TargetReached => return self.coarse_grains(),
            StopReason::Interrupted => " (interrupted)",
            StopReason::TimeLimit => " (the time limit came first)",
            StopReason::AttemptsExhausted | StopReason::Jammed => "",
        };
        Some(format!("short of the target{why}: {}", self.stop_detail))
    }

    /// Whether the fraction falls short of the target; within 2 % of it only where the search for poses ended early.
    pub fn is_short(&self) -> bool {
        self.stop_reason != StopReason::TargetReached || self.off() < -COARSE
    }

    /// Difference of the fraction from its target, as a share of that.
    fn off(&self) -> f64 {
        let asked: f64 = self.classes.iter().map(|class| class.target_fraction).sum();
        self.fraction / asked - 1.0
    }

    /// Says that grains are so large for their specimen that the fraction is off, though every class is within one of them.
    fn coarse_grains(&self) -> Option<String> {
        let off = self.off();
        exceeds(off.abs(), COARSE).then(|| {
            let (fraction, percent) = (self.fraction, 100.0 * off);
            format!(
                "the fraction is {fraction:.5}, {percent:+.1} % off its target: each size class is within one of its grains, \
                 which are large for this specimen; take a larger specimen or smaller aggregates"
            )
        })
    }

    /// The figures that follow from the bodies of a model; others are not recorded.
    pub fn of_bodies(target: &PackingTarget, aggregates: &[Aggregate], inclusions: &[Aggregate]) -> Self {
        let volume = target.specimen.volume();
        let classes = ClassReport::all(target.grading, target.fraction, aggregates, volume);
        let fraction = classes.iter().map(|class| class.fraction).sum();
        let reached = fraction >= target.fraction - 0.001;
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            seed: target.seed,
            target_fraction: target.fraction,
            fraction,
            coated_fraction: coated_fraction(target, aggregates),
            aggregates: aggregates.len(),
            discarded: 0,
            specimen: SpecimenReport::new(target.specimen),
            grading: NOT_RECORDED.to_owned(),
            strategy: NOT_RECORDED.to_owned(),
            classes,
            phases: PhaseReport::all(&target.inclusions, inclusions, volume),
            own_phases: OwnPhaseReport::all(target, aggregates),
            shells: ShellReport::all(target, aggregates),
            itz_limited: Vec::new(),
            itz_thin: Vec::new(),
            reduced: ReducedGrain::all(target.shape),
            labels: None,
            stop_reason: if reached { StopReason::TargetReached } else { StopReason::AttemptsExhausted },
            stop_detail: NOT_RECORDED.to_owned(),
            seconds: Seconds::default(),
            work: Work::default(),
        }
    }

    /// False where a saved model brought no report, and this one was computed from its bodies.
    pub fn is_recorded(&self) -> bool {
        self.strategy != NOT_RECORDED
    }
}

impl ClassReport {
    /// Every class of `grading`: its target at `fraction`, and the share that `aggregates` take of a specimen of
    /// `volume_mm3`.
    pub(crate) fn all(grading: &Grading, fraction: f64, aggregates: &[Aggregate], volume_mm3: f64) -> Vec<Self> {
        let own = |body: &Aggregate| usize::from(body.class);
        Self::by(grading, fraction, aggregates.iter().map(|body| (own(body), body)), volume_mm3)
    }

    /// Every class of `grading`, from bodies with their classes.
    fn by<'a>(
        grading: &Grading,
        fraction: f64,
        bodies: impl Iterator<Item = (usize, &'a Aggregate)>,
        volume_mm3: f64,
    ) -> Vec<Self> {
        let asked = grading.classes().into_iter().map(|class| Self {
            d_min_mm: class.d_min_mm,
            d_max_mm: class.d_max_mm,
            target_fraction: class.share * fraction,
            fraction: 0.0,
            aggregates: 0,
        });
        let mut classes: Vec<Self> = asked.collect();
        for (class, body) in bodies {
            let class = &mut classes[class];
            class.fraction += body.graded().volume() / volume_mm3;
            class.aggregates += 1;
        }
        classes
    }

    /// The class's shortfall in words; `largest` is the share of the specimen that its largest grain takes.
    fn lack(&self, largest: f64) -> Option<String> {
        let percent = lack(self.target_fraction, self.fraction, largest)?;
        Some(format!("{}-{} mm is {percent} short", self.d_min_mm, self.d_max_mm))
    }

    fn too_small(&self) -> String {
        format!("{}-{} mm asks for less than one aggregate", self.d_min_mm, self.d_max_mm)
    }
}

impl PhaseReport {
    /// Every further phase that is asked for, and the share that `bodies` take of a specimen of `volume_mm3`.
    pub(crate) fn all(asked: &Inclusions<'_>, bodies: &[Aggregate], volume_mm3: f64) -> Vec<Self> {
        let phases = Kind::FURTHER.into_iter().zip(asked.fractions()).filter(|(_, target)| *target > 0.0);
        let phase = |(phase, target_fraction)| {
            let own = || bodies.iter().filter(|body| body.kind == phase);
            // An empty sum is -0.0, which would be printed.
            let volume = own().map(|body| body.body.volume()).fold(0.0, |sum, volume| sum + volume);
            let classes = asked.voids.filter(|_| phase == Kind::Void).map(|voids| classes(voids, own(), volume_mm3));
            let (fraction, bodies, classes) = (volume / volume_mm3, own().count(), classes.unwrap_or_default());
            Self { phase, target_fraction, fraction, volume_mm3: volume, bodies, classes }
        };
        phases.map(phase).collect()
    }

    /// Says by how much a phase fell short of its target, like [`ClassReport::lack`]; `None` where it did not.
    fn lack(&self, largest: f64) -> Option<String> {
        let percent = lack(self.target_fraction, self.fraction, largest)?;
        Some(format!("{} are {percent} short", self.phase.plural()))
    }
}

/// The classes of voids with a grading of their own, by the balls of their volumes.
fn classes<'a>(voids: &Voids, bodies: impl Iterator<Item = &'a Aggregate>, volume_mm3: f64) -> Vec<ClassReport> {
    let Some(grading) = &voids.grading else { return Vec::new() };
    let limits = &grading.classes_mm[1..];
    let class = |body: &Aggregate| {
        let diameter = Voids::diameter_of(body.body.volume());
        limits.iter().position(|limit| diameter < *limit).unwrap_or(limits.len() - 1)
    };
    ClassReport::by(grading, voids.fraction, bodies.map(|body| (class(body), body)), volume_mm3)
}

impl OwnPhaseReport {
    /// Every phase of the aggregates' own.
    fn all(target: &PackingTarget, aggregates: &[Aggregate]) -> Vec<Self> {
        let (room, classes) = (target.specimen.volume(), target.grading.classes());
        let of = |(own, phase): (usize, &OwnPhase)| {
            let asked = classes.iter().map(|class| target.fraction * class.share * phase.share_of(class));
            let bodies = || aggregates.iter().filter(|body| body.own == Some(own as u8));
            let volume = bodies().map(|body| body.graded().volume()).fold(0.0, |sum, volume| sum + volume);
            Self {
                phase: phase.name.clone(),
                target_fraction: asked.sum(),
                fraction: volume / room,
                volume_mm3: volume,
                aggregates: bodies().count(),
            }
        };
        target.phases.iter().enumerate().map(of).collect()
    }
}

/// The fraction with outward shells, where there are some.
fn coated_fraction(target: &PackingTarget, aggregates: &[Aggregate]) -> Option<f64> {
    let bodies = || aggregates.iter().map(|body| body.body.volume()).sum::<f64>() / target.specimen.volume();
    target.shape.has_coatings().then(bodies)
}

impl ShellReport {
    /// The shells of every phase, by name.
    fn all(target: &PackingTarget, aggregates: &[Aggregate]) -> Vec<Self> {
        if target.shape.shells.is_empty() {
            return Vec::new();
        }
        let layers = |body: &Aggregate| body.layer_volumes(body.itz_thickness_mm).unwrap_or_default();
        let layers = parallel::map_each(aggregates, layers);
        let names = PhaseNames::of(target.phases, &target.shape.shells);
        let shells: BTreeSet<u8> = target.shape.shells.iter().filter_map(|law| names.find(&law.name)).collect();
        let of = |own: u8| {
            let has = |body: &&Aggregate| body.shells.iter().any(|shell| shell.own == own);
            // The last layer is the core.
            let shells = |layers: &Vec<(Phase, f64)>| -> f64 {
                let shells = layers.iter().rev().skip(1).filter(|(phase, _)| *phase == Phase::Own(own));
                shells.fold(0.0, |sum, (_, volume)| sum + volume)
            };
            let volume_mm3 = layers.iter().map(shells).fold(0.0, |sum, volume| sum + volume);
            Self {
                phase: names.name(Phase::Own(own)).to_owned(),
                fraction: volume_mm3 / target.specimen.volume(),
                volume_mm3,
                aggregates: aggregates.iter().filter(has).count(),
            }
        };
        shells.into_iter().map(of).collect()
    }
}

/// The shortfall of a class or phase, if it has one, in words.
fn lack(target: f64, reached: f64, largest: f64) -> Option<String> {
    let short = target - reached > (REACHED * target).max(largest);
    short.then(|| format!("{:.1} %", 100.0 * (1.0 - reached / target)))
}

/// The fraction reached and the fraction asked. The classes ask for less than `target` where a raw curve omits a part
/// of it.
fn detail(target: f64, classes: &[ClassReport], notes: &[String]) -> String {
    let placed: f64 = classes.iter().map(|class| class.target_fraction).sum();
    let fraction: f64 = classes.iter().map(|class| class.fraction).sum();
    let asked = if (placed - target).abs() < 1e-9 {
        brief(target)
    } else {
        format!("the {} that the raw curve leaves of {}", brief(placed), brief(target))
    };
    if notes.is_empty() {
        return format!("reached {fraction:.5} of {asked}, every class as graded");
    }
    format!("reached {fraction:.5} of {asked}; {}", notes.join(", "))
}

/// A fraction with at most five decimals; a mix design's has many.
fn brief(fraction: f64) -> String {
    let rounded = (fraction * 1e5).round() / 1e5;
    if rounded > 0.0 { rounded.to_string() } else { format!("{fraction:e}") }
}

impl Work {
    /// Adds the counters of collision detection.
    pub(super) fn add(&mut self, counters: &Counters) {
        self.pairs_broad += counters.pairs;
        self.pairs_sphere += counters.after_spheres;
        self.pairs_axis += counters.after_ellipsoids;
        self.gjk_calls += counters.gjk_calls;
        self.exact_calls += counters.exact_calls;
    }
}
