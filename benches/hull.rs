//! Hulls and offsets of the paper's aggregates, against parry3d's hull.
//!
//! Contestants take turns on the same batches, and the median batch counts, in processor time of the thread: only the
//! ratios within one run mean anything. Writes benches/results/hull.csv; `--quick` takes few grains.

#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

#[path = "collision/clock.rs"]
#[allow(dead_code, unreachable_pub, reason = "each bench uses its part")]
mod clock;
#[path = "collision/table.rs"]
mod table;

use meso_concrete::aggregate::random::{Draw, Stream};
use meso_core::geometry::HullBuilder;
use meso_core::geometry::{Polyhedron, convex_hull};
use meso_core::math::Vec3;
use parry3d_f64::math::Vector;
use std::hint::black_box;
use table::Table;

const GRAINS: usize = 1000;
const FEW: usize = 20;
const ROUNDS: usize = 15;

type Contestant<'a> = (&'static str, Box<dyn FnMut() + 'a>);

/// Points on turned ellipsoids, 20 to 30 to a grain, 5 to 20 mm long.
fn grains() -> Vec<Vec<Vec3>> {
    let grain = |index: usize| {
        let mut stream = Stream::new(1, Draw::Sample, 2, index as u64);
        let a = stream.uniform(2.5, 10.0);
        let b = a * stream.uniform(0.5, 1.0);
        let axes = Vec3::new(a, b, b * stream.uniform(0.5, 1.0));
        let turn = stream.rotation();
        let vertices = stream.integer(20, 30);
        (0..vertices).map(|_| turn * (stream.rotation() * Vec3::z()).component_mul(&axes)).collect()
    };
    (0..table::count(GRAINS, FEW)).map(grain).collect()
}

/// Median seconds of a batch for every contestant.
fn compare(contestants: &mut [Contestant]) -> Vec<f64> {
    let mut seconds = vec![Vec::new(); contestants.len()];
    for _ in 0..table::count(ROUNDS, 1) {
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
    let parry: Vec<Vec<_>> =
        grains.iter().map(|points| points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect()).collect();
    let mut builder = HullBuilder::default();
    let mut contestants: Vec<Contestant> = vec![
        ("hull (builder kept)", each(&grains, move |points| builder.build(points))),
        ("hull", each(&grains, |points| convex_hull(points))),
        ("hull by parry3d-f64", each(&parry, |points| parry3d_f64::transformation::try_convex_hull(points))),
        ("offset by 0.3 mm", each(&bodies, |body| body.inward_offset(0.3))),
        ("inscribed ball", each(&bodies, Polyhedron::inscribed_ball)),
        ("volume with centroid and inertia", each(&bodies, Polyhedron::mass_properties)),
    ];
    let medians = compare(&mut contestants);
    let mut table = Table::new("what,microseconds_per_grain");
    for ((name, _), seconds) in contestants.iter().zip(medians) {
        let row = [(*name).to_owned(), format!("{:.2}", seconds / table::count(GRAINS, FEW) as f64 * 1e6)];
        println!("{}", row.join(","));
        table.row(&row);
    }
    table.save("hull.csv");
}
