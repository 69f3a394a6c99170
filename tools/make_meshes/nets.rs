//! Turns a signed field into triangles: naive surface nets (Gibson, "Constrained elastic surface nets", 1998) on a
//! regular grid, then vertices are drawn onto the zero set and evened out.
//!
//! Where the surface enters one cell twice the nets would touch themselves there; the audit refuses such a mesh.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::surface::Surface;

/// A box of cubic cells.
pub(crate) struct Grid {
    pub(crate) low: DVec3,
    pub(crate) cell: f64,
    /// Nodes along each axis.
    pub(crate) nodes: [usize; 3],
}

impl Grid {
    /// The grid of cells of edge `cell` that covers a box.
    pub(crate) fn covering(low: DVec3, high: DVec3, cell: f64) -> Self {
        let nodes = ((high - low) / cell).to_array().map(|n| n as usize + 2);
        Self { low, cell, nodes }
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.nodes[1] + j) * self.nodes[0] + i
    }

    fn lattice(&self, index: usize) -> [usize; 3] {
        let [n, m, _] = self.nodes;
        [index % n, index / n % m, index / (n * m)]
    }

    fn point(&self, lattice: [usize; 3]) -> DVec3 {
        self.low + self.cell * DVec3::from_array(lattice.map(|n| n as f64))
    }

    /// The zero set of `field`, one vertex a cell; normals point to where the field is positive.
    pub(crate) fn surface(&self, field: impl Fn(DVec3) -> f64 + Sync) -> Surface {
        let count = self.nodes.iter().product();
        let values: Vec<f64> = (0..count).into_par_iter().map(|n| field(self.point(self.lattice(n)))).collect();
        let mut vertices = HashMap::new();
        let mut surface = Surface { positions: Vec::new(), triangles: Vec::new() };
        for node in 0..count {
            for axis in 0..3 {
                if let Some(quad) = self.crossed_edge(&values, self.lattice(node), axis) {
                    let corners = quad.map(|cell| {
                        *vertices.entry(cell).or_insert_with(|| {
                            surface.positions.push(self.cell_vertex(&values, cell));
                            surface.positions.len() as u32 - 1
                        })
                    });
                    surface.triangles.extend(halves(corners));
                }
            }
        }
        surface
    }

    /// The four cells around the grid edge from `node` along `axis`, if the field changes sign on it.
    fn crossed_edge(&self, values: &[f64], node: [usize; 3], axis: usize) -> Option<[[usize; 3]; 4]> {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut far = node;
        far[axis] += 1;
        if far[axis] >= self.nodes[axis] || node[u] == 0 || node[v] == 0 {
            return None;
        }
        let inside = [node, far].map(|n| values[self.index(n)] < 0.0);
        if inside[0] == inside[1] {
            return None;
        }
        let mut quad = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(i, j)| {
            let mut cell = node;
            cell[u] -= i;
            cell[v] -= j;
            cell
        });
        if inside[0] {
            quad.reverse();
        }
        quad.reverse();
        Some(quad)
    }

    /// The mean of the places where the field changes sign on the cell's edges.
    fn cell_vertex(&self, values: &[f64], cell: [usize; 3]) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for axis in 0..3 {
            for side in 0..4 {
                let mut near = cell;
                near[(axis + 1) % 3] += side & 1;
                near[(axis + 2) % 3] += side >> 1;
                let mut far = near;
                far[axis] += 1;
                let (a, b) = (values[self.index(near)], values[self.index(far)]);
                if (a < 0.0) != (b < 0.0) {
                    sum += self.point(near).lerp(self.point(far), a / (a - b));
                    count += 1.0;
                }
            }
        }
        sum / count
    }
}

fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// Draws `p` onto the zero set by Newton steps along the gradient, none longer than `reach`.
pub(crate) fn draw_on(field: impl Fn(DVec3) -> f64, p: DVec3, reach: f64, steps: usize) -> DVec3 {
    (0..steps).fold(p, |p, _| {
        let (value, slope) = slope(&field, p, 0.05 * reach);
        let step = slope * (value / slope.length_squared().max(0.25));
        p - step * (reach / step.length()).min(1.0)
    })
}

/// The field and its gradient, from four corners of a tetrahedron.
fn slope(field: impl Fn(DVec3) -> f64, p: DVec3, h: f64) -> (f64, DVec3) {
    const CORNERS: [DVec3; 4] = [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, -1.0, -1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(-1.0, -1.0, 1.0),
    ];
    let values = CORNERS.map(|c| field(p + c * h));
    let gradient = CORNERS.iter().zip(values).map(|(&c, v)| c * v).sum::<DVec3>() / (4.0 * h);
    (values.iter().sum::<f64>() / 4.0, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::audit;

    #[test]
    fn a_ball_comes_out_closed_round_and_facing_out() {
        let ball = |p: DVec3| p.length() - 1.0;
        let grid = Grid::covering(DVec3::splat(-1.3), DVec3::splat(1.3), 0.11);
        let mut surface = grid.surface(ball);
        surface.relax(5, |p| draw_on(ball, p, 0.05, 2));
        let found = audit(&surface).unwrap();
        assert!(found.is_closed_body(), "{found:?}");
        assert!(surface.positions.iter().all(|p| (p.length() - 1.0).abs() < 1e-4));
        assert!(surface.normals().iter().zip(&surface.positions).all(|(n, p)| n.dot(*p) > 0.9));
    }
}
