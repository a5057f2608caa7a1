//! A phase of concrete: its number and its names.

use crate::aggregate::Kind;

/// A phase of concrete. Cells, voxels and surfaces have its number in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Phase {
    /// The matrix.
    Mortar = 0,
    /// The shell between an aggregate's outer and inner surface.
    Itz = 1,
    /// The inside of an aggregate.
    Aggregate = 2,
    /// A void. Meshes for tests have no cells there.
    Void = 3,
    /// A fibre.
    Fibre = 4,
}

impl Phase {
    /// All phases, by their numbers.
    pub const ALL: [Self; 5] = [Self::Mortar, Self::Itz, Self::Aggregate, Self::Void, Self::Fibre];
    /// Those of the cells of a mesh, in the order decks list them.
    pub const SOLID: [Self; 4] = [Self::Aggregate, Self::Itz, Self::Mortar, Self::Fibre];

    /// The phase of a body inside its ITZ.
    pub fn of(kind: Kind) -> Self {
        match kind {
            Kind::Aggregate => Self::Aggregate,
            Kind::Void => Self::Void,
            Kind::Fibre => Self::Fibre,
        }
    }

    /// Its name: the key of its values.
    pub fn name(self) -> &'static str {
        ["mortar", "itz", "aggregate", "void", "fibre"][self as usize]
    }

    /// The name of its element set and of its material in a deck.
    pub fn set_name(self) -> &'static str {
        ["MORTAR", "ITZ", "AGGREGATE", "VOID", "FIBRE"][self as usize]
    }

    /// Its name in messages.
    pub fn in_words(self) -> &'static str {
        ["mortar", "ITZ", "phase of the aggregates", "phase of the voids", "phase of the fibres"][self as usize]
    }
}
