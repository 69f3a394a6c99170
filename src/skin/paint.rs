//! Colours of the skin: by local density as the thesis, darker with age, with a dark margin.

use std::str::FromStr;

use super::palette::{PALETTE, find};
use super::{Apothecia, Areoles, SkinError, as_meant, in_range};
use crate::color::{from_oklab, to_byte, to_oklab};

/// Colours for numbers from 0 to 1, straight lines in Oklab between stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Colormap {
    /// Place and Oklab colour, ascending.
    stops: Vec<(f32, [f32; 3])>,
}

/// A text or a list that is no colour map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ColormapError {
    /// A stop that is not a place and a colour.
    #[error(
        "'{0}' is not a colour stop: write a density from 0 to 1, a colon and a colour, as 0.5:#aabbcc"
    )]
    Stop(String),
    /// A colour that is none.
    #[error("'{0}' is not a colour: write # and six hexadecimal digits, as #aabbcc")]
    Color(String),
    /// Stops that go back.
    #[error("the stops' densities must ascend: {0} comes after a greater or equal one")]
    Order(String),
    /// Fewer than it takes.
    #[error("a colour map has at least one stop, such as 0:#aabbcc")]
    Empty,
    /// A name that no colour map has.
    #[error(transparent)]
    Unknown(#[from] UnknownColormap),
}

/// A name that no colour map has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no colour map '{0}'; there are {names}, or give stops: 0:#202020,0.5:#aabbcc",
    names = names()
)]
pub struct UnknownColormap(pub String);

fn names() -> String {
    let names: Vec<_> = PALETTE.iter().map(|map| map.name).collect();
    names.join(", ")
}

impl Colormap {
    /// A colour map of stops: places from 0 to 1, ascending, each with an sRGB colour.
    ///
    /// # Errors
    /// When there are none, or when one does not ascend or lies outside.
    pub fn new(stops: &[(f32, [u8; 3])]) -> Result<Self, ColormapError> {
        if stops.is_empty() {
            return Err(ColormapError::Empty);
        }
        if let Some((at, _)) = stops.iter().find(|(at, _)| !(0.0..=1.0).contains(at)) {
            return Err(ColormapError::Stop(at.to_string()));
        }
        if let Some(pair) = stops.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
            return Err(ColormapError::Order(pair[1].0.to_string()));
        }
        let stops = stops.iter().map(|(at, rgb)| (*at, to_oklab(*rgb)));
        Ok(Self {
            stops: stops.collect(),
        })
    }

    /// The Oklab colour at a place; that of the nearest stop beyond the ends.
    fn at(&self, place: f32) -> [f32; 3] {
        let after = self.stops.partition_point(|(at, _)| *at <= place);
        let (Some(before), after) = (after.checked_sub(1), after) else {
            return self.stops[0].1;
        };
        let (low, from) = self.stops[before];
        let Some(&(high, to)) = self.stops.get(after) else {
            return from;
        };
        mix(from, to, (place - low) / (high - low))
    }
}

fn mix(from: [f32; 3], to: [f32; 3], share: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| from[k] + share * (to[k] - from[k]))
}

impl FromStr for Colormap {
    type Err = ColormapError;

    /// A name of the palette, or stops as `0:#202020,0.5:#aabbcc`.
    fn from_str(text: &str) -> Result<Self, ColormapError> {
        if !text.contains(':') {
            return find(text).map(Self::from_named);
        }
        let stop = |stop: &str| {
            let wrong = || ColormapError::Stop(stop.trim().to_owned());
            let (at, color) = stop.split_once(':').ok_or_else(wrong)?;
            let at = at.trim().parse().map_err(|_| wrong())?;
            Ok((at, parse_color(color)?))
        };
        let stops: Result<Vec<_>, ColormapError> = text.split(',').map(stop).collect();
        Self::new(&stops?)
    }
}

impl Colormap {
    fn from_named(map: &super::NamedColormap) -> Self {
        let stops = map.stops.iter().map(|(at, rgb)| (*at, to_oklab(*rgb)));
        Self {
            stops: stops.collect(),
        }
    }
}

/// An sRGB colour from `#rrggbb`.
///
/// # Errors
/// [`ColormapError::Color`] for anything else.
pub fn parse_color(text: &str) -> Result<[u8; 3], ColormapError> {
    let wrong = || ColormapError::Color(text.trim().to_owned());
    let digits = text.trim().strip_prefix('#').ok_or_else(wrong)?;
    let hexadecimal = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    let number = u32::from_str_radix(digits, 16).map_err(|_| wrong())?;
    let [_, r, g, b] = number.to_be_bytes();
    hexadecimal.then_some([r, g, b]).ok_or_else(wrong)
}

