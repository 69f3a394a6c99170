//! Keys to a picture: what its colours mean, and how long things are.

use super::{Image, text};

/// One entry of a legend.
#[derive(Clone, Copy)]
pub enum Key<'a> {
    /// Colours of numbers.
    Range {
        /// What the numbers are, with their unit.
        title: &'a str,
        /// The numbers at the ends, the lower first.
        ends: [f64; 2],
        /// The colour at a share of the way from end to end.
        color: &'a dyn Fn(f32) -> [u8; 3],
    },
    /// Colours of kinds.
    Kinds {
        /// What they are kinds of.
        title: &'a str,
        /// Their names and colours.
        kinds: &'a [(String, [u8; 3])],
    },
    /// A length.
    Length {
        /// What it is, with its unit.
        label: &'a str,
        /// How long it is in the picture, as a share of the picture's width: 0 to 1, to which others are limited.
        share: f32,
    },
}

impl std::fmt::Debug for Key<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (name, title) = match self {
            Self::Range { title, .. } => ("Range", title),
            Self::Kinds { title, .. } => ("Kinds", title),
            Self::Length { label, .. } => ("Length", label),
        };
        f.debug_struct(name)
            .field("title", title)
            .finish_non_exhaustive()
    }
}

pub(super) const INK: [u8; 3] = [0x24, 0x24, 0x22];
const PAPER: [u8; 3] = [0xfa, 0xf9, 0xf6];

/// How much of the picture the paper hides.
const OPAQUE: f32 = 0.86;

