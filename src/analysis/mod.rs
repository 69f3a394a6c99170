//! Numbers about a whole lichen that can be compared and published: fractal dimensions, each with
//! the curve, the range and the error of its fit, and what describes a lichen's form: width of the
//! branches, tips, angles, outline, front, growth.
//!
//! [`Analysis::of`] takes a grown cluster, [`analyze`] a lichen as any table of elements has it.
//! Lengths come out in the units of the table, those of the mesh's file. [`Analysis::scalars`] has
//! all single numbers by name. Nothing here reads, writes or prints; the result does not depend on
//! the number of threads.
//!
//! One colony is assumed: of several, mass–radius is the mean over the seeds, fits of dimensions go as far as single
//! colonies do, the size of the first elements (gyration) has no dimension, front and growth are no [`Scalar`]s, and
//! the rest treats them as one lichen. [`Elements::of_colony`] takes one out.

mod boxes;
mod branching;
mod dimension;
mod fit;
mod front;
mod geodesic;
mod ground;
mod mass;
mod outline;
mod plot;
mod profile;
mod ranked;
mod scalar;
mod space;
mod width;

use std::f64::consts::PI;

use serde::Serialize;

pub use branching::Branching;
pub use dimension::{Dimension, FINEST, Method, Through};
pub use fit::{Fit, Scaling};
pub use front::{Front, Pace};
pub use geodesic::SurfaceMetric;
pub use mass::Metric;
pub use outline::Outline;
pub use plot::{PlotError, plot_names, plots};
pub use scalar::{SCALARS, Scalar};
pub use space::Space;
pub use width::{Distribution, Histogram};

pub use crate::morphometry::LOOK;

use crate::cluster::Cluster;
use crate::export::{Elements, LENGTHS};
use crate::morphometry::{Neighbours, Sample, density, is_rim, smooth_normals};
use crate::substrate::Substrate;
use dimension::Scales;
use front::Distances;
use width::branch_widths;

/// Elements that are averaged over, at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Centres {
    /// How many are averaged over with distances through space.
    pub space: usize,
    /// How many are averaged over with distances along the surface, which take longer; 0 to measure none.
    pub surface: usize,
}

impl Default for Centres {
    fn default() -> Self {
        Self {
            space: 1000,
            surface: 100,
        }
    }
}

/// Why a lichen cannot be measured.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// It has no elements.
    #[error("there are no elements to measure")]
    Empty,
    /// Nothing is of this radius, or no squares of it are numbers.
    #[error(
        "a radius of {0:e} cannot be measured: from 1e-150 to 1e150 it can, so take another unit"
    )]
    Radius(f64),
    /// A position is not finite, or no squares of its distances are numbers.
    #[error("element {0} is beyond 1e150, where nothing can be measured: take another unit")]
    Place(usize),
    /// The slices differ in length.
    #[error("there are {0} positions, {1} normals and {2} parents: each element has one of each")]
    Columns(usize, usize, usize),
    /// A normal is no unit vector, by more than a hundredth: which elements are on one sheet goes by it.
    #[error("the normal of element {0} is not of length 1: give unit normals of the surface")]
    Normal(usize),
    /// An element is not born after its parent.
    #[error("the parent of element {0} is not born before it: number elements in order of birth")]
    Parent(usize),
    /// [`Centres::space`] is 0.
    #[error("no element is to be averaged over through space: give at least 1")]
    Centres,
}

/// What was measured on a lichen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Analysis {
    /// Number of elements.
    pub elements: usize,
    /// Number of seeds among them.
    pub colonies: usize,
    /// Element radius r.
    pub radius: f64,
    /// Root of the mean squared distance through space from the centroid.
    pub radius_of_gyration: f64,
    /// R_e: the greatest distance through space from the centroid.
    pub effective_radius: f64,
    /// Area of the elements' discs.
    pub covered_area: f64,
    /// Mean over the elements of the share of the surface within [`LOOK`] radii that elements cover:
    /// see [`density()`].
    pub density: f64,
    /// The edge of the lichen.
    pub outline: Outline,
    /// Width of the branch that each element lies in, twice the distance from the rim at its ridge
    /// and one element more. None where there is no rim, as on a closed surface that is grown over.
    pub branch_width: Option<Distribution>,
    /// Widths of the branches that the elements lie in, in bins of one element's diameter.
    pub branch_widths: Histogram,
    /// Width of the lobe that each element lies in: that of a branch where gaps narrower than [`LOBE`] radii count as
    /// lichen, whatever the pattern inside.
    pub lobe_width: Option<Distribution>,
    /// Tips, angles and orders.
    pub branching: Branching,
    /// Growth and front.
    pub front: Front,
    /// Fractal dimensions.
    pub dimensions: Vec<Dimension>,
}

