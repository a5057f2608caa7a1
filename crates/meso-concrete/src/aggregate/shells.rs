//! Shells of a grain: nested inward offsets below its ITZ, each of a phase of the specimen's own. Outward ones, and the ITZ around
//! them, make the grain larger, so that the stone within them is the one that was taken.
//!
//! The points deeper than a depth hold those deeper than a larger one, so that shells are nested by their thicknesses alone. A
//! shell's thickness is drawn, or follows from its share of the grain's volume within the ITZ. A convex grain's volume falls with
//! the depth, and ever more slowly: Newton's method from a smaller depth never passes the one that is sought. Of others it is
//! sampled, and bracketed.

use super::Grading;
use super::grading::interpolate;
use super::grain::{Grain, Kind, Shell};
use super::random::{Draw, Stream};
use crate::parallel;
use meso_collision::geometry::{BodyForm, OffsetError, Polyhedron};
use serde::{Deserialize, Serialize};

/// A shell that grains have below their ITZ: an entry of `[[shape.shells]]` in a spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ShellLaw {
    /// Name of its phase, as in `[[phases]]`.
    pub name: String,
    /// Smallest and largest thickness, mm; every thickness between them is drawn equally often.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_mm: Option<[f64; 2]>,
    /// Smallest and largest thickness over the size of its grain, as `grading.size` defines that; instead of a thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_share: Option<[f64; 2]>,
    /// Rows of size and thickness, mm, of ascending sizes: linear in the size's logarithm between them, constant beyond;
    /// instead of a thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_over_size_mm: Option<Vec<[f64; 2]>>,
    /// Its volume over that of the grain within its ITZ, above 0 and below 1; instead of a thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_share: Option<f64>,
    /// Phase of `[[phases]]` whose grains have it; absent, all aggregates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// Whether it lies around the stone, as a coating does: the size and the volume that the grading asks for are then the stone's,
    /// and the ITZ lies around the coating. Outward shells come first.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub outward: bool,
}

/// How a shell's thickness follows, by the one of the keys that is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Thickness<'a> {
    /// `thickness_mm`.
    Drawn([f64; 2]),
    /// `size_share`.
    SizeShare([f64; 2]),
    /// `thickness_over_size_mm`.
    OverSize(&'a [[f64; 2]]),
    /// `volume_share`.
    VolumeShare(f64),
}

impl ShellLaw {
    /// The key that decides the thickness; `None` where none is given, or several are.
    pub fn thickness(&self) -> Option<Thickness<'_>> {
        let keys = [
            self.thickness_mm.map(Thickness::Drawn),
            self.size_share.map(Thickness::SizeShare),
            self.thickness_over_size_mm.as_deref().map(Thickness::OverSize),
            self.volume_share.map(Thickness::VolumeShare),
        ];
        let mut given = keys.into_iter().flatten();
        given.next().filter(|_| given.next().is_none())
    }

    /// Limits between which the thickness is drawn in a grain of `size` mm, mm; `None` where its volume decides.
    pub fn limits_mm(&self, size: f64) -> Option<[f64; 2]> {
        match self.thickness()? {
            Thickness::Drawn(limits) => Some(limits),
            Thickness::SizeShare(limits) => Some(limits.map(|share| share * size)),
            Thickness::OverSize(rows) => Some([interpolate(rows.iter().map(|&row| row.into()), size); 2]),
            Thickness::VolumeShare(_) => None,
        }
    }
}

/// A grain whose shells leave nothing inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooThick {
    /// Grains for which that is so.
    pub grains: usize,
    /// Thickness of the ITZ and all shells of the first of them, mm.
    pub thickness_mm: f64,
    /// Distance from its centre to its nearest face, mm.
    pub radius_mm: f64,
}

/// ITZ and shells take at most this share of the distance from a grain's centre to its nearest face.
const LIMIT: f64 = 0.95;
/// The same with dents, whose deepest point is searched to 5 %.
const LIMIT_WITH_DENTS: f64 = 0.9;

/// Gives the grains their shells; `laws` yields those of grains of a phase, with the positions of their own phases.
///
/// # Errors
/// Grains that are too thin for their shells.
pub fn add_shells<'a>(
    grains: &mut [Grain],
    seed: u64,
    grading: &Grading,
    laws: impl Fn(Option<u8>) -> Vec<(u8, &'a ShellLaw)> + Sync,
) -> Result<(), TooThick> {
    let classes = grading.classes();
    let found = parallel::map_each(grains, |grain| {
        let stream = |purpose| Stream::new(seed, purpose, grain.class, u64::from(grain.index));
        let size = || grading.draw(&classes[usize::from(grain.class)], &mut stream(Draw::Take));
        of_grain(grain, size, stream(Draw::Shells), &laws(grain.own))
    });
    let too_thick = || found.iter().filter_map(|shells| shells.as_ref().err());
    if let Some(first) = too_thick().next() {
        return Err(TooThick { grains: too_thick().count(), ..*first });
    }
    grains.iter_mut().zip(found).for_each(|(grain, shells)| grain.shells = shells.unwrap_or_default());
    Ok(())
}

