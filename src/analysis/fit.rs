//! Power laws fitted to measured curves.

use serde::Serialize;

/// A measured curve and the power law y ∝ x^slope in the range where one may hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scaling {
    /// The curve: x ascending, both positive.
    pub points: Vec<[f64; 2]>,
    /// d ln y / d ln x at each point but the first and the last, from its two neighbours.
    pub local_slopes: Vec<[f64; 2]>,
    /// The least and the greatest x that the rule of the method lets into the fit; none of a curve without points.
    pub range: Option<[f64; 2]>,
    /// The line fitted in the range; none where that has fewer than five points, or the curve is flat in x.
    pub fit: Option<Fit>,
}

/// A straight line through the logarithms, by least squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Exponent of x.
    pub slope: f64,
    /// How far it may be from the slope of an endless curve, at a confidence of two thirds: the sum of
    /// two numbers. The first is how far the slopes over all runs of half of the points, rounded down, lie
    /// from it, root mean square. The second is what the curve still lacks at the end of its range, if the
    /// difference between the slopes over its two halves is the work of a correction to scaling that
    /// falls as the root of the length, from either end. The interval holds the true slope at least two
    /// times in three, for any size of such a correction and correlations between neighbouring points
    /// up to 0.8.
    pub error: f64,
    /// y at x = 1.
    pub prefactor: f64,
    /// How many points were fitted.
    pub points: usize,
}

/// The fewest points that a line is laid through: a factor of 4 in x, in steps of √2.
const FEWEST: usize = 5;

/// Room for the round-off of a bound, as a share of it.
const SLACK: f64 = 1e-9;

impl Scaling {
    /// A power law fitted to a curve over lengths, within these bounds. Points that are not positive are left out.
    pub fn new(points: impl IntoIterator<Item = [f64; 2]>, range: [f64; 2]) -> Self {
        Self::over(points, range, 0)
    }

    /// Of a curve whose x or y is the length.
    fn over(points: impl IntoIterator<Item = [f64; 2]>, range: [f64; 2], length: usize) -> Self {
        let positive = |p: &[f64; 2]| p.iter().all(|&c| c > 0.0 && c.is_finite());
        let points: Vec<_> = points.into_iter().filter(positive).collect();
        let within =
            |p: &&[f64; 2]| p[0] >= range[0] * (1.0 - SLACK) && p[0] <= range[1] * (1.0 + SLACK);
        let fitted: Vec<_> = points.iter().filter(within).map(logarithms).collect();
        let lengths = match (fitted.first(), fitted.last()) {
            (Some(first), Some(last)) => (last[length] - first[length]).abs(),
            _ => 0.0,
        };
        let local = |w: &[[f64; 2]]| {
            let [a, b] = [w[0], w[2]].map(|p| logarithms(&p));
            [w[1][0], (b[1] - a[1]) / (b[0] - a[0])]
        };
        Self {
            local_slopes: points.windows(3).map(local).collect(),
            fit: fit(&fitted, lengths),
            range: (!points.is_empty()).then_some(range),
            points,
        }
    }

    /// Of the size of the first x elements. The fit leaves out the x whose size is below `finest`,
    /// and those before them.
    pub(super) fn of_growth(curve: impl IntoIterator<Item = [f64; 2]>, finest: f64) -> Self {
        let curve: Vec<_> = curve.into_iter().collect();
        let small = curve.iter().rposition(|p| p[1] < finest);
        let all = curve.last().map_or(0.0, |p| p[0]);
        let first = curve.get(small.map_or(0, |i| i + 1));
        let lowest = first.map_or(all, |p| p[0]);
        Self::over(curve, [lowest, all], 1)
    }
}

impl Fit {
    /// The law's value at x.
    pub fn at(&self, x: f64) -> f64 {
        self.prefactor * libm::pow(x, self.slope)
    }
}

fn logarithms([x, y]: &[f64; 2]) -> [f64; 2] {
    [libm::log(*x), libm::log(*y)]
}

