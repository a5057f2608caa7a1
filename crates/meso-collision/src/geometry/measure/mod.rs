//! Volumes, moments, facets and the inscribed ball of a body.

pub(crate) mod facet_kernels;
pub(crate) mod inradius;
pub(crate) mod integrals;
pub(crate) mod principal;
pub(crate) mod sum;
pub(crate) mod tetrahedron;
