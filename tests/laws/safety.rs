//! A law survives every strain: its stress is finite, and its integrity a share.

use crate::meso::{as_strong, meso, rated, scattered, with_biaxial_ratio};
use crate::subject::{Number, WIDTH, cdp, cdpm2, mortar};
use meso_element::law::point::ramp;
use meso_element::law::{Law, State, Tensor, cdpm2 as options};

/// Numbers from -1 to 1, the same every time.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn throw(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Random walks with jumps of all sizes, among them absurd ones: stress is finite, integrity a share.
fn walks<R: Number, L: Law<R>>(law: &L) {
    let mut dice = Dice(7);
    for size in [1e-7, 1e-5, 1e-3, 0.1, 10.0] {
        for _ in 0..40 {
            let (mut history, mut strain) = (L::virgin(), [0.0; 6]);
            for _ in 0..200 {
                strain = strain.map(|e: f64| 0.98 * e + size * dice.throw());
                let answer = law.stress(&strain.map(R::splat), &mut history, R::splat(WIDTH));
                let stress: Tensor<f64> = answer.stress.map(Into::into);
                let integrity: f64 = answer.integrity.into();
                assert!(stress.iter().all(|s| s.is_finite()), "{stress:?} at {strain:?}");
                assert!((0.0..=1.000_01).contains(&integrity), "{integrity} at {strain:?}");
            }
        }
    }
}

#[test]
fn no_strain_makes_a_stress_that_is_no_number() {
    let (materials, usual) = (mortar(), options::Options::default());
    walks(&cdp::<f64>(&materials));
    walks(&cdp::<f32>(&materials));
    walks(&cdpm2::<f64>(&materials, &usual));
    walks(&cdpm2::<f32>(&materials, &usual));
    walks(&meso::<f64>());
    walks(&meso::<f32>());
}

/// Loops of strain in small steps: the least that was spent, as a share of the work.
fn dissipation<L: Law<f64>>(law: &L) -> f64 {
    let mut dice = Dice(3);
    let mut least = f64::INFINITY;
    for _ in 0..60 {
        let (mut history, mut strain, mut work) = (L::virgin(), [0.0; 6], 0.0);
        let mut stress = [0.0; 6];
        for _ in 0..6 {
            let to: Tensor<f64> = std::array::from_fn(|_| 0.002 * dice.throw());
            let from = strain;
            for step in 1..=400 {
                let next = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * f64::from(step) / 400.0);
                let new = law.stress(&next, &mut history, WIDTH).stress;
                work += (0..6).map(|i| (stress[i] + new[i]) / 2.0 * (next[i] - strain[i])).sum::<f64>();
                (strain, stress) = (next, new);
            }
            least = least.min((work - law.state(&strain, &history, WIDTH).stored) / work.max(1e-4));
        }
    }
    least
}

/// CDPM2 does not promise that: a crack that opens and closes across pressed material changes its pressure for nothing.
#[test]
fn damaged_plasticity_gives_no_energy_on_any_path() {
    let spent = dissipation(&cdp::<f64>(&mortar()));
    assert!(spent > -1e-9, "{spent}");
}

#[test]
fn mortar_between_grains_gives_no_energy_on_any_path() {
    let spent = dissipation(&meso::<f64>());
    assert!(spent > -1e-9, "{spent}");
}

/// Largest share by which the energy spent so far falls on pressed paths of large strains in coarse steps.
fn returned<L: Law<f64>>(law: &L) -> f64 {
    let (mut dice, mut worst) = (Dice(3), 0.0_f64);
    for _ in 0..100 {
        let (mut history, mut strain, mut stress) = (L::virgin(), [0.0; 6], [0.0; 6]);
        let (mut work, mut most) = (0.0, 0.0_f64);
        for _ in 0..8 {
            let to: Tensor<f64> = std::array::from_fn(|i| 0.05 * (dice.throw() - if i < 3 { 0.4 } else { 0.0 }));
            let from = strain;
            for step in 1..=100 {
                let next = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * f64::from(step) / 100.0);
                let new = law.stress(&next, &mut history, WIDTH).stress;
                work += (0..6).map(|i| (stress[i] + new[i]) / 2.0 * (next[i] - strain[i])).sum::<f64>();
                (strain, stress) = (next, new);
                let spent = work - law.state(&strain, &history, WIDTH).stored;
                worst = worst.max((most - spent) / most.max(1e-4));
                most = most.max(spent);
            }
        }
    }
    worst
}

