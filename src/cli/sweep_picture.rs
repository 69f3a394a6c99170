//! Pictures of the cells of a sweep, all from one side and at one scale.

use std::cell::LazyCell;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use anyhow::Context;
use thallus::cluster::Cluster;
use thallus::export::{read_elements, write_file_atomically};
use thallus::picture::{
    Camera, ContactSheet, Disc, Image, Scene, Settings, Stone, Tile, World, number, render_unless,
    round_below,
};
use thallus::skin::{self, Paint, Shape};
use thallus::sweep::{Axis, CellPicture, Layout, Results, captions, title};

use super::cutout::finish;
use super::failure::Failure;
use super::number::plural;
use super::output::ELEMENTS;
use super::preview::{bare, granules, packed, stone_unchecked};
use super::render::Skin;
use super::render_args::Size;
use super::render_camera::View;
use super::sweep_ended::Ended;
use super::sweep_view::PictureStyle;

/// The folder of the pictures.
const PICTURES: &str = "pictures";

/// The picture of each cell, and what they show.
pub(super) struct Pictures {
    /// None where no run of the cell was grown.
    cells: Vec<Option<Taken>>,
    /// Pixels of a tile of the contact sheet.
    side: [u32; 2],
    /// Width of what a picture shows where the lichens are, mesh units.
    width: f64,
}

/// Discs of all lichens that the camera looks at, about.
const LOOKED_AT: usize = 30_000;

impl Pictures {
    /// Takes them. Those that are there as they would be taken now stay.
    pub(super) fn take(ended: &Ended, style: &PictureStyle) -> Result<Self, Failure> {
        let results = ended.results();
        let stone = LazyCell::new(|| stone_unchecked(ended.substrate));
        let sight = Sight::of(ended, style, &results, &stone)?;
        let mut pictures = Self {
            cells: Vec::new(),
            side: side(&results, style.size),
            width: sight.width,
        };
        let missing = pictures.find(ended, &sight.camera, style)?;
        let kept = pictures.cells.iter().flatten().count();
        if let Some(note) = to_make(missing.len(), kept) {
            ended.voice.note(&note);
        }
        if !missing.is_empty() {
            let stone = LazyCell::force(&stone);
            let take = |run| picture(ended, stone, &sight.camera, style, run);
            pictures.add(ended, &missing, take)?;
        }
        Ok(pictures)
    }

    /// Takes those that are missing, and writes each while the next is taken.
    fn add(
        &mut self,
        ended: &Ended,
        missing: &[Lack],
        take: impl Fn(usize) -> Result<Option<Image>, Failure> + Sync,
    ) -> Result<(), Failure> {
        let taken = missing.iter().enumerate().map(|(number, lack)| {
            ended.check_cancelled()?;
            let name = &ended.plan.cells[lack.cell].name;
            let doing = format!("picture {} of {}: {name}", number + 1, missing.len());
            let spinner = ended.voice.spinner(&doing);
            let image = take(lack.run)?;
            spinner.finish_and_clear();
            let image = image.ok_or_else(|| ended.interrupted())?;
            Ok::<_, Failure>((lack, image))
        });
        let (tile, all) = (self.side[0], self.cells.len());
        let write = |(lack, image): &(&Lack, Image)| {
            let png = image.to_marked_png(&lack.mark);
            let file = file_of(ended, lack.cell);
            write_file_atomically(&file, true, |out: &mut dyn Write| out.write_all(&png))?;
            Ok::<_, Failure>((lack.cell, Taken::of(image, tile, all)))
        };
        for written in packed(taken, write) {
            let (cell, taken) = written??;
            self.cells[cell] = Some(taken);
        }
        Ok(())
    }

    /// Takes over the pictures that are there, and gives those that are not.
    fn find(
        &mut self,
        ended: &Ended,
        camera: &Camera,
        style: &PictureStyle,
    ) -> Result<Vec<Lack>, Failure> {
        let results = ended.results();
        self.cells.resize_with(ended.plan.cells.len(), || None);
        let mut missing = Vec::new();
        for cell in 0..self.cells.len() {
            ended.check_cancelled()?;
            let Some(run) = results.pictured(cell) else {
                continue;
            };
            let mark = mark(ended, camera, style, run)?;
            let there = fs::read(file_of(ended, cell)).ok();
            match there.and_then(|png| Image::of_marked_png(&png, &mark)) {
                Some(image) => self.cells[cell] = Some(self.taken(&image)),
                None => missing.push(Lack { cell, run, mark }),
            }
        }
        Ok(missing)
    }

    fn taken(&self, image: &Image) -> Taken {
        Taken::of(image, self.side[0], self.cells.len())
    }

    /// As the page has them.
    pub(super) fn for_page(&self) -> Vec<CellPicture> {
        let jpeg = |taken: &Taken| taken.jpeg.clone();
        let picture = |taken: &Option<Taken>| CellPicture {
            jpeg: taken.as_ref().map(jpeg).unwrap_or_default(),
        };
        self.cells.iter().map(picture).collect()
    }

