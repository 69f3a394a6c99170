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

/// What is read of a mesh's looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Looks {
    Nothing,
    /// All of them if anything is seen through them. No fault in them is one.
    Openings,
    All,
}

impl<'a> MeshFile<'a> {
    pub(super) fn read(path: &'a Path, looks: Looks) -> Result<Self, Failure> {
        let room = Room::now();
        let read = match looks {
            Looks::All => substrate::load_textured(path),
            _ => load_soup(path).map(|loaded| (loaded, Texturing::default())),
        };
        let (loaded, mut texturing) = read.map_err(|e| failed(path, &e.into()))?;
        room.check(path, &loaded)?;
        if looks == Looks::Openings && loaded.speaks_of_openings {
            let looks = substrate::load_textured(path);
            texturing = looks.map(|(_, looks)| looks).unwrap_or_default();
        }
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
    Ok(MeshFile::read(path, Looks::Nothing)?.surface()?.0)
}

/// The same, with what the file says about textures where something is seen through them.
pub(super) fn load_cut_out(path: &Path) -> Result<(Substrate, Texturing), Failure> {
    MeshFile::read(path, Looks::Openings)?.surface()
}

/// The same, with what the file says about textures.
pub(super) fn load_textured(path: &Path) -> Result<(Substrate, Texturing), Failure> {
    MeshFile::read(path, Looks::All)?.surface()
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
