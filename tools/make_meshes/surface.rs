//! A triangle mesh in the making: normals and the passes that even out its triangles.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use rayon::prelude::*;

/// Welded vertices and counter-clockwise triangles seen from outside.
#[derive(Clone)]
pub(crate) struct Surface {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Surface {
    pub(crate) fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.positions[v as usize])
    }

    /// Unit normals at the vertices, each the area-weighted mean of its triangles'.
    pub(crate) fn normals(&self) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for &triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle);
            let area = (b - a).cross(c - a);
            for v in triangle {
                sums[v as usize] += area;
            }
        }
        sums.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.positions.len()];
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                lists[from as usize].push(to);
            }
        }
        lists
    }

    /// A third of the area of the triangles around each vertex, twice over.
    fn vertex_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.positions.len()];
        for &triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle);
            let area = (b - a).cross(c - a).length();
            triangle.into_iter().for_each(|v| areas[v as usize] += area);
        }
        areas
    }

    /// Moves every vertex half way to the mean of its neighbours, weighted by their areas so that triangles grow
    /// alike, then back onto the surface by `project`. Repeated `passes` times.
    pub(crate) fn relax(&mut self, passes: usize, project: impl Fn(DVec3) -> DVec3 + Sync) {
        let neighbours = self.neighbours();
        for _ in 0..passes {
            let areas = self.vertex_areas();
            let old = &self.positions;
            self.positions = (0..old.len())
                .into_par_iter()
                .map(|v| {
                    let ring = || neighbours[v].iter().map(|&w| w as usize);
                    let weight: f64 = ring().map(|w| areas[w]).sum();
                    let mean = ring().map(|w| old[w] * areas[w]).sum::<DVec3>() / weight;
                    project(old[v] + 0.5 * (mean - old[v]))
                })
                .collect();
        }
    }

    /// Flips edges whose opposite angles add up to more than a half turn (Delaunay), where the two triangles are
    /// nearly coplanar. Returns how many were flipped.
    pub(crate) fn flip_edges(&mut self) -> usize {
        let mut sides: HashMap<(u32, u32), usize> = HashMap::new();
        for (t, &[a, b, c]) in self.triangles.iter().enumerate() {
            sides.extend([((a, b), t), ((b, c), t), ((c, a), t)]);
        }
        let mut edges: Vec<(u32, u32)> = sides.keys().copied().filter(|e| e.0 < e.1).collect();
        edges.sort_unstable();
        let mut present: HashSet<(u32, u32)> = edges.iter().copied().collect();
        let mut touched = vec![false; self.triangles.len()];
        let mut flipped = 0;
        for (a, b) in edges {
            let (left, right) = (sides[&(a, b)], sides[&(b, a)]);
            let (c, d) = (
                apex(self.triangles[left], a, b),
                apex(self.triangles[right], a, b),
            );
            let fresh = (c.min(d), c.max(d));
            if touched[left]
                || touched[right]
                || present.contains(&fresh)
                || !self.gains([a, b, c, d])
            {
                continue;
            }
            self.triangles[left] = [c, a, d];
            self.triangles[right] = [d, b, c];
            (touched[left], touched[right]) = (true, true);
            present.remove(&(a, b));
            present.insert(fresh);
            flipped += 1;
        }
        flipped
    }

    /// Whether replacing the edge a–b of the triangles (a, b, c) and (b, a, d) by c–d improves both angles and
    /// bends the surface little.
    fn gains(&self, quad: [u32; 4]) -> bool {
        let [a, b, c, d] = quad.map(|v| self.positions[v as usize]);
        let cot = |at: DVec3| (a - at).dot(b - at) / (a - at).cross(b - at).length();
        let old = [(b - a).cross(c - a), (a - b).cross(d - b)].map(DVec3::normalize_or_zero);
        let new = [(a - c).cross(d - c), (b - d).cross(c - d)].map(DVec3::normalize_or_zero);
        let flat = new[0].dot(new[1]) > 0.9_f64.min(old[0].dot(old[1]) - 0.05);
        flat && old[0].dot(new[0]) > 0.5 && old[1].dot(new[1]) > 0.5 && cot(c) + cot(d) < -1e-3
    }

    /// Moves the body so that it stands on y = 0 with its bounding box centred on the y axis.
    pub(crate) fn set_down(&mut self) {
        let (low, high) = self.bounds();
        let centre = (low + high) * 0.5;
        let shift = DVec3::new(centre.x, low.y, centre.z);
        self.positions.iter_mut().for_each(|p| *p -= shift);
    }

    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        let infinity = DVec3::splat(f64::INFINITY);
        self.positions
            .iter()
            .fold((infinity, -infinity), |(low, high), &p| {
                (low.min(p), high.max(p))
            })
    }

    /// Rounds every coordinate to what the file will hold.
    pub(crate) fn round(&mut self, to_file: impl Fn(f64) -> f64) {
        for p in &mut self.positions {
            // Adding zero turns -0.0 into 0.0: one spelling of each coordinate.
            *p = DVec3::from_array(p.to_array().map(|x| to_file(x) + 0.0));
        }
    }
}

fn apex(triangle: [u32; 3], a: u32, b: u32) -> u32 {
    triangle
        .into_iter()
        .find(|&v| v != a && v != b)
        .unwrap_or(a)
}
