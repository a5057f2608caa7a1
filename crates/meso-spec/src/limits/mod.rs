//! Values that cannot be, named before any work starts and before anything is allocated.

mod coatings;
mod crowding;
mod grading;
mod inclusions;
mod phases;
mod slender;

use super::messages::{at_most, number};
use super::{Spec, SpecError};
use grading::grading;
pub(super) use inclusions::RANDOM_RODS;
use meso_concrete::aggregate::{AspectRatio, Grading, Itz, Shape, ShapeKind, Template};
use meso_concrete::short;
use meso_concrete::specimen::{ContainerError, Specimen};
use meso_concrete::watch::{Silent, Waiting, Watch};
use meso_place::Placement;

/// Smallest length a spec may name, mm: finer than any aggregate, far above the reach of rounding.
pub(crate) const MIN_LENGTH_MM: f64 = 1e-3;
/// Smallest length of grains and of a box that were found in voxels of nanometres, mm.
const MIN_FOUND_MM: f64 = 1e-5;
/// Largest length a spec may name, mm (a kilometre).
pub const MAX_LENGTH_MM: f64 = 1e6;
/// Most aggregates a spec may ask for; about 1.3 KB each while they are placed, so 13 GB.
pub(crate) const MAX_AGGREGATES: f64 = 1e7;

pub(crate) const TIME_LIMIT: &str = "placement.time_limit_s";
/// Most corners of a specimen's surface.
const MAX_VERTICES: usize = 1_000_000;

pub(super) type Checked = Result<(), SpecError>;

impl Spec {
    /// Names the first invalid value: its key, the value, the accepted range and the way out.
    ///
    /// # Errors
    /// See [`SpecError`].
    pub fn validate(&self) -> Result<(), SpecError> {
        self.validate_while(&Silent)
    }

    /// Validates like [`Spec::validate`]; the proof of a surface reports to `watch`, and ends at the time limit.
    pub fn validate_while(&self, watch: &dyn Watch) -> Result<(), SpecError> {
        self.validate_values(watch, MIN_LENGTH_MM)?;
        leaves_a_core(&self.itz, &self.grading)?;
        largest_fits(self)?;
        count(self)?;
        phases::check(self)?;
        phases::check_shells(self)?;
        inclusions::check(self)
    }

    /// Validates the spec that describes grains which were found, in a label volume: their largest may be as thick as the
    /// specimen or thicker than a slab, and all may be thinner than any that is packed.
    ///
    /// # Errors
    /// See [`SpecError`].
    pub fn validate_described(&self, watch: &dyn Watch) -> Result<(), SpecError> {
        self.validate_values(watch, MIN_FOUND_MM)?;
        phases::check(self)?;
        if !self.shape.shells.is_empty() {
            return Err(SpecError::value("shape.shells", "are of packed grains; grains that were found have none"));
        }
        inclusions::check(self)
    }

    /// Validates the fraction and the placement, whose ranges depend on no other value.
    ///
    /// # Errors
    /// See [`SpecError`].
    pub fn validate_over(&self) -> Result<(), SpecError> {
        fraction(self.fraction)?;
        placement(&self.placement)
    }

    fn validate_values(&self, watch: &dyn Watch, least_mm: f64) -> Result<(), SpecError> {
        self.validate_over()?;
        let deadline = self.placement.deadline(watch.began());
        specimen(&self.specimen, least_mm, Waiting { watch, deadline }).map_err(|error| self.with_limit(error))?;
        grading(&self.grading, least_mm)?;
        shape(&self.shape)?;
        itz(&self.itz)
    }

    /// An error of the time limit says how long that is.
    fn with_limit(&self, error: SpecError) -> SpecError {
        if !error.is_late {
            return error;
        }
        let limit = number(self.placement.time_limit_s.unwrap_or(f64::INFINITY));
        let message = format!("is {limit}, which was over before the specimen's surface was proved: {}", error.message);
        SpecError { message, ..error }
    }

