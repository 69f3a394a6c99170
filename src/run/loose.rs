//! Values of a recipe's text that may be written in several ways.

use serde::Deserialize;
use serde::de::Deserializer;

use super::{SeedPlace, SeedTextError, Slope};

/// A value that may also be written as the flag's text, or as a list of its numbers.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a whole number, a text or a list of numbers is needed here"
)]
enum Loose {
    Text(String),
    Whole(i64),
    Large(u64),
    List(Vec<f64>),
}

impl Loose {
    /// As the flag's text.
    fn into_text(self) -> String {
        match self {
            Self::Text(text) => text,
            Self::Whole(number) => number.to_string(),
            Self::Large(number) => number.to_string(),
            Self::List(numbers) => {
                let numbers: Vec<_> = numbers.iter().map(f64::to_string).collect();
                numbers.join(",")
            }
        }
    }
}

fn loose<'de, D, T, E>(from: D, read: impl Fn(&str) -> Result<T, E>) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    E: std::fmt::Display,
{
    let text = Loose::deserialize(from)?.into_text();
    read(&text).map(Some).map_err(serde::de::Error::custom)
}

pub(super) fn seed<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u64>, D::Error> {
    let wrong = |_| "the seed must be a whole number from 0 to 18446744073709551615";
    loose(from, |text| text.parse::<u64>().map_err(wrong))
}

/// An angle, or whatever else a slope is written as.
#[derive(Deserialize)]
#[serde(untagged, expecting = "an angle, or a list of two, is needed here")]
enum LooseSlope {
    Steepest(f64),
    Other(Loose),
}

pub(super) fn slope<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Slope>, D::Error> {
    let text = match LooseSlope::deserialize(from)? {
        LooseSlope::Steepest(angle) => angle.to_string(),
        LooseSlope::Other(other) => other.into_text(),
    };
    text.parse().map(Some).map_err(serde::de::Error::custom)
}

/// One layer of a mask or several.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a path, or a list of paths, is needed here")]
enum LooseLayers {
    One(String),
    Several(Vec<String>),
}

pub(super) fn layers<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec<String>>, D::Error> {
    match LooseLayers::deserialize(from)? {
        LooseLayers::One(layer) => Ok(Some(vec![layer])),
        LooseLayers::Several(layers) if layers.is_empty() => {
            Err(serde::de::Error::custom("an empty list has no mask"))
        }
        LooseLayers::Several(layers) => Ok(Some(layers)),
    }
}

/// One place or several.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a place, or a list of places, is needed here")]
enum LoosePlaces {
    One(Loose),
    Several(Vec<Loose>),
}

pub(super) fn places<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Option<Vec<SeedPlace>>, D::Error> {
    several(from, str::parse)
}

pub(super) fn triangles<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Option<Vec<SeedPlace>>, D::Error> {
    several(from, SeedPlace::from_triangle_text)
}

fn several<'de, D: Deserializer<'de>>(
    from: D,
    read: impl Fn(&str) -> Result<SeedPlace, SeedTextError>,
) -> Result<Option<Vec<SeedPlace>>, D::Error> {
    let all = match LoosePlaces::deserialize(from)? {
        LoosePlaces::One(Loose::List(numbers)) if numbers.is_empty() => {
            return Err(serde::de::Error::custom("an empty list has no place"));
        }
        LoosePlaces::One(place) => vec![place],
        LoosePlaces::Several(places) => places,
    };
    let all = all.into_iter().map(|place| read(&place.into_text()));
    let all: Result<_, SeedTextError> = all.collect();
    all.map(Some).map_err(serde::de::Error::custom)
}