/// The dark line at the margin of many crustose lichens: hyphae without algae, which run ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prothallus {
    /// How far it reaches in from the outermost elements, in element radii, 0.1 to 200. Holes narrower than 16 radii
    /// have none.
    pub width: f32,
    /// sRGB.
    pub color: [u8; 3],
}

impl Prothallus {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// [`SkinError::Range`] for one that is not.
    pub fn check(&self) -> Result<(), SkinError> {
        let width = as_meant(self.width);
        in_range(("the width of the margin", width, 0.1, 200.0, "r"))
    }
}

/// How a skin is coloured.
#[derive(Clone, Debug, PartialEq)]
pub struct Paint {
    /// The colours by local [density](crate::morphometry::density()), of which closed lichen has 0.5 to 0.75.
    pub colormap: Colormap,
    /// How much darker the oldest part is, as a share of its lightness, 0 to 1.
    pub age_darken: f32,
    /// The dark margin, if there is one.
    pub prothallus: Option<Prothallus>,
    /// The cracks, if there are any.
    pub areoles: Option<Areoles>,
    /// The fruiting bodies, if there are any.
    pub apothecia: Option<Apothecia>,
}

impl From<Colormap> for Paint {
    /// A map and nothing else.
    fn from(colormap: Colormap) -> Self {
        Self {
            colormap,
            age_darken: 0.0,
            prothallus: None,
            areoles: None,
            apothecia: None,
        }
    }
}

impl Default for Paint {
    /// That of the first map of the palette.
    fn default() -> Self {
        Self::of(&PALETTE[0])
    }
}

impl Paint {
    /// A map of the palette, with the margin and the structure that such a lichen has.
    pub fn of(map: &super::NamedColormap) -> Self {
        Self {
            prothallus: map.prothallus,
            areoles: map.areoles,
            apothecia: map.apothecia,
            ..Colormap::from_named(map).into()
        }
    }

    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// [`SkinError::Range`] for the first that is not.
    pub fn check(&self) -> Result<(), SkinError> {
        let darken = as_meant(self.age_darken);
        in_range(("the darkening by age", darken, 0.0, 1.0, ""))?;
        self.prothallus.as_ref().map_or(Ok(()), Prothallus::check)?;
        self.areoles.as_ref().map_or(Ok(()), Areoles::check)?;
        self.apothecia.as_ref().map_or(Ok(()), Apothecia::check)
    }

    /// Whether it has any structure.
    pub(super) fn is_structured(&self) -> bool {
        self.areoles.is_some() || self.apothecia.is_some()
    }

    /// sRGB at a density, an age from 0 for the first born to 1 for the last, and a distance from
    /// the lichen's outline in element radii; without areoles and apothecia.
    pub fn color(&self, density: f32, age: f32, outline: f32) -> [u8; 3] {
        self.light(density, age, outline).map(to_byte)
    }

    /// The same as linear light.
    pub(super) fn light(&self, density: f32, age: f32, outline: f32) -> [f32; 3] {
        let mut lab = self.colormap.at(density);
        let darker = 1.0 - self.age_darken * (1.0 - age.clamp(0.0, 1.0));
        lab = lab.map(|x| x * darker);
        if let Some(Prothallus { width, color }) = self.prothallus {
            lab = mix(
                lab,
                to_oklab(color),
                margin(outline / width.max(f32::MIN_POSITIVE)),
            );
        }
        from_oklab(lab)
    }
}

