//! Devices behind their drivers' libraries, which are opened at run time: one small interface for OpenCL and CUDA.

pub(crate) mod cuda;
pub(crate) mod opencl;

/// Memory of a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Buffer(pub(crate) u64);

/// A compiled kernel with its arguments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel(pub(crate) usize);

/// A device of one driver. Everything goes in order, one thing after the other.
pub(crate) trait Host: Send + Sync {
    /// Compiles `source` for groups of some size; [`kernel`](Self::kernel) names its kernels.
    fn compile(&mut self, source: &str) -> Result<(), String>;
    /// Memory of `bytes`.
    fn buffer(&mut self, bytes: usize) -> Result<Buffer, String>;
    /// Writes `bytes` into a buffer, `at` bytes from its start.
    fn write(&mut self, to: Buffer, at: usize, bytes: &[u8]) -> Result<(), String>;
    /// Reads a buffer, `at` bytes from its start, once all work before it is done.
    fn read(&mut self, from: Buffer, at: usize, bytes: &mut [u8]) -> Result<(), String>;
    /// A kernel with its arguments.
    fn kernel(&mut self, name: &str, arguments: &[Buffer]) -> Result<Kernel, String>;
    /// Starts a kernel in `groups` groups of `threads`.
    fn launch(&mut self, kernel: Kernel, groups: usize, threads: usize) -> Result<(), String>;
}

/// Opens the first library of `names` that is there.
fn library(names: &[String]) -> Result<libloading::Library, String> {
    #[allow(unsafe_code, reason = "a driver's library runs code when it is opened")]
    // SAFETY: the names are those of drivers' libraries, whose initialisers may run at any time.
    names
        .iter()
        .find_map(|name| unsafe { libloading::Library::new(name) }.ok())
        .ok_or_else(|| format!("there is no {}", names[0]))
}