    /// The contact sheet of a page of the grid (Sumner 2001, figure 9-4).
    pub(super) fn sheet(&self, results: &Results, page: usize, note: String) -> Image {
        let layout = results.grid.layout();
        let titles = |axis: Option<&Axis>| match axis {
            Some(axis) => (0..axis.len()).map(|i| axis.title(i)).collect(),
            None => vec![String::new()],
        };
        let first = page * layout.columns * layout.rows;
        let tile = |cell: usize| Tile {
            image: self.cells[cell].as_ref().map(|taken| taken.tile.clone()),
            captions: captions(results, cell)
                .iter()
                .map(|line| line.replace(" ± ", ", sd "))
                .collect(),
        };
        let columns: Vec<String> = titles(results.grid.axes.first());
        ContactSheet {
            title: match results.grid.page_title(page) {
                page if page.is_empty() => title(results),
                page => format!("{}: {page}", title(results)),
            },
            rows: titles(results.grid.axes.get(1)),
            tiles: (first..first + columns.len() * layout.rows)
                .map(tile)
                .collect(),
            side: self.side,
            columns,
            scale: self.scale(),
            note,
        }
        .draw()
    }

    /// A round length of about a quarter of the pictures' width.
    fn scale(&self) -> Option<(String, f32)> {
        let is_sound = self.width > 0.0 && self.width.is_finite();
        is_sound.then(|| {
            let length = round_below(self.width / 4.0);
            let units = if length == 1.0 { "unit" } else { "units" };
            let label = format!("{} mesh {units}", number(length, length));
            (label, (length / self.width) as f32)
        })
    }
}

/// A picture that is not there.
struct Lack {
    cell: usize,
    /// The run that it shows.
    run: usize,
    /// See [`mark`].
    mark: String,
}

/// What is about to happen, where so many pictures are missing and so many are there.
fn to_make(missing: usize, kept: usize) -> Option<String> {
    let pictures = |n| plural(n, "picture", "pictures");
    match (missing, kept) {
        (0, 0) => None,
        (0, kept) => Some(format!(
            "{} there already",
            plural(kept, "picture is", "pictures are")
        )),
        (missing, 0) => Some(format!("making {}", pictures(missing))),
        (missing, kept) => Some(format!(
            "making {}; {} there already",
            pictures(missing),
            plural(kept, "other is", "others are")
        )),
    }
}

fn file_of(ended: &Ended, cell: usize) -> PathBuf {
    let name = format!("{}.png", ended.plan.cells[cell].name);
    ended.folder.join(PICTURES).join(name)
}

/// A picture as sheet and page have it: the whole of a large grid would not fit into memory.
struct Taken {
    tile: Image,
    jpeg: Vec<u8>,
}

impl Taken {
    /// One picture of so many: the page's are smaller the more there are.
    fn of(image: &Image, tile: u32, all: usize) -> Self {
        const QUALITY: u8 = 82;
        const LARGE: f64 = 100.0;
        let shrink = (all as f64 / LARGE).max(1.0).sqrt();
        let width = (f64::from(image.width) / shrink) as u32;
        Self {
            tile: image.shrunk(tile),
            jpeg: image.shrunk(width).to_jpeg(QUALITY),
        }
    }
}

/// Tiles are small where there are many, so that the sheet stays one that programs open.
fn side(results: &Results, size: Size) -> [u32; 2] {
    const WIDEST: u32 = 340;
    const NARROWEST: u32 = 64;
    const SHEET: u32 = 9000;
    /// Of a whole sheet, whatever is in it: 300 MB.
    const PIXELS: f64 = 1e8;
    let Layout { columns, rows, .. } = results.grid.layout();
    let most = columns.max(rows) as u32;
    let width = (SHEET / most).clamp(NARROWEST, WIDEST).min(size.width);
    let each = PIXELS * f64::from(size.aspect()) / (columns as f64 * rows as f64);
    let width = width.min(each.sqrt() as u32).max(1);
    let height = u64::from(width) * u64::from(size.height) / u64::from(size.width);
    [width, (height as u32).max(1)]
}

/// Where all pictures are taken from.
struct Sight {
    camera: Camera,
    width: f64,
}

