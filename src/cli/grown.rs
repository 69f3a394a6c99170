//! A grown lichen as other commands take it: its elements, and what is known about the run.

use std::path::{Path, PathBuf};

use thallus::export::{Elements, UpAxis, read_elements};
use thallus::morphometry::smooth_normals;
use thallus::run::{Length, Settings};
use thallus::substrate::{Substrate, SubstrateError};

use super::failure::Failure;
use super::{check, output, terminal};

/// Elements, with smooth normals where their mesh is known.
pub(crate) struct Grown {
    pub(crate) elements: Elements,
    /// The mesh's up axis, as far as it is known.
    pub(crate) up: Option<UpAxis>,
    /// The curvature radius L that they grew with, mesh units; 10 r where nothing says it.
    pub(crate) curvature_radius: f64,
}

impl Grown {
    /// Reads the folder of a run or its elements.ply, and the mesh, given or as the recipe says.
    pub(crate) fn read(from: &Path, mesh: Option<&Path>) -> Result<Self, Failure> {
        let table = table_in(from);
        let elements = read_elements(&table).map_err(anyhow::Error::new)?;
        if elements.is_empty() {
            let table = table.display();
            return Err(Failure::Failed(anyhow::anyhow!(
                "{table}: there are no elements in it"
            )));
        }
        let recipe = recipe_beside(&table)?;
        let mut grown = Self {
            up: recipe
                .as_ref()
                .and_then(|(_, r)| up_by_name(r.mesh.as_ref()?)),
            curvature_radius: curvature_radius(&elements, recipe.as_ref().map(|(_, r)| r)),
            elements,
        };
        match mesh {
            Some(mesh) => grown.place(mesh, &load(mesh)?)?,
            None => grown.find_mesh(recipe.as_ref())?,
        }
        Ok(grown)
    }

    fn place(&mut self, mesh: &Path, substrate: &Substrate) -> Result<(), Failure> {
        let not_here = |e| Failure::Failed(anyhow::anyhow!("{}: {e}", mesh.display()));
        let places = self.elements.places_on(substrate).map_err(not_here)?;
        let normals = smooth_normals(substrate, &places);
        let source = places.iter().map(|p| substrate.source_triangle(p.triangle));
        self.elements.normals = normals.iter().map(|n| n.as_vec3().to_array()).collect();
        self.elements.source_triangle = Some(source.collect());
        self.up = Some(UpAxis::of(substrate));
        Ok(())
    }

    /// Takes the mesh that the recipe names, seen from here, else from the recipe's folder. The
    /// lichen is whole without it: its normals are then those of the flat triangles.
    fn find_mesh(&mut self, recipe: Option<&(PathBuf, Settings)>) -> Result<(), Failure> {
        let flat = "normals are those of the flat triangles; give the mesh with --mesh";
        let Some((folder, named)) = recipe.and_then(|(f, r)| Some((f, r.mesh.as_ref()?))) else {
            terminal::warn(&format!("nothing says which mesh this grew on: {flat}"));
            return Ok(());
        };
        let places = [PathBuf::from(named), folder.join(named)];
        let Some(mesh) = places.iter().find(|p| p.is_file()) else {
            terminal::warn(&format!(
                "{named}, the mesh that this grew on, is not there: {flat}"
            ));
            return Ok(());
        };
        let placed = load(mesh).and_then(|substrate| self.place(mesh, &substrate));
        if let Err(Failure::Failed(error)) = placed {
            terminal::warn(&format!("{error:#}; {flat}"));
        }
        Ok(())
    }
}

/// The table of a run's folder, or the file itself.
pub(super) fn table_in(from: &Path) -> PathBuf {
    match from.is_dir() {
        true => from.join(output::ELEMENTS),
        false => from.to_owned(),
    }
}

/// The folder and the recipe of the run that a table belongs to.
fn recipe_beside(table: &Path) -> Result<Option<(PathBuf, Settings)>, Failure> {
    let folder = table.parent().unwrap_or(Path::new("")).to_owned();
    let path = folder.join(output::RECIPE);
    if !(table.ends_with(output::ELEMENTS) && path.is_file()) {
        return Ok(None);
    }
    Ok(Some((folder, Settings::read(&path)?)))
}

fn load(mesh: &Path) -> Result<Substrate, Failure> {
    let failed = |e: SubstrateError| anyhow::Error::msg(check::load_error(mesh, &e));
    Ok(Substrate::load(mesh).map_err(failed)?)
}

fn curvature_radius(elements: &Elements, recipe: Option<&Settings>) -> f64 {
    const USUAL_RADII: f64 = 10.0;
    let said = match recipe.and_then(|r| r.curvature_radius) {
        Some(Length::Units(length)) => Some(length),
        Some(Length::Radii(radii)) => Some(radii * elements.radius),
        _ => None,
    };
    let sound = |length: &f64| length.is_finite() && *length >= elements.radius;
    said.filter(sound).unwrap_or(USUAL_RADII * elements.radius)
}

/// The convention of the format that a mesh's name says.
fn up_by_name(mesh: &String) -> Option<UpAxis> {
    let extension = Path::new(mesh).extension()?.to_str()?;
    match extension.to_ascii_lowercase().as_str() {
        "obj" | "gltf" | "glb" => Some(UpAxis::Y),
        "stl" | "ply" => Some(UpAxis::Z),
        _ => None,
    }
}
