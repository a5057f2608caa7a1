//! Effective properties against closed forms.

mod bodies;
mod labels;
mod laminates;
mod packings;
mod spheres;
mod stiffness;
