//! Which mask a recipe is for.

use super::{Settings, SettingsError};
use crate::substrate::Substrate;

/// The mask that is none: for settings that lie over others with one.
pub const NO_MASK: &str = "none";

/// The mask that is made of the [colours](crate::substrate::Mask::from_colors) in the mesh's file.
pub const VERTEX_COLORS: &str = "vertex-colors";

/// Which mask a recipe was made for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaskId {
    /// What it was made of, as the user named it: paths, or words for something else.
    pub layers: Vec<String>,
    /// Its [hash](crate::substrate::Mask::hash).
    pub hash: String,
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
        let found = substrate.mask().map(|mask| mask.hash().to_owned());
        match (found, &self.mask_hash) {
            (None, Some(hash)) if self.mask.is_none() => Err(SettingsError::NoSuchMask {
                said: format!("of hash {hash}"),
            }),
            (None, _) if !said.is_empty() => Err(SettingsError::NoSuchMask {
                said: said.join(", "),
            }),
            (Some(_), _) if self.mask.is_some() && said.is_empty() => {
                Err(SettingsError::UnwantedMask)
            }
            (Some(found), Some(expected)) if found != *expected => Err(SettingsError::OtherMask {
                file: match said {
                    [] => "this".to_owned(),
                    said => said.join(", "),
                },
                found,
                expected: expected.clone(),
            }),
            (found, _) => Ok(found.map(|hash| MaskId {
                layers: match said {
                    [] => vec!["mask".to_owned()],
                    said => said.to_vec(),
                },
                hash,
            })),
        }
    }
}
