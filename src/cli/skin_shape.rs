//! The shape of a skin that was asked for, its lengths measured in radii of elements.

use thallus::cluster::Cluster;
use thallus::run::Length;
use thallus::skin::Shape;
use thallus::substrate::Substrate;

use super::skin_args::{ReliefArgs, ShapeArgs};

/// A length in radii of elements.
pub(super) type InRadii<'a> = &'a dyn Fn(Length) -> f64;

/// What lengths are measured against, in the mesh's units.
pub(super) struct InUnits {
    diagonal: f64,
    radius: f64,
}

impl InUnits {
    pub(super) fn of(substrate: &Substrate, cluster: &Cluster) -> Self {
        let units = substrate.units();
        Self {
            diagonal: units.diagonal(),
            radius: units.length_to_file(cluster.radius()),
        }
    }

    pub(super) fn in_radii(&self, length: Length) -> f64 {
        length.in_radii(self.diagonal, self.radius)
    }
}

pub(super) fn shape(args: &ShapeArgs, in_radii: InRadii) -> Shape {
    let relief = relief(&args.relief, in_radii);
    Shape {
        resolution: in_radii_or(args.resolution, in_radii, relief.resolution),
        ..relief
    }
}

/// What the flags say of the lichen's shape, at the usual resolution.
pub(super) fn relief(args: &ReliefArgs, in_radii: InRadii) -> Shape {
    let default = Shape::default();
    Shape {
        thickness: in_radii_or(args.thickness, in_radii, default.thickness),
        taper: args.taper.unwrap_or(default.taper),
        falloff: in_radii_or(args.falloff, in_radii, default.falloff),
        ..default
    }
}

fn in_radii_or(length: Option<Length>, in_radii: InRadii, default: f64) -> f64 {
    length.map_or(default, in_radii)
}
