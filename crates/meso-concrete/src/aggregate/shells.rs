//! Shells of a grain: nested inward offsets below its ITZ, each of a phase of the specimen's own.
//!
//! The half-space erosion of a convex body lies within that of a smaller depth, so that shells are nested by their thicknesses
//! alone. A shell's thickness is drawn, or follows from its share of the grain's volume within the ITZ. The volume at a depth
//! falls, and ever more slowly: Newton's method from a smaller depth never passes the one that is sought.

use super::grain::{Grain, Kind, Shell};
use super::random::{Draw, Stream};
use crate::parallel;
use meso_collision::geometry::{OffsetError, Polyhedron};
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
    /// Its volume over that of the grain within its ITZ, above 0 and below 1; instead of a thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_share: Option<f64>,
    /// Phase of `[[phases]]` whose grains have it; absent, all aggregates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
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

/// Gives the grains their shells; `laws` yields those of grains of a phase, with the positions of their own phases.
///
/// # Errors
/// Grains that are too thin for their shells.
pub fn add_shells<'a>(
    grains: &mut [Grain],
    seed: u64,
    laws: impl Fn(Option<u8>) -> Vec<(u8, &'a ShellLaw)> + Sync,
) -> Result<(), TooThick> {
    let found = parallel::map_each(grains, |grain| of_grain(grain, seed, &laws(grain.own)));
    let too_thick = || found.iter().filter_map(|shells| shells.as_ref().err());
    if let Some(first) = too_thick().next() {
        return Err(TooThick { grains: too_thick().count(), ..*first });
    }
    grains.iter_mut().zip(found).for_each(|(grain, shells)| grain.shells = shells.unwrap_or_default());
    Ok(())
}

fn of_grain(grain: &Grain, seed: u64, laws: &[(u8, &ShellLaw)]) -> Result<Vec<Shell>, TooThick> {
    if grain.kind != Kind::Aggregate || laws.is_empty() {
        return Ok(Vec::new());
    }
    let mut stream = Stream::new(seed, Draw::Shells, grain.class, u64::from(grain.index));
    let (body, radius_mm) = (grain.body.widened(), f64::from(grain.inner_radius));
    let mut depth = grain.itz_thickness_mm;
    let inside = body.inward_offset(depth).ok().flatten().map_or(0.0, |inside| inside.volume());
    let mut shells = Vec::with_capacity(laws.len());
    for (own, law) in laws {
        let drawn = law.thickness_mm.map(|[low, high]| stream.uniform(low, high));
        let by_volume = || law.volume_share.and_then(|share| below(&body, depth, share * inside).ok().flatten());
        // A volume that is not left is thicker than any grain.
        let thickness_mm = drawn.or_else(by_volume).unwrap_or(f64::INFINITY);
        depth += thickness_mm;
        shells.push(Shell { own: *own, thickness_mm });
    }
    let fits =
        depth <= LIMIT * radius_mm || laws.iter().all(|(_, law)| law.volume_share.is_some()) && depth.is_finite();
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
