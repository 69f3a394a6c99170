//! A picture that the plotting library draws on.

use std::convert::Infallible;

use glam::Vec2;
use plotters_backend::text_anchor::{HPos, Pos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::{Image, text};

/// An opaque picture as a backend of plotters, with smooth edges: lines, rectangles and texts are
/// covered as far as they cover each pixel. Coordinates are those of a picture `SCALE` times
/// smaller, at whose size the fonts are chosen.
pub(crate) struct Drawing<'a> {
    image: &'a mut Image,
}

/// Pixels of the picture for one of the plot.
const SCALE: u32 = 2;

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl Image {
    /// A white picture that a plot of this size is drawn on, twice as fine.
    ///
    /// # Errors
    /// Those of `draw`.
    pub(crate) fn drawn<E>(
        [width, height]: [u32; 2],
        draw: impl FnOnce(Drawing<'_>) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut image = Self::sheet(SCALE * width, SCALE * height, [255; 3]);
        draw(Drawing { image: &mut image })?;
        Ok(image)
    }
}

/// The middle of a pixel of the plot.
fn place((x, y): BackendCoord) -> Vec2 {
    (Vec2::new(x as f32, y as f32) + 0.5) * SCALE as f32
}

impl Drawing<'_> {
    fn blend(&mut self, x: i64, y: i64, color: BackendColor, share: f32) {
        let (red, green, blue) = color.rgb;
        let share = share * color.alpha as f32;
        self.image.blend(x, y, [red, green, blue], share);
    }

    /// A line with round corners and ends; where it crosses itself it is no darker.
    fn stroke(&mut self, path: &[Vec2], width: u32, color: BackendColor) {
        let half = 0.5 * (width * SCALE) as f32;
        let size = Vec2::new(self.image.width as f32, self.image.height as f32);
        let mut covered: Vec<(i64, i64, f32)> = Vec::new();
        for ends in path.windows(2) {
            pixels(ends, half + 1.0, size, |x, y| {
                let middle = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let share = half + 0.5 - distance(middle, ends);
                if share > 0.0 {
                    covered.push((y, x, share.min(1.0)));
                }
            });
        }
        covered.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(b.2.total_cmp(&a.2)));
        covered.dedup_by_key(|(y, x, _)| (*y, *x));
        for (y, x, share) in covered {
            self.blend(x, y, color, share);
        }
    }
}

/// Visits the pixels of a picture in a box about the ends of a line.
fn pixels(ends: &[Vec2], margin: f32, size: Vec2, mut visit: impl FnMut(i64, i64)) {
    let low = (ends[0].min(ends[1]) - margin).clamp(Vec2::ZERO, size);
    let high = (ends[0].max(ends[1]) + margin).clamp(Vec2::ZERO, size);
    for y in low.y as i64..high.y.ceil() as i64 {
        for x in low.x as i64..high.x.ceil() as i64 {
            visit(x, y);
        }
    }
}

/// From a place to a line between two ends.
fn distance(from: Vec2, ends: &[Vec2]) -> f32 {
    let (way, along) = (from - ends[0], ends[1] - ends[0]);
    let share = way.dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    way.distance(along * share.clamp(0.0, 1.0))
}

/// Height of a line of Inter in sizes of its font: from the top of its ascenders to the bottom of its
/// descenders.
const LINE: f32 = 1.21;

/// The plotting library's sizes of fonts are heights of their lines, of this many sizes.
const HEIGHT: f64 = 1.24;

/// Height of a line of text for [`text`].
fn line_height(style: &impl BackendTextStyle) -> f32 {
    (style.size() / HEIGHT) as f32 * LINE
}

/// A line of text, white on black.
struct Line {
    ink: Image,
}

impl Line {
    fn new(words: &str, height: f32) -> Self {
        /// Share of the height above the line that letters stand on.
        const ABOVE: f32 = 0.78;
        let width = text::width(words, height).ceil() as u32 + 1;
        let mut ink = Image::sheet(width, height.ceil() as u32, [0; 3]);
        text::write(&mut ink, words, [0.0, ABOVE * height], height, [255; 3]);
        Self { ink }
    }

    /// Its upper left corner, seen from its anchor.
    fn corner(&self, anchor: &Pos) -> [i32; 2] {
        let [width, height] = [self.ink.width, self.ink.height].map(|side| side as i32);
        let left = match anchor.h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let top = match anchor.v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        [left, top]
    }

    /// Column, row, and how far each is covered.
    fn pixels(&self) -> impl Iterator<Item = (i32, i32, f32)> {
        let width = self.ink.width as usize;
        let pixels = self.ink.rgb.chunks_exact(3).enumerate();
        pixels.map(move |(i, pixel)| {
            let (column, row) = ((i % width) as i32, (i / width) as i32);
            (column, row, f32::from(pixel[0]) / 255.0)
        })
    }
}

