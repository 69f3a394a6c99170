//! `boulder.glb`: a weathered granite boulder of 80,688 triangles in six charts.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

use anyhow::Result;
use glam::DVec3;

use crate::audit::check_star;
use crate::noise::{fbm, noise, ridged, smoothstep, worley};
use crate::plates::face_quads;
use crate::stone::{Face, Stone};
use crate::surface::Surface;

/// Edges of the cube are cut into this many parts: 12·82² triangles.
const PARTS: i32 = 82;

/// Joint planes: where the block broke from its bed.
const FACES: [Face; 9] = [
    ([0.04, -1.0, -0.06], 0.44),
    ([-0.25, 1.0, 0.18], 0.55),
    ([0.95, 0.45, 0.30], 0.60),
    ([0.25, 0.30, 1.0], 0.53),
    ([-0.85, 0.10, 0.75], 0.58),
    ([-0.90, 0.60, -0.45], 0.65),
    ([0.20, 0.15, -1.0], 0.55),
    ([0.80, -0.30, -0.70], 0.65),
    ([0.55, 1.0, -0.60], 0.58),
];

/// A boulder whose vertices are doubled where two charts meet.
pub(crate) struct Charted {
    pub(crate) surface: Surface,
    /// Texture coordinates, one a vertex, within [0, 1]².
    pub(crate) uv: Vec<[f64; 2]>,
    pub(crate) normals: Vec<DVec3>,
}

pub(crate) fn boulder() -> Result<Charted> {
    let stone = Stone::new(DVec3::new(0.80, 0.62, 0.70), &FACES, 5);
    let project = |p: DVec3| {
        let d = p.normalize();
        d * rough_radius(&stone, d)
    };
    let (mut surface, quads) = cubesphere(PARTS);
    surface.positions.iter_mut().for_each(|p| *p = project(*p));
    surface.relax(12, project);
    surface.triangles = quads
        .iter()
        .flat_map(|q| cut_quad(&surface.positions, q.corners))
        .collect();
    check_star(&surface, DVec3::ZERO)?;
    surface.set_down();
    Ok(split_charts(&surface, &quads))
}

/// A lattice square of the cube.
struct Quad {
    chart: usize,
    corners: [u32; 4],
    /// Place of each corner in its chart, in lattice steps.
    chart_places: [[i32; 2]; 4],
}

/// The cube of `n` parts an edge on the unit sphere, spaced evenly by angle along the faces' middle lines.
fn cubesphere(n: i32) -> (Surface, Vec<Quad>) {
    let warp = |i: i32| libm::tan((2.0 * f64::from(i) / f64::from(n) - 1.0) * FRAC_PI_4);
    let mut index = HashMap::new();
    let mut positions = Vec::new();
    let mut quads = Vec::new();
    for chart in 0..6 {
        let axis = chart / 2;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for lattices in face_quads([n; 3], axis, chart % 2 == 1) {
            let corners = lattices.map(|lattice| {
                *index.entry(lattice).or_insert_with(|| {
                    positions.push(DVec3::from_array(lattice.map(warp)).normalize());
                    positions.len() as u32 - 1
                })
            });
            quads.push(Quad {
                chart,
                corners,
                chart_places: lattices.map(|l| [l[u], l[v]]),
            });
        }
    }
    let triangles = quads
        .iter()
        .flat_map(|q| cut_quad(&positions, q.corners))
        .collect();
    (
        Surface {
            positions,
            triangles,
        },
        quads,
    )
}

