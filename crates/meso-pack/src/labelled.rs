//! A model of a label volume: its connected grains as closed surfaces at their places, in a box.
//!
//! The spec that the model carries describes what was found: the box, the fraction, the sieve curve of the grains.

use crate::drilled::{self, Drilled, NoCore};
use crate::model::{Model, target};
use meso_collision::geometry::{Polyhedron, TriangleMesh};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::take::ITZ_LIMIT;
use meso_concrete::aggregate::{Aggregate, Curve, Grading, Itz, Kind, SizeDefinition};
use meso_concrete::import::grains::{
    CoreCylinder, GrainSurfaces, LabelledGrain, LabelledGrains, Roles, SmoothOptions, SurfacesError,
};
use meso_concrete::import::volume::Volume;
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_concrete::{OutOfRange, Ranges, mark_caps, parallel};
use meso_place::{CoreReport, LabelReport, Report, StopReason};
use meso_spec::{MAX_LENGTH_MM, Spec, SpecError};
use std::collections::BTreeSet;

/// How a label volume becomes a model.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelOptions {
    /// Edges of a voxel along x, y, z, mm; `None` takes those of the file.
    pub voxel_size_mm: Option<[f64; 3]>,
    /// Which labels are grains.
    pub roles: Roles,
    /// Labels outside a drilled core, whose cylinder is the specimen then; empty: the specimen is the whole box.
    pub outside: Vec<i64>,
    /// Connected grains of fewer voxels are mortar.
    pub least_voxels: usize,
    /// Largest share of the volume that a grain may have; a larger one is asked about.
    pub largest_grain: f64,
    /// Gap between grains that are nearer in the labels, mm; at least half a voxel.
    pub gap_mm: f64,
    /// Thickness of the ITZ of every grain, mm.
    pub itz_thickness_mm: f64,
    /// How surfaces are made.
    pub surfaces: SmoothOptions,
}

impl Default for LabelOptions {
    fn default() -> Self {
        Self {
            voxel_size_mm: None,
            roles: Roles { mortar: vec![0], aggregate: Vec::new() },
            outside: Vec::new(),
            least_voxels: 64,
            largest_grain: 0.2,
            gap_mm: 0.0,
            itz_thickness_mm: 0.0,
            surfaces: SmoothOptions::default(),
        }
    }
}

