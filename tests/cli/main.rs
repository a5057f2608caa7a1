//! Tests of the `mesocrete` command, run as a user runs it.

#![allow(clippy::print_stderr, reason = "a test that skips says why")]

#[path = "../angle_piece.rs"]
mod angle_piece;
mod bad_input;
#[path = "../bad_specs.rs"]
mod bad_specs;
#[cfg(unix)]
mod checkpoint;
mod command;
#[path = "../hostile/command_line.rs"]
mod command_line;
mod conforming;
mod conforming_periodic;
mod conforming_slabs;
mod conforming_specimens;
mod decks;
#[cfg(feature = "gpu")]
mod devices;
mod effective;
mod files;
mod fit;
mod footing;
mod help;
mod hostile;
#[path = "../hostile/study.rs"]
mod hostile_study;
mod image;
mod import;
mod interrupt;
#[path = "../layer_errors.rs"]
mod layer_errors;
mod meshing;
#[cfg(not(feature = "gpu"))]
mod no_devices;
mod outputs;
mod phase_error;
mod refusals;
mod report;
mod same_bytes;
mod solve;
mod study;
