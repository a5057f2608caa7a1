//! A phase of concrete: its number and its names.
//!
//! Every concrete has the same five numbers. Further phases belong to one specimen: [`PhaseNames`] has their names.

use crate::aggregate::{Aggregate, Kind, OwnPhase, ShellLaw};
use crate::out_of_range::{OutOfRange, Ranges};
use meso_collision::geometry::OffsetError;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A phase of concrete. Cells, voxels and surfaces have its number in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// The matrix.
    Mortar,
    /// The shell between an aggregate's outer and inner surface.
    Itz,
    /// The inside of an aggregate.
    Aggregate,
    /// A void. Meshes for tests have no cells there.
    Void,
    /// A fibre.
    Fibre,
    /// The inside of an aggregate of a phase of the specimen's own, by its position in [`PhaseNames`].
    Own(u8),
}

impl Phase {
    /// The phases of every concrete, by their numbers.
    pub const ALL: [Self; 5] = [Self::Mortar, Self::Itz, Self::Aggregate, Self::Void, Self::Fibre];
    /// Those of the cells of a mesh, in the order decks list them.
    pub const SOLID: [Self; 4] = [Self::Aggregate, Self::Itz, Self::Mortar, Self::Fibre];

    /// The phase of a body of no phase of its own, inside its ITZ.
    pub fn of(kind: Kind) -> Self {
        match kind {
            Kind::Aggregate => Self::Aggregate,
            Kind::Void => Self::Void,
            Kind::Fibre => Self::Fibre,
        }
    }

    /// Its number in files: 0 to 4, then those of the specimen's own.
    pub const fn number(self) -> u8 {
        match self {
            Self::Mortar => 0,
            Self::Itz => 1,
            Self::Aggregate => 2,
            Self::Void => 3,
            Self::Fibre => 4,
            Self::Own(own) => Self::ALL.len() as u8 + own,
        }
    }

    /// Its number, as a position in lists by phase.
    pub const fn index(self) -> usize {
        self.number() as usize
    }

    /// The phase of a number in files.
    pub fn numbered(number: u8) -> Self {
        let own = || Self::Own(number - Self::ALL.len() as u8);
        Self::ALL.get(usize::from(number)).copied().unwrap_or_else(own)
    }

    /// Whether this is the inside of an aggregate, of whatever phase.
    pub const fn is_aggregate(self) -> bool {
        matches!(self, Self::Aggregate | Self::Own(_))
    }
}

impl Aggregate {
    /// Its phase inside the ITZ.
    pub fn phase(&self) -> Phase {
        self.own.map_or(Phase::of(self.kind), Phase::Own)
    }

    /// Its layers below the ITZ, from outside: the depth at which each begins, mm, and its phase. The core is the last.
    pub fn layers(&self) -> impl Iterator<Item = (f64, Phase)> {
        let thicknesses =
            std::iter::once(self.itz_thickness_mm).chain(self.shells.iter().map(|shell| shell.thickness_mm));
        let phases = self.shells.iter().map(|shell| Phase::Own(shell.own)).chain([self.phase()]);
        let depths = thicknesses.scan(0.0, |depth, thickness_mm| {
            *depth += thickness_mm;
            Some(*depth)
        });
        depths.zip(phases)
    }

    /// Depths at which its layer of this number begins and ends, mm: 0 is the ITZ, and the shells follow from outside. Both are
    /// 0 where it has no such layer.
    pub fn layer_between(&self, number: usize) -> [f64; 2] {
        let mut begins = std::iter::once(0.0).chain(self.layers().map(|(depth, _)| depth)).skip(number);
        begins.next().zip(begins.next()).map_or([0.0; 2], |(begin, end)| [begin, end])
    }

    /// The body with the phase of its first layer below the ITZ, then the inside of every further one as a body without ITZ: the
    /// core is the last. Shells without a trustworthy inner body end the list.
    pub fn nested(&self) -> Vec<Self> {
        let of = |phase, itz_thickness_mm, body| {
            let own = if let Phase::Own(own) = phase { Some(own) } else { None };
            Self { own, shells: Vec::new(), itz_thickness_mm, body, ..*self }
        };
        let mut layers = self.layers();
        let outer = layers.next().map(|(itz_mm, phase)| of(phase, itz_mm, self.body.clone()));
        let inner = |(depth, phase)| Some(of(phase, 0.0, self.surface_below(depth).ok().flatten()?));
        outer.into_iter().chain(layers.map_while(inner)).collect()
    }

