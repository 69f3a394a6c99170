//! Outputs appear complete or not at all.

use std::fs;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use tempfile::{TempDir, tempdir};
use thallus::export::{OutputDir, OutputError, write_file_atomically};

fn says(text: &str) -> impl FnOnce(&mut dyn Write) -> io::Result<()> {
    move |out| out.write_all(text.as_bytes())
}

/// Writes more than any buffer holds, then fails.
fn fails(out: &mut dyn Write) -> io::Result<()> {
    out.write_all(&vec![1; 1 << 20])?;
    Err(io::ErrorKind::StorageFull.into())
}

/// Names in a folder, hidden ones too, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}

fn scratch() -> TempDir {
    tempdir().unwrap()
}

#[test]
fn file_appears_with_missing_parents() {
    let folder = scratch();
    let path = folder.path().join("a/b/c.txt");
    write_file_atomically(&path, false, says("hello")).unwrap();
    assert_eq!(read(&path), "hello");
    assert_eq!(names(path.parent().unwrap()), ["c.txt"]);
}

#[test]
fn failed_file_leaves_nothing_behind() {
    let folder = scratch();
    let path = folder.path().join("new/c.txt");
    let error = write_file_atomically(&path, false, fails)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("c.txt") && error.contains("make room"),
        "{error}"
    );
    assert!(names(folder.path()).is_empty());
    let panics = || write_file_atomically(&path, false, |_| panic!("on purpose"));
    assert!(catch_unwind(panics).is_err());
    assert!(names(folder.path()).is_empty());
}

#[test]
fn file_is_replaced_by_force_only() {
    let folder = scratch();
    let path = folder.path().join("c.txt");
    write_file_atomically(&path, true, says("old")).unwrap();
    let error = write_file_atomically(&path, false, |_| panic!("must not be called"));
    let error = error.unwrap_err();
    assert!(matches!(error, OutputError::FileExists(_)));
    assert!(error.to_string().contains("only by force"));
    write_file_atomically(&path, true, fails).unwrap_err();
    assert_eq!(read(&path), "old");
    write_file_atomically(&path, true, says("new")).unwrap();
    assert_eq!(read(&path), "new");
    assert_eq!(names(folder.path()), ["c.txt"]);
}

#[test]
fn file_that_appears_meanwhile_is_kept() {
    let folder = scratch();
    let path = folder.path().join("c.txt");
    let meddle = |out: &mut dyn Write| {
        fs::write(&path, "theirs")?;
        out.write_all(b"ours")
    };
    let error = write_file_atomically(&path, false, meddle).unwrap_err();
    assert!(matches!(error, OutputError::FileExists(_)));
    assert_eq!(read(&path), "theirs");
    assert_eq!(names(folder.path()), ["c.txt"]);
}

#[test]
fn old_file_is_whole_while_the_new_is_written() {
    let folder = scratch();
    let path = folder.path().join("c.txt");
    fs::write(&path, "old").unwrap();
    let look = |out: &mut dyn Write| {
        out.write_all(&vec![1; 1 << 20])?;
        assert_eq!(read(&path), "old");
        Ok(())
    };
    write_file_atomically(&path, true, look).unwrap();
    assert_eq!(fs::read(&path).unwrap().len(), 1 << 20);
}

