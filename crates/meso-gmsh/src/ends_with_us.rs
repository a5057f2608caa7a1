//! gmsh ends when this process is killed outright, so that no run of minutes is left behind.
//!
//! On Linux the kernel sends the signal (`PR_SET_PDEATHSIG`). It does so when the *thread* that started gmsh ends; that thread
//! waits for gmsh, so it outlives it. Elsewhere there is no such thing, and gmsh runs to its end.

use std::process::Command;

/// Arranges that the process `command` starts ends with this one.
#[cfg(not(target_os = "linux"))]
pub(crate) fn arrange(_: &mut Command) {}

/// Arranges that the process `command` starts ends with this one.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
pub(crate) fn arrange(command: &mut Command) {
    use std::io;
    use std::os::unix::process::CommandExt;

    let parent = std::process::id();
    let ask_kernel = move || {
        // SAFETY: both are system calls without pointers, and safe between fork and exec.
        let (asked, now) = unsafe { (libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL), libc::getppid()) };
        // The parent may have ended before it was asked for: nobody would send the signal.
        if asked == 0 && u32::try_from(now).is_ok_and(|now| now == parent) {
            Ok(())
        } else {
            Err(io::Error::from(io::ErrorKind::Interrupted))
        }
    };
    // SAFETY: the closure makes system calls alone; it neither allocates nor takes a lock.
    unsafe { command.pre_exec(ask_kernel) };
}
