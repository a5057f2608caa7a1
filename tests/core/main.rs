//! Tests of the crates behind the facade `meso-core`, one folder for each crate and one module for each subject.
//!
//! One program: a second one would compile the generic code of packing and meshing again. Subjects that reach across all
//! crates are here.

#![allow(clippy::print_stderr, reason = "a test that skips says why")]

#[path = "../angle_piece.rs"]
mod angle_piece;
#[path = "../bad_specs.rs"]
mod bad_specs;
#[path = "../concrete/mod.rs"]
mod concrete;
mod inclusions;
#[path = "../layer_errors.rs"]
mod layer_errors;
mod matrix;
#[path = "../mesh/mod.rs"]
mod mesh;
#[path = "../pack/mod.rs"]
mod pack;
mod phases;
#[path = "../property.rs"]
mod property;
mod sampled_shells;
mod shell_layers;
mod shells;
mod stop;
#[path = "../hostile/targets.rs"]
mod targets;
#[path = "../write/mod.rs"]
mod write;
