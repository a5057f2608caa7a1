//! The cohesive face: traction against separation, friction once it is debonded.
//!
//! Every pair of nodes carries its share of the area (integration at the nodes). Separation d has a normal part d_n and a
//! shear vector d_s; both resist with K. Damage is linear softening over lambda = sqrt(<d_n>^2 + d_s^2) between onset and
//! end, which depend on the share of shear B = d_s^2 / lambda^2 as in the decks: onset where the squares of tractions over
//! strengths add up to 1 (Abaqus' QUADS), and the fracture energy of Benzeggagh and Kenane, G_n + (G_s - G_n) B^power
//! (Camanho and Davila 2002, NASA TM-2002-211737). The damaged part slides with Coulomb's friction (Alfano and Sacco 2006),
//! which the decks do not have. Closing is resisted with the whole K and a damper: friction that follows an undamped pressure
//! flutters at the ears of aggregates until it tears them off.

use crate::lanes::{LANES, Lanes, Octet, Places, Vectors};
use crate::real::Real;
use crate::uniform::pairs;

/// Registers that a pair of nodes remembers: damage, its slip along x, y and z, mm, and its separation along the normal, mm.
pub const REMEMBERED: usize = 5;

/// Damping of closed faces: the last step's change of the closing counts so much more. It is nearly the share of critical
/// damping of a pair whose nodes have just the mass that its step needs. `benches/results/cohesive_damping.csv` has runs with
/// 0, 0.03, 0.05 and this: those with 0 diverge, and those with 0.05 and this have the same peaks within 0.1 %.
const DAMPING: f64 = 0.1;
/// Mass for a stable damped step over the mass for K alone: (w dt)^2 (1 + 2 b) <= 4 in u'' = -w^2 (u + b du).
pub const DAMPED: f64 = 1.0 + 2.0 * DAMPING;

/// Parameters of a cohesive face, as registers.
#[derive(Clone, Copy, Debug)]
pub struct Cohesion<R> {
    stiffness: R,
    /// 1 / onset^2 in opening, and the amount that sliding adds to it, 1/mm2.
    per_square: [R; 2],
    /// Onset times end in opening, and the amount that sliding adds to it, mm2.
    product: [R; 2],
    exponent: R,
    friction: R,
}

/// Values of a cohesive face.
#[derive(Clone, Copy, Debug)]
pub struct CohesionValues {
    /// Against opening, closing and sliding, N/mm3.
    pub stiffness: f64,
    /// Tensile strength, MPa.
    pub tensile: f64,
    /// Shear strength without pressure, MPa.
    pub shear: f64,
    /// Fracture energies in opening and in sliding, N/mm.
    pub energies: [f64; 2],
    /// Exponent of Benzeggagh and Kenane's mixed-mode criterion.
    pub exponent: f64,
    /// Coulomb's coefficient.
    pub friction: f64,
}

/// Eight faces of `N` pairs of nodes.
#[derive(Clone, Copy, Debug)]
pub struct Faces<const N: usize> {
    /// The aggregate side's nodes, then those over them.
    pub at: [[Places; N]; 2],
    /// Out of the aggregate.
    pub normal: [Octet; 3],
    /// Area of a pair of nodes, mm2; 0 in lanes that are empty.
    pub area: Octet,
}

impl<const N: usize> Default for Faces<N> {
    fn default() -> Self {
        Self { at: [[Places::default(); N]; 2], normal: [Octet::default(); 3], area: Octet::default() }
    }
}

impl<R: Real> Cohesion<R> {
    /// As registers.
    pub fn new(values: &CohesionValues) -> Self {
        let CohesionValues { stiffness: k, tensile, shear, energies, exponent, friction } = *values;
        let per_square = [tensile, shear].map(|strength| (k / strength).powi(2));
        // Onset times end: twice the energy over the stiffness.
        let product = energies.map(|g| 2.0 * g / k);
        Self {
            stiffness: R::splat(k),
            per_square: [per_square[0], per_square[1] - per_square[0]].map(R::splat),
            product: [product[0], product[1] - product[0]].map(R::splat),
            exponent: R::splat(exponent),
            friction: R::splat(friction),
        }
    }

    /// Damage of a separation with the squares `opening` and `sliding`, mm2.
    #[inline(always)]
    fn damage(&self, opening: R, sliding: R) -> R {
        let square = opening + sliding;
        let share = sliding / square.max(R::splat(1e-24));
        let power = (self.exponent * share.max(R::splat(1e-12)).ln()).exp();
        let onset = R::splat(1.0) / self.per_square[1].mul_add(share, self.per_square[0]).sqrt();
        let end = self.product[1].mul_add(power, self.product[0]) / onset;
        let lambda = square.sqrt();
        let damage = end * (lambda - onset) / (lambda * (end - onset)).max(R::splat(1e-24));
        damage.between(0.0, 1.0)
    }

