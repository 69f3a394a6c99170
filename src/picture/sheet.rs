//! Pictures side by side, with the values that make them along the edges.

use super::legend::{INK, length};
use super::{Image, text};

/// A grid of pictures of one size.
#[derive(Clone, Debug, Default)]
pub struct ContactSheet {
    /// Above everything.
    pub title: String,
    /// Above each column.
    pub columns: Vec<String>,
    /// Left of each row; empty texts for none.
    pub rows: Vec<String>,
    /// Row by row, as many as columns times rows.
    pub tiles: Vec<Tile>,
    /// Pixels of a tile's side: pictures are shrunk to it.
    pub side: [u32; 2],
    /// A length in all pictures: its name, and its share of a tile's width, 0 to 1, to which others are limited.
    pub scale: Option<(String, f32)>,
    /// Below everything.
    pub note: String,
}

/// One picture of a sheet.
#[derive(Clone, Debug, Default)]
pub struct Tile {
    /// The picture; none is an empty frame.
    pub image: Option<Image>,
    /// Lines under it.
    pub captions: Vec<String>,
}

const SHEET: [u8; 3] = [0xff; 3];
const EMPTY: [u8; 3] = [0xee, 0xed, 0xe8];
const SOFT: [u8; 3] = [0x5c, 0x5d, 0x56];

/// Sizes in shares of a tile's width.
const MARGIN: f32 = 0.09;
const GAP: f32 = 0.045;
const LETTERS: f32 = 0.075;
const SMALL: f32 = 0.056;

/// Least height of letters, pixels.
const LEGIBLE: f32 = 10.0;

impl ContactSheet {
    /// Draws the sheet.
    ///
    /// # Panics
    /// When there are not as many tiles as columns times rows, or a side is zero.
    pub fn draw(&self) -> Image {
        assert_eq!(self.tiles.len(), self.columns.len() * self.rows.len());
        assert!(self.side.iter().all(|&side| side > 0), "sides of tiles");
        let place = Places::of(self);
        let mut image = Image::sheet(place.width, place.height, SHEET);
        let letters = place.letters;
        let baseline = place.margin + letters;
        text::write(
            &mut image,
            &self.title,
            [place.margin, baseline],
            1.25 * letters,
            INK,
        );
        for (i, label) in self.columns.iter().enumerate() {
            let middle = place.tile(i, 0)[0] as f32 + 0.5 * self.side[0] as f32;
            let x = middle - 0.5 * text::width(label, letters);
            let y = place.top as f32 - 0.5 * letters;
            text::write(&mut image, label, [x, y], letters, INK);
        }
        for (i, label) in self.rows.iter().enumerate() {
            let y = place.tile(0, i)[1] as f32 + 0.5 * self.side[1] as f32 + 0.35 * letters;
            text::write(&mut image, label, [place.margin, y], letters, INK);
        }
        for (i, tile) in self.tiles.iter().enumerate() {
            let at = place.tile(i % self.columns.len(), i / self.columns.len());
            self.draw_tile(&mut image, tile, at, &place);
        }
        self.draw_foot(&mut image, &place);
        image
    }

    fn draw_tile(&self, image: &mut Image, tile: &Tile, [x, y]: [u32; 2], place: &Places) {
        let [width, height] = self.side;
        match &tile.image {
            Some(picture) => image.paste(&fitted(picture, self.side), x, y),
            None => {
                let frame = [x, y, x + width, y + height].map(|v| v as f32);
                image.fill(frame, 1.0, |_| EMPTY);
            }
        }
        for (i, line) in tile.captions.iter().enumerate() {
            let base = (y + height) as f32 + place.small * (1.25 + 1.3 * i as f32);
            text::write(image, line, [x as f32, base], place.small, SOFT);
        }
    }

    fn draw_foot(&self, image: &mut Image, place: &Places) {
        let y = place.height as f32 - place.margin;
        let [left, _] = place.tile(0, 0);
        let mut x = left as f32;
        if let Some((label, share)) = &self.scale {
            let length = length(*share, self.side[0]);
            let thick = (0.006 * self.side[0] as f32).max(1.0);
            image.fill([x, y - thick, x + length, y], 1.0, |_| INK);
            x += length + place.small;
            text::write(image, label, [x, y], place.small, INK);
            x += text::width(label, place.small) + 2.0 * place.small;
        }
        text::write(image, &self.note, [x, y], place.small, SOFT);
    }
}

/// A picture at this size: shrunk, and cut to it where its proportions differ.
fn fitted(picture: &Image, [width, height]: [u32; 2]) -> Image {
    let small = picture.shrunk(width);
    let mut tile = Image::sheet(width, height, SHEET);
    let keep = |all: u32, room: u32| all.min(room) as usize;
    let (columns, rows) = (keep(small.width, width), keep(small.height, height));
    for row in 0..rows {
        let [from, to] = [small.width, width].map(|w| 3 * row * w as usize);
        tile.rgb[to..to + 3 * columns].copy_from_slice(&small.rgb[from..from + 3 * columns]);
    }
    tile
}

