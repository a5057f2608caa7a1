//! Tests of meso-core through its public interface, one module per subject.

mod export;
mod mesh;
mod models;
mod saved;
mod spec;
