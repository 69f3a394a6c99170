//! What the layers of a mask are called.

use std::path::Path;

use thallus::run::{EXPOSED, OPAQUE, SECOND_UVS, VERTEX_COLORS};
use thallus::substrate::Selection;

use super::paths::portable;

/// Whether a layer is another lichen: the folder of a run, or its elements.
pub(super) fn is_lichen(layer: &Path) -> bool {
    let is_table = || {
        layer
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("ply"))
    };
    layer.is_dir() || is_table()
}

/// Whether a layer is something in the mesh's own file.
pub(super) fn is_of_mesh(layer: &str) -> bool {
    [VERTEX_COLORS, EXPOSED, OPAQUE].contains(&layer) || Selection::is_meant(layer)
}

/// What says how an image is laid out, if anything does, and the rest, which is a file unless it is of the mesh.
pub(super) fn split(layer: &str) -> (&str, &str) {
    layer.split_at(
        layer
            .strip_prefix(SECOND_UVS)
            .map_or(0, |_| SECOND_UVS.len()),
    )
}

/// A layer as a recipe names it, on any system.
pub(super) fn named_portably(layer: &str) -> String {
    match is_of_mesh(layer) {
        true => layer.to_owned(),
        false => portable(Path::new(layer)),
    }
}
