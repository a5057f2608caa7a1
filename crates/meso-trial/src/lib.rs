//! A test of concrete as data: what is supported, loaded and measured, on which nodes of a mesh, and along which path.
//!
//! A [`Test`] is one description, named or read from a TEST.toml. [`Test::suits`] refuses a specimen that cannot have it.
//! [`Test::loads`] puts its supports and loads on the nodes of a [`Sample`], for decks; the engine (`meso-solve`) takes the
//! same nodes from [`nodes`]. So a deck and the engine test one thing.
//!
//! Units as everywhere: mm, N, MPa, tonne, s.

mod doubts;
mod error;
mod loads;
pub mod nodes;
mod sample;
mod trial;

pub use error::{TEST, TrialError};
pub use loads::{Hold, Loads, Motion, Pressure, RigidSupport};
pub use meso_mesh::materials::LawName;
pub use sample::{Geometry, Sample, gross_section_mm2};
pub use trial::{
    Along, Below, Control, Course, Drive, Expansion, Gauge, Interface, MOST_SUPPORTS, OF_PLATES, OF_SUPPORTS, PHASES,
    Rig, Rule, STRAINS, Setup, Side, Smoothing, Speed, Strip, SupportSpec, Test, TestKind, Turn, TurnOf, word,
};
