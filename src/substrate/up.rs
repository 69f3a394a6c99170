//! Which way is up on a mesh.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Format;

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// +Y, as in OBJ, glTF, Houdini and Maya.
    #[default]
    Y,
    /// +Z, as in STL, PLY, Blender and 3ds Max.
    Z,
}

impl UpAxis {
    /// Its direction.
    pub fn direction(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

impl Format {
    /// The up axis by the format's convention, which not every file keeps to.
    pub fn up(self) -> UpAxis {
        match self {
            Self::Obj | Self::Gltf | Self::Glb => UpAxis::Y,
            Self::Stl | Self::Ply => UpAxis::Z,
        }
    }
}
