//! What things are made of: stone with crystals and a rough face, furrowed bark, and the fine relief of
//! lichen. All of it is noise in space, so no mesh needs texture coordinates.

use std::sync::LazyLock;

use glam::{Mat3A, Vec3A};
use wide::{f32x4, i32x4, u32x4};

use super::color;
use super::sample::{hash, hash_four, unit};

/// What a substrate is drawn as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ground {
    /// Granite: crystals and a rough face.
    #[default]
    Stone,
    /// Bark, its furrows along the longest side of the mesh's box.
    Bark,
    /// Smooth and of one sRGB colour.
    Color([u8; 3]),
}

impl Ground {
    /// At a place in sizes of the scene, where the mesh is longest in this direction.
    pub(super) fn look(self, p: Vec3A, normal: Vec3A, along: Vec3A) -> Look {
        match self {
            Self::Stone => stone(p, normal),
            Self::Bark => bark(p, normal, along),
            Self::Color(rgb) => Look {
                albedo: color::linear(rgb),
                normal,
            },
        }
    }

    /// Linear light that it gives back at such a place.
    pub(crate) fn albedo(self, p: Vec3A, along: Vec3A) -> Vec3A {
        self.look(p, Vec3A::Z, along).albedo
    }
}

/// The axis along which a box is longest.
pub(crate) fn longest_axis([low, high]: [Vec3A; 2]) -> Vec3A {
    let sides = high - low;
    Vec3A::AXES
        .into_iter()
        .max_by(|a, b| sides.dot(*a).total_cmp(&sides.dot(*b)))
        .unwrap_or(Vec3A::Y)
}

/// The look of one place.
pub(super) struct Look {
    /// Share of the light that comes back, linear.
    pub(super) albedo: Vec3A,
    /// The shading normal.
    pub(super) normal: Vec3A,
}

/// Linear light that the ground mass of the stone gives back, its dark and its pale crystals.
const GROUND: Vec3A = Vec3A::new(0.262, 0.242, 0.220);
const DARK: Vec3A = Vec3A::new(0.125, 0.119, 0.113);
const PALE: Vec3A = Vec3A::new(0.46, 0.435, 0.40);

/// Crystals along the scene's diagonal.
const CRYSTALS: f32 = 480.0;

/// A turn about no axis of the mesh's: each octave lies turned to the one before, or the lattice
/// would show as squares and stripes where the camera is near.
const TURN: Mat3A = Mat3A::from_cols_array(&[
    0.0, -0.8, -0.6, //
    0.8, 0.36, -0.48, //
    0.6, -0.48, 0.64,
]);

/// Stone at a place in sizes of the scene.
pub(super) fn stone(p: Vec3A, normal: Vec3A) -> Look {
    let (weather, _) = octaves(p, &[(5.0, 0.5), (19.0, 0.32), (61.0, 0.26)]);
    let (face, slope) = octaves(
        p,
        &[(31.0, 0.35), (97.0, 0.35), (290.0, 0.32), (760.0, 0.2)],
    );
    let (warm, _) = noise(p * 4.0 + Vec3A::splat(31.0));
    let tint = Vec3A::new(1.0 + 0.10 * warm, 1.0, 1.0 - 0.12 * warm);
    let albedo = crystal(p * CRYSTALS) * (1.0 + 0.55 * weather + 0.35 * face) * tint;
    Look {
        albedo: albedo.max(Vec3A::splat(0.02)),
        normal: tilted(normal, slope, 0.0045),
    }
}

/// Linear light that plates of bark and the bottom of furrows give back.
const PLATE: Vec3A = Vec3A::new(0.205, 0.168, 0.134);
const FURROW: Vec3A = Vec3A::new(0.030, 0.023, 0.018);

/// Furrows: how many along the scene's diagonal, how wide beside their distance, and how deep.
const FURROWS: [(f32, f32, f32); 3] = [(38.0, 0.10, 0.9), (85.0, 0.13, 0.7), (190.0, 0.17, 0.35)];