/// Elements nearer than this many radii, from centre to centre, are of one lobe: gaps of less than 14.2 are
/// closed. With L = 20 r and more, lobes are made of plumes with gaps of up to a dozen radii between them. As [`LOOK`]
/// it lies between distances of a packing.
pub const LOBE: f64 = 16.2;

impl Analysis {
    /// Measures a grown lichen on all of rayon's threads, through space and along the surface, in
    /// the units of the mesh's file.
    ///
    /// The cluster must have grown on this substrate. Of another it may give numbers without meaning.
    ///
    /// # Errors
    /// As [`analyze`].
    ///
    /// # Panics
    /// When an element is in a triangle that the substrate does not have.
    pub fn of(
        substrate: &Substrate,
        cluster: &Cluster,
        centres: Centres,
    ) -> Result<Self, AnalysisError> {
        let places: Vec<_> = cluster.elements().iter().map(|e| e.at).collect();
        let normals = smooth_normals(substrate, &places);
        let mut elements = Elements::of(substrate, cluster);
        elements.normals = normals.iter().map(|n| n.as_vec3().to_array()).collect();
        let metric = SurfaceMetric::new(substrate, &places);
        analyze(&elements.sample(), Some(&metric), centres)
    }

    /// The dimension by a method, if it was measured.
    pub fn dimension(&self, through: Through, method: Method) -> Option<&Dimension> {
        let is = |d: &&Dimension| d.method == method && d.through == through;
        self.dimensions.iter().find(is)
    }
}

/// The fractal dimensions of a lichen, measured on all of rayon's threads: through space by every
/// method, and with a metric of its surface by those that it gives.
///
/// # Errors
/// As [`analyze`].
///
/// # Panics
/// As [`analyze`].
pub fn dimensions(
    sample: &Sample<'_>,
    surface: Option<&dyn Metric>,
    centres: Centres,
) -> Result<Vec<Dimension>, AnalysisError> {
    check(sample, centres)?;
    let rim = is_rim(&neighbours(sample, LOOK));
    Ok(dimensions_among(sample, &rim, surface, centres))
}

/// What every measure takes for granted: without it some would not end.
fn check(sample: &Sample<'_>, centres: Centres) -> Result<(), AnalysisError> {
    let radius = sample.radius;
    let columns = sample.columns();
    let [positions, normals, parents] = columns;
    if columns != [positions; 3] {
        return Err(AnalysisError::Columns(positions, normals, parents));
    }
    if positions == 0 {
        return Err(AnalysisError::Empty);
    }
    if !LENGTHS.contains(&radius) {
        return Err(AnalysisError::Radius(radius));
    }
    if centres.space == 0 {
        return Err(AnalysisError::Centres);
    }
    let is_far = |p: &[f64; 3]| !p.iter().all(|x| x.abs() <= *LENGTHS.end());
    if let Some(far) = sample.positions.iter().position(is_far) {
        return Err(AnalysisError::Place(far));
    }
    if let Some(element) = sample.normals.iter().position(|n| !is_unit(n)) {
        return Err(AnalysisError::Normal(element));
    }
    let is_late = |(i, &parent): (usize, &i32)| usize::try_from(parent).is_ok_and(|p| p >= i);
    match sample.parents.iter().enumerate().position(is_late) {
        Some(element) => Err(AnalysisError::Parent(element)),
        None => Ok(()),
    }
}

