//! The independent check of a model: everything a packing promises, proved from the saved coordinates alone.
//!
//! It shares no code with placement: its own broad phase, the exact collision verdict on the vertices as they are
//! saved, and exact orientation signs for convexity. The grains that the spec and the seed give are made again: every
//! body must be one of them, and the report must follow from them. Findings are listed, never repaired.

mod inclusions;
mod labels;
mod pairs;
mod report;
mod solid;
mod taken;

use crate::model::Model;
use meso_collision::geometry::{BodyForm, Polyhedron};
use meso_collision::math::{Aabb, Vec3, longest_distance};
use meso_concrete::aggregate::{Aggregate, Kind, SizeDefinition};
use meso_concrete::parallel;
use meso_concrete::specimen::Container;
use meso_concrete::watch::{Silent, Stage, Watch};
use pairs::Placed;
use serde::Serialize;
use std::borrow::Cow;
use std::fmt;

/// Scope and findings of a check. Where a finding speaks of an aggregate, voids and fibres are included: their ids
/// follow those of the aggregates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Number of aggregates checked.
    pub aggregates: usize,
    /// Pairs whose boxes come within the asked gap of each other: those were put to the exact test.
    pub pairs_tested: u64,
    /// Volume of the polyhedra over the specimen's.
    pub fraction: f64,
    /// Everything that is not as promised; empty for a sound model.
    pub findings: Vec<Finding>,
    /// Promises that were not checked, in words.
    pub not_checked: Vec<&'static str>,
}

/// Promises that no check of the file alone can prove.
const NOT_CHECKED: [&str; 4] = [
    "that this seed puts the bodies where they are: pack the spec again and compare",
    "options of the spec with which the same grains come out, as a limit that none of them reached",
    "the counters in work",
    "which of the versions up to this one wrote the file",
];
/// Where the grains are a label volume's.
const NOT_CHECKED_OF_LABELS: [&str; 2] = [
    "that the bodies, their labels and their distance are the label volume's: import it again and compare",
    "how many grains were dropped, filled, or touched in the label volume, and a core's labels outside, pores and voxels that \
     are off: its voxels alone show that",
];
/// Where a time limit or the user ended the run.
const NOT_CHECKED_IF_STOPPED: &str = "how many grains were made and discarded before the stop";
/// Where the spec makes far more grains than the file accounts for.
const NOT_CHECKED_IF_TOO_MANY: &str = "that the bodies are those of the seed: they are too many to generate again";

/// One thing that is not as promised.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "finding", rename_all = "kebab-case")]
pub enum Finding {
    /// Two aggregates share a point.
    Overlap {
        /// The smaller id.
        a: u32,
        /// The larger id.
        b: u32,
    },
    /// Two aggregates are nearer than the spec's `min_gap_mm`.
    Gap {
        /// The smaller id.
        a: u32,
        /// The larger id.
        b: u32,
        /// Their distance, mm.
        distance_mm: f64,
    },
    /// A vertex is outside the specimen, or nearer to its surface than `wall_gap_mm`.
    Outside {
        /// Id.
        aggregate: u32,
    },
    /// The faces do not bound a convex solid seen from outside.
    NotConvex {
        /// Id.
        aggregate: u32,
        /// The fault.
        reason: String,
    },
    /// The triangles do not bound a solid seen from outside.
    NotSolid {
        /// Id.
        aggregate: u32,
        /// The fault.
        reason: String,
    },
    /// The ITZ leaves no core inside the aggregate.
    Itz {
        /// Id.
        aggregate: u32,
        /// The fault.
        reason: String,
    },
    /// The size is outside its class.
    Size {
        /// Id.
        aggregate: u32,
        /// Its size by the spec's definition, mm.
        size_mm: f64,
    },
    /// A body is none of the grains that the spec and the seed give, or the same one twice.
    NotTaken {
        /// Id.
        body: u32,
    },
    /// A void or fibre does not have the size in the spec.
    Shape {
        /// Id.
        body: u32,
        /// The fault.
        reason: String,
    },
    /// The report contradicts the aggregates.
    Report {
        /// The difference.
        reason: String,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlap { a, b } => write!(f, "aggregates {a} and {b} share a point"),
            Self::Gap { a, b, distance_mm } => write!(f, "aggregates {a} and {b} are only {distance_mm} mm apart"),
            Self::Outside { aggregate } => {
                write!(f, "aggregate {aggregate} extends outside the specimen, or into the gap at its walls")
            }
            Self::NotConvex { aggregate, reason } => write!(f, "aggregate {aggregate} is not a convex solid: {reason}"),
            Self::NotSolid { aggregate, reason } => write!(f, "aggregate {aggregate} is not a solid: {reason}"),
            Self::Itz { aggregate, reason } => write!(f, "aggregate {aggregate} has no sound ITZ: {reason}"),
            Self::NotTaken { body } => {
                write!(
                    f,
                    "body {body} is not one of the grains of this spec and seed: its class, ITZ or volume differs"
                )
            }
            Self::Shape { body, reason } => write!(f, "body {body} does not match the spec: {reason}"),
            Self::Size { aggregate, size_mm } => {
                write!(f, "aggregate {aggregate} has the size {size_mm} mm, outside its class")
            }
            Self::Report { reason } => write!(f, "the report is wrong: {reason}"),
        }
    }
}

