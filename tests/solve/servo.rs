//! Plates with a servo: a specimen that collapses stays slow, and its curve up to the peak is that between steady plates.

use crate::samples::{brittle, concrete, damaged_plasticity, slender};
use meso_core::mesh::{ItzForm, Method};
use meso_solve::{Control, Frame, LawName, Observer, Row, Test};
use std::cell::RefCell;

fn steady() -> Test {
    Test { control: Some(Control::Steady), ..damaged_plasticity() }
}

/// Number of the row with the highest stress.
fn peak(rows: &[Row]) -> usize {
    (0..rows.len()).max_by(|&a, &b| rows[a].stress_mpa.total_cmp(&rows[b].stress_mpa)).unwrap()
}

#[test]
fn a_servo_keeps_a_collapse_quasi_static_and_the_curve_to_the_peak() {
    let specimen = slender();
    let [fast, slow] = [steady(), damaged_plasticity()].map(|test| specimen.solve(&brittle(), &test));
    let (before, after) = (fast.result.kinetic_over_internal_max, slow.result.kinetic_over_internal_max);
    assert!(before > 0.01 && after < 0.5 * before, "{before} {after}");
    let (rows, all) = (&fast.curve[..=peak(&fast.curve)], &slow.curve);
    assert!(rows.len() > 50 && rows == &all[..rows.len()] && peak(all) + 1 == rows.len(), "{}", rows.len());
    // It goes to the same strain, in steps that are more, but not twice as many.
    let strain = |rows: &[Row]| rows.last().unwrap().strain;
    assert!((strain(all) / strain(&fast.curve) - 1.0).abs() < 2e-3, "{} {}", strain(all), strain(&fast.curve));
    let (steps, planned) = (slow.result.steps, slow.result.steps_planned);
    assert!(fast.result.steps == planned && (planned + 100..2 * planned).contains(&steps), "{steps} {planned}");
    assert!(slow.result.energy_balance_error < 1e-3, "{:?}", slow.result);
}

/// Numbers and strains of the frames, in their order.
#[derive(Default)]
struct Frames(RefCell<Vec<(u32, f64)>>);

impl Observer for Frames {
    fn frame(&self, frame: &Frame) {
        self.0.borrow_mut().push((frame.number(), frame.strain()));
    }
}

/// Ten frames were asked, and 24 written: they came by the steps of the servo.
#[test]
fn frames_come_as_many_as_asked_at_even_strains_and_rows_more_densely_while_the_plates_are_held() {
    let (specimen, test) = (slender(), Test { rows: 100, frames: 40, ..damaged_plasticity() });
    let frames = Frames::default();
    let response = specimen.watched(&brittle(), &test, &meso_core::Silent, &frames);
    let (frames, result) = (frames.0.into_inner(), &response.result);
    assert!(result.steps > result.steps_planned && frames.len() == 40, "{frames:?}");
    for ((number, strain), expected) in frames.into_iter().zip(1..) {
        let even = test.strain() * f64::from(number) / 40.0;
        assert!(number == expected && (strain / even - 1.0).abs() < 0.02, "{number} {strain} {even}");
    }
    let stride = response.curve[0].time_s;
    let apart = response.curve.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
    assert!(apart.fold(0.0, f64::max) < 2.0 * stride, "rows are far apart");
}

#[test]
fn a_specimen_that_does_not_break_is_not_held() {
    let specimen = concrete(1.0, Method::FITTED, 4.0, ItzForm::Smeared);
    for test in [
        Test { law: LawName::Elastic, ..damaged_plasticity() },
        Test { strain: Some(0.0005), ..damaged_plasticity() },
        Test { law: LawName::Elastic, kind: meso_solve::TestKind::Tension, ..damaged_plasticity() },
    ] {
        let result = specimen.solve(&brittle(), &test).result;
        assert_eq!(result.steps, result.steps_planned, "{test:?}");
    }
}
