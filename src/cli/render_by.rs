//! Colours by a quantity, as `--by` names it.

use clap::builder::TypedValueParser;
use rayon::prelude::*;
use thallus::export::Elements;
use thallus::morphometry::{LOOK, Neighbours, Tree, density, is_rim, rim_distance};
use thallus::picture::Key;
use thallus::skin::{Colormap, ColormapError, Paint};

use super::choice::choice;
use super::failure::Failure;

/// Something that is known about every element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Birth,
    Density,
    Rim,
    Probability,
    Order,
    Depth,
    Colony,
}

/// Every quantity, its name on the command line and what it is.
const QUANTITIES: [(Quantity, &str, &str); 7] = [
    (Quantity::Birth, "birth", "birth index, 0 for the first"),
    (
        Quantity::Density,
        "density",
        "share of the surface within 6.4 radii that elements cover",
    ),
    (
        Quantity::Rim,
        "rim",
        "distance from the rim, over elements, in mesh units; gaps of less than 4.4 radii are no rim",
    ),
    (
        Quantity::Probability,
        "probability",
        "chance P_s with which the element stuck",
    ),
    (
        Quantity::Order,
        "order",
        "Strahler's branch order, 1 at tips",
    ),
    (Quantity::Depth, "depth", "steps from the seed"),
    (
        Quantity::Colony,
        "colony",
        "the seed that it descends from; without --range and --colormap",
    ),
];

impl Quantity {
    pub(crate) fn parser() -> impl TypedValueParser<Value = Self> {
        choice(QUANTITIES.map(|(quantity, name, _)| (name, quantity)))
    }

    pub(crate) fn help() -> String {
        let lines: String = QUANTITIES
            .iter()
            .map(|(_, name, what)| format!("\n{name}: {what}"))
            .collect();
        format!(
            "Colour by a number that every element has, from the least to the greatest, viridis or \
             the stops of --colormap:{lines}"
        )
    }

    /// What it is called in a legend.
    fn title(self, unit: &str) -> String {
        match self {
            Self::Birth => "birth".to_owned(),
            Self::Density => format!("density within {LOOK} r"),
            Self::Rim => format!("distance from the rim, {unit}"),
            Self::Probability => "sticking probability".to_owned(),
            Self::Order => "branch order (Strahler)".to_owned(),
            Self::Depth => "steps from the seed".to_owned(),
            Self::Colony => "colony".to_owned(),
        }
    }

    /// Its value for each element; NaN where it has none.
    pub(super) fn values(self, elements: &Elements) -> Vec<f64> {
        let tree = || Tree::new(&elements.parent);
        let wide = |column: Vec<u32>| column.into_iter().map(f64::from).collect();
        match self {
            Self::Birth => (0..elements.len()).map(|i| i as f64).collect(),
            Self::Density => density(elements.radius, &near(elements)),
            Self::Rim => {
                let near = near(elements);
                let rim = rim_distance(&is_rim(&near), &near);
                rim.into_iter().map(|d| d.unwrap_or(f64::NAN)).collect()
            }
            // Seeds did not stick to anything.
            Self::Probability => {
                let pairs = elements.probability.iter().zip(&elements.parent);
                let chance =
                    |(&p, &parent): (&_, &i32)| if parent < 0 { f64::NAN } else { f64::from(p) };
                pairs.map(chance).collect()
            }
            Self::Order => wide(tree().strahler()),
            Self::Depth => wide(tree().depth()),
            Self::Colony => elements.colony.iter().map(|&c| c.into()).collect(),
        }
    }
}

/// As the skin looks.
fn near(elements: &Elements) -> Neighbours {
    let Elements {
        radius,
        positions,
        normals,
        ..
    } = elements;
    Neighbours::new(positions, normals, LOOK * radius)
}

/// Matplotlib's viridis (S. van der Walt and N. Smith, 2015): equal steps look equal, also to the
/// colour-blind and in grey.
const VIRIDIS: [(f32, [u8; 3]); 9] = [
    (0.0, [0x44, 0x01, 0x54]),
    (0.125, [0x47, 0x2d, 0x7b]),
    (0.25, [0x3b, 0x52, 0x8b]),
    (0.375, [0x2c, 0x72, 0x8e]),
    (0.5, [0x21, 0x91, 0x8c]),
    (0.625, [0x28, 0xae, 0x80]),
    (0.75, [0x5e, 0xc9, 0x62]),
    (0.875, [0xad, 0xdc, 0x30]),
    (1.0, [0xfd, 0xe7, 0x25]),
];

/// Where there is no number.
const NONE: [u8; 3] = [0x8a, 0x8a, 0x8a];

/// Colours for the values of a quantity.
pub(super) struct Coloring {
    quantity: Quantity,
    ramp: Paint,
    ends: [f64; 2],
}

