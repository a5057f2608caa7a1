//! Free memory and free space on a disk, so that work too large is refused before it begins.

use std::fs;
use std::path::{Path, PathBuf};

/// Bytes of memory that this process can still take; `None` if the system does not say.
///
/// Linux: the least of the machine's available memory with its free swap, of the limits of the control groups, and of the
/// limit on the address space (`ulimit -v`).
pub fn memory() -> Option<u64> {
    let limits = [machine(), address_space(), control_groups()];
    limits.into_iter().flatten().min()
}

/// Bytes that a file in `folder` can take; `None` if the system does not say.
#[cfg(unix)]
pub fn disk(folder: &Path) -> Option<u64> {
    let about = rustix::fs::statvfs(folder).ok()?;
    about.f_bavail.checked_mul(about.f_frsize)
}

/// Bytes that a file in a folder can take; `None` if the system does not say.
#[cfg(not(unix))]
pub fn disk(_: &Path) -> Option<u64> {
    None
}

fn machine() -> Option<u64> {
    let about = fs::read_to_string("/proc/meminfo").ok()?;
    Some(kilobytes(&about, "MemAvailable:")? + kilobytes(&about, "SwapFree:").unwrap_or(0))
}

fn address_space() -> Option<u64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = limit.split_whitespace().next()?.parse().ok()?;
    let taken = kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmSize:")?;
    Some(limit.saturating_sub(taken))
}

/// The least that a control group of this process and those around it leave: version 2, or the memory group of version 1.
fn control_groups() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let places = groups.lines().filter_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        match (fields.next()?, fields.next()?) {
            ("", path) => Some((Path::new("/sys/fs/cgroup"), path.to_owned(), ["memory.max", "memory.current"])),
            ("memory", path) => {
                let files = ["memory.limit_in_bytes", "memory.usage_in_bytes"];
                Some((Path::new("/sys/fs/cgroup/memory"), path.to_owned(), files))
            }
            _ => None,
        }
    });
    let left = places.flat_map(|(root, path, files)| {
        let group = root.join(path.trim_start_matches('/'));
        let groups: Vec<PathBuf> =
            group.ancestors().take_while(|at| at.starts_with(root)).map(Path::to_owned).collect();
        groups.into_iter().filter_map(move |group| left_in(&group, files))
    });
    left.min()
}

/// Memory that a control group leaves; pages of files that it can drop count as free.
fn left_in(group: &Path, [limit, usage]: [&str; 2]) -> Option<u64> {
    let number = |name| fs::read_to_string(group.join(name)).ok()?.trim().parse::<u64>().ok();
    let (limit, usage) = (number(limit)?, number(usage)?);
    let about = fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let files = about.lines().find_map(|line| line.strip_prefix("inactive_file ")?.parse().ok());
    Some(limit.saturating_sub(usage.saturating_sub(files.unwrap_or(0))))
}

fn kilobytes(table: &str, key: &str) -> Option<u64> {
    let row = table.lines().find_map(|line| line.strip_prefix(key))?;
    row.split_whitespace().next()?.parse::<u64>().ok().map(|number| number * 1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_below_the_machines_and_free_space_is_known() {
        let all = kilobytes(&fs::read_to_string("/proc/meminfo").unwrap(), "MemTotal:").unwrap();
        assert!(memory().is_some_and(|free| free > 0 && free < 2 * all), "{:?}", memory());
        assert!(disk(Path::new(".")).is_some());
        assert_eq!(disk(Path::new("/no/such/folder")), None);
    }

    #[test]
    fn a_limited_group_leaves_its_limit_but_for_pages_in_use() {
        let group = tempfile::tempdir().unwrap();
        let files = ["memory.max", "memory.current"];
        let write = |name: &str, text: &str| fs::write(group.path().join(name), text).unwrap();
        write("memory.max", "1000\n");
        write("memory.current", "700\n");
        write("memory.stat", "anon 400\ninactive_file 200\n");
        assert_eq!(left_in(group.path(), files), Some(500));
        write("memory.max", "max\n");
        assert_eq!(left_in(group.path(), files), None);
    }
}
