//! `rock.obj`: a smooth river stone of exactly 4,608 triangles, the size of the thesis's rock.

use std::f64::consts::FRAC_PI_2;

use anyhow::Result;
use glam::DVec3;

use crate::audit::check_star;
use crate::noise::{fbm, noise};
use crate::stone::{Face, Stone};
use crate::surface::Surface;

/// Edges of the octahedron are cut into this many parts: 8·24² triangles, 4·24² + 2 vertices.
const FREQUENCY: u32 = 24;

const FACES: [Face; 6] = [
    ([0.05, -1.0, 0.08], 0.33),
    ([-0.35, 1.0, 0.30], 0.40),
    ([0.85, 0.75, 0.25], 0.54),
    ([-0.70, 0.15, 1.0], 0.50),
    ([0.35, 0.30, -1.0], 0.49),
    ([-1.0, 0.35, -0.55], 0.65),
];

pub(crate) fn rock() -> Result<Surface> {
    let stone = Stone::new(DVec3::new(0.79, 0.47, 0.60), &FACES, 3);
    let project = |p: DVec3| {
        let d = p.normalize();
        d * worn_radius(&stone, d)
    };
    let mut surface = octasphere(FREQUENCY);
    surface.positions.iter_mut().for_each(|p| *p = project(*p));
    surface.relax(300, project);
    check_star(&surface, DVec3::ZERO)?;
    surface.set_down();
    Ok(surface)
}

fn worn_radius(stone: &Stone, d: DVec3) -> f64 {
    let base = stone.radius(d);
    let p = d * base;
    let swell = 0.075 * fbm(p * 1.5 + DVec3::splat(3.1), 2, 11);
    let dents = 0.018 * noise(p * 4.2, 23);
    base * (1.0 + swell + dents)
}

/// The octahedron of frequency `n` on the unit sphere. The warp by sines spaces the edges of each octant evenly by
/// angle, which plain projection would bunch up at the corners.
fn octasphere(n: u32) -> Surface {
    let mut surface = Surface {
        positions: Vec::new(),
        triangles: Vec::new(),
    };
    let step = n as i32;
    let mut index = std::collections::HashMap::new();
    let mut vertex = |lattice: [i32; 3], positions: &mut Vec<DVec3>| {
        *index.entry(lattice).or_insert_with(|| {
            let warp = |x: i32| libm::sin(f64::from(x) / f64::from(step) * FRAC_PI_2);
            positions.push(DVec3::from_array(lattice.map(warp)).normalize());
            positions.len() as u32 - 1
        })
    };
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|axis| 1 - (octant >> axis & 1) * 2);
        let outward = sign[0] * sign[1] * sign[2] > 0;
        for [a, b, c] in octant_triangles(step) {
            let mut corners = [a, b, c].map(|[i, j]| {
                vertex(
                    [sign[0] * i, sign[1] * j, sign[2] * (step - i - j)],
                    &mut surface.positions,
                )
            });
            if !outward {
                corners.swap(1, 2);
            }
            surface.triangles.push(corners);
        }
    }
    surface
}

/// The n² triangles of a face as lattice points (i, j), counter-clockwise in the positive octant.
fn octant_triangles(n: i32) -> Vec<[[i32; 2]; 3]> {
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n - i {
            triangles.push([[i, j], [i + 1, j], [i, j + 1]]);
            if i + j + 1 < n {
                triangles.push([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::audit;

    #[test]
    fn it_has_the_counts_of_the_thesis_and_even_triangles() {
        let rock = rock().unwrap();
        let found = audit(&rock).unwrap();
        assert!(found.is_closed_body(), "{found:?}");
        assert_eq!((found.triangles, found.vertices), (4608, 2306));
        let areas = rock.triangles.iter().map(|&t| {
            let [a, b, c] = rock.corners(t);
            (b - a).cross(c - a).length()
        });
        let (low, high) = areas.fold((f64::MAX, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
        assert!(high / low < 4.0, "areas differ {}-fold", high / low);
        let (low, high) = rock.bounds();
        assert!(((high - low).length() - 2.0).abs() < 0.1);
    }
}