/// `lengths` is the logarithm of the greatest length over the least.
fn fit(points: &[[f64; 2]], lengths: f64) -> Option<Fit> {
    if points.len() < FEWEST {
        return None;
    }
    let (slope, level) = line(points)?;
    let part = points.len() / 2;
    let parts: Vec<f64> = points.windows(part).filter_map(line).map(|l| l.0).collect();
    let squares: f64 = parts
        .iter()
        .map(|part| (part - slope) * (part - slope))
        .sum();
    let scatter = (squares / parts.len() as f64).sqrt();
    let change = (parts.last()? - parts.first()?).abs();
    let rest = match change {
        0.0 => 0.0,
        change => change * remainder(lengths),
    };
    Some(Fit {
        slope,
        error: scatter + rest,
        prefactor: libm::exp(level),
        points: points.len(),
    })
}

/// How far the slope over a range is from its limit, in differences between the slopes over the
/// range's halves: (1 + q) / (2 (1 − q)), where the correction to the slope falls by q over half
/// of the range (L. F. Richardson's deferred approach to the limit, 1927).
///
/// The correction is taken to fall as length^(−1/2). That of an edge falls as the length, from the
/// other end of the range, that of an element's size as fast or faster, and that of diffusion-limited
/// aggregation as N^−0.3, the root of the radius (E. Somfai, L. M. Sander and R. C. Ball, *Scaling and
/// crossovers in diffusion limited aggregation*, 1999): who falls faster lacks less.
fn remainder(lengths: f64) -> f64 {
    const EXPONENT: f64 = 0.5;
    let q = libm::exp(-0.5 * EXPONENT * lengths);
    (1.0 + q) / (2.0 * (1.0 - q))
}

