//! Masks of UDIM tiles, an image each, which are named all at once: `damp.<UDIM>.png` is `damp.1001.png` in the first.

use std::fs;
use std::path::{Path, PathBuf};

use thallus::substrate::udim_mark;

use super::paths::folder_of;

/// The number of the first tile.
const FIRST: u32 = 1001;

/// A name of several images.
pub(super) struct Tiled<'a> {
    folder: &'a Path,
    /// What stands before the number in a file's name, and after it.
    around: [&'a str; 2],
}

impl<'a> Tiled<'a> {
    /// None where the name of a file has no such mark, or several, or where there is something of just that name.
    pub(super) fn of(name: &'a Path) -> Option<Self> {
        let file = name.file_name()?.to_str()?;
        let mark = udim_mark(file.as_bytes())?;
        let tiled = Self {
            folder: name.parent()?,
            around: [&file[..mark.start], &file[mark.end..]],
        };
        let has_another = udim_mark(tiled.around[1].as_bytes()).is_some();
        let is_there = name.symlink_metadata().is_ok();
        (!has_another && !is_there).then_some(tiled)
    }

    /// The image of a tile.
    pub(super) fn file(&self, tile: u32) -> PathBuf {
        let [before, after] = self.around;
        self.folder.join(format!("{before}{tile}{after}"))
    }

    /// The images that there are, by their numbers.
    fn files(&self) -> Vec<PathBuf> {
        let [before, after] = self.around;
        let folder = fs::read_dir(folder_of(&self.file(FIRST)));
        let names = folder.into_iter().flatten().flatten();
        let number = |name: String| {
            let number = name.strip_prefix(before)?.strip_suffix(after)?;
            let tile: u32 = number.parse().ok()?;
            let is_one = (FIRST..=10_000).contains(&tile) && tile.to_string() == number;
            is_one.then_some(tile)
        };
        let names = names.filter_map(|entry| entry.file_name().into_string().ok());
        let mut tiles: Vec<u32> = names.filter_map(number).collect();
        tiles.sort_unstable();
        tiles.into_iter().map(|tile| self.file(tile)).collect()
    }
}

/// The files that a name stands for: itself, unless it is that of images of tiles.
pub(super) fn files(named: &Path) -> Vec<PathBuf> {
    Tiled::of(named).map_or_else(|| vec![named.to_owned()], |tiled| tiled.files())
}

/// Where that is which a name stands for, without links: it tells it from others.
pub(super) fn canonical(named: &Path) -> Option<PathBuf> {
    let Some(tiled) = Tiled::of(named) else {
        return named.canonicalize().ok();
    };
    tiled.files().first()?;
    let folder = folder_of(named).canonicalize().ok()?;
    Some(folder.join(named.file_name()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_the_mark_is_that_of_the_files_that_there_are() {
        let folder = tempfile::tempdir().unwrap();
        let all = [
            "ä.1011.png",
            "ä.1002.png",
            "ä.12.png",
            "ä.01003.png",
            "ä.png",
        ];
        // Windows has no files of such names.
        let marked: &[&str] = if cfg!(windows) {
            &[]
        } else {
            &["lit<UDIM>.png"]
        };
        for name in all.iter().chain(marked) {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let of = |name: &str| {
            let files = files(&folder.path().join(name)).into_iter();
            let name = |file: PathBuf| file.file_name().unwrap().to_str().unwrap().to_owned();
            files.map(name).collect::<Vec<_>>()
        };
        assert_eq!(of("ä.<UDIM>.png"), ["ä.1002.png", "ä.1011.png"]);
        assert_eq!(of("ä.<udim>.png"), ["ä.1002.png", "ä.1011.png"]);
        assert_eq!(of("none.<UDIM>.png"), [""; 0]);
        // As they stand.
        for name in ["ä.png", "<UDIM>.<UDIM>.png"].iter().chain(marked) {
            assert_eq!(of(name), [*name]);
        }
        let place = folder.path().canonicalize().unwrap();
        let tiled = canonical(&folder.path().join("ä.<UDIM>.png"));
        assert_eq!(tiled, Some(place.join("ä.<UDIM>.png")));
        assert_eq!(canonical(&folder.path().join("none.<UDIM>.png")), None);
    }
}
