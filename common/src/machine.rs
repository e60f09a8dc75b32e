//! The machine that a program runs on, as far as plans depend on it: never what is computed.

use std::fs;
use std::io;
use std::path::Path;

use crate::readable::bytes;

/// The memory that a program may use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineMemory {
    /// In all, bytes: of the machine, or of the control group that the program was put into, or the limit of its address space, whatever is least.
    pub total: f64,
    /// Part of it that is free now or easily freed, bytes.
    pub free: f64,
}

impl std::fmt::Display for MachineMemory {
    /// `25 GB, 20 GB of it free now`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}, {} of it free now",
            bytes(self.total),
            bytes(self.free)
        )
    }
}

/// The memory of this machine; none where the system does not report it (Linux does).
#[must_use]
pub fn memory() -> Option<MachineMemory> {
    memory_for(1)
}

/// The memory of this machine for so many processes, each of which may use as much as this one.
#[must_use]
pub fn memory_for(processes: usize) -> Option<MachineMemory> {
    let limits = fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let limit = address_space(&limits).map_or(f64::INFINITY, |limit| limit * processes as f64);
    let MachineMemory { total, free } = of_machine()?;
    Some(MachineMemory {
        total: total.min(limit),
        free: free.min(limit),
    })
}

fn of_machine() -> Option<MachineMemory> {
    let machine = of_meminfo(&fs::read_to_string("/proc/meminfo").ok()?)?;
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    Some(within_groups(machine, &groups, Path::new("/sys/fs/cgroup")))
}

/// Free space for this user on the disk that holds `path`, or will hold it, bytes; none where the system does not report it.
#[must_use]
pub fn free_disk(path: &Path) -> Option<f64> {
    let absolute = std::path::absolute(path).ok()?;
    let there = absolute.ancestors().find(|folder| folder.exists())?;
    let disk = rustix::fs::statvfs(there).ok()?;
    Some(disk.f_bavail as f64 * disk.f_frsize as f64)
}