/// Why a label volume is no specimen.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LabelsError {
    /// An option out of range.
    #[error(transparent)]
    Option(#[from] OutOfRange),
    /// A volume without layers.
    #[error("it has {} x {} x {} voxels; a specimen takes at least {LEAST_COUNT} along each axis", counts[0], counts[1], counts[2])]
    Flat {
        /// Voxels along x, y, z.
        counts: [usize; 3],
    },
    /// More voxels than numbers.
    #[error("it has {voxels} voxels, and at most 2^32 - 2 are taken; cut a part out")]
    Long {
        /// Number of voxels.
        voxels: usize,
    },
    /// A label that mesocrete's own images give to the mortar.
    #[error("it has the label {label}, which is below 0; name it as mortar, or as aggregate")]
    Negative {
        /// The label.
        label: i64,
    },
    /// A label that is named and does not occur.
    #[error("{key} names {label}, which the volume does not have; its labels are {labels}")]
    Absent {
        /// Name of the option.
        key: &'static str,
        /// The label.
        label: i64,
        /// The first labels.
        labels: String,
    },
    /// No connected grain that is large enough.
    #[error("it has no grain of {least} voxels or more ({dropped} are smaller); check which labels are mortar")]
    NoGrains {
        /// Least voxels of a grain.
        least: usize,
        /// How many are smaller.
        dropped: usize,
    },
    /// Grey values, most of whose connected parts are specks.
    #[error(
        "it has {labels} values, and {percent:.0} % of its voxels lie in parts of fewer than {least}: this is a grey image; segment it first, one label a phase or a grain"
    )]
    Grey {
        /// Number of labels.
        labels: usize,
        /// Share of the voxels in small parts, %.
        percent: f64,
        /// Least voxels of a grain.
        least: usize,
    },
    /// A grain that surrounds others, reaches all faces of the volume, or has much of it.
    #[error("label {label} is {percent:.0} % of the volume in one part{}", question(*surrounds, *is_open, *embeds))]
    Mortar {
        /// Its label.
        label: i64,
        /// Its share.
        percent: f64,
        /// How many grains it surrounds.
        surrounds: usize,
        /// Whether it reaches all faces.
        is_open: bool,
        /// Whether it has most of what is labelled, and nearly all the rest lies in its box.
        embeds: bool,
        /// Labels that are mortar if this is.
        mortar: Vec<i64>,
        /// What the labels are if this is no mortar.
        otherwise: Otherwise,
    },
    /// Grains of which no surface is left.
    #[error(
        "its grains are too thin for a surface: none is left after smoothing; take smaller voxels, or less smoothing"
    )]
    Vanished,
    /// A model that no spec can describe.
    #[error("its grains make no model: {0}")]
    Spec(#[from] SpecError),
    /// No drilled core within the outside.
    #[error("{}", no_core(*.0))]
    NoCore(Option<f64>),
    /// Surfaces that could not be made.
    #[error(transparent)]
    Surfaces(#[from] SurfacesError),
}

/// What labels are that were asked about, where the answer is no.
#[derive(Clone, Debug, PartialEq)]
pub enum Otherwise {
    /// Grains: `largest_grain` of this share of the volume takes them.
    Grains(f64),
    /// One phase of these labels, such as core and ITZ.
    Phase(Vec<i64>),
    /// Nothing: a grain cannot surround others of many labels.
    Nothing,
}

/// Says that there is no core, or how much of it lies off its cylinder.
fn no_core(off: Option<f64>) -> String {
    match off {
        None => "outside names nothing that lies about a core, or all of it".to_owned(),
        Some(off) => format!(
            "what does not lie outside is no cylinder along z: {:.0} % of it is off; turn the volume, or leave outside out",
            100.0 * off
        ),
    }
}

/// What is asked about a label that may be mortar.
fn question(surrounds: usize, is_open: bool, embeds: bool) -> String {
    match surrounds {
        0 if embeds && !is_open => {
            ", most of what is labelled, and nearly all other labels lie in its box: is it mortar?".to_owned()
        }
        0 => {
            let open = if is_open { ", which reaches all faces of the volume" } else { "" };
            format!("{open}: is it mortar?")
        }
        1 => " and surrounds a grain: is it mortar?".to_owned(),
        _ => format!(" and surrounds {surrounds} grains: is it mortar?"),
    }
}

/// Fewest voxels along an axis.
const LEAST_COUNT: usize = 4;
/// More values than this, most of them in specks, are a grey image.
const GREY: usize = 20;
/// Most labels that a phase probably has.
const PHASE: usize = 4;
/// Least share of all labelled voxels that mortar in air has.
const MOST: f64 = 0.5;
/// Least share of the other labels' voxels that lie in its box.
const NEARLY: f64 = 0.9;
/// Bytes a voxel: labels as they are read and as numbers, those about a core, roots and sizes of grains.
const VOXEL_BYTES: f64 = 21.0;
/// Least digits of a limit of sizes, 1/mm.
const DIGITS: f64 = 1e3;

impl LabelOptions {
    /// Names the first invalid value.
    ///
    /// # Errors
    /// See [`OutOfRange`].
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let SmoothOptions { step, smoothing, tolerance } = self.surfaces;
        let is_in = |key, value: f64, [low, high]: [f64; 2], unit: &str| {
            Ranges("labels").require(
                key,
                value,
                (low..=high).contains(&value),
                format!("it must be {low} to {high} {unit}"),
            )
        };
        self.voxel_size_mm.iter().try_for_each(|edges| <Volume>::accept_edges("labels", edges))?;
        is_in("step", step, [1.0, 8.0], "voxels")?;
        is_in("smoothing", smoothing, [0.5, 4.0], "voxels")?;
        is_in("tolerance", tolerance, [0.0, 1.0], "voxels")?;
        is_in("largest_grain", self.largest_grain, [0.0, 1.0], "of the volume")?;
        is_in("gap_mm", self.gap_mm, [0.0, 1e3], "mm")?;
        is_in("itz_thickness_mm", self.itz_thickness_mm, [0.0, 1e3], "mm")
    }

    /// Bytes that a volume of so many voxels takes at its most.
    pub fn bytes(counts: [usize; 3]) -> f64 {
        VOXEL_BYTES * counts.iter().map(|count| *count as f64).product::<f64>()
    }

    /// The core in the volume, if labels lie outside of one.
    fn drilled(&self, volume: &Volume<u16>, edges_mm: [f64; 3]) -> Result<Option<Drilled>, LabelsError> {
        if self.outside.is_empty() {
            return Ok(None);
        }
        let found = drilled::find(volume, &self.outside, edges_mm).map_err(|why| match why {
            NoCore::Nothing => LabelsError::NoCore(None),
            NoCore::Off(off) => LabelsError::NoCore(Some(off)),
        })?;
        let counts = found.volume.counts;
        if counts.iter().any(|count| *count < LEAST_COUNT) {
            Err(LabelsError::Flat { counts })
        } else {
            Ok(Some(found))
        }
    }

    /// Asks about labels that are hardly grains, before any surface is made.
    fn ask(&self, volume: &Volume<u16>, roles: &Roles, voxels: f64, parts: &LabelledGrains) -> Result<(), LabelsError> {
        let around = parts.surrounded();
        let mut surrounds = vec![0; parts.grains.len()];
        around.iter().flatten().for_each(|&number| surrounds[number as usize - 1] += 1);
        let embeds = |grain: &LabelledGrain| self.embeds(volume, roles, parts, grain);
        let is_open =
            |grain: &LabelledGrain| self.largest_grain < 1.0 && grain.from == [0; 3] && grain.to == volume.counts;
        let is_large = |grain: &LabelledGrain| grain.voxels as f64 > self.largest_grain * voxels;
        let all = || parts.grains.iter().zip(&surrounds);
        let asked = all().filter(|(grain, count)| **count > 0 || is_open(grain) || is_large(grain) || embeds(grain));
        let Some((grain, count)) = asked.clone().max_by_key(|(grain, count)| (**count, grain.voxels)) else {
            return Ok(());
        };
        let is_of_any_size = asked.clone().any(|(grain, _)| is_open(grain) || !is_large(grain));
        let asked: Vec<i64> = asked.map(|(grain, _)| grain.label).collect();
        let percent = 100.0 * grain.voxels as f64 / voxels;
        // The label with those that it surrounds anywhere.
        let within = parts.grains.iter().zip(&around).filter_map(|(inner, &outer)| Some((inner.label, outer?)));
        let within = within.filter(|(_, outer)| parts.grains[*outer as usize - 1].label == grain.label);
        let phase: BTreeSet<i64> = within.map(|(label, _)| label).chain([grain.label]).collect();
        Err(LabelsError::Mortar {
            label: grain.label,
            percent,
            surrounds: *count,
            is_open: is_open(grain),
            embeds: !is_large(grain) && embeds(grain),
            mortar: self.with_mortar(&volume.labels, &asked),
            otherwise: match count {
                0 if is_of_any_size => Otherwise::Grains(1.0),
                0 => Otherwise::Grains(((percent + 1.0).ceil() / 100.0).min(1.0)),
                _ if phase.len() <= PHASE => Otherwise::Phase(phase.into_iter().collect()),
                _ => Otherwise::Nothing,
            },
        })
    }

    /// Whether a grain has most of what is labelled, and the rest, of two labels or more, lies in its box: mortar in air is
    /// like that, however small its share of the volume and its grains are.
    fn embeds(&self, volume: &Volume<u16>, roles: &Roles, parts: &LabelledGrains, grain: &LabelledGrain) -> bool {
        let labelled = parts.grains.iter().map(|part| part.voxels).sum::<usize>() + parts.dropped[1];
        if grain.voxels as f64 <= MOST.max(self.largest_grain) * labelled as f64 {
            return false;
        }
        let values = roles.values(&volume.labels);
        let own = volume.labels.binary_search(&grain.label).map_or(0, |place| values[place]);
        let mut within = vec![[0_usize; 2]; volume.labels.len()];
        for (voxel, &label) in volume.of.iter().enumerate() {
            let at = parts.at(voxel);
            let is_in = (0..3).all(|axis| (grain.from[axis]..grain.to[axis]).contains(&at[axis]));
            within[usize::from(label)][usize::from(is_in)] += 1;
        }
        let others = || within.iter().zip(&values).filter(|(_, value)| **value != 0 && **value != own);
        let [out, inside] = others().fold([0, 0], |sum, (counts, _)| [sum[0] + counts[0], sum[1] + counts[1]]);
        others().filter(|(counts, _)| counts[1] > 0).count() > 1 && inside as f64 >= NEARLY * (out + inside) as f64
    }

    /// The labels of the mortar if those asked about belong to it.
    fn with_mortar(&self, labels: &[i64], asked: &[i64]) -> Vec<i64> {
        let is_left = |label: &&i64| !self.roles.mortar.contains(label) && !asked.contains(label);
        let given = if labels.iter().any(|label| is_left(&label)) { &self.roles.mortar[..] } else { &[] };
        let mut mortar: Vec<i64> = given.iter().chain(asked).copied().filter(|label| labels.contains(label)).collect();
        mortar.sort_unstable();
        mortar.dedup();
        mortar
    }

    /// Edges of a voxel along x, y, z, mm.
    fn edges_mm(&self, volume: &Volume<u16>) -> [f64; 3] {
        self.voxel_size_mm.or(volume.spacing_mm).unwrap_or([1.0; 3])
    }

    /// Refuses a volume that is no specimen.
    fn accept(&self, volume: &Volume<u16>) -> Result<(), LabelsError> {
        let (edges, counts) = (self.edges_mm(volume), volume.counts);
        Self { voxel_size_mm: Some(edges), ..self.clone() }.validate()?;
        if counts.iter().any(|count| *count < LEAST_COUNT) {
            return Err(LabelsError::Flat { counts });
        }
        for (edge, count) in edges.into_iter().zip(counts) {
            let fits = edge * count as f64 <= MAX_LENGTH_MM;
            let accepted = format!("{count} of them may be {MAX_LENGTH_MM:e} mm long");
            Ranges("labels").require("voxel_size_mm", edge, fits, accepted)?;
        }
        if u32::try_from(volume.of.len() + 1).is_err() {
            return Err(LabelsError::Long { voxels: volume.of.len() });
        }
        let Roles { mortar, aggregate } = &self.roles;
        let is_named = |label: &i64| mortar.contains(label) || !aggregate.is_empty();
        if let Some(&label) = volume.labels.iter().find(|label| **label < 0 && !is_named(label)) {
            return Err(LabelsError::Negative { label });
        }
        // Mortar that is not there is no fault: 0 is named by default.
        let given = mortar.iter().filter(|label| **label != 0).map(|label| ("mortar", label));
        let outside = self.outside.iter().map(|label| ("outside", label));
        let mut named = given.chain(aggregate.iter().map(|label| ("aggregate", label))).chain(outside);
        match named.find(|(_, label)| volume.labels.binary_search(label).is_err()) {
            Some((key, &label)) => Err(LabelsError::Absent { key, label, labels: listed(&volume.labels) }),
            None => Ok(()),
        }
    }
}

