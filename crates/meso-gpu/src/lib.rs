//! Tests on a GPU, with the bytes of the processor.
//!
//! A run of `meso-solve` goes onto a device as flat tables; its laws become kernel code by running them over numbers that
//! write down their operations. Kernels are one file, OpenCL C and CUDA alike; drivers are opened at run time, and no library
//! is linked. Every operation is exactly rounded and every sum has the engine's order, so curves, frames and checkpoints are
//! those of the processor to the last bit, on devices that round so.

mod devices;
mod engine;
mod host;
mod law;
mod name;
mod source;
mod tables;
mod traffic;

pub use devices::{Choice, Lease, devices};
pub use host::cuda::ptx;
pub use name::{DeviceName, Driver, THREADS};
pub use traffic::Traffic;

use meso_solve::{Run, SolveError};

/// Hands the further steps of `run` to `device`; the bytes that it takes there.
///
/// # Errors
/// Tests that devices cannot take, and failures of the device.
pub fn attach(run: &mut Run, device: &DeviceName) -> Result<usize, SolveError> {
    let engine = engine::Engine::new(&run.upload()?, device);
    let engine = engine
        .map_err(|why| SolveError::Device(format!("{}:{}: {why}; {}", device.driver, device.number, devices::OTHER)))?;
    let bytes = engine.bytes;
    run.hand_to(Box::new(engine));
    Ok(bytes)
}

/// Source of the kernels for `run`, OpenCL C and CUDA in one.
///
/// # Errors
/// Tests that devices cannot take.
pub fn source(run: &Run, threads: usize) -> Result<String, SolveError> {
    let upload = run.upload()?;
    let laws = source::Laws::of(&upload);
    Ok(laws.source(&tables::Tables::of(&upload, &laws.of_material, threads), threads))
}

/// Bytes that `run` holds on a device, and that every step moves there, for groups of `threads`. No device is needed.
///
/// # Errors
/// Tests that devices cannot take.
pub fn traffic(run: &Run, threads: usize) -> Result<Traffic, SolveError> {
    traffic::count(&run.upload()?, threads).map_err(SolveError::Device)
}
