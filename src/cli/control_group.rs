//! What is left of the limits on the memory of a container: of the control groups that this process is in, of version 1
//! (the memory controller) or 2 (kernel.org, *Control Group v2*; cgroups(7); proc_pid_mountinfo(5)).

use std::fs;
use std::path::{Component, Path, PathBuf};

/// The least that is left in any of them.
pub(super) fn left() -> Option<f64> {
    let text = |name: &str| fs::read_to_string(Path::new("/proc/self").join(name)).ok();
    left_in(&text("cgroup")?, &text("mountinfo")?)
}

/// The same, where these are the groups of the process and the mounts that it sees.
fn left_in(groups: &str, mounts: &str) -> Option<f64> {
    let hierarchies = mounts.lines().filter_map(Hierarchy::of);
    let left = hierarchies.filter_map(|hierarchy| hierarchy.left(groups));
    left.reduce(f64::min)
}

/// Groups as a mount shows them: folders in folders.
struct Hierarchy<'a> {
    names: &'static Names,
    /// The group that is mounted, and where.
    root: &'a str,
    mount: &'a Path,
}

/// What the files of a version are called, and how lines of /proc/self/cgroup name its hierarchy.
struct Names {
    controller: &'static str,
    most: &'static str,
    taken: &'static str,
    cached: &'static str,
}

const FIRST: Names = Names {
    controller: "memory",
    most: "memory.limit_in_bytes",
    taken: "memory.usage_in_bytes",
    cached: "total_inactive_file ",
};

const SECOND: Names = Names {
    controller: "",
    most: "memory.max",
    taken: "memory.current",
    cached: "inactive_file ",
};

impl<'a> Hierarchy<'a> {
    /// By a line of mountinfo, where that is one that limits memory.
    fn of(line: &'a str) -> Option<Self> {
        let (place, kind) = line.split_once(" - ")?;
        let mut kind = kind.split(' ');
        let names = match (kind.next()?, kind.nth(1)?) {
            ("cgroup2", _) => &SECOND,
            ("cgroup", options) if options.split(',').any(|o| o == FIRST.controller) => &FIRST,
            _ => return None,
        };
        let mut place = place.split(' ').skip(3);
        Some(Self {
            names,
            root: place.next()?,
            mount: Path::new(place.next()?),
        })
    }

    /// The least that is left in the group of the process and those that hold it.
    fn left(&self, groups: &str) -> Option<f64> {
        let folder = self.folder(groups)?;
        let above = folder.ancestors();
        let held = above.take_while(|folder| folder.starts_with(self.mount));
        held.filter_map(|folder| self.names.left(folder))
            .reduce(f64::min)
    }

    /// Of the process's group; that which is mounted, where the process's own is not to be seen from here.
    fn folder(&self, groups: &str) -> Option<PathBuf> {
        let group = groups.lines().find_map(|line| self.group(line))?;
        let below = Path::new(group).strip_prefix(self.root).ok();
        let below =
            below.filter(|path| path.components().all(|c| matches!(c, Component::Normal(_))));
        Some(self.mount.join(below.unwrap_or(Path::new(""))))
    }

