//! Bodies from files that other programs wrote.

pub(crate) mod stl;