    /// Finds the fault of an aggregate `longest` mm long in a periodic specimen: it would meet its own
    /// image.
    pub fn meets_own_image(&self, longest: f64) -> Option<SpecError> {
        let (period, gap) = (self.specimen.period(), self.placement.min_gap_mm);
        let length = (0..3).filter_map(|axis| period.along(axis)).find(|length| longest + gap >= *length)?;
        let message = format!(
            "makes aggregates up to {} long, and the specimen is periodic after {}: they would meet their own images; \
             take smaller aggregates or a larger specimen",
            number((longest * 1e3).ceil() / 1e3),
            number(length)
        );
        Some(SpecError::value("grading.d_max_mm", message))
    }

    /// Estimated number of aggregates that the spec asks for, from mean sizes and aspect ratios.
    pub fn estimated_aggregates(&self) -> f64 {
        let mean_shape = mean_volume(&self.shape);
        let volume = self.fraction * self.specimen.volume();
        let classes = self.grading.classes().into_iter();
        classes
            .map(|class| {
                let (low, high) = (class.d_min_mm, class.d_max_mm);
                let mean_cube = self.grading.size_law.mean_cube(low, high);
                volume * class.share / (mean_cube * mean_shape)
            })
            .sum()
    }
}

fn fraction(value: f64) -> Checked {
    share("fraction", "aggregate", value)
}

/// Checks the share of the specimen's volume that a phase takes; `what` names the phase.
pub(super) fn share(key: &str, what: &str, value: f64) -> Checked {
    let accepted = format!("the accepted range is above 0 and below 1 ({what} volume over specimen volume)");
    if value > 0.0 && value < 1.0 {
        return Ok(());
    }
    if (2.0..100.0).contains(&value) {
        let share = number(short(value / 100.0));
        return Err(SpecError::value(
            key,
            format!("is {}; {accepted}: for {} % write {share}", number(value), number(value)),
        ));
    }
    Err(SpecError::value(key, format!("is {}; {accepted}", number(value))))
}

fn specimen(specimen: &Specimen, least_mm: f64, waiting: Waiting<'_>) -> Checked {
    let lengths =
        |named: &[(&str, f64)]| named.iter().try_for_each(|(key, mm)| length(&format!("specimen.{key}"), *mm));
    let edge = |mm: f64| within("specimen.size_mm", mm, least_mm, MAX_LENGTH_MM);
    match specimen {
        Specimen::Cube { side_mm, .. } => lengths(&[("side_mm", *side_mm)]),
        Specimen::Box { size_mm, .. } => size_mm.iter().try_for_each(|mm| edge(*mm)),
        &Specimen::Prism { length_mm, width_mm, depth_mm } => {
            lengths(&[("length_mm", length_mm), ("width_mm", width_mm), ("depth_mm", depth_mm)])
        }
        &Specimen::Cylinder { diameter_mm, height_mm } => {
            lengths(&[("diameter_mm", diameter_mm), ("height_mm", height_mm)])
        }
        Specimen::Sphere { diameter_mm } => lengths(&[("diameter_mm", *diameter_mm)]),
        &Specimen::NotchedPrism {
            length_mm,
            width_mm,
            depth_mm,
            notch_depth_mm,
            notch_width_mm,
            upper_notch_depth_mm,
            notch_at_mm,
        } => {
            lengths(&[("length_mm", length_mm), ("width_mm", width_mm), ("depth_mm", depth_mm)])?;
            lengths(&[("notch_depth_mm", notch_depth_mm), ("notch_width_mm", notch_width_mm)])?;
            below("specimen.notch_depth_mm", notch_depth_mm, "the prism is only", depth_mm, "deep")?;
            if upper_notch_depth_mm != 0.0 {
                lengths(&[("upper_notch_depth_mm", upper_notch_depth_mm)])?;
                let (key, left) = ("specimen.upper_notch_depth_mm", depth_mm - notch_depth_mm);
                below(key, upper_notch_depth_mm, "the prism above its lower notch is only", left, "deep")?;
            }
            below("specimen.notch_width_mm", notch_width_mm, "the prism is only", length_mm, "long")?;
            let left = 0.5 * (length_mm - notch_width_mm);
            below(
                "specimen.notch_at_mm",
                notch_at_mm.abs(),
                "from the middle to the end the notch has only",
                left,
                "mm",
            )
        }
        Specimen::Dogbone { .. } => dogbone(specimen),
        Specimen::Polyhedron { vertices_mm } | Specimen::Mesh { vertices_mm, .. } => {
            points(specimen, vertices_mm, waiting)
        }
    }
}

