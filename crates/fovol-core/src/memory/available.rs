//! How much memory this process may still take, on Linux.

use std::fs;
use std::path::{Path, PathBuf};

/// Bytes that this process can still get: the least of the free memory of the system (with swap), the limits of the
/// process (`ulimit -v` and `-d`) and the limits of its control groups. `None` if unknown.
///
/// Mapped files count only towards the limit of address space: the system can drop their pages and read them again.
pub fn available() -> Option<u64> {
    if !cfg!(target_os = "linux") {
        return None;
    }
    let system = of_system(&text("/proc/meminfo")?);
    let process = of_process(&text("/proc/self/limits")?, &text("/proc/self/statm")?, page_size());
    let groups = of_groups(&text("/proc/self/cgroup").unwrap_or_default(), Path::new("/sys/fs/cgroup"));
    [system, process, groups].into_iter().flatten().min()
}

fn text(path: impl AsRef<Path>) -> Option<String> {
    fs::read_to_string(path).ok()
}

fn page_size() -> u64 {
    #[cfg(unix)]
    // SAFETY: `sysconf` takes and returns numbers only.
    let size = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    #[cfg(not(unix))]
    let size = 4096;
    u64::try_from(size).unwrap_or(4096)
}

/// Number after the word `name` in `lines`.
fn number(lines: &str, name: &str) -> Option<u64> {
    let rest = lines.lines().find_map(|line| line.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// Available memory and free swap of the system in bytes, from the text of `/proc/meminfo`.
fn of_system(meminfo: &str) -> Option<u64> {
    let kilobytes = number(meminfo, "MemAvailable:")? + number(meminfo, "SwapFree:").unwrap_or(0);
    Some(kilobytes * 1024)
}

/// Remaining address space and data segment of the process in bytes, the lesser of both. From the texts of
/// `/proc/self/limits` and `/proc/self/statm`.
fn of_process(limits: &str, statm: &str, page: u64) -> Option<u64> {
    let pages: Vec<u64> = statm.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let left = |name: &str, used: usize| {
        Some(number(limits, name)?.saturating_sub(page * pages.get(used).copied().unwrap_or(0)))
    };
    [left("Max address space", 0), left("Max data size", 5)].into_iter().flatten().min()
}

/// Remaining bytes of the control groups that `/proc/self/cgroup` names, and of their parents. The files of the groups
/// lie below `root`.
fn of_groups(named: &str, root: &Path) -> Option<u64> {
    let groups = named.lines().filter_map(|line| {
        let mut parts = line.splitn(3, ':');
        let (controllers, path) = (parts.nth(1)?, parts.next()?.trim_start_matches('/'));
        match controllers {
            "" => Some((root.to_owned(), path.to_owned(), VERSION_2)),
            _ if controllers.split(',').any(|name| name == "memory") => {
                Some((root.join("memory"), path.to_owned(), VERSION_1))
            }
            _ => None,
        }
    });
    groups
        .flat_map(|(top, path, files)| with_those_above(&top, &path).filter_map(move |at| files.left(&at)))
        .min()
}

/// Folder `path` below `top` and all folders between them. Some of them may be missing in a container.
fn with_those_above(top: &Path, path: &str) -> impl Iterator<Item = PathBuf> + use<> {
    let top = top.to_owned();
    let whole = top.join(path);
    let all: Vec<PathBuf> =
        whole.ancestors().take_while(|at| at.starts_with(&top)).map(Path::to_owned).collect();
    all.into_iter()
}

/// File names of a version of control groups.
#[derive(Clone, Copy)]
struct GroupFiles {
    limit: &'static str,
    used: &'static str,
    /// Entries of the statistics that count cached file pages. The system drops those when memory is scarce.
    files: [&'static str; 2],
    /// Files of the limit and the use of swap, for versions that limit swap separately.
    swap: Option<[&'static str; 2]>,
}

const VERSION_1: GroupFiles = GroupFiles {
    limit: "memory.limit_in_bytes",
    used: "memory.usage_in_bytes",
    files: ["total_inactive_file", "total_active_file"],
    swap: None,
};

const VERSION_2: GroupFiles = GroupFiles {
    limit: "memory.max",
    used: "memory.current",
    files: ["inactive_file", "active_file"],
    swap: Some(["memory.swap.max", "memory.swap.current"]),
};

impl GroupFiles {
    /// Remaining bytes of the group in the folder `at`; `None` without a limit.
    fn left(self, at: &Path) -> Option<u64> {
        let value = |name: &str| text(at.join(name))?.trim().parse::<u64>().ok();
        let limit = value(self.limit)?;
        let statistics = text(at.join("memory.stat")).unwrap_or_default();
        let files: u64 = self.files.iter().filter_map(|name| number(&statistics, &format!("{name} "))).sum();
        let swap = self.swap.map_or(0, |[limit, used]| self.swap_left(at, limit, used));
        Some(limit.saturating_sub(value(self.used)?.saturating_sub(files)).saturating_add(swap))
    }

    /// Remaining swap of the group in bytes; without a limit, all free swap of the system.
    fn swap_left(self, at: &Path, limit: &str, used: &str) -> u64 {
        let value = |name: &str| text(at.join(name))?.trim().parse::<u64>().ok();
        let free = text("/proc/meminfo").and_then(|said| number(&said, "SwapFree:")).unwrap_or(0) * 1024;
        value(limit).map_or(free, |limit| limit.saturating_sub(value(used).unwrap_or(0)).min(free))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_has_memory_and_swap() {
        let said = "MemTotal:  100 kB\nMemFree:  5 kB\nMemAvailable:   70 kB\nSwapFree:   30 kB\n";
        assert_eq!(of_system(said), Some(100 * 1024));
        assert_eq!(of_system("MemTotal: 100 kB\n"), None, "kernels before 3.14 do not say it");
    }

    #[test]
    fn limits_of_the_process_count_less_what_it_uses() {
        let limits = |space: &str, data: &str| {
            format!(
                "Limit        Soft Limit      Hard Limit     Units\nMax data size      {data}      unlimited  bytes\n\
                 Max address space         {space}           unlimited            bytes\n"
            )
        };
        let statm = "100 50 20 5 0 30 0\n";
        let left = |space, data| of_process(&limits(space, data), statm, 4096);
        assert_eq!(left("unlimited", "unlimited"), None);
        assert_eq!(left("1000000", "unlimited"), Some(1_000_000 - 409_600));
        assert_eq!(left("1000000", "200000"), Some(200_000 - 122_880));
        assert_eq!(left("4096", "unlimited"), Some(0));
    }

    /// Makes the control group `at` below `root`, with files of the given names and contents.
    fn group(root: &Path, at: &str, named: &[(&str, &str)]) {
        fs::create_dir_all(root.join(at)).unwrap();
        named.iter().for_each(|(name, said)| fs::write(root.join(at).join(name), said).unwrap());
    }

    #[test]
    fn the_tightest_group_counts_and_files_in_it_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        group(root, "", &[]);
        group(root, "a", &[("memory.max", "1000\n"), ("memory.current", "400\n")]);
        group(
            root,
            "a/b",
            &[
                ("memory.max", "700\n"),
                ("memory.current", "500\n"),
                ("memory.swap.max", "0\n"),
                ("memory.stat", "anon 100\ninactive_file 150\nactive_file 50\n"),
            ],
        );
        group(root, "a/b/c", &[("memory.max", "max\n"), ("memory.current", "300\n")]);
        assert_eq!(of_groups("0::/a/b/c\n", root), Some(400));
        assert_eq!(of_groups("0::/\n", root), None);
        assert_eq!(of_groups("0::/elsewhere\n", root), None);
    }

    #[test]
    fn groups_of_version_1_are_known_too() {
        let folder = tempfile::tempdir().unwrap();
        let files = [("memory.limit_in_bytes", "900\n"), ("memory.usage_in_bytes", "300\n")];
        group(folder.path(), "memory/x", &files);
        let named = "9:name=systemd:/\n4:cpu,memory:/x/gone\n0::/\n";
        assert_eq!(of_groups(named, folder.path()), Some(600));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_machine_has_memory() {
        assert!(available().unwrap() > 1 << 20);
    }
}
