//! The mask that settings name: where lichen may grow.

use std::collections::{BTreeMap, HashSet};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use anyhow::Context;
use thallus::input;
use thallus::run::{EXPOSED, NO_MASK, OPAQUE, SECOND_UVS, Settings, SettingsError, VERTEX_COLORS};
use thallus::substrate::{Mask, Selection, Substrate, Texturing};

use super::failure::Failure;
use super::grown::Grown;
use super::mask_layer::{is_lichen, is_of_mesh, named_portably, split};
use super::mask_tiles::{self, Tiled};
use super::named_mesh;
use super::number::{percent, plural};
use super::output::FILES;
use super::terminal::Voice;

/// A mask, and where its layers were found.
pub(super) struct Found {
    pub(super) mask: Mask,
    pub(super) layers: Vec<String>,
}

/// All that says where lichen may grow, as flags.
pub(super) fn limits(settings: &Settings) -> String {
    let masks = settings.mask.iter().flatten();
    let masks = masks.map(|mask| format!("--mask {mask}"));
    let slope = settings.slope.map(|slope| format!("--slope {slope}"));
    masks.chain(slope).collect::<Vec<_>>().join(" ")
}

/// Whether the mesh's UVs or colours are read, by which these settings have a mask.
pub(super) fn needs_looks(settings: &Settings, recipes: &[PathBuf]) -> bool {
    let mut places = settings
        .mask_layers()
        .iter()
        .flat_map(|layer| places(layer, recipes));
    places.any(|place| place != EXPOSED && (is_of_mesh(&place) || !is_lichen(Path::new(&place))))
}

/// Where a layer may be: seen from here, or else as the mesh is found that one of these recipes names. As it is named,
/// where it is nowhere.
fn places(layer: &str, recipes: &[PathBuf]) -> Vec<String> {
    let recipes = recipes.iter().filter(|_| !is_of_mesh(layer));
    let (prefix, file) = split(layer);
    let places = recipes.flat_map(|recipe| named_mesh::places(recipe, file));
    let named = |place: PathBuf| format!("{prefix}{}", place.display());
    let mut places: Vec<String> = places.map(named).collect();
    if places.is_empty() {
        places.push(layer.to_owned());
    }
    places
}

/// The mask that settings ask for, if they do. Where recipe files may name it, its layers are looked for beside these
/// too: of several places that which has what the settings expect.
pub(super) fn read(
    settings: &Settings,
    recipes: &[PathBuf],
    on: (&Path, &Substrate, &Texturing),
    voice: Voice,
) -> Result<Option<Found>, Failure> {
    let expected = settings.mask_hash.as_deref();
    let layer = |layer: &String| layer_among(&places(layer, recipes), expected, on, voice);
    let found: Result<Vec<(String, Mask)>, Failure> =
        settings.mask_layers().iter().map(layer).collect();
    let (layers, masks): (Vec<String>, Vec<Mask>) = found?.into_iter().unzip();
    let Some(mask) = masks.into_iter().reduce(Mask::and) else {
        return Ok(None);
    };
    let mut hashes = expected.unwrap_or_default().to_vec();
    hashes.sort_unstable();
    match expected.is_none() || mask.hashes() == hashes {
        true => Ok(Some(Found { mask, layers })),
        false => Err(other(&settings.mask_layers().join(", "), &mask, &hashes)),
    }
}

