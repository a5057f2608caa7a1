//! Tests of meso-solve through its public interface, one module per subject; oracles are closed forms and CalculiX.

mod samples;

mod determinism;
mod elastic;
mod refusals;
