//! A tape of operations, and numbers that write on it.

use meso_solve::real::Real;
use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// An operation; its operands are numbers of earlier ones.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Op {
    /// A component of an input.
    In(Input, u32),
    /// A constant of a phase, by its number.
    Param(u32),
    /// The bits of an f32.
    Const(u32),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    Neg(u32),
    Fma(u32, u32, u32),
    Min(u32, u32),
    Max(u32, u32),
    Abs(u32),
    Sqrt(u32),
    Round(u32),
    Pow2(u32),
    Mantissa(u32),
    Exponent(u32),
    Lt(u32, u32),
    And(u32, u32),
    Or(u32, u32),
    Not(u32),
    Select(u32, u32, u32),
}

/// What a law is given.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Input {
    Strain,
    Memory,
    Width,
}

impl Op {
    /// Numbers of the operands.
    pub(crate) fn operands(self) -> ([u32; 3], usize) {
        match self {
            Self::In(..) | Self::Param(_) | Self::Const(_) => ([0; 3], 0),
            Self::Neg(a)
            | Self::Abs(a)
            | Self::Sqrt(a)
            | Self::Round(a)
            | Self::Pow2(a)
            | Self::Mantissa(a)
            | Self::Exponent(a)
            | Self::Not(a) => ([a, 0, 0], 1),
            Self::Fma(a, b, c) | Self::Select(a, b, c) => ([a, b, c], 3),
            Self::Add(a, b)
            | Self::Sub(a, b)
            | Self::Mul(a, b)
            | Self::Div(a, b)
            | Self::Min(a, b)
            | Self::Max(a, b)
            | Self::Lt(a, b)
            | Self::And(a, b)
            | Self::Or(a, b) => ([a, b, 0], 2),
        }
    }

    /// Whether the answer is yes or no.
    pub(crate) fn is_mask(self) -> bool {
        matches!(self, Self::Lt(..) | Self::And(..) | Self::Or(..) | Self::Not(_))
    }
}

#[derive(Default)]
struct Tape {
    ops: Vec<Op>,
    known: HashMap<Op, u32>,
    /// Values of constants while a law is made: they become parameters.
    params: Option<Vec<f32>>,
}

thread_local!(static TAPE: RefCell<Tape> = RefCell::default());

fn push(op: Op) -> u32 {
    TAPE.with_borrow_mut(|Tape { ops, known, .. }| {
        *known.entry(op).or_insert_with(|| {
            ops.push(op);
            ops.len() as u32 - 1
        })
    })
}

/// A number that writes down its operations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traced(pub(crate) u32);

/// A comparison that is written down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TracedMask(u32);

impl Traced {
    /// A component of an input.
    pub(crate) fn input(of: Input, component: usize) -> Self {
        Self(push(Op::In(of, component as u32)))
    }
}

/// Starts a tape on which constants are parameters.
pub(crate) fn start() {
    TAPE.set(Tape { params: Some(Vec::new()), ..Tape::default() });
}

/// Constants are constants from now on; the parameters so far.
pub(crate) fn end_of_parameters() -> Vec<f32> {
    TAPE.with_borrow_mut(|tape| tape.params.take().unwrap_or_default())
}

/// All operations so far.
pub(crate) fn take() -> Vec<Op> {
    TAPE.take().ops
}

macro_rules! operator {
    ($($trait:ident $name:ident),*) => {$(
        impl $trait for Traced {
            type Output = Self;
            fn $name(self, b: Self) -> Self {
                Self(push(Op::$trait(self.0, b.0)))
            }
        }
    )*};
}
operator!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        Self(push(Op::Neg(self.0)))
    }
}

impl BitAnd for TracedMask {
    type Output = Self;
    fn bitand(self, b: Self) -> Self {
        Self(push(Op::And(self.0, b.0)))
    }
}

impl BitOr for TracedMask {
    type Output = Self;
    fn bitor(self, b: Self) -> Self {
        Self(push(Op::Or(self.0, b.0)))
    }
}

impl Not for TracedMask {
    type Output = Self;
    fn not(self) -> Self {
        Self(push(Op::Not(self.0)))
    }
}

impl Real for Traced {
    type Mask = TracedMask;
    const SINGLE: bool = true;

    fn splat(value: f64) -> Self {
        let value = value as f32;
        let param = TAPE.with_borrow_mut(|tape| {
            tape.params.as_mut().map(|params| {
                params.push(value);
                params.len() as u32 - 1
            })
        });
        Self(push(param.map_or(Op::Const(value.to_bits()), Op::Param)))
    }
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(push(Op::Fma(self.0, b.0, c.0)))
    }
    fn min(self, b: Self) -> Self {
        Self(push(Op::Min(self.0, b.0)))
    }
    fn max(self, b: Self) -> Self {
        Self(push(Op::Max(self.0, b.0)))
    }
    fn abs(self) -> Self {
        Self(push(Op::Abs(self.0)))
    }
    fn sqrt(self) -> Self {
        Self(push(Op::Sqrt(self.0)))
    }
    fn round(self) -> Self {
        Self(push(Op::Round(self.0)))
    }
    fn pow2(self) -> Self {
        Self(push(Op::Pow2(self.0)))
    }
    fn split(self) -> (Self, Self) {
        (Self(push(Op::Mantissa(self.0))), Self(push(Op::Exponent(self.0))))
    }
    fn lt(self, b: Self) -> TracedMask {
        TracedMask(push(Op::Lt(self.0, b.0)))
    }
    fn select(mask: TracedMask, a: Self, b: Self) -> Self {
        Self(push(Op::Select(mask.0, a.0, b.0)))
    }
    /// Both ways are written down, and selected from.
    fn any(_: TracedMask) -> bool {
        true
    }
}