    /// The group that a line of /proc/self/cgroup names, `NUMBER:CONTROLLERS:GROUP`, where it is of this hierarchy.
    fn group(&self, line: &'a str) -> Option<&'a str> {
        let (controllers, group) = line.split_once(':')?.1.split_once(':')?;
        let mut controllers = controllers.split(',');
        controllers
            .any(|c| c == self.names.controller)
            .then_some(group)
    }
}

impl Names {
    /// What a group has left; nothing where it has no limit. Cached files make way.
    fn left(&self, folder: &Path) -> Option<f64> {
        let most = number(folder.join(self.most), "")?;
        let taken = number(folder.join(self.taken), "")?;
        let cached = number(folder.join("memory.stat"), self.cached).unwrap_or(0.0);
        Some((most - (taken - cached)).max(0.0))
    }
}

/// The number after a word at the start of a line.
pub(super) fn number(file: impl AsRef<Path>, word: &str) -> Option<f64> {
    let text = fs::read_to_string(file).ok()?;
    let rest = text.lines().find_map(|line| line.strip_prefix(word))?;
    rest.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    fn mounted(folder: &TempDir, root: &str, kind: &str) -> String {
        let mount = folder.path().display();
        format!(
            "24 1 0:22 / /proc rw - proc proc rw\n35 31 0:32 {root} {mount} rw,relatime shared:9 - {kind}\n"
        )
    }

    fn put(folder: &TempDir, group: &str, files: &[(&str, &str)]) {
        let group = folder.path().join(group);
        fs::create_dir_all(&group).unwrap();
        for (name, text) in files {
            fs::write(group.join(name), text).unwrap();
        }
    }

    #[test]
    fn the_tightest_of_nested_groups_counts() {
        let folder = tempfile::tempdir().unwrap();
        let mounts = mounted(&folder, "/", "cgroup2 cgroup2 rw,nsdelegate");
        put(
            &folder,
            "a/b/c",
            &[("memory.max", "max\n"), ("memory.current", "10\n")],
        );
        assert_eq!(left_in("0::/a/b/c\n", &mounts), None);
        put(
            &folder,
            "a/b",
            &[("memory.max", "9000\n"), ("memory.current", "5000\n")],
        );
        put(
            &folder,
            "a/b",
            &[("memory.stat", "anon 1\ninactive_file 500\n")],
        );
        put(
            &folder,
            "a",
            &[("memory.max", "99000\n"), ("memory.current", "6000\n")],
        );
        put(
            &folder,
            "other",
            &[("memory.max", "1\n"), ("memory.current", "0\n")],
        );
        assert_eq!(left_in("0::/a/b/c\n", &mounts), Some(4500.0));
        put(&folder, "a", &[("memory.max", "7000\n")]);
        assert_eq!(left_in("0::/a/b/c\n", &mounts), Some(1000.0));
        put(&folder, "a", &[("memory.max", "5000\n")]);
        assert_eq!(left_in("0::/a/b/c\n", &mounts), Some(0.0));
        // From a namespace of their own, containers see their group as the root.
        put(
            &folder,
            "",
            &[("memory.max", "80\n"), ("memory.current", "10\n")],
        );
        for group in ["0::/", "0::/../sibling", "1:name=systemd:/a\n0::/"] {
            assert_eq!(left_in(group, &mounts), Some(70.0), "{group}");
        }
    }

    #[test]
    fn groups_of_the_first_version_count() {
        let folder = tempfile::tempdir().unwrap();
        let groups = "5:cpu,memory:/docker/abc/job\n4:pids:/docker/abc\n0::/\n";
        let files = [
            ("memory.usage_in_bytes", "3000"),
            ("memory.limit_in_bytes", "9223372036854771712"),
        ];
        put(&folder, "job", &files);
        let files = [
            ("memory.usage_in_bytes", "4000"),
            ("memory.limit_in_bytes", "10000"),
        ];
        put(&folder, "", &files);
        put(
            &folder,
            "",
            &[("memory.stat", "inactive_file 1\ntotal_inactive_file 300\n")],
        );
        // Seen from a container whose group is mounted alone.
        let mounts = mounted(&folder, "/docker/abc", "cgroup cgroup rw,cpu,memory");
        assert_eq!(left_in(groups, &mounts), Some(6300.0));
        let mounts = mounted(&folder, "/", "cgroup cgroup rw,pids");
        assert_eq!(left_in(groups, &mounts), None);
        assert_eq!(left_in("", ""), None);
    }

    #[test]
    fn a_number_is_read_behind_its_word_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("thallus-number-{}", std::process::id()));
        fs::write(
            &folder,
            "anon 7\ninactive_file 4096\nMax address space unlimited\n",
        )
        .unwrap();
        let file = folder.to_str().unwrap();
        let found = ["", "inactive_file ", "Max address space", "gone"].map(|w| number(file, w));
        fs::remove_file(&folder).unwrap();
        assert_eq!(found, [None, Some(4096.0), None, None]);
        assert_eq!(number(file, ""), None);
    }
}