/// The first labels in words.
fn listed(labels: &[i64]) -> String {
    let first: Vec<String> = labels.iter().take(8).map(i64::to_string).collect();
    let rest = if labels.len() > first.len() { " and so on" } else { "" };
    format!("{}{rest}", first.join(", "))
}

/// The model of a label volume. Its aggregates are in the order of their labels, those of one label from the largest.
///
/// # Errors
/// See [`LabelsError`].
pub fn of_labels(volume: &Volume<u16>, options: &LabelOptions, watch: &dyn Watch) -> Result<Model, LabelsError> {
    options.accept(volume)?;
    watch.stage(Stage::Take, 0.0);
    let spacing = options.edges_mm(volume);
    let drilled = options.drilled(volume, spacing)?;
    let volume = drilled.as_ref().map_or(volume, |drilled| &drilled.volume);
    let mut roles = options.roles.clone();
    roles.mortar.extend(&options.outside);
    let mut parts = LabelledGrains::of(volume, &roles, options.least_voxels);
    let specks = parts.dropped;
    let voxels = drilled.as_ref().map_or(volume.of.len(), |drilled| drilled.voxels) as f64;
    let kept: usize = parts.grains.iter().map(|part| part.voxels).sum();
    if volume.labels.len() > GREY && specks[1] > kept {
        let percent = 100.0 * specks[1] as f64 / voxels;
        return Err(LabelsError::Grey { labels: volume.labels.len(), percent, least: options.least_voxels });
    }
    if parts.grains.is_empty() {
        return Err(LabelsError::NoGrains { least: options.least_voxels, dropped: specks[0] });
    }
    let [filled, hollow_voxels] = parts.fill_hollows();
    options.ask(volume, &roles, voxels, &parts)?;
    let round = drilled.as_ref().map(|drilled| drilled.round);
    let surfaces = GrainSurfaces::new(&parts, spacing, options.surfaces).within(round).apart(options.gap_mm);
    let meshes = surfaces.all(watch)?;
    let gone = || parts.grains.iter().zip(&meshes).filter(|(_, mesh)| mesh.is_none()).map(|(part, _)| part.voxels);
    let dropped = specks[1] + gone().sum::<usize>();
    let kept = || parts.grains.iter().zip(&meshes).filter_map(|(part, mesh)| Some((part, mesh.as_ref()?)));
    // Grains that vanished are apart from nothing.
    let is_left = |number: u32| meshes[number as usize - 1].is_some();
    let report = LabelReport {
        voxels: volume.counts,
        voxel_size_mm: spacing,
        labels: kept().map(|(part, _)| part.label).collect(),
        fraction: kept().map(|(part, _)| part.voxels as f64).sum::<f64>() / voxels,
        farthest_mm: surfaces.farthest(&meshes),
        separated_pairs: parts.touching_pairs().into_iter().filter(|&(a, b)| is_left(a) && is_left(b)).count(),
        dropped: specks[0] + gone().count(),
        dropped_fraction: dropped as f64 / voxels,
        lost_fraction: 0.0,
        filled,
        filled_fraction: hollow_voxels as f64 / voxels,
        core: drilled.as_ref().map(|drilled| CoreReport {
            outside: options.outside.clone(),
            diameter_mm: 2.0 * drilled.round.radius_mm,
            voxels: drilled.voxels,
            off_fraction: drilled.off,
            pores_fraction: drilled.pores,
        }),
    };
    let surfaces: Vec<&TriangleMesh> = kept().map(|(_, mesh)| mesh).collect();
    if surfaces.is_empty() {
        return Err(LabelsError::Vanished);
    }
    // A cylinder's own frame begins at the corner of its box.
    let way = round.map(|CoreCylinder { centre_mm: [x, y], radius_mm }| Vec3::new(radius_mm - x, radius_mm - y, 0.0));
    let body = |mesh: &&TriangleMesh| {
        way.map_or_else(|| Polyhedron::of_surface(mesh), |way| Polyhedron::of_surface(&moved(mesh, way)))
    };
    let bodies = parallel::map_each(&surfaces, body);
    Ok(assembled(bodies, volume.counts, spacing, options.itz_thickness_mm, report)?)
}

