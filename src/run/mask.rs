//! Which mask a recipe is for.

use super::{Settings, SettingsError};
use crate::substrate::{Mask, Substrate};

/// The mask that is none: for settings that lie over others with one.
pub const NO_MASK: &str = "none";

/// The mask that is made of the [colours](crate::substrate::Mask::from_colors) in the mesh's file.
pub const VERTEX_COLORS: &str = "vertex-colors";

/// What stands in place of a mask's file for what is not inside other pieces of the mesh.
pub const EXPOSED: &str = "exposed";

/// What stands in place of a mask's file for what [materials](crate::substrate::Mask::opaque) do not leave open.
pub const OPAQUE: &str = "opaque";

/// What stands before the name of an image that is laid out in the mesh's [second set of
/// UVs](crate::substrate::Mask::from_second_image).
pub const SECOND_UVS: &str = "uv1:";

/// Which mask a recipe was made for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaskId {
    /// What it was made of, as the user named it: paths, or words for something else.
    pub layers: Vec<String>,
    /// Its [hashes](crate::substrate::Mask::hashes).
    pub hashes: Vec<String>,
}

impl MaskId {
    /// Whether it is that of a mask, its layers in whatever order.
    pub(super) fn is_of(&self, mask: &Mask) -> bool {
        let mut hashes: Vec<&str> = self.hashes.iter().map(String::as_str).collect();
        hashes.sort_unstable();
        hashes == mask.hashes()
    }
}

impl Settings {
    /// The layers of the mask that is asked for, as they are named: none where [none](NO_MASK) is.
    pub fn mask_layers(&self) -> &[String] {
        let layers = self.mask.as_deref().unwrap_or_default();
        match layers {
            [only] if only == NO_MASK => &[],
            layers => layers,
        }
    }

    /// The mask that the substrate has, by the names that are said.
    pub(super) fn mask_id(&self, substrate: &Substrate) -> Result<Option<MaskId>, SettingsError> {
        let said = self.mask_layers();
        let names = |other: &str| match said {
            [] => other.to_owned(),
            said => said.join(", "),
        };
        let hashes = |mask: &Mask| mask.hashes().into_iter().map(str::to_owned).collect();
        let found: Option<Vec<String>> = substrate.mask().map(hashes);
        match (found, self.sorted_mask_hash()) {
            (None, Some(hashes)) if self.mask.is_none() => Err(SettingsError::NoSuchMask {
                said: format!("of hash {}", hashes.join(", ")),
            }),
            (None, _) if !said.is_empty() => Err(SettingsError::NoSuchMask { said: names("") }),
            (Some(_), _) if self.mask.is_some() && said.is_empty() => {
                Err(SettingsError::UnwantedMask)
            }
            (Some(found), Some(expected)) if found != expected => Err(SettingsError::OtherMask {
                file: names("this"),
                found: found.join(", "),
                expected: expected.join(", "),
            }),
            (found, _) => Ok(found.map(|hashes| MaskId {
                layers: match said {
                    [] => vec!["mask".to_owned()],
                    said => said.to_vec(),
                },
                hashes,
            })),
        }
    }

    /// As [`Mask::hashes`] has them.
    pub(super) fn sorted_mask_hash(&self) -> Option<Vec<String>> {
        let mut hashes = self.mask_hash.clone()?;
        hashes.sort_unstable();
        Some(hashes)
    }
}
