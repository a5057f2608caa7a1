//! CUDA by its driver, and NVRTC, which compiles the kernels at run time.
#![allow(unsafe_code, reason = "calls into the driver's library")]

use super::opencl::functions;
use super::{Buffer, Host, Kernel, library};
use crate::name::{DeviceName, Driver, THREADS};
use libloading::Library;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::ptr::{null, null_mut};

/// An object of the driver.
type Handle = *mut c_void;

functions!(Functions {
    cuInit(c_uint) -> c_int;
    cuDeviceGetCount(*mut c_int) -> c_int;
    cuDeviceGet(*mut c_int, c_int) -> c_int;
    cuDeviceGetName(*mut c_char, c_int, c_int) -> c_int;
    cuDeviceTotalMem_v2(*mut usize, c_int) -> c_int;
    cuDeviceGetAttribute(*mut c_int, c_int, c_int) -> c_int;
    cuDevicePrimaryCtxRetain(*mut Handle, c_int) -> c_int;
    cuDevicePrimaryCtxRelease_v2(c_int) -> c_int;
    cuCtxSetCurrent(Handle) -> c_int;
    cuModuleLoadData(*mut Handle, *const c_void) -> c_int;
    cuModuleUnload(Handle) -> c_int;
    cuModuleGetFunction(*mut Handle, Handle, *const c_char) -> c_int;
    cuMemAlloc_v2(*mut u64, usize) -> c_int;
    cuMemFree_v2(u64) -> c_int;
    cuMemcpyHtoD_v2(u64, *const c_void, usize) -> c_int;
    cuMemcpyDtoH_v2(*mut c_void, u64, usize) -> c_int;
    cuLaunchKernel(Handle, c_uint, c_uint, c_uint, c_uint, c_uint, c_uint, c_uint, Handle, *mut *mut c_void, *mut *mut c_void) -> c_int;
    cuGetErrorString(c_int, *mut *const c_char) -> c_int;
});

functions!(Compiler {
    nvrtcCreateProgram(*mut Handle, *const c_char, *const c_char, c_int, *const *const c_char, *const *const c_char) -> c_int;
    nvrtcCompileProgram(Handle, c_int, *const *const c_char) -> c_int;
    nvrtcGetProgramLogSize(Handle, *mut usize) -> c_int;
    nvrtcGetProgramLog(Handle, *mut c_char) -> c_int;
    nvrtcGetPTXSize(Handle, *mut usize) -> c_int;
    nvrtcGetPTX(Handle, *mut c_char) -> c_int;
    nvrtcDestroyProgram(*mut Handle) -> c_int;
});

/// Attributes of a device: its compute capability.
const MAJOR: c_int = 75;
const MINOR: c_int = 76;
/// Every operation is rounded by itself, as on the processor.
const OPTIONS: [&str; 4] = ["-fmad=false", "-prec-div=true", "-prec-sqrt=true", "-ftz=false"];

/// PTX of `source` for the architecture `compute_NN`.
///
/// # Errors
/// Where there is no NVRTC, and where the source cannot be compiled.
pub fn ptx(source: &str, architecture: &str) -> Result<String, String> {
    let library = compiler_library()?;
    let compiler = Compiler::of(&library)?;
    let (text, name) = (CString::new(source).map_err(|error| error.to_string())?, c"kernel.cl");
    let mut program = null_mut();
    // SAFETY: the texts end in zeros; there are no headers.
    let status =
        unsafe { (compiler.nvrtcCreateProgram)(&mut program, text.as_ptr(), name.as_ptr(), 0, null(), null()) };
    compiled(status, "nvrtcCreateProgram")?;
    let architecture = format!("--gpu-architecture={architecture}");
    let options: Vec<CString> =
        OPTIONS.into_iter().chain([&*architecture]).map(|option| CString::new(option).expect("no zero")).collect();
    let pointers: Vec<*const c_char> = options.iter().map(|option| option.as_ptr()).collect();
    // SAFETY: as many options as told.
    let status = unsafe { (compiler.nvrtcCompileProgram)(program, pointers.len() as c_int, pointers.as_ptr()) };
    if status != 0 {
        return Err(format!(
            "NVRTC: {}",
            answer(program, compiler.nvrtcGetProgramLogSize, compiler.nvrtcGetProgramLog)
        ));
    }
    let ptx = answer(program, compiler.nvrtcGetPTXSize, compiler.nvrtcGetPTX);
    // SAFETY: the program is not used again.
    unsafe { (compiler.nvrtcDestroyProgram)(&mut program) };
    Ok(ptx)
}

