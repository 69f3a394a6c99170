//! Colours by age, and the tone curve.

use std::sync::LazyLock;

use glam::{Mat3A, Vec3A};

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

/// sRGB of an Oklab colour by lightness 0 to 1, chroma and hue in radians, clipped to what sRGB holds.
pub fn hue_color(lightness: f32, chroma: f32, hue: f32) -> [u8; 3] {
    let (sin, cos) = libm::sincosf(hue);
    from_oklab([lightness, chroma * cos, chroma * sin]).map(to_byte)
}

/// Linear light of an sRGB colour.
pub(super) fn linear(rgb: [u8; 3]) -> Vec3A {
    static OF_BYTE: LazyLock<[f32; 256]> =
        LazyLock::new(|| core::array::from_fn(|byte| to_linear(byte as u8)));
    Vec3A::from_array(rgb.map(|byte| OF_BYTE[usize::from(byte)]))
}

/// Into the space of the tone curve and out of it: S. Hill's fit of the Academy's reference
/// rendering transform (ACES), as in *BakingLab* (Pettineo & Hill 2016).
const INTO_FILM: Mat3A = Mat3A::from_cols_array(&[
    0.59719, 0.07600, 0.02840, //
    0.35458, 0.90834, 0.13383, //
    0.04823, 0.01566, 0.83777,
]);
const OUT_OF_FILM: Mat3A = Mat3A::from_cols_array(&[
    1.60475, -0.10208, -0.00327, //
    -0.53108, 1.10813, -0.07276, //
    -0.07367, -0.00605, 1.07602,
]);

/// Film deepens colours along with the contrast; this share of that is taken back.
const PALER: f32 = 0.13;

/// A film's response: a toe, a straight part and a shoulder. Linear light in and out, out 0 to 1.
fn film(light: Vec3A) -> Vec3A {
    let v = INTO_FILM * light;
    let a = v * (v + 0.024_578_6) - 0.000_090_537;
    let b = v * (0.983_729 * v + 0.432_951) + 0.238_081;
    let v = OUT_OF_FILM * (a / b);
    let grey = v.dot(Vec3A::new(0.2126, 0.7152, 0.0722));
    (v + (grey - v) * PALER).clamp(Vec3A::ZERO, Vec3A::ONE)
}

/// sRGB of light, 0 to 255, before it is made whole.
pub(super) fn exposed(light: Vec3A) -> Vec3A {
    Vec3A::from_array(film(light).to_array().map(encoded)) * 255.0
}

/// [`encode`], straight between 4097 of its values: off by less than a hundredth of a byte, which is
/// little beside the dither, and no power is taken for each pixel.
fn encoded(x: f32) -> f32 {
    const SHARES: usize = 4096;
    static VALUES: LazyLock<Vec<f32>> = LazyLock::new(|| {
        let shares = (0..=SHARES).map(|i| i as f32 / SHARES as f32);
        shares.map(encode).collect()
    });
    let at = x.clamp(0.0, 1.0) * SHARES as f32;
    let below = (at as usize).min(SHARES - 1);
    let values = &VALUES[below..below + 2];
    values[0] + (at - below as f32) * (values[1] - values[0])
}

/// The bytes of a pixel; `dither`, 0 to 1, breaks up the bands of slow gradients.
pub(super) fn to_pixel(light: Vec3A, dither: f32) -> [u8; 3] {
    exposed(light)
        .to_array()
        .map(|x| (x + dither).min(255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_encoded_to_a_hundredth_of_a_byte() {
        for i in 0..=200_000 {
            let x = i as f32 / 200_000.0;
            let aside = (encoded(x) - encode(x)).abs() * 255.0;
            assert!(aside < 0.01, "{x}: {aside} aside");
        }
    }

    #[test]
    fn film_keeps_greys_grey_and_the_order_of_lights() {
        let grey = |x: f32| film(Vec3A::splat(x));
        let mut before = -1.0;
        for i in 0..60 {
            let v = grey(libm::exp2f(i as f32 / 4.0 - 10.0));
            assert!(v.max_element() - v.min_element() < 2e-3, "{v}");
            assert!(v.y >= before && v.y <= 1.0, "{v}");
            before = v.y;
        }
        assert!(grey(0.0).max_element() < 1e-3 && before > 0.99);
    }
}