/// What furrows lose of their number along the bark.
const STRETCH: f32 = 0.82;

/// Bark at a place in sizes of the scene: furrows are where a noise that is stretched along the bark
/// passes through 0, and plates are between.
pub(super) fn bark(p: Vec3A, normal: Vec3A, along: Vec3A) -> Look {
    let stretched = |v: Vec3A| v - along * (v.dot(along) * STRETCH);
    let (weather, _) = octaves(p, &[(6.0, 0.5), (23.0, 0.35)]);
    let (grain, mut slope) = octaves(p, &[(170.0, 0.35), (430.0, 0.3), (900.0, 0.2)]);
    let (_, bend) = noise(p * 13.0);
    let (bent, mut deepest) = (p + bend * 0.009, 0.0f32);
    for (frequency, width, depth) in FURROWS {
        let (level, gradient) = noise(stretched(bent) * frequency + Vec3A::splat(7.0));
        let furrow = (1.0 - level.abs() / width).max(0.0);
        let steep = 2.0 * furrow * depth * level.signum() / width;
        slope += stretched(gradient) * (steep * frequency);
        deepest = deepest.max(depth * furrow * furrow * (3.0 - 2.0 * furrow));
    }
    let plate = PLATE * (1.0 + 0.5 * weather + 0.55 * grain).max(0.1);
    Look {
        albedo: plate.lerp(FURROW, deepest),
        normal: tilted(normal, slope, 0.0022),
    }
}

/// Lichen at a place, with relief and mottles of this size; none at 0.
pub(super) fn lichen(p: Vec3A, normal: Vec3A, color: Vec3A, grain: f32) -> Look {
    if grain <= 0.0 {
        return Look {
            albedo: color,
            normal,
        };
    }
    let (mottle, slope) = octaves(p / grain, &[(0.11, 0.4), (0.37, 0.4), (1.1, 0.3)]);
    Look {
        albedo: (color * (1.0 + 0.4 * mottle)).max(Vec3A::ZERO),
        normal: tilted(normal, slope, 0.55),
    }
}

/// A normal on a face that rises by `height` times a noise of this gradient.
fn tilted(normal: Vec3A, gradient: Vec3A, height: f32) -> Vec3A {
    let along = gradient - normal * gradient.dot(normal);
    (normal - along * height).normalize_or(normal)
}

/// Octaves at most.
const MOST_OCTAVES: usize = 4;

/// How each octave lies to the mesh, and the way back.
type Turns = [(Mat3A, Mat3A); MOST_OCTAVES];

/// Noise of several frequencies by their weights, about 0, and its gradient.
fn octaves(p: Vec3A, of: &[(f32, f32)]) -> (f32, Vec3A) {
    static TURNS: LazyLock<Turns> = LazyLock::new(|| {
        let mut turn = Mat3A::IDENTITY;
        std::array::from_fn(|_| {
            turn = TURN * turn;
            (turn, turn.transpose())
        })
    });
    debug_assert!(of.len() <= MOST_OCTAVES);
    let (mut sum, mut gradient) = (0.0, Vec3A::ZERO);
    for (&(frequency, weight), (turn, back)) in of.iter().zip(&*TURNS) {
        let (value, slope) = noise(*turn * p * frequency);
        sum += weight * value;
        gradient += *back * slope * (weight * frequency);
    }
    (sum, gradient)
}

/// Smooth noise on the lattice of whole numbers, −½ to ½, and its gradient.
fn noise(p: Vec3A) -> (f32, Vec3A) {
    let cell = p.floor();
    let f = p - cell;
    let u = f * f * (Vec3A::splat(3.0) - 2.0 * f);
    let du = 6.0 * f * (Vec3A::ONE - f);
    let [before, after] = hashes(cell).map(|h| shares(h >> 8, 1.0 / (1 << 24) as f32));
    let along = after - before;
    let (rows, along) = ((before + u.x * along).to_array(), along.to_array());
    let sheet = |k: usize| {
        let [a, b, da, db] = [rows[k], rows[k + 1], along[k], along[k + 1]];
        (a + u.y * (b - a), da + u.y * (db - da), b - a)
    };
    let ((a, ax, ay), (b, bx, by)) = (sheet(0), sheet(2));
    let gradient = Vec3A::new(ax + u.z * (bx - ax), ay + u.z * (by - ay), b - a);
    (a + u.z * (b - a) - 0.5, gradient * du)
}