/// Where things lie on a sheet, pixels.
struct Places {
    width: u32,
    height: u32,
    margin: f32,
    letters: f32,
    small: f32,
    left: u32,
    top: u32,
    /// From a tile to the next.
    step: [u32; 2],
}

impl Places {
    fn of(sheet: &ContactSheet) -> Self {
        let side = sheet.side[0] as f32;
        let letters = (LETTERS * side).max(LEGIBLE);
        let small = (SMALL * side).max(LEGIBLE);
        let (margin, gap) = (MARGIN * side, (GAP * side).max(1.0));
        let lines = sheet.tiles.iter().map(|tile| tile.captions.len()).max();
        let captions = small * (0.5 + 1.3 * lines.unwrap_or(0) as f32);
        let widest = |texts: &[String], height| {
            let widths = texts.iter().map(|text| text::width(text, height));
            widths.fold(0.0, f32::max)
        };
        let labels = widest(&sheet.rows, letters);
        let left = margin + if labels > 0.0 { labels + letters } else { 0.0 };
        let top = margin + 3.6 * letters;
        let written = sheet.tiles.iter().map(|tile| widest(&tile.captions, small));
        let tile = written.fold(side, |tile, caption| tile.max(caption + small));
        let step = [
            (tile + gap).ceil() as u32,
            (sheet.side[1] as f32 + captions + gap).ceil() as u32,
        ];
        let across = left + (sheet.columns.len() as u32 * step[0]) as f32 - gap + margin;
        let title = 2.0 * margin + text::width(&sheet.title, 1.25 * letters);
        let down = top + (sheet.rows.len() as u32 * step[1]) as f32 + 1.6 * small + margin;
        let scale = sheet.scale.as_ref().map_or(0.0, |(label, share)| {
            length(*share, sheet.side[0]) + 3.0 * small + text::width(label, small)
        });
        let foot = left + scale + text::width(&sheet.note, small) + margin;
        Self {
            width: across.max(title).max(foot).ceil() as u32,
            height: down.ceil() as u32,
            margin,
            letters,
            small,
            left: left.ceil() as u32,
            top: top.ceil() as u32,
            step,
        }
    }

    /// The upper left corner of a tile.
    fn tile(&self, column: usize, row: usize) -> [u32; 2] {
        [
            self.left + column as u32 * self.step[0],
            self.top + row as u32 * self.step[1],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet() -> ContactSheet {
        let tile = |color| Tile {
            image: Some(Image::sheet(100, 100, color)),
            captions: vec!["R_e 1".to_owned()],
        };
        ContactSheet {
            title: "L, B".to_owned(),
            columns: ["L = 5r", "L = 10r"].map(str::to_owned).to_vec(),
            rows: ["B = 0.2", "B = 0.9"].map(str::to_owned).to_vec(),
            tiles: vec![
                tile([9, 0, 0]),
                tile([0, 9, 0]),
                tile([0, 0, 9]),
                Tile::default(),
            ],
            side: [50, 50],
            scale: Some(("1 mm".to_owned(), 0.25)),
            note: "the same camera".to_owned(),
        }
    }

    #[test]
    fn tiles_lie_row_by_row_and_whole() {
        let sheet = sheet();
        let image = sheet.draw();
        let place = Places::of(&sheet);
        for (i, color) in [[9, 0, 0], [0, 9, 0], [0, 0, 9], EMPTY]
            .into_iter()
            .enumerate()
        {
            let [x, y] = place.tile(i % 2, i / 2);
            for (dx, dy) in [(0, 0), (49, 0), (0, 49), (49, 49)] {
                let pixel = 3 * ((y + dy) * image.width + x + dx) as usize;
                assert_eq!(image.rgb[pixel..pixel + 3], color, "tile {i}");
            }
        }
        let count = |color: [u8; 3]| image.rgb.chunks(3).filter(|p| **p == color).count();
        assert_eq!(count([9, 0, 0]), 2500, "nothing is written over a picture");
        let tiles_and_paper = count(SHEET) + count(EMPTY) + 3 * 2500;
        let inked = image.rgb.len() / 3 - tiles_and_paper;
        assert!(inked > 200, "there are letters: {inked}");
    }

    #[test]
    fn a_length_ends_with_a_tile() {
        let width = |share: f32| {
            let mut sheet = sheet();
            sheet.scale = Some(("a length".to_owned(), share));
            sheet.draw().width
        };
        assert_eq!([1e7, f32::INFINITY].map(width), [width(1.0); 2]);
        assert_eq!([-1e7, f32::NAN].map(width), [width(0.0); 2]);
    }

    #[test]
    fn the_sheet_has_room_for_its_longest_text() {
        let mut sheet = sheet();
        let narrow = sheet.draw().width;
        sheet.note = "a note much longer than the pictures are wide, and on and on".to_owned();
        assert!(sheet.draw().width > narrow);
        let mut sheet = self::sheet();
        sheet.tiles[0].captions = vec!["a caption wider than its picture".to_owned()];
        let places = Places::of(&sheet);
        let caption = text::width(&sheet.tiles[0].captions[0], places.small);
        assert!(places.tile(1, 0)[0] as f32 > places.tile(0, 0)[0] as f32 + caption);
    }
}