/// Whether an error, or one of those that caused it, is that a disk is full or a quota used up.
#[must_use]
pub fn is_full_disk(error: &(dyn std::error::Error + 'static)) -> bool {
    let causes = std::iter::successors(Some(error), |error| error.source());
    causes
        .filter_map(|error| error.downcast_ref::<io::Error>())
        .any(|error| {
            matches!(
                error.kind(),
                io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded
            )
        })
}

/// The limit of the address space of a process (`ulimit -v`), bytes, from the text of `/proc/PID/limits`; `None` without one.
fn address_space(limits: &str) -> Option<f64> {
    let line = (limits.lines()).find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// From the text of `/proc/meminfo`: lines such as `MemTotal:       24579100 kB`.
fn of_meminfo(text: &str) -> Option<MachineMemory> {
    let value = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        let number = line.strip_prefix(':')?.trim().strip_suffix("kB")?;
        number.trim().parse::<u64>().ok().map(|k| k as f64 * 1024.0)
    };
    let total = value("MemTotal")?;
    // Before Linux 3.14 the system reports only free memory.
    let free = value("MemAvailable").or_else(|| value("MemFree"))?;
    Some(MachineMemory {
        total,
        free: free.min(total),
    })
}

/// Memory that control groups leave of the machine's: those of `/proc/self/cgroup` and all above them, which lie below `root`, in
/// both versions.
fn within_groups(machine: MachineMemory, groups: &str, root: &Path) -> MachineMemory {
    let mut left = machine;
    for line in groups.lines() {
        // `0::/path` in version 2, `9:memory:/path` in version 1.
        let mut parts = line.splitn(3, ':');
        let (Some(_), Some(controllers), Some(path)) = (parts.next(), parts.next(), parts.next())
        else {
            continue;
        };
        let (root, limit, usage, cache) = if controllers.is_empty() {
            (
                root.to_owned(),
                "memory.max",
                "memory.current",
                "inactive_file",
            )
        } else if controllers.split(',').any(|name| name == "memory") {
            let names = (
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
                "total_inactive_file",
            );
            (root.join("memory"), names.0, names.1, names.2)
        } else {
            continue;
        };
        // Inside a container the path may be that of the machine outside, which is not there: its root is then ours.
        for group in Path::new(path.trim_start_matches('/')).ancestors() {
            let group = root.join(group);
            let number = |name: &str| -> Option<f64> {
                let text = fs::read_to_string(group.join(name)).ok()?;
                text.trim().parse::<u64>().ok().map(|number| number as f64)
            };
            // `max`: none. Version 1 has a number beyond all memory.
            let Some(limit) = number(limit) else { continue };
            // Files that were read and not used since are given back when memory is short.
            let stat = fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
            let cache = stat.lines().find_map(|line| {
                let (name, number) = line.split_once(' ')?;
                number.parse::<u64>().ok().filter(|_| name == cache)
            });
            let used = number(usage).unwrap_or(0.0) - cache.unwrap_or(0) as f64;
            left.total = left.total.min(limit);
            left.free = left.free.min((limit - used.max(0.0)).max(0.0));
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_address_space_may_be_limited() {
        let limits = |soft: &str| {
            format!(
                "Limit  Soft Limit  Hard Limit  Units\nMax open files  1024  4096  files\nMax address space         {soft}           unlimited            bytes\n"
            )
        };
        assert_eq!(address_space(&limits("2097152000")), Some(2_097_152_000.0));
        assert_eq!(address_space(&limits("unlimited")), None);
        assert_eq!(address_space(""), None);
    }

    #[test]
    fn the_free_space_is_that_of_the_folder_to_come() {
        let folder = tempfile::tempdir().unwrap();
        let to_come = folder.path().join("a/b/c");
        let [here, there] = [folder.path(), &to_come].map(|path| free_disk(path).unwrap());
        // Others write meanwhile.
        assert!(
            here > 0.0 && (there / here - 1.0).abs() < 0.5,
            "{here} {there}"
        );
    }

    #[test]
    fn a_full_disk_is_found_among_the_causes() {
        use crate::whole_file::FileError;
        let of = |kind: io::ErrorKind| FileError::of(Path::new("a"), "x")(kind.into());
        assert!(is_full_disk(&of(io::ErrorKind::StorageFull)));
        assert!(is_full_disk(&of(io::ErrorKind::QuotaExceeded)));
        assert!(!is_full_disk(&of(io::ErrorKind::PermissionDenied)));
        // Error of a full disk on Linux: ENOSPC.
        assert!(is_full_disk(&io::Error::from_raw_os_error(28)));
    }

    const MEMINFO: &str = "MemTotal:       24000000 kB\nMemFree:         1000000 kB\nMemAvailable:   20000000 kB\nSwapTotal: 0 kB\n";

    fn machine() -> MachineMemory {
        of_meminfo(MEMINFO).unwrap()
    }

    #[test]
    fn the_system_says_in_units_of_1024_bytes() {
        assert_eq!(machine().total, 24e6 * 1024.0);
        assert_eq!(machine().free, 20e6 * 1024.0);
        assert_eq!(machine().to_string(), "25 GB, 20 GB of it free now");
        let old = MEMINFO.replace("MemAvailable", "Other");
        assert_eq!(of_meminfo(&old).unwrap().free, 1e6 * 1024.0);
    }

    #[test]
    fn what_cannot_be_understood_is_unknown() {
        for text in [
            "",
            "MemTotal: 5 MB\nMemFree: 1 kB\n",
            "MemTotal: -5 kB\nMemFree: 1 kB\n",
            "MemTotal: 5 kB\n",
            "MemTotalOther: 5 kB\nMemFree: 1 kB\n",
            "MemTotal:\nMemFree:\n",
        ] {
            assert_eq!(of_meminfo(text), None, "{text:?}");
        }
    }

    #[test]
    fn a_control_group_and_those_above_it_leave_less() {
        let root = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        let left = |groups: &str| within_groups(machine(), groups, root.path());
        // No files: no limit.
        assert_eq!(left("0::/job/step\n"), machine());
        // Of the group itself there is none, of the one above it 8 GB, of which 3 GB are used and 1 GB of that is cache.
        write("job/step/memory.max", "max\n");
        write("job/step/memory.current", "3000000000\n");
        write("job/memory.max", "8000000000\n");
        write("job/memory.current", "3000000000\n");
        write(
            "job/memory.stat",
            "anon 2000000000\ninactive_file 1000000000\nactive_file 7\n",
        );
        let expected = MachineMemory {
            total: 8e9,
            free: 6e9,
        };
        assert_eq!(left("0::/job/step\n"), expected);
        assert_eq!(left("0::/other\n"), machine());
        // Version 1, beside other controllers; more is used than may be.
        write("memory/old/memory.limit_in_bytes", "5000000000\n");
        write("memory/old/memory.usage_in_bytes", "6000000000\n");
        let expected = MachineMemory {
            total: 5e9,
            free: 0.0,
        };
        assert_eq!(left("12:pids:/old\n9:cpu,memory:/old\n"), expected);
        assert_eq!(left("12:pids:/old\n"), machine());
        // The root of a container is its group.
        write("memory.max", "4000000000\n");
        assert_eq!(left("0::/\n").total, 4e9);
        assert_eq!(left("0::/of/the/machine/outside\n").total, 4e9);
        // Nonsense changes nothing.
        assert_eq!(left("no colons\n:\n0:\n").total, machine().total);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_machine_has_memory() {
        let memory = memory().unwrap();
        assert!(memory.total > 1e6 && memory.free <= memory.total);
    }
}
