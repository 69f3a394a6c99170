//! Hash noise on the integer lattice: the same bits on every machine.
//!
//! Gradient noise after Perlin, "Improving noise" (2002), with gradients drawn from an integer hash instead of a
//! permutation table; cellular noise after Worley, "A cellular texture basis function" (1996).

use glam::DVec3;

/// A lattice point together with the seed, mixed into 32 well-spread bits.
fn hash(cell: [i32; 3], seed: u32) -> u32 {
    let mut h = seed.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    for c in cell {
        h = (h ^ c as u32).wrapping_mul(0xcc9e_2d51);
        h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

/// Three numbers in [0, 1) from one hash.
fn triple(h: u32) -> DVec3 {
    let part = |shift: u32| f64::from((h >> shift) & 0x3ff) / 1024.0;
    DVec3::new(part(0), part(10), part(20))
}

fn split(p: DVec3) -> ([i32; 3], DVec3) {
    let base = p.floor();
    ([base.x as i32, base.y as i32, base.z as i32], p - base)
}

fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Hermite step from 0 at `low` to 1 at `high`.
pub(crate) fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Gradient noise with features about one unit across; mostly within [-1, 1], zero on average.
pub(crate) fn noise(p: DVec3, seed: u32) -> f64 {
    let (cell, f) = split(p);
    let corner = |i: i32, j: i32, k: i32| {
        let at = [
            cell[0].wrapping_add(i),
            cell[1].wrapping_add(j),
            cell[2].wrapping_add(k),
        ];
        let gradient = triple(hash(at, seed)) * 2.0 - DVec3::splat(1023.0 / 1024.0);
        gradient.dot(f - DVec3::new(f64::from(i), f64::from(j), f64::from(k)))
    };
    let (u, v, w) = (fade(f.x), fade(f.y), fade(f.z));
    let row = |j: i32, k: i32| mix(corner(0, j, k), corner(1, j, k), u);
    1.5 * mix(
        mix(row(0, 0), row(1, 0), v),
        mix(row(0, 1), row(1, 1), v),
        w,
    )
}

/// A rotation with rational entries, so that the lattices of successive octaves never line up.
fn turn(p: DVec3) -> DVec3 {
    DVec3::new(
        0.36 * p.x + 0.48 * p.y - 0.8 * p.z,
        -0.8 * p.x + 0.6 * p.y,
        0.48 * p.x + 0.64 * p.y + 0.6 * p.z,
    )
}

fn octaves(p: DVec3, count: u32, seed: u32, shape: impl Fn(f64) -> f64) -> f64 {
    let (mut at, mut weight, mut sum, mut total) = (p, 1.0, 0.0, 0.0);
    for octave in 0..count {
        sum += weight * shape(noise(at, seed.wrapping_add(octave)));
        total += weight;
        weight *= 0.5;
        at = turn(at) * 2.03 + DVec3::splat(0.37);
    }
    sum / total
}

/// Fractal sum of `count` octaves, each half as tall and half as wide; within about [-1, 1].
pub(crate) fn fbm(p: DVec3, count: u32, seed: u32) -> f64 {
    octaves(p, count, seed, |n| n)
}

/// Fractal sum with sharp crests: 1 on a crest, falling towards 0.
pub(crate) fn ridged(p: DVec3, count: u32, seed: u32) -> f64 {
    octaves(p, count, seed, |n| {
        let crest = (1.0 - n.abs()).max(0.0);
        crest * crest
    })
}

/// What cellular noise knows about a point.
pub(crate) struct Cell {
    /// Distance to the nearest feature point.
    pub(crate) nearest: f64,
    /// Distance to the second nearest.
    pub(crate) second: f64,
    /// Three numbers in [0, 1) that belong to the nearest feature point.
    pub(crate) random: DVec3,
}

/// Cellular noise with one feature point a unit cell.
pub(crate) fn worley(p: DVec3, seed: u32) -> Cell {
    let (cell, f) = split(p);
    let mut found = Cell {
        nearest: f64::MAX,
        second: f64::MAX,
        random: DVec3::ZERO,
    };
    for index in 0..27 {
        let step = [index % 3 - 1, index / 3 % 3 - 1, index / 9 - 1];
        let h = hash(
            [0, 1, 2].map(|a: usize| cell[a].wrapping_add(step[a])),
            seed,
        );
        let corner = DVec3::new(f64::from(step[0]), f64::from(step[1]), f64::from(step[2]));
        let distance = (corner + triple(h) - f).length();
        if distance < found.nearest {
            found.second = found.nearest;
            found.nearest = distance;
            found.random = triple(hash([h as i32, 7, 11], seed));
        } else if distance < found.second {
            found.second = distance;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> impl Iterator<Item = DVec3> {
        (0..20_000).map(|i| triple(hash([i, 3, 5], 1)) * 40.0 - DVec3::splat(20.0))
    }

    #[test]
    fn noise_is_centred_bounded_and_spread() {
        let values: Vec<f64> = samples().map(|p| noise(p, 9)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((0.05..0.3).contains(&variance), "{variance}");
        assert!(values.iter().all(|v| v.abs() < 1.6));
    }

    #[test]
    fn noise_is_continuous_across_cells() {
        for i in -5..5 {
            let wall = DVec3::new(f64::from(i), 0.3, -0.7);
            let gap = noise(wall + DVec3::X * 1e-9, 4) - noise(wall - DVec3::X * 1e-9, 4);
            assert!(gap.abs() < 1e-7);
        }
    }

    #[test]
    fn cells_are_ordered_and_near() {
        for p in samples() {
            let cell = worley(p, 2);
            assert!(cell.nearest <= cell.second && cell.nearest < 1.75);
        }
    }
}