/// 1 at the outline, 0 from one width on.
fn margin(widths: f32) -> f32 {
    let t = (2.0 * (1.0 - widths)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paint(colormap: &str) -> Paint {
        colormap.parse::<Colormap>().unwrap().into()
    }

    #[test]
    fn stops_have_their_colours_and_ends_go_on() {
        let paint = paint("0.25:#102030, 0.5:#aabbcc,1:#ff0000");
        let color = |density| paint.color(density, 1.0, 9.0);
        assert_eq!(color(0.0), [0x10, 0x20, 0x30]);
        assert_eq!(color(0.25), [0x10, 0x20, 0x30]);
        assert_eq!(color(0.5), [0xaa, 0xbb, 0xcc]);
        assert_eq!(color(7.0), [0xff, 0, 0]);
        let between = color(0.375);
        assert!((0..3).all(|k| color(0.25)[k] < between[k] && between[k] < color(0.5)[k]));
    }

    #[test]
    fn paints_of_the_palette_are_in_range_and_none_beyond() {
        for map in PALETTE {
            Paint::of(map).check().expect(map.name);
        }
        let (mut least, mut most) = (structured(), structured());
        number(&mut least, [0.0, 0.1, 3.0, 3.0, 3.0, 1.0, 0.0]);
        number(&mut most, [1.0, 200.0, 1e3, 1e3, 1e4, 1e4, 0.6]);
        assert_eq!([least.check(), most.check()], [Ok(()), Ok(())]);
        for wrong in [f32::NAN, f32::INFINITY, -0.1, 2e4] {
            for k in 0..7 {
                let mut numbers = [0.5, 6.0, 9.0, 10.0, 12.0, 30.0, 0.25];
                numbers[k] = wrong;
                let mut paint = structured();
                number(&mut paint, numbers);
                assert!(paint.check().is_err(), "{numbers:?}");
            }
        }
    }

    fn structured() -> Paint {
        let map = PALETTE.iter().find(|map| map.apothecia.is_some());
        Paint {
            prothallus: Some(Prothallus {
                width: 6.0,
                color: [0; 3],
            }),
            areoles: Some(Areoles {
                width: 9.0,
                color: [0; 3],
            }),
            ..Paint::of(map.expect("a map with apothecia"))
        }
    }

    /// Age, margin, areoles, and width, spacing, begin and margin of apothecia.
    fn number(paint: &mut Paint, [age, margin, areole, width, spacing, from, rim]: [f32; 7]) {
        paint.age_darken = age;
        paint.prothallus.iter_mut().for_each(|p| p.width = margin);
        paint.areoles.iter_mut().for_each(|a| a.width = areole);
        if let Some(own) = &mut paint.apothecia {
            *own = Apothecia {
                width,
                spacing,
                from,
                margin: rim,
                ..*own
            };
        }
    }

    #[test]
    fn a_margin_without_width_is_none_but_at_the_outline() {
        let mut paint = paint("0:#102030,1:#102030");
        let color = [0xff, 0, 0];
        paint.prothallus = Some(Prothallus { width: 0.0, color });
        assert_eq!(paint.color(0.5, 1.0, 0.0), color);
        assert_eq!(paint.color(0.5, 1.0, 0.01), [0x10, 0x20, 0x30]);
    }

    #[test]
    fn every_name_of_the_palette_is_a_map() {
        for map in PALETTE {
            assert_eq!(
                map.name.parse(),
                Ok(Paint::of(map).colormap),
                "{}",
                map.name
            );
            assert_eq!(Colormap::new(map.stops), map.name.parse(), "{}", map.name);
        }
    }

    #[test]
    fn what_is_no_map_is_told_apart() {
        let error = |text: &str| text.parse::<Colormap>().unwrap_err();
        assert!(matches!(error("0:#12345"), ColormapError::Color(_)));
        assert!(matches!(error("0:#+12345"), ColormapError::Color(_)));
        assert!(matches!(error("0:red"), ColormapError::Color(_)));
        assert!(matches!(error("x:#123456"), ColormapError::Stop(_)));
        assert!(matches!(error("1.5:#123456"), ColormapError::Stop(_)));
        assert!(matches!(error("nan:#123456"), ColormapError::Stop(_)));
        assert!(matches!(error("0:#123456,"), ColormapError::Stop(_)));
        assert!(matches!(
            error("0.5:#123456,0.5:#123456"),
            ColormapError::Order(_)
        ));
        assert!(matches!(error("xantoria"), ColormapError::Unknown(_)));
        assert_eq!(Colormap::new(&[]), Err(ColormapError::Empty));
    }

    #[test]
    fn age_darkens_and_the_margin_is_dark() {
        let mut paint = paint("0:#b0b0a0");
        paint.age_darken = 0.5;
        let [old, young] = [0.0, 1.0].map(|age| paint.color(0.5, age, 9.0));
        assert_eq!(young, [0xb0, 0xb0, 0xa0]);
        assert!(old[0] < young[0] / 2 + 10);
        paint.prothallus = Some(Prothallus {
            width: 4.0,
            color: [16, 16, 16],
        });
        assert_eq!(paint.color(0.5, 1.0, 0.0), [16, 16, 16]);
        assert_eq!(paint.color(0.5, 1.0, 4.0), young);
    }
}
