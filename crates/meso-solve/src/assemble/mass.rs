//! Lumped mass, the stable step, and the mass that a longer one needs.
//!
//! An element of n nodes with the metric A = sum g_a g_a^T vibrates no faster than w^2 = (n / rho)(lambda tr A + 2 G a),
//! a the largest eigenvalue of A: tr(H)^2 <= tr(A) |H A^-1/2|^2 for the displacement gradient H, and so on. The mesh
//! vibrates no faster than its fastest element (Hughes 2000, Sec. 9.2), and central differences are stable below 2 / w.
//! In a patch nodes have shares s_a of the mass, and n A becomes sum g_a g_a^T / s_a.
//! Elements that want a shorter step get more mass. A cohesive face is an element of its own: K area on two nodes takes
//! K area dt^2 / 2 of each node's mass, and a fifth more for its damper; the solid elements have some to spare.

use crate::assemble::patches::Patch;
use crate::assemble::tet::Shape;
use meso_collision::math::{Mat3, Vec3};
use meso_element::block::matter::Matter;
use meso_element::hex::BoxShape;

/// Step over the stable one.
pub(crate) const SAFETY: f64 = 0.98;

/// The mass of an element, and the mass that its time step needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Need {
    /// rho V, tonne.
    pub(crate) mass: f64,
    /// For the step asked for, tonne.
    pub(crate) needed: f64,
    /// Longest stable step with its own mass, s.
    pub(crate) stable_s: f64,
}

impl Need {
    /// Mass that is added, tonne.
    pub(crate) fn added(&self) -> f64 {
        (self.needed - self.mass).max(0.0)
    }

    /// Mass that a patch needs for the step `dt`.
    pub(crate) fn of_patch(matter: &Matter, patch: &Patch, dt: f64) -> Self {
        Self::of(matter, &patch.metric(), 1, patch.volume, dt)
    }

    /// Mass that an element needs, with `metric`, `nodes` and `volume`, for the step `dt`.
    pub(crate) fn of(matter: &Matter, metric: &Mat3, nodes: usize, volume: f64, dt: f64) -> Self {
        let [lambda, shear] = matter.lame();
        let density = matter.elastic.density_t_per_mm3;
        let stiffness = lambda.max(0.0) * metric.trace() + 2.0 * shear * largest_eigenvalue(metric);
        let square = nodes as f64 * stiffness / density;
        let mass = density * volume;
        let stable_s = 2.0 / square.sqrt();
        Self { mass, needed: mass * (dt / (SAFETY * stable_s)).powi(2), stable_s }
    }
}

/// Not below the largest eigenvalue, and equal to it where the other two are equal: mean + 2 sqrt(tr(dev^2) / 6).
fn largest_eigenvalue(a: &Mat3) -> f64 {
    let mean = a.trace() / 3.0;
    let deviator = a - Mat3::identity() * mean;
    mean + 2.0 * (deviator.norm_squared() / 6.0).sqrt()
}

/// sum g_a g_a^T of a box, 1/mm2: every gradient is a quarter over the edge along each axis.
pub(crate) fn box_metric(shape: &BoxShape) -> Mat3 {
    Mat3::from_diagonal(&Vec3::from(shape.edges).map(|edge| 0.5 / (edge * edge)))
}

