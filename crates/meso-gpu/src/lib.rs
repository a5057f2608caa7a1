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
mod source;
mod tables;

pub use devices::{Choice, DeviceName, Driver, THREADS, devices};
pub use host::cuda::ptx;

use meso_solve::Run;

/// Why a device does not take a test.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GpuError {
    /// A test that devices have no code for.
    #[error(transparent)]
    Test(#[from] meso_solve::SolveError),
    /// The device or its driver failed.
    #[error("{0}: {1}; take another device (`mesocrete devices`), or --device cpu")]
    Device(String, String),
}

/// Hands the further steps of `run` to `device`; the bytes that it takes there.
///
/// # Errors
/// Tests that devices cannot take, and failures of the device.
pub fn attach(run: &mut Run, device: &DeviceName) -> Result<usize, GpuError> {
    let engine = engine::Engine::new(&run.upload()?, device);
    let engine = engine.map_err(|why| GpuError::Device(format!("{}:{}", device.driver, device.number), why))?;
    let bytes = engine.bytes;
    run.hand_to(Box::new(engine));
    Ok(bytes)
}

/// Source of the kernels for `run`, OpenCL C and CUDA in one.
///
/// # Errors
/// Tests that devices cannot take.
pub fn source(run: &Run, threads: usize) -> Result<String, GpuError> {
    let upload = run.upload()?;
    let laws = source::Laws::of(&upload);
    Ok(laws.source(&tables::Tables::of(&upload, &laws.of_phase, threads), threads))
}