fn below(key: &str, value: f64, whole: &str, limit: f64, what: &str) -> Checked {
    if value < limit {
        return Ok(());
    }
    let message = format!("is {} but {whole} {} {what}; it must be less", number(value), number(limit));
    Err(SpecError::value(key, message))
}

/// A neck narrower than the ends, arcs that reach from one to the other, and space for them.
fn dogbone(specimen: &Specimen) -> Checked {
    let &Specimen::Dogbone { length_mm, width_mm, thickness_mm, neck_width_mm, neck_length_mm, radius_mm } = specimen
    else {
        return Ok(());
    };
    let named = [
        ("specimen.length_mm", length_mm),
        ("specimen.width_mm", width_mm),
        ("specimen.thickness_mm", thickness_mm),
        ("specimen.neck_width_mm", neck_width_mm),
        ("specimen.radius_mm", radius_mm),
    ];
    named.into_iter().try_for_each(|(key, value)| length(key, value))?;
    within("specimen.neck_length_mm", neck_length_mm, 0.0, MAX_LENGTH_MM)?;
    below("specimen.neck_width_mm", neck_width_mm, "the dog-bone is only", width_mm, "wide")?;
    let rise = (width_mm - neck_width_mm) / 2.0;
    if radius_mm < rise {
        let message = format!(
            "is {} but the arcs rise by {} on either side; the radius must be at least that",
            number(radius_mm),
            number(rise)
        );
        return Err(SpecError::value("specimen.radius_mm", message));
    }
    let needed = neck_length_mm + 2.0 * specimen.arc_run().unwrap_or(f64::INFINITY);
    // An arc's length is a root: 1e-9 is far more than it errs.
    if needed > length_mm * (1.0 + 1e-9) {
        let message =
            format!("is {} but the neck and its arcs take {}; lengthen it", number(length_mm), number(needed));
        return Err(SpecError::value("specimen.length_mm", message));
    }
    Ok(())
}

/// Points within reach that enclose something.
fn points(specimen: &Specimen, vertices: &[[f64; 3]], waiting: Waiting<'_>) -> Checked {
    const KEY: &str = "specimen.vertices_mm";
    if vertices.len() > MAX_VERTICES {
        let message = format!("has {} points; at most {MAX_VERTICES} are accepted: simplify it", vertices.len());
        return Err(SpecError::value(KEY, message));
    }
    vertices.iter().flatten().try_for_each(|x| within(KEY, *x, -MAX_LENGTH_MM, MAX_LENGTH_MM))?;
    let key = if matches!(specimen, Specimen::Mesh { .. }) { "specimen.triangles" } else { KEY };
    let container = specimen.check_while(waiting).map_err(|error| match error {
        ContainerError::Late { .. } => SpecError { is_late: true, ..SpecError::value(TIME_LIMIT, error.to_string()) },
        ContainerError::Crossing { .. } | ContainerError::Nested { .. } => {
            SpecError::value(key, format!("are not the surface of a body: {error}"))
        }
        _ => SpecError::value(key, format!("enclose nothing: {error}")),
    })?;
    container.aabb().size().iter().try_for_each(|edge| length(KEY, *edge))
}

fn shape(shape: &Shape) -> Checked {
    let [fewest, most] = shape.vertices;
    let least = shape.kind.fewest_vertices();
    if fewest < least || most > 1000 {
        let message = format!("is [{fewest}, {most}]; the accepted range is {least} to 1000 for grains of this kind");
        return Err(SpecError::value("shape.vertices", message));
    }
    if fewest > most {
        let message = format!("is [{fewest}, {most}]; the fewest come first");
        return Err(SpecError::value("shape.vertices", message));
    }
    library(shape)?;
    aspect_ratio("shape.elongation", &shape.elongation)?;
    aspect_ratio("shape.flatness", &shape.flatness)
}

