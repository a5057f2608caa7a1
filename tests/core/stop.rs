//! Work that nobody waits for any more ends at once.

use meso_core::check::check;
use meso_core::mesh::{self, MeshOptions, Method};
use meso_core::statistics::{Options, statistics};
use meso_core::stop::{Stopped, listen};
use meso_core::{Model, Silent, Spec, pack};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long `work` takes to end after it was told to, some time after its begin; `None` where it was done before.
fn ended_after<T: Send>(begun: Duration, work: impl FnOnce() -> T + Send) -> Option<Duration> {
    let flag = Arc::new(AtomicBool::new(false));
    let heard = Arc::clone(&flag);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).start_handler(move |_| listen(Arc::clone(&heard)));
    let pool = pool.build().unwrap();
    let told = std::thread::spawn(move || {
        std::thread::sleep(begun);
        flag.store(true, Ordering::Relaxed);
        Instant::now()
    });
    let ended = catch_unwind(AssertUnwindSafe(|| pool.install(work)));
    let now = Instant::now();
    let told = told.join().unwrap();
    ended.err().map(|payload| {
        assert!(payload.is::<Stopped>(), "it failed by itself");
        now - told
    })
}

fn model() -> Model {
    let spec = Spec::from_toml("fraction = 0.3\nspecimen = { kind = 'cube', side_mm = 60 }").unwrap();
    pack(&spec, &Silent).unwrap()
}

#[test]
fn meshes_checks_and_statistics_end_when_they_are_told_to() {
    let model = model();
    // The promise is half a second on a machine with nothing else to do; without points the meshes take ten and more.
    let most = Duration::from_secs(4);
    for (begun, method, element_size_mm) in
        [(10, Method::VOXEL, 0.25), (100, Method::FITTED, 0.5), (700, Method::FITTED, 0.5), (3000, Method::FITTED, 0.5)]
    {
        let options = MeshOptions { method, element_size_mm, ..MeshOptions::default() };
        let took = ended_after(Duration::from_millis(begun), || mesh::build(&model, &options).is_ok());
        assert!(took.is_some_and(|took| took < most), "{method:?} after {begun} ms: {took:?}");
    }
    let options = Options { lines: 10_000_000, points: 10_000_000, ..Options::default() };
    let took = ended_after(Duration::from_millis(100), || statistics(&model, &options).is_ok());
    assert!(took.is_some_and(|took| took < most), "statistics: {took:?}");
    let took = ended_after(Duration::ZERO, || (0..1000).map(|_| check(&model).aggregates).sum::<usize>());
    assert!(took.is_some_and(|took| took < most), "check: {took:?}");
}
