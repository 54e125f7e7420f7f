//! Memory of the process and of the machine.

use std::path::Path;

/// Peak resident set in bytes on Linux; 0 elsewhere.
pub fn peak_memory() -> u64 {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|text| kilobytes(&text, "VmHWM:"))
        .unwrap_or(0)
}

/// Memory that the process can still take, in bytes: what the machine has available, or less if a
/// control group of the process limits it. `None` if the system does not report it (Linux does).
pub fn free_memory() -> Option<u64> {
    let machine = std::fs::read_to_string("/proc/meminfo").ok()?;
    let available = kilobytes(&machine, "MemAvailable:")?;
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    Some(
        left_in_groups(&groups, Path::new("/sys/fs/cgroup"))
            .map_or(available, |left| available.min(left)),
    )
}

/// The number of a line such as `MemAvailable:   8000 kB`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.starts_with(name))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

/// The least memory that the limits of control groups and of the groups around them leave, in bytes.
/// `groups` is the content of `/proc/self/cgroup`, in the first or second version, and `root` the
/// folder of the groups. A limit in force is a number; memory of files that can be dropped is free.
fn left_in_groups(groups: &str, root: &Path) -> Option<u64> {
    let mut least = None;
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else {
            continue;
        };
        let (root, limit, usage, droppable) = if controllers.is_empty() {
            (
                root.to_owned(),
                "memory.max",
                "memory.current",
                "inactive_file ",
            )
        } else if controllers.split(',').any(|c| c == "memory") {
            let names = (
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
                "total_inactive_file ",
            );
            (root.join("memory"), names.0, names.1, names.2)
        } else {
            continue;
        };
        for group in Path::new(path.trim_start_matches('/')).ancestors() {
            let read = |name| std::fs::read_to_string(root.join(group).join(name)).ok();
            let number = |name| read(name)?.trim().parse::<u64>().ok();
            let (Some(limit), Some(usage)) = (number(limit), number(usage)) else {
                continue;
            };
            let stat = read("memory.stat").unwrap_or_default();
            let files = stat
                .lines()
                .find_map(|l| l.strip_prefix(droppable)?.parse().ok());
            let left = limit.saturating_sub(usage.saturating_sub(files.unwrap_or(0)));
            least = Some(least.map_or(left, |least: u64| least.min(left)));
        }
    }
    least
}

/// A computation that needs more memory than is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "about {} of memory would be needed, and {} are free",
    in_gib(*needed),
    in_gib(*free)
)]
pub struct TooLittleMemory {
    /// The estimate, bytes.
    pub needed: u64,
    /// What the process can still take, bytes.
    pub free: u64,
}

/// Bytes that every machine has left. To look up what is left takes longer than to fill a small hole.
const SMALL: f64 = 16.0 * (1 << 20) as f64;

/// Checks that the machine has memory left for a computation of `needed` bytes; little is not checked.
///
/// # Errors
/// [`TooLittleMemory`]. Where the free memory is unknown there is none.
pub fn require(needed: f64) -> Result<(), TooLittleMemory> {
    if needed <= SMALL {
        return Ok(());
    }
    require_of(needed, free_memory())
}

fn require_of(needed: f64, free: Option<u64>) -> Result<(), TooLittleMemory> {
    // what exceeds u64 saturates
    let needed = needed as u64;
    match free {
        Some(free) if needed > free => Err(TooLittleMemory { needed, free }),
        _ => Ok(()),
    }
}

/// An amount of memory in words.
pub fn in_gib(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_free_memory_is_known_on_linux() {
        let free = free_memory();
        assert_eq!(free.is_some(), cfg!(target_os = "linux"));
        assert!(free.is_none_or(|bytes| bytes > 1 << 20), "{free:?}");
        assert_eq!(
            kilobytes("MemFree: 1 kB\nMemAvailable:  7 kB\n", "MemAvailable:"),
            Some(7168)
        );
    }

    #[test]
    fn the_tightest_control_group_counts() {
        let root = tempfile::tempdir().expect("a folder");
        let write = |group: &str, files: &[(&str, &str)]| {
            let folder = root.path().join(group);
            std::fs::create_dir_all(&folder).expect("a folder");
            for (name, text) in files {
                std::fs::write(folder.join(name), text).expect("a file");
            }
        };
        let left = |groups| left_in_groups(groups, root.path());
        assert_eq!(left("0::/a/b\n"), None);
        write(
            "a/b",
            &[("memory.max", "max\n"), ("memory.current", "50\n")],
        );
        assert_eq!(left("0::/a/b\n"), None);
        let stat = "anon 90\ninactive_file 30\n";
        write(
            "a",
            &[
                ("memory.max", "1000"),
                ("memory.current", "100"),
                ("memory.stat", stat),
            ],
        );
        assert_eq!(left("0::/a/b\n"), Some(930));
        write("a/b", &[("memory.max", "80\n")]);
        assert_eq!(left("0::/a/b\n"), Some(30));
        assert_eq!(left("0::/a\n"), Some(930));
        let old = [
            ("memory.limit_in_bytes", "70"),
            ("memory.usage_in_bytes", "90"),
        ];
        write("memory/c", &old);
        assert_eq!(left("3:cpu:/c\n4:blkio,memory:/c\n"), Some(0));
    }

    #[test]
    fn more_than_is_free_is_refused_in_words() {
        assert_eq!(require_of(5.0, Some(5)), Ok(()));
        assert_eq!(require_of(1e30, None), Ok(()));
        let error = require_of(3e9, Some(1 << 29)).expect_err("too much");
        let text = "about 2.8 GiB of memory would be needed, and 0.5 GiB are free";
        assert_eq!(error.to_string(), text);
    }
}
