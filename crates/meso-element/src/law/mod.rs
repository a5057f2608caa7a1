//! Material laws: strain in, stress out, for one number or for a register of numbers at a time.
//!
//! Strains are small; tensors have six components, xx yy zz xy yz zx, with engineering shears in strains. Tension is
//! positive. A law is made of f64 values and holds them as registers, so that a step converts none.

pub mod cdp;
pub mod cdpm2;
mod curves;
mod elastic;
mod invariants;
pub mod meso;
pub mod point;
mod rated;
mod softening;

pub use cdp::Cdp;
pub use cdpm2::Cdpm2;
pub use elastic::Hooke;
pub use meso::Meso;
pub use meso_mesh::materials::LawName;
pub use rated::{Rated, RatedScattered, Scaled, Scattered, strengths_over_rest};

use crate::real::Real;

/// A tensor, xx yy zz xy yz zx.
pub type Tensor<R> = [R; 6];

/// A material law over registers `R`.
pub trait Law<R: Real>: Send + Sync {
    /// The history of a point, as registers: all zero at the start.
    type History: Copy + Send + Sync + AsRef<[R]> + AsMut<[R]>;

    /// First and end of the registers of a history that change in every step and spend nothing.
    const RUNNING: [usize; 2] = [0; 2];

    /// History of a point that was never strained.
    fn virgin() -> Self::History;

    /// Stress at the end of a step, MPa, from the whole `strain` at its end; `history` goes along.
    ///
    /// `width` is the width of the band in the element, mm. A mechanism whose band is wider than its
    /// [limit](Law::widest_mm) softens as at the limit, so that it dissipates more than its energy.
    fn stress(&self, strain: &Tensor<R>, history: &mut Self::History, width: R) -> PointResponse<R>;

    /// Values of a point for pictures, from the strain that `history` belongs to.
    fn state(&self, strain: &Tensor<R>, history: &Self::History, width: R) -> State<R>;

    /// Widest bands of cracking and of crushing that soften without snapping back, mm; infinite where nothing softens.
    fn widest_mm(&self) -> [f64; 2];
}

/// The response of a point.
#[derive(Clone, Copy, Debug)]
pub struct PointResponse<R> {
    /// MPa.
    pub stress: Tensor<R>,
    /// Share of the stiffness that is left, 0 to 1, for the hourglass forces.
    pub integrity: R,
}

/// The state of a point.
#[derive(Clone, Copy, Debug)]
pub struct State<R> {
    /// Damage in tension, 0 to 1.
    pub tension: R,
    /// Damage in compression, 0 to 1.
    pub compression: R,
    /// Share of the strength that is lost while the stiffness stays, 0 to 1.
    pub weakened: R,
    /// Opening of its crack, mm.
    pub opening: R,
    /// Energy per volume that unloading would give back, N/mm2.
    pub stored: R,
}
