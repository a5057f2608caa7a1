//! Depths of overlaps and times of impact, each between two bounds.

pub(crate) mod impact;
pub(crate) mod penetration;