/// Draws keys, from the top down, on a panel in the lower left corner. They are in proportion to the
/// smaller side of the picture, or so large that letters can be read, if there is room for that.
///
/// # Panics
/// When there are fewer than three bytes for each pixel.
pub fn draw_legend(image: &mut Image, keys: &[Key<'_>]) {
    if keys.is_empty() {
        return;
    }
    let sheet = Sheet::readable_on(image, keys);
    let [width, height] = sheet.panel(image, keys);
    let [pad, edge, gap] = [PAD, EDGE, GAP].map(|size| size * sheet.unit);
    let top = image.height as f32 - edge - height;
    image.fill([edge, top, edge + width, top + height], OPAQUE, |_| PAPER);
    let mut y = top + pad;
    for key in keys {
        sheet.draw(image, key, [edge + pad, y]);
        y += sheet.height(key) + gap;
    }
}

/// The least size of letters that can be read, in pixels.
const READABLE: f32 = 10.0;

/// Sizes in thousandths of the picture's smaller side, where that makes letters readable.
const EDGE: f32 = 24.0;
const PAD: f32 = 18.0;
const GAP: f32 = 20.0;
const LETTERS: f32 = 24.0;
const LINE: f32 = 32.0;
const BAR: [f32; 2] = [300.0, 20.0];
const TICK: f32 = 7.0;
const RULE: f32 = 3.0;

struct Sheet {
    unit: f32,
}

impl Sheet {
    /// As large as keys are to be on a picture.
    fn readable_on(image: &Image, keys: &[Key]) -> Self {
        let least = image.width.min(image.height) as f32 / 1000.0;
        let readable = least.max(READABLE / LETTERS);
        let panel = Self { unit: readable }.panel(image, keys);
        let room = [image.width, image.height].map(|side| side as f32 - 2.0 * EDGE * readable);
        let fits = (room[0] / panel[0]).min(room[1] / panel[1]).min(1.0);
        Self {
            unit: (fits * readable).max(least),
        }
    }

    /// Width and height of the panel.
    fn panel(&self, image: &Image, keys: &[Key]) -> [f32; 2] {
        let widths = keys.iter().map(|key| self.width(image, key));
        let heights = keys.iter().map(|key| self.height(key));
        let gaps = keys.len().saturating_sub(1) as f32 * GAP;
        let around = 2.0 * PAD * self.unit;
        let height = heights.sum::<f32>() + gaps * self.unit;
        [widths.fold(0.0, f32::max) + around, height + around]
    }

    fn letters(&self) -> f32 {
        LETTERS * self.unit
    }

    fn width(&self, image: &Image, key: &Key) -> f32 {
        let words = |text: &str| text::width(text, self.letters());
        match key {
            Key::Range { title, ends, .. } => {
                let last = ticks(*ends).last().map_or(0.0, |t| words(&t.label));
                words(title).max(BAR[0] * self.unit + 0.5 * last)
            }
            Key::Kinds { title, kinds } => kinds
                .iter()
                .map(|(name, _)| words(name) + LINE * self.unit)
                .fold(words(title), f32::max),
            Key::Length { label, share } => words(label).max(length(*share, image.width)),
        }
    }

    fn height(&self, key: &Key) -> f32 {
        let lines = match key {
            Key::Range { .. } => 2.0 * LINE + BAR[1] + TICK,
            Key::Kinds { kinds, .. } => (1.0 + kinds.len() as f32) * LINE,
            Key::Length { .. } => LINE + RULE + TICK,
        };
        lines * self.unit
    }

    fn draw(&self, image: &mut Image, key: &Key, [x, y]: [f32; 2]) {
        let line = LINE * self.unit;
        match key {
            Key::Range { title, ends, color } => {
                self.write(image, title, [x, y]);
                self.draw_range(image, *ends, color, [x, y + line]);
            }
            Key::Kinds { title, kinds } => {
                self.write(image, title, [x, y]);
                for (i, kind) in kinds.iter().enumerate() {
                    self.draw_kind(image, kind, [x, y + (i + 1) as f32 * line]);
                }
            }
            Key::Length { label, share } => {
                self.write(image, label, [x, y]);
                self.draw_rule(image, length(*share, image.width), [x, y + line]);
            }
        }
    }

    /// A line of text with this upper left corner.
    fn write(&self, image: &mut Image, text: &str, [x, y]: [f32; 2]) {
        let height = self.letters();
        text::write(image, text, [x, y + 0.85 * height], height, INK);
    }

    fn draw_range(
        &self,
        image: &mut Image,
        ends: [f64; 2],
        color: &dyn Fn(f32) -> [u8; 3],
        [x, y]: [f32; 2],
    ) {
        let [width, height] = BAR.map(|side| side * self.unit);
        image.fill([x, y, x + width, y + height], 1.0, |px| {
            color(((px - x) / width).clamp(0.0, 1.0))
        });
        let foot = y + height;
        let thin = (0.5 * RULE * self.unit).max(0.5);
        for Tick { share, label } in ticks(ends) {
            let at = x + share * width;
            let tick = [at - thin, foot, at + thin, foot + TICK * self.unit];
            image.fill(tick, 1.0, |_| INK);
            let left = (at - 0.5 * text::width(&label, self.letters())).max(x);
            self.write(image, &label, [left, foot + (TICK + 4.0) * self.unit]);
        }
    }

    fn draw_kind(&self, image: &mut Image, (name, color): &(String, [u8; 3]), [x, y]: [f32; 2]) {
        let side = BAR[1] * self.unit;
        image.fill([x, y, x + side, y + side], 1.0, |_| *color);
        self.write(image, name, [x + LINE * self.unit, y]);
    }

    fn draw_rule(&self, image: &mut Image, length: f32, [x, y]: [f32; 2]) {
        let [thick, tick] = [RULE, TICK].map(|side| side * self.unit);
        image.fill([x, y, x + length, y + thick], 1.0, |_| INK);
        for end in [x, x + length - thick] {
            image.fill([end, y - tick, end + thick, y + thick], 1.0, |_| INK);
        }
    }
}

/// A share of so many pixels; none where it is no number.
pub(super) fn length(share: f32, of: u32) -> f32 {
    share.clamp(0.0, 1.0).max(0.0) * of as f32
}

/// A number on a bar.
struct Tick {
    /// How far along the bar.
    share: f32,
    label: String,
}

/// Two to five round numbers between the ends; one where the ends are the same.
fn ticks([low, high]: [f64; 2]) -> Vec<Tick> {
    /// How far beyond an end a tick still counts, in steps: births are counted from 0, and end at 19,999.
    const BEYOND: f64 = 1e-3;
    let span = high - low;
    // Half of less is no number that can be divided by.
    if !(span >= f64::MIN_POSITIVE / 0.25 && span.is_finite()) {
        let label = number(low, 0.0);
        return vec![Tick { share: 0.5, label }];
    }
    let step = round_below(0.5 * span * (1.0 + BEYOND));
    let first = (low / step - BEYOND).ceil() as i64;
    let last = (high / step + BEYOND).floor() as i64;
    let tick = |k: i64| {
        let value = k as f64 * step;
        Tick {
            share: ((value - low) / span).clamp(0.0, 1.0) as f32,
            label: number(value, step),
        }
    };
    (first..=last).map(tick).collect()
}

/// The largest of 1, 2 and 5 times a power of ten that is not greater.
///
/// # Panics
/// When `x` is not a positive finite number.
pub fn round_below(x: f64) -> f64 {
    assert!(x > 0.0 && x.is_finite(), "{x}: a positive number");
    let power = libm::pow(10.0, libm::floor(libm::log10(x)));
    let fits = |m: &f64| m * power <= x * (1.0 + 1e-9);
    [5.0, 2.0].into_iter().find(fits).unwrap_or(1.0) * power
}

/// A number as people write it, to the decimals that a step of its scale needs.
pub fn number(value: f64, step: f64) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let step = if step.is_finite() { step } else { 0.0 };
    let size = value.abs().max(step.abs());
    if size != 0.0 && !(1e-3..1e7).contains(&size) {
        let order = |x: f64| libm::floor(libm::log10(x.abs().max(1e-300)) + 1e-9);
        let digits = match () {
            () if value == 0.0 => return "0".to_owned(),
            () if step == 0.0 => 0,
            () => (order(value) - order(step)).max(0.0) as usize,
        };
        return format!("{value:.digits$e}");
    }
    let decimals = match step > 0.0 && step < 1.0 {
        true => libm::ceil(-libm::log10(step) - 1e-9) as usize,
        false if step == 0.0 && value.fract() != 0.0 => 3,
        false => 0,
    };
    let plain = format!("{value:.decimals$}");
    let (whole, rest) = plain.split_at(plain.find('.').unwrap_or(plain.len()));
    thousands(whole) + rest
}

