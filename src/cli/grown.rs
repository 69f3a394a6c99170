//! A grown lichen as other commands take it: its elements, and what is known about the run.

use std::path::{Path, PathBuf};

use anyhow::Context;
use thallus::cluster::Cluster;
use thallus::export::{Elements, read_elements};
use thallus::log::{LOG, count_elements};
use thallus::run::{
    CURVATURE_RADIUS, DEFAULT_CURVATURE_RADII, Length, Settings, VERTEX_COLORS, shell_path,
};
use thallus::substrate::{Format, Substrate, Texturing, UpAxis};

use super::dress::{Dress, load_dressed};
use super::failure::Failure;
use super::mask_layer::{is_lichen, split};
use super::mask_tiles;
use super::mesh_args::MeshArgs;
use super::mesh_file::load;
use super::named_mesh::{self, named_mesh};
use super::number::count;
use super::output;
use super::paths::folder_of;
use super::sweep_files::{CELLS, CSV, GRID};
use super::terminal::Voice;

/// Elements, and the recipe that lies beside them.
pub(crate) struct Grown {
    pub(crate) elements: Elements,
    /// Where they are.
    table: PathBuf,
    /// Where a recipe would be.
    recipe_file: PathBuf,
    recipe: Option<Settings>,
    voice: Voice,
}

/// Refuses to write a file over one that is read.
pub(crate) fn spare(read: &[PathBuf], output: &Path) -> Result<(), Failure> {
    let Ok(place) = output.canonicalize() else {
        return Ok(());
    };
    let is_there = |file: &PathBuf| file.canonicalize().is_ok_and(|file| file == place);
    match read.iter().any(is_there) {
        true => Err(Failure::usage(format!(
            "{} is what the lichen is read from: write to another file",
            output.display()
        ))),
        false => Ok(()),
    }
}

/// Where a lichen is, and what it grew beside.
pub(crate) struct Origin {
    pub(crate) folder: PathBuf,
    /// Folders in full.
    place: Option<PathBuf>,
    beside: Vec<PathBuf>,
}

impl Origin {
    pub(crate) fn grew_beside(&self, other: &Self) -> bool {
        other.place.iter().any(|place| self.beside.contains(place))
    }
}

/// The folder that a file is in, or it is itself, in full.
fn place_of(file: &Path) -> Option<PathBuf> {
    let place = file.canonicalize().ok()?;
    match place.is_dir() {
        true => Some(place),
        false => place.parent().map(Path::to_owned),
    }
}

/// Why it is not known which mesh a lichen grew on.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoMesh {
    #[error("there is no {} to name the mesh that this grew on", .0.display())]
    NoRecipe(PathBuf),
    #[error("{} does not name the mesh that this grew on", .0.display())]
    Unnamed(PathBuf),
    #[error("{named}, the mesh that {} names, is not here, nor beside it or above", .recipe.display())]
    Gone { named: String, recipe: PathBuf },
}

impl From<NoMesh> for Failure {
    fn from(unknown: NoMesh) -> Self {
        let error = anyhow::anyhow!("{unknown}: give the mesh with --mesh");
        match unknown {
            NoMesh::NoRecipe(_) | NoMesh::Unnamed(_) => Self::Usage(error),
            NoMesh::Gone { .. } => Self::Failed(error),
        }
    }
}

/// Refuses the folder of a sweep, which has many lichens.
fn check_is_no_sweep(folder: &Path) -> Result<(), Failure> {
    let is_sweep = folder.join(GRID).is_file() || folder.join(CELLS).is_dir();
    match is_sweep {
        false => Ok(()),
        true => Err(Failure::Failed(anyhow::anyhow!(
            "{0} is the folder of a sweep: name one of its lichens, as {0}/{CELLS}/CELL/seed-N; what all of them \
             measure is in {0}/{CSV}",
            folder.display()
        ))),
    }
}

/// Refuses the folder of a run that was killed before it wrote its elements.
fn check_is_finished(folder: &Path) -> Result<(), Failure> {
    match folder.join(LOG).is_file() {
        false => Ok(()),
        true => Err(Failure::Failed(anyhow::anyhow!(
            "{}: the run has not written its elements: unless it is still growing it was cut short, and thallus grow \
             --resume {} goes on with it",
            folder.display(),
            shell_path(folder)
        ))),
    }
}

