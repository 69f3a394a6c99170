//! A number of elements over time, by straight lines.

use std::str::FromStr;

/// Times in any unit, and how many elements there are then.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve(Vec<(f64, Amount)>);

/// A number of elements.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Amount {
    Elements(f64),
    /// Of all of them, 1 for all.
    Share(f64),
}

impl Amount {
    fn of(self, all: usize) -> f64 {
        match self {
            Self::Elements(n) => n,
            Self::Share(share) => share * all as f64,
        }
    }
}

/// A text that is no curve.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// A point that is not a time and a number.
    #[error(
        "{at}'{text}' is not a point of a curve: write a time and a number of elements, or a share of \
         them, as 2.5:4000 or 2.5:40% (in a file 2.5,4000)"
    )]
    Point {
        /// The line of a file, as the start of a sentence.
        at: String,
        /// What is there.
        text: String,
    },
    /// Times that do not ascend.
    #[error("the curve's times must ascend: {0} comes after a later one, or twice")]
    Order(String),
    /// Fewer elements than before.
    #[error("the curve falls at time {0}: a lichen does not shrink")]
    Falls(String),
    /// Elements and shares cannot be held against one another.
    #[error(
        "the curve has numbers of elements and shares: write all points as one of them, but for 0 and 100%"
    )]
    Mixed,
    /// Times that have no length in 64 bits.
    #[error("the curve's times are too far apart: give them in a larger unit")]
    Apart,
    /// Too few points.
    #[error("a curve has at least two points, as 0:0,1:100%, and does not end at 0")]
    Short,
}

impl Curve {
    /// Elements at a share of the time from the curve's first point to its last, of a lichen that has
    /// so many.
    pub(super) fn elements(&self, share: f64, all: usize) -> f64 {
        let count = |amount: Amount| amount.of(all);
        let (start, end) = (self.0[0].0, self.0[self.0.len() - 1].0);
        let time = start + share * (end - start);
        let after = self.0.partition_point(|(t, _)| *t < time);
        let after = after.clamp(1, self.0.len() - 1);
        let [(t0, n0), (t1, n1)] = [self.0[after - 1], self.0[after]];
        let (n0, n1) = (count(n0), count(n1));
        let part = ((time - t0) / (t1 - t0)).clamp(0.0, 1.0);
        // Exact at both ends.
        if part == 1.0 {
            n1
        } else {
            n0 + part * (n1 - n0)
        }
    }

    /// The most elements at any of its points, of a lichen that has so many.
    pub(super) fn most(&self, all: usize) -> f64 {
        let counts = self.0.iter().map(|(_, amount)| amount.of(all));
        counts.fold(0.0, f64::max)
    }

    /// The points of a CSV file: a line a point, a time and a number of elements (or a share with a
    /// percent sign). Empty lines and those that start with `#` do not count, and neither does a first
    /// line of names.
    ///
    /// # Errors
    /// The first line that is no point, and what keeps the points from being a curve.
    pub fn from_csv(text: &str) -> Result<Self, CurveError> {
        let told = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
        let lines = text.lines().enumerate().filter(|(_, line)| told(line));
        let names = |line: &str| line.chars().next().is_some_and(char::is_alphabetic);
        let mut points = Vec::new();
        for (first, (i, line)) in lines.enumerate().map(|(k, line)| (k == 0, line)) {
            if first && names(line.trim()) {
                continue;
            }
            points.push(point(line, ',', &format!("line {}: ", i + 1))?);
        }
        Self::new(points)
    }