fn thousands(whole: &str) -> String {
    let digits = whole.trim_start_matches('-');
    let mut text = whole[..whole.len() - digits.len()].to_owned();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_few_and_in_their_places() {
        let ranges = [
            [0.0, 19_999.0],
            [0.12, 0.78],
            [0.01, 1.0],
            [-3.0, 4.0],
            [0.0, 3e-5],
            [0.0, 8e9],
            [5.0, 6.0],
        ];
        for [low, high] in ranges {
            let ticks = ticks([low, high]);
            assert!((2..=5).contains(&ticks.len()), "{low} {high}");
            let is_end = high == 19_999.0;
            let labels: Vec<&str> = ticks.iter().map(|t| t.label.as_str()).collect();
            assert!(!is_end || labels == ["0", "10,000", "20,000"], "{labels:?}");
            for Tick { share, label } in ticks {
                let value: f64 = label.replace(',', "").parse().unwrap();
                let error = low + f64::from(share) * (high - low) - value;
                assert!(error.abs() < 1e-3 * (high - low), "{label}");
                assert!((0.0..=1.0).contains(&share));
            }
        }
        assert_eq!(ticks([7.0, 7.0])[0].label, "7");
        for least in [5e-324, 1e-323, 1e-308] {
            assert!((1..=5).contains(&ticks([0.0, least]).len()), "{least}");
        }
    }

    #[test]
    fn letters_can_be_read_where_there_is_room() {
        let keys = [Key::Length {
            label: "1 mm",
            share: 0.1,
        }];
        let letters = |width: u32, height: u32| {
            let image = Image::sheet(width, height, PAPER);
            Sheet::readable_on(&image, &keys).letters()
        };
        assert_eq!([letters(1600, 200), letters(200, 1600)], [READABLE; 2]);
        assert_eq!(letters(1500, 1000), LETTERS);
        assert!(letters(24, 24) < READABLE);
    }

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!(number(20_000.0, 5_000.0), "20,000");
        assert_eq!(number(-1_234_567.0, 1.0), "-1,234,567");
        assert_eq!(number(0.2, 0.2), "0.2");
        assert_eq!(number(0.25, 0.05), "0.25");
        assert_eq!(number(2e-5, 1e-5), "2e-5");
        assert_eq!(number(0.0, 0.5), "0.0");
        assert_eq!(number(0.0, 1e-5), "0");
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(number(odd, 1.0), odd.to_string());
            assert_eq!(number(1.0, odd), "1");
        }
        assert_eq!(round_below(0.0999), 0.05);
        assert_eq!(round_below(3.0), 2.0);
        assert_eq!(round_below(1000.0), 1000.0);
    }
}