impl Finding {
    /// The body that the take does not know.
    fn body(&self) -> Option<u32> {
        match *self {
            Self::NotTaken { body } => Some(body),
            _ => None,
        }
    }

    /// The two aggregates that it is about.
    fn pair(&self) -> Option<(u32, u32)> {
        match *self {
            Self::Overlap { a, b } | Self::Gap { a, b, .. } => Some((a, b)),
            _ => None,
        }
    }
}

impl Check {
    /// Checks like [`check`], and reports to `watch` as [`Stage::Prove`].
    pub fn of(model: &Model, watch: &dyn Watch) -> Self {
        watch.stage(Stage::Prove, 0.02);
        let container = model.spec.specimen.container();
        let bodies = model.bodies();
        let placed = placed(model, &bodies, container.aabb());
        watch.stage(Stage::Prove, 0.1);
        let (pairs_tested, mut findings) = pairs::check(&placed, bodies.len(), model.spec.placement.min_gap_mm);
        watch.stage(Stage::Prove, 0.4);
        findings.extend(parallel::flat_map(bodies.len(), |number| single(model, &*container, &bodies[number])));
        watch.stage(Stage::Prove, 0.7);
        // Summed in the order of the aggregates, whatever the threads.
        let volumes = parallel::map_each(&model.aggregates, |aggregate| aggregate.body.volume());
        let fraction = volumes.iter().sum::<f64>() / container.volume();
        let (taken, not_taken) = taken::check(model, &bodies);
        findings.extend(not_taken);
        findings.extend(report::check(model, taken.as_ref()));
        findings.extend(labels::check(model));
        watch.stage(Stage::Prove, 1.0);
        let not_checked = not_checked(model, taken.is_some());
        Check { aggregates: model.aggregates.len(), pairs_tested, fraction, findings, not_checked }
    }

    /// True when nothing was found.
    pub fn is_sound(&self) -> bool {
        self.findings.is_empty()
    }
}

/// Checks every promise of `model`.
pub fn check(model: &Model) -> Check {
    Check::of(model, &Silent)
}

fn not_checked(model: &Model, made_again: bool) -> Vec<&'static str> {
    if model.report.labels.is_some() {
        return NOT_CHECKED_OF_LABELS.into_iter().chain([NOT_CHECKED[3]]).collect();
    }
    let stopped = taken::was_stopped(model).then_some(NOT_CHECKED_IF_STOPPED);
    let too_many = (!made_again).then_some(NOT_CHECKED_IF_TOO_MANY);
    NOT_CHECKED.into_iter().chain(stopped).chain(too_many).collect()
}

/// The bodies, then their images that one of them may meet.
fn placed<'a>(model: &Model, bodies: &'a [Aggregate], domain: Aabb) -> Vec<Placed<'a>> {
    let place = |body: u32, a: &'a Aggregate, vertices: Cow<'a, [Vec3]>| Placed { body, vertices, of: &a.body };
    let own = (0..).zip(bodies);
    let mut placed: Vec<Placed> = own.map(|(body, a)| place(body, a, Cow::Borrowed(a.body.vertices()))).collect();
    let period = model.spec.specimen.period();
    if period.is_none() {
        return placed;
    }
    let (mut reached, gap) = (domain, Vec3::repeat(model.spec.placement.min_gap_mm));
    bodies.iter().map(|a| a.body.aabb()).for_each(|aabb| reached = reached.with(&aabb));
    // An aggregate far off is a finding of its own; its images would be without number.
    let most = domain.size();
    let reached = Aabb { min: reached.min.sup(&(domain.min - most)), max: reached.max.inf(&(domain.max + most)) };
    let reached = Aabb { min: reached.min - gap, max: reached.max + gap };
    for (id, aggregate) in (0..).zip(bodies) {
        let shifts = period.shifts(&aggregate.body.aabb(), &reached).into_iter().filter(|s| *s != Vec3::zeros());
        placed.extend(shifts.map(|shift| {
            place(id, aggregate, Cow::Owned(aggregate.body.vertices().iter().map(|v| v + shift).collect()))
        }));
    }
    placed
}

