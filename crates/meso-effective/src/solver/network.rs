//! Networks of unknowns whose coarse levels are networks, too.

/// Links between unknowns, with their groups on a coarse level.
pub(crate) trait Network: Sync + Sized {
    /// Number of unknowns.
    fn len(&self) -> usize;
    /// Unknowns of a layer: those that one thread handles, and that are added up in one sum.
    fn layer_len(&self) -> usize;
    /// `out = A u`; returns `u . A u`.
    fn apply(&self, u: &[f32], out: &mut [f32]) -> f64;
    /// `out = rhs - A u`, rounded once. Else the rounded parts would have sources where no link leads away, which no step can
    /// lower.
    fn residual(&self, u: &[f64], rhs: &[f64], out: &mut [f32]);
    /// One over the scale of every unknown, 0 without links. Scaled equations have no eigenvalue above 2.
    fn over_scales(&self) -> Vec<f32>;
    /// `next = x + weight over (rhs - A x)`, where `over` has the scales.
    fn sweep(&self, x: &[f32], rhs: &[f32], over: &[f32], weight: f32, next: &mut [f32]);
    /// The network of the groups; none for few unknowns.
    fn coarse(&self) -> Option<Self>;
    /// Sums of the residual of `x` over the groups.
    fn restrict(&self, coarse: &Self, x: &[f32], rhs: &[f32], into: &mut [f32]);
    /// Adds the groups' corrections.
    fn correct(&self, coarse: &Self, x: &mut [f32], correction: &[f32]);
}

/// One over a scale; 0 without links.
#[inline(always)]
pub(super) fn over(scale: f32) -> f32 {
    if scale > 0.0 { 1.0 / scale } else { 0.0 }
}
