//! Work that nobody waits for any more ends at once.
//!
//! The tests measure the processor time of the working threads, which a busy machine does not change.

use meso_concrete::stop::{Stopped, listen};
use meso_core::check::check;
use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::{self, MeshError, MeshOptions, Method, Tools};
use meso_core::specimen::Specimen;
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::voxel_image::{ImageOptions, Quantity, VoxelImage};
use meso_core::watch::Stage;
use meso_core::{Model, Silent, Spec, Watch, pack, saved};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// The promise, s, on a machine with nothing else to do.
const MOST: f64 = 0.5;

/// Nobody waits once this is true.
#[derive(Clone, Default)]
struct Flag(Arc<AtomicBool>);

impl Watch for Flag {
    fn abandoned(&self) -> Option<Arc<AtomicBool>> {
        Some(Arc::clone(&self.0))
    }
}

/// Moments at which work is abandoned, ms after its begin.
const MOMENTS: [u64; 3] = [10, 100, 700];

/// Processor time of the busiest thread, s: from the kernel where it counts, else a tenth of the clock's, since others
/// work, too.
fn used(threads: &[PathBuf], start: Instant) -> f64 {
    let nanoseconds = |path: &PathBuf| -> Option<f64> {
        std::fs::read_to_string(path.join("schedstat")).ok()?.split(' ').next()?.parse().ok()
    };
    let used: Option<Vec<f64>> = threads.iter().map(nanoseconds).collect();
    match used {
        Some(used) => used.into_iter().fold(0.0, f64::max) * 1e-9,
        None => 0.1 * start.elapsed().as_secs_f64(),
    }
}

/// Seconds for which `work` goes on after it was abandoned at `begun`; `None` where it was done before.
fn ended_after<T>(begun: Duration, work: impl FnOnce() -> T + Send) -> Option<f64> {
    let (flag, threads, start) = (Flag::default(), Arc::new(Mutex::new(Vec::new())), Instant::now());
    let (heard, working) = (flag.clone(), Arc::clone(&threads));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).start_handler(move |_| {
        listen(&heard);
        let own = std::fs::read_link("/proc/thread-self").map(|own| PathBuf::from("/proc").join(own));
        working.lock().unwrap().push(own.unwrap_or_default());
    });
    let pool = pool.build().unwrap();
    let (told, ended) = std::thread::scope(|scope| {
        let told = scope.spawn(|| {
            std::thread::sleep(begun);
            let used = used(&threads.lock().unwrap(), start);
            flag.0.store(true, Ordering::Relaxed);
            used
        });
        let ended = catch_unwind(AssertUnwindSafe(|| pool.install(|| drop(work()))));
        let used = used(&threads.lock().unwrap(), start);
        (told.join().unwrap(), ended.err().map(|payload| (payload, used)))
    });
    ended.map(|(payload, used)| {
        assert!(payload.is::<Stopped>(), "it failed by itself");
        used - told
    })
}

/// Asserts that `work` ends in time whenever it is abandoned, at one of these moments or more.
fn ends_soon<T>(name: &str, moments: &[u64], work: impl Fn() -> T + Sync) {
    let after = |moment: u64| ended_after(Duration::from_millis(moment), &work);
    // Work that is really late is late again. Where memory is short, the kernel takes some tenths of a second now and
    // then.
    let ended = moments.iter().filter_map(|&moment| {
        let seconds = after(moment)?;
        let again = if seconds < MOST { None } else { after(moment) };
        Some((again.map_or(seconds, |again| seconds.min(again)), moment))
    });
    let worst = ended.max_by(|a, b| a.0.total_cmp(&b.0));
    let (seconds, moment) = worst.unwrap_or_else(|| panic!("{name} never heard that it was told to end"));
    eprintln!("{name}: {seconds:.3} s at worst, told after {moment} ms");
    assert!(seconds < MOST, "{name} went on for {seconds} s, told to end after {moment} ms");
}

fn model(side_mm: f64) -> Model {
    let gaps = "placement = { min_gap_mm = 0.3, wall_gap_mm = 0.3 }";
    let spec = format!("fraction = 0.3\nspecimen = {{ kind = 'cube', side_mm = {side_mm} }}\n{gaps}");
    pack(&Spec::from_toml(&spec).unwrap(), &Silent).unwrap()
}

/// `times` times as many grains, one in the other, that the reader takes as they are.
fn repeated(model: &Model, times: usize) -> Model {
    let mut model = model.clone();
    model.aggregates = std::iter::repeat_n(&model.aggregates, times).flatten().cloned().collect();
    (0..).zip(&mut model.aggregates).for_each(|(id, aggregate)| aggregate.id = id);
    model.report.aggregates = model.aggregates.len();
    model
}

fn written(model: &Model) -> Vec<u8> {
    let mut text = Vec::new();
    saved::write(model, &mut text).unwrap();
    text
}