    /// Volume of every layer within an ITZ of `itz_mm`, mm3, with its phase.
    ///
    /// # Errors
    /// Where the offset of an ill-shaped body has no trustworthy answer.
    pub fn layer_volumes(&self, itz_mm: f64) -> Result<Vec<(Phase, f64)>, OffsetError> {
        let inside = self.core_volume(itz_mm)?;
        let below = |(depth, phase)| Some((phase, self.core_volume(depth).ok().filter(|volume| *volume > 0.0)?));
        let mut layers = self.layers();
        let first = layers.next().map(|(_, phase)| (phase, inside));
        let all: Vec<(Phase, f64)> = first.into_iter().chain(layers.map_while(below)).collect();
        let within = all.iter().skip(1).map(|(_, within)| *within).chain([0.0]);
        Ok(all.iter().zip(within).map(|((phase, outer), within)| (*phase, outer - within)).collect())
    }

    /// Phase at a depth below its surface, mm, within its ITZ.
    pub fn phase_at(&self, depth_mm: f64) -> Phase {
        let deeper = self.layers().skip(1).take_while(|(depth, _)| depth_mm >= *depth);
        deeper.last().or_else(|| self.layers().next()).map_or(self.phase(), |(_, phase)| phase)
    }
}

/// The phases of a specimen: the five of every concrete, and its own by their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PhaseNames(Vec<String>);

impl FromIterator<String> for PhaseNames {
    fn from_iter<T: IntoIterator<Item = String>>(names: T) -> Self {
        Self(names.into_iter().collect())
    }
}

impl PhaseNames {
    /// Most phases of one specimen's own.
    pub const MOST: usize = 16;
    /// Most phases of one specimen.
    pub const ROOM: usize = Phase::ALL.len() + Self::MOST;
    /// The phases of every concrete alone.
    pub const COMMON: &Self = &Self(Vec::new());

    /// Names of the phases that some aggregates have, then those of the shells that no other has.
    pub fn of(phases: &[OwnPhase], shells: &[ShellLaw]) -> Self {
        let mut all: Vec<String> = Vec::new();
        for name in phases.iter().map(|phase| &phase.name).chain(shells.iter().map(|law| &law.name)) {
            if !all.contains(name) {
                all.push(name.clone());
            }
        }
        Self(all)
    }

    /// The number of phases, which is one beyond the largest number.
    pub fn count(&self) -> usize {
        Phase::ALL.len() + self.0.len()
    }

    /// The specimen's own phases.
    pub fn own(&self) -> impl ExactSizeIterator<Item = Phase> + use<> {
        (0..self.0.len() as u8).map(Phase::Own)
    }

    /// All phases, by their numbers.
    pub fn all(&self) -> impl Iterator<Item = Phase> + use<> {
        Phase::ALL.into_iter().chain(self.own())
    }

    /// Those of the cells of a mesh, in the order decks list them.
    pub fn solid(&self) -> impl Iterator<Item = Phase> + use<> {
        Phase::SOLID.into_iter().chain(self.own())
    }

    /// Position of the specimen's own phase of this name.
    pub fn find(&self, name: &str) -> Option<u8> {
        self.0.iter().position(|own| own == name).map(|own| own as u8)
    }

    /// Finds out whether `own` has values of all of the specimen's own phases, and of no other; `example` shows such values.
    ///
    /// # Errors
    /// The first phase without values, and the first values without a phase.
    pub fn suit<T>(&self, own: &BTreeMap<String, T>, table: Ranges, example: &str) -> Result<(), OutOfRange> {
        for name in &self.0 {
            let why = format!("the packing has this phase: add {name} = {example} to [{}]", table.0);
            table.require(name, "missing", own.contains_key(name), why)?;
        }
        let has = if self.0.is_empty() { "none".to_owned() } else { self.0.join(", ") };
        for name in own.keys() {
            let why = format!(
                "is no phase of the packing, whose own are: {has}; leave it out, or name it in [[phases]] of the spec"
            );
            table.require(name, "given", self.0.contains(name), why)?;
        }
        Ok(())
    }

    /// Name of the phase: the key of its values.
    pub fn name(&self, phase: Phase) -> &str {
        match phase {
            // Bodies without their specimen's names.
            Phase::Own(own) => self.0.get(usize::from(own)).map_or("own", String::as_str),
            common => ["mortar", "itz", "aggregate", "void", "fibre"][common.index()],
        }
    }

    /// Name of the phase's element set and of its material in a deck.
    pub fn set_name(&self, phase: Phase) -> Cow<'static, str> {
        match phase {
            Phase::Own(_) => self.name(phase).to_uppercase().into(),
            common => ["MORTAR", "ITZ", "AGGREGATE", "VOID", "FIBRE"][common.index()].into(),
        }
    }

    /// Name of the phase in messages.
    pub fn in_words(&self, phase: Phase) -> Cow<'static, str> {
        match phase {
            Phase::Own(_) => format!("phase {}", self.name(phase)).into(),
            common => ["mortar", "ITZ", "phase of the aggregates", "phase of the voids", "phase of the fibres"]
                [common.index()]
            .into(),
        }
    }
}
