//! Effective properties of label volumes: every voxel has the value of its label.
//!
//! A link has the harmonic mean of two voxels. The exact value of the voxels' geometry has bounds from the solution itself: see
//! `interval`. No coarser volume tells as much, since labels at every second voxel lose layers that are one voxel thick.

mod interval;

use crate::effective::{self, Effective, EffectiveOptions, Medium, PhaseShare};
use crate::elastic::{self, ElasticMedium, ElasticShare, Stiffness, StiffnessOptions, Voxels};
use crate::error::EffectiveError;
use crate::field::PropertyField;
use crate::flow::Flow;
use crate::grid::{End, Grid, Space};
use crate::links::Links;
use crate::moduli::{GivenModuli, Moduli, PhaseModuli, refuse_absent};
use crate::phases::{GivenValues, Phases, Property, SIZES};
use meso_collision::math::Vec3;
use meso_concrete::import::volume::Volume;
use meso_concrete::watch::Watch;
use meso_concrete::{Phase, PhaseNames, Ranges, parallel};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A label volume as a specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelSpecimen {
    /// Labels at the voxels.
    pub volume: Volume,
    /// Edges of a voxel along x, y, z, mm.
    pub spacing_mm: [f64; 3],
    /// Axes along which the volume repeats itself.
    pub periodic: [bool; 3],
}

/// Values of a phases file for labels. The keys of a table are labels, as in `0 = 1.0`; or they are the phases of the images that
/// mesocrete writes, as in `mortar = 1.0`, where omitted phases keep their defaults.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LabelPhases {
    /// Diffusivities, relative to any of them.
    pub diffusivity: BTreeMap<String, f64>,
    /// Conductivities, W/(m K).
    pub conductivity: BTreeMap<String, f64>,
    /// Permeabilities, mm2.
    pub permeability: BTreeMap<String, f64>,
    /// Elastic constants.
    pub stiffness: BTreeMap<String, GivenModuli>,
}

/// The effective property of a label volume, and the fields if asked for. The size of voxels is the volume's.
///
/// # Errors
/// Labels without a value, values out of range, and equations that do not converge.
pub fn effective_of_labels(
    specimen: &LabelSpecimen,
    phases: &LabelPhases,
    options: &EffectiveOptions,
    watch: &dyn Watch,
) -> Result<(Effective, Vec<PropertyField>), EffectiveError> {
    <Volume>::accept_edges("effective", &specimen.spacing_mm)?;
    let volume = &specimen.volume;
    let values = phases.values(options.what, volume)?;
    let (mut found, fields) = effective::of_medium(&Labelled { specimen, of: &values }, volume.counts, options, watch)?;
    found.warnings.extend(surplus(options.what.name(), phases.given(options.what), volume));
    Ok((found, fields))
}

/// The stiffness of a label volume, and the stresses if asked for. The size of voxels is the volume's.
///
/// # Errors
/// Labels without constants, constants out of range, and equations that do not converge.
pub fn stiffness_of_labels(
    specimen: &LabelSpecimen,
    phases: &LabelPhases,
    options: &StiffnessOptions,
    watch: &dyn Watch,
) -> Result<(Stiffness, Vec<PropertyField>), EffectiveError> {
    <Volume>::accept_edges("effective", &specimen.spacing_mm)?;
    let volume = &specimen.volume;
    let moduli = phases.moduli(volume)?;
    let (mut found, fields) = elastic::of_medium(&Labelled { specimen, of: &moduli }, volume.counts, options, watch)?;
    found.warnings.extend(surplus("stiffness", &phases.stiffness, volume));
    Ok((found, fields))
}

impl LabelPhases {
    fn given(&self, property: Property) -> &BTreeMap<String, f64> {
        match property {
            Property::Diffusivity => &self.diffusivity,
            Property::Conductivity => &self.conductivity,
            Property::Permeability => &self.permeability,
        }
    }

    /// Values of `property` by the labels of `volume`.
    ///
    /// # Errors
    /// Labels without a value, names that are none, and values out of range.
    pub fn values(&self, property: Property, volume: &Volume) -> Result<Vec<f64>, EffectiveError> {
        let given = self.given(property);
        let ranges = Ranges(property.name());
        let named = || {
            let mut values = GivenValues::default();
            for (name, value) in given {
                *values.phase_mut(name).ok_or_else(|| unknown(property.name(), name))? = Some(*value);
            }
            let phases = Phases {
                diffusivity: values.clone(),
                conductivity: values.clone(),
                permeability: values,
                ..Phases::default()
            };
            let values = phases.values(property);
            values.validate(property, PhaseNames::COMMON)?;
            Ok(Phase::ALL.map(|phase| values.of(phase, PhaseNames::COMMON)).to_vec())
        };
        let numbered = |label: i64, value: &f64| {
            let met = *value == 0.0 || SIZES.contains(value);
            ranges.require(label.to_string(), *value, met, "it must be 0, or 1e-30 to 1e30")?;
            Ok(*value)
        };
        let values = by_label(property.name(), given, volume, numbered, named)?;
        if values.iter().all(|value| *value == 0.0) {
            return Err(EffectiveError::Nothing(property.name()));
        }
        Ok(values)
    }

