//! What settings cannot be grown with, and why.

use super::preset::UnknownPreset;
use crate::growth::{PlaceError, four_digits};
use crate::substrate::UpAxis;

/// A number as one would write it: hundreds of digits say nothing.
pub(super) fn written(value: f64) -> String {
    match value == 0.0 || (1e-6..1e15).contains(&value.abs()) {
        true => value.to_string(),
        false => format!("{value:e}"),
    }
}

/// What cannot be grown, with the setting, the value, its range and what it does.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// A number outside its range.
    #[error("{name} {value} is out of range ({range}). {looks}.")]
    OutOfRange {
        /// The setting.
        name: &'static str,
        /// What was given.
        value: String,
        /// Its range in words.
        range: &'static str,
        /// What it does.
        looks: &'static str,
    },
    /// A notation that this length cannot have.
    #[error("{name} {value}: {problem}")]
    Notation {
        /// The setting.
        name: &'static str,
        /// What was given.
        value: String,
        /// Why not, and what instead.
        problem: &'static str,
    },
    /// Elements that do not fit on the mesh.
    #[error(
        "radius {radius:?} (in mesh units) is larger than the mesh: an element would be {times:.1} \
         times the bounding box's diagonal of {:?}; try radius auto, which is {:?} here",
        four_digits(*.diagonal), four_digits(*.auto)
    )]
    RadiusLargerThanMesh {
        /// Radius, file units.
        radius: f64,
        /// Diameter over the diagonal.
        times: f64,
        /// Diagonal, file units.
        diagonal: f64,
        /// What auto would be.
        auto: f64,
    },
    /// Elements larger than the surface: no second one has room, and a walker's step may cross it millions
    /// of times.
    #[error(
        "radius {:?} (in mesh units): one element would cover the piece of the mesh it is put on {} \
         times; put it elsewhere (at){}",
        four_digits(*.radius), four_digits(*.times), or_radius(*.thousand)
    )]
    RadiusLargerThanSurface {
        /// Radius, file units.
        radius: f64,
        /// An element's area over the surface's.
        times: f64,
        /// The radius of which a thousand cover the surface, if a run takes one so small.
        thousand: Option<f64>,
    },
    /// The same where nobody asked for that radius.
    #[error(
        "{file}: one element of radius {:?}, 1/2000 of the bounding box's diagonal, would cover the piece of \
         the mesh it is put on {} times; remove what lies far from the rest, or put it elsewhere (at){}",
        four_digits(*.radius), four_digits(*.times), or_radius(*.thousand)
    )]
    AutoLargerThanSurface {
        /// The mesh.
        file: String,
        /// Radius, file units.
        radius: f64,
        /// An element's area over the surface's.
        times: f64,
        /// As above.
        thousand: Option<f64>,
    },
    /// Walkers would be dropped where they start.
    #[error(
        "kill {kill:?} must be larger than launch {launch:?}: walkers start at the launch radius \
         and are given up at the kill radius"
    )]
    KillInsideLaunch {
        /// Launch radius.
        launch: f64,
        /// Kill radius.
        kill: f64,
    },
    /// More places than colonies.
    #[error(
        "colonies {colonies} is less than the {places} places given (at): ask for {places} or more, or leave out some places"
    )]
    MorePlaces {
        /// Places of seed elements.
        places: usize,
        /// Colonies.
        colonies: u64,
    },
    /// Fewer elements than colonies.
    #[error(
        "elements {elements} is less than the {colonies} colonies, each of which begins with one element"
    )]
    MoreColonies {
        /// Elements asked for.
        elements: u64,
        /// Colonies.
        colonies: u64,
    },
    /// No such preset.
    #[error(transparent)]
    Preset(#[from] UnknownPreset),
    /// The seed element has no place.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// Another axis of the mesh is up.
    #[error(
        "mesh-up is {said:?}, and the substrate has the other axis up: give it with Substrate::with_up"
    )]
    OtherUp {
        /// What was said.
        said: UpAxis,
    },
    /// A mask is said, and the substrate has none.
    #[error("mask is {said:?}, and the substrate has none: give it with Substrate::with_mask")]
    NoSuchMask {
        /// What was said.
        said: String,
    },
    /// The mask is said to be none, and the substrate has one.
    #[error("mask is \"none\", and the substrate has one: Substrate::with_mask(None) takes it off")]
    UnwantedMask,
    /// The mask is not the one that the recipe was made for.
    #[error(
        "{file} is not the mask that the recipe was made for: its hash is {found}, the recipe's {expected}"
    )]
    OtherMask {
        /// What it was made of.
        file: String,
        /// Its hash.
        found: String,
        /// The recipe's.
        expected: String,
    },
    /// The mesh is not the one that the recipe was made for.
    #[error(
        "{file} is not the mesh that the recipe was made for: its hash is {found}, the recipe's {expected}"
    )]
    OtherMesh {
        /// The file that was loaded.
        file: String,
        /// Its hash.
        found: String,
        /// The recipe's.
        expected: String,
    },
}

/// The end of a cure.
fn or_radius(thousand: Option<f64>) -> String {
    thousand.map_or_else(String::new, |radius| {
        let radius = four_digits(radius);
        format!(", or try radius {radius:?}, with room for about 1000")
    })
}

#[cfg(test)]
mod tests {
    use super::written;

    #[test]
    fn huge_and_tiny_numbers_are_written_in_a_few_digits() {
        let said = [1e300, -1e300, 1e-300, -0.25, 1200.0, 0.0, f64::INFINITY].map(written);
        assert_eq!(
            said,
            ["1e300", "-1e300", "1e-300", "-0.25", "1200", "0", "inf"]
        );
    }
}
