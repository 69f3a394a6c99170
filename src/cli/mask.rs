//! The mask that settings name: where lichen may grow.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use thallus::input;
use thallus::run::{NO_MASK, Settings, SettingsError, VERTEX_COLORS};
use thallus::substrate::{Mask, Substrate, Texturing};

use super::failure::Failure;
use super::named_mesh::named_mesh;
use super::number::{percent, plural};
use super::terminal::Voice;

/// Whether these settings ask for a mask, for which the mesh's UVs or colours are read.
pub(super) fn is_asked(settings: &Settings) -> bool {
    settings.mask.as_deref().is_some_and(|mask| mask != NO_MASK)
}

/// The mask that settings ask for, if they do. Where a recipe file names it, its image is looked for beside that too.
pub(super) fn read(
    settings: &Settings,
    recipe: Option<&Path>,
    (mesh, substrate, texturing): (&Path, &Substrate, &Texturing),
    voice: Voice,
) -> Result<Option<Mask>, Failure> {
    let Some(named) = settings.mask.as_deref().filter(|_| is_asked(settings)) else {
        return Ok(None);
    };
    if named.is_empty() {
        return Err(Failure::usage(
            "--mask is empty: name an image, vertex-colors or none",
        ));
    }
    let mask = match named {
        VERTEX_COLORS => {
            Mask::from_colors(substrate, texturing).with_context(|| mesh.display().to_string())?
        }
        _ => {
            let file = file(settings, recipe).unwrap_or_else(|| PathBuf::from(named));
            let of_file = || file.display().to_string();
            let bytes = input::bytes(&file).map_err(|e| unread(&file, &e))?;
            Mask::from_image(substrate, texturing, &bytes).with_context(of_file)?
        }
    };
    if let Some(expected) = settings
        .mask_hash
        .as_ref()
        .filter(|hash| **hash != mask.hash())
    {
        return Err(Failure::Failed(anyhow::Error::new(
            SettingsError::OtherMask {
                file: named.to_owned(),
                found: mask.hash().to_owned(),
                expected: expected.clone(),
            },
        )));
    }
    if mask.unpainted() > 0 {
        let share = mask.unpainted() as f64 / substrate.triangles().len() as f64;
        voice.warn(&format!(
            "{named}: {} ({}) {} nothing to go by in the mask, so nothing grows there",
            plural(mask.unpainted(), "triangle", "triangles"),
            percent(share),
            if mask.unpainted() == 1 { "has" } else { "have" },
        ));
    }
    Ok(Some(mask))
}

fn unread(file: &Path, problem: &io::Error) -> anyhow::Error {
    let is_colors = |name: &str| name.to_lowercase().starts_with("vertex");
    let cure = match file.to_str() {
        Some(name) if is_colors(name) => format!("did you mean {VERTEX_COLORS}?"),
        _ => "name it with --mask".to_owned(),
    };
    let file = file.display();
    anyhow::anyhow!("{file}: reading the mask failed: {problem}; {cure}")
}

/// The mask as a sweep's grid names it: found from the folder that the program is called from, unless it is known by its
/// hash.
pub(super) fn settled(settings: &Settings, recipe: Option<&Path>) -> Option<String> {
    let found = file(settings, recipe).filter(|_| settings.mask_hash.is_none());
    let found = found.map(|file| file.display().to_string());
    found.or_else(|| settings.mask.clone())
}

/// The image of the mask that settings ask for, if it is one: seen from here, or else found as the mesh is that a recipe
/// names.
pub(super) fn file(settings: &Settings, recipe: Option<&Path>) -> Option<PathBuf> {
    let is_image = |named: &&str| is_asked(settings) && *named != VERTEX_COLORS;
    let named = settings.mask.as_deref().filter(is_image)?;
    let hash = settings.mask_hash.as_deref();
    let found = recipe.and_then(|recipe| named_mesh(recipe, named, hash));
    Some(found.unwrap_or_else(|| PathBuf::from(named)))
}
