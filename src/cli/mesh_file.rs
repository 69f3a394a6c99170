//! A mesh file that becomes a surface.

use std::path::Path;

use thallus::substrate::{self, Loaded, Substrate, SubstrateError, Texturing, load_soup};

use super::failure::Failure;
use super::memory::Room;

/// What was read of a mesh file, which memory has room for.
pub(super) struct MeshFile<'a> {
    path: &'a Path,
    loaded: Loaded,
    /// What it says about textures, if that was asked for, or if something is seen through them.
    texturing: Texturing,
}

impl<'a> MeshFile<'a> {
    pub(super) fn read(path: &'a Path, is_textured: bool) -> Result<Self, Failure> {
        let room = Room::now();
        let read = match is_textured {
            true => substrate::load_textured(path),
            false => load_soup(path).map(|loaded| (loaded, Texturing::default())),
        };
        let (loaded, mut texturing) = read.map_err(|e| failed(path, &e.into()))?;
        if loaded.speaks_of_openings && !is_textured {
            // Nobody has asked for textures, so no fault in them keeps lichen from growing.
            let looks = substrate::load_textured(path);
            texturing = looks.map(|(_, looks)| looks).unwrap_or_default();
        }
        room.check(path, &loaded)?;
        Ok(Self {
            path,
            loaded,
            texturing,
        })
    }

    pub(super) fn surface(self) -> Result<(Substrate, Texturing), Failure> {
        let substrate = Substrate::from_loaded(self.loaded).map_err(|e| failed(self.path, &e))?;
        Ok((substrate, self.texturing))
    }
}

/// The surface in a mesh file.
pub(super) fn load(path: &Path) -> Result<Substrate, Failure> {
    Ok(load_cut_out(path)?.0)
}

/// The same, with what the file says about textures where something is seen through them.
pub(super) fn load_cut_out(path: &Path) -> Result<(Substrate, Texturing), Failure> {
    MeshFile::read(path, false)?.surface()
}

/// The same, with what the file says about textures.
pub(super) fn load_textured(path: &Path) -> Result<(Substrate, Texturing), Failure> {
    MeshFile::read(path, true)?.surface()
}

fn failed(path: &Path, error: &SubstrateError) -> Failure {
    Failure::Failed(anyhow::Error::msg(load_error(path, error)))
}

/// Why a mesh could not be loaded, with the file's name.
pub(super) fn load_error(path: &Path, error: &SubstrateError) -> String {
    match error {
        SubstrateError::Load(named) => named.to_string(),
        unnamed => format!("{}: {unnamed}", path.display()),
    }
}
