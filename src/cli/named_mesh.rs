//! The mesh that a recipe names.

use std::path::{Path, PathBuf};

use thallus::substrate::{Format, load_soup};

use super::mask_tiles;
use super::output::RECIPE;
use super::paths::hash_of;
use super::terminal::Voice;

/// The mesh that a recipe names, seen from here, else from the recipe's folder, else from those that hold that one:
/// one of them mostly is where it was grown from. Of several it is the one that has the hash, or else the first. Where
/// there is a hash to know it by, a file of that name in one of those folders may be it too, whatever folder is named.
pub(super) fn named_mesh(recipe: &Path, named: &str, hash: Option<&str>) -> Option<PathBuf> {
    let bare = hash.and_then(|_| file_name(named));
    let bare = bare.into_iter().flat_map(|name| around(recipe, name));
    let places = first_names(all_places(recipe, named).chain(bare));
    let files: Vec<&PathBuf> = places.iter().filter(|path| path.is_file()).collect();
    let is_meant = |path: &Path| hash.is_none_or(|hash| has_hash(path, hash));
    let meant = match files[..] {
        [] | [_] => None,
        _ => files.iter().find(|path| is_meant(path)),
    };
    let first = files.first().copied();
    meant
        .copied()
        .or(first)
        .or_else(|| places.iter().find(|path| path.exists()))
        .cloned()
}

/// Whether a mesh has this hash: that of its bytes, unless a glTF has more of them in other files.
fn has_hash(path: &Path, hash: &str) -> bool {
    let is_alone = hash_of(path).is_ok_and(|found| found == hash);
    let has_others = matches!(Format::by_name(path), Some(Format::Gltf | Format::Glb));
    is_alone || has_others && load_soup(path).is_ok_and(|mesh| mesh.hash == hash)
}

/// Says so where no recipe can name a mesh: it is text, and not every name is.
pub(super) fn warn_of_nameless(mesh: &Path, voice: Voice) {
    if mesh.to_str().is_none() {
        voice.warn(&format!(
            "{}: this name is not UTF-8, so the recipe cannot name the mesh: give it again where it is needed, or \
             rename it",
            mesh.display()
        ));
    }
}

/// The last part of a path, which another system may have written.
fn file_name(named: &str) -> Option<&str> {
    let name = named.rsplit(['/', '\\']).next();
    name.filter(|name| !name.is_empty())
}

/// Where it may be: each file once, under the first of its names.
pub(super) fn places(recipe: &Path, named: &str) -> Vec<PathBuf> {
    first_names(all_places(recipe, named))
}

fn all_places(recipe: &Path, named: &str) -> impl Iterator<Item = PathBuf> {
    [PathBuf::from(named)]
        .into_iter()
        .chain(around(recipe, named))
}

/// Beside the recipe, and in the folders above it.
fn around(recipe: &Path, named: &str) -> impl Iterator<Item = PathBuf> {
    let folder = recipe.parent().unwrap_or(Path::new(""));
    let beside = folder.join(named);
    // A recipe that is still to be written has a folder. Not as Windows has it, in a form that knows no slashes.
    let to_be = || Some(dunce::canonicalize(folder).ok()?.join(RECIPE));
    let place = dunce::canonicalize(recipe).ok().or_else(to_be);
    let place = place.unwrap_or_default();
    let above: Vec<_> = place
        .ancestors()
        .skip(2)
        .map(|folder| folder.join(named))
        .collect();
    [beside].into_iter().chain(above)
}

/// Those that are there.
fn first_names(places: impl Iterator<Item = PathBuf>) -> Vec<PathBuf> {
    let mut seen = Vec::new();
    let is_new = |path: &PathBuf| {
        let Some(place) = mask_tiles::canonical(path) else {
            return false;
        };
        let is_new = !seen.contains(&place);
        seen.push(place);
        is_new
    };
    places.filter(is_new).collect()
}