/// sum g_a g_a^T of a tetrahedron, 1/mm2, and its volume.
pub(crate) fn tet_metric(corners: &[Vec3; 4]) -> (Mat3, f64) {
    let shape = Shape::of(corners);
    (shape.metric(), shape.volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_element::bending::Bending;
    use meso_element::block::matter::Behaviour;
    use meso_mesh::materials::Elastic;

    #[test]
    fn no_eigenvalue_is_above_its_bound_which_two_equal_ones_meet() {
        for k in 0..200 {
            let x = |i: usize| (f64::from(k) * 0.7 + i as f64 * 1.3).sin();
            let a = Mat3::from_fn(|i, j| x(i * 3 + j));
            let (a, largest) = (a * a.transpose(), (a * a.transpose()).symmetric_eigenvalues().max());
            assert!(largest_eigenvalue(&a) >= largest * (1.0 - 1e-12), "{k}: {} {largest}", largest_eigenvalue(&a));
            let n = Vec3::new(x(1), x(2), x(3));
            let long = Mat3::identity() + n * n.transpose();
            assert!((largest_eigenvalue(&long) - 1.0 - n.norm_squared()).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn with_the_mass_that_it_needs_an_element_is_stable_at_the_step_asked_for() {
        let of = |density: f64, dt: f64| {
            let elastic = Elastic { youngs_modulus_mpa: 3e4, poisson_ratio: 0.2, density_t_per_mm3: density };
            let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.2], [0.1, 2.0, 0.0], [0.5, 0.3, 0.7]].map(Vec3::from);
            let (metric, volume) = tet_metric(&corners);
            Need::of(&Matter::of(elastic, Behaviour::Elastic), &metric, 4, volume.abs(), dt)
        };
        for dt in [1e-8, 1e-7, 1e-6] {
            let need = of(2e-9, dt);
            let heavier = of(2e-9 * need.needed / need.mass, dt);
            assert!((SAFETY * heavier.stable_s / dt - 1.0).abs() < 1e-12, "{need:?} {heavier:?}");
            assert_eq!(need.added() > 0.0, dt > SAFETY * need.stable_s);
        }
    }

    #[test]
    fn the_step_of_a_regular_tetrahedron_is_that_of_its_breathing() {
        let elastic = Elastic { youngs_modulus_mpa: 3e4, poisson_ratio: 0.2, density_t_per_mm3: 2e-9 };
        let matter = Matter::of(elastic, Behaviour::Elastic);
        let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vec3::from);
        let (metric, volume) = tet_metric(&corners);
        let need = Need::of(&matter, &metric, 4, volume.abs(), 1e-7);
        // Displacements x_a at corners 3 from the origin squared: 9 K V over the mass times 3.
        let bulk = 3e4 / (3.0 * (1.0 - 0.4));
        let square: f64 = 9.0 * bulk / (2e-9 * 3.0);
        assert!((need.stable_s * square.sqrt() / 2.0 - 1.0).abs() < 1e-12, "{need:?}");
    }

    /// Largest stiffness of an amplitude, N/mm, by power iteration.
    fn stiffest(shape: &BoxShape, elastic: &Elastic) -> f64 {
        let bending = Bending::<f64>::new(shape, elastic);
        let mut amplitudes = [[1.0, 0.9, 0.8, 0.7], [0.9, 1.0, 0.7, 0.8], [0.8, 0.7, 1.0, 0.9]];
        let mut stiffness = 0.0;
        for _ in 0..2000 {
            let forces = bending.forces(&amplitudes);
            stiffness = forces.as_flattened().iter().map(|f| f * f).sum::<f64>().sqrt();
            amplitudes = forces.map(|row| row.map(|f| f / stiffness));
        }
        stiffness
    }

    #[test]
    fn no_amplitude_is_faster_than_the_bound_of_the_constant_strains() {
        for nu in [-0.3, 0.0, 0.2, 0.4, 0.49] {
            for edges in [[1.0; 3], [1.0, 1.0, 5.0], [1.0, 5.0, 5.0], [1.0, 2.0, 3.0]] {
                let (shape, elastic) = (
                    BoxShape { edges },
                    Elastic { youngs_modulus_mpa: 7e4, poisson_ratio: nu, density_t_per_mm3: 2.6e-9 },
                );
                let matter = Matter::of(elastic, Behaviour::Elastic);
                let need = Need::of(&matter, &box_metric(&shape), 8, shape.volume(), 1e-7);
                // Eight nodes share the mass, and an amplitude is eight displacements.
                let square = 64.0 * stiffest(&shape, &elastic) / need.mass;
                assert!(square.sqrt() < 2.0 / need.stable_s, "{nu} {edges:?}: {square} {}", need.stable_s);
            }
        }
    }
}
