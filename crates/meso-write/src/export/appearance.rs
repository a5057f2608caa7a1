//! Name and colour of a body in every file that holds them: the one table of colours, which
//! pages, pictures and Python's plots read, too.
//!
//! A body is `aggregate_12_class_1`, `void_40` or `fibre_41`: its phase, its id, and an aggregate's size class. Its
//! material is `class_1`, `void`, `fibre`, or a phase of the packing's own, coloured as in the pages and pictures.

use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::{Phase, PhaseNames};

/// Colour of a phase by its label, sRGB; in images the voxels outside the specimen are transparent.
pub const PALETTE: [[u8; 3]; 5] =
    [[0xe4, 0xe1, 0xda], [0x8a, 0x82, 0x75], [0x7f, 0xa8, 0xc9], [0xff, 0xff, 0xff], [0x2f, 0x3b, 0x4c]];
/// Colours of the size classes, in turn, sRGB.
pub const CLASSES: [[u8; 3]; 6] = [
    [0x7f, 0xa8, 0xc9],
    [0xc9, 0xa6, 0x6b],
    [0xa3, 0xb1, 0x8a],
    [0xc4, 0x8b, 0x9f],
    [0x8f, 0xb8, 0xb0],
    [0xb3, 0x9d, 0xdb],
];
/// Colours of the specimen's own phases, in turn, sRGB.
const OWN: [[u8; 3]; 6] = [
    [0xb8, 0x5c, 0x38],
    [0x5b, 0x7f, 0x4f],
    [0x7a, 0x4b, 0x8c],
    [0xd9, 0xb4, 0x3a],
    [0x3f, 0x7d, 0x8c],
    [0xa8, 0x32, 0x5a],
];
/// The mortar's name and colour.
pub(super) const MORTAR: (&str, [u8; 3]) = ("mortar", PALETTE[0]);

/// Colour of the phase of a number, sRGB; those of the specimen's own phases repeat.
pub(crate) fn phase_colour(number: u8) -> [u8; 3] {
    let number = usize::from(number);
    PALETTE.get(number).copied().unwrap_or_else(|| OWN[(number - PALETTE.len()) % OWN.len()])
}

/// The name of a body. Images of an aggregate share it.
pub(super) fn name(body: &Aggregate, phases: &PhaseNames) -> String {
    let phase = phases.name(body.phase());
    match body.kind {
        Kind::Aggregate => format!("{phase}_{}_class_{}", body.id, body.class),
        _ => format!("{phase}_{}", body.id),
    }
}

/// The name of a body's material.
pub(super) fn material(body: &Aggregate, phases: &PhaseNames) -> String {
    match body.phase() {
        Phase::Aggregate => format!("class_{}", body.class),
        phase => phases.name(phase).to_owned(),
    }
}

/// The colour of a body's material, sRGB.
pub(super) fn colour(body: &Aggregate) -> [u8; 3] {
    match body.phase() {
        Phase::Aggregate => CLASSES[usize::from(body.class) % CLASSES.len()],
        phase => phase_colour(phase.number()),
    }
}

/// A rule of CSS that fills elements of a class with a colour: `.c0{fill:#7fa8c9}`.
pub(crate) fn fill(class: &str, colour: [u8; 3]) -> String {
    // Two equal digits are written once.
    match colour.map(|level| (level / 17, level % 17)) {
        [(r, 0), (g, 0), (b, 0)] => format!(".{class}{{fill:#{r:x}{g:x}{b:x}}}"),
        _ => format!(".{class}{{fill:#{:02x}{:02x}{:02x}}}", colour[0], colour[1], colour[2]),
    }
}
