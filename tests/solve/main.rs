//! Tests of meso-solve through its public interface, one module per subject; oracles are closed forms and CalculiX.

#![allow(clippy::print_stderr, reason = "a test that skips says why")]

mod calculix;
mod concrete;
mod determinism;
mod elastic;
mod refusals;
mod samples;
mod softening;
