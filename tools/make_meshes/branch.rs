//! `branch.glb`: a fallen limb from which a smaller branch forks, with furrowed bark and torn ends.

use anyhow::{Result, ensure};
use glam::DVec3;

use crate::crossings::crossings;
use crate::limb::{Bark, Limb, Tear, soft_min};
use crate::nets::{Grid, draw_on};
use crate::surface::Surface;

/// Edge of the grid's cells in metres; it sets the number of triangles.
const CELL: f64 = 0.0056;
/// Width of the fillet where wood grows out of wood.
const COLLAR: f64 = 0.045;

pub(crate) fn branch() -> Result<Surface> {
    let wood = [limb(), fork(), stub()];
    let rough = |p: DVec3, roughness: f64| {
        let fields = wood.iter().map(|l| l.field(p, roughness));
        fields
            .reduce(|a, b| soft_min(a, b, COLLAR))
            .unwrap_or(f64::MAX)
    };
    let field = |p: DVec3| rough(p, 1.0);
    let grid = Grid::covering(
        DVec3::new(-0.52, -0.16, -0.2),
        DVec3::new(0.52, 0.48, 0.3),
        CELL,
    );
    // Splinters thinner than a cell would tie the net in knots: they are drawn out of a calmer surface.
    let mut surface = grid.surface(|p| rough(p, 0.5));
    for _ in 0..5 {
        surface.relax(3, |p| draw_on(field, p, 0.5 * CELL, 1));
        surface.flip_edges();
    }
    surface.relax(2, |p| draw_on(field, p, 0.5 * CELL, 2));
    ensure!(
        crossings(&surface) == 0,
        "the surface passes through itself"
    );
    surface.set_down();
    Ok(surface)
}

fn limb() -> Limb {
    Limb {
        axis: [
            DVec3::new(-0.44, 0.00, 0.03),
            DVec3::new(-0.16, 0.07, -0.05),
            DVec3::new(0.14, -0.05, 0.05),
            DVec3::new(0.44, 0.05, -0.02),
        ],
        radii: [0.098, 0.072],
        bark: Bark {
            depth: 0.0075,
            spacing: 0.034,
        },
        tears: [
            Tear {
                lean: DVec3::new(0.0, -1.0, 0.4),
                tongue: 0.035,
                splinters: 0.022,
            },
            Tear {
                lean: DVec3::new(0.0, 1.0, 0.5),
                tongue: 0.050,
                splinters: 0.026,
            },
        ],
        seed: 100,
    }
}

fn fork() -> Limb {
    Limb {
        axis: [
            DVec3::new(-0.06, 0.01, 0.00),
            DVec3::new(0.01, 0.16, 0.06),
            DVec3::new(0.16, 0.24, 0.13),
            DVec3::new(0.25, 0.40, 0.15),
        ],
        radii: [0.056, 0.036],
        bark: Bark {
            depth: 0.0050,
            spacing: 0.024,
        },
        tears: [
            Tear {
                lean: DVec3::ZERO,
                tongue: 0.0,
                splinters: 0.0,
            },
            Tear {
                lean: DVec3::new(-0.6, 0.0, 0.8),
                tongue: 0.028,
                splinters: 0.012,
            },
        ],
        seed: 200,
    }
}

/// What is left of a twig that snapped off short.
fn stub() -> Limb {
    Limb {
        axis: [
            DVec3::new(0.20, 0.00, 0.02),
            DVec3::new(0.21, 0.02, 0.06),
            DVec3::new(0.22, 0.03, 0.10),
            DVec3::new(0.235, 0.045, 0.145),
        ],
        radii: [0.034, 0.027],
        bark: Bark {
            depth: 0.0035,
            spacing: 0.020,
        },
        tears: [
            Tear {
                lean: DVec3::ZERO,
                tongue: 0.0,
                splinters: 0.0,
            },
            Tear {
                lean: DVec3::new(1.0, -0.3, 0.0),
                tongue: 0.018,
                splinters: 0.008,
            },
        ],
        seed: 300,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::audit;

    #[test]
    fn it_is_one_closed_body_of_fitting_size() {
        let branch = branch().unwrap();
        let found = audit(&branch).unwrap();
        assert!(found.is_closed_body(), "{found:?}");
        assert!((20_000..60_000).contains(&found.triangles), "{found:?}");
    }
}
