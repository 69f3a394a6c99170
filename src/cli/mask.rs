//! The mask that settings name: where lichen may grow.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use thallus::input;
use thallus::run::{NO_MASK, Settings, SettingsError, VERTEX_COLORS};
use thallus::substrate::{Mask, Substrate, Texturing};

use super::failure::Failure;
use super::grown::Grown;
use super::named_mesh::named_mesh;
use super::number::{percent, plural};
use super::terminal::Voice;

/// Whether the mesh's UVs or colours are read, by which these settings have a mask.
pub(super) fn needs_looks(settings: &Settings, recipes: &[PathBuf]) -> bool {
    let layers = found(settings, recipes);
    { layers.iter() }.any(|layer| !is_lichen(Path::new(layer)))
}

/// Whether a layer is another lichen: the folder of a run, or its elements.
fn is_lichen(layer: &Path) -> bool {
    let is_table = || {
        layer
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("ply"))
    };
    layer.is_dir() || is_table()
}

/// The mask that settings ask for, if they do. Where recipe files may name it, its layers are looked for beside these too.
pub(super) fn read(
    settings: &Settings,
    recipes: &[PathBuf],
    on: (&Path, &Substrate, &Texturing),
    voice: Voice,
) -> Result<Option<Mask>, Failure> {
    check_words(settings.mask_layers())?;
    let mut all: Option<Mask> = None;
    for layer in found(settings, recipes) {
        let mask = layer_of(&layer, on, voice)?;
        tell_of_unpainted(&layer, &mask, voice);
        all = Some(match all {
            Some(others) => others.and(mask),
            None => mask,
        });
    }
    match (&all, &settings.mask_hash) {
        (Some(mask), Some(expected)) if mask.hash() != expected => Err(Failure::Failed(
            anyhow::Error::new(SettingsError::OtherMask {
                file: settings.mask_layers().join(", "),
                found: mask.hash().to_owned(),
                expected: expected.clone(),
            }),
        )),
        _ => Ok(all),
    }
}

fn check_words(layers: &[String]) -> Result<(), Failure> {
    if layers.iter().any(String::is_empty) {
        return Err(Failure::usage(
            "--mask is empty: name an image, vertex-colors, the folder of a run, or none",
        ));
    }
    match layers.iter().any(|layer| layer == NO_MASK) {
        true => Err(Failure::usage(
            "--mask none is for no mask at all: leave out the others",
        )),
        false => Ok(()),
    }
}

fn layer_of(
    layer: &str,
    (mesh, substrate, texturing): (&Path, &Substrate, &Texturing),
    voice: Voice,
) -> Result<Mask, Failure> {
    if layer == VERTEX_COLORS {
        let mask = Mask::from_colors(substrate, texturing);
        return Ok(mask.with_context(|| mesh.display().to_string())?);
    }
    let file = Path::new(layer);
    if is_lichen(file) {
        return beside(file, substrate, voice).map_err(|failure| failure.at("--mask".to_owned()));
    }
    let bytes = input::bytes(file).map_err(|e| unread(file, &e))?;
    let mask = Mask::from_image(substrate, texturing, &bytes);
    Ok(mask.with_context(|| layer.to_owned())?)
}

/// The room that a lichen leaves.
fn beside(from: &Path, substrate: &Substrate, voice: Voice) -> Result<Mask, Failure> {
    let lichen = Grown::read(from, voice)?;
    let cluster = lichen.elements.to_cluster(substrate);
    let cluster = cluster.with_context(|| from.display().to_string())?;
    let positions: Vec<_> = cluster.elements().iter().map(|e| e.position).collect();
    Ok(Mask::beside(substrate, &positions, cluster.radius()))
}

fn tell_of_unpainted(layer: &str, mask: &Mask, voice: Voice) {
    let unpainted = mask.unpainted();
    if unpainted > 0 {
        let share = unpainted as f64 / mask.triangles() as f64;
        voice.warn(&format!(
            "{layer}: {} ({}) {} nothing to go by in the mask, so nothing grows there",
            plural(unpainted, "triangle", "triangles"),
            percent(share),
            if unpainted == 1 { "has" } else { "have" },
        ));
    }
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
pub(super) fn settled(settings: &Settings, recipes: &[PathBuf]) -> Option<Vec<String>> {
    let is_known = settings.mask_hash.is_some() || settings.mask_layers().is_empty();
    match is_known {
        true => settings.mask.clone(),
        false => Some(found(settings, recipes)),
    }
}

/// The layers of the mask that settings ask for, those that are files seen from here, or else found as the mesh is that a
/// recipe names: beside the first recipe that has one there.
pub(super) fn found(settings: &Settings, recipes: &[PathBuf]) -> Vec<String> {
    let layers = settings.mask_layers();
    let hash = settings.mask_hash.as_deref().filter(|_| layers.len() == 1);
    let found = |layer: &String| {
        let recipes = recipes.iter().filter(|_| layer != VERTEX_COLORS);
        let mut files = recipes.filter_map(|recipe| named_mesh(recipe, layer, hash));
        Some(files.next()?.display().to_string())
    };
    let here = |layer: &String| found(layer).unwrap_or_else(|| layer.clone());
    layers.iter().map(here).collect()
}
