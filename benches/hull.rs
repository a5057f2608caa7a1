//! Hulls and offsets of the paper's aggregates, against parry3d's hull.
//!
//! Contestants take turns on the same batches, and the median batch counts, in processor time of the thread: only the
//! ratios within one run mean anything. Writes benches/results/hull.csv.

#[path = "collision/clock.rs"]
#[allow(dead_code, unreachable_pub, reason = "each bench uses its part")]
mod clock;

use meso_core::geometry::{Polyhedron, convex_hull, inscribed_ball, inward_offset};
use meso_core::math::Vec3;
use meso_core::testing::{HullBuilder, Purpose, Stream};
use std::fmt::Write as _;
use std::hint::black_box;

const GRAINS: usize = 1000;
const ROUNDS: usize = 15;

type Contestant<'a> = (&'static str, Box<dyn FnMut() + 'a>);

/// Points on turned ellipsoids, 20 to 30 to a grain, 5 to 20 mm long.
fn grains() -> Vec<Vec<Vec3>> {
    let grain = |index: usize| {
        let mut stream = Stream::new(1, Purpose::Sample, 2, index as u64);
        let a = stream.uniform(2.5, 10.0);
        let b = a * stream.uniform(0.5, 1.0);
        let axes = Vec3::new(a, b, b * stream.uniform(0.5, 1.0));
        let turn = stream.rotation();
        let vertices = stream.integer(20, 30);
        (0..vertices).map(|_| turn * (stream.rotation() * Vec3::z()).component_mul(&axes)).collect()
    };
    (0..GRAINS).map(grain).collect()
}

/// Median seconds of a batch for every contestant.
fn compare(contestants: &mut [Contestant]) -> Vec<f64> {
    let mut seconds = vec![Vec::new(); contestants.len()];
    for _ in 0..ROUNDS {
        for ((_, run), seconds) in contestants.iter_mut().zip(&mut seconds) {
            let start = clock::seconds();
            run();
            seconds.push(clock::seconds() - start);
        }
    }
    let median = |mut s: Vec<f64>| {
        s.sort_by(f64::total_cmp);
        s[s.len() / 2]
    };
    seconds.into_iter().map(median).collect()
}

/// A contestant that does one thing to every item of a batch.
fn each<'a, T, R>(items: &'a [T], mut task: impl FnMut(&T) -> R + 'a) -> Box<dyn FnMut() + 'a> {
    Box::new(move || items.iter().for_each(|item| drop(black_box(task(item)))))
}

fn main() {
    let grains = grains();
    let bodies: Vec<Polyhedron> = grains.iter().map(|points| convex_hull(points).expect("solid")).collect();
    let parry: Vec<Vec<_>> = grains.iter().map(|points| points.iter().map(|p| (*p).into()).collect()).collect();
    let mut builder = HullBuilder::default();
    let mut contestants: Vec<Contestant> = vec![
        ("hull (builder kept)", each(&grains, move |points| builder.build(points))),
        ("hull", each(&grains, |points| convex_hull(points))),
        ("hull by parry3d-f64", each(&parry, |points| parry3d_f64::transformation::try_convex_hull(points))),
        ("offset by 0.3 mm", each(&bodies, |body| inward_offset(body, 0.3))),
        ("inscribed ball", each(&bodies, inscribed_ball)),
        ("volume with centroid and inertia", each(&bodies, Polyhedron::mass_properties)),
    ];
    let medians = compare(&mut contestants);
    let mut csv = String::from("what,microseconds_per_grain\n");
    for ((name, _), seconds) in contestants.iter().zip(medians) {
        let _ = writeln!(csv, "{name},{:.2}", seconds / GRAINS as f64 * 1e6);
    }
    // A bench reports to the terminal and to a file.
    #[expect(clippy::print_stdout, reason = "a bench's result")]
    {
        print!("{csv}");
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../benches/results/hull.csv");
    std::fs::write(path, csv).expect("benches/results can be written");
}