impl Coloring {
    /// From the least to the greatest value, or as the flags say.
    pub(super) fn new(
        quantity: Quantity,
        colormap: Option<&str>,
        range: Option<[f64; 2]>,
        values: &[f64],
    ) -> Result<Self, Failure> {
        if quantity == Quantity::Colony && (range.is_some() || colormap.is_some()) {
            return Err(Failure::usage(
                "--by colony: colonies have colours of their own: leave --range and --colormap away",
            ));
        }
        let colormap = match colormap {
            None => Colormap::new(&VIRIDIS),
            Some(text) => text.parse(),
        };
        let wrong = |e: ColormapError| Failure::Usage(anyhow::Error::new(e).context("--colormap"));
        let known = || values.iter().filter(|v| v.is_finite());
        let least = known().fold(f64::INFINITY, |a, &b| a.min(b));
        let greatest = known().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        let found = if least <= greatest {
            [least, greatest]
        } else {
            [0.0; 2]
        };
        Ok(Self {
            quantity,
            ramp: colormap.map_err(wrong)?.into(),
            ends: range.unwrap_or(found),
        })
    }

    /// sRGB of each value.
    pub(super) fn colors(&self, values: &[f64]) -> Vec<[u8; 3]> {
        values.par_iter().map(|&value| self.color(value)).collect()
    }

    fn color(&self, value: f64) -> [u8; 3] {
        let [low, high] = self.ends;
        match () {
            () if !value.is_finite() => NONE,
            () if self.quantity == Quantity::Colony => kind(value as u32),
            () if high > low => self.at(((value - low) / (high - low)) as f32),
            () => self.at(0.5),
        }
    }

    fn at(&self, share: f32) -> [u8; 3] {
        self.ramp.color(share, 1.0, f32::INFINITY)
    }

    /// Hands the key for a legend to `draw`.
    pub(super) fn with_key(&self, values: &[f64], unit: &str, draw: impl FnOnce(Key<'_>)) {
        let title = self.quantity.title(unit);
        if self.quantity == Quantity::Colony {
            let kinds = self.kinds(values);
            return draw(Key::Kinds {
                title: &title,
                kinds: &kinds,
            });
        }
        draw(Key::Range {
            title: &title,
            ends: self.ends,
            color: &|share| self.at(share),
        });
    }

    /// The first colonies, and how many more there are.
    fn kinds(&self, values: &[f64]) -> Vec<(String, [u8; 3])> {
        const SHOWN: usize = 12;
        let mut colonies: Vec<u32> = values.iter().map(|&v| v as u32).collect();
        colonies.par_sort_unstable();
        colonies.dedup();
        let name = |&c: &u32| (c.to_string(), kind(c));
        let mut kinds: Vec<_> = colonies.iter().take(SHOWN).map(name).collect();
        if colonies.len() > SHOWN {
            kinds.push((format!("and {} more", colonies.len() - SHOWN), NONE));
        }
        kinds
    }
}

/// Colours that neighbours in number differ well in: hues a golden angle apart, in three
/// lightnesses.
fn kind(number: u32) -> [u8; 3] {
    const GOLDEN_TURN: f32 = 0.381_966;
    let hue = (number as f32 * GOLDEN_TURN + 0.11).fract() * core::f32::consts::TAU;
    let light = [0.70, 0.56, 0.80][number as usize % 3];
    thallus::picture::hue_color(light, 0.13, hue)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coloring(quantity: Quantity, values: &[f64]) -> Coloring {
        Coloring::new(quantity, None, None, values).unwrap()
    }

    #[test]
    fn the_ends_have_the_ends_of_viridis() {
        let values = [5.0, f64::NAN, 10.0, 7.5];
        let coloring = coloring(Quantity::Rim, &values);
        let expected = [VIRIDIS[0].1, NONE, VIRIDIS[8].1, VIRIDIS[4].1];
        assert_eq!(coloring.colors(&values), expected);
        assert_eq!(coloring.colors(&[-1e9, 1e9]), [VIRIDIS[0].1, VIRIDIS[8].1]);
    }

    #[test]
    fn one_value_or_none_is_no_error() {
        assert_eq!(
            coloring(Quantity::Birth, &[3.0]).colors(&[3.0]),
            [VIRIDIS[4].1]
        );
        assert_eq!(
            coloring(Quantity::Rim, &[f64::NAN]).colors(&[f64::NAN]),
            [NONE]
        );
    }

    #[test]
    fn colonies_have_colours_of_their_own() {
        let values: Vec<f64> = (0..15).map(f64::from).collect();
        let coloring = coloring(Quantity::Colony, &values);
        let colors = coloring.colors(&values);
        for (i, a) in colors.iter().enumerate() {
            for b in &colors[..i] {
                let apart: i32 = (0..3)
                    .map(|k| (i32::from(a[k]) - i32::from(b[k])).abs())
                    .sum();
                assert!(apart > 24, "{a:?} {b:?}");
            }
        }
        let kinds = coloring.kinds(&values);
        assert_eq!((kinds.len(), kinds[12].0.as_str()), (13, "and 3 more"));
    }
}
