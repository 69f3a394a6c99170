//! Seed places as the user writes them.

use std::fmt;
use std::str::FromStr;

use crate::growth::SeedPlace;

/// A text that is no seed place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SeedTextError {
    /// Neither a name nor a point.
    #[error(
        "'{0}' is not a place; write X,Y,Z in mesh units, a triangle as in 'triangle 12', or one of top, highest, center, \
         random"
    )]
    Place(String),
    /// Not a triangle.
    #[error(
        "'{0}' is not a triangle; write its number in the file, from 0, as in 12 or 12,0.3,0.3"
    )]
    Triangle(String),
    /// Outside the triangle.
    #[error(
        "U,V {0},{1} is outside the triangle; U and V are the weights of its second and third \
         corner: neither below 0, together at most 1"
    )]
    Outside(String, String),
}

impl SeedPlace {
    /// Reads `T` or `T,U,V`.
    ///
    /// # Errors
    /// When the text is neither, or U,V lies outside the triangle.
    pub fn from_triangle_text(text: &str) -> Result<Self, SeedTextError> {
        let fail = || SeedTextError::Triangle(text.trim().to_owned());
        let (number, uv) = match text.split_once(',') {
            Some((number, uv)) => (number, Some(numbers::<2>(uv).ok_or_else(fail)?)),
            None => (text, None),
        };
        let triangle = number.trim().parse().map_err(|_| fail())?;
        Self::in_triangle(triangle, uv)
    }

    /// The place in a triangle of the file.
    ///
    /// # Errors
    /// When U,V lies outside the triangle.
    pub fn in_triangle(triangle: u32, uv: Option<[f64; 2]>) -> Result<Self, SeedTextError> {
        match uv {
            Some([u, v]) if !Self::is_in_triangle([u, v]) => {
                Err(SeedTextError::Outside(u.to_string(), v.to_string()))
            }
            _ => Ok(Self::Triangle { triangle, uv }),
        }
    }
}

/// What a triangle among other places begins with.
const TRIANGLE: &str = "triangle ";

/// As [`FromStr`] reads it.
impl fmt::Display for SeedPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Top => f.write_str("top"),
            Self::Highest => f.write_str("highest"),
            Self::Center => f.write_str("center"),
            Self::Random => f.write_str("random"),
            Self::Point([x, y, z]) => write!(f, "{x:?},{y:?},{z:?}"),
            Self::Triangle { triangle, uv: None } => write!(f, "{TRIANGLE}{triangle}"),
            Self::Triangle {
                triangle,
                uv: Some([u, v]),
            } => write!(f, "{TRIANGLE}{triangle},{u:?},{v:?}"),
        }
    }
}

impl FromStr for SeedPlace {
    type Err = SeedTextError;

    fn from_str(text: &str) -> Result<Self, SeedTextError> {
        match text.trim() {
            "top" => Ok(Self::Top),
            "highest" => Ok(Self::Highest),
            "center" | "centre" => Ok(Self::Center),
            "random" => Ok(Self::Random),
            text if text.starts_with(TRIANGLE) => Self::from_triangle_text(&text[TRIANGLE.len()..]),
            point => match numbers::<3>(point) {
                Some(point) => Ok(Self::Point(point)),
                None => Err(SeedTextError::Place(point.to_owned())),
            },
        }
    }
}

/// Exactly N finite numbers between commas.
pub(super) fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let parsed = text.split(',').map(|part| part.trim().parse::<f64>());
    let numbers: Vec<f64> = parsed.collect::<Result<_, _>>().ok()?;
    let finite = numbers.iter().all(|x| x.is_finite());
    numbers.try_into().ok().filter(|_| finite)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read() {
        let read = |text: &str| text.parse::<SeedPlace>().unwrap();
        assert_eq!(read("-1,2.5, 3e2"), SeedPlace::Point([-1.0, 2.5, 300.0]));
        assert_eq!(read("top"), SeedPlace::Top);
        assert_eq!(read("highest"), SeedPlace::Highest);
        assert_eq!(read("centre"), SeedPlace::Center);
        assert_eq!(read("random"), SeedPlace::Random);
    }

    #[test]
    fn places_are_written_as_they_are_read() {
        for text in [
            "top",
            "highest",
            "center",
            "random",
            "-1.0,2.5,1e300",
            "triangle 12",
            "triangle 0,0.25,0.75",
        ] {
            assert_eq!(text.parse::<SeedPlace>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn triangles_are_read() {
        let read = |text: &str| SeedPlace::from_triangle_text(text).unwrap();
        let at = |triangle, uv| SeedPlace::Triangle { triangle, uv };
        assert_eq!(read("12"), at(12, None));
        assert_eq!(read("0, 0.25,0.75"), at(0, Some([0.25, 0.75])));
    }

    #[test]
    fn what_is_no_place_is_refused() {
        for text in [
            "", "1,2", "1,2,3,4", "1,nan,2", "inf,0,0", "bottom", "1;2;3",
        ] {
            assert!(text.parse::<SeedPlace>().is_err(), "{text:?}");
        }
        for text in [
            "",
            "-1",
            "1.5",
            "1,0.5",
            "1,0.5,0.6",
            "1,-0.1,0",
            "1,nan,0",
            "5000000000",
        ] {
            assert!(SeedPlace::from_triangle_text(text).is_err(), "{text:?}");
        }
    }
}
