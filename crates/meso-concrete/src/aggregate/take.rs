//! The *take*: enough grains of every class, each made from its own random stream (Sec. 2.1).

use super::grain::{Grain, Kind, in_order};
use super::inclusions::{self, Inclusions};
use super::random::{Draw, Stream};
use super::{Grading, Itz, Outline, OwnPhase, Shape, SizeClass, SizeDefinition, kinds};
use crate::parallel;
use crate::stop;
use meso_collision::geometry::{HullError, Round, convex_hull};
use std::collections::BTreeMap;

/// An ITZ takes at most this share of the distance from a grain's centre to its nearest face, so that a core remains.
pub const ITZ_LIMIT: f64 = 0.5;

/// The parts of a spec that the take needs.
#[derive(Clone, Copy)]
pub struct Mixture<'a> {
    /// Sizes of aggregates.
    pub grading: &'a Grading,
    /// Shapes of aggregates.
    pub shape: &'a Shape,
    /// Thickness of the ITZ.
    pub itz: &'a Itz,
    /// Voids and fibres.
    pub inclusions: Inclusions<'a>,
    /// Phases of the specimen's own.
    pub phases: &'a [OwnPhase],
    /// Seed of all streams.
    pub seed: u64,
    /// Called now and then with the volume generated so far, mm3; `false` ends the take with the grains it has.
    pub go_on: &'a (dyn Fn(f64) -> bool + Sync),
}

/// Generates grains of every class until each class holds `fraction * volume * share * (1 + surplus)` mm3, as nearly
/// as whole grains allow, and the further phases likewise; the specimen's `volume` is in mm3. Fibres come first,
/// because nothing else is as long, then everything else in descending volume.
///
/// # Errors
/// A shape without volume.
pub fn take(mixture: &Mixture, fraction: f64, volume: f64, surplus: f64) -> Result<Vec<Grain>, HullError> {
    let (classes, beyond) = (mixture.grading.classes(), 1.0 + surplus);
    let mut grains = Vec::new();
    // Coarse classes come first: if the take ends early, a packing begins with them.
    for (class, limits) in (0..classes.len() as u16).zip(&classes).rev() {
        let target = fraction * volume * limits.share * beyond;
        fill(&mut grains, target, mixture.go_on, |index| make(mixture, class, limits, index))?;
    }
    mark_thin(&mut grains);
    take_inclusions(&mut grains, mixture, classes.len() as u16, volume * beyond)?;
    grains.shrink_to_fit();
    in_order(&mut grains);
    kinds::divide(&mut grains, mixture.phases, &classes);
    Ok(grains)
}

/// Marks grains with dents whose parts are thinner than two of their ITZ. The copy of a surface with the thickest ITZ for its
/// size is asked first: where it has none, no other has.
fn mark_thin(grains: &mut [Grain]) {
    let mut copies: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, template) in grains.iter().enumerate().filter_map(|(number, grain)| Some((number, grain.copy_of()?))) {
        copies.entry(template).or_default().push(number);
    }
    let copies: Vec<Vec<usize>> = copies.into_values().collect();
    let is_thin = |number: &usize| {
        let Grain { itz_thickness_mm, body, .. } = &grains[*number];
        *itz_thickness_mm > 0.0 && body.widened().is_thin(*itz_thickness_mm)
    };
    let share = |number: &usize| grains[*number].itz_thickness_mm / f64::from(grains[*number].outer_radius);
    let thin = parallel::flat_map(copies.len(), |surface| {
        let all = &copies[surface];
        let thickest = all.iter().max_by(|a, b| share(a).total_cmp(&share(b))).filter(|number| is_thin(number));
        let Some(thickest) = thickest else { return Vec::new() };
        all.iter().filter(|number| *number == thickest || is_thin(number)).copied().collect()
    });
    thin.into_iter().for_each(|number| grains[number].itz_thin = true);
}

/// Most grains generated at once: enough to share among threads.
const CHUNK: u32 = 256;
/// Grains generated beyond the number predicted from the mean volume so far.
const SPARE: u32 = 8;