impl Grown {
    /// Reads the folder of a run or its elements.ply, and says so where the run has come further since.
    pub(crate) fn read(from: &Path, voice: Voice) -> Result<Self, Failure> {
        let table = match from.is_dir() {
            true => from.join(output::ELEMENTS),
            false => from.to_owned(),
        };
        if !table.exists() {
            check_is_no_sweep(from)?;
            check_is_finished(from)?;
            return Err(Failure::Failed(anyhow::anyhow!(
                "{}: there is no such file: give the folder that thallus grow made, or the elements.ply in \
                 it",
                table.display()
            )));
        }
        let elements = read_elements(&table).map_err(anyhow::Error::new)?;
        if elements.is_empty() {
            let table = table.display();
            return Err(Failure::Failed(anyhow::anyhow!(
                "{table}: there are no elements in it"
            )));
        }
        let recipe_file = table.with_file_name(output::RECIPE);
        let belongs = table.ends_with(output::ELEMENTS) && recipe_file.is_file();
        let recipe = belongs.then(|| Settings::read(&recipe_file));
        let grown = Self {
            elements,
            table,
            recipe: recipe.transpose()?,
            recipe_file,
            voice,
        };
        grown.tell_of_more();
        Ok(grown)
    }

    /// Says so where the run has come further than these elements: it was being extended when it was killed, or
    /// it still is.
    fn tell_of_more(&self) {
        let log = self.table.with_file_name(LOG);
        let more = count_elements(&log).unwrap_or(0);
        if self.recipe.is_none() || more <= self.elements.len() as u64 {
            return;
        }
        self.voice.warn(&format!(
            "{} has the {} elements of the run before it was extended; {LOG} has {}: unless it is still growing, thallus \
             grow --resume {} goes on with it",
            self.table.display(),
            count(self.elements.len() as u64),
            count(more),
            shell_path(folder_of(&log))
        ));
    }

    /// Where this is, and what it grew beside, as far as that is there.
    pub(crate) fn origin(&self) -> Origin {
        let layers = self.recipe.iter().flat_map(Settings::mask_layers);
        let found = layers.filter_map(|layer| {
            let places = named_mesh::places(&self.recipe_file, layer);
            let lichen = places.first().filter(|place| is_lichen(place))?;
            place_of(lichen)
        });
        Origin {
            folder: folder_of(&self.table).to_owned(),
            place: place_of(&self.table),
            beside: found.collect(),
        }
    }

    /// What was read, and what the run needs to go on.
    pub(crate) fn files(&self, mesh: &MeshArgs) -> Vec<PathBuf> {
        let beside = [output::RECIPE, LOG].map(|name| self.table.with_file_name(name));
        let layers = self.recipe.iter().flat_map(Settings::mask_layers);
        let masks = layers.filter_map(|layer| {
            let places = named_mesh::places(&self.recipe_file, split(layer).1);
            places.into_iter().next()
        });
        let masks = masks.flat_map(|mask| mask_tiles::files(&mask));
        let read = [self.table.clone()].into_iter().chain(beside);
        read.chain(self.file_of(mesh).ok()).chain(masks).collect()
    }

    /// Refuses to write a file over one of [`files`](Self::files), whoever asks for it.
    pub(crate) fn spare(&self, output: &Path, mesh: &MeshArgs) -> Result<(), Failure> {
        spare(&self.files(mesh), output)
    }

    /// The lichen on its mesh.
    pub(crate) fn on_mesh(&self, mesh: &MeshArgs) -> Result<(Substrate, Cluster), Failure> {
        let file = self.file_of(mesh)?;
        self.on_turned(load(&file)?, mesh, &file)
    }

    /// The lichen on its mesh, with what the mesh's file says of its looks.
    pub(crate) fn on_dressed(
        &self,
        file: &Path,
        mesh: &MeshArgs,
        dress: Option<&Dress>,
    ) -> Result<(Substrate, Cluster, Texturing), Failure> {
        let (substrate, mut texturing) = load_dressed(file, dress, self.voice)?;
        self.hide_mask(&mut texturing);
        let (substrate, cluster) = self.on_turned(substrate, mesh, file)?;
        Ok((substrate, cluster, texturing))
    }

    /// Takes the colours of a mesh's vertices that are not those of the rock, but the mask that this grew by.
    pub(crate) fn hide_mask(&self, texturing: &mut Texturing) {
        let mut layers = self.recipe.iter().flat_map(Settings::mask_layers);
        if layers.any(|layer| layer == VERTEX_COLORS) && texturing.is_grey() {
            texturing.colors.clear();
            self.voice.note(
                "the colours at the mesh's vertices are the mask that this grew by, all grey, so they are not shown as those \
                 of the rock",
            );
        }
    }