fn is_unit(normal: &[f32; 3]) -> bool {
    let [x, y, z] = normal.map(f64::from);
    (x * x + y * y + z * z - 1.0).abs() <= 0.02
}

/// The elements about each, within so many radii.
fn neighbours(sample: &Sample<'_>, radii: f64) -> Neighbours {
    Neighbours::new(sample.positions, sample.normals, radii * sample.radius)
}

fn dimensions_among(
    sample: &Sample<'_>,
    rim: &[bool],
    surface: Option<&dyn Metric>,
    centres: Centres,
) -> Vec<Dimension> {
    let scales = Scales::of(sample);
    let mut dimensions = dimension::through_space(sample, rim, &scales, centres.space);
    if let Some(metric) = surface.filter(|_| centres.surface > 0) {
        let along = dimension::along_surface(metric, sample, &scales, centres.surface);
        dimensions.extend(along);
    }
    dimensions
}

/// Measures a lichen on all of rayon's threads; with a metric of its surface, along that too.
///
/// # Errors
/// When there are no elements, the slices differ in length, the radius is not from 1e-150 to 1e150, a position is
/// beyond 1e150, a normal is none, an element is not born after its parent, or no element is to be averaged over
/// through space.
///
/// # Panics
/// When the metric is of fewer elements.
pub fn analyze(
    sample: &Sample<'_>,
    surface: Option<&dyn Metric>,
    centres: Centres,
) -> Result<Analysis, AnalysisError> {
    check(sample, centres)?;
    let n = sample.positions.len();
    let near = neighbours(sample, LOOK);
    let rim = is_rim(&near);
    let dimensions = dimensions_among(sample, &rim, surface, centres);
    let widths = branch_widths(sample.radius, &rim, &near);
    let lobes = neighbours(sample, LOBE);
    let lobe_widths = branch_widths(sample.radius, &is_rim(&lobes), &lobes);
    let known: Vec<f64> = widths.iter().copied().flatten().collect();
    Ok(Analysis {
        elements: n,
        colonies: dimension::seeds(sample).len(),
        radius: sample.radius,
        radius_of_gyration: dimension::radius_of_gyration(sample.positions),
        effective_radius: Distances::of(sample.positions).greatest(),
        covered_area: n as f64 * PI * sample.radius * sample.radius,
        density: density(sample.radius, &near).iter().sum::<f64>() / n as f64,
        outline: Outline::new(&near),
        branch_widths: Histogram::of(&known, 2.0 * sample.radius),
        branch_width: Distribution::of(known),
        lobe_width: Distribution::of(lobe_widths.into_iter().flatten().collect()),
        branching: Branching::new(sample, &near, &widths),
        front: Front::new(sample, surface),
        dimensions,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_are_no_lichen_are_refused() {
        const UP: [f32; 3] = [0.0, 0.0, 1.0];
        let positions = [[0.0; 3], [2.0, 0.0, 0.0]];
        let refused = |normals: &[[f32; 3]], parents: &[i32]| {
            let sample = Sample {
                radius: 1.0,
                positions: &positions,
                normals,
                parents,
            };
            analyze(&sample, None, Centres::default()).err()
        };
        assert_eq!(refused(&[UP; 2], &[-1, 0]), None);
        assert_eq!(refused(&[[0.0, 0.6, 0.8]; 2], &[-1, -1]), None);
        for none in [[0.0; 3], [0.0, 0.0, 2.0], [f32::NAN; 3], [f32::INFINITY; 3]] {
            let normal = refused(&[UP, none], &[-1, 0]);
            assert_eq!(normal, Some(AnalysisError::Normal(1)), "{none:?}");
        }
        for parents in [[-1, 1], [-1, 9], [0, -1]] {
            let late = parents.iter().position(|p| *p >= 0);
            assert_eq!(
                refused(&[UP; 2], &parents),
                late.map(AnalysisError::Parent),
                "{parents:?}"
            );
        }
        let columns = [refused(&[UP], &[-1, 0]), refused(&[UP; 2], &[])];
        assert_eq!(
            columns,
            [(1, 2), (2, 0)]
                .map(|(normals, parents)| Some(AnalysisError::Columns(2, normals, parents)))
        );
    }
}