/// A text that NVRTC gives by its size and its letters.
fn answer(
    program: Handle,
    size: unsafe extern "C" fn(Handle, *mut usize) -> c_int,
    letters: unsafe extern "C" fn(Handle, *mut c_char) -> c_int,
) -> String {
    let mut bytes = 0;
    // SAFETY: the program is whole.
    unsafe { size(program, &mut bytes) };
    let mut text = vec![0_u8; bytes.max(1)];
    // SAFETY: the buffer has the size that was told.
    unsafe { letters(program, text.as_mut_ptr().cast()) };
    String::from_utf8_lossy(&text).trim_matches('\0').to_owned()
}

const NO_COMPILER: &str = "there is no libnvrtc, which compiles the kernels; install CUDA's NVRTC, or pip's \
                           nvidia-cuda-nvrtc with its folder in LD_LIBRARY_PATH";

/// NVRTC of CUDA 11 to 13, where the system looks for libraries.
fn compiler_library() -> Result<Library, String> {
    let versions = ["13", "12", "11.2"];
    let mut names: Vec<String> = versions.iter().map(|version| format!("libnvrtc.so.{version}")).collect();
    names.extend(
        ["libnvrtc.so", "/usr/local/cuda/lib64/libnvrtc.so", "nvrtc64_130_0.dll", "nvrtc64_120_0.dll"]
            .map(str::to_owned),
    );
    library(&names).map_err(|_| NO_COMPILER.to_owned())
}

fn compiled(status: c_int, what: &str) -> Result<(), String> {
    if status == 0 { Ok(()) } else { Err(format!("NVRTC: {what} gave {status}")) }
}

fn open() -> Result<(Library, Functions), String> {
    let library = library(&["libcuda.so.1", "libcuda.so", "nvcuda.dll"].map(str::to_owned))?;
    let functions = Functions::of(&library)?;
    // SAFETY: the one argument is 0.
    functions.checked(unsafe { (functions.cuInit)(0) }, "cuInit")?;
    Ok((library, functions))
}

impl Functions {
    fn checked(&self, status: c_int, what: &str) -> Result<(), String> {
        if status == 0 {
            return Ok(());
        }
        let mut text = null();
        // SAFETY: the driver gives a text of its own, or leaves null.
        let why = unsafe {
            (self.cuGetErrorString)(status, &mut text);
            if text.is_null() { String::new() } else { std::ffi::CStr::from_ptr(text).to_string_lossy().into_owned() }
        };
        Err(format!("CUDA: {what} gave {status}, {why}"))
    }

    fn count(&self) -> usize {
        let mut count = 0;
        // SAFETY: the place is a number's.
        let status = unsafe { (self.cuDeviceGetCount)(&mut count) };
        if status == 0 { count.max(0) as usize } else { 0 }
    }

    fn device(&self, number: usize) -> Result<c_int, String> {
        let mut device = 0;
        // SAFETY: the place is a number's.
        self.checked(unsafe { (self.cuDeviceGet)(&mut device, number as c_int) }, "cuDeviceGet")?;
        Ok(device)
    }

    fn name(&self, device: c_int) -> String {
        let mut bytes = [0_u8; 256];
        // SAFETY: the buffer is as long as told.
        unsafe { (self.cuDeviceGetName)(bytes.as_mut_ptr().cast(), bytes.len() as c_int, device) };
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        String::from_utf8_lossy(&bytes[..end]).into_owned()
    }

    fn memory(&self, device: c_int) -> u64 {
        let mut bytes = 0;
        // SAFETY: the place is a number's.
        unsafe { (self.cuDeviceTotalMem_v2)(&mut bytes, device) };
        bytes as u64
    }

    fn architecture(&self, device: c_int) -> String {
        let attribute = |which| {
            let mut value = 0;
            // SAFETY: the place is a number's.
            unsafe { (self.cuDeviceGetAttribute)(&mut value, which, device) };
            value
        };
        format!("compute_{}{}", attribute(MAJOR), attribute(MINOR))
    }
}

/// Devices that there are.
pub(crate) fn devices() -> Vec<DeviceName> {
    let Ok((library, functions)) = open() else { return Vec::new() };
    std::mem::forget(library);
    let refusal = compiler_library().err().map(|_| NO_COMPILER);
    let named = |number: usize| {
        let device = functions.device(number).ok()?;
        let (name, memory, driver) = (functions.name(device), functions.memory(device), Driver::Cuda);
        let (threads, is_processor, faults) = (THREADS, false, Vec::new());
        Some(DeviceName { driver, number, name, memory, threads, is_processor, faults, refusal })
    };
    (0..functions.count()).filter_map(named).collect()
}

/// A device of CUDA.
pub(crate) struct Cuda {
    functions: Functions,
    device: c_int,
    context: Handle,
    module: Handle,
    kernels: Vec<(Handle, Vec<u64>)>,
    buffers: Vec<u64>,
}

