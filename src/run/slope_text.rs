//! Slopes as the user writes them.

use std::fmt;
use std::str::FromStr;

use super::seed_text::numbers;
use crate::growth::Slope;

/// A text that is no slope.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{0}' is not a slope; write the steepest that lichen grows on, as in 60, or the least steep and the steepest, as in \
     30,90, the second the greater: degrees from 0 for level ground over 90 for a wall to 180 for an underside"
)]
pub struct SlopeTextError(String);

/// As [`FromStr`] reads it.
impl fmt::Display for Slope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.angles();
        write!(f, "{least:?},{most:?}")
    }
}

impl FromStr for Slope {
    type Err = SlopeTextError;

    fn from_str(text: &str) -> Result<Self, SlopeTextError> {
        let most = numbers::<1>(text).map(|[most]| [0.0, most]);
        let angles = most.or_else(|| numbers::<2>(text));
        let slope = angles.and_then(|[least, most]| Self::new(least, most));
        slope.ok_or_else(|| SlopeTextError(text.trim().to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_read_and_written() {
        let read = |text: &str| text.parse::<Slope>();
        assert_eq!(read("60").unwrap().angles(), [0.0, 60.0]);
        assert_eq!(read(" 30, 90.5 ").unwrap().angles(), [30.0, 90.5]);
        assert_eq!(read("0,180").unwrap().to_string(), "0.0,180.0");
        for wrong in [
            "", "0", "-1", "181", "60,30", "60,60", "1,2,3", "nan", "up", "-5,60", "30,inf",
        ] {
            let message = read(wrong).unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("'{wrong}' is not a slope")),
                "{message}"
            );
        }
    }
}
