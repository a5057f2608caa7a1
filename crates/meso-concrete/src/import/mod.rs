//! Bodies from files that other programs wrote.

pub mod stl;
