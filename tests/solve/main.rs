//! Tests of meso-solve through its public interface, one module per subject; oracles are closed forms and CalculiX.

#![allow(clippy::print_stderr, reason = "a test that skips says why")]

mod calculix;
mod checkpoint;
mod concrete;
#[path = "../write/deck_reader.rs"]
#[allow(dead_code, reason = "meso-core's tests ask more of it")]
mod deck_reader;
mod determinism;
mod elastic;
mod expansion;
mod fast;
mod from_deck;
mod hostile;
#[path = "../hostile/solver.rs"]
mod hostile_solver;
mod loads;
mod named;
mod own_phases;
mod refusals;
mod samples;
mod scatter;
mod servo;
mod softening;
mod stone;
mod test_decks;
mod twins;
