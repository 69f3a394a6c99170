//! Colours of a mesh with fewer vertices: each vertex that is left stands for those about it that are not, and has the
//! mean of their light, by area. A picture made smaller is filtered in the same way before it is sampled: else what is
//! narrower than a triangle, as cracks and fruiting discs, is seen as blotches as wide as triangles.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec3, Vec3};

use crate::color::{to_byte, to_linear};
use crate::export::TriMesh;

/// Colours for the vertices that are `left`, which are ascending.
pub(super) fn colors_of(mesh: &TriMesh, left: &[usize]) -> Vec<[u8; 3]> {
    let stands_for = nearest(mesh, left);
    let mut sums = vec![(Vec3::ZERO, 0.0); left.len()];
    for (v, area) in areas(mesh).into_iter().enumerate() {
        if let Some((light, whole)) = sums.get_mut(stands_for[v]) {
            *light += Vec3::from(mesh.colors[v].map(to_linear)) * area;
            *whole += area;
        }
    }
    let color = |(&v, (light, area)): (&usize, (Vec3, f32))| match area > 0.0 {
        true => (light / area).to_array().map(to_byte),
        false => mesh.colors[v],
    };
    left.iter().zip(sums).map(color).collect()
}

/// A third of the triangles about each vertex, as a share of all.
fn areas(mesh: &TriMesh) -> Vec<f32> {
    let mut areas = vec![0.0; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| DVec3::from(mesh.positions[v as usize]));
        let area = (b - a).cross(c - a).length();
        triangle.iter().for_each(|&v| areas[v as usize] += area);
    }
    let whole: f64 = areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let share = |area: f64| (area / whole) as f32;
    areas.into_iter().map(share).collect()
}

/// For each vertex the place in `left` of the nearest of those along edges (Dijkstra 1959, from all of them at once);
/// of two as near the first. Vertices that none of them is joined to have the length of `left`.
fn nearest(mesh: &TriMesh, left: &[usize]) -> Vec<usize> {
    let beside = Beside::new(mesh);
    let mut stands_for = vec![left.len(); mesh.positions.len()];
    // Lengths are not negative, so their bits are in their order.
    let start = |(place, &v): (usize, &usize)| Reverse((0.0f64.to_bits(), place, v));
    let mut queue: BinaryHeap<_> = left.iter().enumerate().map(start).collect();
    while let Some(Reverse((bits, place, v))) = queue.pop() {
        if stands_for[v] < left.len() {
            continue;
        }
        stands_for[v] = place;
        let here = DVec3::from(mesh.positions[v]);
        let free = beside.of(v).iter().map(|&to| to as usize);
        queue.extend(free.filter(|&to| stands_for[to] == left.len()).map(|to| {
            let length = here.distance(DVec3::from(mesh.positions[to]));
            Reverse(((f64::from_bits(bits) + length).to_bits(), place, to))
        }));
    }
    stands_for
}

/// The vertices that follow each vertex in its triangles: in a closed mesh all that it shares an edge with.
struct Beside {
    starts: Vec<usize>,
    vertices: Vec<u32>,
}

impl Beside {
    fn new(mesh: &TriMesh) -> Self {
        let mut starts = vec![0; mesh.positions.len() + 1];
        let corners = mesh.triangles.as_flattened().iter();
        corners.for_each(|&v| starts[v as usize + 1] += 1);
        (1..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        let mut next = starts.clone();
        let mut vertices = vec![0; 3 * mesh.triangles.len()];
        for [a, b, c] in &mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                vertices[next[*from as usize]] = *to;
                next[*from as usize] += 1;
            }
        }
        Self { starts, vertices }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.vertices[self.starts[v]..self.starts[v + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of squares, with an upper and an underside, whose columns of vertices are white and black in turn.
    fn striped(squares: u32) -> TriMesh {
        let columns = 0..=squares;
        let pair = |x: u32| [[f64::from(x), 0.0, 0.0], [f64::from(x), 1.0, 0.0]];
        let shade = |x: u32| [[255 * u8::from(x.is_multiple_of(2)); 3]; 2];
        let square = |x: u32| {
            let [a, b, c, d] = [2 * x, 2 * x + 1, 2 * x + 2, 2 * x + 3];
            [[a, c, b], [b, c, d], [a, b, c], [b, d, c]]
        };
        TriMesh {
            positions: columns.clone().flat_map(pair).collect(),
            colors: columns.flat_map(shade).collect(),
            triangles: (0..squares).flat_map(square).collect(),
            ..TriMesh::default()
        }
    }

    #[test]
    fn a_vertex_has_the_mean_colour_of_what_it_stands_for() {
        let mesh = striped(40);
        let ends = [0, 1, 80, 81];
        for color in colors_of(&mesh, &ends) {
            let light = to_linear(color[0]);
            assert!((light - 0.5).abs() < 0.04, "{light}");
        }
        let all: Vec<usize> = (0..mesh.positions.len()).collect();
        assert_eq!(colors_of(&mesh, &all), mesh.colors);
    }
}
