//! Checkpoints and TEST.toml files as an enemy or a bad disk would write them.

use crate::hostile_solver::{checkpoint, test_file};
use meso_solve::TestKind;

/// A generator after G. Marsaglia (xorshift64*).
fn below(state: &mut u64, end: usize) -> usize {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16) as usize % end
}

#[test]
fn changed_checkpoints_with_a_right_hash_are_refused_or_go_on_without_a_panic() {
    let mut state = 3;
    checkpoint(b"");
    for _ in 0..100 {
        let bytes: Vec<u8> = (0..4 * (1 + below(&mut state, 3))).map(|_| below(&mut state, 256) as u8).collect();
        checkpoint(&bytes);
    }
}

/// Lines of good and bad tests.
const LINES: [&str; 30] = [
    "kind = 'compression'",
    "kind = 'bending'",
    "kind = 'triaxial'",
    "kind = 'cyclic'",
    "kind = 'expansion'",
    "strain = 1e-300",
    "strain = 0.001",
    "strain = nan",
    "duration_s = 1e-5",
    "time_step_s = 1e-7",
    "rows = 10",
    "rows = 4294967296",
    "frames = 10000",
    "law = 'cdpm2'",
    "law = 'meso'",
    "smoothing = 'edges'",
    "control = 'steady'",
    "ramp = 1",
    "hourglass = inf",
    "pressure_mpa = 0",
    "stress_ratio = 1e-320",
    "strip_mm = 1e300",
    "turns = [{ at = 0.001 }, { at = 1, of = 'stress' }, { at = -1e300, of = 'opening' }]",
    "expansion = { mortar = 0.02, aggregate = -0.005 }",
    "supports = [{ name = 'a', on = 'z-min', moves = 1 }, { name = 'b', on = 'z-max' }]",
    "supports = [{ name = 'a', on = 'mantle', rule = 'pressure', pressure_mpa = 1000 }]",
    "supports = [{ name = 'a', on = 'x-min', strip = { axis = 'y', at_mm = 1e300, width_mm = -1 } }]",
    "gauges = [{ kind = 'sides', name = 'g', axis = 'x' }, { kind = 'lvdt', name = 'h', axis = 'z', from_mm = 2, to_mm = 9 }]",
    "gauges = [{ kind = 'lvdt', name = 'g', axis = 'z', from_mm = nan, to_mm = inf }]",
    "\"\" = \"\"",
];

#[test]
fn tests_of_lines_in_any_order_break_nothing() {
    let mut state = 7;
    for _ in 0..400 {
        let lines: Vec<&str> = (0..below(&mut state, 6)).map(|_| LINES[below(&mut state, LINES.len())]).collect();
        test_file(lines.join("\n").as_bytes());
    }
    for kind in [TestKind::Compression, TestKind::Triaxial, TestKind::Cyclic, TestKind::Expansion] {
        test_file(kind.recipe().as_bytes());
    }
}
