//! Colours: sRGB, linear light, and the tone curve between them.

use glam::Vec3A;

/// Oklab of the oldest and the youngest element.
const OLD: [f32; 3] = [0.39, -0.044, 0.030];
const YOUNG: [f32; 3] = [0.92, -0.034, 0.088];

/// The colour of an element by its age, 0 the oldest to 1 the youngest: dark sage green to a pale
/// gold-green rim, a straight line in Oklab (Ottosson 2020), so that equal steps look equal.
/// Values outside are clamped; NaN is taken for 0.
pub fn age_color(t: f32) -> [u8; 3] {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let [l, a, b] = [0, 1, 2].map(|k| OLD[k] + t * (YOUNG[k] - OLD[k]));
    from_oklab(l, a, b).to_array().map(to_byte)
}

/// Linear sRGB of an Oklab colour.
fn from_oklab(l: f32, a: f32, b: f32) -> Vec3A {
    let cube = |x: f32| x * x * x;
    let long = cube(l + 0.396_337_78 * a + 0.215_803_76 * b);
    let medium = cube(l - 0.105_561_346 * a - 0.063_854_17 * b);
    let short = cube(l - 0.089_484_18 * a - 1.291_485_5 * b);
    Vec3A::new(
        4.076_741_7 * long - 3.307_711_6 * medium + 0.230_969_94 * short,
        -1.268_438 * long + 2.609_757_4 * medium - 0.341_319_38 * short,
        -0.004_196_086_3 * long - 0.703_418_6 * medium + 1.707_614_7 * short,
    )
}

/// Linear light of an sRGB byte.
fn to_linear(byte: u8) -> f32 {
    let x = f32::from(byte) / 255.0;
    if x <= 0.040_45 {
        x / 12.92
    } else {
        libm::powf((x + 0.055) / 1.055, 2.4)
    }
}

/// Linear light of an sRGB colour.
pub(super) fn linear(rgb: [u8; 3]) -> Vec3A {
    Vec3A::from_array(rgb.map(to_linear))
}

/// sRGB of linear light, 0 to 1 each.
fn encode(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * libm::powf(x, 1.0 / 2.4) - 0.055
    }
}

fn to_byte(x: f32) -> u8 {
    (encode(x) * 255.0 + 0.5) as u8
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
