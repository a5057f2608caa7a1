//! Intersection and distance of two convex bodies: proved answers, on any input.
//!
//! A body is the convex hull of points, closed, of any dimension: one shared point is an overlap. Coordinates are any
//! finite numbers, in any unit. Every answer is certified. A search in floating point ([`Algorithm`]) proposes it; a
//! separating direction or four points around the origin prove it, rounding included; pairs they leave open are decided
//! in exact arithmetic.
//!
//! ```
//! use meso_collision::{gjk, math::Vec3};
//! let tetrahedron = |x: f64| [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(|p| Vec3::new(x + p[0], p[1], p[2]));
//! assert!(gjk::intersects(&tetrahedron(0.0), &tetrahedron(1.0))?); // they touch in one corner
//! assert!(!gjk::intersects(&tetrahedron(0.0), &tetrahedron(1.0 + f64::EPSILON))?);
//! assert_eq!(gjk::distance(&tetrahedron(0.0), &tetrahedron(3.0))?, 2.0);
//! # Ok::<(), gjk::GjkError>(())
//! ```
//!
//! [`closest_points`] adds a witness to a distance, [`Penetration`] is the depth of an overlap, and [`Impact`] is when
//! a moving body arrives.
//!
//! For many queries about the same points, make [`Bodies`] of them. Where they are about bodies that hold their frames'
//! origins and are displaced from each other, a [`Body`] of each is faster still: ask [`Body::overlaps`] or
//! [`Body::separating_axis`].
//!
//! Rooms, from the question to its proof:
//!
//! 1. `ask` takes questions: plain `points`, prepared `bodies`, and pairs of [`Body`]s (`cascade`). `scaled` brings
//!    points to a common scale.
//! 2. `search` proposes an answer. `mpr` takes bodies that hold their frames' origins, in f32 and then in f64;
//!    `enhanced` and `classical` take all others. `kernel` finds supports.
//! 3. `prove` confirms it. `ellipsoid` and `gauge` decide most pairs without a search; `certificate` proves the result
//!    of a search, and `exact` decides the rest in integers.
//! 4. `measure` bounds depths (`penetration`) and times (`impact`) with these searches and proofs.

mod ask;
mod body;
mod error;
mod measure;
mod method;
mod pair;
mod prove;
mod scaled;
mod search;
mod support;

pub use ask::bodies::Bodies;
pub use ask::cascade::{Counters, apart_from};
pub(crate) use ask::points::distance_exceeds;
pub use ask::points::{Verdict, closest_points, distance, intersects};
pub use body::Body;
pub use body::Bounds;
pub use error::{GjkError, Operand};
pub use measure::impact::Impact;
pub use measure::penetration::Penetration;
pub use method::Algorithm;
pub use prove::gauge::Solid;
pub use support::Support;