#[test]
fn folders_and_files_in_each_others_place() {
    let folder = scratch();
    let file = folder.path().join("file");
    fs::write(&file, "x").unwrap();
    for force in [false, true] {
        let error = write_file_atomically(folder.path(), force, says("")).unwrap_err();
        assert!(matches!(error, OutputError::NotAFile(_)), "{error}");
        let below = file.join("deep/c.txt");
        let error = write_file_atomically(&below, force, says("")).unwrap_err();
        assert!(
            matches!(&error, OutputError::NotAFolder(p) if *p == file),
            "{error}"
        );
        for place in [&file, &below] {
            let error = OutputDir::create(place, force).unwrap_err();
            assert!(
                matches!(&error, OutputError::NotAFolder(p) if *p == file),
                "{error}"
            );
        }
    }
    assert_eq!(read(&file), "x");
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn folder_appears_with_missing_parents() {
    let folder = scratch();
    let path = folder.path().join("out/rock");
    let mut dir = OutputDir::create(&path, false).unwrap();
    dir.write("a.txt", says("1")).unwrap();
    dir.write("a.txt", says("2")).unwrap();
    dir.write("b.txt", says("3")).unwrap();
    assert!(!path.join("a.txt").exists());
    dir.commit().unwrap();
    assert_eq!(names(&path), ["a.txt", "b.txt"]);
    assert_eq!(read(&path.join("a.txt")), "2");
}

#[test]
fn abandoned_folder_leaves_nothing_behind() {
    let folder = scratch();
    let path = folder.path().join("out/rock");
    let mut dir = OutputDir::create(&path, false).unwrap();
    dir.write("a.txt", says("1")).unwrap();
    drop(dir);
    assert!(names(folder.path()).is_empty());
    let panics = || {
        let mut dir = OutputDir::create(&path, false).unwrap();
        dir.write("a.txt", |_| panic!("on purpose"))
    };
    assert!(catch_unwind(AssertUnwindSafe(panics)).is_err());
    assert!(names(folder.path()).is_empty());
}

#[test]
fn failed_file_is_not_committed() {
    let folder = scratch();
    let path = folder.path().join("rock");
    let mut dir = OutputDir::create(&path, false).unwrap();
    let error = dir.write("a.txt", fails).unwrap_err().to_string();
    assert!(
        error.contains("a.txt") && !error.contains(".thallus-run"),
        "{error}"
    );
    dir.write("b.txt", says("3")).unwrap();
    dir.commit().unwrap();
    assert_eq!(names(&path), ["b.txt"]);
}

#[test]
fn of_two_files_at_once_the_one_that_fails_is_named_and_not_committed() {
    let folder = scratch();
    let path = folder.path().join("rock");
    let mut dir = OutputDir::create(&path, false).unwrap();
    dir.write_both(("a.txt", says("1")), ("b.txt", says("2")))
        .unwrap();
    let error = dir.write_both(("c.txt", fails), ("d.txt", says("4")));
    assert!(error.unwrap_err().to_string().contains("c.txt"));
    let error = dir.write_both(("a.txt", says("5")), ("e.txt", fails));
    assert!(error.unwrap_err().to_string().contains("e.txt"));
    let error = dir.write_both(("f.txt", fails), ("g.txt", fails));
    assert!(error.unwrap_err().to_string().contains("f.txt"));
    let same = || dir.write_both(("h.txt", says("6")), ("h.txt", says("7")));
    assert!(catch_unwind(AssertUnwindSafe(same)).is_err());
    dir.commit().unwrap();
    assert_eq!(names(&path), ["a.txt", "b.txt", "d.txt"]);
    assert_eq!(read(&path.join("a.txt")), "5");
    assert_eq!(read(&path.join("b.txt")), "2");
}

#[test]
fn used_folder_is_replaced_by_force_only() {
    let folder = scratch();
    let path = folder.path();
    fs::write(path.join("theirs.txt"), "theirs").unwrap();
    fs::write(path.join("ours.txt"), "old").unwrap();
    let error = OutputDir::create(path, false).unwrap_err();
    assert!(matches!(error, OutputError::FolderExists(_)));
    assert!(error.to_string().contains("only by force"));

    let mut dir = OutputDir::create(path, true).unwrap();
    dir.write("ours.txt", says("new")).unwrap();
    assert_eq!(read(&path.join("ours.txt")), "old");
    drop(dir);
    assert_eq!(read(&path.join("ours.txt")), "old");
    assert_eq!(names(path), ["ours.txt", "theirs.txt"]);

    let mut dir = OutputDir::create(path, true).unwrap();
    dir.write("ours.txt", says("new")).unwrap();
    dir.commit().unwrap();
    assert_eq!(read(&path.join("ours.txt")), "new");
    assert_eq!(read(&path.join("theirs.txt")), "theirs");
    assert_eq!(names(path), ["ours.txt", "theirs.txt"]);
}

#[test]
fn empty_folder_is_taken_without_force() {
    let folder = scratch();
    let mut dir = OutputDir::create(folder.path(), false).unwrap();
    dir.write("a.txt", says("1")).unwrap();
    dir.commit().unwrap();
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn files_that_appear_meanwhile_are_kept() {
    let folder = scratch();
    let path = folder.path();
    let mut dir = OutputDir::create(path, false).unwrap();
    dir.write("a.txt", says("1")).unwrap();
    dir.write("b.txt", says("1")).unwrap();
    fs::write(path.join("b.txt"), "theirs").unwrap();
    assert!(matches!(
        dir.commit().unwrap_err(),
        OutputError::FolderExists(_)
    ));
    assert_eq!(names(path), ["b.txt"]);
    assert_eq!(read(&path.join("b.txt")), "theirs");
}

#[test]
fn second_run_into_a_folder_is_refused() {
    let folder = scratch();
    let path = folder.path().join("rock");
    let mut first = OutputDir::create(&path, false).unwrap();
    first.write("a.txt", says("1")).unwrap();
    for force in [false, true] {
        let error = OutputDir::create(&path, force).unwrap_err();
        let me = std::process::id();
        assert!(matches!(error, OutputError::Locked { process, .. } if process == Some(me)));
    }
    first.commit().unwrap();
    assert_eq!(names(&path), ["a.txt"]);
    assert!(OutputDir::create(&path, true).is_ok());
}

/// Its name is another run's now: what the first does must not reach that one.
#[cfg(unix)]
#[test]
fn a_run_whose_folder_was_moved_leaves_the_next_one_there_alone() {
    let scratch = scratch();
    let path = scratch.path().join("rock");
    let mut moved = OutputDir::create(&path, false).unwrap();
    moved.write("a.txt", says("1")).unwrap();
    fs::rename(&path, scratch.path().join("elsewhere")).unwrap();
    let mut next = OutputDir::create(&path, false).unwrap();
    next.write("a.txt", says("2")).unwrap();
    for tried in [
        moved.write("b.txt", says("1")),
        moved.place("b.txt", says("1")),
        moved.replace(&["a.txt"], &[("b.txt", b"1")]),
        moved.remove("a.txt"),
        moved.commit(),
    ] {
        let said = tried.unwrap_err().to_string();
        assert!(said.contains("moved, replaced or removed"), "{said}");
    }
    let error = OutputDir::create(&path, true).unwrap_err();
    assert!(matches!(error, OutputError::Locked { .. }), "{error}");
    next.commit().unwrap();
    assert_eq!(names(&path), ["a.txt"]);
    assert_eq!(read(&path.join("a.txt")), "2");
}

/// The one folder in another.
fn folder_in(folder: &Path, is_it: impl Fn(&Path) -> bool) -> PathBuf {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut folders = entries.filter(|path| path.is_dir() && is_it(path));
    folders.next().expect("a folder")
}

/// Where files of a folder wait for their names.
fn waiting_in(folder: &Path) -> PathBuf {
    let is_hidden = |path: &Path| path.file_name().unwrap().as_encoded_bytes()[0] == b'.';
    folder_in(&folder_in(folder, is_hidden), |_| true)
}

#[test]
fn files_are_replaced_together_or_not_at_all() {
    let folder = scratch();
    let path = folder.path();
    for name in ["a.txt", "b.txt", "d.txt"] {
        fs::write(path.join(name), "old").unwrap();
    }
    fs::create_dir(path.join("c.txt")).unwrap();
    let mut dir = OutputDir::create(path, true).unwrap();
    let by: [(&str, &[u8]); 2] = [("b.txt", b"new"), ("e.txt", b"new")];
    let error = dir.replace(&["a.txt", "b.txt", "c.txt"], &by).unwrap_err();
    assert!(
        matches!(error, OutputError::NotAFile(ref at) if at.ends_with("c.txt")),
        "{error}"
    );
    // The last of them cannot be set aside, when the others have been.
    fs::write(path.join("e.txt"), "old").unwrap();
    let in_the_way = waiting_in(path).join("e.txt.earlier");
    fs::create_dir_all(in_the_way.join("full")).unwrap();
    assert!(dir.replace(&["a.txt"], &by).is_err());
    for name in ["a.txt", "b.txt", "d.txt", "e.txt"] {
        assert_eq!(read(&path.join(name)), "old", "{name}");
    }
    fs::remove_dir_all(in_the_way).unwrap();
    dir.replace(&["a.txt", "b.txt", "f.txt"], &by).unwrap();
    dir.commit().unwrap();
    assert_eq!(names(path), ["b.txt", "c.txt", "d.txt", "e.txt"]);
    assert_eq!(read(&path.join("b.txt")), "new");
}

#[test]
fn what_is_read_is_neither_replaced_nor_removed() {
    let folder = scratch();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("read.txt"), "read").unwrap();
    let mut dir = OutputDir::create(&out, true).unwrap();
    dir.spare(&[out.join("read.txt")]);
    let by: [(&str, &[u8]); 1] = [("read.txt", b"new")];
    for refused in [
        dir.replace(&["read.txt"], &[]),
        dir.replace(&[], &by),
        dir.remove("read.txt"),
        dir.place("read.txt", says("new")),
    ] {
        assert!(matches!(refused, Err(OutputError::IsRead(_))));
    }
    dir.replace(&[], &[("new.txt", b"new")]).unwrap();
    dir.commit().unwrap();
    assert_eq!(read(&out.join("read.txt")), "read");
    assert_eq!(names(&out), ["new.txt", "read.txt"]);
}

/// Runs race for a folder: at any time one of them has it, and what it wrote is what appears.
#[test]
fn racing_runs_never_mix() {
    let folder = scratch();
    let path = folder.path().join("rock");
    let race = |name: usize| {
        let mut committed = 0;
        for round in 0..60 {
            let Ok(mut dir) = OutputDir::create(&path, true) else {
                continue;
            };
            let text = format!("{name} {round}");
            dir.write("a.txt", says(&text)).unwrap();
            dir.write("b.txt", says(&text)).unwrap();
            if round % 3 > 0 {
                dir.commit().unwrap();
                committed += 1;
            }
        }
        committed
    };
    let committed: usize = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..4).map(|name| scope.spawn(move || race(name))).collect();
        runs.into_iter().map(|run| run.join().unwrap()).sum()
    });
    assert!(committed > 0);
    assert_eq!(names(&path), ["a.txt", "b.txt"]);
    assert_eq!(read(&path.join("a.txt")), read(&path.join("b.txt")));
}