/// Checks of one aggregate alone.
fn single(model: &Model, container: &dyn Container, aggregate: &Aggregate) -> Vec<Finding> {
    let id = aggregate.id;
    let not_solid = |reason| Finding::NotSolid { aggregate: id, reason };
    let convex = match aggregate.body.form() {
        BodyForm::Hull => {
            solid::check(&aggregate.body).err().map(|reason| Finding::NotConvex { aggregate: id, reason })
        }
        BodyForm::Round(round) => solid::check_round(&round, &aggregate.body).err().map(not_solid),
        BodyForm::Surface => solid::check_surface(&aggregate.body).err().map(not_solid),
    };
    // The offset of a body that is not convex means nothing.
    let has_itz = aggregate.kind == Kind::Aggregate;
    let itz = if convex.is_none() && has_itz { itz(aggregate) } else { None };
    let range = if has_itz { itz_range(model, aggregate) } else { None };
    let shells = if convex.is_none() { shells(aggregate) } else { None };
    [convex, itz, range, shells, outside(model, container, aggregate), size(model, aggregate)]
        .into_iter()
        .flatten()
        .collect()
}

fn outside(model: &Model, container: &dyn Container, aggregate: &Aggregate) -> Option<Finding> {
    let (body, gap) = (&aggregate.body, model.spec.placement.wall_gap_mm);
    let inside = container.holds_body(&body.form(), body.vertices(), &Vec3::zeros(), gap);
    let (period, middle) = (model.spec.specimen.period(), aggregate.body.aabb());
    let middle = (middle.min + middle.max) / 2.0;
    // In directions that repeat themselves the aggregate is there once, near the box. Which point of it lies in the box
    // is the placement's choice, so half of its length is left to it.
    let slack = aggregate.body.aabb().size() / 2.0;
    let box_size = container.aabb().size();
    let near =
        (0..3).all(|i| period.along(i).is_none() || (middle[i] >= -slack[i] && middle[i] <= box_size[i] + slack[i]));
    (!(inside && near)).then_some(Finding::Outside { aggregate: aggregate.id })
}

/// The thickness is drawn within the spec's limits, or limited where the report says so.
fn itz_range(model: &Model, aggregate: &Aggregate) -> Option<Finding> {
    let ([low, high], thickness) = (model.spec.itz.thickness_mm, aggregate.itz_thickness_mm);
    // The draw is low + (high - low) x, rounded.
    let rounding = 2.0 * f64::EPSILON * high;
    let limited = model.report.itz_limited.binary_search(&aggregate.id).is_ok();
    let fits = thickness <= high + rounding && (limited || thickness >= low - rounding);
    let reason = || format!("it is {thickness} mm thick, the spec says {low} to {high}");
    (!fits).then(|| Finding::Itz { aggregate: aggregate.id, reason: reason() })
}

/// A shell may be thinner by this, mm: planes and distances are rounded to about 1e-13.
const SHELL_ROUNDING: f64 = 1e-9;

/// A point deeper than the shell is thick proves a core; only where the mean of the vertices is none, the core is made.
fn itz(aggregate: &Aggregate) -> Option<Finding> {
    let thickness = aggregate.itz_thickness_mm;
    if thickness == 0.0 {
        return None;
    }
    if solid::depth_of_inner_point(&aggregate.body, thickness) > thickness + SHELL_ROUNDING {
        return None;
    }
    let without_core = || format!("a shell of {thickness} mm leaves no core");
    let reason = match aggregate.core() {
        _ if aggregate.body.form() == BodyForm::Surface => without_core(),
        Err(error) => error.to_string(),
        Ok(None) => without_core(),
        Ok(Some(core)) => {
            return too_thin(&aggregate.body, &core, thickness)
                .map(|reason| Finding::Itz { aggregate: aggregate.id, reason });
        }
    };
    Some(Finding::Itz { aggregate: aggregate.id, reason })
}

/// Shells are the points of one body between two depths, which are nested: that something is left inside is all there is to prove.
fn shells(aggregate: &Aggregate) -> Option<Finding> {
    let all: f64 = aggregate.shells.iter().map(|shell| shell.thickness_mm).sum();
    let depth = aggregate.itz_thickness_mm + all;
    if all == 0.0 || solid::depth_of_inner_point(&aggregate.body, depth) > depth + SHELL_ROUNDING {
        return None;
    }
    let is_left = matches!(aggregate.body.inward_offset(depth), Ok(Some(core)) if core.volume() > 0.0);
    let reason = format!("its ITZ and shells, {depth} mm thick, leave no core");
    (!is_left).then_some(Finding::Itz { aggregate: aggregate.id, reason })
}

