//! Colours by age, and the tone curve.

use glam::Vec3A;

use crate::color::{encode, from_oklab, to_byte, to_linear};

/// Oklab of the oldest and the youngest element.
const OLD: [f32; 3] = [0.39, -0.044, 0.030];
const YOUNG: [f32; 3] = [0.92, -0.034, 0.088];

/// The colour of an element by its age, 0 the oldest to 1 the youngest: dark sage green to a pale
/// gold-green rim, a straight line in Oklab (Ottosson 2020), so that equal steps look equal.
/// Values outside are clamped; NaN is taken for 0.
pub fn age_color(t: f32) -> [u8; 3] {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let [l, a, b] = [0, 1, 2].map(|k| OLD[k] + t * (YOUNG[k] - OLD[k]));
    from_oklab([l, a, b]).map(to_byte)
}

/// Linear light of an sRGB colour.
pub(super) fn linear(rgb: [u8; 3]) -> Vec3A {
    Vec3A::from_array(rgb.map(to_linear))
}

/// Where the shoulder of the tone curve begins.
const SHOULDER: f32 = 0.6;

/// Straight up to the shoulder, then bent to reach white only at infinity.
fn tone(x: f32) -> f32 {
    let room = 1.0 - SHOULDER;
    if x <= SHOULDER {
        x
    } else {
        SHOULDER + room * (1.0 - libm::expf((SHOULDER - x) / room))
    }
}

/// The bytes of a pixel; `dither`, 0 to 1, breaks up the bands of slow gradients.
pub(super) fn to_pixel(light: Vec3A, dither: f32) -> [u8; 3] {
    light
        .to_array()
        .map(|x| (encode(tone(x)) * 255.0 + dither).min(255.0) as u8)
}