    fn new(points: Vec<(f64, Amount)>) -> Result<Self, CurveError> {
        for pair in points.windows(2) {
            let [(before, low), (time, high)] = [pair[0], pair[1]];
            if time <= before {
                return Err(CurveError::Order(time.to_string()));
            }
            let falls = match (low, high) {
                (Amount::Elements(a), Amount::Elements(b))
                | (Amount::Share(a), Amount::Share(b)) => b < a,
                (Amount::Elements(0.0) | Amount::Share(0.0), _) | (_, Amount::Share(1.0)) => false,
                (_, Amount::Elements(0.0) | Amount::Share(0.0)) => true,
                _ => return Err(CurveError::Mixed),
            };
            if falls {
                return Err(CurveError::Falls(time.to_string()));
            }
        }
        let ends_at_nothing = points
            .last()
            .is_none_or(|(_, amount)| matches!(amount, Amount::Elements(0.0) | Amount::Share(0.0)));
        match (points.first(), points.last()) {
            _ if points.len() < 2 || ends_at_nothing => Err(CurveError::Short),
            (Some((from, _)), Some((to, _))) if !(to - from).is_finite() => Err(CurveError::Apart),
            _ => Ok(Self(points)),
        }
    }
}

impl FromStr for Curve {
    type Err = CurveError;

    /// Points as `0:0,2.5:4000,10:100%`.
    fn from_str(text: &str) -> Result<Self, CurveError> {
        let points: Result<Vec<_>, _> = text.split(',').map(|p| point(p, ':', "")).collect();
        Self::new(points?)
    }
}

fn point(text: &str, between: char, at: &str) -> Result<(f64, Amount), CurveError> {
    let read = || {
        let (time, amount) = text.split_once(between)?;
        let time: f64 = time.trim().parse().ok()?;
        let amount = match amount.trim().strip_suffix('%') {
            Some(percent) => Amount::Share(number(percent, 100.0)? / 100.0),
            None => Amount::Elements(number(amount, f64::from(u32::MAX))?),
        };
        time.is_finite().then_some((time, amount))
    };
    read().ok_or_else(|| CurveError::Point {
        at: at.to_owned(),
        text: text.trim().to_owned(),
    })
}

fn number(text: &str, most: f64) -> Option<f64> {
    let number: f64 = text.trim().parse().ok()?;
    (0.0..=most).contains(&number).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_straight_between_their_points() {
        let curve: Curve = "0:0, 2:100, 4:100,10:400".parse().unwrap();
        let at = |time: f64| curve.elements(time / 10.0, 1000);
        assert_eq!(
            [0.0, 1.0, 2.0, 3.0, 4.0, 7.0, 10.0].map(at),
            [0.0, 50.0, 100.0, 100.0, 100.0, 250.0, 400.0]
        );
        let shares: Curve = "0:0,1:25%,2:100%".parse().unwrap();
        assert_eq!(
            [0.0, 0.5, 1.0].map(|s| shares.elements(s, 80)),
            [0.0, 20.0, 80.0]
        );
    }

    #[test]
    fn files_are_read_like_lists() {
        let file = "time,elements\n# slowly at first\n0, 0\n\n2.5,4000\r\n10,100%\n";
        assert_eq!(Curve::from_csv(file), "0:0,2.5:4000,10:100%".parse());
        assert_eq!(
            Curve::from_csv("0,0\n1;5\n"),
            Err(CurveError::Point {
                at: "line 2: ".to_owned(),
                text: "1;5".to_owned(),
            })
        );
    }

    #[test]
    fn what_is_no_curve_is_told_apart() {
        let error = |text: &str| text.parse::<Curve>().unwrap_err();
        for wrong in [
            "",
            "1",
            "0:0,1:-5",
            "0:0,1:101%",
            "0:0,nan:5",
            "0:0,inf:5",
            "0:0,1:nan",
            "0:0,",
        ] {
            assert!(matches!(error(wrong), CurveError::Point { .. }), "{wrong}");
        }
        assert!(matches!(error("0:0,0:5"), CurveError::Order(_)));
        assert!(matches!(error("0:0,2:5,1:7"), CurveError::Order(_)));
        assert!(matches!(error("0:5,1:4"), CurveError::Falls(_)));
        assert!(matches!(error("0:100%,1:0"), CurveError::Falls(_)));
        assert_eq!(error("0:5,1:50%"), CurveError::Mixed);
        assert!("0:0%,1:5".parse::<Curve>().is_ok());
        assert_eq!(error("0:0,1:0"), CurveError::Short);
        assert_eq!(error("0:7"), CurveError::Short);
    }
}
