//! Colour spaces: sRGB as files have it, linear light, and Oklab (Ottosson 2020), in which equal
//! steps look equal.

use std::sync::LazyLock;

/// Linear light of an sRGB byte.
pub(crate) fn to_linear(byte: u8) -> f32 {
    static LIGHT: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|byte| decode(byte as f32 / 255.0)));
    LIGHT[usize::from(byte)]
}

/// Linear light of sRGB, 0 to 1 each.
fn decode(x: f32) -> f32 {
    if x <= 0.040_45 {
        x / 12.92
    } else {
        libm::powf((x + 0.055) / 1.055, 2.4)
    }
}

/// The same of any number, beyond them that of the nearest; 0 of none.
pub(crate) fn decode_any(x: f64) -> f32 {
    match x > 0.0 {
        true => decode(x.min(1.0) as f32),
        false => 0.0,
    }
}

/// sRGB of linear light, 0 to 1 each.
pub(crate) fn encode(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * libm::powf(x, 1.0 / 2.4) - 0.055
    }
}

/// The sRGB byte of linear light.
pub(crate) fn to_byte(x: f32) -> u8 {
    static STEPS: LazyLock<Steps> = LazyLock::new(Steps::new);
    STEPS.byte(x)
}

/// The nearest byte to what [`encode`] says.
fn rounded(x: f32) -> u8 {
    (encode(x) * 255.0 + 0.5) as u8
}

/// Where linear light comes to the next byte, so that no power is taken for each colour.
struct Steps {
    /// The least light of each byte.
    least: [f32; 256],
    /// The byte of k shares of all light.
    low: [u8; Self::SHARES + 1],
}

impl Steps {
    const SHARES: usize = 1024;

    fn new() -> Self {
        // The bits of positive floats ascend with them.
        let least = |byte: usize| {
            let (mut low, mut high) = (0, 1f32.to_bits());
            while low < high {
                let middle = low.midpoint(high);
                match usize::from(rounded(f32::from_bits(middle))) >= byte {
                    true => high = middle,
                    false => low = middle + 1,
                }
            }
            f32::from_bits(low)
        };
        let share = |k: usize| rounded(k as f32 / Self::SHARES as f32);
        Self {
            least: std::array::from_fn(least),
            low: std::array::from_fn(share),
        }
    }

    fn byte(&self, x: f32) -> u8 {
        let x = x.clamp(0.0, 1.0);
        let low = self.low[(x * Self::SHARES as f32) as usize];
        let above = &self.least[usize::from(low) + 1..];
        low + above.iter().take_while(|least| x >= **least).count() as u8
    }
}

/// Linear sRGB of an Oklab colour.
pub(crate) fn from_oklab([l, a, b]: [f32; 3]) -> [f32; 3] {
    let cube = |x: f32| x * x * x;
    let long = cube(l + 0.396_337_78 * a + 0.215_803_76 * b);
    let medium = cube(l - 0.105_561_346 * a - 0.063_854_17 * b);
    let short = cube(l - 0.089_484_18 * a - 1.291_485_5 * b);
    [
        4.076_741_7 * long - 3.307_711_6 * medium + 0.230_969_94 * short,
        -1.268_438 * long + 2.609_757_4 * medium - 0.341_319_38 * short,
        -0.004_196_086_3 * long - 0.703_418_6 * medium + 1.707_614_7 * short,
    ]
}

/// The Oklab colour of an sRGB one.
pub(crate) fn to_oklab(rgb: [u8; 3]) -> [f32; 3] {
    let [r, g, b] = rgb.map(to_linear);
    let long = libm::cbrtf(0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b);
    let medium = libm::cbrtf(0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b);
    let short = libm::cbrtf(0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b);
    [
        0.210_454_26 * long + 0.793_617_8 * medium - 0.004_072_047 * short,
        1.977_998_5 * long - 2.428_592_2 * medium + 0.450_593_7 * short,
        0.025_904_037 * long + 0.782_771_77 * medium - 0.808_675_77 * short,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_grey_and_many_colours_come_back_from_oklab() {
        for i in 0..=255u8 {
            for rgb in [[i, i, i], [i, 255 - i, i / 2], [255, i, 0], [0, i, i]] {
                assert_eq!(from_oklab(to_oklab(rgb)).map(to_byte), rgb);
            }
        }
    }

    #[test]
    fn bytes_are_the_nearest_to_the_encoded_light() {
        let steps = Steps::new();
        let about = |least: &f32| {
            let bits = least.to_bits();
            (bits.saturating_sub(40)..bits + 40).map(f32::from_bits)
        };
        let even = (0..1 << 17).map(|k| k as f32 / (1 << 17) as f32);
        let odd = [-1.0, -0.0, 1.0, 1.5, f32::INFINITY, f32::NAN];
        for x in steps.least.iter().flat_map(about).chain(even).chain(odd) {
            assert_eq!(to_byte(x), rounded(x), "{x}");
        }
        assert!(steps.least.is_sorted());
    }

    #[test]
    fn white_has_lightness_1_and_no_colour() {
        let [l, a, b] = to_oklab([255; 3]);
        assert!((l - 1.0).abs() < 1e-4 && a.abs() < 1e-4 && b.abs() < 1e-4);
    }
}