    /// Tractions of the separation `apart` with `normal`, and the energy per area that this step spent.
    #[inline(always)]
    pub fn traction(&self, apart: [R; 3], normal: &[R; 3], memory: &mut [R; REMEMBERED]) -> ([R; 3], R) {
        let (zero, one, k) = (R::splat(0.0), R::splat(1.0), self.stiffness);
        let along = apart[0].mul_add(normal[0], apart[1].mul_add(normal[1], apart[2] * normal[2]));
        let slide: [R; 3] = std::array::from_fn(|i| apart[i] - along * normal[i]);
        let opening = along.max(zero);
        let sliding = slide[0].mul_add(slide[0], slide[1].mul_add(slide[1], slide[2] * slide[2]));
        let old = memory[0];
        let damage = old.max(self.damage(opening * opening, sliding));
        // A damper pushes, but does not pull.
        let moved = along - memory[4];
        let closed = along.lt(zero);
        let damped = R::select(closed, R::splat(DAMPING).mul_add(moved, along).min(zero), along);
        // Stick, then slip back onto the cone of friction.
        let trial: [R; 3] = std::array::from_fn(|i| k * (slide[i] - memory[i + 1]));
        let size = trial[0].mul_add(trial[0], trial[1].mul_add(trial[1], trial[2] * trial[2])).sqrt();
        let limit = self.friction * k * (-damped).max(zero);
        let kept = (limit / size.max(R::splat(1e-12))).min(one);
        let rub = trial.map(|t| t * kept);
        let slipped = size * (one - kept) / k;
        (0..3).for_each(|i| memory[i + 1] = slide[i] - rub[i] / k);
        memory[0] = damage;
        memory[4] = along;
        let whole = one - damage;
        let pull = k * damped * R::select(closed, one, whole);
        let force = std::array::from_fn(|i| (k * whole).mul_add(slide[i], damage.mul_add(rub[i], pull * normal[i])));
        let torn = R::splat(0.5) * k * opening.mul_add(opening, sliding) * (damage - old);
        let damping = k * (damped - along) * moved;
        (force, (damage * limit.min(size)).mul_add(slipped, torn + damping))
    }
}

impl<const N: usize> Faces<N> {
    /// Puts a face into `lane`; `area` is that of a pair of nodes.
    pub fn set(&mut self, lane: usize, at: [[u16; N]; 2], normal: [f64; 3], area: f64) {
        for (side, nodes) in self.at.iter_mut().zip(at) {
            side.iter_mut().zip(nodes).for_each(|(place, node)| place.set(lane, node));
        }
        self.normal.iter_mut().zip(normal).for_each(|(row, x)| row.0[lane] = x as f32);
        self.area.0[lane] = area as f32;
    }

    /// The eight faces as words: pair by pair, the node over the aggregate's and the aggregate's, two to a word; areas; x, y, z
    /// of the normals; zeros up to the words of an [element](crate::uniform::Uniform::words) with as many nodes.
    pub fn words(&self, out: &mut Vec<u32>) {
        let nodes = self.at[1].iter().zip(&self.at[0]).flat_map(|(over, below)| [over, below]);
        nodes.for_each(|at| out.extend(pairs(at.nodes())));
        let numbers = std::iter::once(&self.area).chain(&self.normal);
        out.extend(numbers.flat_map(|eight| eight.0.map(f32::to_bits)));
        let gradients = LANES / 2 * 3 * (2 * N - 1);
        out.extend(std::iter::repeat_n(0, gradients - LANES));
    }

