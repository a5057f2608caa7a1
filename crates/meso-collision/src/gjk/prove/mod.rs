//! Proofs: bounds that rounding cannot cross, and exact arithmetic.

pub(crate) mod certificate;
pub(crate) mod ellipsoid;
pub(crate) mod exact;
pub(crate) mod gauge;
pub(crate) mod integer;
