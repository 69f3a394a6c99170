//! Letters on a picture.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, GlyphId, PxScale, ScaleFont, point};

use super::Image;

/// Inter, by the Inter Project Authors, under the SIL Open Font License (`font/OFL.txt`).
static INTER: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    FontRef::try_from_slice(include_bytes!("font/Inter-Latin.ttf")).expect("the font is sound")
});

/// Signs that look like one of the font's and mean the same.
const SAME: [(char, char); 7] = [
    ('\u{3bc}', '\u{b5}'),
    ('\u{a0}', ' '),
    ('\u{2009}', ' '),
    ('\u{202f}', ' '),
    ('\u{2010}', '-'),
    ('\u{2014}', '\u{2013}'),
    ('\u{2019}', '\''),
];

/// How letters are written that the font lacks.
const SPELLINGS: &[(&str, &str)] = &[
    ("±", "+-"),
    ("²", "^2"),
    ("³", "^3"),
    ("ß", "ss"),
    ("Æ", "AE"),
    ("æ", "ae"),
    ("Œ", "OE"),
    ("œ", "oe"),
    ("ÀÁÂÃÄÅĀĂĄ", "A"),
    ("àáâãäåāăą", "a"),
    ("ÇĆĈĊČ", "C"),
    ("çćĉċč", "c"),
    ("ÐĎĐ", "D"),
    ("ðďđ", "d"),
    ("ÈÉÊËĒĔĖĘĚ", "E"),
    ("èéêëēĕėęě", "e"),
    ("ĜĞĠĢ", "G"),
    ("ĝğġģ", "g"),
    ("ĤĦ", "H"),
    ("ĥħ", "h"),
    ("ÌÍÎÏĨĪĬĮİ", "I"),
    ("ìíîïĩīĭįı", "i"),
    ("Ĵ", "J"),
    ("ĵ", "j"),
    ("Ķ", "K"),
    ("ķ", "k"),
    ("ĹĻĽŁ", "L"),
    ("ĺļľł", "l"),
    ("ÑŃŅŇ", "N"),
    ("ñńņň", "n"),
    ("ÒÓÔÕÖØŌŎŐ", "O"),
    ("òóôõöøōŏő", "o"),
    ("ŔŖŘ", "R"),
    ("ŕŗř", "r"),
    ("ŚŜŞŠȘ", "S"),
    ("śŝşšș", "s"),
    ("ŢŤŦȚ", "T"),
    ("ţťŧț", "t"),
    ("ÙÚÛÜŨŪŬŮŰŲ", "U"),
    ("ùúûüũūŭůűų", "u"),
    ("Ŵ", "W"),
    ("ŵ", "w"),
    ("ÝŶŸ", "Y"),
    ("ýŷÿ", "y"),
    ("ŹŻŽ", "Z"),
    ("źżž", "z"),
];

/// What stands for any other letter: a gap would not be seen.
const UNKNOWN: &str = "?";

/// The first letter of a text that pictures cannot show as it is.
pub fn unwritable(text: &str) -> Option<char> {
    text.chars().find(|&letter| !is_there(same(letter)))
}

fn same(letter: char) -> char {
    let known = SAME.iter().find(|(other, _)| *other == letter);
    known.map_or(letter, |(_, same)| *same)
}

fn is_there(letter: char) -> bool {
    INTER.glyph_id(letter) != GlyphId(0)
}

/// A text in letters that the font has.
fn spelled(text: &str) -> String {
    let mut spelled = String::with_capacity(text.len());
    for letter in text.chars().map(same) {
        match letter {
            there if is_there(there) => spelled.push(there),
            // Accents of the letter before.
            '\u{300}'..='\u{36f}' if !spelled.is_empty() => (),
            other => {
                let known = SPELLINGS.iter().find(|(all, _)| all.contains(other));
                spelled.push_str(known.map_or(UNKNOWN, |(_, spelling)| spelling));
            }
        }
    }
    spelled
}

/// Width of a line of text of this height, pixels.
pub(super) fn width(text: &str, height: f32) -> f32 {
    let font = INTER.as_scaled(PxScale::from(height));
    let advance = |c: char| font.h_advance(font.glyph_id(c));
    spelled(text).chars().map(advance).sum()
}

/// Writes a line of text of this height that begins at `x` and stands on the line `y`. Letters that the
/// font lacks are spelled with others, or are question marks.
pub(super) fn write(image: &mut Image, text: &str, [x, y]: [f32; 2], height: f32, color: [u8; 3]) {
    let font = INTER.as_scaled(PxScale::from(height));
    let mut at = x;
    for letter in spelled(text).chars() {
        let id = font.glyph_id(letter);
        let glyph = id.with_scale_and_position(height, point(at, y));
        at += font.h_advance(id);
        let Some(outline) = font.outline_glyph(glyph) else {
            continue;
        };
        let corner = outline.px_bounds().min;
        outline.draw(|column, row, share| {
            let [x, y] = [
                corner.x as i64 + i64::from(column),
                corner.y as i64 + i64::from(row),
            ];
            image.blend(x, y, color, share);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_letters_are_spelled_or_seen_to_be_missing() {
        assert_eq!(spelled("0.2 µm"), "0.2 µm");
        assert_eq!(
            spelled("0.2 μm"),
            "0.2 µm",
            "the Greek letter is the micro sign"
        );
        assert_eq!(
            spelled("Rügen — é, e\u{301} ± 3 m²"),
            "Rugen – e, e +- 3 m^2"
        );
        assert_eq!(spelled("岩 Ω\n\u{301}"), "? ??");
        for (letters, spelling) in SPELLINGS {
            assert!(spelling.chars().all(is_there), "{letters}");
            assert!(!letters.chars().any(is_there), "{letters}");
        }
        assert!(SAME.iter().all(|(_, same)| is_there(*same)));
    }

    /// Nothing that has ink in other fonts is a gap in this one.
    #[test]
    fn every_letter_leaves_ink() {
        let ink = |text: &str| {
            let mut image = Image::sheet(40, 30, [255; 3]);
            write(&mut image, text, [4.0, 22.0], 24.0, [0; 3]);
            image.rgb.iter().filter(|byte| **byte < 128).count()
        };
        for letter in ('!'..='\u{2fff}').filter(|c| c.is_alphanumeric()) {
            assert!(ink(&letter.to_string()) > 5, "{letter:?}");
        }
        assert_eq!(ink("μ"), ink("µ"));
    }

    #[test]
    fn what_cannot_be_written_is_named() {
        assert_eq!(unwritable("μm, mm^2 and 5 µm"), None);
        assert_eq!(unwritable("mm²"), Some('²'));
        assert_eq!(unwritable("Å"), Some('Å'), "an ampere is no ångström");
        assert_eq!(unwritable("m\n"), Some('\n'));
    }
}
