//! Tests of meso-solve through its public interface, one module per subject; oracles are closed forms and CalculiX.

mod calculix;
mod concrete;
mod determinism;
mod elastic;
mod refusals;
mod samples;
mod softening;
