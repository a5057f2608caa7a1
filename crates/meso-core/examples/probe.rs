use meso_core::*;
use std::time::Instant;
struct P(Instant);
impl Progress for P {
    fn update(&self, _: f64, _: f64) -> bool {
        true
    }
    fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let f: f64 = a[1].parse().unwrap();
    let seed: u64 = a.get(2).map_or(1, |s| s.parse().unwrap());
    let threads: usize = a.get(3).map_or(1, |s| s.parse().unwrap());
    let mut spec = Spec::default();
    spec.fraction = f;
    spec.seed = seed;
    if let Some(s) = a.get(4) {
        if s != "-" {
            spec.placement.attempts = Some(s.parse().unwrap());
        }
    }
    if let Some(s) = a.get(5) {
        spec.specimen = packing::Specimen::Cube { side_mm: s.parse().unwrap() };
    }
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().unwrap();
    let m = pack(&spec, &P(Instant::now())).unwrap();
    let r = &m.report;
    println!(
        "{} n={} disc={} f={:.5} stop={:?} {} t={:.2} take={:.2} place={:.2} {:?}",
        r.strategy,
        r.aggregates,
        r.discarded,
        r.fraction,
        r.stop_reason,
        r.stop_detail,
        r.seconds.total,
        r.seconds.take,
        r.seconds.place,
        r.work
    );
    for c in &r.classes {
        print!("{:.4} ", c.fraction / c.target_fraction - 1.0);
    }
    println!();
}