fn of_grain(
    grain: &Grain,
    size: impl Fn() -> f64,
    mut stream: Stream,
    laws: &[(u8, &ShellLaw)],
) -> Result<Vec<Shell>, TooThick> {
    if grain.kind != Kind::Aggregate || laws.is_empty() {
        return Ok(Vec::new());
    }
    let size = size();
    let (body, radius_mm) = (grain.body.widened(), f64::from(grain.inner_radius));
    let mut depth = if laws.iter().any(|(_, law)| law.outward) { 0.0 } else { grain.itz_thickness_mm };
    let is_sampled = !body.has_inner_body();
    let inside = if is_sampled {
        body.eroded_volume(depth)
    } else {
        body.inward_offset(depth).ok().flatten().map_or(0.0, |inside| inside.volume())
    };
    let within = |depth, volume| {
        if is_sampled { below_sampled(&body, depth, volume) } else { below(&body, depth, volume).ok().flatten() }
    };
    let mut shells = Vec::with_capacity(laws.len());
    for (own, law) in laws {
        let drawn = law.limits_mm(size).map(|[low, high]| stream.uniform(low, high));
        let by_volume = || law.volume_share.and_then(|share| within(depth, share * inside));
        // A volume that is not left is thicker than any grain.
        let thickness_mm = drawn.or_else(by_volume).unwrap_or(f64::INFINITY);
        depth += if law.outward { 0.0 } else { thickness_mm };
        shells.push(Shell { own: *own, thickness_mm, outward: law.outward });
    }
    let limit = if grain.body.form() == BodyForm::Surface { LIMIT_WITH_DENTS } else { LIMIT };
    let by_volume = |(_, law): &(u8, &ShellLaw)| law.outward || law.volume_share.is_some() && !is_sampled;
    let fits = depth <= limit * radius_mm || laws.iter().all(by_volume) && depth.is_finite();
    if fits { Ok(shells) } else { Err(TooThick { grains: 1, thickness_mm: depth, radius_mm }) }
}

/// Most steps of Newton's method; some six are taken.
const STEPS: usize = 60;
/// Error of a shell's volume over the grain's.
const ROUNDING: f64 = 1e-14;

/// Thickness of the shell below `depth` that has `volume` mm3; `None` where less is left.
fn below(body: &Polyhedron, depth: f64, volume: f64) -> Result<Option<f64>, OffsetError> {
    let Some(outer) = body.inward_offset(depth)? else { return Ok(None) };
    let (left, mut thickness, mut inner) = (outer.volume() - volume, 0.0, outer);
    for _ in 0..STEPS {
        let over = inner.volume() - left;
        if over <= ROUNDING * body.volume() {
            return Ok(Some(thickness));
        }
        thickness += over / inner.area();
        match body.inward_offset(depth + thickness)? {
            Some(next) => inner = next,
            None => return Ok(None),
        }
    }
    Ok(Some(thickness))
}

/// Error of the radius within a shell whose volume is sampled, over that within the one around it: a tenth of the volume's.
const SAMPLED: f64 = 1e-4;

/// Thickness of the shell below `depth` that has `volume` mm3, as these are sampled; `None` where less is left.
///
/// The cube root of the volume within is nearly linear in the depth, as a ball's is: false position with Illinois' halving
/// of the end that stays takes some four volumes.
fn below_sampled(body: &Polyhedron, depth: f64, volume: f64) -> Option<f64> {
    let outer = body.eroded_volume(depth);
    let (radius, left) = (libm::cbrt(outer), libm::cbrt(outer - volume));
    let mut ends = [(0.0, radius - left), (body.aabb().size().max(), -left)];
    for _ in 0..STEPS {
        let [(thin, over), (thick, under)] = ends;
        let thickness = (thick * over - thin * under) / (over - under);
        let more = libm::cbrt(body.eroded_volume(depth + thickness)) - left;
        if more.abs() <= SAMPLED * radius {
            return Some(thickness);
        }
        let end = usize::from(more < 0.0);
        ends[end] = (thickness, more);
        ends[1 - end].1 /= 2.0;
    }
    None
}