/// A flow that took its share of cracking from the trial stress pumped energy into crushed mortar, tenfold in these
/// paths, and cubes between rough plates blew up.
#[test]
fn crushed_mortar_pumps_no_energy_in_coarse_steps() {
    let fallen = returned(&meso::<f64>());
    // Trapezoids of coarse steps err by 0.034 of what is spent, of steps an eighth as long by 0.008; the step itself returns
    // nothing, see below.
    assert!(fallen < 0.05, "{fallen}");
}

/// Corners of a random polygon, or points of an ellipse that turns the principal strains, from 0 back to 0.
fn closed(dice: &mut Dice, size: f64, round: bool) -> Vec<Tensor<f64>> {
    let mut tensor =
        || -> Tensor<f64> { std::array::from_fn(|i| size * (dice.throw() - if i < 3 { 0.3 } else { 0.0 })) };
    let [middle, a, b] = [tensor(), tensor(), tensor()];
    let at = |angle: f64| std::array::from_fn(|i| middle[i] + angle.cos() * a[i] + angle.sin() * b[i]);
    let mut corners =
        if round { (0..24).map(|k| at(f64::from(k) * 0.7)).collect() } else { vec![middle, a, b, tensor()] };
    corners.push([0.0; 6]);
    corners
}

/// Energy per volume that the law spends along closed paths in `steps` steps from corner to corner, and the part of it
/// that steps give back, N/mm2: the flow's work against the stress at the end of a step, and the fall of the stiffness.
fn spent_and_returned<L: Law<f64>>(law: &L, steps: u32, loops: usize) -> [f64; 2] {
    spent_from(law, L::virgin(), steps, loops)
}

/// The same for a point that begins with this history.
fn spent_from<L: Law<f64>>(law: &L, first: L::History, steps: u32, loops: usize) -> [f64; 2] {
    let (mut dice, mut spent, mut returned) = (Dice(5), 0.0, 0.0);
    for turn in 0..loops {
        let (mut history, mut before, mut from) = (first, 1.0, [0.0; 6]);
        for to in closed(&mut dice, [0.001, 0.01, 0.05][turn % 3], turn % 2 == 0) {
            for share in ramp(0.0, 1.0, steps as usize) {
                let strain: Tensor<f64> = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * share);
                let old = history;
                let answer = law.stress(&strain, &mut history, WIDTH);
                let (old, new) = (old.as_ref(), history.as_ref());
                let flowed: f64 = (0..6).map(|i| answer.stress[i] * (new[i] - old[i])).sum();
                let stored: f64 = (0..6).map(|i| 0.5 * answer.stress[i] * (strain[i] - new[i])).sum();
                let step = flowed + stored * (before - answer.integrity) / answer.integrity.max(1e-6);
                before = answer.integrity;
                spent += step.max(0.0);
                returned += (-step).max(0.0);
            }
            from = to;
        }
    }
    [spent, returned]
}

/// Cracks were opened before the cone's dilation closed them again, and worked against its pressure: with the dilation of
/// the defaults 4 of 12 tests of 100 mm gained energy from that beyond half of the peak, and diverged.
#[test]
fn mortar_between_grains_spends_in_steps_of_every_size() {
    let laws = [1.0, 1.16, 2.0].map(with_biaxial_ratio);
    for (law, steps) in laws.iter().flat_map(|law| [200, 20, 4, 1].map(|steps| (law, steps))) {
        let [spent, returned] = spent_and_returned(law, steps, 200);
        assert!(spent > 1.0 && returned <= 1e-12 * spent, "{returned} of {spent} in {steps} steps");
    }
    // The rates of these paths are from 1e-3 to 1e6 /s.
    let slow = [20, 4, 1].map(|steps| [(1e-7, steps), (1e-3, steps), (1.0, steps)]);
    for (dt, steps) in slow.into_iter().flatten().chain([(1e-3, 200)]) {
        let [spent, returned] = spent_and_returned(&rated::<f64>(dt), steps, 200);
        assert!(spent > 1.0 && returned <= 1e-12 * spent, "{returned} of {spent} in {steps} steps of {dt} s");
    }
}

/// The history of a point of such a factor, before its first step.
fn placed<const N: usize>(factor: f64) -> [f64; N] {
    let mut history = [0.0; N];
    history[N - 1] = factor - 1.0;
    history
}

