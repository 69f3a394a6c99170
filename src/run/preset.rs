//! Named looks: what lichens look like, as numbers.

use super::names::nearest_name;
use super::{Length, Settings, StopSetting};
use crate::growth::Join;

/// A named look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// What it looks like, in one sentence.
    pub look: &'static str,
    /// Curvature radius L, in element radii.
    pub curvature_radius: f64,
    /// Sticking bias B.
    pub bias: f64,
    /// Curvature gain A.
    pub gain: f64,
    /// Lowest sticking probability.
    pub min_stick: f64,
    /// How walkers are joined.
    pub join: Join,
    /// Elements that show the look.
    pub elements: u64,
}

/// A name that no preset has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no preset '{name}'{}; there are {}", suggestion(.name), names())]
pub struct UnknownPreset {
    /// The name.
    pub name: String,
}

/// What all but one preset share.
const LICHEN: Preset = Preset {
    name: "",
    look: "",
    curvature_radius: 10.0,
    bias: 0.5,
    gain: 1.0,
    min_stick: 0.01,
    join: Join::Pack,
    elements: 20_000,
};

/// Every preset, from the most open to the most closed.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "dla",
        look: "Frost on a window: hair-thin fractal branches, plain diffusion-limited aggregation",
        min_stick: 1.0,
        join: Join::Touch,
        ..LICHEN
    },
    Preset {
        name: "fruticose",
        look: "A tangle of thin, uneven twigs, like beard or reindeer lichen pressed flat",
        curvature_radius: 5.0,
        bias: 0.9,
        ..LICHEN
    },
    Preset {
        name: "feathered",
        look: "Fans of fine parallel plumes with ragged tips",
        curvature_radius: 20.0,
        bias: 0.7,
        ..LICHEN
    },
    Preset {
        name: "branched",
        look: "Even branches with rounded tips that fork again and again",
        ..LICHEN
    },
    Preset {
        name: "foliose",
        look: "Broad leafy lobes with deep clefts between them, like a shield lichen",
        curvature_radius: 20.0,
        elements: 35_000,
        ..LICHEN
    },
    Preset {
        name: "rosette",
        look: "A dense round thallus that ends in a few short, blunt lobes, like sunburst lichen",
        bias: 0.3,
        elements: 40_000,
        ..LICHEN
    },
    Preset {
        name: "crustose",
        look: "A closed crust with a gently scalloped edge, like map lichen",
        curvature_radius: 20.0,
        bias: 0.3,
        elements: 50_000,
        ..LICHEN
    },
];

/// The preset of this name.
///
/// # Errors
/// [`UnknownPreset`], which names those that there are.
pub fn find(name: &str) -> Result<&'static Preset, UnknownPreset> {
    let unknown = || UnknownPreset {
        name: name.to_owned(),
    };
    PRESETS.iter().find(|p| p.name == name).ok_or_else(unknown)
}

impl Preset {
    /// What it says, to lie under other settings.
    pub fn settings(&self) -> Settings {
        Settings {
            curvature_radius: Some(Length::Radii(self.curvature_radius)),
            bias: Some(self.bias),
            gain: Some(self.gain),
            min_stick: Some(self.min_stick),
            join: Some(self.join),
            stop: Some(StopSetting::Elements(self.elements)),
            ..Settings::default()
        }
    }
}

fn suggestion(name: &str) -> String {
    nearest_name(name, PRESETS.iter().map(|p| p.name))
        .map_or_else(String::new, |near| format!(" (did you mean '{near}'?)"))
}

fn names() -> String {
    let names: Vec<_> = PRESETS.iter().map(|p| p.name).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_can_be_found_and_grown() {
        for preset in PRESETS {
            assert_eq!(find(preset.name), Ok(preset));
            preset.settings().complete().unwrap();
        }
    }

    #[test]
    fn names_and_looks_differ() {
        for (i, a) in PRESETS.iter().enumerate() {
            for b in &PRESETS[..i] {
                assert!(a.name != b.name && a.look != b.look && a.settings() != b.settings());
            }
        }
    }

    #[test]
    fn a_misspelt_name_gets_a_suggestion() {
        let message = find("folios").unwrap_err().to_string();
        assert!(message.contains("did you mean 'foliose'?"), "{message}");
        assert!(message.contains("crustose"), "{message}");
    }
}
