//! The stone: warm grey with grain, from value noise in space.

use glam::{Mat3A, Vec3A};

use super::sample::{hash, unit};

/// Linear light that the stone gives back, before the grain.
const GREY: Vec3A = Vec3A::new(0.225, 0.208, 0.188);

/// A turn about no axis of the mesh's: each octave lies turned to the one before, or the lattice
/// would show as squares and stripes where the camera is near.
const TURN: Mat3A = Mat3A::from_cols_array(&[
    0.0, -0.8, -0.6, //
    0.8, 0.36, -0.48, //
    0.6, -0.48, 0.64,
]);

/// The albedo at a place, in units of the size of the scene.
pub(crate) fn albedo(p: Vec3A) -> Vec3A {
    let octaves = [
        (7.0, 0.24),
        (31.0, 0.20),
        (117.0, 0.24),
        (390.0, 0.26),
        (1100.0, 0.22),
    ];
    let (mut grain, mut turned) = (0.0, p);
    for (frequency, weight) in octaves {
        turned = TURN * turned;
        grain += weight * (noise(turned * frequency) - 0.5);
    }
    let warm = noise(p * 4.0 + Vec3A::splat(31.0)) - 0.5;
    GREY * (1.0 + grain) * Vec3A::new(1.0 + 0.06 * warm, 1.0, 1.0 - 0.06 * warm)
}

/// Smooth noise, 0 to 1, on the lattice of whole numbers.
fn noise(p: Vec3A) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let f = f * f * (Vec3A::splat(3.0) - 2.0 * f);
    let [x, y, z] = cell.to_array().map(|c| c as i32 as u32);
    let row = |j: u32, k: u32| {
        let base = hash(y.wrapping_add(j) ^ hash(z.wrapping_add(k)));
        let [a, b] = [0, 1].map(|i| unit(hash(base ^ x.wrapping_add(i))));
        a + f.x * (b - a)
    };
    let sheet = |k: u32| {
        let (a, b) = (row(0, k), row(1, k));
        a + f.y * (b - a)
    };
    let (a, b) = (sheet(0), sheet(1));
    a + f.z * (b - a)
}
