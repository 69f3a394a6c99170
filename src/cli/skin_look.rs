//! What a skin was asked to look like, its lengths measured in radii of elements.

use thallus::cluster::Cluster;
use thallus::run::Length;
use thallus::skin::{Paint, Shape};
use thallus::substrate::Substrate;

use super::failure::Failure;
use super::skin_args::{ColorArgs, ReliefArgs, ShapeArgs};
use super::skin_paint::paint;

/// What lengths are measured against, in the mesh's units.
pub(super) struct Measure {
    pub(super) diagonal: f64,
    /// Of an element.
    pub(super) radius: f64,
}

impl Measure {
    pub(super) fn of(substrate: &Substrate, cluster: &Cluster) -> Self {
        let units = substrate.units();
        Self {
            diagonal: units.diagonal(),
            radius: units.length_to_file(cluster.radius()),
        }
    }

    fn in_radii(&self, length: Length) -> f64 {
        length.in_radii(self.diagonal, self.radius)
    }

    /// What the flags say of the lichen's shape.
    pub(super) fn shape(&self, args: &ShapeArgs) -> Result<Shape, Failure> {
        let usual = self.unchecked(&args.relief);
        let resolution = args.resolution.map(|length| self.in_radii(length));
        checked(Shape {
            resolution: resolution.unwrap_or(usual.resolution),
            ..usual
        })
    }

    /// The same at the usual resolution.
    pub(super) fn relief(&self, args: &ReliefArgs) -> Result<Shape, Failure> {
        checked(self.unchecked(args))
    }

    fn unchecked(&self, args: &ReliefArgs) -> Shape {
        let default = Shape::default();
        let or = |length: Option<Length>, default| {
            length.map_or(default, |length| self.in_radii(length))
        };
        Shape {
            thickness: or(args.thickness, default.thickness),
            taper: args.taper.unwrap_or(default.taper),
            falloff: or(args.falloff, default.falloff),
            ..default
        }
    }

    /// What they say of its colours.
    pub(super) fn paint(&self, args: &ColorArgs) -> Result<Paint, Failure> {
        paint(args, &|length| self.in_radii(length))
    }
}

fn checked(shape: Shape) -> Result<Shape, Failure> {
    match shape.check() {
        Ok(()) => Ok(shape),
        Err(problem) => Err(Failure::Usage(problem.into())),
    }
}
