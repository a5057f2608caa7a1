//! Tests of written files, through the facade.

mod analysis_decks;
pub(crate) mod calculix;
mod cohesive_decks;
mod conforming_decks;
pub(crate) mod deck_reader;
mod decks;
mod export;
mod fast_decks;
mod lsdyna;
pub(crate) mod periodic_decks;
mod second_order;
mod voxel_image;
