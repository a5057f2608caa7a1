//! Questions: plain points, prepared bodies and pairs of bodies.

pub(crate) mod bodies;
pub(crate) mod cascade;
pub(crate) mod points;
