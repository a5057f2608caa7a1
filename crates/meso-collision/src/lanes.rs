//! Eight numbers side by side, and which of them is the least.
//!
//! Rotates all eight lanes instead of halving: LLVM would narrow a halving reduction back to the loads.

/// Numbers side by side.
pub const LANES: usize = 8;
/// As many numbers.
pub type Eight = [f32; LANES];

/// The least of eight numbers.
#[inline(always)]
pub(crate) fn least(eight: &Eight) -> f32 {
    let mut low = *eight;
    for by in [4, 2, 1] {
        let other: Eight = std::array::from_fn(|lane| low[(lane + by) % LANES]);
        for lane in 0..LANES {
            low[lane] = if other[lane] < low[lane] { other[lane] } else { low[lane] };
        }
    }
    low[0]
}

/// The least of eight finite numbers and its lane, without a branch, since no guess of it would be right. Their last
/// three bits are not looked at.
#[inline(always)]
pub(crate) fn least_lane(eight: &Eight) -> (f32, usize) {
    let mut keys = [0.0; LANES];
    for lane in 0..LANES {
        keys[lane] = f32::from_bits(eight[lane].to_bits() & !(LANES as u32 - 1) | lane as u32);
    }
    let key = least(&keys);
    (key, key.to_bits() as usize % LANES)
}

/// `least_lane` of numbers none of which is below 0: these are in the order of their bits.
#[inline(always)]
pub fn least_lane_from_0(eight: &Eight) -> (f32, usize) {
    let mut least = u32::MAX;
    for (lane, number) in eight.iter().enumerate() {
        least = least.min(number.to_bits() & !(LANES as u32 - 1) | lane as u32);
    }
    (f32::from_bits(least), least as usize % LANES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn the_least_is_found_in_every_lane() {
        let mut stream = Stream::new(5);
        for case in 0..800 {
            let mut eight: Eight = std::array::from_fn(|_| stream.uniform(-1.0, 2.0) as f32);
            eight[case % LANES] = -1.5;
            assert_eq!(least(&eight), -1.5);
            let (low, lane) = least_lane(&eight);
            assert!(lane == case % LANES && (low + 1.5).abs() < 1e-5);
            let (low, lane) = least_lane_from_0(&eight.map(|x| x + 1.75));
            assert!(lane == case % LANES && (low - 0.25).abs() < 1e-6);
        }
        assert_eq!(least_lane(&[f32::MAX; LANES]).1, 0);
        assert_eq!(least_lane_from_0(&[f32::MAX; LANES]).1, 0);
    }
}