fn moved(mesh: &TriangleMesh, way: Vec3) -> TriangleMesh {
    TriangleMesh {
        vertices: mesh.vertices.iter().map(|vertex| vertex + way).collect(),
        triangles: mesh.triangles.clone(),
    }
}

/// The model of these bodies, in a box of so many voxels: everything in it but their places follows from them.
///
/// # Errors
/// Bodies that no spec can describe.
pub(crate) fn assembled(
    bodies: Vec<Polyhedron>,
    counts: [usize; 3],
    spacing: [f64; 3],
    itz: f64,
    labels: LabelReport,
) -> Result<Model, SpecError> {
    let sizes = parallel::map_each(&bodies, Polyhedron::sieve_size);
    let volumes: Vec<f64> = bodies.iter().map(Polyhedron::volume).collect();
    let grading = measured(&sizes, &volumes);
    let classes = grading.classes();
    let class = |size: f64| classes.iter().position(|class| size <= class.d_max_mm).unwrap_or(classes.len() - 1) as u16;
    let aggregate = |(id, body): (usize, Polyhedron)| Aggregate {
        id: id as u32,
        kind: Kind::Aggregate,
        own: None,
        class: class(sizes[id]),
        itz_thickness_mm: 0.0,
        shells: Vec::new(),
        body,
    };
    let mut aggregates: Vec<Aggregate> = bodies.into_iter().enumerate().map(aggregate).collect();
    let size_mm = [0, 1, 2].map(|axis| counts[axis] as f64 * spacing[axis]);
    let specimen = match &labels.core {
        Some(core) => Specimen::Cylinder { diameter_mm: core.diameter_mm, height_mm: size_mm[2] },
        None => Specimen::cuboid(size_mm),
    };
    mark_caps(&mut aggregates, &specimen);
    let most = |body: &Polyhedron| if itz > 0.0 { itz.min(ITZ_LIMIT * body.skin(itz).deepest().1) } else { 0.0 };
    parallel::each_mut(&mut aggregates, |_, grain| grain.itz_thickness_mm = most(&grain.body));
    let limited = aggregates.iter().filter(|grain| grain.itz_thickness_mm < itz).map(|grain| grain.id).collect();
    let is_thin = |grain: &Aggregate| grain.itz_thickness_mm > 0.0 && grain.body.is_thin(grain.itz_thickness_mm);
    let itz_thin = parallel::filter(aggregates.len(), |id| is_thin(&aggregates[id]));
    let fraction = volumes.iter().sum::<f64>() / specimen.volume();
    let spec = Spec { fraction, specimen, grading, itz: Itz { thickness_mm: [itz; 2] }, ..Spec::default() };
    spec.validate_described(&Silent)?;
    // What the grains had in the labels, and have not here.
    let had = labels.fraction + labels.dropped_fraction;
    let have = volumes.iter().sum::<f64>() / (labels.whole() * spacing.iter().product::<f64>());
    let labels = LabelReport { lost_fraction: (had - have).max(0.0), ..labels };
    let report = Report {
        strategy: STRATEGY.to_owned(),
        grading: spec.grading.describe(),
        stop_reason: StopReason::TargetReached,
        stop_detail: format!("all {} grains of the label volume", aggregates.len()),
        itz_limited: limited,
        itz_thin,
        labels: Some(labels),
        ..Report::of_bodies(&target(&spec), &aggregates, &[])
    };
    Model { spec, aggregates, inclusions: Vec::new(), report }.accepted()
}

