//! Laws as code of a device: the engine's laws, run once over numbers that write down what is done with them.
//!
//! A law over [`Traced`] leaves a tape of operations, each exactly rounded; [`Law::code`] prints it in C. There is no second
//! text of a law: a constant that changes in `meso-element/src/law` changes the device's code.

#[cfg(test)]
mod interpret;
mod tape;

use meso_solve::device::{Cohesion, CohesionValues, LawTask, Upload, spent};
use meso_solve::law;
use meso_solve::real::Real;
use std::fmt::Write;
use tape::{Input, Op, Traced};

/// A law on a tape. Phases that differ in constants only have equal ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Law {
    ops: Vec<Op>,
    /// Registers of an element's memory, or of those of a pair of nodes on a cohesive face.
    pub(crate) remembered: usize,
    /// Places on the tape; a traction has three.
    stress: Vec<u32>,
    /// The memory after the step, and the energy that the step spent per volume.
    memory: Vec<u32>,
    spent: u32,
    /// Whether the memory moved; absent, it always moves.
    moved: Option<u32>,
}

/// The law of a material, and the values of its constants.
pub(crate) fn of_material(upload: &Upload, material: usize) -> (Law, Vec<f32>) {
    tape::start();
    upload.law(material, Tracing)
}

/// The law of a pair of nodes on a cohesive face, and the values of its constants: separation and normal are its strain.
pub(crate) fn of_faces(values: &CohesionValues) -> (Law, Vec<f32>) {
    tape::start();
    let cohesion = Cohesion::<Traced>::new(values);
    let params = tape::end_of_parameters();
    let vector = |first| std::array::from_fn(|i| Traced::input(Input::Strain, first + i));
    let mut memory = std::array::from_fn(|i| Traced::input(Input::Memory, i));
    let (traction, energy) = cohesion.traction(vector(0), &vector(3), &mut memory);
    let (stress, memory) = (traction.map(|t| t.0).to_vec(), memory.map(|own| own.0).to_vec());
    let law = Law { ops: tape::take(), remembered: memory.len(), stress, memory, spent: energy.0, moved: None };
    (law, params)
}

/// Writes a law down, with the energy that the engine counts for it.
struct Tracing;

impl LawTask<Traced> for Tracing {
    type Output = (Law, Vec<f32>);

    fn run<W: law::Law<Traced>>(self, law: &W) -> Self::Output {
        let params = tape::end_of_parameters();
        let zero = Traced::splat(0.0);
        let strain: [Traced; 6] = std::array::from_fn(|i| Traced::input(Input::Strain, i));
        let mut history = W::virgin();
        let states = history.as_ref().len();
        for (i, own) in history.as_mut().iter_mut().enumerate() {
            *own = Traced::input(Input::Memory, i);
        }
        let old = history;
        let response = law.stress(&strain, &mut history, Traced::input(Input::Width, 0));
        let (mut memory, mut moved, mut energy) = (Vec::new(), zero, zero);
        if states > 0 {
            let one = Traced::splat(1.0);
            let before = one + Traced::input(Input::Memory, states);
            moved = (before - response.integrity).abs();
            let steps: Vec<Traced> = history.as_ref().iter().zip(old.as_ref()).map(|(new, old)| *new - *old).collect();
            moved = steps.iter().fold(moved, |moved, step| moved.max(step.abs()));
            energy = spent(&response, &strain, history.as_ref(), &std::array::from_fn(|i| steps[i]), before);
            memory.extend(history.as_ref().iter().map(|own| own.0));
            memory.push((response.integrity - one).0);
        }
        let law = Law {
            ops: tape::take(),
            remembered: memory.len(),
            stress: response.stress.map(|s| s.0).to_vec(),
            memory,
            spent: energy.0,
            moved: Some(moved.0),
        };
        (law, params)
    }
}

impl Law {
    /// A function of C, number `number`: stress of a strain; memory moves along, and the energy spent is returned.
    pub(crate) fn code(&self, number: usize) -> String {
        let mut text = format!(
            "DEVICE float law_{number}(GLOBAL const float* params, const float* e, const float w, GLOBAL float* memory, float* s) {{\n"
        );
        let live = self.live();
        for (i, op) in self.ops.iter().enumerate().filter(|(i, _)| live[*i]) {
            let kind = if op.is_mask() { "bool" } else { "float" };
            _ = writeln!(text, "  const {kind} v{i} = {};", expression(*op));
        }
        self.stress.iter().enumerate().for_each(|(i, s)| _ = writeln!(text, "  s[{i}] = v{s};"));
        if self.remembered > 0 {
            _ = self.moved.map(|moved| writeln!(text, "  if (!(0.0f < v{moved})) return 0.0f;"));
            self.memory.iter().enumerate().for_each(|(i, m)| _ = writeln!(text, "  memory[{}] = v{m};", 8 * i));
            _ = writeln!(text, "  return v{};", self.spent);
        } else {
            text += "  return 0.0f;\n";
        }
        text + "}\n"
    }

    /// Number of operations in its code.
    pub(crate) fn operations(&self) -> usize {
        self.live().into_iter().filter(|is_live| *is_live).count()
    }

    /// Operations that something depends on.
    fn live(&self) -> Vec<bool> {
        let mut live = vec![false; self.ops.len()];
        let outputs = self.stress.iter().chain(&self.memory).chain(&self.moved).chain([&self.spent]);
        outputs.for_each(|&i| live[i as usize] = true);
        for i in (0..self.ops.len()).rev() {
            if live[i] {
                let (operands, count) = self.ops[i].operands();
                operands[..count].iter().for_each(|&a| live[a as usize] = true);
            }
        }
        live
    }
}

/// An operation in C; every one is exactly rounded, as on the processor.
fn expression(op: Op) -> String {
    let exponent = |a: u32| format!("((as_int(v{a}) - 0x3f3504f3) >> 23)");
    match op {
        Op::In(Input::Strain, k) => format!("e[{k}]"),
        Op::In(Input::Memory, k) => format!("memory[{}]", 8 * k),
        Op::In(Input::Width, _) => "w".to_owned(),
        Op::Param(k) => format!("params[{k}]"),
        Op::Const(bits) => format!("as_float(0x{bits:08x}u)"),
        Op::Add(a, b) => format!("v{a} + v{b}"),
        Op::Sub(a, b) => format!("v{a} - v{b}"),
        Op::Mul(a, b) => format!("v{a} * v{b}"),
        Op::Div(a, b) => format!("v{a} / v{b}"),
        Op::Neg(a) => format!("-v{a}"),
        Op::Fma(a, b, c) => format!("fma(v{a}, v{b}, v{c})"),
        Op::Min(a, b) => format!("v{a} < v{b} ? v{a} : v{b}"),
        Op::Max(a, b) => format!("v{a} > v{b} ? v{a} : v{b}"),
        Op::Abs(a) => format!("fabs(v{a})"),
        Op::Sqrt(a) => format!("sqrt(v{a})"),
        Op::Round(a) => format!("rint(v{a})"),
        Op::Pow2(a) => format!("as_float((uint)((int)v{a} + 127) << 23)"),
        Op::Mantissa(a) => format!("as_float(as_int(v{a}) - {} * 8388608)", exponent(a)),
        Op::Exponent(a) => format!("(float){}", exponent(a)),
        Op::Lt(a, b) => format!("v{a} < v{b}"),
        Op::And(a, b) => format!("v{a} && v{b}"),
        Op::Or(a, b) => format!("v{a} || v{b}"),
        Op::Not(a) => format!("!v{a}"),
        Op::Select(m, a, b) => format!("v{m} ? v{a} : v{b}"),
    }
}
