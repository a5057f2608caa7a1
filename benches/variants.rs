//! The GJK variants under criterion: `cargo bench -p meso-bench --bench variants`, with criterion's own flags, `--quick`
//! among them.
//!
//! Who is compared and on which pairs is as in the bench `gjk`, which writes the tables of the documents. This one compares
//! with the run before it, and keeps its samples under `target/criterion/`.
#![allow(missing_docs, reason = "criterion makes its group public")]

mod collision;

use collision::ccd::Ccd;
use collision::contestants::contestants;
use collision::pairs;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::time::Duration;

/// Bodies of the pair sets.
const GRAINS: usize = 1000;

fn variants(criterion: &mut Criterion) {
    let ccd = Ccd::load().ok();
    let grains = pairs::grains(GRAINS);
    for (name, queries) in [
        ("intersecting", pairs::intersecting(&grains)),
        ("separated", pairs::separated(&grains)),
        ("near touch", pairs::near_touch(&grains)),
    ] {
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(queries.len() as u64));
        for (contestant, run) in contestants(&grains, ccd.as_ref()) {
            group.bench_function(contestant, |bencher| bencher.iter(|| run(&queries)));
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(Duration::from_secs(2));
    targets = variants
}
criterion_main!(benches);