/// Slope, and y at x = 0, of the line of least squares.
pub(super) fn line(points: &[[f64; 2]]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    let square: f64 = points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum();
    let product: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    (square > 0.0).then(|| (product / square, y - product / square * x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    fn ladder(n: i32) -> impl Iterator<Item = f64> {
        (0..n).map(|k| 2f64.powf(0.5 * f64::from(k)))
    }

    #[test]
    fn a_power_law_is_found_without_error() {
        let scaling = Scaling::new(ladder(12).map(|x| [x, 3.0 * x.powf(1.71)]), [2.0, 16.0]);
        let fit = scaling.fit.unwrap();
        assert!((fit.slope - 1.71).abs() < 1e-12 && fit.error < 1e-12);
        assert!((fit.at(5.0) - 3.0 * 5f64.powf(1.71)).abs() < 1e-9);
        assert_eq!((fit.points, scaling.local_slopes.len()), (7, 10));
        assert!(
            scaling
                .local_slopes
                .iter()
                .all(|s| (s[1] - 1.71).abs() < 1e-9)
        );
    }

    /// Slope 1 below and 2 above x = 4: the parts differ, and the error says so.
    #[test]
    fn a_bend_shows_in_the_error_and_the_local_slopes() {
        let bent = |x: f64| [x, if x < 4.0 { 4.0 * x } else { x * x }];
        let scaling = Scaling::new(ladder(9).map(bent), [1.0, 16.0]);
        let fit = scaling.fit.unwrap();
        assert!((1.3..1.7).contains(&fit.slope), "{fit:?}");
        assert!((0.8..2.0).contains(&fit.error), "{fit:?}");
        assert!((scaling.local_slopes[0][1] - 1.0).abs() < 1e-9);
        assert!((scaling.local_slopes[6][1] - 2.0).abs() < 1e-9);
    }

    /// A slope that is D + c x^−θ, or D + c x^θ: the error reaches to D, from wherever the range
    /// begins, when θ is 1/2 or more.
    #[test]
    fn the_limit_of_a_corrected_law_is_within_the_error() {
        for exponent in [0.5, 0.8, 1.0, 2.0, -0.5, -1.0, -2.0] {
            for points in [5, 6, 7, 9, 14] {
                for c in [-0.2, 0.05] {
                    let law =
                        |x: f64| [x, x.powf(1.71) * (-c / exponent * x.powf(-exponent)).exp()];
                    let scaling = Scaling::new(ladder(points).map(law), [1.0, f64::MAX]);
                    let far = 1f64.max(f64::from(points - 1).exp2().powf(-0.5 * exponent));
                    let fit = scaling.fit.unwrap();
                    let off = (fit.slope - 1.71).abs();
                    assert!(off <= fit.error, "{exponent} {points} {c} {off} {fit:?}");
                    assert!(
                        fit.error < 2.1 * c.abs() * far,
                        "{exponent} {points} {fit:?}"
                    );
                }
            }
        }
    }

    /// A number of mean 0 and variance 1 (Irwin and Hall's sum of twelve).
    fn normal(stream: &mut Stream) -> f64 {
        (0..12).map(|_| stream.uniform()).sum::<f64>() - 6.0
    }

    /// y = x^1.71 with a correction to the slope of `rest` x^(−1/2), and chance of this deviation, of
    /// which a point shares so much with the one before.
    fn law_with_chance(points: i32, rest: f64, shared: f64, stream: &mut Stream) -> Vec<[f64; 2]> {
        const DEVIATION: f64 = 0.05;
        let mut chance = normal(stream);
        let point = |x: f64| {
            let law = 1.71 * x.ln() - 2.0 * rest * x.powf(-0.5);
            let found = [x, (law + DEVIATION * chance).exp()];
            chance = shared * chance + (1.0 - shared * shared).sqrt() * normal(stream);
            found
        };
        ladder(points).map(point).collect()
    }

    /// Two of three errors reach to the truth. A count of 3,000 below that by 3.1 standard deviations
    /// comes once in a thousand times, where the confidence is at its least.
    #[test]
    fn errors_have_the_confidence_that_they_state() {
        const CURVES: u64 = 3000;
        let least = CURVES as f64 * 2.0 / 3.0 - 3.1 * (CURVES as f64 * 2.0 / 9.0).sqrt();
        for (points, rest, shared) in [5, 6, 8, 10, 18].into_iter().flat_map(|points| {
            let rests = [0.0, -0.03, -0.1, -0.3, -1.0].into_iter();
            rests.flat_map(move |rest| [0.0, 0.5, 0.8].map(|shared| (points, rest, shared)))
        }) {
            let reaches = |curve: &u64| {
                let mut stream = Stream::new(*curve, Purpose::Walker, 0);
                let law = law_with_chance(points, rest, shared, &mut stream);
                let fit = Scaling::new(law, [1.0, f64::MAX]).fit.unwrap();
                (fit.slope - 1.71).abs() <= fit.error
            };
            let found = (0..CURVES).filter(reaches).count();
            assert!(
                found as f64 >= least,
                "{points} {rest} {shared}: {found} of {CURVES}"
            );
        }
    }

    /// The same law with x and y exchanged: x counts, y is the length.
    #[test]
    fn the_error_of_growth_goes_by_the_size() {
        let law = |x: f64| [x, x.powf(1.71) * (0.4 * x.powf(-0.5)).exp()];
        let curve: Vec<_> = ladder(12).map(law).collect();
        let turned = curve.iter().map(|[x, y]| [*y, *x]);
        let fit = Scaling::of_growth(turned, 0.5).fit.unwrap();
        let off = (1.0 / fit.slope - 1.71).abs();
        assert!(off <= fit.error / (fit.slope * fit.slope), "{off} {fit:?}");
    }

    /// Nothing grows: the law is level, and exact.
    #[test]
    fn a_level_curve_has_no_error() {
        let fit = Scaling::of_growth(ladder(9).map(|x| [x, 1.0]), 0.5)
            .fit
            .unwrap();
        assert_eq!((fit.slope, fit.error), (0.0, 0.0));
    }

    #[test]
    fn too_short_a_range_has_no_fit() {
        let all = || ladder(9).map(|x| [x, x]);
        assert_eq!(Scaling::new(all(), [1.0, 3.9]).fit.map(|f| f.points), None);
        assert_eq!(
            Scaling::new(all(), [1.0, 4.0]).fit.map(|f| f.points),
            Some(5)
        );
        assert!(Scaling::new([], [1.0, 2.0]).fit.is_none());
        let empty = Scaling::new([[1.0, 0.0]], [1.0, 2.0]);
        assert!(empty.points.is_empty() && empty.range.is_none());
    }
}
