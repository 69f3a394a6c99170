//! Fractal dimensions, each by the curve that it is read from.
//!
//! Every fit leaves out distances below [`FINEST`] element radii or R_g/32, the greater of the two,
//! where the elements' own size shows, and those that the finite lichen bends; the upper bound is
//! told with each method. R_g is the radius of gyration through space, of several colonies the root of the mean over
//! all elements of the squared distance from the centroid of their own:
//!
//! | method | curve | dimension | upper bound |
//! | --- | --- | --- | --- |
//! | mass–radius | N(ρ) about the seeds | slope | R_g |
//! | gyration | R_g of the first n elements | 1 / slope | none: each is a whole lichen |
//! | sandbox | mean N(ρ) about many elements | slope | R_g/2 |
//! | correlation | mean density in rings about them | 2 + slope = 2 − α | R_g/2 |
//! | boxes | boxes of edge ε that hold a centre | −slope | R_g/4 |
//! | outline | boxes of edge ε that hold a centre on the rim | −slope | R_g/3 |
//!
//! The last is the dimension of the edge and not of the lichen: 1 where that is smooth, and that of the
//! lichen where every branch is edge.
//!
//! The many elements are taken from all of the lichen, evenly in birth order. Those near its middle
//! alone will not do: they stand where the mean density is highest, and rings about them pass the
//! denser middle, so that N(ρ) rises too steeply (plain DLA of 100,000 comes to local slopes of 1.9).
//! Those at the edge see less than the whole, which lowers the slopes near the upper bound.
//!
//! Sources: T. A. Witten and L. M. Sander, *Diffusion-limited aggregation* (1981, 1983) for the
//! first, second and fourth; T. Tél, Á. Fülöp and T. Vicsek, *Determination of fractal dimensions for
//! geometrical multifractals* (1989) for the sandbox.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use serde::Serialize;

use super::boxes::count_boxes;
use super::fit::{Fit, Scaling};
use super::mass::{Metric, distances, ladder, mean_mass};
use super::space::Space;
use crate::morphometry::Sample;

/// The least distance of a fit, in element radii: four diameters. A large lichen leaves out more.
pub const FINEST: f64 = 8.0;

/// The greatest error with which a dimension says anything.
const MOST_ERROR: f64 = 1.0;

/// How a dimension was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Method {
    /// Number of elements within a distance of the seeds.
    MassRadius,
    /// Radius of gyration of the first n; along the surface the root of the mean squared distance
    /// from the seed, which grows by the same law.
    Gyration,
    /// Number of elements within a distance, averaged over centres.
    Sandbox,
    /// Density of elements at a distance, averaged over centres and directions.
    Correlation,
    /// Number of boxes that hold an element.
    Boxes,
    /// Number of boxes that hold an element of the rim, that of holes included: the dimension of the
    /// edge.
    Outline,
}

/// Which way distances were measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Through {
    /// Straight through space.
    Space,
    /// Along the surface.
    Surface,
}

/// A dimension, and everything that it was read from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dimension {
    /// How it was measured.
    pub method: Method,
    /// Which way.
    pub through: Through,
    /// The dimension; none where there is no range to fit, and where its error would be above 1: from a line to a
    /// surface is no more.
    pub dimension: Option<f64>,
    /// Its error, at a confidence of two thirds: see [`Fit::error`](super::Fit::error).
    pub error: Option<f64>,
    /// For [`Method::Correlation`], the exponent α by which density falls with distance, 2 less the
    /// dimension.
    pub alpha: Option<f64>,
    /// The curve. Of [`Method::Gyration`] x counts elements; else x is a length.
    pub scaling: Scaling,
}

impl Dimension {
    fn new(method: Method, through: Through, scaling: Scaling) -> Self {
        let error = |fit: &Fit| fit.error * method.sensitivity(fit.slope);
        let fit = scaling.fit.filter(|fit| error(fit) <= MOST_ERROR);
        let is_correlation = method == Method::Correlation;
        Self {
            method,
            through,
            dimension: fit.map(|fit| method.dimension(fit.slope)),
            error: fit.as_ref().map(error),
            alpha: fit.filter(|_| is_correlation).map(|fit| -fit.slope),
            scaling,
        }
    }

