//! What the mesh is drawn as in pictures: by what its own file says, by an image, or made up.

use std::path::{Path, PathBuf};

use thallus::appearance::Appearance;
use thallus::input;
use thallus::picture::{Finish, Ground};
use thallus::skin::parse_color;
use thallus::substrate::{Substrate, Texturing};

use super::failure::Failure;
use super::mesh_file::{load, load_cut_out, load_textured};
use super::terminal::Voice;

/// As it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Dress {
    /// What the mesh's file says.
    Own,
    /// An image in the layout of the mesh.
    Image(PathBuf),
    Drawn(Ground),
}

impl Dress {
    /// The image's file.
    pub(crate) fn file(&self) -> Option<PathBuf> {
        match self {
            Self::Image(file) => Some(file.clone()),
            Self::Own | Self::Drawn(_) => None,
        }
    }

    pub(super) fn parse(text: &str) -> Result<Self, String> {
        match text {
            "mesh" => Ok(Self::Own),
            file if file.contains(['.', '/', '\\']) => Ok(Self::Image(file.into())),
            _ => ground(text)
                .map(Self::Drawn)
                .map_err(|e| format!("{e}, mesh, or the name of a PNG or JPEG file")),
        }
    }
}

/// What is made up where nothing else is said.
pub(super) fn made_up(dress: Option<&Dress>) -> Ground {
    match dress {
        Some(Dress::Drawn(ground)) => *ground,
        _ => Ground::default(),
    }
}

/// A mesh, with what its file says of its looks as far as that is asked for. Where nobody asks, a fault in that is
/// only told.
pub(super) fn load_dressed(
    file: &Path,
    dress: Option<&Dress>,
    voice: Voice,
) -> Result<(Substrate, Texturing), Failure> {
    if let Some(Dress::Drawn(_)) = dress {
        return load_cut_out(file);
    }
    match (dress, load_textured(file)) {
        (None, Err(fault)) => {
            let substrate = load(file)?;
            voice.warn(&format!("{}: the mesh is drawn as stone", fault.reason()));
            Ok((substrate, Texturing::default()))
        }
        (_, loaded) => loaded,
    }
}

/// Refuses an image that a flag names for a mesh without UVs.
pub(super) fn check_lies(
    (mesh, texturing): (&Path, &Texturing),
    (flag, image): (&str, &Path),
) -> Result<(), Failure> {
    if texturing.uvs.iter().any(Option::is_some) {
        return Ok(());
    }
    let (mesh, image) = (mesh.display(), image.display());
    Err(Failure::Failed(anyhow::anyhow!(
        "{mesh}: there are no UVs of its own to lay {image} on it by: unwrap it where it was made, or write {flag} \
         stone"
    )))
}

/// The mesh's own looks, where it is to be drawn by them, or what of it is open.
pub(super) fn appearance<'a>(
    dress: Option<&Dress>,
    (substrate, texturing): (&'a Substrate, &'a Texturing),
    mesh: &Path,
    voice: Voice,
) -> Result<Option<Appearance<'a>>, Failure> {
    let shape = || Some(Appearance::of_shape(substrate, texturing)).filter(Finish::has_openings);
    let own = match dress {
        Some(Dress::Drawn(_)) => {
            return Ok(shape());
        }
        Some(Dress::Image(file)) => {
            check_lies((mesh, texturing), ("--ground", file))?;
            let bytes = input::bytes(file).map_err(|e| e.to_string());
            let own = bytes.and_then(|bytes| Appearance::of_image(substrate, texturing, &bytes));
            own.map_err(|e| anyhow::anyhow!("--ground {}: {e}", file.display()))?
        }
        Some(Dress::Own) | None => Appearance::new(substrate, texturing),
    };
    let tell = |note| voice.warn(&format!("{}: {note}", mesh.display()));
    own.notes().for_each(tell);
    let says_nothing = texturing.materials.is_empty() && texturing.colors.is_empty();
    match dress {
        None => Ok(Some(own).filter(Appearance::has_colors).or_else(shape)),
        Some(Dress::Own) if says_nothing => Err(Failure::Failed(anyhow::anyhow!(
            "{}: it has no colours of its own, of vertices or of a material: leave --ground out for stone, or \
                 name an image in the layout of its UVs",
            mesh.display()
        ))),
        Some(_) => Ok(Some(own)),
    }
}

pub(super) fn ground(text: &str) -> Result<Ground, String> {
    match text {
        "stone" => Ok(Ground::Stone),
        "bark" => Ok(Ground::Bark),
        color => parse_color(color)
            .map(Ground::Color)
            .map_err(|e| format!("{e}; or write stone or bark")),
    }
}

/// As it is read.
pub(super) fn ground_text(ground: Ground) -> String {
    match ground {
        Ground::Stone => "stone".to_owned(),
        Ground::Bark => "bark".to_owned(),
        Ground::Color([r, g, b]) => format!("#{r:02x}{g:02x}{b:02x}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grounds_are_written_as_they_are_read() {
        for text in ["stone", "bark", "#0a80ff"] {
            assert_eq!(ground(text).map(ground_text).as_deref(), Ok(text));
        }
    }
}