/// Of some places, one at least, the first that has an expected layer, if any are.
fn layer_among(
    places: &[String],
    expected: Option<&[String]>,
    on: (&Path, &Substrate, &Texturing),
    voice: Voice,
) -> Result<(String, Mask), Failure> {
    let is_expected = |mask: &Mask| {
        let hashes = mask.hashes();
        expected.is_none_or(|expected| expected.iter().any(|hash| hashes == [hash]))
    };
    let look_at = |place: &String| match layer_of(place, on, voice)? {
        mask if is_expected(&mask) => Ok((place.clone(), mask)),
        mask => Err(other(place, &mask, expected.unwrap_or_default())),
    };
    let (first, others) = (&places[0], &places[1..]);
    let found = look_at(first).or_else(|problem| {
        let mut found = others.iter().filter_map(|place| look_at(place).ok());
        found.next().ok_or(problem)
    })?;
    tell_of_unpainted(&found.0, &found.1, on.1, voice);
    tell_of_tiles(&found.0, on.1, on.2, voice);
    if found.1.is_white() {
        let layer = &found.0;
        voice.warn(&format!(
            "{layer}: the mask is white everywhere, so it keeps nothing from growing"
        ));
    }
    Ok(found)
}

fn other(named: &str, mask: &Mask, expected: &[String]) -> Failure {
    let hashes = mask.hashes();
    let is_part = hashes.iter().all(|hash| expected.iter().any(|e| e == hash));
    if is_part && hashes.len() < expected.len() {
        return Failure::Failed(anyhow::anyhow!(
            "{named}: these are {} of the {} masks that the recipe was made for: name all of them, each with --mask",
            hashes.len(),
            expected.len()
        ));
    }
    let other = SettingsError::OtherMask {
        file: named.to_owned(),
        found: mask.hashes().join(", "),
        expected: expected.join(", "),
    };
    if named.split(", ").any(|layer| layer == OPAQUE) {
        return Failure::Failed(anyhow::anyhow!(
            "{other}; {OPAQUE} is what the mesh's materials and their images say, which have changed: put the earlier ones \
             back, or grow anew with --recipe, --mask {OPAQUE} and another -o"
        ));
    }
    Failure::Failed(anyhow::anyhow!(
        "{other}; name the right one with --mask; a run is gone on with only beside what it grew beside as that was, but \
         --recipe with --mask grows a new one beside it as it is"
    ))
}

/// Refuses words that are no mask, before anything is read.
pub(super) fn check_words(settings: &Settings) -> Result<(), Failure> {
    let layers = settings.mask_layers();
    if layers.iter().any(String::is_empty) {
        return Err(Failure::usage(
            "--mask is empty: name an image (uv1:IMAGE in the second set of UVs), vertex-colors, object:NAME, material:NAME, exposed, opaque, the folder of a run, or \
             none",
        ));
    }
    let is_no_image = |layer: &&String| match split(layer) {
        ("", _) => false,
        (_, name) => {
            let is_file = !name.is_empty() && !Path::new(name).is_dir();
            !is_file || is_of_mesh(name) || Tiled::of(Path::new(name)).is_some()
        }
    };
    if let Some(layer) = layers.iter().find(is_no_image) {
        return Err(Failure::usage(format!(
            "--mask {layer}: {SECOND_UVS} stands before an image, a single one, that is laid out in the mesh's second set of UVs"
        )));
    }
    for layer in layers.iter().filter(|layer| Selection::is_meant(layer)) {
        let read = layer.parse::<Selection>();
        read.map_err(|e| Failure::usage(format!("--mask {e}")))?;
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
        if texturing.is_second_painted() {
            voice.note(SECOND);
        }
        let mask = Mask::from_colors(substrate, texturing);
        return Ok(mask.with_context(|| mesh.display().to_string())?);
    }
    if layer == EXPOSED {
        return Ok(Mask::exposed(substrate));
    }
    if layer == OPAQUE {
        let tell = |note| voice.warn(&format!("{}: {note}", mesh.display()));
        texturing.notes.iter().for_each(tell);
        let mask = Mask::opaque(substrate, texturing).map_err(|e| {
            let mesh = mesh.display();
            anyhow::anyhow!("{mesh}: {OPAQUE}: {e}; or leave {OPAQUE} out, where other masks keep lichen off there")
        });
        return Ok(mask?);
    }
    if Selection::is_meant(layer) {
        let selection: Selection = layer.parse().map_err(anyhow::Error::new)?;
        let mask = Mask::from_selection(substrate, texturing, &selection);
        return Ok(mask.with_context(|| format!("{}: {layer}", mesh.display()))?);
    }
    let (set, name) = split(layer);
    let file = Path::new(name);
    if let Some(tiled) = Tiled::of(file).filter(|_| set.is_empty()) {
        return of_tiles((name, &tiled), (substrate, texturing), voice);
    }
    if set.is_empty() && is_lichen(file) {
        return beside(file, substrate, voice).map_err(|failure| failure.at("--mask".to_owned()));
    }
    let bytes = input::bytes(file).map_err(|e| unread(file, &e))?;
    let mask = match set {
        SECOND_UVS => Mask::from_second_image(substrate, texturing, &bytes),
        _ => Mask::from_image(substrate, texturing, &bytes),
    };
    if set.is_empty() && texturing.second_uvs.iter().any(Option::is_some) {
        voice.note(&format!(
            "{layer}: the mesh has two sets of UVs, and masks are laid out in the first; {SECOND_UVS}{layer} is one in the \
             second"
        ));
    }
    Ok(mask.with_context(|| layer.to_owned())?)
}