    /// Constants by the labels of `volume`.
    ///
    /// # Errors
    /// Labels without constants, names that are none, and constants out of range.
    pub fn moduli(&self, volume: &Volume) -> Result<Vec<Moduli>, EffectiveError> {
        let named = || {
            let mut moduli = PhaseModuli::default();
            for (name, given) in &self.stiffness {
                *moduli.phase_mut(name).ok_or_else(|| unknown("stiffness", name))? = *given;
            }
            Ok(moduli.table(PhaseNames::COMMON)?)
        };
        let numbered = |label: i64, given: &GivenModuli| {
            let missing = EffectiveError::Unlabelled { table: "stiffness", label };
            let moduli = given.or(Moduli::alone(given.youngs_modulus_mpa.ok_or(missing)?));
            moduli.validate(&label.to_string(), moduli.youngs_modulus_mpa)?;
            Ok(moduli)
        };
        let moduli = by_label("stiffness", &self.stiffness, volume, numbered, named)?;
        // Phases with names are those of mesocrete's own images.
        let own = |name: &str| Phase::ALL.into_iter().position(|phase| PhaseNames::COMMON.name(phase) == name);
        let label = |name: &str| name.parse().ok().or_else(|| i64::try_from(own(name)?).ok());
        let is_there = |name: &str| label(name).is_some_and(|label| volume.labels.contains(&label));
        let strains =
            self.stiffness.iter().filter_map(|(name, given)| Some((&**name, is_there(name), given.eigenstrain?)));
        let there: Vec<&str> = self.stiffness.keys().map(String::as_str).filter(|name| is_there(name)).collect();
        refuse_absent(strains, &there.join(", "))?;
        if moduli.iter().all(|moduli| moduli.youngs_modulus_mpa == 0.0) {
            return Err(EffectiveError::Nothing("stiffness"));
        }
        Ok(moduli)
    }
}

/// The entry of a table for each label of a volume. Without a numbered entry, labels are those of mesocrete's own images.
fn by_label<T, U: Copy>(
    table: &'static str,
    given: &BTreeMap<String, T>,
    volume: &Volume,
    numbered: impl Fn(i64, &T) -> Result<U, EffectiveError>,
    named: impl FnOnce() -> Result<Vec<U>, EffectiveError>,
) -> Result<Vec<U>, EffectiveError> {
    let mut numbers: BTreeMap<i64, (&str, &T)> = BTreeMap::new();
    for (name, entry) in given {
        let Ok(label) = name.parse() else { continue };
        if let Some((first, _)) = numbers.insert(label, (name, entry)) {
            return Err(EffectiveError::Twice { table, label, names: [first.to_owned(), name.clone()] });
        }
    }
    let missing = |label: &i64| EffectiveError::Unlabelled { table, label: *label };
    if numbers.is_empty() {
        let own = named()?;
        let of = |label: &i64| usize::try_from(*label).ok().and_then(|label| own.get(label)).copied();
        return volume.labels.iter().map(|label| of(label).ok_or_else(|| missing(label))).collect();
    }
    if let Some(name) = given.keys().find(|name| name.parse::<i64>().is_err()) {
        return Err(unknown(table, name));
    }
    let entry = |label: &i64| numbered(*label, numbers.get(label).ok_or_else(|| missing(label))?.1);
    volume.labels.iter().map(entry).collect()
}

/// A warning of entries for labels that a volume does not have. One phases file may serve several volumes.
fn surplus<T>(table: &str, given: &BTreeMap<String, T>, volume: &Volume) -> Option<String> {
    let labels = given.keys().filter_map(|name| name.parse::<i64>().ok());
    let absent: Vec<String> =
        labels.filter(|label| volume.labels.binary_search(label).is_err()).map(|label| label.to_string()).collect();
    (!absent.is_empty())
        .then(|| format!("[{table}] has {}, and the volume has no voxel of such a label", absent.join(", ")))
}

fn unknown(table: &'static str, name: &str) -> EffectiveError {
    EffectiveError::Name { table, name: name.to_owned() }
}

/// A label volume with what each label has.
struct Labelled<'a, T> {
    specimen: &'a LabelSpecimen,
    of: &'a [T],
}

