//! Tests of grains, specimens and read surfaces, through the facade.

mod grading;
mod shapes;
mod specimens;
mod surfaces;