    /// The line that the dimension is read from; none where there is no dimension.
    pub fn fit(&self) -> Option<Fit> {
        self.dimension.and(self.scaling.fit)
    }

    /// The local slopes as dimensions: the curve that is level where there is scaling.
    pub fn local(&self) -> impl Iterator<Item = [f64; 2]> {
        let read = |&[x, slope]: &[f64; 2]| [x, self.method.dimension(slope)];
        self.scaling.local_slopes.iter().map(read)
    }
}

impl Method {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::MassRadius => "mass-radius",
            Self::Gyration => "gyration",
            Self::Sandbox => "sandbox",
            Self::Correlation => "correlation",
            Self::Boxes => "boxes",
            Self::Outline => "outline",
        }
    }

    fn dimension(self, slope: f64) -> f64 {
        match self {
            Self::MassRadius | Self::Sandbox => slope,
            Self::Gyration => 1.0 / slope,
            Self::Correlation => 2.0 + slope,
            Self::Boxes | Self::Outline => -slope,
        }
    }

    /// What an error of the slope is multiplied by.
    fn sensitivity(self, slope: f64) -> f64 {
        match self {
            Self::Gyration => 1.0 / (slope * slope),
            _ => 1.0,
        }
    }
}

/// Lengths that the bounds of the fits are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    pub(super) radius: f64,
    /// Root of the mean squared distance of elements from the centroid of their own colony: how far several are apart
    /// is no size of theirs.
    pub(super) gyration: f64,
}

impl Scales {
    pub(super) fn of(sample: &Sample<'_>) -> Self {
        let colonies = colonies(sample.parents);
        let mut centroids: Vec<(DVec3, f64)> = Vec::new();
        let placed = || std::iter::zip(&colonies, sample.positions);
        for (&colony, &position) in placed() {
            centroids.resize(centroids.len().max(colony + 1), (DVec3::ZERO, 0.0));
            let (sum, n) = &mut centroids[colony];
            (*sum, *n) = (*sum + DVec3::from(position), *n + 1.0);
        }
        let spread = |(&colony, &position): (&usize, &[f64; 3])| {
            let (sum, n) = centroids[colony];
            DVec3::from(position).distance_squared(sum / n)
        };
        let spread: f64 = placed().map(spread).sum();
        Self {
            radius: sample.radius,
            gyration: (spread / sample.positions.len() as f64).sqrt(),
        }
    }

    /// The least distance of a fit.
    pub(super) fn finest(&self) -> f64 {
        const SHARE: f64 = 1.0 / 32.0;
        (FINEST * self.radius).max(SHARE * self.gyration)
    }

    fn range(&self, until: f64) -> [f64; 2] {
        [self.finest(), until]
    }
}

/// All dimensions with distances through space, `centres` elements being averaged over at most.
pub(super) fn through_space(
    sample: &Sample<'_>,
    rim: &[bool],
    scales: &Scales,
    centres: usize,
) -> Vec<Dimension> {
    let space = Space::new(sample.positions);
    let mut dimensions = vec![mass_radius(&space, Through::Space, sample, scales, centres)];
    dimensions.extend(is_one_colony(sample).then(|| gyration(sample, scales)));
    let centres = self::centres(sample.positions.len(), centres);
    dimensions.extend(about_centres(&space, Through::Space, &centres, scales));
    dimensions.extend(by_boxes(sample, rim, scales));
    dimensions
}

/// All dimensions that distances along the surface give.
pub(super) fn along_surface(
    metric: &dyn Metric,
    sample: &Sample<'_>,
    scales: &Scales,
    centres: usize,
) -> Vec<Dimension> {
    let mut dimensions = vec![mass_radius(
        metric,
        Through::Surface,
        sample,
        scales,
        centres,
    )];
    dimensions.extend(is_one_colony(sample).then(|| spread_from_seed(metric, scales)));
    let centres = self::centres(sample.positions.len(), centres);
    dimensions.extend(about_centres(metric, Through::Surface, &centres, scales));
    dimensions
}

