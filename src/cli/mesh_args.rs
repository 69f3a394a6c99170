//! Which mesh a lichen is on, and how that stands.

use std::path::PathBuf;

use clap::Args;
use thallus::substrate::UpAxis;

use super::choice::up;

#[derive(Debug, Args)]
pub(crate) struct MeshArgs {
    /// The mesh that the lichen grew on, or a copy that a program has turned from z up to y up or back [default: the
    /// one that recipe.toml beside the elements names]
    #[arg(id = "mesh", long = "mesh", value_name = "MESH")]
    pub(crate) file: Option<PathBuf>,
    /// Up axis of the mesh [default: that it grew with; without one, and for a turned copy, y for OBJ and glTF, z for
    /// STL and PLY]
    #[arg(
        id = "mesh_up",
        long = "mesh-up",
        value_parser = up(),
        hide_possible_values = true,
        value_name = "y|z"
    )]
    pub(crate) up: Option<UpAxis>,
}
