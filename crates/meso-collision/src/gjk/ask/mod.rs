//! Questions: plain points, prepared bodies, pairs, and many of them at once.

pub(crate) mod attempts;
pub(crate) mod bodies;
pub(crate) mod cascade;
pub(crate) mod many;
pub(crate) mod pair_query;
pub(crate) mod points;