    /// Says so where the mesh that the recipe names is not the one that this grew on any more. One that is given
    /// by name is taken as it is.
    pub(crate) fn tell_of_change(&self, given: Option<&Path>, file: &Path, substrate: &Substrate) {
        let grown_on = self.recipe.as_ref().and_then(|r| r.mesh_hash.as_deref());
        let found = substrate.mesh_hash();
        if let (None, Some(expected)) = (given, grown_on.filter(|expected| *expected != found)) {
            self.voice.warn(&format!(
                "{} is not as it was when this grew: its hash is {found}, and {} says {expected}; name another with \
                 --mesh, or this one if it is meant",
                file.display(),
                self.recipe_file.display()
            ));
        }
    }

    /// Says so where the mesh is the one that this grew on but for its axes.
    pub(crate) fn tell_of_turn(&self, file: &Path, is_turned: bool) {
        if is_turned {
            self.voice.note(&format!(
                "{} is turned against what this grew on, between z up and y up: the elements are turned with it",
                file.display()
            ));
        }
    }

    /// A mesh that came from this file, with its up axis, and the elements on it: a program that it went through
    /// since may have turned it.
    pub(crate) fn on_turned(
        &self,
        substrate: Substrate,
        mesh: &MeshArgs,
        file: &Path,
    ) -> Result<(Substrate, Cluster), Failure> {
        self.tell_of_change(mesh.file.as_deref(), file, &substrate);
        let found = self.elements.to_cluster_on_turned(&substrate);
        let (cluster, is_turned) = found.with_context(|| file.display().to_string())?;
        self.tell_of_turn(file, is_turned);
        let up = match is_turned {
            true => mesh.up,
            false => self.up(mesh),
        };
        Ok((substrate.with_up(up), cluster))
    }

    /// The mesh that was given, or the one that the recipe names.
    pub(crate) fn file_of(&self, mesh: &MeshArgs) -> Result<PathBuf, NoMesh> {
        match &mesh.file {
            Some(file) => Ok(file.clone()),
            None => self.mesh_file(),
        }
    }

    /// The up axis of the mesh, where that is not the one of its format.
    pub(crate) fn up(&self, mesh: &MeshArgs) -> Option<UpAxis> {
        let grown_with = self.recipe.as_ref().and_then(|recipe| recipe.mesh_up);
        mesh.up.or(grown_with)
    }

    /// The mesh that the recipe names: seen from here, else from the recipe's folder.
    pub(crate) fn mesh_file(&self) -> Result<PathBuf, NoMesh> {
        let file = || self.recipe_file.clone();
        let recipe = self
            .recipe
            .as_ref()
            .ok_or_else(|| NoMesh::NoRecipe(file()))?;
        let named = recipe
            .mesh
            .as_ref()
            .ok_or_else(|| NoMesh::Unnamed(file()))?;
        named_mesh(&self.recipe_file, named, recipe.mesh_hash.as_deref()).ok_or_else(|| {
            NoMesh::Gone {
                named: named.clone(),
                recipe: file(),
            }
        })
    }

    /// The curvature radius L that they grew with, mesh units; the usual one where nothing says it, which is told.
    pub(crate) fn curvature_radius(&self) -> f64 {
        let radius = self.elements.radius;
        let said = self.said_curvature_radius();
        // But for what the table rounds away.
        let near = [1.0 - 1e-6, 1.0 + 1e-6];
        let is_sound = |length: &f64| {
            near.iter()
                .any(|x| CURVATURE_RADIUS.allows(x * length / radius))
        };
        said.filter(is_sound).unwrap_or_else(|| {
            let problem = match said {
                Some(_) => "its recipe.toml says a curvature radius that no lichen grows with",
                None => "nothing says with which curvature radius this grew",
            };
            self.voice.warn(&format!(
                "{}: {problem}: density and the distance from the rim are those within {DEFAULT_CURVATURE_RADII} r; keep the \
                 run's recipe.toml beside it, as it was written",
                self.table.display()
            ));
            DEFAULT_CURVATURE_RADII * radius
        })
    }

    fn said_curvature_radius(&self) -> Option<f64> {
        match self.recipe.as_ref()?.curvature_radius? {
            Length::Units(length) => Some(length),
            Length::Radii(radii) => Some(radii * self.elements.radius),
            Length::Percent(_) | Length::Auto => None,
        }
    }

    /// The up axis of the mesh without a look at it: as it was said, or by the convention of the format that its
    /// name says.
    pub(crate) fn up_unseen(&self, mesh: &MeshArgs) -> Option<UpAxis> {
        self.up(mesh).or_else(|| self.up_by_name())
    }

    fn up_by_name(&self) -> Option<UpAxis> {
        let named = self.recipe.as_ref()?.mesh.as_ref()?;
        Format::by_name(Path::new(named)).map(Format::up)
    }
}
