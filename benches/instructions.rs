//! Passes over a set of pairs, for whoever counts instructions: on an emulated machine they are all there is to measure.
//!
//! `cargo bench -p meso-collision --bench instructions -- SET PASSES`, SET being intersecting, separated, near or stream;
//! `--quick` asks few pairs. What three passes take beyond one, over 1,000, is a pair's. For arm64 count the lines that
//! begin with `Trace` of `qemu-aarch64 -one-insn-per-tb -d nochain,exec PROGRAM SET 3`.
#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

use meso_collision::geometry::convex_hull;
use meso_collision::gjk::Body;
use meso_collision::math::{Mat3, Vec3};

#[allow(dead_code, reason = "other benches write tables")]
#[path = "collision/table.rs"]
mod table;

const PAIRS: usize = 500;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let word = |i: usize, usual: &'static str| words.get(i).map_or(usual, String::as_str);
    let (set, passes) = (word(0, "stream"), word(1, "1").parse().expect("PASSES is a number"));
    let mut stream = Stream(5);
    let bodies: Vec<Body> = (0..30).map(|_| body(&mut stream)).collect();
    let pairs = table::count(PAIRS, PAIRS / 10);
    let mut asks = Vec::with_capacity(pairs);
    while asks.len() < pairs {
        asks.extend(pair(set, &mut stream, &bodies));
    }
    let mut hits = 0;
    for _ in 0..passes {
        hits += asks.iter().filter(|(a, b, b_from_a)| a.overlaps(b, b_from_a)).count();
    }
    println!("{hits} of {} overlap", passes * pairs);
}

/// Numbers that cost no instructions to speak of.
struct Stream(u64);

impl Stream {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::from([(); 3].map(|()| 2.0 * self.unit() - 1.0));
            if (0.01..1.0).contains(&v.norm_squared()) {
                return v.normalize();
            }
        }
    }
}

/// A grain of 20 to 30 points.
fn body(stream: &mut Stream) -> Body {
    let n = 20 + (11.0 * stream.unit()) as usize;
    let axes = Vec3::new(1.0, 0.5 + 0.5 * stream.unit(), 0.3 + 0.2 * stream.unit()) * (2.5 + 2.5 * stream.unit());
    let points: Vec<Vec3> = (0..n).map(|_| stream.direction().component_mul(&axes)).collect();
    Body::on_ellipsoid(&points, &axes, &Mat3::identity()).with_inside_of(&convex_hull(&points).expect("a solid"))
}

/// A pair of the set, or none where the next try must do.
fn pair<'a>(set: &str, stream: &mut Stream, bodies: &'a [Body]) -> Option<(&'a Body, &'a Body, Vec3)> {
    let [a, b] = [0, 1].map(|_| &bodies[(bodies.len() as f64 * stream.unit()) as usize]);
    let reach = a.circumradius() + b.circumradius();
    let v = stream.direction();
    let at = |far: f64| (a, b, v * far);
    match set {
        "intersecting" => Some(at(0.45 * reach * stream.unit())),
        "separated" => Some(at(reach * (0.5 + 0.5 * stream.unit()))).filter(|(.., b_from_a)| !a.overlaps(b, b_from_a)),
        "near" => {
            let (mut inside, mut outside) = (0.0, reach);
            for _ in 0..25 {
                let middle = 0.5 * (inside + outside);
                *(if a.overlaps(b, &(v * middle)) { &mut inside } else { &mut outside }) = middle;
            }
            let off = libm::exp10(-3.0 - 4.0 * stream.unit());
            Some(at(inside * if stream.unit() < 0.5 { 1.0 + off } else { 1.0 - off }))
        }
        _ => Some(at(reach * libm::cbrt(stream.unit()))),
    }
}
