//! Tests of grains, specimens and read surfaces, through the facade.

mod dents;
mod found_files;
mod grading;
mod round;
mod shapes;
mod sieve_tables;
mod specimens;
pub(crate) mod stones;
mod surfaces;
mod volumes;