impl Sight {
    /// Sees all lichens together.
    fn of(
        ended: &Ended,
        style: &PictureStyle,
        results: &Results,
        stone: &LazyCell<Stone, impl FnOnce() -> Stone>,
    ) -> Result<Self, Failure> {
        let spinner = ended.voice.spinner("looking for the best side");
        let pictured = |cell| results.pictured(cell);
        let runs: Vec<usize> = (0..ended.plan.cells.len()).filter_map(pictured).collect();
        let each = LOOKED_AT / runs.len().max(1) + 1;
        let mut discs: Vec<Disc> = Vec::new();
        for &run in &runs {
            ended.check_cancelled()?;
            discs.extend(some_granules(ended, run, each)?);
        }
        let all = LazyCell::new(|| {
            World::new(&Scene {
                discs: &discs,
                finish: finish(ended.cutout),
                ..bare(ended.substrate, stone)
            })
        });
        let aspect = style.size.aspect();
        let camera = style.camera.camera(ended.substrate, &all, aspect)?;
        spinner.finish_and_clear();
        let sum: glam::Vec3 = discs.iter().map(|d| glam::Vec3::from(d.center)).sum();
        let middle = (sum / discs.len().max(1) as f32).to_array();
        let camera = match style.camera {
            View::Auto => nearer(&camera, &discs, middle, aspect),
            _ => camera,
        };
        let width = camera.width_at(camera.depth(middle), aspect);
        let width = ended.substrate.units().length_to_file(f64::from(width));
        Ok(Self { camera, width })
    }
}

/// The camera as near as all lichens still fit in: a picture of a cell is small, and there is no need
/// to show where on the mesh they are.
fn nearer(camera: &Camera, discs: &[Disc], middle: [f32; 3], aspect: f32) -> Camera {
    const FILLED: f32 = 0.86;
    let off_center = |disc: &Disc| {
        let [x, y] = camera.project(disc.center, aspect)?;
        Some((2.0 * x - 1.0).abs().max((2.0 * y - 1.0).abs()))
    };
    let farthest = discs.iter().filter_map(off_center).fold(0.0, f32::max);
    match farthest > 0.01 && farthest < FILLED {
        true => camera.zoomed(camera.depth(middle), FILLED / farthest),
        false => *camera,
    }
}

/// Every so many elements of a run.
fn some_granules(ended: &Ended, run: usize, most: usize) -> Result<Vec<Disc>, Failure> {
    let cluster = cluster(ended, run)?;
    let step = cluster.len().div_ceil(most).max(1);
    let grey = vec![[0; 3]; cluster.len()];
    let discs = granules(ended.substrate, &cluster, grey).into_iter();
    Ok(discs.step_by(step).collect())
}

fn elements_file(ended: &Ended, run: usize) -> PathBuf {
    ended.folder.join(ended.plan.folder(run)).join(ELEMENTS)
}

/// A hash of all that decides a picture.
fn mark(
    ended: &Ended,
    camera: &Camera,
    style: &PictureStyle,
    run: usize,
) -> Result<String, Failure> {
    let file = elements_file(ended, run);
    let elements = fs::read(&file).with_context(|| format!("{}: reading", file.display()))?;
    let cutout = ended
        .cutout
        .map_or_else(String::new, |cutout| format!(", open {}", cutout.hash()));
    let all = format!(
        "thallus {} mesh {} elements {} {camera:?} {} x {} pixels, {} samples, {:?}{cutout}",
        env!("CARGO_PKG_VERSION"),
        ended.substrate.mesh_hash(),
        blake3::hash(&elements),
        style.size.width,
        style.size.height,
        style.samples,
        style.ground,
    );
    Ok(blake3::hash(all.as_bytes()).to_string())
}

fn cluster(ended: &Ended, run: usize) -> Result<Cluster, Failure> {
    let file = elements_file(ended, run);
    let cell = &ended.plan.cells[ended.plan.runs[run].cell].name;
    let cure = || format!("a finished run is damaged; --only {cell} grows its cell anew");
    let elements = read_elements(&file).map_err(anyhow::Error::new);
    let elements = elements.with_context(cure)?;
    let cluster = elements.to_cluster(ended.substrate);
    let cluster = cluster.with_context(|| file.display().to_string());
    Ok(cluster.with_context(cure)?)
}

/// A run with its skin on, as `thallus render` draws it; none where somebody asked to stop meanwhile.
fn picture(
    ended: &Ended,
    stone: &Stone,
    camera: &Camera,
    style: &PictureStyle,
    run: usize,
) -> Result<Option<Image>, Failure> {
    let cluster = cluster(ended, run)?;
    let (shape, paint) = (Shape::default(), Paint::default());
    let mesh = skin::skin(ended.substrate, &cluster, &shape, &paint);
    let mesh = mesh.map_err(|e| Failure::Failed(e.into()))?;
    let skin = Skin::new(ended.substrate, mesh, cluster.radius() as f32);
    let skins = [skin.painted()];
    let world = World::new(&Scene {
        skins: &skins,
        ground: style.ground,
        finish: finish(ended.cutout),
        ..bare(ended.substrate, stone)
    });
    let settings = Settings {
        width: style.size.width,
        height: style.size.height,
        samples: style.samples,
        ..Settings::default()
    };
    let stopped = || ended.cancel.load(Ordering::Relaxed);
    Ok(render_unless(&world, camera, &settings, &stopped))
}