/// Finds a fault of the shell between a body and its core.
fn too_thin(body: &Polyhedron, core: &Polyhedron, thickness: f64) -> Option<String> {
    let thinnest = solid::thinnest_shell(body, core);
    let reason = || format!("its shell is {thinnest} mm thin where it should be {thickness}");
    (thinnest < thickness - SHELL_ROUNDING).then(reason)
}

/// Bound on the length that is lost to the single precision in which a body keeps its vertices about its centre (half of
/// this), and to being turned, by far less than 1e-6 mm.
fn rounding(length_mm: f64) -> f64 {
    1e-6 + f64::from(f32::EPSILON) * length_mm
}

/// Sizes are drawn within the class.
fn size(model: &Model, aggregate: &Aggregate) -> Option<Finding> {
    let class = match aggregate.kind {
        Kind::Aggregate => *model.spec.grading.classes().get(usize::from(aggregate.class))?,
        _ => return inclusions::size(&model.spec.inclusions(), aggregate),
    };
    let body = aggregate.graded();
    let size_mm = match model.spec.grading.size {
        SizeDefinition::LongestAxis => match body.form() {
            BodyForm::Round(round) => 2.0 * round.semi_axes()[0],
            BodyForm::Hull | BodyForm::Surface => longest_distance(body.vertices()),
        },
        SizeDefinition::Sieve => body.sieve_size(),
    };
    let rounding = rounding(size_mm);
    let fits = size_mm >= class.d_min_mm - rounding && size_mm <= class.d_max_mm + rounding;
    (!fits).then_some(Finding::Size { aggregate: aggregate.id, size_mm })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::pack;
    use meso_collision::geometry::convex_hull;
    use meso_spec::{Files, Spec};
    use std::io;

    #[test]
    fn a_shell_thinner_by_a_nanometre_and_more_is_found() {
        let corners = |half: f64| (0..8).map(move |i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { half } else { -half }));
        let body = convex_hull(&corners(2.0).collect::<Vec<_>>()).unwrap();
        let core = body.inward_offset(0.5).unwrap().unwrap();
        assert_eq!(too_thin(&body, &core, 0.5), None);
        assert_eq!(too_thin(&body, &core, 0.5 + 1e-10), None);
        assert!(too_thin(&body, &core, 0.5 + 2e-9).is_some());
    }

    /// A library of one grain.
    struct Library(&'static str);

    impl Files for Library {
        fn read(&mut self, _: &str) -> io::Result<Vec<u8>> {
            Ok(self.0.into())
        }

        fn list(&mut self, _: &str) -> io::Result<Vec<String>> {
            Err(io::ErrorKind::NotADirectory.into())
        }
    }

    /// The case `sieve_library.toml`: 48 cubes, 171 tetrahedra and 84 plates lay outside their classes.
    #[test]
    fn packings_of_regular_grains_by_sieve_size_are_sound() {
        let grains = [
            "[[[1,1,1], [1,1,-1], [1,-1,1], [1,-1,-1], [-1,1,1], [-1,1,-1], [-1,-1,1], [-1,-1,-1]]]",
            "[[[4,4,1], [4,4,-1], [4,-4,1], [4,-4,-1], [-4,4,1], [-4,4,-1], [-4,-4,1], [-4,-4,-1]]]",
            "[[[1,0,0], [-1,0,0], [0,1,0], [0,-1,0], [0,0,1], [0,0,-1]]]",
            "[[[1,1,1], [1,-1,-1], [-1,1,-1], [-1,-1,1]]]",
        ];
        let text = "fraction = 0.2\nspecimen = { kind = 'cube', side_mm = 50 }\nshape = { library = 'grain.json' }\n\
            itz = { thickness_mm = [0, 0] }\n\
            grading = { d_min_mm = 8, d_max_mm = 16, classes_mm = [8, 11.2, 16], size = 'sieve' }\n";
        for grain in grains {
            for seed in 0..5 {
                let spec = Spec::from_toml_with(&format!("seed = {seed}\n{text}"), &mut Library(grain)).unwrap();
                assert_eq!(check(&pack(&spec, &Silent).unwrap()).findings, [], "{grain}, seed {seed}");
            }
        }
    }
}