    /// Adds the forces with which the faces resist; returns the energy spent in this step, mJ by lane.
    #[inline(always)]
    pub fn resist<L: Lanes>(
        &self,
        cohesion: &Cohesion<L>,
        memory: &mut [Octet],
        u: &Vectors,
        forces: &mut Vectors,
    ) -> L {
        let normal = self.normal.each_ref().map(L::load);
        let area = L::load(&self.area);
        let mut spent = L::splat(0.0);
        for (pair, memory) in memory.chunks_exact_mut(REMEMBERED).enumerate().take(N) {
            let (below, over) = (L::gather(u, &self.at[0][pair]), L::gather(u, &self.at[1][pair]));
            let apart = std::array::from_fn(|i| over[i] - below[i]);
            let mut own: [L; REMEMBERED] = std::array::from_fn(|i| L::load(&memory[i]));
            let (traction, energy) = cohesion.traction(apart, &normal, &mut own);
            own.iter().zip(memory).for_each(|(x, to)| x.store(to));
            let force = traction.map(|t| t * area);
            L::scatter(forces, &self.at[1][pair], force);
            L::scatter(forces, &self.at[0][pair], force.map(|f| -f));
            spent = energy.mul_add(area, spent);
        }
        spent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUES: CohesionValues = CohesionValues {
        stiffness: 2e5,
        tensile: 2.0,
        shear: 5.0,
        energies: [0.04, 0.4],
        exponent: 2.0,
        friction: 0.6,
    };

    /// Work per area, the energy that was told as spent, and the last traction, over separations `path(0..=1)`.
    fn along(path: impl Fn(f64) -> [f64; 3]) -> (f64, f64, [f64; 3]) {
        let law = Cohesion::<f64>::new(&VALUES);
        let (mut memory, mut work, mut told) = ([0.0; REMEMBERED], 0.0, 0.0);
        let (mut before, mut last) = (path(0.0), [0.0; 3]);
        for step in 1..=20_000 {
            let apart = path(f64::from(step) / 20_000.0);
            let (traction, spent) = law.traction(apart, &[0.0, 0.0, 1.0], &mut memory);
            told += spent;
            work += (0..3).map(|i| 0.5 * (traction[i] + last[i]) * (apart[i] - before[i])).sum::<f64>();
            (before, last) = (apart, traction);
        }
        (work, told, last)
    }

    #[test]
    fn opening_and_sliding_spend_their_fracture_energies() {
        for (path, energy) in [([0.0, 0.0, 0.1], 0.04), ([0.2, 0.0, 0.0], 0.4)] {
            let (work, told, last) = along(|t| path.map(|x: f64| x * t));
            assert!((work / energy - 1.0).abs() < 1e-3 && (told / energy - 1.0).abs() < 2e-3, "{work} {told}");
            assert!(last.iter().all(|t| t.abs() < 1e-9), "{last:?}");
        }
    }

    #[test]
    fn a_mixed_separation_spends_what_benzeggagh_and_kenane_say() {
        let (work, ..) = along(|t| [0.15 * t, 0.0, 0.15 * t]);
        let energy: f64 = 0.04 + (0.4 - 0.04) * 0.5_f64.powi(2);
        assert!((work / energy - 1.0).abs() < 1e-3, "{work} {energy}");
    }

    #[test]
    fn damage_begins_where_the_squares_of_tractions_over_strengths_add_up_to_1() {
        let law = Cohesion::<f64>::new(&VALUES);
        for angle in [0.0_f64, 0.4, 0.8, 1.2, std::f64::consts::FRAC_PI_2] {
            let [opening, sliding] = [angle.cos(), angle.sin()];
            let first = 1.0 / ((opening / VALUES.tensile).powi(2) + (sliding / VALUES.shear).powi(2)).sqrt();
            let damage = |traction: f64| {
                let apart = [sliding * traction / VALUES.stiffness, 0.0, opening * traction / VALUES.stiffness];
                let mut memory = [0.0; REMEMBERED];
                law.traction(apart, &[0.0, 0.0, 1.0], &mut memory);
                memory[0]
            };
            assert!(damage(0.999 * first) == 0.0 && damage(1.001 * first) > 0.0, "{angle}");
        }
    }

    #[test]
    fn a_face_that_closes_half_way_bears_half_of_what_it_bore_and_does_not_heal() {
        let at_most = along(|t| [0.0, 0.0, 0.02 * t]).2[2];
        let after = along(|t| [0.0, 0.0, 0.02 * (2.0 * t).min(1.5 - t)]).2[2];
        assert!((at_most - 1.0).abs() < 1e-3 && (after - 0.5 * at_most).abs() < 1e-9, "{at_most} {after}");
    }

    #[test]
    fn a_closed_face_that_swings_spends_what_its_damper_takes() {
        let mean = 1e-4;
        let (work, told, _) = along(|t| [0.0, 0.0, -mean * (1.0 - (1000.0 * std::f64::consts::PI * t).cos())]);
        // 500 cycles of 40 steps: k b (mean sin)^2 (2 pi / 40)^2 in each step.
        let turn = std::f64::consts::PI / 20.0;
        let taken = VALUES.stiffness * DAMPING * (mean * turn).powi(2) / 2.0 * 20_000.0;
        assert!((told / taken - 1.0).abs() < 0.01 && (work / told - 1.0).abs() < 0.02, "{work} {told} {taken}");
    }

    #[test]
    fn a_debonded_face_bears_pressure_and_slides_with_friction() {
        let path = |t: f64| if t < 0.5 { [0.4 * t, 0.0, 0.0] } else { [0.2 + 0.1 * (t - 0.5), 0.0, -5e-5] };
        let (_, _, [shear, _, normal]) = along(path);
        assert!((normal + 10.0).abs() < 1e-9 && (shear - 6.0).abs() < 1e-9, "{normal} {shear}");
    }
}