impl<T> Labelled<'_, T> {
    fn space(&self) -> Space {
        let LabelSpecimen { volume, spacing_mm, periodic } = self.specimen;
        let size = Vec3::from_fn(|axis, _| spacing_mm[axis] * volume.counts[axis] as f64);
        Space { min: Vec3::zeros(), size, periodic: *periodic }
    }

    /// The labels of the voxels, the axes turned so that the specimen's `last` becomes the third.
    fn turned(&self, last: usize) -> Cow<'_, [u8]> {
        let volume = &self.specimen.volume;
        if last == 2 {
            return Cow::Borrowed(&volume.of);
        }
        let axis = |a: usize| (last + 1 + a) % 3;
        let counts = [0, 1, 2].map(|a| volume.counts[axis(a)]);
        let stride = [1, volume.counts[0], volume.counts[0] * volume.counts[1]];
        let mut labels = vec![0; volume.of.len()];
        parallel::chunks_mut(&mut labels, counts[0] * counts[1], |k, layer| {
            for (j, row) in layer.chunks_mut(counts[0]).enumerate() {
                let start = j * stride[axis(1)] + k * stride[axis(2)];
                row.iter_mut().enumerate().for_each(|(i, label)| *label = volume.of[start + i * stride[axis(0)]]);
            }
        });
        Cow::Owned(labels)
    }

    /// Share of each label in the volume.
    fn fractions(&self) -> Vec<f64> {
        let volume = &self.specimen.volume;
        let mut counts = vec![0_usize; volume.labels.len()];
        volume.of.iter().for_each(|label| counts[usize::from(*label)] += 1);
        counts.into_iter().map(|count| count as f64 / volume.of.len() as f64).collect()
    }

    /// A result for each label, by its name and volume.
    fn each<U>(&self, of: impl Fn(String, &T, f64) -> U) -> Vec<U> {
        let labels = self.specimen.volume.labels.iter().zip(self.of).zip(self.fractions());
        labels.map(|((label, entry), fraction)| of(label.to_string(), entry, fraction)).collect()
    }
}

impl Medium for Labelled<'_, f64> {
    fn space(&self) -> Space {
        self.space()
    }

    fn links(&self, grid: &Grid, last: usize) -> Links {
        let labels = self.turned(last);
        let across = [0, 1, 2].map(|axis| along(grid, &labels, self.of, axis));
        let mut links = Links::of(grid.counts, grid.ends[2] == End::Periodic, across);
        if self.of.contains(&0.0) {
            links.keep_carriers(grid.ends);
        }
        links
    }

    fn phases(&self) -> Vec<PhaseShare> {
        self.each(|name, value, volume_fraction| PhaseShare { name, value: *value, volume_fraction })
    }

    fn has_bounds(&self) -> bool {
        true
    }

    fn bounds(&self, flow: &Flow, last: usize, found: f64) -> Option<[f64; 2]> {
        Some(interval::bounds(self, flow, last, found))
    }
}

/// The links along an axis, in the grid's order: harmonic means, and at given ends one half voxel.
fn along(grid: &Grid, labels: &[u8], values: &[f64], axis: usize) -> Vec<f32> {
    let [nx, ny, nz] = grid.counts;
    let over = grid.area(axis) / (grid.spacing[axis] / 2.0);
    let of = |a: f64, b: f64| (over / (1.0 / a + 1.0 / b)) as f32;
    let pairs: Vec<f32> = values.iter().flat_map(|a| values.iter().map(move |b| of(*a, *b))).collect();
    let ends: Vec<f32> = values.iter().map(|a| (over * a) as f32).collect();
    let row = |j: usize, k: usize| &labels[(k * ny + j) * nx..][..nx];
    let pair = |a: u8, b: u8| pairs[usize::from(a) * values.len() + usize::from(b)];
    let mut links = vec![0.0; nx * ny * (nz + usize::from(axis == 2))];
    parallel::chunks_mut(&mut links, nx * ny, |k, layer| {
        for (j, links) in layer.chunks_mut(nx).enumerate() {
            let between = |links: &mut [f32], above: &[u8], below: &[u8]| {
                links.iter_mut().zip(above.iter().zip(below)).for_each(|(link, (a, b))| *link = pair(*a, *b));
            };
            let (at, count) = ([0, j, k][axis], grid.counts[axis]);
            let on = |at: usize| if axis == 1 { row(at, k) } else { row(j, at) };
            match grid.ends[axis] {
                end if axis == 0 => {
                    let own = row(j, k);
                    between(&mut links[1..], &own[1..], own);
                    links[0] = if end == End::Periodic { pair(own[0], own[nx - 1]) } else { 0.0 };
                }
                _ if at > 0 && at < count => between(links, on(at), on(at - 1)),
                End::Periodic => between(links, on(0), on(count - 1)),
                End::Fixed => {
                    let own = on(if at == 0 { 0 } else { count - 1 });
                    links.iter_mut().zip(own).for_each(|(link, label)| *link = ends[usize::from(*label)]);
                }
                End::Insulated => (),
            }
        }
    });
    links
}

impl ElasticMedium for Labelled<'_, Moduli> {
    fn space(&self) -> Space {
        self.space()
    }

    fn voxels(&self, grid: &Grid) -> Voxels {
        debug_assert_eq!(grid.counts, self.specimen.volume.counts);
        Voxels::of_phases(self.turned(2).iter().map(|label| u32::from(*label)).collect(), self.of)
    }

    fn phases(&self) -> Vec<(Moduli, ElasticShare)> {
        self.each(|name, moduli, fraction| (*moduli, ElasticShare::new(name, moduli, fraction)))
    }

    fn is_of_voxels(&self) -> bool {
        true
    }
}