/// Root of the mean squared distance from the centroid of all.
pub(super) fn radius_of_gyration(positions: &[[f64; 3]]) -> f64 {
    let n = positions.len() as f64;
    let points = || positions.iter().map(|&p| DVec3::from(p));
    let centroid = points().sum::<DVec3>() / n;
    let spread: f64 = points().map(|p| p.distance_squared(centroid)).sum();
    (spread / n).sqrt()
}

/// The colony of every element, by the order of their seeds.
fn colonies(parents: &[i32]) -> Vec<usize> {
    let (mut seeds, mut colonies) = (0, Vec::with_capacity(parents.len()));
    for &parent in parents {
        let of_parent = usize::try_from(parent).ok().map(|parent| colonies[parent]);
        colonies.push(of_parent.unwrap_or(seeds));
        seeds += usize::from(of_parent.is_none());
    }
    colonies
}

/// The elements that have no parent.
pub(super) fn seeds(sample: &Sample<'_>) -> Vec<usize> {
    let is_seed = |i: &usize| sample.parents[*i] < 0;
    (0..sample.parents.len()).filter(is_seed).collect()
}

/// Whether the first n elements have a size that can grow by a power of n: several colonies are far apart from
/// the start.
pub(super) fn is_one_colony(sample: &Sample<'_>) -> bool {
    seeds(sample).len() < 2
}

/// About all seeds, but no more of them than `most`.
fn mass_radius(
    metric: &dyn Metric,
    through: Through,
    sample: &Sample<'_>,
    scales: &Scales,
    most: usize,
) -> Dimension {
    let radii = distances(scales.radius, 2.0 * scales.gyration);
    let seeds = seeds(sample);
    let seeds: Vec<usize> = centres(seeds.len(), most)
        .into_iter()
        .map(|i| seeds[i])
        .collect();
    let mass = mean_mass(metric, &seeds, &radii);
    let curve = std::iter::zip(radii, mass).map(|(radius, mass)| [radius, mass]);
    let scaling = Scaling::new(curve, scales.range(scales.gyration));
    Dimension::new(Method::MassRadius, through, scaling)
}

/// Elements to average over: every k-th in birth order.
fn centres(all: usize, most: usize) -> Vec<usize> {
    let n = all.min(most);
    (0..n).map(|k| (2 * k + 1) * all / (2 * n)).collect()
}

/// Sandbox and density–density correlation, from the same counts.
fn about_centres(
    metric: &dyn Metric,
    through: Through,
    centres: &[usize],
    scales: &Scales,
) -> [Dimension; 2] {
    let radii = distances(scales.radius, scales.gyration);
    let mass = mean_mass(metric, centres, &radii);
    let range = scales.range(0.5 * scales.gyration);
    let curve: Vec<_> = std::iter::zip(radii, mass).map(|(r, n)| [r, n]).collect();
    let ring = |w: &[[f64; 2]]| {
        let [[inner, less], [outer, more]] = [w[0], w[1]];
        let area = PI * (outer * outer - inner * inner);
        [(inner * outer).sqrt(), (more - less) / area]
    };
    let correlation: Vec<_> = curve.windows(2).map(ring).collect();
    [
        Dimension::new(Method::Sandbox, through, Scaling::new(curve, range)),
        Dimension::new(
            Method::Correlation,
            through,
            Scaling::new(correlation, range),
        ),
    ]
}

/// Of the lichen and of its outline. The rim is that of gaps as wide as neighbours are looked for.
fn by_boxes(sample: &Sample<'_>, rim: &[bool], scales: &Scales) -> [Dimension; 2] {
    let all = upright(sample);
    let rim = std::iter::zip(&all, rim).filter(|(_, is_rim)| **is_rim);
    let rim: Vec<_> = rim.map(|(&p, _)| p).collect();
    let sizes = ladder(2.0 * scales.radius, 2.0 * scales.gyration);
    let dimension = |method, positions: &[_], until: f64| {
        let counts = count_boxes(positions, &sizes);
        let curve = std::iter::zip(&sizes, counts).map(|(&size, n)| [size, n]);
        let scaling = Scaling::new(curve, scales.range(until * scales.gyration));
        Dimension::new(method, Through::Space, scaling)
    };
    [
        dimension(Method::Boxes, &all, 1.0 / 4.0),
        dimension(Method::Outline, &rim, 1.0 / 3.0),
    ]
}

