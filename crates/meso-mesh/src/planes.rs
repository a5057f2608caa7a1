//! The planes of a body's faces by eights, so that a point or a segment meets eight planes at once.

use meso_collision::geometry::Plane;
use meso_collision::math::Vec3;
use meso_collision::simd::{Wide, widest};

/// Planes, corners or cells that are taken together.
pub(crate) const LANES: usize = 8;

/// Eight planes of a body.
#[derive(Clone)]
pub(crate) struct EightPlanes {
    pub(crate) normal: [[f64; LANES]; 3],
    pub(crate) offset: [f64; LANES],
}

impl EightPlanes {
    /// All `planes`; the last eight is filled up with a plane that it has already.
    pub(crate) fn all(planes: &[Plane]) -> Vec<Self> {
        planes.chunks(LANES).map(Self::of).collect()
    }

    fn of(planes: &[Plane]) -> Self {
        let lane = |l: usize| planes[l.min(planes.len() - 1)];
        Self {
            normal: [0, 1, 2].map(|axis| std::array::from_fn(|l| lane(l).normal[axis])),
            offset: std::array::from_fn(|l| lane(l).offset),
        }
    }
}

/// [`Plane::height_over`] of some planes.
pub(crate) fn height_over(eights: &[EightPlanes], x: &Vec3) -> f64 {
    widest(PlaneHeight(eights, x))
}

/// The part of the segment from `inside` along `direction` that lies within the body of some planes, 0 to 1.
pub(crate) fn exit(eights: &[EightPlanes], inside: &Vec3, direction: &Vec3) -> f64 {
    widest(Exit { eights, inside, direction })
}

/// Calls `visit` with the numbers of the planes, `count` in all, that lie within `slack` mm of `x`.
pub(crate) fn touched(eights: &[EightPlanes], count: usize, x: &Vec3, slack: f64, visit: impl FnMut(usize)) {
    each_bit(eights, count, |eights| widest(TouchedPlanes { eights, x, slack }), visit);
}

/// Eights whose lanes are the bits of a word.
const WORD: usize = 8;

/// Calls `visit` with the numbers below `count` of the lanes whose bits `lanes` sets for a word of eights.
pub(crate) fn each_bit<T>(eights: &[T], count: usize, lanes: impl Fn(&[T]) -> u64, mut visit: impl FnMut(usize)) {
    for (part, eights) in eights.chunks(WORD).enumerate() {
        let mut left = lanes(eights);
        while left != 0 {
            let number = WORD * LANES * part + left.trailing_zeros() as usize;
            if number < count {
                visit(number);
            }
            left &= left - 1;
        }
    }
}

/// The bits of eight lanes.
#[inline(always)]
pub(crate) fn bits(is_set: impl Fn(usize) -> bool) -> u64 {
    let mut bits = 0;
    for l in 0..LANES {
        bits |= u64::from(is_set(l)) << l;
    }
    bits
}

struct PlaneHeight<'a>(&'a [EightPlanes], &'a Vec3);

impl Wide for PlaneHeight<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self(eights, x) = self;
        let mut highest = [f64::NEG_INFINITY; LANES];
        for EightPlanes { normal: [nx, ny, nz], offset } in eights {
            for l in 0..LANES {
                let height = nx[l] * x.x + ny[l] * x.y + nz[l] * x.z - offset[l];
                highest[l] = if height > highest[l] { height } else { highest[l] };
            }
        }
        highest.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

struct Exit<'a> {
    eights: &'a [EightPlanes],
    inside: &'a Vec3,
    direction: &'a Vec3,
}

impl Wide for Exit<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { eights, inside: from, direction: way } = self;
        let mut exit = [1.0; LANES];
        for EightPlanes { normal: [nx, ny, nz], offset } in eights {
            for l in 0..LANES {
                let speed = nx[l] * way.x + ny[l] * way.y + nz[l] * way.z;
                let share = (offset[l] - (nx[l] * from.x + ny[l] * from.y + nz[l] * from.z)) / speed;
                exit[l] = if (speed > 0.0) & (share < exit[l]) { share } else { exit[l] };
            }
        }
        exit.into_iter().fold(1.0, f64::min).max(0.0)
    }
}

struct TouchedPlanes<'a> {
    eights: &'a [EightPlanes],
    x: &'a Vec3,
    slack: f64,
}

impl Wide for TouchedPlanes<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let Self { eights, x, slack } = self;
        let mut all = 0;
        for (number, EightPlanes { normal: [nx, ny, nz], offset }) in eights.iter().enumerate() {
            let height = |l: usize| nx[l] * x.x + ny[l] * x.y + nz[l] * x.z - offset[l];
            all |= bits(|l| height(l).abs() <= slack) << (LANES * number);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::convex_hull;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    #[test]
    fn heights_and_exits_by_eights_have_the_bits_of_planes_one_by_one() {
        let mut random = ChaCha8Rng::seed_from_u64(48);
        let mut point = || Vec3::from_fn(|_, _| f64::from(random.next_u32()) / f64::from(u32::MAX)) * 10.0;
        let mut crossed = 0;
        for corners in 4..30 {
            let body = convex_hull(&(0..corners).map(|_| point()).collect::<Vec<_>>()).unwrap();
            let planes: Vec<Plane> = body.planes().collect();
            let eights = EightPlanes::all(&planes);
            for _ in 0..200 {
                let (x, direction) = (point(), point() - point());
                assert_eq!(height_over(&eights, &x).to_bits(), Plane::height_over(&planes, &x).to_bits());
                let ahead = planes.iter().filter(|plane| plane.normal.dot(&direction) > 0.0);
                let share = |p: &Plane| (p.offset - p.normal.dot(&x)) / p.normal.dot(&direction);
                let one_by_one = ahead.map(share).fold(1.0, f64::min).max(0.0);
                assert_eq!(exit(&eights, &x, &direction), one_by_one);
                crossed += usize::from(one_by_one > 0.0 && one_by_one < 1.0);
            }
        }
        assert!((500..5000).contains(&crossed), "{crossed}");
    }
}