#[test]
fn mortar_whose_strengths_scatter_gives_no_energy_back() {
    for (factor, steps) in [0.3, 0.8, 1.7].into_iter().flat_map(|factor| [20, 4, 1].map(|steps| (factor, steps))) {
        for [spent, returned] in [
            spent_from(&scattered::<f64, 9>(1.0), placed(factor), steps, 200),
            spent_from(&scattered::<f64, 11>(1e-3), placed(factor), steps, 200),
        ] {
            assert!(spent > 1.0 && returned <= 1e-12 * spent, "{returned} of {spent}, {factor} in {steps} steps");
        }
    }
}

/// Largest difference of the stresses of two laws on closed paths, over 1 MPa and the stress; and of all shown values.
fn apart<A: Law<f64>, B: Law<f64>>(a: &A, mut first: A::History, b: &B, mut second: B::History) -> f64 {
    let (mut dice, mut worst, mut from, start) = (Dice(5), 0.0_f64, [0.0; 6], (first, second));
    for turn in 0..60 {
        (first, second) = start;
        for to in closed(&mut dice, [0.0005, 0.005, 0.02][turn % 3], turn % 2 == 0) {
            for share in ramp(0.0, 1.0, 40) {
                let strain: Tensor<f64> = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * share);
                let one = a.stress(&strain, &mut first, WIDTH);
                let other = b.stress(&strain, &mut second, WIDTH);
                let shown = |state: State<f64>| [state.tension, state.compression, state.opening, state.stored];
                let pairs = one.stress.into_iter().zip(other.stress);
                let states = [a.state(&strain, &first, WIDTH), b.state(&strain, &second, WIDTH)].map(shown);
                for (x, y) in pairs.chain(states[0].into_iter().zip(states[1])) {
                    worst = worst.max((x - y).abs() / (1.0 + y.abs()));
                }
            }
            from = to;
        }
    }
    worst
}

#[test]
fn a_factor_makes_the_mortar_of_so_many_times_the_strengths_peak_strain_and_energies() {
    for factor in [0.3, 0.8, 1.0, 1.7] {
        let (meso, _) = as_strong::<10>(factor, 1.0);
        let off = apart(&scattered::<f64, 9>(1.0), placed(factor), &meso, [0.0; 8]);
        assert!(off < 1e-9, "{factor}: {off}");
        let (_, rated) = as_strong::<10>(factor, 1e-3);
        let off = apart(&scattered::<f64, 11>(1e-3), placed(factor), &rated, [0.0; 10]);
        assert!(off < 1e-9, "{factor} with rates: {off}");
        let [a, b] = meso.widest_mm();
        let [c, d] = scattered::<f64, 9>(1.0).widest_mm().map(|mm| 2.0 * mm / factor);
        assert!((a / c - 1.0).abs() < 1e-12 && (b / d - 1.0).abs() < 1e-12, "{a} {c} {b} {d}");
    }
}

/// A turned strain path gives the turned stress.
fn turned<L: Law<f64>>(law: &L) {
    // Rows of a rotation, exact in ninths.
    let turn = [[1.0, -4.0, 8.0], [8.0, 4.0, 1.0], [-4.0, 7.0, 4.0]].map(|row| row.map(|x: f64| x / 9.0));
    let rotate = |t: Tensor<f64>, shear: f64| -> Tensor<f64> {
        let (xy, yz, zx) = (t[3] * shear, t[4] * shear, t[5] * shear);
        let m = [[t[0], xy, zx], [xy, t[1], yz], [zx, yz, t[2]]];
        let at = |i: usize, j: usize| -> f64 {
            (0..3).flat_map(|k| (0..3).map(move |l| (k, l))).map(|(k, l)| turn[i][k] * m[k][l] * turn[j][l]).sum()
        };
        [at(0, 0), at(1, 1), at(2, 2), at(0, 1) / shear, at(1, 2) / shear, at(2, 0) / shear]
    };
    let mut dice = Dice(11);
    let (mut straight, mut bent) = (L::virgin(), L::virgin());
    let mut from = [0.0; 6];
    for _ in 0..6 {
        let to: Tensor<f64> = std::array::from_fn(|_| 0.002 * dice.throw());
        for step in 1..=200 {
            let strain = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * f64::from(step) / 200.0);
            let here = law.stress(&strain, &mut straight, WIDTH).stress;
            let there = law.stress(&rotate(strain, 0.5), &mut bent, WIDTH).stress;
            let expected = rotate(here, 1.0);
            let off = (0..6).map(|i| (there[i] - expected[i]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-5, "{there:?} instead of {expected:?}");
        }
        from = to;
    }
}

#[test]
fn laws_know_no_direction() {
    turned(&cdp::<f64>(&mortar()));
    turned(&cdpm2::<f64>(&mortar(), &Default::default()));
    turned(&meso::<f64>());
}