#[test]
fn the_reader_of_a_large_model_ends_when_it_is_abandoned() {
    let text = written(&repeated(&model(60.0), 50));
    ends_soon("read", &[20, 60], || saved::read(&text).is_ok());
}

/// Work of one kind for each grain, some seconds of it, has its end after any of them.
#[test]
fn shapes_of_many_grains_end_when_they_are_abandoned() {
    let many = repeated(&model(40.0), 400);
    ends_soon("shapes", &[10, 100], || {
        Statistics::of(&many, &StatisticsOptions { lines: 0, points: 0, ..StatisticsOptions::default() }).is_ok()
    });
}

#[test]
fn packing_ends_when_it_is_abandoned() {
    let spec = Spec::from_toml("fraction = 0.5\nspecimen = { kind = 'cube', side_mm = 100 }").unwrap();
    ends_soon("pack", &MOMENTS, || pack(&spec, &Silent).is_ok());
}

#[test]
fn meshes_end_when_they_are_abandoned() {
    let model = model(60.0);
    for (method, element_size_mm) in [(Method::VOXEL, 0.25), (Method::FITTED, 0.5)] {
        let options = MeshOptions { method, element_size_mm, ..MeshOptions::default() };
        ends_soon(&format!("{method:?}"), &MOMENTS, || mesh::build(&model, &options, &Tools::default()).is_ok());
    }
}

#[test]
fn surfaces_for_gmsh_end_when_they_are_abandoned() {
    let model = model(60.0);
    let options = MeshOptions { method: Method::CONFORMING, element_size_mm: 0.25, ..MeshOptions::default() };
    let none = |_: &Surfaces| Err(MeshError::NeedsGmsh);
    ends_soon("conforming", &MOMENTS, || {
        mesh::build(&model, &options, &Tools { gmsh: &none, ..Tools::default() }).is_ok()
    });
}

#[test]
fn checks_statistics_and_images_end_when_they_are_abandoned() {
    let model = model(60.0);
    let options = StatisticsOptions { lines: 10_000_000, points: 10_000_000, ..StatisticsOptions::default() };
    ends_soon("statistics", &MOMENTS, || Statistics::of(&model, &options).is_ok());
    ends_soon("check", &MOMENTS, || (0..1000).map(|_| check(&model).aggregates).sum::<usize>());
    for quantity in [Quantity::Share, Quantity::Distance, Quantity::Phase] {
        let options = ImageOptions { quantity, voxel_size_mm: 0.15, ..ImageOptions::default() };
        ends_soon(quantity.name(), &[10, 100, 300], || {
            VoxelImage::new(&model, &options).map(|image| image.slabs().count())
        });
    }
}

/// Every stage at so many moments that hardly any step is missed.
#[test]
#[ignore = "slow: some minutes"]
fn slow_no_step_of_any_stage_keeps_the_end_waiting() {
    // No step of 0.8 s is missed.
    let moments: Vec<u64> = (0..20).map(|k| 25 + 300 * k).collect();
    let small = model(60.0);
    let text = written(&repeated(&small, 200));
    ends_soon("read", &moments, || saved::read(&text).is_ok());
    drop(text);
    let spec = Spec::from_toml("fraction = 0.55\nspecimen = { kind = 'cube', side_mm = 150 }").unwrap();
    ends_soon("pack", &moments, || pack(&spec, &Silent).is_ok());
    for (method, element_size_mm) in [(Method::VOXEL, 0.4), (Method::FITTED, 0.7)] {
        let options = MeshOptions { method, element_size_mm, ..MeshOptions::default() };
        ends_soon(&format!("{method:?}"), &moments, || mesh::build(&small, &options, &Tools::default()).is_ok());
    }
    let many = pack(&Spec::default(), &Silent).unwrap();
    ends_soon("check", &moments, || check(&many).aggregates);
    let options = StatisticsOptions { lines: 300_000, points: 1_000_000, ..StatisticsOptions::default() };
    ends_soon("statistics", &moments, || Statistics::of(&many, &options).is_ok());
}

/// Stops once half of the meshing is done.
struct AtHalf(AtomicBool);

impl Watch for AtHalf {
    fn stage(&self, stage: Stage, share: f64) {
        assert_eq!(stage, Stage::Mesh);
        self.0.fetch_or(share >= 0.5, Ordering::Relaxed);
    }

    fn stops(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

#[test]
fn a_mesh_ends_with_an_error_when_its_watch_stops() {
    let options = MeshOptions { element_size_mm: 4.0, ..MeshOptions::default() };
    let watch = AtHalf(AtomicBool::new(false));
    let tools = Tools { watch: &watch, ..Tools::default() };
    let error = mesh::build((&[], &Specimen::cube(20.0)), &options, &tools).unwrap_err();
    assert!(matches!(error, MeshError::Stopped), "{error}");
}