/// The elements' positions, turned so that their mean normal is the third axis: boxes meet a flat
/// lichen squarely however it leans. Of those that a leaning one meets, some are clipped so little
/// that no centre is in them, and the fewer the larger they are.
fn upright(sample: &Sample<'_>) -> Vec<[f64; 3]> {
    let normals = sample.normals.iter().map(|&n| Vec3::from(n).as_dvec3());
    let up = normals.sum::<DVec3>().normalize_or(DVec3::Z);
    let (x, y) = up.any_orthonormal_pair();
    let turned = |&p: &[f64; 3]| [x, y, up].map(|axis| axis.dot(p.into()));
    sample.positions.iter().map(turned).collect()
}

/// Radius of gyration of the first n elements, for n from all down in steps of √2.
fn gyration(sample: &Sample<'_>, scales: &Scales) -> Dimension {
    let of_first = |n: usize| radius_of_gyration(&sample.positions[..n]);
    grown(sample.positions.len(), Through::Space, scales, &of_first)
}

/// Root mean square distance along the surface of the first n elements from the first of them, which is a seed.
fn spread_from_seed(metric: &dyn Metric, scales: &Scales) -> Dimension {
    let distances = metric.distances(0, f64::INFINITY);
    let of_first = |n: usize| {
        let squares = distances[..n].iter().map(|d| d * d);
        (squares.sum::<f64>() / n as f64).sqrt()
    };
    grown(distances.len(), Through::Surface, scales, &of_first)
}

/// The dimension from the size of the first n elements. The fit leaves out the n whose size is
/// below the finest length.
fn grown(
    all: usize,
    through: Through,
    scales: &Scales,
    size_of_first: &dyn Fn(usize) -> f64,
) -> Dimension {
    let size = |n: usize| [n as f64, size_of_first(n)];
    let curve = prefixes(all).into_iter().map(size);
    let scaling = Scaling::of_growth(curve, scales.finest());
    Dimension::new(Method::Gyration, through, scaling)
}

/// Numbers of elements from 2 to all, in steps of √2, ascending.
pub(super) fn prefixes(all: usize) -> Vec<usize> {
    let smaller = |n: &f64| Some(n / std::f64::consts::SQRT_2);
    let counts = std::iter::successors(Some(all as f64), smaller);
    let mut counts: Vec<_> = counts
        .map(|n| (n + 0.5) as usize)
        .take_while(|&n| n >= 2)
        .collect();
    counts.reverse();
    counts.dedup();
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One over a slope of nearly nothing is some number, with an error larger still.
    #[test]
    fn what_may_be_anything_is_no_dimension() {
        let births = || (3..14).map(|k| f64::from(1 << k));
        let dimension = |size: &dyn Fn(f64) -> f64| {
            let scaling = Scaling::of_growth(births().map(|n| [n, size(n)]), 1e-3);
            Dimension::new(Method::Gyration, Through::Space, scaling)
        };
        let lichen = dimension(&|n| n.powf(1.0 / 1.71));
        assert!((lichen.dimension.unwrap() - 1.71).abs() < 1e-9);
        assert!(lichen.error.unwrap() < 1e-9);
        let scattered = dimension(&|n| 1.0 + 0.1 * n.ln().sin());
        let fit = scattered.scaling.fit.unwrap();
        assert!(fit.error / (fit.slope * fit.slope) > 1.0, "{fit:?}");
        assert_eq!((scattered.dimension, scattered.error), (None, None));
        assert_eq!((lichen.fit(), scattered.fit()), (lichen.scaling.fit, None));
    }
}
