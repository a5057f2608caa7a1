//! The tape, run on this processor in f32: it must give the bits of the law itself.

use super::Law;
use super::tape::{Input, Op};
use meso_solve::real::Real;

/// Inputs of a step of one element.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    pub(crate) strain: [f32; 6],
    pub(crate) width: f32,
    /// The law's history, then the integrity less 1.
    pub(crate) memory: Vec<f32>,
}

impl Law {
    /// Stress or traction, and spent energy of a step; the point's memory goes along.
    pub(crate) fn interpret(&self, params: &[f32], point: &mut Point) -> (Vec<f32>, f32) {
        let mut values: Vec<f32> = Vec::with_capacity(self.ops.len());
        for &op in &self.ops {
            values.push(value(op, &values, params, point));
        }
        let at = |place: u32| values[place as usize];
        let stress = self.stress.iter().map(|&place| at(place)).collect();
        if self.remembered == 0 || self.moved.is_some_and(|moved| !Real::lt(0.0, at(moved))) {
            return (stress, 0.0);
        }
        point.memory = self.memory.iter().map(|&place| at(place)).collect();
        (stress, at(self.spent))
    }
}

/// A mask is 1 or 0.
fn value(op: Op, values: &[f32], params: &[f32], point: &Point) -> f32 {
    let (operands, count) = op.operands();
    let operand = |i: usize| if i < count { values[operands[i] as usize] } else { 0.0 };
    let (a, b, c) = (operand(0), operand(1), operand(2));
    let mask = |holds: bool| f32::from(u8::from(holds));
    match op {
        Op::In(Input::Strain, k) => point.strain[k as usize],
        Op::In(Input::Memory, k) => point.memory[k as usize],
        Op::In(Input::Width, _) => point.width,
        Op::Param(k) => params[k as usize],
        Op::Const(bits) => f32::from_bits(bits),
        Op::Add(..) => a + b,
        Op::Sub(..) => a - b,
        Op::Mul(..) => a * b,
        Op::Div(..) => a / b,
        Op::Neg(_) => -a,
        Op::Fma(..) => a.mul_add(b, c),
        Op::Min(..) => Real::min(a, b),
        Op::Max(..) => Real::max(a, b),
        Op::Abs(_) => a.abs(),
        Op::Sqrt(_) => a.sqrt(),
        Op::Round(_) => Real::round(a),
        Op::Pow2(_) => Real::pow2(a),
        Op::Mantissa(_) => Real::split(a).0,
        Op::Exponent(_) => Real::split(a).1,
        Op::Lt(..) => mask(a < b),
        Op::And(..) => mask(a != 0.0 && b != 0.0),
        Op::Or(..) => mask(a != 0.0 || b != 0.0),
        Op::Not(_) => mask(a == 0.0),
        Op::Select(..) => {
            if a != 0.0 {
                b
            } else {
                c
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tape::{self, Traced};
    use super::super::{Tracing, of_faces};
    use super::{Law, Point};
    use meso_mesh::materials::{LawName, Materials};
    use meso_solve::device::{Cohesion, CohesionValues, LawTask, spent};
    use meso_solve::law::cdpm2::Options;
    use meso_solve::law::{self, Cdp, Cdpm2, Hooke, Meso};
    use meso_solve::real::Real;

    /// Values of mortar that soften within the strains of the tests.
    fn values() -> Materials {
        let mut materials = Materials::default();
        materials.mortar_strength.crushing_energy_n_per_mm = Some(0.5);
        materials
    }

    fn cdp<R: Real>(materials: &Materials) -> Cdp<R> {
        let strength = materials.mortar_strength.of(LawName::Cdp);
        Cdp::new(&materials.mortar, &strength, &materials.plasticity)
    }

    fn cdpm2<R: Real>(materials: &Materials) -> Cdpm2<R> {
        let strength = materials.mortar_strength.of(LawName::Cdpm2);
        Cdpm2::new(&materials.mortar, &strength, 1.16, &Options::default())
    }

    fn meso<R: Real>(materials: &Materials) -> Meso<R> {
        let strength = materials.mortar_strength.of(LawName::Meso);
        Meso::new(&materials.mortar, &strength, &materials.meso)
    }

    fn hooke<R: Real>(materials: &Materials) -> Hooke<R> {
        Hooke::new(&materials.mortar)
    }

    fn traced<W: law::Law<Traced>>(make: impl FnOnce(&Materials) -> W) -> (Law, Vec<f32>) {
        tape::start();
        let law = make(&values());
        Tracing.run(&law)
    }

    /// A step of the law itself, as the engine takes it.
    fn step<W: law::Law<f32>>(law: &W, point: &mut Point) -> (Vec<f32>, f32) {
        let mut history = W::virgin();
        let states = history.as_ref().len();
        history.as_mut().copy_from_slice(&point.memory[..states]);
        let response = law.stress(&point.strain, &mut history, point.width);
        if states == 0 {
            return (response.stress.to_vec(), 0.0);
        }
        let before = 1.0 + point.memory[states];
        let steps: Vec<f32> = history.as_ref().iter().zip(&point.memory).map(|(new, old)| new - old).collect();
        let moved = steps.iter().fold((before - response.integrity).abs(), |moved, step| Real::max(moved, step.abs()));
        if !Real::lt(0.0, moved) {
            return (response.stress.to_vec(), 0.0);
        }
        let energy = spent(&response, &point.strain, history.as_ref(), &std::array::from_fn(|i| steps[i]), before);
        point.memory[..states].copy_from_slice(history.as_ref());
        point.memory[states] = response.integrity - 1.0;
        (response.stress.to_vec(), energy)
    }

    /// Walks a thousand points through random strains by `step` and by the tape; the share of steps that moved their memory.
    fn share_that_moves(
        step: impl Fn(&mut Point) -> (Vec<f32>, f32),
        reach: f32,
        (traced, params): &(Law, Vec<f32>),
    ) -> f64 {
        let mut seed = 1_u32;
        let mut dice = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / 8_388_608.0 - 1.0
        };
        let bits = |(stress, energy): &(Vec<f32>, f32)| {
            (stress.iter().map(|s| s.to_bits()).collect::<Vec<_>>(), energy.to_bits())
        };
        let (mut moved, mut all) = (0, 0);
        for _ in 0..1000 {
            let mut point = Point { strain: [0.0; 6], width: 2.5 + 2.0 * dice(), memory: vec![0.0; traced.remembered] };
            let way: [f32; 6] = std::array::from_fn(|_| 3.0 * reach * dice());
            for _ in 0..20 {
                let before = point.memory.clone();
                (0..6).for_each(|i| point.strain[i] += way[i] + reach * dice());
                let mut other = point.clone();
                let (expected, got) = (step(&mut point), traced.interpret(params, &mut other));
                assert_eq!(bits(&expected), bits(&got), "{before:?} {:?}", point.strain);
                let memories =
                    [&point, &other].map(|point| point.memory.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
                assert_eq!(memories[0], memories[1]);
                moved += usize::from(before != point.memory);
                all += 1;
            }
        }
        f64::from(moved as u32) / f64::from(all)
    }

    fn share_of<W: law::Law<f32>>(own: &W, traced: &(Law, Vec<f32>)) -> f64 {
        share_that_moves(|point| step(own, point), 1e-4, traced)
    }

    #[test]
    fn the_tape_of_every_law_has_the_bits_of_the_law() {
        for share in [
            share_of(&cdp::<f32>(&values()), &traced(cdp)),
            share_of(&cdpm2::<f32>(&values()), &traced(cdpm2)),
            share_of(&meso::<f32>(&values()), &traced(meso)),
        ] {
            assert!(share > 0.3 && share < 0.999, "{share}");
        }
        assert_eq!(share_of(&hooke::<f32>(&values()), &traced(hooke)), 0.0);
    }

    #[test]
    fn the_tape_of_cohesive_faces_has_the_bits_of_their_law() {
        let values = CohesionValues {
            stiffness: 2e5,
            tensile: 2.0,
            shear: 5.0,
            energies: [0.04, 0.4],
            exponent: 2.0,
            friction: 0.6,
        };
        let own = Cohesion::<f32>::new(&values);
        let step = |point: &mut Point| {
            let [x, y, z, a, b, c] = point.strain;
            let mut memory: [f32; 5] = std::array::from_fn(|i| point.memory[i]);
            let (traction, energy) = own.traction([x, y, z], &[a, b, c], &mut memory);
            point.memory = memory.to_vec();
            (traction.to_vec(), energy)
        };
        // Normals of any length do: the law does not ask.
        assert!(share_that_moves(step, 1e-2, &of_faces(&values)) > 0.9);
    }

    #[test]
    fn values_of_a_phase_are_parameters_and_constants_of_a_law_are_code() {
        let mut weaker = values();
        weaker.mortar_strength.tensile_mpa *= 0.5;
        let (law, params) = traced(cdp);
        let (same, others) = traced(|_| cdp(&weaker));
        assert!(law == same && params != others);
        // The least integrity of cracks, 1e-4, from cdp.rs.
        let code = law.code(0);
        assert!(code.contains(&format!("0x{:08x}u", 1e-4_f32.to_bits())), "{code}");
    }
}