/// Grains belong to a library, and a library has some.
fn library(shape: &Shape) -> Checked {
    match (shape.kind, shape.grains.len()) {
        (ShapeKind::Library, 0) => {
            let message = "is missing; name a folder of grains, or a file that ends in .stl, .ply, .obj, .off or .json (or give the vertices as grains)";
            Err(SpecError::value("shape.library", message))
        }
        (ShapeKind::Library, _) | (_, 0) => Ok(()),
        _ => Err(SpecError::value("shape.grains", "counts only for kind = \"library\"; leave out one of the two")),
    }
}

fn aspect_ratio(key: &str, law: &AspectRatio) -> Checked {
    let ratio = |name: &str, value| within(&format!("{key}.{name}"), value, 0.05, 1.0);
    let limits = |min: f64, max: f64| {
        ratio("min", min)?;
        ratio("max", max)?;
        if min > max {
            let message = format!("is {} but {key}.max is {}; the limits must ascend", number(min), number(max));
            return Err(SpecError::value(format!("{key}.min"), message));
        }
        Ok(())
    };
    match *law {
        AspectRatio::Constant { value } => ratio("value", value),
        AspectRatio::Uniform { min, max } => limits(min, max),
        AspectRatio::Normal { mean, sd, min, max } => {
            limits(min, max)?;
            within(&format!("{key}.mean"), mean, min, max)?;
            // Values outside the limits are redrawn: a far wider law would redraw without end.
            within(&format!("{key}.sd"), sd, 0.0, 10.0 * (max - min))
        }
    }
}

/// Volume of a grain whose longest axis is 1 long, roughly.
pub(super) fn mean_volume(shape: &Shape) -> f64 {
    if shape.kind == ShapeKind::Library {
        return shape.grains.iter().map(Template::relative_volume).sum::<f64>() / shape.grains.len() as f64;
    }
    if shape.kind == ShapeKind::Sphere {
        return std::f64::consts::PI / 6.0;
    }
    let ellipsoid = mean(&shape.elongation).powi(2) * mean(&shape.flatness) * std::f64::consts::PI / 6.0;
    ellipsoid * shape.kind.mean_hull_over_ellipsoid()
}

fn mean(law: &AspectRatio) -> f64 {
    match *law {
        AspectRatio::Normal { mean, .. } => mean,
        AspectRatio::Uniform { min, max } => (min + max) / 2.0,
        AspectRatio::Constant { value } => value,
    }
}

const ITZ: &str = "itz.thickness_mm";

fn itz(itz: &Itz) -> Checked {
    itz.thickness_mm.iter().try_for_each(|&thickness| within(ITZ, thickness, 0.0, MAX_LENGTH_MM))?;
    in_order(ITZ, itz.thickness_mm)
}

/// Shells thinner than half of the smallest aggregate leave a core in it.
fn leaves_a_core(itz: &Itz, grading: &Grading) -> Checked {
    let [_, high] = itz.thickness_mm;
    if high * 2.0 < grading.d_min_mm {
        return Ok(());
    }
    let message = format!(
        "reaches {} but the smallest aggregate is {} thick at most; a shell of half of it leaves no aggregate: stay below {}",
        number(high),
        number(grading.d_min_mm),
        number(grading.d_min_mm / 2.0)
    );
    Err(SpecError::value(ITZ, message))
}

fn placement(placement: &Placement) -> Checked {
    if placement.attempts == Some(0) {
        return Err(SpecError::value("placement.attempts", "is 0; the accepted range is 1 to 4294967295"));
    }
    within("placement.surplus", placement.surplus, 0.0, 1.0)?;
    within("placement.min_gap_mm", placement.min_gap_mm, 0.0, MAX_LENGTH_MM)?;
    within("placement.wall_gap_mm", placement.wall_gap_mm, 0.0, MAX_LENGTH_MM)?;
    placement.time_limit_s.map_or(Ok(()), |seconds| within(TIME_LIMIT, seconds, 1e-3, 1e9))
}

