//! What `thallus check` says of the maps that `thallus bake` can make of a mesh.

use serde::Serialize;
use thallus::substrate::{Substrate, Texturing};

use super::bake_flags::{Flags, Settled, WASTED, are_few, cure};
use super::number::{percent, plural, short};

/// What maps of a mesh would be.
#[derive(Debug, Serialize)]
pub(super) struct Maps {
    /// What to call `thallus bake` with, for the fewest overlaps that its flags can reach.
    flags: &'static str,
    /// Maps of each kind that this makes at most.
    images: usize,
    /// Share of their texels that show something.
    used: f64,
    /// Of these the share that stands for several places of the surface.
    overlapping: f64,
    /// That without the flags; null where there are no maps without.
    overlapping_without: Option<f64>,
    /// Parts that there can be no maps of.
    parts_unfit: usize,
    /// Triangles that are in no map.
    triangles_not_shown: usize,
    /// Usual side of an image on the surface.
    side: f64,
    #[serde(skip)]
    cure: String,
}

/// Texels in a row of the maps that are spoken of.
const SIZE: f64 = 2048.0;

impl Maps {
    /// None where the file has no coordinates.
    ///
    /// # Errors
    /// Why there can be no maps, and what to do.
    pub(super) fn of(substrate: &Substrate, texturing: &Texturing) -> Result<Option<Self>, String> {
        if texturing.uvs.iter().all(Option::is_none) {
            return Ok(None);
        }
        let best = Flags::best(substrate, texturing, Settled::default());
        let best = best.map_err(|problem| match problem.is_of_sharing() {
            true => format!(
                "none: {problem}; none of its layouts serves: {}",
                cure(texturing, false)
            ),
            false => format!("none: {problem}"),
        })?;
        let judged = best.judged;
        Ok(Some(Self {
            flags: best.words,
            images: judged.images,
            used: judged.used,
            overlapping: judged.overlapping,
            overlapping_without: best.without,
            parts_unfit: judged.unfit,
            triangles_not_shown: judged.not_shown,
            side: judged.side,
            cure: cure(texturing, false),
        }))
    }

    /// In words; elements have this radius unless something else is said.
    pub(super) fn told(&self, radius: f64) -> String {
        let mut told = match (self.flags, self.overlapping_without) {
            ("", _) => shared(self.overlapping),
            (flags, None) => format!("bake with {flags}: {}", shared(self.overlapping)),
            (flags, Some(without)) => {
                let [with, without] = [self.overlapping, without].map(shared);
                format!("bake with {flags}: {with}, where without that {without}")
            }
        };
        if !are_few(self.overlapping) {
            told += &format!("; {}", self.cure);
        }
        if self.parts_unfit > 0 {
            told += &format!(
                "; {} an image and can have none, which does not matter where no lichen is",
                plural(self.parts_unfit, "part repeats", "parts repeat")
            );
        }
        if self.triangles_not_shown > 0 {
            let triangles = plural(self.triangles_not_shown, "triangle is", "triangles are");
            let them = if self.triangles_not_shown == 1 {
                "it"
            } else {
                "them"
            };
            told += &format!("; {triangles} in no map, and --unwrap has a place for {them}");
        }
        let pack = match self.used < WASTED {
            true => ", so pack the UVs to be larger",
            false => "",
        };
        let [used, wide] = [100.0 * self.used, self.side / SIZE / radius].map(short);
        let images = plural(self.images, "image", "images");
        told + &format!(
            "; {used} % of {images} {} used{pack}; a texel of --size {SIZE} is {wide} auto radii wide",
            if self.images == 1 { "is" } else { "are" }
        )
    }
}

fn shared(share: f64) -> String {
    match are_few(share) {
        true => "no place shares texels with another".to_owned(),
        false => format!(
            "{} of the texels in use stand for several places",
            percent(share)
        ),
    }
}
