//! A point's bits do not depend on its neighbours in a register.

use crate::meso::{meso, rated, scattered};
use crate::safety::Dice;
use crate::subject::{WIDTH, cdp, cdpm2, mortar};
use meso_element::law::{Law, Tensor};
use meso_element::real::Real;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Two f32 side by side.
#[derive(Clone, Copy)]
struct Pair([f32; 2]);

#[derive(Clone, Copy)]
struct Mask([bool; 2]);

impl Pair {
    fn each(self, other: Self, operation: fn(f32, f32) -> f32) -> Self {
        Self([operation(self.0[0], other.0[0]), operation(self.0[1], other.0[1])])
    }
}

macro_rules! operators {
    ($($trait:ident $name:ident $of:ident $value:ident),*) => {
        $(impl $trait for $of {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                Self([0, 1].map(|i| $value::$name(self.0[i], other.0[i])))
            }
        })*
    };
}
operators!(Add add Pair f32, Sub sub Pair f32, Mul mul Pair f32, Div div Pair f32, BitAnd bitand Mask bool, BitOr bitor Mask bool);

impl Neg for Pair {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl Not for Mask {
    type Output = Self;
    fn not(self) -> Self {
        Self(self.0.map(|x| !x))
    }
}

impl Real for Pair {
    type Mask = Mask;
    const SINGLE: bool = true;
    fn splat(value: f64) -> Self {
        Self([value as f32; 2])
    }
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self([0, 1].map(|i| self.0[i].mul_add(b.0[i], c.0[i])))
    }
    fn min(self, other: Self) -> Self {
        self.each(other, Real::min)
    }
    fn max(self, other: Self) -> Self {
        self.each(other, Real::max)
    }
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    fn round(self) -> Self {
        Self(self.0.map(f32::round_ties_even))
    }
    fn pow2(self) -> Self {
        Self(self.0.map(Real::pow2))
    }
    fn split(self) -> (Self, Self) {
        let parts = self.0.map(Real::split);
        (Self(parts.map(|part| part.0)), Self(parts.map(|part| part.1)))
    }
    fn lt(self, other: Self) -> Mask {
        Mask([0, 1].map(|i| self.0[i] < other.0[i]))
    }
    fn select(mask: Mask, a: Self, b: Self) -> Self {
        Self([0, 1].map(|i| if mask.0[i] { a.0[i] } else { b.0[i] }))
    }
    fn any(mask: Mask) -> bool {
        mask.0[0] | mask.0[1]
    }
}

/// A quiet walk and a wild one, alone and side by side: stress and history to the last bit. Returns how often one point was
/// at rest (as stiff as new, no history) while the other was not.
fn neighbours<P: Law<Pair>, S: Law<f32>>(pair: &P, single: &S) -> usize {
    beside(pair, single, None)
}

/// The same with these numbers in the last registers of the histories.
fn beside<P: Law<Pair>, S: Law<f32>>(pair: &P, single: &S, last: Option<[f32; 2]>) -> usize {
    let (mut together, mut alone) = (P::virgin(), [S::virgin(), S::virgin()]);
    if let (Some(last), Some(both)) = (last, together.as_mut().last_mut()) {
        *both = Pair(last);
        let own = alone.iter_mut().filter_map(|history| history.as_mut().last_mut());
        own.zip(last).for_each(|(own, last)| *own = last);
    }
    let (mut dice, mut strains, mut mixed) = (Dice(5), [[0.0_f32; 6]; 2], 0);
    for step in 0..4000 {
        // The quiet point grows wilder, so that it, too, yields in the end.
        let sizes = [3e-8 * f64::from(step) / 40.0, 1e-5];
        for (strain, size) in strains.iter_mut().zip(sizes) {
            *strain = strain.map(|e| e + (size * dice.throw()) as f32);
        }
        let wide: Tensor<Pair> = std::array::from_fn(|i| Pair([strains[0][i], strains[1][i]]));
        let both = pair.stress(&wide, &mut together, Pair::splat(WIDTH));
        let bits = |x: f32| x.to_bits();
        for lane in 0..2 {
            let one = single.stress(&strains[lane], &mut alone[lane], WIDTH as f32);
            assert_eq!(both.stress.map(|s| bits(s.0[lane])), one.stress.map(bits), "step {step}");
            assert_eq!(bits(both.integrity.0[lane]), bits(one.integrity), "step {step}");
            let histories = together.as_ref().iter().zip(alone[lane].as_ref());
            assert!(histories.into_iter().all(|(a, b)| bits(a.0[lane]) == bits(*b)), "step {step}");
        }
        let virgin = |lane: usize| alone[lane].as_ref().iter().all(|x| *x == 0.0);
        mixed += usize::from(virgin(0) && !virgin(1));
    }
    mixed
}

#[test]
fn a_point_has_the_same_bits_alone_and_beside_another() {
    let (materials, usual) = (mortar(), Default::default());
    for mixed in [
        neighbours(&cdp::<Pair>(&materials), &cdp::<f32>(&materials)),
        neighbours(&cdpm2::<Pair>(&materials, &usual), &cdpm2::<f32>(&materials, &usual)),
        neighbours(&meso::<Pair>(), &meso::<f32>()),
    ] {
        assert!((500..3900).contains(&mixed), "a point at rest beside an active one in {mixed} of 4000 steps");
    }
    // Its history has a rate from the first step on.
    for dt in [1e-7, 1e-4] {
        neighbours(&rated::<Pair>(dt), &rated::<f32>(dt));
    }
    // Its history has a factor.
    for factors in [[-0.3, 0.2], [0.5, 0.5]] {
        beside(&scattered::<Pair, 9>(1.0), &scattered::<f32, 9>(1.0), Some(factors));
        beside(&scattered::<Pair, 11>(1e-4), &scattered::<f32, 11>(1e-4), Some(factors));
    }
}
