//! Masks of UDIM tiles, an image each, which are named all at once: `damp.<UDIM>.png` is `damp.1001.png` in the first.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// What stands for a tile's number.
const MARK: &str = "<UDIM>";

/// Every number that a tile may have: ten to a row.
const NUMBERS: RangeInclusive<u32> = 1001..=10000;

/// Where a name has the mark.
fn mark_in(name: &str) -> Option<usize> {
    name.to_ascii_uppercase().find(MARK)
}

/// Whether a name is that of several images.
pub(super) fn is_tiled(name: &str) -> bool {
    mark_in(name).is_some()
}

/// The image of a tile; of another name the file itself.
pub(super) fn file_of(name: &str, tile: u32) -> PathBuf {
    match mark_in(name) {
        Some(at) => PathBuf::from(format!("{}{tile}{}", &name[..at], &name[at + MARK.len()..])),
        None => PathBuf::from(name),
    }
}

/// The files that there are of a name; of one without the mark the file itself, wherever it is.
pub(super) fn files(named: &Path) -> Vec<PathBuf> {
    match named.to_str().filter(|name| is_tiled(name)) {
        Some(name) => {
            let all = NUMBERS.map(|tile| file_of(name, tile));
            all.filter(|file| file.is_file()).collect()
        }
        None => vec![named.to_owned()],
    }
}

/// Where the first of its files is, without links: it tells a name from others.
pub(super) fn canonical(named: &Path) -> Option<PathBuf> {
    files(named).first()?.canonicalize().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_the_mark_is_that_of_the_files_that_there_are() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["damp.1002.png", "damp.1011.png", "damp.12.png", "other.png"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let of = |name: &str| {
            let files = files(&folder.path().join(name)).into_iter();
            let name = |file: PathBuf| file.file_name().unwrap().to_str().unwrap().to_owned();
            files.map(name).collect::<Vec<_>>()
        };
        assert_eq!(of("damp.<UDIM>.png"), ["damp.1002.png", "damp.1011.png"]);
        assert_eq!(of("damp.<udim>.png"), ["damp.1002.png", "damp.1011.png"]);
        assert_eq!(of("none.<UDIM>.png"), [""; 0]);
        assert_eq!(of("other.png"), ["other.png"]);
        assert_eq!(file_of("a/ä<UDIM>.png", 1021), Path::new("a/ä1021.png"));
    }
}
