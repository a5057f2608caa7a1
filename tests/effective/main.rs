//! Effective properties against closed forms.

mod bodies;
mod laminates;
mod packings;
mod spheres;
mod stiffness;
