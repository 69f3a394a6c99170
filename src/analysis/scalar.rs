//! Every single number of an analysis, by name.

use super::dimension::Method::{Boxes, Correlation, Gyration, MassRadius, Outline, Sandbox};
use super::dimension::Through::{Space, Surface};
use super::dimension::{Dimension, Method, Through};
use super::{Analysis, Distribution, Front};

/// One number that an analysis comes to: a column of a table of many lichens.
#[derive(Clone, Copy, Debug)]
pub struct Scalar {
    /// Its name, which does not change: lower case, digits and underscores.
    pub name: &'static str,
    /// Its unit: `1` for a plain number, `unit` for the unit of length of the elements, `unit^2`,
    /// `degree`, `unit/birth`.
    pub unit: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
    read: fn(&Analysis) -> Option<f64>,
}

impl Scalar {
    /// Its value; none where the lichen has no answer, or is too small for one.
    pub fn of(&self, analysis: &Analysis) -> Option<f64> {
        (self.read)(analysis).filter(|x| x.is_finite())
    }

    /// Whether it is a whole number by its nature.
    pub fn is_count(&self) -> bool {
        ["elements", "tips", "strahler_order"].contains(&self.name)
    }
}

/// Every scalar, in the order of the columns of tables.
#[rustfmt::skip]
pub const SCALARS: &[Scalar] = &[
    Scalar { name: "elements", unit: "1", meaning: "number of elements", read: |a| Some(a.elements as f64) },
    Scalar { name: "radius", unit: "unit", meaning: "element radius r", read: |a| Some(a.radius) },
    Scalar { name: "radius_of_gyration", unit: "unit", meaning: "root of the mean squared distance from the centroid", read: |a| Some(a.radius_of_gyration) },
    Scalar { name: "effective_radius", unit: "unit", meaning: "R_e, the greatest distance from the centroid", read: |a| Some(a.effective_radius) },
    Scalar { name: "covered_area", unit: "unit^2", meaning: "area of all elements' discs, also what stands out over an open border", read: |a| Some(a.covered_area) },
    Scalar { name: "density", unit: "1", meaning: "mean share of the surface within 6.4 r of an element that elements cover, as (1 + n)/40.96 for n neighbours there", read: |a| Some(a.density) },
    Scalar { name: "outline_length", unit: "unit", meaning: "length of the outline, gaps below 4.4 r closed", read: |a| Some(a.outline.length) },
    Scalar { name: "outline_area", unit: "unit^2", meaning: "area of discs of 3.2 r about the elements: more than the lichen by a rim of 2.2 r", read: |a| Some(a.outline.area) },
    Scalar { name: "circularity", unit: "1", meaning: "4 pi area/length^2 of the outline; 1 for a flat disc", read: |a| a.outline.circularity },
    Scalar { name: "branch_width", unit: "unit", meaning: "mean width of branches, by area", read: |a| width(a).map(|w| w.mean) },
    Scalar { name: "branch_width_deviation", unit: "unit", meaning: "standard deviation of the widths", read: |a| width(a)?.spread() },
    Scalar { name: "branch_width_p5", unit: "unit", meaning: "width that 5 % of the area is below", read: |a| width(a).map(|w| w.percentiles[0]) },
    Scalar { name: "branch_width_p50", unit: "unit", meaning: "median width", read: |a| width(a).map(|w| w.percentiles[2]) },
    Scalar { name: "branch_width_p95", unit: "unit", meaning: "width that 95 % of the area is below", read: |a| width(a).map(|w| w.percentiles[4]) },
    Scalar { name: "lobe_width", unit: "unit", meaning: "mean width by area, gaps below 14.2 r closed", read: |a| a.lobe_width.as_ref().map(|w| w.mean) },
    Scalar { name: "tips", unit: "1", meaning: "number of tips", read: |a| Some(a.branching.tips? as f64) },
    Scalar { name: "branching_angle", unit: "degree", meaning: "mean angle at which branches part", read: |a| angle(a).map(|w| w.mean) },
    Scalar { name: "branching_angle_deviation", unit: "degree", meaning: "standard deviation of the angles", read: |a| angle(a)?.spread() },
    Scalar { name: "strahler_order", unit: "1", meaning: "Strahler order of the tree of parents", read: |a| Some(f64::from(a.branching.strahler_order)) },
    Scalar { name: "bifurcation_ratio", unit: "1", meaning: "branches of a Strahler order over those of the next", read: |a| a.branching.bifurcation_ratio },
    Scalar { name: "front_radius", unit: "unit", meaning: "mean distance of the last tenth of the births from the centroid", read: |a| front(a)?.radius },
    Scalar { name: "front_width", unit: "unit", meaning: "standard deviation of those distances", read: |a| front(a)?.width },
    Scalar { name: "roughness", unit: "1", meaning: "front_width / front_radius", read: |a| front(a)?.roughness() },
    Scalar { name: "growth_exponent", unit: "1", meaning: "b of R_e ~ births^b", read: |a| front(a)?.growth.fit.map(|f| f.slope) },
    Scalar { name: "growth_exponent_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| front(a)?.growth.fit.map(|f| f.error) },
    Scalar { name: "growth_rate", unit: "unit/birth", meaning: "R_e gained with a birth at the end", read: |a| front(a)?.rate() },
    Scalar { name: "dimension_mass_radius", unit: "1", meaning: "fractal dimension by mass-radius, through space", read: |a| found(a, Space, MassRadius)?.dimension },
    Scalar { name: "dimension_mass_radius_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Space, MassRadius)?.error },
    Scalar { name: "dimension_gyration", unit: "1", meaning: "fractal dimension by radius of gyration, through space", read: |a| found(a, Space, Gyration)?.dimension },
    Scalar { name: "dimension_gyration_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Space, Gyration)?.error },
    Scalar { name: "dimension_sandbox", unit: "1", meaning: "fractal dimension by sandbox, through space", read: |a| found(a, Space, Sandbox)?.dimension },
    Scalar { name: "dimension_sandbox_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Space, Sandbox)?.error },
    Scalar { name: "dimension_correlation", unit: "1", meaning: "fractal dimension by density-density correlation, through space", read: |a| found(a, Space, Correlation)?.dimension },
    Scalar { name: "dimension_correlation_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Space, Correlation)?.error },
    Scalar { name: "dimension_boxes", unit: "1", meaning: "fractal dimension by box counting, through space", read: |a| found(a, Space, Boxes)?.dimension },
    Scalar { name: "dimension_boxes_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Space, Boxes)?.error },
    Scalar { name: "dimension_outline", unit: "1", meaning: "fractal dimension of the outline by box counting, through space", read: |a| found(a, Space, Outline)?.dimension },
    Scalar { name: "dimension_outline_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Space, Outline)?.error },
    Scalar { name: "surface_dimension_mass_radius", unit: "1", meaning: "fractal dimension by mass-radius, along the surface", read: |a| found(a, Surface, MassRadius)?.dimension },
    Scalar { name: "surface_dimension_mass_radius_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Surface, MassRadius)?.error },
    Scalar { name: "surface_dimension_gyration", unit: "1", meaning: "fractal dimension by radius of gyration, along the surface", read: |a| found(a, Surface, Gyration)?.dimension },
    Scalar { name: "surface_dimension_gyration_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Surface, Gyration)?.error },
    Scalar { name: "surface_dimension_sandbox", unit: "1", meaning: "fractal dimension by sandbox, along the surface", read: |a| found(a, Surface, Sandbox)?.dimension },
    Scalar { name: "surface_dimension_sandbox_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Surface, Sandbox)?.error },
    Scalar { name: "surface_dimension_correlation", unit: "1", meaning: "fractal dimension by density-density correlation, along the surface", read: |a| found(a, Surface, Correlation)?.dimension },
    Scalar { name: "surface_dimension_correlation_error", unit: "1", meaning: "its error, at a confidence of two thirds", read: |a| found(a, Surface, Correlation)?.error },
];

fn width(analysis: &Analysis) -> Option<&Distribution> {
    analysis.branch_width.as_ref()
}

fn angle(analysis: &Analysis) -> Option<&Distribution> {
    analysis.branching.angle.as_ref()
}

/// Of several colonies it is none: they are far apart from the start.
fn front(analysis: &Analysis) -> Option<&Front> {
    (analysis.colonies < 2).then_some(&analysis.front)
}

fn found(analysis: &Analysis, through: Through, method: Method) -> Option<&Dimension> {
    analysis.dimension(through, method)
}

impl Analysis {
    /// Every one of [`SCALARS`] with its name, in that order; NaN where there is no answer.
    pub fn scalars(&self) -> Vec<(&'static str, f64)> {
        let value = |s: &Scalar| (s.name, s.of(self).unwrap_or(f64::NAN));
        SCALARS.iter().map(value).collect()
    }
}
