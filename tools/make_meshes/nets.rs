//! Turns a signed field into triangles: surface nets (Gibson, "Constrained elastic surface nets", 1998) on a regular
//! grid, with one vertex for each sheet of the surface in a cell (Nielson, "Dual marching cubes", 2004), so that sheets
//! that share a cell stay apart.

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

    /// The zero set of `field`, a vertex for each sheet in a cell; normals point to where the field is positive.
    pub(crate) fn surface(&self, field: impl Fn(DVec3) -> f64 + Sync) -> Surface {
        let count = self.nodes.iter().product();
        let values: Vec<f64> = (0..count)
            .into_par_iter()
            .map(|n| field(self.point(self.lattice(n))))
            .collect();
        let mut vertices = HashMap::new();
        let mut surface = Surface {
            positions: Vec::new(),
            triangles: Vec::new(),
        };
        for node in 0..count {
            for axis in 0..3 {
                let Some(quad) = self.crossed_edge(&values, self.lattice(node), axis) else {
                    continue;
                };
                let corners = quad.map(|(cell, edge)| {
                    let sheets = self.sheets(&values, cell);
                    *vertices.entry((cell, sheets[edge])).or_insert_with(|| {
                        surface
                            .positions
                            .push(self.sheet_vertex(&values, cell, &sheets, edge));
                        surface.positions.len() as u32 - 1
                    })
                });
                surface.triangles.extend(halves(corners));
            }
        }
        surface
    }

    /// The four cells around the grid edge from `node` along `axis`, each with that edge's number in it, if the field
    /// changes sign on the edge.
    fn crossed_edge(
        &self,
        values: &[f64],
        node: [usize; 3],
        axis: usize,
    ) -> Option<[([usize; 3], usize); 4]> {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let inside = |n: [usize; 3]| values[self.index(n)] < 0.0;
        let mut far = node;
        far[axis] += 1;
        if far[axis] >= self.nodes[axis]
            || node[u] == 0
            || node[v] == 0
            || inside(node) == inside(far)
        {
            return None;
        }
        let mut quad = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(i, j)| {
            let mut cell = node;
            cell[u] -= i;
            cell[v] -= j;
            (cell, 4 * axis + i + 2 * j)
        });
        if !inside(node) {
            quad.reverse();
        }
        Some(quad)
    }

    /// Numbers the sheets of the surface in a cell: for each of its edges the least edge of the sheet that crosses it.
    /// Crossed edges belong together when the zero set joins them on a face; where it crosses all four edges of a
    /// face, it is taken to cut off the inside corners.
    fn sheets(&self, values: &[f64], cell: [usize; 3]) -> [usize; 12] {
        let inside = CELL_CORNERS
            .map(|[i, j, k]| values[self.index([cell[0] + i, cell[1] + j, cell[2] + k])] < 0.0);
        let mut sheet: [usize; 12] = std::array::from_fn(|edge| edge);
        let mut join = |a: usize, b: usize| {
            let (low, high) = (sheet[a].min(sheet[b]), sheet[a].max(sheet[b]));
            sheet
                .iter_mut()
                .filter(|s| **s == high)
                .for_each(|s| *s = low);
        };
        for face in 0..6 {
            let (edges, corners) = face_cycle(face);
            let crossed = |i: usize| inside[corners[i]] != inside[corners[(i + 1) % 4]];
            let met: Vec<usize> = (0..4).filter(|&i| crossed(i)).collect();
            match met[..] {
                [i, j] => join(edges[i], edges[j]),
                [_, _, _, _] => (0..4)
                    .filter(|&i| inside[corners[i]])
                    .for_each(|i| join(edges[(i + 3) % 4], edges[i])),
                _ => {}
            }
        }
        sheet
    }

    /// The mean of the places where the sheet that crosses `edge` crosses the cell's edges.
    fn sheet_vertex(
        &self,
        values: &[f64],
        cell: [usize; 3],
        sheets: &[usize; 12],
        edge: usize,
    ) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for other in (0..12).filter(|&e| sheets[e] == sheets[edge]) {
            let [near, far] = edge_ends(other).map(|c| {
                let [i, j, k] = CELL_CORNERS[c];
                [cell[0] + i, cell[1] + j, cell[2] + k]
            });
            let (a, b) = (values[self.index(near)], values[self.index(far)]);
            sum += self.point(near).lerp(self.point(far), a / (a - b));
            count += 1.0;
        }
        sum / count
    }
}

/// A cell's corners: corner c has bit a of c as its coordinate along axis a.
const CELL_CORNERS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [1, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [0, 1, 1],
    [1, 1, 1],
];

/// The corners that edge 4·axis + i + 2j joins: i and j are its places along the two axes that follow.
fn edge_ends(edge: usize) -> [usize; 2] {
    let (axis, i, j) = (edge / 4, edge & 1, edge >> 1 & 1);
    let near = i << ((axis + 1) % 3) | j << ((axis + 2) % 3);
    [near, near | 1 << axis]
}

/// The edges and corners around a face, edge i between corners i and i + 1. Face 2·axis + side is square to `axis`.
fn face_cycle(face: usize) -> ([usize; 4], [usize; 4]) {
    let (axis, side) = (face / 2, face % 2);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |i: usize, j: usize| side << axis | i << u | j << v;
    // Along u the axes that follow are v and `axis`; along v they are `axis` and u.
    let along_u = |j: usize| 4 * u + j + 2 * side;
    let along_v = |i: usize| 4 * v + side + 2 * i;
    (
        [along_u(0), along_v(1), along_u(1), along_v(0)],
        [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)],
    )
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
    let gradient = CORNERS
        .iter()
        .zip(values)
        .map(|(&c, v)| c * v)
        .sum::<DVec3>()
        / (4.0 * h);
    (values.iter().sum::<f64>() / 4.0, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::audit;

    #[test]
    fn the_edges_of_a_face_join_its_corners() {
        for face in 0..6 {
            let (edges, corners) = face_cycle(face);
            for i in 0..4 {
                let mut expected = [corners[i], corners[(i + 1) % 4]];
                expected.sort_unstable();
                assert_eq!(edge_ends(edges[i]), expected, "face {face}, edge {i}");
            }
        }
    }

    #[test]
    fn two_balls_in_one_cell_stay_apart() {
        let grid = Grid {
            low: DVec3::ZERO,
            cell: 1.0,
            nodes: [4, 4, 4],
        };
        let (a, b) = (DVec3::splat(1.0), DVec3::new(2.0, 2.0, 1.0));
        let surface = grid.surface(|p| p.distance(a).min(p.distance(b)) - 0.6);
        let found = audit(&surface).unwrap();
        assert_eq!((found.pieces, found.boundary_edges, found.euler), (2, 0, 4));
    }

    #[test]
    fn a_ball_comes_out_closed_round_and_facing_out() {
        let ball = |p: DVec3| p.length() - 1.0;
        let grid = Grid::covering(DVec3::splat(-1.3), DVec3::splat(1.3), 0.11);
        let mut surface = grid.surface(ball);
        surface.relax(5, |p| draw_on(ball, p, 0.05, 2));
        let found = audit(&surface).unwrap();
        assert!(found.is_closed_body(), "{found:?}");
        assert!(
            surface
                .positions
                .iter()
                .all(|p| (p.length() - 1.0).abs() < 1e-4)
        );
        assert!(
            surface
                .normals()
                .iter()
                .zip(&surface.positions)
                .all(|(n, p)| n.dot(*p) > 0.9)
        );
    }
}
