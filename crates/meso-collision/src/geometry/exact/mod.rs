//! Exact arithmetic: sums of two doubles, integers, and predicates.

pub(crate) mod double_double;
pub(crate) mod integer;
pub(crate) mod predicates;