impl DrawingBackend for Drawing<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.image.width / SCALE, self.image.height / SCALE)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let path: Vec<_> = path.into_iter().map(place).collect();
        self.stroke(&path, style.stroke_width(), style.color());
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        if !fill {
            let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
            return self.draw_path(corners.into_iter().chain([corners[0]]), style);
        }
        let scaled = |from: i32, to: i32| {
            let scale = i64::from(SCALE);
            i64::from(from) * scale..i64::from(to) * scale
        };
        for y in scaled(top, bottom) {
            for x in scaled(left, right) {
                self.blend(x, y, style.color(), 1.0);
            }
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        words: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let height = line_height(style);
        let width = text::width(words, height).ceil();
        Ok((width as u32, height.ceil() as u32))
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        words: &str,
        style: &S,
        at: BackendCoord,
    ) -> Drawn {
        let line = Line::new(words, line_height(style) * SCALE as f32);
        let [left, top] = line.corner(&style.anchor());
        let from = place(at).as_i64vec2();
        for (column, row, share) in line.pixels() {
            let turned = style.transform().transform(left + column, top + row);
            let [x, y] = [from.x + i64::from(turned.0), from.y + i64::from(turned.1)];
            self.blend(x, y, style.color(), share);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: BackendColor = BackendColor {
        alpha: 1.0,
        rgb: (0, 0, 0),
    };

    struct Thick(u32, f64);

    impl BackendStyle for Thick {
        fn color(&self) -> BackendColor {
            BLACK.mix(self.1)
        }

        fn stroke_width(&self) -> u32 {
            self.0
        }
    }

    /// How much black there is, in pixels of the plot.
    fn ink(draw: impl FnOnce(&mut Drawing<'_>) -> Drawn) -> f64 {
        let image = Image::drawn([100, 60], |mut drawing| draw(&mut drawing)).unwrap();
        let black = image
            .rgb
            .iter()
            .step_by(3)
            .map(|&c| 1.0 - f64::from(c) / 255.0);
        black.sum::<f64>() / f64::from(SCALE * SCALE)
    }

    #[test]
    fn lines_have_their_length_times_their_width() {
        for (to, width, alpha) in [((70, 10), 1, 1.0), ((70, 50), 3, 1.0), ((12, 40), 7, 0.35)] {
            let [x, y] = [f64::from(to.0 - 10), f64::from(to.1 - 10)];
            let cap = std::f64::consts::PI / 4.0 * f64::from(width * width);
            let expected = alpha * (x.hypot(y) * f64::from(width) + cap);
            let found = ink(|drawing| drawing.draw_line((10, 10), to, &Thick(width, alpha)));
            assert!(
                (found / expected - 1.0).abs() < 0.03,
                "{found}, not {expected}"
            );
            // There and back is the same line.
            let path = [(10, 10), to, (10, 10)];
            let back = ink(|drawing| drawing.draw_path(path, &Thick(width, alpha)));
            assert!((back - found).abs() < 1e-9);
        }
    }

    /// A line of text is whole: as much ink as its words one by one.
    #[test]
    fn no_letter_is_cut_off() {
        for height in [20.0, 29.27, 41.9] {
            let ink = |words: &str| {
                let line = Line::new(words, height);
                let shares = line.pixels().map(|(_, _, share)| f64::from(share));
                shares.sum::<f64>()
            };
            let letters: f64 = "gyration,1.71+-units"
                .chars()
                .map(|c| ink(&c.to_string()))
                .sum();
            let line = ink("gyration, 1.71 ± units");
            assert!((line / letters - 1.0).abs() < 0.02, "{line} {letters}");
        }
    }

    #[test]
    fn rectangles_are_filled_and_what_is_outside_is_left_out() {
        assert_eq!(
            ink(|d| d.draw_rect((10, 20), (30, 25), &BLACK, true)),
            100.0
        );
        assert_eq!(ink(|d| d.draw_rect((-5, -5), (2, 3), &BLACK, true)), 6.0);
        assert_eq!(ink(|d| d.draw_pixel((99, 59), BLACK)), 1.0);
        assert_eq!(ink(|d| d.draw_pixel((100, 60), BLACK)), 0.0);
        assert!(ink(|d| d.draw_line((-50, 30), (500, 30), &BLACK)) <= 101.0);
        let frame = ink(|d| d.draw_rect((10, 10), (20, 20), &BLACK, false));
        assert!((frame - 40.0).abs() < 1.0, "{frame}");
    }
}
