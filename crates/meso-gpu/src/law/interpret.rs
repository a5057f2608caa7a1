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
    /// Stress and spent energy of a step; the point's memory goes along.
    pub(crate) fn interpret(&self, params: &[f32], point: &mut Point) -> ([f32; 6], f32) {
        let mut values: Vec<f32> = Vec::with_capacity(self.ops.len());
        for &op in &self.ops {
            values.push(value(op, &values, params, point));
        }
        let at = |place: u32| values[place as usize];
        let stress = self.stress.map(at);
        if self.remembered == 0 || !(0.0 < at(self.moved)) {
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