/// A hash of each corner of a cell of the lattice: of those before it along x, and of those after;
/// in each four y goes first.
fn hashes(cell: Vec3A) -> [u32x4; 2] {
    /// Odd numbers that have little in common, those of xxHash.
    const X: u32 = 0x9E37_79B1;
    const Y: u32 = 0x85EB_CA77;
    const Z: u32 = 0xC2B2_AE3D;
    const ASIDE: [u32; 4] = [0, Y, Z, Y.wrapping_add(Z)];
    let [x, y, z] = lattice(cell);
    let first = x.wrapping_mul(X).wrapping_add(y.wrapping_mul(Y));
    let before = u32x4::splat(first.wrapping_add(z.wrapping_mul(Z))) + u32x4::new(ASIDE);
    [before, before + u32x4::splat(X)].map(hash_four)
}

/// Numbers below 2³¹, each times this.
fn shares(numbers: u32x4, of: f32) -> f32x4 {
    f32x4::from_i32x4(i32x4::new(numbers.to_array().map(|n| n as i32))) * f32x4::splat(of)
}

fn lattice(cell: Vec3A) -> [u32; 3] {
    let [x, y, z] = cell.to_array();
    let [x, y, z, _] = f32x4::new([x, y, z, 0.0]).fast_trunc_int().to_array();
    [x, y, z].map(|c| c as u32)
}

/// The colour of the crystal at a place: cells about one point in each cube of the lattice
/// (Worley 1996), most of them ground mass. Only the eight nearest cubes are looked at, which cuts
/// a few cells short: crystals have straight sides anyway.
fn crystal(p: Vec3A) -> Vec3A {
    let first = (p - 0.5).floor();
    let (aside, hashes) = (first - p, hashes(first));
    let within = |byte: u32, h: u32x4| shares(h >> (8 * byte) & u32x4::splat(255), 1.0 / 255.0);
    let distance_sq = |i: usize| {
        let x = within(0, hashes[i]) + (aside.x + i as f32);
        let y = within(1, hashes[i]) + f32x4::new([0.0, 1.0, 0.0, 1.0]) + aside.y;
        let z = within(2, hashes[i]) + f32x4::new([0.0, 0.0, 1.0, 1.0]) + aside.z;
        (x * x + y * y + z * z).to_array()
    };
    let distances_sq = [distance_sq(0), distance_sq(1)];
    let all = distances_sq
        .iter()
        .flatten()
        .zip(hashes.iter().flat_map(|h| h.to_array()));
    let nearer = |a: (f32, u32), b: (f32, u32)| if b.0 < a.0 { b } else { a };
    let (_, kind) = all.fold((f32::INFINITY, 0), |a, (d, h)| nearer(a, (*d, h)));
    match unit(hash(kind)) {
        k if k < 0.06 => DARK * (0.8 + 8.0 * k),
        k if k < 0.24 => PALE * (0.7 + 1.7 * (k - 0.06)),
        k => GROUND * (0.75 + 0.5 * k),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_the_slope() {
        let of = [(1.0, 0.4), (2.7, 0.3)];
        for i in 0..200 {
            let p = Vec3A::new(i as f32 * 0.37, i as f32 * -0.71, 3.0 + i as f32 * 0.113);
            let (_, gradient) = octaves(p, &of);
            let step = 1e-2;
            for axis in [Vec3A::X, Vec3A::Y, Vec3A::Z] {
                let [a, b] = [step, -step].map(|s| octaves(p + axis * s, &of).0);
                let slope = (a - b) / (2.0 * step);
                assert!((slope - gradient.dot(axis)).abs() < 0.03, "{p} {axis}");
            }
        }
    }
}
