//! Do two convex bodies share a point, and how far apart are they: proved answers, on any input.
//!
//! A body is the convex hull of points, closed, of any dimension: one shared point is an overlap. Coordinates are any finite
//! numbers, in any unit. Every answer is certified. A search in floating point ([`Method`]) proposes it; a separating
//! direction or four points around the origin prove it, rounding included; what they leave open is decided in exact
//! arithmetic.
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
//! [`Body::separating_axis`], [`PairQuery::overlap_many`] for many pairs at once, and [`PairQuery::clear_many`] for many
//! placement attempts.
//!
//! The modules, from the question to its proof:
//!
//! 1. `points` takes plain points, and `scaled` brings them to a common scale; `bodies` lays them out once; `cascade` takes
//!    pairs of [`Body`]s; `many` takes many, and
//!    `attempts` those of placement.
//! 2. `ellipsoid` and `gauge` decide most pairs without a search.
//! 3. `mpr` searches bodies that hold their frames' origins, in f32 and then in f64; `enhanced` and `classical` all others;
//!    `kernel` finds their supports, and `lockstep` runs `mpr` on a register of pairs at once.
//! 4. `certificate` proves what they propose, and `exact` decides the rest in integers.
//! 5. `penetration` and `impact` bound depths and times with the same searches and proofs.

mod attempts;
mod bodies;
mod body;
mod cascade;
mod certificate;
mod classical;
mod ellipsoid;
mod enhanced;
mod error;
mod exact;
mod gauge;
mod impact;
mod integer;
mod kernel;
mod lockstep;
mod many;
mod method;
mod mpr;
mod nearest;
mod pair;
mod pair_query;
mod penetration;
mod points;
mod scaled;
mod simplex;
mod support;

pub use bodies::Bodies;
pub use body::Body;
#[doc(hidden)]
pub use body::Bounds;
#[doc(hidden)]
pub use cascade::{Counters, apart_from};
pub use error::{GjkError, Operand};
#[doc(hidden)]
pub use gauge::Solid;
pub use impact::Impact;
pub use method::Method;
pub use pair_query::PairQuery;
pub use penetration::Penetration;
#[doc(hidden)]
pub use points::distance_exceeds;
pub use points::{Verdict, closest_points, distance, intersects};
#[doc(hidden)]
pub use support::Support;
