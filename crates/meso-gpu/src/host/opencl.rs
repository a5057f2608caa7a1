//! OpenCL 1.2 or later, by the functions that a test needs.
#![allow(unsafe_code, reason = "calls into the driver's library")]

use super::{Buffer, Host, Kernel, library};
use crate::name::{DeviceName, Driver, THREADS};
use libloading::Library;
use std::ffi::{CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::{Mutex, PoisonError};

/// A driver's object.
type Handle = *mut c_void;
type Status = i32;

macro_rules! functions {
    ($table:ident { $($name:ident($($argument:ty),*) -> $answer:ty;)* }) => {
        /// Functions of the library, as its header declares them.
        #[derive(Clone, Copy)]
        #[allow(non_snake_case, reason = "the header's names")]
        struct $table { $($name: unsafe extern "C" fn($($argument),*) -> $answer,)* }

        impl $table {
            fn of(library: &Library) -> Result<Self, String> {
                // SAFETY: the types are those of the header; the library outlives its functions, for it is never closed.
                unsafe { Ok(Self { $($name: *library.get(concat!(stringify!($name), "\0").as_bytes()).map_err(|error| error.to_string())?,)* }) }
            }
        }
    };
}
pub(super) use functions;

functions!(Functions {
    clGetPlatformIDs(u32, *mut Handle, *mut u32) -> Status;
    clGetDeviceIDs(Handle, u64, u32, *mut Handle, *mut u32) -> Status;
    clGetDeviceInfo(Handle, u32, usize, *mut c_void, *mut usize) -> Status;
    clCreateContext(*const isize, u32, *const Handle, *const c_void, *mut c_void, *mut Status) -> Handle;
    clCreateCommandQueue(Handle, Handle, u64, *mut Status) -> Handle;
    clCreateProgramWithSource(Handle, u32, *const *const c_char, *const usize, *mut Status) -> Handle;
    clBuildProgram(Handle, u32, *const Handle, *const c_char, *const c_void, *mut c_void) -> Status;
    clGetProgramBuildInfo(Handle, Handle, u32, usize, *mut c_void, *mut usize) -> Status;
    clCreateKernel(Handle, *const c_char, *mut Status) -> Handle;
    clSetKernelArg(Handle, u32, usize, *const c_void) -> Status;
    clCreateBuffer(Handle, u64, usize, *mut c_void, *mut Status) -> Handle;
    clEnqueueWriteBuffer(Handle, Handle, u32, usize, usize, *const c_void, u32, *const Handle, *mut Handle) -> Status;
    clEnqueueReadBuffer(Handle, Handle, u32, usize, usize, *mut c_void, u32, *const Handle, *mut Handle) -> Status;
    clEnqueueNDRangeKernel(Handle, Handle, u32, *const usize, *const usize, *const usize, u32, *const Handle, *mut Handle) -> Status;
    clReleaseMemObject(Handle) -> Status;
    clReleaseKernel(Handle) -> Status;
    clReleaseProgram(Handle) -> Status;
    clReleaseCommandQueue(Handle) -> Status;
    clReleaseContext(Handle) -> Status;
});

const ALL_DEVICES: u64 = 0xFFFF_FFFF;
const TYPE: u32 = 0x1000;
const PROCESSOR: u64 = 2;
const NAME: u32 = 0x102B;
const SINGLE_CONFIG: u32 = 0x101B;
const DOUBLE_CONFIG: u32 = 0x1032;
const GLOBAL_MEMORY: u32 = 0x101F;
const BUILD_LOG: u32 = 0x1183;
const READ_WRITE: u64 = 1;
/// Bits of the configurations: denormals, rounding to nearest, fused multiply-add; exact division and root.
const NEEDED: u64 = 1 | 4 | 32;
const EXACT_DIVISION: u64 = 128;
const OPTIONS: &str = "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt";

fn open() -> Result<(Library, Functions), String> {
    let names = ["libOpenCL.so.1", "libOpenCL.so", "OpenCL.dll", "/System/Library/Frameworks/OpenCL.framework/OpenCL"];
    let library = library(&names.map(str::to_owned))?;
    let functions = Functions::of(&library)?;
    Ok((library, functions))
}

fn checked(status: Status, what: &str) -> Result<(), String> {
    let why = match status {
        0 => return Ok(()),
        -4 | -6 | -61 => ", it has too little memory",
        _ => "",
    };
    Err(format!("OpenCL: {what} gave {status}{why}"))
}

/// Held while platforms are found: pocl 3.1 crashes where two threads begin at once.
static FINDING: Mutex<()> = Mutex::new(());

/// Devices of all platforms.
fn handles(functions: &Functions) -> Vec<Handle> {
    let _finding = FINDING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut platforms = [null_mut(); 16];
    let mut count = 0;
    // SAFETY: the array has as many places as are told.
    if unsafe { (functions.clGetPlatformIDs)(16, platforms.as_mut_ptr(), &mut count) } != 0 {
        return Vec::new();
    }
    let mut all = Vec::new();
    for &platform in &platforms[..count.min(16) as usize] {
        let (mut devices, mut count) = ([null_mut(); 16], 0);
        // SAFETY: the array has as many places as are told.
        let status = unsafe { (functions.clGetDeviceIDs)(platform, ALL_DEVICES, 16, devices.as_mut_ptr(), &mut count) };
        if status == 0 {
            all.extend(&devices[..count.min(16) as usize]);
        }
    }
    all
}

fn number(functions: &Functions, device: Handle, what: u32) -> u64 {
    let mut value = 0_u64;
    // SAFETY: the answer is a number of 8 bytes at most.
    unsafe { (functions.clGetDeviceInfo)(device, what, 8, (&raw mut value).cast(), null_mut()) };
    value
}

fn name(functions: &Functions, device: Handle) -> String {
    let mut bytes = [0_u8; 256];
    // SAFETY: the buffer is as long as told.
    unsafe { (functions.clGetDeviceInfo)(device, NAME, bytes.len(), bytes.as_mut_ptr().cast(), null_mut()) };
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
}

/// Devices that there are, with what they cannot keep of the promise.
pub(crate) fn devices() -> Vec<DeviceName> {
    let Ok((library, functions)) = open() else { return Vec::new() };
    std::mem::forget(library);
    let describe = |(number_of, device): (usize, Handle)| {
        let (single, double) = (number(&functions, device, SINGLE_CONFIG), number(&functions, device, DOUBLE_CONFIG));
        let mut faults = Vec::new();
        if single & NEEDED != NEEDED {
            faults.push("it flushes denormals or has no fused multiply-add");
        }
        if single & EXACT_DIVISION == 0 {
            faults.push("its division is not correctly rounded");
        }
        let memory = number(&functions, device, GLOBAL_MEMORY);
        DeviceName {
            driver: Driver::OpenCl,
            number: number_of,
            name: name(&functions, device),
            memory,
            threads: THREADS,
            is_processor: number(&functions, device, TYPE) & PROCESSOR != 0,
            faults,
            refusal: (double == 0).then_some("it has no double precision, in which nodes move"),
        }
    };
    handles(&functions).into_iter().enumerate().map(describe).collect()
}

/// A device of OpenCL.
pub(crate) struct OpenCl {
    functions: Functions,
    device: Handle,
    context: Handle,
    queue: Handle,
    program: Handle,
    kernels: Vec<Handle>,
    buffers: Vec<Handle>,
}

// SAFETY: OpenCL's objects may be used from any thread; kernels' arguments are set while the object is borrowed mutably.
unsafe impl Send for OpenCl {}
// SAFETY: nothing is done through a shared borrow.
unsafe impl Sync for OpenCl {}

impl OpenCl {
    /// Opens device `number`.
    pub(crate) fn open(number: usize) -> Result<Self, String> {
        let (library, functions) = open()?;
        std::mem::forget(library);
        let all = handles(&functions);
        let device = *all.get(number).ok_or_else(|| format!("OpenCL has {} devices", all.len()))?;
        let mut status = 0;
        // SAFETY: one device is told and given.
        let context = unsafe { (functions.clCreateContext)(null(), 1, &device, null(), null_mut(), &mut status) };
        checked(status, "clCreateContext")?;
        // SAFETY: the context and device are whole.
        let queue = unsafe { (functions.clCreateCommandQueue)(context, device, 0, &mut status) };
        checked(status, "clCreateCommandQueue")?;
        Ok(Self { functions, device, context, queue, program: null_mut(), kernels: Vec::new(), buffers: Vec::new() })
    }

    fn log(&self) -> String {
        let mut log = vec![0_u8; 1 << 14];
        // SAFETY: the buffer is as long as told.
        unsafe {
            (self.functions.clGetProgramBuildInfo)(
                self.program,
                self.device,
                BUILD_LOG,
                log.len(),
                log.as_mut_ptr().cast(),
                null_mut(),
            )
        };
        String::from_utf8_lossy(&log).trim_matches('\0').trim().to_owned()
    }
}

impl Host for OpenCl {
    fn compile(&mut self, source: &str) -> Result<(), String> {
        let (mut status, text, length) = (0, source.as_ptr().cast::<c_char>(), source.len());
        // SAFETY: one text with its length.
        self.program =
            unsafe { (self.functions.clCreateProgramWithSource)(self.context, 1, &text, &length, &mut status) };
        checked(status, "clCreateProgramWithSource")?;
        let exact = number(&self.functions, self.device, SINGLE_CONFIG) & EXACT_DIVISION != 0;
        let options = CString::new(if exact { OPTIONS } else { "-cl-std=CL1.2" }).expect("no zero");
        // SAFETY: the options end in a zero.
        let status = unsafe {
            (self.functions.clBuildProgram)(self.program, 1, &self.device, options.as_ptr(), null(), null_mut())
        };
        checked(status, "clBuildProgram").map_err(|error| format!("{error}: {}", self.log()))
    }

    fn buffer(&mut self, bytes: usize) -> Result<Buffer, String> {
        let mut status = 0;
        // SAFETY: no memory of the host is given.
        let handle = unsafe {
            (self.functions.clCreateBuffer)(self.context, READ_WRITE, bytes.max(16), null_mut(), &mut status)
        };
        checked(status, "clCreateBuffer")?;
        self.buffers.push(handle);
        Ok(Buffer(handle as u64))
    }

    fn write(&mut self, to: Buffer, at: usize, bytes: &[u8]) -> Result<(), String> {
        if bytes.is_empty() {
            return Ok(());
        }
        let (buffer, from) = (to.0 as Handle, bytes.as_ptr().cast());
        // SAFETY: the call returns when the bytes are read.
        let status = unsafe {
            (self.functions.clEnqueueWriteBuffer)(self.queue, buffer, 1, at, bytes.len(), from, 0, null(), null_mut())
        };
        checked(status, "clEnqueueWriteBuffer")
    }

    fn read(&mut self, from: Buffer, at: usize, bytes: &mut [u8]) -> Result<(), String> {
        if bytes.is_empty() {
            return Ok(());
        }
        let (buffer, to) = (from.0 as Handle, bytes.as_mut_ptr().cast());
        // SAFETY: the call returns when the bytes are written.
        let status = unsafe {
            (self.functions.clEnqueueReadBuffer)(self.queue, buffer, 1, at, bytes.len(), to, 0, null(), null_mut())
        };
        checked(status, "clEnqueueReadBuffer")
    }

    fn kernel(&mut self, name: &str, arguments: &[Buffer]) -> Result<Kernel, String> {
        let (mut status, name) = (0, CString::new(name).expect("no zero"));
        // SAFETY: the name ends in a zero.
        let kernel = unsafe { (self.functions.clCreateKernel)(self.program, name.as_ptr(), &mut status) };
        checked(status, "clCreateKernel")?;
        self.kernels.push(kernel);
        for (number, buffer) in (0..).zip(arguments) {
            let handle = buffer.0 as Handle;
            // SAFETY: an argument is a buffer's handle.
            let status = unsafe {
                (self.functions.clSetKernelArg)(kernel, number, size_of::<Handle>(), (&raw const handle).cast())
            };
            checked(status, "clSetKernelArg")?;
        }
        Ok(Kernel(self.kernels.len() - 1))
    }

    fn launch(&mut self, kernel: Kernel, groups: usize, threads: usize) -> Result<(), String> {
        let (kernel, all) = (self.kernels[kernel.0], groups * threads);
        // SAFETY: one dimension; the kernel has all its arguments.
        let status = unsafe {
            (self.functions.clEnqueueNDRangeKernel)(
                self.queue,
                kernel,
                1,
                null(),
                &all,
                &threads,
                0,
                null(),
                null_mut(),
            )
        };
        checked(status, "clEnqueueNDRangeKernel")
    }
}

impl Drop for OpenCl {
    fn drop(&mut self) {
        let functions = self.functions;
        // SAFETY: every object was made here and is released once.
        unsafe {
            self.kernels.iter().for_each(|&kernel| _ = (functions.clReleaseKernel)(kernel));
            self.buffers.iter().for_each(|&buffer| _ = (functions.clReleaseMemObject)(buffer));
            if !self.program.is_null() {
                (functions.clReleaseProgram)(self.program);
            }
            (functions.clReleaseCommandQueue)(self.queue);
            (functions.clReleaseContext)(self.context);
        }
    }
}
