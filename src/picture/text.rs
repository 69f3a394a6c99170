//! Letters on a picture.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use super::Image;

/// Inter, by the Inter Project Authors, under the SIL Open Font License (`font/OFL.txt`).
static INTER: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    FontRef::try_from_slice(include_bytes!("font/Inter-Latin.ttf")).expect("the font is sound")
});

/// Width of a line of text of this height, pixels.
pub(super) fn width(text: &str, height: f32) -> f32 {
    let font = INTER.as_scaled(PxScale::from(height));
    let advance = |c: char| font.h_advance(font.glyph_id(c));
    text.chars().map(advance).sum()
}

/// Writes a line of text of this height that begins at `x` and stands on the line `y`.
pub(super) fn write(image: &mut Image, text: &str, [x, y]: [f32; 2], height: f32, color: [u8; 3]) {
    let font = INTER.as_scaled(PxScale::from(height));
    let mut at = x;
    for letter in text.chars() {
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
