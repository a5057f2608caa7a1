//! A packed specimen: `pack` returns it, `.json` files hold it, and every other command reads it.

use crate::accept::{self, Fault};
use meso_collision::geometry::HullError;
use meso_concrete::aggregate::Grain;
use meso_concrete::aggregate::take::{Mixture, take};
use meso_concrete::aggregate::{Aggregate, Kind, TooThick, add_shells};
use meso_concrete::specimen::Largest;
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_concrete::{Parts, mark_caps, parallel};
use meso_place::{GrainTally, PackingTarget, Pose, Report, Request, Seconds, Strategy};
use meso_spec::{Spec, SpecError};
use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering};

/// A packed specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Spec that was packed.
    pub spec: Spec,
    /// The aggregates in the specimen's frame, in descending volume; ids count from 0.
    pub aggregates: Vec<Aggregate>,
    /// Voids in descending volume, then fibres; their ids count on. In the report, only [`Report::phases`] counts them.
    pub inclusions: Vec<Aggregate>,
    /// Figures of the packing.
    pub report: Report,
}

/// Generates and places the aggregates that `spec` asks for.
///
/// # Errors
/// A spec that cannot be met is named before any work starts.
pub fn pack(spec: &Spec, watch: &dyn Watch) -> Result<Model, SpecError> {
    let (start, started) = (watch.seconds(), watch.began());
    spec.validate_while(watch)?;
    spec.has_room()?;
    spec.is_reachable_at_random()?;
    let (grains, complete) = take_grains(spec, watch, started)?;
    let largest = largest_body(spec, &grains)?;
    let taken = watch.seconds();
    let Spec { specimen, grading, placement, .. } = spec;
    let target = target(spec);
    let request = Request { target, largest, grains: &grains, placement, watch, started };
    let mut outcome = meso_place::place(&request);
    let tally = GrainTally::of(&grains, &outcome.poses, grading.classes().len(), complete);
    // Every grain is freed as it settles, so that the two lists never coexist in full.
    let (mut aggregates, mut inclusions) = settle(grains, std::mem::take(&mut outcome.poses))?;
    let mut bodies: Vec<&mut Aggregate> = aggregates.iter_mut().chain(&mut inclusions).collect();
    meso_place::keep_off_faces(&mut bodies, specimen, placement.wall_gap_mm);
    mark_caps(&mut aggregates, specimen);
    let placed = watch.seconds();
    let seconds = Seconds { total: placed - start, take: taken - start, place: placed - taken, write: 0.0 };
    let report = meso_place::report(&target, &tally, &outcome, (&aggregates, &inclusions), seconds);
    Model { spec: spec.clone(), aggregates, inclusions, report }.accepted()
}

impl<'a> From<&'a Model> for Parts<'a> {
    fn from(model: &'a Model) -> Self {
        Self { bodies: model.bodies(), specimen: &model.spec.specimen, phases: model.spec.phases() }
    }
}

impl Model {
    /// Accepts a model that can be read back.
    ///
    /// # Errors
    /// The first value that a reader refuses.
    pub fn accept(&self) -> Result<(), Fault> {
        accept::model(&self.spec, &self.aggregates, &self.inclusions, &self.report)
    }

    /// This model, if it can be read back: no product is made of another.
    pub(crate) fn accepted(self) -> Result<Self, SpecError> {
        match self.accept() {
            Ok(()) => Ok(self),
            Err(fault) => Err(SpecError::value("packing", format!("could not be read back: {fault}"))),
        }
    }

    /// All that was placed, aggregates first: the body with id i is the i-th.
    pub fn bodies(&self) -> Cow<'_, [Aggregate]> {
        if self.inclusions.is_empty() {
            return Cow::Borrowed(&self.aggregates);
        }
        Cow::Owned([&self.aggregates[..], &self.inclusions].concat())
    }
}

/// All grains that `spec` takes, to compare a model's bodies with.
///
/// # Errors
/// Shapes without volume.
pub(crate) fn taken(spec: &Spec) -> Result<Vec<Grain>, SpecError> {
    Ok(take_grains(spec, &Silent, 0.0)?.0)
}

/// Target of a packing of `spec`.
pub(crate) fn target(spec: &Spec) -> PackingTarget<'_> {
    let Spec { specimen, fraction, grading, shape, phases, seed, .. } = spec;
    PackingTarget { specimen, fraction: *fraction, grading, shape, inclusions: spec.inclusions(), phases, seed: *seed }
}

/// Upper bounds on a body in the specimen, its distance to the walls kept.
pub(crate) fn largest(spec: &Spec) -> Largest {
    spec.specimen.container().largest().less(spec.placement.wall_gap_mm)
}

/// Upper bounds on a body in the specimen.
///
/// # Errors
/// Grains that meet their own image, and a class of which no grain fits.
fn largest_body(spec: &Spec, grains: &[Grain]) -> Result<Largest, SpecError> {
    let aggregates = grains.iter().filter(|grain| grain.kind == Kind::Aggregate);
    let longest = aggregates.map(|grain| 2.0 * f64::from(grain.outer_radius)).fold(0.0, f64::max);
    if let Some(error) = spec.meets_own_image(longest) {
        return Err(error);
    }
    let largest = largest(spec);
    spec.fits_nowhere(grains, &largest).map_or(Ok(largest), Err)
}

