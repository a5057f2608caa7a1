//! Refusal of work that memory or disk cannot hold, before any of it is taken.

use crate::failure::Failure;
use crate::stderr::flag;
use meso_ask::{Machine, sizes};
use meso_core::mesh::Tools;
use meso_files::{free, whole};
use std::path::Path;

/// This machine, with these tools.
pub(crate) fn machine(tools: Tools<'_>) -> Machine<'_> {
    Machine { memory: free::memory(), tools, asked: None }
}

/// Refuses an image that takes more memory than is free.
pub(crate) fn accept_image(work: &str, bytes: f64) -> Result<(), Failure> {
    let machine = machine(Tools::default());
    Ok(machine.accept_bytes(work, bytes, |_| "cut a part out of the image".to_owned())?)
}

/// Refuses a file of so many bytes that its disk has no space for.
pub(crate) fn accept_on_disk(shown: &Path, path: &Path, bytes: u64) -> Result<(), Failure> {
    let Some(free) = free::disk(whole::folder(path)).filter(|free| *free < bytes) else { return Ok(()) };
    let [needed, free] = sizes([bytes as f64, free as f64]);
    let (shown, part) = (shown.display(), flag("box"));
    Err(Failure::Run(format!(
        "{shown} takes {needed}, and {free} are free on its disk; take larger voxels, a {part}, or another disk"
    )))
}
