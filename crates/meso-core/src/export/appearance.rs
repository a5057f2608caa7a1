//! What a body is called in every file that names bodies, and which colour it has there.
//!
//! A body is `aggregate_12_class_1`, `void_40` or `fibre_41`: its phase, its id, and an aggregate's size class. Its
//! material is `class_1`, `void` or `fibre`, coloured as in the pages and pictures.

use super::raster::PALETTE;
use crate::aggregate::{Aggregate, Kind};
use crate::mesh::Phase;

/// Colours of the size classes, in turn, sRGB.
const CLASSES: [[u8; 3]; 6] = [
    [0x7f, 0xa8, 0xc9],
    [0xc9, 0xa6, 0x6b],
    [0xa3, 0xb1, 0x8a],
    [0xc4, 0x8b, 0x9f],
    [0x8f, 0xb8, 0xb0],
    [0xb3, 0x9d, 0xdb],
];
/// The phase of voids, which meshes do not have.
const VOID: u8 = 3;
/// The mortar's name and colour.
pub(super) const MORTAR: (&str, [u8; 3]) = ("mortar", PALETTE[0]);

/// The number in the field `phase` and the label of voxels inside a body: 2 aggregate, 3 void, 4 fibre.
pub(crate) fn phase(kind: Kind) -> u8 {
    match kind {
        Kind::Aggregate => Phase::Aggregate as u8,
        Kind::Void => VOID,
        Kind::Fibre => Phase::Fibre as u8,
    }
}

/// The name of a body. Images of an aggregate share it.
pub(super) fn name(body: &Aggregate) -> String {
    match body.kind {
        Kind::Aggregate => format!("aggregate_{}_class_{}", body.id, body.class),
        kind => format!("{}_{}", kind.name(), body.id),
    }
}

/// The name of a body's material.
pub(super) fn material(body: &Aggregate) -> String {
    match body.kind {
        Kind::Aggregate => format!("class_{}", body.class),
        kind => kind.name().to_owned(),
    }
}

/// The colour of a body's material, sRGB.
pub(super) fn colour(body: &Aggregate) -> [u8; 3] {
    match body.kind {
        Kind::Aggregate => CLASSES[usize::from(body.class) % CLASSES.len()],
        kind => PALETTE[usize::from(phase(kind))],
    }
}
