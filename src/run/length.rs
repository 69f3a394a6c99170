//! Lengths as the user writes them, before there is a mesh to measure them by.

use std::fmt;
use std::str::FromStr;

use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::substrate::AUTO_RADII_PER_DIAGONAL;

/// A length, absolute or relative.
///
/// As text: `0.02` (mesh units), `10r` (element radii), `0.5%` (of the bounding box's diagonal)
/// or `auto`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// In the mesh file's units.
    Units(f64),
    /// In element radii.
    Radii(f64),
    /// In hundredths of the bounding box's diagonal.
    Percent(f64),
    /// The diagonal over [`AUTO_RADII_PER_DIAGONAL`].
    Auto,
}

/// A text that is no length.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{text}' is not a length{hint}; write a number in mesh units (0.02), in element radii (10r) \
     or in percent of the bounding box's diagonal (0.5%)"
)]
pub struct LengthError {
    text: String,
    hint: &'static str,
}

impl Length {
    /// The length in mesh units, given the bounding box's diagonal and the element radius in them.
    pub fn in_units(self, diagonal: f64, radius: f64) -> f64 {
        match self {
            Self::Units(length) => length,
            Self::Radii(radii) => radii * radius,
            Self::Percent(percent) => percent / 100.0 * diagonal,
            Self::Auto => diagonal / AUTO_RADII_PER_DIAGONAL,
        }
    }

    /// Reads a length that is not `auto`, as only the radius of elements can be.
    ///
    /// # Errors
    /// When the text is none.
    pub fn given(text: &str) -> Result<Self, LengthError> {
        match text.parse()? {
            Self::Auto => Err(LengthError {
                text: text.to_owned(),
                hint: " here (only the radius of elements can be auto)",
            }),
            length => Ok(length),
        }
    }

    /// The length in element radii; as it is, where it was given in them.
    pub fn in_radii(self, diagonal: f64, radius: f64) -> f64 {
        match self {
            Self::Radii(radii) => radii,
            other => other.in_units(diagonal, radius) / radius,
        }
    }
}

impl FromStr for Length {
    type Err = LengthError;

    fn from_str(text: &str) -> Result<Self, LengthError> {
        let text = text.trim();
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let (number, unit): (_, fn(f64) -> Self) = match text.chars().last() {
            Some('r') => (&text[..text.len() - 1], Self::Radii),
            Some('%') => (&text[..text.len() - 1], Self::Percent),
            _ => (text, Self::Units),
        };
        match number.trim_end().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(unit(value)),
            _ => Err(LengthError {
                text: text.to_owned(),
                hint: hint(text),
            }),
        }
    }
}

/// What was probably meant.
fn hint(text: &str) -> &'static str {
    let named = text.starts_with(|c: char| c.is_ascii_digit())
        && text.ends_with(|c: char| c.is_ascii_alphabetic());
    match text {
        _ if text.contains(',') => " (decimals take a point)",
        _ if named => " (mesh units have no name)",
        _ => "",
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Units(length) => write!(f, "{length:?}"),
            Self::Radii(radii) => write!(f, "{radii:?}r"),
            Self::Percent(percent) => write!(f, "{percent:?}%"),
            Self::Auto => f.write_str("auto"),
        }
    }
}

impl Serialize for Length {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Units(length) => serializer.serialize_f64(*length),
            _ => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Length {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(LengthVisitor)
    }
}

struct LengthVisitor;

impl Visitor<'_> for LengthVisitor {
    type Value = Length;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a length: a number, \"10r\", \"0.5%\" or \"auto\"")
    }

    fn visit_f64<E: de::Error>(self, length: f64) -> Result<Length, E> {
        match length.is_finite() {
            true => Ok(Length::Units(length)),
            false => Err(E::invalid_value(de::Unexpected::Float(length), &self)),
        }
    }

    fn visit_i64<E: de::Error>(self, length: i64) -> Result<Length, E> {
        Ok(Length::Units(length as f64))
    }

    fn visit_u64<E: de::Error>(self, length: u64) -> Result<Length, E> {
        Ok(Length::Units(length as f64))
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Length, E> {
        text.parse().map_err(E::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_notation_is_read() {
        let read = |text: &str| text.parse::<Length>().unwrap();
        assert_eq!(read("0.02"), Length::Units(0.02));
        assert_eq!(read("1e-3"), Length::Units(1e-3));
        assert_eq!(read("10r"), Length::Radii(10.0));
        assert_eq!(read(" 2.5 r "), Length::Radii(2.5));
        assert_eq!(read("0.5%"), Length::Percent(0.5));
        assert_eq!(read("auto"), Length::Auto);
        assert_eq!(Length::given("2r"), Ok(Length::Radii(2.0)));
        let refused = Length::given("auto").unwrap_err().to_string();
        assert!(refused.contains("only the radius"), "{refused}");
    }

    #[test]
    fn notations_mean_what_they_say() {
        let units = |text: &str| text.parse::<Length>().unwrap().in_units(200.0, 0.5);
        assert_eq!(units("3"), 3.0);
        assert_eq!(units("10r"), 5.0);
        assert_eq!(units("0.5%"), 1.0);
        assert_eq!(units("auto"), 0.1);
    }

    #[test]
    fn what_is_no_length_is_refused_with_a_hint() {
        for text in [
            "",
            "r",
            "%",
            "nan",
            "inf",
            "1e999",
            "10 cows",
            "--",
            "automatic",
            "1%r",
        ] {
            assert!(text.parse::<Length>().is_err(), "{text:?}");
        }
        let message = |text: &str| text.parse::<Length>().unwrap_err().to_string();
        assert!(message("0,5").contains("decimals take a point"));
        assert!(message("10mm").contains("mesh units have no name"));
        assert!(message("10é").contains("is not a length"));
    }

    proptest! {
        #[test]
        fn text_round_trips(value in proptest::num::f64::NORMAL, kind in 0..3) {
            let length = [Length::Units, Length::Radii, Length::Percent][kind as usize](value);
            prop_assert_eq!(length.to_string().parse::<Length>().unwrap(), length);
        }

        #[test]
        fn no_text_panics(text in "\\PC{0,12}") {
            let _ = text.parse::<Length>();
        }
    }
}