/// Name of the strategy in reports: nothing was placed.
const STRATEGY: &str = "label volume";

/// The sieve curve of grains by their sizes and volumes, with the usual sieves as classes.
fn measured(sizes: &[f64], volumes: &[f64]) -> Grading {
    let (low, high) = sizes.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &size| (low.min(size), high.max(size)));
    // At least three digits, so that grains of nanometres have a class.
    let digits = DIGITS.max(10_f64.powi(2 - libm::log10(low).floor() as i32));
    let d_min_mm = (low * digits).floor() / digits;
    let d_max_mm = ((high * digits).ceil() / digits).max(d_min_mm + 1.0 / digits);
    let limits = Grading { d_min_mm, d_max_mm, size: SizeDefinition::Sieve, ..Grading::default() };
    let sieves = limits.usual_classes();
    let total: f64 = volumes.iter().sum();
    let passes =
        |sieve: f64| sizes.iter().zip(volumes).filter(|(size, _)| **size <= sieve).map(|grain| grain.1).sum::<f64>();
    let last = sieves.len() - 1;
    let passing = |(number, sieve): (usize, &f64)| match number {
        0 => 0.0,
        _ if number == last => 1.0,
        _ => (passes(*sieve) / total).min(1.0),
    };
    let curve = Curve::Sieves { sieves_mm: sieves.clone(), passing: sieves.iter().enumerate().map(passing).collect() };
    Grading { curve, classes_mm: sieves, ..limits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::check;
    use crate::model::pack;
    use crate::saved;
    use meso_collision::math::Vec3;
    use meso_concrete::watch::Silent;

    /// Labels of a cube of `count` voxels, by their middles in voxels.
    fn volume(count: usize, label: impl Fn(&Vec3) -> i64) -> Volume<u16> {
        let middle = |i: usize| [i % count, i / count % count, i / (count * count)].map(|x| x as f64 + 0.5);
        let labels = (0..count * count * count).map(|i| label(&Vec3::from(middle(i))));
        Volume::new([count; 3], None, labels.collect::<Vec<_>>()).unwrap()
    }

    /// The case: a file could have voxels of 1 x 1 x 1e-6 mm, the option could not, and `check` refused what was written.
    #[test]
    fn edges_of_a_file_have_the_range_of_the_option_along_each_axis() {
        let ball = balls(20, &[([10.0, 10.0, 10.0], 6.0)]);
        for edge in [1e-6, 2e-5, 9.9e-5, 1e3, 4e4] {
            for edges in [[edge, 1.0, 1.0], [1.0, edge, 1.0], [1.0, 1.0, edge], [edge; 3]] {
                imported(&Volume { spacing_mm: Some(edges), ..ball.clone() }, &LabelOptions::default());
                imported(&ball, &LabelOptions { voxel_size_mm: Some(edges), ..LabelOptions::default() });
            }
        }
        for edge in [9e-7, 6e4, 1.1e6, f64::NAN] {
            let odd = Volume { spacing_mm: Some([1.0, edge, 1.0]), ..ball.clone() };
            let error = of_labels(&odd, &LabelOptions::default(), &Silent).unwrap_err();
            assert!(matches!(error, LabelsError::Option(_)), "{error}");
        }
    }

    /// Balls by middle and radius; the label of the k-th is k + 1.
    fn balls(count: usize, balls: &[([f64; 3], f64)]) -> Volume<u16> {
        let holds = |p: &Vec3, (middle, radius): &([f64; 3], f64)| (p - Vec3::from(*middle)).norm() < *radius;
        volume(count, |p| balls.iter().position(|ball| holds(p, ball)).map_or(0, |k| k as i64 + 1))
    }

    fn imported(volume: &Volume<u16>, options: &LabelOptions) -> Model {
        let model = of_labels(volume, options, &Silent).unwrap();
        assert_eq!(check(&model).findings, []);
        model
    }

    /// Volume of an aggregate over that of its voxels, less one.
    fn error(model: &Model, volume: &Volume<u16>, id: usize) -> f64 {
        let labels = model.report.labels.as_ref().unwrap();
        let number = volume.labels.binary_search(&labels.labels[id]).unwrap();
        let voxels = volume.of.iter().filter(|of| usize::from(**of) == number).count() as f64;
        model.aggregates[id].body.volume() / labels.voxel_size_mm.iter().product::<f64>() / voxels - 1.0
    }

    #[test]
    fn balls_have_the_volume_of_their_voxels_and_a_surface_near_their_own() {
        let volume = balls(40, &[([14.0, 14.0, 14.0], 9.0), ([29.0, 26.0, 25.0], 7.0)]);
        let options = LabelOptions { voxel_size_mm: Some([0.5; 3]), ..LabelOptions::default() };
        let model = imported(&volume, &options);
        assert_eq!(model.aggregates.len(), 2);
        for (id, (middle, radius)) in [(14.0, 9.0), (f64::NAN, 7.0)].into_iter().enumerate() {
            assert!(error(&model, &volume, id).abs() < 0.005, "{}", error(&model, &volume, id));
            let body = &model.aggregates[id].body;
            let middle = if id == 0 { Vec3::repeat(middle) } else { Vec3::new(29.0, 26.0, 25.0) };
            let away = |v: &Vec3| (v * 2.0 - middle).norm() - radius;
            let farthest = body.vertices().iter().map(|v| away(v).abs()).fold(0.0, f64::max);
            assert!(farthest < 0.6, "{farthest} voxels");
        }
        let labels = model.report.labels.unwrap();
        assert_eq!((labels.labels, labels.separated_pairs), (vec![1, 2], 0));
        assert!(labels.farthest_mm > 0.05 && labels.farthest_mm < 0.6, "{}", labels.farthest_mm);
    }

    #[test]
    fn grains_that_touch_in_the_labels_are_apart() {
        let volume = volume(32, |p| match (p.y, p.z) {
            (y, z) if !(6.0..26.0).contains(&y) || !(6.0..26.0).contains(&z) => 0,
            _ if p.x < 6.0 || p.x > 28.0 => 0,
            _ => 1 + i64::from(p.x > 16.0),
        });
        let model = imported(&volume, &LabelOptions::default());
        assert_eq!(model.report.labels.as_ref().unwrap().separated_pairs, 1);
        let [left, right] = [0, 1].map(|id| model.aggregates[id].body.aabb());
        assert!(right.min.x - left.max.x > 0.0 && right.min.x - left.max.x < 1.0);
    }

    #[test]
    fn a_grain_that_a_face_of_the_volume_cuts_ends_there() {
        let volume = balls(32, &[([0.0, 16.0, 16.0], 10.0), ([32.0, 32.0, 16.0], 9.0)]);
        let model = imported(&volume, &LabelOptions::default());
        let boxes = [0, 1].map(|id| model.aggregates[id].body.aabb());
        assert_eq!((boxes[0].min.x, boxes[1].max.x, boxes[1].max.y), (0.0, 32.0, 32.0));
        for id in 0..2 {
            assert!(error(&model, &volume, id).abs() < 0.005, "{}", error(&model, &volume, id));
        }
    }

    #[test]
    fn a_packing_read_back_keeps_its_ids_and_volumes_on_any_number_of_threads() {
        let spec = "fraction = 0.35\nspecimen = { kind = 'cube', side_mm = 40 }\nitz = { thickness_mm = [0, 0] }\n\
            grading = { d_min_mm = 10, d_max_mm = 20 }\n";
        let packed = pack(&Spec::from_toml(spec).unwrap(), &Silent).unwrap();
        let holds = |p: &Vec3| packed.aggregates.iter().position(|aggregate| aggregate.body.contains(p));
        let volume = volume(80, |p| holds(&(p / 2.0)).map_or(-1, |id| id as i64));
        let roles = Roles { mortar: vec![-1], aggregate: Vec::new() };
        let options = LabelOptions { voxel_size_mm: Some([0.5; 3]), roles, ..LabelOptions::default() };
        let model = imported(&volume, &options);
        let labels = model.report.labels.as_ref().unwrap();
        assert_eq!(labels.labels, (0..packed.aggregates.len() as i64).collect::<Vec<_>>());
        assert!((model.report.fraction / labels.fraction - 1.0).abs() < 0.005);
        assert!((model.report.fraction / packed.report.fraction - 1.0).abs() < 0.01);
        let bytes = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut out = Vec::new();
            saved::write(&pool.install(|| of_labels(&volume, &options, &Silent)).unwrap(), &mut out).unwrap();
            out
        };
        let alone = bytes(1);
        assert!(alone == bytes(3));
        assert!(saved::read(&alone).unwrap() == model);
    }

    #[test]
    fn hollows_are_filled_and_counted() {
        let ball = |p: &Vec3, x: f64| (p - Vec3::new(x, 16.0, 16.0)).norm();
        let volume = volume(32, |p| match (ball(p, 9.0), ball(p, 25.0)) {
            (r, _) if r < 7.0 => i64::from(r > 3.0),
            (_, r) if r < 5.0 => 2,
            _ => 0,
        });
        let model = imported(&volume, &LabelOptions::default());
        let labels = model.report.labels.as_ref().unwrap();
        let middle = |i: usize| Vec3::from([i % 32, i / 32 % 32, i / 1024].map(|x| x as f64 + 0.5));
        let within = |radius: f64| (0..32_768).filter(|&i| ball(&middle(i), 9.0) <= radius).count() as f64;
        assert_eq!((labels.filled, labels.filled_fraction), (1, within(3.0) / 32_768.0));
        // The surface is that of the whole ball; faces of the hollow would be 4 voxels from it.
        let body = model.aggregates[0].body.volume();
        assert!((body / within(7.0) - 1.0).abs() < 0.005 && labels.farthest_mm < 1.0, "{body} {}", labels.farthest_mm);
        assert!((model.report.fraction / labels.fraction - 1.0).abs() < 0.005);
    }

    #[test]
    fn core_and_itz_are_one_phase_whose_parts_are_grains() {
        let depth = |p: &Vec3, x: f64, r: f64| r - (p - Vec3::new(x, 15.0, 15.0)).norm();
        let volume = volume(30, |p| match depth(p, 8.0, 6.5).max(depth(p, 22.0, 6.0)) {
            depth if depth > 1.5 => 0,
            depth if depth > 0.0 => 1,
            _ => 2,
        });
        let roles = Roles { mortar: Vec::new(), aggregate: vec![0, 1] };
        let options = LabelOptions { roles, itz_thickness_mm: 1.0, ..LabelOptions::default() };
        let model = imported(&volume, &options);
        assert_eq!(model.aggregates.len(), 2);
        assert!(model.aggregates[0].body.volume() > model.aggregates[1].body.volume());
        assert_eq!(model.aggregates[0].itz_thickness_mm, 1.0);
        assert!(model.report.itz_limited.is_empty());
    }

    #[test]
    fn volumes_that_are_no_specimen_are_refused_with_a_remedy() {
        let refused =
            |volume: &Volume<u16>, options: LabelOptions| of_labels(volume, &options, &Silent).unwrap_err().to_string();
        let usual = LabelOptions::default;
        let one = balls(20, &[([10.0, 10.0, 10.0], 5.0)]);
        let flat = Volume::new([20, 20, 1], None, vec![1; 400]).unwrap();
        assert!(refused(&flat, usual()).contains("20 x 20 x 1 voxels"));
        let filled = volume(8, |_| 1);
        assert!(
            refused(&filled, usual()).contains("label 1 is 100 % of the volume in one part, which reaches all faces")
        );
        assert!(refused(&volume(8, |_| 0), usual()).contains("no grain of 64 voxels"));
        assert!(refused(&volume(8, |p| -i64::from(p.x < 4.0)), usual()).contains("the label -1"));
        let mortar = |labels: &[i64]| Roles { mortar: labels.to_vec(), aggregate: Vec::new() };
        let absent = LabelOptions { roles: mortar(&[7]), ..usual() };
        assert!(refused(&one, absent).contains("mortar names 7"));
        let size = LabelOptions { voxel_size_mm: Some([0.0; 3]), ..usual() };
        assert!(refused(&one, size).starts_with("labels.voxel_size_mm is 0"));
        let step = LabelOptions { surfaces: SmoothOptions { step: 9.0, ..SmoothOptions::default() }, ..usual() };
        assert!(refused(&one, step).starts_with("labels.step is 9"));
        // A ball in the hollow of another, which the surface of that one fills.
        let shell = volume(30, |p| match (p - Vec3::repeat(15.0)).norm() {
            r if r < 6.0 => 2,
            r if r < 9.0 => 0,
            r if r < 13.0 => 1,
            _ => 0,
        });
        assert!(refused(&shell, usual()).starts_with("label 1 is 23 % of the volume in one part: is it mortar?"));
        let insisting = LabelOptions { largest_grain: 1.0, ..usual() };
        assert!(refused(&shell, insisting).contains("encloses"));
    }
}
