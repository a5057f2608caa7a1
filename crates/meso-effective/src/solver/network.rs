//! Networks of unknowns whose coarse levels are networks, too.

use super::stencil::{Real, dot, layers_mut};

/// Links between unknowns, with their groups on a coarse level.
pub(crate) trait Network: Sync + Sized {
    /// Number of unknowns.
    fn len(&self) -> usize;
    /// Unknowns of a layer: those that one thread handles, and that are added up in one sum.
    fn layer_len(&self) -> usize;
    /// Calls `visit` with every unknown of layer `k`: its number in the layer, the flux out of it, and its scale, which is at
    /// least half the largest eigenvalue of the scaled equations.
    fn fluxes<T: Real>(&self, u: &[T], k: usize, visit: impl FnMut(usize, T, f32));
    /// The network of the groups; none for few unknowns.
    fn coarse(&self) -> Option<Self>;
    /// Sums of the residual of `x` over the groups.
    fn restrict(&self, coarse: &Self, x: &[f32], rhs: &[f32], into: &mut [f32]);
    /// Adds the groups' corrections.
    fn correct(&self, coarse: &Self, x: &mut [f32], correction: &[f32]);

    /// `out = A u`; returns `u . A u`.
    fn apply<T: Real>(&self, u: &[T], out: &mut [T]) -> f64 {
        let len = self.layer_len();
        layers_mut(out, len, |k, out| self.fluxes(u, k, |at, flux, _| out[at] = flux));
        dot(u, out, len)
    }
}
