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
    /// The image's path as the user gave it, or what else it was made of.
    pub file: String,
    /// Its [hash](crate::substrate::Mask::hash).
    pub hash: String,
}

impl Settings {
    /// The mask that the substrate has, by the name that is said.
    pub(super) fn mask_id(&self, substrate: &Substrate) -> Result<Option<MaskId>, SettingsError> {
        let said = self.mask.as_deref().filter(|said| *said != NO_MASK);
        let found = substrate.mask().map(|mask| mask.hash().to_owned());
        match (said, found, &self.mask_hash) {
            (None, None, Some(hash)) if self.mask.is_none() => Err(SettingsError::NoSuchMask {
                said: format!("of hash {hash}"),
            }),
            (Some(said), None, _) => Err(SettingsError::NoSuchMask {
                said: said.to_owned(),
            }),
            (_, Some(found), Some(expected)) if found != *expected => {
                Err(SettingsError::OtherMask {
                    file: said.unwrap_or("this").to_owned(),
                    found,
                    expected: expected.clone(),
                })
            }
            (said, found, _) => Ok(found.map(|hash| MaskId {
                file: said.unwrap_or("mask").to_owned(),
                hash,
            })),
        }
    }
}