/// The mask of an image for each tile that the mesh is laid out in, as far as there are any.
fn of_tiles(
    (name, tiled): (&str, &Tiled<'_>),
    (substrate, texturing): (&Substrate, &Texturing),
    voice: Voice,
) -> Result<Mask, Failure> {
    let laid_out = texturing.tiles(substrate);
    let (mut tiles, mut without) = (BTreeMap::new(), Vec::new());
    for &tile in &laid_out {
        let file = tiled.file(tile);
        match input::bytes(&file) {
            Ok(bytes) => drop(tiles.insert(tile, bytes)),
            Err(e) if e.kind() == ErrorKind::NotFound => without.push(tile.to_string()),
            Err(e) => return Err(unread(&file, &e).into()),
        }
    }
    without.truncate(MOST_NAMED);
    let without = without.join(", ");
    if let (Some(first), true) = (laid_out.first(), tiles.is_empty()) {
        return Err(Failure::Failed(anyhow::anyhow!(
            "{name}: the mesh is laid out in the tiles {without}, and none of them has an image: name that of the first {}",
            tiled.file(*first).display()
        )));
    }
    if !without.is_empty() {
        voice.warn(&format!(
            "{name}: there is no image for these of the mesh's tiles: {without}"
        ));
    }
    let mask = Mask::from_tiles(substrate, texturing, &tiles);
    Ok(mask.with_context(|| name.to_owned())?)
}

/// Tiles that are named, at most.
const MOST_NAMED: usize = 10;

/// Says so where an image is the mask of several tiles, or repeated.
fn tell_of_tiles(layer: &str, substrate: &Substrate, texturing: &Texturing, voice: Voice) {
    let (set, name) = split(layer);
    let file = Path::new(name);
    if is_of_mesh(layer) || is_lichen(file) || Tiled::of(file).is_some() {
        return;
    }
    let uvs = |t: u32| match set {
        SECOND_UVS => texturing.second_uvs_of(substrate, t),
        _ => texturing.uvs_of(substrate, t),
    };
    let all = 0..substrate.triangles().len() as u32;
    let tile =
        |[a, b, c]: [[f64; 2]; 3]| [0, 1].map(|k| ((a[k] + b[k] + c[k]) / 3.0).floor() as i64);
    let tiles: HashSet<[i64; 2]> = all.filter_map(uvs).map(tile).collect();
    if tiles.len() > 1 {
        voice.note(&format!(
            "{layer}: the mesh's UVs reach over {} squares of the size of the image, and it is the mask in each; where these \
             are UDIM tiles, name an image for each by <UDIM>, as in damp.<UDIM>.png",
            tiles.len()
        ));
    }
}

const SECOND: &str = "vertex-colors: the first colours of the mesh (COLOR_0) are white, so the second are the mask (COLOR_1)";

/// The room that a lichen leaves.
fn beside(from: &Path, substrate: &Substrate, voice: Voice) -> Result<Mask, Failure> {
    let lichen = Grown::read(from, voice)?;
    let cluster = lichen.elements.to_cluster_on_turned(substrate);
    let (cluster, _) = cluster.with_context(|| from.display().to_string())?;
    let positions: Vec<_> = cluster.elements().iter().map(|e| e.position).collect();
    Ok(Mask::beside(substrate, &positions, cluster.radius()))
}

fn tell_of_unpainted(layer: &str, mask: &Mask, substrate: &Substrate, voice: Voice) {
    let unpainted = mask.unpainted();
    if unpainted > 0 {
        let share = unpainted as f64 / substrate.triangles().len() as f64;
        voice.warn(&format!(
            "{layer}: {} ({}) {} nothing to go by in the mask, so nothing grows there",
            plural(unpainted, "triangle", "triangles"),
            percent(share),
            if unpainted == 1 { "has" } else { "have" },
        ));
    }
}

/// Whether a name begins as if with a set of UVs.
fn names_a_set(name: &str) -> bool {
    let set = name.split_once(':').map(|(set, _)| set.to_lowercase());
    set.is_some_and(|set| set.strip_prefix("uv").is_some_and(|n| n.len() < 2))
}

fn unread(file: &Path, problem: &io::Error) -> anyhow::Error {
    let is_colors = |name: &str| name.to_lowercase().starts_with("vertex");
    let cure = match (file.to_str(), problem.kind()) {
        (Some(name), _) if is_colors(name) => format!("did you mean {VERTEX_COLORS}?"),
        (Some(name), ErrorKind::NotFound) if names_a_set(name) => {
            format!("the first set of UVs needs no name, and the second is {SECOND_UVS}")
        }
        (Some(name), ErrorKind::NotFound) if name.contains(',') => {
            "of several masks give each with a --mask of its own".to_owned()
        }
        (_, ErrorKind::NotFound) => {
            format!(
                "give the path of an image or of a run's folder, {VERTEX_COLORS}, object:NAME, material:NAME, {EXPOSED}, \
                 {OPAQUE}, or {NO_MASK}"
            )
        }
        _ => "name it with --mask".to_owned(),
    };
    let file = file.display();
    anyhow::anyhow!("{file}: reading the mask failed: {problem}; {cure}")
}

/// The layers as a file names them that names the mesh too: as the settings do, where they are found from that file, or
/// else from the folder that the program is called from.
pub(super) fn named(settings: &Settings, found: &[String], by: &Path) -> Option<Vec<String>> {
    let place = |layer: &str| mask_tiles::canonical(Path::new(split(layer).1));
    let name = |(named, found): (&String, &String)| {
        let seen = places(named, &[by.to_owned()]);
        let is_seen = seen.first().is_some_and(|seen| place(seen) == place(found));
        named_portably(if is_seen { named } else { found })
    };
    match settings.mask_layers() {
        [] => settings.mask.clone(),
        layers => Some(layers.iter().zip(found).map(name).collect()),
    }
}

/// Refuses to replace a layer by what is grown by it.
pub(super) fn check_spares(folder: &Path, layers: &[String]) -> Result<(), Failure> {
    let place = |file: &Path| file.canonicalize().ok();
    let own = [folder.to_owned()].into_iter();
    let own = own.chain(FILES.iter().map(|name| folder.join(name)));
    let own: Vec<_> = own.filter_map(|file| place(&file)).collect();
    let is_own = |layer: &&String| {
        let files = mask_tiles::files(Path::new(split(layer).1)).into_iter();
        files
            .filter_map(|file| place(&file))
            .any(|at| own.contains(&at))
    };
    let mut files = layers.iter().filter(|layer| !is_of_mesh(layer));
    match files.find(is_own) {
        None => Ok(()),
        Some(layer) => Err(Failure::usage(format!(
            "--mask {layer} is what the run itself writes: write to another folder with -o"
        ))),
    }
}
