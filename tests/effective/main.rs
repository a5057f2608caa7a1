//! Effective properties against closed forms.

#![allow(clippy::print_stderr, reason = "a test that skips says why")]

mod bodies;
mod cracks;
mod dents;
mod labels;
mod laminates;
mod own_phases;
mod packings;
mod shells;
mod spheres;
mod stiffness;
mod tetrahedra;
