//! Tests of meso-core through its public interface, one module per subject.

#![allow(clippy::print_stderr, reason = "a test that skips says why")]

mod analysis_decks;
#[path = "../angle_piece.rs"]
mod angle_piece;
#[path = "../bad_specs.rs"]
mod bad_specs;
mod calculix;
mod check;
mod cohesive_decks;
mod conforming_decks;
mod conforming_retries;
mod deck_reader;
mod decks;
mod export;
mod folder;
mod grading;
mod hostile;
mod inclusions;
mod lies;
mod matrix;
mod mesh;
mod mesh_distance;
mod mesh_itz;
mod mesh_lattice;
mod mesh_periodic;
mod mesh_report;
mod mesh_specimens;
mod models;
mod packing;
mod periodic;
mod periodic_decks;
mod properties;
#[path = "../property.rs"]
mod property;
mod saved;
mod second_order;
mod shapes;
mod spec;
mod specimens;
mod statistics;
mod stop;
mod surfaces;
#[path = "../hostile/targets.rs"]
mod targets;
mod voxel_image;