/// Cuts a square along its shorter diagonal.
fn cut_quad(positions: &[DVec3], [a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    let span = |v: u32, w: u32| positions[v as usize].distance_squared(positions[w as usize]);
    if span(a, c) <= span(b, d) {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    }
}

fn rough_radius(stone: &Stone, d: DVec3) -> f64 {
    let bend = DVec3::new(noise(d * 1.7, 71), noise(d * 1.7, 72), noise(d * 1.7, 73));
    let base = stone.radius((d + 0.16 * bend).normalize());
    let p = d * base;
    base * (1.0 + 0.10 * fbm(p * 1.6, 2, 41)) + spalls(p) + crust(p) - cracks(p) - pits(p)
}

/// Ledges where slabs have come away along curved sheets: a staircase of soft steps.
fn spalls(p: DVec3) -> f64 {
    let level = 2.0 * fbm(p * 1.3 + DVec3::splat(9.0), 3, 51) + 0.10 * noise(p * 6.0, 57);
    let step = level.floor() + smoothstep(0.40, 0.60, level - level.floor());
    0.050 * step
}

/// Ridges everywhere; lumps and grain more where the skin has weathered than where it has split.
fn crust(p: DVec3) -> f64 {
    let grain = worley(p * 20.0, 65);
    let weathering = 0.25 + 0.95 * smoothstep(-0.25, 0.30, noise(p * 2.2, 63));
    0.045 * (ridged(p * 2.6, 4, 61) - 0.6)
        + weathering * 0.016 * fbm(p * 9.0, 3, 67)
        + weathering
            * 0.007
            * (smoothstep(0.0, 0.35, grain.second - grain.nearest) + grain.random.x - 1.2)
}

/// Fissures along a few bent planes, each running out along its length.
fn cracks(p: DVec3) -> f64 {
    let planes = [
        ([0.9, 0.35, 0.25], 0.12),
        ([-0.55, 0.75, 0.35], -0.08),
        ([0.3, -0.9, 0.5], 0.16),
    ];
    let wander = 0.07 * fbm(p * 3.0, 4, 81);
    let depth = planes.iter().enumerate().map(|(i, &(normal, offset))| {
        let away = (p.dot(DVec3::from_array(normal).normalize()) - offset + wander).abs();
        let presence = smoothstep(-0.15, 0.25, noise(p * 1.5, 83 + i as u32));
        presence * (1.0 - smoothstep(0.0, 0.028, away))
    });
    0.050 * depth.fold(0.0, f64::max)
}

/// Bowls weathered out around feature points, at two scales; most cells have none.
fn pits(p: DVec3) -> f64 {
    let bowl = |frequency: f64, depth: f64, share: f64, seed: u32| {
        let cell = worley(
            p * frequency + 0.2 * DVec3::splat(noise(p * frequency * 1.5, seed)),
            seed,
        );
        let size = 0.25 + 0.35 * cell.random.y;
        let inside = 1.0 - smoothstep(0.35 * size, size, cell.nearest);
        if cell.random.x < share {
            depth * size * inside
        } else {
            0.0
        }
    };
    bowl(6.0, 0.050, 0.25, 97) + bowl(13.0, 0.028, 0.45, 93)
}

/// Gives each chart its own copy of the vertices on its border, with a place in a 3 × 2 atlas.
fn split_charts(welded: &Surface, quads: &[Quad]) -> Charted {
    let welded_normals = welded.normals();
    let mut copies = HashMap::new();
    let mut split = Charted {
        surface: Surface {
            positions: Vec::new(),
            triangles: Vec::new(),
        },
        uv: Vec::new(),
        normals: Vec::new(),
    };
    for quad in quads {
        let mut local = HashMap::new();
        for (&vertex, &place) in quad.corners.iter().zip(&quad.chart_places) {
            let copy = *copies.entry((quad.chart, vertex)).or_insert_with(|| {
                split
                    .surface
                    .positions
                    .push(welded.positions[vertex as usize]);
                split.normals.push(welded_normals[vertex as usize]);
                split.uv.push(atlas(quad.chart, place));
                split.uv.len() as u32 - 1
            });
            local.insert(vertex, copy);
        }
        let triangles = cut_quad(&welded.positions, quad.corners);
        split
            .surface
            .triangles
            .extend(triangles.map(|t| t.map(|v| local[&v])));
    }
    split
}

/// The place of a chart's lattice point in an atlas of three by two tiles, with a margin around each. Charts on the
/// near sides of the cube are mirrored so that no texture reads backwards.
fn atlas(chart: usize, [i, j]: [i32; 2]) -> [f64; 2] {
    const MARGIN: f64 = 0.02;
    let along = |k: i32| MARGIN + (1.0 - 2.0 * MARGIN) * f64::from(k) / f64::from(PARTS);
    let across = if chart % 2 == 1 {
        along(i)
    } else {
        1.0 - along(i)
    };
    // glTF's v runs downwards.
    [
        ((chart / 2) as f64 + across) / 3.0,
        ((chart % 2) as f64 + 1.0 - along(j)) / 2.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::{audit, weld};

    #[test]
    fn it_is_one_closed_body_in_six_charts() {
        let boulder = boulder().unwrap();
        let found = audit(&boulder.surface).unwrap();
        assert!(found.is_closed_body(), "{found:?}");
        assert_eq!(found.triangles, 80_688);
        assert!(boulder.surface.positions.len() > found.vertices + 800);
        assert_eq!(crate::crossings::crossings(&weld(&boulder.surface)), 0);
        check_charts(&boulder);
    }

    /// Charts that don't overlap cover less than the whole texture, and none is mirrored.
    fn check_charts(boulder: &Charted) {
        let mut total = 0.0;
        for t in &boulder.surface.triangles {
            let [a, b, c] = t.map(|v| boulder.uv[v as usize]);
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(area < 0.0, "a triangle is mirrored in the texture");
            total -= area / 2.0;
        }
        assert!(total < 1.0 && total > 0.85, "the charts cover {total}");
        assert!(boulder.uv.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
    }
}
