//! How a lichen grows, and how even its front is.

use glam::DVec3;
use serde::Serialize;

use super::dimension::{Scales, is_one_colony, prefixes};
use super::fit::{Fit, Scaling};
use super::mass::Metric;
use super::profile::profile;
use crate::morphometry::Sample;

/// The growing front, and what is behind it. Distances are through space, but for the profile.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Front {
    /// R_e of the first n elements: the distance from their centroid to the farthest of them. The
    /// exponent β of R_e ∝ n^β is 1/2 where a disc fills, 1/D for a fractal, and less where growth
    /// slows. The fit leaves out lichens smaller than the least distance of the fits of dimensions. Of several
    /// colonies, which are far apart from the start, there is none.
    pub growth: Scaling,
    /// How R_e gains with the births; none where there is no fit.
    pub pace: Option<Pace>,
    /// Mean distance from the centroid of the last tenth of the births, the active zone
    /// (M. Plischke and Z. Rácz, *Active zone of growing clusters*, 1984). None of fewer than a
    /// hundred elements.
    pub radius: Option<f64>,
    /// The standard deviation of those distances: how wide the active zone is.
    pub width: Option<f64>,
    /// Share of the surface that elements cover in each of 32 rings of equal width about the seed, the
    /// last of which ends at the farthest element: distance of the ring's middle from the seed along
    /// the surface, in units of the mesh, and area of elements over area of the mesh there. Empty
    /// without a metric that knows the ground (see [`Metric::ring_areas`]), and of a single element.
    pub profile: Vec<[f64; 2]>,
}

/// How R_e gains with the births.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// Each birth adds less than the one before: the exponent is below 1 by more than its error.
    Slowing,
    /// Each adds the same, as far as an error of up to a half tells.
    Constant,
    /// The error is larger than that, and the exponent may be anything near 1.
    Undetermined,
    /// Each adds more.
    Quickening,
}

impl Pace {
    fn of(fit: &Fit) -> Self {
        /// As far from 1 as the exponent of a disc that fills.
        const MOST: f64 = 0.5;
        match fit.slope - 1.0 {
            off if off < -fit.error => Self::Slowing,
            off if off > fit.error => Self::Quickening,
            _ if fit.error > MOST => Self::Undetermined,
            _ => Self::Constant,
        }
    }

    /// Its name in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Slowing => "slowing",
            Self::Constant => "constant",
            Self::Undetermined => "undetermined",
            Self::Quickening => "quickening",
        }
    }
}

impl Front {
    pub(super) fn new(sample: &Sample<'_>, surface: Option<&dyn Metric>) -> Self {
        let distances = Distances::of(sample.positions);
        let active = distances.active_zone();
        let mut growth = growth(sample);
        if !is_one_colony(sample) {
            growth.fit = None;
        }
        Self {
            pace: growth.fit.map(|fit| Pace::of(&fit)),
            growth,
            radius: active.map(|[mean, _]| mean),
            width: active.map(|[_, deviation]| deviation),
            profile: surface.map_or_else(Vec::new, |metric| profile(sample.radius, metric)),
        }
    }

    /// R_e gained with each birth at the end, by the fitted law.
    pub fn rate(&self) -> Option<f64> {
        let last = self.growth.points.last()?;
        self.growth.fit.map(|f| f.slope * f.at(last[0]) / last[0])
    }

    /// Width of the active zone over its radius.
    pub fn roughness(&self) -> Option<f64> {
        Some(self.width? / self.radius?)
    }
}

/// Distances from the centroid, in birth order.
pub(super) struct Distances(Vec<f64>);

impl Distances {
    pub(super) fn of(positions: &[[f64; 3]]) -> Self {
        let points = || positions.iter().map(|&p| DVec3::from(p));
        let centroid = points().sum::<DVec3>() / positions.len() as f64;
        Self(points().map(|p| p.distance(centroid)).collect())
    }

    /// R_e.
    pub(super) fn greatest(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }

    fn active_zone(&self) -> Option<[f64; 2]> {
        const FEWEST: usize = 100;
        let last = &self.0[self.0.len() - self.0.len() / 10..];
        let n = last.len() as f64;
        let mean = last.iter().sum::<f64>() / n;
        let squares: f64 = last.iter().map(|d| (d - mean) * (d - mean)).sum();
        (self.0.len() >= FEWEST).then(|| [mean, (squares / n).sqrt()])
    }
}

fn growth(sample: &Sample<'_>) -> Scaling {
    let radius = |n: usize| Distances::of(&sample.positions[..n]).greatest();
    let counts = prefixes(sample.positions.len());
    let curve: Vec<_> = counts.into_iter().map(|n| [n as f64, radius(n)]).collect();
    Scaling::of_growth(curve, Scales::of(sample).finest())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_leaves_room_for_all_determines_nothing() {
        let pace = |slope, error| {
            let fit = Fit {
                slope,
                error,
                prefactor: 1.0,
                points: 9,
            };
            Pace::of(&fit).word()
        };
        assert_eq!(pace(1.1, 0.2), "constant");
        assert_eq!(pace(1.1, 1.2), "undetermined");
        assert_eq!([pace(0.5, 0.1), pace(2.0, 0.7)], ["slowing", "quickening"]);
    }
}