// SAFETY: a context may be made current on any thread, which every call does first.
unsafe impl Send for Cuda {}
// SAFETY: nothing is done through a shared borrow.
unsafe impl Sync for Cuda {}

impl Cuda {
    /// Opens device `number`.
    pub(crate) fn open(number: usize) -> Result<Self, String> {
        let (library, functions) = open()?;
        std::mem::forget(library);
        let device = functions.device(number)?;
        let mut context = null_mut();
        // SAFETY: the device is whole.
        let status = unsafe { (functions.cuDevicePrimaryCtxRetain)(&mut context, device) };
        functions.checked(status, "cuDevicePrimaryCtxRetain")?;
        Ok(Self { functions, device, context, module: null_mut(), kernels: Vec::new(), buffers: Vec::new() })
    }

    fn enter(&self) -> Result<(), String> {
        // SAFETY: the context is held until the object goes.
        self.functions.checked(unsafe { (self.functions.cuCtxSetCurrent)(self.context) }, "cuCtxSetCurrent")
    }
}

impl Host for Cuda {
    fn compile(&mut self, source: &str) -> Result<(), String> {
        self.enter()?;
        let ptx =
            CString::new(ptx(source, &self.functions.architecture(self.device))?).map_err(|error| error.to_string())?;
        // SAFETY: the text ends in a zero.
        let status = unsafe { (self.functions.cuModuleLoadData)(&mut self.module, ptx.as_ptr().cast()) };
        self.functions.checked(status, "cuModuleLoadData")
    }

    fn buffer(&mut self, bytes: usize) -> Result<Buffer, String> {
        self.enter()?;
        let mut address = 0;
        // SAFETY: the place is an address's.
        let status = unsafe { (self.functions.cuMemAlloc_v2)(&mut address, bytes.max(16)) };
        self.functions.checked(status, &format!("cuMemAlloc of {bytes} bytes"))?;
        self.buffers.push(address);
        Ok(Buffer(address))
    }

    fn write(&mut self, to: Buffer, at: usize, bytes: &[u8]) -> Result<(), String> {
        if bytes.is_empty() {
            return Ok(());
        }
        self.enter()?;
        // SAFETY: the buffer has room from `at` on, as its maker asked for it.
        let status = unsafe { (self.functions.cuMemcpyHtoD_v2)(to.0 + at as u64, bytes.as_ptr().cast(), bytes.len()) };
        self.functions.checked(status, "cuMemcpyHtoD")
    }

    fn read(&mut self, from: Buffer, at: usize, bytes: &mut [u8]) -> Result<(), String> {
        self.enter()?;
        // SAFETY: the buffer has these bytes; the call waits for all work before it.
        let status =
            unsafe { (self.functions.cuMemcpyDtoH_v2)(bytes.as_mut_ptr().cast(), from.0 + at as u64, bytes.len()) };
        self.functions.checked(status, "cuMemcpyDtoH")
    }

    fn kernel(&mut self, name: &str, arguments: &[Buffer]) -> Result<Kernel, String> {
        self.enter()?;
        let (mut function, name) = (null_mut(), CString::new(name).expect("no zero"));
        // SAFETY: the name ends in a zero.
        let status = unsafe { (self.functions.cuModuleGetFunction)(&mut function, self.module, name.as_ptr()) };
        self.functions.checked(status, "cuModuleGetFunction")?;
        self.kernels.push((function, arguments.iter().map(|buffer| buffer.0).collect()));
        Ok(Kernel(self.kernels.len() - 1))
    }

    fn launch(&mut self, kernel: Kernel, groups: usize, threads: usize) -> Result<(), String> {
        self.enter()?;
        let (function, arguments) = &mut self.kernels[kernel.0];
        let mut pointers: Vec<*mut c_void> = arguments.iter_mut().map(|address| (&raw mut *address).cast()).collect();
        let (groups, threads) = (groups as c_uint, threads as c_uint);
        // SAFETY: the kernel takes as many addresses as there are; the driver copies them before it returns.
        let status = unsafe {
            (self.functions.cuLaunchKernel)(
                *function,
                groups,
                1,
                1,
                threads,
                1,
                1,
                0,
                null_mut(),
                pointers.as_mut_ptr(),
                null_mut(),
            )
        };
        self.functions.checked(status, "cuLaunchKernel")
    }
}

impl Drop for Cuda {
    fn drop(&mut self) {
        let functions = self.functions;
        if self.enter().is_err() {
            return;
        }
        // SAFETY: everything was made here and is released once.
        unsafe {
            self.buffers.iter().for_each(|&address| _ = (functions.cuMemFree_v2)(address));
            if !self.module.is_null() {
                (functions.cuModuleUnload)(self.module);
            }
            (functions.cuDevicePrimaryCtxRelease_v2)(self.device);
        }
    }
}