/// Generates grains by number until they hold `target` mm3, and adds them to the `grains`.
fn fill(
    grains: &mut Vec<Grain>,
    target: f64,
    go_on: &(dyn Fn(f64) -> bool + Sync),
    make: impl Fn(u32) -> Result<Grain, HullError> + Sync,
) -> Result<(), HullError> {
    let before: f64 = grains.iter().map(Grain::volume).sum();
    let (mut volume, mut made) = (0.0, 0);
    loop {
        if !go_on(before + volume) {
            return Ok(());
        }
        // With no grain yet this is NaN, and NaN.min(CHUNK) is CHUNK.
        let expected = (target - volume) / volume * f64::from(made);
        let count = CHUNK.min((expected.min(f64::from(CHUNK)) as u32).saturating_add(SPARE));
        let chunk = parallel::try_map(count as usize, |k| make(made + k as u32))?;
        for grain in chunk {
            // The last grain is included when that brings the class nearer to its target.
            if volume + grain.volume() / 2.0 >= target {
                return Ok(());
            }
            volume += grain.volume();
            grains.push(grain);
        }
        made += count;
    }
}

fn make(mixture: &Mixture, class: u16, limits: &SizeClass, index: u32) -> Result<Grain, HullError> {
    stop::point();
    let stream = &mut Stream::new(mixture.seed, Draw::Take, class, u64::from(index));
    let size = mixture.grading.draw(limits, stream);
    let is_sieved = mixture.grading.size == SizeDefinition::Sieve;
    let bare = match mixture.shape.outline(size, limits.d_min_mm, stream) {
        Outline::Hull(mut vertices) => {
            if is_sieved {
                let scale = size / convex_hull(&vertices)?.sieve_size();
                vertices.iter_mut().for_each(|vertex| *vertex *= scale);
            }
            Grain::turned(Kind::Aggregate, (class, index), &vertices, stream)?
        }
        Outline::Dents(template, dents) => {
            let length = if is_sieved { size / dents.sieve_size } else { size };
            Grain { template, ..Grain::dented((class, index), &dents.body, length, stream) }
        }
        Outline::Round(semi_axes) => {
            let scale = if is_sieved { size / Round::of_semi_axes(&semi_axes).sieve_size() } else { 1.0 };
            Grain::round((class, index), &(semi_axes * scale), stream)
        }
    };
    let drawn = stream.uniform(mixture.itz.thickness_mm[0], mixture.itz.thickness_mm[1]);
    let most = ITZ_LIMIT * f64::from(bare.inner_radius);
    Ok(Grain { itz_thickness_mm: drawn.min(most), itz_limited: drawn > most, ..bare })
}

/// Adds voids and fibres for a specimen of `volume` mm3 to the `grains`; their classes begin at `first_class`.
fn take_inclusions(grains: &mut Vec<Grain>, mixture: &Mixture, first_class: u16, volume: f64) -> Result<(), HullError> {
    let Inclusions { voids, fibres } = mixture.inclusions;
    let stream = |class, index: u32| Stream::new(mixture.seed, Draw::Take, class, u64::from(index));
    if let Some(voids) = voids {
        let (ball, class, first) = (inclusions::ball(), first_class, grains.len());
        for diameters in voids.classes().iter().rev() {
            // All voids count as one class, whose numbers go on.
            let before = (grains.len() - first) as u32;
            let ids = |index| (class, before + index);
            let make = |index| voids.grain(&ball, diameters, ids(index), &mut stream(class, before + index));
            fill(grains, voids.fraction * volume * diameters.share, mixture.go_on, make)?;
        }
    }
    if let Some(fibres) = fibres {
        let (prism, class) = (fibres.prism(), first_class + 1);
        let make = |index| fibres.grain(&prism, (class, index), &mut stream(class, index));
        fill(grains, fibres.fraction * volume, mixture.go_on, make)?;
    }
    Ok(())
}