/// What a killed run leaves: its hidden folder, with a lock that nobody holds.
#[test]
fn what_a_killed_run_left_is_cleared() {
    let folder = scratch();
    let files = folder.path().join(".thallus-run/files");
    fs::create_dir_all(&files).unwrap();
    fs::write(files.join("a.txt"), "half").unwrap();
    fs::write(folder.path().join(".thallus-run/lock"), "99999999").unwrap();
    let mut dir = OutputDir::create(folder.path(), false).unwrap();
    dir.write("b.txt", says("1")).unwrap();
    dir.commit().unwrap();
    assert_eq!(names(folder.path()), ["b.txt"]);
}

#[test]
#[should_panic(expected = "not a plain file name")]
fn names_stay_in_the_folder() {
    let folder = scratch();
    let mut dir = OutputDir::create(folder.path(), false).unwrap();
    let _ = dir.write("../a.txt", says("1"));
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    /// As `std` makes files, which is what the umask says (0644 under 022), and not 0600.
    #[test]
    fn modes_follow_the_umask() {
        let folder = scratch();
        let plain = folder.path().join("plain");
        fs::write(&plain, "").unwrap();
        let single = folder.path().join("single");
        write_file_atomically(&single, false, says("")).unwrap();
        let path = folder.path().join("dir");
        let mut dir = OutputDir::create(&path, false).unwrap();
        dir.write("a", says("")).unwrap();
        dir.commit().unwrap();
        assert_eq!([mode(&single), mode(&path.join("a"))], [mode(&plain); 2]);
    }

    #[test]
    fn folder_may_be_a_link_and_a_file_link_is_replaced() {
        let folder = scratch();
        let real = folder.path().join("real");
        let link = folder.path().join("link");
        fs::create_dir(&real).unwrap();
        symlink(&real, &link).unwrap();
        let mut dir = OutputDir::create(&link, false).unwrap();
        dir.write("a", says("1")).unwrap();
        dir.commit().unwrap();
        assert_eq!(names(&real), ["a"]);
        let dangling = folder.path().join("dangling");
        symlink(folder.path().join("nowhere"), &dangling).unwrap();
        assert!(write_file_atomically(&dangling, false, says("1")).is_err());
        write_file_atomically(&dangling, true, says("1")).unwrap();
        assert!(!dangling.is_symlink());
    }

    /// The superuser may write anywhere, and learns nothing here.
    #[test]
    fn unwritable_folder_is_refused_at_once() {
        let folder = scratch();
        let path = folder.path().join("locked");
        fs::create_dir(&path).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o555)).unwrap();
        if fs::write(path.join("probe"), "").is_ok() {
            return;
        }
        for place in [path.clone(), path.join("new")] {
            let error = OutputDir::create(&place, false).unwrap_err().to_string();
            assert!(
                error.contains("locked") && error.contains("where you may write"),
                "{error}"
            );
            let file = place.join("c.txt");
            let error = write_file_atomically(&file, false, says(""))
                .unwrap_err()
                .to_string();
            assert!(error.contains("where you may write"), "{error}");
        }
        assert!(names(&path).is_empty());
    }

    #[test]
    fn impossible_names_are_errors() {
        let folder = scratch();
        let long = folder.path().join("x".repeat(300));
        assert!(write_file_atomically(&long, false, says("")).is_err());
        assert!(OutputDir::create(&long, false).is_err());
        assert!(write_file_atomically(Path::new("/"), true, says("")).is_err());
        let unnamed = write_file_atomically(Path::new(""), true, says(""));
        assert!(matches!(unnamed, Err(OutputError::NoName)));
        assert!(matches!(
            OutputDir::create(Path::new(""), true),
            Err(OutputError::NoName)
        ));
        assert!(names(folder.path()).is_empty());
    }
}