/// The largest aggregate fits, with its distance to the walls and to its own images.
fn largest_fits(spec: &Spec) -> Checked {
    let (container, period) = (spec.specimen.container(), spec.specimen.period());
    let (narrowest, gap) = (container.width(), spec.placement.wall_gap_mm);
    let inner = narrowest - 2.0 * gap;
    if inner <= 0.0 {
        let message =
            format!("is {} but the specimen is only {} wide; the walls leave no room", number(gap), at_most(narrowest));
        return Err(SpecError::value("placement.wall_gap_mm", message));
    }
    let shortest = (0..3).filter_map(|axis| period.along(axis)).fold(f64::INFINITY, f64::min);
    let narrowest = narrowest.min(shortest);
    if spec.placement.min_gap_mm >= narrowest {
        let gap = number(spec.placement.min_gap_mm);
        let message = format!("is {gap} but the specimen is only {} wide; the gap must be smaller", at_most(narrowest));
        return Err(SpecError::value("placement.min_gap_mm", message));
    }
    let largest = spec.largest_body_mm();
    if largest > inner {
        let [with, thinner] = if spec.shape.has_coatings() {
            [format!(", with coatings {}", at_most(largest)), ", thinner coatings".to_owned()]
        } else {
            Default::default()
        };
        let message = format!(
            "is {}{with} but the specimen has only {} mm of room; take smaller aggregates{thinner} or a larger specimen{}",
            number(spec.grading.d_max_mm),
            at_most(inner),
            unit_hint(&spec.specimen, container.aabb().size().max())
        );
        return Err(SpecError::value("grading.d_max_mm", message));
    }
    spec.meets_own_image(largest).map_or(Ok(()), Err)
}

/// Specimens of files that are longer than this, mm, are hardly in metres, or in inches.
const LONGEST_IN_METRES: f64 = 3.0;
const LONGEST_IN_INCHES: f64 = 40.0;

/// The unit that a file of so small a specimen may have.
fn unit_hint(specimen: &Specimen, longest: f64) -> String {
    let (unit, scale) = match longest {
        _ if !matches!(specimen, Specimen::Mesh { .. } | Specimen::Polyhedron { .. }) => return String::new(),
        ..=LONGEST_IN_METRES => ("metres", "1000"),
        ..=LONGEST_IN_INCHES => ("inches", "25.4"),
        _ => return String::new(),
    };
    format!(
        "; files have no units, and a longest edge of {} looks like {unit}: give specimen.scale = {scale} beside specimen.file",
        at_most(longest)
    )
}

fn count(spec: &Spec) -> Checked {
    let count = spec.estimated_aggregates();
    if count <= MAX_AGGREGATES {
        return Ok(());
    }
    let message = format!(
        "is {}, which makes about {count:.1e} aggregates in this specimen; at most {MAX_AGGREGATES:.0e} are accepted: \
         raise it, or take a smaller specimen{}",
        number(spec.grading.d_min_mm),
        flattest(&spec.shape)
    );
    Err(SpecError::value("grading.d_min_mm", message))
}

/// Grains thinner than this share of their length have less than a fifth of the volume of stout ones.
const FLAT: f64 = 0.1;

/// A clause about the flattest grain of a library, whose small volume makes for many grains.
fn flattest(shape: &Shape) -> String {
    let thicknesses = shape.grains.iter().map(Template::thickness).enumerate();
    match thicknesses.min_by(|p, q| p.1.total_cmp(&q.1)).filter(|flattest| flattest.1 < FLAT) {
        Some((grain, thickness)) => {
            format!(
                "; grain {grain} of the library, counted from 0, is {thickness:.1e} of its length thick: leave it out"
            )
        }
        None => String::new(),
    }
}

/// Checks the limits of a draw.
pub(super) fn in_order(key: &str, [low, high]: [f64; 2]) -> Checked {
    if low <= high {
        return Ok(());
    }
    Err(SpecError::value(key, format!("is [{}, {}]; the lower limit comes first", number(low), number(high))))
}

pub(super) fn length(key: &str, value: f64) -> Checked {
    within(key, value, MIN_LENGTH_MM, MAX_LENGTH_MM)
}

pub(super) fn within(key: &str, value: f64, low: f64, high: f64) -> Checked {
    if value >= low && value <= high {
        return Ok(());
    }
    let message = format!("is {}; the accepted range is {} to {}", number(value), number(low), number(high));
    Err(SpecError::value(key, message))
}