/// The grains that the time allows, and whether these are all.
fn take_grains(spec: &Spec, watch: &dyn Watch, started: f64) -> Result<(Vec<Grain>, bool), SpecError> {
    let deadline = spec.placement.deadline(started);
    let stopped = AtomicBool::new(false);
    let inclusions: f64 = spec.inclusions().fractions().iter().sum();
    let wanted = spec.specimen.volume() * (spec.fraction + inclusions);
    let go_on = |volume: f64| {
        watch.stage(Stage::Take, volume / wanted);
        let go_on = !watch.stops() && watch.seconds() < deadline;
        stopped.fetch_or(!go_on, Ordering::Relaxed);
        go_on
    };
    let Spec { grading, shape, itz, seed, phases, .. } = spec;
    let mixture = Mixture { grading, shape, itz, inclusions: spec.inclusions(), phases, seed: *seed, go_on: &go_on };
    let surplus = if spec.placement.chosen() == Strategy::TakeAndPlace { spec.placement.surplus } else { 0.0 };
    let taken = take(&mixture, spec.fraction, spec.specimen.volume(), surplus);
    let mut grains = taken.map_err(|error| flat_shape(&error))?;
    if !spec.shape.shells.is_empty() {
        add_shells(&mut grains, *seed, grading, |own| spec.shells_of(own)).map_err(|error| too_thick(&error))?;
    }
    if spec.shape.has_coatings() {
        Grain::coat(&mut grains)
            .map_err(|error| SpecError::value("shape.shells", format!("cannot be put around a grain: {error}")))?;
    }
    Ok((grains, !stopped.into_inner()))
}

fn too_thick(error: &TooThick) -> SpecError {
    let TooThick { grains, thickness_mm, radius_mm } = error;
    let found =
        if thickness_mm.is_finite() { format!("{thickness_mm:.3} mm thick") } else { "all of its volume".to_owned() };
    let message = format!(
        "leave no core in {grains} grains: ITZ and shells of the largest of them are {found}, and its centre is \
         {radius_mm:.3} mm from its nearest face; take thinner shells, volume_share, rounder grains, or a phase of larger sizes_mm"
    );
    SpecError::value("shape.shells", message)
}

fn flat_shape(error: &HullError) -> SpecError {
    SpecError::value("shape", format!("gives aggregates without volume: {error}"))
}

/// Grains that settle together, on all threads.
const AT_ONCE: usize = 256;

/// The placed grains in the specimen's frame: aggregates, then inclusions.
fn settle(mut grains: Vec<Grain>, mut poses: Vec<Option<Pose>>) -> Result<(Vec<Aggregate>, Vec<Aggregate>), SpecError> {
    // Grains without a pose are freed first: settled ones take twice the memory.
    let mut is_placed = poses.iter().map(Option::is_some);
    grains.retain(|_| is_placed.next() == Some(true));
    poses.retain(Option::is_some);
    // In the order of allocation: neighbours that are freed leave space for larger ones.
    let mut order: Vec<u32> = (0..grains.len() as u32).collect();
    order.sort_unstable_by_key(|&number| (grains[number as usize].class, grains[number as usize].index));
    arrange(&mut grains, &order);
    arrange(&mut poses, &order);
    let settle = |grain: &Grain, pose: &Option<Pose>, id: u32| -> Result<Aggregate, SpecError> {
        let pose = pose.as_ref().expect("those without a pose are gone");
        let body = pose.apply(&grain.body).map_err(|error| flat_shape(&error))?;
        let &Grain { kind, own, class, itz_thickness_mm, ref shells, .. } = grain;
        Ok(Aggregate { id, kind, own, class, itz_thickness_mm, shells: shells.clone(), body })
    };
    // From the last on, so that these lists shrink as the list of aggregates grows.
    let mut aggregates = Vec::with_capacity(poses.len());
    while !grains.is_empty() {
        let first = grains.len().saturating_sub(AT_ONCE);
        let (several, theirs) = (grains.split_off(first), poses.split_off(first));
        grains.shrink_to_fit();
        poses.shrink_to_fit();
        let settle = |k: usize| settle(&several[k], &theirs[k], order[first + k]);
        aggregates.extend(parallel::try_map(several.len(), settle)?);
    }
    aggregates.sort_unstable_by_key(|aggregate: &Aggregate| aggregate.id);
    let mut inclusions: Vec<Aggregate> = aggregates.extract_if(.., |body| body.kind != Kind::Aggregate).collect();
    inclusions.sort_by_key(|body| body.kind);
    (0..).zip(aggregates.iter_mut().chain(&mut inclusions)).for_each(|(id, body)| body.id = id);
    Ok((aggregates, inclusions))
}

/// Moves the element of number `order[k]` to position `k`, in place.
fn arrange<T>(list: &mut [T], order: &[u32]) {
    let mut from = order.to_vec();
    for start in 0..list.len() {
        let mut at = start;
        loop {
            let next = std::mem::replace(&mut from[at], at as u32) as usize;
            if next == start {
                break;
            }
            list.swap(at, next);
            at = next;
        }
    }
}
